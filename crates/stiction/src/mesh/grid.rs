//! Blocks and rings of which any part can be made by itself: numbers and places of nodes, cells and boundary faces follow from
//! counting.
//!
//! What [`block`](super::block()) and [`ring`](super::ring()) make as a whole has the same numbers. There everything follows from the
//! cells alone, as in files; a rank that holds a thousandth of a mesh cannot ask that of them.

mod window;

use rayon::prelude::*;

pub(crate) use window::around;

use super::block::{SIDE_NAMES, axis, corners, parts, shape_error};
use super::ring::{SIDES, ring_error};
use super::v3::{V3, add, scale};
use super::{Block, BlockElement, CellKind, Cells, Face, Group, Mesh, MeshArrays, Ring, Turn, ascending};
use crate::Error;

/// Places of a corner along the axes, or how far it is from one to another.
type Step = [i64; 3];

/// Where a corner may be along an axis: within the grid, at its beginning, at its end.
const KINDS: usize = 3;

/// A block or ring divided into cells, moved to where it is.
pub struct Grid {
    axes: [Vec<f64>; 3],
    cells: [u64; 3],
    element: BlockElement,
    is_ring: bool,
    /// Turns, then moves, one after the other.
    placings: Vec<(Option<Turn>, [f64; 3])>,
    /// Of quadratic cells the edges from a corner to those with higher numbers, in their order; by where the corner is, and whether
    /// the sum of its places is odd.
    edges: Vec<[Vec<Step>; 2]>,
    /// Such edges before each row of corners along x, and of all.
    edges_before: Vec<u64>,
}

impl Grid {
    /// That of a block, turned and moved.
    ///
    /// # Errors
    /// As of [`block`](super::block()), but for the number of nodes.
    pub fn of_block(block: &Block, placings: Vec<(Option<Turn>, [f64; 3])>) -> Result<Grid, Error> {
        shape_error(block)?;
        let axes = [axis(block, 0)?, axis(block, 1)?, axis(block, 2)?];
        let cells = block.cells.map(|n| n as u64);
        let (edges, edges_before) = (Vec::new(), vec![0]);
        let mut grid = Grid { axes, cells, element: block.element, is_ring: false, placings, edges, edges_before };
        if block.element.is_quadratic() {
            grid.count_edges();
        }
        Ok(grid)
    }

    /// That of a ring, turned and moved.
    ///
    /// # Errors
    /// As of [`ring`](super::ring()), but for the number of nodes.
    pub fn of_ring(ring: &Ring, placings: Vec<(Option<Turn>, [f64; 3])>) -> Result<Grid, Error> {
        ring_error(ring)?;
        Ok(Grid { is_ring: true, ..Grid::of_block(&ring.straight(), placings)? })
    }

    fn count_edges(&mut self) {
        let kinds = 0..KINDS.pow(3);
        self.edges = kinds.map(|kind| [0, 1].map(|parity| self.edges_of(kind, parity))).collect();
        let [_, y, z] = self.cells;
        let mut before = 0;
        self.edges_before = Vec::with_capacity(((y + 1) * (z + 1)) as usize + 1);
        for row in (0..=z).flat_map(|k| (0..=y).map(move |j| [j, k])) {
            self.edges_before.push(before);
            let last = [self.cells[0], row[0], row[1]];
            before += self.edges_in_row(last) + self.edges_at(last).len() as u64;
        }
        self.edges_before.push(before);
    }

    /// The edges from a corner of this kind, by its eight cells at most.
    fn edges_of(&self, kind: usize, parity: i64) -> Vec<Step> {
        let kinds = [kind % KINDS, kind / KINDS % KINDS, kind / KINDS / KINDS];
        let mut found: Vec<Step> = Vec::new();
        for of_cell in 0..8 {
            // Where the corner is in the cell, by bits.
            let bits = [of_cell & 1, of_cell >> 1 & 1, of_cell >> 2];
            if (0..3).any(|c| kinds[c] > 0 && kinds[c] != bits[c] as usize + 1) {
                continue;
            }
            let odd = (parity - bits.iter().sum::<i64>()).rem_euclid(2) as u64;
            for cell in corners(self.element, odd).chunks_exact(self.element.linear_kind().nodes()) {
                for &[a, b] in self.element.kind().edges() {
                    for [from, to] in [[cell[a], cell[b]], [cell[b], cell[a]]] {
                        let step = bits_of(to);
                        let step = [0, 1, 2].map(|c| step[c] - bits[c]);
                        if from as i64 == of_cell && step.iter().rev().find(|s| **s != 0) > Some(&0) {
                            found.push(step);
                        }
                    }
                }
            }
        }
        found.sort_unstable_by_key(|[x, y, z]| [*z, *y, *x]);
        found.dedup();
        found
    }

