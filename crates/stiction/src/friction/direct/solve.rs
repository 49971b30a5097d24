use super::dual_system::DualSystem;
use super::proximal::proximal;
use super::rigid_start::balanced;
use crate::certificate::{Certificate, certify};
use crate::contact::equilibrium::no_equilibrium;
use crate::contact::{ContactProblem, Friction};
use crate::dual::Dual;
use crate::friction::PointState;
use crate::friction::law::{V3, frozen, parameters, projection};
use crate::friction::solution::{Counts, End, Phase, Progress, Settings, Solution, SolverPath, Status};
use crate::friction::strength::solve_with_strength;
use crate::friction::system::{
    Descent, Iterate, Newton, Observe, Rules, System, accelerated_gradients, by_component, by_point, length, newton,
};
use crate::linalg::{Watch, axpy, norm};

/// Thresholds of Newton's method on the dual.
pub(super) const RULES: Rules = Rules {
    patience: 4,
    shortest: 1.0 / 64.0,
    leaps: 0,
    // Coefficients up to this are harmless from the start (measured: 0.1 to 20 on four loads of the brick).
    largest_slope: 2.5,
    accuracy: 1e-2,
};
/// Thresholds of the strategy. Together with [`RULES`] they leave one of the random cases 0 to 1500 unsolved; single values were
/// varied only where their line says so.
struct Threshold;

impl Threshold {
    /// The accuracy of a step where bodies float: one that is soft and thin bends far under small differences of the forces
    /// on its two sides, and an inaccurate step turns points at its edges open and closed in cycles (measured on a gasket: 1e-3
    /// cycles, and 1e-4 takes fewer products in all even where 1e-2 converges).
    const ACCURACY_FLOATING: f64 = 1e-4;
    /// Forces below this part of the load are measured against it: where nothing touches there are none to compare with.
    const FLOOR: f64 = 1e-3;
    /// The first target of the residual over the tolerance of the certificate, which measures with other scales; it falls by
    /// `Self::FALL` where the certificate does not pass, down to `Self::LOWEST`.
    const FIRST_TARGET: f64 = 0.03;
    const FALL: f64 = 0.1;
    const LOWEST: f64 = 1e-4;
    /// Measures up to this times the tolerance at which a stall may be one of rounding.
    const ROUNDING: f64 = 1e3;
    /// Forces of a pair below this part of those of the largest are rounding, which no weight makes known.
    const LEAST_PAIR: f64 = 1e-12;
    /// Gradient steps after a stall, and what the parameter of the residual is divided by then.
    const GRADIENT_STEPS: usize = 20;
    const SMALLER_PARAMETER: f64 = 3.0;
    /// Relative accuracy of the step that takes back what rounding has left.
    const CORRECTION: f64 = 1e-6;
    /// Part of the residual of the law itself, at most one, to which a step of the fixed point is solved.
    const FIXED_POINT_PART: f64 = 1e-2;
}

/// What a stage of the strategy runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Run {
    /// Newton's method on the law itself. A stall is answered by gradient steps and a smaller parameter.
    Newton,
    /// The proximal method of multipliers.
    Proximal,
    /// One step of the fixed point on the bounds of friction, then an attempt of Newton's method on the law itself.
    FixedPoint,
}

/// A stage of the strategy: entered by convex problems (no bound of friction follows the normal force) or by the
/// others, when `attempts` of the stage before have stalled.
struct Stage {
    run: Run,
    convex: bool,
    attempts: usize,
}

/// All stages share the steps that the settings allow.
const STRATEGY: [Stage; 5] = [
    // The proximal method arrives from anywhere, but takes more steps: two stalls are enough to change.
    Stage { run: Run::Newton, convex: true, attempts: 2 },
    Stage { run: Run::Proximal, convex: true, attempts: 1 },
    Stage { run: Run::FixedPoint, convex: true, attempts: usize::MAX },
    // The problems of the fixed point are convex, and the proximal method solves them; there are many of them.
    Stage { run: Run::Newton, convex: false, attempts: 5 },
    Stage { run: Run::FixedPoint, convex: false, attempts: usize::MAX },
];

