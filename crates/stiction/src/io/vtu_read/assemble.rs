//! From arrays to a mesh.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::document::{Document, Number, Section};
use super::types::{Role, role};
use super::xml::DAMAGED;
use crate::Error;
use crate::mesh::{
    CellArray, CellKind, Mesh, MeshArrays, MeshNote, MeshNotes, NodeArray, RawCells, RawGroup, RawMesh, build,
};

/// Arrays of more values are numbers of something else than groups.
pub(super) const MOST_GROUPS: usize = 1000;
/// Numbers that a thread looks through at a time.
const AT_A_TIME: usize = 1 << 14;
/// Nodes of the largest cell.
const MOST_NODES: usize = 20;

/// What became of a cell of the file: its number among those of its kind.
#[derive(Clone, Copy)]
enum Place {
    /// Its number among those of its kind, which has this place in `CellKind::ALL`.
    Cell(u8, u32),
    Face(u32),
    /// A point or a line.
    Line(u32),
}

/// The cells of the file.
struct Sorted {
    /// One block for each of `CellKind::ALL`.
    blocks: [RawCells; CellKind::ALL.len()],
    places: Vec<Place>,
    faces: Vec<[u32; 4]>,
    /// Nodes of all lines, and where those of each begin and end.
    line_nodes: Vec<u32>,
    lines: Vec<[u32; 2]>,
}

/// Memory that a mesh takes while it is read and built, bytes.
struct Bytes;

impl Bytes {
    const POINT: f64 = 72.0;
    const CELL: f64 = 32.0;
    /// A node that a cell names.
    const NAMED: f64 = 6.0;
    /// A number of an array that makes groups, and of one that is kept.
    const GROUPED: f64 = 16.0;
    const KEPT: f64 = 16.0;

    /// All but the arrays, with so many nodes named by cells.
    fn of_mesh(document: &Document, named: usize) -> f64 {
        Self::POINT * document.points as f64 + Self::CELL * document.cells as f64 + Self::NAMED * named as f64
    }
}

/// Numbers of an array with one a point or a cell.
fn numbers(document: &Document, array: &super::document::Array) -> usize {
    if array.section == Section::PointData { document.points } else { document.cells }
}

/// Collects cells and groups and builds the mesh.
pub(super) fn assemble(document: &Document, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    let grouped = document.arrays.iter().filter(|a| is_data(a) && makes_groups(a));
    let grouped: f64 = grouped.map(|a| Bytes::GROUPED * numbers(document, a) as f64).sum();
    // Of each cell one node at least.
    document.admit("its mesh", Bytes::of_mesh(document, document.cells) + grouped)?;
    let points = document.floats(document.needed(Section::Points, "Points")?, 3 * document.points)?;
    let nodes: Vec<[f64; 3]> = points.as_chunks::<3>().0.iter().map(|x| x.map(|c| c * scale)).collect();
    drop(points);
    let cells = sort(document)?;
    let mut notes = Vec::new();
    let mut groups = cell_groups(document, &cells, &mut notes)?;
    let in_group = !groups.is_empty();
    point_groups(document, &mut groups, &mut notes)?;
    let named = cells.blocks.iter().map(|block| block.nodes.len()).sum();
    let arrays = arrays(document, &cells, Bytes::of_mesh(document, named) + grouped);
    note_unused(document, &cells, &arrays, in_group, &mut notes);
    let Sorted { blocks, places, faces, .. } = cells;
    drop(places); // the build needs memory of its own
    let array_faces = if arrays.cells.is_empty() { Vec::new() } else { faces };
    let mut raw = RawMesh { nodes, cells: blocks.into(), groups, arrays, array_faces, ..RawMesh::default() };
    raw.turn_wedges();
    let (mesh, built) = build(raw)?;
    notes.extend(built.0);
    Ok((mesh, MeshNotes(notes)))
}

