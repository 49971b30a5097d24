//! What campaigns share: their arguments, and the command that they try.

use std::error::Error;
use std::path::PathBuf;

/// `[--seed S] [--count N]`: the seed, 1 if absent, and the number of trials, `count` if absent.
///
/// # Errors
/// If an argument is another one, or its value is missing or no number.
pub fn seed_and_count(mut count: usize) -> Result<(u64, usize), Box<dyn Error>> {
    let mut seed = 1;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().ok_or(format!("{argument} needs a value"))?;
        match argument.as_str() {
            "--seed" => seed = value.parse()?,
            "--count" => count = value.parse()?,
            _ => return Err(format!("{argument} is neither --seed nor --count").into()),
        }
    }
    Ok((seed, count))
}

/// The command that was built beside the program of the campaign.
///
/// # Errors
/// If the place of the program is not known.
pub fn command() -> Result<PathBuf, Box<dyn Error>> {
    Ok(std::env::current_exe()?.with_file_name("stiction"))
}
