//! A case on several ranks: divided, posed, solved, certified.

use std::sync::Arc;

use super::keep::{Finished, Keep, Kept};
use super::local::{Local, local};
use super::record::{RankRecord, RankedStep, RankedSummary};
use super::steps::{put_state, slid as sliding, times};
use super::totals::totals;
use super::tractions::tractions;
use super::{room, scope, share};
use crate::Error;
use crate::certificate::ghost_values;
use crate::fem::full_displacement;
use crate::friction::{self, Multigrid, PointState, Progress, Solution, Status, solve_multigrid};
use crate::io::case::Case;
use crate::io::machine;
use crate::linalg::{Stop, Watch};
use crate::mesh::v3::{V3, add, norm, scale};
use crate::ranks::{Counted, Ranks, Traffic, agree, gather_all, max, sum};
use crate::run::pose::{Seconds, stopwatch};
use crate::run::solve::Totals;
use crate::run::solve::tractions::Traction;
use crate::solve::multigrid_cycles;

/// The answer of one rank, and what all of them know together.
pub struct RankedAnswer {
    pub(super) local: Local,
    /// Displacements of all nodes here, along x, y, z.
    pub(super) u: Vec<V3>,
    /// The same of all unknowns here.
    pub(super) free: Vec<f64>,
    /// Multipliers of all points here, newton, `3m`, and their states.
    pub(super) lambda: Vec<f64>,
    pub(super) states: Vec<PointState>,
    /// Pressure and shear of all points here.
    pub(super) tractions: Vec<Traction>,
    /// The same on every rank.
    pub summary: RankedSummary,
}

impl RankedAnswer {
    /// The nodes of this rank, by their numbers in the whole mesh, with their displacements; length.
    pub fn displacements(&self) -> Vec<(u64, [f64; 3])> {
        let own = (0..self.u.len()).filter(|&v| self.local.division.is_own(v as u32));
        own.map(|v| (self.local.piece.nodes[v], self.u[v])).collect()
    }
}

/// Solves a case on all ranks: rank 0 reads the mesh and sends each its piece, and from then on no rank has more than that.
/// `observer` is told of every cycle; it ends all ranks if one of them says so.
///
/// # Errors
/// What makes the case impossible to pose, or cannot be divided; the same at every rank.
pub fn solve_on_ranks(
    case: &Case,
    ranks: &Arc<dyn Ranks>,
    observer: &mut Watch<Progress>,
) -> Result<RankedAnswer, Error> {
    solve_steps_on_ranks(case, ranks, None, observer)
}

/// The same with the load steps kept in a folder as they are solved, if there are any, and those kept there before it gone on
/// from.
///
/// # Errors
/// As [`solve_on_ranks`]; and if files of steps cannot be written, or those to go on from are of another case.
pub fn solve_steps_on_ranks(
    case: &Case,
    ranks: &Arc<dyn Ranks>,
    keep: Option<&Keep>,
    observer: &mut Watch<Progress>,
) -> Result<RankedAnswer, Error> {
    let mut lap = stopwatch();
    let mut seconds = Seconds::default();
    let counted = Arc::new(Counted::new(Arc::clone(ranks)));
    let ranks: Arc<dyn Ranks> = counted.clone();
    agree(&*ranks, scope::check(case))?;
    let share = share::share(case, &*ranks)?;
    seconds.mesh = lap();
    let limit = room::limit(case, &*ranks);
    room::piece_fits(&share.piece.mesh, &limit, &*ranks)?;
    let mut local = agree(&*ranks, local(case, share, &ranks))?;
    room::hierarchy_fits(&local, &limit, &*ranks)?;
    seconds.assembly = lap();
    let (mut multigrid, mut own) = Multigrid::divided(&local.problem, &local.division, &Stop::never())?;
    seconds.setup = lap();
    let before = counted.traffic();
    let mut settings = friction::Settings {
        tolerance: case.solver.tolerance,
        max_iterations: multigrid_cycles(case.solver.max_iterations),
        path: friction::SolverPath::Multigrid,
        ..friction::Settings::default()
    };
    let mut kept = keep.filter(|_| !case.steps.is_empty()).map(|keep| Kept::begin(keep, case, &local)).transpose()?;
    let (mut steps, mut times) = (Vec::new(), times(case).into_iter());
    let mut slid = vec![0.0; 2 * local.problem.points()];
    if let Some(Finished { records, u }) = kept.as_mut().and_then(Kept::finished) {
        let last = times.nth(records.len() - 1);
        if let Some((_, t)) = last {
            agree(&*ranks, put_state(&mut local, case, t, &slid))?;
        }
        slid = sliding(&local, &u);
        (steps, settings.start_displacement) = (records, Some(u));
    }
    loop {
        let time = times.next();
        if let Some((_, t)) = time {
            agree(&*ranks, put_state(&mut local, case, t, &slid))?;
            own = multigrid.renewed(&local.problem).unwrap_or(own);
        }
        let solution = solve_multigrid(&own, &mut multigrid, &settings, observer);
        let found = everywhere(&local, &multigrid, &solution);
        let tractions = tractions(&local, &found.lambda);
        let contact = totals(&local, &multigrid, &solution, &tractions);
        steps.extend(time.map(|(step, t)| RankedStep::new(case, step, t, &solution, contact.clone())));
        if let (Some(kept), Some(_)) = (&mut kept, time) {
            kept.add(&local, (&found.free, &found.lambda, &found.states), &steps)?;
        }
        if times.len() > 0 && solution.status == Status::Solved {
            slid = sliding(&local, &found.free);
            settings.start_displacement = Some(found.free);
            continue;
        }
        seconds.iteration = lap();
        let traffic = since(before, counted.traffic());
        let summary = summary(case, &local, &multigrid, (&solution, contact, steps), &found.u, &seconds, traffic);
        let Everywhere { u, free, lambda, states } = found;
        return Ok(RankedAnswer { local, u, free, lambda, tractions: tractions.points, states, summary });
    }
}

