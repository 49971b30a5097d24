//! `report.html`, from the files of a result folder alone.

use std::path::Path;

use super::REPORT;
use super::html::{Picture, html};
use super::view::view;
use super::{summary, sums};
use crate::Error;
use crate::io::folder;
use crate::io::units::Units;
use crate::mesh::Mesh;
use crate::run::pose::memory::report_fits;

/// Writes the report of a result folder anew from its other files and returns its size in bytes.
///
/// # Errors
/// If a file is missing or damaged, or the report cannot be written.
pub fn write_report(folder: &Path) -> Result<usize, Error> {
    write_report_on(folder, None)
}

/// The same where `mesh` is at hand already, which then need not be read from the files of the result.
///
/// # Errors
/// As [`write_report`].
pub fn write_report_on(folder: &Path, mesh: Option<&Mesh>) -> Result<usize, Error> {
    let path = folder.join("summary.json");
    if !path.exists() {
        let what = "there is no summary.json in it";
        let remedy = "name a folder that `stiction solve` has filled";
        return Err(Error::new(folder.display().to_string(), what, remedy));
    }
    if folder.join("result.pvtu").exists() {
        let what = "it is the result of a run on several ranks, of which no report is written";
        let remedy = "open result.pvtu in ParaView, or solve the case by `stiction solve`";
        return Err(Error::new(folder.display().to_string(), what, remedy));
    }
    report_fits(folder, mesh)?;
    let summary: super::Summary = summary::read(&path)?;
    // The case of a run may have been given another way than as a file.
    let case = folder.join("case.toml");
    let case_text = if case.exists() { folder::read_text(&case)? } else { String::new() };
    // A name is one of a file in the folder, whatever the summary says.
    let names = summary.pictures.iter().filter(|name| !name.contains(['/', '\\']));
    let pictures = names
        .map(|name| Ok(Picture { name: name.clone(), png: folder::read_bytes(&folder.join(name))? }))
        .collect::<Result<Vec<_>, Error>>()?;
    let units = Units::of(summary.units.as_deref());
    let view = view(folder, mesh, &summary, units)?;
    let text = html(&summary, &case_text, &pictures, &view);
    folder::write_text(&folder.join(REPORT), &text)?;
    let renewed = sums::renew(folder, REPORT);
    if renewed.is_err() && !sums::lists(folder, REPORT) {
        // No file may be there that the list does not know.
        folder::remove(&folder.join(REPORT))?;
    }
    renewed.map(|()| text.len())
}
