//! What is in a mesh.

use std::fmt;

use rayon::prelude::*;

use super::v3::norm;
use super::{CellKind, Mesh, bodies};

/// A summary of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshInfo {
    /// Number of nodes.
    pub nodes: usize,
    /// One entry for each kind of cell.
    pub cells: Vec<CellInfo>,
    /// Lowest and highest coordinates.
    pub bounding_box: [[f64; 3]; 2],
    /// Volume of all cells, length cubed.
    pub volume: f64,
    /// Number of boundary faces.
    pub faces: usize,
    /// Area of the boundary.
    pub area: f64,
    /// Number of connected bodies.
    pub bodies: usize,
    /// Edges of a single boundary face; none in a mesh whose cells meet face to face.
    pub open_edges: usize,
    /// Edges where more than two boundary faces meet: the body touches itself along a line.
    pub non_manifold_edges: usize,
    /// The groups.
    pub groups: Vec<GroupInfo>,
}

/// Cells of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct CellInfo {
    /// The kind.
    pub kind: CellKind,
    /// Number of cells of the kind.
    pub count: usize,
    /// Least and mean of [`quality`](super::quality), in (0, 1].
    pub min_quality: f64,
    /// Mean quality, 1 for the best shape.
    pub mean_quality: f64,
    /// Number of the cell with the least quality.
    pub worst: usize,
}

/// A named group.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupInfo {
    /// Name of the group.
    pub name: String,
    /// Number of its cells.
    pub cells: usize,
    /// Number of its boundary faces.
    pub faces: usize,
    /// Number of its faces between two cells.
    pub interior_faces: usize,
    /// All nodes of the group, also those of its cells and faces.
    pub nodes: usize,
    /// Volume of its cells.
    pub volume: f64,
    /// Area of its boundary faces.
    pub area: f64,
}

/// Counts, sizes, quality and groups of a mesh.
pub fn info(mesh: &Mesh) -> MeshInfo {
    let bodies = bodies(mesh).iter().max().map_or(0, |&last| last as usize + 1);
    info_with(mesh, &mesh.cell_shapes(), bodies)
}

/// What is to be known of the shape of a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellShape {
    /// Volume of all cells, length cubed.
    pub volume: f64,
    pub quality: f64,
}

/// The same where the shapes of the cells are known, one a cell, and the number of bodies.
pub(crate) fn info_with(mesh: &Mesh, shapes: &[CellShape], bodies: usize) -> MeshInfo {
    let [open_edges, non_manifold_edges] = edges(mesh);
    MeshInfo {
        nodes: mesh.nodes.len(),
        cells: cells(mesh, shapes),
        bounding_box: mesh.bounding_box(),
        volume: shapes.iter().map(|shape| shape.volume).sum(),
        faces: mesh.faces.len(),
        area: (0..mesh.faces.len()).map(|f| mesh.face_area(f)).sum(),
        bodies,
        open_edges,
        non_manifold_edges,
        groups: mesh.groups.iter().map(|g| group(mesh, g, shapes)).collect(),
    }
}

fn cells(mesh: &Mesh, shapes: &[CellShape]) -> Vec<CellInfo> {
    let mut infos: Vec<CellInfo> = Vec::new();
    let mut first = 0;
    for block in &mesh.cells {
        let kind = block.kind;
        let at = infos.iter().position(|info| info.kind == kind).unwrap_or_else(|| {
            infos.push(CellInfo { kind, count: 0, min_quality: f64::INFINITY, mean_quality: 0.0, worst: first });
            infos.len() - 1
        });
        let info = &mut infos[at];
        for (number, shape) in (first..).zip(&shapes[first..first + block.len()]) {
            info.mean_quality += shape.quality; // a sum until all are counted
            if shape.quality < info.min_quality {
                (info.min_quality, info.worst) = (shape.quality, number);
            }
        }
        info.count += block.len();
        first += block.len();
    }
    infos.iter_mut().for_each(|info| info.mean_quality /= info.count as f64);
    infos
}

fn group(mesh: &Mesh, group: &super::Group, shapes: &[CellShape]) -> GroupInfo {
    GroupInfo {
        name: group.name.clone(),
        cells: group.cells.len(),
        faces: group.faces.len(),
        interior_faces: group.interior_faces.len(),
        nodes: mesh.group_nodes(group).len(),
        volume: group.cells.iter().map(|&c| shapes[c as usize].volume).sum(),
        area: group.faces.iter().map(|&f| mesh.face_area(f as usize)).sum(),
    }
}

/// Numbers of boundary edges with one face, and with more than two.
fn edges(mesh: &Mesh) -> [usize; 2] {
    let mut edges = Vec::with_capacity(4 * mesh.faces.len());
    for face in &mesh.faces {
        let nodes = face.corners();
        for (i, &a) in nodes.iter().enumerate() {
            let b = nodes[(i + 1) % nodes.len()];
            edges.push([a.min(b), a.max(b)]);
        }
    }
    edges.par_sort_unstable();
    let runs = edges.chunk_by(|a, b| a == b);
    runs.fold([0, 0], |[open, many], run| [open + usize::from(run.len() == 1), many + usize::from(run.len() > 2)])
}

impl fmt::Display for MeshInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.bounding_box;
        let size = [0, 1, 2].map(|c| high[c] - low[c]);
        writeln!(f, "nodes       {}", self.nodes)?;
        for cells in &self.cells {
            let (min, mean) = (cells.min_quality, cells.mean_quality);
            let (kind, count) = (cells.kind.name(), cells.count);
            writeln!(
                f,
                "cells       {count} {kind}, quality {min:.3} at worst (cell {}), {mean:.3} on average",
                cells.worst
            )?;
        }
        let triple = |x: [f64; 3]| format!("{} {} {}", short(x[0]), short(x[1]), short(x[2]));
        writeln!(f, "box         from {} to {}", triple(low), triple(high))?;
        writeln!(f, "size        {} (diagonal {})", triple(size), short(norm(size)))?;
        writeln!(f, "volume      {}", short(self.volume))?;
        writeln!(f, "boundary    {} faces, area {}", self.faces, short(self.area))?;
        writeln!(f, "edges       {} open, {} with more than two faces", self.open_edges, self.non_manifold_edges)?;
        writeln!(f, "bodies      {}", self.bodies)?;
        if self.groups.is_empty() {
            return writeln!(f, "groups      none");
        }
        let width = self.groups.iter().map(|g| g.name.chars().count()).max().unwrap_or(0).max(5);
        writeln!(
            f,
            "\n{:width$} {:>9} {:>9} {:>9} {:>9} {:>12} {:>12}",
            "group", "cells", "faces", "interior", "nodes", "volume", "area"
        )?;
        for g in &self.groups {
            writeln!(
                f,
                "{:width$} {:>9} {:>9} {:>9} {:>9} {:>12} {:>12}",
                g.name,
                g.cells,
                g.faces,
                g.interior_faces,
                g.nodes,
                short(g.volume),
                short(g.area)
            )?;
        }
        Ok(())
    }
}

/// Six significant digits, without an exponent where none is needed.
fn short(x: f64) -> String {
    let x = x + 0.0; // an empty sum is -0
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) {
        let digits = if x == 0.0 { 0 } else { (5 - x.abs().log10().floor() as i32).max(0) as usize };
        let text = format!("{x:.digits$}");
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text };
    }
    format!("{x:.5e}")
}
