//! The loop over the levels.

use std::sync::Arc;

use super::first::first;
use super::values::{self, EXACT, LEAST_LEVELS, Sort, Value};
use super::{marking, prediction};
use crate::Error;
use crate::contact::Counterpart;
use crate::fem::full_displacement;
use crate::friction::Status;
use crate::io::case::{AccuracySpec, AgainstSpec, Case, MeshSource, Placing};
use crate::mesh::{Bisection, MeshNotes, many, refine};
use crate::run::pose::{MemoryLimit, Prepared, Seconds};
use crate::run::solve::{AccuracyRecord, GoalRecord, LevelRecord, Outcome};

/// Bisections of a marked cell from one level to the next; two shorten all its edges but one.
const BISECTIONS: u32 = 2;
/// Levels before the sequence ends whatever it has reached. Each has at least one cell more, and usually twice as many.
const MOST_LEVELS: usize = 40;
/// Unknowns beyond what may be solved that a goal has to take for the sequence to end before it gets there: predictions are
/// that uncertain.
const BEYOND: f64 = 2.0;
/// Levels before a prediction ends the sequence: until contact and corners are resolved errors need not fall at all.
const PREDICTING_LEVELS: usize = 5;
/// Bytes of the process below which memory says nothing about unknowns.
const OWN_MEMORY: u64 = 300 << 20;
/// A mesh to be solved on.
#[derive(Debug)]
pub struct Level {
    /// From 0.
    pub number: usize,
    /// The case on this mesh.
    pub case: Case,
    /// Displacements of the answer before at the nodes of this mesh, three each, length; none on the first and with load steps.
    pub start: Option<Vec<f64>>,
}

/// The answer of a level.
#[derive(Debug)]
pub struct SolvedLevel {
    /// The posed case.
    pub prepared: Prepared,
    /// Its answer.
    pub outcome: Outcome,
    /// Where its error is.
    pub indicators: Indicators,
}

/// Where the error of a level is; with load steps where it is in any of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Indicators {
    /// Squared energy norm of the estimated error of each cell, energy.
    pub cells: Vec<f64>,
    /// Estimated error in the energy norm, relative.
    pub error: f64,
}

impl Indicators {
    /// Takes the larger of what is known and the errors of `outcome`, an answer on the same mesh.
    pub fn add(&mut self, outcome: &Outcome) {
        let Some(estimate) = &outcome.estimate else { return };
        self.error = self.error.max(estimate.relative());
        self.cells.resize(estimate.cells.len(), 0.0);
        self.cells.iter_mut().zip(&estimate.cells).for_each(|(most, cell)| *most = most.max(*cell));
    }
}

/// What is known of the levels so far.
#[derive(Default)]
struct History {
    levels: Vec<LevelRecord>,
    values: Vec<Vec<Value>>,
}

