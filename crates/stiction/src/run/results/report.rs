//! The answer in plain words.

use std::fmt::Write as _;

use serde_json::Value;

use super::fields::surfaces;
use super::method_text;
use super::summary::{largest_displacement, path};
use crate::certificate::Certificate;
use crate::contact::ContactProblem;
use crate::contact::equilibrium::{in_words, no_equilibrium};
use crate::contact::rigid::rigid_motions;
use crate::contact::sliding::Sliding;
use crate::friction::{CoulombFacts, Status};
use crate::io::report::{number, triple};
use crate::run::pose::Prepared;
use crate::run::pose::bolts::Target;
use crate::run::solve::{BoltState, Outcome, Path, Totals, bolt_states, pair_totals, totals};

/// The result of a run, a few lines for a person.
pub fn report(prepared: &Prepared, outcome: &Outcome) -> String {
    let mut text = String::new();
    let solution = &outcome.solution;
    let counts = solution.counts;
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {name:<12} {value}");
    };
    let iterations = match &outcome.method {
        Some(report) => report.counts.iterations,
        None => counts.newton_steps.max(counts.cycles),
    };
    let count = |entry: &Value, key: &str| entry["counts"][key].as_u64().unwrap_or(0) as usize;
    let of_step = |entry: &Value| count(entry, "iterations").max(count(entry, "cycles"));
    let in_all = if outcome.steps.is_empty() { iterations } else { outcome.steps.iter().map(of_step).sum() };
    if let Some(report) = &outcome.method {
        line("method", method_text::words(&outcome.method_name, &outcome.settings, report));
    }
    line("status", status(solution.status, in_all));
    if let Some(last) = outcome.steps.last() {
        steps(&mut line, &outcome.steps, last);
    }
    if let Some(why) = method_text::shortfall(outcome) {
        line("", why);
    }
    if let Some(motion) = departure(&prepared.problem, solution.status) {
        line("", format!("the loads carry away {motion}"));
        line("", "what follows, and the files, show a body that the solver holds by force: they are no result".into());
    }
    if let Some(used_up) = used_up(prepared, outcome) {
        line("", used_up);
    }
    shortfalls(prepared, outcome).into_iter().for_each(|what| line("", what));
    line("certificate", certificate(&solution.certificate));
    if prepared.problem.points() > 0 {
        let pairs = pair_totals(prepared, outcome);
        let several = pairs.len() > 1;
        for (name, t) in &pairs {
            let head = if several { format!("\"{name}\": ") } else { String::new() };
            contact(&mut line, &head, t);
        }
        if several {
            contact(&mut line, "all pairs: ", &totals(prepared, outcome));
        }
    }
    for bolt in bolt_states(prepared, outcome) {
        line(
            "bolt",
            format!("\"{}\": force {}, shortening {}", bolt.name, number(bolt.force), number(bolt.shortening)),
        );
    }
    for warning in far_slides(prepared, outcome) {
        line("note", warning);
    }
    let (size, place) = largest_displacement(prepared, outcome);
    line("displacement", format!("at most {} at {}", number(size), triple(place)));
    if let Some(facts) = &outcome.coulomb {
        line("uniqueness", uniqueness(facts));
    } else if outcome.path == Path::Multigrid && has_coulomb(prepared) {
        let why = "what can be said about others is estimated on the direct path only (path = \"solves\")";
        line("uniqueness", format!("a solution; {why}"));
    }
    if outcome.path == Path::Multigrid {
        let restarts = counted(counts.restarts, "restart");
        line("work", format!("{} of multigrid, {restarts}", counted(counts.cycles, "cycle")));
    } else {
        line(
            "work",
            format!(
                "{}, {} with B K^-1 B' ({}), {}",
                counted(iterations, "iteration"),
                counted(counts.products, "product"),
                path(outcome.path),
                match &outcome.method {
                    Some(report) => {
                        let (steps, problems) = (report.counts.steps(), report.counts.qp_problems);
                        format!("{} in {}", counted(steps, "step"), counted(problems, "quadratic program"))
                    }
                    None => counted(counts.restarts, "restart"),
                }
            ),
        );
    }
    let phases = outcome.seconds.phases().into_iter().filter(|(_, span)| span.wall >= 0.005);
    let phases: Vec<String> = phases.map(|(name, span)| format!("{name} {:.2}", span.wall)).collect();
    let phases = if phases.is_empty() { String::new() } else { format!(" ({})", phases.join(", ")) };
    line("time", format!("{:.2} s{phases}", outcome.seconds.total().wall));
    if let Some(bytes) = outcome.peak_memory {
        line("memory", format!("{:.2} GB at most", bytes as f64 / 1e9));
    }
    text
}

