use std::ops::ControlFlow;

use super::active_set::{ContactCondition, PointLaw, closed_condition, contact_condition, forced_stick, slip_reverses};
use super::directions::{Direction, MOST_DIRECTIONS, Vector, dot, minimise, norm};
use super::equations::{Equations, Projection};
use super::floating::FloatingBodies;
use super::loose::{LooseMotions, NEAR};
use super::monitor::{Monitor, Verdict};
use super::points::Point;
use super::shortened::shorten;
use super::solve::floats;
use super::tightening::{Tightening, share};
use super::transform::Transformed;
use crate::friction::{End, PointState};
use crate::linalg::multigrid::{Block, CoarseLevels, Hierarchy, NodeConstraint, RelativeMatrix};

/// A problem for the iteration, and how far it goes.
#[derive(Clone, Copy)]
pub(super) struct Subproblem<'a> {
    pub transformed: &'a Transformed,
    pub laws: &'a [PointLaw],
    /// Violation of balance and law to reach, over the load.
    pub tolerance: f64,
    /// Cycles in all, those of earlier stages included.
    pub max_cycles: usize,
    /// Resets of cycling active sets before the run counts as failed.
    pub max_resets: usize,
    /// Violation of balance and law over the load above which the run counts as failed, if it began with less.
    pub max_violation: f64,
    /// Floating bodies, which are balanced as rigid ones before each cycle as long as the residual is large.
    pub floating: Option<&'a FloatingBodies<'a>>,
    /// Bolts whose force is given, for [`run`].
    pub tightening: Option<&'a Tightening>,
    /// Equations over many nodes, for [`run`] and springs.
    pub equations: Option<&'a Equations>,
}

impl<'a> Subproblem<'a> {
    /// The points with their laws.
    pub(super) fn points(&self) -> impl Iterator<Item = (&'a Point, &'a PointLaw)> + use<'a> {
        self.transformed.points.iter().zip(self.laws)
    }

    /// `K u` less the forces of the shortenings, with those of the equations.
    pub(super) fn forces_within(&self, at: &Iterate) -> Vector {
        let mut forces = self.transformed.k.times(&at.u);
        if let Some(tightening) = self.tightening {
            tightening.take_off(&at.shortening, &mut forces);
        }
        if let Some(equations) = self.equations {
            equations.add_forces(&at.multipliers, &mut forces);
        }
        forces
    }
}

/// Displacements in the frames, their images under `K`, and the contact conditions there.
#[derive(Debug, Clone, Default)]
pub(super) struct Iterate {
    pub u: Vector,
    /// Less the forces of the shortenings, with those of the equations.
    pub ku: Vector,
    /// Of the bolts whose force is given, beyond what the load contains; length.
    pub shortening: Vec<f64>,
    /// Of the equations over many nodes, newton.
    pub multipliers: Vec<f64>,
    pub conditions: Vec<ContactCondition>,
}

impl Iterate {
    /// The contact force at a node, `f - K u`, newton.
    pub(super) fn force(&self, transformed: &Transformed, node: usize) -> [f64; 3] {
        std::array::from_fn(|c| transformed.f[node][c] - self.ku[node][c])
    }
}

/// The state of the iteration.
#[derive(Debug, Clone, Default)]
pub(super) struct State {
    pub iterate: Iterate,
    /// Cycles and resets in all, those of earlier stages included.
    pub cycles: usize,
    pub resets: usize,
    pub monitor: Monitor,
    /// Points whose slip reversed in the last cycle.
    reversed: Vec<bool>,
    /// Search directions of the last cycles, the newest first.
    directions: Vec<Direction>,
    /// The constraints of the coarse levels; none before they have some of this run.
    coarse: Option<Vec<NodeConstraint>>,
    /// Whether the first contact conditions are a guess, for want of displacements.
    guess: bool,
    /// Whether it begins at displacements that were given, such as the answer of the load step before.
    given: bool,
    projection: Projection,
    /// The motions that nothing resisted in the last cycle near the solution.
    loose: LooseMotions,
    /// The residual that was taken for rounding last, newton.
    rounded: Option<f64>,
    /// Whether this rank was asked to stop, which the others learn with the next survey.
    stops: bool,
}

