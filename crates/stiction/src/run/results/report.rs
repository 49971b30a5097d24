//! The answer in plain words.

use std::fmt;

use super::accuracy_text;
use super::method_text;
use super::overlap_text;
use super::rows::{Row, Rows, print};
use super::smallness_text;
use crate::certificate::{Certificate, Part, PartMeasure};
use crate::contact::Friction;
use crate::contact::escape::Escape;
use crate::friction::{SolverPath, Status};
use crate::io::text::{measure, number, triple};
use crate::mesh::many;
use crate::run::pose::Prepared;
use crate::run::pose::bolts::Target;
use crate::run::solve::quantities::{
    AdriftRecord, Couple, FacetedRecord, adrift_of, couples, faceted, largest_displacement, unheld,
};
use crate::run::solve::{
    BalanceRecord, BoltState, BoundRecord, CouplingState, Outcome, SlidingRecord, SolutionsRecord, StepRecord, Totals,
    UniquenessRecord, bolt_states, coupling_states, escape_of, pair_totals, totals, word,
};

/// The result of a run, a few lines for a person; `Display` prints it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The lines, in their order.
    pub rows: Vec<Row>,
    /// Time and memory, which differ from run to run.
    pub cost: Vec<Row>,
}

/// Width of the labels.
const LABELS: usize = 12;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print(f, &self.rows, LABELS)?;
        print(f, &self.cost, LABELS)
    }
}

/// What is to be said of an answer.
pub fn report(prepared: &Prepared, outcome: &Outcome) -> Report {
    let mut rows = Rows::default();
    let solution = &outcome.solution;
    if let Some(report) = &outcome.method {
        rows.add("method", method_text::words(&outcome.method_name, &outcome.settings, report));
    }
    let all = if outcome.steps.is_empty() {
        iterations(outcome)
    } else {
        outcome.steps.iter().map(|step| step.answer.counts.steps()).sum()
    };
    rows.add("status", status(solution.status, all));
    limit_row(&mut rows, solution.status);
    step_rows(&mut rows, &outcome.steps);
    method_text::shortfall(outcome).into_iter().for_each(|why| rows.more(why));
    let overlaps = overlap_text::sentences(prepared, outcome);
    overlaps.refused.into_iter().for_each(|what| rows.more(what));
    escape_of(prepared, solution.status).into_iter().for_each(|escape| escape_rows(&mut rows, &escape));
    limit_load(prepared, outcome).into_iter().for_each(|what| rows.more(what));
    shortfalls(prepared, outcome).into_iter().for_each(|what| rows.more(what));
    certificate_rows(&mut rows, &solution.certificate);
    if prepared.facts.points > 0 {
        let pairs = pair_totals(prepared, outcome);
        contact_rows(&mut rows, pairs.iter().map(|(name, t)| (&name[..], t)), &totals(prepared, outcome));
    }
    bolt_rows(&mut rows, &bolt_states(prepared, outcome));
    coupling_rows(&mut rows, &coupling_states(prepared, outcome));
    overlaps.warnings.into_iter().for_each(|warning| rows.add("warning", warning));
    let of_steps = outcome.steps.iter().map(|step| (step.answer.smallness.as_ref(), step.t));
    let left = smallness_text::warnings(outcome.smallness.as_ref(), of_steps);
    left.into_iter().for_each(|warning| rows.add("warning", warning));
    let of_steps = outcome.steps.iter().map(|step| (&step.answer.unheld[..], step.t));
    let now = match outcome.steps.is_empty() {
        true => unheld(prepared, &outcome.solution),
        false => Vec::new(),
    };
    unheld_rows(&mut rows, &now, of_steps);
    let of_steps = outcome.steps.iter().map(|step| (step.answer.adrift.as_ref(), step.t));
    adrift_row(&mut rows, || adrift_of(prepared, &outcome.solution), of_steps);
    let of_steps = outcome.steps.iter().map(|step| (step.answer.held_by_facets.as_ref(), step.t));
    faceted_row(&mut rows, || faceted(prepared, &outcome.solution), of_steps);
    couple_rows(&mut rows, &couples(prepared, &outcome.solution.u, &outcome.solution.lambda));
    displacement_row(&mut rows, largest_displacement(prepared, outcome));
    outcome.smallness.iter().for_each(|of| rows.add("deformation", smallness_text::line(of)));
    if let Some(estimate) = &outcome.estimate {
        mesh_row(&mut rows, estimate.relative(), &outcome.steps);
    }
    outcome.bound.iter().for_each(|bound| accuracy_text::bound(&mut rows, &BoundRecord::of(bound)));
    outcome.accuracy.iter().for_each(|accuracy| accuracy_text::rows(&mut rows, accuracy));
    let facts = outcome.coulomb.as_ref().map(UniquenessRecord::of);
    if outcome.solution.status == Status::Solved {
        let laws = Laws::of(&prepared.problem.contact.friction);
        uniqueness_row(&mut rows, facts.as_ref(), outcome.solution.path, laws);
    }
    if let Some(found) = &outcome.solutions {
        solutions(&mut rows, &SolutionsRecord::of(prepared, found));
    }
    rows.add("work", work(outcome));
    Report { rows: rows.0, cost: cost(outcome) }
}

