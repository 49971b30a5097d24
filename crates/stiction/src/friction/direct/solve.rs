use std::ops::ControlFlow;

use super::newton::{End, Iterate, Newton, Observe, TAME_SLOPE, newton};
use super::newton_system::{Linearized, NewtonSystem};
use super::proximal::proximal;
use super::rigid_start::{Foundation, Rest, balanced, keep_apart};
use crate::certificate::certify;
use crate::contact::equilibrium::no_equilibrium;
use crate::contact::{ContactProblem, Friction};
use crate::dual::Dual;
use crate::friction::PointState;
use crate::friction::law::{bound, frozen, residual, states};
use crate::friction::solution::{Counts, Phase, Progress, Settings, Solution, SolverPath, Status};
use crate::linalg::{axpy, norm};
use crate::qp::{PointSet, accelerated_gradient};

/// The parameter of the residual over the local stiffness. Near one, cases rich in sticking points cycle; far below,
/// points leave and enter contact late.
const PARAMETER: f64 = 0.1;
/// Forces below this part of the load are measured against it: where nothing touches there are none to compare with.
const LOOSE: f64 = 1e-3;
/// Products the trial with unlimited bounds may take.
const START_LIMIT: usize = 30;
/// Gradient steps after a stall.
const GRADIENT_STEPS: usize = 20;
/// Stalls answered by gradient steps before the fixed point takes over; and where the problem is convex, before the
/// proximal method does, which arrives from anywhere but takes more steps.
const RESTARTS: usize = 5;
const CONVEX_RESTARTS: usize = 2;

/// Solves contact with friction: Newton's method on the law itself; after a stall some accelerated gradient steps and
/// a smaller parameter; after repeated stalls the fixed point on the bounds of friction, whose problems are convex and are
/// solved by the proximal method of multipliers.
///
/// Bodies that contact alone holds start from their rest as rigid bodies on an elastic foundation; their rigid motions
/// are unknowns of each Newton step, and the balance of their forces is part of the residual. Gradient steps take
/// the body where it is; then it is moved to where its forces balance.
///
/// The answer is judged by its certificate: `Solved` is only reported if that passes, and a residual that was small
/// enough but did not certify is reduced further.
pub fn solve(
    problem: &ContactProblem,
    dual: &Dual,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Solution {
    let isotropic = problem.isotropic();
    let mut solver = Solver::new(problem, &isotropic, dual, settings);
    if no_equilibrium(problem, &dual.floating.motions).is_some() {
        return Solution { status: Status::NoEquilibrium, ..solver.finish(End::Stalled, settings.tolerance) };
    }
    // The certificate measures with other scales than the residual: the first target is a guess, then it is lowered.
    let mut tolerance = 0.03 * settings.tolerance;
    loop {
        let end = solver.ladder(tolerance, observer);
        if matches!(end, End::Limit | End::Stalled) {
            solver.return_to_best();
        }
        let solution = solver.finish(end, settings.tolerance);
        tolerance *= 0.1;
        if end != End::Converged || solution.certificate.passed || tolerance < 1e-4 * settings.tolerance {
            return solution;
        }
    }
}

/// How a solution by this operator is found.
pub(in crate::friction) fn path_of(dual: &Dual) -> SolverPath {
    if dual.is_dense() { SolverPath::Dense } else { SolverPath::Solves }
}

/// A loop of Newton steps: [`newton`] or [`proximal`].
type Method = fn(&Newton<'_>, &mut Iterate, &mut usize, &mut Observe<'_>) -> End;

/// The parameter of the residual at each point from the local stiffness of each row.
pub(in crate::friction) fn parameter(problem: &ContactProblem, stiffness: &[f64], factor: f64) -> Vec<f64> {
    let local = |j: usize| {
        let rows = problem.rows(j).map(|i| stiffness[i]);
        let live = rows.iter().filter(|&&k| k > 0.0).count().max(1);
        rows.iter().sum::<f64>() / live as f64
    };
    let fallback = stiffness.iter().fold(0.0, |a: f64, &b| a.max(b)).max(f64::MIN_POSITIVE);
    (0..problem.points()).map(|j| factor * PARAMETER * if local(j) > 0.0 { local(j) } else { fallback }).collect()
}

struct Solver<'a> {
    /// The problem as it was given, which the certificate judges.
    given: &'a ContactProblem,
    /// The same with discs for ellipses, which is solved.
    problem: &'a ContactProblem,
    dual: &'a Dual,
    live: Vec<bool>,
    stiffness: Vec<f64>,
    /// `v` at zero multipliers and zero rigid motions.
    v0: Vec<f64>,
    /// `Rᵀ f` on the rigid motions of floating bodies.
    resultant: Vec<f64>,
    at: Iterate,
    /// Where a run of steps ended with the least [merit](Self::merit), and that.
    best: Option<(f64, Iterate)>,
    steps_left: usize,
    max_steps: usize,
    counts: Counts,
    history: Vec<Progress>,
}

