//! What is printed and written of discrete problems given as matrices.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use crate::discrete::{DiscreteProblem, Measures, Method, Status};
use crate::io::Contents;
use crate::run::solve::algebraic::Answer;

/// The problem, how the iteration went and how the answer is judged.
pub fn report(name: &str, contents: &Contents, answer: &Answer) -> String {
    let (problem, solution) = (&contents.problem, &answer.solution);
    let kind = match problem {
        DiscreteProblem::Local(_) => "local",
        DiscreteProblem::Global(_) => "global",
    };
    let mut text = format!("{name}\n  problem      {kind}, {} contacts", problem.points());
    let _ = write!(text, " in {} dimensions, W of order {}", problem.dimension(), answer.order);
    let rank = answer.rank.map_or("not computed".to_string(), |r| r.to_string());
    let _ = match answer.entries {
        Some(entries) => writeln!(text, " with {entries} entries, rank {rank}"),
        None => writeln!(text, ", not formed"),
    };
    let counts = solution.counts;
    let _ = write!(text, "  method       {}:", method(answer));
    for (count, name) in [
        (counts.iterations, if counts.newton_steps > 0 { "proximal steps" } else { "rounds" }),
        (counts.newton_steps, "Newton steps"),
        (counts.sweeps, "sweeps"),
        (counts.gradients, "gradient steps"),
        (counts.alternations, "alternations"),
    ] {
        if count > 0 {
            let _ = write!(text, " {count} {name},");
        }
    }
    let _ = writeln!(text, " {:.4} s", answer.seconds.total());
    if let Some(guess) = &answer.guess {
        let _ = write!(text, "  guesses      {}: ", guess.guesses);
        let _ = match guess.chosen {
            Some((number, residual)) => write!(text, "started from number {number}, worst residual {residual:.1e}"),
            None => write!(text, "none is nearer than no impulse at all"),
        };
        text += if guess.abandoned { "; it led nowhere, begun again from rest\n" } else { "\n" };
    }
    if answer.dropped > 0 {
        let _ = writeln!(text, "  bilateral    {} constraints follow from others and were left out", answer.dropped);
    }
    let _ = writeln!(text, "  status       {}", answer.status().replace('_', " "));
    let balance = [("equilibrium", answer.recovered.equilibrium)];
    for (name, value) in answer.measures.all().into_iter().chain(balance) {
        let verdict = if value > answer.tolerance { "  exceeds the tolerance" } else { "" };
        let _ = writeln!(text, "  {:<17} {value:.1e}{verdict}", name.replace('_', " "));
    }
    if solution.status == Status::Rounding {
        text += "  note         the residual by velocity is the rounding of impulses that are much larger than velocities: ";
        text += "choose a larger unit of impulse or a smaller one of velocity\n";
    }
    if let Some(claimed) = &answer.claimed {
        let verdict = if claimed.passed(answer.tolerance) { "is one" } else { "is none" };
        let _ = writeln!(
            text,
            "  note         what the file calls a solution {verdict} (worst residual {:.1e}); it was not used",
            claimed.worst()
        );
    }
    text
}

/// The method that gave the answer.
fn method(answer: &Answer) -> &'static str {
    let counts = answer.solution.counts;
    match answer.method {
        Method::Auto if counts.sweeps + counts.alternations > 0 => "ladder+newton",
        Method::Auto | Method::Newton => "proximal newton",
        other => other.name(),
    }
}

/// The head of the table of many problems.
pub fn table_head() -> String {
    format!(
        "{:<44} {:>8} {:>6} {:<15} {:>10} {:>9} {:>11} {:>10} {:>9}  {}\n",
        "problem",
        "contacts",
        "rank",
        "method",
        "iterations",
        "seconds",
        "by velocity",
        "by largest",
        "invariant",
        "verdict"
    )
}

/// A line of the table of many problems.
pub fn table_row(name: &str, contents: &Contents, answer: &Answer) -> String {
    let m = &answer.measures;
    format!(
        "{name:<44} {:>8} {:>6} {:<15} {:>10} {:>9.4} {:>11.1e} {:>10.1e} {:>9.1e}  {}\n",
        contents.problem.points(),
        answer.rank.map_or("-".to_string(), |r| r.to_string()),
        method(answer),
        if answer.solution.counts.newton_steps > 0 {
            answer.solution.counts.newton_steps
        } else {
            answer.solution.counts.iterations
        },
        answer.seconds.total(),
        m.by_velocity,
        m.by_largest,
        m.invariant,
        answer.status().replace('_', " "),
    )
}

/// The answer as JSON, for scripts.
pub fn summary(name: &str, contents: &Contents, answer: &Answer) -> Value {
    let measures = |m: &Measures| -> Map<String, Value> {
        m.all().into_iter().map(|(name, value)| (name.to_string(), json!(value))).collect()
    };
    let mut judged = measures(&answer.measures);
    judged.insert("equilibrium".into(), json!(answer.recovered.equilibrium));
    judged.insert("worst".into(), json!(answer.measures.worst()));
    judged.insert("tolerance".into(), json!(answer.tolerance));
    judged.insert("passed".into(), json!(answer.passed()));
    let counts = answer.solution.counts;
    json!({
        "problem": name,
        "status": answer.status(),
        "certificate": judged,
        "contacts": contents.problem.points(),
        "dimension": contents.problem.dimension(),
        "order": answer.order,
        "entries": answer.entries,
        "rank": answer.rank,
        "method": method(answer),
        "form": if answer.entries.is_some() { "condensed" } else { "sparse" },
        "dropped_constraints": answer.dropped,
        "guess": answer.guess.map(|g| json!({
            "guesses": g.guesses,
            "chosen": g.chosen.map(|c| c.0),
            "residual": g.chosen.map(|c| c.1),
            "abandoned": g.abandoned,
        })),
        "counts": {
            "iterations": counts.newton_steps,
            "proximal_steps": counts.iterations,
            "sweeps": counts.sweeps,
            "gradients": counts.gradients,
            "alternations": counts.alternations,
        },
        "seconds": {
            "condensation": answer.seconds.condensation,
            "iteration": answer.seconds.iteration,
            "total": answer.seconds.total(),
        },
        "claimed_solution": answer.claimed.as_ref().map(measures),
        "versions": { "stiction": env!("CARGO_PKG_VERSION"), "summary": 1 },
    })
}

/// Writes the problem with the answer as its solution, and the summary, into `directory`; the names of the files.
///
/// # Errors
/// If a file cannot be written.
#[cfg(feature = "fclib")]
pub fn write(
    name: &str,
    contents: &Contents,
    answer: &Answer,
    directory: &std::path::Path,
) -> Result<Vec<String>, crate::Error> {
    use crate::discrete::Recovered;
    use crate::io::fclib_write::{self, State};
    use crate::io::folder;
    use crate::run::results::json;

    folder::create(directory)?;
    let files = vec![format!("{name}.solution.hdf5"), format!("{name}.summary.json")];
    folder::remove(&directory.join(&files[1]))?;
    let Recovered { u, v, l, .. } = answer.recovered.clone();
    let state = State { r: answer.solution.r.clone(), u, v, l };
    fclib_write::write(&directory.join(&files[0]), &contents.problem, Some(&state), &[])?;
    folder::write_text(&directory.join(&files[1]), &json::text(&summary(name, contents, answer)))?;
    Ok(files)
}
