//! A case on several ranks against the same case on one, where the hierarchies, the order of the sums and the certificate's
//! exchange are others.

use std::ops::ControlFlow;
use std::sync::Arc;

use stiction::certificate::{Certificate, certify, certify_divided};
use stiction::contact::Division;
use stiction::friction::SolverPath;
use stiction::io::case::{self, Case};
use stiction::mesh::{Cuts, WeightedNode};
use stiction::ranks::{Alone, Counted, Ranks, threads};
use stiction::run::{Keep, Outcome, Prepared, Summary, solve_on_ranks, solve_steps_on_ranks, totals};
use stiction::{Error, Status};
use stiction_fixtures::case_run::{displacement, solved_case};
use stiction_fixtures::random_case;

const STEEL: &str = "[materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n";

/// The brick of Haslinger, Kučera & Dostál (2004), pressed at one end and lifted at the other.
fn brick(element: &str, friction: &str) -> String {
    format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [48, 16, 16], {element} }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[load]]\non = \"x-max\"\ntraction = [0, 0, 1e6]\n\
         [[load]]\non = \"z-max\"\ntraction = [0, 0, \"-2/3*1e6*(3 - x)\"]\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {friction}\n"
    )
}

/// A quarter of a block that is pushed onto a ball and slides off a wall: planes of symmetry, prescribed displacements, supports
/// of single components, two contacts, a total force and the weight.
fn on_a_ball() -> String {
    format!(
        "[mesh]\nblock = {{ size = [1, 1, 0.5], cells = [14, 14, 7], element = \"wedge6\" }}\n{STEEL}density = 7800\n\
         [[fix]]\non = \"x-min\"\ncondition = \"symmetry\"\n[[fix]]\non = \"y-min\"\ncomponents = \"y\"\n\
         [[fix]]\non = \"z-max\"\ncomponents = \"z\"\nvalue = [-2e-4]\n\
         [[load]]\non = \"y-max\"\nforce = [0, 2e6, -1e6]\n[[load]]\ngravity = [0, 0, -9.81]\n\
         [[contact]]\nname = \"ball\"\non = \"z-min\"\n\
         against = {{ sphere = {{ center = [0, 0, -2], radius = 2 }} }}\nfriction = {{ coulomb = 0.2 }}\n\
         [[contact]]\nname = \"wall\"\non = {{ box = [[1, 0, 0.2], [1, 1, 0.5]] }}\n\
         against = {{ plane = {{ point = [1.00002, 0, 0], normal = [-1, 0, 0] }} }}\nfriction = \"none\"\n"
    )
}

pub(super) fn case_of(text: &str, tolerance: &str) -> Case {
    let set = |key: &str, value: &str| (format!("solver.{key}"), value.to_string());
    case::parse(text, "case.toml", &[set("tolerance", tolerance), set("path", "\"multigrid\"")]).unwrap()
}

/// The answer of all ranks: displacements by the nodes of the whole mesh.
pub(super) fn on_ranks(case: &Case, size: usize) -> (Vec<[f64; 3]>, Summary) {
    each_with_its_own(&|_| case.clone(), size)
}

/// The same where each rank reads the case.
pub(super) fn each_with_its_own(read: &(dyn Fn(&dyn Ranks) -> Case + Sync), size: usize) -> (Vec<[f64; 3]>, Summary) {
    let parts = threads(size, |ranks| {
        let answer = solve_on_ranks(&read(&*ranks), &ranks, &mut |_| ControlFlow::Continue(())).unwrap();
        (answer.displacements(), answer.summary)
    });
    let nodes = parts[0].1.ranks.as_ref().unwrap().nodes as usize;
    let mut u = vec![[f64::NAN; 3]; nodes];
    for (part, summary) in &parts {
        // Threads share the memory of their process, which is asked at another moment by each.
        assert!(
            summary.answer.certificate == parts[0].1.answer.certificate
                && summary.answer.contact == parts[0].1.answer.contact
        );
        part.iter().for_each(|(node, d)| u[*node as usize] = *d);
    }
    let summary = parts.into_iter().next().unwrap().1;
    (u, summary)
}

/// The error of all ranks.
pub(super) fn refusal(case: &Case, size: usize, keep: Option<&Keep>) -> Error {
    let mut all = threads(size, |ranks| {
        solve_steps_on_ranks(case, &ranks, keep, &mut |_| ControlFlow::Continue(())).map(|_| ()).unwrap_err()
    });
    assert!(all.iter().all(|error| *error == all[0]) && !all[0].remedy.is_empty(), "{all:?}");
    all.swap_remove(0)
}

