//! Checksums of the files of a result folder, as `sha256sum --check` reads them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;

use super::REPORT;
use super::contact_csv::CONTACT_CSV;
use super::level_file::LEVELS;
use super::step_file::{STATE, number_of};
use super::write::{BOUND, is_other_solution};
use crate::Error;
use crate::io::{checksum, folder};

/// The file of checksums.
pub const SUMS: &str = "SHA256SUMS";

/// Checksums by the names of their files.
pub(crate) type Sums = BTreeMap<String, String>;

/// What a run writes besides its pictures and the files of its steps.
const NAMES: [&str; 15] = [
    BOUND,
    "case.toml",
    CONTACT_CSV,
    "contact.pvd",
    "contact.vtu",
    "log.jsonl",
    "obstacles.vtu",
    "problem.npz",
    LEVELS,
    "result.pvd",
    "result.vtu",
    "solution.npz",
    STATE,
    "summary.json",
    REPORT,
];

/// The names in `folder` that are those of files a run writes, or of its pictures.
pub(crate) fn written(folder: &Path, pictures: &[String]) -> Result<Vec<String>, Error> {
    let mut names = folder::names(folder)?;
    names.retain(|name| {
        NAMES.contains(&&name[..]) || number_of(name).is_some() || is_other_solution(name) || pictures.contains(name)
    });
    Ok(names)
}

/// Checksums of files that have just been written.
///
/// # Errors
/// If one of them cannot be read.
pub(crate) fn of_files(folder: &Path, names: &[String]) -> Result<Sums, Error> {
    names.par_iter().map(|name| Ok((name.clone(), of_file(folder, name)?))).collect()
}

/// The checksum of one of them.
///
/// # Errors
/// If it cannot be read.
pub(crate) fn of_file(folder: &Path, name: &str) -> Result<String, Error> {
    let path = folder.join(name);
    checksum::of_file(&path).map_err(|error| {
        let what = format!("this file was written and cannot be read again ({error})");
        Error::new(path.display().to_string(), what, "check the folder and the disk")
    })
}

/// Writes the list.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(folder: &Path, sums: &Sums) -> Result<(), Error> {
    // Two blanks stand for a text in the format of sha256sum, which makes no difference outside Windows.
    let text: String = sums.iter().map(|(name, sum)| format!("{sum}  {name}\n")).collect();
    folder::write_text_durably(&folder.join(SUMS), &text)
}

/// Reads the list; none if there is none.
///
/// # Errors
/// If it is no list of checksums.
pub(crate) fn read(folder: &Path) -> Result<Option<Sums>, Error> {
    let path = folder.join(SUMS);
    if !path.exists() {
        return Ok(None);
    }
    let mut sums = Sums::new();
    for (number, line) in (1..).zip(folder::read_text(&path)?.lines()) {
        let entry = line.split_once("  ").filter(|(sum, name)| {
            let digits = sum.len() == 64 && sum.bytes().all(|b| b.is_ascii_hexdigit());
            digits && !name.is_empty() && !name.contains(['/', '\\'])
        });
        let (sum, name) = entry.ok_or_else(|| {
            let what = format!("line {number} is not a checksum, two blanks and the name of a file");
            Error::new(path.display().to_string(), what, "the file is damaged; solve the case again")
        })?;
        if sums.insert(name.to_string(), sum.to_ascii_lowercase()).is_some() {
            let what = format!("line {number} names {name:?} a second time");
            return Err(Error::new(path.display().to_string(), what, "the file is damaged; solve the case again"));
        }
    }
    Ok(Some(sums))
}

/// Whether the list can be read and has this file.
#[cfg(feature = "report")]
pub(crate) fn lists(folder: &Path, name: &str) -> bool {
    read(folder).is_ok_and(|sums| sums.is_some_and(|sums| sums.contains_key(name)))
}

/// Replaces the checksum of one file, which has been written again; a folder without a list gets none.
///
/// # Errors
/// If files cannot be read or written.
#[cfg(feature = "report")]
pub(crate) fn renew(folder: &Path, name: &str) -> Result<(), Error> {
    let Some(mut sums) = read(folder)? else { return Ok(()) };
    sums.extend(of_files(folder, &[name.to_string()])?);
    write(folder, &sums)
}

/// Files that are not what `sums` says: name, and what is wrong with it.
pub(crate) fn differing(folder: &Path, sums: &Sums) -> Vec<(String, String)> {
    let wrong = |(name, sum): (&String, &String)| match checksum::of_file(&folder.join(name)) {
        Ok(found) if found == *sum => None,
        Ok(_) => Some((name.clone(), "changed since it was written".to_string())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Some((name.clone(), "missing".to_string())),
        Err(error) => Some((name.clone(), format!("cannot be read ({error})"))),
    };
    sums.par_iter().filter_map(wrong).collect()
}

/// Files of a finished folder that are missing, changed, or unknown to its list of checksums though a run writes files
/// of that name.
///
/// # Errors
/// If there is no list, or it is none.
pub(crate) fn verify(folder: &Path, pictures: &[String]) -> Result<Vec<(String, String)>, Error> {
    let Some(sums) = read(folder)? else {
        let what = format!("there is no {SUMS} in it: an older version has written it, or it is not complete");
        return Err(Error::new(folder.display().to_string(), what, "solve the case again"));
    };
    let mut wrong: BTreeSet<(String, String)> = differing(folder, &sums).into_iter().collect();
    for name in written(folder, pictures)?.into_iter().filter(|name| !sums.contains_key(name)) {
        wrong.insert((name, format!("not listed in {SUMS}")));
    }
    for name in ["problem.npz", "solution.npz", "summary.json"].into_iter().filter(|name| !sums.contains_key(*name)) {
        wrong.insert((name.to_string(), format!("not listed in {SUMS}")));
    }
    Ok(wrong.into_iter().collect())
}
