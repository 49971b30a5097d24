//! `stiction report`.

use std::path::PathBuf;

use stiction::Error;
#[cfg(feature = "report")]
use stiction::run;

#[cfg(feature = "report")]
use crate::{hold, output};

/// Write report.html of a result folder again, from its other files
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that `stiction solve` wrote
    folder: PathBuf,
}

/// Says that this program writes none.
#[cfg(not(feature = "report"))]
pub fn run(_: &Arguments) -> Result<u8, Error> {
    Err(crate::not_built("report.html", "report"))
}

/// Writes the report and says where it is.
#[cfg(feature = "report")]
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    // A folder without results is not taken, and not created, but refused by what follows.
    if arguments.folder.join("summary.json").exists() {
        hold::folder(&arguments.folder)?;
    }
    let bytes = run::write_report(&arguments.folder)?;
    let path = arguments.folder.join(run::REPORT);
    output::out(&format!("{} ({:.1} MB)\n", path.display(), bytes as f64 / 1e6));
    Ok(0)
}
