//! Any mesh cut into tetrahedra that meet face to face.
//!
//! Every quadrilateral is halved from its corner with the lowest number, which both of its cells see alike; a hexahedron
//! or a wedge becomes the pyramids from its own lowest corner over the faces opposite, or over their halves (Dompierre, Labbé, Vallet,
//! Camarero, "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999). No corner is added.

use super::bisect::{Bisection, Marks, Refined, initial, unit};
use super::geometry::{HEX_CORNERS, tet_jacobian};
use super::inherit::{Children, Edges, Labels, NONE, OPPOSITE, Rows, edges_between};
use super::shape::TET_EDGES;
use super::v3::{V3, add, cross, det, dot, norm, scale, sub};
use super::{CellKind, Group, Mesh};
use crate::Error;

/// The order of the tetrahedra made of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Four nodes.
    Linear,
    /// Ten nodes.
    Quadratic,
}

/// A mesh as tetrahedra of that order, ready to be refined; see [`cut`].
///
/// # Errors
/// As [`cut`].
pub fn tetrahedra(mesh: &Mesh, order: Order) -> Result<Bisection, Error> {
    cut(mesh, order).map(|cut| cut.next)
}

/// A mesh as tetrahedra of that order, with marks by their longest edges.
///
/// Tetrahedra stay, hexahedra become five or six, wedges three. Nodes keep their numbers; those in the middles of new edges come after
/// them. Edges of quadratic cells stay as they are, other edges are straight, except for the diagonals of faces that are
/// not plane: their middles are those of the faces. Linear hexahedra and wedges so keep all their faces if the order is quadratic; if
/// it is linear, a warped face becomes two triangles. Cells of several orders cannot share a face in a [`Mesh`]; where
/// they share an edge only, its middle becomes that of all. Triangles of tetrahedra on quadrilaterals of other cells are
/// joined where the diagonal is the same.
///
/// # Errors
/// If a hexahedron or wedge is so warped that one of its tetrahedra would be inside out, or if quadratic cells are to become linear.
pub fn cut(mesh: &Mesh, order: Order) -> Result<Refined, Error> {
    let is_quadratic = |kind: CellKind| kind != kind.linear();
    if order == Order::Linear && mesh.cells.iter().any(|block| is_quadratic(block.kind)) {
        let what = "linear cells were asked for, but the mesh has quadratic ones, which would lose their curved edges";
        return Err(Error::new("mesh", what, "take quadratic cells, or mesh with linear elements"));
    }
    let faces = Labels::new(mesh);
    let unit = unit(mesh);
    let mut pieces = Pieces::default();
    for (number, (kind, cell)) in (0..).zip(mesh.cell_iter()) {
        let labels = &faces.of_cell[number as usize];
        if kind.linear() == CellKind::Tet4 {
            let corners = [cell[0], cell[1], cell[2], cell[3]];
            pieces.push(&mesh.nodes, unit, number, corners, OPPOSITE.map(|local| labels[local]));
            continue;
        }
        let parts = if kind.linear() == CellKind::Wedge6 { wedge(cell) } else { hexahedron(cell) };
        for local in parts {
            let corners = local.map(|i| cell[i]);
            if det(tet_jacobian(&corners.map(|node| mesh.nodes[node as usize]))) <= 0.0 {
                let x = mesh.nodes[cell[0] as usize];
                let name = if kind.linear() == CellKind::Wedge6 { "wedge" } else { "hexahedron" };
                let what = format!("the {name} {} at {x:?} is too warped to be cut into tetrahedra", number + 1);
                return Err(Error::new("mesh", what, "mesh with tetrahedra, or make its faces flatter"));
            }
            let of_face = std::array::from_fn(|i| face_of(kind, local, i).map_or(NONE, |face| labels[face]));
            pieces.push(&mesh.nodes, unit, number, corners, of_face);
        }
    }
    pieces.finish(mesh, order, unit, &faces).map_err(|error| error.at("cut into tetrahedra"))
}

/// The tetrahedra by the corners of the hexahedron; five where that can be, else six.
fn hexahedron(cell: &[u32]) -> Vec<[usize; 4]> {
    let lowest = (0..8).min_by_key(|&i| cell[i]).unwrap_or(0);
    let opposite = (0..8).find(|&i| (0..3).all(|c| HEX_CORNERS[i][c] != HEX_CORNERS[lowest][c])).unwrap_or(6);
    let halves = opposite_to(CellKind::Hex8, cell, lowest);
    // Seen from outside the corners of a face turn left, seen from the lowest corner right.
    let pyramid = |[a, b, c]: [usize; 3]| [a, c, b, lowest];
    let around: Vec<[usize; 3]> = halves.iter().copied().filter(|half| half.contains(&opposite)).collect();
    let [first, _, _] = around[..] else { return halves.into_iter().map(pyramid).collect() };
    // No diagonal ends at the opposite corner: three of the pyramids are its tip and a tetrahedron under it.
    let turn = first.iter().position(|&i| i == opposite).unwrap_or(0);
    let (b, c) = (first[(turn + 1) % 3], first[(turn + 2) % 3]);
    let last = around.iter().flatten().copied().find(|&i| i != opposite && i != b && i != c).unwrap_or(0);
    let rest = halves.into_iter().filter(|half| !half.contains(&opposite)).map(pyramid);
    rest.chain([[opposite, c, b, last], [lowest, b, c, last]]).collect()
}

