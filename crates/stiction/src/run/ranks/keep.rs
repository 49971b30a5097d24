//! Load steps on several ranks, kept in a folder as they are solved: any number of ranks goes on from them.
//!
//! Each rank writes what is its own of a step, by the numbers of nodes in the whole mesh. A step counts from the moment when rank
//! 0 has put it on the list, `steps.json`, after the files of all ranks are on the disk.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::fretting::numbers;
use super::hash::Hash;
use super::local::Local;
use super::timed::{begins, changes_laws, is_brittle};
use super::write::{named, sums_of_all, withdraw};
use crate::Error;
use crate::contact::Friction;
use crate::friction::{PointState, Status};
use crate::io::case::Case;
use crate::io::pieces::{Head, NamedPiece, displacements_of_step, of_points_of_step, step_name, write_step_piece};
use crate::io::step::StepFile;
use crate::io::{checksum, folder};
use crate::ranks::{Ranks, Wire, agree, broadcast, gather_all, to_bytes};
use crate::run::pose::axis::Position;
use crate::run::pose::load_state::Initial;
use crate::run::pose::surfaces::widened;
use crate::run::results::json;
use crate::run::results::step_file::{STATE, remove_steps, widen};
use crate::run::results::sums::{self, Sums};
use crate::run::results::{Fretting, PointHistory};
use crate::run::solve::StepRecord;
use crate::run::solve::extrapolation::KEPT;
use crate::run::solve::strength::{left, lost};
use crate::run::whole::Stage;

/// Where load steps and levels are kept.
#[derive(Debug, Clone)]
pub struct Keep {
    /// All ranks see it.
    pub folder: PathBuf,
    /// Whether to go on from the steps or meshes that are there; otherwise they are removed.
    pub resume: bool,
    /// Called at rank 0 with what the case amounts to ([`Stage::Posed`]), remarks ([`Stage::Note`]) and finished levels ([`Stage::Level`]).
    pub tell: fn(&Stage),
}

/// Number of the format of the list; that of one rank has another kind of value here.
const FORMAT: &str = "ranks 2";
const WHAT: &str = "a list of finished load steps of several ranks";
const AGAIN: &str = "solve the case from its beginning, without --resume";

/// The list of finished steps.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct List {
    format: String,
    /// A number of mesh, loads, contacts and steps, in hexadecimal digits.
    case: String,
    /// Contacts whose `search` was found too short before these steps, and what it is instead; length.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    widened: Vec<(String, f64)>,
    steps: Vec<Entry>,
}

/// A finished step.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Entry {
    record: StepRecord,
    /// Where the next increment begins, as [`Position::write`] says it.
    at: [usize; 4],
    /// Checksums of its files.
    files: Sums,
    /// That of all this and of what stands before it.
    checksum: String,
}

impl Entry {
    fn new(record: StepRecord, at: [usize; 4], files: Sums, before: &str) -> Entry {
        let checksum = seal(&record, at, &files, before);
        Entry { record, at, files, checksum }
    }
}

fn seal(record: &StepRecord, at: [usize; 4], files: &Sums, before: &str) -> String {
    checksum::of_text(&format!("{before}\n{}", json!([record, at, files])))
}

/// Increments that were finished before.
pub(super) struct Finished {
    /// What is known of them.
    pub records: Vec<StepRecord>,
    /// Displacements of all unknowns here at the end of the last three, and of those at whose end something stood that keeps its place:
    /// with the number of each from 0, ascending.
    pub u: Vec<(usize, Vec<f64>)>,
    /// Multipliers of all points here at the end of the last one, newton.
    pub lambda: Vec<f64>,
    /// What the points here have been through until then.
    pub fretting: Fretting,
    /// The points here whose strength is lost.
    pub lost: Vec<bool>,
    /// Where the next begins.
    pub at: Position,
}

/// The steps of a run.
pub(super) struct Kept {
    folder: PathBuf,
    list: List,
    named: NamedPiece,
    /// The number of the case, which the files of its steps carry.
    run: u64,
    finished: Option<Finished>,
}

