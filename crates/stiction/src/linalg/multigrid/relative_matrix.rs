use std::borrow::Cow;

use super::RelativeCoordinates;
use super::blocks::{Block, Blocks, rows_at};
use super::packed::Packed;
use super::relative_coordinates::places;
use super::relative_rows::{RelativeRows, diagonal};
use super::smoother::Level;
use crate::ranks::Halo;

/// The place of a row that is not that of `A` and not kept.
const NOT_KEPT: u32 = u32::MAX - 1;

/// A matrix `A` in relative coordinates: `Tᵀ A T`. Without any it is `A`.
///
/// Products take the way over the displacements. Forms of quadratic contact couple the nodes of one body with so many of the
/// other that the matrix has more than twice the entries of `A`.
#[derive(Debug)]
pub(crate) struct RelativeMatrix {
    a: Blocks<3, 3>,
    /// How the nodes are divided among ranks; the rows are those of this rank.
    pub halo: Halo,
    pub relative: Option<RelativeCoordinates>,
    changed: ChangedRows,
}

/// The rows that are not those of `A`, and the place of each row among them, `u32::MAX` for the others.
#[derive(Debug, Clone)]
struct ChangedRows {
    rows: Blocks<3, 3>,
    at: Vec<u32>,
}

impl ChangedRows {
    fn row<'a>(&'a self, a: &'a Blocks<3, 3>, i: usize) -> (&'a [u32], &'a [Block<3, 3>]) {
        match self.at[i] {
            u32::MAX => a.row(i),
            place => self.rows.row(place as usize),
        }
    }
}

/// All rows of a matrix, also those that it does not keep.
pub(crate) struct AllRows<'a> {
    a: &'a Blocks<3, 3>,
    changed: Cow<'a, ChangedRows>,
}

impl AllRows<'_> {
    /// Column and block of every place in row `i`.
    pub(crate) fn entries_of(&self, i: usize) -> impl Iterator<Item = (u32, &Block<3, 3>)> {
        let (columns, blocks) = self.changed.row(self.a, i);
        columns.iter().copied().zip(blocks)
    }

    /// The diagonal block of row `i`; zero where none is stored.
    pub(crate) fn diagonal(&self, i: usize) -> Block<3, 3> {
        diagonal(self.changed.row(self.a, i), i)
    }
}

impl RelativeMatrix {
    /// Of all nodes. The rows that are kept are those of `A` and of the nodes that are relative to others: products do without the
    /// rest, and those of nodes that others are measured from are the longest.
    pub(crate) fn new(a: Blocks<3, 3>, relative: Option<RelativeCoordinates>) -> Self {
        let halo = Halo::alone(a.rows);
        let (mut at, mut rows) = (vec![u32::MAX; a.rows], Blocks::default());
        if let Some(relative) = &relative {
            let all = RelativeRows::new(&a, relative);
            (0..a.rows).filter(|&i| all.is_changed(i)).for_each(|i| at[i] = NOT_KEPT);
            let kept;
            (kept, rows) = all.changed_of(&relative.nodes);
            kept.iter().enumerate().for_each(|(t, &i)| at[i as usize] = t as u32);
        }
        RelativeMatrix { a, halo, relative, changed: ChangedRows { rows, at } }
    }

    /// Of one rank: `a` has rows for its nodes, for the ghosts of `halo` and for further nodes that are here, complete at the own
    /// ones and at those measured from them. The rows that are kept are those of this rank; with relative coordinates too they reach
    /// no further than the ghosts.
    pub(crate) fn divided(a: Blocks<3, 3>, halo: Halo, relative: Option<RelativeCoordinates>) -> Self {
        let (own, here) = (halo.own(), halo.len());
        let (mut changed, rows) =
            relative.as_ref().map(|relative| RelativeRows::new(&a, relative).changed()).unwrap_or_default();
        changed.truncate(changed.partition_point(|&i| (i as usize) < own));
        let rows = rows.truncated(changed.len(), here);
        let (at, a) = (places(&changed, own), a.truncated(own, here));
        RelativeMatrix { a, halo, relative, changed: ChangedRows { rows, at } }
    }

