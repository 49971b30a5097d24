use std::borrow::Cow;

use rayon::prelude::*;

use super::Hierarchy;
use super::between_ranks::{Entries, Reach, ghost_rows};
use super::blocks::{Block, Blocks};
use super::dense::{add_product, add_transpose_product};
use super::packed::{Packed, add_to, double, scaled, unit};
use super::smoother::Level;
use super::truncation::Columns;
use crate::ranks::Halo;

/// The problem in the space of the second coarse level, with springs at the contact nodes: the first problem of nested
/// iteration where there is no coarser mesh. Its cycle costs a few hundredths of one of the whole hierarchy. It borrows the
/// coarse levels of the hierarchy, which have to be constrained again afterwards.
pub(crate) struct CoarseProblem<'a> {
    hierarchy: &'a mut Hierarchy,
    /// Without springs.
    matrix: Blocks<6, 6>,
    /// Displacements of the nodes by those of this space, a row for each node.
    rows: Blocks<3, 6>,
    columns: Columns,
    /// How the nodes of this space are divided among ranks, with those that `rows` reach as ghosts.
    reached: Halo,
    /// The nodes of this space that the springs of this rank reach.
    reach: Reach,
}

/// Fewest nodes of the second coarse level; with six a start from there costs more cycles than it saves.
const LEAST: usize = 12;

/// Displacements of the contact nodes of this rank by those of a level, and how the nodes of the level are divided, with those
/// that these rows reach as ghosts.
type Rows = (Blocks<3, 6>, Halo);

/// The product of rows with the prolongation from the next level, which is divided by `coarser`.
fn below((rows, halo): &Rows, prolongation: &Packed<6, 6>, coarser: &Halo) -> Rows {
    let row = |i: u32| -> Entries<6, 6> {
        let entries = prolongation.entries_of(i as usize);
        entries.map(|(k, value)| (coarser.global(k as usize), double(value))).collect()
    };
    let mut is_reached = vec![false; halo.own()];
    rows.column.iter().filter(|&&j| (j as usize) < halo.own()).for_each(|&j| is_reached[j as usize] = true);
    let own = (0..halo.own() as u32).map(|i| if is_reached[i as usize] { row(i) } else { Vec::new() });
    let factor: Vec<Entries<6, 6>> = own.chain(ghost_rows(halo, row)).collect();
    let wider = coarser.with_other_ghosts(factor.iter().flatten().map(|entry| entry.0));
    let place = |k: u64| wider.place(k).expect("a node of this rank or one of its ghosts") as u32;
    let local = |row: Entries<6, 6>| row.into_iter().map(|(k, block)| (place(k), block)).collect();
    let factor: Vec<Vec<(u32, Block<6, 6>)>> = factor.into_iter().map(local).collect();
    let reached = |i: usize, name: &mut dyn FnMut(u32)| {
        rows.row(i).0.iter().for_each(|&j| factor[j as usize].iter().for_each(|&(k, _)| name(k)));
    };
    let product = Blocks::from_rows(rows.rows, wider.len(), reached, |i, row| {
        for (j, block) in rows.entries_of(i) {
            factor[j as usize].iter().for_each(|(k, value)| add_product(block, value, row.at(*k)));
        }
    });
    (product, wider)
}

/// Adds the diagonal of `P D⁻¹ Pᵀ` for rows of a prolongation from a level, whose nodes `halo` divides.
fn add_compliances<const C: usize, const W: usize>(
    rows: &Blocks<3, C>,
    halo: &Halo,
    level: &Level<C, W>,
    sum: &mut [[f64; 3]],
) {
    let inverse = halo.extended(&level.inverse);
    sum.par_iter_mut().enumerate().for_each(|(i, sum)| {
        for (j, block) in rows.entries_of(i) {
            let mut moved = [[0.0; C]; 3];
            add_product(block, &double(&inverse[j as usize]), &mut moved);
            (0..3).for_each(|r| sum[r] += (0..C).map(|c| moved[r][c] * block[r][c]).sum::<f64>());
        }
    });
}

