use super::active_set::PointLaw;
use super::descent::descend;
use super::iteration::{Iterate, Observe, State, Subproblem, judge, run};
use crate::friction::End;
use crate::friction::law::frozen;
use crate::linalg::multigrid::Hierarchy;

/// Thresholds of [`fixed_point`], by the random cases that the active-set iteration leaves.
struct Threshold;

impl Threshold {
    /// Accuracy of the problems with given friction, over the violation of Coulomb's law, and its upper bound.
    const INNER: f64 = 0.1;
    const INNER_MOST: f64 = 0.02;
    /// Below this violation the active-set iteration is tried on Coulomb's law itself, and after a failure again below
    /// [`Self::NEARER`] times the violation it began with.
    const NEAR: f64 = 0.05;
    const NEARER: f64 = 0.1;
    /// First and least relaxation of the bounds. A half contracts even where a bound that falls raises the next one by up to three
    /// times as much. Where a body is wedged and friction carries most of the load that is not enough: it is halved while the
    /// violation does not fall below [`Self::FALLS`] times the last one.
    const RELAXATION: [f64; 2] = [0.5, 0.06];
    const FALLS: f64 = 0.8;
    /// Changes of the bounds, one after the other, that no cycle follows: the least relaxation has taken them to where they tend by
    /// then, to six digits.
    const IDLE: usize = 250;
}

/// Coulomb friction by the fixed point on the slip bounds (Necas, Jarusek & Haslinger 1980), for active sets that cycle: each
/// problem with given friction minimises an energy, which the descent does where the active-set iteration fails. Close to the
/// solution the active-set iteration on Coulomb's law is faster. It ends where the loads overcome the bounds: the body
/// slides off, and the bounds of its contact forces there do not hold it either; and where bounds that do not change any more leave the
/// law violated: a point that opens loses its cohesion, of which given friction knows nothing.
pub(super) fn fixed_point(
    problem: &Subproblem<'_>,
    hierarchy: &mut Hierarchy,
    state: &mut State,
    observe: &mut Observe<'_>,
) -> End {
    if judge(problem, &mut state.iterate) > Threshold::NEAR
        && let Some(floating) = problem.floating
    {
        floating.balance(problem, &mut state.iterate);
    }
    let (mut normals, mut accuracy, mut near) =
        (normal_forces(problem, &state.iterate), Threshold::INNER_MOST, Threshold::NEAR);
    let ([mut relaxation, least], mut last) = (Threshold::RELAXATION, f64::INFINITY);
    let mut idle = 0;
    loop {
        let cycles = state.cycles;
        let given: Vec<PointLaw> = (problem.laws.iter().zip(&normals))
            .map(|(law, &normal)| PointLaw { friction: frozen(law.friction, normal), ..*law })
            .collect();
        let inner = Subproblem { laws: &given, tolerance: accuracy, ..*problem };
        let known = problem.floating.filter(|_| !problem.transformed.halo().is_divided());
        let slides_off = || known.is_some_and(|floating| floating.slide_off(&normals));
        let end = attempt(&inner, hierarchy, state, observe)
            .unwrap_or_else(|| descend(&inner, hierarchy, state, &slides_off, observe));
        if end != End::Converged {
            return end;
        }
        let violated = judge(problem, &mut state.iterate);
        if violated <= problem.tolerance {
            return End::Converged;
        }
        if violated <= near {
            if let Some(end) = attempt(problem, hierarchy, state, observe) {
                return end;
            }
            near = Threshold::NEARER * violated;
        }
        idle = if state.cycles == cycles { idle + 1 } else { 0 };
        if idle > Threshold::IDLE {
            return End::Stalled;
        }
        if violated > Threshold::FALLS * last {
            relaxation = least.max(0.5 * relaxation);
        }
        last = violated;
        let new = normal_forces(problem, &state.iterate);
        normals.iter_mut().zip(new).for_each(|(normal, new)| *normal += relaxation * (new - *normal));
        accuracy = (Threshold::INNER * violated).min(Threshold::INNER_MOST).max(0.3 * problem.tolerance);
    }
}

/// The active-set iteration from here. `None` if it fails; then only its cycles count.
fn attempt(
    problem: &Subproblem<'_>,
    hierarchy: &mut Hierarchy,
    state: &mut State,
    observe: &mut Observe<'_>,
) -> Option<End> {
    state.restart();
    let before = state.clone();
    let end = run(&Subproblem { max_resets: 0, ..*problem }, hierarchy, state, observe);
    if end != End::Stalled {
        return Some(end);
    }
    *state = before.after(state);
    None
}

/// Augmented normal forces, newton.
fn normal_forces(problem: &Subproblem<'_>, at: &Iterate) -> Vec<f64> {
    (problem.points())
        .map(|(p, law)| {
            let force = at.force(problem.transformed, p.node)[0];
            (force + law.parameter * (at.u[p.node][0] - law.target[0])).max(0.0)
        })
        .collect()
}
