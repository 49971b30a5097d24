//! The tables of the page.

use serde_json::json;

use crate::contact::SMALL_MOTION;
use crate::io::text::{escaped, measure, number, triple};
use crate::io::units::Units;
use crate::run::results::accuracy_text::percent;
use crate::run::results::rows::Row;
use crate::run::results::summary::{Summary, Versions};
use crate::run::solve::quantities::{SMALL_ROTATION, SMALL_STRAIN, Smallness};
use crate::run::solve::{
    AccuracyRecord, BoundRecord, CertificateRecord, LevelRecord, StepRecord, Totals, ValueRecord, word,
};

impl Units<'_> {
    fn area(&self) -> String {
        if self.length.is_empty() { String::new() } else { format!("{}²", self.length) }
    }

    fn energy(&self) -> String {
        if self.length.is_empty() { String::new() } else { format!("{} {}", self.force, self.length) }
    }
}

/// Rows of cells that are escaped; the head and the number of columns of words at the left.
struct Table {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
    /// Columns that hold words and may wrap.
    words: Vec<usize>,
}

impl Table {
    fn new(head: &[&str]) -> Self {
        Table { head: head.iter().map(|h| h.to_string()).collect(), rows: Vec::new(), words: Vec::new() }
    }

    /// Leaves out columns that no row has anything in; none of them holds words.
    fn leave_out_empty_columns(&mut self) {
        let keep: Vec<bool> = (0..self.head.len()).map(|i| self.rows.iter().any(|row| !row[i].is_empty())).collect();
        for row in self.rows.iter_mut().chain([&mut self.head]) {
            let mut keep = keep.iter();
            row.retain(|_| keep.next() == Some(&true));
        }
    }

    fn html(&self) -> String {
        let class = |i: usize| if self.words.contains(&i) { " class=\"words\"" } else { "" };
        let head: String =
            self.head.iter().enumerate().map(|(i, h)| format!("<th{}>{}</th>", class(i), escaped(h))).collect();
        let mut out = format!("<div class=\"wide\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            let cells = row.iter().enumerate().map(|(i, cell)| match cell.as_str() {
                "exceeds" => "<td class=\"bad\">exceeds</td>".to_string(),
                "holds" => "<td class=\"good\">holds</td>".to_string(),
                cell => format!("<td{}>{}</td>", class(i), escaped(cell)),
            });
            out += &format!("<tr>{}</tr>\n", cells.collect::<String>());
        }
        out + "</tbody>\n</table></div>\n"
    }
}

fn unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_string() } else { format!("{name} [{unit}]") }
}

/// The measure that is farthest from its bound.
pub(super) fn worst_measure(certificate: &CertificateRecord) -> Option<&str> {
    certificate.measures.0.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| name.as_str())
}

fn meaning(measure: &str) -> &'static str {
    match measure {
        "equilibrium" => "forces at the nodes out of balance, over the loads",
        "force_balance" => "loads, reactions and contact forces of a body that do not add up to zero",
        "moment_balance" => "the same for moments",
        "penetration" => "deepest overlap of the surfaces, over the largest of displacements and local deflections",
        "tension" => "largest pull where surfaces can only push, over the largest contact force",
        "cone" => "friction beyond its bound, over the largest bound",
        "slip_direction" => "slip that friction does not oppose fully, over the largest bound and the same length",
        "bipotential_gap" => {
            "energy by which the laws of contact and friction are missed, over the work of all contact forces along that length"
        }
        "data_rounding" => "rounding of the numbers given, of which only differences count, over the same length",
        "natural_residual" => "distance of the contact forces from those the laws demand, over the forces",
        _ => "",
    }
}

/// What is known of other solutions, as a sentence that begins with a space; empty without Coulomb friction.
pub(super) fn uniqueness(s: &Summary) -> String {
    let Some(facts) = &s.answer.coulomb else { return String::new() };
    if let Some(found) = s.answer.solutions.as_ref().map(|found| found.distinct.len()).filter(|found| *found > 1) {
        return format!(" It is one of {found} solutions that were found.");
    }
    match (facts.unique, facts.uniqueness_bound) {
        (true, _) => " The solution is unique: friction is below the proven bound.".into(),
        (false, Some(bound)) => {
            let [bound, largest] = [bound, facts.largest_coefficient].map(number);
            format!(
                " It is a solution; that there is no other is proved only below the coefficient {bound} (here {largest})."
            )
        }
        (false, None) => " It is a solution; whether there are others is not known.".into(),
    }
}

