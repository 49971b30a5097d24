use rayon::prelude::*;

use super::Solid;
use super::elements::{MOST_NODES, folded, volume_points};
use super::incidence::Incidence;
use crate::Error;
use crate::linalg::Csr;
use crate::mesh::CellKind;

/// The consistent mass matrix `M_ij = ∫ density N_i N_j` over the nodes `i` and `j`, mass, symmetric to the bit. It is the
/// same for each component of the displacement, along any axes; nodes that share a cell have an entry each, zero or not.
///
/// By the quadrature of gravity: exact on straight tetrahedra and parallelepipeds; the sum of all entries is the mass of
/// the cells by the volume that loads see.
///
/// # Errors
/// If materials or cells cannot be used, a cell is folded, or no material has a density.
pub fn mass(solid: &Solid) -> Result<Csr, Error> {
    solid.validate()?;
    let density = |cell: usize| solid.materials[solid.material_of_cell[cell] as usize].density;
    let cells = solid.cells();
    if !(0..solid.mesh.cell_count()).any(|cell| density(cell) > 0.0) {
        let remedy = "give `density`, mass per volume, to a material";
        return Err(Error::new("materials", "no cell has a mass", remedy));
    }
    let incidence = Incidence::new(solid.mesh)?;
    // The mass at each point of a quadrature, cell by cell.
    let weights = |cell: usize| -> Result<Vec<f64>, Error> {
        let (kind, nodes) = cells.get(cell);
        let points = volume_points(kind, solid.mesh, nodes).ok_or_else(|| folded(solid, cell, kind, nodes))?;
        Ok(points.iter().map(|point| density(cell) * point.weight).collect())
    };
    let weights: Vec<Vec<f64>> =
        (0..solid.mesh.cell_count()).into_par_iter().map(weights).collect::<Result<_, Error>>()?;
    let shapes = shapes(solid)?;
    let row = |i: usize| -> Vec<(u32, f64)> {
        let mut row: Vec<(u32, f64)> = Vec::new();
        for &cell in incidence.at(i) {
            let (kind, nodes) = cells.get(cell as usize);
            let (_, shapes) = shapes.iter().find(|(of, _)| *of == kind).expect("shapes of each kind");
            let own = nodes.iter().position(|&node| node as usize == i).expect("a cell at the node");
            for (k, &other) in nodes.iter().enumerate() {
                let product = |(w, shape): (&f64, &[f64; MOST_NODES])| w * (shape[own] * shape[k]);
                row.push((other, weights[cell as usize].iter().zip(shapes).map(product).sum()));
            }
        }
        // Cells are added in their order, which both triangles have in common.
        row.sort_by_key(|entry| entry.0);
        row.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        row
    };
    let n = solid.mesh.nodes.len();
    let rows: Vec<Vec<(u32, f64)>> = (0..n).into_par_iter().map(row).collect();
    let mut mass = Csr::zero(n, n);
    for (i, row) in rows.into_iter().enumerate() {
        mass.column.extend(row.iter().map(|entry| entry.0));
        mass.value.extend(row.iter().map(|entry| entry.1));
        mass.start[i + 1] = mass.column.len();
    }
    Ok(mass)
}

/// Shape functions at the points of the quadrature, which are the same for all cells of a kind.
type Shapes = Vec<(CellKind, Vec<[f64; MOST_NODES]>)>;

fn shapes(solid: &Solid) -> Result<Shapes, Error> {
    let mut shapes = Shapes::new();
    for (cell, (kind, nodes)) in solid.mesh.cell_iter().enumerate() {
        if shapes.iter().all(|(of, _)| *of != kind) {
            let points = volume_points(kind, solid.mesh, nodes).ok_or_else(|| folded(solid, cell, kind, nodes))?;
            shapes.push((kind, points.into_iter().map(|point| point.shape).collect()));
        }
    }
    Ok(shapes)
}
