//! Pressure and shear of the surfaces in contact, in the results only: no solver and no certificate knows them.
//!
//! Against an obstacle they are force over area of a point. Between two bodies that quotient scatters: forces of several
//! points whose sum vanishes at each node of the master are determined by the stiffness of the slave alone, and where a
//! face of the slave hangs over the edge of the master, points beyond the edge have hardly any area but a lever arm. The
//! two bodies exchange the force `sum_j int psi_j phi_k lambda_j / D_jj` at each node `k` of the master. Over the area
//! `int phi_k` that the slave covers there it is the pressure of the master. A point of the slave takes the mean of the
//! nodes of the master that it shares area with. A constant pressure stays at each node whatever is covered, resultants
//! stay to 1e-4 (to 1e-2 where the contact ends at a rim), and with matching meshes nothing changes.

use std::collections::BTreeMap;

use crate::contact::{ContactProblem, Counterpart, Master, TributaryArea, tributary_areas};
use crate::fem::DofMap;
use crate::mesh::v3::{V3, add, dot, scale};
use crate::run::pose::Prepared;
use crate::run::pose::frames::{PointFrame, entries};
use crate::run::solve::Outcome;

/// Pressure, then shear in global axes: the force of the slave on its counterpart, per area.
pub(crate) type Traction = [f64; 4];

/// Of all pairs, force over area.
pub(crate) struct Tractions {
    /// At each contact point.
    pub points: Vec<Traction>,
    /// For each pair at the nodes of its master, ascending; none where no point reaches, nothing on obstacles.
    pub masters: Vec<Vec<Option<Traction>>>,
    /// At each contact point work of friction and pressure times slip of the load step, energy per area. Between two bodies they are
    /// means like the tractions: the product of a mean shear with the slip of a point is not the work.
    pub rubbing: Vec<[f64; 2]>,
}

/// Part of the area of a point at a node of the master; area. Negative where the function of the point is.
pub(crate) type Shared = Vec<(usize, f64)>;

/// Sums that differ by less than this part are equal.
const ROUNDING: f64 = 1e-9;
/// Sweeps of what is repeated until areas and forces add up.
const SWEEPS: usize = 20;

/// The tractions of an answer; `frames` are those of its points.
pub(crate) fn tractions(prepared: &Prepared, outcome: &Outcome, frames: &[PointFrame]) -> Tractions {
    let (problem, lambda) = (&prepared.problem, &outcome.solution.lambda);
    let quotient = |(j, frame): (usize, &PointFrame)| {
        let [n, t1, t2] = problem.rows(j).map(|row| lambda[row]);
        let [x, y, z] = frame.tangential([t1, t2]);
        [n, x, y, z].map(|force| force / problem.labels.area[j])
    };
    let mut points: Vec<Traction> = frames.iter().enumerate().map(quotient).collect();
    let rubbing = rubbing(problem, &outcome.solution.u, lambda, frames.len());
    let mut rubbing: Vec<Traction> = rubbing.into_iter().map(|[work, pressed]| [work, pressed, 0.0, 0.0]).collect();
    let mut masters = Vec::new();
    for (surface, pair) in prepared.surfaces.iter().zip(&problem.labels.pairs) {
        let Counterpart::Surface(master) = &surface.against else {
            masters.push(Vec::new());
            continue;
        };
        let (shared, patches) = shared(prepared, master, frames, pair.points.clone());
        let (of_points, mut of_nodes) = project(&shared, &points[pair.points.clone()], patches.len());
        follow(&prepared.model.dofs, &patches, &mut of_nodes);
        points[pair.points.clone()].copy_from_slice(&of_points);
        let (means, _) = project(&shared, &rubbing[pair.points.clone()], patches.len());
        rubbing[pair.points.clone()].copy_from_slice(&means);
        masters.push(of_nodes);
    }
    let rubbing = rubbing.into_iter().map(|[work, pressed, ..]| [work, pressed]).collect();
    Tractions { points, masters, rubbing }
}

/// Work of friction and pressure times slip at the first `count` points, energy per area.
pub(crate) fn rubbing(problem: &ContactProblem, u: &[f64], lambda: &[f64], count: usize) -> Vec<[f64; 2]> {
    let slips = problem.gap_and_slip(u);
    let of_point = |j: usize| {
        let [[n, a, b], [_, s, t]] = [lambda, &slips].map(|of| problem.rows(j).map(|row| of[row]));
        let area = problem.labels.area[j] * problem.labels.unity_sum[j];
        if area > 0.0 { [-(a * s + b * t) / area, n * s.hypot(t) / area] } else { [0.0; 2] }
    };
    (0..count).map(of_point).collect()
}