/// Solves contact with friction: Newton's method on the law itself; after a stall some accelerated gradient steps and
/// a smaller parameter; after repeated stalls the fixed point on the bounds of friction, whose problems are convex and are
/// solved by the proximal method of multipliers.
///
/// Bodies that contact alone holds start from their equilibrium as rigid bodies on an elastic foundation; their rigid
/// motions are unknowns of each Newton step, and the balance of their forces is part of the residual. Gradient steps take
/// the body where it is; then it is moved to where its forces balance. Slender bodies start from contact without friction.
///
/// The answer is judged by its certificate: `Solved` is only reported if that passes, and a residual that was small
/// enough but did not certify is reduced further.
///
/// # Panics
/// If the start has another length than `3m`; [`Settings::validate`] checks it.
pub fn solve(problem: &ContactProblem, dual: &Dual, settings: &Settings, observer: &mut Watch<Progress>) -> Solution {
    let judge = (problem, settings.tolerance);
    let mut shifted = |problem: &ContactProblem, settings: &Settings| judged(problem, judge, dual, settings, observer);
    if let Some(solution) = solve_with_strength(problem, settings, &mut shifted) {
        return solution;
    }
    judged(problem, judge, dual, settings, observer)
}

/// The same for a problem without strengths, judged by the one that it was made of and its tolerance: forces that are far smaller than
/// strengths are known to it as exactly as rounding allows, which a certificate of the problem without cannot tell.
fn judged(
    problem: &ContactProblem,
    judge: (&ContactProblem, f64),
    dual: &Dual,
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Solution {
    let isotropic = problem.isotropic();
    let mut solver = Solver::new((problem, judge), &isotropic, dual, settings);
    if no_equilibrium(problem, &dual.floating.motions).is_some() {
        return Solution { status: Status::NoEquilibrium, ..solver.finish(End::Stalled) };
    }
    let mut tolerance = Threshold::FIRST_TARGET * settings.tolerance;
    let mut by_pairs = false;
    loop {
        let end = solver.run_strategy(tolerance, observer);
        if matches!(end, End::Limit | End::Stalled) {
            solver.return_to_best();
        }
        let mut solution = solver.finish(end);
        let ended = matches!(end, End::Converged | End::Stalled);
        if ended && !solution.certificate.is_as_good_as_the_data() && !solver.refines {
            solver.refines = true;
            solution = solver.finish(end);
            if end == End::Stalled && solution.certificate.worst <= Threshold::ROUNDING * judge.1 {
                // The steps may have stalled at the rounding of `v`, which is gone now.
                solver.best = None;
                continue;
            }
        }
        let certificate = &solution.certificate;
        if end != End::Converged || certificate.is_as_good_as_the_data() {
            return solution;
        }
        if !by_pairs && certificate.worst <= judge.1 {
            // The whole is solved, a pair or a body that carries little is not.
            by_pairs = true;
            solver.weigh_pairs();
            tolerance = Threshold::FIRST_TARGET * certificate.part_tolerance();
        } else {
            tolerance *= Threshold::FALL;
        }
        if tolerance < Threshold::LOWEST * settings.tolerance {
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

pub(super) struct Solver<'a> {
    /// The problem as it was given.
    given: &'a ContactProblem,
    /// What the certificate judges, and its tolerance: the same or the one with strengths.
    judge: (&'a ContactProblem, f64),
    /// The same with discs for ellipses, which is solved.
    pub problem: &'a ContactProblem,
    pub system: DualSystem<'a>,
    /// The parameter of the residual at each point, force per length.
    pub r: Vec<f64>,
    /// What norms weigh the forces of each point with.
    pub weight: Vec<f64>,
    /// `v` at zero multipliers and zero rigid motions, `[all v_n; all v_t1; all v_t2]`.
    pub v0: Vec<f64>,
    pub at: Iterate,
    /// Where a run of steps ended with the least [merit](Newton::merit), and that.
    best: Option<(f64, Iterate)>,
    /// Whether displacements are refined: where the certificate does not pass what rounding has left of them may be why.
    refines: bool,
    pub steps_left: usize,
    max_steps: usize,
    counts: Counts,
    history: Vec<Progress>,
}

impl<'a> Solver<'a> {
    fn new(
        (given, judge): (&'a ContactProblem, (&'a ContactProblem, f64)),
        problem: &'a ContactProblem,
        dual: &'a Dual,
        settings: &'a Settings,
    ) -> Self {
        let resultant = balanced(&dual.floating.motions, &problem.elastic.f);
        let system = DualSystem::new(problem, dual, resultant, &settings.stop);
        let size = 3 * problem.points();
        let v0 = problem.gap_and_slip(&dual.displacement(problem, &vec![0.0; size]));
        let mut alpha = vec![0.0; dual.floating.len()];
        let at = match &settings.start {
            Some(start) => {
                let mut lambda = start.clone();
                given.to_isotropic(&mut lambda);
                if let Some(u) = settings.start_displacement.as_ref().filter(|_| !alpha.is_empty()) {
                    // Bodies that float are where they were: the multipliers alone do not tell.
                    let deformed = dual.displacement(problem, &lambda);
                    let rest: Vec<f64> = u.iter().zip(deformed).map(|(u, deformed)| u - deformed).collect();
                    alpha = dual.floating.motions.work(&rest);
                }
                let mut v = dual.times(&lambda);
                axpy(1.0, &v0, &mut v);
                dual.floating.close(&alpha, &mut v);
                Iterate { lambda: by_point(&lambda), v: by_point(&v), alpha }
            }
            None => Iterate { lambda: vec![[0.0; 3]; problem.points()], v: by_point(&v0), alpha },
        };
        let r = parameters(problem, &by_component(&system.stiffness));
        let (steps_left, max_steps) = (settings.max_iterations, settings.max_iterations);
        let (counts, history) = Default::default();
        let weight = vec![1.0; problem.points()];
        let (best, refines) = (None, false);
        Solver {
            given,
            judge,
            problem,
            system,
            r,
            weight,
            v0,
            at,
            best,
            refines,
            steps_left,
            max_steps,
            counts,
            history,
        }
    }

    /// From here on each pair counts by its own forces: they are weighed to the size of the largest. What a pair that carries
    /// nothing has left of rounding stays as it is.
    fn weigh_pairs(&mut self) {
        let pairs = &self.given.labels.pairs;
        let forces = pairs.iter().map(|pair| length(&self.at.lambda[pair.points.clone()])).collect::<Vec<f64>>();
        let largest = forces.iter().fold(0.0, |a: f64, b| a.max(*b));
        for (pair, force) in pairs.iter().zip(forces) {
            let carries = force > Threshold::LEAST_PAIR * largest;
            self.weight[pair.points.clone()].fill(if carries { largest / force } else { 1.0 });
        }
        self.best = None;
    }

    pub(super) fn dual(&self) -> &'a Dual {
        self.system.dual
    }

    pub(super) fn friction(&self) -> &'a [Friction] {
        &self.problem.contact.friction
    }

    fn run_strategy(&mut self, tolerance: f64, observer: &mut Watch<Progress>) -> End {
        if self.at.lambda.iter().all(|x| *x == [0.0; 3]) {
            self.rigid_start();
            if let Some(end) = self.slender_start(observer) {
                return end;
            }
        }
        let laws = self.friction();
        let convex = laws.iter().all(|&law| frozen(law, 1.0) == law);
        for stage in STRATEGY.iter().filter(|stage| stage.convex == convex) {
            let mut factor = 1.0;
            for _ in 0..stage.attempts {
                let end = match stage.run {
                    Run::Newton => self.steps(newton, laws, Phase::Newton, factor, tolerance, observer),
                    Run::Proximal => self.steps(proximal, laws, Phase::Proximal, factor, tolerance, observer),
                    Run::FixedPoint => self.fixed_point_step(tolerance, observer),
                };
                if end != End::Stalled {
                    return end;
                }
                if stage.run == Run::Newton {
                    self.gradient_steps();
                    factor /= Threshold::SMALLER_PARAMETER;
                }
            }
        }
        End::Stalled
    }

    /// A step of `g -> F lambda_n(g)`, then an attempt of Newton on the law itself; where that stalls it leaves no trace.
    fn fixed_point_step(&mut self, tolerance: f64, observer: &mut Watch<Progress>) -> End {
        if self.steps_left == 0 {
            return End::Limit;
        }
        self.counts.fixed_point_steps += 1;
        let frozen = self.frozen_laws();
        let law = self.newton(self.friction(), &self.r, tolerance);
        let scale = law.weighed(&self.at.lambda).max(f64::MIN_POSITIVE);
        // Less than it is now, or the step would be none.
        let residual = law.merit(&self.at).min(10.0 * self.newton(&frozen, &self.r, tolerance).merit(&self.at)) / scale;
        let target = tolerance.max(Threshold::FIXED_POINT_PART * residual.min(1.0));
        match self.steps(proximal, &frozen, Phase::FixedPoint, 1.0, target, observer) {
            End::Stalled => self.gradient_steps(),
            End::Converged => {}
            end => return end,
        }
        let before = self.at.clone();
        let end = self.steps(newton, self.friction(), Phase::Newton, 1.0, tolerance, observer);
        if end == End::Stalled {
            self.at = before;
        }
        end
    }

    /// A motion that nothing resisted for a while may have been long: what it rounded off `v` is restored.
    pub(super) fn refresh(&mut self) {
        let floating = &self.dual().floating;
        if floating.is_empty() {
            return;
        }
        let lambda = by_component(&self.at.lambda);
        if self.refines {
            self.at.v = by_point(&self.problem.gap_and_slip(&self.displacement(&lambda)));
            return;
        }
        let mut v = self.dual().times(&lambda);
        axpy(1.0, &self.v0, &mut v);
        floating.close(&self.at.alpha, &mut v);
        self.at.v = by_point(&v);
    }

    /// The displacements under `lambda`, those of the rigid motions included.
    fn displacement(&self, lambda: &[f64]) -> Vec<f64> {
        let mut u = self.dual().displacement(self.problem, lambda);
        if self.refines {
            self.dual().refine(self.problem, lambda, &mut u);
        }
        self.dual().floating.motions.add(&self.at.alpha, &mut u);
        u
    }

    /// Newton's method on `laws`.
    pub(super) fn newton<'b>(&'b self, laws: &'b [Friction], r: &'b [f64], tolerance: f64) -> Newton<'b> {
        let mut rules = RULES;
        if !self.dual().floating.is_empty() {
            rules.accuracy = Threshold::ACCURACY_FLOATING;
        }
        let absolute = tolerance * Threshold::FLOOR * norm(&self.problem.elastic.f);
        let weight = &self.weight;
        Newton { system: &self.system, friction: laws, r, weight, proximal: None, tolerance, absolute, rules }
    }

    /// A run of Newton steps by `method` for the `laws`, with `factor` times the usual parameter.
    pub(super) fn steps(
        &mut self,
        method: Method,
        laws: &[Friction],
        phase: Phase,
        factor: f64,
        tolerance: f64,
        observer: &mut Watch<Progress>,
    ) -> End {
        self.refresh();
        let r: Vec<f64> = self.r.iter().map(|r| factor * r).collect();
        let (mut history, mut at) = (std::mem::take(&mut self.history), self.at.clone());
        let mut steps_left = self.steps_left;
        let mut iteration = self.max_steps - steps_left;
        let mut observe = |_: &Iterate, theta: f64, scale: f64, states: &[PointState]| {
            let [open, stick, slip] = PointState::count(states);
            let progress = Progress {
                phase,
                iteration,
                residual: if scale > 0.0 { theta / scale } else { f64::from(u8::from(theta > 0.0)) },
                products: self.system.dual.products(),
                open,
                stick,
                slip,
            };
            iteration += 1;
            history.push(progress);
            observer(&progress)
        };
        let end = method(&self.newton(laws, &r, tolerance), &mut at, &mut steps_left, &mut observe);
        // A linear system that was stopped gives a step of no use, after which the method may well say that it stalls.
        let end = if self.system.stop.asked() { End::Interrupted } else { end };
        (self.history, self.at, self.steps_left) = (history, at, steps_left);
        let merit = self.newton(self.friction(), &self.r, tolerance).merit(&self.at);
        if self.best.as_ref().is_none_or(|(least, _)| merit < *least) {
            self.best = Some((merit, self.at.clone()));
        }
        end
    }

    /// On failure the best iterate is returned: a body that nothing holds may have gone far since.
    fn return_to_best(&mut self) {
        if let Some((_, best)) = self.best.take() {
            self.at = best;
        }
    }

    /// Given friction with the bounds of the present normal forces.
    fn frozen_laws(&self) -> Vec<Friction> {
        self.friction().iter().zip(&self.at.lambda).map(|(&law, lambda)| frozen(law, lambda[0])).collect()
    }

    fn gradient_steps(&mut self) {
        self.counts.restarts += 1;
        let laws = self.frozen_laws();
        // Bodies that float are held by their springs where they are.
        let mut v0 = self.v0.clone();
        self.dual().floating.close(&self.at.alpha, &mut v0);
        let v = |lambda: &[V3]| {
            let mut v = self.dual().times(&by_component(lambda));
            axpy(1.0, &v0, &mut v);
            by_point(&v)
        };
        let nearest = |j: usize, lambda: V3| self.system.masked(j, projection(laws[j], lambda));
        let on = Descent { v: &v, nearest: &nearest, weight: &self.r, reduction: 0.0, stop: self.system.stop };
        let Iterate { mut lambda, v: mut gap, alpha } = self.at.clone();
        accelerated_gradients(&on, &mut lambda, &mut gap, &mut 1.0, Threshold::GRADIENT_STEPS);
        self.at = Iterate { lambda, v: gap, alpha };
        self.settle();
    }

    /// Takes the displacements of one more Newton step. A slender body turns the last digit of the multipliers into displacements
    /// that contact notices (a belt of 0.5 around a radius of 100: 1e-6 of its forces): the multipliers cannot hold what
    /// this step adds to them, and equilibrium does not notice it.
    fn correct(&mut self, u: &mut [f64], tolerance: f64) {
        let newton = self.newton(self.friction(), &self.r, tolerance);
        let laws = newton.linearised(&self.at, f64::INFINITY);
        let Some(step) = self.system.step(&self.at, &laws, Threshold::CORRECTION) else { return };
        let next = self.system.advance(&self.at, 1.0, &step);
        let falls = newton.merit(&next) < newton.merit(&self.at);
        if !step.resisted || !falls {
            return;
        }
        axpy(1.0, &self.dual().response(self.problem, &by_component(&step.lambda)), u);
        self.dual().floating.motions.add(&step.alpha, u);
        self.at = next;
    }

    fn certificate(&self, u: &[f64], lambda: &[f64]) -> Certificate {
        let ((problem, tolerance), mut lambda) = (self.judge, lambda.to_vec());
        if !std::ptr::eq(problem, self.given) {
            problem.take_strength_off(&mut lambda);
        }
        certify(problem, u, &lambda, tolerance)
    }

    /// Makes the multipliers admissible, recomputes everything from them and lets the certificate judge.
    fn finish(&mut self, end: End) -> Solution {
        let tolerance = self.judge.1;
        let states = self.newton(self.friction(), &self.r, tolerance).states(&self.at);
        let mut lambda = by_component(&self.at.lambda);
        make_admissible(self.friction(), &mut lambda);
        self.at.lambda = by_point(&lambda);
        let mut u = self.displacement(&lambda);
        self.at.v = by_point(&self.problem.gap_and_slip(&u));
        self.given.out_of_isotropic(&mut lambda);
        let mut certificate = self.certificate(&u, &lambda);
        if self.refines && end != End::Interrupted && !certificate.is_as_good_as_the_data() {
            let (before, mut corrected) = (self.at.clone(), u.clone());
            self.correct(&mut corrected, tolerance);
            let mut forces = by_component(&self.at.lambda);
            make_admissible(self.friction(), &mut forces);
            self.given.out_of_isotropic(&mut forces);
            let of_corrected = self.certificate(&corrected, &forces);
            // A long step after a stall may need forces that are not admissible.
            if of_corrected.missed() < certificate.missed() {
                (u, lambda, certificate) = (corrected, forces, of_corrected);
            } else {
                self.at = before;
            }
        }
        let status = end.status(certificate.passed);
        self.counts.newton_steps = self.max_steps - self.steps_left;
        self.counts.products = self.dual().products();
        self.counts.solves = self.dual().solves();
        let (counts, history) = (self.counts, self.history.clone());
        let path = path_of(self.dual());
        Solution { status, path, u, lambda, states, certificate, counts, history }
    }
}

/// Removes from multipliers `[all lambda_n; all lambda_t1; all lambda_t2]` what rounding and the tolerance left outside the
/// law's set: tension, and friction beyond its bound.
pub(in crate::friction) fn make_admissible(friction: &[Friction], lambda: &mut [f64]) {
    let m = friction.len();
    for (j, &law) in friction.iter().enumerate() {
        let rows = [j, m + j, 2 * m + j];
        rows.into_iter().zip(projection(law, rows.map(|i| lambda[i]))).for_each(|(i, x)| lambda[i] = x);
    }
}
