//! Whole files or none: written under a temporary name and renamed once complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::Error;

/// Writes the file `path` by `fill`. A reader sees the old file or the complete new one; a failed or interrupted run
/// leaves no half file under this name.
pub(crate) fn replace(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), Error> {
    Pending::write(path, fill)?.commit()
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
        let what = format!("cannot write this file ({error})");
        Error::new(self.path.display().to_string(), what, remedy(error.kind()))
    }
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
