//! `report.html`, from the files of a result folder alone.

use std::path::Path;

use super::html::{Picture, View, html};
use super::view::{view, view_of_pieces};
use super::write::PVTU;
use super::{REPORT, Summary, summary, sums};
use crate::Error;
use crate::io::folder;
use crate::io::pvtu::named_pieces;
use crate::io::units::Units;
use crate::mesh::Mesh;
use crate::run::pose::memory::{report_fits, report_of_pieces_fits};
use crate::run::ranks::RankedSummary;

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
    let (summary, view) = match folder.join(PVTU[0]).exists() {
        true => of_ranks(folder, &path)?,
        false => {
            report_fits(folder, mesh)?;
            let summary: Summary = summary::read(&path)?;
            let view = view(folder, mesh, &summary, Units::of(summary.units.as_deref()))?;
            (summary, view)
        }
    };
    // The case of a run may have been given another way than as a file.
    let case = folder.join("case.toml");
    // Ranks write none: what is there is of an earlier run.
    let has_case = case.exists() && !folder.join(PVTU[0]).exists();
    let case_text = if has_case { folder::read_text(&case)? } else { String::new() };
    // A name is one of a file in the folder, whatever the summary says.
    let names = summary.pictures.iter().filter(|name| !name.contains(['/', '\\']));
    let pictures = names
        .map(|name| Ok(Picture { name: name.clone(), png: folder::read_bytes(&folder.join(name))? }))
        .collect::<Result<Vec<_>, Error>>()?;
    let text = html(&summary, &case_text, &pictures, &view);
    folder::write_text(&folder.join(REPORT), &text)?;
    let renewed = sums::renew(folder, REPORT);
    if renewed.is_err() && !sums::lists(folder, REPORT) {
        // No file may be there that the list does not know.
        folder::remove(&folder.join(REPORT))?;
    }
    renewed.map(|()| text.len())
}

/// What several ranks have written.
fn of_ranks(folder: &Path, summary: &Path) -> Result<(Summary, View), Error> {
    let pieces = [named_pieces(&folder.join(PVTU[0]))?, named_pieces(&folder.join(PVTU[1]))?];
    report_of_pieces_fits(&pieces[0])?;
    let summary: RankedSummary = summary::read(summary)?;
    let view = view_of_pieces(&pieces, summary.nodes, Units::of(summary.units.as_deref()))?;
    Ok((summary.into(), view))
}