/// Cycles of the same case on one machine.
pub(super) fn serial_cycles(case: &Case) -> usize {
    let (outcome, _) = solved_case(case);
    assert_eq!((outcome.solution.status, outcome.solution.path), (Status::Solved, SolverPath::Multigrid));
    outcome.solution.counts.cycles
}

fn close(found: f64, expected: f64, accuracy: f64) -> bool {
    (found - expected).abs() <= accuracy * expected.abs()
}

/// Solved to 1e-10 both answers are that close to the one there is; where points between stick and slip are within the
/// tolerance their states may differ.
pub(super) fn agrees(text: &str, sizes: &[usize]) {
    agrees_case(&case_of(text, "1e-10"), sizes);
}

/// The same of a case that was read, with a tolerance of 1e-10.
pub(super) fn agrees_case(case: &Case, sizes: &[usize]) {
    are_as_on_one(case, sizes, &|size| on_ranks(case, size));
}

/// Compares the answers of so many ranks with that of one machine.
pub(super) fn are_as_on_one(case: &Case, sizes: &[usize], ranked: &dyn Fn(usize) -> (Vec<[f64; 3]>, Summary)) {
    let serial: (Outcome, Prepared) = solved_case(case);
    let expected = displacement(&serial);
    let largest = expected.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let resultants = totals(&serial.1, &serial.0);
    for &size in sizes {
        let (u, summary) = ranked(size);
        assert_eq!(summary.answer.status, Status::Solved, "{size} ranks");
        assert!(summary.answer.certificate.passed && summary.ranks.as_ref().unwrap().ranks.len() == size);
        assert_eq!(
            (summary.answer.dofs, summary.answer.dual_dofs),
            (serial.1.problem.unknowns(), 3 * serial.1.problem.points())
        );
        let differences = u.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        // `f64::max` would leave out what is not a number.
        let worst = differences.fold(0.0, |most: f64, d| if d <= most { most } else { d });
        assert!(worst <= 1e-8 * largest, "{size} ranks: {:e}", worst / largest);
        let found = &summary.answer.contact;
        assert!(close(found.normal_force, resultants.normal_force, 1e-9), "{size} ranks: {found:?} {resultants:?}");
        let friction = found.tangential_force.iter().zip(resultants.tangential_force);
        assert!(friction.clone().all(|(a, b)| (a - b).abs() <= 1e-9 * resultants.normal_force.abs()), "{size} ranks");
        assert!(close(found.max_pressure, resultants.max_pressure, 1e-6));
        assert!(close(found.max_other_pressure, resultants.max_other_pressure, 1e-6));
        assert!(close(found.max_shear, resultants.max_shear, 1e-6));
        assert!(close(found.open_area + found.stick_area + found.slip_area, area(&serial.1), 1e-9));
    }
}

/// The area that the points stand for.
fn area(prepared: &Prepared) -> f64 {
    let labels = &prepared.problem.labels;
    labels.area.iter().zip(&labels.unity_sum).map(|(area, share)| area * share).sum()
}

#[test]
fn the_brick_on_ranks_is_the_brick_on_one() {
    agrees(&brick("element = \"tet4\", split = \"six\"", "{ coulomb = 0.35 }"), &[1, 2, 3, 8]);
    agrees(&brick("element = \"hex8\"", "{ coulomb = 0.35 }"), &[2, 4, 8]);
}

#[test]
fn friction_that_is_given_limited_or_none_is_the_same_on_ranks() {
    for friction in ["{ tresca = 1.3e5 }", "\"none\"", "{ coulomb = 0.35, limit = 2e5 }", "\"bonded\""] {
        agrees(&brick("element = \"hex8\"", friction), &[4]);
    }
    agrees(&brick("element = \"hex8\"", "{ coulomb = [0.5, 0.2], direction = [1, 0.5, 0] }"), &[3]);
}

#[test]
fn symmetry_supports_of_components_and_two_obstacles_are_the_same_on_ranks() {
    agrees(&on_a_ball(), &[2, 5, 8]);
}

