//! Closure of clearances: where loose parts come to rest when bolts draw them together.
//!
//! A bolt whose parts can approach each other without strain takes no force until something lies between them. That
//! motion, the rigid mode of the bolt, is found here, and the equilibrium of all parts as rigid bodies on an elastic
//! foundation, from which the shortening is searched and multigrid starts.

use crate::friction::rigid_equilibrium;
use crate::linalg::axpy;
use crate::mesh::Mesh;
use crate::run::pose::Prepared;
use crate::run::pose::bolts::{Bolt, Target};

/// Forces at a cut that are left of a motion, over those of the shortening itself, below which it strains nothing.
const NO_STRAIN: f64 = 1e-8;

/// Displacements of the unknowns by which a unit of shortening strains nothing, for each bolt; `None` where the parts of
/// the bolt are held or hang together elsewhere.
fn rigid_modes(prepared: &Prepared) -> Vec<Option<Vec<f64>>> {
    prepared.loading.bolts.iter().map(|bolt| rigid_mode(prepared, bolt)).collect()
}

fn rigid_mode(prepared: &Prepared, bolt: &Bolt) -> Option<Vec<f64>> {
    let (mesh, dofs, k) = (&prepared.mesh, &prepared.model.dofs, &prepared.problem.elastic.K);
    let at_cut = |node: u32| bolt.cut.nodes.binary_search(&node).is_ok();
    let mut beyond = reached(mesh, &bolt.cut.cells, &at_cut);
    let mut before = reached(mesh, &cells_before(mesh, bolt), &at_cut);
    for &node in &bolt.cut.nodes {
        (beyond[node as usize], before[node as usize]) = (false, true);
    }
    let mut wanted = vec![0.0; k.rows];
    for &(dof, force) in &bolt.cut.force {
        if let Some(wanted) = wanted.get_mut(dofs.unknown[dof as usize] as usize) {
            *wanted = force;
        }
    }
    let largest = wanted.iter().fold(0.0, |a: f64, f| a.max(f.abs()));
    let moving = |part: &[bool], way: f64| {
        let of = |&dof: &u32| if part[dof as usize / 3] { way * bolt.cut.axis[dof as usize % 3] } else { 0.0 };
        let motion: Vec<f64> = dofs.free.iter().map(of).collect();
        let strains = k.times(&motion).iter().zip(&wanted).any(|(a, b)| (a - b).abs() > NO_STRAIN * largest);
        (!strains).then_some(motion)
    };
    moving(&beyond, -1.0).or_else(|| moving(&before, 1.0))
}

/// Cells at the cut on the side its axis comes from.
fn cells_before(mesh: &Mesh, bolt: &Bolt) -> Vec<u32> {
    let touches = |nodes: &[u32]| nodes.iter().any(|node| bolt.cut.nodes.binary_search(node).is_ok());
    let all = (0u32..).zip(mesh.cell_iter()).filter(|(_, (_, nodes))| touches(nodes)).map(|(cell, _)| cell);
    all.filter(|cell| bolt.cut.cells.binary_search(cell).is_err()).collect()
}

/// Nodes reached from cells through others without crossing the nodes of the cut.
fn reached(mesh: &Mesh, from: &[u32], at_cut: &dyn Fn(u32) -> bool) -> Vec<bool> {
    let mut reached = vec![false; mesh.nodes.len()];
    mesh.cell_nodes(from).iter().filter(|&&node| !at_cut(node)).for_each(|&node| reached[node as usize] = true);
    // A sweep in either direction passes through a part whose cells are numbered along it.
    let count = mesh.cell_count();
    let mut grows = true;
    while grows {
        grows = false;
        for cell in (0..count).chain((0..count).rev()) {
            let nodes = mesh.cell(cell).1;
            if nodes.iter().any(|&node| reached[node as usize]) {
                for &node in nodes.iter().filter(|&&node| !at_cut(node)) {
                    grows |= !std::mem::replace(&mut reached[node as usize], true);
                }
            }
        }
    }
    reached
}

/// The part of a bolt's force under which it has closed its clearance and hardly more.
const HARDLY: f64 = 1e-6;

/// For each bolt with a rigid mode that begins from rest (`from_rest`) and whose force is given: its number, its clearance,
/// and what its parts approach each other by before they bear the force; lengths.
pub(crate) fn clearances(
    prepared: &Prepared,
    targets: &[Target],
    from_rest: &[bool],
    shortening: &[f64],
) -> Vec<(usize, f64, f64)> {
    let wanted = |target: &Target| if let Target::Force(force) = target { Some(*force) } else { None };
    if !targets.iter().zip(from_rest).any(|(target, from_rest)| *from_rest && wanted(target).is_some()) {
        return Vec::new();
    }
    let modes = rigid_modes(prepared);
    let (mut columns, mut pull, mut bolts) = (Vec::new(), Vec::new(), Vec::new());
    let mut u = vec![0.0; prepared.problem.unknowns()];
    for (number, mode) in modes.iter().enumerate() {
        let Some(mode) = mode else { continue };
        match wanted(&targets[number]).filter(|_| from_rest[number]) {
            Some(force) => {
                columns.push(mode.clone());
                pull.push(force);
                bolts.push(number);
            }
            None => axpy(shortening[number], mode, &mut u),
        }
    }
    if columns.is_empty() {
        return Vec::new();
    }
    let way = |part: f64| {
        let pull: Vec<f64> = pull.iter().map(|force| part * force).collect();
        rigid_equilibrium(&prepared.problem, &prepared.motions, &columns, &pull, u.clone()).1
    };
    bolts.into_iter().zip(way(HARDLY)).zip(way(1.0)).map(|((bolt, least), way)| (bolt, least, way)).collect()
}

/// Displacements of the parts as rigid bodies with the bolts as they stand now; `None` without a bolt that has a rigid mode.
pub(crate) fn start(prepared: &Prepared) -> Option<Vec<f64>> {
    let shortening = &prepared.loading.initial.shortening;
    if shortening.iter().all(|&s| s == 0.0) {
        return None;
    }
    let mut u = vec![0.0; prepared.problem.unknowns()];
    let mut moved = false;
    for (mode, &s) in rigid_modes(prepared).iter().zip(shortening) {
        if let Some(mode) = mode {
            axpy(s, mode, &mut u);
            moved = true;
        }
    }
    moved.then(|| rigid_equilibrium(&prepared.problem, &prepared.motions, &[], &[], u).0)
}
