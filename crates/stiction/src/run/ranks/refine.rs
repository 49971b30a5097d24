//! An answer as accurate as asked on several ranks. Rank 0 goes through the levels: it has their meshes and the answers on them, marks
//! and refines. The others wait to be told what all ranks do next.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use super::gather::{WholeAnswer, scattered};
use super::keep::Keep;
use super::local::Local;
use super::record::{of_all, take_cost};
use super::report::{iterations, take_accuracy};
use super::solve::{Begun, How, RankedAnswer, Solved, Start};
use super::tighten::Found;
use super::write::withdraw;
use super::{room, scope, share};
use crate::Error;
use crate::accuracy::Estimate;
use crate::friction::{Progress, Solution, Status};
use crate::io::case::{AccuracySpec, Case, MeshSource};
use crate::io::machine;
use crate::linalg::{Stop, Watch};
use crate::ranks::{Ranks, agree, broadcast, max};
use crate::run::pose::bolts::tightened;
use crate::run::pose::load_state::{apply, load_state};
use crate::run::pose::memory::looking_fits;
use crate::run::pose::{MemoryLimit, Prepared, Seconds, prepare_to_look_at};
use crate::run::refine::{Indicators, Level, Levels, Sequence, SolvedLevel, other_case, solve_to_accuracy};
use crate::run::results::{adopt_steps, discard_steps, keep_levels, kept_levels, problem_fingerprint, remove_levels};
use crate::run::solve::passing::{Searches, with_searches};
use crate::run::solve::{AccuracyRecord, AnswerRecord, Event, Outcome, Settings, discretisation_error};
use crate::run::whole::{MOST_WIDENINGS, Plan, Run, Stage};
use crate::solve::SolveEvent;

/// What all ranks do next.
const SOLVE: u8 = 0;
/// The ranks take and judge the answer that rank 0 has found alone.
const TAKE: u8 = 1;
const END: u8 = 2;

/// Solves a case on ever finer meshes until its goals are met. Rank 0 solves those with at most `most` displacements alone, all ranks
/// the others.
///
/// # Errors
/// As [`solve_to_accuracy`], at every rank.
pub(super) fn refined(
    (case, accuracy): (&Case, &AccuracySpec),
    ranks: &Arc<dyn Ranks>,
    keep: Option<&Keep>,
    observer: &mut Watch<Progress>,
    most: usize,
) -> Result<RankedAnswer, Error> {
    let limits = [room::limit(case, &**ranks).bytes, MemoryLimit::of(&case.solver).bytes];
    let folder = keep.map(|keep| &*keep.folder);
    let mut team = Team { case, ranks, observer, limits, folder, tell: keep.map(|keep| keep.tell), answer: None };
    if ranks.rank() > 0 {
        loop {
            let _ = match team.told(0) {
                // What is wrong is told again at the end, if it ends the levels.
                SOLVE => team.solve(None).map(|_| ()),
                TAKE => team.take(None),
                _ => return team.end(Ok(None)),
            };
        }
    }
    let levels = First::levels(team, keep, most);
    levels.solved(accuracy)
}

/// All ranks.
struct Team<'a, 'b> {
    case: &'a Case,
    ranks: &'a Arc<dyn Ranks>,
    observer: &'a mut Watch<'b, Progress>,
    /// Bytes that this rank may use, and the same if it were alone on its machine; at the beginning.
    limits: [Option<u64>; 2],
    /// Where load steps are kept.
    folder: Option<&'a Path>,
    tell: Option<fn(&Stage)>,
    /// The last answer that the ranks have.
    answer: Option<RankedAnswer>,
}

impl Team<'_, '_> {
    /// What rank 0 says is done next.
    fn told(&self, what: u8) -> u8 {
        broadcast(&**self.ranks, vec![what]).first().copied().unwrap_or(END)
    }