/// The estimated error of an answer, and the largest one of its load steps.
pub(in crate::run) fn mesh_row(rows: &mut Rows, error: f64, steps: &[StepRecord]) {
    let error = accuracy_text::percent(error);
    let over_steps = worst_step(steps).map_or(String::new(), |(error, t)| {
        format!(", over the load steps at most {} at t = {}", accuracy_text::percent(error), number(t))
    });
    rows.add("mesh", format!("{} {error} (energy norm){over_steps}", accuracy_text::ESTIMATED));
}

/// Which kinds of laws some points have that say something of other solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::run) struct Laws {
    pub cohesive: bool,
    pub coulomb: bool,
}

impl Laws {
    pub(in crate::run) fn of(laws: &[Friction]) -> Laws {
        let cohesive = laws.iter().any(|law| matches!(law, Friction::Cohesive { .. }));
        Laws { cohesive, coulomb: laws.iter().any(|law| law.coefficient().is_some()) }
    }
}

/// What is known of other solutions.
pub(in crate::run) fn uniqueness_row(
    rows: &mut Rows,
    facts: Option<&UniquenessRecord>,
    path: SolverPath,
    Laws { cohesive, coulomb }: Laws,
) {
    if let Some(facts) = facts {
        rows.add("uniqueness", uniqueness(facts));
    } else if cohesive {
        let why = "nothing is known of others with cohesion, which a point loses where it opens";
        rows.add("uniqueness", format!("a solution; {why}"));
    } else if coulomb && path == SolverPath::Multigrid {
        let why = "others are looked for with `--starts N`, and what can be said about them is estimated then";
        rows.add("uniqueness", format!("a solution; {why}"));
    }
}

/// What is to be done where the limit of iterations has ended a run.
pub(in crate::run) fn limit_row(rows: &mut Rows, status: Status) {
    if status == Status::MaxIterations {
        rows.more("if the residuals still fall, give it more with a larger `max_iterations` under [solver]".into());
    }
}

/// How a body is carried away.
pub(in crate::run) fn escape_rows(rows: &mut Rows, Escape { motion, facts, remedy }: &Escape) {
    rows.more(format!("the loads carry away {motion}"));
    facts.iter().for_each(|fact| rows.more(fact.clone()));
    rows.more(format!("remedy: {remedy}"));
    rows.more("what follows, and the files, show a body that the solver holds by force: they are no result".into());
}

/// What the certificate says.
pub(in crate::run) fn certificate_rows(rows: &mut Rows, of: &Certificate) {
    rows.add("certificate", certificate(of));
    worst_part(of).into_iter().for_each(|part| rows.more(part));
    if of.data_rounding.is_some_and(|rounding| rounding > of.tolerance) {
        rows.more(
            "what the numbers given leave open is larger: count displacements and obstacles from where the".into(),
        );
        rows.more("bodies meet, or ask for a larger tolerance".into());
    }
}

/// Each pair by its name, and where there are several all of them.
pub(in crate::run) fn contact_rows<'a>(
    rows: &mut Rows,
    pairs: impl ExactSizeIterator<Item = (&'a str, &'a Totals)>,
    all: &Totals,
) {
    let several = pairs.len() > 1;
    for (name, t) in pairs {
        let head = if several { format!("\"{name}\": ") } else { String::new() };
        contact(rows, &head, t);
    }
    if several {
        contact(rows, "all pairs: ", all);
    }
}

