//! Whether contact forces can balance the loads on floating bodies at all: statics of rigid bodies, before any
//! elasticity.

use super::hull::Hull;
use super::rigid::RigidMotions;
use super::stretch::Stretch;
use super::{ContactProblem, Friction};
use crate::fem::Motion;
use crate::linalg::{Csr, axpy, dot, max_abs, norm};
use crate::mesh::v3::V3;

/// A rigid motion of floating bodies, and why it matters.
#[derive(Debug, Clone, PartialEq)]
pub struct Slide {
    /// The motion in the columns of [`RigidMotions`], of unit length.
    pub alpha: Vec<f64>,
    /// Work of the loads on the motion over that of a load of the same size in its direction, from 0 to 1.
    pub work: f64,
}

/// A motion counts as resisted if some contact point moves by this part of the largest displacement in a direction in
/// which it can carry force. As [`unconstrained_motions`](crate::fem::unconstrained_motions) for supports.
const UNSEEN: f64 = 1e-6;

/// Loads out of balance by less than this part of their resultants may be in balance: a projection on a cone cannot
/// tell angles better than the root of rounding.
const BALANCED: f64 = 3e-8;

/// What rounding may leave of the resultants of forces that cancel, as a part of the sum of their sizes.
const ROUNDING: f64 = 1e-13;

/// Generators that may be added to the hull. Some ten for each motion were needed in trials.
const GENERATORS: usize = 4000;

/// A rigid motion in which no contact point moves in a direction in which it can carry force, whichever points touch:
/// nothing determines the displacement, whether or not the loads work on it. Where they do, the motion is the one they
/// cause. `None` where every motion is resisted.
pub fn unresisted(problem: &ContactProblem, motions: &RigidMotions) -> Option<Slide> {
    let jumps = motions.jumps(&problem.isotropic_rows());
    if motions.is_empty() {
        return None;
    }
    let m = problem.points();
    let carries = |i: usize| i < m || problem.contact.friction[i % m].bound(f64::MAX) > 0.0;
    let rows: Vec<usize> = (0..3 * m).filter(|&i| carries(i)).collect();
    let free = motions.without_jump(&jumps, &rows, problem.contact.B.max_abs(), UNSEEN);
    let first = free.first()?.clone();
    let load = motions.work(&problem.elastic.f);
    let mut caused = vec![0.0; load.len()];
    free.iter().for_each(|v| axpy(dot(v, &load) / dot(v, v), v, &mut caused));
    // Forces that have no resultant, such as those of heat, leave rounding.
    let has_resultant = norm(&load) > ROUNDING * motions.work_size(&problem.elastic.f);
    let pushed = has_resultant && dot(&caused, &load) > BALANCED * norm(&load) * norm(&caused);
    Some(if pushed { slide(caused, &load) } else { Slide { work: 0.0, ..slide(first, &load) } })
}

fn slide(alpha: Vec<f64>, load: &[f64]) -> Slide {
    let length = norm(&alpha);
    let alpha: Vec<f64> = alpha.iter().map(|a| a / length).collect();
    let work = dot(&alpha, load) / norm(load).max(f64::MIN_POSITIVE);
    Slide { alpha, work }
}

/// The motion in which floating bodies leave where no admissible contact forces balance their loads; `None` where there
/// are such forces (to a few parts in 1e8), or where it could not be decided.
///
/// The resultants of admissible forces form a convex set; the loads are projected on it, and what is left is a motion
/// on which they do more work than any friction can take up (Gale's and Farkas' alternative). The set is the hull of one
/// force a point, the one that a motion meets: those are added one by one, and the projection on the cone of those found
/// so far is that of Lawson & Hanson (`Hull`). What weak friction alone can take up is asked on a scale of its own (`Stretch`).
pub fn no_equilibrium(problem: &ContactProblem, motions: &RigidMotions) -> Option<Slide> {
    no_equilibrium_with(problem, motions, &problem.elastic.f)
}

/// The same under other loads, newton, length `n`.
pub(crate) fn no_equilibrium_with(problem: &ContactProblem, motions: &RigidMotions, loads: &[f64]) -> Option<Slide> {
    let load = motions.work(loads);
    let terms = motions.work_size(loads);
    // Forces that have no resultant, such as those of heat, leave rounding.
    if norm(&load) <= ROUNDING * terms {
        return None;
    }
    let jumps = motions.jumps(&problem.isotropic_rows());
    no_equilibrium_of(&Bearing::of(problem, &jumps), motions, (&load, terms))
}

/// The contact points that may bear something, of all ranks where these share a problem.
pub(crate) struct Bearing<'a> {
    /// Jumps of the motions at the points, `3m` rows.
    pub jumps: &'a Csr,
    /// The law of each.
    pub friction: &'a [Friction],
    /// Those that take no part, ascending.
    pub out: &'a [u32],
}

