//! Bolts whose force is given: their shortenings are unknowns of the iteration.
//!
//! A bolt stores `1/2 u'Ku - s force'u + 1/2 s² stiffness`, so that `K u - s force` balances the loads and
//! `stiffness s - force'u` is the force through its cut. To lengthen `s` at fixed displacements all strain goes into
//! the cells at the cut, which are stiffer than the bolt by its length over theirs. Each bolt therefore brings a
//! [stretch](SoughtForce::stretch) along its free length: over `s` with its stretch the energy is minimised exactly
//! before each cycle, and the search directions of the cycles are made conjugate to it.

use super::directions::{Direction, Vector};
use super::equations::Equations;
use super::iteration::{Iterate, State, Subproblem};
use super::part::Part;
use super::solve::{Multigrid, floats, multipliers, point_laws, progress, start};
use super::strategy::{STAGES, Traits};
use super::transform::Transformed;
use crate::Error;
use crate::contact::ContactProblem;
use crate::friction::{Counts, End, Progress, Settings, SolverPath};
use crate::linalg::{SmallLu, Watch};
use crate::ranks::Halo;

/// A bolt whose force is given, with what its shortening does beyond the one that the load of the problem contains.
#[derive(Debug, Clone)]
pub(crate) struct SoughtForce {
    /// Forces on the unknowns for each unit of shortening, newton per length.
    pub force: Vec<(u32, f64)>,
    /// Force through the cut for each unit of shortening while nothing moves, newton per length.
    pub stiffness: f64,
    /// `stiffness s - force'u` in the answer, newton.
    pub target: f64,
    /// Displacements of unknowns that take up a unit of shortening along the bolt; zero where `B` acts.
    pub stretch: Vec<(u32, f64)>,
}

/// The part of this rank in what all of them know: that of the first is all of it.
pub(super) fn share(halo: &Halo) -> f64 {
    if halo.is_divided() && halo.ranks().rank() > 0 { 0.0 } else { 1.0 }
}

/// Entries of a vector of nodes.
type Entries = Vec<(u32, [f64; 3])>;

fn entries(of: &Vector) -> Entries {
    (0u32..).zip(of).filter(|(_, x)| **x != [0.0; 3]).map(|(v, x)| (v, *x)).collect()
}

/// Of what this rank has.
fn dot(x: &Entries, y: &Vector) -> f64 {
    x.iter().map(|(v, x)| (0..3).map(|c| x[c] * y[*v as usize][c]).sum::<f64>()).sum()
}

fn add(factor: f64, x: &Entries, y: &mut Vector) {
    for (v, x) in x {
        (0..3).for_each(|c| y[*v as usize][c] += factor * x[c]);
    }
}

/// The bolts in the frames of the points.
#[derive(Debug)]
pub(super) struct Tightening {
    bolts: Vec<Bolt>,
    /// Of the energy over the shortenings with their stretches.
    energy: SmallLu,
}

#[derive(Debug)]
struct Bolt {
    force: Entries,
    stiffness: f64,
    target: f64,
    /// The stretch and what it adds to `K u - s force` with a unit of shortening.
    stretch: Entries,
    image: Entries,
}

