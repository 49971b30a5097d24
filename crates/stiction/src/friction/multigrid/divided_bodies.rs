//! Bodies that contact alone holds, where their nodes are divided among ranks: the motions of each are found from sums over all
//! ranks, which are the same on every one.

use crate::Error;
use crate::contact::among::Among;
use crate::contact::rigid::{FloatingBody, NO_ENERGY, RigidMotions};
use crate::contact::{Bodies, Body, ContactProblem, Division};
use crate::linalg::{dot, max_abs, symmetric_eigen};
use crate::ranks::{max, sum};

/// What is left of a motion beside the others, over its own length, below which it is their combination. Lengths come from sums of
/// squares, of which rounding leaves some 1e-8.
const DEPENDENT: f64 = 1e-6;
/// A motion is not resisted if no contact point sees more than this part of it.
const UNSEEN: f64 = 1e-6;

/// Combinations of the six motions of a body.
type Combination = [f64; 6];

/// The rigid motions that strain nothing, at the unknowns here; those of all ranks together have unit length. Every rank has all
/// bodies, those too of which it has no unknown. Empty where the problem has no near-kernel.
pub(super) fn divided_motions(problem: &ContactProblem, division: &Division) -> RigidMotions {
    let (Some(kernel), Some(bodies), Some(labels)) =
        (&problem.elastic.near_kernel, &problem.labels.bodies, &problem.elastic.node_of)
    else {
        return Default::default();
    };
    let moved: Vec<Combination> =
        kernel.iter().zip(&bodies.of).map(|(row, &b)| about(row, &bodies.list[b as usize], bodies)).collect();
    let forces: [Vec<f64>; 6] =
        std::array::from_fn(|q| problem.elastic.K.times(&moved.iter().map(|row| row[q]).collect::<Vec<_>>()));
    // Products of the motions, and with the forces that they cause.
    let mut products = vec![[[[0.0; 6]; 6]; 2]; bodies.list.len()];
    let mut largest = vec![0.0; bodies.list.len()];
    for (i, row) in moved.iter().enumerate().filter(|(i, _)| division.is_own(labels[*i])) {
        let b = bodies.of[i] as usize;
        largest[b] = f64::max(largest[b], problem.elastic.K.diagonal(i));
        for (p, q) in (0..6).flat_map(|p| (0..6).map(move |q| (p, q))) {
            products[b][0][p][q] += row[p] * row[q];
            products[b][1][p][q] += row[p] * forces[q][i];
        }
    }
    sum(&*division.ranks, products.as_flattened_mut().as_flattened_mut().as_flattened_mut());
    max(&*division.ranks, &mut largest);
    let floating = |b: usize| {
        let free = free_motions(&products[b], NO_ENERGY * largest[b]);
        let unknowns: Vec<u32> = (0..moved.len() as u32).filter(|&i| bodies.of[i as usize] as usize == b).collect();
        let motion = |c: &Combination| unknowns.iter().map(|&i| dot(c, &moved[i as usize])).collect();
        let motions = free.iter().map(motion).collect();
        let coefficients = free.iter().map(|c| of_kernel(c, &bodies.list[b], bodies)).collect();
        FloatingBody { place: Some(b), unknowns, motions, coefficients }
    };
    RigidMotions { bodies: (0..bodies.list.len()).map(floating).filter(|body| !body.motions.is_empty()).collect() }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A row of the near-kernel with rotations about the centre of the body, in radii.
fn about(row: &[f64; 6], body: &Body, bodies: &Bodies) -> Combination {
    let along = [row[0], row[1], row[2]];
    let shift = [0, 1, 2].map(|c| body.centre[c] - bodies.origin[c]);
    let less = cross(shift, along);
    std::array::from_fn(|q| if q < 3 { row[q] } else { (row[q] - less[q - 3]) / radius(body) })
}

fn radius(body: &Body) -> f64 {
    if body.radius > 0.0 { body.radius } else { 1.0 }
}

/// Such a combination as one of the columns of the near-kernel.
fn of_kernel(c: &Combination, body: &Body, bodies: &Bodies) -> [f64; 6] {
    let turn = [3, 4, 5].map(|q| c[q] / radius(body));
    let shift = cross(turn, [0, 1, 2].map(|c| body.centre[c] - bodies.origin[c]));
    std::array::from_fn(|q| if q < 3 { c[q] - shift[q] } else { turn[q - 3] })
}

/// Orthonormal combinations whose energy is at most `none`, from products of motions and their energies.
fn free_motions([gram, energy]: &[[[f64; 6]; 6]; 2], none: f64) -> Vec<Combination> {
    let product =
        |of: &[[f64; 6]; 6], a: &Combination, b: &Combination| -> f64 { (0..6).map(|p| a[p] * dot(&of[p], b)).sum() };
    let mut basis: Vec<Combination> = Vec::new();
    for k in 0..6 {
        let mut next: Combination = std::array::from_fn(|q| f64::from(u8::from(q == k)));
        // A small remainder has lost digits: it is made orthogonal once more.
        for _ in 0..2 {
            for other in &basis {
                let along = product(gram, &next, other);
                (0..6).for_each(|q| next[q] -= along * other[q]);
            }
        }
        let left = product(gram, &next, &next).max(0.0).sqrt();
        if left > DEPENDENT * gram[k][k].sqrt() {
            basis.push(next.map(|v| v / left));
        }
    }
    let entry = |a: &Combination, b: &Combination| {
        let value = 0.5 * (product(energy, a, b) + product(energy, b, a));
        if value.abs() <= none { 0.0 } else { value }
    };
    let energies: Vec<Vec<f64>> = basis.iter().map(|a| basis.iter().map(|b| entry(a, b)).collect()).collect();
    let (values, vectors) = symmetric_eigen(&energies);
    let free = values.into_iter().zip(vectors).filter(|(value, _)| *value <= none);
    let combined = |weights: Vec<f64>| -> Combination {
        std::array::from_fn(|q| weights.iter().zip(&basis).map(|(w, c)| w * c[q]).sum())
    };
    free.map(|(_, weights)| combined(weights)).collect()
}

/// Refuses motions that no contact point resists, whichever of them touch: nothing determines the displacement. `own` are the points
/// of this rank.
pub(super) fn refuse_unresisted(
    problem: &ContactProblem,
    division: &Division,
    motions: &RigidMotions,
    own: &[u32],
) -> Result<(), Error> {
    let m = problem.points();
    let jumps = motions.jumps(&problem.isotropic_rows());
    let carries = |i: usize| i < m || problem.contact.friction[i % m].bound(f64::MAX) > 0.0;
    let rows: Vec<usize> = own.iter().flat_map(|&j| problem.rows(j as usize)).filter(|&i| carries(i)).collect();
    let ranks = &*division.ranks;
    let among = Among { sum: &|values| sum(ranks, values), max: &|values| max(ranks, values), ..Among::ALONE };
    let none_held = vec![false; motions.len()];
    let free = motions.without_jump_among(&jumps, (&rows, &none_held), problem.contact.B.max_abs(), UNSEEN, &among);
    let Some(free) = free.first() else { return Ok(()) };
    let mut sizes: Vec<f64> = motions.bodies.iter().flat_map(|body| body.motions.iter().map(|r| max_abs(r))).collect();
    max(ranks, &mut sizes);
    let size = |a: usize| (free[a] * sizes[a]).abs();
    let most = (0..free.len()).fold(0, |best, a| if size(a) > size(best) { a } else { best });
    let mut of_motion = motions.bodies.iter().flat_map(|body| body.motions.iter().map(|_| body.place));
    let place = of_motion.nth(most).flatten();
    let name = problem.labels.bodies.as_ref().zip(place).map_or("", |(bodies, place)| &bodies.list[place].name);
    let what = format!("no support and no contact resists some rigid motion of body \"{name}\"");
    let remedy = "hold it by prescribed displacements or by friction; `stiction solve` says which motion it is";
    Err(Error::new("", what, remedy))
}