impl Kept {
    /// Makes the folder ready, and reads what is to be gone on from.
    ///
    /// # Errors
    /// If files cannot be read or written, or the steps there are of another case; the same at every rank.
    pub(super) fn begin(keep: &Keep, case: &Case, local: &Local) -> Result<Kept, Error> {
        let ranks = &*local.division.ranks;
        let (named, run) = (named(local), fingerprint(case, local));
        let widened = widened(&case.contacts);
        let empty = List { format: FORMAT.into(), case: format!("{run:016x}"), widened, steps: Vec::new() };
        let list = match ranks.rank() {
            0 => prepared(keep, &empty, case),
            _ => Ok(empty.clone()),
        };
        let own = agree(ranks, list)?;
        let text = broadcast(ranks, json::text(&own).into_bytes());
        let list: List = serde_json::from_slice(&text).unwrap_or(empty);
        let mut kept = Kept { folder: keep.folder.clone(), list, named, run, finished: None };
        if let Some(at) = kept.list.steps.last().and_then(|last| Position::read(last.at, &case.steps)) {
            let steps = &kept.list.steps;
            let of_step = |number: usize| {
                let u = agree(ranks, displacements(&kept.folder, &kept.named, &steps[number]))?;
                Ok((number, u))
            };
            let u = to_go_on_from(case, steps).into_iter().map(of_step).collect::<Result<_, Error>>()?;
            let lost = match steps.last().filter(|_| is_brittle(case)) {
                Some(last) => agree(ranks, lost_strength(&kept.folder, &kept.named, last, &local.timed.laws))?,
                None => Vec::new(),
            };
            let lambda = steps.last().map_or(Ok(Vec::new()), |last| forces(&kept.folder, &kept.named, last));
            let lambda = agree(ranks, lambda)?;
            let fretting =
                steps.last().map_or(Ok(Fretting::default()), |last| history(&kept.folder, &kept.named, last));
            let fretting = agree(ranks, fretting)?;
            let records = steps.iter().map(|entry| entry.record.clone()).collect();
            kept.finished = Some(Finished { records, u, lambda, fretting, lost, at });
        }
        Ok(kept)
    }

    /// What was finished before; once.
    pub(super) fn finished(&mut self) -> Option<Finished> {
        self.finished.take()
    }

    /// Removes the increments: others from the beginning follow.
    ///
    /// # Errors
    /// If a file cannot be removed, at every rank.
    pub(super) fn begin_again(&mut self, ranks: &dyn Ranks) -> Result<(), Error> {
        self.list.steps.clear();
        let removed = match ranks.rank() {
            0 => withdraw(&self.folder, &|_| true).and_then(|()| remove_steps(&self.folder)),
            _ => Ok(()),
        };
        agree(ranks, removed)
    }

    /// Keeps the last of `steps`, with what the points here have been through until then: its displacements, multipliers and states are those of all that is here. One that was not solved
    /// is not put on the list. The next increment begins `at`.
    ///
    /// # Errors
    /// If a file cannot be written, at every rank.
    pub(super) fn add(
        &mut self,
        (local, case): (&Local, &Case),
        (u, lambda, states): (&[f64], &[f64], &[PointState]),
        (steps, fretting): (&[StepRecord], &Fretting),
        at: Position,
    ) -> Result<(), Error> {
        let Some(record) = steps.last() else { return Ok(()) };
        let ranks = &*local.division.ranks;
        let head = Head { run: self.run, rank: ranks.rank(), ranks: ranks.size() };
        let name = step_name(steps.len(), head.rank);
        let own = own_part(local, case, &self.named, record.t, u, lambda, states);
        let history = self.named.of_points(&numbers(fretting, local)).into_flattened();
        let written = write_step_piece(&self.folder.join(&name), &head, &self.named, &own, &history);
        agree(ranks, written.and_then(|()| folder::sync(&self.folder, std::slice::from_ref(&name))))?;
        let sums = sums_of_all(ranks, &self.folder, &[name])?;
        if record.answer.status == Status::Solved {
            let before = self.list.steps.last().map_or("", |entry| &entry.checksum).to_string();
            self.list.steps.push(Entry::new(record.clone(), at.write(), sums, &before));
            let first = head.rank == 0;
            agree(ranks, if first { write_list(&self.folder, &self.list) } else { Ok(()) })?;
        }
        Ok(())
    }
}