    /// `A` itself.
    pub(super) fn of_displacements(&self) -> &Blocks<3, 3> {
        &self.a
    }

    /// Number of nodes of this rank.
    pub(crate) fn len(&self) -> usize {
        self.a.rows
    }

    /// What computes the rows that are not kept, if there are any.
    fn others(&self) -> Option<RelativeRows<'_>> {
        let relative = self.relative.as_ref().filter(|_| self.changed.at.contains(&NOT_KEPT))?;
        Some(RelativeRows::new(&self.a, relative))
    }

    /// All rows in double precision; those that are not kept are computed.
    pub(crate) fn all_rows(&self) -> AllRows<'_> {
        let changed = match self.others().map(|others| others.changed()) {
            Some((changed, rows)) => Cow::Owned(ChangedRows { rows, at: places(&changed, self.a.rows) }),
            None => Cow::Borrowed(&self.changed),
        };
        AllRows { a: &self.a, changed }
    }

    /// The finest level: all rows in single precision, the diagonal blocks from double precision.
    pub(super) fn finest_level(&self) -> Level<3, 4> {
        match self.others() {
            Some(others) => Level::of(others.packed(), self.halo.clone(), |i| others.diagonal(i)),
            None => Level::of(Packed::of_rows(self.len(), |i| self.row(i)), self.halo.clone(), |i| self.diagonal(i)),
        }
    }

    /// The rows of these nodes in double precision, in this order.
    pub(super) fn rows_at(&self, nodes: &[u32]) -> Blocks<3, 3> {
        match self.others() {
            Some(others) => others.of(nodes),
            None => rows_at(nodes, self.a.cols, |v| self.row(v as usize)),
        }
    }

    /// Columns and blocks of row `i`, one that is kept.
    pub(crate) fn row(&self, i: usize) -> (&[u32], &[Block<3, 3>]) {
        self.changed.row(&self.a, i)
    }

    /// Column and block of every place in row `i`.
    pub(crate) fn entries_of(&self, i: usize) -> impl Iterator<Item = (u32, &Block<3, 3>)> {
        let (columns, blocks) = self.row(i);
        columns.iter().copied().zip(blocks)
    }

    /// The diagonal block of row `i`; zero where none is stored.
    pub(crate) fn diagonal(&self, i: usize) -> Block<3, 3> {
        diagonal(self.row(i), i)
    }

    /// `Tᵀ A T x`, from and at the nodes of this rank.
    pub(crate) fn times(&self, x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Some(relative) = self.relative.as_ref().filter(|_| self.halo.is_alone()) else {
            return self.times_rows(&self.halo.extended(x));
        };
        let mut u = x.to_vec();
        relative.to_absolute(&mut u);
        let mut forces = self.a.times(&u);
        relative.forces(&mut forces);
        forces
    }

    /// The sum of the squares of what the nodes of this rank contribute to their own forces in [`times`](Self::times).
    pub(crate) fn squares_of_terms(&self, x: &[[f64; 3]]) -> f64 {
        let mut u = x.to_vec();
        if let Some(relative) = self.relative.as_ref().filter(|_| self.halo.is_alone()) {
            relative.to_absolute(&mut u);
        }
        let of_node = |(i, u): (usize, &[f64; 3])| {
            let stiffness = self.a.diagonal(i);
            (0..3).map(|c| (stiffness[c][c] * u[c]).powi(2)).sum::<f64>()
        };
        u.iter().enumerate().map(of_node).sum()
    }

    /// The product by rows, which takes no exchange but that of `x`.
    fn times_rows(&self, x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut y = self.a.times(x);
        let ChangedRows { rows, at } = &self.changed;
        if rows.rows > 0 {
            let changed = rows.times(x);
            let places = at.iter().enumerate().filter(|(_, at)| **at != u32::MAX);
            places.for_each(|(i, &at)| y[i] = changed[at as usize]);
        }
        y
    }
}
