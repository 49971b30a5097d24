use std::convert::Infallible;
use std::ops::ControlFlow;

use super::arc::{Arcs, face_steps, preconditioned};
use super::face::{Direction, Preconditioner, conjugate};
use super::iterate::{Iterate, Step};
use super::mprgp::curvature;
use super::{PointSet, QpCounts, SetSettings, project};
use crate::linalg::{axpy, dot, norm};

/// Part of `a |reduced gradient|^2` by which a step on a curved face must lower the objective.
const SURE_PART: f64 = 1e-2;

/// What the steps of [`kprgp`] share.
pub(super) struct Kprgp<'a> {
    pub sets: &'a [PointSet],
    pub settings: &'a SetSettings,
    pub preconditioner: Option<&'a Preconditioner<'a>>,
    /// Length of projected gradient steps.
    pub a: f64,
    /// Norm of the reduced gradient.
    pub measure: f64,
    pub counts: QpCounts,
}

/// Conjugate gradients on the face while it is proportional, projected gradient steps otherwise: Kučera 2008, SIAM J.
/// Optim. 19, 846-862, in the form of Bouchala, Dostál, Kozubek, Pospíšil & Vodstrčil 2014, Appl. Math. Comput. 247,
/// 848-864; steps up to twice the inverse of the norm after Bouchala, Dostál & Vodstrčil 2013, J. Optim. Theory Appl.
/// 157. Each step lowers the objective. Faces with curved boundaries are ours, see [`curved_step`].
pub(super) fn kprgp(it: &mut Iterate, run: &mut Kprgp, norm_of_a: Option<f64>) -> Step<Infallible> {
    it.refresh()?;
    let (norm_of_a, products) = it.operator_norm(norm_of_a)?;
    run.counts.estimation = products;
    run.a = run.settings.step / norm_of_a;
    let mut last: Option<Direction> = None;
    loop {
        let reduced = reduced_gradient(run.sets, &it.x, &it.g, run.a);
        run.measure = norm(&reduced);
        if it.judge(run.measure)? {
            last = None;
            continue;
        }
        let arcs = Arcs::new(run.sets, &it.x, &it.g);
        it.count(6);
        if arcs.part_on_face(&reduced) < run.settings.least_part {
            last = None;
            gradient_step(it, run)?;
        } else if arcs.curved {
            last = None;
            curved_step(it, run, &arcs)?;
        } else {
            let p = conjugate(it, preconditioned(&arcs, &arcs.free, run.a, run.preconditioner), last.take());
            let ap = it.times(&p)?;
            let curvature = curvature(it, &p, &ap)?;
            let cg = dot(&it.g, &p) / curvature;
            let feasible = arcs.feasible_step(run.sets, &it.x, &p);
            let way: Vec<f64> = p.iter().map(|p| -cg * p).collect();
            if cg <= feasible {
                it.advance(cg, &p, &ap);
                last = Some(Direction { p, ap, curvature });
                run.counts.cg_steps += 1;
            } else if !projected(it, run, &way, 0.0)? {
                it.advance(feasible, &p, &ap);
                project(run.sets, &mut it.x);
                gradient_step(it, run)?;
            }
        }
    }
}

/// Minimises the model on a face with curved boundaries and follows them by projection, which agrees with the
/// boundary to second order; taken if it lowers the objective by a part of what the projected gradient step is sure
/// of, so that the rate of that step holds for this one too, up to that part. Otherwise a projected gradient step.
///
/// The matrix of the model is that of the semismooth Newton step of Kučera, Motyčková, Markopoulos & Haslinger 2020,
/// Optim. Methods Softw. 35: `A` on the tangents plus multiplier times curvature.
fn curved_step(it: &mut Iterate, run: &mut Kprgp, arcs: &Arcs) -> Step<()> {
    let precision = (run.settings.forcing * norm(&arcs.free)).max(0.5 * it.tolerance());
    let steps = face_steps(it, run.sets, arcs, run.a, precision, run.preconditioner)?;
    run.counts.cg_steps += steps.steps;
    let least = SURE_PART * run.a * run.measure * run.measure;
    if projected(it, run, &steps.way, least)? {
        return ControlFlow::Continue(());
    }
    if let Some(way) = steps.feasible
        && projected(it, run, &way, least)?
    {
        return ControlFlow::Continue(());
    }
    gradient_step(it, run)
}

/// Goes to the projection of `x + way` if that lowers the objective by more than `least`. Where rounding hides that
/// much, the reduced gradient decides.
fn projected(it: &mut Iterate, run: &mut Kprgp, way: &[f64], least: f64) -> Step<bool> {
    run.counts.expansions += 1;
    let mut y: Vec<f64> = it.x.iter().zip(way).map(|(x, s)| x + s).collect();
    project(run.sets, &mut y);
    it.count(2);
    let g = it.gradient_at(&y)?;
    let (rise, noise) = (it.rise(&y, &g), boundary_rounding(it));
    let hidden = least <= noise && rise <= noise;
    let lower = rise < -least.max(noise) || (hidden && norm(&reduced_gradient(run.sets, &y, &g, run.a)) < run.measure);
    if lower {
        it.move_to(y, g);
    }
    ControlFlow::Continue(lower)
}

/// The projection of `x - a g`. Where the objective rises, the norm of the operator was underestimated: `a` is halved
/// and the step not taken.
fn gradient_step(it: &mut Iterate, run: &mut Kprgp) -> Step<()> {
    run.counts.gradient_steps += 1;
    let mut y = it.x.clone();
    axpy(-run.a, &it.g, &mut y);
    project(run.sets, &mut y);
    it.count(2);
    let g = it.gradient_at(&y)?;
    let moved = y.iter().zip(&it.x).map(|(y, x)| (y - x) * (y - x)).sum::<f64>().sqrt();
    if it.rise(&y, &g) > it.rounding() * moved + boundary_rounding(it) {
        run.a *= 0.5;
    } else {
        it.move_to(y, g);
    }
    ControlFlow::Continue(())
}

/// What the objective may change by because points on boundaries are rounded.
fn boundary_rounding(it: &mut Iterate) -> f64 {
    it.count(2);
    4.0 * f64::EPSILON * norm(&it.x) * norm(&it.g)
}

/// `(x - P(x - a g)) / a`.
pub(super) fn reduced_gradient(sets: &[PointSet], x: &[f64], g: &[f64], a: f64) -> Vec<f64> {
    let mut y = x.to_vec();
    axpy(-a, g, &mut y);
    project(sets, &mut y);
    y.iter().zip(x).map(|(y, x)| (x - y) / a).collect()
}