/// The case with what an earlier run has found of its contacts, if it is gone on from.
///
/// # Errors
/// If the list of its steps is damaged, at every rank.
pub(super) fn widened_before(keep: &Keep, mut case: Case, ranks: &dyn Ranks) -> Result<Case, Error> {
    let path = keep.folder.join(STATE);
    let read = || -> Result<Vec<(String, f64)>, Error> {
        let is_kept = keep.resume && ranks.rank() == 0 && path.exists();
        if is_kept { json::read::<List>(&path, WHAT, AGAIN).map(|list| list.widened) } else { Ok(Vec::new()) }
    };
    let message = broadcast(ranks, json::text(&agree(ranks, read())?).into_bytes());
    let found: Vec<(String, f64)> = serde_json::from_slice(&message).unwrap_or_default();
    widen(&mut case, &found);
    Ok(case)
}

fn write_list(folder: &Path, list: &List) -> Result<(), Error> {
    folder::write_text_durably(&folder.join(STATE), &json::text(list))
}

/// The list of the steps to go on from, with everything removed from the folder that is none of it.
fn prepared(keep: &Keep, empty: &List, case: &Case) -> Result<List, Error> {
    let folder = &keep.folder;
    folder::create(folder)?;
    let mut list = if keep.resume { read(keep, empty)? } else { empty.clone() };
    let next = |entry: &Entry| Position::read(entry.at, &case.steps).and_then(|at| at.span(&case.steps));
    if list.steps.last().is_some_and(|last| next(last).is_none()) {
        // An answer has fields that no file of a step holds: the last increment is solved again.
        list.steps.pop();
    }
    let files: Vec<&String> = list.steps.iter().flat_map(|entry| entry.files.keys()).collect();
    withdraw(folder, &|name| !files.iter().any(|file| *file == name))?;
    match list.steps.is_empty() {
        true => remove_steps(folder)?,
        false => {
            let reached = list.steps.last().map_or(0.0, |last| last.record.t);
            (keep.tell)(&Stage::Note(&format!("going on after {} increments, at t = {reached}", list.steps.len())));
            write_list(folder, &list)?;
        }
    }
    Ok(list)
}

/// The list in the folder up to the first step of which something is damaged; an empty one if there is none.
fn read(keep: &Keep, empty: &List) -> Result<List, Error> {
    let path = keep.folder.join(STATE);
    if !path.exists() {
        return Ok(empty.clone());
    }
    let fail = |what: &str, remedy: &str| Err(Error::new(path.display().to_string(), what, remedy));
    let mut list: List = json::read(&path, WHAT, AGAIN)?;
    if list.format != FORMAT {
        return fail("the list of finished steps has another format than this version reads", AGAIN);
    }
    if list.case != empty.case {
        let remedy = "resume with the case and the mesh that the run began with, choose another folder with -o DIR, or \
                      solve without --resume";
        return fail(
            "the finished steps in this folder are of another case: mesh, loads, contacts or steps differ",
            remedy,
        );
    }
    let mut before = String::new();
    for k in 0..list.steps.len() {
        let entry = &list.steps[k];
        let damaged = match entry.checksum == seal(&entry.record, entry.at, &entry.files, &before) {
            true => sums::differing(&keep.folder, &entry.files).into_iter().next(),
            false => Some((format!("what {STATE} says"), "damaged".into())),
        };
        if let Some((name, what)) = damaged {
            (keep.tell)(&Stage::Note(&format!("{name} of increment {} is {what}: it is solved again", k + 1)));
            list.steps.truncate(k);
            break;
        }
        before.clone_from(&entry.checksum);
    }
    Ok(list)
}

/// The displacements of all unknowns here at the end of a step.
fn displacements(folder: &Path, named: &NamedPiece, step: &Entry) -> Result<Vec<f64>, Error> {
    let mut u = vec![f64::NAN; named.unknowns.len()];
    // A file at a time: no rank ever has the whole.
    displacements_of_step(folder, &files_of(step), |name, value| {
        if let Ok(place) = named.unknowns.binary_search(&name) {
            u[place] = value;
        }
    })?;
    match u.iter().any(|u| u.is_nan()) {
        true => {
            Err(Error::new(folder.join(STATE).display().to_string(), "the files of a finished step lack nodes", AGAIN))
        }
        false => Ok(u),
    }
}

