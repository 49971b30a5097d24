//! What contact across a distance that nothing closes does to the balance of moments.

use crate::contact::{Counterpart, InitialGap, SurfaceFriction};
use crate::mesh::v3::{V3, add, norm, scale, sub};
use crate::run::pose::Prepared;

/// Couples below this part of what the forces of their pair have about its centre are not worth a word: so much do forces have that
/// act at either side of a play, or across flat faces that stand for curved ones.
const SMALL: f64 = 0.01;

/// Forces below this part of what elements exert at a support before it cancels are what is left of the iteration: a body that is
/// turned without load has no others.
const NONE: f64 = 1e-8;

/// A pair whose forces on the two bodies cancel while their moments do not: its surfaces lie apart, as tied or with a gap that the
/// case calls closed, and shear acts at either.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Couple {
    pub pair: String,
    /// What is left of the moments, newton times length.
    pub moment: V3,
    /// Its size over the sum of the sizes of the moments that the forces at the points have about the centre of the pair.
    pub part: f64,
}

/// Pairs that leave a couple which counts; `u` are the displacements of the unknowns, `lambda` the contact forces.
pub(crate) fn couples(prepared: &Prepared, u: &[f64], lambda: &[f64]) -> Vec<Couple> {
    let problem = &prepared.problem;
    let (Some(supports), Some(motions)) = (&problem.labels.supports, &problem.elastic.near_kernel) else {
        return Vec::new();
    };
    let m = problem.points();
    let at_supports = |p: usize| supports.K.entries_of(p).map(|(i, k)| (k * u[i as usize]).abs()).sum::<f64>();
    let least = NONE * (0..supports.K.rows).map(at_supports).fold(0.0, f64::max);
    let mut found = Vec::new();
    for (k, (surface, pair)) in prepared.surfaces.iter().zip(&problem.labels.pairs).enumerate() {
        let Counterpart::Surface(master) = &surface.against else { continue };
        if surface.friction != SurfaceFriction::Bonded && master.gap == InitialGap::AsMeshed {
            continue;
        }
        let own = |(i, force): (usize, &f64)| if pair.points.contains(&(i % m)) { *force } else { 0.0 };
        let of_pair: Vec<f64> = lambda.iter().enumerate().map(own).collect();
        let [free, held] = [&problem.contact.B, &supports.B].map(|rows| rows.transpose_times(&of_pair));
        let mut moment = [0.0; 3];
        for (motion, force) in motions.iter().zip(&free).chain(supports.rigid.iter().zip(&held)) {
            (0..3).for_each(|c| moment[c] += motion[3 + c] * force);
        }
        let nodes = &prepared.facts.contacts[k].surface.nodes;
        let at = || nodes.iter().map(|&node| prepared.mesh.nodes[node as usize]);
        let centre = scale(1.0 / nodes.len().max(1) as f64, at().fold([0.0; 3], add));
        let size = |j: usize| norm(problem.rows(j).map(|i| lambda[i]));
        let whole: f64 = pair.points.clone().zip(at()).map(|(j, x)| size(j) * norm(sub(x, centre))).sum();
        let largest = pair.points.clone().map(size).fold(0.0, f64::max);
        let part = norm(moment) / whole;
        if part > SMALL && largest > least {
            found.push(Couple { pair: pair.name.clone(), moment, part });
        }
    }
    found
}
