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
pub(crate) const NO_STRAIN: f64 = 1e-8;

/// Displacements of the unknowns by which a unit of shortening strains nothing, for each bolt; `None` where the parts of
/// the bolt are held or hang together elsewhere.
fn rigid_modes(prepared: &Prepared) -> Vec<Option<Vec<f64>>> {
    prepared.loading.bolts.iter().map(|bolt| rigid_mode(prepared, bolt)).collect()
}

fn rigid_mode(prepared: &Prepared, bolt: &Bolt) -> Option<Vec<f64>> {
    let (dofs, k) = (&prepared.model.dofs, &prepared.problem.elastic.K);
    let [before, beyond] = sides(&prepared.mesh, bolt);
    let mut wanted = vec![0.0; k.rows];
    for &(dof, force) in &bolt.cut.force {
        if let Some(wanted) = wanted.get_mut(dofs.unknown[dof as usize] as usize) {
            *wanted = force;
        }
    }
    let largest = wanted.iter().fold(0.0, |a: f64, f| a.max(f.abs()));
    let moving = |part: &[bool], way: f64| {
        let of = |&dof: &u32| {
            if part[dofs.mesh_node(dof / 3) as usize] { way * bolt.cut.axis[dof as usize % 3] } else { 0.0 }
        };
        let motion: Vec<f64> = dofs.free.iter().map(of).collect();
        let strains = k.times(&motion).iter().zip(&wanted).any(|(a, b)| (a - b).abs() > NO_STRAIN * largest);
        (!strains).then_some(motion)
    };
    moving(&beyond, -1.0).or_else(|| moving(&before, 1.0))
}

/// Nodes on the side of the cut its axis comes from, those of the cut included, and on the other.
pub(crate) fn sides(mesh: &Mesh, bolt: &Bolt) -> [Vec<bool>; 2] {
    let at_cut = |node: u32| bolt.cut.nodes.binary_search(&node).is_ok();
    let mut beyond = reached(mesh, &bolt.cut.cells, &at_cut);
    let mut before = reached(mesh, &cells_before(mesh, bolt), &at_cut);
    for &node in &bolt.cut.nodes {
        (beyond[node as usize], before[node as usize]) = (false, true);
    }
    [before, beyond]
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

/// Adds to the shortening each bolt is searched from what its parts approach each other by before they bear its force;
/// `from_rest` marks the bolts that have no shortening of an earlier step.
pub(crate) fn close_clearance(prepared: &Prepared, targets: &[Target], from_rest: &[bool], shortening: &mut [f64]) {
    let wanted = |target: &Target| if let Target::Force(force) = target { Some(*force) } else { None };
    if !targets.iter().zip(from_rest).any(|(target, from_rest)| *from_rest && wanted(target).is_some()) {
        return;
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
    if !columns.is_empty() {
        let (_, way) = rigid_equilibrium(&prepared.problem, &prepared.motions, &columns, &pull, u);
        bolts.iter().zip(way).for_each(|(&bolt, way)| shortening[bolt] += way.max(0.0));
    }
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
