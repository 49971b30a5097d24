use std::convert::Infallible;
use std::ops::ControlFlow;

use super::face::{Direction, Preconditioner, advance_to_bound, conjugate, feasible_step};
use super::iterate::{Iterate, Step};
use super::mprgp::{curvature, projected_step, proportioning_step, split};
use super::{BoundCounts, Bounds};
use crate::linalg::dot;

/// Parameters of [`super::BoundMethod::Proportioning`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProportioningSettings {
    /// The problem on the face is solved until `|chopped| > proportion |free|`: the precision of an auxiliary problem
    /// follows what leaving its face promises. Positive; the larger, the more precisely faces are solved.
    pub proportion: f64,
    /// How often a projected step that does not lower the objective is halved before the bound is accepted.
    pub halvings: usize,
}

impl Default for ProportioningSettings {
    fn default() -> Self {
        ProportioningSettings { proportion: 1.0, halvings: 3 }
    }
}

/// Conjugate gradients in the face with proportioning and projections: Dostál 1997, SIAM J. Optim. 7, 871-887, and,
/// with the shortened projected search, Bielschowsky, Friedlander, Gomes, Martínez & Raydan 1997, Investigación Oper.
/// 7; the test for leaving a face goes back to Friedlander & Martínez 1994, SIAM J. Optim. 4, 177-192.
pub(super) fn proportioning(
    it: &mut Iterate,
    bounds: &Bounds,
    settings: &ProportioningSettings,
    preconditioner: Option<&Preconditioner>,
    counts: &mut BoundCounts,
) -> Step<Infallible> {
    it.refresh()?;
    let gamma2 = settings.proportion * settings.proportion;
    let mut last: Option<Direction> = None;
    loop {
        let face = split(it, bounds, 1.0);
        if it.judge(face.projected)? {
            last = None;
            continue;
        }
        if face.chopped2 <= gamma2 * face.free2 {
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
                if !projected_search(it, bounds, settings.halvings, cg, feasible, &p)? {
                    advance_to_bound(it, bounds, feasible, &p, &ap);
                }
            }
        } else {
            proportioning_step(it, bounds, &face.chopped)?;
            last = None;
            counts.proportionings += 1;
        }
    }
}

/// The first of `P(x - cg p)`, `P(x - cg/2 p)`, .. beyond the bound that lowers the objective; false if none does.
fn projected_search(
    it: &mut Iterate,
    bounds: &Bounds,
    halvings: usize,
    cg: f64,
    feasible: f64,
    p: &[f64],
) -> Step<bool> {
    let mut step = cg;
    for _ in 0..=halvings {
        if step <= feasible {
            break;
        }
        if projected_step(it, bounds, step, p)? {
            return ControlFlow::Continue(true);
        }
        step *= 0.5;
    }
    ControlFlow::Continue(false)
}