/// What each of these points shares with the nodes of the master, `int psi_j phi`, with the partition of unity in it, and
/// what these nodes stand for, ascending. On quadratic faces `phi` are the functions with positive integrals.
fn shared(
    prepared: &Prepared,
    master: &Master,
    frames: &[PointFrame],
    points: std::ops::Range<usize>,
) -> (Vec<Shared>, Vec<TributaryArea>) {
    let patches = tributary_areas(&prepared.mesh, &master.faces);
    let place = |node: u32| patches.binary_search_by_key(&node, |patch| patch.node).ok();
    // Points that take no part have their area beside others that do.
    let out = &prepared.problem.contact.out;
    let is_out = |j: usize| out.binary_search(&(j as u32)).is_ok();
    let some_are_in = points.clone().any(|j| !is_out(j));
    let turns = turns(&prepared.model.dofs);
    // A node that follows another of the master is one with it.
    let leader = |node: u32| match prepared.model.dofs.follows.get(&node) {
        Some(followed) if place(followed.node).is_some() => followed.node,
        _ => node,
    };
    let of_point = |j: usize| {
        if some_are_in && is_out(j) {
            return Shared::new();
        }
        let (frame, area) = (&frames[j], prepared.problem.labels.area[j]);
        let mut shared = Shared::new();
        for (node, weight) in weights(prepared, frame, prepared.problem.rows(j), &turns) {
            let Some(at) = place(leader(node)) else { continue };
            let part = area * weight;
            shared.push((at, part * patches[at].unity_sum()));
            let ends = patches[at].others.iter();
            shared.extend(ends.filter_map(|&(end, weight)| Some((place(leader(end))?, -part * weight))));
        }
        shared.sort_by_key(|entry| entry.0);
        let same = shared.chunk_by(|a, b| a.0 == b.0);
        same.map(|terms| (terms[0].0, terms.iter().map(|term| term.1).sum())).collect()
    };
    (points.map(of_point).collect(), patches)
}

/// What the jump of a point takes of each node but its own. Any row gives the weights, with the other sign: they stand before the axis
/// that the row has at the point's own node, beyond a cut of cyclic symmetry before this turned by a sector.
fn weights(prepared: &Prepared, frame: &PointFrame, rows: [usize; 3], turns: &[[V3; 3]]) -> Vec<(u32, f64)> {
    let axes = [frame.normal, frame.tangents[0], frame.tangents[1]];
    // By node, for each turn: by the first row, and by all, as only these tell half a turn from none.
    let mut of_node: BTreeMap<u32, Vec<[f64; 2]>> = BTreeMap::new();
    let used = rows.into_iter().zip(axes).filter(|(_, axis)| dot(*axis, *axis) > 0.0);
    for (place, (row, axis)) in used.enumerate().take(if turns.len() > 1 { 3 } else { 1 }) {
        for (dof, value) in entries(prepared, row).filter(|(dof, _)| dof / 3 != frame.node) {
            let direction = scale(-value / dot(axis, axis), prepared.model.dofs.direction(dof));
            let sums = of_node.entry(dof / 3).or_insert_with(|| vec![[0.0; 2]; turns.len()]);
            for ([first, all], turn) in sums.iter_mut().zip(turns) {
                let part = dot(direction, turned(*turn, axis));
                *first += if place == 0 { part } else { 0.0 };
                *all += part;
            }
        }
    }
    // Of a wrong turn the sum is smaller; of half a turn across the axis it may be the same but for the sign.
    let size = |[_, all]: &[f64; 2]| all.abs() + if *all > 0.0 { ROUNDING * all.abs() } else { 0.0 };
    let largest = |best: [f64; 2], sums: [f64; 2]| if size(&sums) > size(&best) { sums } else { best };
    of_node.into_iter().map(|(node, sums)| (node, sums.into_iter().fold([0.0; 2], largest)[0])).collect()
}