impl<'a> Solver<'a> {
    fn new(given: &'a ContactProblem, problem: &'a ContactProblem, dual: &'a Dual, settings: &Settings) -> Self {
        let stiffness = Dual::local_stiffness(problem);
        let live = stiffness.iter().map(|&k| k > 0.0).collect();
        let size = 3 * problem.points();
        let v0 = problem.opening(&dual.displacement(problem, &vec![0.0; size]));
        let at = match settings.start.as_ref().filter(|s| s.len() == size && s.iter().all(|x| x.is_finite())) {
            Some(start) => {
                let mut lambda = start.clone();
                given.to_isotropic(&mut lambda);
                let mut v = dual.times(&lambda);
                axpy(1.0, &v0, &mut v);
                Iterate { lambda, v, alpha: vec![0.0; dual.floating.len()] }
            }
            None => Iterate { lambda: vec![0.0; size], v: v0.clone(), alpha: vec![0.0; dual.floating.len()] },
        };
        let resultant = balanced(&dual.floating.motions, &problem.elastic.f);
        let (steps_left, max_steps) = (settings.max_iterations, settings.max_iterations);
        let (counts, history) = Default::default();
        Solver {
            given,
            problem,
            dual,
            live,
            stiffness,
            v0,
            resultant,
            at,
            best: None,
            steps_left,
            max_steps,
            counts,
            history,
        }
    }

    /// The parameter of the residual at each point.
    fn parameter(&self, factor: f64) -> Vec<f64> {
        parameter(self.problem, &self.stiffness, factor)
    }

    fn ladder(&mut self, tolerance: f64, observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>) -> End {
        let laws = self.problem.contact.friction.clone();
        let mut factor = 1.0;
        if self.at.lambda.iter().all(|&x| x == 0.0) {
            self.rigid_start();
            self.stick_start();
        }
        // Without a bound that follows the normal force the problem is convex.
        let convex = laws.iter().all(|&law| frozen(law, 1.0) == law);
        for _ in 0..if convex { CONVEX_RESTARTS } else { RESTARTS } {
            let end = self.steps(newton, &laws, Phase::Newton, factor, tolerance, observer);
            if end != End::Stalled {
                return end;
            }
            self.gradient_steps();
            factor /= 3.0;
        }
        if convex {
            let end = self.steps(proximal, &laws, Phase::Proximal, 1.0, tolerance, observer);
            if end != End::Stalled {
                return end;
            }
        }
        // Fixed point g -> F lambda_n(g); every step ends with an attempt of Newton on the law itself.
        while self.steps_left > 0 {
            self.counts.fixed_point_steps += 1;
            let frozen = self.frozen_laws();
            let accuracy = tolerance.max(1e-6);
            let end = self.steps(proximal, &frozen, Phase::FixedPoint, 1.0, accuracy, observer);
            match end {
                End::Stalled => self.gradient_steps(),
                End::Converged => {}
                End::Limit | End::Interrupted => return end,
            }
            let before = self.at.clone();
            let end = self.steps(newton, &laws, Phase::Newton, 1.0, tolerance, observer);
            if end != End::Stalled {
                return end;
            }
            self.at = before;
        }
        End::Limit
    }

