//! One problem from several starts: whether there are further solutions.

use std::ops::ControlFlow;

use super::{Kept, Observer, Operator, solve_validated};
use crate::Error;
use crate::contact::{ContactProblem, Friction};
use crate::friction::{Settings, Solution, Status};
use crate::linalg::{memory, norm};

/// What a solve begins with. Each is the solution of related problems whose friction does not follow the normal force, or
/// follows it with another coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// What the solver begins with where nothing is given.
    Default,
    /// All points stick.
    Stick,
    /// Friction acts as if all points slipped where they do without friction.
    WithSlip,
    /// The same against the slip that there is without friction.
    AgainstSlip,
    /// The coefficient rises from zero.
    RisingFriction,
    /// The coefficient falls from a multiple.
    FallingFriction,
    /// The mean of two solutions that were found, by their places: between two that attract the solver lies one that does not.
    Between(usize, usize),
    /// Random forces and bounds of friction, by the number of the start.
    Random(usize),
}

/// A start and what came of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attempt {
    /// What it began with.
    pub start: Start,
    /// How it ended.
    pub status: Status,
    /// The place of its answer among the [`distinct`](Solutions::distinct) ones, if it is certified.
    pub solution: Option<usize>,
}

/// What several starts have found.
#[derive(Debug, Clone, Default)]
pub struct Solutions {
    /// One for each start, in their order.
    pub attempts: Vec<Attempt>,
    /// Certified solutions that differ, in the order in which they were found.
    pub distinct: Vec<Solution>,
    /// Why not all starts were tried: too little memory, or it was stopped.
    pub ended: Option<Error>,
}

struct Threshold;

impl Threshold {
    /// Two solutions are one if no force and no displacement differs by more than this part of the largest. The certificate
    /// alone does not say how near a solution is: errors grow by `1 / (1 - contraction)`.
    const SAME: f64 = 1e-3;
    /// Accuracy of the problems that lead to a start.
    const ROUGH: f64 = 1e-4;
    /// The coefficients of a continuation, over the one of the problem.
    const RISING: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
    const FALLING: [f64; 3] = [8.0, 3.0, 1.5];
    /// A bound of friction over the size of all forces, at which every point sticks.
    const STICKS: f64 = 1e3;
    /// Largest random force and largest random bound of friction, over the bound by the normal force without friction.
    const RANDOM: f64 = 2.0;
}

impl Start {
    /// In words.
    pub fn name(self) -> String {
        match self {
            Start::Default => "default".into(),
            Start::Stick => "all stick".into(),
            Start::WithSlip => "with the slip".into(),
            Start::AgainstSlip => "against the slip".into(),
            Start::RisingFriction => "rising friction".into(),
            Start::FallingFriction => "falling friction".into(),
            Start::Between(a, b) => format!("between {} and {}", a + 1, b + 1),
            Start::Random(number) => format!("random {number}"),
        }
    }

    const FIRST: [Start; 6] = [
        Start::Default,
        Start::Stick,
        Start::WithSlip,
        Start::AgainstSlip,
        Start::RisingFriction,
        Start::FallingFriction,
    ];

    /// The next start after those that `found` knows.
    fn next(found: &Solutions) -> Start {
        let tried = found.attempts.len();
        let is_new = |start: &Start| found.attempts.iter().all(|attempt| attempt.start != *start);
        let pairs = (1..found.distinct.len()).flat_map(|b| (0..b).map(move |a| Start::Between(a, b)));
        Self::FIRST.get(tried).copied().or_else(|| pairs.into_iter().find(is_new)).unwrap_or(Start::Random(tried))
    }
}

/// Multipliers (`3m`) and displacements (`n`).
type State = (Vec<f64>, Vec<f64>);

