//! The part of a grid within a box of its corners: counting tells where a node is in it, without a search.

use std::ops::Range;

use rayon::prelude::*;

use super::{CornerBox, Grid, GridMesh, Grids, bits_of, stepped};
use crate::mesh::block::parts;
use crate::mesh::{Cells, Mesh, MeshArrays};

/// Corners of a grid from the first to the last along each axis, then the middles of the edges from them. Places in it ascend as
/// the numbers of the nodes do.
struct Window<'a> {
    grid: &'a Grid,
    low: [u64; 3],
    /// Corners along each axis.
    size: [u64; 3],
    /// Of quadratic cells, for each row of corners along x the middles in the rows before it and the number of its first one.
    middles: Vec<[u64; 2]>,
    /// Nodes.
    count: u64,
}

/// The cells in a row along x that a part has, and the places of their nodes.
#[derive(Default)]
struct Row {
    cells: Vec<u64>,
    nodes: Vec<u32>,
}

impl Window<'_> {
    fn new(grid: &Grid, [low, high]: CornerBox) -> Window<'_> {
        let size = [0, 1, 2].map(|c| high[c] - low[c] + 1);
        let mut window = Window { grid, low, size, middles: Vec::new(), count: size.iter().product() };
        if !grid.edges.is_empty() {
            let corners = window.count;
            for (k, j) in (low[2]..=high[2]).flat_map(|k| (low[1]..=high[1]).map(move |j| (k, j))) {
                let (first, last) = ([low[0], j, k], [high[0], j, k]);
                window.middles.push([window.count - corners, grid.first_middle(first)]);
                window.count += grid.first_middle(last) + grid.edges_at(last).len() as u64 - grid.first_middle(first);
            }
        }
        window
    }

    fn corner_place(&self, at: [u64; 3]) -> u64 {
        let [i, j, k] = [0, 1, 2].map(|c| at[c] - self.low[c]);
        i + self.size[0] * (j + self.size[1] * k)
    }

    /// The place of a middle by its number: `row` is that of the lower corner.
    fn middle_place(&self, [_, j, k]: [u64; 3], number: u64) -> u64 {
        let [before, first] = self.middles[((j - self.low[1]) + self.size[1] * (k - self.low[2])) as usize];
        self.size.iter().product::<u64>() + before + (number - first)
    }

    /// The number of the node at a place.
    fn number(&self, place: u64) -> u64 {
        let [x, y, z] = self.size;
        let Some(middle) = place.checked_sub(x * y * z) else {
            let at = [place % x, place / x % y, place / x / y];
            return self.grid.number([0, 1, 2].map(|c| self.low[c] + at[c]));
        };
        let row = self.middles.partition_point(|[before, _]| *before <= middle) - 1;
        let [before, first] = self.middles[row];
        first + (middle - before)
    }

    /// Appends the places of the nodes of a cell.
    fn cell_nodes(&self, at: [u64; 3], part: usize, nodes: &mut Vec<u32>) {
        let grid = self.grid;
        let bits = grid.corner_bits(at, part);
        let (first, [x, y, _]) = (self.corner_place(at), self.size);
        let beyond = |bits: usize| (bits & 1) as u64 + x * ((bits >> 1 & 1) as u64 + y * (bits >> 2) as u64);
        nodes.extend(bits.iter().map(|&bits| (first + beyond(bits)) as u32));
        let middle = |&[a, b]: &[usize; 2]| {
            let [a, b] = [bits[a].min(bits[b]), bits[a].max(bits[b])].map(bits_of);
            let low = stepped(at, a);
            self.middle_place(low, grid.middle(low, [0, 1, 2].map(|c| b[c] - a[c]))) as u32
        };
        nodes.extend(grid.element.kind().edges().iter().map(middle));
    }

    /// The grid cells within along an axis.
    fn cells(&self, axis: usize) -> Range<u64> {
        self.low[axis]..self.low[axis] + self.size[axis] - 1
    }

    /// Those of the cells within that `has` one of their nodes at, by its place, and those of `beside`, which ascend.
    fn rows(&self, beside: &[u64], has: impl Fn(u32) -> bool + Sync) -> Vec<Row> {
        let ([x, y, _], parts) = (self.grid.cells, parts(self.grid.element) as u64);
        let rows: Vec<[u64; 2]> = self.cells(2).flat_map(|k| self.cells(1).map(move |j| [j, k])).collect();
        let row = |&[j, k]: &[u64; 2]| {
            let mut row = Row::default();
            let number = |i: u64| parts * (i + x * (j + y * k));
            let mut beside = &beside[beside.partition_point(|&cell| cell < number(self.low[0]))..];
            for i in self.cells(0) {
                for part in 0..parts {
                    let (number, from) = (number(i) + part, row.nodes.len());
                    self.cell_nodes([i, j, k], part as usize, &mut row.nodes);
                    let is_beside = beside.first() == Some(&number);
                    beside = &beside[usize::from(is_beside)..];
                    if is_beside || row.nodes[from..].iter().any(|&place| has(place)) {
                        row.cells.push(number);
                    } else {
                        row.nodes.truncate(from);
                    }
                }
            }
            row
        };
        rows.par_iter().map(row).collect()
    }
}

/// No place.
const NONE: u32 = u32::MAX;