    /// Solves a level, which rank 0 has with its displacements to start from, and returns there what it looks at.
    ///
    /// # Errors
    /// As [`Begun::solved`], and what rank 0 finds wrong with the answer; the same at every rank.
    fn solve(&mut self, level: Option<&Level>) -> Result<Option<SolvedLevel>, Error> {
        let mut case = level.map_or(self.case, |level| &level.case).clone();
        let mut widenings = 0;
        loop {
            let (solved, needed) = self.attempt(level, &case)?;
            match with_searches(&case, &needed).filter(|_| widenings < MOST_WIDENINGS) {
                Some(wider) => (case, widenings) = (wider, widenings + 1),
                None => return Ok(solved),
            }
        }
    }

    /// The same once, with how far surfaces would have to be looked for by the number of each contact; length.
    ///
    /// # Errors
    /// As [`Self::solve`].
    fn attempt(&mut self, level: Option<&Level>, case: &Case) -> Result<(Option<SolvedLevel>, Searches), Error> {
        let begun = Begun::new(self.ranks);
        let share = share::of_whole(case, None, &*begun.ranks)?;
        let given = level.and_then(|level| level.start.as_deref());
        let is_given = broadcast(&**self.ranks, vec![u8::from(given.is_some())]) == [1];
        let start = is_given.then(|| {
            let all = given.map_or(&[][..], |all| all.as_chunks::<3>().0);
            Start::Displacements(scattered(&**self.ranks, &share.piece.nodes, all))
        });
        let mut seen = Seen::new(case, level.map_or_else(Indicators::default, Indicators::of));
        let ranks = &**self.ranks;
        let mut look = |local: &Local, found: &Found, t: f64| {
            let whole = WholeAnswer::gathered(local, &found.everywhere, &found.shortening);
            agree(ranks, whole.map_or(Ok(()), |whole| seen.add(&whole, &found.solution, t)))
        };
        let apart = self.folder.map(|folder| Keep { folder: folder.join("level"), resume: false, tell: |_| {} });
        let tell = self.tell.filter(|_| level.is_some_and(|level| level.number == 0));
        let how = How { start, keep: apart.as_ref(), tell, look: Some(&mut look), of_case: false };
        let solved = begun.solved((case, share), how, self.observer);
        let first = ranks.rank() == 0;
        let kept = apart.filter(|_| first && !case.steps.is_empty());
        let discard = || kept.iter().for_each(|apart| discard_level(&apart.folder));
        let Solved { answer, seconds, needed } = solved.inspect_err(|_| discard())?;
        let is_solved = answer.summary.answer.status == Status::Solved;
        let is_taken = needed.is_empty() && (is_solved || self.answer.is_none());
        let settled = match kept.as_ref().zip(self.folder) {
            Some((apart, folder)) if is_taken => adopt_level(&apart.folder, folder),
            _ => {
                discard();
                Ok(())
            }
        };
        agree(ranks, settled)?;
        let memory = self.memory();
        let (iterations, energy) =
            (iterations(&answer.summary.answer, &answer.summary.steps), answer.summary.answer.energy);
        if is_taken {
            self.answer = Some(answer);
        }
        if !first {
            return Ok((None, needed));
        }
        Ok((seen.ended(iterations, seconds, energy, memory), needed))
    }

    /// Lets the ranks judge an answer on a mesh that rank 0 has. Where they have other points, and load steps, each of which has files of
    /// all ranks, they solve themselves.
    ///
    /// # Errors
    /// As [`Begun::solved`], the same at every rank.
    fn take(&mut self, found: Option<(&Case, &WholeAnswer, AnswerRecord)>) -> Result<(), Error> {
        let case = found.as_ref().map_or(self.case, |(case, ..)| case);
        let begun = Begun::new(self.ranks);
        let share = share::of_whole(case, None, &*begun.ranks)?;
        let mut message = Vec::new();
        if let Some((_, answer, known)) = &found {
            message = answer.to_bytes();
            message.extend(serde_json::to_vec(known).unwrap_or_default());
        }
        let message = broadcast(&**self.ranks, message);
        let mut from = &message[..];
        let answer = WholeAnswer::take(&mut from);
        let known = serde_json::from_slice(from).ok().filter(|_| case.steps.is_empty());
        let start = known.map(|known| Start::Answer(answer, Box::new(known)));
        let keep = self.folder.map(|folder| Keep { folder: folder.to_path_buf(), resume: false, tell: |_| {} });
        let how = How { start, keep: keep.as_ref(), tell: None, look: None, of_case: false };
        self.answer = Some(begun.solved((case, share), how, self.observer)?.answer);
        Ok(())
    }

