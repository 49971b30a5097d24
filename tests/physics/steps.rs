//! Load steps: friction remembers where it has slid, and what becomes of the work.

use std::ops::ControlFlow;

use stiction::certificate::certify;
use stiction::contact::Friction;
use stiction::friction::Status;
use stiction::io::case;
use stiction::linalg::norm;
use stiction::run::{
    BalanceRecord, Event, Outcome, Prepared, Restart, Settings, Step, StepRecord, pair_totals, prepare, solve,
    solve_steps,
};
use stiction::{SolveEvent, SolverPath};
use stiction_fixtures::case_run;

/// A block of 20 x 10 x 10 on a plane, without loads.
const BLOCK: &str = r#"
[mesh]
block = { size = [20, 10, 10], cells = [8, 4, 4], element = "hex8" }
[materials.steel]
young = 210e3
poisson = 0
"#;

/// A stepped run in memory: its case, its answer and the multipliers of each step.
struct Run {
    prepared: Prepared,
    outcome: Outcome,
    lambda: Vec<Vec<f64>>,
}

fn run_with(text: &str, change: impl FnOnce(&mut Settings)) -> Run {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let mut settings = Settings::of(&case.solver);
    change(&mut settings);
    let mut lambda = Vec::new();
    let mut keep = |_: &Prepared, step: &Step| {
        lambda.push(step.outcome.solution.lambda.clone());
        Ok(())
    };
    let outcome = solve_steps(&mut prepared, &settings, None, &mut keep, &mut |_| ControlFlow::Continue(()));
    Run { prepared, outcome: outcome.unwrap_or_else(|e| panic!("{e}")), lambda }
}

/// The same, and every step is certified.
fn run(text: &str) -> Run {
    let run = run_with(text, |_| {});
    assert_eq!(run.outcome.solution.status, Status::Solved);
    assert!(run.outcome.steps.iter().all(|step| step.answer.certificate.passed));
    run
}

impl Run {
    fn balance(&self, step: usize) -> BalanceRecord {
        self.outcome.steps[step].balance
    }

    fn friction_x(&self, step: usize) -> f64 {
        self.outcome.steps[step].answer.contact.tangential_force[0]
    }
}

fn energies(balance: &BalanceRecord) -> [f64; 3] {
    [balance.work, balance.elastic, balance.dissipation]
}

fn contact(friction: &str, motion: &str) -> String {
    format!(
        "[[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }}{motion} }}\n\
         friction = {friction}\n"
    )
}

fn steps(list: &[(f64, usize)]) -> String {
    list.iter().map(|(until, n)| format!("[[step]]\nuntil = {until}\nincrements = {n}\n")).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied())
}

