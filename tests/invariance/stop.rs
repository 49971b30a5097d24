//! A stop is heard in each phase of a solve, and nothing comes of it but an end.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

use stiction::contact::{ContactProblem, SurfaceFriction};
use stiction::friction::{Settings, Solution, SolverPath, Status};
use stiction::linalg::Stop;
use stiction::mesh::BlockElement;
use stiction::{Error, Kept, SolveEvent, solve_with_kept};
use stiction_fixtures::*;

fn phase(event: &SolveEvent) -> &'static str {
    match event {
        SolveEvent::SettingUp { .. } => "setting up",
        SolveEvent::Ordering => "ordering",
        SolveEvent::Factorising { .. } => "factorising",
        SolveEvent::Solving => "solving",
        SolveEvent::Iteration(_) => "iteration",
    }
}

/// The result if the stop asks to end from this question of a phase on, and the phase of each question.
fn stopped_at(
    problem: &ContactProblem,
    path: SolverPath,
    (of, question): (&'static str, usize),
) -> (Result<Solution, Error>, Vec<&'static str>) {
    let now = Arc::new(Mutex::new("before"));
    let asked = Arc::new(Mutex::new(Vec::new()));
    let (of_stop, phases) = (Arc::clone(&now), Arc::clone(&asked));
    let stop = Stop::when(move || {
        let mut phases = phases.lock().unwrap();
        phases.push(*of_stop.lock().unwrap());
        count(&phases, of) > question
    });
    let settings = Settings { path, stop, ..settings(1e-10) };
    let result = solve_with_kept(problem, &settings, &mut Kept::default(), &mut |event| {
        *now.lock().unwrap() = phase(event);
        ControlFlow::Continue(())
    });
    let phases = asked.lock().unwrap().clone();
    (result, phases)
}

fn count(asked: &[&str], phase: &str) -> usize {
    asked.iter().filter(|other| **other == phase).count()
}

/// The same at a question that is asked. Work in a thread of its own is asked about every few milliseconds: a run may have fewer
/// questions than the one before it.
fn stopped(
    problem: &ContactProblem,
    path: SolverPath,
    (phase, mut question): (&'static str, usize),
) -> Result<Solution, Error> {
    loop {
        let (result, asked) = stopped_at(problem, path, (phase, question));
        match count(&asked, phase) {
            0 => panic!("{path:?}: not asked while {phase}"),
            asked if asked <= question => question = asked - 1,
            _ => return result,
        }
    }
}

fn heard_in_each(path: SolverPath, phases: &[&'static str]) {
    let friction = SurfaceFriction::Coulomb(0.35);
    let problem = brick(5, BlockElement::Hex8, BrickLoad::Lift, friction).pose().problem;
    let (whole, asked) = stopped_at(&problem, path, (phases[0], usize::MAX));
    assert_eq!(whole.unwrap().status, Status::Solved);
    for phase in phases {
        let count = count(&asked, phase);
        assert!(count > 0, "{path:?}: not asked while {phase}");
        for question in [0, count / 2, count - 1] {
            match stopped(&problem, path, (phase, question)) {
                Ok(solution) => {
                    assert!(*phase == "iteration" || *phase == "solving", "{path:?}, {phase}");
                    assert_eq!(solution.status, Status::Interrupted, "{path:?}, {phase}, question {question}");
                    assert!(solution.u.iter().chain(&solution.lambda).all(|x| x.is_finite()));
                }
                Err(error) => assert!(error.interrupted && *phase != "iteration", "{path:?}, {phase}: {error}"),
            }
        }
    }
}

#[test]
fn a_stop_is_heard_in_each_phase_of_the_direct_paths() {
    for path in [SolverPath::Dense, SolverPath::Solves] {
        heard_in_each(path, &["ordering", "factorising", "iteration"]);
    }
}

#[test]
fn a_stop_is_heard_in_each_phase_of_multigrid() {
    heard_in_each(SolverPath::Multigrid, &["setting up", "iteration"]);
}

#[test]
fn the_observer_ends_a_solve_at_any_of_its_events() {
    let friction = SurfaceFriction::Coulomb(0.35);
    let problem = brick(4, BlockElement::Hex8, BrickLoad::Lift, friction).pose().problem;
    for (path, word) in [
        (SolverPath::Solves, "ordering"),
        (SolverPath::Solves, "factorising"),
        (SolverPath::Solves, "iteration"),
        (SolverPath::Multigrid, "setting up"),
        (SolverPath::Multigrid, "iteration"),
    ] {
        let settings = Settings { path, ..settings(1e-10) };
        let result = solve_with_kept(&problem, &settings, &mut Kept::default(), &mut |event| {
            if phase(event) == word { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        match result {
            Ok(solution) => assert!(word == "iteration" && solution.status == Status::Interrupted, "{path:?}, {word}"),
            Err(error) => assert!(word != "iteration" && error.interrupted, "{path:?}, {word}: {error}"),
        }
    }
}
