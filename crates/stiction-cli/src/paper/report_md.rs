//! The report as Markdown.

use super::choices;
use super::compare::Verdict;
use super::grid::{Cell, Grid, grid};
use super::published::SOURCE;
use super::study::{Study, TableReport, Tally};

/// The text of `report.md`; figures lie beside it.
pub fn markdown(study: &Study) -> String {
    let mut text = format!("# The source paper's tables and figures beside our numbers\n\n{SOURCE}.\n\n");
    let (tally, version) = (study.tally().words(), env!("CARGO_PKG_VERSION"));
    text += &format!("{tally}. Made by stiction {version} in {:.0} s.\n\n", study.seconds);
    if study.quick {
        text += "This is the quick subset of the tables.\n\n";
    }
    text += &format!("{}\n\n", choices::READING);
    text += "✓ within its band, ✗ outside, (✗) outside as documented, no mark: reported only. Bands, deviations and \
             reasons stand below each table; the CSV files have all of them.\n\n## Fitted choices\n\n";
    for (name, words) in choices::FITTED {
        text += &format!("- **FITTED: {name}.** {words}\n");
    }
    for table in &study.tables {
        text += &section(table);
    }
    for figure in &study.figures {
        let (n, title) = (figure.number, &figure.title);
        text += &format!("\n## Figure {n}: {title}\n\n![{title}](figure{n:02}.png)\n\n{}\n", figure.caption);
    }
    text
}

fn section(table: &TableReport) -> String {
    let mut text = format!("\n## Table {}: {}\n\n", table.number, table.caption);
    for (name, words) in &table.settings {
        text += &format!("- *{name}*: {words}\n");
    }
    text += &format!("\n{}\n{}.\n", rows(&grid(table)), Tally::of(&table.comparisons).words());
    let judged = table.comparisons.iter().filter(|c| matches!(c.verdict, Verdict::Outside | Verdict::Known(_)));
    for c in judged {
        let name = c.quantity.name();
        let show = |v: Option<f64>| v.map_or("–".into(), |v| c.quantity.show(v));
        let reason = if let Verdict::Known(reason) = c.verdict { reason } else { "no reason is known" };
        let (ours, published) = (show(c.ours), show(c.published));
        text += &format!(
            "- outside: {}, {name} ({}): {ours}, published {published}, band {}: {reason}\n",
            c.run,
            c.setting,
            c.band.words()
        );
    }
    text
}

fn rows(grid: &Grid) -> String {
    let mut head = "| run |".to_string();
    let mut line = "|---|".to_string();
    for group in &grid.groups {
        for setting in std::iter::once("paper").chain(group.settings.iter().copied()) {
            head += &format!(" {} {setting} |", group.quantity.name());
            line += "---:|";
        }
    }
    let mut text = format!("{head}\n{line}\n");
    for (run, cells) in &grid.rows {
        let cells: Vec<String> = cells.iter().map(marked).collect();
        text += &format!("| {run} | {} |\n", cells.join(" | "));
    }
    text
}

fn marked(cell: &Cell) -> String {
    match cell.verdict {
        Some(Verdict::Within) => format!("{} ✓", cell.text),
        Some(Verdict::Outside) => format!("{} ✗", cell.text),
        Some(Verdict::Known(_)) => format!("{} (✗)", cell.text),
        Some(Verdict::Unjudged) | None => cell.text.clone(),
    }
}
