use std::borrow::Cow;

use super::aggregate::{in_lines, marks, neighbours};
use super::blocks::Blocks;
use super::distance::{FAR, near, square_distance};
use super::quadratic::NO_NODE;
use crate::ranks::Halo;

/// Middles of edges along a plate whose corners hang together in short lines only, those through the plate. They join the line at
/// one end of their edge.
///
/// As nodes like others they lead aggregates from line to line, since from a line to a middle it is half as far as to the next line:
/// aggregates are then up to two cells wide, and plates of hexahedra (20 nodes, 1:50) take 69 to 106 cycles; they take 26 to 48 so.
#[derive(Debug, Default)]
pub(super) struct Middles {
    /// For each node of this rank that joins a line, the ends of its edge that are here; empty if none does.
    ends: Vec<[u32; 2]>,
    /// Whether each node and each ghost joins a line.
    joins: Vec<bool>,
}

impl Middles {
    /// From the ends of the edge of each node that is a middle, [`NO_NODE`] for those that are elsewhere or prescribed, and the blocks
    /// between strongly coupled nodes at these places.
    pub(super) fn new<const R: usize>(
        a: &Blocks<R, R>,
        halo: &Halo,
        place: &[[f64; 3]],
        strong: &[bool],
        ends: Option<&[[u32; 2]]>,
    ) -> Middles {
        let Some(ends) = ends else { return Middles::default() };
        let known = |v: usize| ends.get(v).into_iter().flatten().copied().filter(|&end| end != NO_NODE);
        let middles = Middles::of(halo, |v| known(v).next().is_some(), |v| ends[v]);
        if middles.joins.is_empty() {
            return middles;
        }
        let (start, neighbour) = neighbours(a, &near(a, halo, place, &middles.between_others(a, strong)));
        let in_lines = in_lines(&start, &neighbour, halo.total());
        let joins = |v: usize| middles.joins[v] && known(v).all(|end| in_lines[end as usize]);
        Middles::of(halo, joins, |v| ends[v])
    }

    fn of(halo: &Halo, joins: impl Fn(usize) -> bool, ends: impl Fn(usize) -> [u32; 2]) -> Middles {
        let own: Vec<u32> = (0..halo.own()).map(|v| u32::from(joins(v))).collect();
        let joins: Vec<bool> = halo.extended(&own).iter().map(|&joins| joins > 0).collect();
        if !halo.any(joins.contains(&true)) {
            return Middles::default();
        }
        let ends = (0..halo.own()).map(|v| if joins[v] { ends(v) } else { [NO_NODE; 2] }).collect();
        Middles { ends, joins }
    }

    /// The strong blocks between other nodes.
    pub(super) fn between_others<'s, const R: usize>(&self, a: &Blocks<R, R>, strong: &'s [bool]) -> Cow<'s, [bool]> {
        if self.joins.is_empty() {
            return Cow::Borrowed(strong);
        }
        Cow::Owned(marks(a, |i, at| strong[at] && !self.joins[i] && !self.joins[a.column[at] as usize]))
    }

    /// Each after the end whose aggregate `of` it joins. It is the one with the lower number: all middles between two lines join the same one.
    pub(super) fn after_ends(&self, of: &[u32]) -> Vec<Vec<u32>> {
        let after = |(v, ends): (usize, &[u32; 2])| {
            let known = ends.iter().filter(|&&end| end != NO_NODE);
            known.min_by_key(|&&end| of[end as usize]).map(|&end| vec![end, v as u32])
        };
        self.ends.iter().enumerate().filter_map(after).collect()
    }

    /// Adds the blocks by which they reach aggregates: those of corners that are at most [`FAR`] times as far as the ends of their
    /// edge. Reaching further fills the coarse matrix, to 1.5 times the entries of the finest one, and saves no cycle.
    pub(super) fn reach<const R: usize>(
        &self,
        a: &Blocks<R, R>,
        place: &[[f64; 3]],
        strong: &[bool],
        kept: Vec<bool>,
    ) -> Vec<bool> {
        if self.joins.is_empty() {
            return kept;
        }
        let half = |i: usize| {
            let known = self.ends[i].iter().filter(|&&end| end != NO_NODE);
            known.map(|&end| square_distance(place, i, end)).fold(0.0, f64::max)
        };
        marks(a, |i, at| {
            let j = a.column[at];
            let reaches = || strong[at] && !self.joins[j as usize];
            kept[at] || self.joins[i] && reaches() && square_distance(place, i, j) <= FAR.powi(2) * half(i)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Threshold;
    use super::super::coarsen::coarsen;
    use super::super::dense::add_product;
    use super::super::tests::lattice;
    use super::*;

    /// A plate of two layers of nodes, every other line through it a middle between its neighbours: lines of corners are further apart than the
    /// plate is thick, those of middles are not.
    #[test]
    fn middles_join_a_line_through_a_plate_and_leave_its_width_to_aggregates() {
        let size = [41, 41, 2];
        let (mut a, kernel) = lattice(size, [1.04, 1.04, 1.0]);
        // Without the supports of the lattice no motion has forces, and the prolongation represents all of them exactly.
        for v in 0..a.rows {
            let mut support = [[0.0; 3]; 3];
            for (_, block) in a.entries_of(v) {
                support.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(sum, x)| *sum += x);
            }
            let own = (a.start[v]..a.start[v + 1]).find(|&at| a.column[at] as usize == v).unwrap();
            a.value[own].iter_mut().flatten().zip(support.iter().flatten()).for_each(|(x, sum)| *x -= sum);
        }
        let at = |[i, j, k]: [usize; 3]| ((i * size[1] + j) * size[2] + k) as u32;
        let ends_of = |v: usize| {
            let x = [v / (size[1] * size[2]), v / size[2] % size[1], v % size[2]];
            let end = |step: usize| at([0, 1, 2].map(|d| if d < 2 && x[d] % 2 == 1 { x[d] + step - 1 } else { x[d] }));
            if x[0] % 2 + x[1] % 2 == 0 { [NO_NODE; 2] } else { [end(0), end(2)] }
        };
        let ends: Vec<[u32; 2]> = (0..a.rows).map(ends_of).collect();
        let halo = Halo::alone(a.rows);
        let coarse = |ends| coarsen(&a, &halo, &kernel, Threshold::STRONG, &[], ends, &[]).unwrap().unwrap();
        let (lines, wide) = (coarse(Some(&ends)), coarse(None));
        assert_eq!(lines.matrix.rows, 21 * 21);
        assert!(wide.matrix.rows < 21 * 21 * 2 / 3, "{}", wide.matrix.rows);
        // Middles reach the lines at both ends of their edge, so that a line is coupled with the eight around it.
        assert!(lines.matrix.value.len() <= 9 * 21 * 21, "{}", lines.matrix.value.len());
        for v in 0..a.rows {
            let mut motions = [[0.0; 6]; 3];
            lines
                .prolongation
                .entries_of(v)
                .for_each(|(g, block)| add_product(block, &lines.kernel[g as usize], &mut motions));
            for (found, expected) in motions.iter().flatten().zip(kernel[v].iter().flatten()) {
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }
}
