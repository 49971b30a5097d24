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
    let width = pieces(graph.len(), &neighbours(graph)).iter().map(|piece| piece.width).max();
    let (nodes, width) = (graph.len() as f64, width.unwrap_or(0).max(2) as f64);
    let flops = Threshold::FLOPS * 27.0 * nodes * width.powf(1.5);
    let bytes = Threshold::BYTES * 72.0 * nodes * width.sqrt() * 0.5 * width.ln();
    let products = if problem.points() > 0 { Cost::EXPECTED_PRODUCTS } else { 1.0 };
    let seconds = Threshold::ORDERING * nodes
        + flops / Cost::FLOPS_PER_SECOND
        + products * 2.0 * Threshold::TOUCHED * bytes / Cost::BYTES_PER_SECOND;
    Estimate { flops, bytes, seconds }
}

/// What every factor of a mesh has at least, in the order by METIS. Measured in blocks of `K`, a node and a node, for each
/// node: [note](../../../../docs/notes/2026-11-23-fixed-costs.md).
struct Fill;

impl Fill {
    /// Below so many nodes a factor takes less than a tenth of a gigabyte, and nothing is said.
    const SMALL: f64 = 20_000.0;
    /// For boxes over `p (1 + ln(q/p))`, `p <= q` the nodes along their two short edges: a constant, and what comes with `ln p`
    /// up to the largest `p` that was measured. 6.2 to 14 was found from plates of one cell to cubes and bars.
    const BOX: [f64; 2] = [3.9, 1.2];
    /// The same where boxes are cut into five tetrahedra, 3.8 to 6.5, and where these have nodes in the middle of their edges,
    /// 4.8 to 8.6.
    const BOX_OF_FIVE: [f64; 2] = [2.4, 0.6];
    const BOX_OF_FIVE_QUADRATIC: [f64; 2] = [3.3, 0.8];
    const LARGEST: f64 = 40.0;
    /// For any graph over a thickness that is told by its levels: that of a cube, `sqrt(w/3)`, or that of a plate, `w/(2d)`, of
    /// `d` levels with at most `w` nodes. At least 5.2 for the same meshes.
    const GRAPH: f64 = 4.5;
}

/// Entries that the factor of a box of `nodes` has at least, three unknowns each; `corners` are the nodes along its edges but
/// for those in the middle of the edges of cells.
pub(crate) fn least_entries_of_box(nodes: f64, corners: [f64; 3], of_five_tetrahedra: bool) -> f64 {
    let finer = (nodes / corners.iter().product::<f64>()).cbrt();
    let mut along = corners.map(|count| count * finer);
    along.sort_by(f64::total_cmp);
    let [p, q, _] = along;
    let [constant, growth] = match (of_five_tetrahedra, nodes > 2.0 * corners.iter().product::<f64>()) {
        (false, _) => Fill::BOX,
        (true, false) => Fill::BOX_OF_FIVE,
        (true, true) => Fill::BOX_OF_FIVE_QUADRATIC,
    };
    let each = (constant + growth * p.min(Fill::LARGEST).ln()) * p * (1.0 + (q / p).ln());
    if nodes < Fill::SMALL { 0.0 } else { BLOCK * nodes * each }
}

/// Entries that the factor has at least for a graph of so many nodes with three unknowns each.
pub(crate) fn least_entries_of_graph(nodes: usize, neighbours: &Neighbours) -> f64 {
    let of_piece = |piece: &Piece| {
        let [nodes, width, depth] = [piece.nodes, piece.width, piece.depth].map(|count| count as f64);
        let thickness = (width / 3.0).sqrt().min(width / (2.0 * depth));
        if nodes < Fill::SMALL { 0.0 } else { BLOCK * nodes * Fill::GRAPH * thickness }
    };
    pieces(nodes, neighbours).iter().map(of_piece).sum()
}

/// Entries of a block of three unknowns by three.
const BLOCK: f64 = 9.0;

/// Calls for every neighbour of a node, repeated or not, the node itself or not.
pub(crate) type Neighbours<'a> = dyn Fn(u32, &mut dyn FnMut(u32)) + 'a;

/// The neighbours in the graph of `K`.
pub(super) fn neighbours(graph: &NodeGraph) -> impl Fn(u32, &mut dyn FnMut(u32)) {
    |v, visit| graph.neighbours_of(v as usize).iter().for_each(|&w| visit(w))
}

/// A connected piece of a graph, seen from an end of it.
struct Piece {
    nodes: usize,
    /// The most nodes at one distance.
    width: usize,
    /// How many distances there are.
    depth: usize,
}

fn pieces(nodes: usize, neighbours: &Neighbours) -> Vec<Piece> {
    // The last search that saw each node: searches need no fresh memory, however many pieces there are.
    let (mut seen, mut search) = (vec![0u32; nodes], 0);
    let mut all = Vec::new();
    for seed in 0..nodes {
        if seen[seed] > 0 {
            continue;
        }
        let (mut start, mut piece) = (seed, Piece { nodes: 0, width: 0, depth: 0 });
        for _ in 0..Threshold::PASSES {
            search += 1;
            (start, piece) = levels(neighbours, start, search, &mut seen);
        }
        all.push(piece);
    }
    all
}

/// The last node reached from `start`, and what was reached.
fn levels(neighbours: &Neighbours, start: usize, search: u32, seen: &mut [u32]) -> (usize, Piece) {
    seen[start] = search;
    let (mut level, mut last) = (vec![start as u32], start);
    let mut piece = Piece { nodes: 0, width: 0, depth: 0 };
    while let Some(&first) = level.first() {
        last = first as usize;
        piece = Piece { nodes: piece.nodes + level.len(), width: piece.width.max(level.len()), depth: piece.depth + 1 };
        let mut next = Vec::new();
        for &v in &level {
            neighbours(v, &mut |w| {
                if std::mem::replace(&mut seen[w as usize], search) != search {
                    next.push(w);
                }
            });
        }
        level = next;
    }
    (last, piece)
}