/// The multipliers of all points here at the end of a step, newton.
fn forces(folder: &Path, named: &NamedPiece, step: &Entry) -> Result<Vec<f64>, Error> {
    let (place, m) = (places(named), named.points.len());
    let mut lambda = vec![0.0; 3 * m];
    of_points_of_step::<3>(folder, &files_of(step), ("lambda", false), |name, force| {
        if let Some(&j) = place.get(&name) {
            (0..3).for_each(|r| lambda[r * m + j] = force[r]);
        }
    })?;
    Ok(lambda)
}

/// What the points here have been through until the end of a step.
fn history(folder: &Path, named: &NamedPiece, step: &Entry) -> Result<Fretting, Error> {
    let place = places(named);
    let mut points = vec![PointHistory::default(); named.points.len()];
    of_points_of_step(folder, &files_of(step), ("history", true), |name, numbers| {
        if let Some(&j) = place.get(&name) {
            points[j] = PointHistory::of_numbers(numbers);
        }
    })?;
    Ok(Fretting::of(points))
}

/// Where each point stands here.
fn places(named: &NamedPiece) -> HashMap<[u64; 3], usize> {
    named.points.iter().copied().zip(0..).collect()
}

fn files_of(step: &Entry) -> Vec<String> {
    step.files.keys().cloned().collect()
}

