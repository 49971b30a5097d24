//! The loop over the levels.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::first::first;
use super::shape::{shapes, warnings};
use super::values::{self, EXACT, LEAST_LEVELS, Sort, Value};
use super::{marking, prediction};
use crate::Error;
use crate::contact::{Counterpart, Role};
use crate::fem::full_displacement;
use crate::friction::Status;
use crate::io::case::{AccuracySpec, AgainstSpec, Case, MeshSource, Placing};
use crate::io::text::number;
use crate::mesh::{Bisection, MeshNotes, many, refine};
use crate::run::pose::{MemoryLimit, Prepared, Seconds};
use crate::run::solve::{AccuracyRecord, GoalRecord, LevelRecord, Named, Outcome, contact_terms};

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
    /// Whether an earlier run has solved it.
    pub again: bool,
    /// What the first mesh leaves open of the gaps of each contact, length; empty on the first.
    shapes: Vec<f64>,
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
    /// Squared energy norm of the estimated error of each cell, and at contact surfaces what the laws miss between its nodes;
    /// energy.
    pub cells: Vec<f64>,
    /// Estimated error in the energy norm, relative: the largest of the steps, each over its own norm or a tenth of the largest.
    pub error: f64,
    /// The square of the error of each step so far, and of the norm it is compared with, energy.
    pub steps: Vec<[f64; 2]>,
    /// The cells at the largest pressures at the ends of the steps of the case.
    pub peaks: Vec<u32>,
    /// As of [`Level`].
    shapes: Vec<f64>,
    /// The values at the ends of all steps of the case but the last.
    earlier: Vec<Value>,
}

/// Of the largest energy norm of the load steps: a step with less than this part is compared with this part, because what is left of stress in
/// a body that is lifted off again is mostly rounding, whose relative error no mesh makes smaller.
const UNLOADED: f64 = 0.1;

impl Indicators {
    /// Of a level of which nothing is known yet.
    pub fn of(level: &Level) -> Indicators {
        Indicators { shapes: level.shapes.clone(), ..Indicators::default() }
    }

    /// Those that an earlier run has kept of its last level.
    pub(in crate::run) fn kept(cells: Vec<f64>, error: f64, peaks: Vec<u32>) -> Indicators {
        Indicators { cells, error, peaks, ..Indicators::default() }
    }

    /// Takes the larger of what is known and the errors of `outcome`, an answer on the same mesh at time `t`.
    pub fn add(&mut self, prepared: &Prepared, outcome: &Outcome, t: f64) {
        let Some(estimate) = &outcome.estimate else { return };
        self.steps.push([estimate.error2(), estimate.whole2()]);
        let largest = self.steps.iter().fold(0.0, |most: f64, step| most.max(step[1]));
        let relative = |[error, whole]: &[f64; 2]| error / whole.max(UNLOADED * UNLOADED * largest);
        let loaded = self.steps.iter().filter(|step| step[1] > 0.0);
        self.error = loaded.map(relative).fold(0.0, f64::max).sqrt();
        let mut cells = estimate.cells.clone();
        contact_terms(prepared, outcome).into_iter().for_each(|(cell, missed)| cells[cell as usize] += missed);
        self.cells.resize(cells.len(), 0.0);
        self.cells.iter_mut().zip(&cells).for_each(|(most, cell)| *most = most.max(*cell));
        let steps = &prepared.loading.steps;
        let end = steps.iter().position(|step| step.until == t);
        if end.is_some() || steps.is_empty() {
            self.peaks.extend(values::cells_at_peaks(prepared, outcome));
        }
        if end.is_some_and(|step| step + 1 < steps.len()) {
            // The first mesh has none yet.
            if self.shapes.len() != prepared.surfaces.len() {
                self.shapes = shapes(prepared);
            }
            self.earlier.extend(values::at_time(t, values::values(prepared, outcome, self.error, &self.shapes)));
        }
    }
}

/// The levels that were solved, with all that a later run needs to go on from the last of them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Sequence {
    /// One for each level.
    pub levels: Vec<LevelRecord>,
    values: Vec<Vec<Value>>,
    contacts: Vec<Fixed>,
    /// What the first mesh leaves open of the gaps of each contact, length.
    #[serde(default)]
    shapes: Vec<f64>,
    /// What finer meshes do not mend, in words.
    #[serde(default)]
    warnings: Vec<String>,
    /// Cells of each level but the last that were marked, in ascending order.
    #[serde(skip)]
    pub marked: Vec<Vec<u32>>,
    /// Where the error of the last level is.
    #[serde(skip)]
    pub indicators: Indicators,
    /// Displacements of all nodes of the last level, three each, length.
    #[serde(skip)]
    pub displacement: Vec<f64>,
}