/// With a flat foot and loads in proportion to the time, stress and slip are in proportion too: each point slips in one
/// direction, or not at all, and the number of steps does not matter.
#[test]
fn proportional_loading_of_a_flat_foot_does_not_depend_on_the_steps() {
    let body = BLOCK
        .replace("poisson = 0", "poisson = 0.3")
        .replace("[20, 10, 10], cells = [8,", "[30, 10, 10], cells = [12,")
        + "[[fix]]\non = \"x-min\"\n[[load]]\non = \"z-max\"\ntraction = [\"4*t\", 0, \"-t*(35 - x)\"]\n\
           [[load]]\non = \"x-max\"\ntraction = [0, 0, \"12*t\"]\n"
        + &contact("{ coulomb = 1 }", "");
    let [one, five] = [1, 5].map(|count| run(&(body.clone() + &steps(&[(1.0, count)]))));
    let last = &one.outcome.steps[0].answer.contact;
    assert!([last.open, last.stick, last.slip].iter().all(|&points| points > 3), "{last:?}");
    assert!(apart(&five.outcome.solution.lambda, &one.outcome.solution.lambda) < 1e-6);
    assert!(apart(&five.outcome.solution.u, &one.outcome.solution.u) < 1e-6);
    // Without [[step]] the case is solved at t = 1.
    let case = case::parse(&body, "case.toml", &[]).unwrap();
    let still =
        solve(&prepare(&case).unwrap(), &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(apart(&one.outcome.solution.lambda, &still.solution.lambda) < 1e-6);
}

/// The same again: from the third step on the last two lead to the answer, on both paths.
#[test]
fn steps_in_proportion_are_met_at_once() {
    let body = BLOCK.replace("poisson = 0", "poisson = 0.3")
        + "[[fix]]\non = \"x-min\"\n[[load]]\non = \"z-max\"\ntraction = [\"4*t\", 0, \"-t*(35 - x)\"]\n"
        + &contact("{ coulomb = 0.4 }", "")
        + &steps(&[(1.0, 2), (2.0, 3)]);
    for (path, first, further) in [("multigrid", 8, 1), ("dense", 3, 1)] {
        let run = run(&format!("{body}[solver]\npath = \"{path}\"\n"));
        let taken: Vec<usize> = run.outcome.steps.iter().map(|step| step.answer.counts.steps()).collect();
        assert!(taken[0] >= first && taken[2..].iter().all(|&n| n <= further), "{path}: {taken:?}");
    }
}

/// A block that nothing else holds is pressed and released again. Without load there is no force and no displacement,
/// which is an answer like any other: each step takes one attempt, and each measure is a number.
#[test]
fn unloading_to_nothing_ends_at_zero() {
    let body = r#"
[mesh]
block = { size = [20, 20, 10], cells = [2, 2, 1], element = "hex8" }
[materials.steel]
young = 210e3
poisson = 0.3
[[load]]
on = "z-max"
force = [0, 0, "-1000*min(t, 2 - t)"]
"#
    .to_string()
        + &contact("{ coulomb = 0.3 }", "")
        + &steps(&[(1.0, 2), (2.0, 2)]);
    for path in ["dense", "solves", "multigrid"] {
        let run = run(&format!("{body}[solver]\npath = \"{path}\"\n"));
        for (step, wanted) in run.outcome.steps.iter().zip([500.0, 1000.0, 500.0, 0.0]) {
            assert_eq!(step.attempts, 1, "{path} t = {}", step.t);
            assert!(step.answer.certificate.measures.0.iter().all(|(_, value)| value.is_finite()), "{path}");
            assert!((step.answer.contact.normal_force - wanted).abs() <= 1e-6 * 1000.0, "{path} t = {}", step.t);
        }
        let end = &run.outcome.solution;
        let largest = |x: &[f64]| x.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(largest(&end.lambda) <= 1e-12 * 1000.0, "{path} {:?}", end.lambda);
        // Nothing holds the block: it may have moved, but not bent.
        let [before, after] = [1, 3].map(|step| run.balance(step).elastic);
        assert!(after.abs() <= 1e-12 * before, "{path} {after} {before}");
    }
}

/// Fully slipping, the elastic state does not depend on how far the block has slid: between two cycles whose amplitudes
/// differ by 0.1 the dissipated energies differ by 4 F N 0.1 exactly, and one more way along costs F N times the way.
/// With Poisson's ratio zero N = E A d / h = 8400.
#[test]
fn a_block_pulled_to_and_fro_dissipates_the_area_of_its_loop() {
    let top = "0.1*max(0, min(t - 1, 1)) - 0.2*max(0, min(t - 2, 1)) + 0.2*max(0, min(t - 3, 1)) \
               + 0.1*max(0, min(t - 4, 1)) - 0.4*max(0, min(t - 5, 1)) + 0.4*max(0, min(t - 6, 1))";
    let text = BLOCK.to_string()
        + &format!("[[fix]]\non = \"z-max\"\nvalue = [\"{top}\", 0, \"-2e-3*min(t, 1)\"]\n")
        + &contact("{ coulomb = 0.5 }", "")
        + &steps(&[(1.0, 1), (2.0, 2), (4.0, 4), (5.0, 2), (7.0, 8)]);
    let run = run(&text);
    let time = |t: f64| run.outcome.steps.iter().position(|step| step.t == t).unwrap();
    let dissipated = |t: f64| run.balance(time(t)).dissipation;
    let (small, large) = (dissipated(4.0) - dissipated(2.0), dissipated(7.0) - dissipated(5.0));
    assert!(((large - small) / (4.0 * 4200.0 * 0.1) - 1.0).abs() < 1e-9, "{small} {large}");
    assert!(((dissipated(5.0) - dissipated(4.0)) / (4200.0 * 0.1) - 1.0).abs() < 1e-9);
    // Both are the parallelogram less what the block itself shears back, two halves of a few per cent.
    assert!(small < 4.0 * 4200.0 * 0.1 && small > 0.9 * 4.0 * 4200.0 * 0.1);
    for (t, force) in [(1.0, 0.0), (2.0, -4200.0), (3.0, 4200.0), (4.0, -4200.0), (6.0, 4200.0), (7.0, -4200.0)] {
        assert!((run.friction_x(time(t)) - force).abs() < 1e-6 * 4200.0, "t = {t}");
        assert!((run.outcome.steps[time(t)].answer.contact.normal_force / 8400.0 - 1.0).abs() < 1e-9);
    }
}

/// Pulled back a little after slipping, the foot sticks: friction falls by what the block's shear alone takes,
/// less than its bound on the other side. A solver that forgot the slip would answer as if pushed from the start.
#[test]
fn friction_remembers_where_it_slid() {
    let body = BLOCK.to_string()
        + "[[fix]]\non = \"z-max\"\nvalue = [\"0.1*t - 0.101*max(0, t - 1)\", 0, \"-2e-3*min(2*t, 1)\"]\n"
        + &contact("{ coulomb = 0.5 }", "");
    let run = run(&(body + &steps(&[(1.0, 2), (2.0, 1)])));
    // From 0.1 at t = 1 to 0.099 at t = 2: one micrometre back.
    assert!((run.friction_x(1) + 4200.0).abs() < 1e-6 * 4200.0);
    let back = run.friction_x(2);
    assert!(back > -4200.0 * 0.99 && back < 0.0, "{back}");
    // Where the pressure falls with the shear a few points still slip, by next to nothing.
    assert!(run.outcome.steps[2].answer.contact.stick > 30);
    assert!((run.balance(2).dissipation / run.balance(1).dissipation - 1.0).abs() < 1e-3);
}

/// Only relative motion counts: a plane that moves up and along is a top that moves down and back.
#[test]
fn moving_the_obstacle_is_moving_the_support_the_other_way() {
    let path = ["3e-3*sin(2*t)", "1e-3*t", "2e-3*min(1, t)"];
    let [x, y, z] = path;
    let body = BLOCK.replace("poisson = 0", "poisson = 0.3");
    let top = format!("[[fix]]\non = \"z-max\"\nvalue = [\"-({x})\", \"-({y})\", \"-({z})\"]\n");
    let by_support = body.clone() + &top + &contact("{ coulomb = 0.3 }", "");
    let motion = format!(", motion = [\"{x}\", \"{y}\", \"{z}\"]");
    let by_obstacle = body + "[[fix]]\non = \"z-max\"\n" + &contact("{ coulomb = 0.3 }", &motion);
    let [a, b] = [by_support, by_obstacle].map(|text| run(&(text + &steps(&[(2.0, 6)]))));
    let partial = |step: &StepRecord| step.answer.contact.stick > 0 && step.answer.contact.slip > 0;
    assert!(a.outcome.steps.iter().any(partial));
    for step in 0..6 {
        assert!(apart(&b.lambda[step], &a.lambda[step]) < 1e-6);
        let (of_a, of_b) = (a.balance(step), b.balance(step));
        for (a, b) in energies(&of_a).into_iter().zip(energies(&of_b)) {
            assert!((a - b).abs() < 1e-6 * of_a.work, "{of_a:?} {of_b:?}");
        }
    }
    // What is solved at once without steps is the first step that goes there.
    let only = run(&(by_one_step(&motion) + &steps(&[(1.0, 1)])));
    let case = case::parse(&by_one_step(&motion), "case.toml", &[]).unwrap();
    let still =
        solve(&prepare(&case).unwrap(), &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(apart(&only.outcome.solution.lambda, &still.solution.lambda) < 1e-6);
}

fn by_one_step(motion: &str) -> String {
    BLOCK.to_string() + "[[fix]]\non = \"z-max\"\n" + &contact("{ coulomb = 0.3 }", motion)
}

/// The displacements themselves by multigrid, whose set-up is kept as the factor is.
#[test]
fn both_paths_walk_the_same_steps() {
    let text = BLOCK.replace("poisson = 0", "poisson = 0.3")
        + "[[fix]]\non = \"z-max\"\nvalue = [\"4e-3*sin(2*min(t, 2))\", 0, \"-2e-3*min(t, 1)\"]\n"
        + &contact("{ coulomb = 0.3 }", "")
        + &steps(&[(2.0, 4), (3.0, 1)]);
    let [direct, multigrid] = ["solves", "multigrid"].map(|path| run(&format!("{text}[solver]\npath = \"{path}\"\n")));
    assert!(multigrid.outcome.steps.iter().all(|step| step.answer.path == SolverPath::Multigrid));
    for step in 0..5 {
        assert!(apart(&multigrid.lambda[step], &direct.lambda[step]) < 1e-6);
    }
    // Nothing changes in the last step.
    let cycles = |step: usize| multigrid.outcome.steps[step].answer.counts.cycles;
    assert!(cycles(0) > 5 && cycles(4) <= 2, "{} {}", cycles(0), cycles(4));
}

/// The first look at the multipliers of the last step is enough.
#[test]
fn a_step_that_changes_nothing_costs_next_to_nothing() {
    let text = BLOCK.replace("poisson = 0", "poisson = 0.3")
        + "[[fix]]\non = \"z-max\"\nvalue = [\"2e-3*min(t, 1)\", 0, \"-2e-3*min(t, 1)\"]\n"
        + &contact("{ coulomb = 0.3 }", "")
        + &steps(&[(1.0, 1), (2.0, 1)]);
    let run = run(&text);
    let [first, second] = [0, 1].map(|step: usize| run.outcome.steps[step].answer.counts);
    assert!(first.iterations >= 3 && first.products > 20, "{first:?}");
    assert_eq!(second.iterations, 0);
    assert!(second.products <= 2 && second.solves <= 3, "{second:?}");
    assert_eq!(run.outcome.steps[1].attempts, 1);
    assert!(apart(&run.lambda[1], &run.lambda[0]) < 1e-12);
    let [first, second] = [0, 1].map(|step| run.balance(step).dissipation);
    assert!(first > 0.0 && (second / first - 1.0).abs() < 1e-9);
}

/// A step of length dt misses O(dt²) of the energy, so that the whole way misses O(dt).
#[test]
fn the_balance_of_energy_closes_as_the_steps_get_shorter() {
    let text = BLOCK.replace("poisson = 0", "poisson = 0.3")
        + "[[fix]]\non = \"z-max\"\nvalue = [\"4e-3*sin(1.5*t)\", 0, \"-2e-3*(1 - 0.5*cos(t))\"]\n"
        + &contact("{ coulomb = 0.3 }", "");
    let drifts = |count: usize| {
        let run = run(&(text.clone() + &steps(&[(0.1, 1), (1.6, count)])));
        // From the second step on: the body is not at rest at t = 0, and the first step has it all.
        let drift: Vec<f64> = (0..=count).map(|step| run.balance(step).drift).collect();
        let work = run.balance(count).work;
        let each = drift.windows(2).map(|d| (d[1] - d[0]).abs()).fold(0.0, f64::max);
        [each / work, (drift[count] - drift[0]).abs() / work]
    };
    let found = [6, 12, 24, 48].map(drifts);
    println!("largest of a step, and in all, over the work: {found:?}");
    let [each, all] = [0, 1].map(|i| (found[0][i] / found[3][i]).log2() / 3.0);
    println!("observed orders {each:.2} and {all:.2}");
    assert!(each > 1.6 && all > 0.8, "{each} {all}");
    assert!(found[3][1] < 0.02);
}

/// Without friction the way does not matter: an increment that is too long for the few iterations allowed ends, in
/// halves, where one long step would have ended.
#[test]
fn a_step_that_fails_is_halved_and_grows_back() {
    let text = BLOCK.replace("poisson = 0", "poisson = 0.3")
        + "[[fix]]\non = \"z-max\"\nvalue = [0, 0, \"-0.3*t\"]\n[[contact]]\non = \"z-min\"\nfriction = \"none\"\n\
           against = { sphere = { center = [7, 4, -60.2], radius = 60 } }\n";
    let exact = run(&(text.clone() + &steps(&[(3.0, 1)])));
    let newton_steps = exact.outcome.solution.counts.newton_steps;
    assert!(newton_steps > 3, "{newton_steps}");
    let mut halved = 0;
    let case = case::parse(&(text.clone() + &steps(&[(3.0, 1)])), "case.toml", &[]).unwrap();
    let mut prepared = prepare(&case).unwrap();
    let mut settings = Settings::of(&case.solver);
    settings.solver.max_iterations = newton_steps - 1;
    // The other path would solve it.
    settings.solver.path = SolverPath::Solves;
    let mut count = |event: &Event| {
        halved += usize::from(matches!(event, Event::Halved { .. }));
        ControlFlow::Continue(())
    };
    let short = solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), &mut count).unwrap();
    assert_eq!(short.solution.status, Status::Solved);
    assert!(halved > 0 && short.steps.len() > 1, "{halved}");
    assert_eq!(short.steps.last().unwrap().t, 3.0);
    assert!(apart(&short.solution.lambda, &exact.outcome.solution.lambda) < 1e-6);

    // Where nothing helps, the shortest step says how it ended.
    let lost = run_with(&(text + &steps(&[(1.0, 1), (3.0, 1)])), |settings| {
        (settings.solver.max_iterations, settings.solver.path) = (1, SolverPath::Solves);
    });
    let last = lost.outcome.steps.last().unwrap();
    assert_eq!(lost.outcome.solution.status, Status::MaxIterations);
    assert!(last.answer.status == Status::MaxIterations && !last.answer.certificate.passed);
    assert!(last.attempts > 2 && last.dt == 1.0 / 64.0, "{last:?}");
}