impl<'a> Bearing<'a> {
    pub(super) fn of(problem: &'a ContactProblem, jumps: &'a Csr) -> Self {
        Bearing { jumps, friction: &problem.contact.friction, out: &problem.contact.out }
    }

    fn rows(&self, j: usize) -> [usize; 3] {
        let m = self.friction.len();
        [j, m + j, 2 * m + j]
    }

    /// The points that take part, and the rows of each.
    pub(super) fn points(&self) -> impl Iterator<Item = (usize, [usize; 3])> + '_ {
        let is_in = |j: &usize| self.out.binary_search(&(*j as u32)).is_err();
        (0..self.friction.len()).filter(is_in).map(|j| (j, self.rows(j)))
    }
}

/// The same of these points, where the loads do the work `load` on the motions; it adds up terms whose sizes come to `terms`, newton.
pub(crate) fn no_equilibrium_of(
    bearing: &Bearing,
    motions: &RigidMotions,
    (load, terms): (&[f64], f64),
) -> Option<Slide> {
    let size = norm(load);
    if size <= ROUNDING * terms {
        return None;
    }
    let found = departs(bearing, load, size);
    if found.is_some() {
        return found;
    }
    let stretch = Stretch::of_weak_friction(bearing, motions, (load, terms))?;
    let stretched = stretch.rows(bearing.jumps);
    let alpha = departs(&Bearing { jumps: &stretched, ..*bearing }, &stretch.times(load), size)?.alpha;
    Some(slide(stretch.times(&alpha), load))
}

/// How far parts go along `slices` (displacements of all unknowns, by which nothing is strained) in the motion in which they leave,
/// floating bodies beside them, where no admissible contact forces balance the loads and the forces `pull`, newton, along the slices;
/// `None` where there are such forces. Without a unit.
pub(crate) fn departs_along(
    problem: &ContactProblem,
    motions: &RigidMotions,
    slices: &[Vec<f64>],
    pull: &[f64],
) -> Option<Vec<f64>> {
    let (f, rows) = (&problem.elastic.f, problem.isotropic_rows());
    let lengths: Vec<f64> = slices.iter().map(|slice| norm(slice)).collect();
    let of_unit_length = |(slice, length): (&Vec<f64>, &f64)| rows.times(slice).iter().map(|j| j / length).collect();
    let jumps = motions.jumps(&rows).beside(&slices.iter().zip(&lengths).map(of_unit_length).collect::<Vec<_>>());
    let mut load = motions.work(f);
    let mut terms = motions.work_size(f);
    for ((slice, length), pull) in slices.iter().zip(&lengths).zip(pull) {
        load.push((dot(f, slice) + pull) / length);
        terms += (f.iter().zip(slice).map(|(f, s)| (f * s).abs()).sum::<f64>() + pull.abs()) / length;
    }
    departs_along_of(&Bearing::of(problem, &jumps), (&load, terms), slices.len())
}

/// The same of these points, whose last motions are so many slices of unit length; `load` and `terms` as of [`no_equilibrium_of`].
pub(crate) fn departs_along_of(bearing: &Bearing, (load, terms): (&[f64], f64), slices: usize) -> Option<Vec<f64>> {
    let size = norm(load);
    if size <= ROUNDING * terms {
        return None;
    }
    let slide = departs(bearing, load, size)?;
    Some(slide.alpha[load.len() - slices..].to_vec())
}

/// Whether no admissible forces balance `load`, of which `size` counts as one.
fn departs(bearing: &Bearing, load: &[f64], size: f64) -> Option<Slide> {
    let forces = Forces { bearing, size };
    // Friction that is given is bounded by itself and no cone: a further coordinate, one for the loads, makes it one.
    let mut target: Vec<f64> = load.iter().map(|e| e / size).collect();
    target.push(1.0);
    let mut slack = vec![0.0; target.len()];
    slack[load.len()] = 1.0;
    let mut hull = Hull::new(target);
    hull.add(None, slack);
    let mut before = f64::INFINITY;
    for _ in 0..GENERATORS {
        let mut residual = hull.project();
        if norm(&residual) >= before {
            // Many updates of the factorisation may have left rounding.
            residual = hull.project_anew();
        }
        let distance = norm(&residual);
        if distance <= BALANCED {
            return None;
        }
        let Some((point, generator)) = forces.against(&residual) else {
            // No point can carry force.
            return Some(physical(&forces, &hull, residual, load));
        };
        // The error of the residual is the root of the angle; an angle of rounding gains nothing any more.
        if dot(&generator, &residual) <= 1e-14 * distance || distance >= before {
            return Some(physical(&forces, &hull, residual, load));
        }
        before = distance;
        hull.add(point, generator);
    }
    None
}

