//! `report.html`, from the files of a result folder alone.

use std::path::{Path, PathBuf};

use super::html::{Picture, View, html};
use super::view::view;
use super::{REPORT, Summary, summary, sums};
use crate::Error;
use crate::io::folder;
use crate::io::units::Units;
use crate::mesh::Mesh;
use crate::run::pose::memory::report_fits;

/// Writes the report of a result folder of one machine anew from its other files and returns its size in bytes. `mesh` is that of
/// the result where it is at hand already; it then need not be read.
///
/// # Errors
/// If a file is missing or damaged, or the report cannot be written.
pub fn write_report_on(folder: &Path, mesh: Option<&Mesh>) -> Result<usize, Error> {
    let path = summary_in(folder)?;
    report_fits(folder, mesh)?;
    let summary: Summary = summary::read(&path)?;
    let view = view(folder, mesh, &summary, Units::of(summary.units.as_deref()))?;
    write_page(folder, &summary, &case_in(folder)?, &view)
}

/// The case of the results in a folder; empty where it was given another way than as a file.
pub(crate) fn case_in(folder: &Path) -> Result<String, Error> {
    let case = folder.join("case.toml");
    if case.exists() { folder::read_text(&case) } else { Ok(String::new()) }
}

/// The summary that a folder needs to be one of results.
pub(crate) fn summary_in(folder: &Path) -> Result<PathBuf, Error> {
    let path = folder.join("summary.json");
    if path.exists() {
        return Ok(path);
    }
    let what = "there is no summary.json in it";
    let remedy = "name a folder that `stiction solve` has filled";
    Err(Error::new(folder.display().to_string(), what, remedy))
}

/// The page, with the pictures that the folder holds.
pub(crate) fn write_page(folder: &Path, summary: &Summary, case_text: &str, view: &View) -> Result<usize, Error> {
    // A name is one of a file in the folder, whatever the summary says.
    let names = summary.pictures.iter().filter(|name| !name.contains(['/', '\\']));
    let pictures = names
        .map(|name| Ok(Picture { name: name.clone(), png: folder::read_bytes(&folder.join(name))? }))
        .collect::<Result<Vec<_>, Error>>()?;
    let text = html(summary, case_text, &pictures, view);
    folder::write_text(&folder.join(REPORT), &text)?;
    let renewed = sums::renew(folder, REPORT);
    if renewed.is_err() && !sums::lists(folder, REPORT) {
        // No file may be there that the list does not know.
        folder::remove(&folder.join(REPORT))?;
    }
    renewed.map(|()| text.len())
}
