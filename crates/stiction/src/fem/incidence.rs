use std::ops::Range;

use rayon::prelude::*;

use super::solid::CellList;
use crate::Error;
use crate::mesh::Mesh;

/// Nodes whose rows are assembled as one task, which no result depends on: the more they are, the fewer cells belong to
/// several tasks and are integrated for each of them, until the sums of a task no longer stay near the processor.
const NODES_PER_RANGE: Range<usize> = 2048..16384;
/// Ranges for each thread at least, where they do not get shorter than that.
const RANGES_PER_THREAD: usize = 8;

/// The cells at each node, ascending: node `i` has `cell[start[i]..start[i + 1]]`.
pub(super) struct Incidence {
    start: Vec<usize>,
    cell: Vec<u32>,
}

impl Incidence {
    /// Counting sort of the corners of all cells by their node. An error for a node without a cell.
    pub fn new(mesh: &Mesh) -> Result<Self, Error> {
        let mut start = vec![0usize; mesh.nodes.len() + 1];
        let corners = || mesh.cells.iter().flat_map(|block| &block.nodes);
        corners().for_each(|&i| start[i as usize + 1] += 1);
        if let Some(node) = start[1..].iter().position(|&count| count == 0) {
            let place = format!("node {node} at {}", super::field::point(mesh.nodes[node]));
            return Err(Error::new(place, "the node belongs to no cell", "remove it from the mesh"));
        }
        for i in 0..mesh.nodes.len() {
            start[i + 1] += start[i];
        }
        let mut place = start.clone();
        let mut cell = vec![0; start[mesh.nodes.len()]];
        let mut number = 0;
        for block in &mesh.cells {
            for nodes in block.nodes.chunks_exact(block.kind.nodes()) {
                for &i in nodes {
                    cell[place[i as usize]] = number;
                    place[i as usize] += 1;
                }
                number += 1;
            }
        }
        Ok(Incidence { start, cell })
    }

    /// Cells at node `i`, ascending.
    pub fn at(&self, i: usize) -> &[u32] {
        &self.cell[self.start[i]..self.start[i + 1]]
    }
}

/// A contiguous range of nodes and their neighbours: the 3 x 3 blocks of its rows of the stiffness matrix that are needed,
/// those up to the diagonal and those that prescribed displacements touch.
pub(super) struct NodeRange {
    pub nodes: Range<usize>,
    /// The `k`-th node of the range has the blocks `start[k]..start[k + 1]`.
    start: Vec<usize>,
    /// Nodes that share a cell with it and whose blocks are needed, itself included, ascending.
    neighbour: Vec<u32>,
}

impl NodeRange {
    /// All nodes in ranges, with their neighbours; some displacement of the nodes `held` is prescribed.
    pub fn all(incidence: &Incidence, cells: &CellList, held: &[bool]) -> Vec<NodeRange> {
        let nodes = incidence.start.len() - 1;
        let size = nodes / (RANGES_PER_THREAD * rayon::current_num_threads());
        let size = size.clamp(NODES_PER_RANGE.start, NODES_PER_RANGE.end);
        let ranges = (0..nodes.div_ceil(size)).into_par_iter();
        ranges
            .map_init(
                || vec![u32::MAX; nodes],
                |seen_by, r| {
                    let range = r * size..((r + 1) * size).min(nodes);
                    NodeRange::new(range, incidence, cells, held, seen_by)
                },
            )
            .collect()
    }

    /// `seen_by[j]` is the last node that listed `j` as its neighbour.
    fn new(nodes: Range<usize>, incidence: &Incidence, cells: &CellList, held: &[bool], seen_by: &mut [u32]) -> Self {
        let mut neighbour = Vec::with_capacity(nodes.len() * 10);
        let mut start = vec![0];
        for i in nodes.clone() {
            let first = neighbour.len();
            for &cell in incidence.at(i) {
                for &j in cells.get(cell as usize).1 {
                    if is_needed(i, j as usize, held) && seen_by[j as usize] != i as u32 {
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
    pub fn blocks(&self) -> usize {
        self.neighbour.len()
    }

    /// Positions of the blocks of node `i`.
    pub fn row(&self, i: usize) -> Range<usize> {
        let k = i - self.nodes.start;
        self.start[k]..self.start[k + 1]
    }

    /// Neighbours of node `i` whose blocks are needed, itself included, ascending.
    pub fn neighbours(&self, i: usize) -> &[u32] {
        &self.neighbour[self.row(i)]
    }

    /// Cells that touch the range, each once, ascending.
    pub fn cells(&self, incidence: &Incidence, cells: &CellList) -> Vec<u32> {
        let mut touching = Vec::new();
        for i in self.nodes.clone() {
            // A cell is listed by the first of its corners that lies in the range.
            let first = |cell: &&u32| {
                let corners = cells.get(**cell as usize).1;
                corners.iter().find(|&&j| self.nodes.contains(&(j as usize))) == Some(&(i as u32))
            };
            touching.extend(incidence.at(i).iter().filter(first));
        }
        touching.sort_unstable();
        touching
    }
}

/// Whether the block of nodes `i` and `j` is needed: the unknowns among themselves take one of it and its mirror image.
pub(super) fn is_needed(i: usize, j: usize, held: &[bool]) -> bool {
    j <= i || held[i] || held[j]
}
