//! The page.

use serde_json::{Value, json};

use super::tables;
use super::text::{base64, script_json};
use super::view::{View, encoded};
use crate::friction::Status;
use crate::io::look;
use crate::io::text::{escaped, measure, number, triple};
use crate::io::units::Units;
use crate::run::results::overlap_text;
use crate::run::results::rows::Row;
use crate::run::results::summary::Summary;
use crate::run::solve::CertificateRecord;

/// A picture of the result folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    /// Its file.
    pub name: String,
    pub png: Vec<u8>,
}

const STYLE: &str = include_str!("style.css");
const VIEWER: &str = include_str!("viewer.js");
const NO_VIEW: &str = "The interactive view needs JavaScript; the pictures below show the result.";

/// The text of `report.html`; `case_text` is the case file as it was.
pub(crate) fn html(s: &Summary, case_text: &str, pictures: &[Picture], view: &View) -> String {
    let units = Units::of(s.units.as_deref());
    let title = escaped(&s.title);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<meta name=\"generator\" content=\"stiction\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n"
    );
    out += &format!("<p class=\"soft\">{}</p>\n</header>\n", escaped(&subtitle(s)));
    out += &verdict(s);
    out += &warnings(s, view);
    out += &cards(s, &units);
    out += &viewer(view, &units);
    out += &drawn(pictures);
    out += &tables::all(s, &units);
    if !case_text.is_empty() {
        out += &format!("<h2 id=\"case\">Case file</h2>\n<pre>{}</pre>\n", escaped(case_text));
    }
    let version = escaped(&s.versions.stiction);
    out += &format!("<footer class=\"soft\">Written by stiction {version} from the files beside it.</footer>\n");
    out += "<script type=\"application/json\" id=\"view-data\">";
    out += &script_json(&view_data(view, &units));
    out += &format!("</script>\n<script>\n{VIEWER}</script>\n</body>\n</html>\n");
    out
}

/// The pictures of the folder, if it has any.
fn drawn(pictures: &[Picture]) -> String {
    let figure = |picture: &Picture| {
        let (name, data) = (escaped(&picture.name), base64(picture.png.iter().copied()));
        format!(
            "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{data}\"><figcaption>{name}</figcaption></figure>\n"
        )
    };
    let all: String = pictures.iter().map(figure).collect();
    match all.is_empty() {
        true => all,
        false => format!("<h2 id=\"pictures\">Pictures</h2>\n<div class=\"pictures\">\n{all}</div>\n"),
    }
}

fn view_data(view: &View, units: &Units) -> Value {
    let mut data = encoded(view);
    data["length"] = json!(units.length);
    data["map"] = json!((0..256).map(|i| look::viridis(f64::from(i) / 255.0)).collect::<Vec<_>>());
    data["states"] = json!(look::STATUS.iter().chain([&look::OUTSIDE]).collect::<Vec<_>>());
    data
}

fn subtitle(s: &Summary) -> String {
    let points = s.answer.contact.points;
    let steps = if s.steps.is_empty() { String::new() } else { format!(", {} load steps", s.steps.len()) };
    let units = s.units.as_ref().map_or(String::new(), |units| format!("; units {units}"));
    format!("Elastic contact with friction: {} unknowns, {points} contact points{steps}{units}.", s.answer.dofs)
}

/// First of all: what the answer is worth.
fn verdict(s: &Summary) -> String {
    let CertificateRecord { worst, tolerance, passed, .. } = s.answer.certificate;
    let name = tables::worst_measure(&s.answer.certificate);
    let name = name.map_or(String::new(), |name| format!(", {}", name.replace('_', " ")));
    let steps = &s.steps;
    let (good, head) = match (s.answer.status, passed) {
        (Status::Solved, true) => (true, "Solved and certified."),
        (Status::Solved, false) => (false, "Not certified."),
        (Status::MaxIterations, _) => (false, "Not solved: the limit of iterations was reached."),
        (Status::Stalled, _) => (false, "Not solved: the iteration gained nothing more."),
        (Status::NoEquilibrium, _) => (false, "Not solved: there is no equilibrium."),
        (Status::PassesThrough, _) => (false, "Not solved: surfaces pass through each other."),
        (Status::Interrupted, true) => (false, "Interrupted. What was finished is certified."),
        (Status::Interrupted, false) => (false, "Not solved: the run was interrupted."),
        (Status::Uncertified, _) => (false, "Not certified: the method ended by its own rule, not by the certificate."),
    };
    let mut text = if passed {
        format!(
            "Every measure of the certificate lies within the tolerance {tolerance:e}; the worst{name}, is {worst:.1e}. \
             They were recomputed from the problem and the answer by code that shares nothing with the solver."
        )
    } else {
        format!("The worst measure of the certificate{name}, is {}; the tolerance is {tolerance:e}.", measure(worst))
    };
    for overlap in s.answer.overlaps.iter().filter(|overlap| overlap_text::is_refused(overlap)) {
        text += &format!(" {}.", overlap_text::sentence(overlap));
    }
    if let Some(motion) = &s.answer.escape_mode {
        text += &format!(" The loads carry away {motion}; what follows shows a body held by force and is no result.");
    } else if !passed {
        text += " What follows is as far as the iteration came and is no result.";
    }
    if steps.len() > 1 {
        let passed = steps.iter().filter(|step| step.answer.certificate.passed).count();
        text += &format!(" {passed} of {} load steps are certified; below is the last one.", steps.len());
    }
    text += &tables::uniqueness(s);
    let class = if good { "good" } else { "bad" };
    format!("<section class=\"verdict {class}\"><strong>{head}</strong><p>{}</p></section>\n", escaped(&text))
}

