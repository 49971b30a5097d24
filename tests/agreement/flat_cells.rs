//! Cells whose corners lie nearly in one plane, as meshing programs leave a few: they tie their nodes to one another ten thousand times as
//! stiffly as others do, and multigrid takes hardly more cycles for them.

use std::collections::HashSet;
use std::ops::ControlFlow;

use stiction::contact::{ContactProblem, SurfaceFriction};
use stiction::friction::{Multigrid, Settings, Solution, solve_multigrid};
use stiction::mesh::{BlockElement, Mesh};
use stiction_fixtures::*;

/// Places with flat cells.
const FLAT: usize = 8;

/// Edges of a quadratic tetrahedron in the order of their middles.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

fn volume(nodes: &[[f64; 3]], cell: &[u32]) -> f64 {
    let [a, b, c, d]: [[f64; 3]; 4] = std::array::from_fn(|k| nodes[cell[k] as usize]);
    let [u, v, w] = [b, c, d].map(|x| [x[0] - a[0], x[1] - a[1], x[2] - a[2]]);
    u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])
}

/// Moves a corner inside the block towards the face opposite to it until `left` of its height is left, of every cell where that leaves the
/// others around the corner room, but for one whose face is in the same plane, as long as no two of these places have a node in common and none has
/// one on the floor. Returns their number.
fn flatten(mesh: &mut Mesh, size: [f64; 3], left: f64) -> usize {
    let cells: Vec<Vec<u32>> = mesh.cell_iter().map(|(_, nodes)| nodes.to_vec()).collect();
    let mut used: HashSet<u32> = HashSet::new();
    let mut count = 0;
    for cell in &cells {
        if count == FLAT || cell[..4].iter().any(|v| used.contains(v)) {
            continue;
        }
        for &v in &cell[..4] {
            let old = mesh.nodes[v as usize];
            if (0..3).any(|d| old[d] < 1e-9 || old[d] > size[d] - 1e-9) {
                continue;
            }
            let others: Vec<[f64; 3]> =
                cell[..4].iter().filter(|&&w| w != v).map(|&w| mesh.nodes[w as usize]).collect();
            let middle: [f64; 3] = std::array::from_fn(|d| others.iter().map(|x| x[d]).sum::<f64>() / 3.0);
            let around: Vec<&Vec<u32>> = cells.iter().filter(|other| other[..4].contains(&v)).collect();
            if around.iter().any(|cell| cell.iter().any(|&node| mesh.nodes[node as usize][2] < 1e-9)) {
                continue;
            }
            let before: Vec<f64> = around.iter().map(|cell| volume(&mesh.nodes, cell)).collect();
            mesh.nodes[v as usize] = std::array::from_fn(|d| middle[d] + left * (old[d] - middle[d]));
            let kept = around.iter().zip(&before).map(|(cell, before)| volume(&mesh.nodes, cell) / before);
            let kept: Vec<f64> = kept.collect();
            let flat = kept.iter().filter(|&&kept| kept < 2.0 * left).count();
            if (1..=2).contains(&flat) && kept.iter().all(|&kept| kept > 0.0 && (kept > 0.2 || kept < 2.0 * left)) {
                used.extend(around.iter().flat_map(|cell| &cell[..4]));
                count += 1;
                break;
            }
            mesh.nodes[v as usize] = old;
        }
    }
    for cell in cells.iter().filter(|cell| cell.len() == 10) {
        for (k, [a, b]) in EDGES.into_iter().enumerate() {
            let [a, b] = [a, b].map(|end| mesh.nodes[cell[end] as usize]);
            mesh.nodes[cell[4 + k] as usize] = std::array::from_fn(|d| 0.5 * (a[d] + b[d]));
        }
    }
    count
}

/// A block on a floor with friction, of which some cells are flat.
fn problem(element: BlockElement, cells: [usize; 3], left: Option<f64>) -> (ContactProblem, usize) {
    let size = [3.0, 1.0, 1.0];
    let mut case = block_of(size, cells, element, 1000.0, 0.3);
    let count = left.map_or(0, |left| flatten(&mut case.mesh, size, left));
    let held = case.contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.3)).fix("x-min", HELD);
    (held.traction("z-max", [0.1, 0.05, -1.0]).pose().problem, count)
}

fn by_multigrid(problem: &ContactProblem) -> Solution {
    let settings = Settings { max_iterations: 1000, ..settings(1e-9) };
    let solution =
        solve_multigrid(problem, &mut Multigrid::new(problem).unwrap(), &settings, &mut |_| ControlFlow::Continue(()));
    assert_solved(&solution);
    solution
}

/// Eight places with flat cells take at most twice the cycles of none, whatever is left of their height (measured: 16 to 26 of linear tetrahedra, 16
/// without, and 20 to 30 of quadratic ones, 20 without); the forces are those of the direct path.
#[test]
fn flat_cells_take_few_more_cycles_and_give_the_forces_of_the_direct_path() {
    for (element, cells) in [(BlockElement::Tet4Six, [15, 5, 5]), (BlockElement::Tet10Six, [12, 4, 4])] {
        let usual = by_multigrid(&problem(element, cells, None).0).counts.cycles;
        for left in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6] {
            let (flat, count) = problem(element, cells, Some(left));
            let found = by_multigrid(&flat);
            println!("{element:?} {count} cells {left:e} {usual} {:?}", found.counts);
            assert!(count == FLAT && found.counts.cycles <= 2 * usual, "{element:?} {left} {:?}", found.counts);
            let off = distance(&found.lambda, &solved(&flat, 1e-9).lambda);
            assert!(off <= 1e-5, "{element:?} {left}: forces differ by {off:e}");
        }
    }
}
