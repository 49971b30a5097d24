//! A case on several ranks: divided, posed, solved, certified.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::estimate::{add_estimate, estimate};
use super::facts::facts;
use super::fretting::{add_step, figures, records};
use super::gather::WholeAnswer;
use super::keep::{Keep, Kept, widened_before};
use super::local::{Local, local};
use super::loose::move_back;
use super::refine::refined;
use super::remarks::{Remarks, couples, largest_displacement, look as look_at};
use super::report::{Known, iterations, rows};
use super::share::Share;
use super::steps::slid as sliding;
use super::tighten::{Answer, Found, March, Solver};
use super::timed::note_where_it_stands;
use super::tractions::{RankTractions, tractions};
use super::{energy, nested, record, room, scope, share, small};
use crate::Error;
use crate::certificate::ghost_values;
use crate::contact::ContactProblem;
use crate::contact::escape::Escape;
use crate::fem::full_displacement;
use crate::friction::{self, Multigrid, PointState, Progress, Solution, Status};
use crate::io::case::Case;
use crate::io::machine;
use crate::linalg::{Stop, Watch};
use crate::mesh::v3::{V3, add, scale};
use crate::ranks::{Counted, Ranks, Traffic, agree, broadcast, gather_all, max, sum};
use crate::run::pose::axis::Position;
use crate::run::pose::bolts::Target;
use crate::run::pose::loads::end;
use crate::run::pose::{Seconds, Span, stopwatch};
use crate::run::results::facts_text::problem_rows;
use crate::run::results::report::Laws;
use crate::run::results::{FIGURES, Fretting, RankRecord, RanksRecord, Row, Summary, Versions};
use crate::run::solve::extrapolation::KEPT;
use crate::run::solve::passing::{Searches, with_searches};
use crate::run::solve::tractions::Traction;
use crate::run::solve::{AnswerRecord, BalanceRecord, SlidingRecord, StepRecord};
use crate::run::whole::{MOST_WIDENINGS, Stage};
use crate::solve::multigrid_cycles;

/// The answer of one rank, and what all of them know together.
pub struct RankedAnswer {
    pub(super) local: Local,
    /// The time of the answer.
    pub(super) t: f64,
    /// Displacements of all nodes here, along x, y, z.
    pub(super) u: Vec<V3>,
    /// The same of all unknowns here.
    pub(super) free: Vec<f64>,
    /// Multipliers of all points here, newton, `3m`, and their states.
    pub(super) lambda: Vec<f64>,
    pub(super) states: Vec<PointState>,
    /// Pressure and shear of all points here.
    pub(super) tractions: Vec<Traction>,
    /// Of each pair at own nodes of the other surface that points reach.
    pub(super) masters: Vec<Vec<(u32, Traction)>>,
    /// What load steps have done to the contact points here, see [`PointHistory::figures`](crate::run::results::PointHistory::figures); of own
    /// ones, and empty without load steps.
    pub(super) figures: Vec<[f64; FIGURES]>,
    /// Shortening of each bolt, length.
    pub(super) shortening: Vec<f64>,
    /// Further solutions: displacements of all unknowns and multipliers of all points here.
    pub(super) others: Vec<[Vec<f64>; 2]>,
    /// Estimated error of the stress of each cell here, see [`Estimate::by_cell`](crate::accuracy::Estimate::by_cell); empty where the
    /// loads carry a body away.
    pub(super) error: Vec<f64>,
    /// Times of this rank.
    pub(super) seconds: Seconds,
    /// What was told of each cycle of the last increment.
    pub history: Vec<Progress>,
    /// The same on every rank.
    pub summary: Summary,
}

impl RankedAnswer {
    /// The nodes of this rank, by their numbers in the whole mesh, with their displacements; length.
    pub fn displacements(&self) -> Vec<(u64, [f64; 3])> {
        let own = (0..self.u.len()).filter(|&v| self.local.division.is_own(v as u32));
        own.map(|v| (self.local.piece.nodes[v], self.u[v])).collect()
    }
}

