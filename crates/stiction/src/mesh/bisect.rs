//! Tetrahedra bisected where they are marked, and around these until all meet face to face again.
//!
//! Arnold, Mukherjee and Pouly, "Locally adapted tetrahedral meshes using bisection", SIAM J. Sci. Comput. 22 (2000) 431.
//! Every face has a marked edge, the same for both of its cells, and every cell an edge that is marked in both of its
//! faces: there it is cut. What a face becomes depends on its own mark only, so the mesh can always be closed, the result
//! does not depend on the order in which cells are taken, and each cell has finitely many shapes of descendants. On cubes
//! cut by Kuhn's rule these are the cells of Maubach (SIAM J. Sci. Comput. 16 (1995) 210).
//!
//! Cells of ten nodes are cut at the nodes in the middle of their edges, and the new middles are points of the map of the
//! parent, so that curved faces stay the surfaces they are.

use super::inherit::{Children, Edges, Labels, NONE, OPPOSITE, Rows, edges_between, longer};
use super::v3::{V3, add, scale, sub};
use super::{Bounds, CellKind, Group, Mesh, ascending};
use crate::Error;

/// A mesh of tetrahedra that can be refined by bisection.
#[derive(Debug, Clone, PartialEq)]
pub struct Bisection {
    /// All cells are linear, or all quadratic, in one list. Nodes 0 and 1 of a cell are the ends of the edge where it will be
    /// cut.
    pub mesh: Mesh,
    /// The marks of each cell.
    pub(super) marks: Vec<Marks>,
}

/// A mesh made of the cells of another.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The mesh: the old nodes with their numbers, then the new ones. Children follow in the order of their parents.
    pub next: Bisection,
    /// The cell of the old mesh that each cell is a part of.
    pub parent: Vec<u32>,
    pub(super) rows: Rows,
}

impl Refined {
    /// A field of the old mesh, three values a node, at the nodes of the new one: at new nodes by the functions of the old
    /// cells. The field stays the same where the new cells are parts of the old; of hexahedra the tetrahedra made of them
    /// cannot express all.
    ///
    /// # Errors
    /// If the field has not three values for each node of the old mesh.
    pub fn carry(&self, field: &[f64]) -> Result<Vec<f64>, Error> {
        if field.len() != 3 * self.rows.first() {
            let what = format!("{} values for {} nodes of the old mesh", field.len(), self.rows.first());
            return Err(Error::new("field to carry on", what, "give three values for each node"));
        }
        let mut values = field.to_vec();
        self.rows.extend(&mut values, 3);
        Ok(values)
    }
}

/// The marked edges of the faces opposite to corners 0 and 1; those of the other two faces are the edge from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Marks {
    /// 2 or 3: from the other one of corners 0 and 1 to that corner; 0: between corners 2 and 3.
    of: [u8; 2],
    /// Whether a cell whose marked edges lie in one plane was made of such a cell.
    flag: bool,
}

impl Marks {
    /// All marked edges are edges of one face.
    fn is_planar(self) -> bool {
        self.of[0] == self.of[1] && self.of[0] != 0
    }
}

/// Orders of the corners of a tetrahedron that keep it positive, with each edge in front, in the order of [`EDGES`].
const FRONT: [[usize; 4]; 6] = [[0, 1, 2, 3], [1, 2, 0, 3], [2, 0, 1, 3], [0, 3, 1, 2], [1, 3, 2, 0], [2, 3, 0, 1]];

const EDGES: [[usize; 2]; 6] = super::shape::TET_EDGES;

/// Which of [`EDGES`] joins two corners.
const JOINS: [[usize; 4]; 4] = [[6, 0, 2, 3], [0, 6, 1, 4], [2, 1, 6, 5], [3, 4, 5, 6]];

