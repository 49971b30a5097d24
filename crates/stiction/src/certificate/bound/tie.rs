//! Whether the fields of a bound speak of a problem and its answer: the same displacements, forces, supports, obstacles and
//! friction.

use std::collections::{HashMap, HashSet};

use super::super::scales::ROUNDING;
use super::cells::{at_corners, gradients, places, stress_at_corners};
use super::sides::{Outside, RADON, judge_faces, side_nodes};
use super::vectors::{V3, ascending, basis, dot, length, minus, ratio, traction};
use super::{BOUND_TOLERANCE, BoundFields, BoundMeasure, Touch, Worst, damaged, validate};
use crate::Error;
use crate::contact::{ContactProblem, Friction};

/// Displacements may differ by this part of the largest; the answer and the fields are written with all their digits, but
/// tied faces are put in their place.
const DISPLACEMENTS: f64 = 1e-6;

/// What the fields have in common with a problem and the displacements `u` of its unknowns: each measure is at most
/// [`BOUND_TOLERANCE`] where they agree.
///
/// The forces of the stress of `found` less the loads have to be `K u - f` at every unknown, which holds nodes, cells,
/// materials, loads, initial strains and prescribed displacements against the problem.
///
/// # Errors
/// If arrays do not fit each other or the problem.
///
/// # Panics
/// If `u` has not one entry for each unknown.
pub fn judge_tie(fields: &BoundFields, problem: &ContactProblem, u: &[f64]) -> Result<Vec<BoundMeasure>, Error> {
    assert_eq!(u.len(), problem.unknowns());
    validate(fields)?;
    if fields.unknowns.len() != u.len() {
        let what = format!("they have {} unknowns and the problem has {}", fields.unknowns.len(), u.len());
        return Err(damaged(what));
    }
    let mut worst = Worst::default();
    let outside = judge_faces(fields, 1.0, &mut Worst::default())?;
    let at = |i: usize| fields.unknowns[i].node as usize;
    let own: Vec<f64> = (0..u.len())
        .map(|i| dot(fields.unknowns[i].direction, std::array::from_fn(|c| fields.found[3 * at(i) + c])))
        .collect();
    let most = fields.found.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    for (i, (own, u)) in own.iter().zip(u).enumerate() {
        let off = ratio((own - u).abs(), most) * (BOUND_TOLERANCE / DISPLACEMENTS);
        worst.see("displacements of solution.npz", off, || node(at(i)));
    }
    let forces = forces(fields, &outside);
    let (of_problem, magnitude) = (problem.elastic.K.times(&own), problem.elastic.K.magnitude_times(&own));
    let size = magnitude.iter().chain(&problem.elastic.f).fold(0.0, |m: f64, v| m.max(v.abs()));
    for i in 0..u.len() {
        let force = dot(fields.unknowns[i].direction, forces[at(i)]);
        let off = (force - (of_problem[i] - problem.elastic.f[i])).abs();
        worst.see("forces of problem.npz", ratio(off, size), || node(at(i)));
    }
    supports(fields, problem, &outside, &mut worst);
    contact(fields, problem, &outside, most, &mut worst);
    Ok(worst.0)
}

fn node(i: usize) -> String {
    format!("node {}", i + 1)
}

/// Forces of the stress of the displacements found less the loads, at the nodes.
fn forces(fields: &BoundFields, outside: &HashMap<[u32; 3], Outside>) -> Vec<V3> {
    let mut sum = vec![[0.0; 3]; fields.nodes.len()];
    let mut add = |node: u32, factor: f64, force: V3| {
        let own = &mut sum[node as usize];
        (0..3).for_each(|c| own[c] += factor * force[c]);
    };
    for cell in 0..fields.corners.len() {
        let x = places(fields, cell);
        let (six, gradient) = gradients([x[0], x[1], x[2], x[3]]);
        let volume = six.abs() / 6.0;
        let stress = stress_at_corners(fields, &fields.found, cell, &gradient);
        let force = fields.body_force.get(cell).copied().unwrap_or([0.0; 3]);
        // Stress and gradients of functions are linear, and so are integrated exactly.
        let of = |slopes: [V3; 4]| -> V3 {
            let total: V3 = std::array::from_fn(|c| slopes.iter().map(|slope| slope[c]).sum());
            let each = stress.iter().zip(slopes).map(|(stress, slope)| {
                let (own, shared) = (traction(stress, slope), traction(stress, total));
                std::array::from_fn(|c| own[c] + shared[c])
            });
            each.fold([0.0; 3], |sum, more: V3| std::array::from_fn(|c| sum[c] + volume / 20.0 * more[c]))
        };
        let middles = fields.middles.get(cell);
        for (k, &node) in fields.corners[cell].iter().chain(middles.into_iter().flatten()).enumerate() {
            add(node, 1.0, of(at_corners(k, middles.is_some(), &gradient)));
            let share = match (middles.is_some(), k < 4) {
                (false, _) => 0.25,
                (true, true) => -0.05,
                (true, false) => 0.2,
            };
            add(node, -share * volume, force);
        }
    }
    for side in &fields.sides {
        let Some(own) = outside.get(&ascending(side.corners)) else { continue };
        let nodes = side_nodes(fields, side, own);
        for (w, weight) in RADON {
            let load: V3 = std::array::from_fn(|c| (0..3).map(|a| w[a] * side.load[a][c]).sum());
            for (k, &node) in nodes.iter().enumerate() {
                let Some(node) = node else { continue };
                let value = match (nodes[3].is_some(), k.checked_sub(3)) {
                    (false, _) => w[k],
                    (true, None) => w[k] * (2.0 * w[k] - 1.0),
                    (true, Some(a)) => 4.0 * w[(a + 1) % 3] * w[(a + 2) % 3],
                };
                add(node, -weight * own.area * value, load);
            }
        }
    }
    sum
}

