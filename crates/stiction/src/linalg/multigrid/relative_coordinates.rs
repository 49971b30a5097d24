use rayon::prelude::*;

use super::blocks::{Block, Blocks};
use super::coarsen::Coarser;
use super::cycles::{Cycle, Entries, Link, order, product, rows_of_cycle, summed};
use super::dense::{add_product, add_transpose_product};
use super::divided_product::{moved, widened};
use super::relative_matrix::RelativeMatrix;
use super::truncation::contact_ghosts;

/// A change of unknowns, `x' = x + C x` at some nodes and the same elsewhere, that makes constraints on differences
/// between nodes constraints on single unknowns: with relative displacements at the nodes of one side of an interface
/// (Wohlmuth & Krause 2003, for dual Lagrange multipliers) contact between bodies is as local as contact with an
/// obstacle.
///
/// A node may be relative to one that is itself relative, as the middle of a quadratic edge is to its ends and these to
/// the other body, and in a cycle that fades to itself, as nodes beside the border of two contacts are: `x = x' - D x'` with
/// `D = (I + C)⁻¹ C`.
#[derive(Debug, Clone)]
pub(crate) struct RelativeCoordinates {
    /// The nodes with relative displacements.
    pub nodes: Vec<u32>,
    /// `C`: a row for each of `nodes`, a column for each node of the mesh.
    c: Blocks<3, 3>,
    /// `D`, in the same form.
    pub(super) d: Blocks<3, 3>,
    /// Places in `nodes`, each before those of the nodes it is relative to.
    order: Vec<Link>,
}

/// Most entries of `D` over those of `C` and one a row; middles of quadratic edges have three times as many.
const MOST_FILL: usize = 8;

impl RelativeCoordinates {
    /// `C` from its rows, each a list of columns and blocks; `None` if a node is relative to itself in a cycle that does not fade, or if
    /// chains fill `D`.
    pub(crate) fn new(nodes: Vec<u32>, rows: &[Entries], count: usize) -> Option<RelativeCoordinates> {
        let place = places(&nodes, count);
        let order = order(&place, rows)?;
        let mut most = MOST_FILL * rows.iter().map(|row| row.len() + 1).sum::<usize>();
        let mut inverse: Vec<Entries> = vec![Vec::new(); rows.len()];
        // The row of `D` of what a row of `C` names, whose own rows of `D` are known.
        let row = |named: Entries, inverse: &[Entries]| {
            let mut row = named.clone();
            for (k, block) in &named {
                let Some(relative) = inverse.get(place[*k as usize] as usize) else { continue };
                row.extend(product(&block.map(|r| r.map(|v| -v)), relative));
            }
            summed(row)
        };
        for link in order.iter().rev() {
            match link {
                Link::Row(i) => inverse[*i as usize] = row(rows[*i as usize].clone(), &inverse),
                Link::Cycle(cycle) => {
                    let of_cycle = rows_of_cycle(cycle, (&nodes, &place), rows, |named| row(named, &inverse));
                    cycle.rows.iter().zip(of_cycle).for_each(|(&i, row)| inverse[i as usize] = row);
                }
            }
            let added = |i: &u32| inverse[*i as usize].len();
            let added = match link {
                Link::Row(i) => added(i),
                Link::Cycle(cycle) => cycle.rows.iter().map(added).sum(),
            };
            most = most.checked_sub(added)?;
        }
        let blocks = |rows: &[Entries]| {
            let named = |i: usize, name: &mut dyn FnMut(u32)| rows[i].iter().for_each(|&(k, _)| name(k));
            Blocks::from_rows(nodes.len(), count, named, |i, row| {
                rows[i].iter().for_each(|(k, block)| *row.at(*k) = *block);
            })
        };
        let (c, d) = (blocks(rows), blocks(&inverse));
        Some(RelativeCoordinates { nodes, c, d, order })
    }