/// Last digits of a factorisation depend on where the allocator puts its arrays, and steps that start from them end
/// anywhere within the tolerance of the certificate.
const ROUNDING: f64 = 1e-8;

/// An interrupted run ends with its last finished step, and a run that goes on from there ends as if nothing had been.
#[test]
fn an_interrupted_run_goes_on_where_it_stopped() {
    let text = BLOCK.replace("poisson = 0", "poisson = 0.3")
        + "[[fix]]\non = \"z-max\"\nvalue = [\"4e-3*sin(2*t)\", 0, \"-2e-3*min(t, 1)\"]\n"
        + &contact("{ coulomb = 0.3 }", "")
        + &steps(&[(1.0, 2), (3.0, 5)]);
    let whole = run(&text);
    let case = case::parse(&text, "case.toml", &[]).unwrap();
    let settings = Settings::of(&case.solver);
    let mut prepared = prepare(&case).unwrap();
    let mut kept: Option<Restart> = None;
    let mut keep = |_: &Prepared, step: &Step| {
        let before =
            kept.take().into_iter().flat_map(|restart| [restart.before, vec![restart.last]].concat()).collect();
        kept = Some(Restart { records: step.records.to_vec(), last: step.file.clone(), before, history: Vec::new() });
        Ok(())
    };
    let mut finished = 0;
    let mut stop = |event: &Event| {
        finished += usize::from(matches!(event, Event::Finished(_)));
        let within = matches!(event, Event::Solver(SolveEvent::Iteration(p)) if p.iteration > 0);
        if finished == 3 && within { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let stopped = solve_steps(&mut prepared, &settings, None, &mut keep, &mut stop).unwrap();
    assert_eq!(stopped.solution.status, Status::Interrupted);
    assert_eq!(stopped.steps.len(), 3);
    assert!(stopped.solution.certificate.passed);
    let (u, lambda) = (&stopped.solution.u, &stopped.solution.lambda);
    // The problem it leaves is that of the step it kept.
    let judged = stiction::certificate::certify(&prepared.problem, u, lambda, 1e-8);
    assert!(judged.passed && apart(lambda, &whole.lambda[2]) < ROUNDING, "{judged:?}");

    let mut prepared = prepare(&case).unwrap();
    let resumed =
        solve_steps(&mut prepared, &settings, kept, &mut |_, _| Ok(()), &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(apart(&resumed.solution.lambda, &whole.outcome.solution.lambda) < ROUNDING);
    assert!(apart(&resumed.solution.u, &whole.outcome.solution.u) < ROUNDING);
    assert_eq!(resumed.steps.len(), whole.outcome.steps.len());
    for (a, b) in resumed.steps.iter().zip(&whole.outcome.steps) {
        for (x, y) in energies(&a.balance).into_iter().zip(energies(&b.balance)) {
            assert!((x - y).abs() <= ROUNDING * b.balance.work.abs(), "{:?} {:?}", a.balance, b.balance);
        }
        assert_eq!(a.answer.contact.slip, b.answer.contact.slip);
    }
    let largest = resumed.solution.u.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
    let references = prepared.problem.contact.slip_reference.iter().zip(&whole.prepared.problem.contact.slip_reference);
    assert!(references.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < ROUNDING * largest);
}

/// What costs most is done once a run, on either path. Steps that follow their loads take no more cycles than the first and
/// hardly more Newton steps.
#[test]
fn all_steps_share_one_set_up_or_one_factor() {
    // The load on the upper of two blocks grows and turns.
    let text = "[mesh.parts.low]\nblock = { size = [4, 4, 2], cells = [10, 10, 4], element = \"hex8\" }\n\
                [mesh.parts.high]\nblock = { size = [3, 3, 2], cells = [8, 8, 5], element = \"hex8\" }\n\
                move = [0.5, 0.5, 2]\n[materials.steel]\nyoung = 210e3\npoisson = 0.3\n\
                [[fix]]\non = \"low.z-min\"\n[[load]]\non = \"high.z-max\"\n\
                traction = [\"3*t*cos(12*t)\", \"3*t*sin(12*t)\", \"-5 - 20*t\"]\n\
                [[contact]]\non = \"high.z-min\"\nagainst = \"low.z-max\"\nfriction = { coulomb = 0.2 }\n\
                [[step]]\nuntil = 0.1\nincrements = 10\n";
    for (path, expected, most) in [("multigrid", [1, 0], 1.0), ("solves", [0, 1], 1.2)] {
        let case = case::parse(&format!("{text}[solver]\npath = \"{path}\"\n"), "case.toml", &[]).unwrap();
        let mut prepared = prepare(&case).unwrap();
        let [mut set_up, mut factorised] = [0, 0];
        let mut count = |event: &Event| {
            set_up += usize::from(matches!(event, Event::Solver(SolveEvent::SettingUp { .. })));
            factorised += usize::from(matches!(event, Event::Solver(SolveEvent::Factorising { .. })));
            ControlFlow::Continue(())
        };
        let settings = Settings::of(&case.solver);
        let outcome = solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), &mut count).unwrap();
        assert_eq!((outcome.solution.status, [set_up, factorised]), (Status::Solved, expected), "{path}");
        let counts: Vec<usize> = outcome.steps.iter().map(|step| step.answer.counts.steps()).collect();
        let mean = counts[1..].iter().sum::<usize>() as f64 / 9.0;
        assert!(mean <= most * counts[0] as f64, "{path}: {counts:?}");
        assert!(outcome.steps.iter().all(|step| step.attempts == 1), "{path}");
    }
}

/// What would go wrong in a later step is said before the first one is solved.
#[test]
fn steps_that_cannot_be_posed_are_refused_at_once() {
    let fails = |fix: &str, contact: &str, parts: &[&str]| {
        let text = BLOCK.to_string() + fix + contact + &steps(&[(1.0, 1), (3.0, 2)]);
        let error = match prepare(&case::parse(&text, "case.toml", &[]).unwrap()) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("accepted: {text}"),
        };
        parts.iter().for_each(|part| assert!(error.contains(part), "{part:?} is not in {error}"));
    };
    let plane = |motion: &str| contact("{ coulomb = 0.3 }", motion);
    let held = "[[fix]]\non = \"z-max\"\nvalue = [0, 0, \"sqrt(2.5 - t)*(t - 3)\"]\n";
    fails("[[fix]]\non = \"z-max\"\nvalue = [\"1/(t - 2)\", 0, 0]\n", &plane(""), &["case.toml:7", "at time t = 2"]);
    fails(&held.replace("2.5", "2"), &plane(""), &["case.toml:7", "NaN", "t = 3"]);
    let top = "[[fix]]\non = \"z-max\"\n";
    fails(top, &plane(", motion = [0, \"1/(t - 1)\", 0]"), &["case.toml:9", "at time t = 1"]);
    // A plane of symmetry does not follow an obstacle that moves across it.
    let symmetry = top.to_string() + "[[fix]]\non = \"y-min\"\ncomponents = \"y\"\n";
    fails(&symmetry, &plane(", motion = [0, \"t*(t - 3)\", 0]"), &["slides over the obstacle", "held in a direction"]);
    let clamped = top.to_string() + "[[fix]]\non = \"x-min\"\n";
    fails(&clamped, &plane(", motion = [0, 0, \"1e-3*t*(3 - t)\"]"), &["which is held, gets 2.000e-3 into", "t = 1"]);
}

