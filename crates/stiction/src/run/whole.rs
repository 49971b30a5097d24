//! The whole way from a case to its answer, as the command and Python go it: load steps, contact found beyond where it was looked
//! for, refinement, going on where an earlier run ended.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::Path;

use crate::Error;
use crate::friction::Status;
use crate::io::case::{AccuracySpec, Case};
use crate::linalg::Stop;
use crate::mesh::many;
use crate::run::pose::{Facts, Prepared, prepare};
use crate::run::refine::{Indicators, Level, Levels, Sequence, SolvedLevel, other_case, solve_to_accuracy};
use crate::run::results::{
    Ahead, adopt_steps, begin_steps, discard_steps, keep_levels, keep_step, kept_levels, passes_through,
    problem_fingerprint, remove_levels, solve_writing, widened_before,
};
use crate::run::solve::{Event, LevelRecord, Outcome, Restart, Settings, Step, add_bound, solve, solve_steps, widened};

/// How a case is solved.
#[derive(Debug, Clone, Copy, Default)]
pub struct Plan<'a> {
    /// Where load steps and levels are kept as they are finished; without one nothing is.
    pub folder: Option<&'a Path>,
    /// Whether to go on after the last load step or level that the folder holds.
    pub resume: bool,
    /// Whether pictures are to be drawn.
    pub pictures: bool,
}

