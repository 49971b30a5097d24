use super::descent::descend;
use super::frames::Turned;
use super::iteration::{Cycles, End, Observe, State, judge, run};
use super::sets::Law;
use crate::friction::law::frozen;
use crate::linalg::multigrid::Multigrid;

/// A problem with given bounds is solved to this share of what is still wrong with them, and to this at first.
const INNER: f64 = 0.1;
const ROUGH: f64 = 0.02;
/// The law itself is tried below this violation, and once that fails below this share of where it began.
const NEAR: f64 = 0.05;
const NEARER: f64 = 0.1;

/// Coulomb friction by the fixed point on its bounds (Necas, Jarusek & Haslinger 1980), where the law itself goes round in
/// circles: each problem has given friction and a least energy, which the descent finds where the sets' own iteration does
/// not. Bounds move by half: that also contracts where a bound that falls makes the next one rise by up to three times as
/// much. Close to the solution the law itself is faster.
pub(super) fn follow_bounds(
    on: &Cycles<'_>,
    laws: &[Law],
    multigrid: &mut Multigrid,
    at: &mut State,
    observe: &mut Observe<'_>,
) -> End {
    let (turned, tolerance) = (on.turned, on.tolerance);
    if judge(turned, laws, at) > NEAR
        && let Some(floating) = on.floating
    {
        floating.settle(turned, laws, at);
    }
    let (mut normals, mut accuracy, mut near) = (normal_forces(turned, laws, at), ROUGH, NEAR);
    loop {
        let given: Vec<Law> = (laws.iter().zip(&normals))
            .map(|(law, &normal)| Law { friction: frozen(law.friction, normal), ..*law })
            .collect();
        let rough = Cycles { tolerance: accuracy, ..*on };
        let end = attempt(&rough, &given, multigrid, at, observe)
            .unwrap_or_else(|| descend(&rough, &given, multigrid, at, observe));
        if end != End::Converged {
            return end;
        }
        let wrong = judge(turned, laws, at);
        if wrong <= tolerance {
            return End::Converged;
        }
        if wrong <= near {
            if let Some(end) = attempt(on, laws, multigrid, at, observe) {
                return end;
            }
            near = NEARER * wrong;
        }
        let new = normal_forces(turned, laws, at);
        normals.iter_mut().zip(new).for_each(|(normal, new)| *normal = 0.5 * (*normal + new)); // g = F lambda_n
        accuracy = (INNER * wrong).min(ROUGH).max(0.3 * tolerance);
    }
}

/// The sets' own iteration from here; if it fails it has cost its cycles and nothing else, and `None` is returned.
fn attempt(
    on: &Cycles<'_>,
    laws: &[Law],
    multigrid: &mut Multigrid,
    at: &mut State,
    observe: &mut Observe<'_>,
) -> Option<End> {
    at.begin_anew();
    let before = at.clone();
    let end = run(on, laws, multigrid, at, 0, observe);
    if end != End::Failed {
        return Some(end);
    }
    *at = before.after(at.cycles);
    None
}

/// Augmented normal forces, newton.
fn normal_forces(turned: &Turned, laws: &[Law], at: &State) -> Vec<f64> {
    (turned.points.iter().zip(laws))
        .map(|(p, law)| {
            let force = turned.f[p.node][0] - at.ku[p.node][0];
            (force + law.parameter * (at.u[p.node][0] - law.rest[0])).max(0.0)
        })
        .collect()
}
