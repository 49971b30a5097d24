use super::discs::discs;
use super::fixed_point::{SlipBounds, fixed_point, inexact_fixed_point, uzawa_on};
use super::given::Record;
use super::lagrangian::{Copies, Lagrangian};
use super::method::{
    CopiesAtOnce, Given, Method, MethodCounts, MethodReport, MethodSettings, MethodStep, Minimization, Penalty,
    Splitting, Sweeps,
};
use super::minimize::Minimizer;
use super::quadratic::Quadratic;
use super::squares::{Squares, boxes};
use crate::Error;
use crate::contact::Friction;
use crate::friction::End;
use crate::linalg::{Watch, norm};

/// Solves by one of the methods with squares, by the discs or by the fixed point, for laws `friction` of the points
/// of `q`. Methods for Coulomb friction take given friction as well, whose bounds they leave alone.
///
/// # Errors
/// If the settings make no sense, a method for given friction meets Coulomb friction, or the method is Newton's
/// ([`crate::friction::solve`]). Ending short of the tolerance is no error but reported by [`MethodReport::end`].
pub fn run_method(
    q: &Quadratic<'_>,
    friction: &[Friction],
    settings: &MethodSettings,
    observe: &mut Watch<MethodStep>,
) -> Result<MethodReport, Error> {
    validate(friction, settings)?;
    let mut record = Record { counts: MethodCounts::default(), history: Vec::new(), observe };
    let mut bounds = SlipBounds::new(friction, settings.start.slip_bound.as_deref());
    if friction.is_empty() {
        return Ok(report(End::Converged, Vec::new(), &bounds, &mut record));
    }
    let run = if settings.method.given() == Some(Given::Discs) { with_discs } else { with_squares };
    Ok(run(q, &mut bounds, settings, &mut record))
}

