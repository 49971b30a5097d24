//! Methods by name, for the summary and the report.

use serde_json::{Value, json};

use crate::friction::{
    CopiesAtOnce, Coupling, Given, MethodEnd, MethodReport, MethodSettings, Minimization, Splitting, Status, Sweeps,
};
use crate::io::report::number;
use crate::run::solve::Outcome;

fn given_name(given: Given) -> &'static str {
    match given {
        Given::Uzawa(Minimization { copies: CopiesAtOnce::One, .. }) => "alg1",
        Given::Uzawa(Minimization { copies: CopiesAtOnce::All, .. }) => "alg2",
        Given::AdaptiveUzawa => "smalbe",
        Given::Discs => "discs",
    }
}

fn coupling(coupling: Coupling) -> &'static str {
    match coupling {
        Coupling::Chain => "chain",
        Coupling::Star => "star",
    }
}

fn end(end: MethodEnd) -> &'static str {
    match end {
        MethodEnd::Converged => "converged",
        MethodEnd::Limit => "limit",
        MethodEnd::Stalled => "stalled",
        MethodEnd::Interrupted => "interrupted",
    }
}

/// Settings and end of a method for the summary; `null` for Newton's.
pub(crate) fn details(settings: &MethodSettings, report: Option<&MethodReport>) -> Value {
    let (Some(report), Some(given)) = (report, settings.method.given()) else { return Value::Null };
    let (splitting, variant) = match given {
        Given::Uzawa(how) => {
            let splitting = match how.splitting {
                Splitting::No => "no",
                Splitting::Partial => "partial",
                Splitting::Complete => "complete",
            };
            let variant = if how.sweeps == Sweeps::One { 2 } else { 1 };
            (Some(splitting), (how.copies == CopiesAtOnce::One).then_some(variant))
        }
        Given::AdaptiveUzawa | Given::Discs => (None, None),
    };
    let squares = given != Given::Discs;
    json!({
        "end": end(report.end),
        "inner": given_name(given),
        "variant": variant,
        "splitting": splitting,
        "squares": squares.then_some(settings.squares),
        "coupling": squares.then(|| coupling(settings.coupling)),
        "rho": squares.then_some(report.penalty),
        "disagreement": squares.then_some(report.disagreement),
        "tolerance": settings.tolerance,
    })
}

/// What a method cost, by name.
pub(crate) fn counts(report: &MethodReport) -> Value {
    let c = report.counts;
    json!({
        "iterations": c.iterations,
        "fixed_point_steps": c.fixed_point_steps,
        "qp_problems": c.qp_problems,
        "short_problems": c.short_problems,
        "cg_steps": c.cg_steps,
        "expansions": c.expansions,
        "proportionings": c.proportionings,
        "products": c.products,
        "flops": c.flops,
    })
}

/// The method in a few words.
pub(crate) fn words(name: &str, settings: &MethodSettings, report: &MethodReport) -> String {
    let Some(given) = settings.method.given() else { return name.into() };
    let inner = given_name(given);
    let inside = if name.starts_with("msa") { format!(" with {inner}") } else { String::new() };
    if given == Given::Discs {
        return format!("{name}{inside}");
    }
    let (squares, coupling) = (settings.squares, coupling(settings.coupling));
    let plural = if squares == 1 { "" } else { "s" };
    format!("{name}{inside}, {squares} square{plural} ({coupling}), rho {}", number(report.penalty))
}

/// Why a method that converged by its own rule has not solved the problem, and the remedy.
pub(crate) fn shortfall(outcome: &Outcome) -> Option<String> {
    let settings = &outcome.settings;
    if outcome.solution.status != Status::Uncertified {
        return None;
    }
    if settings.method.given() == Some(Given::Discs) {
        return Some(
            "rounding, or a rule that ends too early: ask for less accuracy or take method = \"newton\"".into(),
        );
    }
    let squares = settings.squares;
    let excess = 100.0 / (std::f64::consts::FRAC_PI_4 / squares as f64).cos() - 100.0;
    let sides = 4 * squares;
    Some(format!(
        "a polygon of {sides} sides stands for the disc of friction and reaches {} % beyond it; the certificate asks \
         for the disc: take more squares to come nearer, method = \"newton\" to get there",
        number(excess)
    ))
}