    /// The columns and blocks of the rows of `C` of these nodes, by their places; none of a node that is not relative.
    pub(super) fn rows_of<'a>(
        &'a self,
        nodes: &'a [u32],
    ) -> impl Fn(usize) -> Box<dyn Iterator<Item = (u32, &'a Block<3, 3>)> + 'a> + 'a {
        let place = places(&self.nodes, self.c.cols);
        move |i| match place[nodes[i] as usize] {
            u32::MAX => Box::new(std::iter::empty()),
            k => Box::new(self.c.entries_of(k as usize)),
        }
    }

    /// `x' = x + C x`.
    pub(crate) fn to_relative(&self, x: &mut [[f64; 3]]) {
        for link in &self.order {
            match link {
                Link::Row(i) => self.displace(*i, x, 1.0),
                Link::Cycle(cycle) => {
                    let all: Vec<[f64; 3]> = cycle.rows.iter().map(|&i| self.times(i, x)).collect();
                    self.of_cycle(cycle).zip(all).for_each(|(v, c)| add(&mut x[v], 1.0, c));
                }
            }
        }
    }

    /// `x = x' - D x'`, which is `x' - C x` from the ends of the chains on.
    pub(crate) fn to_absolute(&self, x: &mut [[f64; 3]]) {
        for link in self.order.iter().rev() {
            match link {
                Link::Row(i) => self.displace(*i, x, -1.0),
                Link::Cycle(cycle) => {
                    // `x' - C x` with what is known alone, and then the inverse.
                    let mut left: Vec<[f64; 3]> = self.of_cycle(cycle).map(|v| std::mem::take(&mut x[v])).collect();
                    for (left, &i) in left.iter_mut().zip(&cycle.rows) {
                        add(left, -1.0, self.times(i, x));
                    }
                    for (v, row) in self.of_cycle(cycle).zip(&cycle.inverse) {
                        row.iter().for_each(|(k, block)| add(&mut x[v], 1.0, times(block, &left[*k as usize])));
                    }
                }
            }
        }
    }

    /// Forces that do the same work on the relative displacements, `f' = f - Dᵀ f`, which is `f - Cᵀ f'`.
    pub(crate) fn forces(&self, f: &mut [[f64; 3]]) {
        for link in &self.order {
            match link {
                Link::Row(i) => {
                    let own = f[self.nodes[*i as usize] as usize];
                    self.take_off(*i, own, f);
                }
                Link::Cycle(cycle) => {
                    let given: Vec<[f64; 3]> = self.of_cycle(cycle).map(|v| f[v]).collect();
                    let mut own = vec![[0.0; 3]; given.len()];
                    for (row, given) in cycle.inverse.iter().zip(&given) {
                        row.iter()
                            .for_each(|(k, block)| add(&mut own[*k as usize], 1.0, transpose_times(block, given)));
                    }
                    cycle.rows.iter().zip(&own).for_each(|(&i, own)| self.take_off(i, *own, f));
                    self.of_cycle(cycle).zip(own).for_each(|(v, own)| f[v] = own);
                }
            }
        }
    }

    fn of_cycle<'a>(&'a self, cycle: &'a Cycle) -> impl Iterator<Item = usize> + 'a {
        cycle.rows.iter().map(|&i| self.nodes[i as usize] as usize)
    }

    fn displace(&self, i: u32, x: &mut [[f64; 3]], sign: f64) {
        for (k, c) in self.c.entries_of(i as usize) {
            let other = x[k as usize];
            add(&mut x[self.nodes[i as usize] as usize], sign, times(c, &other));
        }
    }

    /// `C x` at the node of a row.
    fn times(&self, i: u32, x: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (k, c) in self.c.entries_of(i as usize) {
            add(&mut sum, 1.0, times(c, &x[k as usize]));
        }
        sum
    }

    /// `f -= Cᵀ own` of a row.
    fn take_off(&self, i: u32, own: [f64; 3], f: &mut [[f64; 3]]) {
        for (k, c) in self.c.entries_of(i as usize) {
            add(&mut f[k as usize], -1.0, transpose_times(c, &own));
        }
    }

    /// Transforms a coarsening step for the displacements into one for the relative displacements, whose matrix is `matrix`.
    /// `contact` are the nodes of the rows of `A P`: on one rank all that are relative, on several those of this rank.
    pub(super) fn transform_step<const C: usize>(
        &self,
        mut step: Coarser<3, C>,
        matrix: &RelativeMatrix,
        contact: &[u32],
    ) -> Coarser<3, C> {
        self.transform_prolongation(&mut step.prolongation);
        if matrix.halo.is_alone() {
            step.a_times_p = self.transpose_own(&step.a_times_p);
        } else {
            step = self.transpose_divided(step, matrix, contact);
        }
        let more = self.more(matrix, contact, &step);
        if matrix.halo.is_alone() {
            widen(&mut step.matrix, &more);
            return step;
        }
        widened(step, &more)
    }

    /// `Tᵀ X` on the rows of the changed nodes alone, which `x` has in their order.
    fn transpose_own<const C: usize>(&self, x: &Blocks<3, C>) -> Blocks<3, C> {
        let place = places(&self.nodes, self.d.cols);
        let mut taken: Vec<Vec<(usize, &Block<3, 3>)>> = vec![Vec::new(); self.nodes.len()];
        for i in 0..self.nodes.len() {
            for (k, d) in self.d.entries_of(i).filter(|(k, _)| place[*k as usize] != u32::MAX) {
                taken[place[k as usize] as usize].push((i, d));
            }
        }
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            let rows = taken[t].iter().map(|entry| entry.0).chain([t]);
            rows.for_each(|i| x.row(i).0.iter().for_each(|&j| name(j)));
        };
        Blocks::from_rows(
            x.rows,
            x.cols,
            reached,
            #[inline(always)]
            |t, row| {
                x.entries_of(t).for_each(|(j, block)| *row.at(j) = *block);
                for &(i, d) in &taken[t] {
                    let minus = d.map(|r| r.map(|v| -v));
                    for (j, block) in x.entries_of(i) {
                        add_transpose_product(&minus, block, row.at(j));
                    }
                }
            },
        )
    }

    /// The same of the rows of `A P` of a step whose nodes are divided among ranks; `contact` are those of this rank.
    fn transpose_divided<const C: usize>(
        &self,
        step: Coarser<3, C>,
        matrix: &RelativeMatrix,
        contact: &[u32],
    ) -> Coarser<3, C> {
        let (halo, ghosts) = contact_ghosts(matrix, contact);
        let (at, place) = (places(&[contact, &ghosts].concat(), self.d.cols), places(&self.nodes, self.d.cols));
        let mut taken: Vec<Vec<(usize, &Block<3, 3>)>> = vec![Vec::new(); halo.len()];
        for (t, &v) in contact.iter().enumerate() {
            let others = self.d.entries_of(place[v as usize] as usize);
            for (k, d) in others.filter(|(k, _)| at[*k as usize] != u32::MAX) {
                taken[at[k as usize] as usize].push((t, d));
            }
        }
        if !halo.any(taken.iter().any(|rows| !rows.is_empty())) {
            return step;
        }
        let x = &step.a_times_p;
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            taken[t].iter().for_each(|&(i, _)| x.row(i).0.iter().for_each(|&j| name(j)));
        };
        let rows = Blocks::from_rows(halo.len(), x.cols, reached, |t, row| {
            for &(i, d) in &taken[t] {
                let minus = d.map(|r| r.map(|v| -v));
                x.entries_of(i).for_each(|(j, block)| add_transpose_product(&minus, block, row.at(j)));
            }
        });
        moved(step, &halo, &rows)
    }

    /// Transforms a prolongation into one to relative displacements, `T⁻¹ P`.
    fn transform_prolongation<const C: usize>(&self, p: &mut Blocks<3, C>) {
        // Of nodes of other ranks that are no ghosts the prolongation has no rows.
        let is_here = |&i: &usize| !self.c.row(i).0.is_empty() && (self.nodes[i] as usize) < p.rows;
        let mut coupled: Vec<usize> = (0..self.nodes.len()).filter(is_here).collect();
        coupled.sort_unstable_by_key(|&i| self.nodes[i]);
        let nodes: Vec<u32> = coupled.iter().map(|&i| self.nodes[i]).collect();
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            p.row(nodes[t] as usize).0.iter().for_each(|&j| name(j));
            self.c.row(coupled[t]).0.iter().for_each(|&k| p.row(k as usize).0.iter().for_each(|&j| name(j)));
        };
        let rows = Blocks::from_rows(
            nodes.len(),
            p.cols,
            reached,
            #[inline(always)]
            |t, row| {
                p.entries_of(nodes[t] as usize).for_each(|(j, block)| *row.at(j) = *block);
                for (k, c) in self.c.entries_of(coupled[t]) {
                    for (j, block) in p.entries_of(k as usize) {
                        add_product(c, block, row.at(j));
                    }
                }
            },
        );
        p.replace_rows(&nodes, &rows);
    }

    /// The columns by which the rows of the coarse matrix of a transformed step are extended, for the entries that constraints at
    /// the `contact` nodes will add: aggregates of both sides become neighbours.
    fn more<const C: usize>(&self, a: &RelativeMatrix, contact: &[u32], step: &Coarser<3, C>) -> Vec<Vec<u32>> {
        let Coarser { prolongation: p, a_times_p, halo, .. } = step;
        let place = places(&self.nodes, self.d.cols);
        let mut more: Vec<Vec<u32>> = vec![Vec::new(); halo.len()];
        let mut near = Vec::new();
        for (t, &v) in contact.iter().enumerate() {
            near.clear();
            near.extend_from_slice(a_times_p.row(t).0);
            for &w in a.row(v as usize).0.iter().filter(|&&w| place[w as usize] != u32::MAX) {
                near.extend_from_slice(p.row(w as usize).0);
            }
            near.sort_unstable();
            near.dedup();
            for &j in p.row(v as usize).0 {
                more[j as usize].extend_from_slice(&near);
                near.iter().for_each(|&k| more[k as usize].push(j));
            }
        }
        more.par_iter_mut().for_each(|row| {
            row.sort_unstable();
            row.dedup();
        });
        more
    }
}

