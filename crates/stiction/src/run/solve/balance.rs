//! The balance of energy from the start of the first load step.

use crate::contact::{ContactProblem, Friction};
use crate::linalg::dot;
use crate::run::pose::load_state::{Initial, LoadState, jump};

/// Energies since the start, force times length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Work of loads, temperature, supports and moving obstacles on the body: mean of the forces before and after each
    /// step, times the displacement of the step.
    pub work: f64,
    /// Elastic energy of body and springs now, `1/2 u'Ku` over all degrees of freedom, less thermal strain.
    pub elastic: f64,
    /// Sum of `lambda_t . slip` over points and steps, >= 0: what friction takes under the law of each step.
    pub dissipation: f64,
}

impl Balance {
    /// What the balance misses, `work - elastic - dissipation`. A step of length `dt` adds `O(dt²)` to it: half the
    /// change of friction times the slip (implicit Euler), and half the force of what closes or opens times its way.
    pub fn drift(&self) -> f64 {
        self.work - self.elastic - self.dissipation
    }
}

/// The body at the end of a step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BodyState {
    pub loads: LoadState,
    /// Displacements of the unknowns, length `n`.
    pub u: Vec<f64>,
    /// Newton, length `3m`.
    pub lambda: Vec<f64>,
    pub balance: Balance,
}

/// The balance after the step from `before` to the solution `(u, lambda)` of `problem`, which holds what acts at
/// `loads`.
pub(crate) fn balance(
    problem: &ContactProblem,
    before: &BodyState,
    loads: &LoadState,
    u: &[f64],
    lambda: &[f64],
) -> Balance {
    let (old, m) = (&before.loads, problem.points());
    let mean_dot = |a: &[f64], b: &[f64], x: &[f64], y: &[f64]| -> f64 {
        a.iter().zip(b).zip(x.iter().zip(y)).map(|((a, b), (x, y))| 0.5 * (a + b) * (y - x)).sum()
    };
    let mut work = before.balance.work;
    work += mean_dot(&old.load, &loads.load, &before.u, u);
    work -= mean_dot(&before.lambda, lambda, &old.motion, &loads.motion);
    work -= work_of_switched(problem, before, loads, u, lambda);
    if problem.labels.supports.is_some() {
        let (first, last) =
            (support_forces(problem, &before.u, &before.lambda, old), support_forces(problem, u, lambda, loads));
        work += mean_dot(&first, &last, &old.displacement, &loads.displacement);
    }
    work += initial_energy(&loads.initial, u, &loads.displacement)
        - initial_energy(&old.initial, &before.u, &old.displacement);
    let slip = problem.gap_and_slip(u);
    let taken: f64 = (m..3 * m).map(|i| -lambda[i] * slip[i]).sum();
    Balance {
        work,
        elastic: elastic(problem, u, &loads.displacement) + initial_energy(&loads.initial, u, &loads.displacement),
        dissipation: before.balance.dissipation + taken,
    }
}

/// What the work of moving obstacles misses where points are taken out, or tied or overlapping ones put in: their forces vanish or arise
/// along the way of the body.
fn work_of_switched(problem: &ContactProblem, before: &BodyState, loads: &LoadState, u: &[f64], lambda: &[f64]) -> f64 {
    let old = &before.loads;
    if old.out.is_empty() && loads.out.is_empty() {
        return 0.0;
    }
    let is_out = |list: &[(usize, f64)], j: usize| list.binary_search_by_key(&j, |out| out.0).is_ok();
    let [from, to] = [jump(problem, &old.displacement, &before.u), jump(problem, &loads.displacement, u)];
    let way = |i: usize| (to[i] - from[i]) - (loads.motion[i] - old.motion[i]);
    let of_row = |i: usize| 0.5 * (before.lambda[i] + lambda[i]) * way(i);
    let gap = problem.gap_and_slip(u);
    let of_point = |j: usize| -> f64 {
        let rows = problem.rows(j);
        let tied = problem.contact.friction[j] == Friction::Bonded;
        if is_out(&loads.out, j) || is_out(&old.out, j) && tied {
            rows.map(of_row).into_iter().sum()
        } else if is_out(&old.out, j) && gap[j] + way(rows[0]) < 0.0 {
            // What overlaps is pushed out.
            of_row(rows[0])
        } else {
            0.0
        }
    };
    (0..problem.points()).map(of_point).sum()
}

/// All forces on the prescribed degrees of freedom but those of contact, newton: loads and reactions.
fn support_forces(problem: &ContactProblem, u: &[f64], lambda: &[f64], loads: &LoadState) -> Vec<f64> {
    let Some(supports) = &problem.labels.supports else { return Vec::new() };
    let mut force = supports.K.times(u);
    force.iter_mut().zip(supports.K_own.times(&loads.displacement)).for_each(|(f, k)| *f += k);
    force.iter_mut().zip(supports.B.transpose_times(lambda)).for_each(|(f, b)| *f += b);
    force
}

/// What strain without stress changes in the elastic energy: `1/2 ∫ (e - e0) C (e - e0) - 1/2 ∫ e C e`. Its forces are
/// among the loads, whose work is that of the temperature but for this.
fn initial_energy(initial: &Initial, u: &[f64], held: &[f64]) -> f64 {
    initial.energy - dot(&initial.load, u) - dot(&initial.support_load, held)
}

fn elastic(problem: &ContactProblem, u: &[f64], held: &[f64]) -> f64 {
    let mixed = problem.labels.supports.as_ref().map_or(0.0, |s| {
        let (from_free, own) = (s.K.times(u), s.K_own.times(held));
        dot(&from_free, held) + 0.5 * dot(&own, held)
    });
    0.5 * dot(&problem.elastic.K.times(u), u) + mixed
}
