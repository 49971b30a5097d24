//! The balance of energy from the start of the first load step.

use crate::contact::{ContactProblem, Friction};
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

/// What counts of a problem that ranks share: each unknown, prescribed displacement and contact point on one of them.
pub(crate) struct Counted<'a> {
    pub unknown: &'a dyn Fn(usize) -> bool,
    pub held: &'a dyn Fn(usize) -> bool,
    pub point: &'a dyn Fn(usize) -> bool,
}

impl Counted<'_> {
    /// All of a problem that is no part.
    pub(crate) const ALL: Counted<'static> = Counted { unknown: &|_| true, held: &|_| true, point: &|_| true };

    /// `a . b` over the unknowns, and over the prescribed displacements.
    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        products(a, b, self.unknown)
    }

    fn dot_held(&self, a: &[f64], b: &[f64]) -> f64 {
        products(a, b, self.held)
    }
}

fn products(a: &[f64], b: &[f64], counts: &dyn Fn(usize) -> bool) -> f64 {
    a.iter().zip(b).enumerate().filter(|(i, _)| counts(*i)).map(|(_, (a, b))| a * b).sum()
}

/// `1/2 u'Ku - f'u` over all degrees of freedom that count, the prescribed ones included. `f` holds what the prescribed displacements
/// demand of the unknowns, their mixed term.
pub(crate) fn potential(problem: &ContactProblem, u: &[f64], counted: &Counted) -> f64 {
    let of = |elastic: &[f64], load: &[f64], u: &[f64], counts: &dyn Fn(usize) -> bool| -> f64 {
        let all = elastic.iter().zip(load).zip(u).enumerate().filter(|(i, _)| counts(*i));
        all.map(|(_, ((k, f), u))| (0.5 * k - f) * u).sum()
    };
    let unknowns = of(&problem.elastic.K.times(u), &problem.elastic.f, u, counted.unknown);
    let held = problem.labels.supports.as_ref();
    let held = held.map_or(0.0, |s| of(&s.K_own.times(&s.displacement), &s.load, &s.displacement, counted.held));
    unknowns + held
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
/// `loads`; what the step adds and what is stored are those of what is `counted`.
pub(crate) fn balance(
    problem: &ContactProblem,
    before: &BodyState,
    loads: &LoadState,
    u: &[f64],
    lambda: &[f64],
    counted: &Counted,
) -> Balance {
    let (old, m) = (&before.loads, problem.points());
    let mean_dot = |[a, b]: [&[f64]; 2], [x, y]: [&[f64]; 2], counts: &dyn Fn(usize) -> bool| -> f64 {
        let all = a.iter().zip(b).zip(x.iter().zip(y)).enumerate().filter(|(i, _)| counts(*i));
        all.map(|(_, ((a, b), (x, y)))| 0.5 * (a + b) * (y - x)).sum()
    };
    let of_row = |i: usize| (counted.point)(i % m);
    let mut work = before.balance.work;
    work += mean_dot([&old.load, &loads.load], [&before.u, u], counted.unknown);
    work -= mean_dot([&before.lambda, lambda], [&old.motion, &loads.motion], &of_row);
    work -= work_of_switched(problem, before, loads, u, lambda, counted);
    if problem.labels.supports.is_some() {
        let (first, last) =
            (support_forces(problem, &before.u, &before.lambda, old), support_forces(problem, u, lambda, loads));
        work += mean_dot([&first, &last], [&old.displacement, &loads.displacement], counted.held);
    }
    let stored = initial_energy(&loads.initial, u, &loads.displacement, counted);
    work += stored - initial_energy(&old.initial, &before.u, &old.displacement, counted);
    let slip = problem.gap_and_slip(u);
    let taken: f64 = (m..3 * m).filter(|i| of_row(*i)).map(|i| -lambda[i] * slip[i]).sum();
    Balance {
        work,
        elastic: elastic(problem, u, &loads.displacement, counted) + stored,
        dissipation: before.balance.dissipation + taken,
    }
}

/// What the work of moving obstacles misses where points are taken out, or tied or overlapping ones put in: their forces vanish or arise
/// along the way of the body.
fn work_of_switched(
    problem: &ContactProblem,
    before: &BodyState,
    loads: &LoadState,
    u: &[f64],
    lambda: &[f64],
    counted: &Counted,
) -> f64 {
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
    (0..problem.points()).filter(|j| (counted.point)(*j)).map(of_point).sum()
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
fn initial_energy(initial: &Initial, u: &[f64], held: &[f64], counted: &Counted) -> f64 {
    initial.energy - counted.dot(&initial.load, u) - counted.dot_held(&initial.support_load, held)
}

fn elastic(problem: &ContactProblem, u: &[f64], held: &[f64], counted: &Counted) -> f64 {
    let mixed = problem.labels.supports.as_ref().map_or(0.0, |s| {
        let (from_free, own) = (s.K.times(u), s.K_own.times(held));
        counted.dot_held(&from_free, held) + 0.5 * counted.dot_held(&own, held)
    });
    0.5 * counted.dot(&problem.elastic.K.times(u), u) + mixed
}
