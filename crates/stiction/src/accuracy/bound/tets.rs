//! Straight tetrahedra, their faces, and the forces and stresses of displacements on them.

use std::array::from_fn;

use rayon::prelude::*;

use super::{Acting, NoBound};
use crate::fem::elements::Law;
use crate::fem::{Solid, Voigt};
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};
use crate::mesh::{CellKind, Mesh, ascending};

/// Corners of the edges of a tetrahedron.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// Places of the components of a symmetric tensor.
pub(super) const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
/// Middles of edges farther than this part of the edge from where they belong make a cell curved.
const CURVED: f64 = 1e-8;
/// Cells for each task of a thread at least.
pub(super) const CELLS_PER_TASK: usize = 256;
/// In the place of the second cell of a boundary face.
pub(super) const NONE: u32 = u32::MAX;

/// Tetrahedra with their corners in ascending order, so that cells on both sides of a face see its corners in one order.
/// Face `j` of a cell is the one opposite its corner `j`.
pub(super) struct Tets<'a> {
    pub solid: Solid<'a>,
    pub corners: Vec<[u32; 4]>,
    /// The nodes in the middles of [`EDGES`]; empty for linear cells.
    pub middles: Vec<[u32; 6]>,
    pub faces_of: Vec<[u32; 4]>,
    /// Corners of each face, ascending.
    pub faces: Vec<[u32; 3]>,
    /// The cells of each face; the normal of the face points out of the first.
    pub cells_of: Vec<[u32; 2]>,
    /// For each boundary face of the mesh its number here.
    pub of_boundary: Vec<u32>,
}

/// A tetrahedron's size and place.
pub(super) struct Shape {
    pub x: [V3; 4],
    /// Gradients of the functions that are one at a corner, 1/length.
    pub gradient: [V3; 4],
    pub volume: f64,
    /// Whether the corners turn the way positive volumes do.
    pub positive: bool,
}

impl<'a> Tets<'a> {
    pub(super) fn new(solid: &Solid<'a>) -> Result<Self, NoBound> {
        let mesh = solid.mesh;
        let mut tets = Tets {
            solid: *solid,
            corners: Vec::with_capacity(mesh.cell_count()),
            middles: Vec::new(),
            faces_of: Vec::new(),
            faces: Vec::new(),
            cells_of: Vec::new(),
            of_boundary: Vec::new(),
        };
        for (kind, nodes) in mesh.cell_iter() {
            let mut order = [0, 1, 2, 3];
            order.sort_unstable_by_key(|&i| nodes[i]);
            match kind {
                CellKind::Hex8 | CellKind::Hex20 | CellKind::Wedge6 | CellKind::Wedge15 => {
                    return Err(NoBound::Hexahedra);
                }
                CellKind::Tet4 => {}
                CellKind::Tet10 => tets.middles.push(middles(mesh, nodes, order)?),
            }
            tets.corners.push(order.map(|i| nodes[i]));
        }
        if !tets.middles.is_empty() && tets.middles.len() < tets.corners.len() {
            return Err(NoBound::MixedOrders);
        }
        tets.number_faces();
        let of_boundary = mesh.faces.par_iter().with_min_len(1024).map(|face| {
            let corners = face.corners();
            let opposite = tets.corners[face.cell as usize].iter().position(|corner| !corners.contains(corner));
            tets.faces_of[face.cell as usize][opposite.unwrap_or(0)]
        });
        tets.of_boundary = of_boundary.collect();
        Ok(tets)
    }

    fn number_faces(&mut self) {
        let cells = self.corners.len();
        let of_cell = |cell: usize| {
            let corners = self.corners[cell];
            (0..4).map(move |j| {
                let [a, b, c] = without(&corners, j);
                ([a, b, c], 4 * cell as u64 + j as u64)
            })
        };
        let mut sides: Vec<([u32; 3], u64)> = (0..cells).into_par_iter().flat_map_iter(of_cell).collect();
        sides.par_sort_unstable();
        self.faces_of = vec![[NONE; 4]; cells];
        for (corners, side) in sides {
            let (cell, j) = ((side / 4) as usize, (side % 4) as usize);
            if self.faces.last() == Some(&corners) {
                self.cells_of.last_mut().iter_mut().for_each(|cells| cells[1] = cell as u32);
            } else {
                self.faces.push(corners);
                self.cells_of.push([cell as u32, NONE]);
            }
            self.faces_of[cell][j] = self.faces.len() as u32 - 1;
        }
    }

    pub(super) fn quadratic(&self) -> bool {
        !self.middles.is_empty()
    }