/// Where a support holds a part of the normal of a curved obstacle the rest of it is shorter than one.
#[test]
fn a_curved_obstacle_beside_a_support_of_one_component_is_the_same_on_ranks() {
    for element in ["hex8", "tet10"] {
        agrees(
            &format!(
                "[mesh]\nblock = {{ size = [1, 0.5, 0.3], cells = [10, 6, 4], element = \"{element}\" }}\n{STEEL}\
                 [[fix]]\non = \"x-min\"\ncomponents = \"x\"\n[[spring]]\non = \"x-min\"\nnormal = 2e10\ntangential = 5e9\n\
                 [[load]]\non = \"z-max\"\ntraction = [0, 0, -1e6]\n[[contact]]\non = \"z-min\"\n\
                 against = {{ cylinder = {{ point = [0.7, 0, -1], axis = [0, 1, 0], radius = 1 }} }}\nfriction = {{ coulomb = 0.2 }}\n"
            ),
            &[1, 2, 4],
        );
    }
}

#[test]
fn elastic_foundations_are_the_same_on_ranks() {
    let spring = "[[spring]]\non = \"z-max\"\nnormal = 2e10\ntangential = 5e9\n";
    let text = brick("element = \"hex8\"", "{ coulomb = 0.35 }").replace("[[fix]]\non = \"x-min\"\n", spring);
    assert!(text.contains(spring));
    agrees(&text, &[1, 2, 5]);
}

/// Meshes of a few hundred nodes: already the first coarse level is held by all ranks, while contact nodes remain divided.
#[test]
fn meshes_with_few_nodes_for_each_rank_are_the_same_on_ranks() {
    agrees(&random_case::text(46), &[4, 8]);
    agrees(&random_case::text(2059), &[2]);
    // Most nodes of this mesh are held.
    let refused = random_case::outcome_on_ranks(&random_case::text(185), 8).unwrap_err();
    assert!(refused.contains("too few nodes that move for 8 ranks") && refused.contains("fewer ranks"), "{refused}");
}

/// On four ranks the active sets of this mesh go round, and so does what follows.
#[test]
fn what_ranks_together_do_not_solve_rank_0_solves_alone_and_all_judge_it() {
    let case = case::parse(&random_case::text(803), "case.toml", &[]).unwrap();
    let (u, summary) = on_ranks(&case, 4);
    assert!(
        summary.found_by_first() && summary.answer.status == Status::Solved && summary.answer.certificate.passed,
        "{summary}"
    );
    assert!(summary.to_string().contains("by rank 0 alone"), "{summary}");
    assert_eq!(u, displacement(&solved_case(&case)));
}

/// A block on a slope leaves where the slope is steeper than its friction; the ranks have that from rank 0, which alone looks at statics.
#[test]
fn a_block_on_a_slope_leaves_on_ranks_as_on_one_machine() {
    let status = |coefficient: f64| {
        let text = format!(
            "[mesh]\nblock = {{ size = [10, 10, 5], cells = [4, 4, 2], element = \"hex8\" }}\n[materials.m]\nyoung = 1e5\npoisson = 0.3\n\
             [[load]]\non = \"z-max\"\npressure = 5\n[[contact]]\non = \"z-min\"\n\
             against = {{ plane = {{ point = [0, 0, 0], normal = [0.2, 0, 1] }} }}\nfriction = {{ coulomb = {coefficient} }}\n"
        );
        on_ranks(&case::parse(&text, "case.toml", &[]).unwrap(), 3).1.answer.status
    };
    assert_eq!((status(0.19), status(0.21)), (Status::NoEquilibrium, Status::Solved));
}

/// Pushed ever harder a block leaves where friction is used up, at 6/7 of the time: increments are halved until that is known to 1/64, and
/// those beyond take no cycle.
#[test]
fn load_steps_end_on_ranks_where_loads_have_no_equilibrium_any_more() {
    let text = "[mesh]\nblock = { size = [10, 10, 5], cells = [4, 4, 2], element = \"hex8\" }\n[materials.m]\nyoung = 1e5\npoisson = 0.3\n\
                [[load]]\non = \"z-max\"\npressure = 5\n[[load]]\non = \"z-min\"\ntraction = [\"1.75*t\", 0, 0]\n\
                [[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n\
                friction = { coulomb = 0.3 }\n[[step]]\nuntil = 1\n";
    let summary = on_ranks(&case::parse(text, "case.toml", &[]).unwrap(), 3).1;
    let [.., before, last] = &summary.steps[..] else { panic!("{summary}") };
    assert_eq!((before.answer.status, last.answer.status), (Status::Solved, Status::NoEquilibrium));
    assert!(before.t < 6.0 / 7.0 && 6.0 / 7.0 < last.t && last.t - before.t < 0.016, "{} {}", before.t, last.t);
    assert!(last.answer.counts.cycles == 0 && summary.to_string().contains("there is no equilibrium"), "{summary}");
}