/// Reads the cells and sorts them by what they are.
fn sort(document: &Document) -> Result<Sorted, Error> {
    let unknown = |n: i64| u32::try_from(n).unwrap_or(u32::MAX);
    let code = |n: i64| u8::try_from(n).unwrap_or(u8::MAX);
    let codes = document.integers(document.needed(Section::Cells, "types")?, document.cells, code)?;
    let ends = document.integers(document.needed(Section::Cells, "offsets")?, document.cells, unknown)?;
    let count = ends.last().map_or(0, |&end| end as usize);
    document.admit("its mesh", Bytes::of_mesh(document, count))?;
    let mut nodes = document.integers(document.needed(Section::Cells, "connectivity")?, count, unknown)?;

    let block = |kind| RawCells { kind, nodes: Vec::new(), ids: Vec::new() };
    if let Some(which) = only_kind(document, &codes, &ends, &nodes) {
        let mut blocks = CellKind::ALL.map(block);
        blocks[which].nodes = nodes;
        blocks[which].ids = (0..codes.len() as u64).collect();
        let places = (0..codes.len() as u32).map(|i| Place::Cell(which as u8, i)).collect();
        return Ok(Sorted { blocks, places, faces: Vec::new(), line_nodes: Vec::new(), lines: Vec::new() });
    }
    // Nearly all cells of nearly every file are of one kind: they move to the front of the list they come in.
    let major = major(&codes, &ends);
    let mut front = 0;
    let others = others(&codes, &ends, nodes.len());
    let mut sorted = Sorted {
        blocks: CellKind::ALL.map(block),
        places: Vec::with_capacity(codes.len()),
        faces: Vec::with_capacity(others.faces),
        line_nodes: Vec::with_capacity(others.line_nodes),
        lines: Vec::with_capacity(others.lines),
    };
    if let Some((major, count)) = major {
        sorted.blocks[major].ids.reserve_exact(count);
    }
    let mut refused: BTreeMap<&str, (usize, &str)> = BTreeMap::new();
    let mut from = 0;
    for (i, (&code, &end)) in codes.iter().zip(&ends).enumerate() {
        let fail = |what: String| Error::new(format!("cell {i}"), what, DAMAGED);
        let Some(cell) = nodes.get(from..end as usize) else {
            return Err(fail(format!("its nodes end at {end} where they begin at {from} of {count}")));
        };
        from = end as usize;
        if let Some(node) = cell.iter().find(|&&node| node as usize >= document.points) {
            return Err(fail(format!("it names node {node} of {} (counted from 0)", document.points)));
        }
        let place = match role(code, cell.len()) {
            Role::Cell(kind, order) => {
                let which = CellKind::ALL.iter().position(|&k| k == kind).unwrap_or(0);
                let block = &mut sorted.blocks[which];
                if major.is_some_and(|major| major.0 == which) {
                    let mut taken = [0; MOST_NODES];
                    taken.iter_mut().zip(order).for_each(|(node, &n)| *node = cell[n]);
                    nodes[front..front + order.len()].copy_from_slice(&taken[..order.len()]);
                    front += order.len();
                } else {
                    block.nodes.extend(order.iter().map(|&n| cell[n]));
                }
                block.ids.push(i as u64);
                Place::Cell(which as u8, block.ids.len() as u32 - 1)
            }
            Role::Face(order) => {
                let mut corners = [u32::MAX; 4];
                corners.iter_mut().zip(order).for_each(|(corner, &n)| *corner = cell[n]);
                sorted.faces.push(corners);
                Place::Face(sorted.faces.len() as u32 - 1)
            }
            Role::Nodes => {
                sorted.line_nodes.extend(cell);
                let end = sorted.line_nodes.len();
                sorted.lines.push([end - cell.len(), end].map(|n| n as u32));
                Place::Line(sorted.lines.len() as u32 - 1)
            }
            Role::Refused(what, remedy) => {
                refused.entry(what).or_insert((0, remedy)).0 += 1;
                continue;
            }
        };
        sorted.places.push(place);
    }
    if let Some((major, _)) = major {
        nodes.truncate(front);
        sorted.blocks[major].nodes = nodes;
    }
    if let Some((_, (_, remedy))) = refused.iter().next() {
        let list: Vec<String> = refused.iter().map(|(what, (count, _))| format!("{count} x {what}")).collect();
        return Err(Error::new("", format!("cells that cannot be used: {}", list.join(", ")), *remedy));
    }
    if sorted.blocks.iter().all(|block| block.ids.is_empty()) {
        let what = format!("there are no volume cells among its {} cells", codes.len());
        return Err(Error::new("", what, "write the solid with tetrahedra, wedges or hexahedra, not only its surface"));
    }
    Ok(sorted)
}

/// The place in `CellKind::ALL` of the kind of all cells, if there is nothing to sort or to refuse.
fn only_kind(document: &Document, codes: &[u8], ends: &[u32], nodes: &[u32]) -> Option<usize> {
    let Role::Cell(kind, order) = role(*codes.first()?, *ends.first()? as usize) else { return None };
    let n = order.len();
    let follow = |(k, ends): (usize, &[u32])| (k * AT_A_TIME + 1..).zip(ends).all(|(i, &end)| end as usize == n * i);
    let ordered = order.iter().enumerate().all(|(i, &place)| i == place)
        && codes.par_chunks(AT_A_TIME).all(|some| some.iter().all(|code| *code == codes[0]))
        && ends.par_chunks(AT_A_TIME).enumerate().all(follow)
        && nodes.par_chunks(AT_A_TIME).all(|some| some.iter().all(|&node| (node as usize) < document.points));
    if ordered { CellKind::ALL.iter().position(|&k| k == kind) } else { None }
}