    pub(super) fn mesh(&self) -> &'a Mesh {
        self.solid.mesh
    }

    pub(super) fn law(&self, cell: usize) -> Law<'a> {
        Law::new(&self.solid.materials[self.solid.material_of_cell[cell] as usize])
    }

    /// One if the normal of the face points out of the cell, minus one if it points into it.
    #[inline]
    pub(super) fn sign(&self, cell: usize, face: u32) -> f64 {
        if self.cells_of[face as usize][0] == cell as u32 { 1.0 } else { -1.0 }
    }

    pub(super) fn shape(&self, cell: usize) -> Shape {
        let x = self.corners[cell].map(|node| self.mesh().nodes[node as usize]);
        let [a, b, c] = [1, 2, 3].map(|i| sub(x[i], x[0]));
        let normals = [cross(b, c), cross(c, a), cross(a, b)];
        let det = dot(a, normals[0]);
        let [g1, g2, g3] = normals.map(|n| scale(1.0 / det, n));
        let g0 = scale(-1.0, add(add(g1, g2), g3));
        Shape { x, gradient: [g0, g1, g2, g3], volume: det.abs() / 6.0, positive: det > 0.0 }
    }

    /// Stress of a cell at its corners, between which it is linear.
    pub(super) fn stress(&self, cell: usize, shape: &Shape, u: &[f64], initial: &[Voigt]) -> [Voigt; 4] {
        let law = self.law(cell);
        let at = |node: u32| -> V3 { from_fn(|c| u[3 * node as usize + c]) };
        let corners = self.corners[cell].map(at);
        // From one corner, and from the straight edges: rigid motions and linear displacements keep their digits.
        let from = corners[0];
        let mut linear = [[0.0; 3]; 3];
        (1..4).for_each(|i| add_outer(&mut linear, 1.0, sub(corners[i], from), shape.gradient[i]));
        let free = initial.get(cell).copied().unwrap_or([0.0; 6]);
        let stress = |h: &[V3; 3]| {
            let e = [h[0][0], h[1][1], h[2][2], h[0][1] + h[1][0], h[1][2] + h[2][1], h[0][2] + h[2][0]];
            law.stress(&from_fn(|k| e[k] - free[k]))
        };
        let Some(middles) = self.middles.get(cell) else { return [stress(&linear); 4] };
        let mut at_corner = [linear; 4];
        for ([a, b], &middle) in EDGES.into_iter().zip(middles) {
            let bulge = sub(at(middle), scale(0.5, add(corners[a], corners[b])));
            add_outer(&mut at_corner[a], 4.0, bulge, shape.gradient[b]);
            add_outer(&mut at_corner[b], 4.0, bulge, shape.gradient[a]);
        }
        at_corner.map(|h| stress(&h))
    }

    /// Adds the nodal forces `∫ σ ∇N` of a stress that is linear between its values at the corners of a cell.
    fn add_inner(&self, cell: usize, shape: &Shape, stress: &[Voigt; 4], forces: &mut [f64]) {
        let v = shape.volume;
        let total: Voigt = from_fn(|k| stress.iter().map(|s| s[k]).sum());
        let mut to = |node: u32, factor: f64, s: &Voigt, g: V3| {
            let force = traction(s, g);
            (0..3).for_each(|c| forces[3 * node as usize + c] += factor * force[c]);
        };
        for (i, &node) in self.corners[cell].iter().enumerate() {
            if !self.quadratic() {
                to(node, 0.25 * v, &total, shape.gradient[i]);
                continue;
            }
            let s = from_fn(|k| 0.2 * stress[i][k] - 0.05 * total[k]);
            to(node, v, &s, shape.gradient[i]);
        }
        let Some(middles) = self.middles.get(cell) else { return };
        for ([a, b], &middle) in EDGES.into_iter().zip(middles) {
            for (i, other) in [(a, b), (b, a)] {
                to(middle, 0.2 * v, &from_fn(|k| total[k] + stress[i][k]), shape.gradient[other]);
            }
        }
    }

    /// Inner forces of all nodes, newton.
    pub(super) fn inner_forces(&self, u: &[f64], initial: &[Voigt]) -> Vec<f64> {
        let mut forces = vec![0.0; u.len()];
        let stress = |cell: usize| {
            let shape = self.shape(cell);
            let stress = self.stress(cell, &shape, u, initial);
            (shape, stress)
        };
        let chunk = 64 * CELLS_PER_TASK;
        for first in (0..self.corners.len()).step_by(chunk) {
            let end = self.corners.len().min(first + chunk);
            let parts: Vec<_> = (first..end).into_par_iter().with_min_len(CELLS_PER_TASK).map(stress).collect();
            for (cell, (shape, stress)) in (first..end).zip(&parts) {
                self.add_inner(cell, shape, stress, &mut forces);
            }
        }
        forces
    }

    /// Adds the nodal forces of a traction that is linear on a face; `forces_at` is traction times area at its corners.
    pub(super) fn add_traction(&self, face: u32, forces_at: &[V3; 3], forces: &mut [f64]) {
        let corners = self.faces[face as usize];
        let total = forces_at.iter().fold([0.0; 3], |sum, &f| add(sum, f));
        let mut to = |node: u32, force: V3| (0..3).for_each(|c| forces[3 * node as usize + c] += force[c]);
        for i in 0..3 {
            if !self.quadratic() {
                to(corners[i], scale(1.0 / 12.0, add(total, forces_at[i])));
                continue;
            }
            to(corners[i], scale(1.0 / 60.0, sub(scale(3.0, forces_at[i]), total)));
        }
        if !self.quadratic() {
            return;
        }
        for (i, middle) in self.middles_of(face).into_iter().enumerate() {
            to(middle, scale(1.0 / 15.0, sub(scale(2.0, total), forces_at[i])));
        }
    }

    /// The nodes in the middles of the edges of a face of quadratic cells; the one opposite corner `i` is in place `i`.
    pub(super) fn middles_of(&self, face: u32) -> [u32; 3] {
        let cell = self.cells_of[face as usize][0] as usize;
        let local =
            self.faces[face as usize].map(|node| self.corners[cell].iter().position(|&c| c == node).unwrap_or(0));
        let middle = |a: usize, b: usize| {
            let edge = EDGES.iter().position(|edge| *edge == [local[a], local[b]]);
            self.middles[cell][edge.unwrap_or(0)]
        };
        [middle(1, 2), middle(0, 2), middle(0, 1)]
    }

    /// Adds the nodal forces of a constant force per volume in a cell.
    fn add_body_force(&self, cell: usize, density: V3, forces: &mut [f64]) {
        let volume = self.shape(cell).volume;
        let corner = if self.quadratic() { -0.05 } else { 0.25 };
        let middles = self.middles.get(cell).into_iter().flatten().map(|&node| (node, 0.2));
        for (node, part) in self.corners[cell].into_iter().map(|node| (node, corner)).chain(middles) {
            (0..3).for_each(|c| forces[3 * node as usize + c] += part * volume * density[c]);
        }
    }

    /// Values at the corners of a boundary face of the mesh, by ascending numbers of the corners.
    pub(super) fn in_order(&self, face: u32, at_corners: [V3; 3]) -> [V3; 3] {
        let corners = self.mesh().faces[face as usize].corners();
        self.faces[self.of_boundary[face as usize] as usize]
            .map(|node| at_corners[corners.iter().position(|&corner| corner == node).unwrap_or(0)])
    }

    /// Nodal forces of the loads and body forces, newton.
    pub(super) fn outer_forces(&self, acting: &Acting) -> Vec<f64> {
        let mut forces = vec![0.0; 3 * self.mesh().nodes.len()];
        for (face, at_corners) in acting.loads {
            let own = self.of_boundary[*face as usize];
            let area = self.area(own);
            self.add_traction(own, &self.in_order(*face, *at_corners).map(|t| scale(area, t)), &mut forces);
        }
        for (cell, &density) in acting.body_force.iter().enumerate().filter(|(_, f)| **f != [0.0; 3]) {
            self.add_body_force(cell, density, &mut forces);
        }
        forces
    }

    /// Normal of a face as long as its area, out of its first cell.
    pub(super) fn vector_area(&self, face: u32) -> V3 {
        let [a, b, c] = self.faces[face as usize].map(|node| self.mesh().nodes[node as usize]);
        let cell = self.cells_of[face as usize][0] as usize;
        let opposite = self.corners[cell].iter().find(|node| !self.faces[face as usize].contains(node));
        let inside = sub(self.mesh().nodes[*opposite.unwrap_or(&0) as usize], a);
        let area = scale(0.5, cross(sub(b, a), sub(c, a)));
        if dot(area, inside) > 0.0 { scale(-1.0, area) } else { area }
    }

    pub(super) fn area(&self, face: u32) -> f64 {
        norm(self.vector_area(face))
    }

    /// The nodes of some faces, ascending.
    pub(super) fn corners_of(&self, faces: impl Iterator<Item = u32>) -> Vec<u32> {
        ascending(faces.flat_map(|face| self.faces[face as usize]))
    }
}

