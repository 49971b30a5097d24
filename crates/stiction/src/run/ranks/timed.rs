//! What of contact changes from increment to increment: laws that depend on time, points that take part in some steps only, supports
//! that begin or end with a step, strength that is lost. All of it is found by the functions of one machine, at the points here.

use super::local::Local;
use super::steps::full;
use crate::Error;
use crate::contact::{ContactProblem, Friction};
use crate::fem::{DofMap, FeModel};
use crate::friction::PointState;
use crate::io::case::{Case, ContactSpec, Spot};
use crate::mesh::Mesh;
use crate::ranks::max;
use crate::run::pose::activity::{ALWAYS, Activity, Period, note_gaps, timed_contacts};
use crate::run::pose::coefficients;
use crate::run::pose::load_state::{jump, take_lost_strength};
use crate::run::pose::ties::{Tied, Ties, TimedFix, nodes_of_points, ties_of_supports};
use crate::run::solve::strength::lose_of;

/// Of the points of this rank, those of others among them.
pub(super) struct Timed {
    activity: Activity,
    /// Bonded points that are put in with a step, each with the period.
    put_in: Vec<(usize, Period)>,
    /// Equations, couplings, and supports that begin or end with a step; their points are the last.
    ties: Ties,
    /// What ties and bonded points that have been put in keep: the sum of each tie and the gap of each point when it began, length.
    stood: Vec<f64>,
    /// The law of each point while it is in, as posed.
    pub laws: Vec<Friction>,
    /// The points whose strength is lost; empty before the first.
    pub lost: Vec<bool>,
    /// Those whose strength can be lost.
    brittle: Vec<usize>,
}

/// What ties displacements here.
pub(super) enum Posed {
    /// Supports that begin or end with a step, where the case has no other ties.
    Supports(Vec<TimedFix>),
    /// Points that rank 0 has made of all ties.
    Points(Tied),
}

impl Timed {
    /// Of a posed problem, to which the points of ties are added. `contact_of` is the contact of
    /// each pair, `diagonal` that of the whole mesh, length.
    pub(super) fn new(
        case: &Case,
        (mesh, model): (&Mesh, &FeModel),
        problem: &mut ContactProblem,
        (contact_of, diagonal): (&[u32], f64),
        posed: Posed,
    ) -> Result<Timed, Error> {
        let contacts = |problem: &ContactProblem| -> Vec<_> {
            let pairs = problem.labels.pairs.iter().zip(contact_of);
            // Points that give way to others for a time have been refused.
            pairs.map(|(pair, &k)| (&case.contacts[k as usize], pair.points.clone(), &[][..])).collect()
        };
        let all = contacts(problem);
        let brittle = all.iter().filter(|(contact, ..)| contact.friction.is_brittle());
        let brittle = brittle.flat_map(|(_, points, _)| points.clone()).collect();
        let (mut activity, put_in) = timed_contacts(&case.steps, diagonal, all.into_iter());
        let tied = match posed {
            Posed::Supports(supports) if case.fixes.iter().any(|fix| fix.during.period(&case.steps) != ALWAYS) => {
                let taken = nodes_of_points(&model.dofs, problem);
                Some(Tied::new(&model.dofs, ties_of_supports(mesh, &model.dofs, &supports)?, &taken)?)
            }
            Posed::Supports(_) => None,
            Posed::Points(tied) => Some(tied),
        };
        let ties = match tied {
            // Pairs are the same on all ranks.
            Some(tied) => Ties::of(tied, &model.dofs, problem, &mut activity),
            None => Ties::none(problem),
        };
        let laws = problem.contact.friction.clone();
        Ok(Timed { activity, put_in, ties, stood: Vec::new(), laws, lost: Vec::new(), brittle })
    }

    /// The nodes of the points of ties.
    pub(super) fn nodes(&self) -> &[u32] {
        self.ties.nodes()
    }

    /// Where the case says so of the point of a tie.
    pub(super) fn spot(&self, j: usize) -> Spot {
        self.ties.spot(j - self.contact_points())
    }

    /// Forces on the body that hold the ties here at time `t`, as of [`Ties::forces`].
    pub(super) fn forces(&self, lambda: &[f64], t: f64) -> Vec<f64> {
        self.ties.forces(lambda, t)
    }

    /// Forces of supports that begin or end with a step, as of [`Ties::reactions`].
    pub(super) fn reactions(&self, lambda: &[f64], t: f64) -> Vec<(u32, f64)> {
        self.ties.reactions(lambda, t)
    }

