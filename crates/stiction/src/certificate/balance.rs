use super::scales::{ROUNDING, measure};
use super::share::Share;
use crate::contact::{ContactProblem, Supports};
use crate::linalg::Csr;

/// Where nothing reacts on a body, rounding of its inner forces explains at most this part of the loads: an answer that has flown away
/// would explain any load by it.
const EXPLAINED: f64 = 1e-6;

/// Resultants of loads, reactions and contact forces of a body, over the sum of the magnitudes they add up from (that
/// of the body where it is largest): the largest component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// Imbalance of force over the sum of the sizes of all forces.
    pub force: f64,
    /// About the centre the rigid motions are taken about.
    pub moment: f64,
}

/// The forces on one body, newton, and how they balance.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyBalance {
    /// The body's name.
    pub name: String,
    /// Resultant of its loads, newton.
    pub load: [f64; 3],
    /// From the supports.
    pub support: [f64; 3],
    /// From all it touches.
    pub contact: [f64; 3],
    /// How far its forces and moments are from balance.
    pub balance: Balance,
}

#[derive(Default, Clone)]
struct Sums {
    sum: [f64; 6],
    magnitude: [f64; 6],
    rounding: [f64; 6],
    /// Sizes of the loads, and how many reactions do work on each motion.
    loaded: [f64; 6],
    reactions: [f64; 6],
    load: [f64; 3],
    support: [f64; 3],
    contact: [f64; 3],
}

impl Sums {
    /// Adds those of all ranks.
    fn join(&mut self, share: &Share) {
        let lists: [&mut [f64]; 8] = [
            &mut self.sum,
            &mut self.magnitude,
            &mut self.rounding,
            &mut self.loaded,
            &mut self.reactions,
            &mut self.load,
            &mut self.support,
            &mut self.contact,
        ];
        lists.into_iter().for_each(|list| share.sum(list));
    }

    fn add(&mut self, motion: &[f64; 6], force: f64, internal: f64) {
        for (k, &motion) in motion.iter().enumerate() {
            self.sum[k] += motion * force;
            self.magnitude[k] += (motion * force).abs();
            self.rounding[k] += (motion * internal).abs() * ROUNDING;
        }
    }

    /// A reaction, which is what the deformed body exerts: newton.
    fn react(&mut self, motion: &[f64; 6], force: f64, internal: f64) {
        self.add(motion, force, internal);
        self.reactions.iter_mut().zip(motion).for_each(|(count, &motion)| *count += f64::from(u8::from(motion != 0.0)));
    }
}

/// Adds the part of a force along the translations.
fn along(total: &mut [f64; 3], motion: &[f64; 6], force: f64) {
    (0..3).for_each(|k| total[k] += motion[k] * force);
}

