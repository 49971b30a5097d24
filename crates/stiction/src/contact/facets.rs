//! Motions that curved surfaces resist by the facets of their meshes alone.
//!
//! A round pin without friction turns in its hole. The mesh of either is a polygon: normals differ a little from those of the other one,
//! and a small turn presses some facets and opens others. The equations then have a solution, and where it ends is a matter of
//! the mesh.

use super::among::Among;
use super::rigid::RigidMotions;
use super::sliding::{PRESSED, WORKS};
use super::{ContactProblem, Friction};
use crate::linalg::{axpy, dot, max_abs, norm, symmetric_eigen};

/// A rigid motion of floating bodies along the surfaces that press against one another, but for how far their normals differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Faceted {
    /// The motion in the columns of [`RigidMotions`].
    pub alpha: Vec<f64>,
    /// By how much it moves the surfaces against one another, over how far: the root of the mean square, weighted with the normal forces;
    /// radians.
    pub slope: f64,
    /// By how much the normals of both surfaces differ where it moves, likewise; radians.
    pub angle: f64,
}

/// Slopes and angles below it are rounding: such a motion is along the surfaces.
const ROUNDING: f64 = 1e-6;
/// Each surface is off by its own facets. On a pin in a lug of quadratic tetrahedra, sixteen faces around, the slope is 0.3 times the angle, and 1.2 times
/// after a turn by 16 degrees, when few points are left in contact; 1.6 times in hexahedra whose nodes lie unevenly, and 5.3 times on waves of 18 %
/// in `tests/physics/facets.rs`, which do hold.
const SAFETY: f64 = 2.0;
/// Motions that move what presses by less than this part of others move something else.
const UNSEEN: f64 = 1e-12;

/// Of the rigid motions that the points pressed together at `lambda` (`3m`, newton) resist by no more than the normals of the two surfaces
/// differ, `angle` at each point (`m`, radians), the one along which the loads push; the one that is resisted least where they push along none.
/// `slides` tells of a point whether friction is at its limit there: it resists what turns the slip, a turn of a plug that is pressed into its
/// seat. `None` where there is no such motion, and where surfaces are flat.
pub fn held_by_facets(
    problem: &ContactProblem,
    motions: &RigidMotions,
    lambda: &[f64],
    slides: &dyn Fn(usize) -> bool,
    angle: &[f64],
) -> Option<Faceted> {
    held_among((problem, motions), (lambda, slides, angle), &Among::ALONE)
}

