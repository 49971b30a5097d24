//! The report as one HTML file: figures inside, nothing fetched.

use super::choices;
use super::compare::Verdict;
use super::grid::{Cell, Grid, grid};
use super::published::SOURCE;
use super::study::{Study, TableReport, Tally};
use stiction::io::text::escaped;

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, 'DejaVu Sans', Verdana, sans-serif; color: #222; max-width: 80rem; margin: 0 auto; padding: 1.5rem; }
h1 { font-size: 1.7rem; line-height: 1.25; } h2 { font-size: 1.25rem; margin-top: 2.6rem; border-top: 1px solid #ddd; padding-top: 1.2rem; }
.source, .caption, .small { color: #555; font-size: .9rem; }
nav a { margin-right: .7rem; white-space: nowrap; }
.wide { overflow-x: auto; }
table { border-collapse: separate; border-spacing: 0; font-size: .88rem; font-variant-numeric: tabular-nums; margin: .8rem 0; }
th, td { padding: .22rem .5rem; border-bottom: 1px solid #e4e4e4; text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: #fff; }
th[colspan] { text-align: center; border-left: 2px solid #bbb; }
thead th { font-weight: 600; } thead tr:last-child th { border-bottom: 2px solid #888; }
td.paper, th.paper { background: #f4f4f4; border-left: 2px solid #bbb; }
td.within { background: #e2f2e4; } td.outside { background: #f7d4d0; font-weight: 600; } td.known { background: #fbeac6; }
.key span { padding: .1rem .5rem; margin-right: .6rem; }
.within { background: #e2f2e4; } .outside { background: #f7d4d0; } .known { background: #fbeac6; }
figure { margin: 1rem 0; } figure svg { width: 100%; height: auto; max-width: 60rem; }
li { margin: .25rem 0; }
";

/// The text of `report.html`.
pub fn html(study: &Study) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>The source paper beside stiction</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>The source paper's tables and figures beside our numbers</h1>\n\
         <p class=\"source\">{}.</p>\n",
        escaped(SOURCE)
    );
    text += &format!("<p><strong>{}.</strong>", study.tally().words());
    if study.quick {
        text += " This is the quick subset of the tables.";
    }
    text += &format!(" Made by stiction {} in {:.0} s.", env!("CARGO_PKG_VERSION"), study.seconds);
    text += &format!("</p>\n<p class=\"small\">{}", escaped(choices::READING));
    text += "</p>\n<p class=\"key\"><span class=\"within\">within its band</span><span class=\"outside\">outside</span>\
             <span class=\"known\">outside, documented</span> no colour: reported only. Deviation, band and reason are \
             shown when the pointer rests on a number, and stand in the CSV files.</p>\n<nav>";
    study.tables.iter().for_each(|t| text += &format!("<a href=\"#table{0}\">Table {0}</a> ", t.number));
    study.figures.iter().for_each(|f| text += &format!("<a href=\"#figure{0}\">Figure {0}</a> ", f.number));
    text += "</nav>\n<h2>Fitted choices</h2>\n<p>What the paper leaves open was chosen after seeing its numbers:</p>\n<ul>\n";
    for (name, words) in choices::FITTED {
        text += &format!("<li><strong>FITTED: {}.</strong> {}</li>\n", escaped(name), escaped(words));
    }
    text += "</ul>\n";
    study.tables.iter().for_each(|table| text += &section(table));
    for figure in &study.figures {
        let (n, title) = (figure.number, escaped(&figure.title));
        let caption = escaped(&figure.caption);
        text += &format!(
            "<h2 id=\"figure{n}\">Figure {n}: {title}</h2>\n<figure>\n{}<figcaption class=\"caption\">{caption}\
             </figcaption>\n</figure>\n",
            figure.drawing.svg()
        );
    }
    text + "</body>\n</html>\n"
}

fn section(table: &TableReport) -> String {
    let n = table.number;
    let mut text = format!("<h2 id=\"table{n}\">Table {n}: {}</h2>\n<ul class=\"small\">\n", escaped(&table.caption));
    for (name, words) in &table.settings {
        text += &format!("<li><em>{}</em>: {}</li>\n", escaped(name), escaped(words));
    }
    text += &format!("</ul>\n<div class=\"wide\">\n{}</div>\n", rows(&grid(table)));
    text += &format!("<p>{}.</p>\n<ul class=\"small\">\n", Tally::of(&table.comparisons).words());
    for c in table.comparisons.iter().filter(|c| matches!(c.verdict, Verdict::Outside | Verdict::Known(_))) {
        let (class, reason) = match c.verdict {
            Verdict::Known(reason) => ("known", reason),
            _ => ("outside", "no reason is known"),
        };
        let show = |v: Option<f64>| v.map_or("–".into(), |v| c.quantity.show(v));
        text += &format!(
            "<li><span class=\"{class}\">{} {}</span> at {} ({}), published {}, band {}: {}</li>\n",
            c.quantity.name(),
            show(c.ours),
            escaped(&c.run),
            escaped(c.setting),
            show(c.published),
            escaped(&c.band.words()),
            escaped(reason)
        );
    }
    text + "</ul>\n"
}

fn rows(grid: &Grid) -> String {
    let mut quantities = "<tr><th></th>".to_string();
    let mut settings = "<tr><th>run</th>".to_string();
    for group in &grid.groups {
        let span = 1 + group.settings.len();
        quantities += &format!("<th colspan=\"{span}\">{}</th>", group.quantity.name());
        settings += "<th class=\"paper\">paper</th>";
        group.settings.iter().for_each(|s| settings += &format!("<th>{}</th>", escaped(s)));
    }
    let mut text = format!("<table>\n<thead>\n{quantities}</tr>\n{settings}</tr>\n</thead>\n<tbody>\n");
    for (run, cells) in &grid.rows {
        text += &format!("<tr><td>{}</td>", escaped(run));
        cells.iter().for_each(|cell| text += &data(cell));
        text += "</tr>\n";
    }
    text + "</tbody>\n</table>\n"
}

fn data(cell: &Cell) -> String {
    let class = match cell.verdict {
        None if cell.text.is_empty() => "",
        None => "paper",
        Some(Verdict::Within) => "within",
        Some(Verdict::Outside) => "outside",
        Some(Verdict::Known(_)) => "known",
        Some(Verdict::Unjudged) => "",
    };
    let title = if cell.note.is_empty() { String::new() } else { format!(" title=\"{}\"", escaped(&cell.note)) };
    format!("<td class=\"{class}\"{title}>{}</td>", escaped(&cell.text))
}