/// Cells that are no volumes, and the nodes of lines.
#[derive(Default)]
struct Others {
    faces: usize,
    lines: usize,
    line_nodes: usize,
}

/// How many of them there are, of `nodes` altogether: arrays that grow take up to three times what they hold.
fn others(codes: &[u8], ends: &[u32], nodes: usize) -> Others {
    let (mut found, mut from) = (Others::default(), 0);
    for (&code, &end) in codes.iter().zip(ends) {
        let count = end.saturating_sub(from) as usize;
        match role(code, count) {
            Role::Face(_) => found.faces += 1,
            Role::Nodes => (found.lines, found.line_nodes) = (found.lines + 1, found.line_nodes + count),
            Role::Cell(..) | Role::Refused(..) => {}
        }
        from = from.max(end);
    }
    // Ends that do not ascend, or lie beyond the nodes, are refused where cells are read.
    found.line_nodes = found.line_nodes.min(nodes);
    found
}

/// The place in `CellKind::ALL` of the kind that most cells are of, and how many are.
fn major(codes: &[u8], ends: &[u32]) -> Option<(usize, usize)> {
    let mut counts = [0; CellKind::ALL.len()];
    let mut from = 0;
    for (&code, &end) in codes.iter().zip(ends) {
        if let Role::Cell(kind, _) = role(code, end.saturating_sub(from) as usize) {
            counts.iter_mut().zip(CellKind::ALL).filter(|(_, k)| *k == kind).for_each(|(count, _)| *count += 1);
        }
        from = end;
    }
    counts.into_iter().enumerate().filter(|count| count.1 > 0).max_by_key(|count| count.1)
}

/// The values of an array that makes groups, and whether they are all 0 or 1.
fn group_values(document: &Document, section: Section, count: usize) -> Result<Vec<(String, Vec<i64>, bool)>, Error> {
    let mut arrays = Vec::new();
    for array in document.arrays.iter().filter(|a| a.section == section && makes_groups(a)) {
        let values = document.integers(array, count, |n| n)?;
        let mut distinct: Vec<i64> = Vec::new();
        for value in &values {
            if let Err(at) = distinct.binary_search(value) {
                distinct.insert(at, *value);
            }
            if distinct.len() > MOST_GROUPS {
                break;
            }
        }
        let numbers = distinct.len() == values.len() && values.len() > 2;
        if !numbers && distinct.len() <= MOST_GROUPS {
            arrays.push((array.name.clone(), values, distinct.iter().all(|v| [0, 1].contains(v))));
        }
    }
    Ok(arrays)
}

pub(super) fn makes_groups(array: &super::document::Array) -> bool {
    array.number != Number::Float && array.components == 1 && !array.name.starts_with("vtk") && !array.name.is_empty()
}

/// The name of the group of cells or points with that value.
pub(super) fn group_name(array: &str, value: i64, mask: bool) -> String {
    if mask && value == 1 { array.to_string() } else { format!("{array}-{value}") }
}

fn cell_groups(document: &Document, cells: &Sorted, notes: &mut Vec<MeshNote>) -> Result<Vec<RawGroup>, Error> {
    let mut groups: Vec<RawGroup> = Vec::new();
    let mut first = [0; CellKind::ALL.len()];
    (1..first.len()).for_each(|k| first[k] = first[k - 1] + cells.blocks[k - 1].ids.len() as u32);
    for (array, values, mask) in group_values(document, Section::CellData, document.cells)? {
        let mut of_value: BTreeMap<i64, RawGroup> = BTreeMap::new();
        for (place, value) in cells.places.iter().zip(values) {
            let group = of_value.entry(value).or_default();
            match *place {
                Place::Cell(kind, i) => group.cells.push(first[kind as usize] + i),
                Place::Face(i) => group.faces.push(cells.faces[i as usize]),
                Place::Line(i) => {
                    let [from, to] = cells.lines[i as usize];
                    group.nodes.extend(&cells.line_nodes[from as usize..to as usize]);
                }
            }
        }
        for (value, mut group) in of_value {
            group.name = group_name(&array, value, mask);
            groups.push(group);
        }
    }
    notes.extend(merge(&mut groups));
    Ok(groups)
}