/// All tables with their headings.
pub(super) fn all(s: &Summary, units: &Units) -> String {
    let mut out = certificate(&s.answer.certificate, units);
    out += &contact(s, units);
    out += &fretting(s, units);
    out += &s.answer.smallness.as_ref().map_or(String::new(), |of| small(of, units));
    out += &s.accuracy.as_ref().map_or(String::new(), accuracy);
    out += &s.bound.as_ref().map_or(String::new(), bound);
    out += &solutions(s, units);
    out += &bodies(s, units);
    out += &steps(&s.steps, units);
    out += &problem(&s.problem);
    out + &run(s)
}

fn certificate(c: &CertificateRecord, units: &Units) -> String {
    let tolerance = c.tolerance;
    let mut table = Table::new(&["Measure", "Value", "", "Bound", "", "What it says"]);
    table.words = vec![5];
    for (name, value) in &c.measures.0 {
        let [sign, verdict] = if *value <= tolerance { ["≤", "holds"] } else { [">", "exceeds"] };
        let cells = [&name.replace('_', " "), &measure(*value), sign, &format!("{tolerance:e}"), verdict];
        let mut row: Vec<String> = cells.iter().map(|cell| cell.to_string()).collect();
        row.push(meaning(name).into());
        table.rows.push(row);
    }
    let gap = c.duality_gap.map_or(String::new(), |gap| {
        let energy = units.energy();
        format!("<p>The duality gap, a bound of the error in energy, is {} {}.</p>\n", number(gap), escaped(&energy))
    });
    format!("<h2 id=\"certificate\">Certificate</h2>\n{}{gap}{}", table.html(), parts(c))
}

/// Each body and each pair by its own forces.
fn parts(c: &CertificateRecord) -> String {
    let mut table = Table::new(&["", "Name", "Residual", "", "Bound", ""]);
    for part in &c.parts {
        let [sign, verdict] = if part.residual <= c.part_tolerance { ["≤", "holds"] } else { [">", "exceeds"] };
        let (residual, bound) = (measure(part.residual), format!("{:e}", c.part_tolerance));
        table.rows.push([&part.part, &part.name, &residual, sign, &bound, verdict].map(str::to_string).to_vec());
    }
    format!(
        "<p>Each body and each pair by its own forces: equilibrium of the body; natural residual and equilibrium of the pair.</p>\n{}",
        table.html()
    )
}

/// The meshes of a refinement, and the values of the last with their error bars.
fn accuracy(accuracy: &AccuracyRecord) -> String {
    let has_bound = accuracy.levels.iter().any(|level| level.bound.is_some());
    let heads = ["Mesh", "Cells", "Unknowns", "Points", "Error", "Iterations", "CPU [s]", "Bound"];
    let mut meshes = Table::new(&heads[..heads.len() - usize::from(!has_bound)]);
    for level in &accuracy.levels {
        let LevelRecord { level, cells, unknowns, points, error, bound, iterations, cpu_seconds, .. } = level;
        let counts = [level + 1, *cells, *unknowns, *points].map(|count| count.to_string());
        let rest = [percent(*error), iterations.to_string(), format!("{cpu_seconds:.2}")];
        let bound = has_bound.then(|| bound.map_or(String::new(), percent));
        meshes.rows.push(counts.into_iter().chain(rest).chain(bound).collect());
    }
    let mut values = Table::new(&["Quantity", "Value", "Error bar"]);
    for ValueRecord { name, value, bar, .. } in &accuracy.values {
        let bar = if value.is_some() { bar.map_or("not known".to_string(), number) } else { String::new() };
        let value = value.map_or("grows without bound".to_string(), number);
        values.rows.push(vec![name.clone(), value, bar]);
    }
    format!(
        "<h2 id=\"accuracy\">Accuracy</h2>\n<p>The error is that of the stresses in the mean (energy norm), estimated from \
         recovered stresses. A bar says how far the value of the last mesh is expected from that of an infinitely fine one.</p>\n{}{}",
        meshes.html(),
        values.html()
    )
}

