//! The files of a stepped run as it goes on: each step is on the disk before the next one begins.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::fields::body;
use super::json;
use super::masters::pair_fields;
use super::write::{encoded, log, write_body, write_contact};
use crate::Error;
use crate::io::case::{AgainstSpec, Case};
use crate::io::step::{read_step, write_step};
use crate::io::vtu::EncodedGrid;
use crate::io::{folder, vtu};
use crate::run::pose::Prepared;
use crate::run::solve::{Restart, Step, StepRecord};

/// What has been finished, beside the files of the steps.
const STATE: &str = "steps.json";
/// What messages call it, and the remedy if it cannot be read.
const WHAT: &str = "a list of finished steps";
const AGAIN: &str = "solve the case from its beginning, without --resume";
/// Number of its format.
const FORMAT: u32 = 2;

/// The contents of `steps.json`.
#[derive(Debug, Serialize, Deserialize)]
struct State {
    format: u32,
    /// In hexadecimal digits.
    fingerprint: String,
    /// [`Prepared::widened`].
    #[serde(default)]
    widened: Vec<(String, f64)>,
    steps: Vec<StepRecord>,
}

/// Numbered files of a step: the front and the end of their names.
const NUMBERED: [(&str, &str); 3] = [("result-", ".vtu"), ("contact-", ".vtu"), ("step-", ".npz")];

/// Where the steps of a run are kept.
#[derive(Debug, Clone)]
pub struct StepFiles {
    folder: PathBuf,
    /// Of the case on its mesh: no step of another problem is taken for one of this.
    fingerprint: u64,
    /// `log.jsonl` so far.
    log: String,
    /// The mesh as the files of all steps have it.
    grid: EncodedGrid,
}

/// Makes `folder` ready for the steps of a prepared case. With `resume` the steps that it holds already are read, if
/// there are any; otherwise the files of an earlier run are removed.
///
/// # Errors
/// If files cannot be read or written, or `resume` is asked for and the folder holds the steps of another case.
pub fn begin_steps(prepared: &Prepared, folder: &Path, resume: bool) -> Result<(StepFiles, Option<Restart>), Error> {
    folder::create(folder)?;
    let (fingerprint, grid) = (fingerprint(prepared), encoded(prepared, true)?);
    let mut files = StepFiles { folder: folder.to_path_buf(), fingerprint, log: String::new(), grid };
    let restart = if resume { restart(prepared, &mut files)? } else { None };
    folder::withdraw(&folder.join("summary.json"))?;
    if restart.is_none() {
        remove_steps(folder)?;
        for name in ["result.vtu", "contact.vtu"] {
            folder::remove(&folder.join(name))?;
        }
    }
    Ok((files, restart))
}

/// The case as the finished steps in `folder`, if there are any, have solved it: they may have found that `search` of a
/// contact is too short.
///
/// # Errors
/// If the list of finished steps cannot be read.
pub fn widened_before(case: &Case, folder: &Path) -> Result<Case, Error> {
    #[derive(Deserialize)]
    struct Head {
        #[serde(default)]
        widened: Vec<(String, f64)>,
    }
    let (path, mut case) = (folder.join(STATE), case.clone());
    if !path.exists() {
        return Ok(case);
    }
    for (name, search) in json::read::<Head>(&path, WHAT, AGAIN)?.widened {
        for contact in case.contacts.iter_mut().filter(|contact| contact.name == name) {
            if let AgainstSpec::Surface { widened, .. } = &mut contact.against {
                *widened = Some(search);
            }
        }
    }
    Ok(case)
}

/// Removes what a stepped run has left.
pub(crate) fn remove_steps(folder: &Path) -> Result<(), Error> {
    folder::withdraw(&folder.join(STATE))?;
    for name in ["result.pvd", "contact.pvd", "history.png"] {
        folder::remove(&folder.join(name))?;
    }
    let numbered = |name: &str| {
        NUMBERED.iter().any(|(front, end)| {
            let number = name.strip_prefix(front).and_then(|rest| rest.strip_suffix(end));
            number.is_some_and(|n| n.len() >= 4 && n.bytes().all(|b| b.is_ascii_digit()))
        })
    };
    let names = folder::names(folder)?;
    names.iter().filter(|name| numbered(name)).try_for_each(|name| folder::remove(&folder.join(name)))
}

