//! Meshes moved in space and put together.

use super::v3::{V3, add, cross, dot, scale, sub};
use super::{CellArray, Group, Mesh, MeshArrays, NodeArray};

/// A turn about a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// A point of the line; length.
    pub point: [f64; 3],
    /// Its direction, of length one.
    pub axis: [f64; 3],
    /// Degrees, positive as a right-handed screw along the axis.
    pub degrees: f64,
}

impl Turn {
    /// Where the turn takes `x` (Rodrigues). Quarters of a turn are exact.
    pub fn apply(&self, x: [f64; 3]) -> [f64; 3] {
        let (sine, cosine) = sine_cosine(self.degrees);
        let r = sub(x, self.point);
        let along = scale(dot(self.axis, r), self.axis);
        let across = sub(r, along);
        add(self.point, add(along, add(scale(cosine, across), scale(sine, cross(self.axis, across)))))
    }
}

fn sine_cosine(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

/// Turns, then moves all nodes of a mesh.
pub fn place(mesh: &mut Mesh, turn: Option<&Turn>, by: [f64; 3]) {
    for x in &mut mesh.nodes {
        let turned: V3 = turn.map_or(*x, |turn| turn.apply(*x));
        *x = add(turned, by);
    }
}

/// One mesh of several, whose nodes are not joined where they meet. The groups of the part `NAME` are called
/// `NAME.group`; the new group `NAME` has all its cells.
pub fn join(parts: Vec<(String, Mesh)>) -> Mesh {
    let mut all = Mesh {
        nodes: Vec::new(),
        cells: Vec::new(),
        faces: Vec::new(),
        groups: Vec::new(),
        arrays: MeshArrays::default(),
    };
    for (name, mut part) in parts {
        let (nodes, faces) = (all.nodes.len() as u32, all.faces.len() as u32);
        let (cells, count) = (all.cell_count() as u32, part.cell_count() as u32);
        part.cells.iter_mut().flat_map(|block| &mut block.nodes).for_each(|node| *node += nodes);
        for face in &mut part.faces {
            face.cell += cells;
            shift(&mut face.all, nodes);
        }
        for group in &mut part.groups {
            group.name = format!("{name}.{}", group.name);
            group.cells.iter_mut().for_each(|cell| *cell += cells);
            group.faces.iter_mut().for_each(|face| *face += faces);
            group.nodes.iter_mut().for_each(|node| *node += nodes);
            group.interior_faces.iter_mut().for_each(|corners| shift(corners, nodes));
        }
        append(&mut all.arrays, std::mem::take(&mut part.arrays), &name, [nodes, cells, faces]);
        all.groups.push(Group { name, cells: (cells..cells + count).collect(), ..Group::default() });
        all.groups.append(&mut part.groups);
        all.nodes.append(&mut part.nodes);
        all.cells.append(&mut part.cells);
        all.faces.append(&mut part.faces);
    }
    let (nodes, cells) = (all.nodes.len(), all.cell_count());
    all.arrays.nodes.iter_mut().for_each(|array| array.values.resize(nodes, f64::NAN));
    all.arrays.cells.iter_mut().for_each(|array| array.values.resize(cells, f64::NAN));
    all
}

/// Appends the arrays of a part before which there are so many nodes, cells and faces. Elsewhere they have no value; who
/// asks for it there is answered so.
fn append(all: &mut MeshArrays, part: MeshArrays, name: &str, [nodes, cells, faces]: [u32; 3]) {
    let called = |array: &str| format!("{name}.{array}");
    let padded = |before: u32, values: Vec<f64>| {
        let mut padded = vec![f64::NAN; before as usize];
        padded.extend(values);
        padded
    };
    for NodeArray { name, values } in part.nodes {
        all.nodes.push(NodeArray { name: called(&name), values: padded(nodes, values) });
    }
    for CellArray { name, values, faces: own } in part.cells {
        let own = own.into_iter().map(|(face, value)| (face + faces, value)).collect();
        all.cells.push(CellArray { name: called(&name), values: padded(cells, values), faces: own });
    }
    all.others.extend(part.others.into_iter().map(|(name, what)| (called(&name), what)));
}

/// Marks of places without a node stay.
fn shift(nodes: &mut [u32], by: u32) {
    nodes.iter_mut().filter(|node| **node != u32::MAX).for_each(|node| *node += by);
}

#[cfg(test)]
mod tests {
    use super::super::{Block, BlockElement, RawCells, RawGroup, RawMesh, block, bodies, build};
    use super::*;

    fn cube(element: BlockElement) -> Mesh {
        block(&Block { size: [1.0; 3], cells: [2, 1, 1], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap()
    }

    #[test]
    fn a_joined_mesh_is_what_a_file_with_both_parts_would_give() {
        let (a, b) = (cube(BlockElement::Tet4Six), cube(BlockElement::Hex8));
        let joined = join(vec![("a".into(), a.clone()), ("b".into(), b.clone())]);
        let shift = a.nodes.len() as u32;
        let raw = RawMesh {
            nodes: [a.nodes.clone(), b.nodes.clone()].concat(),
            cells: vec![
                RawCells { kind: a.cells[0].kind, nodes: a.cells[0].nodes.clone(), ids: Vec::new() },
                RawCells {
                    kind: b.cells[0].kind,
                    nodes: b.cells[0].nodes.iter().map(|n| n + shift).collect(),
                    ids: Vec::new(),
                },
            ],
            groups: vec![RawGroup {
                name: "b.z-max".into(),
                faces: (b.groups[5].faces.iter())
                    .map(|&f| std::array::from_fn(|i| b.faces[f as usize].nodes()[i] + shift))
                    .collect(),
                ..RawGroup::default()
            }],
            ..RawMesh::default()
        };
        let (built, _) = build(raw).unwrap();
        assert_eq!((&joined.nodes, &joined.cells, &joined.faces), (&built.nodes, &built.cells, &built.faces));
        assert_eq!(joined.group("b.z-max"), built.group("b.z-max"));
        assert_eq!(joined.group("b").unwrap().cells, [12, 13]);
        assert_eq!(bodies(&joined).iter().max(), Some(&1));
    }

    #[test]
    fn turns_are_right_handed_and_quarters_exact() {
        let quarter = Turn { point: [1.0, 0.0, 0.0], axis: [0.0, 0.0, 1.0], degrees: 90.0 };
        assert_eq!(quarter.apply([3.0, 0.0, 5.0]), [1.0, 2.0, 5.0]);
        let axis = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
        let turn = Turn { point: [0.3, -1.0, 2.0], axis, degrees: 17.0 };
        let back = Turn { degrees: -17.0, ..turn };
        let x = [1.0, 2.0, -0.5];
        let there = turn.apply(x);
        let again = back.apply(there);
        assert!((0..3).all(|c| (again[c] - x[c]).abs() < 1e-15 * 8.0));
        assert!((dot(sub(there, turn.point), axis) - dot(sub(x, turn.point), axis)).abs() < 1e-14);
    }
}