/// The three tetrahedra by the corners of the wedge: over the triangle and the two halves of the quadrilateral opposite to
/// the lowest corner, all positive where the wedge is.
fn wedge(cell: &[u32]) -> Vec<[usize; 4]> {
    let lowest = (0..6).min_by_key(|&i| cell[i]).unwrap_or(0);
    opposite_to(CellKind::Wedge6, cell, lowest).into_iter().map(|[a, b, c]| [a, c, b, lowest]).collect()
}

/// The faces of a cell that its lowest corner is not on, quadrilaterals halved.
fn opposite_to(kind: CellKind, cell: &[u32], lowest: usize) -> Vec<[usize; 3]> {
    let mut triangles = Vec::with_capacity(6);
    for face in kind.faces().iter().filter(|face| !face.contains(&lowest)) {
        let from = (0..face.len()).min_by_key(|&i| cell[face[i]]).unwrap_or(0);
        let at = |i: usize| face[(from + i) % face.len()];
        triangles.push([at(0), at(1), at(2)]);
        if face.len() == 4 {
            triangles.push([at(0), at(2), at(3)]);
        }
    }
    triangles
}

/// The face of a cell that the face of a tetrahedron in it opposite to corner `i` lies in.
fn face_of(kind: CellKind, local: [usize; 4], i: usize) -> Option<usize> {
    let within = |face: &[usize]| (0..4).all(|k| k == i || face.contains(&local[k]));
    kind.linear().faces().iter().position(|face| within(face))
}

/// Tetrahedra with their corners.
#[derive(Default)]
struct Pieces {
    corners: Vec<[u32; 4]>,
    labels: Vec<[u32; 4]>,
    parent: Vec<u32>,
    marks: Vec<Marks>,
}

impl Pieces {
    fn push(&mut self, nodes: &[V3], unit: f64, parent: u32, corners: [u32; 4], labels: [u32; 4]) {
        let (order, marks) = initial(nodes, unit, corners);
        self.corners.push(order.map(|i| corners[i]));
        self.labels.push(order.map(|i| labels[i]));
        self.parent.push(parent);
        self.marks.push(marks);
    }

    fn finish(self, mesh: &Mesh, order: Order, unit: f64, faces: &Labels) -> Result<Refined, Error> {
        let first = mesh.nodes.len();
        let (mut nodes, mut rows) = (mesh.nodes.clone(), Rows::new(first));
        let (mut kind, mut cells) = (CellKind::Tet4, self.corners.as_flattened().to_vec());
        let mut new = Vec::new();
        if order == Order::Quadratic {
            let middles = Middles::new(mesh, &self.corners);
            for (ends, from) in &middles.new {
                nodes.push(from.place(mesh, *ends));
                rows.push(from.row(mesh, *ends));
            }
            kind = CellKind::Tet10;
            cells = self.corners.iter().flat_map(|&corners| middles.cell(corners)).collect();
            new = middles.new;
        }
        let named = |group: &Group| {
            if group.nodes.is_empty() || new.is_empty() {
                return Vec::new();
            }
            let edges = edges_between(mesh, &group.nodes, unit);
            let has = |node: &u32| group.nodes.binary_search(node).is_ok();
            let is_in = |(ends, from): &([u32; 2], From)| match from {
                From::Edge => edges.binary_search(ends).is_ok(),
                _ => from.nodes(mesh).iter().all(has),
            };
            (first as u32..).zip(&new).filter(|(_, new)| is_in(new)).map(|(node, _)| node).collect()
        };
        let children =
            Children { old: mesh, nodes, kind, cells, parent: &self.parent, labels: self.labels, rows: &rows };
        let mesh = children.mesh(faces, named)?;
        Ok(Refined { next: Bisection { mesh, marks: self.marks }, parent: self.parent, rows })
    }
}

/// What the edge of a tetrahedron is of the cell it was made of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum From {
    Edge,
    /// A diagonal of a face of a hexahedron or wedge: the cell and which of its faces.
    Face(u32, u8),
    /// A diagonal through a hexahedron.
    Cell(u32),
}

impl From {
    /// The nodes of the face or cell.
    fn nodes(self, mesh: &Mesh) -> Vec<u32> {
        match self {
            From::Edge => Vec::new(),
            From::Face(cell, local) => {
                let (kind, nodes) = mesh.cell(cell as usize);
                kind.faces()[local as usize].iter().map(|&i| nodes[i]).collect()
            }
            From::Cell(cell) => mesh.cell(cell as usize).1.to_vec(),
        }
    }