    fn edges_at(&self, at: [u64; 3]) -> &[Step] {
        let kind = |c: usize| match at[c] {
            0 => 1,
            n if n == self.cells[c] => 2,
            _ => 0,
        };
        let kind = kind(0) + KINDS * (kind(1) + KINDS * kind(2));
        &self.edges[kind][(at.iter().sum::<u64>() % 2) as usize]
    }

    /// The edges from the corners of a row before the one at `at`: all between the first and the last are alike but for their parity.
    fn edges_in_row(&self, at: [u64; 3]) -> u64 {
        let [i, j, k] = at;
        let count = |i: u64| self.edges_at([i, j, k]).len() as u64;
        let within = i.saturating_sub(1);
        let first = if i > 0 { count(0) } else { 0 };
        let ones = if within > 0 { within.div_ceil(2) * count(1) } else { 0 };
        first + ones + if within > 1 { within / 2 * count(2) } else { 0 }
    }

    /// Corners of cells.
    fn corner_count(&self) -> u64 {
        self.cells.iter().map(|n| n + 1).product()
    }

    /// Nodes of the whole.
    pub fn nodes(&self) -> u64 {
        self.corner_count() + self.edges_before[self.edges_before.len() - 1]
    }

    /// Cells of the whole.
    pub fn cell_count(&self) -> u64 {
        self.cells.iter().product::<u64>() * parts(self.element) as u64
    }

    fn number(&self, [i, j, k]: [u64; 3]) -> u64 {
        i + (self.cells[0] + 1) * (j + (self.cells[1] + 1) * k)
    }

    fn corner(&self, number: u64) -> [u64; 3] {
        let [x, y, _] = self.cells.map(|n| n + 1);
        [number % x, number / x % y, number / x / y]
    }

    /// The number of the node in the middle of the edge between two corners, the first of which has the lower number.
    fn middle(&self, low: [u64; 3], step: Step) -> u64 {
        let place = self.edges_at(low).iter().position(|s| *s == step).unwrap_or_default() as u64;
        self.first_middle(low) + place
    }

    /// The number of the first one from a corner.
    fn first_middle(&self, at: [u64; 3]) -> u64 {
        let row = at[1] + (self.cells[1] + 1) * at[2];
        self.corner_count() + self.edges_before[row as usize] + self.edges_in_row(at)
    }