/// How the loads carry a body away, if the status says that nothing balances them.
pub fn departure(problem: &ContactProblem, status: Status) -> Option<String> {
    if status != Status::NoEquilibrium {
        return None;
    }
    let motions = rigid_motions(problem);
    no_equilibrium(problem, &motions).map(|slide| in_words(problem, &motions, &slide.alpha))
}

/// Where friction may be used up and nothing was found: along which motion, and by how much. Forces are per unit of the
/// displacement of what moves farthest.
pub fn used_up(prepared: &Prepared, outcome: &Outcome) -> Option<String> {
    let Sliding { alpha, load, friction } = outcome.sliding.as_ref()?;
    let motion = in_words(&prepared.problem, &prepared.motions, alpha);
    let [load, friction] = [load, friction].map(|force| number(*force));
    let of = if outcome.steps.len() > 1 { "of the last step that was solved" } else { "reached" };
    Some(format!(
        "at the normal forces {of} friction resists at most {friction}, and the loads push with {load}: {motion}"
    ))
}

/// How far the load steps came, and what became of the work; the lines below are of the last step.
fn steps(line: &mut impl FnMut(&str, String), all: &[Value], last: &Value) {
    let value = |entry: &Value| entry.as_f64().unwrap_or(f64::NAN);
    let (t, begin) = (value(&last["t"]), value(&last["t"]) - value(&last["dt"]));
    let again = all.iter().filter(|entry| entry["attempts"].as_u64() > Some(1)).count();
    let again = if again == 0 { String::new() } else { format!(", {again} of them not at the first attempt") };
    line("steps", format!("{} to t = {}{again}; below is the last", counted(all.len(), "step"), number(t)));
    if matches!(last["status"].as_str(), Some("max_iterations" | "stalled")) {
        let (name, attempts) = (last["name"].as_str().unwrap_or(""), &last["attempts"]);
        let span = format!("from t = {} to {}", number(begin), number(t));
        line(
            "",
            format!("the last one (\"{name}\", {span}) was not solved in {attempts} attempts with ever shorter steps"),
        );
    }
    let energy = |name: &str| number(value(&last["balance"][name]));
    let (work, elastic, dissipated, drift) =
        (energy("work"), energy("elastic"), energy("dissipation"), energy("drift"));
    line("energy", format!("work {work} = elastic {elastic} + dissipated {dissipated} + drift {drift}"));
}

/// Sliding beyond this part of a face is not small: two surfaces are coupled as they lie before the load.
const SMALL_SLIDING: f64 = 0.2;

