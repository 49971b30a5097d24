use super::V3;
use super::blocks::plus;
use super::condense::{Recovered, balance};
use super::problem::GlobalProblem;
use super::saddle::{Order, Saddle, Touch, bordered};
use super::step::{change, refined};
use super::system::{Discrete, Shifted};
use crate::Error;
use crate::friction::law::Linearisation;
use crate::friction::system::{Iterate, Step, System, length, moved};
use crate::linalg::{Csr, Lu, axpy, inverse_forms, norm};

/// A global problem with its velocities kept as unknowns: `W = H' A⁻¹ H` is never formed, with `A = [M -G; G' 0]`.
#[derive(Debug)]
#[allow(non_snake_case)]
pub(super) struct Sparse {
    pub A: Csr,
    factor: Lu,
    pub order: Order,
    /// `dm x (n + p)`.
    directions: Csr,
    H: Csr,
    /// Number of velocities.
    unknowns: usize,
    /// `f`, then `-b`.
    load: Vec<f64>,
    w: Vec<f64>,
    pub mu: Vec<f64>,
    /// Scaled as [`super::blocks::Blocks`].
    q: Vec<V3>,
    scale: Vec<f64>,
    pub touches: Vec<Touch>,
    size: f64,
    pub dimension: usize,
    /// Trace of `W_aa` at each point.
    pub traces: Vec<f64>,
    /// `q` in the units of the problem.
    pub offset: Vec<f64>,
}

impl Sparse {
    /// Factorises; bilateral constraints have to be independent.
    ///
    /// # Errors
    /// If `M` is singular.
    pub(super) fn new(problem: &GlobalProblem, order: Order) -> Result<Self, Error> {
        let (d, m) = (problem.dimension, problem.mu.len());
        let a = bordered(problem, &order);
        let singular = || {
            let what = "M is singular, or its bilateral constraints hold nothing";
            Error::new("M", what, "each body needs its mass, or enough support")
        };
        let factor = Lu::new(&a, &order.plan(&a, &[])).ok_or_else(singular)?;
        let known: Vec<f64> = (0..a.rows).map(|i| 1.0 + (i as f64 * 0.7).sin()).collect();
        refined(&factor, &a, &known).ok_or_else(singular)?;
        let mut h = problem.H.clone();
        h.rows = a.rows;
        h.start.resize(a.rows + 1, h.value.len());
        let directions = h.transpose();
        let forms = inverse_forms(&factor, &directions);
        let traces: Vec<f64> = forms.chunks_exact(d).map(|f| f.iter().sum()).collect();
        let scale = super::blocks::scales(&traces);
        let touches = (0..m).map(|a| Touch::new(&directions, d, &order, a, scale[a])).collect();
        let mut load = problem.f.clone();
        load.extend(problem.equalities.iter().flat_map(|e| e.b.iter().map(|b| -b)));
        let mut system = Sparse {
            A: a,
            factor,
            order,
            directions,
            H: h,
            unknowns: problem.f.len(),
            w: problem.w.clone(),
            mu: problem.mu.clone(),
            q: Vec::new(),
            scale,
            touches,
            size: 1.0,
            dimension: d,
            traces,
            offset: Vec::new(),
            load,
        };
        system.offset = system.state(&vec![0.0; d * m]).1;
        let at = |a: usize, c: usize| if c < d { system.offset[d * a + c] * system.scale[a] } else { 0.0 };
        let mut q: Vec<V3> = (0..m).map(|a| std::array::from_fn(|c| at(a, c))).collect();
        let size = length(&q);
        system.size = if size > 0.0 { size } else { 1.0 };
        q.as_flattened_mut().iter_mut().for_each(|x| *x /= system.size);
        system.q = q;
        Ok(system)
    }

    /// Velocities of the bodies with the impulses of constraints, and velocities of the points, at impulses `r`; in the
    /// units of the problem.
    pub(super) fn state(&self, r: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut load = self.H.times(r);
        axpy(1.0, &self.load, &mut load);
        let mut x = self.factor.solve(&load);
        let mut rest = load;
        axpy(-1.0, &self.A.times(&x), &mut rest);
        axpy(1.0, &self.factor.solve(&rest), &mut x);
        let mut u = self.directions.times(&x);
        axpy(1.0, &self.w, &mut u);
        (x, u)
    }

