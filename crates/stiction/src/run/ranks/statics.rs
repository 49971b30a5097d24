//! Loads that have no equilibrium, which every rank finds by statics before anything is iterated, and loads that friction does not take up: from the
//! contact points of all ranks.

use super::bolts;
use super::local::Local;
use super::loose::among;
use crate::contact::ContactProblem;
use crate::contact::equilibrium::in_words_among;
use crate::contact::escape::{Escape, escape_among};
use crate::contact::sliding::Sliding;
use crate::friction::Multigrid;
use crate::run::pose::bolts::Target;
use crate::run::solve::SlidingRecord;
use crate::run::solve::path::is_worth_a_word;

/// How the loads that the problem has carry away a body, or the parts of bolts of which `targets` are prescribed, where nothing balances them; the
/// same on every rank. `own` is the problem of the points of this rank. No bolt is shortened.
pub(super) fn escape(
    local: &Local,
    (multigrid, own): (&Multigrid, &ContactProblem),
    targets: &[Target],
) -> Option<Escape> {
    if let Some(slide) = multigrid.no_equilibrium(own).filter(|_| !multigrid.motions().is_empty()) {
        return Some(among(local, |among| escape_among(&local.problem, multigrid.motions(), &slide, among)));
    }
    bolts::escape(local, (multigrid, own), targets)
}

/// How friction at the multipliers of the points of this rank, `3m`, is overcome; the same on every rank.
pub(super) fn limit_load(
    local: &Local,
    (multigrid, own): (&Multigrid, &ContactProblem),
    lambda: &[f64],
) -> Option<SlidingRecord> {
    let Sliding { alpha, load, friction } = multigrid.least_resisted(own, lambda).filter(is_worth_a_word)?;
    let motion = among(local, |among| in_words_among(&local.problem, multigrid.motions(), &alpha, among.max));
    Some(SlidingRecord { motion, load, friction })
}