/// Gives nodes of a master that follow others of it what these have, turned.
fn follow(dofs: &DofMap, patches: &[TributaryArea], of_nodes: &mut [Option<Traction>]) {
    let place = |node: u32| patches.binary_search_by_key(&node, |patch| patch.node).ok();
    for (at, patch) in patches.iter().enumerate() {
        let Some(followed) = dofs.follows.get(&patch.node) else { continue };
        let Some(leader) = place(followed.node) else { continue };
        of_nodes[at] = of_nodes[leader].map(|[pressure, x, y, z]| {
            let [x, y, z] = turned(followed.axes, [x, y, z]);
            [pressure, x, y, z]
        });
    }
}

/// Nothing, and where there is cyclic symmetry a sector forth and back.
fn turns(dofs: &DofMap) -> Vec<[V3; 3]> {
    let rest = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let back = |axes: [V3; 3]| [0, 1, 2].map(|c| axes.map(|axis| axis[c]));
    let first = dofs.follows.iter().min_by_key(|(node, _)| **node);
    let sector = first.map(|(_, followed)| [followed.axes, back(followed.axes)]);
    std::iter::once(rest).chain(sector.into_iter().flatten()).collect()
}

fn turned(axes: [V3; 3], v: V3) -> V3 {
    (0..3).fold([0.0; 3], |sum, c| add(sum, scale(v[c], axes[c])))
}

/// From the points to the nodes of the master and back; `quotients` is force over area of each point.
pub(crate) fn project(
    shared: &[Shared],
    quotients: &[Traction],
    count: usize,
) -> (Vec<Traction>, Vec<Option<Traction>>) {
    let mut nodes = vec![Received::default(); count];
    for (row, traction) in shared.iter().zip(quotients) {
        row.iter().for_each(|&(k, area)| nodes[k].add(area, traction));
    }
    let parts = positive_parts(shared, &nodes);
    let mut received: Vec<Traction> = nodes.iter().map(Received::quotient).collect();
    // Of a sliver beyond the edge of the slave, or of the rim of the contact, the quotient is an extrapolation: what is
    // beyond the least and the greatest of its points goes to the neighbours.
    for _ in 0..SWEEPS {
        let within: Vec<Traction> = nodes.iter().zip(&received).map(|(node, value)| node.within(value)).collect();
        let excess: Vec<Traction> = received.iter().zip(&within).map(|(a, b)| subtracted(a, b)).collect();
        received = within;
        if excess.iter().flatten().all(|&e| e == 0.0) {
            break;
        }
        let passed = to_nodes(&parts, &to_points(&parts, &excess), &nodes);
        received.iter_mut().flatten().zip(passed.iter().flatten()).for_each(|(sum, passed)| *sum += passed);
    }
    let received: Vec<Traction> = nodes.iter().zip(&received).map(|(node, value)| node.within(value)).collect();
    let points = to_points(&parts, &received);
    let with_means = parts.iter().zip(points).zip(quotients);
    let points = with_means.map(|((row, mean), quotient)| if row.is_empty() { *quotient } else { mean }).collect();
    (points, nodes.iter().zip(received).map(|(node, value)| (node.area > 0.0).then_some(value)).collect())
}

/// The positive parts of the shared areas, scaled in turn to the areas of points and of nodes (Sinkhorn 1964).
fn positive_parts(shared: &[Shared], nodes: &[Received]) -> Vec<Shared> {
    let positive = |row: &Shared| {
        let whole = sum(row) > 0.0;
        row.iter().copied().filter(|&(k, area)| whole && area > 0.0 && nodes[k].area > 0.0).collect()
    };
    let mut parts: Vec<Shared> = shared.iter().map(positive).collect();
    for _ in 0..SWEEPS {
        for (row, whole) in parts.iter_mut().zip(shared) {
            let factor = sum(whole) / sum(row);
            row.iter_mut().for_each(|(_, part)| *part *= factor);
        }
        let mut sums = vec![0.0; nodes.len()];
        parts.iter().flatten().for_each(|&(k, part)| sums[k] += part);
        parts.iter_mut().flatten().for_each(|(k, part)| *part *= nodes[*k].area / sums[*k]);
    }
    parts
}

fn sum(row: &Shared) -> f64 {
    row.iter().map(|entry| entry.1).sum()
}

/// The mean of the nodes at each point.
fn to_points(parts: &[Shared], nodes: &[Traction]) -> Vec<Traction> {
    let mean = |row: &Shared| {
        let whole = sum(row);
        [0, 1, 2, 3].map(|c| row.iter().map(|&(k, part)| part * nodes[k][c]).sum::<f64>() / whole)
    };
    parts.iter().map(|row| if row.is_empty() { [0.0; 4] } else { mean(row) }).collect()
}

