use super::V3;
use super::admm::alternating_directions;
use super::blocks::Blocks;
use super::gradient::{ROUND, fixed_point};
use super::monitor::Monitor;
use super::problem::LocalProblem;
use super::proximal::proximal;
use super::settings::{Method, Progress, Settings, Solution, Status};
use super::sweeps::sweep;
use super::system::Discrete;
use crate::Error;
use crate::linalg::{Watch, axpy};

/// Solves a local problem without bilateral part by the method of the settings.
///
/// The answer is judged on the problem as it was given; `Solved` is only reported if all measures pass.
///
/// # Errors
/// If the start has another length than the problem needs, or holds values that are not finite.
pub fn solve(problem: &LocalProblem, settings: &Settings, observer: &mut Watch<Progress>) -> Result<Solution, Error> {
    let blocks = Blocks::new(problem);
    let velocity = |r: &[f64]| {
        let mut u = problem.W.times(r);
        axpy(1.0, &problem.q, &mut u);
        u
    };
    let system = Discrete::new(problem.dimension, &problem.mu, &problem.q, &blocks);
    system.solve(&problem.traces(), &problem.q, &velocity, settings, observer)
}

/// The iteration of a method from scaled impulses `r`.
pub(super) fn iterate(system: &Discrete<'_>, r: Vec<V3>, method: Method, monitor: &mut Monitor) -> Status {
    match method {
        Method::Auto => proximal(system, r, true, monitor),
        Method::Newton => proximal(system, r, false, monitor),
        Method::GaussSeidel => gauss_seidel(system, r, monitor),
        Method::Gradient => fixed_point(system, r, monitor),
        Method::Admm => alternating_directions(system, r, monitor),
    }
}

fn gauss_seidel(system: &Discrete<'_>, mut r: Vec<V3>, monitor: &mut Monitor) -> Status {
    loop {
        if let Some(status) = monitor.ends(&r, 0.0) {
            return status;
        }
        if !sweep(system, &mut r, ROUND) {
            return Status::Stalled;
        }
        monitor.counts.sweeps += ROUND;
        monitor.counts.iterations += 1;
    }
}
