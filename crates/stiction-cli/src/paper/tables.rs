//! One table: its runs in all settings, beside the published numbers.

use std::time::Instant;

use super::choices::{FIT, FIT_CHAIN, FIT_LOAD, FIT_PARITY, PRECONDITIONED, PRINTED, STEP_LIMIT, Setting};
use super::compare::{Band, Comparison, Quantity, Verdict};
use super::experiment::{Experiment, Line, Plan, band, plan};
use super::known::known;
use super::laboratory::{Laboratory, Measured, relative_change};
use super::published::Published;
use super::study::TableReport;
use stiction::Error;
use stiction::friction::End;

/// Settings in which a table is run; the first is judged.
pub fn settings(table: usize, quick: bool) -> Vec<Setting> {
    match table {
        _ if quick => vec![FIT],
        1 | 9 => vec![FIT, FIT_PARITY, PRINTED],
        3 => vec![FIT, FIT_PARITY, FIT_LOAD, PRINTED],
        2 | 4 => vec![FIT, FIT_LOAD, PRINTED],
        5 => vec![FIT, FIT_LOAD, PRECONDITIONED, PRINTED],
        6 | 7 | 12 => vec![FIT, FIT_CHAIN, PRECONDITIONED, PRINTED],
        11 => vec![FIT, PRECONDITIONED, PRINTED],
        _ => vec![FIT, PRINTED],
    }
}

/// Whether some number of the line is judged: the quick subset.
fn is_judged(table: usize, line: &Line) -> bool {
    line.published.iter().any(|&(quantity, _)| band(table, line, quantity) != Band::None)
}

/// Runs a table.
///
/// # Errors
/// If the observer of the laboratory asked to stop.
pub fn table(published: &Published, quick: bool, laboratory: &mut Laboratory) -> Result<TableReport, Error> {
    let start = Instant::now();
    let Plan { lines, reference } = plan(published);
    let settings = settings(published.number, quick);
    let mut comparisons = Vec::new();
    for (line, reference) in lines.iter().zip(&reference) {
        if quick && !is_judged(published.number, line) {
            continue;
        }
        for &setting in &settings {
            compare(published.number, line, *reference, setting, laboratory, &mut comparisons)?;
        }
    }
    Ok(TableReport {
        number: published.number,
        caption: published
            .caption
            .replace("eff_percent", "Eff (%)")
            .replace("rel_error", "Rel error")
            .replace("; iter is", "; Iter is"),
        settings: settings.iter().map(|s| (s.name, words(*s, &lines))).collect(),
        comparisons,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// What a setting means for these runs.
fn words(setting: Setting, lines: &[Line]) -> String {
    let mut parts = vec![format!("loads times {}", setting.load), format!("parity {}", setting.parity)];
    let mut factors: Vec<String> = Vec::new();
    for Experiment { partition, method, .. } in lines.iter().map(|l| l.experiment) {
        let factor = format!("{} on partition {partition}", setting.rho_factor(method.family(), partition));
        if !factors.contains(&factor) {
            factors.push(factor);
        }
    }
    parts.push(format!("rho times {}", factors.join(", ")));
    if lines.iter().any(|l| l.experiment.squares > 2 && l.experiment.method.is_one_program()) {
        parts.push(format!("{:?} coupling", setting.coupling).to_lowercase());
    }
    if lines.iter().any(|l| l.experiment.method.is_coulomb()) {
        parts.push(if setting.start == 0.0 { "g(0) = 0".into() } else { format!("g(0) = {:e}", setting.start) });
    }
    parts.join("; ")
}

fn compare(
    table: usize,
    line: &Line,
    reference: Option<Experiment>,
    setting: Setting,
    laboratory: &mut Laboratory,
    comparisons: &mut Vec<Comparison>,
) -> Result<(), Error> {
    let measured = laboratory.run(line.experiment, setting)?;
    let note = note(&measured);
    for &(quantity, published) in &line.published {
        let ours = match measured.given_up {
            true => None,
            false => value(quantity, line.experiment, &measured, reference, setting, laboratory)?,
        };
        let judged = setting.judged && published.is_some();
        let band = if judged { band(table, line, quantity) } else { Band::None };
        let verdict = Verdict::of(band, published, ours, known(table, line, quantity));
        let (run, setting, note) = (line.label.clone(), setting.name, note.clone());
        comparisons.push(Comparison { run, quantity, setting, published, ours, band, verdict, note });
    }
    Ok(())
}

fn note(measured: &Measured) -> String {
    let Measured { cg_steps, expansions, proportionings, end, stuck, given_up, short_problems, .. } = measured;
    let mut parts = vec![match end {
        End::Limit if *given_up => format!("given up at {STEP_LIMIT} products"),
        End::Limit if *stuck => "no point slips: w tends to zero and rule (6.1) never holds".into(),
        End::Limit => "stopped at its limit".into(),
        End::Stalled => "stalled".into(),
        End::Converged | End::Interrupted => String::new(),
    }];
    if *short_problems > 0 {
        parts.push(format!("{short_problems} programs ended at the level of rounding"));
    }
    parts.push(format!("{cg_steps} cg, {expansions} expansions, {proportionings} proportionings"));
    parts.retain(|part| !part.is_empty());
    parts.join("; ")
}

fn value(
    quantity: Quantity,
    experiment: Experiment,
    measured: &Measured,
    reference: Option<Experiment>,
    setting: Setting,
    laboratory: &mut Laboratory,
) -> Result<Option<f64>, Error> {
    Ok(match quantity {
        Quantity::Iterations => Some(measured.iterations as f64),
        Quantity::QpProblems => Some(measured.qp_problems as f64),
        Quantity::CgSteps => Some(measured.cg_steps as f64),
        Quantity::Efficiency => match reference {
            Some(reference) => Some(100.0 * measured.flops / laboratory.run(reference, setting)?.flops),
            None => None,
        },
        Quantity::Precision => Some(laboratory.precision(measured, experiment, setting)?),
        Quantity::FixedPoint => Some(laboratory.fixed_point(measured, experiment, setting)?),
        Quantity::Change if experiment.squares > 2 => {
            let squares = experiment.squares - 2;
            let before = laboratory.run(Experiment { squares, ..experiment }, setting)?;
            Some(if experiment.method.is_coulomb() {
                relative_change(&measured.slip_bound, &before.slip_bound)
            } else {
                relative_change(&measured.lambda, &before.lambda)
            })
        }
        Quantity::Change => None,
    })
}