/// The marks by the longest edges, and the order of corners that brings the longest edge to the front.
pub(super) fn initial(nodes: &[V3], unit: f64, corners: [u32; 4]) -> ([usize; 4], Marks) {
    let length = |i: usize, j: usize| longer(nodes, unit, [corners[i], corners[j]]);
    let [i, j] = EDGES.into_iter().max_by_key(|&[i, j]| length(i, j)).unwrap_or_default();
    let order = FRONT[JOINS[i][j]];
    let of = [0, 1].map(|k| {
        let edges = [(order[1 - k], order[2], 2), (order[1 - k], order[3], 3), (order[2], order[3], 0)];
        edges.into_iter().max_by_key(|&(i, j, _)| length(i, j)).map_or(0, |(_, _, code)| code)
    });
    (order, Marks { of, flag: false })
}

/// The ten nodes, or whatever belongs to them, in another order of the corners.
pub(super) fn reordered(nodes: [u32; 10], order: [usize; 4]) -> [u32; 10] {
    std::array::from_fn(|i| match i {
        0..4 => nodes[order[i]],
        _ => nodes[4 + JOINS[order[EDGES[i - 4][0]]][order[EDGES[i - 4][1]]]],
    })
}

/// The square of the length that lengths of edges are compared by.
pub(super) fn unit(mesh: &Mesh) -> f64 {
    Bounds::around(mesh.nodes.iter().copied()).diagonal().powi(2)
}

/// Bisects each of the cells `marked` and its children `times` times in all, and others until the mesh conforms.
///
/// Groups and arrays are inherited. A new node belongs to a group of nodes if all nodes of the edge or face it lies on do.
///
/// # Errors
/// If `marked` names a cell that is not there, or the cells of the result could not be used: a curved cell that is folded
/// between the points where it was checked, or more nodes than can be numbered.
pub fn refine(from: &Bisection, marked: &[u32], times: u32) -> Result<Refined, Error> {
    if let Some(cell) = marked.iter().find(|&&cell| cell as usize >= from.marks.len()) {
        let what = format!("cell {cell} is marked, of {}", from.marks.len());
        return Err(Error::new("refinement", what, "mark cells by their numbers in this mesh"));
    }
    let faces = Labels::new(&from.mesh);
    let mut work = Work::new(from, &faces);
    for cell in ascending(marked.iter().copied()) {
        work.bisect(cell as usize, times);
    }
    work.close();
    work.finish(from, &faces).map_err(|error| error.at("refinement"))
}

/// A tetrahedron while it is cut.
#[derive(Debug, Clone, Copy)]
struct Tet {
    nodes: [u32; 10],
    /// Of the faces opposite to the corners.
    labels: [u32; 4],
    marks: Marks,
    parent: u32,
}

impl Tet {
    fn reordered(self, order: [usize; 4], marks: Marks) -> Tet {
        Tet { nodes: reordered(self.nodes, order), labels: order.map(|i| self.labels[i]), marks, ..self }
    }
}

/// A new edge from a node that halves another.
struct Spoke {
    to: u32,
    middle: u32,
    /// The next one from the same node, or [`NONE`].
    next: u32,
}

/// The cells as they are cut. Linear cells are given middles of their edges as well, which become nodes where they are cut.
struct Work {
    tets: Vec<Tet>,
    nodes: Vec<V3>,
    /// Where the nodes after the first come from: `[a, b]` in the middle of a straight edge; `[a, z, b]` between `a` and the
    /// middle `z` of the edge to `b`; `[a, b, c, ab, bc, ca]` between `c` and the middle of `ab`.
    origin: Vec<[u32; 6]>,
    first: usize,
    is_corner: Vec<bool>,
    /// The first spoke of each node.
    head: Vec<u32>,
    spokes: Vec<Spoke>,
}

