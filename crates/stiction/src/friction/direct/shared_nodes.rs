use std::collections::BTreeMap;

use crate::contact::ContactProblem;
use crate::linalg::{SmallLu, SymmetricCsr};

/// Contact points on one node, as where the faces of a body meet that touch different counterparts: they have more multipliers
/// than the node has unknowns, and only the sum of their forces has an effect.
pub(super) struct SharedNode {
    pub points: Vec<usize>,
    /// Displacement in the rows of these points by forces in them, length/newton, `3 points x 3 points`, of each node that they reach
    /// as if all others were held. Singular.
    pub compliance: Vec<Vec<f64>>,
}

/// A point is on the node that has more than this part of the squares of its rows, at most one: all of them on a rigid obstacle, more than half
/// between bodies, but where meshes match exactly, and both sides have half.
const ON_NODE: f64 = 0.5 + 1e-9;

/// The rows of some points on one node: by unknown, the entries of the `3 points` rows.
type Rows = BTreeMap<u32, Vec<f64>>;

/// The nodes of more than one contact point, ascending by their labels.
pub(super) fn shared_nodes(problem: &ContactProblem) -> Vec<SharedNode> {
    let Some(label_of) = &problem.elastic.node_of else { return Vec::new() };
    let label = |column: u32| label_of[column as usize];
    let mut points_on: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for j in 0..problem.points() {
        let mut squares: BTreeMap<u32, f64> = BTreeMap::new();
        for i in problem.rows(j) {
            let (columns, values) = problem.contact.B.row(i);
            columns.iter().zip(values).for_each(|(&c, v)| *squares.entry(label(c)).or_insert(0.0) += v * v);
        }
        let all: f64 = squares.values().sum();
        let own = squares.into_iter().find(|(_, square)| *square > ON_NODE * all);
        own.into_iter().for_each(|(node, _)| points_on.entry(node).or_default().push(j));
    }
    let shared = points_on.into_values().filter(|points| points.len() > 1);
    shared.map(|points| shared_node(problem, points, label)).collect()
}

fn shared_node(problem: &ContactProblem, points: Vec<usize>, label: impl Fn(u32) -> u32) -> SharedNode {
    let size = 3 * points.len();
    let mut by_node: BTreeMap<u32, Rows> = BTreeMap::new();
    for (k, i) in points.iter().flat_map(|&j| problem.rows(j)).enumerate() {
        let (columns, values) = problem.contact.B.row(i);
        for (&column, &value) in columns.iter().zip(values) {
            let rows = by_node.entry(label(column)).or_default();
            rows.entry(column).or_insert_with(|| vec![0.0; size])[k] = value;
        }
    }
    let mut compliance = vec![vec![0.0; size]; size];
    by_node.values().for_each(|rows| add_compliance(&problem.elastic.K, rows, &mut compliance));
    SharedNode { points, compliance }
}

/// Adds `B_v K_vv^-1 B_vᵀ` of the node `v`.
fn add_compliance(k: &SymmetricCsr, rows: &Rows, compliance: &mut [Vec<f64>]) {
    let columns: Vec<usize> = rows.keys().map(|&column| column as usize).collect();
    let block = columns.iter().map(|&a| columns.iter().map(|&b| k.entry(a, b)).collect()).collect();
    let inverse = SmallLu::new(block);
    for (s, column) in (0..compliance.len()).map(|s| (s, rows.values().map(|row| row[s]).collect::<Vec<f64>>())) {
        let u = inverse.solve(&column);
        for (r, out) in compliance.iter_mut().enumerate() {
            out[s] += rows.values().zip(&u).map(|(row, u)| row[r] * u).sum::<f64>();
        }
    }
}
