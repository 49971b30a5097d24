use rayon::prelude::*;

use super::Hierarchy;
use super::blocks::{Block, Blocks};
use super::dense::{add_product, add_transpose_product};
use super::packed::{Packed, double, scaled, unit};
use super::smoother::Level;
use super::truncation::Columns;

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
    sum.par_iter_mut().enumerate().for_each(|(i, sum)| {
        for (j, block) in rows.entries_of(i) {
            let mut moved = [[0.0; C]; 3];
            add_product(block, &double(&level.inverse[j as usize]), &mut moved);
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
        let mut rows = self.truncation.support.p.clone();
        let mut sum = vec![[0.0; 3]; rows.rows];
        if let Some(linear) = &self.linear {
            add_compliances(&linear.support.p, &linear.level, &mut sum);
        }
        for (k, level) in self.coarse.iter().enumerate() {
            add_compliances(&rows, level, &mut sum);
            if let Some(coarser) = self.coarse.get(k + 1) {
                rows = below(&rows, &self.further[k], coarser.matrix.rows);
            }
        }
        sum
    }
}

impl<'a> CoarseProblem<'a> {
    /// `None` if the hierarchy has no second coarse level, or one with too few nodes to resolve the contact surface.
    pub(crate) fn new(hierarchy: &'a mut Hierarchy) -> Option<CoarseProblem<'a>> {
        let further = hierarchy.further.first()?;
        let matrix = hierarchy.without_constraints(1);
        if matrix.rows < LEAST {
            return None;
        }
        let rows = below(&hierarchy.truncation.support.p, further, matrix.rows);
        let columns = rows.by_columns();
        Some(CoarseProblem { hierarchy, matrix, rows, columns })
    }

    /// A load on the finest level, newton by its nodes, in this space.
    pub(crate) fn restrict(&self, f: &[[f64; 3]]) -> Vec<[f64; 6]> {
        let (scale, f) = unit(f);
        let Hierarchy { linear, first, .. } = &*self.hierarchy;
        let f = match linear {
            Some(linear) => linear.prolongation.transpose_times(&f, linear.level.matrix.rows),
            None => f,
        };
        let coarse = first.transpose_times(&f, self.hierarchy.first_coarse());
        scaled(scale, &self.hierarchy.further[0].transpose_times(&coarse, self.matrix.rows))
    }

    /// Displacements of this space by the nodes of the finest level.
    pub(crate) fn prolong(&self, x: &[[f64; 6]]) -> Vec<[f64; 3]> {
        let (scale, x) = unit(x);
        let mut coarse = vec![[0.0; 6]; self.hierarchy.first_coarse()];
        self.hierarchy.further[0].add_times(&x, &mut coarse);
        let Hierarchy { fine, linear, first, .. } = &*self.hierarchy;
        let mut u = vec![[0.0; 3]; linear.as_ref().map_or(fine.matrix.rows, |linear| linear.level.matrix.rows)];
        first.add_times(&coarse, &mut u);
        if let Some(linear) = linear {
            let on_corners = std::mem::replace(&mut u, vec![[0.0; 3]; fine.matrix.rows]);
            linear.prolongation.add_times(&on_corners, &mut u);
        }
        scaled(scale, &u)
    }

    /// `A x`, without springs.
    pub(crate) fn times(&self, x: &[[f64; 6]]) -> Vec<[f64; 6]> {
        self.matrix.times(x)
    }

    /// Displacements of the nodes that may be constrained, in their order.
    pub(crate) fn to_nodes(&self, x: &[[f64; 6]]) -> Vec<[f64; 3]> {
        self.rows.times(x)
    }

    /// Forces on those nodes, newton in the direction of their displacements, in this space.
    pub(crate) fn restrict_from_nodes(&self, forces: &[[f64; 3]]) -> Vec<[f64; 6]> {
        let mut sum = vec![[0.0; 6]; self.matrix.rows];
        for (i, force) in forces.iter().enumerate() {
            for (k, block) in self.rows.entries_of(i) {
                let sum = &mut sum[k as usize];
                (0..6).for_each(|c| sum[c] += (0..3).map(|r| block[r][c] * force[r]).sum::<f64>());
            }
        }
        sum
    }

    /// Springs for the cycles, one stiffness (force per length, positive semidefinite) for each of those nodes; they take the
    /// place of those before.
    pub(crate) fn set_springs(&mut self, springs: &[Block<3, 3>]) {
        let CoarseProblem { hierarchy, rows, columns: (start, entry), .. } = self;
        let touched = &hierarchy.truncation.touched[1];
        let of_column = |t: usize| {
            let k = touched[t] as usize;
            let entries = entry[start[k]..start[k + 1]].iter();
            entries.filter(|&&(i, _)| springs[i as usize] != [[0.0; 3]; 3])
        };
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            of_column(t).for_each(|&(i, _)| rows.row(i as usize).0.iter().for_each(|&j| name(j)));
        };
        let change = Blocks::from_rows(touched.len(), rows.cols, reached, |t, row| {
            for &(i, place) in of_column(t) {
                let mut pulled = [[0.0; 6]; 3];
                add_product(&springs[i as usize], &rows.value[place as usize], &mut pulled);
                rows.entries_of(i as usize).for_each(|(j, block)| add_transpose_product(&pulled, block, row.at(j)));
            }
        });
        hierarchy.change_coarse(1, change);
    }

    /// One cycle for `(A + springs) x = b` from zero.
    pub(crate) fn cycle(&self, b: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let (scale, b) = unit(b);
        scaled(scale, &self.hierarchy.cycles_from(1, &b))
    }
}
