//! All faces of all cells, each findable by its nodes.
//!
//! Faces are identified by their corners; neighbours must share the middles of edges too. They come into the bucket of
//! their lowest node by counting, which is faster than sorting and gives the same order for any number of threads.

use std::ops::Range;

use rayon::prelude::*;

use super::{Buckets, CellKind, Face, RawMesh};

/// Nodes whose faces a thread sorts at a time; the result does not depend on it.
const NODES_PER_TASK: usize = 4096;

/// Room for the six faces of a cell, a power of two: face number = `STRIDE * cell + local`.
const STRIDE: u32 = 8;

/// Largest number of cells whose faces can be numbered.
pub(super) const MAX_CELLS: usize = (u32::MAX / STRIDE) as usize;

/// The faces of all cells, each in the bucket of its lowest node, sorted there by their corners.
///
/// Keys are read from the cells whenever they are needed, which costs less memory than keeping them.
pub(super) struct FaceTable<'a> {
    blocks: Vec<Block<'a>>,
    faces: Buckets,
}

/// Cells of one kind with their nodes.
struct Block<'a> {
    kind: CellKind,
    nodes: &'a [u32],
    /// Numbers of its cells.
    cells: Range<usize>,
    /// Corners of the faces of a cell; [`NONE`] ends triangles.
    corners: [[u8; 4]; 6],
}

/// No node of any cell.
const NONE: u8 = u8::MAX;

impl<'a> Block<'a> {
    fn new(kind: CellKind, nodes: &'a [u32], first: usize) -> Self {
        let mut corners = [[NONE; 4]; 6];
        for (corners, face) in corners.iter_mut().zip(kind.linear().faces()) {
            corners.iter_mut().zip(*face).for_each(|(corner, &i)| *corner = i as u8);
        }
        Block { kind, nodes, cells: first..first + nodes.len() / kind.nodes(), corners }
    }

    /// Nodes of cell number `cell`, which is one of the block.
    fn cell(&self, cell: usize) -> &'a [u32] {
        &self.nodes[(cell - self.cells.start) * self.kind.nodes()..][..self.kind.nodes()]
    }

    /// The faces of the cells that are in `range`, as their lowest node and their number; ascending.
    fn faces_in(&self, range: Range<usize>) -> impl Iterator<Item = [u32; 2]> {
        let (n, faces) = (self.kind.nodes(), self.kind.faces().len());
        let own =
            range.start.clamp(self.cells.start, self.cells.end)..range.end.clamp(self.cells.start, self.cells.end);
        let cells = &self.nodes[(own.start - self.cells.start) * n..(own.end - self.cells.start) * n];
        own.zip(cells.chunks_exact(n)).flat_map(move |(cell, nodes)| {
            let number = move |local: usize| STRIDE * cell as u32 + local as u32;
            (0..faces).map(move |local| [lowest(nodes, self.corners[local]), number(local)])
        })
    }
}

/// The lowest node of a face of a cell.
fn lowest(nodes: &[u32], [a, b, c, d]: [u8; 4]) -> u32 {
    let at = |i: u8| nodes[i as usize];
    let three = at(a).min(at(b)).min(at(c));
    nodes.get(d as usize).map_or(three, |&d| three.min(d))
}

/// How the cells meet.
#[derive(Default)]
pub(super) struct Encounters {
    /// Face numbers of exactly one cell, ascending.
    pub boundary: Vec<u32>,
    /// Cells at a face that three or more share.
    pub crowded: Vec<u32>,
    /// Pairs of cells on the same side of a face they share.
    pub folded: Vec<[u32; 2]>,
    /// Cells that have the same nodes as another.
    pub twins: Vec<u32>,
    /// Pairs of cells that share the corners of a face but not the nodes in the middles of its edges.
    pub unlike: Vec<[u32; 2]>,
    /// A node that is the lowest of more than [`MOST_AT_A_NODE`] faces, and of how many; nothing is seen there.
    pub star: Option<[usize; 2]>,
}

/// Faces with the same lowest node are compared with each other: more are no mesh, and would take memory out of proportion.
const MOST_AT_A_NODE: usize = 1 << 18;