impl Tightening {
    /// Where nodes are divided each rank has the entries at its own.
    fn new(transformed: &Transformed, sought: &[SoughtForce]) -> Tightening {
        let dense = |entries: &[(u32, f64)]| {
            let mut all = vec![0.0; transformed.nodes.of.len()];
            entries.iter().for_each(|&(i, value)| all[i as usize] += value);
            all
        };
        let bolt = |sought: &SoughtForce| {
            let force = entries(&transformed.forces(&dense(&sought.force)));
            let stretch = transformed.to_frames(&dense(&sought.stretch));
            let mut image = transformed.k.times(&stretch);
            add(-1.0, &force, &mut image);
            let (stretch, image) = (entries(&stretch), entries(&image));
            Bolt { force, stiffness: sought.stiffness, target: sought.target, stretch, image }
        };
        let bolts: Vec<Bolt> = sought.iter().map(bolt).collect();
        let (nodes, share) = (transformed.f.len(), share(transformed.halo()));
        let row = |(i, of): (usize, &Bolt)| {
            let mut image = vec![[0.0; 3]; nodes];
            add(1.0, &of.image, &mut image);
            let mut stretched = vec![[0.0; 3]; nodes];
            add(1.0, &of.stretch, &mut stretched);
            let entry = |(j, other): (usize, &Bolt)| {
                let own = if i == j { share * other.stiffness } else { 0.0 };
                dot(&other.stretch, &image) + own - dot(&other.force, &stretched)
            };
            bolts.iter().enumerate().map(entry).collect::<Vec<f64>>()
        };
        let mut rows = bolts.iter().enumerate().map(row).collect::<Vec<_>>().concat();
        transformed.halo().sum(&mut rows);
        let energy = SmallLu::new(rows.chunks(bolts.len().max(1)).map(<[f64]>::to_vec).collect());
        Tightening { bolts, energy }
    }

    /// What is missing of each force, newton, the same on every rank.
    pub(super) fn missing(&self, halo: &Halo, at: &Iterate) -> Vec<f64> {
        let from_body = self.with_forces(halo, &at.u);
        let missing = |((bolt, s), body): ((&Bolt, &f64), f64)| bolt.target - bolt.stiffness * s + body;
        self.bolts.iter().zip(&at.shortening).zip(from_body).map(missing).collect()
    }

    /// Products of the forces of each bolt with displacements.
    fn with_forces(&self, halo: &Halo, u: &Vector) -> Vec<f64> {
        let mut products: Vec<f64> = self.bolts.iter().map(|bolt| dot(&bolt.force, u)).collect();
        halo.sum(&mut products);
        products
    }

    /// This rank's part of the energy of `x` with `y` that their shortenings take part in.
    pub(super) fn coupled(&self, halo: &Halo, x: &Direction, y: &Direction) -> f64 {
        let share = share(halo);
        let of = |((bolt, x), s): ((&Bolt, &f64), &f64)| x * (share * bolt.stiffness * s - dot(&bolt.force, &y.p));
        self.bolts.iter().zip(&x.shortening).zip(&y.shortening).map(of).sum()
    }

    /// Minimises the energy over the shortenings with their stretches.
    pub(super) fn balance(&self, transformed: &Transformed, at: &mut Iterate) {
        at.shortening.resize(self.bolts.len(), 0.0);
        let along = |bolt: &Bolt| -> f64 {
            let left = |(v, x): &(u32, [f64; 3])| {
                let force = at.force(transformed, *v as usize);
                (0..3).map(|c| x[c] * force[c]).sum::<f64>()
            };
            bolt.stretch.iter().map(left).sum()
        };
        let halo = transformed.halo();
        let mut stretches: Vec<f64> = self.bolts.iter().map(along).collect();
        halo.sum(&mut stretches);
        let gradient: Vec<f64> = self.missing(halo, at).iter().zip(stretches).map(|(m, along)| m + along).collect();
        for ((bolt, change), s) in self.bolts.iter().zip(self.energy.solve(&gradient)).zip(&mut at.shortening) {
            *s += change;
            add(change, &bolt.stretch, &mut at.u);
            add(change, &bolt.image, &mut at.ku);
        }
    }

    /// Makes a direction without shortenings conjugate to them.
    pub(super) fn make_conjugate(&self, halo: &Halo, direction: &mut Direction) {
        let mut work: Vec<f64> = self.bolts.iter().map(|bolt| dot(&bolt.image, &direction.p)).collect();
        halo.sum(&mut work);
        direction.shortening = self.energy.solve(&work).into_iter().map(|change| -change).collect();
        for (bolt, &change) in self.bolts.iter().zip(&direction.shortening) {
            add(change, &bolt.stretch, &mut direction.p);
            add(change, &bolt.image, &mut direction.kp);
        }
    }

    /// `K u - s force` from `K u`.
    pub(super) fn take_off(&self, shortening: &[f64], ku: &mut Vector) {
        self.bolts.iter().zip(shortening).for_each(|(bolt, &s)| add(-s, &bolt.force, ku));
    }
}

