//! Closure of clearances: where loose parts come to rest when bolts draw them together.
//!
//! A bolt whose parts can approach each other without strain takes no force until something lies between them. That
//! motion, the rigid mode of the bolt, is found here, and the equilibrium of all parts as rigid bodies on an elastic
//! foundation, from which the shortening is searched and multigrid starts.

use crate::contact::equilibrium::departs_along;
use crate::contact::escape::Escape;
use crate::fem::{Cut, DofMap};
use crate::friction::rigid_equilibrium;
use crate::linalg::{SymmetricCsr, axpy};
use crate::run::pose::Prepared;
use crate::run::pose::bolts::{Bolt, Target};
use crate::run::pose::cut_sides::sides;

/// Forces at a cut that are left of a motion, over those of the shortening itself, below which it strains nothing.
const NO_STRAIN: f64 = 1e-8;

/// The parts that bolts draw together, as far as what is here of them.
pub(crate) struct Loose<'a> {
    /// Unknown displacements.
    pub unknowns: usize,
    /// For each bolt the displacements of the unknowns by which a unit of shortening strains nothing ([`rigid_mode`]).
    pub modes: &'a dyn Fn() -> Vec<Option<Vec<f64>>>,
    /// For each bolt the force through its cut that thermal strain causes while nothing moves; empty where there is none.
    pub thermal: &'a [f64],
    /// Finds the equilibrium of the parts as rigid bodies that may also move along slices, along which forces (newton) pull, from
    /// given displacements: displacements of the unknowns, and how far each slice goes.
    pub equilibrium: &'a Equilibrium<'a>,
}

type Equilibrium<'a> = dyn Fn(&[Vec<f64>], &[f64], Vec<f64>) -> (Vec<f64>, Vec<f64>) + 'a;

impl Loose<'_> {
    /// As [`close_clearance`].
    pub(crate) fn close(&self, targets: &[Target], from_rest: &[bool], shortening: &mut [f64]) {
        let wanted = |target: &Target| if let Target::Force(force) = target { Some(*force) } else { None };
        if !targets.iter().zip(from_rest).any(|(target, from_rest)| *from_rest && wanted(target).is_some()) {
            return;
        }
        let (mut slices, mut pull, mut bolts) = (Vec::new(), Vec::new(), Vec::new());
        let mut u = vec![0.0; self.unknowns];
        for (number, mode) in (self.modes)().into_iter().enumerate() {
            let Some(mode) = mode else { continue };
            match wanted(&targets[number]).filter(|_| from_rest[number]) {
                Some(force) => {
                    slices.push(mode);
                    // The loads contain it along the mode.
                    pull.push(force - self.thermal.get(number).copied().unwrap_or(0.0));
                    bolts.push(number);
                }
                None => axpy(shortening[number], &mode, &mut u),
            }
        }
        if !slices.is_empty() {
            let (_, way) = (self.equilibrium)(&slices, &pull, u);
            bolts.iter().zip(way).for_each(|(&bolt, way)| shortening[bolt] += way);
        }
    }

    /// As [`start`].
    pub(crate) fn start(&self, shortening: &[f64]) -> Option<Vec<f64>> {
        if shortening.iter().all(|&s| s == 0.0) {
            return None;
        }
        let mut u = vec![0.0; self.unknowns];
        let mut moved = false;
        for (mode, &s) in (self.modes)().iter().zip(shortening) {
            if let Some(mode) = mode {
                axpy(s, mode, &mut u);
                moved = true;
            }
        }
        moved.then(|| (self.equilibrium)(&[], &[], u).0)
    }
}