impl<'a> FaceTable<'a> {
    /// The table of a mesh with at most [`MAX_CELLS`] cells whose node numbers are in range, and how its cells meet.
    pub(super) fn new(raw: &'a RawMesh) -> (Self, Encounters) {
        let mut first = 0;
        let block = |b: &'a super::RawCells| {
            let block = Block::new(b.kind, &b.nodes, first);
            first = block.cells.end;
            block
        };
        let blocks: Vec<Block> = raw.cells.iter().map(block).collect();
        let table = FaceTable { blocks, faces: Buckets::default() };
        let of_cells = |range: Range<usize>| table.blocks.iter().flat_map(move |block| block.faces_in(range.clone()));
        let mut faces = Buckets::new(raw.nodes.len(), first, of_cells);
        let (mut tasks, mut rest) = (Vec::new(), faces.items.as_mut_slice());
        let starts = &faces.start;
        for first in (0..raw.nodes.len()).step_by(NODES_PER_TASK) {
            let end = raw.nodes.len().min(first + NODES_PER_TASK);
            let (own, tail) = rest.split_at_mut(starts[end] - starts[first]);
            tasks.push((&starts[first..=end], own));
            rest = tail;
        }
        let star = starts.windows(2).position(|at| at[1] - at[0] > MOST_AT_A_NODE);
        if let Some(node) = star {
            let star = Some([node, starts[node + 1] - starts[node]]);
            return (FaceTable { faces, ..table }, Encounters { star, ..Encounters::default() });
        }
        let sort = |keyed: &mut Vec<u128>, (starts, faces): (&[usize], &mut [u32])| table.sort(keyed, starts, faces);
        let parts: Vec<Encounters> = tasks.into_par_iter().with_max_len(1).map_init(Vec::new, sort).collect();
        let mut seen = parts.into_iter().fold(Encounters::default(), Encounters::and);
        seen.put_in_order();
        (FaceTable { faces, ..table }, seen)
    }

    /// Sorts the faces of consecutive nodes, and sees how their cells meet.
    fn sort(&self, keyed: &mut Vec<u128>, starts: &[usize], mut faces: &mut [u32]) -> Encounters {
        let mut seen = Encounters::default();
        for range in starts.windows(2) {
            let (bucket, others) = faces.split_at_mut(range[1] - range[0]);
            faces = others;
            keyed.clear();
            // All have the same lowest corner: the others and the number make one number to sort by.
            keyed.extend(bucket.iter().map(|&face| {
                let [_, b, c, d] = self.key(face).map(u128::from);
                b << 96 | c << 64 | d << 32 | u128::from(face)
            }));
            keyed.sort_unstable();
            bucket.iter_mut().zip(&*keyed).for_each(|(slot, &key)| *slot = key as u32);
            let mut rest = &*bucket;
            for run in keyed.chunk_by(|a, b| a >> 32 == b >> 32) {
                let (together, others) = rest.split_at(run.len());
                self.encounter(together, &mut seen);
                rest = others;
            }
        }
        seen
    }

    /// The block with that cell.
    fn block(&self, cell: u32) -> &Block<'a> {
        let of = |block: &&Block| (cell as usize) < block.cells.end;
        self.blocks.iter().find(of).expect("the table numbers only faces of its own cells")
    }

    /// The face with that number.
    pub(super) fn face(&self, face: u32) -> Face {
        let cell = face / STRIDE;
        let block = self.block(cell);
        Face::of_cell(block.kind, block.cell(cell as usize), cell, (face % STRIDE) as u8)
    }

    /// Its corners, counter-clockwise seen from outside; triangles end in `u32::MAX`.
    fn corners(&self, face: u32) -> [u32; 4] {
        let block = self.block(face / STRIDE);
        let nodes = block.cell((face / STRIDE) as usize);
        block.corners[(face % STRIDE) as usize].map(|i| nodes.get(i as usize).copied().unwrap_or(u32::MAX))
    }

    fn key(&self, face: u32) -> [u32; 4] {
        sorted(self.corners(face))
    }

    /// Numbers of the faces with these corners in any order, ascending; triangles end in `u32::MAX`.
    pub(super) fn find(&self, corners: [u32; 4]) -> &[u32] {
        let key = sorted(corners);
        let bucket = self.faces.at(key[0] as usize);
        let from = bucket.partition_point(|&face| self.key(face) < key);
        let count = bucket[from..].iter().take_while(|&&face| self.key(face) == key).count();
        &bucket[from..from + count]
    }

    /// Sees which cells the faces with the same corners belong to.
    fn encounter(&self, faces: &[u32], seen: &mut Encounters) {
        match *faces {
            [face] => seen.boundary.push(face),
            [a, b] => self.meet(a, b, seen),
            _ => self.crowd(faces, seen),
        }
    }

    /// Two cells share a face: seen from outside, each must see the nodes turn the other way.
    fn meet(&self, a: u32, b: u32, seen: &mut Encounters) {
        if [a, b].into_iter().all(|face| self.block(face / STRIDE).kind == CellKind::Tet4) {
            // Nearly always, and sooner said: one of two orders of the same three corners is even, the other odd.
            let odd = |[a, b, c, _]: [u32; 4]| (a > b) ^ (a > c) ^ (b > c);
            if odd(self.corners(a)) != odd(self.corners(b)) {
                return;
            }
        }
        let (front, back) = (self.face(a), self.face(b));
        let (x, y) = (front.corners(), back.corners());
        let n = x.len();
        let shift = y.iter().position(|&node| node == x[0]).unwrap_or(0);
        let cells = [a / STRIDE, b / STRIDE];
        if (0..n).all(|i| x[i] == y[(shift + n - i) % n]) {
            let (mine, theirs) = (&front.nodes()[n..], &back.nodes()[n..]);
            // the edge from corner i to the next is the one towards corner shift - i for the neighbour
            let same = |i: usize| mine[i] == theirs[(shift + 2 * n - i - 1) % n];
            if mine.len() != theirs.len() || !(0..mine.len()).all(same) {
                seen.unlike.push(cells);
            }
            return;
        }
        if self.cell_key(cells[0]) == self.cell_key(cells[1]) {
            // Twins meet at all their faces: one is enough.
            if a.is_multiple_of(STRIDE) || b.is_multiple_of(STRIDE) {
                seen.twins.extend(cells);
            }
        } else {
            seen.folded.push(cells);
        }
    }

    /// Three or more cells share a face.
    fn crowd(&self, faces: &[u32], seen: &mut Encounters) {
        let mut keys: Vec<_> = faces.iter().map(|&f| (self.cell_key(f / STRIDE), f)).collect();
        keys.sort_unstable();
        let twins = || keys.windows(2).filter(|w| w[0].0 == w[1].0).flat_map(|w| [w[0].1, w[1].1]);
        seen.twins.extend(twins().filter(|face| face.is_multiple_of(STRIDE)).map(|face| face / STRIDE));
        if twins().next().is_none() {
            seen.crowded.extend(faces.iter().map(|f| f / STRIDE));
        }
    }

    fn cell_key(&self, cell: u32) -> Vec<u32> {
        let mut nodes = self.block(cell).cell(cell as usize).to_vec();
        nodes.sort_unstable();
        nodes
    }
}

impl Encounters {
    fn and(mut self, other: Encounters) -> Encounters {
        let Encounters { boundary, crowded, folded, twins, unlike, star: _ } = other;
        self.boundary.extend(boundary);
        self.crowded.extend(crowded);
        self.folded.extend(folded);
        self.twins.extend(twins);
        self.unlike.extend(unlike);
        self
    }

    fn put_in_order(&mut self) {
        self.boundary.sort_unstable();
        for list in [&mut self.crowded, &mut self.twins] {
            list.sort_unstable();
            list.dedup();
        }
        self.folded.sort_unstable();
        self.unlike.sort_unstable();
    }
}

/// Four numbers in ascending order.
pub(super) fn sorted([a, b, c, d]: [u32; 4]) -> [u32; 4] {
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    let (low, b_or_c) = (a.min(c), a.max(c));
    let (high, c_or_b) = (b.max(d), b.min(d));
    [low, b_or_c.min(c_or_b), b_or_c.max(c_or_b), high]
}