    /// The corners that a node lies between: twice the same if it is one.
    fn ends(&self, number: u64) -> [[u64; 3]; 2] {
        let Some(edge) = number.checked_sub(self.corner_count()) else { return [self.corner(number); 2] };
        let row = self.edges_before.partition_point(|&before| before <= edge) as u64 - 1;
        let rest = edge - self.edges_before[row as usize];
        let at = |i: u64| [i, row % (self.cells[1] + 1), row / (self.cells[1] + 1)];
        // The last corner before whose edges there are no more than that.
        let [mut low, mut high] = [0, self.cells[0] + 1];
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.edges_in_row(at(middle)) <= rest { low = middle } else { high = middle }
        }
        let step = self.edges_at(at(low))[(rest - self.edges_in_row(at(low))) as usize];
        [at(low), stepped(at(low), step)]
    }

    fn place(&self, [a, b]: [[u64; 3]; 2]) -> V3 {
        let flat = |at: [u64; 3]| [0, 1, 2].map(|c| self.axes[c][at[c] as usize]);
        let [r, angle, z] = if a == b { flat(a) } else { scale(0.5, add(flat(a), flat(b))) };
        let x = if self.is_ring { [r * angle.cos(), r * angle.sin(), z] } else { [r, angle, z] };
        self.placings.iter().fold(x, |x, (turn, by)| add(turn.as_ref().map_or(x, |turn| turn.apply(x)), *by))
    }

    /// The grid cell of a cell and which of the cells there it is.
    fn grid_cell(&self, number: u64) -> ([u64; 3], usize) {
        let parts = parts(self.element) as u64;
        let (at, [x, y, _]) = (number / parts, self.cells);
        ([at % x, at / x % y, at / x / y], (number % parts) as usize)
    }

    /// The corners of a cell, by bits within its grid cell.
    fn corner_bits(&self, at: [u64; 3], part: usize) -> &'static [usize] {
        let count = self.element.linear_kind().nodes();
        &corners(self.element, at.iter().sum::<u64>())[part * count..][..count]
    }

    /// Appends the nodes of a cell.
    fn cell_nodes(&self, number: u64, nodes: &mut Vec<u64>) {
        let (at, part) = self.grid_cell(number);
        let bits = self.corner_bits(at, part);
        let corner = |bits: usize| stepped(at, bits_of(bits));
        nodes.extend(bits.iter().map(|&bits| self.number(corner(bits))));
        let middle = |&[a, b]: &[usize; 2]| {
            let [a, b] = [corner(bits[a]), corner(bits[b])];
            let [low, high] = if self.number(a) < self.number(b) { [a, b] } else { [b, a] };
            self.middle(low, [0, 1, 2].map(|c| high[c] as i64 - low[c] as i64))
        };
        nodes.extend(self.element.kind().edges().iter().map(middle));
    }

    /// The side that each face of a cell is on, by its number in [`SIDE_NAMES`].
    fn sides(&self, number: u64) -> impl Iterator<Item = (u8, usize)> {
        let (at, part) = self.grid_cell(number);
        let inside = (0..3).all(|c| at[c] > 0 && at[c] + 1 < self.cells[c]);
        let (bits, kind) = (self.corner_bits(at, part), self.element.linear_kind());
        let count = if inside { 0 } else { kind.faces().len() };
        (0..count).filter_map(move |local| {
            let on = |side: usize| {
                let (c, end) = (side / 2, side % 2);
                let at_end = if end == 0 { at[c] == 0 } else { at[c] + 1 == self.cells[c] };
                at_end && kind.faces()[local].iter().all(|&corner| bits[corner] >> c & 1 == end)
            };
            Some((local as u8, (0..6).find(|&side| on(side))?))
        })
    }

    /// Appends the cells of the grid cells that have no neighbour on some side: all cells at the nodes of the boundary are among
    /// them. Their numbers start at `first`.
    fn boundary_cells(&self, first: u64, cells: &mut Vec<u64>) {
        let ([x, y, z], parts) = (self.cells, parts(self.element) as u64);
        let ends = |n: u64, at: u64| at == 0 || at + 1 == n;
        for (j, k) in (0..z).flat_map(|k| (0..y).map(move |j| (j, k))) {
            let row = first + parts * x * (j + y * k);
            if ends(y, j) || ends(z, k) || x < 3 {
                cells.extend(row..row + parts * x);
            } else {
                cells.extend(row..row + parts);
                cells.extend(row + parts * (x - 1)..row + parts * x);
            }
        }
    }

    fn side_name(&self, side: usize) -> &'static str {
        let name = SIDE_NAMES[side];
        let ring = SIDES.iter().find(|(old, _)| self.is_ring && *old == name);
        ring.map_or(name, |(_, new)| *new)
    }
}

fn bits_of(bits: usize) -> Step {
    [bits & 1, bits >> 1 & 1, bits >> 2].map(|bit| bit as i64)
}

fn stepped(at: [u64; 3], step: Step) -> [u64; 3] {
    [0, 1, 2].map(|c| (at[c] as i64 + step[c]) as u64)
}

/// Grids beside each other, numbered one after the other; as [`join`](super::join()) puts meshes together where they have names.
pub struct Grids {
    list: Vec<(Option<String>, Grid)>,
    /// Nodes and cells before each, and of all.
    before: [Vec<u64>; 2],
}

/// A part of grids: a mesh without groups, and the numbers of its nodes and cells, ascending.
pub struct GridMesh {
    /// The cells, with all faces of the boundary if they were asked for.
    pub mesh: Mesh,
    /// Of each node in the whole.
    pub nodes: Vec<u64>,
    /// Of each cell in the whole.
    pub cells: Vec<u64>,
}

/// Where corners of a grid are: from the first to the last along each axis.
pub type CornerBox = [[u64; 3]; 2];

