use stiction_metis::{Failure, Options};

use super::memory::refused;
use super::pattern::Pattern;
use super::{Csr, Stop, SymmetricCsr};
use crate::Error;

/// The graph of nodes behind a matrix: unknowns of one node are coupled to the same neighbours and are
/// eliminated together, which makes orderings and symbolic counts about nine times cheaper in elasticity.
#[derive(Debug, Clone)]
pub struct NodeGraph {
    /// Unknowns of node `v` are `unknowns[first[v]..first[v + 1]]`, ascending.
    pub first: Vec<usize>,
    /// Unknowns, node by node.
    pub unknowns: Vec<u32>,
    /// Neighbours of node `v` (without `v`) are `neighbours[start[v]..start[v + 1]]`, ascending.
    pub start: Vec<usize>,
    /// Neighbours, node by node.
    pub neighbours: Vec<u32>,
}

impl NodeGraph {
    /// The graph of `k`, whose pattern is symmetric; `node_of[i]` is the node of unknown `i` (any labels), `None` makes
    /// every unknown a node of its own.
    pub fn new(k: &Csr, node_of: Option<&[u32]>) -> Self {
        let (node, mut graph) = Self::nodes(k.rows, node_of);
        let coupled = |v: usize, name: &mut dyn FnMut(u32)| {
            let of_unknowns = graph.unknowns_of(v).iter().flat_map(|&i| k.row(i as usize).0);
            of_unknowns.map(|&j| node[j as usize]).filter(|&w| w as usize != v).for_each(name);
        };
        let Pattern { start, column } = Pattern::new(graph.len(), graph.len(), coupled);
        (graph.start, graph.neighbours) = (start, column);
        graph
    }

    /// The same of a symmetric matrix.
    pub fn of_symmetric(k: &SymmetricCsr, node_of: Option<&[u32]>) -> Self {
        let (node, mut graph) = Self::nodes(k.rows, node_of);
        let coupled = |v: usize, name: &mut dyn FnMut(u32)| {
            // Rows whose columns are among those of the next, which is of the same node, add nothing.
            let known = |i: usize| k.shares(i) && node[i + 1] as usize == v;
            let rows = graph.unknowns_of(v).iter().map(|&i| i as usize).filter(|&i| !known(i));
            rows.flat_map(|i| k.row(i).0).map(|&j| node[j as usize]).filter(|&w| w as usize != v).for_each(name);
        };
        let Pattern { start, column } = Pattern::new(graph.len(), graph.len(), coupled).mirrored();
        (graph.start, graph.neighbours) = (start, column);
        graph
    }

    /// The node of each of `n` unknowns, and the graph without neighbours.
    fn nodes(n: usize, node_of: Option<&[u32]>) -> (Vec<u32>, Self) {
        let (node, count) = compact_labels(n, node_of);
        let mut first = vec![0usize; count + 1];
        node.iter().for_each(|&v| first[v as usize + 1] += 1);
        (0..count).for_each(|v| first[v + 1] += first[v]);
        let mut place = first.clone();
        let mut unknowns = vec![0u32; n];
        for (i, &v) in node.iter().enumerate() {
            unknowns[place[v as usize]] = i as u32;
            place[v as usize] += 1;
        }
        (node, NodeGraph { first, unknowns, start: Vec::new(), neighbours: Vec::new() })
    }

    /// The same graph with its nodes in another order: `order[k]` becomes node `k`.
    pub fn reordered(&self, order: &[u32]) -> Self {
        let mut place = vec![0u32; self.len()];
        order.iter().enumerate().for_each(|(k, &v)| place[v as usize] = k as u32);
        let mut graph = NodeGraph { first: vec![0], unknowns: Vec::new(), start: vec![0], neighbours: Vec::new() };
        graph.unknowns.reserve(self.unknowns.len());
        graph.neighbours.reserve(self.neighbours.len());
        for &v in order {
            graph.unknowns.extend_from_slice(self.unknowns_of(v as usize));
            graph.neighbours.extend(self.neighbours_of(v as usize).iter().map(|&w| place[w as usize]));
            graph.first.push(graph.unknowns.len());
            graph.start.push(graph.neighbours.len());
        }
        graph
    }

