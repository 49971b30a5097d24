use serde::{Deserialize, Serialize};

use super::squares::Coupling;
use crate::friction::{End, PointState};
use crate::qp::MprgpSettings;

/// How contact with friction is solved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Method {
    /// Newton's method on the law itself, with its fallbacks: [`crate::friction::solve`]. Needs no tuning.
    #[default]
    Newton,
    /// Given friction.
    Given(Given),
    /// The fixed point `g -> F lambda_n(g)` for Coulomb friction, every problem with given friction solved.
    #[doc(alias = "MSA1")]
    FixedPoint(Given),
    /// The same with one Uzawa step for each change of the bounds `g`; not for [`Given::Discs`].
    #[doc(alias("MSA2", "CFS1", "CFS2"))]
    InexactFixedPoint(Given),
}

/// How a problem with given friction is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Given {
    /// Squares: Uzawa's method on the augmented Lagrangian, minimised as given here.
    #[doc(alias("ALG1", "ALG2"))]
    Uzawa(Minimization),
    /// Squares: the same with the accuracy of each minimisation following the disagreement of the copies.
    #[doc(alias("SMALBE", "SMALSE"))]
    AdaptiveUzawa,
    /// The discs themselves.
    Discs,
}

/// How the augmented Lagrangian is minimised over the copies in Step 1: as a whole, or block after block
/// (Gauss-Seidel).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Minimization {
    /// How many copies of the multipliers change at a time.
    pub copies: CopiesAtOnce,
    /// Whether normal and tangential multipliers are minimised apart.
    pub splitting: Splitting,
    /// How often.
    pub sweeps: Sweeps,
}

/// Copies in one block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CopiesAtOnce {
    /// One copy after the other.
    #[doc(alias = "ALG1")]
    One,
    /// All copies together.
    #[doc(alias = "ALG2")]
    All,
}

/// Multipliers in one block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Splitting {
    /// Together.
    #[default]
    No,
    /// The normal ones, then the tangential ones.
    Partial,
    /// The normal, the first tangential, the second tangential ones.
    Complete,
}

/// Passes over the blocks in one Step 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sweeps {
    /// Until the multipliers change no more.
    #[doc(alias = "Variant 1")]
    UntilConverged,
    /// Once.
    #[default]
    #[doc(alias = "Variant 2")]
    One,
}

impl Given {
    /// The source paper's ALG1; variant 1 sweeps until converged, variant 2 once.
    pub const fn alg1(sweeps: Sweeps, splitting: Splitting) -> Given {
        Given::Uzawa(Minimization { copies: CopiesAtOnce::One, splitting, sweeps })
    }

    /// The source paper's ALG2. A splitting, which the paper announces, sweeps until converged.
    pub const fn alg2(splitting: Splitting) -> Given {
        Given::Uzawa(Minimization { copies: CopiesAtOnce::All, splitting, sweeps: Sweeps::UntilConverged })
    }
}

impl Method {
    /// The source paper's CFS1: MSA2 with ALG1, variant 2.
    pub const fn cfs1(splitting: Splitting) -> Method {
        Method::InexactFixedPoint(Given::alg1(Sweeps::One, splitting))
    }

    /// The source paper's CFS2: MSA2 with ALG2.
    pub const fn cfs2() -> Method {
        Method::InexactFixedPoint(Given::alg2(Splitting::No))
    }

    /// The method of the problems with given friction; `None` for Newton's.
    pub fn given(&self) -> Option<Given> {
        match *self {
            Method::Newton => None,
            Method::Given(given) | Method::FixedPoint(given) | Method::InexactFixedPoint(given) => Some(given),
        }
    }
}

/// `rho` of the augmented Lagrangian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Penalty {
    /// Length per newton.
    Absolute(f64),
    /// Times the largest eigenvalue of `Q`.
    Scaled(f64),
}

/// Settings of the methods with squares and of the fixed point; Newton's method uses none of them.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSettings {
    /// The method.
    pub method: Method,
    /// Squares `N` around each disc of friction; at least one.
    pub squares: usize,
    /// How the squares are tied to one another.
    pub coupling: Coupling,
    /// How the penalty is chosen.
    pub penalty: Penalty,
    /// `tol` of `|w_l - w_(l-1)| <= tol |w_l|` for given friction (6.1) and of `|g_k - g_(k-1)| <= tol |g_k|` for the
    /// fixed point (6.3). The adaptive method and the discs hold the projected gradient, over the norm of the load,
    /// and the disagreement of the copies, over their length, against it.
    pub tolerance: f64,
    /// Given friction also ends where `|C lambda| <= agreement |lambda|`; zero leaves the source paper's rule alone,
    /// which never holds where all points stick and `w` vanishes.
    pub agreement: f64,
    /// Each quadratic program is solved until the norm of its projected gradient is at most this times that of its
    /// right-hand side.
    pub inner_tolerance: f64,
    /// Sweeps over the blocks end where they change the copies by at most this times their length.
    pub sweep_tolerance: f64,
    /// Changes of the multipliers `w` (executions of Step 2), for the discs iterations of the quadratic program, all
    /// together.
    pub max_iterations: usize,
    /// Steps of the quadratic programs of all kinds, all together.
    pub max_cg_steps: usize,
    /// Of the quadratic programs over boxes.
    pub bounds: MprgpSettings,
    /// Whether faces are preconditioned by the blocks of the points, which takes out what a large `rho` does.
    pub precondition: bool,
    /// Where the method starts.
    pub start: Start,
}