    /// The functions of the cell in the middle of the edge.
    fn row(self, mesh: &Mesh, ends: [u32; 2]) -> Vec<(u32, f32)> {
        let nodes = self.nodes(mesh);
        let (corners, weights) = match (self, nodes.len()) {
            (From::Edge, _) => return ends.map(|node| (node, 0.5)).to_vec(),
            (From::Face(..), 8) => (4, [-0.25, 0.5]),
            (From::Face(..), _) => (4, [0.25, 0.0]),
            (From::Cell(_), 20) => (8, [-0.25, 0.25]),
            (From::Cell(_), _) => (8, [0.125, 0.0]),
        };
        nodes.iter().enumerate().map(|(i, &node)| (node, weights[usize::from(i >= corners)])).collect()
    }

    /// Where the middle lies.
    fn place(self, mesh: &Mesh, ends: [u32; 2]) -> V3 {
        let at = |node: u32| mesh.nodes[node as usize];
        let straight = scale(0.5, add(at(ends[0]), at(ends[1])));
        let is_straight = match self {
            From::Edge => true,
            From::Face(..) => {
                let x: Vec<V3> = self.nodes(mesh).into_iter().map(at).collect();
                let normal = cross(sub(x[2], x[0]), sub(x[3], x[1]));
                let size = norm(sub(x[2], x[0]));
                let normal = scale(1.0 / norm(normal), normal);
                let is_level = |x: &V3, other: V3| dot(sub(*x, other), normal).abs() <= ROUNDING * size;
                let off = |i: usize| sub(x[4 + i], scale(0.5, add(x[i], x[(i + 1) % 4])));
                x.iter().all(|point| is_level(point, x[0])) && (4..x.len()).all(|i| norm(off(i - 4)) <= ROUNDING * size)
            }
            From::Cell(cell) => {
                let (kind, nodes) = mesh.cell(cell as usize);
                let off = |(k, &[i, j]): (usize, &[usize; 2])| {
                    norm(sub(at(nodes[8 + k]), scale(0.5, add(at(nodes[i]), at(nodes[j])))))
                };
                kind.edges().iter().enumerate().map(off).fold(0.0, f64::max)
                    <= ROUNDING * norm(sub(at(ends[1]), at(ends[0])))
            }
        };
        if is_straight {
            return straight;
        }
        let add_weighted = |sum: V3, (node, weight): (u32, f32)| add(sum, scale(f64::from(weight), at(node)));
        self.row(mesh, ends).into_iter().fold([0.0; 3], add_weighted)
    }
}

/// How far a point may lie off a plane or a line that it belongs to, as a part of the size of its face.
const ROUNDING: f64 = 1e-9;

/// The nodes in the middles of all edges.
struct Middles {
    edges: Edges,
    of_edge: Vec<u32>,
    /// The new ones in their order: ends of the edge, the lower first, and where it lies.
    new: Vec<([u32; 2], From)>,
}

impl Middles {
    fn new(mesh: &Mesh, corners: &[[u32; 4]]) -> Middles {
        let edges = Edges::new(mesh.nodes.len(), corners);
        let mut of_edge = vec![NONE; edges.len()];
        let mut from = vec![From::Edge; edges.len()];
        for (number, (kind, cell)) in (0..).zip(mesh.cell_iter()) {
            for (&[i, j], &middle) in kind.edges().iter().zip(&cell[kind.linear().nodes()..]) {
                if let Some(edge) = edges.find(cell[i], cell[j]) {
                    of_edge[edge] = middle;
                }
            }
            if kind.linear() == CellKind::Tet4 {
                continue;
            }
            for (local, face) in (0..).zip(kind.linear().faces()).filter(|(_, face)| face.len() == 4) {
                for (i, j) in [(face[0], face[2]), (face[1], face[3])] {
                    if let Some(edge) = edges.find(cell[i], cell[j]).filter(|&edge| from[edge] == From::Edge) {
                        from[edge] = From::Face(number, local);
                    }
                }
            }
            let through: &[[usize; 2]] =
                if kind.linear() == CellKind::Hex8 { &[[0, 6], [1, 7], [2, 4], [3, 5]] } else { &[] };
            for &[i, j] in through {
                if let Some(edge) = edges.find(cell[i], cell[j]) {
                    from[edge] = From::Cell(number);
                }
            }
        }
        let (mut next, mut new) = (mesh.nodes.len() as u32, Vec::new());
        for ((ends, middle), from) in edges.iter().zip(&mut of_edge).zip(from) {
            if *middle == NONE {
                *middle = next;
                next += 1;
                new.push((ends, from));
            }
        }
        Middles { edges, of_edge, new }
    }

    /// The ten nodes of a tetrahedron.
    fn cell(&self, corners: [u32; 4]) -> [u32; 10] {
        let middle =
            |[i, j]: [usize; 2]| self.edges.find(corners[i], corners[j]).map_or(NONE, |edge| self.of_edge[edge]);
        std::array::from_fn(|i| if i < 4 { corners[i] } else { middle(TET_EDGES[i - 4]) })
    }
}
