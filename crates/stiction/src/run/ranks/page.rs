//! `report.html` of a result folder, whoever wrote it: one machine, or several ranks their pieces.

use std::path::Path;

use crate::Error;
use crate::io::pvtu::named_pieces;
use crate::io::units::Units;
use crate::run::pose::memory::report_of_pieces_fits;
use crate::run::results::page::{case_in, summary_in, write_page, write_report_on};
use crate::run::results::view::view_of_pieces;
use crate::run::results::write::PVTU;
use crate::run::results::{Summary, summary};

/// Writes the report of a result folder anew from its other files and returns its size in bytes. Of several ranks it joins the pieces,
/// which takes the memory of one machine for the whole, and shows the last increment.
///
/// # Errors
/// If a file is missing or damaged, or the report cannot be written.
pub fn write_report(folder: &Path) -> Result<usize, Error> {
    let collections = PVTU.map(|name| folder.join(name));
    if !collections[0].exists() {
        return write_report_on(folder, None);
    }
    let path = summary_in(folder)?;
    let pieces = [named_pieces(&collections[0])?, named_pieces(&collections[1])?];
    report_of_pieces_fits(&pieces[0])?;
    let summary: Summary = summary::read(&path)?;
    let nodes = summary.ranks.as_ref().map_or(0, |of| of.nodes);
    let view = view_of_pieces(&pieces, nodes, !summary.steps.is_empty(), Units::of(summary.units.as_deref()));
    let view = view.map_err(|error| error.at(&folder.display().to_string()))?;
    write_page(folder, &summary, &case_in(folder)?, &view)
}
