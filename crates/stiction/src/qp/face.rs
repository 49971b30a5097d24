use super::Bounds;
use super::iterate::Iterate;
use crate::linalg::{axpy, dot};

/// Applies an approximate inverse of `A` restricted to the entries marked free; other entries of the result are
/// ignored. It must be symmetric and positive definite on each face.
pub type Preconditioner<'a> = dyn Fn(&[f64], &[bool]) -> Vec<f64> + 'a;

/// The gradient split at the face of `x`: where a bound is attained, and where not.
pub(super) struct Face {
    pub is_free: Vec<bool>,
    /// The gradient on the free entries, zero elsewhere.
    pub free: Vec<f64>,
    /// The gradient where it points out of a bound that holds, zero elsewhere.
    pub chopped: Vec<f64>,
    /// `reduced'free`, the free gradient reduced to what a step of the given length can use.
    pub reduced2: f64,
    /// `|chopped|^2`.
    pub chopped2: f64,
    /// `|free + chopped|`, zero at the solution and nowhere else.
    pub projected: f64,
}

impl Face {
    /// Splits `g` at `x`, with the free gradient reduced for gradient steps of length `step`.
    pub(super) fn new(bounds: &Bounds, x: &[f64], g: &[f64], step: f64) -> Face {
        let n = x.len();
        let (mut is_free, mut free, mut chopped) = (vec![false; n], vec![0.0; n], vec![0.0; n]);
        let mut reduced2 = 0.0;
        for i in 0..n {
            let (at_lower, at_upper) = (x[i] <= bounds.lower[i], x[i] >= bounds.upper[i]);
            match (at_lower, at_upper) {
                (false, false) => {
                    is_free[i] = true;
                    free[i] = g[i];
                    let room = if g[i] > 0.0 { x[i] - bounds.lower[i] } else { bounds.upper[i] - x[i] };
                    reduced2 += g[i].abs() * g[i].abs().min(room / step);
                }
                (true, false) => chopped[i] = g[i].min(0.0),
                (false, true) => chopped[i] = g[i].max(0.0),
                (true, true) => {}
            }
        }
        let (free2, chopped2) = (dot(&free, &free), dot(&chopped, &chopped));
        // min and max pass over NaN; the sum of all entries does not.
        let projected = if g.iter().sum::<f64>().is_nan() { f64::NAN } else { (free2 + chopped2).sqrt() };
        Face { is_free, free, chopped, reduced2, chopped2, projected }
    }

    /// The free gradient, preconditioned on the face if that gives a direction of ascent.
    pub(super) fn preconditioned(&self, preconditioner: Option<&Preconditioner>) -> Vec<f64> {
        let Some(apply) = preconditioner else { return self.free.clone() };
        let mut z = apply(&self.free, &self.is_free);
        z.iter_mut().zip(&self.is_free).for_each(|(z, free)| *z = if *free { *z } else { 0.0 });
        let ascent = dot(&z, &self.free);
        if z.len() == self.free.len() && ascent > 0.0 && ascent.is_finite() { z } else { self.free.clone() }
    }
}

/// The last direction of conjugate gradients and its image, kept while the face does not change.
pub(super) struct Direction {
    pub p: Vec<f64>,
    pub ap: Vec<f64>,
    pub curvature: f64,
}

/// The next direction: the preconditioned free gradient `z`, made conjugate to the last one.
pub(super) fn conjugate(it: &mut Iterate, z: Vec<f64>, last: Option<Direction>) -> Vec<f64> {
    let Some(last) = last else { return z };
    it.count(2);
    let mut p = z;
    let along = dot(&p, &last.ap) / last.curvature;
    axpy(-along, &last.p, &mut p);
    p
}

/// The largest `t` for which `x - t p` is within the bounds.
pub(super) fn feasible_step(bounds: &Bounds, x: &[f64], p: &[f64]) -> f64 {
    (0..x.len()).fold(f64::INFINITY, |t, i| t.min(room(bounds, x, p, i)))
}

/// Goes from `x` to `x - step p` where a bound is met, and puts the entries that meet theirs exactly upon it.
pub(super) fn advance_to_bound(it: &mut Iterate, bounds: &Bounds, step: f64, p: &[f64], ap: &[f64]) {
    // Entries that meet their bounds together do so up to the rounding of a quotient.
    let reach = step * (1.0 + 4.0 * f64::EPSILON);
    let meets: Vec<usize> = (0..p.len()).filter(|i| room(bounds, &it.x, p, *i) <= reach).collect();
    it.advance(step, p, ap);
    for i in meets {
        it.x[i] = if p[i] > 0.0 { bounds.lower[i] } else { bounds.upper[i] };
    }
    bounds.project(&mut it.x);
    it.count(2);
}

fn room(bounds: &Bounds, x: &[f64], p: &[f64], i: usize) -> f64 {
    match p[i] {
        p if p > 0.0 => (x[i] - bounds.lower[i]) / p,
        p if p < 0.0 => (x[i] - bounds.upper[i]) / p,
        _ => f64::INFINITY,
    }
}
