//! The folder of a study.

use std::path::Path;

use super::study::Study;
use super::{report_csv, report_html, report_md};
use stiction::Error;
use stiction::io::folder;

/// Writes `report.html`, `report.md`, a CSV a table, an SVG and a PNG a figure into `folder`, which is created, and
/// returns their names.
///
/// Each file is whole or absent, and `report.html` comes last: a folder that has one is complete.
///
/// # Errors
/// If a file cannot be written.
pub fn write_study(study: &Study, folder: &Path) -> Result<Vec<String>, Error> {
    folder::create(folder)?;
    folder::remove(&folder.join("report.html"))?;
    let mut files = Vec::new();
    for table in &study.tables {
        let name = format!("table{:02}.csv", table.number);
        folder::write_text(&folder.join(&name), &report_csv::csv(table))?;
        files.push(name);
    }
    for figure in &study.figures {
        let name = format!("figure{:02}", figure.number);
        let [svg, png] = ["svg", "png"].map(|kind| format!("{name}.{kind}"));
        figure.drawing.write_svg(&folder.join(&svg))?;
        figure.drawing.write_png(&folder.join(&png))?;
        files.extend([svg, png]);
    }
    folder::write_text(&folder.join("report.md"), &report_md::markdown(study))?;
    folder::write_text(&folder.join("report.html"), &report_html::html(study))?;
    files.extend(["report.md", "report.html"].map(String::from));
    Ok(files)
}