/// The mean of the points at each node.
fn to_nodes(parts: &[Shared], points: &[Traction], nodes: &[Received]) -> Vec<Traction> {
    let mut means = vec![[0.0; 4]; nodes.len()];
    for (row, value) in parts.iter().zip(points) {
        for &(k, part) in row {
            (0..4).for_each(|c| means[k][c] += part / nodes[k].area * value[c]);
        }
    }
    means
}

fn subtracted(a: &Traction, b: &Traction) -> Traction {
    [0, 1, 2, 3].map(|c| a[c] - b[c])
}

/// What a node of the master receives.
#[derive(Clone)]
struct Received {
    area: f64,
    force: Traction,
    /// The least and the greatest quotient of its points.
    range: [Traction; 2],
}

impl Default for Received {
    fn default() -> Self {
        Received { area: 0.0, force: [0.0; 4], range: [[f64::INFINITY; 4], [f64::NEG_INFINITY; 4]] }
    }
}

impl Received {
    fn add(&mut self, area: f64, traction: &Traction) {
        self.area += area;
        for (c, &value) in traction.iter().enumerate() {
            self.force[c] += area * value;
            self.range[0][c] = self.range[0][c].min(value);
            self.range[1][c] = self.range[1][c].max(value);
        }
    }

    fn quotient(&self) -> Traction {
        if self.area > 0.0 { self.force.map(|force| force / self.area) } else { [0.0; 4] }
    }

    fn within(&self, value: &Traction) -> Traction {
        let [least, greatest] = self.range;
        // No force is no pressure, without a sign.
        let of = |c: usize| 0.0 + value[c].max(least[c]).min(greatest[c]);
        if self.area > 0.0 { [0, 1, 2, 3].map(of) } else { [0.0; 4] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_matching_meshes_pressures_are_forces_over_areas() {
        let shared = [vec![(0, 0.5)], vec![(2, 0.1)], vec![(1, 0.7)]];
        let values = [[3.0, 1.0, 0.0, 0.5], [0.0; 4], [-2.0, 0.0, -1.0, 4.0]];
        let (points, nodes) = project(&shared, &values, 4);
        for (c, value) in points.iter().flatten().zip(values.iter().flatten()) {
            assert!((c - value).abs() < 1e-15);
        }
        assert_eq!(nodes, [Some(values[0]), Some(values[2]), Some(values[1]), None]);
    }

    /// Of the forces 3 and -1 over areas 1 and 3, which two points put on the same node, nothing remains.
    #[test]
    fn forces_that_cancel_at_each_node_of_the_master_leave_no_pressure() {
        let shared = [vec![(0, 1.0)], vec![(0, 3.0)]];
        let (points, nodes) = project(&shared, &[[3.0; 4], [-1.0; 4]], 1);
        assert_eq!((points, nodes), (vec![[0.0; 4]; 2], vec![Some([0.0; 4])]));
    }

    /// With functions that change their sign, and with a sliver: 1e-6 of the area of its neighbours.
    #[test]
    fn the_resultant_stays_and_a_constant_stays() {
        let shared = [
            vec![(0, 0.6), (1, 0.5), (2, -0.1)],
            vec![(0, -0.2), (1, 0.9), (2, 0.3)],
            vec![(1, 0.4), (2, 0.7), (3, -1e-8)],
            vec![(2, 1e-6), (3, 1e-7)],
        ];
        let values = [[1.0, 0.3, 0.0, 0.0], [2.0, -0.3, 0.0, 0.0], [4.0, 0.0, 0.1, 0.0], [1e4, 0.0, 0.0, 0.0]];
        let (points, _) = project(&shared, &values, 4);
        for c in 0..4 {
            let force = |of: &[Traction]| shared.iter().zip(of).map(|(row, t)| sum(row) * t[c]).sum::<f64>();
            assert!((force(&points) - force(&values)).abs() < 1e-3, "{} {}", force(&points), force(&values));
        }
        assert!(points[3][0] < 1e3, "{points:?}");
        let (points, nodes) = project(&shared, &[[2.0, 1.0, -1.0, 0.0]; 4], 4);
        for value in points.into_iter().chain(nodes.into_iter().flatten()) {
            assert!((0..4).all(|c| (value[c] - [2.0, 1.0, -1.0, 0.0][c]).abs() < 1e-14), "{value:?}");
        }
    }
}
