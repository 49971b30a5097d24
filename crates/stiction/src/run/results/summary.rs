//! `summary.json`: what a script needs.

use serde_json::{Map, Value, json};

use super::report::{departure, report};
use super::write::Origin;
use super::{fields, method_text};
use crate::certificate::{BodyBalance, Certificate};
use crate::contact::equilibrium::in_words;
use crate::friction::Status;
use crate::mesh::v3::{add, scale};
use crate::run::pose::{Prepared, Span};
use crate::run::solve::{Balance, BoltState, Outcome, Path, Totals, bolt_states, pair_totals, totals};

/// The text of `summary.json` but for the names of the pictures, which are known once they are written; numbers are
/// written with all their digits, what is not finite as `null`.
pub fn summary(prepared: &Prepared, outcome: &Outcome, origin: &Origin) -> String {
    format!("{:#}\n", Value::Object(whole(prepared, outcome, origin)))
}

pub(crate) fn whole(prepared: &Prepared, outcome: &Outcome, origin: &Origin) -> Map<String, Value> {
    let overrides: Vec<String> = origin.overrides.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let mut map = Map::new();
    map.insert("title".into(), json!(prepared.facts.title));
    map.insert("units".into(), json!(prepared.facts.units));
    map.extend(answer(prepared, outcome));
    map.insert("overrides".into(), json!(overrides));
    map.insert("versions".into(), json!({ "stiction": env!("CARGO_PKG_VERSION"), "summary": 1 }));
    if let Some(last) = outcome.steps.last() {
        map.insert("load".into(), json!(load(prepared)));
        map.insert("balance".into(), last["balance"].clone());
        map.insert("steps".into(), json!(outcome.steps));
    }
    map.insert("command".into(), json!(origin.command));
    map.insert("posed".into(), labelled(&prepared.facts.to_string(), POSED_LABEL));
    map.insert("told".into(), labelled(&report(prepared, outcome), TOLD_LABEL));
    map
}

/// Width of the labels in the text of the facts and in that of the report.
const POSED_LABEL: usize = 10;
const TOLD_LABEL: usize = 12;

/// What differs from run to run and stands in the summary as a number anyway.
const NOT_TOLD: [&str; 2] = ["time", "memory"];

/// Lines such as `  label   text` as pairs; a line without a label of its own goes on with the last.
fn labelled(text: &str, width: usize) -> Value {
    let mut lines: Vec<[String; 2]> = Vec::new();
    for line in text.lines().filter_map(|line| line.strip_prefix("  ")) {
        let (label, words): (String, String) = (line.chars().take(width).collect(), line.chars().skip(width).collect());
        match (label.trim(), lines.last_mut()) {
            ("", Some([_, last])) => *last += &format!("; {}", words.trim()),
            (label, _) => lines.push([label.to_string(), words.trim().to_string()]),
        }
    }
    lines.retain(|[label, _]| !NOT_TOLD.contains(&label.as_str()));
    json!(lines)
}

/// What the summary says of one answer; of a stepped run it says the same of every step.
pub(crate) fn answer(prepared: &Prepared, outcome: &Outcome) -> Map<String, Value> {
    let solution = &outcome.solution;
    let with_names = |(name, totals): (String, Totals)| {
        let mut entry = Map::from_iter([("name".to_string(), json!(name))]);
        entry.extend(contact(&totals));
        Value::Object(entry)
    };
    let coulomb = outcome.coulomb.map(|facts| {
        json!({
            "contraction": facts.contraction,
            "uniqueness_bound": facts.uniqueness_bound,
            "largest_coefficient": facts.largest_coefficient,
            "unique": facts.proved_unique(),
        })
    });
    let seconds = |of: fn(&Span) -> f64| {
        let all = outcome.seconds.phases().into_iter().chain([("total", outcome.seconds.total())]);
        all.map(|(name, span)| (name.to_string(), json!(of(&span)))).collect::<Map<String, Value>>()
    };
    let value = json!({
        "status": status(solution.status),
        "departure": departure(&prepared.problem, solution.status),
        "sliding": sliding(prepared, outcome),
        "certificate": certificate(&solution.certificate),
        "contact": contact(&totals(prepared, outcome)),
        "pairs": pair_totals(prepared, outcome).into_iter().map(with_names).collect::<Vec<_>>(),
        "bodies": solution.certificate.bodies.iter().map(body).collect::<Vec<_>>(),
        "bolts": bolt_states(prepared, outcome).iter().map(bolt).collect::<Vec<_>>(),
        "displacement_max": largest_displacement(prepared, outcome).0,
        "energy": energy(prepared, outcome),
        "reaction": reaction(prepared, outcome),
        "load": prepared.facts.resultant(),
        "dofs": prepared.problem.unknowns(),
        "dual_dofs": 3 * prepared.problem.points(),
        "method": outcome.method_name,
        "method_details": method_text::details(&outcome.settings, outcome.method.as_ref()),
        "counts": all_counts(outcome),
        "path": path(outcome.path),
        "seconds": seconds(|span| span.wall),
        "cpu_seconds": seconds(|span| span.cpu),
        "peak_memory_bytes": outcome.peak_memory,
        "coulomb": coulomb,
    });
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// Where friction may be used up: the motion in words, the work of the loads on it, and the most friction takes up of it.
fn sliding(prepared: &Prepared, outcome: &Outcome) -> Option<Value> {
    let sliding = outcome.sliding.as_ref()?;
    let motion = in_words(&prepared.problem, &prepared.motions, &sliding.alpha);
    Some(json!({ "motion": motion, "load": sliding.load, "friction": sliding.friction }))
}

/// Work, elastic energy, dissipation and what their balance misses, since the start of the first step.
pub(crate) fn balance(balance: &Balance) -> Value {
    json!({
        "work": balance.work,
        "elastic": balance.elastic,
        "dissipation": balance.dissipation,
        "drift": balance.drift(),
    })
}

/// The force the loads add up to in the step that is solved.
pub(crate) fn load(prepared: &Prepared) -> [f64; 3] {
    let dofs = &prepared.model.dofs;
    let mut sum = [0.0; 3];
    if let Some(supports) = &prepared.problem.labels.supports {
        let free = dofs.free.iter().zip(&supports.free_load);
        let held = dofs.prescribed.iter().zip(&supports.load);
        free.chain(held).for_each(|(&dof, force)| sum = add(sum, scale(*force, dofs.direction(dof))));
    }
    sum
}

/// What the iteration cost by name, that of Newton's method or that of another.
fn all_counts(outcome: &Outcome) -> Value {
    let counts = outcome.solution.counts;
    let mut value = match &outcome.method {
        Some(report) => method_text::counts(report),
        None => json!({
            "iterations": counts.newton_steps,
            "restarts": counts.restarts,
            "fixed_point_steps": counts.fixed_point_steps,
            "products": counts.products,
        }),
    };
    value["solves"] = json!(counts.solves);
    value["cycles"] = json!(counts.cycles);
    value["coulomb_products"] = json!(outcome.coulomb.map_or(0, |facts| facts.products));
    value
}

/// How the iteration ended, as in the summary.
pub(crate) fn status(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::MaxIterations => "max_iterations",
        Status::Stalled => "stalled",
        Status::NoEquilibrium => "no_equilibrium",
        Status::Uncertified => "uncertified",
        Status::Interrupted => "interrupted",
    }
}

