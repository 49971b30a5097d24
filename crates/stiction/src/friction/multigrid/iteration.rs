use std::ops::ControlFlow;

use super::directions::{Direction, MOST, Vector, advance, norm};
use super::floating::Floating;
use super::frames::Turned;
use super::sets::{Law, Set, halted, reverses, set, stuck};
use crate::friction::PointState;
use crate::linalg::multigrid::{Block, Blocks, Condition, Multigrid};

/// How a run of cycles ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Converged,
    Limit,
    /// Not a number, or no gain over many cycles.
    Failed,
    Interrupted,
}

/// Where the iteration is: displacements in the frames, their forces, the directions kept.
#[derive(Debug, Clone, Default)]
pub(super) struct State {
    pub u: Vector,
    pub ku: Vector,
    pub sets: Vec<Set>,
    /// Points whose slip has turned round in the last cycle.
    reversed: Vec<bool>,
    kept: Vec<Direction>,
    /// Sets the coarse levels of the hierarchy follow.
    coarse: Vec<Condition>,
    /// The residual after each cycle.
    history: Vec<f64>,
    /// Where the residual was least so far.
    best: Option<Best>,
    last_reset: usize,
    /// Whether the first sets are those of the displacements.
    warm: bool,
    pub cycles: usize,
    pub resets: usize,
}

#[derive(Debug, Clone)]
struct Best {
    residual: f64,
    u: Vector,
    ku: Vector,
    sets: Vec<Set>,
}

impl State {
    /// Zero displacements of so many nodes; the first sets are guessed.
    pub fn zero(nodes: usize) -> State {
        State { u: vec![[0.0; 3]; nodes], ku: vec![[0.0; 3]; nodes], ..State::default() }
    }

    /// Displacements whose law decides the first sets.
    pub fn at(u: Vector, k: &Blocks<3, 3>) -> State {
        State { ku: k.times(&u), u, warm: true, ..State::default() }
    }

    /// The same once so many cycles have been run.
    pub fn after(self, cycles: usize) -> State {
        State { cycles, ..self }
    }

    /// Goes back to where the residual was least. Bodies that nothing holds any more are carried off ever faster, and where
    /// they are then says nothing.
    pub fn go_back(&mut self) {
        if let Some(Best { u, ku, sets, .. }) = self.best.take() {
            (self.u, self.ku, self.sets) = (u, ku, sets);
        }
    }

    fn keep_best(&mut self, residual: f64) {
        if self.best.as_ref().is_none_or(|best| residual < best.residual) {
            let (u, ku, sets) = (self.u.clone(), self.ku.clone(), self.sets.clone());
            self.best = Some(Best { residual, u, ku, sets });
        }
    }

    /// Another iteration begins here: its sets are not those the directions were kept for.
    pub fn begin_anew(&mut self) {
        self.kept.clear();
        self.reversed.clear();
        self.history.clear();
        self.coarse.clear();
        self.best = None;
        self.resets = 0;
        self.last_reset = self.cycles;
        self.warm = true;
    }
}

/// Cycles over which a residual above [`HIGH`] is to fall by [`GAIN`]; otherwise the sets go round in circles. Down to there
/// friction follows the normal force a cycle later: the sets are not those of the end, and a step that knows more of them
/// goes round more easily.
const PATIENCE: usize = 15;
const GAIN: f64 = 0.7;
const HIGH: f64 = 0.05;
/// Above this residual the body swings as a whole, and slips that turn round twice say nothing of their points. Below it they
/// go to and fro one by one, a little less each cycle, and single ones cost ten to thirty cycles.
const SWINGS: f64 = 0.3;
/// Resets of the first way at most, and the cycles with frozen sets after one.
pub(super) const RESETS: usize = 4;
const FROZEN: usize = 5;
/// Steps kept while the residual is above [`HIGH`]: older ones belong to other sets.
const KEPT_FAR: usize = 2;
/// After so many cycles without a halving friction follows a cycle later again.
const SLOW: usize = 12;
/// Cycles without a halving of the best residual that count as a failure.
const HOPELESS: usize = 60;

/// What cycles are run on, and how far.
#[derive(Clone, Copy)]
pub(super) struct Cycles<'a> {
    pub turned: &'a Turned,
    /// Violation to reach, over the load.
    pub tolerance: f64,
    /// Cycles in all, those of earlier runs counted.
    pub most: usize,
    /// Bodies that are moved as a whole before each cycle, by [`run`] while the residual is above [`HIGH`].
    pub floating: Option<&'a Floating<'a>>,
}

/// Told the residual and the sets after each cycle; may stop the run.
pub(super) type Observe<'a> = dyn FnMut(usize, f64, &[Set]) -> ControlFlow<()> + 'a;