/// Extends the pattern of a matrix by `more` columns of each row.
fn widen<const C: usize>(m: &mut Blocks<C, C>, more: &[Vec<u32>]) {
    let wider: Vec<u32> = (0..m.rows as u32).filter(|&i| !more[i as usize].is_empty()).collect();
    let named = |t: usize, name: &mut dyn FnMut(u32)| {
        let i = wider[t] as usize;
        m.row(i).0.iter().chain(&more[i]).for_each(|&j| name(j));
    };
    let rows = Blocks::from_rows(wider.len(), m.cols, named, |t, row| {
        m.entries_of(wider[t] as usize).for_each(|(j, block)| *row.at(j) = *block);
    });
    m.replace_rows(&wider, &rows);
}

/// Place of each of `count` nodes among `nodes`, `u32::MAX` for the others.
pub(super) fn places(nodes: &[u32], count: usize) -> Vec<u32> {
    let mut place = vec![u32::MAX; count];
    nodes.iter().enumerate().for_each(|(i, &v)| place[v as usize] = i as u32);
    place
}

/// `x += sign y`.
fn add(x: &mut [f64; 3], sign: f64, y: [f64; 3]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += sign * y);
}

fn times(a: &Block<3, 3>, x: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| (0..3).map(|s| a[r][s] * x[s]).sum())
}