/// What bolts bear.
pub(in crate::run) fn bolt_rows(rows: &mut Rows, bolts: &[BoltState]) {
    for BoltState { name, force, shortening } in bolts {
        rows.add("bolt", format!("\"{name}\": force {}, shortening {}", number(*force), number(*shortening)));
    }
}

/// A warning for each couple that is left.
pub(in crate::run) fn couple_rows(rows: &mut Rows, couples: &[Couple]) {
    for Couple { pair, moment, part } in couples {
        let (moment, part) = (triple(*moment), accuracy_text::percent(*part));
        let what = "shear acts at either surface, and these lie apart: of the moments of the contact forces the couple";
        let remedy = "mesh the surfaces where they touch, or move one there";
        rows.add("warning", format!("contact \"{pair}\": {what} {moment} is left, {part} of them; {remedy}"));
    }
}

/// Bodies among several that nothing holds, in an answer or in some of its load steps, each with its time: a support may have been
/// forgotten.
pub(in crate::run) fn unheld_rows<'a>(
    rows: &mut Rows,
    answer: &[String],
    steps: impl ExactSizeIterator<Item = (&'a [String], f64)>,
) {
    if steps.len() == 0 {
        for body in answer {
            let remedy = "if it is to take forces, add a [[fix]] for it, or a load that presses it";
            let what = "has no support, and nothing presses on it: its place says nothing";
            rows.add("warning", format!("body \"{body}\" {what}; {remedy}"));
        }
        return;
    }
    let mut times: Vec<(&str, Vec<f64>)> = Vec::new();
    for (bodies, t) in steps {
        for body in bodies {
            match times.iter_mut().find(|(name, _)| name == body) {
                Some((_, times)) => times.push(t),
                None => times.push((body, vec![t])),
            }
        }
    }
    for (body, times) in times {
        let first = times.first().map_or(String::new(), |&t| number(t));
        let more = match times.len() {
            1 => String::new(),
            count => format!(" and in {}", many(count - 1, "more increment")),
        };
        let why = "its place there says nothing, and friction of later steps depends on it";
        let remedy = "hold it there, or let its contact begin with the first step";
        rows.add("warning", format!("nothing holds body \"{body}\" at t = {first}{more}: {why}; {remedy}"));
    }
}

/// A motion that facets alone hold, from time `t` on with load steps.
/// The motion of an answer, or the first of its load steps with its time, that hardly more than facets resists.
pub(in crate::run) fn faceted_row<'a>(
    rows: &mut Rows,
    answer: impl FnOnce() -> Option<FacetedRecord>,
    steps: impl ExactSizeIterator<Item = (Option<&'a FacetedRecord>, f64)>,
) {
    let found = of_answer_or_steps(answer, steps);
    found.iter().for_each(|(held, t)| rows.add("warning", by_facets(held, *t)));
}

/// The same of motions that nothing resists.
pub(in crate::run) fn adrift_row<'a>(
    rows: &mut Rows,
    answer: impl FnOnce() -> Option<AdriftRecord>,
    steps: impl ExactSizeIterator<Item = (Option<&'a AdriftRecord>, f64)>,
) {
    let Some((AdriftRecord { motion, motions }, t)) = of_answer_or_steps(answer, steps) else { return };
    let at = t.map_or(String::new(), |t| format!(" at t = {}", number(t)));
    let what = match motions {
        1 => format!("nothing resists a motion{at}: {motion}"),
        _ => format!("nothing resists {motions} independent motions{at}, one of them: {motion}"),
    };
    let remedy = "bodies are left where they were, as far as gaps allow: their place along it is arbitrary, and friction that \
                  later follows from it; hold them by a [[fix]]";
    rows.add("warning", format!("{what}; {remedy}"));
}