    /// The last answer with what rank 0 knows of the levels and of the error of each cell.
    ///
    /// # Errors
    /// What ended the levels, at every rank.
    fn end(self, found: Result<Option<Outcome>, Error>) -> Result<RankedAnswer, Error> {
        let ranks = &**self.ranks;
        let outcome = agree(ranks, found)?;
        let own = outcome.as_ref().and_then(|outcome| outcome.accuracy.as_ref());
        let message = broadcast(ranks, serde_json::to_vec(&own).unwrap_or_default());
        // Rank 0 reads it as well, so that all have the same or end alike.
        let accuracy: Option<AccuracyRecord> = serde_json::from_slice(&message).map_err(|_| {
            Error::new("", "the record of the meshes is damaged", "report this to the developers with the case")
        })?;
        let estimate = outcome.as_ref().and_then(|outcome| outcome.estimate.as_ref());
        let mut relative = [estimate.map_or(f64::NEG_INFINITY, Estimate::relative)];
        max(ranks, &mut relative);
        let Some(mut answer) = self.answer else {
            return Err(Error::new("", "no mesh was solved", "report this to the developers with the case"));
        };
        let error = (relative[0] >= 0.0).then_some(relative[0]);
        if error.is_some() {
            let of_cells = estimate.map_or(Vec::new(), Estimate::by_cell);
            answer.error = scattered(ranks, &answer.local.piece.cells, &of_cells);
        }
        take_accuracy(&mut answer.summary, error, accuracy);
        // Those of all meshes, which rank 0 has.
        let all = outcome.as_ref().map_or(Seconds::default(), |outcome| outcome.seconds);
        answer.seconds = all;
        take_cost(&mut answer.summary.answer, &of_all(&all, ranks), ranks);
        Ok(answer)
    }

    /// The largest memory of a rank as a part of what it may use, in bytes of what rank 0 might use alone: what the loop over the levels
    /// holds against that.
    fn memory(&self) -> Option<u64> {
        let [limit, alone] = self.limits;
        let part = machine::peak_memory().zip(limit).map_or(-1.0, |(peak, limit)| peak as f64 / limit as f64);
        let mut part = [part];
        max(&**self.ranks, &mut part);
        alone.filter(|_| part[0] >= 0.0).map(|alone| (part[0] * alone as f64) as u64)
    }
}

/// What rank 0 sees of a level.
struct Seen<'a> {
    case: &'a Case,
    /// The problem of the whole as it was answered last, and the answer.
    last: Option<(Prepared, Outcome)>,
    indicators: Indicators,
}

impl<'a> Seen<'a> {
    fn new(case: &'a Case, indicators: Indicators) -> Self {
        Seen { case, last: None, indicators }
    }

