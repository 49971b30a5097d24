//! One run at a time in a result folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::replace::clear_parts;
use super::{folder, machine};
use crate::Error;

/// Its file in the folder. The system locks it and frees it with the process, however that ends; what it says is for
/// people.
const NAME: &str = ".stiction-lock";

/// The right to write to a folder. Dropped, it leaves nothing behind, not even the folder if that was created for it and
/// is empty.
#[derive(Debug)]
pub struct Lock {
    file: Option<File>,
    path: PathBuf,
    /// Folders created for it, the innermost first.
    created: Vec<PathBuf>,
}

impl Lock {
    /// Takes `folder`, which need not exist, and removes the half files of runs that were killed in it. What there is to
    /// say about it comes second: a run before was killed, or the file system knows no locks.
    ///
    /// # Errors
    /// If another run has it, or it cannot be written to.
    pub fn take(folder: &Path) -> Result<(Lock, Option<String>), Error> {
        let missing = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists());
        let mut lock = Lock { file: None, path: folder.join(NAME), created: missing.map(Path::to_path_buf).collect() };
        folder::create(folder)?;
        // An earlier owner may remove the file between our opening and locking it: then there is a new one to lock.
        loop {
            let mut file = lock.open(folder)?;
            let note = match file.try_lock() {
                Ok(()) if !names(&lock.path, &file) => continue,
                Ok(()) => None,
                Err(TryLockError::WouldBlock) => return Err(taken(folder, &owner(&mut file))),
                Err(TryLockError::Error(error)) => Some(format!(
                    "{}: this file system has no locks ({error}); see to it that no other run writes to this folder",
                    folder.display()
                )),
            };
            let before = owner(&mut file);
            let left = || {
                let folder = folder.display();
                format!("{folder}: a run before this one ({before}) was killed; its lock file is taken over")
            };
            let note = note.or_else(|| (!before.is_empty()).then(left));
            let write = |file: &mut File| {
                file.set_len(0)?;
                io::Seek::rewind(file)?;
                file.write_all(this_run().as_bytes())
            };
            let written = write(&mut file);
            lock.file = Some(file);
            written.map_err(|error| folder::refused(folder, &error))?;
            clear_parts(folder);
            return Ok((lock, note));
        }
    }

    fn open(&self, folder: &Path) -> Result<File, Error> {
        let fail = |what: String| {
            let remedy = "remove it if no other run writes to this folder, or choose another folder with -o DIR";
            Error::new(self.path.display().to_string(), what, remedy)
        };
        let found = fs::symlink_metadata(&self.path).ok();
        if found.as_ref().is_some_and(|found| !found.is_file()) {
            return Err(fail("the lock file of this folder is no regular file".into()));
        }
        let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&self.path);
        opened.map_err(|error| match found {
            Some(_) => fail(format!("the lock file of this folder cannot be opened ({error})")),
            None => folder::refused(folder, &error),
        })
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            // The name goes while the lock is held: whoever opened the file before then sees that it has no name.
            let _ = fs::remove_file(&self.path);
            drop(file);
        }
        self.created.iter().for_each(|folder| folder::remove_empty(folder));
    }
}

fn taken(folder: &Path, owner: &str) -> Error {
    let owner = if owner.is_empty() { String::new() } else { format!(" ({owner})") };
    let what = format!("another run{owner} writes to this folder");
    let remedy = "wait until it has ended or stop it, or choose another folder with -o DIR";
    Error::new(folder.display().to_string(), what, remedy)
}

/// Whether `path` is still a name of this open file.
#[cfg(unix)]
fn names(path: &Path, file: &File) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let identity = |found: fs::Metadata| (found.dev(), found.ino());
    matches!((fs::metadata(path).map(identity), file.metadata().map(identity)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(not(unix))]
fn names(path: &Path, _: &File) -> bool {
    path.exists()
}

/// What the file says about its owner; empty where it says nothing or cannot be read.
fn owner(file: &mut File) -> String {
    let mut bytes = Vec::new();
    let _ = file.take(300).read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes);
    text.lines().next().unwrap_or_default().chars().filter(|c| !c.is_control()).collect()
}

fn this_run() -> String {
    let host = machine::host_name().map_or(String::new(), |name| format!(" on {name}"));
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    format!("process {}{host}, started {}\n", std::process::id(), utc(seconds))
}

/// A time in seconds since 1970 by the calendar.
fn utc(seconds: u64) -> String {
    let leap = |year: u64| u64::from(year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400)));
    let (mut day, mut year, mut month) = (seconds / 86_400, 1970, 0);
    while day >= 365 + leap(year) {
        day -= 365 + leap(year);
        year += 1;
    }
    let months = [31, 28 + leap(year), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    while day >= months[month] {
        day -= months[month];
        month += 1;
    }
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    format!("{year}-{:02}-{:02} {hour:02}:{minute:02}:{second:02} UTC", month + 1, day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_taken_once_and_left_as_it_was() {
        let root = std::env::temp_dir().join(format!("stiction-lock-{}", std::process::id()));
        let folder = root.join("a/b");
        let (lock, note) = Lock::take(&folder).unwrap();
        assert!(note.is_none(), "{note:?}");
        let error = Lock::take(&folder).unwrap_err().to_string();
        let pid = std::process::id();
        assert!(error.contains(&format!("process {pid}")) && error.contains("-o DIR"), "{error}");
        drop(lock);
        assert!(!root.exists());

        fs::create_dir_all(&folder).unwrap();
        let own =
            [".result.vtu.17.part", ".SHA256SUMS.17.part", ".problem.npz.4194304.part", "..stiction-probe.1.part"];
        let others = [".film.mp4.17.part", ".result.vtu.part", "result.vtu.17.part", ".notes.json.x.part"];
        own.iter().chain(&others).for_each(|name| fs::write(folder.join(name), "x").unwrap());
        fs::write(folder.join(NAME), "process 17 on \u{1b}[1mhere\nanother line").unwrap();
        let (lock, note) = Lock::take(&folder).unwrap();
        assert!(note.unwrap().contains("process 17 on [1mhere) was killed"));
        let left = |name: &&&str| folder.join(name).exists();
        assert_eq!((own.iter().filter(left).count(), others.iter().filter(left).count()), (0, others.len()));
        drop(lock);
        assert!(folder.exists() && !folder.join(NAME).exists());
        fs::create_dir(folder.join(NAME)).unwrap();
        assert!(Lock::take(&folder).unwrap_err().to_string().contains("no regular file"));
        fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn times_follow_the_calendar() {
        assert_eq!(utc(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(utc(951_782_400), "2000-02-29 00:00:00 UTC");
        assert_eq!(utc(1_234_567_890), "2009-02-13 23:31:30 UTC");
        assert_eq!(utc(4_107_542_399), "2100-02-28 23:59:59 UTC");
        assert_eq!(utc(4_107_542_400), "2100-03-01 00:00:00 UTC");
    }
}