/// Solves the problem from `starts` starts, of which `first` is what the first one, [`Start::Default`], has found: the other
/// ones look for solutions elsewhere. Without Coulomb friction there is one solution, up to motions that nothing resists, and
/// no other start is tried.
///
/// Problem and settings are valid, and `first` is a solution of them: [`solve`](crate::solve) has checked the former and
/// returned the latter. `kept` is what the first solve has kept. A start that fails is an [`Attempt`] without a solution. The problem is copied once, `K` is shared.
pub fn solve_from_starts(
    problem: &ContactProblem,
    settings: &Settings,
    first: &Solution,
    starts: usize,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Solutions {
    let mut found = Solutions::default();
    // The displacement that the loads cause at a node held by its neighbours: where nothing moves there is no other.
    let of_load = |(i, f): (usize, &f64)| f.abs() / problem.elastic.K.diagonal(i);
    let length = problem.elastic.f.iter().enumerate().map(of_load).fold(0.0, f64::max);
    found.take(Start::Default, first.clone(), length);
    if problem.contact.friction.iter().all(|law| law.coefficient().is_none_or(|coefficient| coefficient == 0.0)) {
        return found;
    }
    let stored = problem.contact.B.value.len() * 16 + problem.unknowns() * 80;
    found.ended = memory::ensure("a copy of the problem for other starts", stored as f64, settings.memory_limit).err();
    if found.ended.is_some() {
        return found;
    }
    let mut search = Search { varied: problem.clone(), problem, settings, kept, observer, without_friction: None };
    while found.attempts.len() < starts {
        let start = Start::next(&found);
        match search.solve_from(start, &found.distinct) {
            Ok(solution) => found.take(start, solution, length),
            Err(error) => {
                found.ended = Some(error);
                break;
            }
        }
    }
    found
}

impl Solutions {
    fn take(&mut self, start: Start, solution: Solution, length: f64) {
        let status = solution.status;
        let certified = status == Status::Solved;
        let known = self.distinct.iter().position(|other| certified && is_same(other, &solution, length));
        let place = known.or_else(|| certified.then_some(self.distinct.len()));
        if known.is_none() && certified {
            self.distinct.push(solution);
        }
        self.attempts.push(Attempt { start, status, solution: place });
    }
}

/// Whether forces and displacements agree; displacements are also held against `length`.
fn is_same(a: &Solution, b: &Solution, length: f64) -> bool {
    let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let same = |a: &[f64], b: &[f64], least: f64| {
        let apart = a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        apart <= Threshold::SAME * largest(a).max(largest(b)).max(least)
    };
    same(&a.lambda, &b.lambda, 0.0) && same(&a.u, &b.u, length)
}

struct Search<'a, 'b> {
    problem: &'a ContactProblem,
    /// A copy with other friction and other loads.
    varied: ContactProblem,
    settings: &'a Settings,
    kept: &'a mut Kept,
    observer: &'a mut Observer<'b>,
    without_friction: Option<State>,
}

impl Search<'_, '_> {
    fn solve_from(&mut self, start: Start, found: &[Solution]) -> Result<Solution, Error> {
        let m = self.problem.points();
        let none = vec![0.0; 2 * m];
        let scaled = |factor: f64| {
            move |law: Friction, _: usize| match law {
                Friction::Coulomb { coefficient } => Friction::Coulomb { coefficient: factor * coefficient },
                Friction::Limited { coefficient, limit } => {
                    Friction::Limited { coefficient: factor * coefficient, limit: factor * limit }
                }
                other => other,
            }
        };
        let mut state = None;
        match start {
            Start::Default => {}
            Start::Stick => state = Some(self.sticking()?),
            Start::WithSlip | Start::AgainstSlip => {
                let (lambda, u) = self.frictionless()?;
                let v = self.problem.gap_and_slip(&u);
                let along = if start == Start::WithSlip { -1.0 } else { 1.0 };
                let mut force = none;
                for j in 0..m {
                    let length = v[m + j].hypot(v[2 * m + j]).max(f64::MIN_POSITIVE);
                    let bound = self.bound(j, lambda[j]);
                    (0..2).for_each(|c| force[c * m + j] = along * bound * v[(c + 1) * m + j] / length);
                }
                state = Some(self.vary(|_, _| Friction::None, &force, Some((lambda, u)))?);
            }
            Start::RisingFriction => {
                for factor in Threshold::RISING {
                    state = Some(self.vary(scaled(factor), &none, state)?);
                }
            }
            Start::FallingFriction => {
                state = Some(self.sticking()?);
                for factor in Threshold::FALLING {
                    state = Some(self.vary(scaled(factor), &none, state)?);
                }
            }
            Start::Between(a, b) => {
                let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
                state = Some((mean(&found[a].lambda, &found[b].lambda), mean(&found[a].u, &found[b].u)));
            }
            Start::Random(number) => {
                let (lambda, u) = self.frictionless()?;
                let mut draw = uniform(number as u64);
                let turn = std::f64::consts::TAU * draw();
                let mut force = none;
                let mut bounds = vec![0.0; m];
                for j in 0..m {
                    let bound = Threshold::RANDOM * self.bound(j, lambda[j]);
                    let (part, angle) = (draw(), turn + draw() - 0.5);
                    (force[j], force[m + j]) = (bound * part * angle.cos(), bound * part * angle.sin());
                    bounds[j] = bound * draw();
                }
                let given = |_, j: usize| Friction::Given { slip_bound: bounds[j] };
                state = Some(self.vary(given, &force, Some((lambda, u)))?);
            }
        }
        self.solve(self.settings.tolerance, state, false)
    }

    /// The friction that the normal force bounds, newton.
    fn bound(&self, j: usize, normal: f64) -> f64 {
        let bound = self.problem.contact.friction[j].bound(normal);
        if bound.is_finite() { bound } else { 0.0 }
    }

    fn frictionless(&mut self) -> Result<State, Error> {
        let state = match self.without_friction.take() {
            Some(state) => state,
            None => self.vary(|_, _| Friction::None, &vec![0.0; 2 * self.problem.points()], None)?,
        };
        self.without_friction = Some(state.clone());
        Ok(state)
    }

    fn sticking(&mut self) -> Result<State, Error> {
        let (lambda, u) = self.frictionless()?;
        let slip_bound = Threshold::STICKS * norm(&self.problem.elastic.f).max(norm(&lambda));
        self.vary(|_, _| Friction::Given { slip_bound }, &vec![0.0; 2 * self.problem.points()], Some((lambda, u)))
    }

    /// The answer of the problem with other laws for points that are not tied and with tangential forces of the body on its
    /// counterpart (`2m`, newton) beside those of the law; both are part of the multipliers. Whatever the iteration comes to
    /// is a start.
    fn vary(
        &mut self,
        law: impl Fn(Friction, usize) -> Friction,
        force: &[f64],
        from: Option<State>,
    ) -> Result<State, Error> {
        let m = self.problem.points();
        let laws = self.problem.contact.friction.iter().enumerate();
        self.varied.contact.friction =
            laws.map(|(j, &old)| if old == Friction::Bonded { old } else { law(old, j) }).collect();
        let all: Vec<f64> = std::iter::repeat_n(0.0, m).chain(force.iter().copied()).collect();
        let load = self.problem.contact.B.transpose_times(&all);
        self.varied.elastic.f = self.problem.elastic.f.iter().zip(load).map(|(f, load)| f - load).collect();
        let mut solution = self.solve(Threshold::ROUGH.max(self.settings.tolerance), from, true)?;
        solution.lambda.iter_mut().zip(all).for_each(|(lambda, force)| *lambda += force);
        Ok((solution.lambda, solution.u))
    }

    fn solve(&mut self, tolerance: f64, from: Option<State>, varied: bool) -> Result<Solution, Error> {
        let problem = if varied { &self.varied } else { self.problem };
        let (mut start, mut start_displacement) = (None, None);
        if let Some((lambda, u)) = from {
            let by_multigrid = match &self.kept.operator {
                Some(operator) => matches!(operator, Operator::Multigrid(..)),
                None => self.kept.begins_with_multigrid(problem, self.settings),
            };
            match by_multigrid {
                true => start_displacement = Some(u),
                false => start = Some(lambda),
            }
        }
        let settings = Settings { tolerance, start, start_displacement, ..self.settings.clone() };
        // What a start iterates is not the history of the answer.
        let observer: &mut Observer = &mut |event| match event {
            super::SolveEvent::Iteration(_) if varied => ControlFlow::Continue(()),
            event => (self.observer)(event),
        };
        let solution = solve_validated(problem, &settings, self.kept, observer)?;
        if solution.status == Status::Interrupted { Err(Error::interrupted()) } else { Ok(solution) }
    }
}

/// Numbers in `0..1`, the same for the same seed (SplitMix64, Steele, Lea & Flood 2014).
fn uniform(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
