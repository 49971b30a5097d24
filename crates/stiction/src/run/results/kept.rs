//! The list of finished load steps, `steps.json`: each step with the checksums of its files, and sealed by a checksum of
//! all that stands before it in the list.

use std::path::Path;

use serde::Deserialize as _;
use serde_json::{Value, json};

use super::json;
use super::sums::Sums;
use crate::Error;
use crate::io::checksum;
use crate::run::solve::StepRecord;

/// What messages call the list, and the remedy if it cannot be read.
const WHAT: &str = "a list of finished steps";
pub(crate) const AGAIN: &str = "solve the case from its beginning, without --resume";
/// Number of its format.
const FORMAT: u32 = 3;

/// The list.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    /// Format, fingerprint of the posed problem, widened searches.
    pub(crate) head: Value,
    pub(crate) steps: Vec<KeptStep>,
}

/// A finished step.
#[derive(Debug, Clone)]
pub(crate) struct KeptStep {
    pub(crate) record: StepRecord,
    /// Of its own files.
    pub(crate) files: Sums,
    /// Checksum of its lines of the log.
    pub(crate) log: String,
    /// The checksum of all this and of what stands before it.
    seal: String,
    /// All this as it stands in the file: the list is written with every step, and most of it is not new.
    text: String,
}

impl KeptStep {
    fn new(record: StepRecord, files: Sums, log: String, entry: &Value) -> KeptStep {
        let seal = entry["checksum"].as_str().unwrap_or_default().to_string();
        // Line breaks within strings are escaped.
        KeptStep { record, files, log, seal, text: format!("{entry:#}").replace('\n', "\n    ") }
    }
}

impl Kept {
    /// No step yet; `fingerprint` in hexadecimal digits, and [`Prepared::widened`](crate::run::Prepared).
    pub(crate) fn new(fingerprint: &str, widened: &[(String, f64)]) -> Kept {
        let head = json!({ "format": FORMAT, "fingerprint": fingerprint, "widened": widened });
        Kept { head, steps: Vec::new() }
    }

    /// Adds a step with the checksums of its files and of its lines of the log.
    pub(crate) fn push(&mut self, record: &StepRecord, files: Sums, log: String) {
        let mut entry = json!({ "record": record, "files": files, "log": log });
        entry["checksum"] = seal(self.last_seal(), &entry).into();
        self.steps.push(KeptStep::new(record.clone(), files, log, &entry));
    }

    fn last_seal(&self) -> String {
        self.steps.last().map_or_else(|| seal(String::new(), &self.head), |step| step.seal.clone())
    }

    /// The text of the file.
    pub(crate) fn text(&self) -> String {
        let mut list = self.head.clone();
        list["checksum"] = seal(String::new(), &self.head).into();
        list["steps"] = json!([]);
        let head = json::text(&list);
        let entries: Vec<&str> = self.steps.iter().map(|step| step.text.as_str()).collect();
        match head.strip_suffix("[]\n}\n") {
            Some(head) if !entries.is_empty() => format!("{head}[\n    {}\n  ]\n}}\n", entries.join(",\n    ")),
            _ => head,
        }
    }

    /// Reads the list up to the first entry that is not as it was written, and says which that is; without a list where its
    /// head is not.
    ///
    /// # Errors
    /// If the file cannot be read, is no such list, or is one of another format.
    pub(crate) fn read(path: &Path) -> Result<(Option<Kept>, Option<String>), Error> {
        let fail = |what: &str| Error::new(path.display().to_string(), what, AGAIN);
        let no_list = || fail(&format!("this is not {WHAT}"));
        let mut head: Value = json::read(path, WHAT, AGAIN)?;
        if head["format"].as_str().is_some_and(|format| format.starts_with("ranks")) {
            return Err(fail(
                "the finished steps are those of a run on several ranks, which `stiction-mpi --resume` goes on with",
            ));
        }
        if head["format"].as_u64() != Some(FORMAT.into()) {
            return Err(fail("the list of finished steps has another format than this version reads"));
        }
        let mut take = |name: &str| head.as_object_mut().and_then(|map| map.shift_remove(name)).ok_or_else(no_list);
        let (sealed, entries) = (take("checksum")?, take("steps")?);
        let Value::Array(entries) = entries else { return Err(no_list()) };
        if sealed != seal(String::new(), &head) {
            return Ok((None, Some("the head of the list of finished steps is damaged".into())));
        }
        let mut kept = Kept { head, steps: Vec::new() };
        for entry in entries {
            let mut unsealed = entry.clone();
            let sealed = unsealed.as_object_mut().and_then(|map| map.shift_remove("checksum"));
            if sealed.is_none_or(|sealed| sealed != seal(kept.last_seal(), &unsealed)) {
                let what = format!("what the list of finished steps says of step {} is damaged", kept.steps.len() + 1);
                return Ok((Some(kept), Some(what)));
            }
            let fields = (|| {
                let record = StepRecord::deserialize(&entry["record"])?;
                Ok((record, Sums::deserialize(&entry["files"])?, String::deserialize(&entry["log"])?))
            })();
            let (record, files, log) = fields.map_err(|_: serde_json::Error| no_list())?;
            kept.steps.push(KeptStep::new(record, files, log, &entry));
        }
        Ok((Some(kept), None))
    }

    /// [`Prepared::widened`](crate::run::Prepared) of the run.
    pub(crate) fn widened(&self) -> Vec<(String, f64)> {
        Vec::deserialize(&self.head["widened"]).unwrap_or_default()
    }
}

/// The checksum of an entry after `before`, that of all before it.
fn seal(before: String, entry: &Value) -> String {
    checksum::of_text(&format!("{before}\n{entry}"))
}
