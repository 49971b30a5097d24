use std::convert::Infallible;
use std::ops::ControlFlow;

use super::face::{Direction, Face, Preconditioner, advance_to_bound, conjugate, feasible_step};
use super::iterate::{Iterate, Step};
use super::{Bounds, QpCounts, QpStatus};
use crate::linalg::dot;

/// Parameters of [`super::minimize_in_bounds`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MprgpSettings {
    /// An iterate is proportional if `|chopped|^2 <= proportion^2 reduced'free`; positive, 1 is best for the rate.
    pub proportion: f64,
    /// Length of the fixed step times the largest eigenvalue, in `(0, 2)`.
    pub step: f64,
}

impl Default for MprgpSettings {
    fn default() -> Self {
        MprgpSettings { proportion: 1.0, step: 1.9 }
    }
}

/// Modified proportioning with reduced gradient projections: Dostál & Schöberl 2005, Comput. Optim. Appl. 30, 23-43;
/// fixed steps up to twice the inverse of the norm after Dostál 2009, two-sided bounds and the preconditioning of the
/// face after Dostál, Optimal Quadratic Programming Algorithms, chapter 5; the projected step after Kružík, Horák,
/// Čermák, Pospíšil & Pecha 2020, Active set expansion strategies in MPRGP algorithm, Adv. Eng. Softw.
pub(super) fn mprgp(
    it: &mut Iterate,
    bounds: &Bounds,
    settings: &MprgpSettings,
    norm: Option<f64>,
    preconditioner: Option<&Preconditioner>,
    counts: &mut QpCounts,
) -> Step<Infallible> {
    it.refresh()?;
    let (norm, products) = it.operator_norm(norm)?;
    counts.estimation = products;
    let mut a = settings.step / norm;
    let gamma2 = settings.proportion * settings.proportion;
    let mut last: Option<Direction> = None;
    loop {
        let face = split(it, bounds, a);
        if it.judge(face.projected)? {
            last = None;
            continue;
        }
        if face.chopped2 <= gamma2 * face.reduced2 {
            let p = conjugate(it, face.preconditioned(preconditioner), last.take());
            let ap = it.times(&p)?;
            let curvature = curvature(it, &p, &ap)?;
            let cg = dot(&it.g, &p) / curvature;
            let feasible = feasible_step(bounds, &it.x, &p);
            if cg <= feasible {
                it.advance(cg, &p, &ap);
                last = Some(Direction { p, ap, curvature });
                counts.cg_steps += 1;
            } else {
                counts.expansions += 1;
                // The whole step, projected; where that does not lower the objective, to the bound and a fixed step.
                if projected_step(it, bounds, cg, &p)? {
                    continue;
                }
                advance_to_bound(it, bounds, feasible, &p, &ap);
                a = fixed_step(it, bounds, a)?;
            }
        } else {
            proportioning_step(it, bounds, &face.chopped)?;
            last = None;
            counts.gradient_steps += 1;
        }
    }
}

/// Splits the gradient of `it`, counted.
pub(super) fn split(it: &mut Iterate, bounds: &Bounds, step: f64) -> Face {
    it.count(4);
    Face::new(bounds, &it.x, &it.g, step)
}

/// `p'Ap`, which must be positive.
pub(super) fn curvature(it: &mut Iterate, p: &[f64], ap: &[f64]) -> Step<f64> {
    // This product, and the two that follow each product: the step length and the room to the bounds.
    it.count(3);
    let curvature = dot(p, ap);
    if curvature > 0.0 { ControlFlow::Continue(curvature) } else { ControlFlow::Break(QpStatus::Indefinite) }
}

/// Leaves the bounds along the chopped gradient, to the minimum there or to the first bound met.
pub(super) fn proportioning_step(it: &mut Iterate, bounds: &Bounds, chopped: &[f64]) -> Step<()> {
    let ap = it.times(chopped)?;
    let cg = dot(&it.g, chopped) / curvature(it, chopped, &ap)?;
    let feasible = feasible_step(bounds, &it.x, chopped);
    if cg <= feasible {
        it.advance(cg, chopped, &ap);
    } else {
        advance_to_bound(it, bounds, feasible, chopped, &ap);
    }
    ControlFlow::Continue(())
}

/// Goes to the projection of `x - step p` if the objective is lower there.
pub(super) fn projected_step(it: &mut Iterate, bounds: &Bounds, step: f64, p: &[f64]) -> Step<bool> {
    let mut y: Vec<f64> = it.x.iter().zip(p).map(|(x, p)| x - step * p).collect();
    bounds.project(&mut y);
    it.count(2);
    // The gradient is computed here, not by recurrence: the step is not along p.
    let g = it.gradient_at(&y)?;
    let lower = it.rise(&y, &g) < 0.0;
    if lower {
        it.move_to(y, g);
    }
    ControlFlow::Continue(lower)
}

/// A step of length `a` along the reduced free gradient. Returns `a`, halved if the objective rose: then the norm of
/// the operator was underestimated, and the step is not taken.
fn fixed_step(it: &mut Iterate, bounds: &Bounds, a: f64) -> Step<f64> {
    let face = split(it, bounds, a);
    let mut y: Vec<f64> = it.x.iter().zip(&face.free).map(|(x, g)| x - a * g).collect();
    bounds.project(&mut y);
    it.count(2);
    let g = it.gradient_at(&y)?;
    let moved = y.iter().zip(&it.x).map(|(y, x)| (y - x) * (y - x)).sum::<f64>().sqrt();
    if it.rise(&y, &g) > it.rounding() * moved {
        return ControlFlow::Continue(0.5 * a);
    }
    it.move_to(y, g);
    ControlFlow::Continue(a)
}
