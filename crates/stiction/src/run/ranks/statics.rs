//! Loads that have no equilibrium: rank 0 poses the case alone, if it is small enough, and says so by statics before anything is iterated.

use super::local::Local;
use super::small::MOST_UNKNOWNS;
use super::solve::unknowns;
use super::timed::is_brittle;
use crate::contact::escape::Escape;
use crate::friction::{Multigrid, Status};
use crate::io::case::Case;
use crate::ranks::{Ranks, broadcast, max};
use crate::run::pose::bolts::Target;
use crate::run::pose::load_state::{apply, load_state};
use crate::run::pose::{Prepared, prepare};
use crate::run::solve::clearance::escape_of_bolts;
use crate::run::solve::escape;

/// What statics says of a case.
pub(super) struct Statics {
    /// Whether rank 0 looks, the same on every rank.
    looks: bool,
    /// On rank 0.
    prepared: Option<Box<Prepared>>,
    /// What the loads carry away, and how, where they were found last to have no equilibrium.
    pub escape: Option<Escape>,
}

impl Statics {
    /// Every rank calls it; where contact alone holds no body and no bolt is tightened by force there is nothing to look for.
    pub(super) fn new(case: &Case, local: &Local, multigrid: &Multigrid) -> Self {
        let ranks = &*local.division.ranks;
        let mut floats = [f64::from(u8::from(!multigrid.motions().is_empty()))];
        max(ranks, &mut floats);
        let by_force = local.bolts.iter().any(|bolt| bolt.bolt.is_by_force());
        // What strength is left rank 0 does not know.
        let looks = (floats[0] > 0.0 || by_force) && !is_brittle(case) && unknowns(local) <= MOST_UNKNOWNS;
        let prepared = if looks && ranks.rank() == 0 { prepare(case).ok().map(Box::new) } else { None };
        Statics { looks, prepared, escape: None }
    }

    /// One that does not look.
    pub(super) fn none() -> Self {
        Statics { looks: false, prepared: None, escape: None }
    }

    /// Whether the loads at time `t`, where `targets` are prescribed of the bolts, have no equilibrium, the same on every rank.
    pub(super) fn departs(&mut self, ranks: &dyn Ranks, targets: &[Target], t: f64) -> bool {
        if !self.looks {
            return false;
        }
        let found = self.prepared.as_mut().and_then(|prepared| at(prepared, targets, t));
        let found = serde_json::to_vec(&found).unwrap_or_default();
        self.escape = serde_json::from_slice(&broadcast(ranks, found)).unwrap_or_default();
        self.escape.is_some()
    }
}

fn at(prepared: &mut Prepared, targets: &[Target], t: f64) -> Option<Escape> {
    // What cannot be had at that time the ranks say themselves.
    let loads = load_state(prepared, t).ok()?;
    let unslid = vec![0.0; 2 * prepared.problem.points()];
    apply(prepared, &loads, &unslid);
    escape(&prepared.problem, Status::NoEquilibrium).or_else(|| escape_of_bolts(prepared, targets))
}