impl Hierarchy {
    /// The compliance (displacement over force) of the contact nodes' components, without the parts of the finest and the
    /// coarsest level: the diagonal of `sum of P D⁻¹ Pᵀ` over the levels between (Bramble, Pasciak & Xu 1990), for a
    /// hierarchy without constraints. In flat cells it is most of the compliance: their nodes move with their close
    /// neighbours.
    pub(crate) fn coarse_compliances(&self) -> Vec<[f64; 3]> {
        let mut rows = self.support_rows();
        let mut sum = vec![[0.0; 3]; rows.0.rows];
        if let Some(linear) = &self.linear {
            add_compliances(&linear.support.p, &linear.level.halo, &linear.level, &mut sum);
        }
        for (k, level) in self.coarse.iter().enumerate() {
            add_compliances(&rows.0, &rows.1, level, &mut sum);
            if k + 1 < self.coarse.len() {
                rows = below(&rows, &self.further[k], &self.halos[k + 1]);
            }
        }
        sum
    }

    /// The displacements of the contact nodes of this rank by those of the first aggregated level.
    fn support_rows(&self) -> Rows {
        let (support, own) = (&self.truncation.support.p, self.truncation.halo.own());
        let halo = &self.halos[0];
        let global = |j: u32| halo.global(j as usize);
        let reached = halo.with_other_ghosts((0..own).flat_map(|i| support.row(i).0).map(|&j| global(j)));
        let place = |j: u32| reached.place(global(j)).expect("a node of this rank or one of its ghosts") as u32;
        let named = |i: usize, name: &mut dyn FnMut(u32)| support.row(i).0.iter().for_each(|&j| name(place(j)));
        let rows = Blocks::from_rows(own, reached.len(), named, |i, row| {
            support.entries_of(i).for_each(|(j, block)| *row.at(place(j)) = *block);
        });
        (rows, reached)
    }
}