/// Virtual work of all external forces, reactions and contact forces of each body on its six rigid motions. Without a
/// list of bodies everything counts as one. `internal` is `|K| |u|`: the reactions, where
/// there are some, add up to what is left at the free nodes, of which its rounding is a part.
pub(super) fn balances(
    problem: &ContactProblem,
    share: &Share,
    u: &[f64],
    lambda: &[f64],
    internal: &[f64],
) -> Option<Vec<BodyBalance>> {
    let (supports, free_rigid) = (problem.labels.supports.as_ref()?, problem.elastic.near_kernel.as_ref()?);
    let bodies = problem.labels.bodies.as_ref();
    let names: Vec<String> =
        bodies.map_or(vec!["body".into()], |b| b.list.iter().map(|body| body.name.clone()).collect());
    let mut sums = vec![Sums::default(); names.len()];
    let of = |list: Option<&Vec<u32>>, i: usize| list.map_or(0, |of| of[i] as usize);
    // What acts at points of no surface, equations and supports that end with a step, comes from outside.
    let m = problem.points();
    let split = |inside: bool| -> Vec<f64> {
        let of = |(i, l): (usize, &f64)| if (problem.labels.unity_sum[i % m] != 0.0) == inside { *l } else { 0.0 };
        lambda.iter().enumerate().map(of).collect()
    };
    let of_surfaces = split(true);
    let [contact_free, held_free] = [&of_surfaces, &split(false)].map(|l| problem.contact.B.transpose_times(l));
    for (i, motion) in free_rigid.iter().enumerate().filter(|(i, _)| share.has_unknown(*i)) {
        let body = &mut sums[of(bodies.map(|b| &b.of), i)];
        body.add(motion, supports.free_load[i], internal[i]);
        body.add(motion, -contact_free[i], 0.0);
        body.add(motion, -held_free[i], 0.0);
        body.loaded.iter_mut().zip(motion).for_each(|(sum, motion)| *sum += (motion * supports.free_load[i]).abs());
        along(&mut body.load, motion, supports.free_load[i]);
        along(&mut body.contact, motion, -contact_free[i]);
        along(&mut body.support, motion, -held_free[i]);
    }
    let forces = SupportForces::new(supports, u, &of_surfaces);
    for (i, motion) in supports.rigid.iter().enumerate().filter(|(i, _)| share.has_support(*i)) {
        let body = &mut sums[of(bodies.map(|b| &b.of_support), i)];
        // load - contact + reaction, where the reaction is K u - load + contact
        body.react(motion, forces.elastic[i], forces.magnitude(supports, i, u));
        along(&mut body.load, motion, supports.load[i]);
        along(&mut body.contact, motion, -forces.contact[i]);
        along(&mut body.support, motion, forces.elastic[i] - supports.load[i] + forces.contact[i]);
    }
    // Springs are supports whose force the stiffness holds already: here they act from outside.
    let springs = supports.spring_forces(u);
    for (i, &force) in springs.iter().enumerate() {
        let support = i.checked_sub(free_rigid.len());
        if !support.map_or_else(|| share.has_unknown(i), |p| share.has_support(p)) {
            continue;
        }
        let (motion, body) = match support {
            None => (&free_rigid[i], of(bodies.map(|b| &b.of), i)),
            Some(p) => (&supports.rigid[p], of(bodies.map(|b| &b.of_support), p)),
        };
        sums[body].react(motion, force, force.abs());
        along(&mut sums[body].support, motion, force);
    }
    sums.iter_mut().for_each(|sums| sums.join(share));
    // A body that nothing loads has forces of rounding only: no body is measured by less than the others carry.
    let scale = |range: std::ops::Range<usize>| {
        sums.iter().flat_map(|s| s.magnitude[range.clone()].to_vec()).fold(0.0, f64::max)
    };
    let (force_scale, moment_scale) = (scale(0..3), scale(3..6));
    // What a body's rounding leaves open is handed on to those it touches. Where nothing reacts on a body loads and contact forces have to
    // balance one another, however far it has gone; without loads all its forces are rounding.
    let rounding: [f64; 6] = std::array::from_fn(|k| {
        let largest = |reacts: bool| {
            let bodies = sums.iter().filter(|s| (s.reactions[k] > 0.0) == reacts);
            bodies.fold(0.0, |a: f64, s| a.max(s.rounding[k]))
        };
        let loaded = sums.iter().fold(0.0, |a: f64, s| a.max(s.loaded[k]));
        let explained = if loaded > 0.0 { EXPLAINED * loaded } else { f64::INFINITY };
        largest(true).max(largest(false).min(explained))
    });
    let balance = |(name, s): (String, &Sums)| {
        // A body that moves without load has reactions of rounding only: what rounding explains is no imbalance.
        let worst = |range: std::ops::Range<usize>, scale: f64| {
            range.map(|k| measure(s.sum[k].abs(), rounding[k], scale)).fold(0.0, f64::max)
        };
        let balance = Balance { force: worst(0..3, force_scale), moment: worst(3..6, moment_scale) };
        BodyBalance { name, load: s.load, support: s.support, contact: s.contact, balance }
    };
    Some(names.into_iter().zip(&sums).map(balance).collect())
}

/// The worst over all bodies.
pub(super) fn worst(bodies: &[BodyBalance]) -> Option<Balance> {
    let both = |a: Balance, b: Balance| Balance { force: a.force.max(b.force), moment: a.moment.max(b.moment) };
    bodies.iter().map(|b| b.balance).reduce(both)
}

/// At the prescribed displacements.
struct SupportForces {
    /// What the deformed body exerts.
    elastic: Vec<f64>,
    contact: Vec<f64>,
}

impl SupportForces {
    fn new(supports: &Supports, u: &[f64], lambda: &[f64]) -> Self {
        let held = supports.K.times(u);
        let own = supports.K_own.times(&supports.displacement);
        let elastic = held.iter().zip(&own).map(|(a, b)| a + b).collect();
        SupportForces { elastic, contact: supports.B.transpose_times(lambda) }
    }

    /// The size of the terms that `elastic` adds up.
    fn magnitude(&self, supports: &Supports, row: usize, u: &[f64]) -> f64 {
        row_magnitude(&supports.K, row, u) + row_magnitude(&supports.K_own, row, &supports.displacement)
    }
}

/// `|row| . |x|`: the size of the terms a product adds up.
fn row_magnitude(matrix: &Csr, row: usize, x: &[f64]) -> f64 {
    let (columns, values) = matrix.row(row);
    columns.iter().zip(values).map(|(&j, v)| (v * x[j as usize]).abs()).sum()
}
