//! Bolts on several ranks: rank 0 finds their cuts in the whole mesh, each rank has what acts at its nodes, and forces are sums.

use super::local::Local;
use crate::Error;
use crate::contact::escape::Escape;
use crate::contact::{ContactProblem, PosedPoints};
use crate::fem::{Cut, DofMap, Solid, full_displacement};
use crate::friction::{Multigrid, SoughtForce};
use crate::io::case::{BoltSpec, Case};
use crate::mesh::MeshPiece;
use crate::ranks::{max, put, sum, take};
use crate::run::pose::BoltFacts;
use crate::run::pose::bolts::{Bolt, Target, bolts};
use crate::run::pose::cut_sides::sides;
use crate::run::pose::loads::end;
use crate::run::solve::BoltState;
use crate::run::solve::clearance::{Loose, in_words, rigid_mode};
use crate::run::solve::stretch::{along_axis, stretch};

/// A bolt of the whole mesh, or what of it is on a piece, whose numbers it has then.
#[derive(Debug)]
pub(super) struct RankBolt {
    /// Its stiffness is that of the whole cut.
    pub bolt: Bolt,
    /// Whether each node lies before the cut, or is of it, and whether it lies beyond.
    sides: [Vec<bool>; 2],
    /// How far a unit of shortening moves nodes along the axis if the bolt takes it up along its free length.
    stretch: Vec<(u32, f64)>,
}

/// The bolts of a case on its whole mesh; `held` are the degrees of freedom and `points` the contact points there.
pub(super) fn of_whole(
    case: &Case,
    solid: &Solid,
    held: &DofMap,
    points: &PosedPoints,
) -> Result<(Vec<RankBolt>, Vec<BoltFacts>), Error> {
    let (found, facts) = bolts(solid, held, case, end(case))?;
    let mut ends = vec![false; if found.is_empty() { 0 } else { solid.mesh.nodes.len() }];
    let touched = points.nodes().chain(points.links().into_iter().flatten());
    let fixed = held.prescribed.iter().map(|dof| dof / 3);
    touched.chain(fixed).filter(|_| !found.is_empty()).for_each(|node| ends[node as usize] = true);
    let of = |bolt: Bolt| {
        let (sides, stretch) = (sides(solid.mesh, &bolt), stretch(solid.mesh, &bolt, &ends));
        RankBolt { bolt, sides, stretch }
    };
    Ok((found.into_iter().map(of).collect(), facts))
}

/// Appends what of the bolts is on a piece to a message.
pub(super) fn put_bolts(bolts: &[RankBolt], piece: &MeshPiece, to: &mut Vec<u8>) {
    let node = |v: u32| piece.nodes.binary_search(&u64::from(v)).ok().map(|k| k as u32);
    for RankBolt { bolt, sides, stretch } in bolts {
        let Cut { axis, cells, nodes, force, stiffness, strain } = &bolt.cut;
        put(&[axis[0], axis[1], axis[2], *stiffness], to);
        put(&nodes.iter().filter_map(|&v| node(v)).collect::<Vec<u32>>(), to);
        let cell = |c: u32| piece.cells.binary_search(&u64::from(c)).ok().map(|k| k as u32);
        let of_cells = cells.iter().zip(strain).filter_map(|(&c, strain)| Some((cell(c)?, *strain)));
        let (cells, strains): (Vec<u32>, Vec<[f64; 6]>) = of_cells.unzip();
        put(&cells, to);
        put(&strains, to);
        let forces = force.iter().filter_map(|&(dof, value)| Some((3 * node(dof / 3)? + dof % 3, value)));
        put_pairs(forces, to);
        let side = |&v: &u64| u8::from(sides[0][v as usize]) + 2 * u8::from(sides[1][v as usize]);
        put(&piece.nodes.iter().map(side).collect::<Vec<u8>>(), to);
        put_pairs(stretch.iter().filter_map(|&(v, way)| Some((node(v)?, way))), to);
    }
}

fn put_pairs(pairs: impl Iterator<Item = (u32, f64)>, to: &mut Vec<u8>) {
    let (numbers, values): (Vec<u32>, Vec<f64>) = pairs.unzip();
    put(&numbers, to);
    put(&values, to);
}

