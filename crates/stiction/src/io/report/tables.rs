//! The tables of the page.

use serde_json::Value;

use super::text::{escaped, number, triple};

/// Labels of the units, empty where the case names none.
pub(super) struct Units<'a> {
    pub length: &'a str,
    pub force: &'a str,
    pub stress: &'a str,
}

impl<'a> Units<'a> {
    pub fn of(summary: &'a Value) -> Self {
        let [length, force, stress] = crate::io::plot::units(summary["units"].as_str());
        Units { length, force, stress }
    }

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

fn float(value: &Value) -> String {
    value.as_f64().map_or("none".into(), number)
}

pub(super) fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|c| value[c].as_f64().unwrap_or(0.0))
}

/// Labelled lines as the summary keeps them.
pub(super) fn lines(value: &Value) -> Vec<(String, String)> {
    let pair = |line: &Value| Some((line[0].as_str()?.to_string(), line[1].as_str()?.to_string()));
    value.as_array().map_or(Vec::new(), |lines| lines.iter().filter_map(pair).collect())
}

/// The measures of a certificate; what is not finite was written as null.
fn measures(certificate: &Value) -> Vec<(&str, f64)> {
    const OTHERS: [&str; 4] = ["duality_gap", "worst", "tolerance", "passed"];
    let Some(map) = certificate.as_object() else { return Vec::new() };
    let own = map.iter().filter(|(name, _)| !OTHERS.contains(&name.as_str()));
    own.map(|(name, value)| (name.as_str(), value.as_f64().unwrap_or(f64::INFINITY))).collect()
}

pub(super) fn worst_measure(certificate: &Value) -> Option<&str> {
    measures(certificate).into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| name)
}

fn meaning(measure: &str) -> &'static str {
    match measure {
        "equilibrium" => "forces at the nodes out of balance, over the loads",
        "force_balance" => "loads, reactions and contact forces of a body that do not add up to zero",
        "moment_balance" => "the same for moments",
        "penetration" => "deepest overlap of the surfaces, over the largest displacement",
        "tension" => "largest pull where surfaces can only push, over the largest contact force",
        "cone" => "friction beyond its bound, over the largest bound",
        "slip_direction" => "slip that friction does not oppose fully, over bound and displacement",
        "bipotential_gap" => "energy by which the laws of contact and friction are missed, over what is at stake",
        "natural_residual" => "distance of the contact forces from those the laws demand, over the forces",
        _ => "",
    }
}

/// What is known of other solutions, as a sentence that begins with a space; empty without Coulomb friction.
pub(super) fn uniqueness(s: &Value) -> String {
    let c = &s["coulomb"];
    if !c.is_object() {
        return String::new();
    }
    let largest = float(&c["largest_coefficient"]);
    match (c["unique"].as_bool(), c["uniqueness_bound"].as_f64()) {
        (Some(true), _) => " The solution is unique: friction is below the proven bound.".into(),
        (_, Some(bound)) => {
            let bound = number(bound);
            format!(
                " It is a solution; that there is no other is proved only below the coefficient {bound} (here {largest})."
            )
        }
        _ => " It is a solution; whether there are others is not known.".into(),
    }
}

/// All tables with their headings.
pub(super) fn all(s: &Value, units: &Units) -> String {
    let mut out = certificate(s, units);
    out += &contact(s, units);
    out += &bodies(s, units);
    out += &steps(s, units);
    out += &posed(s);
    out + &run(s)
}

fn certificate(s: &Value, units: &Units) -> String {
    let c = &s["certificate"];
    let tolerance = c["tolerance"].as_f64().unwrap_or(f64::NAN);
    let mut table = Table::new(&["Measure", "Value", "", "Bound", "", "What it says"]);
    table.words = vec![5];
    for (name, value) in measures(c) {
        let holds = value <= tolerance;
        let [sign, verdict] = if holds { ["≤", "holds"] } else { [">", "exceeds"] };
        let cells = [&name.replace('_', " "), &format!("{value:.1e}"), sign, &format!("{tolerance:e}"), verdict];
        let mut row: Vec<String> = cells.iter().map(|cell| cell.to_string()).collect();
        row.push(meaning(name).into());
        table.rows.push(row);
    }
    let gap = c["duality_gap"].as_f64().map_or(String::new(), |gap| {
        let energy = units.energy();
        format!("<p>The duality gap, a bound of the error in energy, is {} {}.</p>\n", number(gap), escaped(&energy))
    });
    format!("<h2 id=\"certificate\">Certificate</h2>\n{}{gap}", table.html())
}