impl Grids {
    /// One grid without a name, or several with names.
    pub fn new(list: Vec<(Option<String>, Grid)>) -> Grids {
        let before = |count: fn(&Grid) -> u64| {
            let counts = list.iter().map(|(_, grid)| count(grid));
            let running = counts.scan(0, |sum, count| {
                *sum += count;
                Some(*sum)
            });
            [0].into_iter().chain(running).collect()
        };
        let before = [before(Grid::nodes), before(Grid::cell_count)];
        Grids { list, before }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Nodes and cells of all.
    pub fn sizes(&self) -> [u64; 2] {
        let last = |before: &Vec<u64>| before[self.len()];
        [last(&self.before[0]), last(&self.before[1])]
    }

    /// The grid of a node.
    pub fn of_node(&self, number: u64) -> usize {
        self.before[0].partition_point(|&before| before <= number) - 1
    }

    /// The grid of a cell.
    pub fn of_cell(&self, number: u64) -> usize {
        self.before[1].partition_point(|&before| before <= number) - 1
    }

    /// The groups that all cells of a grid are in.
    pub fn cell_groups(&self, k: usize) -> Vec<String> {
        let named = |name: &String| vec![name.clone(), format!("{name}.body")];
        self.list[k].0.as_ref().map_or(vec!["body".into()], named)
    }

    /// The place of a node, length.
    pub fn place(&self, number: u64) -> [f64; 3] {
        let k = self.of_node(number);
        let grid = &self.list[k].1;
        grid.place(grid.ends(number - self.before[0][k]))
    }

    /// The corners that a node is one of or lies between, and its grid.
    pub fn corners_of(&self, number: u64) -> (usize, CornerBox) {
        let k = self.of_node(number);
        let [a, b] = self.list[k].1.ends(number - self.before[0][k]);
        (k, [[0, 1, 2].map(|c| a[c].min(b[c])), [0, 1, 2].map(|c| a[c].max(b[c]))])
    }

    /// Appends the nodes of a cell, in the order of its kind.
    pub fn cell_nodes(&self, number: u64, nodes: &mut Vec<u64>) {
        let k = self.of_cell(number);
        let from = nodes.len();
        self.list[k].1.cell_nodes(number - self.before[1][k], nodes);
        nodes[from..].iter_mut().for_each(|node| *node += self.before[0][k]);
    }

    /// What each is made of.
    pub fn elements(&self) -> impl Iterator<Item = BlockElement> {
        self.list.iter().map(|(_, grid)| grid.element)
    }

    /// No fewer nodes than [`Self::boundary_cells`] have, nearly.
    pub fn boundary_nodes(&self) -> f64 {
        let of_grid = |(_, grid): &(Option<String>, Grid)| {
            let [all, inside]: [f64; 2] =
                [0.0, 2.0].map(|less| grid.cells.iter().map(|&n| (n as f64 - less).max(0.0)).product());
            let (nodes, outer): (f64, f64) = (grid.nodes() as f64, all - inside);
            // Two layers of nodes for one of cells.
            nodes.min(2.0 * nodes * outer / all)
        };
        self.list.iter().map(of_grid).sum()
    }

    /// All cells at the nodes of the boundary, and some beside them.
    pub fn boundary_cells(&self) -> Vec<u64> {
        let mut cells = Vec::new();
        self.list.iter().zip(&self.before[1]).for_each(|((_, grid), &first)| grid.boundary_cells(first, &mut cells));
        cells
    }

    /// The mesh of some cells, which ascend, without faces and groups.
    pub fn mesh(&self, cells: Vec<u64>) -> GridMesh {
        let of_grid = |k: usize| {
            let place = |number: u64| cells.partition_point(|&cell| cell < number);
            &cells[place(self.before[1][k])..place(self.before[1][k + 1])]
        };
        // The nodes of some cells that follow one another are few: each chunk puts its own in order, then looks them up once.
        let chunk = |k: usize, some: &[u64]| {
            let mut nodes = Vec::with_capacity(self.list[k].1.element.kind().nodes() * some.len());
            some.iter().for_each(|&cell| self.cell_nodes(cell, &mut nodes));
            let own = ascending(nodes.iter().copied());
            let place = |node: &u64| own.partition_point(|other| other < node) as u32;
            (nodes.iter().map(place).collect::<Vec<u32>>(), own)
        };
        let chunks = |k: usize| of_grid(k).par_chunks(CHUNK).map(|some| chunk(k, some)).collect::<Vec<_>>();
        let chunks: Vec<Vec<Chunk>> = (0..self.len()).map(chunks).collect();
        let mut nodes: Vec<u64> = chunks.iter().flatten().flat_map(|(_, own)| own.iter().copied()).collect();
        nodes.par_sort_unstable();
        nodes.dedup();
        let local = |(places, own): &Chunk| {
            let own: Vec<u32> = own.iter().map(|number| nodes.partition_point(|node| node < number) as u32).collect();
            places.iter().map(|&place| own[place as usize]).collect::<Vec<u32>>()
        };
        let block = |(k, chunks): (usize, &Vec<Chunk>)| Cells {
            kind: self.list[k].1.element.kind(),
            nodes: chunks.par_iter().flat_map_iter(local).collect(),
        };
        let blocks: Vec<Cells> = chunks.iter().enumerate().map(block).filter(|block| !block.is_empty()).collect();
        drop(chunks);
        let places = nodes.par_iter().map(|&number| self.place(number)).collect();
        let (arrays, groups, faces) = (MeshArrays::default(), Vec::new(), Vec::new());
        GridMesh { mesh: Mesh { nodes: places, cells: blocks, faces, groups, arrays }, nodes, cells }
    }

    /// The same with the faces that are at the boundary of the whole.
    pub fn mesh_with_faces(&self, cells: Vec<u64>) -> GridMesh {
        let GridMesh { mut mesh, nodes, cells } = self.mesh(cells);
        let of_cell = |(own, &number): (usize, &u64)| {
            let k = self.of_cell(number);
            let sides = self.list[k].1.sides(number - self.before[1][k]);
            sides.map(move |(local, _)| [own as u32, u32::from(local)])
        };
        let faces = cells.iter().enumerate().flat_map(of_cell);
        let face = |[own, local]: [u32; 2]| {
            let (kind, nodes) = mesh.cell(own as usize);
            Face::of_cell(kind, nodes, own, local as u8)
        };
        mesh.faces = faces.map(face).collect();
        GridMesh { mesh, nodes, cells }
    }

    /// The groups of the whole, as far as they are in a part: those of sides and of all cells.
    pub fn groups(&self, part: &GridMesh) -> Vec<Group> {
        let mut groups = Vec::new();
        for (k, (name, grid)) in self.list.iter().enumerate() {
            let first = part.cells.partition_point(|&cell| cell < self.before[1][k]) as u32;
            let end = part.cells.partition_point(|&cell| cell < self.before[1][k + 1]) as u32;
            let called = |group: &str| name.as_ref().map_or(group.to_string(), |name| format!("{name}.{group}"));
            let all = |name: String| Group { name, cells: (first..end).collect(), ..Group::default() };
            groups.extend(name.clone().map(all));
            let named = |side: usize| Group { name: called(grid.side_name(side)), ..Group::default() };
            let mut sides = [0, 1, 2, 3, 4, 5].map(named);
            for (number, face) in part.mesh.faces.iter().enumerate().filter(|(_, f)| (first..end).contains(&f.cell)) {
                let cell = part.cells[face.cell as usize] - self.before[1][k];
                let side = grid.sides(cell).find(|(local, _)| *local == face.local);
                side.into_iter().for_each(|(_, side)| sides[side].faces.push(number as u32));
            }
            groups.extend(sides);
            groups.push(all(called("body")));
        }
        groups
    }
}

/// Cells whose nodes a thread finds at a time.
const CHUNK: usize = 1 << 14;

/// The nodes of some cells by their places among those of the chunk, which ascend.
type Chunk = (Vec<u32>, Vec<u64>);

impl BlockElement {
    fn linear_kind(self) -> CellKind {
        self.kind().linear()
    }
}

#[cfg(test)]
mod tests {
    use super::super::block::tests::ELEMENTS;
    use super::super::{block, join, place, ring};
    use super::*;