/// Cycles until the law and the balance hold to `tolerance` of the load.
///
/// Every cycle the sets are those of the present iterate; held components take their values and are truncated from
/// the hierarchy, slipping points add the spring of their turning friction and what it grows by with the normal force, and
/// the balance is met on the preconditioned residual and the last two or three steps (without friction that follows a normal
/// force: the energy is least over them). Keeping those steps across changes of the sets is what makes the
/// whole cost that of one linear solve: restarting conjugate gradients for each set costs two to four of them.
/// Sets that go round in circles are reset so many times and then a failure. Truncation follows Graeser & Kornhuber (2009),
/// the radius of friction the augmented normal force (Alart & Curnier 1991).
pub(super) fn run(
    on: &Cycles<'_>,
    laws: &[Law],
    multigrid: &mut Multigrid,
    at: &mut State,
    resets: usize,
    observe: &mut Observe<'_>,
) -> End {
    let Cycles { turned, tolerance, most, floating } = *on;
    let (k, f, points) = (&turned.k, &turned.f, &turned.points);
    loop {
        if let Some(floating) = floating
            && at.history.last().is_some_and(|eps| *eps > HIGH)
        {
            floating.settle(turned, laws, at);
        }
        let lambda = |node: usize| std::array::from_fn(|c| f[node][c] - at.ku[node][c]);
        let first = at.cycles == 0 && at.sets.is_empty() && !at.warm;
        let mut sets: Vec<Set> = (points.iter().zip(laws))
            .map(|(p, law)| {
                if first && (p.floats || law.rest[0] <= 0.0) {
                    stuck(law, p)
                } else {
                    set(law, p, lambda(p.node), at.u[p.node])
                }
            })
            .collect();
        let swings = at.history.last().is_none_or(|eps| *eps > SWINGS);
        at.reversed.resize(sets.len(), false);
        for (((new, old), p), reversed) in sets.iter_mut().zip(&at.sets).zip(points).zip(&mut at.reversed) {
            let before = std::mem::replace(reversed, reverses(old, new));
            if before && *reversed && !swings {
                *new = halted(new, p.live);
            }
        }
        at.sets = sets;
        let eps = violation(turned, laws, &at.sets, &at.u, &at.ku);
        at.history.push(eps);
        if observe(at.cycles, eps, &at.sets).is_break() {
            return End::Interrupted;
        }
        if eps <= tolerance && !first {
            // The forces were carried along; they are believed once a fresh product agrees.
            let fresh = k.times(&at.u);
            let drift: Vector = fresh.iter().zip(&at.ku).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect();
            at.ku = fresh;
            if norm(&drift) <= 0.1 * tolerance * load(turned, &at.ku) {
                return End::Converged;
            }
            at.history.pop();
            continue;
        }
        if at.cycles >= most {
            return End::Limit;
        }
        at.keep_best(eps);
        if !eps.is_finite() || hopeless(&at.history) {
            return End::Failed;
        }
        let near = eps <= HIGH && !slow(&at.history);
        if !near {
            at.sets.iter_mut().for_each(|s| s.condition.follows = [0.0; 2]);
        }
        let round = goes_round(&at.history, at.cycles - at.last_reset);
        if round && at.resets >= resets {
            return End::Failed;
        }
        if round {
            for ((s, p), law) in at.sets.iter_mut().zip(points).zip(laws) {
                if s.condition.held[0] {
                    *s = stuck(law, p);
                }
            }
            at.kept.clear();
            at.resets += 1;
            at.last_reset = at.cycles;
        }
        constrain(multigrid, laws, at);
        hold(k, points, laws, at);
        for _ in 0..if round { FROZEN } else { 1 } {
            let r = residual(turned, laws, at);
            let p = multigrid.cycle(&r);
            let kp = k.times(&p);
            at.kept.insert(0, Direction { p, kp });
            advance(&mut at.kept, &r, points, &at.sets, &mut at.u, &mut at.ku);
            at.kept.truncate(if near { MOST - 1 } else { KEPT_FAR });
            at.cycles += 1;
        }
    }
}

fn hopeless(history: &[f64]) -> bool {
    no_halving(history, HOPELESS)
}

fn slow(history: &[f64]) -> bool {
    no_halving(history, SLOW)
}

fn no_halving(history: &[f64], cycles: usize) -> bool {
    let Some(before) = history.len().checked_sub(cycles) else { return false };
    let best = |part: &[f64]| part.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    best(&history[before..]) > 0.5 * best(&history[..before])
}

fn goes_round(history: &[f64], since_reset: usize) -> bool {
    let Some(before) = history.len().checked_sub(PATIENCE) else { return false };
    let best = history[..before].iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let now = history[history.len() - 1];
    since_reset > PATIENCE && now > HIGH && now > GAIN * best
}