    /// Bodies that float start where they rest as rigid bodies, with the forces of the foundation.
    fn rigid_start(&mut self) {
        let floating = &self.dual.floating;
        if floating.is_empty() {
            return;
        }
        let mut u = self.dual.displacement(self.problem, &vec![0.0; self.v0.len()]);
        // The springs bend a body whose loads they have to balance; one that is tightened or heated keeps its shape.
        let mut first = 0;
        for body in &floating.motions.bodies {
            let own = first..first + body.motions.len();
            first = own.end;
            if self.resultant[own].iter().any(|&e| e != 0.0) {
                body.unknowns.iter().for_each(|&i| u[i as usize] = 0.0);
            }
        }
        let mut opening = self.problem.opening(&u);
        let margin = keep_apart(&mut opening);
        let least = margin * self.parameter(1.0).iter().fold(0.0, |a: f64, r| a.max(*r));
        self.rest_on(&opening);
        if self.at.lambda.iter().all(|x| x.abs() <= least) {
            self.at.lambda.fill(0.0);
            self.refresh();
        } else {
            self.align();
        }
    }

    /// Moves floating bodies until the augmented multipliers of the present deformation balance their loads, and takes these
    /// for the multipliers.
    fn settle(&mut self) {
        if !self.dual.floating.is_empty() {
            self.rest_on(&self.augmented_opening());
            self.align();
        }
    }

    /// Moves floating bodies, with the multipliers as they are, to where the augmented ones balance their loads: the points
    /// that are then in contact hold the bodies, and the next step finds them there.
    fn align(&mut self) {
        self.at.alpha = self.rest(&self.augmented_opening()).alpha;
        self.refresh();
    }

    /// The opening at which a foundation exerts `lambda - r v`, where floating bodies have not moved.
    fn augmented_opening(&self) -> Vec<f64> {
        let r = self.parameter(1.0);
        let still: Vec<f64> = self.at.alpha.iter().map(|a| -a).collect();
        let mut opening = self.at.v.clone();
        self.dual.floating.close(&still, &mut opening);
        opening.iter_mut().enumerate().for_each(|(i, v)| *v -= self.at.lambda[i] / r[i % r.len()]);
        opening
    }

    fn rest(&self, opening: &[f64]) -> Rest {
        let (friction, jumps) = (&self.problem.contact.friction[..], &self.dual.floating.jumps[..]);
        let (resultant, stiffness) = (&self.resultant[..], &self.parameter(1.0)[..]);
        Foundation { friction, jumps, resultant, opening, stiffness }.rest()
    }

    /// Rigid motions and multipliers from the rest on the foundation with this opening at zero motions.
    fn rest_on(&mut self, opening: &[f64]) {
        Rest { alpha: self.at.alpha, lambda: self.at.lambda } = self.rest(opening);
        self.at.lambda.iter_mut().zip(&self.live).for_each(|(x, &live)| *x = if live { *x } else { 0.0 });
        make_admissible(&self.problem.contact.friction, &mut self.at.lambda);
        self.refresh();
    }

    /// A motion that nothing resisted for a while may have been long: what it rounded off `v` is restored.
    fn refresh(&mut self) {
        let floating = &self.dual.floating;
        if floating.is_empty() {
            return;
        }
        self.at.v = self.dual.times(&self.at.lambda);
        axpy(1.0, &self.v0, &mut self.at.v);
        floating.close(&self.at.alpha, &mut self.at.v);
    }

