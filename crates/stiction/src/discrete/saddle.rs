use super::V3;
use super::condense::symmetric_pattern;
use super::problem::{Equalities, GlobalProblem};
use crate::linalg::{Csr, NodeGraph, Plan, nested_dissection, plan};

/// An elimination order of the unknowns of a global problem, into which constraints and contact points are put right
/// after the last velocity they touch: their pivots are then Schur complements and not the zeros of the diagonal.
#[derive(Debug, Clone)]
pub(super) struct Order {
    /// Equal where unknowns are coupled to the same others.
    labels: Vec<u32>,
    /// Unknowns of each label.
    groups: Vec<Vec<u32>>,
    order: Vec<u32>,
}

impl Order {
    /// By nested dissection of the graph in which all unknowns that a point or a constraint touches are neighbours.
    pub(super) fn new(problem: &GlobalProblem) -> Self {
        let velocities = cliques(problem);
        let labels = equal_rows(&velocities);
        let graph = NodeGraph::new(&velocities, Some(&labels));
        let mut groups = vec![Vec::new(); graph.len()];
        (0..).zip(&labels).for_each(|(i, &label)| groups[label as usize].push(i));
        let mut order = Order { order: nested_dissection(&graph), labels, groups };
        if let Some(Equalities { G, .. }) = &problem.equalities {
            let constraints = G.transpose();
            let touched = |k: usize| constraints.row(k).0.iter().map(|&i| order.labels[i as usize]).collect();
            let touched: Vec<Vec<u32>> = (0..constraints.rows).map(touched).collect();
            let first = order.groups.len() as u32;
            order.insert(&touched, first);
            for (label, i) in (first..).zip(problem.f.len() as u32..).take(G.cols) {
                order.labels.push(label);
                order.groups.push(vec![i]);
            }
        }
        order
    }

    /// Flops of one factor with all points in contact, and entries of a triangle of the factor of `A`.
    pub(super) fn cost(&self, problem: &GlobalProblem) -> [f64; 2] {
        let a = bordered(problem, self);
        let entries = self.plan(&a, &[]).entries();
        let directions = problem.H.transpose();
        let d = problem.dimension;
        let touch = |j: usize| self.closed(reached(&directions, d, j));
        let touched: Vec<Vec<u32>> = (0..problem.mu.len()).map(touch).collect();
        let n = a.rows;
        let mut pattern: Vec<(usize, usize, f64)> = a.entries().collect();
        for (j, touched) in touched.iter().enumerate() {
            let own = n + d * j..n + d * (j + 1);
            for k in own.clone() {
                pattern.extend(touched.iter().flat_map(|&i| [(i as usize, k, 0.0), (k, i as usize, 0.0)]));
                pattern.extend(own.clone().map(|l| (k, l, 0.0)));
            }
        }
        let size = n + d * touched.len();
        let points: Vec<(usize, &[u32])> = touched.iter().map(|t| (d, &t[..])).collect();
        // A symmetric plan counts one triangle.
        let flops = 2.0 * self.plan(&Csr::from_triplets(size, size, &pattern), &points).flops();
        [flops, entries]
    }

    /// All unknowns whose label is among those of the given ones, ascending.
    pub(super) fn closed(&self, unknowns: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut labels: Vec<u32> = unknowns.map(|i| self.labels[i as usize]).collect();
        labels.sort_unstable();
        labels.dedup();
        let mut all: Vec<u32> = labels.iter().flat_map(|&l| self.groups[l as usize].iter().copied()).collect();
        all.sort_unstable();
        all
    }

    /// Puts the `k`-th new vertex, `first + k`, after the last of `touched[k]`.
    fn insert(&mut self, touched: &[Vec<u32>], first: u32) {
        let mut place = vec![0usize; self.order.len()];
        self.order.iter().enumerate().for_each(|(p, &v)| place[v as usize] = p);
        let mut after: Vec<(usize, u32)> = touched
            .iter()
            .zip(first..)
            .map(|(touched, new)| (touched.iter().map(|&v| place[v as usize] + 1).max().unwrap_or(0), new))
            .collect();
        after.sort_unstable();
        let mut all = Vec::with_capacity(self.order.len() + after.len());
        let mut next = after.into_iter().peekable();
        for p in 0..=self.order.len() {
            while let Some((_, new)) = next.next_if(|(at, _)| *at == p) {
                all.push(new);
            }
            all.extend(self.order.get(p));
        }
        self.order = all;
    }