/// Tells the hierarchy the conditions. Its coarse levels follow when some point holds other components, some spring is
/// another, or friction begins or ceases to follow the normal force: functions truncated at a component that is free again,
/// or the spring of a point that has hardly slipped yet, a thousand times stiffer than a cycle later, hold the body where
/// nothing does. A single one costs a hundred cycles on graded meshes.
pub(super) fn constrain(multigrid: &mut Multigrid, laws: &[Law], at: &mut State) {
    let conditions: Vec<Condition> = at.sets.iter().map(|s| s.condition).collect();
    let follow = |conditions: &[Condition]| conditions.iter().any(|c| c.follows != [0.0; 2]);
    let other = |((new, old), law): ((&Condition, &Condition), &Law)| {
        new.held != old.held || differs(&new.spring, &old.spring, law.parameter)
    };
    let coarse = at.coarse.len() != conditions.len()
        || follow(&conditions) != follow(&at.coarse)
        || conditions.iter().zip(&at.coarse).zip(laws).any(other);
    multigrid.constrain(&conditions, coarse);
    if coarse {
        at.coarse = conditions;
    }
}

/// Whether a spring has become stiffer or softer by more than itself and the body's stiffness at its point.
fn differs(new: &Block<3, 3>, old: &Block<3, 3>, parameter: f64) -> bool {
    let trace = |spring: &Block<3, 3>| spring[1][1] + spring[2][2];
    let pairs = new.iter().flatten().zip(old.iter().flatten());
    let change = pairs.map(|(new, old)| (new - old).abs()).fold(0.0, f64::max);
    change > parameter + trace(new).min(trace(old))
}

/// Held components take their values; the directions kept lose them.
fn hold(k: &Blocks<3, 3>, points: &[super::frames::Point], laws: &[Law], at: &mut State) {
    for ((s, p), law) in at.sets.iter().zip(points).zip(laws) {
        for c in (0..3).filter(|&c| s.condition.held[c]) {
            let change = law.rest[c] - std::mem::replace(&mut at.u[p.node][c], law.rest[c]);
            add_column(k, p.node, c, change, &mut at.ku);
            for d in &mut at.kept {
                let change = -std::mem::take(&mut d.p[p.node][c]);
                add_column(k, p.node, c, change, &mut d.kp);
            }
        }
    }
}

/// `y += change` times the column of `K` at a component of a node; `K` is symmetric.
fn add_column(k: &Blocks<3, 3>, node: usize, component: usize, change: f64, y: &mut Vector) {
    if change == 0.0 {
        return;
    }
    let (columns, blocks) = k.row(node);
    for (&j, block) in columns.iter().zip(blocks) {
        (0..3).for_each(|c| y[j as usize][c] += change * block[component][c]);
    }
}

fn balance(turned: &Turned, ku: &Vector) -> Vector {
    turned.f.iter().zip(ku).map(|(f, k)| std::array::from_fn(|c| f[c] - k[c])).collect()
}

/// The residual on the components that are not held: `f - K u` less friction.
pub(super) fn residual(turned: &Turned, laws: &[Law], at: &State) -> Vector {
    let mut r = balance(turned, &at.ku);
    for ((p, s), law) in turned.points.iter().zip(&at.sets).zip(laws) {
        let (r, u) = (&mut r[p.node], at.u[p.node]);
        for c in 1..3 {
            let spring = &s.condition.spring[c];
            r[c] -= s.friction[c - 1] + spring[1] * (u[1] - law.rest[1]) + spring[2] * (u[2] - law.rest[2]);
        }
        (0..3).filter(|&c| s.condition.held[c]).for_each(|c| r[c] = 0.0);
    }
    r
}

/// Takes the sets of the law at the present displacements, and says how much it is violated, over the load.
pub(super) fn judge(turned: &Turned, laws: &[Law], at: &mut State) -> f64 {
    let lambda = |v: usize| std::array::from_fn(|c| turned.f[v][c] - at.ku[v][c]);
    at.sets = turned.points.iter().zip(laws).map(|(p, law)| set(law, p, lambda(p.node), at.u[p.node])).collect();
    violation(turned, laws, &at.sets, &at.u, &at.ku)
}

/// Violation of balance and law over the load: forces that are not balanced and, as forces, displacements that are
/// not held.
fn violation(turned: &Turned, laws: &[Law], sets: &[Set], u: &Vector, ku: &Vector) -> f64 {
    let mut r = balance(turned, ku);
    for ((p, s), law) in turned.points.iter().zip(sets).zip(laws) {
        let (r, u) = (&mut r[p.node], u[p.node]);
        for c in 0..3 {
            if s.condition.held[c] {
                r[c] = law.parameter * (u[c] - law.rest[c]);
            } else if c > 0 && s.state == PointState::Slip {
                r[c] -= s.friction[c - 1];
            }
        }
    }
    let scale = load(turned, ku);
    if scale > 0.0 { norm(&r) / scale } else { norm(&r) }
}

/// The larger of the load and the contact forces, newton.
fn load(turned: &Turned, ku: &Vector) -> f64 {
    let at = |v: usize| (0..3).map(|c| (turned.f[v][c] - ku[v][c]).powi(2)).sum::<f64>();
    let contact: f64 = turned.points.iter().map(|p| at(p.node)).sum();
    norm(&turned.f).max(contact.sqrt())
}