/// What the ranks find of an iterate together, in one message.
pub(super) struct Survey {
    /// The violation of balance and law, newton.
    pub left: f64,
    /// The same over the load.
    pub violated: f64,
    /// The same over the contact forces alone.
    of_contact: f64,
    /// Points in each state: open, stick, slip.
    pub states: [usize; 3],
    /// What the contact conditions do to the coarse levels, without Coulomb coupling and with it.
    coarse: [CoarseLevels; 2],
    /// Whether some rank was asked to stop.
    pub stops: bool,
}

/// Further thresholds of the iteration.
struct Threshold;

impl Threshold {
    /// Cycles with frozen active sets after a reset; found with the prototype by which the monitor's thresholds were.
    const FROZEN_CYCLES: usize = 5;
    /// Directions kept while the Coulomb coupling is left out: older ones belong to other active sets.
    const KEPT_FAR: usize = 2;
    /// Points that stick, over those that slip, below which friction that slips holds a body. With zero 3000 random cases
    /// take the same cycles, the load steps of the hip stem (620 000 unknowns) 60, 46 and 37 instead of 47, 50 and 38.
    const STICKING: f64 = 0.01;
    /// The residual over the contact forces above which the sweeps of nodes alone rest: contact conditions change with every cycle there,
    /// and with them the matrix of these sweeps, which takes as long as several cycles. 300 random cases take 5 722 cycles with all
    /// sweeps, 5 731 and 5 728 with 0.03 and 0.01; stacked plates (190 000 unknowns) 33.5, 27.4 and 25.9 s, but hexahedra of two bodies
    /// on 8 ranks 27, 28 and 29 cycles.
    const UNSETTLED: f64 = 0.03;
    /// The residual over the contact forces at which the shortenings of bolts are known: over a load that closes a clearance, ten thousand
    /// times as large, the residual leaves a force open in its sixth digit.
    const SHARP: f64 = 1e-6;
    /// The square of contact forces over that of the load below which there are none to measure by.
    const FORCES: f64 = 1e-10;
    /// What rounding leaves of forces that balance, over their size.
    const ROUNDING: f64 = 1e-14;
    /// The residual over one that was taken for rounding, and did not certify, at which it is taken for it once more.
    const ONCE_MORE: f64 = 0.01;
    /// The last cycle's drift of `K u` that is accepted, over the tolerance.
    const DRIFT: f64 = 0.1;
}

/// Receives the cycle, the residual and the points in each state (open, stick, slip); may stop the run.
pub(super) type Observe<'a> = dyn FnMut(usize, f64, [usize; 3]) -> ControlFlow<()> + 'a;

