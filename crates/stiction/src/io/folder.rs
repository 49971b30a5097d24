//! Folders of results.

use std::fs;
use std::io::Write as _;
use std::path::Path;

pub(crate) use super::replace::sync;
use super::replace::{parent, remove_durably, replace, replace_durably, sync_names};
use crate::Error;

/// Whether files can be written to `folder`, which need not exist yet: tried out and undone.
///
/// # Errors
/// If they cannot.
pub fn writable(folder: &Path) -> Result<(), Error> {
    // The folders that do not exist yet, the innermost first.
    let missing: Vec<&Path> = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists()).collect();
    let tried = create(folder).and_then(|()| {
        let probe = folder.join(".stiction-probe");
        replace(&probe, |file| file.write_all(b"?"))
            .and_then(|()| fs::remove_file(&probe).map_err(|error| refused(folder, &error)))
    });
    missing.iter().for_each(|created| {
        let _ = fs::remove_dir(created); // fails where nothing had been created, or others now use it
    });
    tried
}

/// Creates `folder` with all folders above it.
///
/// # Errors
/// If the system refuses it.
pub fn create(folder: &Path) -> Result<(), Error> {
    let missing: Vec<&Path> = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists()).collect();
    fs::create_dir_all(folder).map_err(|error| refused(folder, &error))?;
    // Not every folder above may be read.
    missing.iter().rev().for_each(|created| drop(sync_names(parent(created))));
    Ok(())
}

/// Writes a text file as a whole, which is on the disk on return.
///
/// # Errors
/// If the system refuses it.
pub fn write_text_durably(path: &Path, text: &str) -> Result<(), Error> {
    replace_durably(path, |file| file.write_all(text.as_bytes()))
}

/// Writes a text file as a whole.
///
/// # Errors
/// If the system refuses it.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    replace(path, |file| file.write_all(text.as_bytes()))
}

/// Reads a text file.
///
/// # Errors
/// If there is no such file or it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|error| {
        let what = format!("this file cannot be read ({error})");
        Error::new(path.display().to_string(), what, "check the name of the folder and its permissions")
    })
}

/// Reads a file as it is.
///
/// # Errors
/// If there is no such file or it cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    fs::read(path).map_err(|error| {
        let what = format!("this file cannot be read ({error})");
        Error::new(path.display().to_string(), what, "solve the case again")
    })
}

/// Removes a file that need not exist.
///
/// # Errors
/// If the system refuses it.
pub fn remove(path: &Path) -> Result<(), Error> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(stays(path, &error)),
        _ => Ok(()),
    }
}

/// Removes a file that names others, and need not exist, before these may be replaced.
///
/// # Errors
/// If the system refuses it.
pub fn withdraw(path: &Path) -> Result<(), Error> {
    remove_durably(path).map_err(|error| stays(path, &error))
}

fn stays(path: &Path, error: &std::io::Error) -> Error {
    let what = format!("this file cannot be removed ({error})");
    Error::new(path.display().to_string(), what, "check the permissions of its folder")
}

/// Removes a folder if there is nothing in it.
pub fn remove_empty(folder: &Path) {
    let _ = fs::remove_dir(folder); // fails where something is in it
}

/// The names of what lies in a folder, in no order; names that are not UTF-8 are left out.
///
/// # Errors
/// If there is no such folder or it cannot be read.
pub fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = fs::read_dir(folder).map_err(|error| refused(folder, &error))?;
    Ok(entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect())
}

/// Whether both paths lead to one file that exists.
pub fn same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

pub(crate) fn refused(folder: &Path, error: &std::io::Error) -> Error {
    let what = format!("results cannot be written to this folder ({error})");
    Error::new(folder.display().to_string(), what, "choose another folder with -o DIR")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trying_a_folder_leaves_nothing_behind() {
        let root = std::env::temp_dir().join(format!("stiction-folder-{}", std::process::id()));
        create(&root).unwrap();
        writable(&root.join("a/b")).unwrap();
        writable(&root).unwrap();
        assert_eq!(fs::read_dir(&root).unwrap().count(), 0);
        write_text(&root.join("file"), "x").unwrap();
        assert!(writable(&root.join("file/inside")).is_err());
        assert!(writable(&root.join("file")).is_err());
        assert_eq!(fs::read_dir(&root).unwrap().count(), 1);
        fs::remove_dir_all(&root).unwrap();
    }
}