    /// What belongs to impulses `r`; impulses of constraints as they are numbered here.
    pub(super) fn recover(&self, r: &[f64]) -> Recovered {
        let (mut v, u) = self.state(r);
        let n = self.unknowns;
        let mut load = self.H.times(r);
        axpy(1.0, &self.load, &mut load);
        let inner: Vec<f64> = self.A.times(&v).iter().map(|x| -x).collect();
        let mut equilibrium = balance(&[&inner[..n], &load[..n]]);
        if n < v.len() {
            // Where b vanishes, the terms of G' v are the scale.
            let terms = |i: usize| self.A.row(i).0.iter().zip(self.A.row(i).1).map(|(&j, g)| (g * v[j as usize]).abs());
            let speeds: Vec<f64> = (n..v.len()).map(|i| terms(i).sum()).collect();
            let rest: Vec<f64> = (n..v.len()).map(|i| inner[i] + load[i]).collect();
            let scale = norm(&speeds).max(norm(&load[n..]));
            equilibrium = equilibrium.max(if scale > 0.0 { norm(&rest) / scale } else { 0.0 });
        }
        let l = v.split_off(n);
        Recovered { u, v, l, equilibrium }
    }

    /// Scaled impulses in the units of the problem, `dm`.
    pub(super) fn unscaled(&self, r: &[V3]) -> Vec<f64> {
        let of_point = |(r, s): (&V3, &f64)| r.map(|x| x * s * self.size);
        let all: Vec<V3> = r.iter().zip(&self.scale).map(of_point).collect();
        all.iter().flat_map(|r| r[..self.dimension].iter().copied()).collect()
    }

    /// Impulses of length `dm` scaled.
    pub(super) fn scaled(&self, r: &[f64]) -> Vec<V3> {
        let d = self.dimension;
        let at = |a: usize, c: usize| if c < d { r[d * a + c] / (self.scale[a] * self.size) } else { 0.0 };
        (0..self.mu.len()).map(|a| std::array::from_fn(|c| at(a, c))).collect()
    }
}

impl System for Sparse {
    fn live(&self, _: usize) -> [bool; 3] {
        [true; 3]
    }

    fn imbalance(&self, _: &[V3]) -> Vec<f64> {
        Vec::new()
    }

    fn step(&self, _: &Iterate, points: &[Linearisation], _: f64) -> Option<Step> {
        let saddle = Saddle::new(self, points);
        let y = refined(&saddle.factor(self)?, &saddle.matrix, &saddle.rhs)?;
        let d: Vec<V3> = points.iter().enumerate().map(|(a, p)| p.change(saddle.of_point(a, &y))).collect();
        d.as_flattened().iter().all(|x| x.is_finite()).then(|| change(d))
    }

    fn advance(&self, at: &Iterate, t: f64, step: &Step) -> Iterate {
        let lambda = moved(&at.lambda, t, &step.lambda);
        Iterate { v: self.velocity(&lambda), lambda, alpha: Vec::new() }
    }
}

impl Discrete for Sparse {
    fn mu(&self) -> &[f64] {
        &self.mu
    }

    fn offset(&self) -> &[V3] {
        &self.q
    }

    fn velocity(&self, r: &[V3]) -> Vec<V3> {
        let d = self.dimension;
        let impulses: Vec<f64> =
            r.iter().zip(&self.scale).flat_map(|(r, s)| r.map(|x| x * s).into_iter().take(d)).collect();
        let u = self.directions.times(&self.factor.solve(&self.H.times(&impulses)));
        let at = |a: usize, c: usize| if c < d { u[d * a + c] * self.scale[a] } else { 0.0 };
        (0..r.len()).map(|a| plus(&std::array::from_fn(|c| at(a, c)), &self.q[a])).collect()
    }

    fn shifted(&self, shift: f64) -> Option<Shifted<'_>> {
        let saddle_of = vec![Linearisation::free(shift); self.mu.len()];
        let saddle = Saddle::new(self, &saddle_of);
        let lu = saddle.factor(self)?;
        let n = self.A.rows;
        Some(Box::new(move |x| {
            let rhs: Vec<f64> = std::iter::repeat_n(0.0, n).chain(x.as_flattened().iter().copied()).collect();
            lu.solve(&rhs)[n..].as_chunks().0.to_vec()
        }))
    }

    fn sweep(&self, _: &mut [V3], _: usize) -> bool {
        false
    }
}
