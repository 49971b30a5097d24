use std::ops::ControlFlow;

use super::V3;
use super::admm::alternating_directions;
use super::blocks::Blocks;
use super::gradient::{ROUND, fixed_point};
use super::measures::measure;
use super::monitor::{Judged, Monitor};
use super::problem::LocalProblem;
use super::proximal::proximal;
use super::settings::{Method, Progress, Settings, Solution, Status};
use super::system::Discrete;
use crate::linalg::norm;

/// Solves a local problem without bilateral part by the method of the settings.
///
/// The answer is judged on the problem as it was given; `Solved` is only reported if all three residuals pass.
pub fn solve(
    problem: &LocalProblem,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Solution {
    let blocks = Blocks::new(problem);
    let traces = problem.traces();
    let judge = |r: &[V3]| {
        let r = blocks.unscaled(r);
        let mut u = problem.W.times(&r);
        u.iter_mut().zip(&problem.q).for_each(|(u, q)| *u += q);
        let measures = measure(problem.dimension, &problem.mu, &traces, &problem.q, &r, &u);
        Judged { r, u, measures }
    };
    let start = match settings.start.as_ref().filter(|s| s.len() == problem.q.len()) {
        Some(start) if start.iter().all(|x| x.is_finite()) => blocks.scaled(start),
        _ => vec![[0.0; 3]; problem.mu.len()],
    };
    let mut monitor = Monitor::new(&problem.mu, norm(&problem.q), &judge, settings, observer);
    let status = iterate(&blocks, start, settings.method, &mut monitor);
    monitor.solution(status)
}

/// The iteration of a method from scaled impulses `r`.
pub(super) fn iterate(system: &dyn Discrete, r: Vec<V3>, method: Method, monitor: &mut Monitor) -> Status {
    match method {
        Method::Auto => proximal(system, r, true, monitor),
        Method::Newton => proximal(system, r, false, monitor),
        Method::GaussSeidel => gauss_seidel(system, r, monitor),
        Method::Gradient => fixed_point(system, r, monitor),
        Method::Admm => alternating_directions(system, r, monitor),
    }
}

fn gauss_seidel(system: &dyn Discrete, mut r: Vec<V3>, monitor: &mut Monitor) -> Status {
    loop {
        if let Some(status) = monitor.ends(&r, 0.0) {
            return status;
        }
        if !system.sweep(&mut r, ROUND) {
            return Status::Stalled;
        }
        monitor.counts.sweeps += ROUND;
        monitor.counts.iterations += 1;
    }
}