/// Displacements of the unknowns by which a unit of shortening strains nothing; `None` where the parts of the bolt are held or hang
/// together elsewhere. `sides` are those of [`sides`]; `largest` is told a number for the unknowns for which `is_own` is true, and
/// says the largest of all ranks.
pub(crate) fn rigid_mode(
    model: (&DofMap, &SymmetricCsr),
    cut: &Cut,
    [before, beyond]: &[Vec<bool>; 2],
    is_own: &dyn Fn(usize) -> bool,
    largest: &dyn Fn(f64) -> f64,
) -> Option<Vec<f64>> {
    let (dofs, k) = model;
    let mut wanted = vec![0.0; k.rows];
    for &(dof, force) in &cut.force {
        if let Some(wanted) = wanted.get_mut(dofs.unknown[dof as usize] as usize) {
            *wanted = force;
        }
    }
    let allowed = NO_STRAIN * largest(wanted.iter().fold(0.0, |a: f64, f| a.max(f.abs())));
    let moving = |part: &[bool], way: f64| {
        let of = |&dof: &u32| {
            if part[dofs.mesh_node(dof / 3) as usize] { way * cut.axis[dof as usize % 3] } else { 0.0 }
        };
        let motion: Vec<f64> = dofs.free.iter().map(of).collect();
        let forces = k.times(&motion);
        let left = forces.iter().zip(&wanted).enumerate().filter(|(i, _)| is_own(*i));
        let left = largest(left.fold(0.0, |a: f64, (_, (force, wanted))| a.max((force - wanted).abs())));
        (left <= allowed).then_some(motion)
    };
    moving(beyond, -1.0).or_else(|| moving(before, 1.0))
}

/// Adds to the shortening each bolt is searched from what its parts approach each other by before they bear its force;
/// `from_rest` marks the bolts that have no shortening of an earlier step.
pub(crate) fn close_clearance(prepared: &Prepared, targets: &[Target], from_rest: &[bool], shortening: &mut [f64]) {
    loose(prepared, |loose| loose.close(targets, from_rest, shortening));
}

/// How the loads carry away what bolts hold whose force is given (thermal strain pulls at a cut with forces that are among the loads, and in the
/// force through it): where their parts strain nothing as they come together or part, and no
/// forces of contact balance the loads and the forces of the bolts. The loads are those of `prepared`, in which no bolt is shortened.
pub(crate) fn escape_of_bolts(prepared: &Prepared, targets: &[Target]) -> Option<Escape> {
    let Prepared { mesh, model, problem, motions, loading, .. } = prepared;
    let (mut slices, mut pull, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (number, (bolt, target)) in loading.bolts.iter().zip(targets).enumerate() {
        let Target::Force(force) = target else { continue };
        let sides = sides(mesh, bolt);
        let mode = rigid_mode((&model.dofs, &problem.elastic.K), &bolt.cut, &sides, &|_| true, &|x| x);
        if let Some(mode) = mode {
            slices.push(mode);
            pull.push(force - loading.initial.thermal_force.get(number).copied().unwrap_or(0.0));
            names.push(&bolt.name);
        }
    }
    if slices.is_empty() {
        return None;
    }
    let way = departs_along(problem, motions, &slices, &pull)?;
    in_words(&names, &way)
}

/// How the parts of bolts with these names go along their axes.
pub(crate) fn in_words(names: &[&String], way: &[f64]) -> Option<Escape> {
    let (first, way) = names.iter().zip(way).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let (fact, remedy) = if *way > 0.0 {
        (
            "they come together: nothing that is held lies between them",
            "see to the contacts under its head and its nut, or tighten it by `shortening` first",
        )
    } else {
        (
            "they part: nothing but the force that is given holds them together",
            "give more force, lock it before it is loaded, or hold the parts by a support, a spring or a bonded contact",
        )
    };
    Some(Escape { motion: format!("the parts of bolt {first:?}"), facts: vec![fact.into()], remedy: remedy.into() })
}

/// Displacements of the parts as rigid bodies with the bolts as they stand now; `None` without a bolt that has a rigid mode.
pub(crate) fn start(prepared: &Prepared) -> Option<Vec<f64>> {
    loose(prepared, |loose| loose.start(&prepared.loading.initial.shortening))
}

/// The parts of a case on one machine, for `find`.
fn loose<T>(prepared: &Prepared, find: impl FnOnce(&Loose) -> T) -> T {
    let Prepared { mesh, model, problem, motions, loading, .. } = prepared;
    let mode =
        |bolt: &Bolt| rigid_mode((&model.dofs, &problem.elastic.K), &bolt.cut, &sides(mesh, bolt), &|_| true, &|x| x);
    let modes = || loading.bolts.iter().map(mode).collect();
    let equilibrium =
        |slices: &[Vec<f64>], pull: &[f64], u: Vec<f64>| rigid_equilibrium(problem, motions, slices, pull, u);
    let thermal = &loading.initial.thermal_force;
    find(&Loose { unknowns: problem.unknowns(), modes: &modes, thermal, equilibrium: &equilibrium })
}