/// What the first mesh decides for a contact with a surface, by the number of the contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Fixed {
    contact: usize,
    slave: Option<Role>,
    search: Option<f64>,
}

/// What is done on each level.
pub trait Levels {
    /// Solves a level.
    ///
    /// # Errors
    /// What ends the sequence.
    fn solve(&mut self, level: &Level) -> Result<SolvedLevel, Error>;

    /// A level is solved, the last of `sequence`.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn finished(&mut self, sequence: &Sequence) -> Result<(), Error>;
}

/// Solves `case` on ever finer meshes until the goals of `accuracy` are met. Goals are believed from the third level on: before, contact may not be resolved at all.
///
/// Goes on from `before`, the levels of an earlier run of the same case: their meshes are made again, and the last of them is
/// solved again from its displacements.
///
/// Ends early, with the reason in the record, where a later level cannot be made, is interrupted or not solved, where memory or
/// `max_unknowns` forbids it, and where a goal is predicted to take more than twice what they allow. The answer then is the last that
/// was solved.
///
/// # Errors
/// On the first level: what makes the mesh impossible to refine, more of it than `max_unknowns`, what [`Levels::solve`] returns. On any:
/// what [`Levels::finished`] returns. If the levels `before` are not of this case.
pub fn solve_to_accuracy(
    case: &Case,
    accuracy: &AccuracySpec,
    before: Option<Sequence>,
    work: &mut dyn Levels,
) -> Result<(Prepared, Outcome), Error> {
    let limit = MemoryLimit::of(&case.solver);
    let (mut bisection, notes) = first(case, accuracy, &limit)?;
    let (mut case, again) = (case.clone(), before.is_some());
    let mut sequence = before.unwrap_or_default();
    sequence.fix_contacts(&mut case);
    for (marked, level) in sequence.marked.iter().zip(&sequence.levels) {
        bisection = repeated(&bisection, marked, level)?;
    }
    let mut level = Level {
        number: sequence.marked.len(),
        start: (again && case.steps.is_empty()).then(|| sequence.displacement.clone()),
        case: on_mesh(&case, &bisection, &notes),
        again,
        shapes: sequence.shapes.clone(),
    };
    let mut last: Option<(Prepared, Outcome)> = None;
    let mut seconds = Seconds::default();
    let ended = loop {
        let solved = match (work.solve(&level), &last) {
            (Ok(solved), _) => solved,
            // What was found on the mesh before is not lost.
            (Err(error), Some(_)) if error.interrupted => break Some("it was interrupted".to_string()),
            (Err(error), Some(_)) => break Some(error.what),
            (Err(error), None) => return Err(error),
        };
        let SolvedLevel { prepared, outcome, indicators } = solved;
        if outcome.solution.status != Status::Solved {
            if last.is_none() {
                return Ok((prepared, outcome));
            }
            let how = if outcome.solution.status == Status::Interrupted { "interrupted" } else { "not solved" };
            break Some(format!("the mesh with {} was {how}", many(prepared.problem.unknowns(), "unknown")));
        }
        if !level.again {
            sequence.add(&prepared, &outcome, indicators);
            sequence.fix_contacts(&mut case);
        }
        sequence.bounded(&outcome);
        if !level.again {
            work.finished(&sequence)?;
        }
        seconds.add(&outcome.seconds);
        let peak = outcome.peak_memory;
        last = Some((prepared, outcome));
        let goals = sequence.goals(accuracy, sequence.levels.len());
        let is_proven = accuracy.proven && sequence.is_bounded();
        let enough = sequence.levels.len() >= LEAST_LEVELS || sequence.is_exact() || is_proven;
        if enough && goals.iter().all(GoalRecord::met) {
            break None;
        }
        if sequence.levels.len() >= MOST_LEVELS {
            break Some(format!("{MOST_LEVELS} meshes were solved"));
        }
        if let Some(why) = sequence.open_by_shape(&goals).filter(|_| enough) {
            break Some(why);
        }
        let needed = sequence.needed(accuracy).filter(|_| sequence.levels.len() >= PREDICTING_LEVELS);
        let most = most_unknowns(&sequence, &limit, peak);
        if let Some(why) = needed.and_then(|needed| out_of_reach(needed, most)) {
            break Some(why);
        }
        let cells = &sequence.indicators.cells;
        let mut marked = marking::marked(cells, goal_of_sum(&goals, cells));
        let misses_pressure = goals.iter().any(|goal| goal.name == PRESSURE && !goal.met());
        if misses_pressure {
            // Without finer cells at a peak no mesh tells more of it.
            marking::mark_also(&mut marked, sequence.indicators.peaks.clone());
        }
        let (finer, start) = match finer(&bisection, &marked, accuracy, &sequence.displacement) {
            Ok(finer) => finer,
            Err(error) => break Some(error.what),
        };
        sequence.marked.push(marked);
        bisection = finer;
        level = Level {
            number: level.number + 1,
            // The last load step says nothing of the first.
            start: case.steps.is_empty().then_some(start),
            case: on_mesh(&case, &bisection, &notes),
            again: false,
            shapes: sequence.shapes.clone(),
        };
    };
    let Some((prepared, mut outcome)) = last else {
        return Err(Error::new("", "no mesh was solved", "report this to the developers with the case"));
    };
    outcome.seconds = seconds;
    outcome.accuracy = Some(sequence.record(accuracy, ended));
    Ok((prepared, outcome))
}

