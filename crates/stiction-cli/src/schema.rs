//! `stiction schema`.

use stiction::Error;
use stiction::io::case;

use crate::output;

/// Print the JSON schema of case files, for editors that complete and check them
#[derive(clap::Args)]
pub struct Arguments {}

pub fn run(_: &Arguments) -> Result<u8, Error> {
    output::data(&format!("{:#}\n", case::schema()));
    Ok(0)
}