    /// The points of surfaces; those of ties follow.
    pub(super) fn contact_points(&self) -> usize {
        self.ties.points().start
    }

    /// The points that take no part at time `t`, with the gap each gets more, length.
    pub(super) fn out(&self, t: f64) -> impl Iterator<Item = (usize, f64)> {
        self.activity.out(t)
    }

    /// Adds to `motion`, `3m`, what is kept at time `t` of gaps, and where supports are that hold then.
    pub(super) fn put_into(&self, motion: &mut [f64], dofs: &DofMap, undeformed: &[f64], t: f64) -> Result<(), Error> {
        self.ties.put_into(motion, dofs, &self.stood, [0.0; 3], t)?;
        let stood = self.stood.get(self.ties.len()..).unwrap_or_default();
        self.activity.keep_gaps((&self.put_in, stood), undeformed, motion, t);
        Ok(())
    }
}

/// Whether the laws or gaps of some points change with time.
pub(super) fn changes_laws(case: &Case) -> bool {
    let of_contact = |contact: &ContactSpec| {
        contact.periods(&case.steps) != [ALWAYS]
            || contact.bonded_until.is_some()
            || coefficients::of_time(&contact.friction).is_some()
    };
    case.contacts.iter().any(of_contact) || of_ties(case).any(|period| period != ALWAYS)
}

/// When supports, and motions of couplings, are prescribed.
fn of_ties(case: &Case) -> impl Iterator<Item = Period> {
    let during = case.fixes.iter().map(|fix| &fix.during).chain(case.couplings.iter().map(|coupling| &coupling.during));
    during.map(|during| during.period(&case.steps))
}

/// Whether strength can be lost.
pub(super) fn is_brittle(case: &Case) -> bool {
    case.contacts.iter().any(|contact| contact.friction.is_brittle())
}

/// The times at which something begins that keeps what it finds, ascending.
pub(super) fn begins(case: &Case) -> Vec<f64> {
    let of_contacts = case.contacts.iter().flat_map(|contact| contact.periods(&case.steps));
    let mut begins: Vec<f64> =
        of_contacts.chain(of_ties(case)).map(|period| period[0]).filter(|begin| begin.is_finite()).collect();
    begins.sort_by(f64::total_cmp);
    begins.dedup();
    begins
}

/// The laws of all points here at time `t`.
pub(super) fn laws(local: &Local, case: &Case, t: f64) -> Result<Vec<Friction>, Error> {
    let Local { timed, problem, .. } = local;
    let pairs = problem.labels.pairs.iter().zip(&local.contact_of);
    let surfaces = pairs.map(|(pair, &k)| {
        let contact = &case.contacts[k as usize];
        (&contact.friction, pair.points.clone(), &contact.spot)
    });
    let node = |j: usize| local.node_of(j);
    let changed = coefficients::at(&local.piece.mesh, &timed.laws, surfaces, &node, t)?;
    let mut laws = timed.activity.laws(changed, &timed.laws, t).unwrap_or_else(|| timed.laws.clone());
    take_lost_strength(&mut laws, &timed.lost);
    Ok(laws)
}

/// Takes the strength of points that have failed, by the states of all points here; false where none of any rank has.
pub(super) fn lose_strength(local: &mut Local, case: &Case, states: &[PointState]) -> bool {
    if !is_brittle(case) {
        return false;
    }
    let Local { timed, problem, division, .. } = local;
    let here = lose_of(&timed.brittle, states, &mut problem.contact.friction, &mut timed.lost);
    let mut any = [f64::from(u8::from(here))];
    max(&*division.ranks, &mut any);
    any[0] > 0.0
}

/// Notes where everything stands that begins at the end `t` of the step that has the displacements `u`, of all unknowns here, or
/// later.
pub(super) fn note_where_it_stands(local: &mut Local, u: &[f64], t: f64) {
    let all = full(local, u);
    let Local { timed, problem, model, motion, undeformed, .. } = local;
    let ties = timed.ties.len();
    timed.stood.resize(ties + timed.put_in.len(), 0.0);
    timed.ties.note(&mut timed.stood[..ties], &model.dofs, &all, [0.0; 3], t);
    if !timed.put_in.is_empty() {
        let held = problem.labels.supports.as_ref().map_or(&[][..], |supports| &supports.displacement);
        let jump = jump(problem, held, u);
        note_gaps((&timed.put_in, &mut timed.stood[ties..]), &jump, motion, undeformed, t);
    }
}
