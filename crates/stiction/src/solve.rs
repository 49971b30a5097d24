//! One call from matrices to a certified solution: validates the problem, chooses multigrid or a Cholesky factor, solves
//! and certifies.

mod least;
mod starts;

use std::ops::ControlFlow;

use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::equilibrium::no_equilibrium;
use crate::dual::{Dual, DualSettings, Form, choose, estimate};
use crate::friction::{
    self, Multigrid, Part, Progress, SetUp, Settings, Solution, SolverPath, SoughtForce, Status, Tightened, equations,
    multigrid_fits, points_in,
};
use crate::linalg::Watch;

pub(crate) use least::{LeastCounts, fits_by_counts};
pub use starts::{Attempt, Solutions, Start, solve_from_starts};

/// What [`solve_with_kept`] is about to do. The observer's `Break` ends it: at an iteration with the status
/// [`Interrupted`](Status::Interrupted), before the first one with [`Error::interrupted`]. Between two events
/// [`Settings::stop`] does the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SolveEvent {
    /// Set-up of the multigrid hierarchy.
    SettingUp {
        /// Unknown displacements.
        unknowns: usize,
    },
    /// Ordering of the unknowns for the factor.
    Ordering,
    /// Elimination of `unknowns`, predicted to take so many bytes.
    Factorising {
        /// Unknown displacements.
        unknowns: usize,
        /// Predicted memory.
        bytes: u64,
    },
    /// The hierarchy or the factor stands, the iteration begins.
    Solving,
    /// An iteration has been done.
    Iteration(Progress),
}

/// Called at every [`SolveEvent`].
pub type Observer<'a> = Watch<'a, SolveEvent>;

/// A factor or a multigrid hierarchy, worth keeping from one solve to the next while `K` and `B` stand.
#[derive(Debug, Default)]
pub struct Kept {
    operator: Option<Operator>,
    /// Whether [`SolverPath::Auto`] tries multigrid first; known after the first solve.
    multigrid_first: Option<bool>,
    /// Why the direct path was taken, where multigrid has failed or an earlier run says so.
    pub(crate) why_direct: Option<String>,
}

#[derive(Debug)]
enum Operator {
    Factor(Box<Dual>),
    /// Of these points; of all where none are named.
    Multigrid(Box<Multigrid>, Option<Vec<u32>>),
}

/// The multigrid cycles that a bound on the iterations stands for.
pub(crate) fn multigrid_cycles(iterations: usize) -> usize {
    Threshold::CYCLES_PER_ITERATION.saturating_mul(iterations)
}

/// What the choice of a path is made by.
struct Threshold;

impl Threshold {
    /// Below so many unknowns either path takes about a tenth of a second, and the factor also gives facts about uniqueness.
    const SMALL: usize = 10_000;
    /// Above so many unknowns multigrid is the faster path whatever the shape (bars, plates and cubes were measured).
    const LARGE: usize = 100_000;
    /// Seconds of set-up and cycles an unknown on one core of 2020 or later: 30 cycles; only ratios are meant.
    const MULTIGRID_SECONDS: f64 = 1e-5;
    /// Cycles allowed for each iteration: a Newton step on the other path costs about as much.
    const CYCLES_PER_ITERATION: usize = 5;
}

/// Whether multigrid is predicted to be faster than a factor.
pub fn multigrid_is_faster(problem: &ContactProblem) -> bool {
    match problem.unknowns() {
        n if n < Threshold::SMALL => false,
        n if n > Threshold::LARGE => true,
        n => Threshold::MULTIGRID_SECONDS * (n as f64) < estimate(problem).seconds,
    }
}

impl Kept {
    /// Nothing yet, with the choice of [`SolverPath::Auto`] already made.
    pub fn deciding(multigrid_first: bool) -> Self {
        Kept { multigrid_first: Some(multigrid_first), ..Kept::default() }
    }