    /// From zero multipliers most points seem to slip, and where they stick the iteration has to find out one by one.
    /// One step with unlimited friction tells; its result is kept if most points do stick there. Not so for large
    /// coefficients, whose slipping points need the tame steps that a start far away brings.
    fn stick_start(&mut self) {
        let unlimited = |&law: &Friction| match law {
            Friction::Given { slip_bound } if slip_bound > 0.0 => Friction::Given { slip_bound: f64::MAX },
            Friction::Coulomb { coefficient } if coefficient > 0.0 && coefficient <= TAME_SLOPE => {
                Friction::Coulomb { coefficient: f64::MAX }
            }
            Friction::Limited { coefficient, limit } if coefficient.min(limit) > 0.0 && coefficient <= TAME_SLOPE => {
                Friction::Coulomb { coefficient: f64::MAX }
            }
            other => other,
        };
        let stuck: Vec<Friction> = self.problem.contact.friction.iter().map(unlimited).collect();
        if stuck == self.problem.contact.friction || self.steps_left == 0 {
            return;
        }
        let (r, at) = (self.parameter(1.0), &self.at);
        let system = NewtonSystem::new(&Linearized {
            friction: &stuck,
            largest_slope: 0.0,
            live: &self.live,
            stiffness: &self.stiffness,
            lambda: &at.lambda,
            v: &at.v,
            r: &r,
            centre: None,
        });
        let floating = &self.dual.floating;
        let imbalance = floating.imbalance(&self.resultant, &at.lambda);
        let step = system.solve(self.dual, &floating.jumps, &imbalance, 0.1, START_LIMIT);
        let mut next = at.clone();
        axpy(1.0, &step.d, &mut next.lambda);
        axpy(1.0, &step.dv, &mut next.v);
        axpy(1.0, &step.d_alpha, &mut next.alpha);
        let found = states(&self.problem.contact.friction, &next.lambda, &next.v, &r);
        let count = |s| found.iter().filter(|&&x| x == s).count();
        self.steps_left -= 1;
        if count(PointState::Stick) >= count(PointState::Slip).max(usize::from(!floating.is_empty())) {
            self.at = next;
        }
    }