/// A body and its obstacle at the end of a long way are what they are at its beginning: what cancels is only known to the
/// rounding of the numbers given, which the certificate states, and no better.
#[test]
fn a_common_travel_changes_nothing_but_what_is_known() {
    for path in ["dense", "multigrid"] {
        travels(path);
    }
}

fn travels(path: &str) {
    let of = |way: f64, tolerance: f64| {
        BLOCK.replace("poisson = 0", "poisson = 0.3")
            + &format!("[[fix]]\non = \"z-max\"\nvalue = [\"1e-3*t\", 0, \"{way:?} - 2e-3*t\"]\n")
            + &contact("{ coulomb = 0.3 }", "").replace("[0, 0, 0]", &format!("[0, 0, {way:?}]"))
            + &format!("[solver]\npath = \"{path}\"\ntolerance = {tolerance:e}\n")
            + &steps(&[(1.0, 2)])
    };
    let here = run(&of(0.0, 1e-8));
    let known = |run: &Run| run.outcome.solution.certificate.data_rounding;
    assert_eq!(known(&here), None);
    // 2^27 is a number of its own; what is added to it is rounded to 2^-26 of a millimetre.
    let way = -134_217_728.0;
    let far = run_with(&of(way, 1e-8), |_| {});
    let rounding = known(&far).unwrap();
    assert!(rounding > 1e-6 && rounding < 1e-4, "{rounding}");
    assert!(!far.outcome.solution.certificate.passed && far.outcome.solution.status != Status::Solved);
    // No solver goes on for what cannot be known: as many iterations as without the way, give or take what rounding does.
    let iterations = |run: &Run| run.outcome.steps[0].answer.counts.steps();
    assert!(iterations(&far) <= iterations(&here) + 3, "{path} {} {}", iterations(&far), iterations(&here));
    // Who asks for no more than can be known gets it.
    let far = run(&of(way, 1e-4));
    let (of_far, of_here) = (&far.outcome.solution, &here.outcome.solution);
    let apart = apart(&of_far.lambda, &of_here.lambda);
    assert!(apart < 10.0 * rounding, "{apart} {rounding}");
    let largest = far.outcome.steps.last().unwrap().answer.displacement_max;
    assert!((largest + way).abs() < 0.01, "{largest}");
    for (a, b) in energies(&far.balance(1)).into_iter().zip(energies(&here.balance(1))).skip(1) {
        assert!((a - b).abs() < 1e-3 * b.abs(), "{a} {b}");
    }
}

