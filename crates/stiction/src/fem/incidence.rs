use std::ops::Range;

use rayon::prelude::*;

use super::solid::CellList;
use crate::Error;
use crate::mesh::{Buckets, Mesh};

/// Nodes whose rows are assembled as one task, which no result depends on: the more they are, the fewer cells belong to
/// several tasks and are integrated for each of them, until the sums of a task no longer stay near the processor.
const NODES_PER_RANGE: Range<usize> = 2048..16384;
/// Ranges for each thread at least, where they do not get shorter than that.
const RANGES_PER_THREAD: usize = 8;

/// The cells at each node, ascending.
pub(super) struct Incidence(Buckets);

impl Incidence {
    /// An error for a node without a cell.
    pub(super) fn new(mesh: &Mesh) -> Result<Self, Error> {
        let at = Buckets::new(mesh.nodes.len(), mesh.cell_count(), |range| {
            mesh.cells_in(range).flat_map(|(cell, nodes)| nodes.iter().map(move |&node| [node, cell as u32]))
        });
        if let Some(node) = at.start.windows(2).position(|range| range[0] == range[1]) {
            let place = format!("node {node} at {}", super::field::point(mesh.nodes[node]));
            return Err(Error::new(place, "the node belongs to no cell", "remove it from the mesh"));
        }
        Ok(Incidence(at))
    }

    /// Cells at node `i`, ascending.
    pub(super) fn at(&self, i: usize) -> &[u32] {
        self.0.at(i)
    }

    /// Number of nodes.
    fn nodes(&self) -> usize {
        self.0.start.len() - 1
    }
}

/// The cells that touch a range of nodes: a bit for each up to the highest met so far, all zero between two ranges.
#[derive(Debug, Default)]
pub(super) struct Touching(Vec<u64>);

impl Touching {
    /// Cells that touch the range, each once, ascending.
    pub(super) fn cells(&mut self, range: &NodeRange, incidence: &Incidence) -> Vec<u32> {
        let Incidence(at) = incidence;
        let own = &at.items[at.start[range.nodes.start]..at.start[range.nodes.end]];
        // Words with a bit, of which a mesh numbered as it lies in space has few.
        let mut words = Vec::new();
        for &cell in own {
            let word = cell as usize / 64;
            if word >= self.0.len() {
                self.0.resize(word + 1, 0);
            }
            if self.0[word] == 0 {
                words.push(word);
            }
            self.0[word] |= 1 << (cell % 64);
        }
        words.sort_unstable();
        // Most are met at two nodes or more.
        let mut cells = Vec::with_capacity(own.len() / 2);
        for word in words {
            let mut bits = std::mem::take(&mut self.0[word]);
            while bits != 0 {
                cells.push(64 * word as u32 + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
        cells
    }
}

/// A contiguous range of nodes and their neighbours: the 3 x 3 blocks of its rows of the stiffness matrix that are needed,
/// those up to the diagonal, or at it, and those that prescribed displacements touch.
pub(super) struct NodeRange {
    pub nodes: Range<usize>,
    /// The `k`-th node of the range has the blocks `start[k]..start[k + 1]`.
    start: Vec<usize>,
    /// Nodes that share a cell with it and whose blocks are needed, itself included, ascending.
    neighbour: Vec<u32>,
}

impl NodeRange {
    /// All nodes in ranges, with their neighbours.
    pub(super) fn all(incidence: &Incidence, cells: &CellList, needed: &Needed) -> Vec<NodeRange> {
        let nodes = incidence.nodes();
        let size = nodes / (RANGES_PER_THREAD * rayon::current_num_threads());
        let size = size.clamp(NODES_PER_RANGE.start, NODES_PER_RANGE.end);
        let ranges = (0..nodes.div_ceil(size)).into_par_iter();
        ranges
            .map_init(
                || vec![u32::MAX; nodes],
                |seen_by, r| {
                    let range = r * size..((r + 1) * size).min(nodes);
                    NodeRange::new(range, incidence, cells, needed, seen_by)
                },
            )
            .collect()
    }

    /// `seen_by[j]` is the last node that listed `j` as its neighbour.
    fn new(nodes: Range<usize>, incidence: &Incidence, cells: &CellList, needed: &Needed, seen_by: &mut [u32]) -> Self {
        let mut neighbour = Vec::with_capacity(nodes.len() * 10);
        let mut start = vec![0];
        for i in nodes.clone() {
            let first = neighbour.len();
            for &cell in incidence.at(i) {
                for &j in cells.get(cell as usize).1 {
                    if needed.has(i, j as usize) && seen_by[j as usize] != i as u32 {
                        seen_by[j as usize] = i as u32;
                        neighbour.push(j);
                    }
                }
            }
            neighbour[first..].sort_unstable();
            start.push(neighbour.len());
        }
        NodeRange { nodes, start, neighbour }
    }

    /// Number of blocks in all its rows.
    pub(super) fn blocks(&self) -> usize {
        self.neighbour.len()
    }

    /// Positions of the blocks of node `i`.
    pub(super) fn row(&self, i: usize) -> Range<usize> {
        let k = i - self.nodes.start;
        self.start[k]..self.start[k + 1]
    }

    /// Neighbours of node `i` whose blocks are needed, itself included, ascending.
    pub(super) fn neighbours(&self, i: usize) -> &[u32] {
        &self.neighbour[self.row(i)]
    }
}

/// The entries of `K` that are assembled. Those that prescribed displacements have always are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Entries {
    /// Its lower triangle.
    All,
    /// Its diagonal: where others solve, that says how stiff an unknown is.
    Diagonal,
}

/// Which blocks are needed.
pub(super) struct Needed {
    /// Nodes of which some displacement is prescribed.
    pub constrained: Vec<bool>,
    pub entries: Entries,
}

impl Needed {
    /// Whether the block of nodes `i` and `j` is: the unknowns among themselves take one of it and its mirror image.
    pub(super) fn has(&self, i: usize, j: usize) -> bool {
        j == i || j < i && self.entries == Entries::All || self.constrained[i] || self.constrained[j]
    }
}