/// The bound of the error.
fn bound(bound: &BoundRecord) -> String {
    let mut table = Table::new(&["Bound of the error", "Over the norm of the exact stress, at most"]);
    let part = |part: Option<f64>| part.map_or("more than all stress there is".to_string(), percent);
    if bound.reason.is_none() {
        table.rows.push(vec!["of the stresses".into(), part(bound.error)]);
        table.rows.push(vec!["of the mean stress".into(), part(bound.mean_error)]);
    }
    let why = bound.reason.as_ref().map_or(String::new(), |reason| format!(": {}", escaped(reason)));
    let rows = if bound.reason.is_none() { table.html() } else { String::new() };
    format!("<h2 id=\"bound\">Bound</h2>\n<p>In the energy norm, {}{why}.</p>\n{rows}", bound.standing)
}

fn contact(s: &Summary, units: &Units) -> String {
    let pairs = &s.answer.pairs;
    if pairs.is_empty() {
        return String::new();
    }
    let area = units.area();
    let head = [
        "Surface".to_string(),
        "Points".into(),
        "Open".into(),
        "Stick".into(),
        "Slip".into(),
        unit("Area in contact", &area),
        unit("Normal force", units.force),
        unit("Friction on the body (x, y, z)", units.force),
        unit("Largest pressure", units.stress),
        unit("at (x, y, z)", units.length),
        unit("Largest shear", units.stress),
    ];
    let mut table = Table { head: head.to_vec(), rows: Vec::new(), words: Vec::new() };
    let row = |name: &str, t: &Totals| {
        let counts = [t.points, t.open, t.stick, t.slip].map(|count| count.to_string());
        let mut row = vec![name.to_string()];
        row.extend(counts);
        row.extend([
            number(t.stick_area + t.slip_area),
            number(t.normal_force),
            triple(t.tangential_force),
            number(t.max_pressure),
            t.max_pressure_at.map_or("none".into(), triple),
            number(t.max_shear),
        ]);
        row
    };
    table.rows.extend(pairs.iter().map(|pair| row(&pair.name, &pair.totals)));
    if pairs.len() > 1 {
        table.rows.push(row("all", &s.answer.contact));
    }
    format!(
        "<h2 id=\"contact\">Contact</h2>\n{}<p class=\"note\">The normal force is the sum of the forces of the points along \
         their normals. Friction is given as a force on the body whose surface the case names in <code>on</code>. Pressure and \
         shear are those at contact points, between bodies means over nodes of the other surface, some of which have more.</p>\n",
        table.html()
    )
}

fn solutions(s: &Summary, units: &Units) -> String {
    let Some(found) = &s.answer.solutions else { return String::new() };
    let energy = units.energy();
    let [stored, lost] = ["Energy", "Dissipated"].map(|name| unit(name, &energy));
    let force = unit("Normal force", units.force);
    let mut table = Table::new(&["", &stored, &lost, &force, "Open / stick / slip", "Worst measure", "Found from"]);
    table.words = vec![6];
    for (k, solution) in (1..).zip(&found.distinct) {
        let starts = found.starts.iter().filter(|start| start.solution == Some(k));
        let states = format!("{} / {} / {}", solution.open, solution.stick, solution.slip);
        let mut row = vec![k.to_string()];
        row.extend([solution.energy, solution.dissipation, solution.normal_force].map(number));
        row.extend([states, measure(solution.worst)]);
        row.push(starts.map(|start| start.start.as_str()).collect::<Vec<_>>().join(", "));
        table.rows.push(row);
    }
    let several = match found.distinct.len() {
        0 | 1 => "",
        _ => "The first one is shown on this page, the others are in <code>solution-2.npz</code> and so on. ",
    };
    let ended = found.ended.as_ref().map_or(String::new(), |why| format!(" Not all were tried: {}", escaped(why)));
    format!(
        "<h2 id=\"solutions\">Solutions found</h2>\n{}<p class=\"note\">{several}{} starts were tried.{ended}</p>\n",
        table.html(),
        found.starts.len()
    )
}

