use super::descent::descend;
use super::floating::Floating;
use super::frames::Turned;
use super::iteration::{End, Manner, Observe, State, run, violation};
use super::sets::{Law, set};
use crate::friction::law::frozen;
use crate::linalg::multigrid::Multigrid;

/// A problem with the bounds of friction of the last one is solved to this share of what is still wrong with them.
const INNER: f64 = 0.1;
/// And to this at first, times the load.
const ROUGH: f64 = 0.02;
/// The law itself is tried below this violation, and after a failure below this share of the present one.
const NEAR: f64 = 0.05;
const LESS: f64 = 0.1;

/// Coulomb friction by the fixed point on its bounds, where the law itself goes round in circles: each problem has given
/// friction and is convex. Bounds move by half at a time: that also contracts where a bound that falls makes the next one
/// rise by up to three times as much.
pub(super) fn follow_bounds(
    turned: &Turned,
    laws: &[Law],
    multigrid: &mut Multigrid,
    at: &mut State,
    tolerance: f64,
    max_cycles: usize,
    floating: Option<&Floating>,
    observe: &mut Observe<'_>,
) -> End {
    if let Some(floating) = floating {
        floating.settle(turned, laws, at);
    }
    let normal = |at: &State| -> Vec<f64> {
        (turned.points.iter().zip(laws))
            .map(|(p, law)| {
                let beyond = at.u[p.node][0] - law.rest[0];
                (turned.f[p.node][0] - at.ku[p.node][0] + law.parameter * beyond).max(0.0)
            })
            .collect()
    };
    let (mut normals, mut accuracy, mut near) = (normal(at), ROUGH, NEAR);
    let dbg = std::env::var("DBG").is_ok();
    loop {
        let given: Vec<Law> =
            laws.iter().zip(&normals).map(|(law, &n)| Law { friction: frozen(law.friction, n), ..*law }).collect();
        at.begin_anew();
        let before = at.clone();
        let manner = Manner { settle: floating, resets: 0 };
        let mut end = run(turned, &given, multigrid, at, accuracy, max_cycles, manner, observe);
        if end == End::Failed {
            let cycles = at.cycles;
            *at = before;
            at.cycles = cycles;
            if dbg { println!("-- descend {cycles}"); }
            end = descend(turned, &given, multigrid, at, accuracy, max_cycles, floating, observe);
        }
        if end != End::Converged {
            return end;
        }
        let wrong = wrong(turned, laws, at);
        if dbg { println!("-- outer {} wrong {wrong:e} acc {accuracy:e}", at.cycles); }
        if wrong <= tolerance {
            return End::Converged;
        }
        if wrong <= near {
            at.begin_anew();
            let before = at.clone();
            let manner = Manner { settle: None, resets: 0 };
            let end = run(turned, laws, multigrid, at, tolerance, max_cycles, manner, observe);
            if end != End::Failed {
                return end;
            }
            let cycles = at.cycles;
            *at = before;
            at.cycles = cycles;
            near = LESS * wrong;
            if dbg { println!("-- tried {cycles}"); }
        }
        let new = normal(at);
        normals.iter_mut().zip(new).for_each(|(old, new)| *old = 0.5 * (*old + new));
        accuracy = (INNER * wrong).clamp(0.3 * tolerance, ROUGH);
    }
}

/// Violation of the law itself.
fn wrong(turned: &Turned, laws: &[Law], at: &State) -> f64 {
    let lambda = |v: usize| std::array::from_fn(|c| turned.f[v][c] - at.ku[v][c]);
    let sets: Vec<_> =
        turned.points.iter().zip(laws).map(|(p, law)| set(law, p, lambda(p.node), at.u[p.node])).collect();
    violation(turned, laws, &sets, &at.u, &at.ku)
}
