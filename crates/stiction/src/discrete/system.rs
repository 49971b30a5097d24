use super::V3;
use super::blocks::Blocks;
use super::linear::LinearSystem;
use super::measures::measure;
use super::monitor::{Judged, Monitor};
use super::settings::{Progress, Settings, Solution};
use super::solve::iterate;
use crate::Error;
use crate::friction::law::Linearisation;
use crate::friction::system::{Iterate, Step, System, length, moved};
use crate::linalg::{Lu, Watch, norm};

/// `x -> (W + shift)⁻¹ x`, factorised.
pub(super) type Shifted<'a> = Box<dyn Fn(&[V3]) -> Vec<V3> + 'a>;

/// `W` between points scaled by `s_a = sqrt(3 / trace W_aa)`, stored or not.
pub(super) trait Operator {
    /// `s_a`.
    fn scale(&self) -> &[f64];

    /// `W r`.
    fn times(&self, r: &[V3]) -> Vec<V3>;

    /// The linearised laws of all points as one linear system.
    fn linearised(&self, points: &[Linearisation]) -> LinearSystem;

    /// A factor of its matrix; `None` if that is singular.
    fn factor(&self, points: &[Linearisation], linear: &LinearSystem) -> Option<Lu>;

    /// The blocks of `W`, if it is stored.
    fn blocks(&self) -> Option<&Blocks>;
}

/// Points under Coulomb's law with their velocities as an affine function of their impulses, `u = W r + q`. As a
/// [`System`] the impulses are the multipliers, the velocities `v`, and the parameter of the law is one.
///
/// With `s_a` and one number `size` of the dimension of `q`, the scaled quantities are `s_a W_ab s_b`, `s_a q_a / size`,
/// `r_a / (s_a size)` and `s_a u_a / size` (two dimensions get a third that is zero): the law of friction does not change,
/// the units vanish, every diagonal block has the trace 3 and `q` has length one.
pub(super) struct Discrete<'a> {
    pub mu: &'a [f64],
    pub q: Vec<V3>,
    size: f64,
    dimension: usize,
    pub operator: &'a dyn Operator,
}

impl<'a> Discrete<'a> {
    /// `q` in the units of the problem.
    pub(super) fn new(dimension: usize, mu: &'a [f64], q: &[f64], operator: &'a dyn Operator) -> Self {
        let mut q: Vec<V3> = in_three(dimension, q);
        q.iter_mut().zip(operator.scale()).for_each(|(q, s)| *q = q.map(|x| x * s));
        let size = Some(length(&q)).filter(|&size| size > 0.0).unwrap_or(1.0);
        q.as_flattened_mut().iter_mut().for_each(|x| *x /= size);
        Discrete { mu, q, size, dimension, operator }
    }

    /// `W r + q`.
    pub(super) fn velocity(&self, r: &[V3]) -> Vec<V3> {
        moved(&self.operator.times(r), 1.0, &self.q)
    }

    /// `x -> (W + shift)⁻¹ x`, factorised once; `None` if singular.
    pub(super) fn shifted(&self, shift: f64) -> Option<Shifted<'a>> {
        let points = vec![Linearisation::free(shift); self.mu.len()];
        let linear = self.operator.linearised(&points);
        let (lu, others) = (self.operator.factor(&points, &linear)?, linear.first[0]);
        Some(Box::new(move |x| {
            let rhs: Vec<f64> = std::iter::repeat_n(0.0, others).chain(x.as_flattened().iter().copied()).collect();
            lu.solve(&rhs)[others..].as_chunks().0.to_vec()
        }))
    }

    /// Solves by the method of the settings. `trace` and `q` are those of [`measure`], `velocity` the velocities of
    /// impulses; all in the units of the problem.
    pub(super) fn solve(
        &self,
        trace: &[f64],
        q: &[f64],
        velocity: &dyn Fn(&[f64]) -> Vec<f64>,
        settings: &Settings,
        observer: &mut Watch<Progress>,
    ) -> Result<Solution, Error> {
        let start = settings.start(q.len())?;
        let start = start.map_or_else(|| vec![[0.0; 3]; self.mu.len()], |start| self.scaled(start));
        let judge = |r: &[V3]| {
            let r = self.unscaled(r);
            let u = velocity(&r);
            let measures = measure(self.dimension, self.mu, trace, q, &r, &u);
            Judged { r, u, measures }
        };
        let (counts, history) = Default::default();
        let (mu, size_of_q, best, at_rounding) = (self.mu, norm(q), None, 0);
        let mut monitor =
            Monitor { mu, judge: &judge, size_of_q, settings, observer, counts, history, best, at_rounding };
        let status = iterate(self, start, settings.method, &mut monitor);
        Ok(monitor.solution(status))
    }

    /// Scaled impulses in the units of the problem, `dm`.
    fn unscaled(&self, r: &[V3]) -> Vec<f64> {
        let of_point = |(r, s): (&V3, &f64)| r.map(|x| x * s * self.size).into_iter().take(self.dimension);
        r.iter().zip(self.operator.scale()).flat_map(of_point).collect()
    }

    /// Impulses of length `dm` scaled.
    fn scaled(&self, r: &[f64]) -> Vec<V3> {
        let scales = self.operator.scale().iter();
        in_three(self.dimension, r).iter().zip(scales).map(|(r, s)| r.map(|x| x / (s * self.size))).collect()
    }
}

/// `d` numbers a point as three, the third zero in two dimensions.
pub(super) fn in_three(dimension: usize, x: &[f64]) -> Vec<V3> {
    x.chunks_exact(dimension).map(|x| std::array::from_fn(|c| x.get(c).copied().unwrap_or(0.0))).collect()
}

impl System for Discrete<'_> {
    fn is_exact(&self) -> bool {
        true
    }

    fn step(&self, _: &Iterate, points: &[Linearisation], _: f64) -> Option<Step> {
        let linear = self.operator.linearised(points);
        let lambda = if linear.rhs.is_empty() {
            points.iter().map(|p| p.known).collect()
        } else {
            linear.changes(&self.operator.factor(points, &linear)?, points)?
        };
        // Velocities are computed anew along the step.
        Some(Step { lambda, v: Vec::new(), alpha: Vec::new(), resisted: true })
    }

    fn advance(&self, at: &Iterate, t: f64, step: &Step) -> Iterate {
        let lambda = moved(&at.lambda, t, &step.lambda);
        Iterate { v: self.velocity(&lambda), lambda, alpha: Vec::new() }
    }
}
