use super::choice::Threshold as Cost;
use crate::contact::ContactProblem;
use crate::linalg::NodeGraph;

/// What the direct path would cost, without ordering anything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Multiplications and additions of the factorisation.
    pub flops: f64,
    /// Memory of the factor.
    pub bytes: f64,
    /// Seconds of ordering, factorisation and products on one core of 2020 or later; only ratios are meant.
    pub seconds: f64,
}

/// Factors of the prediction, by cubes, bars and plates of tetrahedra and hexahedra.
struct Threshold;

impl Threshold {
    /// Passes that look for the ends of the graph; the first starts anywhere.
    const PASSES: usize = 3;
    /// Flops over `27 N w^(3/2)` and bytes over `72 N w^(1/2) ln(w)/2`, in the middle of cubes, bars and plates of
    /// tetrahedra and hexahedra (0.7 to 4.5 and 1.0 to 3.8).
    const FLOPS: f64 = 1.8;
    const BYTES: f64 = 2.0;
    /// Part of the factor a product touches, roughly: what lies above the contact unknowns.
    const TOUCHED: f64 = 0.5;
    /// Seconds of ordering and symbolic factorisation a node.
    const ORDERING: f64 = 1.5e-5;
}

/// A guess, good to a factor of three to five, from the number of nodes `N` and the width `w` of the graph: the most
/// nodes at one distance from an end of it. A body of width `w` is a row of cubes with `w^(3/2)` nodes, and nested
/// dissection of a cube spends `w^3` on its largest separator (George 1973).
pub fn estimate(problem: &ContactProblem) -> Estimate {
    of_graph(problem, &NodeGraph::of_symmetric(&problem.elastic.K, problem.elastic.node_of.as_deref()))
}

/// The same with the graph of `K` at hand.
pub(super) fn of_graph(problem: &ContactProblem, graph: &NodeGraph) -> Estimate {
    let (nodes, width) = (graph.len() as f64, width(graph).max(2) as f64);
    let flops = Threshold::FLOPS * 27.0 * nodes * width.powf(1.5);
    let bytes = Threshold::BYTES * 72.0 * nodes * width.sqrt() * 0.5 * width.ln();
    let products = if problem.points() > 0 { Cost::EXPECTED_PRODUCTS } else { 1.0 };
    let seconds = Threshold::ORDERING * nodes
        + flops / Cost::FLOPS_PER_SECOND
        + products * 2.0 * Threshold::TOUCHED * bytes / Cost::BYTES_PER_SECOND;
    Estimate { flops, bytes, seconds }
}

/// The most nodes at one distance from a node at an end of the graph; the widest of its pieces.
fn width(graph: &NodeGraph) -> usize {
    // The last search that saw each node: searches need no fresh memory, however many pieces there are.
    let (mut seen, mut search) = (vec![0u32; graph.len()], 0);
    let mut widest = 0;
    for seed in 0..graph.len() {
        if seen[seed] > 0 {
            continue;
        }
        let (mut start, mut width) = (seed, 0);
        for _ in 0..Threshold::PASSES {
            search += 1;
            (start, width) = widest_level(graph, start, search, &mut seen);
        }
        widest = widest.max(width);
    }
    widest
}

/// The last node reached from `start`, and the most nodes at one distance from it.
fn widest_level(graph: &NodeGraph, start: usize, search: u32, seen: &mut [u32]) -> (usize, usize) {
    seen[start] = search;
    let (mut level, mut last, mut widest) = (vec![start as u32], start, 0);
    while let Some(&first) = level.first() {
        (last, widest) = (first as usize, widest.max(level.len()));
        let mut next = Vec::new();
        for &w in level.iter().flat_map(|&v| graph.neighbours_of(v as usize)) {
            if std::mem::replace(&mut seen[w as usize], search) != search {
                next.push(w);
            }
        }
        level = next;
    }
    (last, widest)
}