/// What friction has done to each pair over the load steps.
fn fretting(s: &Summary, units: &Units) -> String {
    if s.fretting.is_empty() {
        return String::new();
    }
    let per_area = if units.length.is_empty() { String::new() } else { format!("{} {}", units.stress, units.length) };
    let head = [
        "Pair".to_string(),
        unit("Work of friction", &units.energy()),
        unit("Largest work", &per_area),
        unit("Amplitude of slip", units.length),
        unit("Amplitude of shear", units.stress),
        unit("τδ", &per_area),
        "στδ".into(),
        unit("Depth of wear", units.length),
    ];
    let mut table = Table { head: head.to_vec(), rows: Vec::new(), words: Vec::new() };
    for of in &s.fretting {
        let mut row = vec![of.name.clone()];
        row.extend([of.work, of.max_work, of.max_slip_amplitude, of.max_shear_amplitude].map(number));
        row.extend([number(of.max_ruiz_1), number(of.max_ruiz_2), of.max_wear.map_or(String::new(), number)]);
        table.rows.push(row);
    }
    format!(
        "<h2 id=\"fretting\">Friction over the load steps</h2>\n{}<p class=\"note\">Largest values of a point; τδ and στδ are \
         the parameters of Ruiz. Each point is in <code>contact-0001.csv</code> and so on.</p>\n",
        table.html()
    )
}

/// How small rotations, strains and slips are.
fn small(of: &Smallness, units: &Units) -> String {
    let mut table = Table::new(&["", "Largest", "", "Small up to", "", "At (x, y, z)", "Part of the volume beyond"]);
    let mut add = |name: &str, size: String, limit: String, good: bool, at: String, part: String| {
        let [sign, verdict] = if good { ["≤", "holds"] } else { [">", "exceeds"] };
        table.rows.push(vec![name.into(), size, sign.into(), limit, verdict.into(), at, part]);
    };
    let (turn, at, part) = (of.rotation, triple(of.rotation_at), percent(of.rotation_volume));
    let degrees = |angle: f64| format!("{} degrees", number(angle));
    add("rotation", degrees(turn), degrees(SMALL_ROTATION), turn <= SMALL_ROTATION, at, part);
    let (strain, at, part) = (of.strain, triple(of.strain_at), percent(of.strain_volume));
    add("strain", percent(strain), percent(SMALL_STRAIN), strain <= SMALL_STRAIN, at, part);
    if let Some(pair) = &of.slip_pair {
        let (slip, good) = (percent(of.slip_over_face), of.slip_over_face <= SMALL_MOTION);
        let slip = format!("{slip} of a face, \"{pair}\"");
        add("slip", slip, percent(SMALL_MOTION), good, String::new(), String::new());
    }
    let slip = format!("{} {}", number(of.slip), units.length);
    format!(
        "<h2 id=\"small\">Small</h2>\n{}<p class=\"note\">Rotation and strain are those at the middles of cells. The farthest slide of a \
         touching point is {}.</p>\n",
        table.html(),
        escaped(slip.trim())
    )
}

fn bodies(s: &Summary, units: &Units) -> String {
    let [load, support, contact] =
        ["Load (x, y, z)", "Supports (x, y, z)", "Contact (x, y, z)"].map(|name| unit(name, units.force));
    let mut table = Table::new(&["Body", &load, &support, &contact, "Force balance", "Moment balance"]);
    for body in &s.answer.bodies {
        let mut row = vec![body.name.clone()];
        row.extend([body.load, body.support, body.contact].map(triple));
        row.extend([body.force_balance, body.moment_balance].map(measure));
        table.rows.push(row);
    }
    if table.rows.is_empty() {
        String::new()
    } else {
        format!("<h2 id=\"bodies\">Forces on each body</h2>\n{}", table.html())
    }
}