fn take_pairs(from: &mut &[u8]) -> Vec<(u32, f64)> {
    let numbers: Vec<u32> = take(from);
    numbers.into_iter().zip(take::<f64>(from)).collect()
}

/// Takes the bolts of a case out of a message of [`put_bolts`].
pub(super) fn take_bolts(case: &[BoltSpec], from: &mut &[u8]) -> Vec<RankBolt> {
    let of = |spec: &BoltSpec| {
        let numbers: Vec<f64> = take(from);
        let [x, y, z, stiffness] = [0, 1, 2, 3].map(|k| numbers[k]);
        let (nodes, cells, strain) = (take(from), take(from), take(from));
        let cut = Cut { axis: [x, y, z], nodes, cells, strain, force: take_pairs(from), stiffness };
        let BoltSpec { name, by, lock, spot, .. } = spec.clone();
        let side: Vec<u8> = take(from);
        let sides = [1, 2].map(|bit| side.iter().map(|side| side & bit != 0).collect());
        RankBolt { bolt: Bolt { name, cut, by, lock, spot }, sides, stretch: take_pairs(from) }
    };
    case.iter().map(of).collect()
}

/// Adds what the bolts do, drawn together by `shortening`, to forces along the degrees of freedom of the nodes here.
pub(super) fn add_forces(local: &Local, shortening: &[f64], forces: &mut [f64]) {
    for (RankBolt { bolt, .. }, &s) in local.bolts.iter().zip(shortening) {
        let entries = local.model.dofs.entries(&bolt.cut.force);
        entries.iter().for_each(|&(dof, unit)| forces[dof as usize] += s * unit);
    }
}

/// The mean strain of each cell here that causes no stress; empty without bolts and temperatures.
pub(super) fn strain(local: &Local, shortening: &[f64]) -> Vec<[f64; 6]> {
    let mut strain = local.initial.strain.clone();
    if local.bolts.is_empty() {
        return strain;
    }
    strain.resize(local.material_of_cell.len(), [0.0; 6]);
    for (RankBolt { bolt, .. }, s) in local.bolts.iter().zip(shortening) {
        for (&cell, unit) in bolt.cut.cells.iter().zip(&bolt.cut.strain) {
            (0..6).for_each(|k| strain[cell as usize][k] += s * unit[k]);
        }
    }
    strain
}

/// Forces of the bodies on unit jumps at each cut, less those of thermal strain, of which those of this rank are added: `u` has all
/// components of nodes here.
fn from_body(local: &Local, u: &[f64]) -> Vec<f64> {
    let of_bolt = |(number, RankBolt { bolt, .. }): (usize, &RankBolt)| {
        let own = bolt.cut.force.iter().filter(|(dof, _)| local.division.is_own(dof / 3));
        let thermal = local.initial.thermal_force.get(number).copied().unwrap_or(0.0);
        own.map(|&(dof, unit)| unit * u[dof as usize]).sum::<f64>() - thermal
    };
    let mut forces: Vec<f64> = local.bolts.iter().enumerate().map(of_bolt).collect();
    sum(&*local.division.ranks, &mut forces);
    forces
}

/// Force and shortening of each bolt, the same on every rank; `u` are the displacements of all nodes here.
pub(super) fn states(local: &Local, u: &[[f64; 3]], shortening: &[f64]) -> Vec<BoltState> {
    if local.bolts.is_empty() {
        return Vec::new();
    }
    let bolts = local.bolts.iter().zip(shortening).zip(from_body(local, u.as_flattened()));
    let state = |((RankBolt { bolt, .. }, &s), from_body): ((&RankBolt, &f64), f64)| BoltState {
        name: bolt.name.clone(),
        force: bolt.cut.stiffness * s - from_body,
        shortening: s,
    };
    bolts.map(state).collect()
}