/// Solves a case on all ranks: each has its piece of the mesh, and no rank has more than that once it is posed.
/// `observer` is told of every cycle; it ends all ranks if one of them says so.
///
/// # Errors
/// What makes the case impossible to pose, or cannot be divided; the same at every rank.
pub fn solve_on_ranks(
    case: &Case,
    ranks: &Arc<dyn Ranks>,
    observer: &mut Watch<Progress>,
) -> Result<RankedAnswer, Error> {
    solve_steps_on_ranks(case, ranks, None, observer)
}

/// As [`solve_on_ranks`]; with `keep` load steps are kept in a folder as they are solved, and the run goes on after those that it
/// holds already, if that is asked for.
///
/// # Errors
/// As [`solve_on_ranks`]; and if files of steps cannot be written, or those to go on from are of another case.
pub fn solve_steps_on_ranks(
    case: &Case,
    ranks: &Arc<dyn Ranks>,
    keep: Option<&Keep>,
    observer: &mut Watch<Progress>,
) -> Result<RankedAnswer, Error> {
    agree(&**ranks, scope::check(case))?;
    if let Some(accuracy) = case.accuracy.as_ref().filter(|accuracy| accuracy.refines()) {
        return refined((case, accuracy), ranks, keep, observer, small::MOST_UNKNOWNS);
    }
    let (mut case, mut keep) = (case.clone(), keep.cloned());
    if let Some(keep) = keep.as_ref().filter(|_| !case.steps.is_empty()) {
        case = widened_before(keep, case, &**ranks)?;
    }
    let mut widenings = 0;
    loop {
        let begun = Begun::new(ranks);
        let share = share::share(&case, &*begun.ranks)?;
        let tell = keep.as_ref().map(|keep| keep.tell);
        let how = How { keep: keep.as_ref(), tell, of_case: true, ..How::default() };
        let Solved { mut answer, needed, .. } = begun.solved((&case, share), how, observer)?;
        match with_searches(&case, &needed).filter(|_| widenings < MOST_WIDENINGS) {
            Some(wider) => (case, widenings) = (wider, widenings + 1),
            None => {
                add_estimate(&case, &mut answer);
                return Ok(answer);
            }
        }
        tell_again(keep.as_ref(), &answer, &**ranks);
        keep.iter_mut().for_each(|keep| keep.resume = false);
    }
}

/// Says that a case is solved again with contact that was found beyond where it was looked for.
fn tell_again(keep: Option<&Keep>, answer: &RankedAnswer, ranks: &dyn Ranks) {
    if let Some(keep) = keep.filter(|_| ranks.rank() == 0) {
        let what = answer.summary.passes_through();
        (keep.tell)(&Stage::Note(&format!("\n{what}\nsolved again with contact there\n")));
    }
}

/// What a solve starts from, where there is something.
pub(super) enum Start {
    /// Displacements of the nodes here along x, y, z, length.
    Displacements(Vec<V3>),
    /// The answer, to be judged, with what rank 0 knows of it.
    Answer(WholeAnswer, Box<AnswerRecord>),
}

/// Told of every answer: of each increment as it is solved, or of the only one at last. All ranks are, and an error of one of them is one of all.
pub(super) type Look<'a> = dyn FnMut(&Local, &Found, f64) -> Result<(), Error> + 'a;

/// How a share is solved.
#[derive(Default)]
pub(super) struct How<'a> {
    pub start: Option<Start>,
    pub keep: Option<&'a Keep>,
    /// Told at rank 0 what the case amounts to.
    pub tell: Option<fn(&Stage)>,
    /// With it rank 0 solves nothing alone.
    pub look: Option<&'a mut Look<'a>>,
    /// Whether the share is of the mesh that the case has, at every rank, which a coarser one may stand for to begin with.
    pub of_case: bool,
}

