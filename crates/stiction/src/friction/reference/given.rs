use std::ops::ControlFlow;

use super::lagrangian::{Copies, Lagrangian};
use super::method::{MethodCounts, MethodSettings, MethodStep};
use super::minimize::{Minimizer, verdict};
use crate::friction::{End, PointState};
use crate::linalg::{Watch, dot, norm};
use crate::qp::Bounds;

/// What an iteration keeps besides its iterate.
pub(super) struct Record<'a, 'b> {
    pub counts: MethodCounts,
    pub history: Vec<MethodStep>,
    pub observe: &'a mut Watch<'b, MethodStep>,
}

impl Record<'_, '_> {
    /// Notes one execution of Step 2; `change` is what the method's rule looks at.
    pub(super) fn note(
        &mut self,
        lagrangian: &Lagrangian<'_>,
        copies: &Copies,
        bounds: &Bounds,
        change: f64,
    ) -> Result<(), End> {
        let [open, stick, slip] = PointState::count(&lagrangian.state_of_points(&copies.x, bounds));
        let disagreement = lagrangian.disagreement(&copies.x);
        let MethodCounts { iterations, fixed_point_steps, products, .. } = self.counts;
        let (steps, fixed_point_step) = (self.counts.steps(), fixed_point_steps);
        let step = MethodStep {
            iteration: iterations,
            fixed_point_step,
            change,
            disagreement,
            steps,
            products,
            open,
            stick,
            slip,
        };
        self.history.push(step);
        match (self.observe)(&step) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(End::Interrupted),
        }
    }
}

/// `change / size`, zero where nothing changes.
pub(super) fn relative(change: f64, size: f64) -> f64 {
    if change == 0.0 { 0.0 } else { change / size }
}

/// Uzawa's method: ALG1 where Step 1 takes the copies one by one, ALG2 where it takes them as one quadratic program
/// (Haslinger, Kucera & Dostal 2004, sections 4.2 and 4.3), with their rule (6.1).
///
/// # Errors
/// How the method ended if not by its rule; the copies are where it came to.
pub(super) fn uzawa(
    step1: &Minimizer<'_>,
    copies: &mut Copies,
    bounds: &Bounds,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> Result<(), End> {
    let lagrangian = step1.lagrangian;
    loop {
        if record.counts.iterations >= settings.max_iterations {
            return Err(End::Limit);
        }
        step1.minimize(copies, bounds, &mut record.counts)?; // Step 1
        let change = lagrangian.ascend(copies); // Step 2: w += rho C lambda
        record.counts.iterations += 1;
        record.note(lagrangian, copies, bounds, relative(change, norm(&copies.w)))?;
        let agreed = lagrangian.disagreement(&copies.x) <= settings.agreement;
        if change <= settings.tolerance * norm(&copies.w) || agreed {
            return Ok(());
        }
    }
}

/// Parameters of [`Adaptive`], as PERMON sets them.
struct Threshold;

impl Threshold {
    /// `M` starts at so many times the norm of `A`, and falls by this factor.
    const FIRST_M: f64 = 100.0;
    const FALL_OF_M: f64 = 0.5;
    /// No program is solved less accurately than to this part of its load.
    const COARSEST: f64 = 0.1;
}

/// Where the adaptive method stands between two steps.
pub(super) struct Adaptive {
    m: f64,
    /// The Lagrangian after the last step.
    last: Option<f64>,
}

impl Adaptive {
    pub(super) fn new(lagrangian: &Lagrangian<'_>) -> Self {
        Adaptive { m: Threshold::FIRST_M * lagrangian.q.largest / lagrangian.squares.count as f64, last: None }
    }

    /// One step of SMALBE-M (Dostal 2006, Computing 78; with fixed `rho` and variable `M`: Dostal, Optimal Quadratic
    /// Programming Algorithms, 2009, chapter 6). Returns the norm of the projected gradient over that of `b`.
    ///
    /// # Errors
    /// As [`uzawa`].
    pub(super) fn step(
        &mut self,
        step1: &Minimizer<'_>,
        copies: &mut Copies,
        bounds: &Bounds,
        tolerance: f64,
        counts: &mut MethodCounts,
    ) -> Result<f64, End> {
        let l = step1.lagrangian;
        let load = l.load(&copies.w);
        let size = norm(&l.load(&vec![0.0; copies.w.len()]));
        let loose =
            |x: &[f64], gradient: f64| gradient <= (self.m * norm(&l.differences(x))).min(Threshold::COARSEST * size);
        let found = step1.program(0, &load, copies, bounds, tolerance * size, &mut { loose }, counts); // Step 1
        counts.qp_problems += 1;
        copies.x.clone_from(&found.x);
        verdict(found.status)?;
        let value = 0.5 * (dot(&found.x, &found.gradient) - dot(&found.x, &load));
        let change = l.ascend(copies); // Step 2: w += rho C lambda
        // Step 3: the Lagrangian must have grown enough, or the program was too rough.
        let wanted = self.last.map(|last| last + 0.5 * change * change / l.penalty);
        if wanted.is_some_and(|wanted| value < wanted) {
            self.m *= Threshold::FALL_OF_M;
        }
        self.last = Some(value);
        Ok(relative(found.measure, size))
    }
}

/// SMALBE-M until both the projected gradient and the disagreement of the copies are small.
///
/// # Errors
/// As [`uzawa`].
pub(super) fn adaptive_uzawa(
    step1: &Minimizer<'_>,
    copies: &mut Copies,
    bounds: &Bounds,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> Result<(), End> {
    let lagrangian = step1.lagrangian;
    let mut adaptive = Adaptive::new(lagrangian);
    loop {
        if record.counts.iterations >= settings.max_iterations {
            return Err(End::Limit);
        }
        let gradient = adaptive.step(step1, copies, bounds, settings.tolerance, &mut record.counts)?;
        record.counts.iterations += 1;
        let disagreement = lagrangian.disagreement(&copies.x);
        record.note(lagrangian, copies, bounds, gradient.max(disagreement))?;
        if gradient <= settings.tolerance && disagreement <= settings.tolerance {
            return Ok(());
        }
    }
}
