//! What is weak beside what is strong: each body and each pair is judged by its own forces, and solved to them.

use stiction::certificate::{PART_TOLERANCE, Part, certify};
use stiction::contact::{ContactProblem, Friction, Pair};
use stiction::friction::{PointState, Settings, Status};
use stiction::linalg::{Csr, SymmetricCsr};
use stiction::{SolverPath, solve};
use stiction_fixtures::*;

const TOLERANCE: f64 = 1e-8;
const SPRING: f64 = 1000.0;
const COEFFICIENT: f64 = 0.3;
/// Forces that press the two nodes on the plane.
const PRESS: [f64; 2] = [1e5, 1e-4];

/// Two nodes on springs above the plane z = 0, a pair each, which a spring between them may couple; `along` over what
/// presses them is what pulls them.
fn two_nodes(along: f64, coupling: f64) -> ContactProblem {
    let entry = |i: usize| [(i, i, SPRING + coupling), (i, (i + 3) % 6, -coupling)];
    let k: Vec<_> = (0..6).flat_map(entry).collect();
    let k = SymmetricCsr::from_full(&Csr::from_triplets(6, 6, &k), "K").unwrap();
    let b = [(0, 2, -1.0), (1, 5, -1.0), (2, 0, 1.0), (3, 3, 1.0), (4, 1, 1.0), (5, 4, 1.0)];
    let f = PRESS.iter().flat_map(|press| [along * press, 0.0, -press]).collect();
    let law = Friction::Coulomb { coefficient: COEFFICIENT };
    let mut p = ContactProblem::from_matrices(k, f, Csr::from_triplets(6, 6, &b), vec![0.0; 2], vec![law; 2]);
    p.elastic.node_of = Some(vec![0, 0, 0, 1, 1, 1]);
    p.labels.pairs = vec![Pair { name: "strong".into(), points: 0..1 }, Pair { name: "weak".into(), points: 1..2 }];
    p
}

#[test]
fn a_weak_pair_with_wrong_forces_is_refused_by_its_name() {
    for coupling in [0.0, 500.0] {
        let p = two_nodes(0.2, coupling);
        // Both stick, so that nothing moves and the forces are the loads.
        let u = [0.0; 6];
        let lambda = [PRESS[0], PRESS[1], 0.2 * PRESS[0], 0.2 * PRESS[1], 0.0, 0.0];
        let c = certify(&p, &u, &lambda, TOLERANCE);
        assert!(c.passed, "{c:?}");
        for part in [1e-5, -1e-5] {
            for i in [1, 3, 5] {
                let mut wrong = lambda;
                wrong[i] += part * PRESS[1];
                let c = certify(&p, &u, &wrong, TOLERANCE);
                // By the largest forces nothing is wrong.
                assert!(c.worst < TOLERANCE && !c.passed, "{i} {c:?}");
            }
            for i in 3..6 {
                let mut wrong = u;
                wrong[i] += part * PRESS[1] / SPRING;
                let c = certify(&p, &wrong, &lambda, TOLERANCE);
                assert!(c.worst < TOLERANCE && !c.passed, "{i} {c:?}");
                let weak = c.parts.iter().find(|measure| measure.part == Part::Pair && measure.name == "weak").unwrap();
                assert!(weak.residual > PART_TOLERANCE, "{i} {weak:?}");
            }
        }
    }
}

/// All forces balance and the weak pair has none: its node lies in the plane by what its spring takes instead.
#[test]
fn a_weak_pair_that_is_open_by_mistake_is_refused() {
    let p = two_nodes(0.0, 0.0);
    let mut u = [0.0; 6];
    u[5] = -PRESS[1] / SPRING;
    let c = certify(&p, &u, &[PRESS[0], 0.0, 0.0, 0.0, 0.0, 0.0], TOLERANCE);
    assert!(c.worst < TOLERANCE && !c.passed, "{c:?}");
    assert!(c.worst_part().is_some_and(|part| part.part == Part::Pair && part.name == "weak"), "{c:?}");
}