/// An answer with what the loop over meshes wants to know of it.
pub(super) struct Solved {
    pub answer: RankedAnswer,
    /// Of all ranks, see [`record::of_all`].
    pub seconds: Seconds,
    /// How far the surfaces of contacts have to be looked for.
    pub needed: Searches,
}

/// A solve under way.
pub(super) struct Begun {
    pub ranks: Arc<dyn Ranks>,
    counted: Arc<Counted>,
    lap: Box<dyn FnMut() -> Span>,
}

impl Begun {
    pub(super) fn new(ranks: &Arc<dyn Ranks>) -> Self {
        let counted = Arc::new(Counted::new(Arc::clone(ranks)));
        Begun { ranks: counted.clone(), counted, lap: Box::new(stopwatch()) }
    }

    /// Poses the share of each rank and solves.
    ///
    /// # Errors
    /// As [`solve_steps_on_ranks`].
    pub(super) fn solved(
        self,
        (case, share): (&Case, Share),
        How { start, keep, tell, mut look, of_case }: How,
        observer: &mut Watch<Progress>,
    ) -> Result<Solved, Error> {
        let Begun { ranks, counted, mut lap } = self;
        let mut seconds = Seconds { mesh: lap(), ..Seconds::default() };
        let limit = room::limit(case, &*ranks);
        room::piece_fits(&share.piece.mesh, &limit, &*ranks)?;
        let mut local = local(case, share, &ranks)?;
        room::hierarchy_fits(&local, &limit, &*ranks)?;
        let asked = scope::of_rank_0(case).is_some();
        scope::check_size(case, unknowns(&local))?;
        let problem = told(case, &local, tell)?;
        seconds.assembly = lap();
        let (mut multigrid, own) = Multigrid::divided(&local.problem, &local.division, &Stop::never())?;
        seconds.setup = lap();
        let begins = of_case && start.is_none() && case.steps.is_empty();
        let nested = if begins { nested::start(case, &local) } else { None };
        let before = counted.traffic();
        let settings = friction::Settings {
            tolerance: case.solver.tolerance,
            max_iterations: multigrid_cycles(case.solver.max_iterations),
            path: friction::SolverPath::Multigrid,
            ..friction::Settings::default()
        };
        let mut kept =
            keep.filter(|_| !case.steps.is_empty()).map(|keep| Kept::begin(keep, case, &local)).transpose()?;
        let (mut of_first, mut others) = (None, Vec::new());
        let mut by_first = None;
        if let Some(Start::Answer(answer, known)) = &start {
            let found = small::taken(case, (&mut local, &mut multigrid), answer, end(case), known)?;
            of_first = found.is_some().then(|| (**known).clone());
            by_first = found.map(|found| (found, Vec::new(), Fretting::default()));
        } else if asked {
            let found = small::by_first(case, &mut local, &mut multigrid, kept.as_mut(), observer)?;
            by_first = found.map(|found| {
                (of_first, others) = (Some(found.answer), found.others);
                (found.last, found.steps, found.fretting)
            });
        }
        let looks = by_first.is_none() && look.is_none();
        let Marched { mut found, mut steps, mut fretting, mut remarks, escape, mut sliding } = match by_first {
            Some((mut found, steps, fretting)) => {
                let t = steps.last().map_or(end(case), |step| step.t);
                let remarks = look_at(case, (&local, multigrid.motions()), &mut None, &mut found, t)?;
                Marched { found, steps, fretting, remarks, escape: None, sliding: None }
            }
            None => {
                let start = start.map(|start| start.displacements(&local)).or(nested);
                let each = (kept.as_mut(), look.as_deref_mut());
                march(case, (&mut local, &mut multigrid, own), (settings, start, looks), each, observer)?
            }
        };
        let unsolved = matches!(found.solution.status, Status::Stalled | Status::MaxIterations);
        if unsolved
            && looks
            && !asked
            && unknowns(&local) <= small::MOST_UNKNOWNS
            && let Some(mut other) = small::by_first(case, &mut local, &mut multigrid, kept.as_mut(), observer)?
        {
            other.answer.counts.cycles += found.solution.counts.cycles;
            (found, steps, fretting, sliding) = (other.last, other.steps, other.fretting, None);
            of_first = Some(other.answer);
            let t = steps.last().map_or(end(case), |step| step.t);
            remarks = look_at(case, (&local, multigrid.motions()), &mut None, &mut found, t)?;
        }
        let escape = escape.filter(|_| found.solution.status == Status::NoEquilibrium);
        if escape.is_some() {
            remarks = Remarks { micromotions: remarks.micromotions, ..Remarks::default() };
        }
        let tractions = tractions(&local, &found.everywhere.free, &found.everywhere.lambda);
        let t = steps.last().map_or(end(case), |step| step.t);
        let mut answer = record::answer(case, (&local, &multigrid), &found, &remarks, &tractions, t);
        answer.escape_mode = escape.as_ref().map(|escape: &Escape| escape.motion.clone());
        answer.sliding = sliding;
        if let Some(last) = steps.last_mut() {
            (last.answer.escape_mode, last.answer.sliding) = (answer.escape_mode.clone(), answer.sliding.clone());
        }
        let found_by_first = of_first.is_some();
        of_first.into_iter().for_each(|of_first| record::take_way(&mut answer, of_first));
        let (couples, displacement) = (couples(&local, &found), largest_displacement(&local, &found));
        seconds.iteration = lap();
        let traffic = since(before, counted.traffic());
        let parts =
            RanksRecord { found_by_first, ..parts(&local, &multigrid, iterations(&answer, &steps).max(1), traffic) };
        let step = steps.last().and_then(|last| case.steps.iter().position(|step| step.name == last.name));
        let targets = local.bolts.iter().filter_map(|bolt| bolt.bolt.target(step.unwrap_or(0), t).ok()).collect();
        let mut summary = Summary {
            title: case.title.clone(),
            units: case.units.clone(),
            answer,
            overrides: Vec::new(),
            versions: Versions::default(),
            balance: steps.last().map(|last| last.balance),
            fretting: if steps.is_empty() { Vec::new() } else { records(&fretting, case, &local) },
            steps,
            accuracy: None,
            bound: None,
            command: None,
            problem,
            report: Vec::new(),
            pictures: Vec::new(),
            ranks: Some(parts),
        };
        let (certificate, laws) = (&found.solution.certificate, laws(&local));
        let known = Known { certificate, couples: &couples, displacement, escape: escape.as_ref(), targets, laws };
        summary.report = rows(case, &summary, known);
        let figures = if summary.steps.is_empty() { Vec::new() } else { figures(&fretting, case, &local, &found) };
        // What looks at the only answer of a case has room then.
        drop(multigrid);
        if let Some(look) = look.filter(|_| case.steps.is_empty()) {
            look(&local, &found, end(case))?;
            seconds.output = lap();
        }
        let of_all = record::of_all(&seconds, &*ranks);
        record::take_cost(&mut summary.answer, &of_all, &*ranks);
        let Found { solution, everywhere: Everywhere { u, free, lambda, states }, shortening, .. } = found;
        let history = solution.history;
        let RankTractions { points: tractions, masters, .. } = tractions;
        let answer = RankedAnswer {
            local,
            t,
            u,
            free,
            lambda,
            tractions,
            masters,
            figures,
            states,
            shortening,
            others,
            error: Vec::new(),
            seconds,
            history,
            summary,
        };
        Ok(Solved { answer, seconds: of_all, needed: remarks.needed })
    }
}

