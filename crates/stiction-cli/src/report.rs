//! `stiction report`.

use std::path::PathBuf;

use stiction::Error;
use stiction::run;

use crate::output;

/// Write report.html of a result folder again, from its other files
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that `stiction solve` wrote
    folder: PathBuf,
}

/// Writes the report and says where it is.
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    let bytes = run::write_report(&arguments.folder)?;
    let path = arguments.folder.join(run::REPORT);
    output::out(&format!("{} ({:.1} MB)\n", path.display(), bytes as f64 / 1e6));
    Ok(0)
}