/// Active-set iteration until the law and the balance hold to the tolerance.
///
/// Every cycle the contact conditions are those of the present iterate: constrained components take their target values and
/// are truncated from the hierarchy (Graeser & Kornhuber 2009), slipping points add the stiffness of their friction, and the
/// radius of friction is the augmented normal force (Alart & Curnier 1991). One multigrid cycle gives a direction, and the
/// energy is minimised over it and the last two or three; floating bodies far from the solution may go a part of that step
/// (`shortened.rs`). Keeping directions across changes of the active sets is what makes the cost that of one linear solve: restarting
/// conjugate gradients for each set costs two to four times as much.
pub(super) fn run(
    problem: &Subproblem<'_>,
    hierarchy: &mut Hierarchy,
    state: &mut State,
    observe: &mut Observe<'_>,
) -> End {
    let floats = floats(problem.transformed, problem.equations);
    loop {
        if let Some(floating) = problem.floating.filter(|_| state.monitor.is_far()) {
            balance(floating, problem, &mut state.iterate);
        }
        if let Some(tightening) = problem.tightening {
            tightening.balance(problem.transformed, &mut state.iterate);
        }
        if let Some(equations) = problem.equations {
            equations.balance(problem, &state.projection, &mut state.iterate);
        }
        let guessed = state.update_conditions(problem);
        let Survey { left, violated, of_contact, states, coarse, stops } = state.survey(problem);
        state.monitor.record(violated, of_contact);
        if state.is_stopped(problem, stops, observe(state.cycles, violated, states)) {
            return End::Interrupted;
        }
        let is_sharp = problem.tightening.is_none() || of_contact <= Threshold::SHARP;
        let rounded = state.is_rounding(problem, left);
        if (violated <= problem.tolerance || rounded) && is_sharp && !guessed {
            if rounded {
                state.rounded = Some(left);
            }
            if state.refresh_forces(problem) || rounded {
                return End::Converged;
            }
            state.monitor.retract();
            continue;
        }
        if state.cycles >= problem.max_cycles {
            return End::Limit;
        }
        let verdict = match state.monitor.assess(&state.iterate, state.cycles) {
            Verdict::Progress if violated > problem.max_violation && state.monitor.has_grown() => Verdict::Failed,
            verdict => verdict,
        };
        let cycles = match verdict {
            Verdict::Progress => 1,
            Verdict::Cycling if state.monitor.resets < problem.max_resets => {
                state.reset(problem);
                Threshold::FROZEN_CYCLES
            }
            Verdict::Cycling | Verdict::Failed => return End::Stalled,
        };
        // From nearby the present sets are most of the final ones. Without the coupling a body that is wedged, whose friction
        // carries most of the load, swings off: of the hip stem (200 000 unknowns) the second load step takes 44 cycles with
        // it, 163 without. From elsewhere the coupling makes sets cycle (the clamp: 200 cycles instead of 68), unless hardly a
        // point of a floating body sticks: then the body slides with the friction of the last normal forces, out of its cone
        // and back. The first load step of that stem (620 000 unknowns) takes 47 cycles with the coupling, 194 without.
        let slides = floats && Threshold::STICKING * (states[2] as f64) > states[1] as f64;
        let coupled = state.monitor.is_coupled(state.given, slides);
        if !coupled {
            state.iterate.conditions.iter_mut().for_each(|s| s.constraint.coulomb = [0.0; 2]);
        }
        let coarse = match verdict {
            Verdict::Progress => coarse,
            _ => state.coarse_levels(problem),
        };
        state.constrain(hierarchy, coarse[usize::from(coupled)], of_contact <= Threshold::UNSETTLED);
        state.apply_targets(problem);
        if let Some(equations) = problem.equations {
            state.projection.update(equations, problem, (&state.iterate.conditions, state.cycles), hierarchy);
        }
        for _ in 0..cycles {
            if let Some(equations) = problem.equations {
                equations.balance(problem, &state.projection, &mut state.iterate);
            }
            let r = residual(problem, &state.iterate);
            let mut p = hierarchy.cycle_in_units(left.max(f64::MIN_POSITIVE), &r);
            if let Some(floating) = problem.floating.filter(|_| violated <= NEAR) {
                floating.keep_in_place(problem.transformed, &state.iterate.conditions, (&mut state.loose, &mut p));
            }
            if let Some(equations) = problem.equations {
                equations.project(problem.transformed.halo(), &state.projection, &mut p);
            }
            let kp = problem.transformed.k.times(&p);
            let mut direction = Direction { p, kp, shortening: Vec::new() };
            if let Some(tightening) = problem.tightening {
                tightening.make_conjugate(problem.transformed.halo(), &mut direction);
            }
            state.directions.insert(0, direction);
            let points = &problem.transformed.points;
            let halo = problem.transformed.halo();
            // Parts of a step leave their multipliers to be found.
            let is_far = floats && problem.equations.is_none() && state.monitor.is_far();
            let from = is_far.then(|| state.iterate.clone());
            minimise(halo, &mut state.directions, &r, points, problem.tightening, &mut state.iterate);
            if let Some(from) = from {
                shorten(problem, &from, &state.directions[0], &mut state.iterate);
            }
            state.directions.truncate(if coupled { MOST_DIRECTIONS - 1 } else { Threshold::KEPT_FAR });
            state.cycles += 1;
        }
    }
}