/// Solves `case` on ever finer meshes until the goals of `accuracy` are met; `solve` solves one level, `observe` is told of
/// each that is solved. Goals are believed from the third level on: before, contact may not be resolved at all.
///
/// Ends early, with the reason in the record, where a later level cannot be made, is interrupted or not solved, where memory or
/// `max_unknowns` forbids it, and where a goal is predicted to take more than twice what they allow. The answer then is the last that
/// was solved.
///
/// # Errors
/// On the first level: what makes the mesh impossible to refine, more of it than `max_unknowns`, what `solve` returns.
pub fn solve_to_accuracy(
    case: &Case,
    accuracy: &AccuracySpec,
    solve: &mut dyn FnMut(&Level) -> Result<SolvedLevel, Error>,
    observe: &mut dyn FnMut(&LevelRecord),
) -> Result<(Prepared, Outcome), Error> {
    let limit = MemoryLimit::of(&case.solver);
    let (mut bisection, notes) = first(case, accuracy, &limit)?;
    let mut level = Level { number: 0, case: on_mesh(case, &bisection, &notes), start: None };
    let mut history = History::default();
    let mut last: Option<(Prepared, Outcome)> = None;
    let mut seconds = Seconds::default();
    let ended = loop {
        let solved = match (solve(&level), &last) {
            (Ok(solved), _) => solved,
            // What was found on the mesh before is not lost.
            (Err(error), Some(_)) if error.interrupted => break Some("it was interrupted".to_string()),
            (Err(error), Some(_)) => break Some(error.what),
            (Err(error), None) => return Err(error),
        };
        let SolvedLevel { prepared, outcome, indicators: Indicators { cells, error } } = solved;
        if outcome.solution.status != Status::Solved {
            if last.is_none() {
                return Ok((prepared, outcome));
            }
            let how = if outcome.solution.status == Status::Interrupted { "interrupted" } else { "not solved" };
            break Some(format!("the mesh with {} was {how}", many(prepared.problem.unknowns(), "unknown")));
        }
        history.add(level.number, &prepared, &outcome, error);
        history.levels.last().into_iter().for_each(&mut *observe);
        seconds.add(&outcome.seconds);
        fix_contacts(&mut level.case, &prepared);
        let u = full_displacement(&prepared.model, &outcome.solution.u);
        let peak = outcome.peak_memory;
        last = Some((prepared, outcome));
        let goals = history.goals(accuracy, history.levels.len());
        let enough = history.levels.len() >= LEAST_LEVELS || error <= EXACT;
        if enough && goals.iter().all(GoalRecord::met) {
            break None;
        }
        if history.levels.len() >= MOST_LEVELS {
            break Some(format!("{MOST_LEVELS} meshes were solved"));
        }
        let needed = history.needed(accuracy).filter(|_| history.levels.len() >= PREDICTING_LEVELS);
        let most = most_unknowns(accuracy, &history, &limit, peak);
        if let Some(why) = needed.and_then(|needed| out_of_reach(needed, most)) {
            break Some(why);
        }
        let marked = marking::marked(&cells, goal_of_sum(&goals, &cells));
        let (finer, start) = match finer(&bisection, &marked, accuracy, &u) {
            Ok(finer) => finer,
            Err(error) => break Some(error.what),
        };
        bisection = finer;
        level = Level {
            number: level.number + 1,
            case: on_mesh(&level.case, &bisection, &notes),
            // The last load step says nothing of the first.
            start: case.steps.is_empty().then_some(start),
        };
    };
    let Some((prepared, mut outcome)) = last else {
        return Err(Error::new("", "no mesh was solved", "report this to the developers with the case"));
    };
    outcome.seconds = seconds;
    outcome.accuracy = Some(history.record(accuracy, ended));
    Ok((prepared, outcome))
}

/// The next mesh, with the displacements `u` at its nodes.
fn finer(mesh: &Bisection, marked: &[u32], accuracy: &AccuracySpec, u: &[f64]) -> Result<(Bisection, Vec<f64>), Error> {
    let finer = refine(mesh, marked, BISECTIONS)?;
    let displacements = 3 * finer.next.mesh.nodes.len();
    if accuracy.max_unknowns.is_some_and(|most| displacements > most) {
        let what = format!("the next mesh has {displacements} displacements, more than `max_unknowns`");
        return Err(Error::new("", what, "allow more"));
    }
    let start = finer.carry(u)?;
    Ok((finer.next, start))
}

/// The case on the mesh of a level, where it is placed already.
fn on_mesh(case: &Case, bisection: &Bisection, notes: &MeshNotes) -> Case {
    let mut case = case.clone();
    case.mesh.source = MeshSource::Given(Arc::new((bisection.mesh.clone(), notes.clone())));
    case.mesh.placing = Placing::default();
    case
}

/// Keeps what the mesh decided: which surface of a pair carries the contact points, and how far its counterpart is looked for.
fn fix_contacts(case: &mut Case, prepared: &Prepared) {
    for (number, contact) in case.contacts.iter_mut().enumerate() {
        let AgainstSpec::Surface { slave, search, widened, .. } = &mut contact.against else { continue };
        let Some(surface) = prepared.contact_of.iter().position(|&of| of == number) else { continue };
        if let Counterpart::Surface(master) = &prepared.surfaces[surface].against {
            *slave = Some(master.slave);
        }
        if let Some(pair) = &prepared.facts.contacts[surface].surface.pair {
            (*search, *widened) = (Some(pair.search), None);
        }
    }
}