/// The steps whose displacements a run needs that goes on: the last three, and for each time at which something begins the last one
/// until then.
fn to_go_on_from(case: &Case, steps: &[Entry]) -> Vec<usize> {
    let until = |begin: f64| steps.iter().rposition(|entry| entry.record.t <= begin);
    let mut numbers: Vec<usize> = begins(case).into_iter().filter_map(until).collect();
    numbers.extend(steps.len().saturating_sub(KEPT)..steps.len());
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// The points here whose strength is lost at the end of a step; `laws` are those that they have while they are intact.
fn lost_strength(folder: &Path, named: &NamedPiece, step: &Entry, laws: &[Friction]) -> Result<Vec<bool>, Error> {
    let place = places(named);
    let mut left: Vec<[f64; 2]> = laws.iter().map(Friction::strength).collect();
    of_points_of_step(folder, &files_of(step), ("strength", true), |name, strength| {
        if let Some(&j) = place.get(&name) {
            left[j] = strength;
        }
    })?;
    Ok(lost(&left, laws))
}

/// What is this rank's own of a step at time `t`.
fn own_part(
    local: &Local,
    case: &Case,
    named: &NamedPiece,
    t: f64,
    u: &[f64],
    lambda: &[f64],
    states: &[PointState],
) -> StepFile {
    let (elastic, contact) = (&local.problem.elastic, &local.problem.contact);
    let supports = local.problem.labels.supports.as_ref();
    let of_supports = |list: Option<&Vec<f64>>| list.map_or(Vec::new(), |list| named.of_supports(list));
    let timed = &local.timed;
    let strength = if is_brittle(case) { left(&timed.laws, &timed.lost) } else { Vec::new() };
    let out: HashSet<usize> = timed.out(t).map(|(j, _)| j).collect();
    let own_points = named.own_points.iter().enumerate();
    let codes: Vec<usize> = states.iter().map(|state| usize::from(state.code())).collect();
    let Initial { load, support_load, energy, shortening, .. } = &local.initial;
    let initial_load = match load.is_empty() {
        true => Vec::new(),
        false => [named.of_unknowns(load), named.of_supports(support_load)].concat(),
    };
    StepFile {
        t,
        f: named.of_unknowns(&elastic.f),
        gap: named.of_points(&contact.gap),
        slip_reference: named.of_points(&contact.slip_reference),
        strength: named.of_points(&strength).into_flattened(),
        laws: if changes_laws(case) { named.of_points(&contact.friction) } else { Vec::new() },
        out: own_points.filter(|(_, j)| out.contains(&(**j as usize))).map(|(place, _)| place).collect(),
        motion: named.of_points(&local.motion),
        support_load: of_supports(supports.map(|s| &s.load)),
        support_free_load: named.of_unknowns(supports.map_or(&elastic.f, |s| &s.free_load)),
        support_displacement: of_supports(supports.map(|s| &s.displacement)),
        rounding: contact.rounding,
        initial_load,
        initial_energy: *energy,
        shortening: shortening.clone(),
        u: named.of_unknowns(u),
        lambda: named.of_points(lambda),
        states: named.of_points(&codes),
        ..StepFile::default()
    }
}

/// A number that is the same on any number of ranks, and another one where mesh, loads, contacts or steps differ.
fn fingerprint(case: &Case, local: &Local) -> u64 {
    let (piece, ranks) = (&local.piece, &*local.division.ranks);
    let (mesh, is_own) = (&piece.mesh, |v: u32| local.division.is_own(v));
    let global = |v: u32| piece.nodes[v as usize];
    let mut total: u64 = 0;
    // Each thing is hashed by the rank that owns it, and the sum knows no order.
    let mut thing = |words: &mut dyn Iterator<Item = u64>| {
        let mut hash = Hash::default();
        words.for_each(|word| hash.word(word));
        total = total.wrapping_add(hash.value());
    };
    for (v, place) in mesh.nodes.iter().enumerate().filter(|(v, _)| is_own(*v as u32)) {
        thing(&mut [0, global(v as u32)].into_iter().chain(place.map(f64::to_bits)));
    }
    for ((_, nodes), &material) in mesh.cell_iter().zip(&local.material_of_cell).filter(|((_, n), _)| is_own(n[0])) {
        thing(&mut [1, material.into()].into_iter().chain(nodes.iter().map(|&v| global(v))));
    }
    for group in &mesh.groups {
        let mut name = Hash::default();
        name.text(&group.name);
        for &v in group.nodes.iter().filter(|v| is_own(**v)) {
            thing(&mut [2, name.value(), global(v)].into_iter());
        }
        for nodes in group.faces.iter().map(|&f| mesh.faces[f as usize].nodes()).filter(|nodes| is_own(nodes[0])) {
            thing(&mut [3, name.value()].into_iter().chain(nodes.iter().map(|&v| global(v))));
        }
    }
    for (number, array) in mesh.arrays.nodes.iter().enumerate() {
        for (v, value) in array.values.iter().enumerate().filter(|(v, _)| is_own(*v as u32)) {
            thing(&mut [5, number as u64, global(v as u32), value.to_bits()].into_iter());
        }
    }
    for (number, array) in mesh.arrays.cells.iter().enumerate() {
        let of_cells = piece.cells.iter().zip(&array.values).zip(mesh.cell_iter());
        for ((&cell, value), _) in of_cells.filter(|(_, (_, nodes))| is_own(nodes[0])) {
            thing(&mut [6, number as u64, cell, value.to_bits()].into_iter());
        }
    }
    let points = (0..local.problem.points()).map(|j| (j, local.node_of(j)));
    for (j, node) in points.filter(|(_, node)| is_own(*node)) {
        let law = local.problem.contact.friction[j].numbers().map(f64::to_bits);
        let head = [4, local.pair_of(j) as u64, global(node), local.undeformed[j].to_bits()];
        thing(&mut head.into_iter().chain(law));
    }
    let sum = gather_all(ranks, to_bytes(&[total])).iter().fold(0u64, |sum, bytes| sum.wrapping_add(u64::read(bytes)));
    let Case { materials, fixes, springs, equations, couplings, loads, bolts, contacts, steps, .. } = case;
    let mut all = Hash::default();
    all.word(sum);
    all.text(&format!("{materials:?} {fixes:?} {springs:?} {loads:?} {bolts:?} {contacts:?} {steps:?}"));
    all.text(&format!("{equations:?} {couplings:?}"));
    // In a case that is refined rank 0 alone knows what earlier meshes have decided for contacts.
    u64::read(&broadcast(ranks, to_bytes(&[all.value()])))
}
