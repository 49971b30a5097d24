//! `[solver]`: the method and its settings.

use super::data::{ContactSpec, SolverSpec};
use super::view::View;
use crate::Error;
use crate::friction::{Coupling, Given, Method, MethodSettings, Penalty, SolverPath, Splitting, Sweeps};

/// Programs within a method are solved this much more accurately than the method itself.
const INNER: f64 = 1e-2;
/// Most iterations where the case does not say: Newton steps, and changes of the multipliers of the other methods.
const NEWTON_ITERATIONS: usize = 200;
const METHOD_ITERATIONS: usize = 10_000;
/// Keys that only some methods use.
const METHOD_KEYS: [&str; 8] =
    ["inner", "variant", "splitting", "squares", "coupling", "rho", "rho_factor", "inner_tolerance"];

/// The settings of the solver, those of a method that fits the friction of all contacts.
pub(super) fn solver(case: &View, contacts: &[ContactSpec]) -> Result<SolverSpec, Error> {
    let Some(table) = case.table("solver") else {
        return Ok(SolverSpec::default());
    };
    let method = method(&table)?;
    let coulomb = contacts.iter().find(|c| c.friction.is_coulomb());
    if let (Method::Given(_), Some(contact)) = (method.method, coulomb) {
        let name = table.text("method");
        let what = format!("{name:?} is for given friction, but the friction of contact {:?} is coulomb", contact.name);
        let remedy = "take \"newton\", \"msa1\", \"msa2\", \"cfs1\" or \"cfs2\", or friction = { tresca = ... }";
        return Err(table.error("method", what, remedy));
    }
    if table.given("starts").is_some() && method.method != Method::Newton {
        let what = format!("`starts` is not used by the method {:?}", table.text("method"));
        return Err(table.error("starts", what, "take it out, or method = \"newton\""));
    }
    Ok(SolverSpec {
        tolerance: table.number("tolerance"),
        max_iterations: most_iterations(&table, method.method),
        memory: table.given("memory").map(|_| table.number("memory")),
        path: match table.text("path").as_str() {
            "dense" => SolverPath::Dense,
            "solves" => SolverPath::Solves,
            "multigrid" => SolverPath::Multigrid,
            _ => SolverPath::Auto,
        },
        starts: table.given("starts").map(|_| table.count("starts")),
        method_name: table.text("method"),
        method,
        spot: table.spot(),
    })
}

fn most_iterations(table: &View, method: Method) -> usize {
    match table.given("max_iterations") {
        Some(_) => table.count("max_iterations"),
        None if method == Method::Newton => NEWTON_ITERATIONS,
        None => METHOD_ITERATIONS,
    }
}

fn method(table: &View) -> Result<MethodSettings, Error> {
    let name = table.text("method");
    let outer = match name.as_str() {
        "msa1" | "msa2" => Some(name.as_str()),
        _ => None,
    };
    let inner = match (name.as_str(), table.given("inner")) {
        ("cfs1", _) => "alg1".to_string(),
        ("cfs2", _) => "alg2".to_string(),
        ("msa1" | "msa2", Some(_)) => table.text("inner"),
        ("msa1" | "msa2", None) => "alg2".to_string(),
        _ => name.clone(),
    };
    used_keys_only(table, &name, &inner)?;
    let splitting = match table.text("splitting").as_str() {
        "partial" => Splitting::Partial,
        "complete" => Splitting::Complete,
        _ => Splitting::No,
    };
    let once = table.given("variant").is_none_or(|_| table.count("variant") == 2);
    let given = match inner.as_str() {
        "alg1" => Given::alg1(if once { Sweeps::One } else { Sweeps::UntilConverged }, splitting),
        "alg2" => Given::alg2(splitting),
        "discs" => Given::Discs,
        _ => Given::AdaptiveUzawa,
    };
    let method = match (name.as_str(), outer) {
        ("newton", _) => Method::Newton,
        (_, Some("msa1")) => Method::FixedPoint(given),
        ("cfs1" | "cfs2", _) | (_, Some("msa2")) => Method::InexactFixedPoint(given),
        _ => Method::Given(given),
    };
    if method == Method::InexactFixedPoint(Given::Discs) {
        let what = "\"msa2\" takes one step of an iteration on squares at a time, and \"discs\" has none";
        return Err(table.error("inner", what, "take \"alg1\", \"alg2\" or \"smalbe\", or method = \"msa1\""));
    }
    let mut settings = MethodSettings::new(method);
    if method == Method::Newton {
        return Ok(settings);
    }
    if table.given("rho").is_some() {
        if table.given("rho_factor").is_some() {
            return Err(table.error("rho_factor", "`rho` and `rho_factor` say the same thing twice", "take one out"));
        }
        settings.penalty = Penalty::Absolute(table.number("rho"));
    } else if table.given("rho_factor").is_some() {
        settings.penalty = Penalty::Scaled(table.number("rho_factor"));
    }
    let tolerance = table.number("tolerance");
    settings.squares = table.count("squares");
    settings.coupling = if table.text("coupling") == "chain" { Coupling::Chain } else { Coupling::Star };
    (settings.tolerance, settings.agreement) = (tolerance, tolerance);
    settings.inner_tolerance =
        table.given("inner_tolerance").map_or(INNER * tolerance, |_| table.number("inner_tolerance"));
    settings.sweep_tolerance = settings.inner_tolerance;
    settings.max_iterations = most_iterations(table, method);
    Ok(settings)
}

/// A key that the method does not use is a mistake, and which ones it does use is the remedy.
fn used_keys_only(table: &View, name: &str, inner: &str) -> Result<(), Error> {
    let mut used = Vec::new();
    if matches!(name, "msa1" | "msa2") {
        used.push("inner");
    }
    if inner == "alg1" && name != "cfs1" {
        used.push("variant");
    }
    if matches!(inner, "alg1" | "alg2") && name != "cfs2" {
        used.push("splitting");
    }
    if matches!(inner, "alg1" | "alg2" | "smalbe") {
        used.extend(["squares", "coupling", "rho", "rho_factor"]);
    }
    if matches!(inner, "alg1" | "alg2") {
        used.push("inner_tolerance");
    }
    let Some(key) = METHOD_KEYS.into_iter().find(|key| table.given(key).is_some() && !used.contains(key)) else {
        return Ok(());
    };
    let inside =
        if inner == name || name.starts_with("cfs") { String::new() } else { format!(" with {inner:?} inside") };
    let remedy = match used.as_slice() {
        [] => format!("take it out: {name:?} needs none of these settings"),
        _ => format!("take it out: {name:?}{inside} uses {}", used.join(", ")),
    };
    Err(table.error(key, format!("`{key}` is not used by the method {name:?}{inside}"), remedy))
}