impl Grids {
    /// The mesh of the cells at the nodes whose `owner` is `own` and of those `beside`, which ascend; without faces and groups, and
    /// with the owner of each of its nodes.
    ///
    /// The boxes, of which a grid has one, are around the corners that such nodes are at or lie between. Only nodes of the cells
    /// beside may be outside.
    pub fn part(
        &self,
        boxes: &[(usize, CornerBox)],
        beside: &[u64],
        own: u32,
        owner: impl Fn(u64) -> u32 + Sync,
    ) -> (GridMesh, Vec<u32>) {
        let (mut blocks, mut nodes, mut owners, mut cells) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (k, (_, grid)) in self.list.iter().enumerate() {
            let [first_node, first_cell] = [0, 1].map(|kind: usize| self.before[kind][k]);
            let range = [k, k + 1].map(|k| beside.partition_point(|&cell| cell < self.before[1][k]));
            let beside: Vec<u64> = beside[range[0]..range[1]].iter().map(|cell| cell - first_cell).collect();
            let of_nodes = boxes.iter().filter(|(grid, _)| *grid == k).map(|(_, corners)| grid.widened(*corners));
            let of_cells = beside.iter().map(|&cell| grid.grid_cell(cell).0).map(|at| [at, at.map(|n| n + 1)]);
            let Some(corners) = of_nodes.chain(of_cells).reduce(around) else { continue };
            let window = Window::new(grid, corners);
            let owner = |place: u64| owner(first_node + window.number(place));
            let owner_at: Vec<u32> = (0..window.count).into_par_iter().map(owner).collect();
            let rows = window.rows(&beside, |place| owner_at[place as usize] == own);
            let mut places = vec![NONE; owner_at.len()];
            rows.iter().flat_map(|row| &row.nodes).for_each(|&place| places[place as usize] = 0);
            for (place, number) in places.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
                *number = nodes.len() as u32;
                nodes.push(first_node + window.number(place as u64));
                owners.push(owner_at[place]);
            }
            let mut block = Vec::with_capacity(rows.iter().map(|row| row.nodes.len()).sum());
            for row in rows {
                cells.extend(row.cells.iter().map(|cell| first_cell + cell));
                block.extend(row.nodes.iter().map(|&place| places[place as usize]));
            }
            if !block.is_empty() {
                blocks.push(Cells { kind: grid.element.kind(), nodes: block });
            }
        }
        let places = nodes.par_iter().map(|&number| self.place(number)).collect();
        let (arrays, groups, faces) = (MeshArrays::default(), Vec::new(), Vec::new());
        (GridMesh { mesh: Mesh { nodes: places, cells: blocks, faces, groups, arrays }, nodes, cells }, owners)
    }
}

impl Grid {
    /// A box around all corners of the cells at those of a box.
    fn widened(&self, [low, high]: CornerBox) -> CornerBox {
        [low.map(|n| n.saturating_sub(1)), [0, 1, 2].map(|c| (high[c] + 1).min(self.cells[c]))]
    }
}

/// The box around two.
pub(crate) fn around(a: CornerBox, b: CornerBox) -> CornerBox {
    [[0, 1, 2].map(|c| a[0][c].min(b[0][c])), [0, 1, 2].map(|c| a[1][c].max(b[1][c]))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::block::tests::ELEMENTS;
    use crate::mesh::{Block, Ring};

    /// By the definition of a part, from all cells of the whole.
    #[test]
    fn a_part_has_the_cells_at_its_nodes_and_those_beside() {
        for element in ELEMENTS {
            let (grading, cells) = ([2.0, 1.0, 0.3], [5, 4, 6]);
            let block = Block { size: [1.0; 3], cells, origin: [0.0; 3], grading, element };
            let ring = Ring { radii: [2.0, 5.0], height: 4.0, degrees: 120.0, cells: [3, 1, 2], grading, element };
            let named = |name: &str, grid: Grid| (Some(name.to_string()), grid);
            let of_block = |name: &str| named(name, Grid::of_block(&block, Vec::new()).unwrap());
            let grids = Grids::new(vec![
                of_block("first"),
                named("ring", Grid::of_ring(&ring, Vec::new()).unwrap()),
                of_block("last"),
            ]);
            let whole = grids.mesh((0..grids.sizes()[1]).collect());
            // Own nodes in a corner of two of the grids, few of them in the other; cells beside in the middle of all.
            let owner = |number: u64| {
                let ([x, y, z], k) = (grids.place(number), grids.of_node(number));
                u32::from(if k == 1 { x > 4.5 } else { x + y < 0.8 && z > 0.4 }) * 7
            };
            let mut boxes: Vec<(usize, CornerBox)> = Vec::new();
            for number in (0..grids.sizes()[0]).filter(|&number| owner(number) == 7) {
                let (k, corners) = grids.corners_of(number);
                match boxes.iter_mut().find(|(other, _)| *other == k) {
                    Some((_, found)) => *found = around(*found, corners),
                    None => boxes.push((k, corners)),
                }
            }
            let [_, count] = grids.sizes();
            let beside: Vec<u64> = (0..count).filter(|cell| cell % 7 == 3 && *cell < count * 2 / 3).collect();
            let (part, owners) = grids.part(&boxes, &beside, 7, owner);
            let wanted = |(cell, (_, nodes)): (usize, (_, &[u32]))| {
                let at_own = nodes.iter().any(|&v| owner(u64::from(v)) == 7);
                (at_own || beside.contains(&(cell as u64))).then_some(cell as u64)
            };
            let wanted: Vec<u64> = whole.mesh.cell_iter().enumerate().filter_map(wanted).collect();
            assert!(wanted.len() > beside.len() && wanted.len() < count as usize * 3 / 4);
            let expected = grids.mesh(wanted);
            assert_eq!([&part.nodes, &part.cells], [&expected.nodes, &expected.cells], "{element:?}");
            assert_eq!(part.mesh, expected.mesh);
            assert!(part.nodes.iter().map(|&number| owner(number)).eq(owners));
        }
    }
}