/// Balances floating bodies as rigid ones, unless the violation grows: a stem that slips into its cone is far softer than it is as a
/// rigid body on springs at its points, and would be thrown out. Of the hip stem (620 000 unknowns) the first load step takes
/// 194 cycles with this, 425 without; 900 random cases take 20 094 and 20 873.
fn balance(floating: &FloatingBodies<'_>, problem: &Subproblem<'_>, at: &mut Iterate) {
    let (u, conditions) = (at.u.clone(), at.conditions.clone());
    let before = judge(problem, at);
    floating.balance(problem, at);
    if judge(problem, at) > before {
        at.u = u;
    }
    at.conditions = conditions;
}

impl State {
    /// At zero displacements of so many nodes; the first contact conditions are a guess.
    pub(super) fn zero(nodes: usize) -> State {
        let iterate = Iterate { u: vec![[0.0; 3]; nodes], ku: vec![[0.0; 3]; nodes], ..Iterate::default() };
        State { iterate, guess: true, ..State::default() }
    }

    /// At displacements `u`, whose law decides the first contact conditions.
    pub(super) fn at(u: Vector, k: &RelativeMatrix) -> State {
        State { iterate: Iterate { ku: k.times(&u), u, ..Iterate::default() }, ..State::default() }
    }

    /// The same, whose displacements were given.
    pub(super) fn given(self) -> State {
        State { given: true, ..self }
    }

    /// The same with the counts of an earlier stage. A guess or a start that has failed is not repeated.
    pub(super) fn after(self, earlier: &State) -> State {
        let is_first = earlier.cycles == 0;
        let (guess, given) = (self.guess && is_first, self.given && is_first);
        State { cycles: earlier.cycles, resets: earlier.resets, stops: earlier.stops, guess, given, ..self }
    }

    /// Another iteration begins here: directions, coarse levels and residuals belong to other active sets.
    pub(super) fn restart(&mut self) {
        self.directions.clear();
        self.reversed.clear();
        self.coarse = None;
        self.monitor.restart(self.cycles);
        (self.guess, self.given) = (false, false);
    }

    /// Goes back to the best iterate.
    pub(super) fn go_back(&mut self) {
        if let Some(best) = self.monitor.take_best() {
            self.iterate = best;
        }
    }

    /// Takes the contact conditions of the law at the iterate, and forces points to stick whose slip reverses twice in a row;
    /// returns whether the conditions are guessed.
    fn update_conditions(&mut self, problem: &Subproblem<'_>) -> bool {
        let guessed = std::mem::take(&mut self.guess);
        let mut conditions: Vec<ContactCondition> = (problem.points())
            .map(|(p, law)| {
                if guessed && (p.floats || law.target[0] <= 0.0) {
                    closed_condition(law, p)
                } else {
                    contact_condition(law, p, self.iterate.force(problem.transformed, p.node), self.iterate.u[p.node])
                }
            })
            .collect();
        let chattering = self.monitor.is_chattering();
        self.reversed.resize(conditions.len(), false);
        let all = conditions.iter_mut().zip(&self.iterate.conditions).zip(&problem.transformed.points);
        for (((new, old), p), reversed) in all.zip(&mut self.reversed) {
            let before = std::mem::replace(reversed, slip_reverses(old, new));
            if before && *reversed && chattering {
                *new = forced_stick(new, p.has_row);
            }
        }
        self.iterate.conditions = conditions;
        guessed
    }

    /// Replaces `K u`, which was updated along with `u`, by a fresh product; whether the two agree.
    fn refresh_forces(&mut self, problem: &Subproblem<'_>) -> bool {
        let fresh = problem.forces_within(&self.iterate);
        let pairs = fresh.iter().zip(&self.iterate.ku);
        let drift: Vector = pairs.map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect();
        self.iterate.ku = fresh;
        let drift = norm(problem.transformed.halo(), &drift);
        drift <= Threshold::DRIFT * problem.tolerance * load(problem, &self.iterate)
    }

