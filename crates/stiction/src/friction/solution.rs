//! What every solver of contact takes, reports and returns.

use serde::{Deserialize, Serialize};

use super::PointState;
use crate::Error;
use crate::certificate::Certificate;
use crate::contact::{ContactProblem, Friction};
use crate::linalg::Stop;

/// The way a solution is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverPath {
    /// The faster by prediction, within memory; never that of a [`Solution`].
    #[default]
    Auto,
    /// `B K⁻¹ Bᵀ` by a Cholesky factor of `K` and the dense Schur complement on the unknowns that `B` touches.
    Dense,
    /// `B K⁻¹ Bᵀ` by solves with the factor.
    Solves,
    /// The displacements by multigrid.
    Multigrid,
}

/// Settings of a solve; the defaults need no tuning.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Every entry of the certificate is to be at most this; useful from 1e-3 to about 1e-12.
    pub tolerance: f64,
    /// Newton steps, or a fifth of the multigrid cycles.
    pub max_iterations: usize,
    /// Factor or multigrid.
    pub path: SolverPath,
    /// Bytes the factor or the multigrid hierarchy may take; `None` sets no limit.
    pub memory_limit: Option<u64>,
    /// Multipliers to start from, length `3m`, newton; zero if `None`. For a factor, which [`SolverPath::Auto`] takes then;
    /// with both starts it takes the faster path.
    pub start: Option<Vec<f64>>,
    /// Displacements to start from, length `n`, length; zero if `None`. For multigrid, which [`SolverPath::Auto`] takes then. With
    /// `start` beside them a factor takes from them where the bodies are that contact alone holds.
    pub start_displacement: Option<Vec<f64>>,
    /// Ends the solve: with [`Status::Interrupted`] if the iteration has begun, otherwise with [`Error::interrupted`].
    pub stop: Stop,
}

impl Settings {
    /// Checks the tolerance and the starts for use with `problem`.
    ///
    /// # Errors
    /// If the tolerance is not a positive number, or a start has another length than the problem needs, holds values that are
    /// not finite, or is none for the path asked for.
    pub fn validate(&self, problem: &ContactProblem) -> Result<(), Error> {
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            let what = format!("`tolerance` is {}", self.tolerance);
            return Err(Error::new("settings", what, "give a positive number, such as 1e-8"));
        }
        let by_multigrid = self.path == SolverPath::Multigrid;
        if by_multigrid && self.start.is_some() {
            let what = "`start` holds multipliers, and multigrid starts from displacements";
            return Err(Error::new("settings", what, "give `start_displacement` instead, or leave `path` at auto"));
        }
        let no_multipliers = self.start_displacement.is_some() && self.start.is_none();
        if !by_multigrid && self.path != SolverPath::Auto && no_multipliers {
            let what = "`start_displacement` is for multigrid, and a factor starts from multipliers";
            return Err(Error::new("settings", what, "give `start` instead, or leave `path` at auto"));
        }
        let (n, m) = (problem.unknowns(), problem.points());
        for (name, list, length) in [("start", &self.start, 3 * m), ("start_displacement", &self.start_displacement, n)]
        {
            let Some(list) = list else { continue };
            if list.len() != length {
                let what = format!("`{name}` has {} numbers where {length} are needed", list.len());
                return Err(Error::new(
                    "settings",
                    what,
                    "give [lambda_n; lambda_t1; lambda_t2] (3m) or u (n), or None",
                ));
            }
            if let Some(i) = list.iter().position(|x| !x.is_finite()) {
                return Err(Error::new("settings", format!("`{name}`[{i}] is {}", list[i]), "give finite numbers"));
            }
        }
        Ok(())
    }
}

impl Default for Settings {
    fn default() -> Self {
        let (start, start_displacement) = (None, None);
        Settings {
            tolerance: 1e-8,
            max_iterations: 200,
            path: SolverPath::Auto,
            memory_limit: None,
            start,
            start_displacement,
            stop: Stop::never(),
        }
    }
}

/// How the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The certificate passes.
    Solved,
    /// The limit of iterations was reached.
    MaxIterations,
    /// No method gains on the residual any more.
    Stalled,
    /// No contact forces balance the loads on a body that floats: it moves away
    /// ([`no_equilibrium`](crate::contact::equilibrium::no_equilibrium) finds the motion). What is returned is no equilibrium.
    NoEquilibrium,
    /// The method has converged by its own rule, but the certificate does not pass.
    Uncertified,
    /// Surfaces between which contact is named pass through each other where no contact point is. No solver ends so: a
    /// [`ContactProblem`](crate::contact::ContactProblem) knows its points alone.
    PassesThrough,
    /// The observer or [`Settings::stop`] asked to stop.
    Interrupted,
}

