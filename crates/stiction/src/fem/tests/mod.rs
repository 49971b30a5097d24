mod assembly;
mod convergence;
mod elements;
mod loads;
mod mass;
mod patch;
mod rigid;

use std::collections::HashMap;
use std::sync::Arc;

use faer::linalg::solvers::Solve;

use super::*;
use crate::linalg::{Csr, SymmetricCsr};
use crate::mesh::{Block, BlockElement, CellKind, Cells, Face, Mesh, block, v3};

/// A box `[0, size]` of `cells` bricks, hexahedra, two wedges or five tetrahedra each.
fn brick(kind: CellKind, cells: [usize; 3], size: [f64; 3]) -> Mesh {
    let made = match kind {
        CellKind::Tet10 => Some(BlockElement::Tet10Five { parity: 0 }),
        CellKind::Hex20 => Some(BlockElement::Hex20),
        CellKind::Wedge6 => Some(BlockElement::Wedge6),
        CellKind::Wedge15 => Some(BlockElement::Wedge15),
        CellKind::Tet4 | CellKind::Hex8 => None,
    };
    if let Some(element) = made {
        return block(&Block { size, cells, origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
    }
    let node = |i: usize, j: usize, k: usize| ((k * (cells[1] + 1) + j) * (cells[0] + 1) + i) as u32;
    let mut nodes = Vec::new();
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let x = [i, j, k];
                nodes.push(std::array::from_fn(|a| size[a] * x[a] as f64 / cells[a] as f64));
            }
        }
    }
    // The second split mirrors the first, so that the diagonals of neighbouring bricks meet.
    const SPLIT: [[[usize; 4]; 5]; 2] = [
        [[0, 1, 3, 4], [2, 3, 1, 6], [5, 4, 6, 1], [7, 6, 4, 3], [1, 3, 4, 6]],
        [[1, 2, 0, 5], [3, 0, 2, 7], [4, 5, 7, 0], [6, 7, 5, 2], [0, 5, 2, 7]],
    ];
    let mut list = Vec::new();
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let bottom = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
                let corner = |c: usize| node(bottom[c % 4][0], bottom[c % 4][1], k + c / 4);
                match kind {
                    CellKind::Hex8 => list.extend((0..8).map(corner)),
                    _ => list.extend(SPLIT[(i + j + k) % 2].iter().flatten().map(|&c| corner(c))),
                }
            }
        }
    }
    let mut mesh = Mesh {
        nodes,
        cells: vec![Cells { kind, nodes: list }],
        faces: vec![],
        groups: vec![],
        arrays: Default::default(),
    };
    if kind == CellKind::Tet4 {
        for tet in mesh.cells[0].nodes.chunks_exact_mut(4) {
            let [a, b, c, d]: [[f64; 3]; 4] = std::array::from_fn(|i| mesh.nodes[tet[i] as usize]);
            if v3::dot(v3::sub(d, a), v3::cross(v3::sub(b, a), v3::sub(c, a))) < 0.0 {
                tet.swap(2, 3);
            }
        }
    }
    mesh.faces = boundary(&mesh);
    mesh
}

/// Faces of exactly one cell.
fn boundary(mesh: &Mesh) -> Vec<Face> {
    let mut count: HashMap<Vec<u32>, usize> = HashMap::new();
    let mut faces = Vec::new();
    for (number, nodes) in mesh.cells[0].nodes.chunks_exact(mesh.cells[0].kind.nodes()).enumerate() {
        for local in 0..mesh.cells[0].kind.faces().len() {
            faces.push(Face::of_cell(mesh.cells[0].kind, nodes, number as u32, local as u8));
        }
    }
    let key = |face: &Face| {
        let mut nodes = face.nodes().to_vec();
        nodes.sort_unstable();
        nodes
    };
    faces.iter().for_each(|face| *count.entry(key(face)).or_default() += 1);
    faces.into_iter().filter(|face| count[&key(face)] == 1).collect()
}

/// Moves every node that is not on the boundary of the box by up to `amount`, the same way in each run; those of
/// quadratic cells, which are nearer to one another and bend, by less.
fn distort(mesh: &mut Mesh, amount: f64) {
    let amount = if mesh.cells[0].kind.edges().is_empty() { amount } else { 0.3 * amount };
    let mut inside = vec![true; mesh.nodes.len()];
    mesh.faces.iter().flat_map(|face| face.nodes()).for_each(|&i| inside[i as usize] = false);
    for (i, x) in mesh.nodes.iter_mut().enumerate().filter(|(i, _)| inside[*i]) {
        for (c, x) in x.iter_mut().enumerate() {
            *x += amount * (1.7 * i as f64 + 2.9 * c as f64 + 0.4).sin();
        }
    }
}

fn material(young: f64, poisson: f64) -> Material {
    Material { name: "m".into(), young, poisson, density: 1.0, formulation: Formulation::Auto, ..Material::default() }
}

fn function(f: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static) -> Field {
    Field::Function { text: "f(x, y, z)".into(), value: Arc::new(move |x, _| f(x)) }
}

/// Nodes for which `on` holds.
fn nodes_where(mesh: &Mesh, on: impl Fn([f64; 3]) -> bool) -> Vec<u32> {
    (0..mesh.nodes.len() as u32).filter(|&i| on(mesh.nodes[i as usize])).collect()
}

/// Boundary faces for all nodes of which `on` holds.
fn faces_where(mesh: &Mesh, on: impl Fn([f64; 3]) -> bool) -> Vec<u32> {
    let holds = |f: &u32| mesh.faces[*f as usize].nodes().iter().all(|&i| on(mesh.nodes[i as usize]));
    (0..mesh.faces.len() as u32).filter(holds).collect()
}

fn boundary_nodes(mesh: &Mesh) -> Vec<u32> {
    let mut nodes: Vec<u32> = mesh.faces.iter().flat_map(|f| f.nodes().to_vec()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Assembles a body of one material.
fn model_of(mesh: &Mesh, material: &Material, loads: &[Load], fixes: &[Fix]) -> Result<FeModel, crate::Error> {
    let solid =
        Solid { mesh, materials: std::slice::from_ref(material), material_of_cell: &vec![0; mesh.cell_count()] };
    assemble(&solid, loads, fixes, 0.0)
}

/// The full displacement under `loads` and `fixes`.
fn solve(mesh: &Mesh, material: &Material, loads: &[Load], fixes: &[Fix]) -> Vec<f64> {
    let model = model_of(mesh, material, loads, fixes).unwrap();
    full_displacement(&model, &solve_spd(&model.stiffness, &model.load))
}

/// `A x = b` by faer's sparse Cholesky factorisation.
fn solve_spd(a: &SymmetricCsr, b: &[f64]) -> Vec<f64> {
    let rows = (0..a.rows).flat_map(|i| a.row(i).0.iter().zip(a.row(i).1).map(move |(&j, &v)| (i, j as usize, v)));
    let entries: Vec<_> = rows.map(|(i, j, v)| faer::sparse::Triplet::new(i, j, v)).collect();
    let a = faer::sparse::SparseColMat::<usize, f64>::try_new_from_triplets(a.rows, a.rows, &entries).unwrap();
    let x = a.sp_cholesky(faer::Side::Lower).unwrap().solve(faer::Col::from_fn(b.len(), |i| b[i]));
    (0..b.len()).map(|i| x[i]).collect()
}

const KINDS: [CellKind; 6] = CellKind::ALL;