/// Where a face is said to be held no node may be free, but where contact ties it.
fn supports(fields: &BoundFields, problem: &ContactProblem, outside: &HashMap<[u32; 3], Outside>, worst: &mut Worst) {
    let mut tied = HashSet::<u32>::new();
    for (j, _) in problem.contact.friction.iter().enumerate().filter(|(_, law)| **law == Friction::Bonded) {
        problem.rows(j).into_iter().for_each(|row| tied.extend(problem.contact.B.row(row).0.iter().copied()));
    }
    let mut free: HashMap<u32, Vec<V3>> = HashMap::new();
    for (_, unknown) in (0..).zip(&fields.unknowns).filter(|(i, _)| !tied.contains(i)) {
        free.entry(unknown.node).or_default().push(unknown.direction);
    }
    for side in fields.sides.iter().filter(|side| !side.held.is_empty()) {
        let Some(own) = outside.get(&ascending(side.corners)) else { continue };
        for held in basis(&side.held) {
            for at in side_nodes(fields, side, own).into_iter().flatten() {
                let off = free.get(&at).into_iter().flatten().map(|&d| dot(d, held).abs()).fold(0.0, f64::max);
                worst.see("supports of problem.npz", off, || node(at as usize));
            }
        }
    }
}

/// Obstacles and laws of friction at the contact points.
fn contact(
    fields: &BoundFields,
    problem: &ContactProblem,
    outside: &HashMap<[u32; 3], Outside>,
    most: f64,
    worst: &mut Worst,
) {
    let mut touches: HashMap<u32, Vec<(&Touch, usize)>> = HashMap::new();
    let mut references: HashMap<(u32, u32), V3> = HashMap::new();
    for side in fields.sides.iter().filter(|side| !side.touches.is_empty()) {
        let Some(own) = outside.get(&ascending(side.corners)) else { continue };
        for (k, node) in side_nodes(fields, side, own).into_iter().enumerate() {
            let of_node = node.map(|node| touches.entry(node).or_default());
            // A middle has the law of one of its ends.
            let corner = if k < 3 { k } else { (k - 2) % 3 };
            of_node.into_iter().for_each(|list| list.extend(side.touches.iter().map(|touch| (touch, corner))));
            for (node, touch) in node.into_iter().flat_map(|node| side.touches.iter().map(move |touch| (node, touch))) {
                let first = *references.entry((node, touch.obstacle)).or_insert(touch.reference[k]);
                let off = ratio(length(minus(touch.reference[k], first)), most);
                worst.see(REFERENCE, off, || self::node(node as usize));
            }
        }
    }
    let mut unknowns_of: HashMap<u32, usize> = HashMap::new();
    fields.unknowns.iter().for_each(|unknown| *unknowns_of.entry(unknown.node).or_default() += 1);
    let contact = &problem.contact;
    for (j, law) in contact.friction.iter().enumerate().filter(|(_, law)| **law != Friction::Bonded) {
        let [normals, tangents @ ..] = problem.rows(j).map(|row| by_node(fields, problem, row));
        if normals.is_empty() {
            continue;
        }
        // The point is that of the node with the largest part.
        let known = normals.iter().filter(|(node, _)| touches.contains_key(node));
        let Some(&(own, _)) = known.max_by(|a, b| length(a.1).total_cmp(&length(b.1))) else {
            worst.see("obstacles of problem.npz", f64::INFINITY, || format!("contact point {}", j + 1));
            continue;
        };
        let m = contact.friction.len();
        let at_supports =
            |row: usize| problem.labels.supports.as_ref().is_some_and(|supports| !supports.B.row(row).0.is_empty());
        let of_touch = |(touch, corner): &(&Touch, usize)| -> [f64; 3] {
            let obstacle = &fields.obstacles[touch.obstacle as usize];
            let (mut turned, mut gap, mut scale): (f64, f64, f64) = (0.0, 0.0, 0.0);
            // What the row has at nodes that are held altogether is not among its unknowns.
            let mut whole = !at_supports(j);
            for (node, normal) in &normals {
                let x = fields.nodes[*node as usize];
                let along = dot(*normal, obstacle.normal);
                let across = minus(*normal, obstacle.normal.map(|n| along * n));
                // What supports hold of a node has no unknown.
                whole &= unknowns_of[node] == 3;
                turned = if unknowns_of[node] == 3 { turned.max(length(across)) } else { turned };
                gap += along * (obstacle.offset - dot(obstacle.normal, x));
                scale += along.abs() * (obstacle.offset.abs() + length(x));
            }
            let off = ((gap - contact.gap[j]).abs() - contact.rounding - 100.0 * ROUNDING * scale).max(0.0);
            let off = if whole { ratio(off, most) } else { 0.0 };
            let slip = |(row, of_nodes): (usize, &Vec<(u32, V3)>)| {
                let parts = of_nodes.iter().map(|&(node, part)| {
                    references.get(&(node, touch.obstacle)).map_or(f64::NAN, |&reference| dot(part, reference))
                });
                let off = (parts.sum::<f64>() - contact.slip_reference[row * m + j]).abs() - contact.rounding;
                // What holds nothing back slips by nothing that matters.
                if whole && *law != Friction::None { ratio(off.max(0.0), most) } else { 0.0 }
            };
            let slips = tangents.iter().enumerate().map(slip).fold(0.0, |a: f64, b| if b <= a { a } else { b });
            [turned.max(off), differs(law, touch.law[*corner], problem.labels.area[j]), slips]
        };
        let all: Vec<[f64; 3]> = touches[&own].iter().map(of_touch).collect();
        // A node in a corner has two obstacles: the point belongs to the one whose normal it has.
        let nearest = all.iter().map(|values| values[0]).fold(f64::INFINITY, f64::min);
        worst.see("obstacles of problem.npz", nearest, || node(own as usize));
        for (k, name) in [(1, "friction of problem.npz"), (2, REFERENCE)] {
            let of_nearest = all.iter().filter(|values| values[0] == nearest).map(|values| values[k]);
            worst.see(name, of_nearest.fold(f64::INFINITY, f64::min), || node(own as usize));
        }
    }
}