    /// Takes the answer at time `t` of all ranks as one of the whole mesh.
    ///
    /// # Errors
    /// If the whole cannot be posed, or there is no memory for it.
    fn add(&mut self, whole: &WholeAnswer, found: &Solution, t: f64) -> Result<(), Error> {
        let mut prepared = match self.last.take() {
            Some((prepared, _)) => prepared,
            None => {
                looking_fits(whole.u.len() as f64, &MemoryLimit::of(&self.case.solver))?;
                prepare_to_look_at(self.case)?
            }
        };
        refuse_travel(self.case, &prepared)?;
        if !self.case.steps.is_empty() || !prepared.loading.bolts.is_empty() {
            let state = tightened(&prepared, load_state(&prepared, t)?, &whole.shortening);
            let unslid = vec![0.0; 2 * prepared.problem.points()];
            apply(&mut prepared, &state, &unslid);
        }
        let Some(mut at_points) = whole.at_points_of_whole(&prepared) else {
            let what = "the ranks have other contact points than the whole mesh";
            return Err(Error::new("", what, "report this to the developers with the case"));
        };
        at_points.put_into(&mut prepared.problem.contact);
        let dofs = &prepared.model.dofs;
        let mut components = whole.u.as_flattened().to_vec();
        dofs.to_components(&mut components);
        let solution = Solution {
            u: dofs.free.iter().map(|&dof| components[dofs.mesh_dof(dof) as usize]).collect(),
            lambda: at_points.lambda,
            states: at_points.states,
            ..found.clone()
        };
        let mut outcome = Outcome::new(solution, &Settings::of(&self.case.solver));
        outcome.estimate = Some(discretisation_error(&prepared, &outcome.solution.u));
        self.indicators.add(&prepared, &outcome, t);
        self.last = Some((prepared, outcome));
        Ok(())
    }

    /// The last answer with what the solve has taken; `iterations` are those of load steps.
    fn ended(self, iterations: usize, seconds: Seconds, energy: f64, memory: Option<u64>) -> Option<SolvedLevel> {
        let Seen { last, indicators, .. } = self;
        let (prepared, mut outcome) = last?;
        outcome.energy = Some(energy);
        outcome.peak_memory = memory.or(outcome.peak_memory);
        outcome.solution.counts.cycles = outcome.solution.counts.cycles.max(iterations);
        outcome.seconds = seconds;
        Some(SolvedLevel { prepared, outcome, indicators })
    }
}

/// Moves the load steps of a level, which have a folder of their own until it is solved, into that of the result.
fn adopt_level(from: &Path, folder: &Path) -> Result<(), Error> {
    withdraw(folder, &|_| true)?;
    adopt_steps(from, folder)
}

/// Removes those of a level that was not solved.
fn discard_level(folder: &Path) {
    // What cannot be removed is replaced by the next level.
    let _ = withdraw(folder, &|_| true);
    discard_steps(folder);
}

/// Displacements of one machine leave out what supports have in common; those of ranks do not.
fn refuse_travel(case: &Case, prepared: &Prepared) -> Result<(), Error> {
    if prepared.loading.travel == [0.0; 3] {
        return Ok(());
    }
    Err(scope::refused(&case.mesh.spot, "[accuracy] with supports that travel farther than the mesh is large"))
}

/// Rank 0, which has the levels.
struct First<'a, 'b> {
    team: Team<'a, 'b>,
    keep: Option<&'a Keep>,
    /// Displacements up to which it solves a level alone.
    most: usize,
    /// The fingerprint of the problem of the present level, and the one that an earlier run has found.
    problem: String,
    wanted: Option<String>,
    /// The last level, if the ranks do not have its answer.
    alone: Option<Case>,
}

impl<'a, 'b> First<'a, 'b> {
    fn levels(team: Team<'a, 'b>, keep: Option<&'a Keep>, most: usize) -> Self {
        First { team, keep, most, problem: String::new(), wanted: None, alone: None }
    }

    /// Goes through the levels and ends all ranks.
    fn solved(mut self, accuracy: &AccuracySpec) -> Result<RankedAnswer, Error> {
        let found = self.before().and_then(|before| {
            let (prepared, outcome) = solve_to_accuracy(self.team.case, accuracy, before, &mut self)?;
            if let Some(case) = self.alone.take() {
                self.team.told(TAKE);
                let answer = WholeAnswer::of_outcome(&prepared, &outcome);
                self.team.take(Some((&case, &answer, AnswerRecord::of(&prepared, &outcome))))?;
            }
            Ok(Some(outcome))
        });
        self.team.told(END);
        self.team.end(found)
    }

