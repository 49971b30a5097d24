use super::condense::{Condensed, Recovered, components, condense, imbalance, symmetric_pattern};
use super::measures::{Measures, measure};
use super::problem::{DiscreteProblem, GlobalProblem};
use super::redundant::{Independent, independent};
use super::saddle::Order;
use super::settings::{Method, Progress, Settings, Solution};
use super::solve::solve;
use super::sparse::Sparse;
use super::system::Discrete;
use crate::Error;
use crate::linalg::Watch;

/// Whether the velocities of bodies are eliminated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// The cheaper one by prediction.
    #[default]
    Auto,
    /// `W` is formed.
    Condensed,
    /// Velocities stay unknowns, matrices sparse; for global problems.
    Sparse,
}

/// A problem made ready to be solved.
#[derive(Debug)]
pub struct Prepared<'a> {
    given: &'a DiscreteProblem,
    independent: Independent<'a>,
    body: Body,
}

#[derive(Debug)]
enum Body {
    Condensed(Box<Condensed>),
    Sparse(Box<Sparse>),
}

/// Thresholds of the choice of form, by bricks of 4 to 16 cells solved in both forms (docs/matrices.md).
struct Threshold;

impl Threshold {
    /// Below this order of the dense part of `W` condensing is never dear.
    const SMALL: usize = 600;
    /// Newton steps that a typical solve takes.
    const STEPS: f64 = 20.0;
    /// A multiplication in a triangular solve takes the time of so many in a factorisation by fronts.
    const SOLVES: f64 = 8.0;
}

/// Leaves out redundant bilateral constraints, and condenses or factorises.
///
/// # Errors
/// If `M` is singular, or bilateral constraints contradict each other.
pub fn prepare(problem: &DiscreteProblem, form: Form, method: Method) -> Result<Prepared<'_>, Error> {
    let independent = independent(problem)?;
    let body = match &*independent.problem {
        DiscreteProblem::Global(global) => match sparse_order(global, form, method) {
            Some(order) => Body::Sparse(Box::new(Sparse::new(global, order)?)),
            None => Body::Condensed(Box::new(condense(&independent.problem)?)),
        },
        DiscreteProblem::Local(_) => Body::Condensed(Box::new(condense(&independent.problem)?)),
    };
    Ok(Prepared { given: problem, independent, body })
}

/// The elimination order of a problem that is not to be condensed.
fn sparse_order(problem: &GlobalProblem, form: Form, method: Method) -> Option<Order> {
    // Sweeps need the rows of W.
    if form == Form::Condensed || method == Method::GaussSeidel {
        return None;
    }
    let bodies = touched_components(problem);
    if form == Form::Auto && bodies.iter().all(|b| b.impulses <= Threshold::SMALL) {
        return None;
    }
    let order = Order::new(problem);
    if form == Form::Sparse {
        return Some(order);
    }
    let [factor, entries] = order.cost(problem);
    let unknowns = problem.f.len().max(1) as f64;
    let condensed: f64 = bodies
        .iter()
        .map(|b| {
            let (k, part) = (b.impulses as f64, b.unknowns as f64 / unknowns);
            Threshold::STEPS * k.powi(3) * 2.0 / 3.0 + Threshold::SOLVES * k * 4.0 * entries * part
        })
        .sum();
    // The factor of A, its inverse on the pattern, and one factor a Newton step.
    (factor * (Threshold::STEPS + 3.0) < condensed).then_some(order)
}

struct TouchedComponent {
    unknowns: usize,
    /// Components of contact impulses that act on it.
    impulses: usize,
}

/// Unknowns that `M` couples.
fn touched_components(problem: &GlobalProblem) -> Vec<TouchedComponent> {
    let mut seen = vec![u32::MAX; problem.w.len()];
    let mut all = Vec::new();
    for (number, unknowns) in (0..).zip(components(&symmetric_pattern(&problem.M))) {
        let mut impulses = 0;
        for &j in unknowns.iter().flat_map(|&i| problem.H.row(i as usize).0) {
            impulses += usize::from(std::mem::replace(&mut seen[j as usize], number) != number);
        }
        all.push(TouchedComponent { unknowns: unknowns.len(), impulses });
    }
    all
}

impl Prepared<'_> {
    /// Solves by the method of the settings; see [`solve`].
    ///
    /// # Errors
    /// As [`solve`].
    pub fn solve(&self, settings: &Settings, observer: &mut Watch<Progress>) -> Result<Solution, Error> {
        match &self.body {
            Body::Condensed(condensed) => solve(&condensed.local, settings, observer),
            Body::Sparse(sparse) => {
                let Sparse { dimension, traces, offset, .. } = &**sparse;
                let system = Discrete::new(*dimension, self.given.mu(), offset, &**sparse);
                system.solve(traces, offset, &|r| sparse.state(r).1, settings, observer)
            }
        }
    }

    /// Velocities and bilateral impulses for impulses `r`, `dm`.
    pub fn recover(&self, r: &[f64]) -> Recovered {
        let mut recovered = match (&self.body, &*self.independent.problem) {
            (Body::Sparse(sparse), DiscreteProblem::Global(global)) => sparse.recover(global, r),
            (Body::Sparse(_), DiscreteProblem::Local(_)) => unreachable!("only global problems keep their velocities"),
            (Body::Condensed(condensed), problem) => condensed.recover(problem, r),
        };
        if self.independent.dropped() > 0 {
            recovered.l = self.independent.all(&recovered.l);
            recovered.equilibrium = recovered.equilibrium.max(imbalance(self.given, r, &recovered));
        }
        recovered
    }

    /// Judges impulses `r` at velocities `u` of the points, both `dm`.
    pub fn measures(&self, r: &[f64], u: &[f64]) -> Measures {
        match &self.body {
            Body::Condensed(condensed) => {
                let local = &condensed.local;
                measure(local.dimension, &local.mu, &local.traces(), &local.q, r, u)
            }
            Body::Sparse(s) => measure(s.dimension, self.given.mu(), &s.traces, &s.offset, r, u),
        }
    }

    /// The condensed problem, if there is one.
    pub fn condensed(&self) -> Option<&Condensed> {
        match &self.body {
            Body::Condensed(condensed) => Some(condensed),
            Body::Sparse(_) => None,
        }
    }

    /// Bilateral constraints left out because they follow from others.
    pub fn dropped(&self) -> usize {
        self.independent.dropped()
    }
}