/// As a case names it.
pub(crate) fn path(path: Path) -> &'static str {
    match path {
        Path::Dense => "dense",
        Path::Solves => "solves",
        Path::Multigrid => "multigrid",
    }
}

pub(crate) fn certificate(certificate: &Certificate) -> Value {
    let measures = certificate.measures().into_iter().map(|(name, value)| (name.to_string(), json!(value)));
    let mut map: Map<String, Value> = measures.collect();
    map.insert("duality_gap".into(), json!(certificate.duality_gap));
    map.insert("worst".into(), json!(certificate.worst));
    map.insert("tolerance".into(), json!(certificate.tolerance));
    map.insert("passed".into(), json!(certificate.passed));
    Value::Object(map)
}

/// The forces on one body and their balance.
fn body(body: &BodyBalance) -> Value {
    json!({
        "name": body.name,
        "load": body.load,
        "support": body.support,
        "contact": body.contact,
        "force_balance": body.balance.force,
        "moment_balance": body.balance.moment,
    })
}

fn bolt(bolt: &BoltState) -> Value {
    json!({ "name": bolt.name, "force": bolt.force, "shortening": bolt.shortening })
}

fn contact(t: &Totals) -> Map<String, Value> {
    let entries = [
        ("points", json!(t.points)),
        ("open", json!(t.open)),
        ("stick", json!(t.stick)),
        ("slip", json!(t.slip)),
        ("open_area", json!(t.open_area)),
        ("stick_area", json!(t.stick_area)),
        ("slip_area", json!(t.slip_area)),
        ("normal_force", json!(t.normal_force)),
        ("tangential_force", json!(t.tangential_force)),
        ("max_lambda_n", json!(t.max_lambda_n)),
        ("max_lambda_t", json!(t.max_lambda_t)),
        ("max_pressure", json!(t.max_pressure)),
        ("max_pressure_at", json!(t.max_pressure_at)),
        ("max_shear", json!(t.max_shear)),
    ];
    entries.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// The largest displacement of a node, and where the node is.
pub(crate) fn largest_displacement(prepared: &Prepared, outcome: &Outcome) -> (f64, [f64; 3]) {
    let u = crate::fem::full_displacement(&prepared.model, &outcome.solution.u);
    let size = |u: &[f64; 3]| (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).sqrt();
    let sizes = u.as_chunks().0.iter().map(size).zip(&prepared.mesh.nodes);
    sizes.fold((0.0, [0.0; 3]), |best, (size, x)| if size > best.0 { (size, *x) } else { best })
}

/// `1/2 u'Ku - f'u` over all degrees of freedom, the prescribed ones included: what the body stores less the work of
/// the loads. `problem.f` holds what the prescribed displacements demand of the unknowns, their mixed term.
fn energy(prepared: &Prepared, outcome: &Outcome) -> f64 {
    let (problem, u) = (&prepared.problem, &outcome.solution.u);
    let unknowns = potential(&problem.elastic.K.times(u), &problem.elastic.f, u);
    let supports = problem
        .labels
        .supports
        .as_ref()
        .map_or(0.0, |s| potential(&s.K_own.times(&s.displacement), &s.load, &s.displacement));
    unknowns + supports + prepared.acting.initial.energy
}

/// `1/2 u'Ku - f'u` for `elastic` `= K u`.
fn potential(elastic: &[f64], load: &[f64], u: &[f64]) -> f64 {
    elastic.iter().zip(load).zip(u).map(|((k, f), u)| (0.5 * k - f) * u).sum()
}

/// The force of all supports on the body.
fn reaction(prepared: &Prepared, outcome: &Outcome) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for force in fields::reaction(prepared, outcome) {
        (0..3).for_each(|c| sum[c] += force[c]);
    }
    sum
}