    /// The whole by counting is that which is built from its cells.
    #[test]
    fn a_grid_has_the_numbers_places_and_faces_of_the_mesh_that_is_made_as_a_whole() {
        let turn = Turn { point: [0.1, 0.2, 0.3], axis: [0.0, 0.6, 0.8], degrees: 33.0 };
        for element in ELEMENTS {
            for cells in [[1, 1, 1], [2, 1, 3], [4, 3, 2], [1, 4, 5], [5, 2, 1]] {
                let (size, origin, grading) = ([3.0, 1.0, 0.5], [-1.0, 2.0, 7.0], [2.0, 1.0, 0.3]);
                let of_block = Block { size, cells, origin, grading, element };
                let mut expected = block(&of_block).unwrap();
                place(&mut expected, Some(&turn), [1.0, -2.0, 0.1]);
                let grid = Grid::of_block(&of_block, vec![(Some(turn), [1.0, -2.0, 0.1])]).unwrap();
                same(&Grids::new(vec![(None, grid)]), &expected);

                let of_ring = Ring { radii: [2.0, 5.0], height: 4.0, degrees: 120.0, cells, grading, element };
                let bent = |by: [f64; 3]| {
                    let mut mesh = ring(&of_ring).unwrap();
                    place(&mut mesh, None, by);
                    mesh
                };
                let parts = [("a", [0.0; 3]), ("long", [9.0, 0.0, 1.0]), ("lo", [9.0, 3.0, 1.0])];
                let joined = join(parts.map(|(name, by)| (name.to_string(), bent(by))).into());
                let grid = |by: [f64; 3]| Grid::of_ring(&of_ring, vec![(None, by)]).unwrap();
                same(&Grids::new(parts.map(|(name, by)| (Some(name.to_string()), grid(by))).into()), &joined);
            }
        }
    }

