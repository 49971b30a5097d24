//! The files of a stepped run as it goes on: each step is on the disk before the next one begins.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use super::contact_csv::{CONTACT_CSV, advance, figures_of, replay, tensions, write_csv};
use super::fields::body;
use super::fretting::Fretting;
use super::kept::{AGAIN, Kept, KeptStep};
use super::masters::pair_fields;
use super::sums::{self, Sums};
use super::write::{encoded, log, withdraw_result, write_body, write_contact};
use crate::Error;
use crate::friction::Progress;
use crate::io::case::{AgainstSpec, Case};
use crate::io::step::{read_step, write_step};
use crate::io::units::Units;
use crate::io::vtu::EncodedGrid;
use crate::io::{checksum, folder, vtu};
use crate::run::pose::Prepared;
use crate::run::pose::memory::output_fits;
use crate::run::solve::extrapolation::KEPT;
use crate::run::solve::{Restart, Step, StepRecord};

/// What has been finished, beside the files of the steps.
pub(crate) const STATE: &str = "steps.json";

/// How the names of files of contact surfaces begin.
const CONTACT: &str = "contact-";
/// Numbered files of a step: the front and the end of their names.
const NUMBERED: [(&str, &str); 4] = [("result-", ".vtu"), (CONTACT, ".vtu"), (CONTACT, ".csv"), ("step-", ".npz")];

/// Where the steps of a run are kept.
#[derive(Debug, Clone)]
pub struct StepFiles {
    folder: PathBuf,
    /// The list of finished steps.
    kept: Kept,
    /// Which step of the earlier run is not whole.
    damage: Option<String>,
    /// `log.jsonl` so far.
    log: String,
    /// The mesh as the files of all steps have it.
    grid: EncodedGrid,
    /// What the contact points have been through.
    fretting: Fretting,
}

impl StepFiles {
    /// What is damaged of the steps of an earlier run: none of them from there on is built on.
    pub fn damage(&self) -> Option<&str> {
        self.damage.as_deref()
    }
}