    /// In a few words why [`SolverPath::Auto`] has taken the direct path.
    pub(crate) fn why_direct(&self, problem: &ContactProblem) -> String {
        match &self.why_direct {
            Some(why) => why.clone(),
            None if problem.unknowns() < Threshold::SMALL => format!("less than {} unknowns", Threshold::SMALL),
            None => "predicted to be faster than multigrid".into(),
        }
    }

    /// Whether the next solve begins with multigrid.
    pub fn begins_with_multigrid(&mut self, problem: &ContactProblem, settings: &Settings) -> bool {
        match settings.path {
            SolverPath::Multigrid => true,
            SolverPath::Auto => match (&settings.start, &settings.start_displacement) {
                (Some(_), None) => false,
                (None, Some(_)) => true,
                _ => *self.multigrid_first.get_or_insert_with(|| multigrid_is_faster(problem)),
            },
            SolverPath::Dense | SolverPath::Solves => false,
        }
    }

    /// Refuses a problem whose hierarchy does not fit, unless it stands already.
    pub(crate) fn fits(&self, problem: &ContactProblem, settings: &Settings) -> Result<(), Error> {
        match &self.operator {
            Some(Operator::Multigrid(..)) => Ok(()),
            _ => multigrid_fits(problem, None, settings.memory_limit),
        }
    }

    /// The hierarchy for `problem`, set up if it does not stand yet. Equations over many nodes are not among its points. Where points share
    /// nodes with others that are out it is of those that are in, and made anew when others are.
    pub(crate) fn set_up(
        &mut self,
        problem: &ContactProblem,
        settings: &Settings,
        observer: &mut Observer,
    ) -> Result<SetUp<'_>, Error> {
        let equations = equations(problem, None);
        let without = |mut points: Vec<u32>| {
            points.retain(|j| equations.binary_search(j).is_err());
            points
        };
        let points = || without(points_in(problem));
        let all = || without((0..problem.points() as u32).collect());
        let (multigrid, of) = match self.operator.take() {
            Some(Operator::Multigrid(multigrid, None)) if equations.is_empty() => (multigrid, None),
            Some(Operator::Multigrid(multigrid, Some(of))) if of == points() || of == all() => (multigrid, Some(of)),
            old => {
                let share_nodes = matches!(old, Some(Operator::Multigrid(..)));
                drop(old);
                multigrid_fits(problem, None, settings.memory_limit)?;
                begin(observer, SolveEvent::SettingUp { unknowns: problem.unknowns() })?;
                let make = |of: Option<Vec<u32>>| {
                    let multigrid = match &of {
                        None => Multigrid::until(problem, &settings.stop),
                        Some(of) => Multigrid::until(&problem.of_points(of), &settings.stop),
                    };
                    multigrid.map(|multigrid| (Box::new(multigrid), of))
                };
                let of_all = match share_nodes {
                    true => None,
                    false => match make((!equations.is_empty()).then(all)) {
                        Err(error) if error.interrupted || problem.contact.out.is_empty() => return Err(error),
                        made => made.ok(),
                    },
                };
                match of_all {
                    Some(made) => made,
                    None => make(Some(points()))?,
                }
            }
        };
        let part = of.clone().map(|points| Part::new(problem, points, equations));
        let Operator::Multigrid(multigrid, _) = self.operator.insert(Operator::Multigrid(multigrid, of)) else {
            unreachable!("just put there")
        };
        Ok(SetUp { multigrid, part })
    }

    /// The factor for `problem`, made if it does not stand yet.
    ///
    /// # Errors
    /// If it does not fit `settings.memory_limit`, or `K` is not positive definite beyond the rigid motions of its bodies. If
    /// it is stopped: [`Error::interrupted`].
    pub fn factorised(
        &mut self,
        problem: &ContactProblem,
        settings: &Settings,
        observer: &mut Observer,
    ) -> Result<&Dual, Error> {
        let dual = match self.operator.take() {
            Some(Operator::Factor(dual)) => dual,
            // The hierarchy goes before the factor comes: both together may not fit the memory.
            hierarchy => {
                drop(hierarchy);
                begin(observer, SolveEvent::Ordering)?;
                let form = match settings.path {
                    SolverPath::Auto | SolverPath::Multigrid => Form::Auto,
                    SolverPath::Dense => Form::Dense,
                    SolverPath::Solves => Form::Solves,
                };
                let (memory_limit, stop) = (settings.memory_limit, settings.stop.clone());
                let choice = choose(problem, &DualSettings { form, memory_limit, stop })?;
                begin(observer, SolveEvent::Factorising { unknowns: problem.unknowns(), bytes: choice.bytes })?;
                Box::new(Dual::new(problem, choice)?)
            }
        };
        let Operator::Factor(dual) = self.operator.insert(Operator::Factor(dual)) else {
            unreachable!("just put there")
        };
        Ok(dual)
    }
}