const ENERGIES: &str = "<p class=\"note\">Energies count from the start; work = elastic + dissipated + what the length of the steps \
                        costs.</p>\n";

/// A number; nothing for one that the run has not taken.
fn known(x: f64) -> String {
    if x.is_nan() { String::new() } else { number(x) }
}

fn steps(list: &[StepRecord], units: &Units) -> String {
    if list.is_empty() {
        return String::new();
    }
    let energy = units.energy();
    let head = [
        "Step".to_string(),
        "t".into(),
        "Status".into(),
        "Worst measure".into(),
        unit("Normal force", units.force),
        unit("Friction on the body (x, y, z)", units.force),
        "Open / stick / slip".into(),
        unit("Largest displacement", units.length),
        unit("Work", &energy),
        unit("Elastic", &energy),
        unit("Dissipated", &energy),
        "Iterations".into(),
        "Attempts".into(),
    ];
    let mut table = Table { head: head.to_vec(), rows: Vec::new(), words: Vec::new() };
    for StepRecord { step, name, t, attempts, answer, balance, .. } in list {
        let c = &answer.contact;
        table.rows.push(vec![
            format!("{step} {name}").trim_end().to_string(),
            number(*t),
            word(answer.status).replace('_', " "),
            measure(answer.certificate.worst),
            number(c.normal_force),
            triple(c.tangential_force),
            format!("{} / {} / {}", c.open, c.stick, c.slip),
            known(answer.displacement_max),
            known(balance.work),
            known(balance.elastic),
            known(balance.dissipation),
            answer.counts.steps().to_string(),
            if *attempts > 0 { attempts.to_string() } else { String::new() },
        ]);
    }
    table.leave_out_empty_columns();
    let has_energies = list.iter().any(|step| !step.balance.work.is_nan());
    let note = if has_energies { ENERGIES } else { "" };
    format!("<h2 id=\"steps\">Load steps</h2>\n{}{note}", table.html())
}

fn problem(rows: &[Row]) -> String {
    let mut table = Table::new(&["", "As the program understood the case"]);
    table.words = vec![1];
    let own = rows.iter().filter(|row| row.label != "note");
    table.rows.extend(own.map(|row| vec![row.label.clone(), row.line()]));
    if table.rows.is_empty() {
        String::new()
    } else {
        format!("<h2 id=\"problem\">What was solved</h2>\n{}", table.html())
    }
}

/// Shorter times are not shown, seconds.
const SHORTEST: f64 = 0.005;

fn run(s: &Summary) -> String {
    let mut table = Table::new(&["", "How it was solved"]);
    table.words = vec![1];
    let mut add = |name: &str, text: String| {
        if !text.is_empty() {
            table.rows.push(vec![name.into(), text]);
        }
    };
    let answer = &s.answer;
    let list = |entries: &mut dyn Iterator<Item = (&str, String)>| -> String {
        entries.map(|(name, value)| format!("{} {value}", name.replace('_', " "))).collect::<Vec<_>>().join(", ")
    };
    let counts = json!(answer.counts);
    let counts = counts.as_object().into_iter().flatten().filter_map(|(name, n)| Some((name.as_str(), n.as_u64()?)));
    let seconds = answer.seconds.0.iter().filter(|(_, time)| *time >= SHORTEST);
    let Versions { stiction, summary } = &s.versions;
    add("method", answer.method.clone());
    add("path", word(answer.path));
    add("counts", list(&mut counts.filter(|(_, n)| *n > 0).map(|(name, n)| (name, n.to_string()))));
    add("seconds", list(&mut seconds.map(|(name, time)| (name.as_str(), format!("{time:.2}")))));
    add("memory", answer.peak_memory_bytes.map_or(String::new(), |b| format!("{:.2} GB at most", b as f64 / 1e9)));
    add("command", s.command.clone().unwrap_or_default());
    add("options", s.overrides.join(", "));
    add("versions", format!("stiction {stiction}, summary {summary}"));
    format!("<h2 id=\"run\">The run</h2>\n{}", table.html())
}