/// Pairs that slide farther than the frozen coupling allows for.
fn far_slides(prepared: &Prepared, outcome: &Outcome) -> Vec<String> {
    let mut warnings = Vec::new();
    for (contact, fields) in prepared.facts.contacts.iter().zip(surfaces(prepared, outcome)) {
        let Some(pair) = &contact.surface.pair else { continue };
        let size = pair.face_size[0].min(pair.face_size[1]);
        let touching = fields.slip.iter().zip(&fields.status).filter(|(_, status)| **status > 0);
        let slide = touching.map(|(s, _)| (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt()).fold(0.0, f64::max);
        if slide > SMALL_SLIDING * size {
            let what = format!("the surfaces slide by up to {}, a face is {} wide", number(slide), number(size));
            warnings.push(format!("contact \"{}\": {what}; contact is that of the unmoved bodies", fields.name));
        }
    }
    warnings
}

fn has_coulomb(prepared: &Prepared) -> bool {
    prepared.problem.contact.friction.iter().any(|law| law.coefficient().is_some())
}

fn contact(line: &mut impl FnMut(&str, String), head: &str, t: &Totals) {
    line(
        "contact",
        format!("{head}normal force {}, friction on the body {}", number(t.normal_force), triple(t.tangential_force)),
    );
    line(
        "",
        format!(
            "open {} points (area {}), stick {} ({}), slip {} ({})",
            t.open,
            number(t.open_area),
            t.stick,
            number(t.stick_area),
            t.slip,
            number(t.slip_area)
        ),
    );
    if t.open == t.points {
        line("", "no point is in contact".into());
    }
    if let Some(place) = t.max_pressure_at {
        line(
            "",
            format!(
                "pressure at most {} at {}, shear at most {}",
                number(t.max_pressure),
                triple(place),
                number(t.max_shear)
            ),
        );
    }
}

/// `1 iteration`, `7 iterations`.
fn counted(n: usize, thing: &str) -> String {
    format!("{n} {thing}{}", if n == 1 { "" } else { "s" })
}

/// How the iteration ended.
fn status(status: Status, iterations: usize) -> String {
    let count = counted(iterations, "iteration");
    match status {
        Status::Solved => format!("solved after {count}"),
        Status::MaxIterations => format!("NOT SOLVED: stopped at the limit of {count}"),
        Status::Stalled => format!("NOT SOLVED: nothing more was gained after {count}"),
        Status::NoEquilibrium => "NOT SOLVED: there is no equilibrium".into(),
        Status::Uncertified => format!("NOT SOLVED: converged by its own rule after {count}, not by the certificate"),
        Status::Interrupted => format!("NOT SOLVED: interrupted after {count}"),
    }
}

/// The worst measure by name against the tolerance.
fn certificate(c: &Certificate) -> String {
    let worst = c.measures().into_iter().find(|(_, value)| *value == c.worst || value.is_nan());
    let name = worst.map_or(String::new(), |(name, _)| format!(" ({})", words(name)));
    let (verdict, sign) = if c.passed { ("passed", "<=") } else { ("NOT PASSED", ">") };
    format!("{verdict}: the worst measure is {:.1e}{name} {sign} {:e}", c.worst, c.tolerance)
}

/// What is known of other solutions.
pub fn uniqueness(facts: &CoulombFacts) -> String {
    let coefficient = facts.largest_coefficient;
    let contraction = format!("contraction of the fixed point about {:.2}", facts.contraction);
    if facts.proved_unique() {
        let bound = facts.uniqueness_bound.unwrap_or(f64::INFINITY);
        return format!(
            "the solution is unique: F = {coefficient} is below the proven bound {bound:.2e}; {contraction}"
        );
    }
    let why = match facts.uniqueness_bound {
        Some(bound) => format!("F = {coefficient} is above the proven bound {bound:.2e}"),
        None => "no bound is known for this case".to_string(),
    };
    format!("a solution; uniqueness is not proved: {why}; {contraction}")
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}

/// What to say of bolts that a run which ended short could not tighten.
pub(crate) fn shortfalls(prepared: &Prepared, outcome: &Outcome) -> Vec<String> {
    let (Some(last), Status::Stalled | Status::MaxIterations) = (outcome.steps.last(), outcome.solution.status) else {
        return Vec::new();
    };
    let step = prepared.acting.steps.iter().position(|step| last["name"] == step.name.as_str());
    let (step, t) = (step.unwrap_or(0), last["t"].as_f64().unwrap_or(f64::NAN));
    let targets = prepared.acting.targets(step, t).unwrap_or_default();
    let short = |(bolt, target): (BoltState, Target)| match target {
        Target::Force(force) if (bolt.force - force).abs() > MISSED * force.abs() => Some(format!(
            "bolt \"{}\" has the force {:.4e} where {force:.4e} is asked for: if nothing that is held lies between its parts, \
             see to the contacts under its head and its nut; otherwise tighten it by `shortening` first",
            bolt.name, bolt.force
        )),
        _ => None,
    };
    bolt_states(prepared, outcome).into_iter().zip(targets).filter_map(short).collect()
}

/// Part of a force whose lack is worth a word: that of a search which was about to end is smaller.
const MISSED: f64 = 1e-3;
