use crate::contact::Friction;
use crate::linalg::{SmallLu, axpy, dot, norm};

/// A rigid body on an elastic foundation (Winkler): where the points would be if only they yielded.
pub(super) struct Foundation<'a> {
    pub friction: &'a [Friction],
    /// Columns of `G`, the jumps of the rigid motions.
    pub jumps: &'a [Vec<f64>],
    /// `Rᵀ f`, newton.
    pub resultant: &'a [f64],
    /// `[gap - N u; slip_reference - T u]` where the rigid motions are zero, length, `3m`.
    pub opening: &'a [f64],
    /// Stiffness of each point, force per length, `m`.
    pub stiffness: &'a [f64],
}

/// Far more than the pieces of the energy that are crossed on the way.
const STEPS: usize = 50;
const DOUBLINGS: usize = 200;
const BISECTIONS: usize = 60;

/// Tangential stiffness of points that do not touch, over that of those that do: it decides nothing but where a body
/// goes that nothing else guides.
const GUIDE: f64 = 1e-6;

impl Foundation<'_> {
    /// The rigid motions at rest: first as far as normal forces stop the body, then with the tangents of the points
    /// held that touch there.
    pub fn rest(&self) -> Vec<f64> {
        let guided = self.least_energy(&vec![GUIDE; self.friction.len()]);
        let mut v = self.opening.to_vec();
        guided.iter().zip(self.jumps).for_each(|(a, g)| axpy(-a, g, &mut v));
        let held: Vec<f64> = (0..self.friction.len()).map(|j| if v[j] < 0.0 { 1.0 } else { GUIDE }).collect();
        self.least_energy(&held)
    }

    /// Newton's method with exact line search on the convex energy `1/2 sum of r |overlap|² + r h |T u|² - Rᵀf . alpha`,
    /// `h` the share of each point's tangential stiffness.
    fn least_energy(&self, held: &[f64]) -> Vec<f64> {
        let mut alpha = vec![0.0; self.jumps.len()];
        let mut v = self.opening.to_vec();
        for _ in 0..STEPS {
            let force = self.force(&v, held);
            let lacking: Vec<f64> = self.jumps.iter().zip(self.resultant).map(|(g, e)| e - dot(g, &force)).collect();
            if norm(&lacking) <= 1e-6 * norm(self.resultant) {
                break;
            }
            let d = SmallLu::new(self.curvature(&v, held)).solve(&lacking);
            let mut dv = vec![0.0; v.len()];
            d.iter().zip(self.jumps).for_each(|(d, g)| axpy(-d, g, &mut dv));
            let t = self.rest_along(&v, &dv, dot(&d, self.resultant), held);
            axpy(t, &d, &mut alpha);
            axpy(t, &dv, &mut v);
        }
        alpha
    }

    /// Force of the foundation at the opening `v`, `3m`.
    fn force(&self, v: &[f64], held: &[f64]) -> Vec<f64> {
        v.iter().enumerate().map(|(i, v)| -self.spring(i, *v, held) * v).collect()
    }

    /// Stiffness of row `i` at the opening `v`.
    fn spring(&self, i: usize, v: f64, held: &[f64]) -> f64 {
        let (m, j) = (self.friction.len(), i % self.friction.len());
        let share = match self.friction[j] {
            Friction::Bonded => 1.0,
            _ if i < m => f64::from(u8::from(v < 0.0)),
            Friction::None => 0.0,
            Friction::Given { .. } | Friction::Coulomb { .. } => held[j],
        };
        share * self.stiffness[j]
    }

    fn curvature(&self, v: &[f64], held: &[f64]) -> Vec<Vec<f64>> {
        let springs: Vec<f64> = v.iter().enumerate().map(|(i, v)| self.spring(i, *v, held)).collect();
        let weighted = |g: &Vec<f64>| -> Vec<f64> { g.iter().zip(&springs).map(|(g, s)| g * s).collect() };
        let mut h: Vec<Vec<f64>> =
            self.jumps.iter().map(weighted).map(|w| self.jumps.iter().map(|g| dot(g, &w)).collect()).collect();
        // A motion that nothing resists yet goes far; the line search ends it where something does.
        let all: f64 = self.jumps.iter().map(|g| dot(g, g)).sum();
        let largest = self.stiffness.iter().fold(0.0, |a: f64, s| a.max(*s));
        (0..h.len()).for_each(|k| h[k][k] += 1e-9 * all * largest / self.friction.len() as f64);
        h
    }

    /// The length at which the slope of the energy vanishes along a descent direction whose load does `work`.
    fn rest_along(&self, v: &[f64], dv: &[f64], work: f64, held: &[f64]) -> f64 {
        let slope = |t: f64| {
            let along = |(i, (v, dv)): (usize, (&f64, &f64))| {
                let v = v + t * dv;
                self.spring(i, v, held) * v * dv
            };
            v.iter().zip(dv).enumerate().map(along).sum::<f64>() - work
        };
        let mut high = 1.0;
        for _ in 0..DOUBLINGS {
            if slope(high) >= 0.0 {
                break;
            }
            high *= 2.0;
        }
        let mut low = 0.0;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            *(if slope(middle) < 0.0 { &mut low } else { &mut high }) = middle;
        }
        low
    }
}