    /// The plan for a matrix whose first unknowns are these; `points` are the others: how many unknowns each has, and
    /// the ones it touches.
    pub(super) fn plan(&self, matrix: &Csr, points: &[(usize, &[u32])]) -> Plan {
        let mut order = self.clone();
        let first = order.groups.len() as u32;
        let touched: Vec<Vec<u32>> =
            points.iter().map(|(_, touched)| touched.iter().map(|&i| self.labels[i as usize]).collect()).collect();
        order.insert(&touched, first);
        for ((unknowns, _), label) in points.iter().zip(first..) {
            order.labels.extend(std::iter::repeat_n(label, *unknowns));
        }
        plan(&NodeGraph::new(matrix, Some(&order.labels)), &order.order, 0)
    }
}

/// `M` with entries, zero if need be, wherever two unknowns are touched by one point or one constraint.
fn cliques(problem: &GlobalProblem) -> Csr {
    let mut entries: Vec<(usize, usize, f64)> = symmetric_pattern(&problem.M).entries().collect();
    let (directions, d) = (problem.H.transpose(), problem.dimension);
    let mut groups: Vec<Vec<u32>> = (0..problem.mu.len()).map(|a| reached(&directions, d, a).collect()).collect();
    if let Some(Equalities { G, .. }) = &problem.equalities {
        let constraints = G.transpose();
        groups.extend((0..constraints.rows).map(|k| constraints.row(k).0.to_vec()));
    }
    for group in &groups {
        entries.extend(group.iter().flat_map(|&i| group.iter().map(move |&j| (i as usize, j as usize, 0.0))));
    }
    Csr::from_triplets(problem.M.rows, problem.M.cols, &entries)
}

/// Unknowns that the impulses of point `a` act on; `directions` has a row a component.
fn reached(directions: &Csr, dimension: usize, a: usize) -> impl Iterator<Item = u32> + '_ {
    (dimension * a..dimension * (a + 1)).flat_map(|i| directions.row(i).0.iter().copied())
}

/// Labels that agree where rows have their entries in the same places.
fn equal_rows(a: &Csr) -> Vec<u32> {
    let mut known = std::collections::HashMap::new();
    (0..a.rows)
        .map(|i| {
            let next = known.len() as u32;
            *known.entry(a.row(i).0).or_insert(next)
        })
        .collect()
}

/// `[M -G; G' 0]` on the pattern of `order`.
pub(super) fn bordered(problem: &GlobalProblem, order: &Order) -> Csr {
    let velocities = cliques(problem);
    let Some(Equalities { G, b }) = &problem.equalities else { return velocities };
    let (n, constraints) = (velocities.rows, G.transpose());
    let mut entries: Vec<(usize, usize, f64)> = velocities.entries().collect();
    for k in 0..b.len() {
        let (unknowns, values) = constraints.row(k);
        for (&i, &g) in unknowns.iter().zip(values) {
            entries.extend([(i as usize, n + k, -g), (n + k, i as usize, g)]);
        }
        for i in order.closed(unknowns.iter().copied()) {
            entries.extend([(i as usize, n + k, 0.0), (n + k, i as usize, 0.0)]);
        }
        entries.push((n + k, n + k, 0.0));
    }
    Csr::from_triplets(n + b.len(), n + b.len(), &entries)
}

/// What a point touches: unknowns, and how each of its components moves with them.
#[derive(Debug, Clone)]
pub(super) struct Touch {
    pub unknowns: Vec<u32>,
    pub direction: Vec<V3>,
}

impl Touch {
    /// Of point `a` with the rows `directions`, times `scale`.
    pub(super) fn new(directions: &Csr, dimension: usize, order: &Order, a: usize, scale: f64) -> Self {
        let rows = dimension * a..dimension * (a + 1);
        let unknowns = order.closed(reached(directions, dimension, a));
        let mut direction = vec![[0.0; 3]; unknowns.len()];
        for (c, i) in rows.enumerate() {
            let (columns, values) = directions.row(i);
            for (j, v) in columns.iter().zip(values) {
                direction[unknowns.partition_point(|i| i < j)][c] = scale * v;
            }
        }
        Touch { unknowns, direction }
    }
}