#[test]
fn both_paths_reach_the_forces_of_a_weak_pair() {
    for along in [0.2, 0.4] {
        let p = two_nodes(along, 0.0);
        let friction = COEFFICIENT.min(along);
        for path in [SolverPath::Dense, SolverPath::Solves, SolverPath::Multigrid] {
            let s = solve(&p, &Settings { path, ..Settings::default() }).unwrap();
            assert_eq!(s.status, Status::Solved, "{path:?} {:?}", s.certificate);
            for (j, press) in PRESS.into_iter().enumerate() {
                let (normal, tangential, slip) = (s.lambda[j], s.lambda[2 + j], s.u[3 * j]);
                assert!((normal - press).abs() <= 1e-6 * press, "{path:?} {j} {normal}");
                assert!((tangential - friction * press).abs() <= 1e-6 * press, "{path:?} {j} {tangential}");
                let wanted = (along - friction) * press / SPRING;
                assert!((slip - wanted).abs() <= 1e-6 * press / SPRING, "{path:?} {j} {slip}");
            }
        }
    }
}

/// A block pressed by 1e-6 on a plane, beside one that a prescribed displacement presses 1e8 times as much: the forces
/// of the first are those that it has alone.
#[test]
fn a_weak_pair_has_the_forces_it_has_alone() {
    const STRONG: &str = r#"
[[fix]]
on = "a.z-max"
value = [5e-3, 0, -1e-2]
[[contact]]
name = "strong"
on = "a.z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 0.3 }
[mesh.parts.a]
block = { size = [20, 20, 10], cells = [4, 4, 2], element = "hex8" }
"#;
    const WEAK: &str = r#"
[mesh.parts.b]
block = { size = [20, 20, 10], cells = [4, 4, 2], element = "hex8", origin = [100, 0, 0] }
[materials.s]
young = 210e3
poisson = 0.3
[[load]]
on = "b.z-max"
pressure = 1e-6
[[load]]
on = "b.z-max"
traction = [2e-7, 0, 0]
[[contact]]
name = "weak"
on = "b.z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 0.3 }
"#;
    for path in ["dense", "multigrid"] {
        let solver = format!("[solver]\npath = \"{path}\"\n");
        let alone = case_run::solved(&format!("{WEAK}{solver}")).0.solution;
        let (outcome, prepared) = case_run::solved(&format!("{WEAK}{STRONG}{solver}"));
        let both = &outcome.solution;
        let problem = &prepared.problem;
        let pair = problem.labels.pairs.iter().find(|pair| pair.name == "weak").unwrap();
        let beside: Vec<f64> =
            (0..3).flat_map(|c| both.lambda[c * problem.points()..][pair.points.clone()].to_vec()).collect();
        assert!(distance(&beside, &alone.lambda) < 1e-5, "{path}: {}", distance(&beside, &alone.lambda));
        assert_eq!(both.states[pair.points.clone()], alone.states[..], "{path}");
        let weak = both.certificate.parts.iter().filter(|part| part.name == "weak").map(|part| part.residual);
        assert!(weak.clone().count() == 1 && weak.fold(0.0, f64::max) <= PART_TOLERANCE, "{path}");
    }
}

/// Of two blocks far apart one has no load and rests: it is at zero whatever the other does, and what iteration leaves
/// there is not counted in its own forces, which are none.
#[test]
fn a_body_without_any_force_is_not_judged_by_its_own() {
    let text = |other: &str| {
        format!(
            r#"
[mesh.parts.high]
block = {{ size = [1, 1, 1], cells = [6, 6, 6], element = "hex8" }}
{other}[materials.steel]
young = 2e11
poisson = 0.3
[[fix]]
on = "high.z-max"
[[load]]
on = "high.x-min"
traction = [1e5, 1e5, 0]
[solver]
path = "multigrid"
"#
        )
    };
    let other = "[mesh.parts.low]\nblock = { size = [1, 1, 1], cells = [5, 5, 5], element = \"hex8\" }\n\
                 move = [0, 0, -2]\n[[fix]]\non = \"low.z-min\"\n[[contact]]\non = \"high.z-min\"\n\
                 against = \"low.z-max\"\nsearch = 2\nfriction = \"none\"\n";
    let alone = case_run::solved(&text(
        "[[contact]]\non = \"high.z-min\"\nagainst = { plane = { point = [0, 0, -1], normal = [0, 0, 1] } }\nfriction = \"none\"\n",
    ))
    .0
    .solution;
    let both = case_run::solved(&text(other)).0.solution;
    assert!(both.states.iter().all(|s| *s == PointState::Open));
    // Displacements relative to the other body take a few more.
    assert!(both.counts.cycles <= 2 * alone.counts.cycles, "{:?} {:?}", both.counts, alone.counts);
}