    /// Whether a residual of `left` newton that does not fall is what rounding leaves of the forces inside the bodies: where loads vanish
    /// that is all there is, and nothing to measure it by.
    fn is_rounding(&self, problem: &Subproblem<'_>, left: f64) -> bool {
        let is_less = self.rounded.is_none_or(|before| left <= Threshold::ONCE_MORE * before);
        if !is_less || !self.monitor.is_slow() {
            return false;
        }
        let mut squares = [problem.transformed.k.squares_of_terms(&self.iterate.u)];
        problem.transformed.halo().sum(&mut squares);
        left <= Threshold::ROUNDING * squares[0].sqrt()
    }

    /// Resets cycling active sets: all points in contact stick, and the directions are dropped.
    fn reset(&mut self, problem: &Subproblem<'_>) {
        for (condition, (p, law)) in self.iterate.conditions.iter_mut().zip(problem.points()) {
            if condition.constraint.constrained[0] {
                *condition = closed_condition(law, p);
            }
        }
        self.directions.clear();
        self.monitor.reset(self.cycles);
    }

    /// Whether the run is stopped, of which all ranks learn together: with the next survey where there are several.
    pub(super) fn is_stopped(&mut self, problem: &Subproblem<'_>, elsewhere: bool, here: ControlFlow<()>) -> bool {
        self.stops |= here.is_break();
        elsewhere || self.stops && problem.transformed.halo().is_alone()
    }

    /// What the ranks find of the iterate and its contact conditions.
    pub(super) fn survey(&self, problem: &Subproblem<'_>) -> Survey {
        self.survey_with(problem, squares(problem, &self.iterate))
    }

    /// The same with these squares of the violation, of the load and of the contact forces on this rank.
    pub(super) fn survey_with(&self, problem: &Subproblem<'_>, squares: [f64; 3]) -> Survey {
        let [left, load, contact] = squares;
        let [open, stick, slip] = states(&self.iterate.conditions);
        let [without, with, couples] = self.coarse_levels_here(problem);
        let stops = f64::from(u8::from(self.stops));
        let mut sums = [left, load, contact, open, stick, slip, without, with, couples, stops];
        problem.transformed.halo().sum(&mut sums);
        let [left, load, contact, open, stick, slip, without, with, couples, stops] = sums;
        Survey {
            left: left.sqrt(),
            violated: over_load([left, load, contact]),
            of_contact: (left / contact.max(Threshold::FORCES * load)).sqrt(),
            states: [open, stick, slip].map(|count| count as usize),
            coarse: coarse_levels([without, with, couples]),
            stops: stops > 0.0,
        }
    }

    /// Whether the coarse levels change by the contact conditions of this rank, without their Coulomb coupling and with it: when
    /// a component is constrained or released, a spring changes, or the coupling begins or ends. The levels may not lag
    /// behind: a function truncated at a component that is free again, or the spring of a point that has hardly slipped yet, a
    /// thousand times stiffer than a cycle later, makes the coarse levels too stiff there. A single one costs a hundred
    /// cycles on graded meshes.
    fn coarse_levels_change(&self, problem: &Subproblem<'_>) -> [bool; 2] {
        let Some(coarse) = &self.coarse else { return [true; 2] };
        let new = || self.iterate.conditions.iter().map(|s| &s.constraint);
        let couples = |c: &NodeConstraint| c.coulomb != [0.0; 2];
        let differs = |((new, old), law): ((&NodeConstraint, &NodeConstraint), &PointLaw)| {
            new.constrained != old.constrained || spring_differs(&new.spring, &old.spring, law.parameter)
        };
        let differ = new().zip(coarse).zip(problem.laws).any(differs);
        let were_coupled = coarse.iter().any(couples);
        [false, new().any(couples)].map(|coupled| differ || coupled != were_coupled)
    }

    /// The numbers of ranks, of which this one counts, whose coarse levels change without Coulomb coupling and with it, and that couple.
    fn coarse_levels_here(&self, problem: &Subproblem<'_>) -> [f64; 3] {
        let [without, with] = self.coarse_levels_change(problem);
        let couples = self.iterate.conditions.iter().any(|s| s.constraint.coulomb != [0.0; 2]);
        [without, with, couples].map(|so| f64::from(u8::from(so)))
    }

