//! Keys of `[solver]`.

use super::super::kind::{ANY, Kind, Limits, POSITIVE, Rules, choice, key};

pub(super) static SOLVER: Rules = Rules {
    doc: "Settings of the solver.",
    one_of: &[],
    keys: &[
        key(
            "tolerance",
            Kind::Number(TOLERANCE),
            "tolerance = 1e-8",
            "What every number of the certificate is held against.",
        )
        .default("1e-8"),
        key(
            "max_iterations",
            Kind::Whole { from: 1, to: 1_000_000 },
            "max_iterations = 200",
            "Most outer iterations; 200 if absent, for methods other than \"newton\" 10000.",
        ),
        key("method", METHOD, "method = \"newton\"", "How the case is solved; the default needs no tuning.")
            .default("\"newton\""),
        key(
            "inner",
            INNER,
            "inner = \"alg2\"",
            "For msa1 and msa2: what solves the problems with given friction (\"alg2\" if absent; \"discs\" only for msa1).",
        ),
        key(
            "variant",
            Kind::Whole { from: 1, to: 2 },
            "variant = 2",
            "For alg1: 1 sweeps over the copies until they rest, 2 sweeps once a step; if absent, 1 for alg1 and msa1, 2 for msa2.",
        ),
        key(
            "splitting",
            SPLITTING,
            "splitting = \"complete\"",
            "For alg1, alg2 and cfs1: how the multipliers are split by Gauss-Seidel.",
        )
        .default("\"no\""),
        key(
            "squares",
            Kind::Whole { from: 1, to: 1000 },
            "squares = 4",
            "For methods with squares: how many, turned against one another, stand for the disc of friction.",
        )
        .default("2"),
        key(
            "coupling",
            COUPLING,
            "coupling = \"star\"",
            "For methods with squares: which copies of the multipliers are compared.",
        )
        .default("\"star\""),
        key(
            "rho",
            Kind::Number(POSITIVE),
            "rho = 1e-8",
            "For methods with squares: the penalty on the disagreement of the copies.",
        )
        .unit("length/force"),
        key(
            "rho_factor",
            Kind::Number(POSITIVE),
            "rho_factor = 2",
            "The same over the largest eigenvalue of B K⁻¹ Bᵀ; 0.01 for alg1 and cfs1, else 2, if absent.",
        ),
        key(
            "inner_tolerance",
            Kind::Number(TOLERANCE),
            "inner_tolerance = 1e-10",
            "For alg1, alg2, cfs1 and cfs2: accuracy of each quadratic program; a hundredth of `tolerance` if absent.",
        ),
        key(
            "memory",
            Kind::Number(POSITIVE),
            "memory = 8",
            "Most memory for stored matrices; what is there if absent.",
        )
        .unit("gigabyte"),
        key(
            "starts",
            Kind::Whole { from: 1, to: 10_000 },
            "starts = 8",
            "Looks for further solutions from so many starts, the default one included, and estimates uniqueness by multigrid too.",
        ),
        key("path", PATH, "path = \"auto\"", "How Newton's method gets at the solution.").default("\"auto\""),
    ],
};

const TOLERANCE: Limits = Limits { low: 1e-14, low_included: true, high: 0.1, high_included: true, ..ANY };
const METHOD: Kind = choice(&[
    ("newton", "Newton's method on the law itself"),
    ("alg1", "given friction: squares one by one"),
    ("alg2", "given friction: all squares in one quadratic program"),
    ("smalbe", "given friction: the same with adaptive accuracy"),
    ("discs", "given friction: the discs themselves"),
    ("msa1", "Coulomb: successive approximations"),
    ("msa2", "Coulomb: the same with inexact inner problems"),
    ("cfs1", "msa2 with alg1"),
    ("cfs2", "msa2 with alg2"),
]);
const INNER: Kind = choice(&[
    ("alg1", "squares one by one"),
    ("alg2", "all squares in one quadratic program"),
    ("smalbe", "the same with adaptive accuracy"),
    ("discs", "the discs themselves"),
]);
const SPLITTING: Kind = choice(&[
    ("no", "all at once"),
    ("partial", "normal, then tangential"),
    ("complete", "normal, first tangential, second tangential"),
]);
const COUPLING: Kind =
    choice(&[("star", "each with the first"), ("chain", "each with the next, as printed in the source paper")]);
const PATH: Kind = choice(&[
    ("auto", "the cheaper one that fits the memory"),
    ("dense", "B K⁻¹ Bᵀ as a dense factor"),
    ("solves", "B K⁻¹ Bᵀ by triangular solves"),
    ("multigrid", "the displacements themselves, without a factor"),
]);
