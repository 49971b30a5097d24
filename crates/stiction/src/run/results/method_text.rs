//! Methods other than Newton's in words.

use crate::friction::{Given, MethodReport, MethodSettings, Status};
use crate::io::text::number;
use crate::run::solve::{MethodDetails, Outcome, word};

/// The method in a few words.
pub(crate) fn words(name: &str, settings: &MethodSettings, report: &MethodReport) -> String {
    let Some(details) = MethodDetails::of(settings, report) else { return name.into() };
    let inside = if name.starts_with("msa") { format!(" with {}", details.inner) } else { String::new() };
    let (Some(squares), Some(coupling)) = (details.squares, details.coupling) else { return format!("{name}{inside}") };
    let plural = if squares == 1 { "" } else { "s" };
    format!("{name}{inside}, {squares} square{plural} ({}), rho {}", word(coupling), number(report.penalty))
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
