//! The projection of a vector on a cone of which generators are found one by one.

use crate::linalg::{axpy, dot, norm};

/// A cone by unit generators, and the projection of `target` on it: non-negative least squares by active sets (Lawson & Hanson
/// 1974, ch. 23), whose orthogonal factorisation is updated as generators come and go (Golub & Van Loan, sec. 6.5).
pub(super) struct Hull {
    target: Vec<f64>,
    pub generators: Vec<Generator>,
    /// The generators in the factorisation.
    passive: Vec<usize>,
    /// Its orthonormal columns, and those of the triangle, each up to its diagonal entry.
    q: Vec<Vec<f64>>,
    r: Vec<Vec<f64>>,
    /// The target along each column.
    image: Vec<f64>,
}

/// A unit vector.
pub(super) struct Generator {
    /// The contact point whose force it is, if one.
    pub point: Option<usize>,
    pub vector: Vec<f64>,
    /// Its part in the projection.
    pub weight: f64,
}

impl Hull {
    pub(super) fn new(target: Vec<f64>) -> Self {
        let (generators, passive, q, r, image) = Default::default();
        Hull { target, generators, passive, q, r, image }
    }

    /// Adds a generator that brings the projection nearer to the target, or the first.
    pub(super) fn add(&mut self, point: Option<usize>, vector: Vec<f64>) {
        self.generators.push(Generator { point, vector, weight: 0.0 });
        self.factor(self.generators.len() - 1);
    }

    /// What is left of the target beside its projection.
    pub(super) fn project(&mut self) -> Vec<f64> {
        loop {
            let wanted = self.least_squares();
            let stop = |(at, (&g, &w)): (usize, (&usize, &f64))| {
                let weight = self.generators[g].weight;
                (if weight > 0.0 { weight / (weight - w) } else { 0.0 }, at)
            };
            let stops = self.passive.iter().zip(&wanted).enumerate().filter(|(_, (_, w))| **w <= 0.0).map(stop);
            // As far towards the wanted weights as none turns negative; the one that vanishes first is left out.
            let first = stops.min_by(|a, b| a.0.total_cmp(&b.0));
            let step = first.map_or(1.0, |(step, _)| step);
            for (&g, &w) in self.passive.iter().zip(&wanted) {
                let weight = &mut self.generators[g].weight;
                *weight = if step < 1.0 { (*weight + step * (w - *weight)).max(0.0) } else { w };
            }
            let Some((_, at)) = first else { break };
            self.remove(at);
        }
        let mut residual = self.target.clone();
        self.passive.iter().for_each(|&g| axpy(-self.generators[g].weight, &self.generators[g].vector, &mut residual));
        residual
    }

    /// The same by a new factorisation.
    pub(super) fn project_anew(&mut self) -> Vec<f64> {
        (self.q, self.r, self.image) = Default::default();
        std::mem::take(&mut self.passive).into_iter().for_each(|g| self.factor(g));
        self.project()
    }

    /// Puts a generator into the factorisation.
    fn factor(&mut self, g: usize) {
        let mut column = self.generators[g].vector.clone();
        let mut r = vec![0.0; self.q.len() + 1];
        for _ in 0..2 {
            for (r, q) in r.iter_mut().zip(&self.q) {
                let along = dot(&column, q);
                *r += along;
                axpy(-along, q, &mut column);
            }
        }
        let left = norm(&column);
        let reciprocal = if left > 0.0 { 1.0 / left } else { 0.0 };
        column.iter_mut().for_each(|v| *v *= reciprocal);
        r[self.q.len()] = left;
        self.image.push(dot(&column, &self.target));
        self.q.push(column);
        self.r.push(r);
        self.passive.push(g);
    }

    /// Takes the generator at place `at` out of the factorisation; rotations make the triangle one again.
    fn remove(&mut self, at: usize) {
        self.generators[self.passive.remove(at)].weight = 0.0;
        self.r.remove(at);
        for k in at..self.r.len() {
            let [a, b] = [self.r[k][k], self.r[k][k + 1]];
            let length = a.hypot(b);
            let [c, s] = if length > 0.0 { [a / length, b / length] } else { [1.0, 0.0] };
            let turn = |a: &mut f64, b: &mut f64| (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
            for r in &mut self.r[k..] {
                let (above, below) = r.split_at_mut(k + 1);
                turn(&mut above[k], &mut below[0]);
            }
            self.r[k].truncate(k + 1);
            let (before, after) = self.q.split_at_mut(k + 1);
            before[k].iter_mut().zip(&mut after[0]).for_each(|(a, b)| turn(a, b));
            let (before, after) = self.image.split_at_mut(k + 1);
            turn(&mut before[k], &mut after[0]);
        }
        self.q.pop();
        self.image.pop();
    }

    /// Weights of the generators in the factorisation that come nearest to the target.
    fn least_squares(&self) -> Vec<f64> {
        let least = 1e-12 * self.r.iter().enumerate().fold(0.0, |a: f64, (k, r)| a.max(r[k].abs()));
        let mut x = self.image.clone();
        for (k, r) in self.r.iter().enumerate().rev() {
            // Generators that nearly depend on others get large weights, which are soon left out.
            let pivot = if r[k].abs() <= least { least.max(f64::MIN_POSITIVE) } else { r[k] };
            x[k] /= pivot;
            let known = x[k];
            axpy(-known, &r[..k], &mut x[..k]);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The conditions of Karush, Kuhn and Tucker tell the projection: no generator gains, those with weight are at right angles to
    /// what is left.
    #[test]
    fn the_projection_on_a_cone_meets_its_conditions() {
        let n = 9;
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1u64 << 31) as f64 - 0.4
        };
        let mut left = false;
        for _ in 0..20 {
            let target: Vec<f64> = (0..n).map(|_| random()).collect();
            let candidates: Vec<Vec<f64>> = (0..40)
                .map(|_| {
                    let v: Vec<f64> = (0..n).map(|_| random()).collect();
                    let length = norm(&v);
                    v.iter().map(|v| v / length).collect()
                })
                .collect();
            let mut hull = Hull::new(target.clone());
            let mut residual = target.clone();
            for _ in 0..200 {
                let gain = |k: &usize| dot(&candidates[*k], &residual);
                let best = (0..40).max_by(|a, b| gain(a).total_cmp(&gain(b))).expect("forty of them");
                if gain(&best) <= 1e-13 {
                    break;
                }
                hull.add(Some(best), candidates[best].clone());
                residual = hull.project();
                left |= hull.passive.len() < hull.generators.len();
            }
            candidates.iter().for_each(|v| assert!(dot(v, &residual) <= 1e-12));
            let weighted: f64 = hull.generators.iter().map(|g| (g.weight * dot(&g.vector, &residual)).abs()).sum();
            assert!(weighted <= 1e-12, "{weighted:e}");
            let anew = hull.project_anew();
            assert!(anew.iter().zip(&residual).all(|(a, b)| (a - b).abs() < 1e-13));
        }
        assert!(left, "generators are left out as well");
    }
}