/// Name of the measure of the displacements from which slip is measured.
const REFERENCE: &str = "slip reference of problem.npz";

/// What a row of `B` has at each node.
fn by_node(fields: &BoundFields, problem: &ContactProblem, row: usize) -> Vec<(u32, V3)> {
    let (columns, values) = problem.contact.B.row(row);
    let mut parts: Vec<(u32, V3)> = Vec::new();
    for (&i, &value) in columns.iter().zip(values) {
        let unknown = &fields.unknowns[i as usize];
        let part = unknown.direction.map(|d| value * d);
        match parts.iter_mut().find(|(node, _)| *node == unknown.node) {
            Some((_, sum)) => (0..3).for_each(|c| sum[c] += part[c]),
            None => parts.push((unknown.node, part)),
        }
    }
    parts
}

/// How far a law of friction is from one of tractions, as part of its numbers.
fn differs(law: &Friction, [coefficient, most]: [f64; 2], area: f64) -> f64 {
    let expected = match *law {
        Friction::None => [f64::INFINITY, 0.0],
        Friction::Given { slip_bound } => [f64::INFINITY, slip_bound / area],
        Friction::Coulomb { coefficient } => [coefficient, f64::INFINITY],
        Friction::Limited { coefficient, limit } => [coefficient, limit / area],
        // A bound knows no cohesion.
        Friction::Cohesive { .. } => return f64::INFINITY,
        Friction::Bonded => return 0.0,
    };
    let off = |a: f64, b: f64| if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) };
    let nothing = |[coefficient, most]: [f64; 2]| coefficient == 0.0 || most == 0.0;
    if nothing(expected) && nothing([coefficient, most]) {
        return 0.0;
    }
    let off = off(expected[0], coefficient).max(off(expected[1], most));
    if off.is_nan() { f64::INFINITY } else { off }
}