fn warnings(s: &Summary, view: &View) -> String {
    let notes = s
        .problem
        .iter()
        .chain(&s.report)
        .filter(|row| ["note", "warning"].contains(&row.label.as_str()))
        .map(Row::line);
    let notes = notes.chain(view.notes.iter().cloned());
    let items: String = notes.map(|note| format!("<li>{}</li>\n", escaped(&note))).collect();
    if items.is_empty() { items } else { format!("<ul class=\"warnings\" aria-label=\"Notes\">\n{items}</ul>\n") }
}

fn cards(s: &Summary, units: &Units) -> String {
    let c = &s.answer.contact;
    let with = |value: f64, unit: &str| format!("{} {unit}", number(value)).trim().to_string();
    let mut cards = vec![("largest displacement", with(s.answer.displacement_max, units.length))];
    if c.points > 0 {
        let friction = triple(c.tangential_force);
        cards.insert(0, ("normal force of contact", with(c.normal_force, units.force)));
        cards.insert(1, ("friction on the body (x, y, z)", format!("{friction} {}", units.force)));
        cards.push(("largest pressure", with(c.max_pressure, units.stress)));
        cards.push(("largest shear traction", with(c.max_shear, units.stress)));
        cards.push(("points open / stick / slip", format!("{} / {} / {}", c.open, c.stick, c.slip)));
    }
    let card =
        |(label, text): &(&str, String)| format!("<div><b>{}</b><span>{label}</span></div>\n", escaped(text.trim()));
    format!("<div class=\"cards\">\n{}</div>\n", cards.iter().map(card).collect::<String>())
}

fn viewer(view: &View, units: &Units) -> String {
    let steps = view.frames.len();
    let slider = match view.frames.last() {
        Some(last) if steps > 1 => format!(
            "<label>Load step <input type=\"range\" id=\"frame\" min=\"0\" max=\"{0}\" value=\"{0}\"></label>\
             <output id=\"frame-name\">{1}</output>\n",
            steps - 1,
            escaped(&last.name)
        ),
        _ => String::new(),
    };
    let axis = |(name, color): (&str, &str)| {
        format!(
            "<line id=\"axis-{name}\" x1=\"40\" y1=\"40\" x2=\"40\" y2=\"40\" stroke=\"{color}\" stroke-width=\"2\"/>\
             <text id=\"label-{name}\">{name}</text>"
        )
    };
    let axes: String = [("x", "#d55e00"), ("y", "#009e73"), ("z", "#3a87d0")].map(axis).concat();
    let unit = if units.length.is_empty() { String::new() } else { format!(" Lengths in {}.", escaped(units.length)) };
    format!(
        "<h2 id=\"view\">Interactive view</h2>\n<p id=\"viewer-missing\" class=\"soft\" hidden></p>\n\
         <noscript><p class=\"soft\">{NO_VIEW}</p></noscript>\n<div id=\"viewer\">\n<div class=\"controls\">\n\
         <label>Field <select id=\"field\"></select></label>\n\
         <label id=\"show-choice\">Show <select id=\"show\"><option value=\"all\">everything</option>\
         <option value=\"through\">contact through the body</option>\
         <option value=\"contact\">contact surfaces only</option></select></label>\n\
         <label>Deformation <input type=\"range\" id=\"deformation\" min=\"0\" max=\"1000\"> \
         &times; <input type=\"number\" id=\"factor\" step=\"any\" aria-label=\"scale of the deformation\"></label>\n\
         <label><input type=\"checkbox\" id=\"lines\"> mesh</label>\n{slider}\
         <span><button type=\"button\" data-view=\"iso\">Above</button> <button type=\"button\" data-view=\"below\">Below\
         </button> <button type=\"button\" data-view=\"x\">X</button> <button type=\"button\" data-view=\"y\">Y</button> \
         <button type=\"button\" data-view=\"z\">Z</button> <button type=\"button\" data-view=\"fit\">Fit</button></span>\n\
         </div>\n<div class=\"stage\"><canvas id=\"canvas\" tabindex=\"0\" aria-label=\"The deformed body\"></canvas>\
         <svg viewBox=\"0 0 80 80\" aria-hidden=\"true\">{axes}</svg><div id=\"dot\" hidden></div>\
         <div class=\"key\"><span id=\"bar-title\"></span><div id=\"bar\"></div><div id=\"bar-note\"></div></div></div>\n\
         <div id=\"probe\"></div>\n</div>\n<p class=\"soft\">The deformation is multiplied by the factor shown, \
         so that surfaces in contact may seem to part or to overlap where they were pressed together; × 1 is true to \
         scale.{unit}</p>\n"
    )
}