    /// Entries of a matrix with an entry wherever two unknowns of neighbouring nodes meet, both triangles.
    pub fn entries(&self) -> usize {
        let unknowns = |v: usize| self.first[v + 1] - self.first[v];
        let around =
            |v: usize| unknowns(v) + self.neighbours_of(v).iter().map(|&w| unknowns(w as usize)).sum::<usize>();
        (0..self.len()).map(|v| unknowns(v) * around(v)).sum()
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.first.len() - 1
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Unknowns of node `v`.
    pub fn unknowns_of(&self, v: usize) -> &[u32] {
        &self.unknowns[self.first[v]..self.first[v + 1]]
    }

    /// Neighbours of node `v`.
    pub fn neighbours_of(&self, v: usize) -> &[u32] {
        &self.neighbours[self.start[v]..self.start[v + 1]]
    }
}

fn compact_labels(n: usize, node_of: Option<&[u32]>) -> (Vec<u32>, usize) {
    let Some(labels) = node_of else { return ((0..n as u32).collect(), n) };
    let mut number = vec![u32::MAX; labels.iter().map(|&l| l as usize + 1).max().unwrap_or(0)];
    let mut count = 0;
    let node = labels.iter().map(|&l| {
        let slot = &mut number[l as usize];
        if *slot == u32::MAX {
            *slot = count;
            count += 1;
        }
        *slot
    });
    (node.collect(), count as usize)
}

/// The order of Cuthill & McKee (1969), connected part by connected part: `order[k]` is the node that comes as the `k`-th.
/// Nodes follow one another in fronts through the mesh, so that neighbours have close numbers. Each part begins at a node
/// that is far from another one.
pub(crate) fn fronts(graph: &NodeGraph) -> Vec<u32> {
    let degree = |v: u32| graph.neighbours_of(v as usize).len();
    let mut seen = vec![0u8; graph.len()];
    let mut order = Vec::with_capacity(graph.len());
    for first in 0..graph.len() as u32 {
        if seen[first as usize] > 0 {
            continue;
        }
        // The node reached last by a search from anywhere is far from some other one.
        let (begin, mut from) = (order.len(), first);
        for pass in 1..=2 {
            order.truncate(begin);
            order.push(from);
            seen[from as usize] = pass;
            let mut next = begin;
            while let Some(&v) = order.get(next) {
                next += 1;
                let new = order.len();
                for &w in graph.neighbours_of(v as usize) {
                    if seen[w as usize] < pass {
                        seen[w as usize] = pass;
                        order.push(w);
                    }
                }
                order[new..].sort_by_key(|&w| degree(w));
            }
            from = order[order.len() - 1];
        }
    }
    order
}

/// Mean distance of the numbers of neighbours where `place[v]` is the number of node `v`.
pub(crate) fn mean_distance(graph: &NodeGraph, place: impl Fn(u32) -> u32) -> f64 {
    let distances = |v: u32| graph.neighbours_of(v as usize).iter().map(move |&w| (v, w));
    let all = (0..graph.len() as u32).flat_map(distances);
    all.map(|(v, w)| f64::from(place(v).abs_diff(place(w)))).sum::<f64>() / graph.neighbours.len().max(1) as f64
}

/// Nested dissection by METIS (Karypis & Kumar 1998): `order[k]` is the node eliminated as the `k`-th.
/// The seed is fixed, so the same graph always gets the same order.
pub fn nested_dissection(graph: &NodeGraph) -> Vec<u32> {
    nested_dissection_until(graph, &Stop::never()).unwrap_or_else(|_| as_they_are(graph))
}

/// The same, which can be stopped within a few milliseconds.
///
/// # Errors
/// If there is not enough memory; any order is valid, but the factor of another one would take far more. If it is stopped:
/// [`Error::interrupted`].
pub fn nested_dissection_until(graph: &NodeGraph, stop: &Stop) -> Result<Vec<u32>, Error> {
    let n = graph.len();
    if n < 2 || graph.neighbours.is_empty() || graph.neighbours.len() > i32::MAX as usize {
        return Ok(as_they_are(graph));
    }
    let metis = own_numbers(graph);
    // Two separators are tried at every level: a few per cent less fill for a tenth of the factor time.
    let options = Options { seed: 1, separators: 2, ..Options::default() };
    match stiction_metis::nested_dissection(metis, options, &|| stop.asked()) {
        Ok(order) => Ok(order.into_iter().map(|v| v as u32).collect()),
        Err(Failure::Stopped) => Err(Error::interrupted()),
        Err(Failure::OutOfMemory) => Err(refused("the ordering of the unknowns", ordering_bytes(graph))),
        // Any order is valid, only slower.
        Err(Failure::NoGraph) => Ok(as_they_are(graph)),
    }
}

/// The graph in the numbers of METIS.
fn own_numbers(graph: &NodeGraph) -> stiction_metis::Graph {
    stiction_metis::Graph {
        start: graph.start.iter().map(|&s| s as i32).collect(),
        neighbours: graph.neighbours.iter().map(|&w| w as i32).collect(),
        weights: (0..graph.len()).map(|v| graph.unknowns_of(v).len() as i32).collect(),
    }
}

/// The most that [`nested_dissection`] takes at a time, bytes: the graph in the numbers of METIS and its coarser graphs.
pub fn ordering_bytes(graph: &NodeGraph) -> f64 {
    Threshold::BYTES
        + Threshold::BYTES_PER_NODE * graph.len() as f64
        + Threshold::BYTES_PER_NEIGHBOUR * graph.neighbours.len() as f64
}

struct Threshold;

impl Threshold {
    /// By the least that METIS gets along with on bars and cubes of all elements; `ordering_takes_what_is_predicted`.
    const BYTES: f64 = 64e3;
    const BYTES_PER_NODE: f64 = 120.0;
    const BYTES_PER_NEIGHBOUR: f64 = 28.0;
}

fn as_they_are(graph: &NodeGraph) -> Vec<u32> {
    (0..graph.len() as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five-point Laplacian on an `n x n` grid.
    pub(crate) fn grid(n: usize) -> Csr {
        let at = |i: usize, j: usize| i * n + j;
        let mut entries = Vec::new();
        for i in 0..n {
            for j in 0..n {
                entries.push((at(i, j), at(i, j), 4.0));
                for (a, b) in [(i + 1, j), (i, j + 1)] {
                    if a < n && b < n {
                        entries.push((at(i, j), at(a, b), -1.0));
                        entries.push((at(a, b), at(i, j), -1.0));
                    }
                }
            }
        }
        Csr::from_triplets(n * n, n * n, &entries)
    }

    #[test]
    fn fronts_bring_neighbours_of_a_scattered_mesh_together() {
        let n = 30;
        let graph = NodeGraph::new(&grid(n), None);
        // 7 is no divisor of the number of nodes: a permutation.
        let scattered =
            graph.reordered(&(0..n as u32 * n as u32).map(|v| v * 7 * 31 % (n * n) as u32).collect::<Vec<_>>());
        assert!(mean_distance(&scattered, |v| v) > 100.0);
        let order = fronts(&scattered);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(k, &v)| k as u32 == v));
        // Row by row neighbours are 1 or n apart. Fronts from a corner have at most n nodes.
        let bandwidth = |graph: &NodeGraph| {
            let of = |v: u32| graph.neighbours_of(v as usize).iter().map(move |w| w.abs_diff(v)).max().unwrap_or(0);
            (0..graph.len() as u32).map(of).max().unwrap_or(0)
        };
        let found = scattered.reordered(&order);
        assert!(bandwidth(&found) <= n as u32 + 1, "{}", bandwidth(&found));
        assert!(mean_distance(&found, |v| v) < 1.5 * mean_distance(&graph, |v| v));
    }