    /// The levels of an earlier run.
    fn before(&mut self) -> Result<Option<Sequence>, Error> {
        let Some(keep) = self.keep else { return Ok(None) };
        let found = if keep.resume { kept_levels(&keep.folder)? } else { None };
        if found.is_none() {
            remove_levels(&keep.folder)?;
        }
        let (wanted, before) = found.unzip();
        self.wanted = wanted;
        let note = match &before {
            Some(sequence) => format!("going on after {} meshes", sequence.levels.len()),
            None => "there are no meshes to go on from: solving from the beginning".into(),
        };
        if keep.resume {
            (keep.tell)(&Stage::Note(&note));
        }
        Ok(before)
    }

    /// Solves a level as one machine does; one that is not solved that way is left to all ranks.
    fn solve_alone(&mut self, level: &Level) -> Result<SolvedLevel, Error> {
        let (observer, keep) = (&mut *self.team.observer, self.keep);
        let mut tell = |stage: Stage| match stage {
            Stage::Event(Event::Solver(SolveEvent::Iteration(progress))) => observer(progress),
            Stage::Note(_) | Stage::Posed(_, 0) => {
                keep.into_iter().for_each(|keep| (keep.tell)(&stage));
                ControlFlow::Continue(())
            }
            _ => ControlFlow::Continue(()),
        };
        let (plan, stop) = (Plan::default(), Stop::never());
        let solved = Run::new(&plan, &stop, &mut tell).solve(level)?;
        refuse_travel(&level.case, &solved.prepared)?;
        if solved.outcome.solution.status == Status::Solved {
            self.check(level, &solved.prepared)?;
        }
        self.alone = Some(level.case.clone());
        Ok(solved)
    }

    fn solve_together(&mut self, level: &Level) -> Result<SolvedLevel, Error> {
        self.team.told(SOLVE);
        let Some(solved) = self.team.solve(Some(level))? else {
            return Err(Error::new("", "the ranks have no answer", "report this to the developers with the case"));
        };
        self.check(level, &solved.prepared)?;
        if solved.outcome.solution.status == Status::Solved {
            self.alone = None;
        }
        Ok(solved)
    }

    /// Refuses levels of another case to go on from.
    fn check(&mut self, level: &Level, prepared: &Prepared) -> Result<(), Error> {
        // That of one machine holds all of `K`.
        self.problem = format!("ranks {}", problem_fingerprint(prepared));
        let is_other = level.again && self.wanted.as_ref().is_some_and(|wanted| *wanted != self.problem);
        if is_other { Err(other_case()) } else { Ok(()) }
    }
}

impl Levels for First<'_, '_> {
    fn solve(&mut self, level: &Level) -> Result<SolvedLevel, Error> {
        let nodes = match &level.case.mesh.source {
            MeshSource::Given(given) => given.0.nodes.len(),
            _ => usize::MAX / 3,
        };
        if 3 * nodes <= self.most {
            let before = self.alone.clone();
            let solved = self.solve_alone(level)?;
            if solved.outcome.solution.status == Status::Solved {
                return Ok(solved);
            }
            self.alone = before;
        }
        self.solve_together(level)
    }

    fn finished(&mut self, sequence: &Sequence) -> Result<(), Error> {
        if let Some(case) = &mut self.alone {
            // As far as rank 0 has looked for counterparts all ranks do.
            sequence.fix_contacts(case);
        }
        let Some(keep) = self.keep else { return Ok(()) };
        sequence.levels.last().iter().for_each(|level| (keep.tell)(&Stage::Level(level)));
        keep_levels(&keep.folder, &self.problem, sequence)
    }
}

#[cfg(test)]
#[path = "refine_tests.rs"]
mod tests;