/// Makes `folder` ready for the steps of a prepared case. With `resume` the steps that it holds already are read, if
/// there are any, up to the last one before which nothing is damaged; all other files of an earlier run are removed.
///
/// # Errors
/// If files cannot be read or written, or `resume` is asked for and the folder holds the steps of another case.
pub fn begin_steps(prepared: &Prepared, folder: &Path, resume: bool) -> Result<(StepFiles, Option<Restart>), Error> {
    folder::create(folder)?;
    let kept = Kept::new(&format!("{:016x}", fingerprint(prepared)), &prepared.widened);
    let grid = encoded(prepared, true)?;
    let mut files = StepFiles {
        folder: folder.to_path_buf(),
        kept,
        damage: None,
        log: String::new(),
        grid,
        fretting: Fretting::default(),
    };
    let restart = if resume { restart(prepared, &mut files)? } else { None };
    withdraw_result(folder)?;
    if restart.is_none() {
        remove_steps(folder)?;
        for name in ["result.vtu", "contact.vtu", CONTACT_CSV] {
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
    let (path, mut case) = (folder.join(STATE), case.clone());
    let kept = if path.exists() { Kept::read(&path)?.0 } else { None };
    widen(&mut case, &kept.map_or(Vec::new(), |kept| kept.widened()));
    Ok(case)
}

/// Lets contacts look as far as these say by their names, length.
pub(in crate::run) fn widen(case: &mut Case, found: &[(String, f64)]) {
    for (name, search) in found {
        for contact in case.contacts.iter_mut().filter(|contact| contact.name == *name) {
            if let AgainstSpec::Surface { widened, .. } = &mut contact.against {
                *widened = Some(*search);
            }
        }
    }
}

/// Moves the steps of a level of refinement from a folder of their own into that of the result, where they replace those of the
/// level before.
///
/// # Errors
/// If a file cannot be moved.
pub(in crate::run) fn adopt_steps(from: &Path, folder: &Path) -> Result<(), Error> {
    withdraw_result(folder)?;
    remove_steps(folder)?;
    let mut names = folder::names(from)?;
    // The list of finished steps comes last: what it names is there.
    names.sort_by_key(|name| name == STATE);
    for name in names {
        std::fs::rename(from.join(&name), folder.join(&name)).map_err(|error| folder::refused(folder, &error))?;
    }
    folder::remove_empty(from);
    Ok(())
}

/// Removes the steps of a level that was not solved, with their folder.
pub(in crate::run) fn discard_steps(from: &Path) {
    // What cannot be removed is replaced by the next level.
    let _ = remove_steps(from);
    let _ = folder::remove(&from.join("log.jsonl"));
    folder::remove_empty(from);
}

/// Removes what a stepped run has left.
pub(crate) fn remove_steps(folder: &Path) -> Result<(), Error> {
    folder::withdraw(&folder.join(STATE))?;
    for name in ["result.pvd", "contact.pvd", "history.png"] {
        folder::remove(&folder.join(name))?;
    }
    remove_after(folder, 0)
}

/// Removes the files of the steps after the first `count`.
fn remove_after(folder: &Path, count: usize) -> Result<(), Error> {
    let names = folder::names(folder)?;
    let later = names.iter().filter(|name| number_of(name).is_some_and(|number| number > count));
    later.map(|name| folder.join(name)).try_for_each(|path| folder::remove(&path))
}

/// The step that a file called `name` is of.
pub(crate) fn number_of(name: &str) -> Option<usize> {
    NUMBERED.iter().find_map(|(front, end)| {
        let number = name.strip_prefix(front)?.strip_suffix(end)?;
        let digits = number.len() >= 4 && number.bytes().all(|b| b.is_ascii_digit());
        number.parse().ok().filter(|_| digits)
    })
}

/// Writes the files of a step. The list of finished steps comes last: a step it names is whole and on the disk.
///
/// # Errors
/// If a file cannot be written.
pub fn keep_step(files: &mut StepFiles, prepared: &Prepared, step: &Step) -> Result<(), Error> {
    let (folder, number) = (&files.folder, step.number);
    output_fits(&prepared.mesh, false)?;
    let mut names = vec![step_name(number), format!("result-{number:04}.vtu")];
    write_step(&folder.join(&names[0]), &step.file)?;
    write_body(&folder.join(&names[1]), prepared, &files.grid, &body(prepared, step.outcome))?;
    let surfaces = pair_fields(prepared, step.outcome);
    if !surfaces.is_empty() {
        names.push(format!("{CONTACT}{number:04}.vtu"));
        write_contact(&folder.join(&names[2]), &surfaces, true)?;
        let tension = tensions(prepared, step.outcome, &surfaces);
        // That of a step which is not finished is not gone on from.
        advance(&mut files.fretting, &surfaces, &tension);
        names.push(csv_name(number));
        let figures = figures_of(prepared, &surfaces, &files.fretting, &tension);
        write_csv(&folder.join(&names[3]), &Units::of(prepared.facts.units.as_deref()), &surfaces, Some(&figures))?;
    }
    let lines = log(step.outcome, Some(number));
    files.log += &lines;
    write_lists(files, step.records, !surfaces.is_empty())?;
    // One that is not finished is named by the summary.
    folder::sync(&files.folder, &names)?;
    if step.finished {
        let sums = sums::of_files(&files.folder, &names)?;
        if let Some(record) = step.records.last() {
            files.kept.push(record, sums, checksum::of_text(&lines));
        }
        folder::write_text_durably(&files.folder.join(STATE), &files.kept.text())?;
    }
    Ok(())
}

/// What is written again with each step: the steps over time, and the log.
fn write_lists(files: &StepFiles, records: &[StepRecord], contact: bool) -> Result<(), Error> {
    let collection = |name: &str| {
        let part = |(record, number): (&StepRecord, usize)| (record.t, format!("{name}-{number:04}.vtu"));
        let parts: Vec<(f64, String)> = records.iter().zip(1..).map(part).collect();
        vtu::write_collection(&files.folder.join(format!("{name}.pvd")), &parts)
    };
    if contact {
        collection("contact")?;
    }
    collection("result")?;
    folder::write_text(&files.folder.join("log.jsonl"), &files.log)
}

/// Checksums of the files of all finished steps, as they were when they had been written.
pub(crate) fn step_sums(folder: &Path) -> Result<Sums, Error> {
    let path = folder.join(STATE);
    let kept = if path.exists() { Kept::read(&path)?.0 } else { None };
    Ok(kept.iter().flat_map(|kept| &kept.steps).flat_map(|step| step.files.clone()).collect())
}

pub(crate) fn step_file(folder: &Path, number: usize) -> PathBuf {
    folder.join(step_name(number))
}

pub(crate) fn csv_name(number: usize) -> String {
    format!("{CONTACT}{number:04}.csv")
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
    let (kept, damage) = Kept::read(&path)?;
    files.damage = damage;
    let Some(mut kept) = kept else { return Ok(None) };
    if kept.head != files.kept.head {
        let remedy = "resume with the case and the mesh that the run began with, choose another folder with -o DIR, or \
                      solve without --resume";
        return fail(
            "the finished steps in this folder are of another case: mesh, loads, contacts or steps differ",
            remedy,
        );
    }
    let differing = |step: &KeptStep| sums::differing(&files.folder, &step.files).into_iter().next();
    if let Some((k, (name, what))) = kept.steps.iter().enumerate().find_map(|(k, step)| Some((k, differing(step)?))) {
        files.damage = Some(format!("{name} of step {} is {what}", k + 1));
        kept.steps.truncate(k);
    }
    let records: Vec<StepRecord> = kept.steps.iter().map(|step| step.record.clone()).collect();
    let Some(last_record) = records.last() else { return Ok(None) };
    let (n, m) = (prepared.problem.unknowns(), prepared.problem.points());
    let read = |number: usize| read_step(&step_file(&files.folder, number), n, prepared.model.dofs.prescribed.len(), m);
    let last = read(records.len())?;
    let before = (1..records.len()).rev().take(KEPT - 1).map(read).collect::<Result<Vec<_>, _>>()?;
    let before = before.into_iter().rev().collect();
    if last_record.t != last.t {
        return fail("the list of finished steps and the file of the last one differ", AGAIN);
    }
    files.log = finished_log(&files.folder, &kept.steps);
    let contact = kept.steps.iter().any(|step| step.files.keys().any(|name| name.starts_with(CONTACT)));
    for step in kept.steps.iter().flat_map(|step| step.files.keys()).filter(|name| name.ends_with(".csv")) {
        replay(&files.folder.join(step), &mut files.fretting)?;
    }
    files.kept = kept;
    // First the list, then what it names no longer.
    folder::write_text(&path, &files.kept.text())?;
    remove_after(&files.folder, records.len())?;
    write_lists(files, &records, contact)?;
    let history = history(&files.log, records.len());
    Ok(Some(Restart { records, last, before, history }))
}

/// The lines of the log that belong to `steps`; those of a step that are not as they were written are left out, which is
/// no reason to solve it again.
fn finished_log(folder: &Path, steps: &[KeptStep]) -> String {
    let text = folder::read_text(&folder.join("log.jsonl")).unwrap_or_default();
    #[derive(Deserialize)]
    struct Line {
        step: usize,
    }
    let mut of_step = vec![String::new(); steps.len()];
    for line in text.lines() {
        let step = serde_json::from_str::<Line>(line).map_or(0, |line| line.step);
        if let Some(lines) = step.checked_sub(1).and_then(|k| of_step.get_mut(k)) {
            *lines += &format!("{line}\n");
        }
    }
    let whole = of_step.iter().zip(steps).filter(|(lines, step)| checksum::of_text(lines) == step.log);
    whole.map(|(lines, _)| &lines[..]).collect()
}

/// The iterations of step `number` in the log.
fn history(log: &str, number: usize) -> Vec<Progress> {
    let progress = |line: &str| {
        let line: Value = serde_json::from_str(line).ok()?;
        if line["step"] == number { Progress::deserialize(line).ok() } else { None }
    };
    log.lines().filter_map(progress).collect()
}

/// A number that differs where the posed problem, its loading, or the time axis differs (FNV-1a, by words).
pub(crate) fn fingerprint(prepared: &Prepared) -> u64 {
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
    let law = (&loading.laws, &problem.contact.orthotropy);
    let text = format!("{law:?} {:?} {:?} {:?} {steps:?}", loading.loads, loading.fixes, loading.motions);
    // Laws that change with time stand in `law` as they are at the end.
    let frictions: Vec<_> = prepared.surfaces.iter().map(|surface| &surface.friction).collect();
    let text = format!("{text} {:?} {frictions:?} {:?}", loading.bolts, loading.ties);
    let text = format!("{text} {:?} {:?} {:?}", loading.couplings, loading.activity, loading.put_in);
    text.bytes().for_each(|byte| word(byte.into()));
    hash
}
