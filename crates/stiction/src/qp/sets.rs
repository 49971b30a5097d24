use std::convert::Infallible;
use std::ops::ControlFlow;

use super::arc::{Arcs, face_steps, preconditioned};
use super::face::{Direction, Preconditioner, conjugate};
use super::iterate::{Iterate, Step, Stop};
use super::mprgp::curvature;
use super::{PointSet, QpStatus, project};
use crate::linalg::{axpy, dot, norm};

/// `min 1/2 x'Ax - b'x` over a product of [`PointSet`]s, `A` symmetric positive definite, in triples
/// `[all x_0; all x_1; all x_2]`.
pub struct SetProblem<'a> {
    /// `x -> A x`.
    pub operator: &'a mut dyn FnMut(&[f64]) -> Vec<f64>,
    pub b: &'a [f64],
    /// The norm of `A`, or a number not much above it; estimated by Lanczos steps, which count, if not given.
    pub largest_eigenvalue: Option<f64>,
    /// Approximate inverse of `A` on the entries marked free. A pair that moves along its boundary has both its
    /// entries marked; the result is restricted to the tangent.
    pub preconditioner: Option<&'a Preconditioner<'a>>,
}

/// Parameters of [`minimize_in_sets`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetSettings {
    /// Length of the projected gradient step times the largest eigenvalue, in `(0, 2)`.
    pub step: f64,
    /// Least share of the squared reduced gradient that must lie on the face for the face to be kept. (The sources
    /// compare scalar products with the gradient; those drown in rounding long before the reduced gradient does.)
    pub share: f64,
    /// Whether pairs on curved boundaries move along them with the second derivative of the boundary; otherwise the
    /// gradient steps alone move them.
    pub follow_boundaries: bool,
    /// With `follow_boundaries`: the gradient of the model on the face is reduced by this factor before the face is
    /// left, in `(0, 1)`.
    pub forcing: f64,
}

impl Default for SetSettings {
    fn default() -> Self {
        SetSettings { step: 1.9, share: 0.5, follow_boundaries: true, forcing: 0.01 }
    }
}

/// What a minimisation over sets cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SetCounts {
    /// Products with `A`, those of `estimation` included.
    pub products: usize,
    /// Products spent on the largest eigenvalue.
    pub estimation: usize,
    /// Steps of conjugate gradients.
    pub cg_steps: usize,
    /// Projected steps out of a face, taken or not.
    pub expansions: usize,
    /// Projected gradient steps of fixed length.
    pub gradient_steps: usize,
    /// Operations on vectors, counted as for [`super::BoundCounts`].
    pub flops: f64,
}

/// Where a minimisation ended; `x` is in the sets whatever the status except `Empty` and `NotFinite`.
#[derive(Debug, Clone, PartialEq)]
pub struct SetSolution {
    pub x: Vec<f64>,
    /// `A x - b`.
    pub gradient: Vec<f64>,
    /// Euclidean norm of the reduced gradient, see [`minimize_in_sets`].
    pub reduced_gradient: f64,
    pub counts: SetCounts,
    pub status: QpStatus,
}

/// Minimises from the projection of `start` until `|(x - P(x - a g)) / a| <= tolerance`, in the unit of `b`, with
/// `a = step / largest_eigenvalue` and the projection `P`; or until `stop` returns true, or `max_products` products
/// with `A` are spent. The measure is the norm of the gradient where nothing holds, and zero at the solution only.
///
/// Three entries of `b` and `start` belong to each set. `stop` is asked at every iteration with the iterate and the
/// measure.
pub fn minimize_in_sets(
    problem: SetProblem,
    sets: &[PointSet],
    start: &[f64],
    settings: &SetSettings,
    tolerance: f64,
    max_products: usize,
    stop: &mut Stop,
) -> SetSolution {
    let SetProblem { operator, b, largest_eigenvalue, preconditioner } = problem;
    assert!(b.len() == start.len() && b.len() == 3 * sets.len(), "three entries of b and start a set");
    let (mut x, mut counts) = (start.to_vec(), SetCounts::default());
    if !sets.iter().all(PointSet::is_valid) {
        let gradient = vec![f64::NAN; x.len()];
        return SetSolution { x, gradient, reduced_gradient: f64::NAN, counts, status: QpStatus::Empty };
    }
    let finite = norm(start).is_finite() && norm(b).is_finite();
    project(sets, &mut x);
    let limit = if finite { max_products } else { 0 };
    let mut it = Iterate::new(operator, b, x, tolerance, limit, stop);
    let mut a = f64::NAN;
    let ControlFlow::Break(status) =
        kprgp(&mut it, sets, settings, largest_eigenvalue, preconditioner, &mut a, &mut counts);
    let status = if finite { status } else { QpStatus::NotFinite };
    counts.products = it.products;
    counts.flops = it.flops;
    let reduced_gradient = norm(&reduced_gradient(&mut it, sets, a));
    SetSolution { x: it.x, gradient: it.g, reduced_gradient, counts, status }
}