fn contact(s: &Value, units: &Units) -> String {
    let pairs = s["pairs"].as_array().map_or(&[][..], Vec::as_slice);
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
    let row = |name: &str, t: &Value| {
        let count = |key: &str| t[key].as_u64().unwrap_or(0).to_string();
        let closed = t["stick_area"].as_f64().unwrap_or(0.0) + t["slip_area"].as_f64().unwrap_or(0.0);
        vec![
            name.to_string(),
            count("points"),
            count("open"),
            count("stick"),
            count("slip"),
            number(closed),
            float(&t["normal_force"]),
            triple(vector(&t["tangential_force"])),
            float(&t["max_pressure"]),
            if t["max_pressure_at"].is_array() { triple(vector(&t["max_pressure_at"])) } else { "none".into() },
            float(&t["max_shear"]),
        ]
    };
    table.rows.extend(pairs.iter().map(|pair| row(pair["name"].as_str().unwrap_or(""), pair)));
    if pairs.len() > 1 {
        table.rows.push(row("all", &s["contact"]));
    }
    format!(
        "<h2 id=\"contact\">Contact</h2>\n{}<p class=\"note\">The normal force is the sum of the forces of the points along \
         their normals. Friction is told as a force on the body whose surface the case names in <code>on</code>.</p>\n",
        table.html()
    )
}

fn bodies(s: &Value, units: &Units) -> String {
    let list = s["bodies"].as_array().map_or(&[][..], Vec::as_slice);
    let [load, support, contact] =
        ["Load (x, y, z)", "Supports (x, y, z)", "Contact (x, y, z)"].map(|name| unit(name, units.force));
    let mut table = Table::new(&["Body", &load, &support, &contact, "Force balance", "Moment balance"]);
    for body in list {
        let mut row = vec![body["name"].as_str().unwrap_or("").to_string()];
        row.extend(["load", "support", "contact"].map(|key| triple(vector(&body[key]))));
        row.extend(
            ["force_balance", "moment_balance"].map(|key| format!("{:.1e}", body[key].as_f64().unwrap_or(f64::NAN))),
        );
        table.rows.push(row);
    }
    if list.is_empty() {
        String::new()
    } else {
        format!("<h2 id=\"bodies\">Forces on each body</h2>\n{}", table.html())
    }
}

fn steps(s: &Value, units: &Units) -> String {
    let Some(list) = s["steps"].as_array() else { return String::new() };
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
    for e in list {
        let c = &e["contact"];
        let count = |v: &Value| v.as_u64().unwrap_or(0);
        let name = e["name"].as_str().filter(|name| !name.is_empty()).map_or(String::new(), |name| format!(" {name}"));
        table.rows.push(vec![
            format!("{}{name}", count(&e["step"])),
            float(&e["t"]),
            e["status"].as_str().unwrap_or("").replace('_', " "),
            format!("{:.1e}", e["certificate"]["worst"].as_f64().unwrap_or(f64::INFINITY)),
            float(&c["normal_force"]),
            triple(vector(&c["tangential_force"])),
            format!("{} / {} / {}", count(&c["open"]), count(&c["stick"]), count(&c["slip"])),
            float(&e["displacement_max"]),
            float(&e["balance"]["work"]),
            float(&e["balance"]["elastic"]),
            float(&e["balance"]["dissipation"]),
            count(&e["counts"]["iterations"]).max(count(&e["counts"]["cycles"])).to_string(),
            count(&e["attempts"]).to_string(),
        ]);
    }
    format!(
        "<h2 id=\"steps\">Load steps</h2>\n{}<p class=\"note\">Energies count from the start; work = elastic + dissipated + \
         what the length of the steps costs.</p>\n",
        table.html()
    )
}

fn posed(s: &Value) -> String {
    let mut table = Table::new(&["", "As the program understood the case"]);
    table.words = vec![1];
    let own = lines(&s["posed"]).into_iter().filter(|(label, _)| label != "note");
    table.rows.extend(own.map(|(label, text)| vec![label, text]));
    if table.rows.is_empty() {
        String::new()
    } else {
        format!("<h2 id=\"posed\">What was solved</h2>\n{}", table.html())
    }
}

fn run(s: &Value) -> String {
    let mut table = Table::new(&["", "How it was solved"]);
    table.words = vec![1];
    let mut add = |name: &str, text: String| {
        if !text.is_empty() {
            table.rows.push(vec![name.into(), text]);
        }
    };
    let named = |map: &Value, show: &dyn Fn(&Value) -> Option<String>| -> String {
        let entries = map.as_object().into_iter().flatten();
        let shown = entries.filter_map(|(name, value)| Some(format!("{} {}", name.replace('_', " "), show(value)?)));
        shown.collect::<Vec<_>>().join(", ")
    };
    let list = |value: &Value, between: &str| -> String {
        value.as_array().map_or(String::new(), |l| l.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(between))
    };
    let word = |key: &str| s[key].as_str().unwrap_or("").to_string();
    add("method", word("method"));
    add("path", word("path"));
    add("counts", named(&s["counts"], &|v| v.as_u64().filter(|&n| n > 0).map(|n| n.to_string())));
    add("seconds", named(&s["seconds"], &|v| v.as_f64().filter(|&t| t >= 0.005).map(|t| format!("{t:.2}"))));
    add("memory", s["peak_memory_bytes"].as_f64().map_or(String::new(), |b| format!("{:.2} GB at most", b / 1e9)));
    add("command", word("command"));
    add("options", list(&s["overrides"], ", "));
    add("versions", named(&s["versions"], &|v| v.as_str().map(String::from).or(v.as_u64().map(|n| n.to_string()))));
    format!("<h2 id=\"run\">The run</h2>\n{}", table.html())
}
