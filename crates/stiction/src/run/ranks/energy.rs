//! Energies, and forces of loads and supports, over all ranks: each counts what is its own, by the functions of one machine.

use super::bolts::RankBolt;
use super::local::Local;
use super::solve::Everywhere;
use crate::fem::InitialStrain;
use crate::mesh::v3::{V3, add};
use crate::ranks::sum;
use crate::run::pose::load_state::{Initial, LoadState};
use crate::run::solve::balance::{Balance, BodyState, Counted, balance, potential};
use crate::run::solve::quantities::{load_of, reaction_at_nodes};

/// Calls `of` with what counts here.
fn counted<T>(local: &Local, of: impl FnOnce(&Counted) -> T) -> T {
    let (division, labels) = (&local.division, local.problem.elastic.node_of.as_deref().unwrap_or_default());
    of(&Counted {
        unknown: &|i| division.is_own(labels[i]),
        held: &|p| division.is_own(division.supports[p]),
        point: &|j| division.is_own(division.points[j]),
    })
}

fn summed<const N: usize>(local: &Local, here: [f64; N]) -> [f64; N] {
    let mut sums = here;
    sum(&*local.division.ranks, &mut sums);
    sums
}

/// `1/2 u'Ku - f'u` over all degrees of freedom of all ranks, with the energy of thermal strain and of shortened bolts; `u` are
/// displacements of all unknowns here.
pub(super) fn energy(local: &Local, u: &[f64]) -> f64 {
    let [energy] = summed(local, [counted(local, |own| potential(&local.problem, u, own)) + local.initial.energy]);
    energy
}

/// The force that all loads add up to.
pub(super) fn load(local: &Local) -> V3 {
    summed(local, counted(local, |own| load_of(&local.model.dofs, &local.problem, own)))
}

/// Force of the supports on the body at each node here, newton, complete at own nodes; from displacements of all unknowns and multipliers of all
/// points here.
pub(super) fn reactions(local: &Local, [free, lambda]: [&[f64]; 2], t: f64) -> Vec<V3> {
    let of_ties = local.timed.reactions(lambda, t);
    reaction_at_nodes(local.piece.mesh.nodes.len(), (&local.model, &local.problem), &of_ties, free, lambda)
}

/// That of all supports.
pub(super) fn reaction(local: &Local, answer: &Everywhere, t: f64) -> V3 {
    let all = reactions(local, [&answer.free, &answer.lambda], t);
    let own = all.iter().enumerate().filter(|(v, _)| local.division.is_own(*v as u32));
    summed(local, own.fold([0.0; 3], |sum, (_, force)| add(sum, *force)))
}

/// What thermal strain and bolts that are drawn together by `shortening` (length) come to here: forces of all cells at what is here, the energy of own
/// cells. The energy of a bolt belongs to rank 0, but for what thermal strain has in it.
pub(super) fn initial(
    local: &Local,
    strained: Option<InitialStrain>,
    thermal_force: Vec<f64>,
    shortening: &[f64],
) -> Initial {
    let dofs = &local.model.dofs;
    let InitialStrain { strain, rise, mut force, mut energy } = strained.unwrap_or_default();
    if !shortening.is_empty() {
        force.resize(3 * local.piece.mesh.nodes.len(), 0.0);
    }
    if force.is_empty() {
        return Initial { thermal_force, ..Initial::default() };
    }
    dofs.to_components(&mut force);
    let first = local.division.ranks.rank() == 0;
    for ((RankBolt { bolt, .. }, &s), k) in local.bolts.iter().zip(shortening).zip(0..) {
        if first {
            energy += 0.5 * s * s * bolt.cut.stiffness;
        }
        energy += s * thermal_force.get(k).copied().unwrap_or(0.0);
        dofs.entries(&bolt.cut.force).iter().for_each(|&(dof, unit)| force[dof as usize] += s * unit);
    }
    let at = |list: &[u32]| list.iter().map(|&dof| force.get(dof as usize).copied().unwrap_or(0.0)).collect();
    let (load, support_load) = (at(&dofs.free), at(&dofs.prescribed));
    Initial { load, support_load, energy, strain, rise, thermal_force, shortening: shortening.to_vec() }
}

/// The load state at time `t`, which [`put_state`](super::steps::put_state) has put into the problem.
pub(super) fn state(local: &Local, t: f64) -> LoadState {
    let (problem, supports) = (&local.problem, local.problem.labels.supports.as_ref());
    LoadState {
        load: supports.map_or(&problem.elastic.f, |held| &held.free_load).clone(),
        support_load: supports.map_or(Vec::new(), |held| held.load.clone()),
        displacement: supports.map_or(Vec::new(), |held| held.displacement.clone()),
        motion: local.motion.clone(),
        initial: local.initial.clone(),
        out: local.timed.out(t).collect(),
        t,
        ..LoadState::start(0, 0, 0)
    }
}

/// The body here before the first step.
pub(super) fn at_rest(local: &Local) -> BodyState {
    let (n, m) = (local.problem.unknowns(), local.problem.points());
    let loads = LoadState::start(n, local.model.dofs.prescribed.len(), m);
    BodyState { loads, u: vec![0.0; n], lambda: vec![0.0; 3 * m], balance: Balance::default() }
}

/// The body here after the step from `before` to an answer at time `t`, with the balance of all ranks.
pub(super) fn after(local: &Local, before: &mut BodyState, answer: &Everywhere, t: f64) -> BodyState {
    let loads = state(local, t);
    // What was before is that of all ranks, and is added once.
    let Balance { work, dissipation, .. } = std::mem::take(&mut before.balance);
    let Everywhere { free, lambda, .. } = answer;
    let here = counted(local, |own| balance(&local.problem, before, &loads, free, lambda, own));
    let [of_step, elastic, taken] = summed(local, [here.work, here.elastic, here.dissipation]);
    let balance = Balance { work: work + of_step, elastic, dissipation: dissipation + taken };
    BodyState { loads, u: free.clone(), lambda: lambda.clone(), balance }
}
