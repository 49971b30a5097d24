//! A bolt that is tightened: a cut across which the displacement jumps along an axis.
//!
//! A slice of thickness `s` is taken out of the body and the sides of the cut are joined again (a Volterra dislocation).
//! Cells beyond the cut then see `u - s axis` at its nodes, which leaves the stiffness as it is: the jump acts like
//! thermal strain, by forces and an energy of its own. Any cut through the whole section gives the same state.
//! No node is doubled, so the cut need not follow the mesh. Fields at the nodes of the cut are those of the side the axis
//! comes from.

use super::Solid;
use super::elastic::Voigt;
use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, Wedge6, Wedge15, folded};
use super::recovery::{mean_gradient, strain_of};
use crate::Error;
use crate::mesh::CellKind;
use crate::mesh::geometry::corners;
use crate::mesh::v3::{V3, dot};

/// A cut by what a unit of shortening does; the body stores `1/2 u'Ku - s force'u + 1/2 s² stiffness`.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// Unit vector into the part that is drawn back.
    pub axis: [f64; 3],
    /// Cells of that part at the cut, ascending.
    pub cells: Vec<u32>,
    /// Nodes of the cut, ascending.
    pub nodes: Vec<u32>,
    /// Forces on the body for each unit of shortening by degree of freedom, ascending, newton per length; they have no
    /// resultant.
    pub force: Vec<(u32, f64)>,
    /// Force through the cut for each unit of shortening while no node moves, newton per length, > 0.
    pub stiffness: f64,
    /// Mean strain of each of `cells` for each unit of shortening, 1/length.
    pub strain: Vec<Voigt>,
}

/// The cut at `nodes` (ascending) with `cells` beyond it; `axis` points from the cut into them.
///
/// # Errors
/// A cell that is folded.
pub fn cut(solid: &Solid, mut cells: Vec<u32>, nodes: Vec<u32>, axis: [f64; 3]) -> Result<Cut, Error> {
    cells.sort_unstable();
    let list = solid.cells();
    let laws: Vec<Law> = solid.materials.iter().map(Law::new).collect();
    let mut forces: Vec<(u32, f64)> = Vec::new();
    let (mut stiffness, mut strain) = (0.0, Vec::with_capacity(cells.len()));
    for &cell in &cells {
        let (kind, of_cell) = list.get(cell as usize);
        let law = laws[solid.material_of_cell[cell as usize] as usize];
        let jump: Vec<V3> =
            of_cell.iter().map(|node| if nodes.binary_search(node).is_ok() { axis } else { [0.0; 3] }).collect();
        let x = &solid.mesh.nodes;
        let answer = match kind {
            CellKind::Tet4 => Tet4::new(&corners(x, of_cell)).map(|e| response(&e, law, &jump)),
            CellKind::Hex8 => Hex8::new(&corners(x, of_cell)).map(|e| response(&e, law, &jump)),
            CellKind::Tet10 => Tet10::new(&corners(x, of_cell)).map(|e| response(&e, law, &jump)),
            CellKind::Hex20 => Hex20::new(&corners(x, of_cell)).map(|e| response(&e, law, &jump)),
            CellKind::Wedge6 => Wedge6::new(&corners(x, of_cell)).map(|e| response(&e, law, &jump)),
            CellKind::Wedge15 => Wedge15::new(&corners(x, of_cell)).map(|e| response(&e, law, &jump)),
        };
        let (force, mean) = answer.ok_or_else(|| folded(solid, cell as usize, kind, of_cell))?;
        for ((&node, force), jump) in of_cell.iter().zip(force).zip(&jump) {
            stiffness += dot(force, *jump);
            forces.extend((0..3).map(|c| (3 * node + c as u32, force[c])));
        }
        strain.push(mean);
    }
    forces.sort_by_key(|entry| entry.0);
    let mut force: Vec<(u32, f64)> = Vec::new();
    for (dof, value) in forces {
        match force.last_mut() {
            Some(last) if last.0 == dof => last.1 += value,
            _ => force.push((dof, value)),
        }
    }
    Ok(Cut { axis, cells, nodes, force, stiffness, strain })
}

/// Nodal forces and mean strain of a cell whose nodes are displaced by `jump`.
fn response<const N: usize, const Q: usize>(element: &Element<N, Q>, law: Law, jump: &[V3]) -> (Vec<V3>, Voigt) {
    let force = |i: usize| {
        let row = element.row(i, law);
        let along = |a: usize| row.iter().zip(jump).map(|(block, u)| dot(block[a], *u)).sum();
        [along(0), along(1), along(2)]
    };
    let numbers: Vec<u32> = (0..N as u32).collect();
    ((0..N).map(force).collect(), strain_of(&mean_gradient(element, &numbers, |i| jump[i as usize])))
}
