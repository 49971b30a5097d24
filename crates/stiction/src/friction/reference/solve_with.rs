use super::method::{Given, Method, MethodCounts, MethodReport, MethodSettings, MethodStep, Start};
use super::quadratic::{MOST_STORED, Quadratic};
use super::run_method::{is_exact, run_method};
use crate::Error;
use crate::certificate::certify;
use crate::contact::ContactProblem;
use crate::dual::Dual;
use crate::friction::direct::{make_admissible, path_of, solve};
use crate::friction::law::{augmented, parameters, state};
use crate::friction::solution::{Counts, End, Phase, Progress, Settings, Solution, Status};
use crate::friction::system::by_point;
use crate::linalg::Watch;

/// A solution and what the method has to tell about how it got there.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The solution with its certificate.
    pub solution: Solution,
    /// `None` for Newton's method, which ends by the certificate.
    pub method: Option<MethodReport>,
}

/// Targets below this part of the certificate's tolerance ask for rounding.
const LOWEST_TARGET: f64 = 1e-4;

/// Rows up to which storing `Q` pays for methods that take no more than some hundred products.
const MOST_STORED_FRUGAL: usize = 600;

/// Solves by any of the methods; the certificate judges all of them by the law itself.
///
/// Methods with squares solve a problem with polygons around the discs of friction. Where there is such a disc their
/// answer does not pass the certificate however far they converge: its status is [`Status::Uncertified`] then. The
/// others are run to tolerances of their own that fall until the certificate passes.
///
/// # Errors
/// As [`run_method`]; or a body floats and the method is not Newton's, which alone keeps its forces in balance.
pub fn solve_with(
    problem: &ContactProblem,
    dual: &Dual,
    settings: &Settings,
    method: &MethodSettings,
    observer: &mut Watch<Progress>,
) -> Result<Answer, Error> {
    if method.method == Method::Newton {
        return Ok(Answer { solution: solve(problem, dual, settings, observer), method: None });
    }
    if !dual.floating.is_empty() {
        return Err(Error::new(
            "",
            "a body is held by contact alone, and this method is for bodies that supports hold",
            "take Newton's method (`method.method`), or hold the body in `elastic.K`",
        ));
    }
    let frugal = matches!(method.method.given(), Some(Given::AdaptiveUzawa | Given::Discs));
    let given = problem;
    let problem = &*given.isotropic();
    let q = Quadratic::stored_up_to(if frugal { MOST_STORED_FRUGAL } else { MOST_STORED }, problem, dual);
    let exact = is_exact(&problem.contact.friction, &q.has_row, method);
    let phase = phase(method.method);
    let mut next = method.clone();
    if settings.start.is_some() && next.start.lambda.is_none() {
        next.start.lambda.clone_from(&settings.start);
    }
    if let Some(lambda) = next.start.lambda.as_mut().filter(|start| start.len() == 3 * problem.points()) {
        given.to_isotropic(lambda);
    }
    let mut spent = MethodCounts::default();
    let mut history = Vec::new();
    loop {
        let before = spent;
        let mut observe = |step: &MethodStep| {
            let step = progress(phase, step, &before);
            history.push(step);
            observer(&step)
        };
        let mut report = run_method(&q, &problem.contact.friction, &next, &mut observe)?;
        spent.add(&report.counts);
        report.counts = spent;
        let solution = judge(given, problem, dual, exact, &report, settings.tolerance, &history);
        next.tolerance *= 0.1;
        next.agreement *= 0.1;
        next.inner_tolerance *= 0.1;
        next.max_iterations = method.max_iterations.saturating_sub(spent.iterations);
        let hopeless = !exact || next.tolerance < LOWEST_TARGET * settings.tolerance || next.max_iterations == 0;
        if report.end != End::Converged || solution.certificate.passed || hopeless {
            return Ok(Answer { solution, method: Some(report) });
        }
        next.start = Start { slip_bound: Some(report.slip_bound), w: Some(report.w), lambda: Some(report.lambda) };
    }
}

fn phase(method: Method) -> Phase {
    match method {
        Method::FixedPoint(_) | Method::InexactFixedPoint(_) => Phase::FixedPoint,
        Method::Given(Given::Discs) => Phase::Gradient,
        Method::Given(_) | Method::Newton => Phase::Uzawa,
    }
}

fn progress(phase: Phase, step: &MethodStep, before: &MethodCounts) -> Progress {
    Progress {
        phase,
        iteration: before.iterations + step.iteration,
        residual: step.change,
        products: before.products + step.products,
        open: step.open,
        stick: step.stick,
        slip: step.slip,
    }
}

/// Recomputes everything from the multipliers and lets the certificate judge.
#[allow(clippy::too_many_arguments)]
fn judge(
    given: &ContactProblem,
    problem: &ContactProblem,
    dual: &Dual,
    exact: bool,
    report: &MethodReport,
    tolerance: f64,
    history: &[Progress],
) -> Solution {
    let mut lambda = report.lambda.clone();
    if exact {
        make_admissible(&problem.contact.friction, &mut lambda);
    }
    let u = dual.displacement(problem, &lambda);
    let isotropic = by_point(&lambda);
    given.out_of_isotropic(&mut lambda);
    let certificate = certify(given, &u, &lambda, tolerance);
    let status = match report.end.status(certificate.passed) {
        Status::Stalled if report.end == End::Converged => Status::Uncertified,
        status => status,
    };
    let states = if exact {
        let (r, v) = (parameters(problem, &Dual::local_stiffness(problem)), by_point(&problem.gap_and_slip(&u)));
        let state = |j: usize| state(problem.contact.friction[j], augmented(isotropic[j], v[j], r[j]));
        (0..problem.points()).map(state).collect()
    } else {
        report.states.clone()
    };
    let counts = Counts {
        fixed_point_steps: report.counts.fixed_point_steps,
        products: report.counts.products,
        solves: dual.solves(),
        ..Counts::default()
    };
    let path = path_of(dual);
    Solution { status, path, u, lambda, states, certificate, counts, history: history.to_vec() }
}