fn with_discs(
    q: &Quadratic<'_>,
    bounds: &mut SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> MethodReport {
    let mut lambda = start_lambda(q, settings);
    let end = if let Method::FixedPoint(_) = settings.method {
        fixed_point(bounds, settings, record, &mut |bounds, record| {
            discs(q, &mut lambda, bounds, settings, record).map(|()| lambda.clone())
        })
    } else {
        discs(q, &mut lambda, bounds, settings, record)
    };
    report(end.err().unwrap_or(End::Converged), lambda, bounds, record)
}

/// Of a method that has no copies.
fn report(end: End, lambda: Vec<f64>, bounds: &SlipBounds<'_>, record: &mut Record<'_, '_>) -> MethodReport {
    MethodReport {
        end,
        copies: lambda.clone(),
        lambda,
        slip_bound: bounds.value.clone(),
        w: Vec::new(),
        states: Vec::new(),
        penalty: 0.0,
        disagreement: 0.0,
        counts: record.counts,
        history: std::mem::take(&mut record.history),
    }
}

fn with_squares(
    q: &Quadratic<'_>,
    slip_bounds: &mut SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> MethodReport {
    let given = settings.method.given().unwrap_or(Given::AdaptiveUzawa);
    let how = match given {
        Given::Uzawa(how) => how,
        Given::AdaptiveUzawa | Given::Discs => {
            Minimization { copies: CopiesAtOnce::All, splitting: Splitting::No, sweeps: Sweeps::One }
        }
    };
    let squares = Squares::new(settings.squares, slip_bounds.friction, &q.has_row);
    let penalty = match settings.penalty {
        Penalty::Absolute(rho) => rho,
        Penalty::Scaled(factor) => factor * q.largest,
    };
    let lagrangian = Lagrangian::new(q, squares, settings.coupling, penalty, how.copies == CopiesAtOnce::One);
    let step1 = Minimizer::new(&lagrangian, how, settings);
    let mut copies = start_copies(&lagrangian, settings);
    let end = match settings.method {
        Method::InexactFixedPoint(_) => inexact_fixed_point(given, &step1, &mut copies, slip_bounds, settings, record),
        Method::FixedPoint(_) => fixed_point(slip_bounds, settings, record, &mut |bounds, record| {
            if let Given::Uzawa(_) = given {
                copies.w.fill(0.0); // as published; the adaptive method gains from what it knows
            }
            uzawa_on(given, &step1, &mut copies, bounds, settings, record)?;
            Ok(lagrangian.squares.mean(&copies.x))
        }),
        Method::Given(_) | Method::Newton => uzawa_on(given, &step1, &mut copies, slip_bounds, settings, record),
    };
    let boxes = boxes(slip_bounds.friction, &q.has_row, &slip_bounds.last);
    MethodReport {
        end: end.err().unwrap_or(End::Converged),
        lambda: lagrangian.squares.mean(&copies.x),
        slip_bound: slip_bounds.value.clone(),
        copies: lagrangian.squares.in_common_axes(&copies.x),
        states: lagrangian.state_of_points(&copies.x, &boxes),
        disagreement: lagrangian.disagreement(&copies.x),
        w: copies.w,
        penalty,
        counts: record.counts,
        history: std::mem::take(&mut record.history),
    }
}

fn start_lambda(q: &Quadratic<'_>, settings: &MethodSettings) -> Vec<f64> {
    let mut lambda = settings.start.lambda.clone().unwrap_or_else(|| vec![0.0; q.h.len()]);
    lambda.iter_mut().zip(&q.has_row).filter(|(_, has_row)| !**has_row).for_each(|(x, _)| *x = 0.0);
    lambda
}

fn start_copies(lagrangian: &Lagrangian<'_>, settings: &MethodSettings) -> Copies {
    let lambda = start_lambda(lagrangian.q, settings);
    let count = lagrangian.squares.count;
    let w = settings.start.w.clone().unwrap_or_else(|| vec![0.0; lambda.len() * (count - 1)]);
    Copies { x: lagrangian.squares.in_own_axes(&lambda.repeat(count)), w }
}

/// `|Psi(g) - g| / |g|` with `Psi(g) = F lambda_n(g)` by one problem with given friction, solved by the method of
/// `settings` ("Cont" of the source paper, eq. 6.4); `slip_bound` is `g`, newton, `m`. Zero if no friction is
/// Coulomb's.
///
/// # Errors
/// As [`run_method`].
#[doc(alias = "Cont")]
pub fn fixed_point_defect(
    q: &Quadratic<'_>,
    friction: &[Friction],
    slip_bound: &[f64],
    settings: &MethodSettings,
) -> Result<f64, Error> {
    if slip_bound.len() != friction.len() {
        let what = format!("{} slip bounds for {} points", slip_bound.len(), friction.len());
        return Err(Error::new("method", what, "give one a point"));
    }
    let mut bounds = SlipBounds::new(friction, Some(slip_bound));
    let freeze = |(law, &slip_bound): (&Friction, &f64)| match law {
        Friction::Coulomb { .. } | Friction::Limited { .. } | Friction::Cohesive { .. } => {
            Friction::Given { slip_bound }
        }
        other => *other,
    };
    let frozen: Vec<Friction> = friction.iter().zip(&bounds.value).map(freeze).collect();
    let report = run_method(q, &frozen, settings, &mut |_| std::ops::ControlFlow::Continue(()))?;
    let size = norm(
        &(0..friction.len()).map(|j| if frozen[j] == friction[j] { 0.0 } else { bounds.value[j] }).collect::<Vec<_>>(),
    );
    let (change, _) = bounds.follow(&report.lambda);
    Ok(if change == 0.0 { 0.0 } else { change / size })
}

/// Whether the squares stand in for no disc: the answer of a converged method is that of the problem itself.
pub(super) fn is_exact(friction: &[Friction], has_row: &[bool], settings: &MethodSettings) -> bool {
    settings.method.given().is_none_or(|given| given == Given::Discs)
        || Squares::new(settings.squares, friction, has_row).cuts_no_disc()
}

fn validate(friction: &[Friction], settings: &MethodSettings) -> Result<(), Error> {
    let fail = |what: String, remedy: &str| Err(Error::new("method", what, remedy));
    if let Some(j) = friction.iter().position(|law| matches!(law, Friction::Cohesive { .. })) {
        let what = format!("friction at point {j} has cohesion, which the methods of the paper do not know");
        return fail(what, "take Newton's method");
    }
    let coulomb = friction.iter().position(|law| law.coefficient().is_some());
    match (settings.method, coulomb) {
        (Method::Newton, _) => return fail("Newton's method is not among these".into(), "call `solve`"),
        (Method::Given(_), Some(j)) => {
            let what = format!("the method is for given friction, but friction at point {j} is Coulomb's");
            return fail(what, "take Newton's method or a fixed point (msa1, msa2, cfs1, cfs2)");
        }
        (Method::InexactFixedPoint(Given::Discs), _) => {
            return fail(
                "the inexact fixed point needs squares".into(),
                "take alg1, alg2 or smalbe inside it, or msa1",
            );
        }
        _ => {}
    }
    if settings.squares == 0 {
        return fail("no square bounds nothing".into(), "take at least one square");
    }
    let (Penalty::Absolute(rho) | Penalty::Scaled(rho)) = settings.penalty;
    let positive = [
        ("penalty", rho),
        ("tolerance", settings.tolerance),
        ("inner tolerance", settings.inner_tolerance),
        ("sweep tolerance", settings.sweep_tolerance),
    ];
    if let Some((name, value)) = positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        return fail(format!("the {name} is {value}"), "give a number greater than zero");
    }
    let (m, start) = (friction.len(), &settings.start);
    let copies = if settings.method.given() == Some(Given::Discs) { 0 } else { settings.squares - 1 };
    let starts =
        [("slip_bound", &start.slip_bound, m), ("w", &start.w, 3 * m * copies), ("lambda", &start.lambda, 3 * m)];
    for (name, list, length) in starts {
        if list.as_ref().is_some_and(|list| list.len() != length || list.iter().any(|x| !x.is_finite())) {
            return fail(format!("`start.{name}` is not {length} finite numbers"), "give as many, or None");
        }
    }
    if !(settings.agreement.is_finite() && settings.agreement >= 0.0) {
        return fail(format!("the agreement is {}", settings.agreement), "give a number of at least zero");
    }
    Ok(())
}
