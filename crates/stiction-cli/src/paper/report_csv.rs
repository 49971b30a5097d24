//! One CSV a table: all comparisons, a line each.

use super::compare::Verdict;
use super::study::TableReport;

/// The text of the file.
pub fn csv(table: &TableReport) -> String {
    let mut text = "run,quantity,setting,published,ours,deviation,band,verdict,note\n".to_string();
    for c in &table.comparisons {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v}"));
        let reason = if let Verdict::Known(reason) = c.verdict { reason } else { "" };
        let note = [c.note.as_str(), reason].into_iter().filter(|n| !n.is_empty()).collect::<Vec<_>>().join("; ");
        let deviation = c.deviation().map_or(String::new(), |d| format!("{d:.4}"));
        let cells = [
            c.run.clone(),
            c.quantity.name().to_string(),
            c.setting.to_string(),
            number(c.published),
            number(c.ours),
            deviation,
            c.band.words(),
            c.verdict.name().to_string(),
            note,
        ];
        text += &(cells.map(|cell| quoted(&cell)).join(",") + "\n");
    }
    text
}

/// As RFC 4180 has it: quotes where they are needed.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_string() }
}