fn point_groups(document: &Document, groups: &mut Vec<RawGroup>, notes: &mut Vec<MeshNote>) -> Result<(), Error> {
    for (array, values, mask) in group_values(document, Section::PointData, document.points)? {
        let mut of_value: BTreeMap<i64, RawGroup> = BTreeMap::new();
        for (node, &value) in values.iter().enumerate().filter(|(_, value)| !(mask && **value == 0)) {
            of_value.entry(value).or_default().nodes.push(node as u32);
        }
        for (value, mut group) in of_value {
            (group.name, group.faces_of_nodes) = (group_name(&array, value, mask), true);
            groups.push(group);
        }
    }
    notes.extend(merge(groups));
    Ok(())
}

/// Arrays of one number a point or a cell that make no groups; `taken` is the memory of all else.
fn arrays(document: &Document, cells: &Sorted, mut taken: f64) -> MeshArrays {
    let mut arrays = MeshArrays::default();
    for array in document.arrays.iter().filter(|a| is_data(a)) {
        let name = array.name.clone();
        if let Some(what) = unfit(array) {
            arrays.others.push((name, what));
            continue;
        }
        // One that cannot be read is no reason to refuse the mesh: who asks for it gets the reason.
        let count = numbers(document, array);
        taken += Bytes::KEPT * count as f64;
        match document.admit("its mesh with this array", taken).and_then(|()| document.floats(array, count)) {
            Ok(values) if array.section == Section::PointData => arrays.nodes.push(NodeArray { name, values }),
            Ok(values) => arrays.cells.push(cell_array(name, &values, cells)),
            Err(error) => arrays.others.push((name, error.what)),
        }
    }
    arrays
}

pub(super) fn is_data(array: &super::document::Array) -> bool {
    matches!(array.section, Section::PointData | Section::CellData) && !array.name.is_empty()
}

/// Why an array is not a number at each place.
fn unfit(array: &super::document::Array) -> Option<String> {
    match array.number {
        _ if array.components != 1 => Some(format!("it has {} components", array.components)),
        Number::Float => None,
        Number::Signed | Number::Unsigned => Some("its whole numbers make groups".into()),
    }
}

/// The values of cells and faces out of those of all cells of the file.
fn cell_array(name: String, values: &[f64], cells: &Sorted) -> CellArray {
    let blocks = cells.blocks.iter().map(|block| vec![f64::NAN; block.ids.len()]);
    let mut of_blocks: Vec<Vec<f64>> = blocks.collect();
    let mut faces = Vec::new();
    for (place, &value) in cells.places.iter().zip(values) {
        match *place {
            Place::Cell(kind, i) => of_blocks[kind as usize][i as usize] = value,
            Place::Face(i) => faces.push((i, value)),
            Place::Line(_) => {}
        }
    }
    CellArray { name, values: of_blocks.concat(), faces }
}

/// Groups of one name become one.
fn merge(groups: &mut Vec<RawGroup>) -> Vec<MeshNote> {
    let mut at: HashMap<String, usize> = HashMap::new();
    let mut notes = Vec::new();
    let mut merged: Vec<RawGroup> = Vec::with_capacity(groups.len());
    for group in groups.drain(..) {
        match at.get(&group.name) {
            Some(&first) => {
                notes.push(MeshNote::SharedName { group: group.name });
                let first: &mut RawGroup = &mut merged[first];
                first.cells.extend(group.cells);
                first.faces.extend(group.faces);
                first.nodes.extend(group.nodes);
                first.faces_of_nodes |= group.faces_of_nodes;
            }
            None => {
                at.insert(group.name.clone(), merged.len());
                merged.push(group);
            }
        }
    }
    *groups = merged;
    notes
}

/// Notes arrays that are not read, and faces in no group.
fn note_unused(document: &Document, cells: &Sorted, arrays: &MeshArrays, in_group: bool, notes: &mut Vec<MeshNote>) {
    let data = |a: &&super::document::Array| matches!(a.section, Section::PointData | Section::CellData);
    let read = |a: &super::document::Array| is_data(a) && !arrays.others.iter().any(|other| other.0 == a.name);
    let unused = document.arrays.iter().filter(data).filter(|a| !makes_groups(a) && !read(a));
    let what: Vec<String> = unused.map(|a| format!("array \"{}\"", a.name)).collect();
    if !what.is_empty() {
        notes.push(MeshNote::NotRead { what });
    }
    let count = cells.faces.len() + cells.lines.len();
    if count > 0 && !in_group {
        notes.push(MeshNote::Skipped { what: "surface or curve element".into(), count });
    }
}