impl Work {
    fn new(from: &Bisection, faces: &Labels) -> Work {
        let mesh = &from.mesh;
        let mut nodes = mesh.nodes.clone();
        let mut origin = Vec::new();
        let mut tets = Vec::with_capacity(mesh.cell_count());
        let first = mesh.nodes.len();
        let linear = mesh.cells[0].kind == CellKind::Tet4;
        let edges = Edges::new(first, if linear { mesh.cells[0].nodes.as_chunks().0 } else { &[] });
        nodes.extend(edges.iter().map(|[a, b]| middle(mesh.nodes[a as usize], mesh.nodes[b as usize])));
        origin.extend(edges.iter().map(|[a, b]| [a, b, NONE, NONE, NONE, NONE]));
        let mut is_corner = vec![false; nodes.len()];
        for (parent, ((_, cell), &marks)) in (0..).zip(mesh.cell_iter().zip(&from.marks)) {
            let middle = |[i, j]: [usize; 2]| edges.find(cell[i], cell[j]).map_or(NONE, |edge| (first + edge) as u32);
            let nodes = std::array::from_fn(|i| cell.get(i).copied().unwrap_or_else(|| middle(EDGES[i - 4])));
            nodes[..4].iter().for_each(|&node| is_corner[node as usize] = true);
            let labels = OPPOSITE.map(|local| faces.of_cell[parent as usize][local]);
            tets.push(Tet { nodes, labels, marks, parent });
        }
        Work { tets, head: vec![NONE; nodes.len()], nodes, origin, first, is_corner, spokes: Vec::new() }
    }

    /// Cuts a cell, whose number one child keeps, and the children until `times` is used up.
    fn bisect(&mut self, cell: usize, times: u32) {
        if times == 0 {
            return;
        }
        let parent = self.tets[cell];
        let [a, b, c, d, z, bc, ca, ad, bd, cd] = parent.nodes;
        self.is_corner[z as usize] = true;
        let az = self.spoke(a, [a, z, b, NONE, NONE, NONE], z);
        let bz = self.spoke(b, [b, z, a, NONE, NONE, NONE], z);
        let cz = self.spoke(c, [a, b, c, z, bc, ca], z);
        let dz = self.spoke(d, [a, b, d, z, bd, ad], z);
        let flagged = parent.marks.is_planar() && parent.marks.flag;
        let flag = parent.marks.is_planar() && !parent.marks.flag;
        let [of_a, of_b, of_c, of_d] = parent.labels;
        // The faces that were cut are marked opposite to the new node, and so is the face between the children unless the
        // parent was flagged; then it is marked from the new node to where the children will be cut.
        let low = Tet { nodes: [a, z, c, d, az, cz, ca, ad, dz, cd], labels: [NONE, of_b, of_c, of_d], ..parent };
        let (order, of) = match parent.marks.of[1] {
            2 => ([0, 2, 3, 1], [if flagged { 3 } else { 2 }, 2]),
            3 => ([0, 3, 1, 2], [if flagged { 2 } else { 3 }, 3]),
            _ => ([2, 3, 0, 1], [2, 2]),
        };
        self.tets[cell] = low.reordered(order, Marks { of, flag });
        let high = Tet { nodes: [z, b, c, d, bz, bc, cz, dz, bd, cd], labels: [of_a, NONE, of_c, of_d], ..parent };
        let (order, of) = match parent.marks.of[0] {
            2 => ([1, 2, 0, 3], [if flagged { 2 } else { 3 }, 3]),
            3 => ([1, 3, 2, 0], [if flagged { 3 } else { 2 }, 2]),
            _ => ([2, 3, 0, 1], [3, 3]),
        };
        let other = self.tets.len();
        self.tets.push(high.reordered(order, Marks { of, flag }));
        self.bisect(cell, times - 1);
        self.bisect(other, times - 1);
    }

    /// The middle of the new edge between `to` and `z`.
    fn spoke(&mut self, to: u32, origin: [u32; 6], z: u32) -> u32 {
        let mut place = self.head[z as usize];
        while place != NONE {
            let spoke = &self.spokes[place as usize];
            if spoke.to == to {
                return spoke.middle;
            }
            place = spoke.next;
        }
        let node = self.nodes.len() as u32;
        let at = |i: u32| self.nodes[i as usize];
        // By how much the middle of an edge lies off its chord.
        let off = |a: u32, m: u32, b: u32| sub(at(m), middle(at(a), at(b)));
        let curve = match origin {
            [a, z, b, NONE, ..] => scale(0.25, off(a, z, b)),
            [a, b, c, ab, bc, ca] => sub(scale(0.5, add(off(b, bc, c), off(c, ca, a))), scale(0.25, off(a, ab, b))),
        };
        self.nodes.push(add(middle(at(to), at(z)), curve));
        self.origin.push(origin);
        self.is_corner.push(false);
        self.spokes.push(Spoke { to, middle: node, next: self.head[z as usize] });
        self.head[z as usize] = (self.spokes.len() - 1) as u32;
        self.head.push(NONE);
        node
    }

