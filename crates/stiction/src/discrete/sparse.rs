use super::V3;
use super::blocks::{Blocks, scales};
use super::condense::{Recovered, balance_of_bodies};
use super::linear::{LinearSystem, dot, verified};
use super::problem::GlobalProblem;
use super::saddle::{Order, Touch, bordered};
use super::system::{Operator, in_three};
use crate::Error;
use crate::friction::law::Linearisation;
use crate::linalg::{Csr, Lu, axpy, inverse_forms};

/// A global problem with its velocities kept as unknowns: `W = H' A⁻¹ H` is never formed, with `A = [M -G; G' 0]`.
#[derive(Debug)]
pub(super) struct Sparse {
    A: Csr,
    factor: Lu,
    order: Order,
    /// `dm x (n + p)`.
    directions: Csr,
    H: Csr,
    /// `f`, then `-b`.
    load: Vec<f64>,
    w: Vec<f64>,
    /// `s_a`.
    scale: Vec<f64>,
    touches: Vec<Touch>,
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
        let factor = Lu::new(&a, &order.plan(&a, &[])).and_then(|lu| verified(lu, &a)).ok_or_else(|| {
            let what = "M is singular, or its bilateral constraints hold nothing";
            Error::new("M", what, "each body needs its mass, or enough support")
        })?;
        let mut h = problem.H.clone();
        h.rows = a.rows;
        h.start.resize(a.rows + 1, h.value.len());
        let directions = h.transpose();
        let forms = inverse_forms(&factor, &directions);
        let traces: Vec<f64> = forms.chunks_exact(d).map(|f| f.iter().sum()).collect();
        let scale = scales(&traces);
        let touches = (0..m).map(|a| Touch::new(&directions, d, &order, a, scale[a])).collect();
        let mut load = problem.f.clone();
        load.extend(problem.equalities.iter().flat_map(|e| e.b.iter().map(|b| -b)));
        let (w, offset) = (problem.w.clone(), Vec::new());
        let mut sparse =
            Sparse { A: a, factor, order, directions, H: h, load, w, scale, touches, dimension: d, traces, offset };
        sparse.offset = sparse.state(&vec![0.0; d * m]).1;
        Ok(sparse)
    }

    /// Velocities of the bodies with the impulses of constraints, and velocities of the points, at impulses `r`; in the
    /// units of the problem.
    pub(super) fn state(&self, r: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut load = self.H.times(r);
        axpy(1.0, &self.load, &mut load);
        let mut x = self.factor.solve(&load);
        let mut residual = load;
        axpy(-1.0, &self.A.times(&x), &mut residual);
        axpy(1.0, &self.factor.solve(&residual), &mut x);
        let mut u = self.directions.times(&x);
        axpy(1.0, &self.w, &mut u);
        (x, u)
    }

    /// What belongs to impulses `r` of the problem this was made of.
    pub(super) fn recover(&self, problem: &GlobalProblem, r: &[f64]) -> Recovered {
        let (mut v, u) = self.state(r);
        let l = v.split_off(problem.f.len());
        Recovered { equilibrium: balance_of_bodies(problem, r, &v, &l), u, v, l }
    }
}

impl Operator for Sparse {
    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn times(&self, r: &[V3]) -> Vec<V3> {
        let of_point = |(r, s): (&V3, &f64)| r.map(|x| x * s).into_iter().take(self.dimension);
        let impulses: Vec<f64> = r.iter().zip(&self.scale).flat_map(of_point).collect();
        let mut u = in_three(self.dimension, &self.directions.times(&self.factor.solve(&self.H.times(&impulses))));
        u.iter_mut().zip(&self.scale).for_each(|(u, s)| *u = u.map(|x| x * s));
        u
    }

    /// With the velocities `x` of bodies as unknowns beside the `y` of [`Linearisation`]:
    ///
    /// ```text
    /// A dx - H C y                                            = H known
    /// rows' H' dx + compliance y = rhs
    /// ```
    fn linearised(&self, points: &[Linearisation]) -> LinearSystem {
        let n = self.A.rows;
        let first = LinearSystem::number(points, n);
        let size = first[points.len()];
        let (mut matrix, mut rhs) = (Csr::zero(size, size), vec![0.0; size]);
        // Columns -H C by row of A.
        let mut beside: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        for (a, (point, touch)) in points.iter().zip(&self.touches).enumerate() {
            for (&i, h) in touch.unknowns.iter().zip(&touch.direction) {
                rhs[i as usize] += dot(h, &point.known);
                let columns = (first[a] as u32..).zip(&point.columns[..point.unknowns]);
                beside[i as usize].extend(columns.map(|(k, column)| (k, -dot(h, column))));
            }
        }
        for (i, beside) in beside.iter().enumerate() {
            let (columns, values) = self.A.row(i);
            matrix.column.extend(columns.iter().copied().chain(beside.iter().map(|e| e.0)));
            matrix.value.extend(values.iter().copied().chain(beside.iter().map(|e| e.1)));
            matrix.start[i + 1] = matrix.column.len();
        }
        for (a, (point, touch)) in points.iter().zip(&self.touches).enumerate() {
            for k in 0..point.unknowns {
                matrix.column.extend_from_slice(&touch.unknowns);
                matrix.value.extend(touch.direction.iter().map(|h| dot(h, &point.rows[k])));
                for l in 0..point.unknowns {
                    matrix.column.push((first[a] + l) as u32);
                    matrix.value.push(if k == l { point.compliance[k] } else { 0.0 });
                }
                matrix.start[first[a] + k + 1] = matrix.column.len();
                rhs[first[a] + k] = point.rhs[k];
            }
        }
        LinearSystem { matrix, rhs, first }
    }

    fn factor(&self, points: &[Linearisation], linear: &LinearSystem) -> Option<Lu> {
        let active = points.iter().zip(&self.touches).filter(|(p, _)| p.unknowns > 0);
        let touched: Vec<(usize, &[u32])> = active.map(|(p, touch)| (p.unknowns, &touch.unknowns[..])).collect();
        Lu::new(&linear.matrix, &self.order.plan(&linear.matrix, &touched))
    }

    fn blocks(&self) -> Option<&Blocks> {
        None
    }
}