fn of_answer_or_steps<'a, T: Clone + 'a>(
    answer: impl FnOnce() -> Option<T>,
    mut steps: impl ExactSizeIterator<Item = (Option<&'a T>, f64)>,
) -> Option<(T, Option<f64>)> {
    if steps.len() == 0 {
        Some((answer()?, None))
    } else {
        steps.find_map(|(found, t)| Some((found?.clone(), Some(t))))
    }
}

fn by_facets(FacetedRecord { motion, slope, angle }: &FacetedRecord, t: Option<f64>) -> String {
    let at = t.map_or(String::new(), |t| format!(" at t = {}", number(t)));
    let in_degrees = |angle: &f64| {
        if *angle < 0.01 { "less than 0.01 degrees".into() } else { format!("{angle:.2} degrees") }
    };
    let [slope, angle] = [slope, angle].map(in_degrees);
    format!(
        "hardly more than the facets of a mesh or of triangles resists a motion{at}: {motion}; it climbs {slope} where normals of the \
         surfaces are off by {angle}, and friction is at its limit or there is none: where it ends, and forces that grow with it, say \
         nothing; hold it by a [[fix]], or by a plane, ball or cylinder as obstacle"
    )
}

/// The largest displacement, and where it is.
pub(in crate::run) fn displacement_row(rows: &mut Rows, (size, place): (f64, [f64; 3])) {
    rows.add("displacement", format!("at most {} at {}", number(size), triple(place)));
}

/// The largest estimated error of any load step with its time; `None` if it is that of the last one.
fn worst_step(steps: &[StepRecord]) -> Option<(f64, f64)> {
    let known = |step: &StepRecord| step.answer.discretisation_error.map(|error| (error, step.t));
    let worst = steps.iter().filter_map(known).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (worst.1 < steps.last()?.t).then_some(worst)
}

fn iterations(outcome: &Outcome) -> usize {
    let counts = outcome.solution.counts;
    outcome.method.as_ref().map_or(counts.newton_steps.max(counts.cycles), |report| report.counts.iterations)
}

fn work(outcome: &Outcome) -> String {
    let counts = outcome.solution.counts;
    if outcome.solution.path == SolverPath::Multigrid {
        let restarts = many(counts.restarts, "restart");
        return format!("{} of multigrid, {restarts}", many(counts.cycles, "cycle"));
    }
    let path = word(outcome.solution.path);
    let inside = match &outcome.method {
        Some(report) => {
            let (steps, problems) = (report.counts.steps(), report.counts.qp_problems);
            format!("{} in {}", many(steps, "step"), many(problems, "quadratic program"))
        }
        None => many(counts.restarts, "restart"),
    };
    let (iterations, products) = (many(iterations(outcome), "iteration"), many(counts.products, "product"));
    let why = outcome.path_reason.as_ref().map_or(String::new(), |why| format!(": {why}"));
    format!("{iterations}, {products} with B K^-1 B' ({path}{why}), {inside}")
}

/// Phases that took less than this are not listed, seconds.
const SHORTEST_PHASE: f64 = 0.005;

fn cost(outcome: &Outcome) -> Vec<Row> {
    let mut rows = Rows::default();
    let phases = outcome.seconds.phases().into_iter().filter(|(_, span)| span.wall >= SHORTEST_PHASE);
    let phases: Vec<String> = phases.map(|(name, span)| format!("{name} {:.2}", span.wall)).collect();
    let phases = if phases.is_empty() { String::new() } else { format!(" ({})", phases.join(", ")) };
    rows.add("time", format!("{:.2} s{phases}", outcome.seconds.total().wall));
    if let Some(bytes) = outcome.peak_memory {
        rows.add("memory", format!("{:.2} GB at most", bytes as f64 / 1e9));
    }
    rows.0
}

/// The limit load where nothing was found and friction may have reached its limit: along which motion, and how the loads
/// compare with what friction resists. Forces are per unit of the displacement of what moves farthest.
pub fn limit_load(prepared: &Prepared, outcome: &Outcome) -> Option<String> {
    let sliding = SlidingRecord::of(prepared, outcome.sliding.as_ref()?);
    Some(limit_load_of(&sliding, &outcome.steps))
}

pub(in crate::run) fn limit_load_of(
    SlidingRecord { motion, load, friction }: &SlidingRecord,
    steps: &[StepRecord],
) -> String {
    let [load, friction] = [load, friction].map(|force| number(*force));
    let of = if steps.len() > 1 { "of the last step that was solved" } else { "reached" };
    format!("at the normal forces {of} friction resists at most {friction}, and the loads push with {load}: {motion}")
}

/// Where surfaces between which contact is named pass through each other, and the remedy.
pub fn passes_through(prepared: &Prepared, outcome: &Outcome) -> Option<String> {
    let refused = overlap_text::sentences(prepared, outcome).refused;
    (!refused.is_empty()).then(|| refused.join("; "))
}

/// Motion of reference points, and what acts there.
pub(in crate::run) fn coupling_rows(rows: &mut Rows, couplings: &[CouplingState]) {
    for CouplingState { name, displacement, rotation, force, moment } in couplings {
        let [displacement, rotation, force, moment] = [displacement, rotation, force, moment].map(|v| triple(*v));
        rows.add("reference", format!("\"{name}\": displacement {displacement}, rotation {rotation}"));
        rows.more(format!("force {force}, moment {moment}"));
    }
}

/// How far the load steps came, and the balance of energy; the rows below are of the last step.
pub(in crate::run) fn step_rows(rows: &mut Rows, all: &[StepRecord]) {
    let Some(last) = all.last() else { return };
    let StepRecord { name, t, dt, attempts, .. } = last;
    let again = all.iter().filter(|step| step.attempts > 1).count();
    let again = if again == 0 { String::new() } else { format!(", {again} of them not at the first attempt") };
    let count = many(all.len(), "step");
    rows.add("steps", format!("{count} to t = {}{again}; below is the last", number(*t)));
    if matches!(last.answer.status, Status::MaxIterations | Status::Stalled) {
        let span = format!("from t = {} to {}", number(t - dt), number(*t));
        let shorter =
            if *attempts > 1 { format!(" in {attempts} attempts with ever shorter steps") } else { String::new() };
        rows.more(format!("the last one (\"{name}\", {span}) was not solved{shorter}"));
    }
    let BalanceRecord { work, elastic, dissipation, drift } = last.balance;
    let [work, elastic, dissipated, drift] = [work, elastic, dissipation, drift].map(number);
    rows.add("energy", format!("work {work} = elastic {elastic} + dissipated {dissipated} + drift {drift}"));
}

fn contact(rows: &mut Rows, head: &str, t: &Totals) {
    let (normal, tangential) = (number(t.normal_force), triple(t.tangential_force));
    rows.add("contact", format!("{head}normal force {normal}, friction on the body {tangential}"));
    let [open, stick, slip] = [t.open_area, t.stick_area, t.slip_area].map(number);
    rows.more(format!("open {} points (area {open}), stick {} ({stick}), slip {} ({slip})", t.open, t.stick, t.slip));
    if t.open == t.points {
        rows.more("no point is in contact".into());
    }
    if let Some(place) = t.max_pressure_at {
        let (pressure, place, shear) = (number(t.max_pressure), triple(place), number(t.max_shear));
        rows.more(format!("pressure at most {pressure} at {place}, shear at most {shear}{}", other_side(t)));
    }
}

/// Pressures of the two surfaces that differ by less are the same to a reader.
const SAME_PRESSURE: f64 = 1e-3;

/// The pressure of the other surface, which `contact.vtu` shows as well, where it is larger.
fn other_side(t: &Totals) -> String {
    if t.max_other_pressure <= (1.0 + SAME_PRESSURE) * t.max_pressure {
        return String::new();
    }
    format!(" (at contact points; at nodes of the other surface, side 1, up to {})", number(t.max_other_pressure))
}

/// How the iteration ended.
pub(in crate::run) fn status(status: Status, iterations: usize) -> String {
    let count = many(iterations, "iteration");
    match status {
        Status::Solved => format!("solved after {count}"),
        Status::MaxIterations => format!("NOT SOLVED: stopped at the limit of {count}"),
        Status::Stalled => format!("NOT SOLVED: nothing more was gained after {count}"),
        Status::NoEquilibrium => "NOT SOLVED: there is no equilibrium".into(),
        Status::PassesThrough => "NOT SOLVED: surfaces between which contact is named pass through each other".into(),
        Status::Uncertified => format!("NOT SOLVED: converged by its own rule after {count}, not by the certificate"),
        Status::Interrupted => format!("NOT SOLVED: interrupted after {count}"),
    }
}

/// The worst measure by name against the tolerance.
fn certificate(c: &Certificate) -> String {
    let worst = c.measures().into_iter().find(|(_, value)| *value == c.worst || value.is_nan());
    let name = worst.map_or(String::new(), |(name, _)| format!(" ({})", words(name)));
    let verdict = if c.passed { "passed" } else { "NOT PASSED" };
    let sign = if c.worst <= c.tolerance { "<=" } else { ">" };
    format!("{verdict}: the worst measure is {}{name} {sign} {:e}", measure(c.worst), c.tolerance)
}

/// The body or the pair that is farthest off by its own forces, where there are several to tell apart or it is too far.
fn worst_part(c: &Certificate) -> Option<String> {
    let worst = c.worst_part()?;
    let several = |part| c.parts.iter().filter(|other| other.part == part).count() > 1;
    let holds = worst.residual <= c.part_tolerance();
    (several(Part::Body) || several(Part::Pair) || !holds).then(|| {
        let sign = if holds { "<=" } else { ">" };
        let PartMeasure { part, name, residual } = worst;
        let (part, residual) = (part.name(), measure(*residual));
        let bound = c.part_tolerance();
        format!("each body and pair in its own forces: the worst is {part} \"{name}\", {residual} {sign} {bound:e}")
    })
}

/// What several starts have found.
pub(in crate::run) fn solutions(rows: &mut Rows, found: &SolutionsRecord) {
    let SolutionsRecord { starts, distinct, ended } = found;
    let failed = starts.iter().filter(|start| start.solution.is_none()).count();
    let failures = if failed > 0 { format!(", {failed} of which failed") } else { String::new() };
    rows.add("solutions", format!("{} from {}{failures}", distinct.len(), many(starts.len(), "start")));
    for (k, s) in (1..).zip(distinct) {
        let from: Vec<&str> =
            starts.iter().filter(|start| start.solution == Some(k)).map(|start| start.start.as_str()).collect();
        rows.more(format!(
            "{k}: energy {}, dissipated {}, normal force {}, open {}, stick {}, slip {}; from: {}",
            number(s.energy),
            number(s.dissipation),
            number(s.normal_force),
            s.open,
            s.stick,
            s.slip,
            from.join(", ")
        ));
    }
    ended.iter().for_each(|why| rows.more(format!("not all starts were tried: {why}")));
}

/// What is known of other solutions.
pub fn uniqueness(facts: &UniquenessRecord) -> String {
    let coefficient = facts.largest_coefficient;
    let contraction = format!("contraction of the fixed point about {:.2}", facts.contraction);
    if facts.unique {
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
fn shortfalls(prepared: &Prepared, outcome: &Outcome) -> Vec<String> {
    let (Some(last), Status::Stalled | Status::MaxIterations) = (outcome.steps.last(), outcome.solution.status) else {
        return Vec::new();
    };
    let step = prepared.loading.steps.iter().position(|step| last.name == step.name).unwrap_or(0);
    let targets = prepared.loading.targets(step, last.t).unwrap_or_default();
    short_of(bolt_states(prepared, outcome), targets)
}

/// The same of bolts and of what is asked of each.
pub(in crate::run) fn short_of(bolts: Vec<BoltState>, targets: Vec<Target>) -> Vec<String> {
    let short = |(bolt, target): (BoltState, Target)| match target {
        Target::Force(force) if (bolt.force - force).abs() > MISSED * force.abs() => Some(format!(
            "bolt \"{}\" has the force {:.4e} where {force:.4e} is asked for: if nothing that is held lies between its parts, \
             see to the contacts under its head and its nut; otherwise tighten it by `shortening` first",
            bolt.name, bolt.force
        )),
        _ => None,
    };
    bolts.into_iter().zip(targets).filter_map(short).collect()
}

/// What a run says at its end that has not solved its case; `why` goes on with it. With load steps the last ended at `t`.
pub fn ended_short(status: Status, t: Option<f64>, why: &str) -> Option<String> {
    match status {
        Status::Solved | Status::Interrupted => None,
        Status::NoEquilibrium => {
            let why = if why.is_empty() { String::new() } else { format!(", {why}") };
            let [when, files] = match t {
                Some(t) => [format!(" at t = {t}"), "the files of that step hold".into()],
                None => [String::new(), "the files hold".into()],
            };
            Some(format!("there is no equilibrium{when}{why}; {files} no result"))
        }
        Status::PassesThrough => Some(format!("{why}; the files hold bodies that pass through each other")),
        Status::MaxIterations | Status::Stalled | Status::Uncertified => {
            let why = if why.is_empty() { String::new() } else { format!("{why}; ") };
            let files = "the files hold the last step and a certificate that says so";
            Some(format!("the tolerance was not reached; {why}{files}"))
        }
    }
}

/// Part of a force whose lack is worth a word: that of a search which was about to end is smaller.
const MISSED: f64 = 1e-3;
