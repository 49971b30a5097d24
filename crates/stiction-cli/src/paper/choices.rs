//! What the paper leaves open, and what was chosen after seeing its numbers.

use super::experiment::Family;
use super::model::SLIP_BOUND;
use stiction::friction::Coupling;

/// Fits, by name, with their reasons.
pub const FITTED: [(&str, &str); 7] = [
    (
        "loads times 4",
        "With the tractions as printed no reading of g = 5.25e4 (nodal force, or stress times nodal area) gives the \
         paper's tables 1 to 7; as a nodal force with loads 4 to 4.3 times as large both partitions fit. Equivalent: g \
         = 13125 with the printed loads. The factor's origin is unknown. The columns \"as printed\" use the printed \
         loads, those with \"loads 4.29\" the other end of the range.",
    ),
    (
        "factors on the penalty rho",
        "ALG1 as printed (1e-10), ALG2 times 0.5 on partition 1 and times 1 on partition 2, CFS1 and CFS2 times 0.7. No \
         reason is known.",
    ),
    (
        "start of the fixed point",
        "g(0) = 5.25e4 at every node (with the loads times 4); the paper does not say where it starts. The columns \"as \
         printed\" start from g(0) = 0.",
    ),
    (
        "coupling of the copies",
        "The paper prints rows lambda_i - lambda_(i+1) (chain). For N = 4 and 6 rows lambda_1 - lambda_i (star) come \
         closer to its counts for ALG2 and CFS2. Both are reported; they are the same at N = 2. ALG1 and CFS1 take the \
         chain.",
    ),
    (
        "parity of the tetrahedra",
        "Cubes can be cut into five tetrahedra in two alternating ways; the text does not say which. Parity 0 is judged, \
         parity 1 reported beside it in tables 1, 3 and 9.",
    ),
    (
        "precision of the inner problems",
        "The paper calls it adaptive and gives no number. Each quadratic program is solved until its projected gradient \
         is at most 1e-8 of its right-hand side where friction is given and 1e-7 where it is Coulomb's; sweeps of \
         variant 1 end where they change the copies by at most 1e-5 of their length.",
    ),
    (
        "what a Cg step is",
        "Steps of conjugate gradients within a face are counted, expansions and proportionings are not (the CSV files \
         have their numbers). The solver is MPRGP without preconditioner; \"preconditioned\" is this project's own choice.",
    ),
];

/// What the column `Eff (%)` counts, see [`stiction::friction::MethodCounts::flops`], and where runs are stopped.
pub const READING: &str = "Eff (%) compares counted floating-point operations: two for each entry of the block of Q in \
     a product, and the work on vectors; forming Q is not counted. How the paper counted in 2003 is not known, so that it \
     is reported without a band, as are QPPs, Prec and Cont. ALG2 is stopped after 100 iterations, as in the paper, other \
     methods after 5000; a run that has used 10 000 products is given up and shows a dash.";

/// Inner tolerances, relative to the right-hand side, and that of sweeps: see [`FITTED`].
pub const INNER_GIVEN: f64 = 1e-8;
pub const INNER_COULOMB: f64 = 1e-7;
pub const SWEEP: f64 = 1e-5;
/// Stopping rules (6.1) and (6.3) of the paper.
pub const OUTER: f64 = 1e-6;
/// Penalty of ALG1 and CFS1, length per newton (section 6.1 of the paper).
pub const ALG1_RHO: f64 = 1e-10;
/// Relative tolerance of reference solutions.
pub const SHARP: f64 = 1e-12;
/// Executions of Step 2 after which the paper stopped ALG2, as its tables show.
pub const ALG2_LIMIT: usize = 100;
/// Executions of Step 2 of the other methods at most; the longest published run has 2333.
pub const LONGEST: usize = 5000;
/// Steps of all kinds after which a run of ALG2 or CFS2 is given up. The paper had such a limit without saying which;
/// its longest run that ended has 6538.
pub const STEP_LIMIT: usize = 10_000;

/// One way to fill in what the paper leaves open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    pub name: &'static str,
    /// Factor on the printed tractions.
    pub load: f64,
    pub parity: u8,
    pub coupling: Coupling,
    /// Whether `rho` takes the fitted factors.
    pub fitted_rho: bool,
    pub preconditioned: bool,
    /// Start of the fixed point at every node, newton.
    pub start: f64,
    /// Whether bands apply.
    pub judged: bool,
}

/// The fits.
pub const FIT: Setting = Setting {
    name: "fitted",
    load: 4.0,
    parity: 0,
    coupling: Coupling::Star,
    fitted_rho: true,
    preconditioned: false,
    start: SLIP_BOUND,
    judged: true,
};
/// The fits with the printed coupling, which is another one for more than two squares.
pub const FIT_CHAIN: Setting = Setting { name: "chain", coupling: Coupling::Chain, judged: false, ..FIT };
pub const FIT_PARITY: Setting = Setting { name: "parity 1", parity: 1, judged: false, ..FIT };
/// The other end of the range of loads that fit.
pub const FIT_LOAD: Setting = Setting { name: "loads 4.29", load: 4.29, judged: false, ..FIT };
/// Faces preconditioned by the blocks of the points: not the paper's solver but ours.
pub const PRECONDITIONED: Setting = Setting { name: "preconditioned", preconditioned: true, judged: false, ..FIT };
pub const PRINTED: Setting = Setting {
    name: "as printed",
    load: 1.0,
    parity: 0,
    coupling: Coupling::Chain,
    fitted_rho: false,
    preconditioned: false,
    start: 0.0,
    judged: false,
};

impl Setting {
    /// The factor on the penalty of a method.
    pub fn rho_factor(self, family: Family, partition: u8) -> f64 {
        match family {
            _ if !self.fitted_rho => 1.0,
            Family::Alg1 => 1.0,
            Family::Alg2 if partition == 1 => 0.5,
            Family::Alg2 => 1.0,
            Family::Cfs1 | Family::Cfs2 => 0.7,
        }
    }
}