/// A block that slides as a whole: the friction of each point is the coefficient of the time times its pressure. The file of
/// each step holds the coefficients it was solved with, and no others pass.
#[test]
fn a_coefficient_of_the_time_holds_at_each_step() {
    let text = BLOCK.to_string()
        + "[[fix]]\non = \"z-max\"\nvalue = [\"0.1*t\", 0, \"-0.01*min(t, 1)\"]\n"
        + &contact("{ coulomb = \"0.1*t + 0.001*x\" }", "")
        + &steps(&[(1.0, 1), (3.0, 2)]);
    let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap();
    let mut seen = 0;
    let mut keep = |prepared: &Prepared, step: &Step| {
        let mut problem = prepared.problem.clone();
        step.file.put_into(&mut problem);
        assert_eq!(problem, prepared.problem);
        let (m, lambda, states) = (problem.points(), &step.file.lambda, &step.file.states);
        let laws: Vec<f64> = problem.contact.friction.iter().filter_map(Friction::coefficient).collect();
        let (low, high) = laws.iter().fold((f64::MAX, 0.0), |(a, b): (f64, f64), &mu| (a.min(mu), b.max(mu)));
        assert!((low - 0.1 * step.file.t).abs() < 1e-15 && (high - low - 0.02).abs() < 1e-15);
        for j in 0..m {
            let shear = lambda[m + j].hypot(lambda[2 * m + j]);
            assert!(states[j] == 2 && (shear - laws[j] * lambda[j]).abs() < 1e-7 * shear, "{shear} at {j}");
        }
        assert!(certify(&problem, &step.file.u, lambda, 1e-8).passed);
        let mut wrong = step.file.clone();
        let Friction::Coulomb { coefficient } = &mut wrong.laws[0] else { panic!("{:?}", wrong.laws[0]) };
        *coefficient *= 1.0 + 1e-6;
        wrong.put_into(&mut problem);
        assert!(!certify(&problem, &step.file.u, lambda, 1e-8).passed);
        seen += 1;
        Ok(())
    };
    let go_on = &mut |_: &Event| ControlFlow::Continue(());
    solve_steps(&mut prepared, &Settings::of(&case.solver), None, &mut keep, go_on).unwrap();
    assert_eq!(seen, 3);
    // Negative at some time, and with two coefficients.
    let negative = text.replace("0.1*t + 0.001*x", "0.2 - 0.1*t");
    let error = prepare(&case::parse(&negative, "case.toml", &[]).unwrap()).unwrap_err().to_string();
    assert!(error.contains("is -") && error.contains("at time t = 3"), "{error}");
    let two = text.replace("\"0.1*t + 0.001*x\"", "[\"0.1*t\", 0.2], direction = [1, 0, 0]");
    let error = case::parse(&two, "case.toml", &[]).unwrap_err().to_string();
    assert!(error.contains("changes with the time"), "{error}");
}

