//! A table's comparisons arranged as the paper arranges them: a row a run, our columns beside each published one.

use super::compare::{Comparison, Quantity, Verdict};
use super::study::TableReport;

/// A cell to show.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    pub text: String,
    /// Of the published columns, none.
    pub verdict: Option<Verdict>,
    pub note: String,
}

/// A group of columns: a quantity with its published column and ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    pub quantity: Quantity,
    /// Settings that have this quantity.
    pub settings: Vec<&'static str>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    pub groups: Vec<Group>,
    /// The run's name and its cells: for each group the published one, then one a setting.
    pub rows: Vec<(String, Vec<Cell>)>,
}

/// Arranges the comparisons of a table.
pub fn grid(table: &TableReport) -> Grid {
    let mut groups: Vec<Group> = Vec::new();
    let mut runs: Vec<&str> = Vec::new();
    for c in &table.comparisons {
        if !runs.contains(&c.run.as_str()) {
            runs.push(&c.run);
        }
        let at = groups.iter().position(|g| g.quantity == c.quantity).unwrap_or_else(|| {
            groups.push(Group { quantity: c.quantity, settings: Vec::new() });
            groups.len() - 1
        });
        if !groups[at].settings.contains(&c.setting) {
            groups[at].settings.push(c.setting);
        }
    }
    let rows = runs.iter().map(|run| (run.to_string(), cells(table, run, &groups))).collect();
    Grid { groups, rows }
}

fn cells(table: &TableReport, run: &str, groups: &[Group]) -> Vec<Cell> {
    let mut cells = Vec::new();
    for group in groups {
        let here = |c: &&Comparison| c.run == run && c.quantity == group.quantity;
        let published = table.comparisons.iter().find(here).and_then(|c| c.published);
        let show = |value: Option<f64>| value.map_or("–".to_string(), |v| group.quantity.show(v));
        cells.push(Cell { text: show(published), verdict: None, note: String::new() });
        for setting in &group.settings {
            let ours = table.comparisons.iter().filter(here).find(|c| c.setting == *setting);
            cells.push(match ours {
                Some(c) => Cell { text: show(c.ours), verdict: Some(c.verdict), note: note(c) },
                None => Cell { text: String::new(), verdict: None, note: String::new() },
            });
        }
    }
    cells
}

/// Deviation, band and whatever must be said.
fn note(c: &Comparison) -> String {
    let deviation = c.deviation().map(|d| format!("{:+.1} %", 100.0 * d));
    let known = if let Verdict::Known(reason) = c.verdict { reason.to_string() } else { String::new() };
    let parts = [deviation.unwrap_or_default(), c.band.words(), c.note.clone(), known];
    parts.into_iter().filter(|p| !p.is_empty()).collect::<Vec<_>>().join("; ")
}
