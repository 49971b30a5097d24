use rayon::prelude::*;

use super::Hierarchy;
use super::between_ranks::Reach;
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
    /// How what contact nodes add to this space is divided among ranks: of a level below one that is joined each rank has all
    /// values, but the contact nodes remain divided.
    from_nodes: Halo,
    /// The nodes of this space that the springs of this rank reach.
    reach: Reach,
}

/// Fewest nodes of the second coarse level; with six a start from there costs more cycles than it saves.
const LEAST: usize = 12;

/// The product of rows of blocks with a prolongation from a level of so many nodes.
fn below(rows: &Blocks<3, 6>, prolongation: &Packed<6, 6>, nodes: usize) -> Blocks<3, 6> {
    let reached = |i: usize, name: &mut dyn FnMut(u32)| {
        rows.row(i).0.iter().for_each(|&j| prolongation.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    Blocks::from_rows(rows.rows, nodes, reached, |i, row| {
        for (j, block) in rows.entries_of(i) {
            prolongation.entries_of(j as usize).for_each(|(k, value)| add_product(block, &double(value), row.at(k)));
        }
    })
}

/// Adds the diagonal of `P D⁻¹ Pᵀ` for rows of a prolongation from a level.
fn add_compliances<const C: usize, const W: usize>(rows: &Blocks<3, C>, level: &Level<C, W>, sum: &mut [[f64; 3]]) {
    let inverse = level.halo.extended(&level.inverse);
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
        let mut sum = vec![[0.0; 3]; rows.rows];
        if let Some(linear) = &self.linear {
            add_compliances(&linear.support.p, &linear.level, &mut sum);
        }
        for (k, level) in self.coarse.iter().enumerate() {
            add_compliances(&rows, level, &mut sum);
            if k + 1 < self.coarse.len() {
                rows = below(&rows, &self.further[k], self.halos[k + 1].len());
            }
        }
        sum
    }

    /// The displacements of the contact nodes of this rank by those of the first aggregated level.
    fn support_rows(&self) -> Blocks<3, 6> {
        let mut rows = self.truncation.support.p.clone();
        rows.rows = self.truncation.halo.own();
        rows.start.truncate(rows.rows + 1);
        let entries = rows.start[rows.rows];
        rows.column.truncate(entries);
        rows.value.truncate(entries);
        rows
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
        let rows = below(&hierarchy.support_rows(), further, halo.len());
        let columns = rows.by_columns(rows.rows);
        let mut reach = rows.column.clone();
        reach.sort_unstable();
        reach.dedup();
        let touched = &hierarchy.truncation.touched[1];
        let above = &hierarchy.halos[0];
        let from_nodes = if above.is_joined() { Halo::joined(above.ranks(), halo.len()) } else { halo.clone() };
        // On one rank there are rows for all that constraints touch, empty where springs do not reach.
        let reach = if from_nodes.is_alone() { touched.clone() } else { touched.within(&from_nodes, reach) };
        Some(CoarseProblem { hierarchy, matrix, rows, columns, from_nodes, reach })
    }

    /// How the nodes of this space are divided among ranks.
    pub(crate) fn halo(&self) -> &Halo {
        &self.hierarchy.halos[1]
    }

    /// A load on the finest level, newton by its nodes, in this space.
    pub(crate) fn restrict(&self, f: &[[f64; 3]]) -> Vec<[f64; 6]> {
        let Hierarchy { fine, linear, first, halos, .. } = &*self.hierarchy;
        let (scale, f) = unit(&fine.halo, f);
        let f = match linear {
            Some(linear) => {
                let mut f = linear.prolongation.transpose_times(&f, linear.level.halo.len());
                linear.level.halo.add(&mut f, add_to);
                f
            }
            None => f,
        };
        let mut coarse = first.transpose_times(&f, halos[0].len());
        halos[0].add(&mut coarse, add_to);
        let mut coarse = self.hierarchy.further[0].transpose_times(&coarse, halos[1].len());
        halos[1].add(&mut coarse, add_to);
        scaled(scale, &coarse)
    }

    /// Displacements of this space by the nodes of the finest level.
    pub(crate) fn prolong(&self, x: &[[f64; 6]]) -> Vec<[f64; 3]> {
        let Hierarchy { fine, linear, first, further, halos, .. } = &*self.hierarchy;
        let (scale, mut x) = unit(&halos[1], x);
        halos[1].update(&mut x);
        let mut coarse = vec![[0.0; 6]; halos[0].own()];
        further[0].add_times(&x, &mut coarse);
        halos[0].update(&mut coarse);
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
        self.matrix.times(&self.halo().extended(x))
    }

    /// Displacements of the nodes that may be constrained, in their order.
    pub(crate) fn to_nodes(&self, x: &[[f64; 6]]) -> Vec<[f64; 3]> {
        self.rows.times(&self.halo().extended(x))
    }

    /// Forces on those nodes, newton in the direction of their displacements, in this space.
    pub(crate) fn restrict_from_nodes(&self, forces: &[[f64; 3]]) -> Vec<[f64; 6]> {
        let mut sum = vec![[0.0; 6]; self.halo().len()];
        for (i, force) in forces.iter().enumerate() {
            for (k, block) in self.rows.entries_of(i) {
                let sum = &mut sum[k as usize];
                (0..6).for_each(|c| sum[c] += (0..3).map(|r| block[r][c] * force[r]).sum::<f64>());
            }
        }
        self.from_nodes.add(&mut sum, add_to);
        sum
    }

    /// Springs for the cycles, one stiffness (force per length, positive semidefinite) for each of those nodes; they take the
    /// place of those before.
    pub(crate) fn set_springs(&mut self, springs: &[Block<3, 3>]) {
        let CoarseProblem { hierarchy, rows, columns: (start, entry), reach, .. } = self;
        let of_column = |t: usize| {
            let k = reach.reach[t] as usize;
            let entries = entry[start[k]..start[k + 1]].iter();
            entries.filter(|&&(i, _)| springs[i as usize] != [[0.0; 3]; 3])
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