/// A sector of 12 degrees, driven between two walls by a force F towards their edge, from which the force is taken off: friction
/// of 0.3 is more than the tangent of 6 degrees, and the wedge stays. While it is driven in friction is at its bound, and
/// `F = 2 N (sin 6 + 0.3 cos 6)`; without a force `T = N tan 6` at each wall.
#[test]
fn a_wedge_stays_where_it_was_driven_in() {
    let half = 6.0f64.to_radians();
    let (s, c) = half.sin_cos();
    let force = format!("[\"-1e4*{c}*min(t, 2 - t)\", \"-1e4*{s}*min(t, 2 - t)\", 0]");
    // Apart by far less than they are pressed together, so that nothing overlaps where no load acts.
    let wall = |on: &str, normal: [f64; 3]| {
        let point = normal.map(|n| -1e-12 * n);
        format!(
            "[[contact]]\non = \"{on}\"\nagainst = {{ plane = {{ point = {point:?}, normal = {normal:?} }} }}\n\
             friction = {{ coulomb = 0.3 }}\n"
        )
    };
    let case = |path: &str| {
        "[mesh]\nring = { radii = [40, 60], height = 10, degrees = 12, cells = [6, 4, 2], element = \"hex8\" }\n\
         [materials.steel]\nyoung = 210e3\npoisson = 0\n[[fix]]\non = \"z-min\"\ncondition = \"symmetry\"\n"
            .to_string()
            + &format!("[[load]]\non = \"outer\"\nforce = {force}\n")
            + &wall("start", [0.0, 1.0, 0.0])
            + &wall("end", [(2.0 * half).sin(), -(2.0 * half).cos(), 0.0])
            + "[[step]]\nname = \"drive\"\nuntil = 1\n[[step]]\nname = \"release\"\nuntil = 2\nincrements = 4\n"
            + &format!("[solver]\ntolerance = 1e-10\npath = \"{path}\"\n")
    };
    let left = ["dense", "solves", "multigrid"].map(|path| {
        let run = case_run::solved(&case(path));
        let driven = &run.0.steps[0].answer.contact;
        assert_eq!([driven.open, driven.stick], [0, 0], "{path}");
        assert!((driven.normal_force * (s + 0.3 * c) / 1e4 - 1.0).abs() < 1e-8, "{path} {}", driven.normal_force);
        for (_, pair) in pair_totals(&run.1, &run.0) {
            let [normal, tangential] = [pair.normal_force, norm(&pair.tangential_force)];
            assert!(normal > 0.3 * driven.normal_force, "{path}: it has come loose, {normal}");
            assert!((tangential / (normal * half.tan()) - 1.0).abs() < 1e-7, "{path} {tangential} {normal}");
        }
        run.0.steps[4].answer.contact.normal_force
    });
    assert!(left.iter().all(|force| (force / left[0] - 1.0).abs() < 1e-7), "{left:?}");
}