/// The forces (`wanted`: number of the bolt, newton) beyond what `shortening` gives, as
/// [`sought_forces`](crate::run::solve::stretch::sought_forces).
pub(super) fn sought(local: &Local, wanted: &[(usize, f64)], shortening: &[f64]) -> Vec<SoughtForce> {
    let dofs = &local.model.dofs;
    let from_held = from_body(local, &full_displacement(&local.model, &vec![0.0; local.problem.unknowns()]));
    let unknowns = |entries: &[(u32, f64)]| -> Vec<(u32, f64)> {
        let numbered = dofs.entries(entries).into_iter().map(|(dof, x)| (dofs.unknown[dof as usize], x));
        numbered.filter(|(number, _)| *number != u32::MAX).collect()
    };
    let of = |&(number, force): &(usize, f64)| {
        let RankBolt { bolt, stretch, .. } = &local.bolts[number];
        let stiffness = bolt.cut.stiffness;
        SoughtForce {
            force: unknowns(&bolt.cut.force),
            stiffness,
            target: force + from_held[number] - stiffness * shortening[number],
            stretch: unknowns(&along_axis(bolt, stretch)),
        }
    };
    wanted.iter().map(of).collect()
}

/// As [`close_clearance`](crate::run::solve::clearance::close_clearance); `own` is the problem of the points of this rank.
pub(super) fn close_clearance(
    local: &Local,
    with: (&Multigrid, &ContactProblem),
    targets: &[Target],
    from_rest: &[bool],
    shortening: &mut [f64],
) {
    loose(local, with, |loose| loose.close(targets, from_rest, shortening));
}

/// As [`escape_of_bolts`](crate::run::solve::clearance::escape_of_bolts); `own` is the problem of the points of this rank.
pub(super) fn escape(
    local: &Local,
    (multigrid, own): (&Multigrid, &ContactProblem),
    targets: &[Target],
) -> Option<Escape> {
    let modes = modes(local);
    let mut thermal = local.initial.thermal_force.clone();
    thermal.resize(local.bolts.len(), 0.0);
    sum(&*local.division.ranks, &mut thermal);
    let (mut slices, mut pull, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (((bolt, target), mode), thermal) in local.bolts.iter().zip(targets).zip(modes).zip(thermal) {
        if let (Target::Force(force), Some(mode)) = (target, mode) {
            slices.push(mode);
            pull.push(force - thermal);
            names.push(&bolt.bolt.name);
        }
    }
    if slices.is_empty() {
        return None;
    }
    in_words(&names, &multigrid.departs_along(own, &slices, &pull)?)
}

/// As [`start`](crate::run::solve::clearance::start).
pub(super) fn start(local: &Local, with: (&Multigrid, &ContactProblem), shortening: &[f64]) -> Option<Vec<f64>> {
    loose(local, with, |loose| loose.start(shortening))
}

/// How the parts of each bolt come together as rigid ones: displacements of all unknowns here.
fn modes(local: &Local) -> Vec<Option<Vec<f64>>> {
    let (dofs, k) = (&local.model.dofs, &local.problem.elastic.K);
    let is_own = |i: usize| local.division.is_own(dofs.free[i] / 3);
    let largest = |here: f64| {
        let mut most = [here];
        max(&*local.division.ranks, &mut most);
        most[0]
    };
    let mode = |RankBolt { bolt, sides, .. }: &RankBolt| rigid_mode((dofs, k), &bolt.cut, sides, &is_own, &largest);
    local.bolts.iter().map(mode).collect()
}

/// The parts of all ranks, for `find`: modes and displacements are those of the unknowns here.
fn loose<T>(local: &Local, (multigrid, own): (&Multigrid, &ContactProblem), find: impl FnOnce(&Loose) -> T) -> T {
    let (ranks, modes) = (&*local.division.ranks, || modes(local));
    let part = multigrid.part(own);
    let equilibrium = |slices: &[Vec<f64>], pull: &[f64], u: Vec<f64>| {
        multigrid.rigid_equilibrium((own, part.as_ref()), slices, pull, u)
    };
    let mut thermal = local.initial.thermal_force.clone();
    if !local.bolts.is_empty() {
        thermal.resize(local.bolts.len(), 0.0);
        sum(ranks, &mut thermal);
    }
    find(&Loose { unknowns: local.problem.unknowns(), modes: &modes, thermal: &thermal, equilibrium: &equilibrium })
}