/// An answer in which bolts have their forces, if it is `solved`.
#[derive(Debug)]
pub(crate) struct Tightened {
    /// Whether the iteration has converged.
    pub solved: bool,
    /// What is added to each shortening, length.
    pub shortening: Vec<f64>,
    /// Displacements, length `n`.
    pub u: Vec<f64>,
    /// Multipliers, newton, `3m`.
    pub lambda: Vec<f64>,
    /// Those of equations over many nodes.
    multipliers: Vec<f64>,
    /// What it cost.
    pub counts: Counts,
}

/// The iteration ends at this part of the tolerance: the answer is to hold with its shortenings fixed, and forces follow
/// displacements, a small part of the shortening, only in their first digits.
const ACCURACY: f64 = 0.1;

/// Solves contact with friction for displacements and for the shortenings of bolts whose force is given, by the first
/// stage of [`solve_multigrid`](super::solve_multigrid).
///
/// # Panics
/// As [`solve_multigrid`](super::solve_multigrid).
pub(crate) fn tighten_by_multigrid(
    problem: &ContactProblem,
    multigrid: &mut Multigrid,
    sought: &[SoughtForce],
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Tightened {
    tighten_with(problem, multigrid, (sought, None), settings, observer)
}

/// The same of a part of the points of a problem.
///
/// # Errors
/// If equations depend on one another.
///
/// # Panics
/// As [`tighten_by_multigrid`].
pub(crate) fn tighten_part(
    (whole, part): (&ContactProblem, &Part),
    multigrid: &mut Multigrid,
    sought: &[SoughtForce],
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Result<Tightened, Error> {
    let equations = Equations::of_part(whole, part, multigrid)?;
    let mut found = tighten_with(&part.problem, multigrid, (sought, equations.as_ref()), settings, observer);
    let multipliers = equations.as_ref().map_or(&[][..], |equations| equations.own(&found.multipliers));
    found.lambda = part.of_all(whole, &found.lambda, multipliers);
    multigrid.equations = equations;
    Ok(found)
}

fn tighten_with(
    problem: &ContactProblem,
    multigrid: &mut Multigrid,
    (sought, equations): (&[SoughtForce], Option<&Equations>),
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Tightened {
    if multigrid.has_strength(problem) {
        let mut found = multigrid.with_strength_off(problem, |shifted, multigrid| {
            tighten_by_multigrid(shifted, multigrid, sought, settings, observer)
        });
        problem.take_strength_off(&mut found.lambda);
        return found;
    }
    let Multigrid { transformed, hierarchy, .. } = multigrid;
    transformed.set_load(&problem.elastic.f);
    let transformed = &*transformed;
    let laws = point_laws(problem, transformed);
    let traits = Traits {
        floats: floats(transformed, equations),
        convex: false,
        has_equations: equations.is_some(),
        asked: settings.path == SolverPath::Multigrid,
        max_iterations: settings.max_iterations,
    };
    let tightening = Tightening::new(transformed, sought);
    let mut state = start(problem, (transformed, &laws, equations), (hierarchy, None), settings);
    let first = &STAGES[0];
    let subproblem = Subproblem {
        transformed,
        laws: &laws,
        tolerance: ACCURACY * settings.tolerance,
        max_cycles: (first.budget)(0, &traits),
        max_resets: 0,
        max_violation: f64::INFINITY,
        floating: None,
        tightening: Some(&tightening),
        equations,
    };
    let mut observe = |cycle: usize, residual: f64, states: [usize; 3]| observer(&progress(cycle, residual, states));
    let end = (first.run)(&subproblem, hierarchy, &mut state, &mut observe);
    let State { iterate, cycles, monitor, .. } = state;
    let lambda = multipliers(problem, transformed, &iterate);
    let u = transformed.out_of_frames(&iterate.u);
    let counts = Counts { cycles, restarts: monitor.resets, ..Counts::default() };
    let Iterate { shortening, multipliers, .. } = iterate;
    Tightened { solved: end == End::Converged, shortening, u, lambda, multipliers, counts }
}