/// The motion without the lift that the cone of friction pairs with sliding: points that carry force stay on their
/// obstacle, if the loads still work on what remains.
fn physical(forces: &Forces, hull: &Hull, mut residual: Vec<f64>, load: &[f64]) -> Slide {
    residual.truncate(load.len());
    let carrying = hull.generators.iter().filter(|generator| generator.weight > 0.0);
    let carrying = carrying.filter_map(|generator| generator.point);
    let mut along = residual.clone();
    let mut normals: Vec<Vec<f64>> = Vec::new();
    for j in carrying {
        let jumps = forces.bearing.jumps;
        let mut normal = vec![0.0; jumps.cols];
        jumps.entries_of(j).for_each(|(k, jump)| normal[k as usize] = jump);
        let own = norm(&normal);
        for _ in 0..2 {
            normals.iter().for_each(|n| axpy(-dot(&normal, n), n, &mut normal));
        }
        let left = norm(&normal);
        if left > UNSEEN * own {
            normals.push(normal.iter().map(|v| v / left).collect());
        }
    }
    normals.iter().for_each(|n| axpy(-dot(&along, n), n, &mut along));
    let works = dot(&along, load) > UNSEEN * norm(&along) * norm(load) && norm(&along) > UNSEEN * norm(&residual);
    slide(if works { along } else { residual }, load)
}

struct Forces<'a> {
    bearing: &'a Bearing<'a>,
    /// Force that counts as one.
    size: f64,
}

impl Forces<'_> {
    /// The admissible force that takes up most of the work of the motion `residual`, by direction: a unit vector of the
    /// space of resultants, with its point if it is that of one point.
    fn against(&self, residual: &[f64]) -> Option<(Option<usize>, Vec<f64>)> {
        let jumps = self.bearing.jumps;
        let jump = jumps.times(&residual[..jumps.cols]);
        let mut best: Option<(f64, Option<usize>, Resultant)> = None;
        let mut offer = |point: Option<usize>, resultant: &Resultant| {
            let length = resultant.iter().map(|(_, v)| v * v).sum::<f64>().sqrt();
            if length > 0.0 {
                let score = resultant.iter().map(|&(k, v)| v * residual[k as usize]).sum::<f64>() / length;
                if best.as_ref().is_none_or(|(least, ..)| score > *least) {
                    best = Some((score, point, resultant.iter().map(|&(k, v)| (k, v / length)).collect()));
                }
            }
        };
        let mut resultant = Resultant::new();
        let mut friction = vec![0.0; residual.len()];
        for (j, rows) in self.bearing.points() {
            let [n, t1, t2] = rows.map(|i| jump[i]);
            let sliding = t1.hypot(t2);
            let along = if sliding > 0.0 { [t1 / sliding, t2 / sliding] } else { [0.0; 2] };
            let force = match self.bearing.friction[j] {
                Friction::None => [1.0, 0.0, 0.0],
                Friction::Coulomb { coefficient } => [1.0, coefficient * along[0], coefficient * along[1]],
                Friction::Limited { coefficient, limit } if limit < coefficient * self.size => {
                    // All forces: those of the normal alone, and one at the rim, which a part of it joins to zero.
                    let [press, rub] = [limit / coefficient / self.size, limit / self.size];
                    if press * n + rub * sliding > 0.0 {
                        self.add(rows, [press, rub * along[0], rub * along[1]], &mut friction);
                    }
                    [1.0, 0.0, 0.0]
                }
                // A limit beyond the loads rules where the forces of points press against one another, if at all.
                Friction::Limited { coefficient, .. } => [1.0, coefficient * along[0], coefficient * along[1]],
                Friction::Cohesive { coefficient, cohesion, tension } => {
                    // A cone from its cut-off: one force on the rim there, and the cone's own.
                    let [pull, rub] = [tension, (cohesion - coefficient * tension).max(0.0)].map(|x| x / self.size);
                    self.add(rows, [0.0 - pull, rub * along[0], rub * along[1]], &mut friction);
                    [1.0, coefficient * along[0], coefficient * along[1]]
                }
                Friction::Bonded => [n, t1, t2],
                Friction::Given { slip_bound } => {
                    let bound = slip_bound / self.size;
                    self.add(rows, [0.0, bound * along[0], bound * along[1]], &mut friction);
                    [1.0, 0.0, 0.0]
                }
            };
            resultant.clear();
            self.resultant(rows, force, &mut resultant);
            offer(Some(j), &resultant);
        }
        if norm(&friction) > 0.0 {
            *friction.last_mut()? = 1.0;
            offer(None, &friction.iter().enumerate().map(|(k, &v)| (k as u32, v)).collect());
        }
        best.map(|(_, point, resultant)| {
            let mut vector = vec![0.0; residual.len()];
            resultant.into_iter().for_each(|(k, v)| vector[k as usize] += v);
            (point, vector)
        })
    }

    /// Adds the resultants of a force at the three rows of a point.
    fn add(&self, rows: [usize; 3], force: [f64; 3], vector: &mut [f64]) {
        for (i, f) in rows.into_iter().zip(force) {
            self.bearing.jumps.entries_of(i).for_each(|(k, jump)| vector[k as usize] += jump * f);
        }
    }

    /// The same, of one point, by the few motions that it moves in.
    fn resultant(&self, rows: [usize; 3], force: [f64; 3], to: &mut Resultant) {
        for (i, f) in rows.into_iter().zip(force).filter(|(_, f)| *f != 0.0) {
            for (k, jump) in self.bearing.jumps.entries_of(i) {
                match to.iter_mut().find(|(motion, _)| *motion == k) {
                    Some((_, v)) => *v += jump * f,
                    None => to.push((k, jump * f)),
                }
            }
        }
    }
}