    /// What the contact conditions of all ranks do to the coarse levels, without Coulomb coupling and with it.
    pub(super) fn coarse_levels(&self, problem: &Subproblem<'_>) -> [CoarseLevels; 2] {
        let mut ranks = self.coarse_levels_here(problem);
        problem.transformed.halo().sum(&mut ranks);
        coarse_levels(ranks)
    }

    /// Constrains the hierarchy by the contact conditions, its coarse levels too where they change on some rank, and its sweeps of nodes
    /// alone where sets are `settled`. Rounding of the changes of other runs is not carried on.
    pub(super) fn constrain(&mut self, hierarchy: &mut Hierarchy, coarse: CoarseLevels, settled: bool) {
        let constraints: Vec<NodeConstraint> = self.iterate.conditions.iter().map(|s| s.constraint).collect();
        let changes = coarse != CoarseLevels::Stay;
        if changes && self.coarse.is_none() {
            hierarchy.forget_coarse_constraints();
        }
        hierarchy.constrain(&constraints, coarse, settled);
        if changes {
            self.coarse = Some(constraints);
        }
    }

    /// Constrained components take their target values, and those of the directions become zero.
    pub(super) fn apply_targets(&mut self, problem: &Subproblem<'_>) {
        let transformed = problem.transformed;
        let k = &transformed.k;
        let Iterate { u, ku, conditions, .. } = &mut self.iterate;
        let mut changes =
            vec![[[0.0; 3]; MOST_DIRECTIONS]; if transformed.halo().is_alone() { 0 } else { conditions.len() }];
        for (j, (condition, (p, law))) in conditions.iter().zip(problem.points()).enumerate() {
            for c in (0..3).filter(|&c| condition.constraint.constrained[c]) {
                let change = law.target[c] - std::mem::replace(&mut u[p.node][c], law.target[c]);
                add_column(k, p.node, c, change, ku);
                let mut note = |d: usize, change: f64| changes.get_mut(j).map_or((), |of| of[d][c] = change);
                note(0, change);
                for (d, direction) in self.directions.iter_mut().enumerate() {
                    let change = -std::mem::take(&mut direction.p[p.node][c]);
                    add_column(k, p.node, c, change, &mut direction.kp);
                    note(d + 1, change);
                }
            }
        }
        let kp = self.directions.iter_mut().map(|d| &mut d.kp);
        transformed.add_columns_of_ghosts(changes, std::iter::once(ku).chain(kp));
    }
}

/// From the numbers of ranks whose coarse levels change without Coulomb coupling and with it, and that couple.
fn coarse_levels([without, with, couples]: [f64; 3]) -> [CoarseLevels; 2] {
    [CoarseLevels::of(without > 0.0, false), CoarseLevels::of(with > 0.0, couples > 0.0)]
}

/// Whether a spring changes by more than the stiffness of the spring and of the body at its point.
fn spring_differs(new: &Block<3, 3>, old: &Block<3, 3>, parameter: f64) -> bool {
    let trace = |spring: &Block<3, 3>| spring[1][1] + spring[2][2];
    let pairs = new.iter().flatten().zip(old.iter().flatten());
    let change = pairs.map(|(new, old)| (new - old).abs()).fold(0.0, f64::max);
    change > parameter + trace(new).min(trace(old))
}

/// `y += change` times the column of `K` at a component of a node, at the nodes of this rank; `K` is symmetric.
fn add_column(k: &RelativeMatrix, node: usize, component: usize, change: f64, y: &mut Vector) {
    if change == 0.0 {
        return;
    }
    for (j, block) in k.entries_of(node).filter(|(j, _)| (*j as usize) < k.len()) {
        (0..3).for_each(|c| y[j as usize][c] += change * block[component][c]);
    }
}

fn unbalanced(transformed: &Transformed, ku: &Vector) -> Vector {
    transformed.f.iter().zip(ku).map(|(f, k)| std::array::from_fn(|c| f[c] - k[c])).collect()
}

