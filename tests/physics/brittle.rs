//! Strength that is lost on slip: what is left is friction alone, for good.

use std::ops::ControlFlow;

use stiction::friction::Status;
use stiction::io::case;
use stiction::io::step::StepFile;
use stiction::run::{Outcome, Prepared, Restart, Settings, Step, prepare, solve_steps};
use stiction_fixtures::case_run::{block, is, refused};

const YOUNG: f64 = 2000.0;

struct Run {
    outcome: Outcome,
    prepared: Prepared,
    files: Vec<StepFile>,
}

fn run(text: &str, restart: impl FnOnce() -> Option<Restart>) -> Run {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let mut files = Vec::new();
    let mut keep = |_: &Prepared, step: &Step| {
        files.push(step.file.clone());
        Ok(())
    };
    let settings = Settings::of(&case.solver);
    let outcome = solve_steps(&mut prepared, &settings, restart(), &mut keep, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(outcome.solution.status, Status::Solved);
    Run { outcome, prepared, files }
}

fn glued(size: [f64; 3], cells: [usize; 3], top: &str, path: &str) -> String {
    block(size, cells, "element = \"hex8\"")
        + &format!("[materials.soft]\nyoung = {YOUNG}\npoisson = 0\n[[fix]]\non = \"z-max\"\nvalue = {top}\n")
        + "[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n\
           friction = { coulomb = 0.5, cohesion = 1.2, tension = 0.4, cohesion_lost = \"on slip\" }\n"
        + &format!("[solver]\npath = \"{path}\"\ntolerance = 1e-10\n")
}

/// A cube glued to the floor is pulled until `E d = T`: from then on it carries no pull, also where it has been pressed
/// on the floor again in between, and where a support that is let go half way makes the laws of all points change by step.
#[test]
fn a_glue_that_has_torn_pulls_no_more() {
    // The middle does not move along y anyway.
    let held = "[[fix]]\non = { box = [[-1, -1, 0.4], [2, 2, 0.6]] }\ncomponents = \"y\"\nuntil = \"first\"\n\
                [[step]]\nname = \"first\"\nuntil = 1.25\nincrements = 10\n[[step]]\nuntil = 2.5\nincrements = 10\n";
    let steps = ["[[step]]\nuntil = 2.5\nincrements = 20\n", held];
    for (path, steps) in ["dense", "multigrid"].into_iter().flat_map(|path| steps.map(|steps| (path, steps))) {
        // Tears between t = 1/8, where the pull is 0.38, and t = 1/4; pressed from t = 1 to 2; then pulled again.
        let at = |t: f64| 5e-4 * (std::f64::consts::PI * t).sin();
        let top = "[0, 0, \"5e-4*sin(pi*t)\"]";
        let text = glued([1.0; 3], [2, 2, 2], top, path) + steps;
        let run = run(&text, || None);
        let mut torn = false;
        for step in &run.outcome.steps {
            let pull = YOUNG * at(step.t);
            torn |= pull > 0.4;
            let wanted = if pull <= 0.0 || !torn { -pull } else { 0.0 };
            is(step.answer.contact.normal_force, wanted, 1.0);
        }
        assert!(torn && run.outcome.steps.iter().any(|step| YOUNG * at(step.t) < -0.1));
    }
}

/// A glued block under pressure is dragged off: more than friction while the glue holds, friction alone once it has failed
/// everywhere; what has failed stays failed, and a run resumed in between ends in the same.
#[test]
fn a_glued_block_that_is_dragged_off_is_left_with_friction() {
    let text = |path: &str| {
        glued([2.0, 1.0, 0.5], [8, 3, 3], "[\"4e-3*t\", 0, -5e-4]", path)
            + "[[fix]]\non = { box = [[-1, -1, -1], [3, 3, 3]] }\ncomponents = \"y\"\n[[step]]\nuntil = 1\nincrements = 8\n"
    };
    for path in ["dense", "solves"] {
        let whole = run(&text(path), || None);
        let forces = |run: &Run| -> Vec<[f64; 2]> {
            let of = |step: &stiction::run::StepRecord| {
                [step.answer.contact.normal_force, -step.answer.contact.tangential_force[0]]
            };
            run.outcome.steps.iter().map(of).collect()
        };
        let all = forces(&whole);
        let most = all.iter().map(|[normal, shear]| shear / normal).fold(0.0, f64::max);
        let [normal, shear] = all[all.len() - 1];
        assert!(most > 0.65, "{all:?}");
        is(shear, 0.5 * normal, 10.0 * normal);
        let intact = |file: &StepFile| file.strength.as_chunks::<2>().0.iter().filter(|s| **s != [0.0; 2]).count();
        let counts: Vec<usize> = whole.files.iter().map(intact).collect();
        assert!(
            counts.is_sorted_by(|a, b| a >= b)
                && counts[0] == whole.prepared.problem.points()
                && counts.last() == Some(&0)
        );
        let middle = counts.iter().position(|&count| count < counts[0]).unwrap();
        let resumed = run(&text(path), || {
            Some(Restart {
                records: whole.outcome.steps[..=middle].to_vec(),
                last: whole.files[middle].clone(),
                before: whole.files[..middle].to_vec(),
                history: Vec::new(),
            })
        });
        for (a, b) in forces(&resumed).iter().zip(&all) {
            (0..2).for_each(|k| is(a[k], b[k], 10.0));
        }
    }
}

#[test]
fn a_loss_on_slip_without_load_steps_is_refused() {
    let told = refused(&glued([1.0; 3], [1, 1, 1], "[0, 0, 1e-4]", "dense"));
    assert!(told.contains("depends on the load path") && told.contains("[[step]]"), "{told}");
}

/// Load steps with a layer, an initial stress and a glue that tears: the folder holds all that a judge needs.
#[test]
fn steps_of_an_interface_with_everything_are_judged_anew_from_their_files() {
    let text = glued([1.0; 3], [2, 2, 2], "[0, 0, \"2e-4*t\"]", "dense").replacen(
        "[solver]",
        "stiffness = { normal = 4000, tangential = 1000 }\ninitial_stress = [0, 0, -0.05, 0, 0.02, 0]\n[solver]",
        1,
    ) + "[[step]]\nuntil = 3\nincrements = 3\n";
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("torn-layer");
    let _ = std::fs::remove_dir_all(&folder);
    let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let (mut files, _) = stiction::run::begin_steps(&prepared, &folder, false).unwrap();
    let mut keep = |prepared: &Prepared, step: &Step| stiction::run::keep_step(&mut files, prepared, step);
    let settings = Settings::of(&case.solver);
    let go_on = &mut |_: &stiction::run::Event| ControlFlow::Continue(());
    let mut outcome = solve_steps(&mut prepared, &settings, None, &mut keep, go_on).unwrap();
    stiction::run::write(&prepared, &mut outcome, &stiction::run::Origin::default(), &folder).unwrap();
    let checked = stiction::run::check(&folder).unwrap_or_else(|e| panic!("{e}"));
    assert!(checked.passed() && checked.steps.len() == outcome.steps.len(), "{checked:?}");
    // Pulled by d, column and layer in series lose d / (H/E + 1/k) of the initial pressure, down to -T.
    let forces: Vec<f64> = outcome.steps.iter().map(|step| step.answer.contact.normal_force).collect();
    is(forces[0], 0.05 - 2e-4 / (1.0 / YOUNG + 1.0 / 4000.0), 1.0);
    assert!(forces[forces.len() - 1] == 0.0, "{forces:?}");
    let last = folder.join(format!("contact-{:04}.vtu", outcome.steps.len()));
    let contact = std::fs::read(last).unwrap();
    assert!(contact.windows(8).any(|bytes| bytes == b"cohesion"));
}

/// Between two pulls below its strength a glue is without any force, exactly: that is no failure.
#[test]
fn a_glue_that_nothing_loads_for_a_while_holds() {
    for path in ["dense", "multigrid"] {
        let text =
            glued([1.0; 3], [2, 2, 2], "[0, 0, \"1e-4*abs(t - 2)\"]", path) + "[[step]]\nuntil = 3\nincrements = 3\n";
        let run = run(&text, || None);
        for (step, pull) in run.outcome.steps.iter().zip([0.2, 0.0, 0.2]) {
            is(step.answer.contact.normal_force, -pull, 1.0);
        }
        assert_eq!(run.outcome.steps.len(), 3);
    }
}
