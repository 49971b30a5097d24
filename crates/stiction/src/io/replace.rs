//! Whole files or none: written under a temporary name and renamed once complete.
//!
//! After a power cut a renamed file may be empty or lost unless it was synced. Syncing takes milliseconds a file, so it is
//! done where a run commits itself: [`sync`] all files that another one is about to name, then [`replace_durably`] that
//! one. What names files that are to be replaced is taken away first, by [`remove_durably`].

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::Error;

/// Writes the file `path` by `fill`. A reader sees the old file or the complete new one; a failed or interrupted run
/// leaves no half file under this name.
pub(crate) fn replace(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), Error> {
    Pending::write(path, fill)?.commit()
}

/// The same for a file that names others, after [`sync`] of these: on return it and its name are on the disk.
pub(crate) fn replace_durably(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), Error> {
    let pending = Pending::write(path, fill)?;
    sync_file(&pending.part).map_err(|error| pending.failed(&error))?;
    pending.commit()?;
    sync_names(parent(path)).map_err(|error| failed(path, &error))
}

/// Has these files of `folder` and their names on the disk on return.
pub(crate) fn sync<S: AsRef<str> + Sync>(folder: &Path, names: &[S]) -> Result<(), Error> {
    // Together: the disk takes what is asked of it at the same time in one go.
    names.par_iter().try_for_each(|name| {
        let path = folder.join(name.as_ref());
        sync_file(&path).map_err(|error| failed(&path, &error))
    })?;
    sync_names(folder).map_err(|error| failed(folder, &error))
}

/// Removes a file, if it exists, before any change that follows reaches the disk.
pub(crate) fn remove_durably(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Ok(()) => sync_names(parent(path)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
    }
}

/// Removes the temporary files that killed runs have left in a folder in which no other run writes.
pub(crate) fn clear_parts(folder: &Path) {
    for name in super::folder::names(folder).unwrap_or_default() {
        if is_part(&name) {
            // In nobody's way if it stays.
            let _ = fs::remove_file(folder.join(name));
        }
    }
}

/// Whether [`Pending`] gives such names to files of results.
fn is_part(name: &str) -> bool {
    let split = || name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.');
    let ours = [".vtu", ".pvd", ".npz", ".json", ".jsonl", ".toml", ".png", ".html", ".stiction-probe", "SHA256SUMS"];
    split().is_some_and(|(file, process)| {
        ours.iter().any(|end| file.ends_with(end)) && !process.is_empty() && process.bytes().all(|b| b.is_ascii_digit())
    })
}

fn sync_file(path: &Path) -> io::Result<()> {
    // Some systems sync only what may be written to.
    supported(OpenOptions::new().write(true).open(path)?.sync_all())
}

/// The names in a folder.
#[cfg(unix)]
pub(crate) fn sync_names(folder: &Path) -> io::Result<()> {
    supported(File::open(folder)?.sync_all())
}

/// Elsewhere folders are not opened.
#[cfg(not(unix))]
pub(crate) fn sync_names(_: &Path) -> io::Result<()> {
    Ok(())
}

/// A file system that cannot sync is no reason to stop.
fn supported(synced: io::Result<()>) -> io::Result<()> {
    match synced {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        other => other,
    }
}

/// The folder that a file or folder lies in.
pub(crate) fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A complete file that has not got its name yet; it is removed unless it gets it.
#[derive(Debug)]
pub(crate) struct Pending {
    path: PathBuf,
    part: PathBuf,
}

impl Pending {
    /// Writes all of the file that is to become `path`.
    pub(crate) fn write(
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<Pending, Error> {
        let Some(name) = path.file_name() else {
            let what = "this is not the name of a file";
            return Err(Error::new(path.display().to_string(), what, "give a file name inside an existing folder"));
        };
        // In the same folder, since a rename across file systems is a copy and can be interrupted.
        let part = path.with_file_name(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
        // From here on what is left of a failure is removed.
        let pending = Pending { path: path.to_path_buf(), part };
        let written = File::create(&pending.part).and_then(|file| {
            let mut file = BufWriter::with_capacity(1 << 18, file);
            fill(&mut file)?;
            file.flush()
        });
        written.map_err(|error| pending.failed(&error))?;
        Ok(pending)
    }

    /// Gives the file its name; what had it before is gone.
    pub(crate) fn commit(self) -> Result<(), Error> {
        fs::rename(&self.part, &self.path).map_err(|error| self.failed(&error))
    }

    fn failed(&self, error: &io::Error) -> Error {
        failed(&self.path, error)
    }
}

fn failed(path: &Path, error: &io::Error) -> Error {
    let what = format!("cannot write this file ({error})");
    Error::new(path.display().to_string(), what, remedy(error.kind()))
}

impl Drop for Pending {
    fn drop(&mut self) {
        // After a rename there is nothing of this name, and the error before it is the one to report.
        let _ = fs::remove_file(&self.part);
    }
}

fn remedy(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::NotFound | ErrorKind::NotADirectory => "create its folder first",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "choose a folder that you may write to",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "make room on the disk or choose a folder elsewhere"
        }
        ErrorKind::IsADirectory => "a folder of this name is in the way; move it or choose another name",
        _ => "check the folder and the disk",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_else() {
        let folder = std::env::temp_dir().join(format!("stiction-replace-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.txt");
        replace(&path, |f| f.write_all(b"old")).unwrap();
        let full = |f: &mut BufWriter<File>| {
            f.write_all(b"half")?;
            Err(io::Error::from(ErrorKind::StorageFull))
        };
        let error = replace(&path, full).unwrap_err().to_string();
        assert!(error.contains("a.txt") && error.contains("make room"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        // Written in full, but given up before it has its name.
        drop(Pending::write(&path, |f| f.write_all(b"new")).unwrap());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        let error = replace(&folder.join("missing/a.txt"), |_| Ok(())).unwrap_err().to_string();
        assert!(error.contains("create its folder"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