/// The residual on the free components: `f - K u` less friction.
pub(super) fn residual(problem: &Subproblem<'_>, at: &Iterate) -> Vector {
    let mut r = unbalanced(problem.transformed, &at.ku);
    for ((p, law), condition) in problem.points().zip(&at.conditions) {
        let (r, u, constraint) = (&mut r[p.node], at.u[p.node], &condition.constraint);
        r[0] -= constraint.spring[0][0] * (u[0] - law.target[0]);
        for c in 1..3 {
            let spring = &constraint.spring[c];
            r[c] -= condition.friction[c - 1] + spring[1] * (u[1] - law.target[1]) + spring[2] * (u[2] - law.target[2]);
        }
        (0..3).filter(|&c| constraint.constrained[c]).for_each(|c| r[c] = 0.0);
    }
    r
}

/// Takes the contact conditions of the law at the iterate; returns the violation there.
pub(super) fn judge(problem: &Subproblem<'_>, at: &mut Iterate) -> f64 {
    at.conditions = judged(problem, at);
    violation(problem, at)
}

/// The contact conditions of the law at the iterate.
pub(super) fn judged(problem: &Subproblem<'_>, at: &Iterate) -> Vec<ContactCondition> {
    let of_point =
        |(p, law): (&Point, &PointLaw)| contact_condition(law, p, at.force(problem.transformed, p.node), at.u[p.node]);
    problem.points().map(of_point).collect()
}

/// Points in each state on this rank: open, stick, slip.
pub(super) fn states(conditions: &[ContactCondition]) -> [f64; 3] {
    let count = |state: PointState| conditions.iter().filter(|x| x.state == state).count() as f64;
    [PointState::Open, PointState::Stick, PointState::Slip].map(count)
}

/// Violation of balance and law over the load: unbalanced forces on free components, and on constrained ones the distance
/// from the target value times the parameter.
fn violation(problem: &Subproblem<'_>, at: &Iterate) -> f64 {
    let mut squares = squares(problem, at);
    problem.transformed.halo().sum(&mut squares);
    over_load(squares)
}

/// The first of these squares over the larger of the load and the contact forces.
pub(super) fn over_load(squares: [f64; 3]) -> f64 {
    let [left, load, contact] = squares.map(f64::sqrt);
    let scale = load.max(contact);
    if scale > 0.0 { left / scale } else { left }
}

/// The squares of the violation, of the load and of the contact forces on this rank.
pub(super) fn squares(problem: &Subproblem<'_>, at: &Iterate) -> [f64; 3] {
    let mut r = unbalanced(problem.transformed, &at.ku);
    for ((p, law), condition) in problem.points().zip(&at.conditions) {
        let (r, u) = (&mut r[p.node], at.u[p.node]);
        for c in 0..3 {
            if condition.constraint.constrained[c] {
                r[c] = law.parameter * (u[c] - law.target[c]);
            } else if c > 0 && condition.state == PointState::Slip {
                r[c] -= condition.friction[c - 1];
            }
        }
    }
    let halo = problem.transformed.halo();
    let missing: f64 = problem.tightening.map_or(0.0, |t| t.missing(halo, at).iter().map(|m| m * m).sum());
    let [load, contact] = load_squares(problem, at);
    [dot(&r, &r) + share(halo) * missing, load, contact]
}

/// The larger of the load and the contact forces, newton.
pub(super) fn load(problem: &Subproblem<'_>, at: &Iterate) -> f64 {
    let mut squares = load_squares(problem, at);
    problem.transformed.halo().sum(&mut squares);
    squares[0].sqrt().max(squares[1].sqrt())
}

/// The squares of both at the nodes of this rank; the forces of equations are loads.
pub(super) fn load_squares(problem: &Subproblem<'_>, at: &Iterate) -> [f64; 2] {
    let transformed = problem.transformed;
    let of_equations = problem.equations.map_or(0.0, |equations| equations.force_square(&at.multipliers));
    let of_equations = share(transformed.halo()) * of_equations;
    let square = |v: usize| at.force(transformed, v).iter().map(|f| f * f).sum::<f64>();
    let contact = transformed.points.iter().map(|p| square(p.node)).sum();
    [dot(&transformed.f, &transformed.f) + of_equations, contact]
}