    #[test]
    fn nested_dissection_is_a_permutation() {
        let graph = NodeGraph::new(&grid(20), None);
        let mut order = nested_dissection(&graph);
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(i, &v)| v as usize == i));
    }

    #[test]
    fn unknowns_of_a_node_stay_together() {
        let labels: Vec<u32> = (0..400).map(|i| 7 + i / 2).collect();
        let graph = NodeGraph::new(&grid(20), Some(&labels));
        assert_eq!(graph.len(), 200);
        assert_eq!(graph.unknowns_of(3), [6, 7]);
        assert!(graph.neighbours_of(0).contains(&1) && graph.neighbours_of(0).contains(&10));
    }

    /// A cube of nodes, each the neighbour of the 26 around it, as in a mesh of hexahedra.
    fn cube(n: usize) -> NodeGraph {
        let place = |i: [usize; 3]| (i[0] + n * (i[1] + n * i[2])) as u32;
        let (mut start, mut neighbours) = (vec![0], Vec::new());
        for v in 0..n.pow(3) {
            let at = [v % n, v / n % n, v / n / n];
            let range = |c: usize| at[c].saturating_sub(1)..(at[c] + 2).min(n);
            for k in range(2) {
                range(1).for_each(|j| neighbours.extend(range(0).map(|i| place([i, j, k])).filter(|&w| w != v as u32)));
            }
            start.push(neighbours.len());
        }
        NodeGraph { first: (0..=n.pow(3)).collect(), unknowns: (0..n.pow(3) as u32).collect(), start, neighbours }
    }

    #[test]
    fn the_ordering_takes_what_is_predicted() {
        // METIS counts what it holds and gives up beyond what it may.
        for graph in [NodeGraph::new(&grid(20), None), NodeGraph::new(&grid(200), None), cube(6), cube(12), cube(30)] {
            let own = own_numbers(&graph);
            let is_enough = |bytes: f64| {
                let options = Options { seed: 1, separators: 2, most_bytes: bytes as usize };
                stiction_metis::nested_dissection(own.clone(), options, &|| false).is_ok()
            };
            let copies = 4.0 * (own.start.len() + own.neighbours.len() + 4 * own.weights.len()) as f64;
            let predicted = ordering_bytes(&graph);
            assert!(is_enough(predicted - copies), "{} nodes take more than {predicted}", graph.len());
            assert!(!is_enough(0.4 * predicted - copies), "{} nodes take far less than {predicted}", graph.len());
        }
    }

    #[test]
    fn a_stop_reaches_the_ordering() {
        let graph = NodeGraph::new(&grid(60), None);
        for questions in [0, 1, 10, 100, 1000] {
            let stopped = nested_dissection_until(&graph, &Stop::after(questions)).unwrap_err();
            assert!(stopped.interrupted, "after {questions}");
        }
        assert_eq!(nested_dissection_until(&graph, &Stop::when(|| false)), Ok(nested_dissection(&graph)));
    }
}