/// Solves elastic contact with friction, from matrices to a certified answer.
///
/// Stiffness, load, `B`, gap and laws suffice ([`ContactProblem::from_matrices`]). With `elastic.node_of` and
/// `elastic.near_kernel` large problems can go by multigrid, which is faster from some ten thousand unknowns on, and
/// bodies may float. Unless `settings.path` says otherwise the path is chosen by prediction, or as the one that can use the
/// start; where one of them does not end certified, the other takes over.
///
/// An iteration that ends short of its tolerance is no error: [`Solution::status`] says so, and the certificate how far.
///
/// # Errors
/// If the problem or the settings are not valid (lengths, indices, values; a start that the path cannot use), `K` is not
/// positive definite beyond the rigid motions of its bodies, or the matrices do not fit `settings.memory_limit`. If it is
/// stopped before its first iteration: [`Error::interrupted`].
pub fn solve(problem: &ContactProblem, settings: &Settings) -> Result<Solution, Error> {
    solve_with_kept(problem, settings, &mut Kept::default(), &mut |_| ControlFlow::Continue(()))
}

/// As [`solve`], with what an earlier solve has kept and an observer.
///
/// What `kept` holds must be of the same `K` and `B`; load, gap, slip reference and laws may differ. Counts are those of
/// this solve alone.
///
/// # Errors
/// As [`solve`].
pub fn solve_with_kept(
    problem: &ContactProblem,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Result<Solution, Error> {
    problem.validate()?;
    settings.validate(problem)?;
    let only_displacement = settings.start.is_none() && settings.start_displacement.is_some();
    if settings.path == SolverPath::Auto && only_displacement {
        // The factor would leave the start unused.
        kept.set_up(problem, settings, observer).map_err(|error| match error.interrupted {
            true => error,
            false => {
                let what = format!("`start_displacement` is a start for multigrid alone: {}", error.what);
                Error::new("settings", what, "give multipliers (`start`), or no start")
            }
        })?;
    }
    solve_validated(problem, settings, kept, observer)
}

/// As [`solve_with_kept`], for a problem that has been validated.
pub(crate) fn solve_validated(
    problem: &ContactProblem,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Result<Solution, Error> {
    let observer: &mut Observer = &mut |event| {
        let flow = observer(event);
        if settings.stop.asked() { ControlFlow::Break(()) } else { flow }
    };
    if !kept.begins_with_multigrid(problem, settings) {
        let direct = by_factor(problem, settings, kept, observer)?;
        // A failed warm start is tried again from zero first.
        if settings.path != SolverPath::Auto || settings.start.is_some() || is_final(&direct) {
            return Ok(direct);
        }
        // The two methods cycle on different problems.
        return match by_multigrid(problem, settings, kept, observer) {
            Ok(found) if found.status == Status::Solved => Ok(found),
            Ok(Solution { status: Status::Interrupted, .. }) | Err(Error { interrupted: true, .. }) => {
                Ok(Solution { status: Status::Interrupted, ..direct })
            }
            _ => Ok(direct),
        };
    }
    let asked = settings.path == SolverPath::Multigrid;
    match by_multigrid(problem, settings, kept, observer) {
        Ok(solution) if asked || is_final(&solution) => Ok(solution),
        Err(error) if asked || error.interrupted => Err(error),
        by_multigrid => {
            let direct = by_factor(problem, settings, kept, observer);
            kept.multigrid_first = Some(direct.is_err());
            kept.why_direct = Some(match &by_multigrid {
                Ok(found) => format!("multigrid did not reach the tolerance in {} cycles", found.counts.cycles),
                Err(error) => error.what.clone(),
            });
            match (direct, by_multigrid) {
                (Err(error), Ok(found)) if error.interrupted => Ok(Solution { status: Status::Interrupted, ..found }),
                // The factor may not fit the memory: then what multigrid has found is the better answer.
                (Err(_), Ok(found)) => Ok(found),
                (direct, _) => direct,
            }
        }
    }
}

/// Reports what begins, unless it shall not.
fn begin(observer: &mut Observer, event: SolveEvent) -> Result<(), Error> {
    if observer(&event).is_break() { Err(Error::interrupted()) } else { Ok(()) }
}

/// Whether another path could not do better.
fn is_final(solution: &Solution) -> bool {
    solution.certificate.is_as_good_as_the_data()
        || matches!(solution.status, Status::Solved | Status::Interrupted | Status::NoEquilibrium)
}

fn by_multigrid(
    problem: &ContactProblem,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Result<Solution, Error> {
    let set_up = kept.set_up(problem, settings, observer)?;
    let _ = observer(&SolveEvent::Solving);
    let departs = no_equilibrium(problem, set_up.multigrid.motions()).is_some();
    let cycles = multigrid_cycles(settings.max_iterations);
    let max_iterations = if departs { 0 } else { cycles };
    let settings = friction::Settings { max_iterations, ..settings.clone() };
    let mut report = |progress: &Progress| observer(&SolveEvent::Iteration(*progress));
    let solution = set_up.solution(problem, &settings, &mut report)?;
    let status = if departs { Status::NoEquilibrium } else { solution.status };
    Ok(Solution { status, ..solution })
}

/// Solves for the shortenings of bolts whose force is given as well, by multigrid; `None` where that is not for the problem
/// and not asked for.
///
/// # Errors
/// As [`solve`], and if it is stopped [`Error::interrupted`].
pub(crate) fn tighten(
    problem: &ContactProblem,
    sought: &[SoughtForce],
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Result<Option<Tightened>, Error> {
    let set_up = match kept.set_up(problem, settings, observer) {
        Ok(set_up) => set_up,
        Err(error) if error.interrupted || settings.path == SolverPath::Multigrid => return Err(error),
        Err(_) => return Ok(None),
    };
    begin(observer, SolveEvent::Solving)?;
    let max_iterations = multigrid_cycles(settings.max_iterations);
    let settings = friction::Settings { max_iterations, ..settings.clone() };
    let mut interrupted = false;
    let mut report = |progress: &Progress| {
        let flow = observer(&SolveEvent::Iteration(*progress));
        interrupted |= flow.is_break();
        flow
    };
    match set_up.tighten(problem, sought, &settings, &mut report) {
        _ if interrupted => Err(Error::interrupted()),
        Err(error) if settings.path == SolverPath::Multigrid => Err(error),
        found => Ok(found.ok()),
    }
}

fn by_factor(
    problem: &ContactProblem,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Result<Solution, Error> {
    let dual = kept.factorised(problem, settings, observer)?;
    let _ = observer(&SolveEvent::Solving);
    // The operator counts on from solve to solve.
    let (products, solves) = (dual.products(), dual.solves());
    let own = |progress: &Progress| Progress { products: progress.products - products, ..*progress };
    let mut solution = friction::solve(problem, dual, settings, &mut |p| observer(&SolveEvent::Iteration(own(p))));
    solution.counts.products -= products;
    solution.counts.solves -= solves;
    solution.history.iter_mut().for_each(|progress| *progress = own(progress));
    Ok(solution)
}