/// Resultants by their motions.
type Resultant = Vec<(u32, f64)>;

/// The motion in plain words: which bodies move, and how.
pub fn in_words(problem: &ContactProblem, motions: &RigidMotions, alpha: &[f64]) -> String {
    in_words_among(problem, motions, alpha, &|_| {})
}

/// The same where ranks share the problem; `max` takes the maxima over all of them.
pub(crate) fn in_words_among(
    problem: &ContactProblem,
    motions: &RigidMotions,
    alpha: &[f64],
    max: &dyn Fn(&mut [f64]),
) -> String {
    let moving = moving_among(motions, alpha, max);
    let names: Vec<String> = moving.iter().map(|&number| name(problem, motions, number)).collect();
    let Some(&first) = moving.first() else { return "no body moves".into() };
    format!("{}: {}{}", names[0], motion(problem, motions, first, alpha), with(&names))
}

/// The bodies that move beside the first.
pub(super) fn with(names: &[String]) -> String {
    match names.len() {
        0 | 1 => String::new(),
        _ => format!(", and with it {}", names[1..].join(", ")),
    }
}

/// The bodies that a motion moves, that which moves farthest first; `max` takes the maxima over all ranks.
pub(super) fn moving_among(motions: &RigidMotions, alpha: &[f64], max: &dyn Fn(&mut [f64])) -> Vec<usize> {
    let mut first = 0;
    let mut sizes = Vec::new(); // largest displacement of each body
    for body in &motions.bodies {
        let mut u = vec![0.0; body.unknowns.len()];
        body.motions.iter().zip(&alpha[first..]).for_each(|(r, &a)| axpy(a, r, &mut u));
        first += body.motions.len();
        sizes.push(max_abs(&u));
    }
    max(&mut sizes);
    let mut moving: Vec<(f64, usize)> = sizes.into_iter().zip(0..).collect();
    let largest = moving.iter().fold(0.0, |a: f64, b| a.max(b.0));
    moving.retain(|(size, _)| *size > 1e-3 * largest);
    moving.sort_by(|a, b| b.0.total_cmp(&a.0));
    moving.into_iter().map(|(_, number)| number).collect()
}

/// `the body`, or `body "name"` where there are several.
pub(super) fn name(problem: &ContactProblem, motions: &RigidMotions, number: usize) -> String {
    let body = &motions.bodies[number];
    match problem.labels.bodies.as_ref().zip(body.place) {
        Some((bodies, place)) if bodies.list.len() > 1 => format!("body \"{}\"", bodies.list[place].name),
        None if motions.bodies.len() > 1 => format!("the body of unknown {}", body.unknowns[0]),
        _ => "the body".into(),
    }
}

fn motion(problem: &ContactProblem, motions: &RigidMotions, number: usize, alpha: &[f64]) -> String {
    let (t, omega, origin, centre, radius) = velocity(problem, motions, number, alpha);
    Motion::of(t, omega, origin, centre, radius).to_string()
}

/// Translation and rotation of a body with the point they are about, and the body's centre and radius.
pub(super) fn velocity(
    problem: &ContactProblem,
    motions: &RigidMotions,
    number: usize,
    alpha: &[f64],
) -> (V3, V3, V3, V3, f64) {
    let first: usize = motions.bodies[..number].iter().map(|b| b.motions.len()).sum();
    let body = &motions.bodies[number];
    let mut six = [0.0; 6];
    body.coefficients.iter().zip(&alpha[first..]).for_each(|(c, &a)| axpy(a, c, &mut six));
    let bodies = problem.labels.bodies.as_ref().zip(body.place);
    let place = bodies.map(|(bodies, place)| (bodies.origin, &bodies.list[place]));
    let (origin, centre, radius) = place.map_or(([0.0; 3], [0.0; 3], 1.0), |(o, b)| (o, b.centre, b.radius));
    ([six[0], six[1], six[2]], [six[3], six[4], six[5]], origin, centre, radius)
}