/// The bar of the design: at most two cycles or 15 % more, whatever the ranks.
#[test]
fn ranks_take_hardly_more_cycles_than_one() {
    for element in ["element = \"tet4\", split = \"six\"", "element = \"hex8\""] {
        let text = brick(element, "{ coulomb = 0.35 }");
        let case = case_of(&text, "1e-8");
        let serial = serial_cycles(&case);
        for size in [1, 2, 4, 8, 16] {
            let cycles = on_ranks(&case, size).1.answer.counts.cycles;
            let most = (serial + 2).max(serial * 115 / 100);
            assert!(cycles <= most, "{element}: {cycles} cycles on {size} ranks, {serial} on one");
            assert!(size > 1 || cycles == serial, "{cycles} {serial}");
        }
    }
}

/// Everything that all ranks wait for in a cycle: what they find of the iterate, and the products of the directions. Sets of points
/// change in most cycles, and the coarse levels with them.
#[test]
fn a_cycle_takes_two_sums_over_all_ranks() {
    for friction in ["{ coulomb = 0.35 }", "{ tresca = 3e5 }"] {
        let case = case_of(&brick("element = \"hex8\"", friction), "1e-8");
        let counts = threads(3, |ranks| {
            let counted = Arc::new(Counted::new(ranks));
            let ranks: Arc<dyn Ranks> = counted.clone();
            let mut sums = Vec::new();
            let mut watch = |_: &_| {
                sums.push(counted.traffic().sums);
                ControlFlow::Continue(())
            };
            let answer = solve_on_ranks(&case, &ranks, &mut watch).unwrap();
            (sums, answer.summary.answer.counts.cycles)
        });
        for (sums, cycles) in counts {
            let of_cycles: Vec<u64> = sums.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(cycles >= 8 && of_cycles.len() == cycles, "{friction}: {cycles} cycles, {sums:?}");
            assert!(of_cycles.iter().all(|&sums| sums == 2), "{friction}: {of_cycles:?}");
        }
    }
}

/// Few of many ranks have the second level: visited thrice, as on one rank, it would take 15 exchanges a cycle, and the others wait.
#[test]
fn a_level_that_few_of_many_ranks_have_is_visited_once() {
    let text = brick("element = \"hex8\"", "{ coulomb = 0.35 }").replace("[48, 16, 16]", "[72, 24, 24]");
    let summary = on_ranks(&case_of(&text, "1e-8"), 32).1;
    let sent = summary.ranks.as_ref().unwrap().ranks.iter().map(|rank| rank.exchanges_per_cycle).fold(0.0, f64::max);
    let cycles = summary.answer.counts.cycles;
    assert!(cycles <= 16 && sent <= 13.0, "{cycles} cycles, {sent} exchanges each");
}

/// The certificates of ranks that hold all of a problem and own a part of it each.
fn certified(prepared: &Prepared, u: &[f64], lambda: &[f64], size: usize) -> Vec<Certificate> {
    let problem = &prepared.problem;
    let places = &prepared.mesh.nodes;
    let nodes: Vec<WeightedNode> =
        places.iter().zip(0..).map(|(&place, number)| WeightedNode { place, number, weight: 1.0 }).collect();
    let cuts = Cuts::new(&Alone, &nodes, size);
    let owner: Vec<u32> = nodes.iter().map(|node| cuts.part(node.place, node.number)).collect();
    threads(size, |ranks: Arc<dyn Ranks>| {
        let division = Division {
            ranks,
            owner: owner.clone(),
            global: (0..places.len() as u64).collect(),
            supports: prepared.model.dofs.prescribed.iter().map(|dof| dof / 3).collect(),
            points: prepared.facts.contacts.iter().flat_map(|c| c.surface.nodes.clone()).collect(),
        };
        let labels = problem.elastic.node_of.as_ref().unwrap();
        // What is not its own is not to be read.
        let own = |(i, &x): (usize, &f64)| if division.is_own(labels[i]) { x } else { f64::NAN };
        let u: Vec<f64> = u.iter().enumerate().map(own).collect();
        let own = |(i, &x): (usize, &f64)| {
            if division.is_own(division.points[i % division.points.len()]) { x } else { f64::NAN }
        };
        let lambda: Vec<f64> = lambda.iter().enumerate().map(own).collect();
        certify_divided(problem, &division, &u, &lambda, 1e-8)
    })
}