/// The most unknowns that may be solved, as far as the levels tell: memory grows with them in proportion once it is more
/// than the program's own.
fn most_unknowns(accuracy: &AccuracySpec, history: &History, limit: &MemoryLimit, peak: Option<u64>) -> f64 {
    let asked = accuracy.max_unknowns.map_or(f64::INFINITY, |most| most as f64);
    let last = history.levels.last().map_or(0.0, |level| level.unknowns as f64);
    let by_memory = match (limit.bytes, peak) {
        (Some(limit), Some(peak)) if peak > OWN_MEMORY => last * limit as f64 / peak as f64,
        _ => f64::INFINITY,
    };
    asked.min(by_memory)
}

/// Why a goal that needs so many unknowns is given up where there may be `most`.
fn out_of_reach(needed: f64, most: f64) -> Option<String> {
    (needed > BEYOND * most).then(|| format!("the goal is far beyond the {most:.0} unknowns that may be solved"))
}

/// What the sum of the indicators has to fall to, where the energy norm is all that is missing.
fn goal_of_sum(goals: &[GoalRecord], cells: &[f64]) -> Option<f64> {
    let mut missing = goals.iter().filter(|goal| !goal.met());
    let (energy, others) = (missing.next()?, missing.next());
    let reached = energy.reached.filter(|_| energy.name == ENERGY && others.is_none())?;
    Some(cells.iter().sum::<f64>() * (energy.asked / reached).powi(2))
}

/// The key of the goal that the estimate itself is held against.
const ENERGY: &str = "energy";

impl History {
    fn add(&mut self, level: usize, prepared: &Prepared, outcome: &Outcome, error: f64) {
        let values = values::values(prepared, outcome);
        let of_steps: usize = outcome.steps.iter().map(|step| step.answer.counts.steps()).sum();
        let counts = &outcome.solution.counts;
        self.levels.push(LevelRecord {
            level,
            cells: prepared.mesh.cell_count(),
            unknowns: prepared.problem.unknowns(),
            points: prepared.problem.points(),
            error,
            iterations: if outcome.steps.is_empty() { counts.newton_steps.max(counts.cycles) } else { of_steps },
            cpu_seconds: outcome.seconds.total().cpu,
            values: values::named(&values),
        });
        self.values.push(values);
    }

    fn errors(&self) -> Vec<f64> {
        self.levels.iter().map(|level| level.error).collect()
    }

    /// The goals, and what the first `levels` levels have reached.
    fn goals(&self, accuracy: &AccuracySpec, levels: usize) -> Vec<GoalRecord> {
        let (values, error) = (&self.values[..levels], &self.errors()[..levels]);
        let by_bars = |sort: Sort| values::worst_bar(values, error, sort);
        let all = [
            (ENERGY, accuracy.energy, error.last().copied()),
            ("forces", accuracy.forces, by_bars(Sort::Force)),
            ("displacement", accuracy.displacement, by_bars(Sort::Displacement)),
            ("pressure", accuracy.pressure, by_bars(Sort::Pressure)),
        ];
        let goal = |(name, asked, reached): (&str, Option<f64>, Option<f64>)| {
            asked.map(|asked| GoalRecord { name: name.into(), asked, reached })
        };
        all.into_iter().filter_map(goal).collect()
    }

    /// Unknowns at which all goals are expected to be met.
    fn needed(&self, accuracy: &AccuracySpec) -> Option<f64> {
        let by_level: Vec<Vec<GoalRecord>> =
            (1..=self.levels.len()).map(|levels| self.goals(accuracy, levels)).collect();
        let for_goal = |(i, goal): (usize, &GoalRecord)| {
            let known = self
                .levels
                .iter()
                .zip(&by_level)
                .filter_map(|(level, goals)| Some((level.unknowns, goals[i].reached?)));
            let (unknowns, reached): (Vec<usize>, Vec<f64>) = known.unzip();
            prediction::unknowns_for(&unknowns, &reached, goal.asked)
        };
        by_level.last()?.iter().enumerate().filter(|(_, goal)| !goal.met()).filter_map(for_goal).reduce(f64::max)
    }

    fn record(self, accuracy: &AccuracySpec, ended: Option<String>) -> AccuracyRecord {
        let goals = self.goals(accuracy, self.levels.len());
        let needed_unknowns = ended.as_ref().and_then(|_| self.needed(accuracy));
        let values = values::records(&self.values, &self.errors());
        AccuracyRecord { goals, reached: ended.is_none(), ended, needed_unknowns, levels: self.levels, values }
    }
}