    /// A run of Newton steps by `method` for the `laws`, with `factor` times the usual parameter.
    fn steps(
        &mut self,
        method: Method,
        laws: &[Friction],
        phase: Phase,
        factor: f64,
        tolerance: f64,
        observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> End {
        let r = self.parameter(factor);
        self.refresh();
        let on = Newton {
            dual: self.dual,
            friction: laws,
            live: &self.live,
            stiffness: &self.stiffness,
            r: &r,
            resultant: &self.resultant,
            loose: LOOSE * norm(&self.problem.elastic.f),
            tolerance,
        };
        let (history, dual) = (&mut self.history, self.dual);
        let first = self.max_steps - self.steps_left;
        let mut iteration = first;
        let mut observe = |theta: f64, scale: f64, states: &[PointState]| {
            let count = |s| states.iter().filter(|&&x| x == s).count();
            let progress = Progress {
                phase,
                iteration,
                residual: if scale > 0.0 { theta / scale } else { f64::from(u8::from(theta > 0.0)) },
                products: dual.products(),
                open: count(PointState::Open),
                stick: count(PointState::Stick),
                slip: count(PointState::Slip),
            };
            iteration += 1;
            history.push(progress);
            observer(&progress)
        };
        let end = method(&on, &mut self.at, &mut self.steps_left, &mut observe);
        let merit = self.merit();
        if self.best.as_ref().is_none_or(|(least, _)| merit < *least) {
            self.best = Some((merit, self.at.clone()));
        }
        end
    }

    /// Norm of the residual of the law itself and of what forces on floating bodies lack of balance, newton.
    fn merit(&self) -> f64 {
        let lacking = self.dual.floating.imbalance(&self.resultant, &self.at.lambda);
        norm(&residual(&self.problem.contact.friction, &self.at.lambda, &self.at.v, &self.parameter(1.0)))
            .hypot(norm(&lacking))
    }

    /// What ends unsolved is told where it was nearest to a solution: a body that nothing holds may have gone far since.
    fn return_to_best(&mut self) {
        if let Some((_, best)) = self.best.take() {
            self.at = best;
        }
    }

    /// Given friction with the bounds of the present normal forces.
    fn frozen_laws(&self) -> Vec<Friction> {
        self.problem.contact.friction.iter().zip(&self.at.lambda).map(|(&law, &normal)| frozen(law, normal)).collect()
    }

    fn gradient_steps(&mut self) {
        self.counts.restarts += 1;
        let sets: Vec<PointSet> = (self.frozen_laws().iter())
            .map(|law| match *law {
                Friction::Given { slip_bound } => PointSet::HalfLineAndDisc { radius: slip_bound },
                Friction::Bonded => PointSet::Free,
                Friction::None | Friction::Coulomb { .. } | Friction::Limited { .. } => {
                    PointSet::HalfLineAndDisc { radius: 0.0 }
                }
            })
            .collect();
        // Bodies that float are held by their springs where they are.
        let mut v0 = self.v0.clone();
        self.dual.floating.close(&self.at.alpha, &mut v0);
        let b: Vec<f64> = v0.iter().map(|v| -v).collect();
        let q_lambda: Vec<f64> = self.at.v.iter().zip(&v0).map(|(v, v0)| v - v0).collect();
        let weight = self.parameter(1.0);
        let operator = |x: &[f64]| {
            let masked: Vec<f64> = x.iter().zip(&self.live).map(|(x, &l)| if l { *x } else { 0.0 }).collect();
            self.dual.times(&masked)
        };
        let found = accelerated_gradient(operator, &b, &sets, &weight, &self.at.lambda, &q_lambda, GRADIENT_STEPS);
        self.at.lambda = found.x;
        self.at.lambda.iter_mut().zip(&self.live).for_each(|(x, &live)| *x = if live { *x } else { 0.0 });
        self.at.v = found.a_times_x.iter().zip(&v0).map(|(q, v0)| q + v0).collect();
        self.settle();
    }

    /// Makes the multipliers admissible, recomputes everything from them and lets the certificate judge.
    fn finish(&mut self, end: End, tolerance: f64) -> Solution {
        let r = self.parameter(1.0);
        let found = states(&self.problem.contact.friction, &self.at.lambda, &self.at.v, &r);
        let mut lambda = self.at.lambda.clone();
        make_admissible(&self.problem.contact.friction, &mut lambda);
        let mut u = self.dual.displacement(self.problem, &lambda);
        self.dual.floating.motions.add(&self.at.alpha, &mut u);
        self.at.v = self.problem.opening(&u);
        self.at.lambda = lambda;
        let mut lambda = self.at.lambda.clone();
        self.given.out_of_isotropic(&mut lambda);
        let certificate = certify(self.given, &u, &lambda, tolerance);
        let status = match end {
            End::Interrupted => Status::Interrupted,
            _ if certificate.passed => Status::Solved,
            End::Limit => Status::MaxIterations,
            End::Stalled | End::Converged => Status::Stalled,
        };
        self.counts.newton_steps = self.max_steps - self.steps_left;
        self.counts.products = self.dual.products();
        self.counts.solves = self.dual.solves();
        let (counts, history) = (self.counts, self.history.clone());
        let path = path_of(self.dual);
        Solution { status, path, u, lambda, states: found, certificate, counts, history }
    }
}

/// Removes what rounding and the tolerance left outside the law's set: tension, and friction beyond its bound.
pub(in crate::friction) fn make_admissible(friction: &[Friction], lambda: &mut [f64]) {
    let m = friction.len();
    for (j, &law) in friction.iter().enumerate() {
        if law == Friction::Bonded {
            continue;
        }
        lambda[j] = lambda[j].max(0.0);
        let (limit, length) = (bound(law, lambda[j]), lambda[m + j].hypot(lambda[2 * m + j]));
        if length > limit {
            let shrink = limit / length;
            lambda[m + j] *= shrink;
            lambda[2 * m + j] *= shrink;
        }
    }
}