    fn same(grids: &Grids, expected: &Mesh) {
        let [nodes, cells] = grids.sizes();
        assert_eq!([nodes, cells], [expected.nodes.len() as u64, expected.cell_count() as u64]);
        let mut whole = grids.mesh_with_faces((0..cells).collect());
        assert!(whole.nodes.iter().copied().eq(0..nodes));
        whole.mesh.groups = grids.groups(&whole);
        assert_eq!(whole.mesh.groups, expected.groups);
        assert_eq!(&whole.mesh, expected);
        for group in &expected.groups {
            let of_all = (0..grids.len()).find(|&k| grids.cell_groups(k).contains(&group.name));
            let count = of_all.map_or(0, |k| grids.before[1][k + 1] - grids.before[1][k]);
            assert_eq!(count, group.cells.len() as u64, "{}", group.name);
        }
    }

    /// By their definition: cells with a node on the boundary.
    #[test]
    fn the_cells_at_the_boundary_are_found() {
        for element in ELEMENTS {
            let of_block = Block { size: [1.0; 3], cells: [5, 4, 6], origin: [0.0; 3], grading: [1.0; 3], element };
            let mesh = block(&of_block).unwrap();
            let grids = Grids::new(vec![(None, Grid::of_block(&of_block, Vec::new()).unwrap())]);
            let found = grids.boundary_cells();
            assert!(found.len() < mesh.cell_count() && found.is_sorted());
            let mut outer = vec![false; mesh.nodes.len()];
            mesh.faces.iter().flat_map(Face::nodes).for_each(|&v| outer[v as usize] = true);
            for (cell, (_, nodes)) in mesh.cell_iter().enumerate() {
                let at_boundary = nodes.iter().any(|&v| outer[v as usize]);
                assert!(!at_boundary || found.binary_search(&(cell as u64)).is_ok());
            }
        }
    }

    /// Numbers beyond those of 32 bits: the last node of the whole is where its last corners are.
    #[test]
    fn a_grid_with_more_nodes_than_32_bits_count_is_numbered() {
        for element in [BlockElement::Tet10Six, BlockElement::Hex8] {
            let of_block =
                Block { size: [1.0; 3], cells: [1999, 1499, 1599], origin: [0.0; 3], grading: [1.0; 3], element };
            let grids = Grids::new(vec![(None, Grid::of_block(&of_block, Vec::new()).unwrap())]);
            let [nodes, cells] = grids.sizes();
            assert!(nodes as f64 == of_block.nodes() && nodes > u64::from(u32::MAX));
            let last = grids.mesh(vec![cells - 1]);
            assert!(last.nodes.iter().all(|&v| v < nodes));
            assert!(element == BlockElement::Hex8 || last.nodes.contains(&(nodes - 1)));
            assert!(last.mesh.volume() * of_block.cells.iter().product::<usize>() as f64 > 0.1);
        }
    }
}
