//! What makes a mesh unusable.

use rayon::prelude::*;

use super::face_table::{Encounters, MAX_CELLS};
use super::notes::{SHOWN, list, many};
use super::quality::validity;
use super::v3::V3;
use super::{CellArray, CellKind, RawMesh, ascending};
use crate::Error;

/// A cell is flat if its quality, a ratio of volumes, is not above this: the round-off of coordinates
/// that are a thousand times longer than the cell.
const FLAT: f64 = 1e-12;

/// Node and cell numbers are in range, coordinates finite, and each cell has as many distinct nodes as its kind.
pub(super) fn numbers(raw: &RawMesh) -> Result<(), Error> {
    let (nodes, cells) = (raw.nodes.len(), raw.cell_count());
    if cells == 0 {
        return Err(Error::new("", "the mesh has no cells", "mesh the volume with tetrahedra, wedges or hexahedra"));
    }
    if nodes >= u32::MAX as usize || cells > MAX_CELLS {
        let what = format!("{nodes} nodes and {cells} cells are more than a mesh can number");
        return Err(Error::new("", what, format!("at most {} nodes and {MAX_CELLS} cells", u32::MAX - 1)));
    }
    let outside = |n: &u32| *n as usize >= nodes;
    let (broken, repeated): (Vec<usize>, Vec<usize>) = unsound(raw).into_iter().partition(|&cell| {
        let (kind, own) = raw.cell(cell);
        own.len() != kind.nodes() || own.iter().any(outside)
    });
    let remedy = "every node a cell names must be in the file";
    cells_error(raw, &broken, "with a broken node list", remedy)?;
    cells_error(raw, &repeated, "with a repeated node", "split or remove collapsed cells")?;
    for group in &raw.groups {
        let face = |f: &[u32; 4]| f[..3].iter().any(outside) || f[3] != u32::MAX && outside(&f[3]);
        let cell = |c: &u32| *c as usize >= cells;
        if group.nodes.iter().any(outside)
            || group.faces.iter().any(face)
            || group.cells.iter().chain(&group.skin).any(cell)
        {
            let place = format!("group \"{}\"", group.name);
            return Err(Error::new(place, "it refers to a node or cell that does not exist", "write the file again"));
        }
    }
    arrays(raw, cells)?;
    let bad: Vec<usize> = (0..nodes).filter(|&i| !raw.nodes[i].iter().all(|c| c.is_finite())).collect();
    let Some(&first) = bad.first() else { return Ok(()) };
    let shown: Vec<u64> = bad.iter().take(SHOWN).map(|&i| raw.node_id(i)).collect();
    let what = format!(
        "{} with a coordinate that is not a finite number: {}",
        many(bad.len(), "node"),
        list(&shown, bad.len())
    );
    Err(Error::new(format!("node {}", raw.node_id(first)), what, "write the file again"))
}

/// Numbers of the cells that are not whole, name nodes that are not there, or a node twice; ascending.
fn unsound(raw: &RawMesh) -> Vec<usize> {
    let (mut bad, mut first) = (Vec::new(), 0);
    for block in &raw.cells {
        let own = match block.kind {
            CellKind::Tet4 => unsound_of::<4>(&block.nodes, raw.nodes.len()),
            CellKind::Hex8 => unsound_of::<8>(&block.nodes, raw.nodes.len()),
            CellKind::Tet10 => unsound_of::<10>(&block.nodes, raw.nodes.len()),
            CellKind::Hex20 => unsound_of::<20>(&block.nodes, raw.nodes.len()),
            CellKind::Wedge6 => unsound_of::<6>(&block.nodes, raw.nodes.len()),
            CellKind::Wedge15 => unsound_of::<15>(&block.nodes, raw.nodes.len()),
        };
        bad.extend(own.iter().map(|cell| first + cell));
        first += block.nodes.len().div_ceil(block.kind.nodes());
    }
    bad
}

/// The same of cells with `N` nodes each, one after the other, counted from 0.
fn unsound_of<const N: usize>(cells: &[u32], nodes: usize) -> Vec<usize> {
    /// Looked through at a time.
    const CELLS: usize = 1 << 12;
    let (whole, rest) = cells.as_chunks::<N>();
    // Without a jump at every comparison.
    let is_bad = |cell: &[u32; N]| {
        let repeated = |i: usize| (0..i).fold(false, |bad, j| bad | (cell[i] == cell[j]));
        (0..N).fold(false, |bad, i| bad | (cell[i] as usize >= nodes) | repeated(i))
    };
    let of_part = |(k, part): (usize, &[[u32; N]])| -> Vec<usize> {
        (k * CELLS..).zip(part).filter(|(_, cell)| is_bad(cell)).map(|(number, _)| number).collect()
    };
    let mut bad: Vec<usize> = whole.par_chunks(CELLS).enumerate().flat_map_iter(of_part).collect();
    bad.extend((!rest.is_empty()).then_some(whole.len()));
    bad
}