/// A mesh that an earlier run has refined, once more; `level` is what that run says of it.
fn repeated(mesh: &Bisection, marked: &[u32], level: &LevelRecord) -> Result<Bisection, Error> {
    let cells = mesh.mesh.cell_count();
    if level.cells != cells || marked.iter().any(|&cell| cell as usize >= cells) {
        return Err(other_case());
    }
    Ok(refine(mesh, marked, BISECTIONS)?.next)
}

/// Refuses to go on with levels that are not of the case.
pub(in crate::run) fn other_case() -> Error {
    let remedy = "resume with the case and the mesh that the run began with, choose another folder with -o DIR, or solve \
                  without --resume";
    Error::new("", "the meshes that were solved before are of another case", remedy)
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

/// What the mesh of a posed case decides.
fn decided(prepared: &Prepared) -> Vec<Fixed> {
    let of_surface = |(surface, &contact): (usize, &usize)| {
        let slave = match &prepared.surfaces[surface].against {
            Counterpart::Surface(master) => Some(master.slave),
            Counterpart::Obstacle(_) => None,
        };
        let search = prepared.facts.contacts[surface].surface.pair.as_ref().map(|pair| pair.search);
        Fixed { contact, slave, search }
    };
    prepared.contact_of.iter().enumerate().map(of_surface).collect()
}

/// The most unknowns that memory allows, as far as the levels tell: it grows with them in proportion once it is more
/// than the program's own. `max_unknowns` ends the sequence where it is met: up to there the user has agreed to the time, and
/// predictions may be ten times too large.
fn most_unknowns(sequence: &Sequence, limit: &MemoryLimit, peak: Option<u64>) -> f64 {
    let last = sequence.levels.last().map_or(0.0, |level| level.unknowns as f64);
    match (limit.bytes, peak) {
        (Some(limit), Some(peak)) if peak > OWN_MEMORY => last * limit as f64 / peak as f64,
        _ => f64::INFINITY,
    }
}

/// Why a goal that needs so many unknowns is given up where there may be `most`.
fn out_of_reach(needed: f64, most: f64) -> Option<String> {
    (needed > BEYOND * most).then(|| format!("the goal is far beyond the {most:.0} unknowns that memory allows"))
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
/// The key of the goal that is missed as long as a peak is not resolved.
const PRESSURE: &str = "pressure";
/// The keys of the goals of values.
const SORTS: [(&str, Sort); 3] =
    [("forces", Sort::Force), ("displacement", Sort::Displacement), (PRESSURE, Sort::Pressure)];

impl Sequence {
    fn add(&mut self, prepared: &Prepared, outcome: &Outcome, mut indicators: Indicators) {
        // There are none before the first mesh.
        if self.shapes.len() != prepared.surfaces.len() {
            self.shapes = shapes(prepared);
        }
        self.warnings = warnings(prepared, outcome, &self.shapes);
        let mut values = values::values(prepared, outcome, indicators.error, &self.shapes);
        values.append(&mut indicators.earlier);
        let of_steps: usize = outcome.steps.iter().map(|step| step.answer.counts.steps()).sum();
        let counts = &outcome.solution.counts;
        self.levels.push(LevelRecord {
            level: self.levels.len(),
            cells: prepared.mesh.cell_count(),
            unknowns: prepared.problem.unknowns(),
            points: prepared.facts.points,
            error: indicators.error,
            bound: None,
            iterations: if outcome.steps.is_empty() { counts.newton_steps.max(counts.cycles) } else { of_steps },
            cpu_seconds: outcome.seconds.total().cpu,
            values: values::named(&values),
            bars: Named::default(),
        });
        self.values.push(values);
        let errors = self.errors();
        if let Some(level) = self.levels.last_mut() {
            level.bars = values::bars(&self.values, &errors);
        }
        self.contacts = decided(prepared);
        self.displacement = full_displacement(&prepared.model, &outcome.solution.u);
        self.indicators = indicators;
    }

    /// Takes the bound of the last level, if it has one.
    fn bounded(&mut self, outcome: &Outcome) {
        let bound = outcome.bound.as_ref().and_then(|bound| bound.as_ref().ok());
        if let (Some(level), Some(bound)) = (self.levels.last_mut(), bound) {
            level.bound = Some(bound.mean_relative());
        }
    }

    fn is_exact(&self) -> bool {
        self.indicators.error <= EXACT
    }

    fn is_bounded(&self) -> bool {
        self.levels.last().is_some_and(|level| level.bound.is_some())
    }

    /// Tells a case what the first mesh has decided: which surface of a pair carries the contact points, and how far its
    /// counterpart is looked for.
    pub(in crate::run) fn fix_contacts(&self, case: &mut Case) {
        for fixed in &self.contacts {
            let against = case.contacts.get_mut(fixed.contact).map(|contact| &mut contact.against);
            if let Some(AgainstSpec::Surface { slave, search, widened, .. }) = against {
                *slave = fixed.slave.or(*slave);
                if fixed.search.is_some() {
                    (*search, *widened) = (fixed.search, None);
                }
            }
        }
    }

    fn errors(&self) -> Vec<f64> {
        self.levels.iter().map(|level| level.error).collect()
    }

    /// The goals, and what the first `levels` levels have reached.
    fn goals(&self, accuracy: &AccuracySpec, levels: usize) -> Vec<GoalRecord> {
        let (values, error) = (&self.values[..levels], &self.errors()[..levels]);
        let by_bars = |sort: Sort| values::worst_bar(values, error, sort);
        let all = [
            (ENERGY, accuracy.energy, self.levels[..levels].last().map(|level| level.known(accuracy.proven))),
            (SORTS[0].0, accuracy.forces, by_bars(SORTS[0].1)),
            (SORTS[1].0, accuracy.displacement, by_bars(SORTS[1].1)),
            (SORTS[2].0, accuracy.pressure, by_bars(SORTS[2].1)),
        ];
        let goal = |(name, asked, reached): (&str, Option<f64>, Option<f64>)| {
            asked.map(|asked| GoalRecord { name: name.into(), asked, reached })
        };
        all.into_iter().filter_map(goal).collect()
    }

    /// Why a goal of values is missed on any mesh with the shape of the first one, where all others are met.
    fn open_by_shape(&self, goals: &[GoalRecord]) -> Option<String> {
        let mut missed = goals.iter().filter(|goal| !goal.met());
        let least = |goal: &GoalRecord| {
            let sort = SORTS.iter().find(|(name, _)| *name == goal.name)?.1;
            Some(values::least_bar(&self.values, sort)).filter(|least| *least > goal.asked)
        };
        let all: Option<Vec<f64>> = missed.by_ref().map(least).collect();
        let most = all?.into_iter().reduce(f64::max)?;
        let by = if most.is_finite() { format!(" by {} %", number((1e3 * most).ceil() / 10.0)) } else { String::new() };
        Some(format!("the shape of the first mesh leaves the values open{by}, whatever the cells"))
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
        // Where the shape forbids a goal no mesh meets it.
        let may_be_met = ended.is_some() && self.open_by_shape(&goals).is_none();
        let needed_unknowns = if may_be_met { self.needed(accuracy) } else { None };
        let values = values::records(&self.values, &self.errors());
        let (reached, warnings) = (ended.is_none(), self.warnings);
        AccuracyRecord { goals, reached, ended, needed_unknowns, levels: self.levels, values, warnings }
    }
}