/// Which laws the points of all ranks have.
fn laws(local: &Local) -> Laws {
    let Laws { cohesive, coulomb } = Laws::of(&local.problem.contact.friction);
    let mut any = [cohesive, coulomb].map(|any| f64::from(u8::from(any)));
    max(&*local.division.ranks, &mut any);
    Laws { cohesive: any[0] > 0.0, coulomb: any[1] > 0.0 }
}

impl Start {
    /// Those of all unknowns here.
    pub(super) fn displacements(self, local: &Local) -> Vec<f64> {
        let u = match self {
            Start::Displacements(u) => u,
            Start::Answer(answer, _) => {
                let of = |&v: &u64| answer.u.get(v as usize).copied().unwrap_or_default();
                local.piece.nodes.iter().map(of).collect()
            }
        };
        let mut components = u.into_flattened();
        local.model.dofs.to_components(&mut components);
        let dofs = &local.model.dofs;
        dofs.free.iter().map(|&dof| components[dofs.mesh_dof(dof) as usize]).collect()
    }
}

/// The last answer, the records of all increments, what the points here have been through, and what is to be remarked.
pub(super) struct Marched {
    pub found: Found,
    steps: Vec<StepRecord>,
    fretting: Fretting,
    remarks: Remarks,
    /// How loads without equilibrium carry a body away in the last increment.
    escape: Option<Escape>,
    /// Where it is not solved, and friction may have reached its limit.
    sliding: Option<SlidingRecord>,
}