#[test]
fn the_certificate_of_ranks_is_that_of_one_for_right_and_wrong_answers() {
    let text = brick("element = \"tet4\", split = \"six\"", "{ coulomb = 0.35 }").replace("[48, 16, 16]", "[12, 4, 4]");
    certificate_agrees(&text);
}

/// The bound of the error in energy where friction is given, or there is none: for an answer and for one that is disturbed, so that it
/// penetrates and opens what is tied. Ranks that share unknowns of the other body come to other displacements that keep the constraints,
/// whose energies are within `same` of that of one machine.
fn bound_agrees(text: &str, same: f64) {
    let (outcome, prepared) = solved_case(&case_of(text, "1e-10"));
    let (problem, lambda) = (&prepared.problem, &outcome.solution.lambda);
    let largest = outcome.solution.u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    for size in [0.0, 1e-3] {
        let disturbed = |(i, u): (usize, &f64)| u + size * largest * (i as f64).sin();
        let u: Vec<f64> = outcome.solution.u.iter().enumerate().map(disturbed).collect();
        let stored = 0.5 * u.iter().zip(problem.elastic.K.times(&u)).map(|(x, f)| x * f).sum::<f64>();
        let bound = |certificate: &Certificate| certificate.duality_gap.expect("friction is not Coulomb's");
        let expected = bound(&certify(problem, &u, lambda, 1e-8));
        assert_eq!(expected > 1e-9 * stored, size > 0.0, "{expected:e} of {stored:e}");
        for size in [1, 2, 5] {
            let found = certified(&prepared, &u, lambda, size);
            assert!(found.iter().all(|certificate| bound(certificate) == bound(&found[0])));
            let (found, same) = (bound(&found[0]), if size == 1 { 1e-12 } else { same });
            let near = (found - expected).abs() <= same * expected + 1e-12 * stored;
            assert!(near, "{size} ranks: {found:e} {expected:e} of {stored:e}");
        }
    }
}

#[test]
fn the_bound_for_given_friction_is_found_on_ranks() {
    for friction in ["{ tresca = 1.3e5 }", "\"none\"", "\"bonded\""] {
        bound_agrees(&brick("element = \"hex8\"", friction).replace("[48, 16, 16]", "[12, 4, 4]"), 1e-9);
        bound_agrees(
            &super::ranks_bodies::blocks("element = \"hex8\"", false, friction).replace("[30, 10, 10]", "[12, 4, 4]"),
            0.1,
        );
    }
}

/// For an answer and for wrong ones.
pub(super) fn certificate_agrees(text: &str) {
    let (outcome, prepared) = solved_case(&case_of(text, "1e-8"));
    let (u, lambda) = (&outcome.solution.u, &outcome.solution.lambda);
    let m = prepared.problem.points();
    let (n, closed) = (u.len(), (0..m).find(|&j| lambda[j] > 0.0).unwrap());
    let wrong_u = |i: usize, change: f64| {
        let mut u = u.clone();
        u[i] += change;
        (u, lambda.clone())
    };
    let wrong_lambda = |i: usize, factor: f64| {
        let mut lambda = lambda.clone();
        lambda[i] *= factor;
        (u.clone(), lambda)
    };
    let answers = [
        (u.clone(), lambda.clone()),
        wrong_u(n - 1, 1e-7),
        wrong_u(n / 2, f64::NAN),
        wrong_lambda(closed, 1.001),
        wrong_lambda(closed, -1.0),
        wrong_lambda(m + closed, 1.5),
        wrong_lambda(m + closed, -1.0),
    ];
    for (number, (u, lambda)) in answers.iter().enumerate() {
        let whole = certify(&prepared.problem, u, lambda, 1e-8);
        assert_eq!(whole.passed, number == 0);
        for size in [1, 2, 5] {
            let found = certified(&prepared, u, lambda, size);
            assert!(found.iter().all(|c| c.measures() == found[0].measures() && c.passed == whole.passed));
            for ((name, value), (_, expected)) in found[0].measures().into_iter().zip(whole.measures()) {
                // Rounding that is not counted is some 1e-15 of a measure's scale.
                let near = (value - expected).abs() <= 1e-9 * expected.abs() + 1e-13;
                assert!(near || value == expected, "answer {number}, {size} ranks: {name} {value:e} {expected:e}");
            }
            let parts = found[0].parts.iter().zip(&whole.parts);
            for (found, expected) in parts {
                let (a, b) = (found.residual, expected.residual);
                assert!((a - b).abs() <= 1e-9 * b.abs() + 1e-13 || a == b, "{found:?} {expected:?}");
            }
        }
    }
}