impl<'a> CoarseProblem<'a> {
    /// `None` if the hierarchy has no second coarse level, or one with too few nodes to resolve the contact surface.
    pub(crate) fn new(hierarchy: &'a mut Hierarchy) -> Option<CoarseProblem<'a>> {
        let further = hierarchy.further.first()?;
        let matrix = hierarchy.without_constraints(1);
        let halo = &hierarchy.halos[1];
        if halo.total() < LEAST {
            return None;
        }
        let (rows, reached) = below(&hierarchy.support_rows(), further, halo);
        let columns = rows.by_columns(rows.rows);
        let mut reach = rows.column.clone();
        reach.sort_unstable();
        reach.dedup();
        let touched = &hierarchy.truncation.touched[1];
        // On one rank there are rows for all that constraints touch, empty where springs do not reach.
        let reach = if reached.is_alone() { touched.clone() } else { touched.within(&reached, reach) };
        Some(CoarseProblem { hierarchy, matrix, rows, columns, reached, reach })
    }

    /// How the nodes of this space are divided among ranks.
    pub(crate) fn halo(&self) -> &Halo {
        &self.hierarchy.halos[1]
    }

    /// A load on the finest level, newton by its nodes, in this space.
    pub(crate) fn restrict(&self, f: &[[f64; 3]]) -> Vec<[f64; 6]> {
        let Hierarchy { fine, linear, first, transfers, .. } = &*self.hierarchy;
        let (scale, f) = unit(&fine.halo, f);
        let f = match linear {
            Some(linear) => {
                let mut f = linear.prolongation.transpose_times(&f, linear.level.halo.len());
                linear.level.halo.add(&mut f, add_to);
                f
            }
            None => f,
        };
        let mut coarse = first.transpose_times(&f, transfers[0].len());
        transfers[0].add(&mut coarse, add_to);
        let mut coarse = self.hierarchy.further[0].transpose_times(&coarse, transfers[1].len());
        transfers[1].add(&mut coarse, add_to);
        scaled(scale, &coarse)
    }

    /// Displacements of this space by the nodes of the finest level.
    pub(crate) fn prolong(&self, x: &[[f64; 6]]) -> Vec<[f64; 3]> {
        let Hierarchy { fine, linear, first, further, transfers, .. } = &*self.hierarchy;
        let (scale, mut x) = unit(&transfers[1], x);
        transfers[1].update(&mut x);
        let mut coarse = vec![[0.0; 6]; transfers[0].own()];
        further[0].add_times(&x, &mut coarse);
        transfers[0].update(&mut coarse);
        let mut u = vec![[0.0; 3]; linear.as_ref().map_or(fine.matrix.rows, |linear| linear.level.matrix.rows)];
        first.add_times(&coarse, &mut u);
        if let Some(linear) = linear {
            let mut on_corners = std::mem::replace(&mut u, vec![[0.0; 3]; fine.matrix.rows]);
            linear.level.halo.update(&mut on_corners);
            linear.prolongation.add_times(&on_corners, &mut u);
        }
        scaled(scale, &u)
    }

    /// `A x`, without springs.
    pub(crate) fn times(&self, x: &[[f64; 6]]) -> Vec<[f64; 6]> {
        // The rows of the coarsest level have no ghosts.
        let level = self.hierarchy.coarse.get(1);
        self.matrix.times(&level.map_or(Cow::Borrowed(x), |level| level.halo.extended(x)))
    }

    /// Displacements of the nodes that may be constrained, in their order.
    pub(crate) fn to_nodes(&self, x: &[[f64; 6]]) -> Vec<[f64; 3]> {
        self.rows.times(&self.reached.extended(x))
    }

    /// Forces on those nodes, newton in the direction of their displacements, in this space.
    pub(crate) fn restrict_from_nodes(&self, forces: &[[f64; 3]]) -> Vec<[f64; 6]> {
        let mut sum = vec![[0.0; 6]; self.reached.len()];
        for (i, force) in forces.iter().enumerate() {
            for (k, block) in self.rows.entries_of(i) {
                let sum = &mut sum[k as usize];
                (0..6).for_each(|c| sum[c] += (0..3).map(|r| block[r][c] * force[r]).sum::<f64>());
            }
        }
        self.reached.add(&mut sum, add_to);
        sum
    }

    /// Springs for the cycles, one stiffness (force per length, positive semidefinite) for each of those nodes; they take the
    /// place of those before.
    pub(crate) fn set_springs(&mut self, springs: &[Block<3, 3>]) {
        let CoarseProblem { hierarchy, rows, columns: (start, entry), reach, .. } = self;
        let of_column = |t: usize| {
            let k = reach.reach[t] as usize;
            let entries = entry[start[k]..start[k + 1]].iter();
            entries.filter(|&&(i, _)| springs.get(i as usize).is_some_and(|spring| *spring != [[0.0; 3]; 3]))
        };
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            of_column(t).for_each(|&(i, _)| rows.row(i as usize).0.iter().for_each(|&j| name(j)));
        };
        let change = Blocks::from_rows(reach.reach.len(), rows.cols, reached, |t, row| {
            for &(i, place) in of_column(t) {
                let mut pulled = [[0.0; 6]; 3];
                add_product(&springs[i as usize], &rows.value[place as usize], &mut pulled);
                rows.entries_of(i as usize).for_each(|(j, block)| add_transpose_product(&pulled, block, row.at(j)));
            }
        });
        hierarchy.renew_coarse_levels();
        hierarchy.change_coarse(1, reach.rows(change));
    }

    /// One cycle for `(A + springs) x = b` from zero.
    pub(crate) fn cycle(&self, b: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let halo = self.halo();
        let (scale, b) = unit(halo, b);
        let mut x = self.hierarchy.cycles_from(1, &b);
        x.truncate(halo.own());
        scaled(scale, &x)
    }
}