/// How an iteration ended by its own rule, before the certificate judges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The residual is at most its target.
    Converged,
    /// At the limit of iterations, or of steps within them.
    Limit,
    /// Nothing gains on the residual any more, by rounding or because the active sets cycle, or a matrix was singular.
    Stalled,
    /// The observer or [`Settings::stop`] asked to stop.
    Interrupted,
}

impl End {
    /// The status of a solution whose certificate has passed or not.
    pub(super) fn status(self, passed: bool) -> Status {
        match self {
            End::Interrupted => Status::Interrupted,
            _ if passed => Status::Solved,
            End::Limit => Status::MaxIterations,
            End::Stalled | End::Converged => Status::Stalled,
        }
    }
}

/// What the solver is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Newton's method on the law itself.
    Newton,
    /// Projected gradients with frozen bounds: after a stall, or as a method of its own.
    Gradient,
    /// Newton's method with the bounds of friction frozen (one step of the fixed point), after repeated stalls; or a
    /// step of one of the methods that are fixed points.
    FixedPoint,
    /// The proximal method of multipliers on a convex problem, after repeated stalls.
    Proximal,
    /// Uzawa's method on the copies of the multipliers, one a square.
    Uzawa,
    /// Multigrid cycles on the displacements.
    Multigrid,
}

/// What the observer receives at every iteration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// What the solver is doing.
    pub phase: Phase,
    /// Number of the iteration.
    pub iteration: usize,
    /// Norm of the residual over the norm of the multipliers; with multigrid over that of the load.
    pub residual: f64,
    /// Products with `Q` so far; with multigrid, products with `K`.
    pub products: usize,
    /// Points that are open.
    pub open: usize,
    /// Points that stick.
    pub stick: usize,
    /// Points that slip.
    pub slip: usize,
}

/// What the solve cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Newton steps, those of the fixed point included.
    pub newton_steps: usize,
    /// Times a stall was answered by gradient steps.
    pub restarts: usize,
    /// Outer steps of the fixed point.
    pub fixed_point_steps: usize,
    /// Products with `Q`.
    pub products: usize,
    /// Solves with the whole of `K`.
    pub solves: usize,
    /// Multigrid cycles.
    pub cycles: usize,
}

impl Counts {
    /// Adds those of another solve.
    pub(crate) fn add(&mut self, other: &Counts) {
        self.newton_steps += other.newton_steps;
        self.restarts += other.restarts;
        self.fixed_point_steps += other.fixed_point_steps;
        self.products += other.products;
        self.solves += other.solves;
        self.cycles += other.cycles;
    }
}

/// A solution with its certificate.
#[derive(Debug, Clone)]
pub struct Solution {
    /// How the iteration ended.
    pub status: Status,
    /// The way it was found.
    pub path: SolverPath,
    /// Displacements, length `n`.
    pub u: Vec<f64>,
    /// Multipliers `[lambda_n; lambda_t1; lambda_t2]`, newton, `3m`; admissible to the last digit.
    pub lambda: Vec<f64>,
    /// The state of each point, `m`.
    pub states: Vec<PointState>,
    /// How far the answer is from a solution.
    pub certificate: Certificate,
    /// What it cost.
    pub counts: Counts,
    /// The progress at every iteration.
    pub history: Vec<Progress>,
}

impl Solution {
    /// Whether nothing acts on a problem, neither loads nor overlaps: forces that have to vanish leave an iteration no scale to end at.
    pub(crate) fn nothing_acts(problem: &ContactProblem) -> bool {
        problem.elastic.f.iter().all(|&f| f == 0.0) && problem.contact.gap.iter().all(|&gap| gap >= 0.0)
    }

    /// Whether, in addition, the states of points without force are known: those with strength hold or not by what came before.
    pub(crate) fn may_rest(problem: &ContactProblem) -> bool {
        Solution::nothing_acts(problem) && problem.contact.friction.iter().all(|law| law.strength() == [0.0; 2])
    }

    /// Neither displacements nor forces, of so many unknowns and the points with these laws, as `certificate` judges it; `None` if it is
    /// no answer.
    pub(crate) fn at_rest(
        (unknowns, laws): (usize, &[Friction]),
        path: SolverPath,
        certificate: &dyn Fn(&[f64], &[f64]) -> Certificate,
    ) -> Option<Solution> {
        let (u, lambda) = (vec![0.0; unknowns], vec![0.0; 3 * laws.len()]);
        let certificate = certificate(&u, &lambda);
        let state = |law: &Friction| if *law == Friction::Bonded { PointState::Stick } else { PointState::Open };
        let states = laws.iter().map(state).collect();
        let (status, counts, history) = (Status::Solved, Counts::default(), Vec::new());
        certificate.passed.then_some(Solution { status, path, u, lambda, states, certificate, counts, history })
    }
}