/// The same of the part of a problem that a rank has, the same on all.
pub(crate) fn held_among(
    (problem, motions): (&ContactProblem, &RigidMotions),
    (lambda, slides, angle): (&[f64], &dyn Fn(usize) -> bool, &[f64]),
    among: &Among,
) -> Option<Faceted> {
    if motions.is_empty() {
        return None;
    }
    let m = problem.points();
    let counted: Vec<usize> = (0..m).filter(|&j| (among.point)(j)).collect();
    let most = among.largest(counted.iter().map(|&j| lambda[j]));
    let pressed: Vec<usize> = counted.iter().copied().filter(|&j| lambda[j] > PRESSED * most).collect();
    if among.largest(pressed.iter().map(|&j| angle[j])) <= ROUNDING {
        return None;
    }
    let mut sums = [pressed.iter().map(|&j| lambda[j]).sum::<f64>(), counted.len() as f64];
    (among.sum)(&mut sums);
    let [sum, count] = sums;
    let is_in = |j: &usize| problem.contact.out.binary_search(&(*j as u32)).is_err();
    let tied = counted.iter().copied().filter(|&j| problem.contact.friction[j] == Friction::Bonded).filter(is_in);
    // Ties hold whatever they carry.
    let weights = pressed.iter().map(|&j| (j, lambda[j] / sum)).chain(tied.map(|j| (j, 1.0 / count)));
    let jumps = motions.jumps(&problem.isotropic_rows());
    let mut forces = lambda.to_vec();
    problem.to_isotropic(&mut forces);
    let row = |i: usize, factor: f64| jumps.entries_of(i).map(move |(a, v)| (a as usize, factor * v));
    // Motions by their largest displacement.
    let mut unit: Vec<f64> = motions.bodies.iter().flat_map(|b| b.motions.iter().map(|r| max_abs(r))).collect();
    (among.max)(&mut unit);
    unit.iter_mut().for_each(|length| *length = 1.0 / *length);
    let k = unit.len();
    let zero = || vec![vec![0.0; k]; k];
    // Squares of jumps: all, those that are resisted, and those that the differing normals would resist.
    let (mut whole, mut resisted, mut expected) = (zero(), zero(), zero());
    for (j, weight) in weights {
        let slides = slides(j) && problem.contact.friction[j] != Friction::Bonded;
        let (s, t) = (m + j, 2 * m + j);
        let friction = forces[s].hypot(forces[t]);
        let along = |[x, y]: [f64; 2]| row(s, x).chain(row(t, y)).collect::<Vec<_>>();
        let [first, second] = match friction > PRESSED * most {
            true => [[forces[s] / friction, forces[t] / friction], [-forces[t] / friction, forces[s] / friction]],
            false => [[1.0, 0.0], [0.0, 1.0]],
        };
        let across_resists = !slides || friction > PRESSED * most;
        let rows = [(row(j, 1.0).collect(), true), (along(first), !slides), (along(second), across_resists)];
        for (row, resists) in &rows {
            for &(a, of_a) in row {
                for &(b, of_b) in row {
                    let product = weight * of_a * unit[a] * of_b * unit[b];
                    whole[a][b] += product;
                    match resists {
                        true => resisted[a][b] += product,
                        false => expected[a][b] += angle[j] * angle[j] * product,
                    }
                }
            }
        }
    }
    for row in [&mut whole, &mut resisted, &mut expected].into_iter().flatten() {
        (among.sum)(row);
    }
    // Combinations that move what presses, each by one.
    let (values, vectors) = symmetric_eigen(&whole);
    let largest = values.iter().fold(0.0, |a: f64, b| a.max(*b));
    let seen: Vec<Vec<f64>> = values
        .iter()
        .zip(vectors)
        .filter(|(value, _)| **value > UNSEEN * largest)
        .map(|(value, vector)| vector.iter().map(|x| x / value.sqrt()).collect())
        .collect();
    let square = |matrix: &[Vec<f64>], v: &[f64]| matrix.iter().zip(v).map(|(row, x)| x * dot(row, v)).sum::<f64>();
    let image = |v: &Vec<f64>| resisted.iter().map(|row| dot(row, v)).collect::<Vec<f64>>();
    let images: Vec<Vec<f64>> = seen.iter().map(image).collect();
    let of_seen: Vec<Vec<f64>> = seen.iter().map(|v| images.iter().map(|image| dot(v, image)).collect()).collect();
    let (_, vectors) = symmetric_eigen(&of_seen);
    let faceted = |alpha: Vec<f64>| {
        let [size, slope, angle] = [&whole, &resisted, &expected].map(|matrix| square(matrix, &alpha).max(0.0).sqrt());
        Faceted { alpha, slope: slope / size, angle: angle / size }
    };
    let combined = |parts: &[f64], of: &[Vec<f64>]| {
        let mut alpha = vec![0.0; k];
        parts.iter().zip(of).for_each(|(&part, v)| axpy(part, v, &mut alpha));
        alpha
    };
    let mut found: Vec<Faceted> = vectors.iter().map(|weights| faceted(combined(weights, &seen))).collect();
    found.retain(|motion| motion.slope > ROUNDING && motion.slope <= SAFETY * motion.angle);
    let f = problem.elastic.f.iter().enumerate();
    let f: Vec<f64> = f.map(|(i, &f)| if (among.unknown)(i) { f } else { 0.0 }).collect();
    let mut work = motions.work(&f);
    (among.sum)(&mut work);
    let load: Vec<f64> = work.iter().zip(&unit).map(|(work, unit)| work * unit).collect();
    let along: Vec<Vec<f64>> = found.iter().map(|motion| motion.alpha.clone()).collect();
    let works: Vec<f64> = along.iter().map(|alpha| dot(alpha, &load)).collect();
    let possible = along.iter().map(|alpha| norm(alpha)).fold(0.0, f64::max) * norm(&load);
    let chosen = match norm(&works) > WORKS * possible {
        true => Some(faceted(combined(&works, &along))),
        false => found.into_iter().min_by(|a, b| a.slope.total_cmp(&b.slope)),
    }?;
    let alpha = chosen.alpha.iter().zip(&unit).map(|(a, unit)| a * unit).collect();
    Some(Faceted { alpha, ..chosen })
}