fn since(before: Traffic, now: Traffic) -> Traffic {
    Traffic {
        exchanges: now.exchanges - before.exchanges,
        messages: now.messages - before.messages,
        bytes: now.bytes - before.bytes,
        halo_exchanges: now.halo_exchanges - before.halo_exchanges,
        halo_bytes: now.halo_bytes - before.halo_bytes,
        sums: now.sums - before.sums,
    }
}

/// An answer here: displacements of all unknowns and of all nodes, multipliers and states of all points.
struct Everywhere {
    free: Vec<f64>,
    u: Vec<V3>,
    lambda: Vec<f64>,
    states: Vec<PointState>,
}

/// The answer at all nodes and points here: what belongs to other ranks is asked of them.
fn everywhere(local: &Local, multigrid: &Multigrid, solution: &Solution) -> Everywhere {
    let (own, m) = (multigrid.own_points(), local.problem.points());
    let (mut lambda, mut codes) = (vec![0.0; 3 * m], vec![0.0; 3 * m]);
    for (place, &j) in own.iter().enumerate() {
        let j = j as usize;
        (0..3).for_each(|r| lambda[r * m + j] = solution.lambda[r * own.len() + place]);
        codes[j] = f64::from(solution.states[place].code());
    }
    let (free, lambda) = ghost_values(&local.problem, &local.division, &solution.u, &lambda);
    let (_, codes) = ghost_values(&local.problem, &local.division, &solution.u, &codes);
    let state = |code: &f64| PointState::of_code(*code as usize).unwrap_or(PointState::Open);
    let full = full_displacement(&local.model, &free);
    let (u, states) = (full.as_chunks().0.to_vec(), codes[..m].iter().map(state).collect());
    Everywhere { free, u, lambda, states }
}

/// The node of a point and its rows there, along x, y, z: normal, tangents.
pub(super) fn axes(local: &Local, j: usize) -> (u32, [V3; 3]) {
    let (problem, dofs) = (&local.problem, &local.model.dofs);
    let node = local.division.points[j];
    let mut axes = [[0.0; 3]; 3];
    for (axis, i) in axes.iter_mut().zip(problem.rows(j)) {
        let (columns, values) = problem.contact.B.row(i);
        let free = columns.iter().zip(values).map(|(&k, v)| (dofs.free[k as usize], *v));
        let held = problem.labels.supports.as_ref().map_or((&[][..], &[][..]), |s| s.B.row(i));
        let held = held.0.iter().zip(held.1).map(|(&k, v)| (dofs.prescribed[k as usize], *v));
        for (dof, value) in free.chain(held).filter(|(dof, _)| dof / 3 == node) {
            *axis = add(*axis, scale(value, dofs.direction(dof)));
        }
    }
    (node, axes)
}

fn summary(
    case: &Case,
    local: &Local,
    multigrid: &Multigrid,
    (solution, contact, steps): (&Solution, Totals, Vec<RankedStep>),
    u: &[V3],
    seconds: &Seconds,
    traffic: Traffic,
) -> RankedSummary {
    let ranks = &*local.division.ranks;
    let labels = local.problem.elastic.node_of.iter().flatten();
    let mut sums = [labels.filter(|&&label| local.division.is_own(label)).count() as f64];
    sum(ranks, &mut sums);
    let own = u.iter().enumerate().filter(|(v, _)| local.division.is_own(*v as u32));
    let mut largest = [own.map(|(_, u)| norm(*u)).fold(0.0, f64::max)];
    max(ranks, &mut largest);
    let [nodes, ghosts] = multigrid.nodes_here();
    let of_steps: usize = steps.iter().map(|step| step.iterations).sum();
    let cycles = of_steps.max(solution.counts.cycles).max(1) as f64;
    let per_cycle = |count: u64| count as f64 / cycles;
    let record = RankRecord {
        nodes,
        ghosts,
        points: multigrid.own_points().len(),
        exchanges_per_cycle: per_cycle(traffic.halo_exchanges),
        bytes_per_cycle: per_cycle(traffic.halo_bytes),
        messages_per_cycle: per_cycle(traffic.messages),
        sums_per_cycle: per_cycle(traffic.sums),
        peak_memory_bytes: machine::peak_memory(),
    };
    let records = gather_all(ranks, record.to_bytes()).iter().map(|bytes| RankRecord::from_bytes(bytes)).collect();
    RankedSummary::new(case, local.sizes, solution, contact, sums[0] as usize, largest[0], records, seconds)
        .with_levels(multigrid.level_sizes())
        .with_steps(steps)
}
