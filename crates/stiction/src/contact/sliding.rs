//! How much of the loads on floating bodies friction can take up at given normal forces: limit analysis.

use rustc_hash::FxHashMap;

use super::among::Among;
use super::equilibrium::Bearing;
use super::rigid::RigidMotions;
use super::{ContactProblem, Friction};
use crate::linalg::{SmallLu, axpy, dot, norm};

/// A rigid motion of floating bodies along all surfaces that press against one another, and what friction does about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Sliding {
    /// The motion in the columns of [`RigidMotions`], such that the point that moves farthest moves by a unit length.
    pub alpha: Vec<f64>,
    /// Work of the loads on it: for a translation the force along it, newton.
    pub load: f64,
    /// The most that friction can take up of this work at the given normal forces.
    pub friction: f64,
}

/// Normal forces below this part of the largest hold nothing; rounding and the tolerance leave such.
pub(super) const PRESSED: f64 = 1e-9;
/// A motion keeps a surface shut if no point moves across it by more than this part of the largest displacement. As for
/// motions that contact does not resist.
const ALONG: f64 = 1e-6;
/// Work of the loads below this part of what they could do is rounding.
pub(super) const WORKS: f64 = 1e-9;
/// Steps of the weighted least squares; slips below a part of the largest count as that part, which halves each time.
const STEPS: usize = 60;

/// Of all rigid motions that slide along the surfaces pressed together at `lambda` (length `3m`, newton), the one of which
/// friction takes up the smallest part of what the loads do on it.
///
/// With the normal forces given, the bounds of friction are, and every motion bounds the loads that can be carried from
/// above (the kinematic theorem of limit analysis): loads that do more work on it than friction at its bounds cannot
/// rest as long as the normal forces are these. Coulomb friction may find rest with others; that is why this is no proof
/// that there is no equilibrium, as [`no_equilibrium`](super::equilibrium::no_equilibrium) is. Found by reweighted least
/// squares; how well decides only how sharp the bound is.
///
/// `None` if no such motion is loaded, or if it runs into a surface that does not touch yet.
pub fn least_resisted(problem: &ContactProblem, motions: &RigidMotions, lambda: &[f64]) -> Option<Sliding> {
    let jumps = motions.jumps(&problem.isotropic_rows());
    let load = motions.work(&problem.elastic.f);
    let largest = |alpha: &[f64]| largest_displacement(problem, motions, alpha);
    let bearing = Bearing::of(problem, &jumps);
    least_resisted_of((&bearing, motions), (lambda, &load), problem.contact.B.max_abs(), &largest, &Among::ALONE)
}

/// The same of these points and the work of the loads on the motions, on every rank: `scale` is the largest entry of the rows here, `largest` the
/// displacement in a motion of the node, of those here, that moves farthest; maxima are taken `among` the ranks.
pub(crate) fn least_resisted_of(
    (bearing, motions): (&Bearing, &RigidMotions),
    (lambda, load): (&[f64], &[f64]),
    scale: f64,
    largest: &dyn Fn(&[f64]) -> f64,
    among: &Among,
) -> Option<Sliding> {
    let (m, jumps, laws) = (bearing.friction.len(), bearing.jumps, bearing.friction);
    let most_pressed = lambda[..m].iter().fold(0.0, |a: f64, n| a.max(*n));
    let pressed = |j: usize| laws[j] == Friction::Bonded || lambda[j] > PRESSED * most_pressed;
    let constrained = (0..3 * m).filter(|&i| pressed(i % m) && (i < m || laws[i % m] == Friction::Bonded));
    let (constrained, held) = (constrained.collect::<Vec<_>>(), vec![false; motions.len()]);
    let along = motions.without_jump_among(jumps, (&constrained, &held), scale, ALONG, among);
    let force: Vec<f64> = along.iter().map(|a| dot(a, load)).collect();
    let possible = along.iter().map(|a| norm(a)).fold(0.0, f64::max) * norm(load);
    if norm(&force) <= WORKS * possible {
        return None;
    }
    let of_motions: Vec<Vec<f64>> = along.iter().map(|a| jumps.times(a)).collect();
    // Tied points do not slide.
    let bound = |j: usize| Some(laws[j].bound(lambda[j])).filter(|g| g.is_finite());
    let bounds: Vec<f64> = (0..m).map(|j| bound(j).unwrap_or(0.0)).collect();
    let weights = least_dissipation(&of_motions, &bounds, &force);
    let mut alpha = vec![0.0; load.len()];
    weights.iter().zip(&along).for_each(|(&w, a)| axpy(w, a, &mut alpha));
    let size = among.largest(std::iter::once(largest(&alpha)));
    alpha.iter_mut().for_each(|a| *a /= size);
    let jump = jumps.times(&alpha);
    if (0..m).any(|j| !pressed(j) && jump[j] > ALONG) {
        return None;
    }
    let friction = (0..m).map(|j| bounds[j] * jump[m + j].hypot(jump[2 * m + j])).sum();
    Some(Sliding { load: dot(&alpha, load), friction, alpha })
}

/// The weights `w` of the motions with `force . w = 1` of which friction takes up the least, `sum of bound |T w|`.
fn least_dissipation(jumps: &[Vec<f64>], bounds: &[f64], force: &[f64]) -> Vec<f64> {
    let (k, m) = (jumps.len(), bounds.len());
    let mut slips = vec![1.0; m];
    let mut part = 1.0;
    let mut w = vec![0.0; k];
    for _ in 0..STEPS {
        let weight: Vec<f64> = bounds.iter().zip(&slips).map(|(g, s)| g / s).collect();
        let product = |a: usize, b: usize| -> f64 {
            let at = |i: usize| jumps[a][i] * jumps[b][i];
            (0..m).map(|j| weight[j] * (at(m + j) + at(2 * m + j))).sum()
        };
        let mut matrix: Vec<Vec<f64>> = (0..k).map(|a| (0..k).map(|b| product(a, b)).collect()).collect();
        let trace: f64 = (0..k).map(|a| matrix[a][a]).sum();
        // What friction does not resist at all would make the matrix singular.
        (0..k).for_each(|a| matrix[a][a] += 1e-12 * trace.max(f64::MIN_POSITIVE));
        w = SmallLu::new(matrix).solve(force);
        let work = dot(&w, force);
        w.iter_mut().for_each(|w| *w /= work);
        part *= 0.5;
        let sum = |row: usize| jumps.iter().zip(&w).map(|(g, w)| g[row] * w).sum::<f64>();
        slips = (0..m).map(|j| sum(m + j).hypot(sum(2 * m + j))).collect();
        let least = part * slips.iter().fold(0.0, |a: f64, s| a.max(*s));
        slips.iter_mut().for_each(|s| *s = s.max(least).max(f64::MIN_POSITIVE));
    }
    w
}

/// Of all nodes; of all unknowns where nodes are not known. Length.
pub(crate) fn largest_displacement(problem: &ContactProblem, motions: &RigidMotions, alpha: &[f64]) -> f64 {
    let mut u = vec![0.0; problem.unknowns()];
    motions.add(alpha, &mut u);
    let mut squares: FxHashMap<u32, f64> = FxHashMap::default();
    for (i, u) in u.iter().enumerate() {
        let node = problem.elastic.node_of.as_ref().map_or(i as u32, |of| of[i]);
        *squares.entry(node).or_default() += u * u;
    }
    squares.values().fold(0.0, |a: f64, s| a.max(*s)).sqrt()
}