/// Where to start; what is `None` starts from zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Start {
    /// Bounds `g` of the fixed point, newton, `m`; only those of points with Coulomb friction are used.
    pub slip_bound: Option<Vec<f64>>,
    /// Multipliers `w` of the agreement, length, `3m(N - 1)`; none for the discs.
    pub w: Option<Vec<f64>>,
    /// Multipliers every copy starts from, newton, `3m`.
    pub lambda: Option<Vec<f64>>,
}

impl MethodSettings {
    /// For use: two squares coupled as a star, `rho` in units of `Q`.
    pub fn new(method: Method) -> Self {
        let one_by_one = |given| matches!(given, Given::Uzawa(Minimization { copies: CopiesAtOnce::One, .. }));
        MethodSettings {
            method,
            squares: 2,
            coupling: Coupling::Star,
            penalty: Penalty::Scaled(if method.given().is_some_and(one_by_one) { PENALTY_ONE } else { PENALTY_ALL }),
            tolerance: 1e-8,
            agreement: 1e-8,
            inner_tolerance: 1e-10,
            sweep_tolerance: 1e-9,
            max_iterations: 10_000,
            max_cg_steps: usize::MAX,
            bounds: MprgpSettings::default(),
            precondition: true,
            start: Start::default(),
        }
    }

    /// As in the source paper: the printed coupling, its stopping rules with `tol = 1e-6`, `rho` absolute. The
    /// accuracy of the quadratic programs is not printed there.
    pub fn published(method: Method, squares: usize, rho: f64) -> Self {
        MethodSettings {
            squares,
            coupling: Coupling::Chain,
            penalty: Penalty::Absolute(rho),
            tolerance: 1e-6,
            agreement: 0.0,
            inner_tolerance: 1e-8,
            sweep_tolerance: 1e-6,
            precondition: false,
            ..MethodSettings::new(method)
        }
    }
}

/// Penalties over the largest eigenvalue of `Q`, measured on the source paper's brick: where copies take turns a
/// larger one ties each to its neighbours, where they move together a smaller one only costs steps of Uzawa's method.
const PENALTY_ONE: f64 = 0.01;
const PENALTY_ALL: f64 = 2.0;

/// One change of the multipliers `w` or, for the discs, one projected step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodStep {
    /// Executions of Step 2 so far.
    pub iteration: usize,
    /// Changes of the bounds `g` so far.
    pub fixed_point_step: usize,
    /// What the method holds against its tolerance.
    pub change: f64,
    /// `|C lambda| / |lambda|`.
    pub disagreement: f64,
    /// Steps of the quadratic programs of all kinds so far.
    pub steps: usize,
    /// Products with `Q` so far.
    pub products: usize,
    /// Points with no normal force in any copy, with friction below its bounds in all, and the others.
    pub open: usize,
    /// Points that stick.
    pub stick: usize,
    /// Points that slip.
    pub slip: usize,
}

/// What a method cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MethodCounts {
    /// Executions of Step 2 ("Iter" of the source paper); for the discs iterations of the quadratic program.
    pub iterations: usize,
    /// Changes of the bounds `g`.
    pub fixed_point_steps: usize,
    /// Passes over one copy, or over all of them where they are one block ("QPPs").
    pub qp_problems: usize,
    /// Passes whose quadratic program ended short of its tolerance.
    pub short_problems: usize,
    /// Steps of conjugate gradients within their face.
    pub cg_steps: usize,
    /// Steps of conjugate gradients that met a bound.
    pub expansions: usize,
    /// Steps that left a bound; for the discs projected gradient steps.
    pub proportionings: usize,
    /// Products with `Q` or a block of it; a product of all `N` copies counts `N`.
    pub products: usize,
    /// Floating-point operations: `2 r c` for a block of `r` rows and `c` columns of a stored `Q`, the work on vectors
    /// and that of the coupling; without the making of `Q` and preconditioners.
    pub flops: f64,
}

impl MethodCounts {
    pub(super) fn add(&mut self, more: &MethodCounts) {
        self.iterations += more.iterations;
        self.fixed_point_steps += more.fixed_point_steps;
        self.qp_problems += more.qp_problems;
        self.short_problems += more.short_problems;
        self.cg_steps += more.cg_steps;
        self.expansions += more.expansions;
        self.proportionings += more.proportionings;
        self.products += more.products;
        self.flops += more.flops;
    }

    /// Steps of the quadratic programs of all kinds.
    pub fn steps(&self) -> usize {
        self.cg_steps + self.expansions + self.proportionings
    }
}

/// Where a method ended and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodReport {
    /// How the method ended.
    pub end: End,
    /// The mean of the copies, newton, `3m`.
    pub lambda: Vec<f64>,
    /// The bounds `g` of the last step at points with Coulomb or given friction, newton, `m`.
    pub slip_bound: Vec<f64>,
    /// The copies in the axes of the problem, newton, `3mN`.
    pub copies: Vec<f64>,
    /// Multipliers of the agreement in the axes of the problem, length, `3m(N - 1)`.
    pub w: Vec<f64>,
    /// Open, sticking or slipping, from the bounds the copies meet; empty for the discs.
    pub states: Vec<PointState>,
    /// `rho`, length per newton.
    pub penalty: f64,
    /// `|C lambda| / |lambda|`.
    pub disagreement: f64,
    /// What it cost.
    pub counts: MethodCounts,
    /// Its steps.
    pub history: Vec<MethodStep>,
}