/// The nodes in the middles of the edges of a cell whose corners stand in the order `order`.
fn middles(mesh: &Mesh, nodes: &[u32], order: [usize; 4]) -> Result<[u32; 6], NoBound> {
    let mut middles = [0; 6];
    for (middle, [a, b]) in middles.iter_mut().zip(EDGES) {
        let ends = [order[a], order[b]];
        let edges = CellKind::Tet10.edges();
        let edge = edges.iter().position(|&[p, q]| [p, q] == ends || [q, p] == ends).unwrap_or(0);
        *middle = nodes[4 + edge];
        let [p, q] = ends.map(|i| mesh.nodes[nodes[i] as usize]);
        let off = norm(sub(mesh.nodes[*middle as usize], scale(0.5, add(p, q))));
        if off > CURVED * norm(sub(q, p)) {
            return Err(NoBound::CurvedCells);
        }
    }
    Ok(middles)
}

/// The corners other than number `j`.
#[inline]
pub(super) fn without(corners: &[u32; 4], j: usize) -> [u32; 3] {
    from_fn(|i| corners[i + usize::from(i >= j)])
}

/// `h += factor a ⊗ b`.
fn add_outer(h: &mut [V3; 3], factor: f64, a: V3, b: V3) {
    for i in 0..3 {
        (0..3).for_each(|j| h[i][j] += factor * a[i] * b[j]);
    }
}

/// `σ n`.
#[inline]
pub(super) fn traction(s: &Voigt, n: V3) -> V3 {
    from_fn(|a| (0..3).map(|b| s[PLACE[a][b]] * n[b]).sum())
}