/// Conjugate gradients on the face while it is proportional, projected gradient steps otherwise: Kučera 2008, SIAM J.
/// Optim. 19, 846-862, in the form of Bouchala, Dostál, Kozubek, Pospíšil & Vodstrčil 2014, Appl. Math. Comput. 247,
/// 848-864; steps up to twice the inverse of the norm after Bouchala, Dostál & Vodstrčil 2013, J. Optim. Theory Appl.
/// 157. Each step lowers the objective.
fn kprgp(
    it: &mut Iterate,
    sets: &[PointSet],
    settings: &SetSettings,
    norm_of_a: Option<f64>,
    preconditioner: Option<&Preconditioner>,
    a: &mut f64,
    counts: &mut SetCounts,
) -> Step<Infallible> {
    it.refresh()?;
    let (norm_of_a, products) = it.operator_norm(norm_of_a)?;
    counts.estimation = products;
    *a = settings.step / norm_of_a;
    let mut last: Option<Direction> = None;
    loop {
        let reduced = reduced_gradient(it, sets, *a);
        let measure = norm(&reduced);
        if it.judge(measure)? {
            last = None;
            continue;
        }
        let arcs = Arcs::new(sets, &it.x, &it.g, settings.follow_boundaries);
        it.count(3);
        if arcs.share(&reduced) < settings.share {
            last = None;
            gradient_step(it, sets, a, counts)?;
        } else if arcs.curved {
            last = None;
            curved_step(it, sets, settings, &arcs, preconditioner, measure, a, counts)?;
        } else {
            let p = conjugate(it, preconditioned(&arcs, &arcs.free, *a, preconditioner), last.take());
            let ap = it.times(&p)?;
            let curvature = curvature(it, &p, &ap)?;
            let cg = dot(&it.g, &p) / curvature;
            let feasible = arcs.feasible_step(sets, &it.x, &p);
            if cg <= feasible {
                it.advance(cg, &p, &ap);
                last = Some(Direction { p, ap, curvature });
                counts.cg_steps += 1;
            } else if !projected(it, sets, &p.iter().map(|p| -cg * p).collect::<Vec<_>>(), *a, 0.0, measure, counts)? {
                it.advance(feasible, &p, &ap);
                project(sets, &mut it.x);
                gradient_step(it, sets, a, counts)?;
            }
        }
    }
}

/// Minimises the model on a face with curved boundaries and follows them by projection, which agrees with the
/// boundary to second order; taken if it lowers the objective by a share of what the projected gradient step is sure
/// of, so that the rate of that step holds for this one too. Otherwise a projected gradient step.
#[allow(clippy::too_many_arguments)]
fn curved_step(
    it: &mut Iterate,
    sets: &[PointSet],
    settings: &SetSettings,
    arcs: &Arcs,
    preconditioner: Option<&Preconditioner>,
    measure: f64,
    a: &mut f64,
    counts: &mut SetCounts,
) -> Step<()> {
    let precision = (settings.forcing * norm(&arcs.free)).max(0.5 * it.tolerance());
    let steps = face_steps(it, sets, arcs, *a, precision, preconditioner)?;
    counts.cg_steps += steps.steps;
    let least = SURE_SHARE * *a * measure * measure;
    if projected(it, sets, &steps.way, *a, least, measure, counts)? {
        return ControlFlow::Continue(());
    }
    if let Some(way) = steps.feasible {
        if projected(it, sets, &way, *a, least, measure, counts)? {
            return ControlFlow::Continue(());
        }
    }
    gradient_step(it, sets, a, counts)
}

/// Share of `a |reduced gradient|^2` by which a step on a curved face must lower the objective.
const SURE_SHARE: f64 = 1e-2;

/// Goes to the projection of `x + way` if that lowers the objective by more than `least`. Where rounding hides that
/// much, the reduced gradient decides, which `measure` is the norm of.
#[allow(clippy::too_many_arguments)]
fn projected(
    it: &mut Iterate,
    sets: &[PointSet],
    way: &[f64],
    a: f64,
    least: f64,
    measure: f64,
    counts: &mut SetCounts,
) -> Step<bool> {
    counts.expansions += 1;
    let mut y: Vec<f64> = it.x.iter().zip(way).map(|(x, s)| x + s).collect();
    project(sets, &mut y);
    it.count(2);
    let g = it.gradient_at(&y)?;
    let (rise, noise) = (it.rise(&y, &g), boundary_rounding(it));
    let hidden = least <= noise && rise <= noise;
    let lower = rise < -least.max(noise) || (hidden && norm(&reduced_at(sets, &y, &g, a)) < measure);
    if lower {
        it.move_to(y, g);
    }
    ControlFlow::Continue(lower)
}

/// What the objective may change by because points on boundaries are rounded.
fn boundary_rounding(it: &mut Iterate) -> f64 {
    it.count(2);
    4.0 * f64::EPSILON * norm(&it.x) * norm(&it.g)
}

/// The projection of `x - a g`. Where the objective rises, the norm of the operator was underestimated: `a` is halved
/// and the step not taken.
fn gradient_step(it: &mut Iterate, sets: &[PointSet], a: &mut f64, counts: &mut SetCounts) -> Step<()> {
    counts.gradient_steps += 1;
    let mut y = it.x.clone();
    axpy(-*a, &it.g, &mut y);
    project(sets, &mut y);
    it.count(2);
    let g = it.gradient_at(&y)?;
    let moved = y.iter().zip(&it.x).map(|(y, x)| (y - x) * (y - x)).sum::<f64>().sqrt();
    if it.rise(&y, &g) > it.rounding() * moved + boundary_rounding(it) {
        *a *= 0.5;
    } else {
        it.move_to(y, g);
    }
    ControlFlow::Continue(())
}

/// `(x - P(x - a g)) / a`, counted.
fn reduced_gradient(it: &mut Iterate, sets: &[PointSet], a: f64) -> Vec<f64> {
    it.count(3);
    reduced_at(sets, &it.x, &it.g, a)
}

fn reduced_at(sets: &[PointSet], x: &[f64], g: &[f64], a: f64) -> Vec<f64> {
    let mut y = x.to_vec();
    axpy(-a, g, &mut y);
    project(sets, &mut y);
    y.iter().zip(x).map(|(y, x)| (x - y) / a).collect()
}