/// Each array has a number for every node or cell, and names faces that are there.
fn arrays(raw: &RawMesh, cells: usize) -> Result<(), Error> {
    let (arrays, nodes) = (&raw.arrays, raw.nodes.len());
    let node = |n: &u32| (*n as usize) < nodes;
    let faces = raw.array_faces.iter().all(|f| f[..3].iter().all(node) && (f[3] == u32::MAX || node(&f[3])));
    let own = |own: &(u32, f64)| faces && (own.0 as usize) < raw.array_faces.len();
    let unfit =
        (arrays.nodes.iter().find(|array| array.values.len() != nodes).map(|array| &array.name)).or_else(|| {
            let unfit = |array: &&CellArray| array.values.len() != cells || !array.faces.iter().all(own);
            arrays.cells.iter().find(unfit).map(|array| &array.name)
        });
    let Some(name) = unfit else { return Ok(()) };
    let what = "it has not one number for each node or cell, or names a face of other nodes";
    Err(Error::new(format!("array \"{name}\""), what, "write the file again"))
}

/// Every cell has positive volume, at every point where a stiffness matrix may look.
pub(super) fn shapes(raw: &RawMesh) -> Result<(), Error> {
    let mut inverted = Vec::new();
    let mut flat = Vec::new();
    let mut offset = 0;
    for block in &raw.cells {
        let bad: Vec<(usize, f64)> = block
            .nodes
            .par_chunks_exact(block.kind.nodes())
            .enumerate()
            .map(|(i, cell)| (offset + i, validity(&raw.nodes, block.kind, cell)))
            .filter(|&(_, quality)| quality.is_nan() || quality <= FLAT)
            .collect();
        for (cell, quality) in bad {
            if quality < -FLAT { inverted.push(cell) } else { flat.push(cell) }
        }
        offset += block.nodes.len() / block.kind.nodes();
    }
    let remedy = if inverted.len() == raw.cell_count() {
        "all cells are mirrored: is the node order that of Gmsh and VTK, and the mesh not reflected?"
    } else {
        "repair these cells in the mesher, for instance by a finer or smoothed mesh there"
    };
    cells_error(raw, &inverted, "inside out (somewhere the Jacobian is negative)", remedy)?;
    cells_error(raw, &flat, "without volume (flat to round-off)", remedy)
}

/// Cells meet face to face, two at a face.
pub(super) fn neighbours(raw: &RawMesh, seen: &Encounters) -> Result<(), Error> {
    let cells = |list: &[u32]| -> Vec<usize> { list.iter().map(|&c| c as usize).collect() };
    if let Some([node, count]) = seen.star {
        let place = format!("node {}", raw.node_id(node));
        let what = format!("it belongs to {count} faces of cells, more than those of any mesh");
        return Err(Error::new(place, what, "are cells given again and again?"));
    }
    let remedy = "remove the copies; does the file hold the same volume twice?";
    cells_error(raw, &cells(&seen.twins), "given more than once", remedy)?;
    let remedy = "a face belongs to one cell or to two; remove overlapping volumes";
    cells_error(raw, &cells(&seen.crowded), "at a face that more than two cells share", remedy)?;
    let folded = ascending(cells(seen.folded.as_flattened()));
    let remedy = "neighbours overlap or the mesh is folded there; mesh it again";
    cells_error(raw, &folded, "on the same side of a face they share with a neighbour", remedy)?;
    let unlike = ascending(cells(seen.unlike.as_flattened()));
    let remedy =
        "cells that touch are of one order and share the nodes of their edges; mesh all of a body with one order";
    cells_error(raw, &unlike, "at a face whose mid-side nodes the neighbour does not share", remedy)
}

/// An error naming these cells, unless there are none.
fn cells_error(raw: &RawMesh, bad: &[usize], what: &str, remedy: &str) -> Result<(), Error> {
    let Some(&first) = bad.first() else { return Ok(()) };
    let shown: Vec<u64> = bad.iter().take(SHOWN).map(|&i| raw.cell_id(i)).collect();
    let what = format!("{} {what}: {}", many(bad.len(), "cell"), list(&shown, bad.len()));
    Err(Error::new(format!("element {}", raw.cell_id(first)), what, remedy))
}

/// How many of the given nodes lie closer than `distance` (length, > 0) to one with a higher number, and the first
/// such pair.
pub(super) fn coincident(nodes: &[V3], which: &[u32], distance: f64) -> (usize, Option<[u32; 2]>) {
    // boxes of four distances: a ball of radius `distance` around a node reaches into few of them
    let place = |x: V3| x.map(|c| (c / (4.0 * distance)).floor() as i64);
    let mut boxed: Vec<([i64; 3], u32)> = which.iter().map(|&n| (place(nodes[n as usize]), n)).collect();
    boxed.par_sort_unstable();
    let partner = |&n: &u32| -> Option<[u32; 2]> {
        let x = nodes[n as usize];
        let close = |m: &u32| (0..3).map(|c| (x[c] - nodes[*m as usize][c]).powi(2)).sum::<f64>() < distance * distance;
        let [low, high] = [-distance, distance].map(|d| place(x.map(|c| c + d)));
        let boxes = (low[0]..=high[0])
            .flat_map(|i| (low[1]..=high[1]).flat_map(move |j| (low[2]..=high[2]).map(move |k| [i, j, k])));
        let in_box = |b: [i64; 3]| {
            let from = boxed.partition_point(|entry| *entry <= (b, n));
            boxed[from..].iter().take_while(move |entry| entry.0 == b).map(|entry| entry.1).find(close)
        };
        boxes.filter_map(in_box).min().map(|m| [n, m])
    };
    // the first partner of a node ends its search: many nodes at one place cost no more than a few
    let pairs: Vec<[u32; 2]> = which.par_iter().filter_map(partner).collect();
    (pairs.len(), pairs.first().copied())
}