/// Solves the increments of all load steps, or without steps what acts at once. Before each statics looks for an equilibrium, if `looks`
/// says so.
pub(super) fn march(
    case: &Case,
    (local, multigrid, own): (&mut Local, &mut Multigrid, ContactProblem),
    (settings, start, looks): (friction::Settings, Option<Vec<f64>>, bool),
    (mut kept, mut look): (Option<&mut Kept>, Option<&mut Look>),
    observer: &mut Watch<Progress>,
) -> Result<Marched, Error> {
    let ranks = Arc::clone(&local.division.ranks);
    let mut stopped = false;
    let mut watch = |progress: &Progress| {
        stopped |= observer(progress).is_break();
        if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let (slid, shortening) = (vec![0.0; 2 * local.problem.points()], vec![0.0; local.bolts.len()]);
    let (lost, answers) = (Vec::new(), Vec::new());
    let (at, body) = (Position::start(), energy::at_rest(local));
    let fretting = Fretting::default();
    let mut march = March { at, slid, shortening, lost, answers, start, moved: None, body, fretting };
    let mut steps = Vec::new();
    if let Some(finished) = kept.as_mut().and_then(|kept| kept.finished()) {
        steps = march.go_on(finished, local, case)?;
    }
    let max_iterations = settings.max_iterations;
    let mut solver = Solver { local, multigrid, own, case, settings, observer: &mut watch, attempts: 0 };
    let mut lap = stopwatch();
    loop {
        let span = march.at.span(&case.steps);
        let t = span.map_or(end(case), |[_, t]| t);
        let targets = solver.local.bolts.iter().map(|b| b.bolt.target(march.at.step, t)).collect::<Result<Vec<_>, _>>();
        let mut targets = agree(&*ranks, targets)?;
        let escape = if looks { solver.escape(&march, &targets, t)? } else { None };
        let departs = escape.is_some();
        if departs {
            // No search ends where nothing bears the forces: bolts stay as short as they are.
            for (target, &s) in targets.iter_mut().zip(&march.shortening) {
                if !matches!(target, Target::Shortening(_)) {
                    *target = Target::Shortening(s);
                }
            }
        }
        solver.settings.max_iterations = if departs { 0 } else { max_iterations };
        let mut found = solver.step(&march, &targets, t)?;
        if departs && found.solution.status != Status::Interrupted {
            found.solution.status = Status::NoEquilibrium;
        }
        let unsolved = [Status::MaxIterations, Status::Stalled, Status::NoEquilibrium];
        let may_be_shorter = span.is_some() && unsolved.contains(&found.solution.status);
        if may_be_shorter
            && (found.solution.status == Status::NoEquilibrium || !found.solution.certificate.is_as_good_as_the_data())
            && let Some(shorter) = march.at.halve()
        {
            march.at = shorter;
            continue;
        }
        let (before, tolerance) = (march.answers.last().map(|answer| &answer.u[..]), solver.settings.tolerance);
        move_back(solver.local, solver.multigrid.motions(), before, tolerance, &mut found);
        let remarks = look_at(case, (solver.local, solver.multigrid.motions()), &mut march.moved, &mut found, t)?;
        let beyond = solver.limit_load(&march, &found);
        let Some([begin, t]) = span else {
            return Ok(Marched { found, steps, fretting: march.fretting, remarks, escape, sliding: beyond });
        };
        let solved = found.solution.status == Status::Solved;
        look.as_mut().map_or(Ok(()), |look| look(solver.local, &found, t))?;
        let tractions = tractions(solver.local, &found.everywhere.free, &found.everywhere.lambda);
        add_step(&mut march.fretting, solver.local, &found.everywhere, &found.shortening, &tractions);
        let of = (&*solver.local, &*solver.multigrid);
        let mut answer = record::answer(case, of, &found, &remarks, &tractions, t);
        if answer.status != Status::NoEquilibrium {
            answer.discretisation_error = Some(estimate(case, of.0, &found.everywhere.u, &found.shortening).0);
        }
        let seconds = Seconds { iteration: lap(), ..Seconds::default() };
        record::take_cost(&mut answer, &record::of_all(&seconds, &*ranks), &*ranks);
        march.body = energy::after(of.0, &mut march.body, &found.everywhere, t);
        let name = case.steps.get(march.at.step).map_or(String::new(), |step| step.name.clone());
        let attempts = std::mem::take(&mut solver.attempts);
        let balance = BalanceRecord::of(&march.body.balance);
        steps.push(StepRecord { step: steps.len() + 1, name, t, dt: t - begin, attempts, answer, balance });
        march.at = march.at.advance(&case.steps);
        if let Some(kept) = &mut kept {
            let Everywhere { free, lambda, states, .. } = &found.everywhere;
            kept.add((solver.local, case), (free, lambda, states), (&steps, &march.fretting), march.at)?;
        }
        if !solved || march.at.span(&case.steps).is_none() {
            return Ok(Marched { found, steps, fretting: march.fretting, remarks, escape, sliding: beyond });
        }
        march.slid = sliding(solver.local, &found.everywhere.free);
        march.lost.clone_from(&solver.local.timed.lost);
        note_where_it_stands(solver.local, &found.everywhere.free, t);
        let problem = &solver.local.problem;
        let (f, gap) = (problem.elastic.f.clone(), problem.contact.gap.clone());
        march.answers.push(Answer { t, f, gap, u: found.everywhere.free });
        if march.answers.len() > KEPT {
            march.answers.remove(0);
        }
        march.shortening = found.shortening;
    }
}

/// Unknown displacements of all ranks.
pub(super) fn unknowns(local: &Local) -> usize {
    let labels = local.problem.elastic.node_of.iter().flatten();
    let mut sums = [labels.filter(|&&label| local.division.is_own(label)).count() as f64];
    sum(&*local.division.ranks, &mut sums);
    sums[0] as usize
}

/// Tells what the case amounts to, and returns that, the same on every rank.
///
/// # Errors
/// As [`facts`].
fn told(case: &Case, local: &Local, tell: Option<fn(&Stage)>) -> Result<Vec<Row>, Error> {
    let facts = facts(case, local)?;
    if let (Some(facts), Some(tell)) = (&facts, tell) {
        tell(&Stage::Posed(facts, 0));
    }
    let rows = serde_json::to_vec(&facts.map(|facts| problem_rows(&facts))).unwrap_or_default();
    let rows = serde_json::from_slice(&broadcast(&*local.division.ranks, rows));
    Ok(rows.ok().flatten().unwrap_or_default())
}

fn since(before: Traffic, now: Traffic) -> Traffic {
    Traffic {
        exchanges: now.exchanges - before.exchanges,
        messages: now.messages - before.messages,
        bytes: now.bytes - before.bytes,
        halo_exchanges: now.halo_exchanges - before.halo_exchanges,
        halo_bytes: now.halo_bytes - before.halo_bytes,
        sums: now.sums - before.sums,
    }
}

/// An answer here: displacements of all unknowns and of all nodes, multipliers and states of all points.
pub(super) struct Everywhere {
    pub free: Vec<f64>,
    pub u: Vec<V3>,
    pub lambda: Vec<f64>,
    pub states: Vec<PointState>,
}

/// The answer at all nodes and points here: what belongs to other ranks is asked of them.
pub(super) fn everywhere(local: &Local, multigrid: &Multigrid, solution: &Solution) -> Everywhere {
    let (own, m) = (multigrid.own_points(), local.problem.points());
    let (mut lambda, mut codes) = (vec![0.0; 3 * m], vec![0.0; 3 * m]);
    for (place, &j) in own.iter().enumerate() {
        let j = j as usize;
        (0..3).for_each(|r| lambda[r * m + j] = solution.lambda[r * own.len() + place]);
        codes[j] = f64::from(solution.states[place].code());
    }
    let (free, lambda) = ghost_values(&local.problem, &local.division, &solution.u, &lambda);
    let (_, codes) = ghost_values(&local.problem, &local.division, &solution.u, &codes);
    let state = |code: &f64| PointState::of_code(*code as usize).unwrap_or(PointState::Open);
    let full = full_displacement(&local.model, &free);
    let (u, states) = (full.as_chunks().0.to_vec(), codes[..m].iter().map(state).collect());
    Everywhere { free, u, lambda, states }
}

/// The entries of a row of `B` here by degrees of freedom, free ones and prescribed ones.
pub(super) fn entries(local: &Local, row: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
    let (problem, dofs) = (&local.problem, &local.model.dofs);
    let (columns, values) = problem.contact.B.row(row);
    let free = columns.iter().zip(values).map(|(&k, v)| (dofs.free[k as usize], *v));
    let (columns, values) = problem.labels.supports.as_ref().map_or((&[][..], &[][..]), |s| s.B.row(row));
    free.chain(columns.iter().zip(values).map(|(&k, v)| (dofs.prescribed[k as usize], *v)))
}

/// The node of a point and its rows there, along x, y, z: normal, tangents.
pub(super) fn axes(local: &Local, j: usize) -> (u32, [V3; 3]) {
    let (problem, dofs) = (&local.problem, &local.model.dofs);
    let node = local.division.points[j];
    let mut axes = [[0.0; 3]; 3];
    for (axis, i) in axes.iter_mut().zip(problem.rows(j)) {
        for (dof, value) in entries(local, i).filter(|(dof, _)| dof / 3 == node) {
            *axis = add(*axis, scale(value, dofs.direction(dof)));
        }
    }
    (dofs.mesh_node(node), axes)
}

/// What the ranks have had and sent in so many cycles.
fn parts(local: &Local, multigrid: &Multigrid, cycles: usize, traffic: Traffic) -> RanksRecord {
    let ranks = &*local.division.ranks;
    let [own, ghosts] = multigrid.nodes_here();
    let per_cycle = |count: u64| count as f64 / cycles as f64;
    let record = RankRecord {
        nodes: own,
        ghosts,
        points: multigrid.own_points().len(),
        exchanges_per_cycle: per_cycle(traffic.halo_exchanges),
        bytes_per_cycle: per_cycle(traffic.halo_bytes),
        messages_per_cycle: per_cycle(traffic.messages),
        sums_per_cycle: per_cycle(traffic.sums),
        peak_memory_bytes: machine::peak_memory(),
    };
    let records = gather_all(ranks, record.to_bytes()).iter().map(|bytes| RankRecord::from_bytes(bytes)).collect();
    let [nodes, cells] = local.sizes;
    RanksRecord { nodes, cells, found_by_first: false, levels: multigrid.level_sizes(), ranks: records }
}