    /// Cuts every cell with a node inside an edge, until there is none.
    fn close(&mut self) {
        let mut again = true;
        while again {
            again = false;
            let mut cell = 0;
            while cell < self.tets.len() {
                while self.tets[cell].nodes[4..].iter().any(|&middle| self.is_corner[middle as usize]) {
                    self.bisect(cell, 1);
                    again = true;
                }
                cell += 1;
            }
        }
    }

    fn finish(mut self, from: &Bisection, faces: &Labels) -> Result<Refined, Error> {
        let mesh = &from.mesh;
        let kind = mesh.cells[0].kind;
        self.tets.sort_by_key(|tet| tet.parent);
        // Linear cells keep those of their middles that have become corners.
        let is_kept = |node: usize| kind == CellKind::Tet10 || self.is_corner[node];
        let kept: Vec<usize> = (0..self.nodes.len()).filter(|&node| is_kept(node)).collect();
        let mut number = vec![NONE; self.nodes.len()];
        (0..).zip(&kept).for_each(|(new, &node)| number[node] = new);
        let mut rows = Rows::new(self.first);
        for &node in &kept[self.first..] {
            let row = |weights: &[(u32, f32)]| {
                weights.iter().map(|&(node, w)| (number[node as usize], w)).collect::<Vec<_>>()
            };
            rows.push(match (kind, self.origin[node - self.first]) {
                (_, [a, b, NONE, ..]) | (CellKind::Tet4, [a, b, _, NONE, ..] | [_, _, a, b, ..]) => {
                    row(&[(a, 0.5), (b, 0.5)])
                }
                (_, [a, z, b, NONE, ..]) => row(&[(a, 0.375), (z, 0.75), (b, -0.125)]),
                (_, [a, b, _, ab, bc, ca]) => row(&[(a, -0.125), (b, -0.125), (ab, 0.25), (bc, 0.5), (ca, 0.5)]),
            });
        }
        let named = |group: &Group| {
            let unit = unit(mesh);
            let mut is_in = vec![false; if group.nodes.is_empty() { 0 } else { self.nodes.len() }];
            if group.nodes.is_empty() {
                return Vec::new();
            }
            group.nodes.iter().for_each(|&node| is_in[node as usize] = true);
            let edges = if kind == CellKind::Tet4 { edges_between(mesh, &group.nodes, unit) } else { Vec::new() };
            for (node, origin) in (self.first..).zip(&self.origin) {
                is_in[node] = match *origin {
                    [a, b, NONE, ..] => edges.binary_search(&[a, b]).is_ok(),
                    _ => origin.iter().all(|&other| other == NONE || is_in[other as usize]),
                };
            }
            (self.first..self.nodes.len())
                .filter(|&node| is_in[node] && number[node] != NONE)
                .map(|node| number[node])
                .collect()
        };
        let nodes_of = |tet: &Tet| tet.nodes.map(|node| number[node as usize]);
        let children = Children {
            old: mesh,
            nodes: kept.iter().map(|&node| self.nodes[node]).collect(),
            kind,
            cells: self.tets.iter().flat_map(|tet| nodes_of(tet).into_iter().take(kind.nodes())).collect(),
            parent: &self.tets.iter().map(|tet| tet.parent).collect::<Vec<u32>>(),
            labels: self.tets.iter().map(|tet| tet.labels).collect(),
            rows: &rows,
        };
        let parent = children.parent.to_vec();
        let mesh = children.mesh(faces, named)?;
        let marks = self.tets.iter().map(|tet| tet.marks).collect();
        Ok(Refined { next: Bisection { mesh, marks }, parent, rows })
    }
}

/// Half of the sum, in an order that does not depend on which end is which.
fn middle(a: V3, b: V3) -> V3 {
    scale(0.5, add(a, b))
}
