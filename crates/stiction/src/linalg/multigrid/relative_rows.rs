use super::blocks::{Block, Blocks, Row};
use super::dense::{add_product, add_transpose_product};
use super::packed::Packed;
use super::relative_coordinates::{RelativeCoordinates, places};

/// The rows of `Tᵀ A T` with `x = T x'`, each computed where it is asked for: together they are longer than those of `A`.
///
/// Those near the changed nodes and near the columns of their rows of `D` are not those of `A`.
pub(super) struct RelativeRows<'a> {
    a: &'a Blocks<3, 3>,
    relative: &'a RelativeCoordinates,
    /// The rows of `A T` that are not those of `A`, and the place of each row among them, `u32::MAX` of the others.
    right: Blocks<3, 3>,
    at: Vec<u32>,
    /// `D` by columns: the rows with an entry in each, and its place.
    start: Vec<usize>,
    entry: Vec<(u32, u32)>,
}

impl<'a> RelativeRows<'a> {
    pub(super) fn new(a: &'a Blocks<3, 3>, relative: &'a RelativeCoordinates) -> Self {
        let d = &relative.d;
        let place = places(&relative.nodes, d.cols);
        let coupled = |j: u32| {
            let i = place[j as usize];
            (i != u32::MAX && !d.row(i as usize).0.is_empty()).then_some(i as usize)
        };
        // The column of a changed node contributes to the columns of its row of D as well.
        let changed: Vec<u32> =
            (0..a.rows as u32).filter(|&i| a.row(i as usize).0.iter().any(|&j| coupled(j).is_some())).collect();
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            for &j in a.row(changed[t] as usize).0 {
                name(j);
                coupled(j).into_iter().for_each(|i| d.row(i).0.iter().for_each(|&k| name(k)));
            }
        };
        let right: Blocks<3, 3> = Blocks::from_rows(
            changed.len(),
            a.cols,
            reached,
            #[inline(always)]
            |t, row| {
                for (j, block) in a.entries_of(changed[t] as usize) {
                    let own = row.at(j);
                    own.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(x, v)| *x += v);
                    if let Some(i) = coupled(j) {
                        let minus = negative(block);
                        d.entries_of(i).for_each(|(k, d)| add_product(&minus, d, row.at(k)));
                    }
                }
            },
        );
        let at = places(&changed, a.rows);
        let (start, entry) = d.by_columns(d.rows);
        RelativeRows { a, relative, right, at, start, entry }
    }

    /// Row `i` of `A T`.
    fn right(&self, i: u32) -> (&[u32], &[Block<3, 3>]) {
        match self.at[i as usize] {
            u32::MAX => self.a.row(i as usize),
            t => self.right.row(t as usize),
        }
    }

    /// The changed nodes that are measured from node `i`, and the places of their entries of `D`.
    fn followers(&self, i: usize) -> &[(u32, u32)] {
        &self.entry[self.start[i]..self.start[i + 1]]
    }

    /// Names the columns of row `i`.
    fn names(&self, i: usize, name: &mut dyn FnMut(u32)) {
        self.right(i as u32).0.iter().for_each(|&j| name(j));
        for &(t, _) in self.followers(i) {
            self.right(self.relative.nodes[t as usize]).0.iter().for_each(|&j| name(j));
        }
    }

    /// Adds the blocks of row `i`: of `Tᵀ`, the rows of the changed nodes are subtracted from those of the columns of `D`.
    #[inline(always)]
    fn fill(&self, i: usize, row: &mut Row<'_, 3, 3>) {
        let (columns, blocks) = self.right(i as u32);
        columns.iter().zip(blocks).for_each(|(&j, block)| *row.at(j) = *block);
        for &(t, place) in self.followers(i) {
            let minus = negative(&self.relative.d.value[place as usize]);
            let (columns, blocks) = self.right(self.relative.nodes[t as usize]);
            columns.iter().zip(blocks).for_each(|(&j, block)| add_transpose_product(&minus, block, row.at(j)));
        }
    }

    /// Whether row `i` may be another than that of `A`.
    pub(super) fn is_changed(&self, i: usize) -> bool {
        self.at[i] != u32::MAX || !self.followers(i).is_empty()
    }

    /// The rows of these nodes.
    pub(super) fn of(&self, nodes: &[u32]) -> Blocks<3, 3> {
        Blocks::from_rows(
            nodes.len(),
            self.a.cols,
            |t, name| self.names(nodes[t] as usize, name),
            #[inline(always)]
            |t, row| self.fill(nodes[t] as usize, row),
        )
    }

    /// The nodes whose rows are not those of `A`, and these rows.
    pub(super) fn changed(&self) -> (Vec<u32>, Blocks<3, 3>) {
        let nodes: Vec<u32> = (0..self.a.rows as u32).filter(|&i| self.is_changed(i as usize)).collect();
        let rows = self.of(&nodes);
        (nodes, rows)
    }

    /// The changed ones among these nodes, in ascending order, and their rows.
    pub(super) fn changed_of(&self, nodes: &[u32]) -> (Vec<u32>, Blocks<3, 3>) {
        let mut nodes: Vec<u32> = nodes.iter().copied().filter(|&i| self.is_changed(i as usize)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let rows = self.of(&nodes);
        (nodes, rows)
    }

    /// All rows in single precision.
    pub(super) fn packed(&self) -> Packed<3, 3> {
        Packed::from_rows(
            self.a.rows,
            self.a.cols,
            |i, name| self.names(i, name),
            #[inline(always)]
            |i, row| self.fill(i, row),
        )
    }

    /// The diagonal block of row `i`.
    pub(super) fn diagonal(&self, i: usize) -> Block<3, 3> {
        let mut sum = diagonal(self.right(i as u32), i);
        for &(t, place) in self.followers(i) {
            let right = diagonal(self.right(self.relative.nodes[t as usize]), i);
            add_transpose_product(&negative(&self.relative.d.value[place as usize]), &right, &mut sum);
        }
        sum
    }
}

/// The block at column `i` of a row; zero where none is stored.
pub(super) fn diagonal((columns, blocks): (&[u32], &[Block<3, 3>]), i: usize) -> Block<3, 3> {
    columns.binary_search(&(i as u32)).map_or([[0.0; 3]; 3], |place| blocks[place])
}

fn negative(block: &Block<3, 3>) -> Block<3, 3> {
    block.map(|r| r.map(|v| -v))
}