/// `aᵀ x`.
fn transpose_times(a: &Block<3, 3>, x: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|s| (0..3).map(|r| a[r][s] * x[r]).sum())
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::absolute_sweeps::AbsoluteSweeps;
    use super::super::relative_rows::RelativeRows;
    use super::super::tests::{assert_local_changes, coarsen, lattice};
    use super::super::{CoarseLevels, Hierarchy, NodeConstraint};
    use super::*;
    use crate::linalg::Stop;

    /// Two lattices side by side without a spring between them, the nodes of one face of the first coupled to two nodes
    /// of the second.
    pub(in super::super) fn two_bodies() -> (Blocks<3, 3>, Vec<[[f64; 6]; 3]>, RelativeCoordinates) {
        let (a, kernel) = lattice([4, 4, 4], [1.0; 3]);
        let n = a.rows;
        let named = |i: usize, name: &mut dyn FnMut(u32)| {
            a.row(i % n).0.iter().for_each(|&j| name(j + (i / n * n) as u32));
        };
        let both = Blocks::from_rows(2 * n, 2 * n, named, |i, row| {
            a.entries_of(i % n).for_each(|(j, b)| *row.at(j + (i / n * n) as u32) = *b);
        });
        let weight = |w: f64| [[-w, 0.1 * w, 0.0], [0.0, -w, 0.2 * w], [0.3 * w, 0.0, -w]];
        let rows = (0..16u32).map(|i| vec![(n as u32 + i, weight(0.7)), (n as u32 + (i + 1) % 16, weight(0.3))]);
        let kernel = [kernel.clone(), kernel].concat();
        let coordinates = RelativeCoordinates::new((0..16).collect(), &rows.collect::<Vec<_>>(), 2 * n).unwrap();
        (both, kernel, coordinates)
    }

    /// One lattice; every other node of an edge is relative to its neighbours, and all of them can be constrained.
    fn ends_and_middles() -> (Blocks<3, 3>, Vec<[[f64; 6]; 3]>, RelativeCoordinates) {
        let (a, kernel) = lattice([4, 4, 5], [1.0; 3]);
        let weight = [[-0.2, 0.02, 0.0], [0.0, -0.2, 0.03], [0.01, 0.0, -0.2]];
        let row = |i: u32| if i.is_multiple_of(2) { Vec::new() } else { vec![(i - 1, weight), (i + 1, weight)] };
        let coordinates = RelativeCoordinates::new((0..17).collect(), &(0..17).map(row).collect::<Vec<_>>(), a.rows);
        (a, kernel, coordinates.unwrap())
    }

    /// As [`two_bodies`], every other node of the face also relative to its neighbours there, as the middles of quadratic
    /// edges are.
    pub(in super::super) fn chains() -> (Blocks<3, 3>, Vec<[[f64; 6]; 3]>, RelativeCoordinates) {
        let (a, kernel, simple) = two_bodies();
        let end = [[-0.2, 0.02, 0.0], [0.0, -0.2, 0.03], [0.01, 0.0, -0.2]];
        let row = |i: usize| {
            let mut row: Entries = simple.c.entries_of(i).map(|(k, block)| (k, *block)).collect();
            let ends = if i % 2 == 1 { vec![i - 1, (i + 1) % 16] } else { Vec::new() };
            row.extend(ends.into_iter().map(|k| (k as u32, end)));
            row
        };
        let coordinates = RelativeCoordinates::new(simple.nodes.clone(), &(0..16).map(row).collect::<Vec<_>>(), a.rows);
        (a, kernel, coordinates.unwrap())
    }

    /// As [`chains`], the nodes of the face beside one another in pairs: each relative to the other one, and these to the next.
    pub(in super::super) fn cycles() -> (Blocks<3, 3>, Vec<[[f64; 6]; 3]>, RelativeCoordinates) {
        let (a, kernel, simple) = two_bodies();
        let beside = [[0.2, 0.02, 0.0], [0.0, 0.25, 0.03], [0.01, 0.0, 0.2]];
        let row = |i: usize| {
            let mut row: Entries = simple.c.entries_of(i).map(|(k, block)| (k, *block)).collect();
            row.push((i as u32 ^ 1, beside));
            row.extend((i < 6).then_some((i as u32 + 2, beside)));
            row
        };
        let coordinates = RelativeCoordinates::new(simple.nodes.clone(), &(0..16).map(row).collect::<Vec<_>>(), a.rows);
        (a, kernel, coordinates.unwrap())
    }

    #[test]
    fn chains_that_are_closed_tightly_are_refused() {
        let block = [[0.5, 0.0, 0.0]; 3];
        let closed = |weight: f64| -> Vec<Entries> {
            (0..3).map(|i| vec![((i + 1) % 3, [[weight, 0.0, 0.0], [0.0, weight, 0.0], [0.0, 0.0, weight]])]).collect()
        };
        assert!(RelativeCoordinates::new(vec![0, 1, 2], &closed(-1.0), 4).is_none());
        assert!(RelativeCoordinates::new(vec![0, 1, 2], &closed(-0.5), 4).is_some());
        let open: Vec<Entries> = (0..3).map(|i| vec![(i + 1, block)]).collect();
        assert!(RelativeCoordinates::new(vec![0, 1, 2], &open, 4).is_some());
        let long: Vec<Entries> = (0..100).map(|i| vec![(i + 1, block)]).collect();
        assert!(RelativeCoordinates::new((0..100).collect(), &long, 101).is_none());
    }

    pub(in super::super) fn relative(a: &Blocks<3, 3>, coordinates: &RelativeCoordinates) -> RelativeMatrix {
        RelativeMatrix::new(a.clone(), Some(coordinates.clone()))
    }

    /// With the changed rows in their places.
    fn explicit(a: &Blocks<3, 3>, coordinates: &RelativeCoordinates) -> Blocks<3, 3> {
        let (mut explicit, (changed, rows)) = (a.clone(), RelativeRows::new(a, coordinates).changed());
        explicit.replace_rows(&changed, &rows);
        explicit
    }

    pub(in super::super) fn vector(n: usize, seed: f64) -> Vec<[f64; 3]> {
        (0..n).map(|i| std::array::from_fn(|c| ((i * 3 + c) as f64 * seed).fract() - 0.5)).collect()
    }

    pub(in super::super) fn dot(x: &[[f64; 3]], y: &[[f64; 3]]) -> f64 {
        x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum()
    }

    #[test]
    fn relative_displacements_have_the_energy_and_the_work_of_the_absolute_ones() {
        for (a, _, coordinates) in [two_bodies(), ends_and_middles(), chains(), cycles()] {
            keeps_energy_and_work(&a, &coordinates);
        }
    }

    fn keeps_energy_and_work(a: &Blocks<3, 3>, coordinates: &RelativeCoordinates) {
        let (relative, explicit) = (relative(a, coordinates), explicit(a, coordinates));
        for seed in [0.618, 0.414] {
            let (x, f) = (vector(a.rows, seed), vector(a.rows, 0.7321));
            let mut y = x.clone();
            coordinates.to_relative(&mut y);
            let (e, other) = (dot(&x, &a.times(&x)), dot(&y, &relative.times(&y)));
            assert!((e - other).abs() < 1e-12 * e);
            assert!((e - dot(&y, &explicit.times(&y))).abs() < 1e-12 * e);
            let mut g = f.clone();
            coordinates.forces(&mut g);
            assert!((dot(&f, &x) - dot(&g, &y)).abs() < 1e-12 * dot(&f, &f));
            coordinates.to_absolute(&mut y);
            let back = x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
            assert!(back < 1e-14);
        }
    }

    #[test]
    fn the_coarse_matrix_stays_and_bodies_joined_by_constraints_are_solved_fast() {
        for (a, kernel, coordinates) in [two_bodies(), ends_and_middles(), chains(), cycles()] {
            solved_fast(&a, &kernel, &coordinates);
        }
    }

    fn solved_fast(a: &Blocks<3, 3>, kernel: &[[[f64; 6]; 3]], coordinates: &RelativeCoordinates) {
        let (relative, explicit) = (relative(a, coordinates), explicit(a, coordinates));
        let step = coarsen(a, kernel, 0.05, &coordinates.nodes).unwrap().unwrap();
        let mut p = step.prolongation.clone();
        coordinates.transform_prolongation(&mut p);
        // P'T'ATP is P'AP: the coarse spaces are the same displacements.
        for q in [0, 3, 7] {
            let mut coarse = vec![[0.0; 6]; p.cols];
            coarse[q % p.cols][q % 6] = 1.0;
            let fine = p.times(&coarse);
            let (energy, expected) =
                (dot(&fine, &relative.times(&fine)), step.matrix.diagonal(q % p.cols)[q % 6][q % 6]);
            assert!((energy - expected).abs() < 1e-12 * expected);
        }
        let constraints_of = |constrained: &dyn Fn(usize) -> [bool; 3]| -> Vec<NodeConstraint> {
            (0..coordinates.nodes.len())
                .map(|i| NodeConstraint { constrained: constrained(i), spring: [[0.0; 3]; 3], coulomb: [0.0; 2] })
                .collect()
        };
        let coupled = coordinates.transform_step(step, &relative, &coordinates.nodes);
        for constraints in [constraints_of(&|_| [true; 3]), constraints_of(&|i| [i % 3 == 0, i % 4 == 1, false])] {
            assert_local_changes(&explicit, &explicit, &coupled, &coordinates.nodes, &constraints);
        }
        let mut multigrid =
            Hierarchy::new(&relative, kernel, &coordinates.nodes, coordinates.nodes.len(), None, &Stop::never())
                .unwrap()
                .unwrap();
        multigrid.constrain(&constraints_of(&|_| [true; 3]), CoarseLevels::Change, true);
        let zero_constrained = |x: &mut Vec<[f64; 3]>| coordinates.nodes.iter().for_each(|&v| x[v as usize] = [0.0; 3]);
        // Steepest descent with the cycle contracts the error; constrained nodes do not move.
        let mut x = vector(a.rows, 0.618);
        zero_constrained(&mut x);
        let start = dot(&x, &relative.times(&x));
        for _ in 0..12 {
            let mut r: Vec<[f64; 3]> = relative.times(&x);
            zero_constrained(&mut r);
            let z = multigrid.cycle(&r);
            assert!(coordinates.nodes.iter().all(|&v| z[v as usize] == [0.0; 3]));
            let step = dot(&r, &z) / dot(&z, &relative.times(&z));
            x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x -= step * z);
        }
        assert!(dot(&x, &relative.times(&x)) < 1e-5 * start);
    }

    /// Nodes that slide on those they are measured from, with springs along the surface.
    #[test]
    fn cycles_stay_symmetric_and_contract_faster_with_sweeps_of_nodes_without_their_followers() {
        for (a, kernel, coordinates) in [two_bodies(), chains(), cycles()] {
            let relative = relative(&a, &coordinates);
            let count = coordinates.nodes.len();
            let stiffness = 0.01 * a.diagonal(coordinates.nodes[0] as usize)[0][0];
            let spring = [[0.0; 3], [0.0, stiffness, 0.0], [0.0, 0.0, stiffness]];
            let constraint = NodeConstraint { constrained: [true, false, false], spring, coulomb: [0.0; 2] };
            let zero_constrained =
                |x: &mut Vec<[f64; 3]>| coordinates.nodes.iter().for_each(|&v| x[v as usize][0] = 0.0);
            let times = |x: &Vec<[f64; 3]>| {
                let mut y = relative.times(x);
                for &v in &coordinates.nodes {
                    (1..3).for_each(|c| y[v as usize][c] += stiffness * x[v as usize][c]);
                }
                zero_constrained(&mut y);
                y
            };
            let mut multigrid =
                Hierarchy::new(&relative, &kernel, &coordinates.nodes, coordinates.nodes.len(), None, &Stop::never())
                    .unwrap()
                    .unwrap();
            multigrid.constrain(&vec![constraint; count], CoarseLevels::Change, true);
            let [mut p, mut q] = [0.618, 0.414].map(|seed| vector(a.rows, seed));
            zero_constrained(&mut p);
            zero_constrained(&mut q);
            let (of_p, of_q) = (multigrid.cycle(&p), multigrid.cycle(&q));
            let size = (dot(&p, &of_p) * dot(&q, &of_q)).sqrt();
            assert!((dot(&q, &of_p) - dot(&p, &of_q)).abs() < 1e-5 * size);
            // No eigenvalue of the cycle times the matrix is above one.
            assert!(dot(&of_p, &times(&of_p)) <= (1.0 + 1e-5) * dot(&p, &of_p));
            let left_after = |multigrid: &Hierarchy, cycles: usize| {
                let mut x = p.clone();
                for _ in 0..cycles {
                    let z = multigrid.cycle(&times(&x));
                    x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x -= z);
                }
                dot(&x, &times(&x)) / dot(&p, &times(&p))
            };
            let with = left_after(&multigrid, 8);
            multigrid.absolute = AbsoluteSweeps::new(None, &coordinates.nodes, &multigrid.fine);
            let without = left_after(&multigrid, 8);
            assert!(with < 0.1 * without, "{with} {without}");
        }
    }
}
