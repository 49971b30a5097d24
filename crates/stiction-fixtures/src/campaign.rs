//! The arguments that campaigns share.

use std::error::Error;
use std::path::PathBuf;

/// What a campaign is told.
pub struct Arguments {
    pub seed: u64,
    pub count: usize,
    /// The command that is tried: the one beside the program of the campaign if none is named.
    pub command: PathBuf,
}

impl Arguments {
    /// `[--seed S] [--count N] [--command PATH]`: seed 1 and `count` if absent.
    ///
    /// # Errors
    /// If an argument is another one, or its value is missing or no number.
    pub fn read(count: usize) -> Result<Arguments, Box<dyn Error>> {
        let command = std::env::current_exe()?.with_file_name("stiction");
        let mut read = Arguments { seed: 1, count, command };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let value = arguments.next().ok_or(format!("{argument} needs a value"))?;
            match argument.as_str() {
                "--seed" => read.seed = value.parse()?,
                "--count" => read.count = value.parse()?,
                "--command" => read.command = value.into(),
                _ => return Err(format!("{argument} is none of --seed, --count, --command").into()),
            }
        }
        Ok(read)
    }
}