/// What is told on the way.
#[derive(Debug)]
pub enum Stage<'a> {
    /// A mesh is read or taken, and the problem on it assembled.
    Posing,
    /// It is posed; the number of its level, 0 without refinement.
    Posed(&'a Facts, usize),
    /// The solver or the load steps go on. This alone is asked whether to.
    Event(&'a Event),
    /// A load step is solved.
    Step(&'a Prepared, &'a Step<'a>),
    /// A level is solved.
    Level(&'a LevelRecord),
    /// A remark.
    Note(&'a str),
    /// What is not as it should be, and goes on nevertheless.
    Warning(&'a str),
}

/// Told of all stages.
pub type Teller<'t> = dyn FnMut(Stage) -> ControlFlow<()> + 't;

/// Contact where none was looked for moves bodies elsewhere, where they may meet again; so often at most.
pub(super) const MOST_WIDENINGS: usize = 5;

/// Solves a case: all its load steps, on ever finer meshes if it has goals of accuracy, again where contact turns up that was not
/// looked for. With `proven` the error of the answer is bounded. `posed` is the case posed already. The rest of the files is written by [`write_with`](super::write_with).
///
/// # Errors
/// As [`prepare`], [`solve()`](super::solve()) and [`solve_to_accuracy`]; if there is nothing that could be resumed, or what the
/// folder holds is damaged or of another case; if files cannot be written; [`Error::interrupted`] before there is any answer.
pub fn solve_case(
    case: &Case,
    plan: &Plan,
    stop: &Stop,
    posed: Option<Prepared>,
    tell: &mut Teller,
) -> Result<(Prepared, Outcome, Ahead), Error> {
    let refined = case.accuracy.as_ref().filter(|accuracy| accuracy.refines());
    if plan.resume && case.steps.is_empty() && refined.is_none() {
        let what = "this case has no load steps to resume, and no accuracy that refines its mesh";
        return Err(Error::new(
            "--resume",
            what,
            "solve it without --resume, or add [[step]] or [accuracy] to the case",
        ));
    }
    let mut run = Run::new(plan, stop, tell);
    let solved = match refined {
        Some(accuracy) => run.refined(case, accuracy),
        None => {
            let case = match plan.folder.filter(|_| plan.resume) {
                Some(folder) => &widened_before(case, folder)?,
                None => case,
            };
            let solved = run.solved(case, plan, posed.filter(|_| !plan.resume), None)?;
            // Levels of an earlier run are those of another one from now on.
            plan.folder.map_or(Ok(()), remove_levels)?;
            Ok(solved)
        }
    };
    let (prepared, mut outcome, ahead) = solved?;
    if case.accuracy.is_some_and(|accuracy| accuracy.proven) && outcome.bound.is_none() {
        add_bound(&prepared, &mut outcome, stop);
    }
    Ok((prepared, outcome, ahead))
}

/// A case under way.
pub(super) struct Run<'r, 't> {
    plan: &'r Plan<'r>,
    stop: &'r Stop,
    tell: &'r mut Teller<'t>,
    /// With refinement the fingerprint of the problem of the present level, and the one that an earlier run has found.
    problem: String,
    wanted: Option<String>,
}

impl Levels for Run<'_, '_> {
    fn solve(&mut self, level: &Level) -> Result<SolvedLevel, Error> {
        // Until a level is solved the folder holds the steps of the level before.
        let folder = self.plan.folder;
        let apart = folder.filter(|_| !level.again).map(|folder| folder.join("level"));
        let plan = Plan { folder: apart.as_deref().or(folder), resume: level.again, ..*self.plan };
        let mut indicators = Indicators::of(level);
        let solved = self.solved(&level.case, &plan, None, Some((level, &mut indicators)));
        let discard = || apart.iter().for_each(|apart| discard_steps(apart));
        let (prepared, mut outcome, _) = solved.inspect_err(|_| discard())?;
        // No bound is smaller than the error, which the estimate is near: before it is below the goal a bound will not be.
        let may_be_proven = |accuracy: &AccuracySpec| accuracy.proven && accuracy.energy >= Some(indicators.error);
        if level.case.accuracy.as_ref().is_some_and(may_be_proven) {
            add_bound(&prepared, &mut outcome, self.stop);
        }
        if let (Some(apart), Some(folder)) = (&apart, folder)
            && !level.case.steps.is_empty()
        {
            match outcome.solution.status == Status::Solved || level.number == 0 {
                true => adopt_steps(apart, folder)?,
                false => discard(),
            }
        }
        Ok(SolvedLevel { prepared, outcome, indicators })
    }

    fn finished(&mut self, sequence: &Sequence) -> Result<(), Error> {
        if let Some(level) = sequence.levels.last() {
            self.say(Stage::Level(level));
        }
        self.plan.folder.map_or(Ok(()), |folder| keep_levels(folder, &self.problem, sequence))
    }
}

impl<'r, 't> Run<'r, 't> {
    pub(super) fn new(plan: &'r Plan<'r>, stop: &'r Stop, tell: &'r mut Teller<'t>) -> Self {
        Run { plan, stop, tell, problem: String::new(), wanted: None }
    }

    /// Tells what does not ask whether to go on.
    fn say(&mut self, stage: Stage) {
        let _ = (self.tell)(stage);
    }

    fn settings(&self, case: &Case) -> Settings {
        let mut settings = Settings::of(&case.solver);
        settings.solver.stop = self.stop.clone();
        settings.pictures = self.plan.pictures;
        settings
    }

    /// Solves the case on ever finer meshes.
    fn refined(&mut self, case: &Case, accuracy: &AccuracySpec) -> Result<(Prepared, Outcome, Ahead), Error> {
        let mut before = None;
        if let Some(folder) = self.plan.folder {
            if self.plan.resume {
                before = kept_levels(folder)?;
            }
            match &before {
                Some((_, sequence)) => self.say(Stage::Note(&levels_found(sequence, folder))),
                None if self.plan.resume => self.say(Stage::Note(&nothing_found(folder))),
                None => {}
            }
            if before.is_none() {
                remove_levels(folder)?;
            }
        }
        let (wanted, before) = before.unzip();
        self.wanted = wanted;
        let (prepared, outcome) = solve_to_accuracy(case, accuracy, before, self)?;
        Ok((prepared, outcome, Ahead::of(&self.settings(case))))
    }

    /// Solves the case, again where contact was found beyond where it was looked for.
    fn solved(
        &mut self,
        case: &Case,
        plan: &Plan,
        mut posed: Option<Prepared>,
        mut level: Option<(&Level, &mut Indicators)>,
    ) -> Result<(Prepared, Outcome, Ahead), Error> {
        let (mut case, mut plan, mut widenings) = (case.clone(), *plan, 0);
        loop {
            if let Some((level, indicators)) = &mut level {
                **indicators = Indicators::of(level);
            }
            let own = level.as_mut().map(|(level, indicators)| (*level, &mut **indicators));
            let (prepared, outcome, ahead) = self.attempt(&case, &plan, posed.take(), own)?;
            match widened(&case, &prepared, &outcome) {
                Some(wider) if widenings < MOST_WIDENINGS => {
                    let what = passes_through(&prepared, &outcome).unwrap_or_default();
                    self.say(Stage::Note(&format!("\n{what}\nsolved again with contact there\n")));
                    (case, plan.resume, widenings) = (wider, false, widenings + 1);
                }
                _ => return Ok((prepared, outcome, ahead)),
            }
        }
    }

    /// Poses the case and solves it once.
    fn attempt(
        &mut self,
        case: &Case,
        plan: &Plan,
        posed: Option<Prepared>,
        level: Option<(&Level, &mut Indicators)>,
    ) -> Result<(Prepared, Outcome, Ahead), Error> {
        self.say(Stage::Posing);
        let mut prepared = match posed {
            Some(posed) => posed,
            None => prepare(case)?,
        };
        self.stop.check()?;
        let number = level.as_ref().map_or(0, |(level, _)| level.number);
        self.say(Stage::Posed(&prepared.facts, number));
        if let Some((level, _)) = &level {
            self.problem = problem_fingerprint(&prepared);
            if level.again && self.wanted.as_ref().is_some_and(|wanted| *wanted != self.problem) {
                return Err(other_case());
            }
            level.start.iter().for_each(|start| prepared.start_from(start.clone()));
        }
        let settings = self.settings(case);
        if !case.steps.is_empty() {
            let outcome = self.stepped(&mut prepared, plan, &settings, level)?;
            return Ok((prepared, outcome, Ahead::of(&settings)));
        }
        let mut observe = |event: &Event| (self.tell)(Stage::Event(event));
        let (outcome, ahead) = match (plan.folder, &level) {
            (Some(folder), None) => solve_writing(&prepared, &settings, folder, &mut observe)?,
            _ => (solve(&prepared, &settings, &mut observe)?, Ahead::of(&settings)),
        };
        level.into_iter().for_each(|(_, indicators)| indicators.add(&prepared, &outcome, 1.0));
        Ok((prepared, outcome, ahead))
    }

    /// Solves all load steps.
    fn stepped(
        &mut self,
        prepared: &mut Prepared,
        plan: &Plan,
        settings: &Settings,
        mut level: Option<(&Level, &mut Indicators)>,
    ) -> Result<Outcome, Error> {
        let (mut files, mut restart) = (None, None);
        if let Some(folder) = plan.folder {
            let begun = match begin_steps(prepared, folder, plan.resume) {
                // Those of the next level, whose end was not kept.
                Err(_) if level.is_some() => begin_steps(prepared, folder, false),
                begun => begun,
            };
            let (begun, found) = begun?;
            if plan.resume && level.is_none() {
                if let Some(damage) = begun.damage() {
                    let from = match &found {
                        Some(restart) => format!("going back to the end of step {}", restart.records.len()),
                        None => "no step before it is whole".into(),
                    };
                    self.say(Stage::Warning(&format!("{damage}; {from}")));
                }
                let note = found.as_ref().map_or_else(|| nothing_found(folder), |restart| steps_found(restart, folder));
                self.say(Stage::Note(&note));
            }
            (files, restart) = (Some(begun), found);
        }
        // Both are told on the way.
        let tell = RefCell::new(&mut *self.tell);
        let mut keep = |prepared: &Prepared, step: &Step| {
            let t = step.records.last().map_or(0.0, |record| record.t);
            level.iter_mut().for_each(|(_, indicators)| indicators.add(prepared, step.outcome, t));
            let _ = (tell.borrow_mut())(Stage::Step(prepared, step));
            files.as_mut().map_or(Ok(()), |files| keep_step(files, prepared, step))
        };
        let mut observe = |event: &Event| (tell.borrow_mut())(Stage::Event(event));
        solve_steps(prepared, settings, restart, &mut keep, &mut observe)
    }
}

fn steps_found(restart: &Restart, folder: &Path) -> String {
    let steps = restart.records.len();
    format!("resuming after step {steps} at t = {}, found in {}", restart.last.t, folder.display())
}

fn levels_found(sequence: &Sequence, folder: &Path) -> String {
    let unknowns = sequence.levels.last().map_or(0, |level| level.unknowns);
    let mesh = format!("mesh {} with {}", sequence.levels.len(), many(unknowns, "unknown"));
    format!("resuming after {mesh}, found in {}", folder.display())
}

fn nothing_found(folder: &Path) -> String {
    format!("nothing to resume in {}: solving from the beginning", folder.display())
}