/// Writes the files of a step. The list of finished steps comes last: a step it names is whole and on the disk.
///
/// # Errors
/// If a file cannot be written.
pub fn keep_step(files: &mut StepFiles, prepared: &Prepared, step: &Step) -> Result<(), Error> {
    let (folder, number) = (&files.folder, step.number);
    write_step(&step_file(folder, number), &step.file)?;
    let mut written = vec![step_name(number), format!("result-{number:04}.vtu")];
    write_body(&folder.join(&written[1]), prepared, &files.grid, &body(prepared, step.outcome))?;
    let times: Vec<f64> = step.records.iter().map(|record| record.t).collect();
    let collection = |name: &str| {
        let parts: Vec<(f64, String)> =
            times.iter().zip(1..).map(|(&t, number)| (t, format!("{name}-{number:04}.vtu"))).collect();
        vtu::write_collection(&folder.join(format!("{name}.pvd")), &parts)
    };
    let surfaces = pair_fields(prepared, step.outcome);
    if !surfaces.is_empty() {
        written.push(format!("contact-{number:04}.vtu"));
        write_contact(&folder.join(&written[2]), &surfaces, true)?;
        collection("contact")?;
    }
    collection("result")?;
    files.log += &log(step.outcome, Some(number));
    folder::write_text(&folder.join("log.jsonl"), &files.log)?;
    // One that is not finished is named by the summary.
    folder::sync(folder, &written)?;
    if step.finished {
        let fingerprint = format!("{:016x}", files.fingerprint);
        let (widened, steps) = (prepared.widened.clone(), step.records.to_vec());
        let state = State { format: FORMAT, fingerprint, widened, steps };
        folder::write_text_durably(&folder.join(STATE), &json::text(&state))?;
    }
    Ok(())
}

pub(crate) fn step_file(folder: &Path, number: usize) -> PathBuf {
    folder.join(step_name(number))
}

fn step_name(number: usize) -> String {
    format!("step-{number:04}.npz")
}

/// The steps that are finished in the folder, if there are any.
fn restart(prepared: &Prepared, files: &mut StepFiles) -> Result<Option<Restart>, Error> {
    let path = files.folder.join(STATE);
    if !path.exists() {
        return Ok(None);
    }
    let place = path.display().to_string();
    let fail = |what: &str, remedy: &str| Err(Error::new(&place, what, remedy));
    #[derive(Deserialize)]
    struct Head {
        format: u32,
    }
    if json::read::<Head>(&path, WHAT, AGAIN)?.format != FORMAT {
        return fail("the list of finished steps has another format than this version reads", AGAIN);
    }
    let State { fingerprint, steps: records, .. } = json::read(&path, WHAT, AGAIN)?;
    if fingerprint != format!("{:016x}", files.fingerprint) {
        let remedy = "resume with the case and the mesh that the run began with, choose another folder with -o DIR, or \
                      solve without --resume";
        return fail(
            "the finished steps in this folder are of another case: mesh, loads, contacts or steps differ",
            remedy,
        );
    }
    let Some(last_record) = records.last() else { return Ok(None) };
    let (n, m) = (prepared.problem.unknowns(), prepared.problem.points());
    let read = |number: usize| read_step(&step_file(&files.folder, number), n, prepared.model.dofs.prescribed.len(), m);
    let last = read(records.len())?;
    let before = if records.len() > 1 { Some(read(records.len() - 1)?) } else { None };
    if last_record.t != last.t {
        return fail("the list of finished steps and the file of the last one differ", AGAIN);
    }
    files.log = finished_log(&files.folder, records.len());
    Ok(Some(Restart { records, last, before }))
}

/// The lines of the log that belong to the first `count` steps; a log that is lost is no reason to stop.
fn finished_log(folder: &Path, count: usize) -> String {
    let text = folder::read_text(&folder.join("log.jsonl")).unwrap_or_default();
    #[derive(Deserialize)]
    struct Line {
        step: usize,
    }
    let step = |line: &str| serde_json::from_str::<Line>(line).ok().map(|line| line.step);
    let kept = text.lines().filter(|line| step(line).is_some_and(|step| step <= count));
    kept.map(|line| format!("{line}\n")).collect()
}

/// A number that differs where the posed problem, its loading, or the time axis differs (FNV-1a, by words).
fn fingerprint(prepared: &Prepared) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    let (problem, loading) = (&prepared.problem, &prepared.loading);
    let mut hash = OFFSET;
    let mut word = |word: u64| {
        hash = (hash ^ word).wrapping_mul(PRIME);
        // The low bits would never learn of the high ones.
        hash ^= hash >> 32;
    };
    for (column, value) in
        [(&problem.elastic.K.column, &problem.elastic.K.value), (&problem.contact.B.column, &problem.contact.B.value)]
    {
        column.iter().for_each(|&j| word(j.into()));
        value.iter().for_each(|v| word(v.to_bits()));
    }
    loading.undeformed.iter().for_each(|v| word(v.to_bits()));
    let steps: Vec<_> = loading.steps.iter().map(|s| (&s.name, s.until, s.increments)).collect();
    let law = (&problem.contact.friction, &problem.contact.orthotropy);
    let text = format!("{law:?} {:?} {:?} {:?} {steps:?}", loading.loads, loading.fixes, loading.motions);
    let text = format!("{text} {:?}", loading.bolts);
    text.bytes().for_each(|byte| word(byte.into()));
    hash
}
