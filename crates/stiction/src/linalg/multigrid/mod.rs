//! Smoothed-aggregation multigrid for elasticity (Vanek, Mandel & Brezina 1996): blocks by nodes, six rigid motions a
//! coarse node, set up in double and cycled in single precision.
//!
//! The nodes may be divided among ranks ([`Halo`]): each has the rows of its own, and aggregates do not cross the borders. Small
//! coarse levels are agglomerated: fewer and fewer ranks have nodes of them, at last rank 0 alone. Without ghosts this is the
//! serial method.
//!
//! Some nodes may be constrained ([`NodeConstraint`]): their constrained components are truncated from the finest
//! prolongation, and the coarse matrices follow by local changes ([`Hierarchy::constrain`]).

// Small dense blocks are read by their indices.
#![allow(clippy::needless_range_loop)]

mod absolute_sweeps;
mod aggregate;
mod between_ranks;
mod blocks;
mod coarse_problem;
mod coarsen;
mod coarsest;
mod coulomb_coupling;
mod cycles;
mod dense;
mod distance;
mod divided_product;
mod middles;
mod packed;
mod quadratic;
mod relative_coordinates;
mod relative_matrix;
mod relative_rows;
mod smoother;
mod stiff_groups;
#[cfg(test)]
mod tests;
mod truncation;

pub(crate) use blocks::{Block, Blocks, Nodes};
pub(crate) use coarse_problem::CoarseProblem;
pub(crate) use coarsen::Kernel;
pub(crate) use dense::inverse;
pub(crate) use quadratic::{LinearSpace, NO_NODE};
pub(crate) use relative_coordinates::RelativeCoordinates;
pub(crate) use relative_matrix::{AllRows, RelativeMatrix};
pub(crate) use truncation::{CoarseLevels, NodeConstraint, contact_ghosts};

use super::Stop;
use crate::Error;
use crate::ranks::Halo;
use absolute_sweeps::AbsoluteSweeps;
use aggregate::diagonal_norms;
use between_ranks::gathered;
use coarsen::{Coarser, coarsen, copied, product_of};
use coarsest::CoarsestFactor;
use coulomb_coupling::CoulombCoupling;
use packed::{Packed, add_to, in_units, largest, scaled};
use quadratic::Linear;
use smoother::Level;
use stiff_groups::{StiffGroups, stiff_groups, without};
use truncation::{Support, Truncation};

/// A hierarchy of matrices, used as a preconditioner: one V-cycle with a forward Gauss-Seidel sweep before and a
/// backward one after the coarse correction, which is symmetric and positive definite.
#[derive(Debug, Clone)]
pub(crate) struct Hierarchy {
    fine: Level<3, 4>,
    /// Of quadratic elements, between the finest and the first aggregated level.
    linear: Option<Linear>,
    /// From the first aggregated level to the linear or else the finest one.
    first: Packed<3, 6>,
    /// The aggregated levels without the coarsest.
    coarse: Vec<Level<6, 8>>,
    /// How the nodes of each aggregated level, and those of the coarsest, are divided among ranks. Ghosts are all that the matrix of
    /// the level and the prolongation from it reach. [`Level::halo`] exchanges those of the matrix.
    halos: Vec<Halo>,
    /// The same for those that a cycle needs on the next finer level.
    transfers: Vec<Halo>,
    /// Cycles on each coarse level for one on the next finer level: one is a V-cycle, two a W-cycle.
    cycle_index: Vec<usize>,
    /// From each further level to the one before it.
    further: Vec<Packed<6, 6>>,
    coarsest: CoarsestFactor,
    /// Nodes with constrained components, by their places among those that may have some.
    constrained: Vec<(u32, [bool; 3])>,
    /// Nodes with a Coulomb coupling on the finest level ([`NodeConstraint::coulomb`]).
    coulomb: Vec<(u32, [f32; 2])>,
    /// The coupling on the coarse levels, as of their last change.
    coulomb_coupling: CoulombCoupling,
    truncation: Truncation,
    /// Of the finest level.
    absolute: AbsoluteSweeps,
    /// Of the finest level.
    stiff: StiffGroups,
}

// Parameters of the hierarchy. The counts they were chosen by: docs/notes/2026-11-23-multigrid-trials.md.

/// Thresholds of the hierarchy; the trials are in docs/notes/2026-11-23-multigrid-trials.md.
struct Threshold;

impl Threshold {
    /// Couplings weaker than this do not join nodes into aggregates on the finest level.
    const STRONG: f64 = 0.05;
    /// The same on coarse levels, where couplings within a body are weaker; those of materials with a contrast of ten
    /// thousand are 0.01 at most.
    const STRONG_COARSE: f64 = 0.025;
    /// Coarsening goes on as long as a level has more nodes than this.
    const COARSEST_NODES: usize = 50;
    /// Most nodes of the coarsest level. Its dense factor is renewed with every change of the constraints; beyond this size the
    /// hierarchy is refused.
    const COARSEST_LIMIT: usize = 300;
    /// Fewest nodes of a level for each rank that has some: parts of a few dozen nodes coarsen badly. Smaller levels are
    /// agglomerated, those with at most [`Self::COARSEST_LIMIT`] nodes on one rank; a finest one is copied first. See
    /// docs/notes/2026-11-26-ranks.md.
    const NODES_PER_RANK: usize = 256;
    /// Most coarse levels.
    const LEVELS: usize = 12;
    /// The cycle index from the second coarse level on, where [`Self::VISIT_WORK`] allows it. The coarser spaces are made without
    /// constraints and represent functions of the first coarse level badly once these are truncated. With a V-cycle the rate on a
    /// brick of tetrahedra, 28 cells across, rises from 0.19 to 0.28 with a face in contact, and from 0.30 to 0.41 with Coulomb
    /// coupling.
    const CYCLE_INDEX: usize = 3;
    /// Bound on the matrix entries that the busiest rank reads in all visits of a coarse level together, over the most that a rank has
    /// of the finest matrix. Cells
    /// flat along one side coarsen along lines only, and a constant cycle index would cost more on every coarser level. On blocks
    /// whose cells are stretched a thousand times, a quarter of the finest matrix takes 10 % more cycles at the same cost, and
    /// twice the finest matrix 15 % fewer at a higher one.
    /// Where the first coarse level is the larger one, as that of four layers of flat cells, it is the measure.
    const VISIT_WORK: f64 = 1.0;
    /// Fewest entries of the finest matrix that this bound takes the busiest of several ranks to have: some 0.3 ms, for which messages
    /// are waited for anyway. 300 random cases on four ranks take 5,127, 4,850, 4,448 and 7,131 cycles with 0, 0.1, 0.3 and 1 million.
    const WORK_OF_RANK: usize = 300_000;
}

impl Hierarchy {
    /// Sets up the hierarchy of a symmetric positive definite matrix with its near-kernel, three rows a node (the
    /// rigid motions for elasticity). Only `contact_nodes` can be constrained later, as many of them as `constrained` says; the others
    /// are measured from the first ones. `None` if aggregation does not make
    /// the matrix coarser.
    ///
    /// With relative coordinates the coarse spaces are those of the displacements, so that bodies joined by contact alone keep
    /// separate aggregates.
    ///
    /// With a linear space the first coarse level is that of its functions, and aggregation begins there.
    ///
    /// # Errors
    /// If there is no memory for a level, or `stop` asks to end, which it is asked between the levels and their parts.
    pub(crate) fn new(
        a: &RelativeMatrix,
        kernel: &[Kernel<3>],
        contact_nodes: &[u32],
        constrained: usize,
        linear: Option<LinearSpace>,
        stop: &Stop,
    ) -> Result<Option<Hierarchy>, Error> {
        let (plain, relative) = (a.of_displacements(), a.relative.as_ref());
        let groups = stiff_groups(plain, &diagonal_norms(plain));
        let (contact_halo, ghosts) = contact_ghosts(a, contact_nodes);
        let (linear, step, support) = match linear {
            None => {
                let free = without(&groups, &contact_nodes[..constrained]);
                let Some(mut step) = aggregated(plain, &a.halo, kernel, &free, None, contact_nodes)? else {
                    return Ok(None);
                };
                stop.check()?;
                if let Some(relative) = relative {
                    step = relative.transform_step(step, a, contact_nodes);
                }
                let step = agglomerated(step);
                let support = Support::of_step(&step, &[contact_nodes, &ghosts].concat());
                (None, step, support)
            }
            Some(LinearSpace { prolongation, kernel, halo, ends }) => {
                let Some((prolongation, matrix, a_times_p, halo)) =
                    product_of(plain, &a.halo, prolongation, halo, contact_nodes)
                else {
                    return Ok(None);
                };
                stop.check()?;
                let mut linear = Coarser { prolongation, a_times_p, matrix, kernel, halo };
                if let Some(relative) = relative {
                    linear = relative.transform_step(linear, a, contact_nodes);
                }
                stop.check()?;
                let groups = stiff_groups(&linear.matrix, &diagonal_norms(&linear.matrix));
                let constrained = contact_nodes[..constrained].iter();
                let named: Vec<u32> =
                    constrained.flat_map(|&v| linear.prolongation.row(v as usize).0).copied().collect();
                let free = without(&groups, &named);
                let Some(step) = aggregated(&linear.matrix, &linear.halo, &linear.kernel, &free, Some(&ends), &[])?
                else {
                    return Ok(None);
                };
                let step = agglomerated(step);
                let linear = Linear::new(&linear, &groups, &[contact_nodes, &ghosts].concat());
                let support = linear.support.within(&step.prolongation);
                (Some(linear), step, support)
            }
        };
        stop.check()?;
        let mut truncation = Truncation::new(a, contact_nodes, (contact_halo, &ghosts), support, &step.halo);
        stop.check()?;
        let first = Packed::new(&step.prolongation);
        // The prolongation is dropped here so that the next level reuses its memory: first touches of fresh pages are a
        // good part of the set-up.
        drop(step.prolongation);
        let above = linear.as_ref().map_or(a.len(), |linear| linear.level.matrix.rows);
        let columns = &first.column[..first.start[above]];
        let mut transfers = vec![step.halo.only(columns.iter().chain(truncation.support.own_columns()).copied())];
        let mut fine = a.finest_level();
        if linear.is_some() {
            fine.damp_less();
        }
        let (mut matrix, mut kernel, mut halos) = (step.matrix, step.kernel, vec![step.halo]);
        let (mut coarse, mut further) = (Vec::new(), Vec::new());
        while halos[coarse.len()].total() > Threshold::COARSEST_NODES && coarse.len() < Threshold::LEVELS {
            stop.check()?;
            let halo = halos[coarse.len()].among_owners();
            let Some(step) = coarsen(&matrix, &halo, &kernel, Threshold::STRONG_COARSE, &[], None, &[])? else { break };
            let step = agglomerated(step);
            let halo = halo.only(matrix.column.iter().copied());
            let (mut level, prolongation) = (Level::new(&matrix, halo), Packed::new(&step.prolongation));
            level.expect_changes(&truncation.touched[coarse.len()].touched);
            truncation.add_level(&matrix, &step.prolongation, &step.halo);
            let columns = &prolongation.column[..prolongation.start[matrix.rows]];
            transfers.push(step.halo.only(columns.iter().copied()));
            coarse.push(level);
            further.push(prolongation);
            halos.push(step.halo);
            (matrix, kernel) = (step.matrix, step.kernel);
        }
        if halos[coarse.len()].total() > Threshold::COARSEST_LIMIT {
            return Ok(None);
        }
        let absolute = AbsoluteSweeps::new(relative, &contact_nodes[..constrained], &fine);
        let coarsest = CoarsestFactor::new(&matrix);
        truncation.set_coarsest(matrix);
        let mut hierarchy = Hierarchy {
            fine,
            linear,
            first,
            coarse,
            halos,
            transfers,
            cycle_index: Vec::new(),
            further,
            coarsest,
            constrained: Vec::new(),
            coulomb: Vec::new(),
            coulomb_coupling: CoulombCoupling::default(),
            truncation,
            absolute,
            stiff: StiffGroups::new(&groups, a.halo.own(), contact_nodes, |nodes| a.rows_at(nodes)),
        };
        let mut sizes = hierarchy.busiest_sizes();
        if a.halo.is_divided() {
            sizes[0].1 = sizes[0].1.max(Threshold::WORK_OF_RANK);
        }
        hierarchy.cycle_index = affordable_cycle_index(&sizes, hierarchy.coarse.len());
        Ok(Some(hierarchy))
    }

    /// Whether some motion costs no energy under the present constraints. The coarsest level decides: it represents the
    /// near-kernel exactly.
    pub(crate) fn is_singular(&self) -> bool {
        self.coarsest_halo().any(self.coarsest.singular > 0)
    }

    /// How the nodes of the coarsest level are divided: on several ranks rank 0 has all of them.
    fn coarsest_halo(&self) -> &Halo {
        &self.halos[self.coarse.len()]
    }

    /// Nodes of each level, the finest first, and the entries stored in its matrix, of all ranks together.
    pub(crate) fn level_sizes(&self) -> Vec<(usize, usize)> {
        self.sizes(Halo::sum)
    }

    /// The same of each level's busiest rank, and of the coarsest level as a whole.
    fn busiest_sizes(&self) -> Vec<(usize, usize)> {
        self.sizes(Halo::max)
    }

    fn sizes(&self, of_ranks: impl Fn(&Halo, &mut [f64])) -> Vec<(usize, usize)> {
        fn here<const R: usize, const W: usize>(level: &Level<R, W>) -> (&Halo, [f64; 2]) {
            (&level.halo, [level.matrix.rows as f64, (R * R * level.matrix.value.len()) as f64])
        }
        let levels = [here(&self.fine)].into_iter().chain(self.linear.as_ref().map(|linear| here(&linear.level)));
        let sizes = levels.chain(self.coarse.iter().map(here)).map(|(halo, mut sizes)| {
            of_ranks(halo, &mut sizes);
            (sizes[0] as usize, sizes[1] as usize)
        });
        let coarsest = self.coarsest_halo().total();
        sizes.chain([(coarsest, 36 * coarsest * coarsest)]).collect()
    }

    /// One cycle for `A x = b` from zero; `b` is zero on constrained components. With Coulomb coupling the sweeps of the
    /// finest level are those of the unsymmetric system, and the coarse levels see the coupling in their residuals alone.
    pub(crate) fn cycle(&self, b: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.cycle_in_units(largest(&self.fine.halo, b), b)
    }

    /// The same where all ranks know about how large the entries of `b` are: that takes no message.
    pub(crate) fn cycle_in_units(&self, scale: f64, b: &[[f64; 3]]) -> Vec<[f64; 3]> {
        if !scale.is_finite() {
            return vec![[0.0; 3]; b.len()];
        }
        let b = in_units(scale, b);
        let (mut x, mut residual) = self.fine.forward(&b);
        self.stiff.forward(&self.fine.matrix, &mut x, &mut residual);
        self.absolute.forward(&self.fine, &mut x, &mut residual, &self.coulomb);
        let residual = self.truncated_residual(&x, residual);
        match &self.linear {
            None => {
                let mut coarse = self.restricted(&residual);
                self.subtract_lifted(&x, &mut coarse);
                self.first.add_times(&self.correction(0, &coarse), &mut x[..b.len()]);
            }
            Some(linear) => {
                let y = self.linear_cycle(linear, &x, &residual);
                linear.prolongation.add_times(&y, &mut x[..b.len()]);
            }
        }
        self.zero_constrained(&mut x);
        self.absolute.backward(&self.fine.matrix, &b, &mut x, &self.coulomb);
        self.stiff.backward(&self.fine.matrix, &b, &mut x);
        self.fine.backward(&b, &mut x);
        scaled(scale, &x[..b.len()])
    }

    /// A residual of the level above the first aggregated one, at own nodes, on the functions of that.
    fn restricted(&self, residual: &[[f32; 3]]) -> Vec<[f32; 6]> {
        let mut coarse = self.first.transpose_times(residual, self.first_coarse());
        self.transfers[0].add(&mut coarse, add_to);
        coarse
    }

    /// One cycle from the linear level on, for the residual that `x` leaves on the finest one; the result at ghosts as well.
    fn linear_cycle(&self, linear: &Linear, x: &[[f32; 3]], residual: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let halo = &linear.level.halo;
        let mut b = linear.prolongation.transpose_times(residual, halo.len());
        halo.add(&mut b, add_to);
        let (mut y, mut residual) = linear.level.forward(&b);
        linear.stiff.forward(&linear.level.matrix, &mut y, &mut residual);
        let mut coarse = self.restricted(&residual);
        if self.has_lifts() {
            // Lifts test the forces of the finest level, as they are before the sweep on this one.
            let before = self.restricted(&b);
            let mut after = before.clone();
            self.subtract_lifted(x, &mut after);
            let change = after.iter().flatten().zip(before.iter().flatten()).map(|(after, before)| after - before);
            coarse.iter_mut().flatten().zip(change).for_each(|(coarse, change)| *coarse += change);
        }
        self.first.add_times(&self.correction(0, &coarse), &mut y[..b.len()]);
        linear.stiff.backward(&linear.level.matrix, &b, &mut y);
        linear.level.backward(&b, &mut y);
        halo.update(&mut y);
        y
    }

    /// Zeroes constrained components.
    fn zero_constrained(&self, x: &mut [[f32; 3]]) {
        for &(place, constrained) in &self.constrained {
            let x = &mut x[self.truncation.node(place) as usize];
            (0..3).filter(|&c| constrained[c]).for_each(|c| x[c] = 0.0);
        }
    }

    /// Nodes of the first aggregated level on this rank, ghosts included.
    fn first_coarse(&self) -> usize {
        self.halos[0].len()
    }

    /// One cycle from this level, for the whole residual at own nodes; the result at own nodes, with ghosts that are not set.
    fn cycle_from(&self, level: usize, b: &[[f32; 6]]) -> Vec<[f32; 6]> {
        let Some(here) = self.coarse.get(level) else { return self.coarsest.solve(b) };
        let (mut x, residual) = here.forward(b);
        let coarser = &self.transfers[level + 1];
        let mut coarse = self.further[level].transpose_times(&residual, coarser.len());
        coarser.add(&mut coarse, add_to);
        self.further[level].add_times(&self.correction(level + 1, &coarse), &mut x[..b.len()]);
        here.backward(b, &mut x);
        x
    }

    /// As many cycles from this level as its cycle index says, each on the residual of those before; the result as that of
    /// [`Self::cycle_from`]. Without Coulomb coupling it is as symmetric and definite as that of one cycle.
    fn cycles_from(&self, level: usize, b: &[[f32; 6]]) -> Vec<[f32; 6]> {
        let mut x = self.cycle_from(level, b);
        let Some(here) = self.coarse.get(level) else { return x };
        for _ in 1..self.cycle_index[level] {
            here.halo.update(&mut x);
            let mut residual = vec![[0.0; 6]; b.len()];
            here.matrix.add_times(&x, &mut residual);
            residual.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(r, b)| *r = b - *r);
            self.subtract_coulomb(level, &x, &mut residual);
            let further = self.cycle_from(level, &residual);
            x.iter_mut().flatten().zip(further.iter().flatten()).for_each(|(x, c)| *x += c);
        }
        x
    }

    /// What cycles from this level correct the next finer one by, for the residual at own nodes of this one: the result at ghosts as
    /// well.
    fn correction(&self, level: usize, b: &[[f32; 6]]) -> Vec<[f32; 6]> {
        let mut x = self.cycles_from(level, b);
        self.transfers[level].update(&mut x);
        x
    }
}

/// The first step of aggregation. A matrix of which ranks have too few nodes to make it coarser well goes to fewer ranks as it is, and so
/// does one that is small enough for a coarsest level and does not get coarser.
fn aggregated(
    a: &Blocks<3, 3>,
    halo: &Halo,
    kernel: &[Kernel<3>],
    groups: &[Vec<u32>],
    ends: Option<&[[u32; 2]]>,
    contact_nodes: &[u32],
) -> Result<Option<Coarser<3>>, Error> {
    let copy = || copied(a, halo, kernel, contact_nodes);
    if halo.is_divided() && halo.total() < Threshold::NODES_PER_RANK * halo.ranks().size() {
        return Ok(copy());
    }
    let is_small = halo.total() <= Threshold::COARSEST_LIMIT;
    Ok(coarsen(a, halo, kernel, Threshold::STRONG, groups, ends, contact_nodes)?
        .or_else(|| is_small.then(copy).flatten()))
}

/// Agglomerates a coarse level that has too few nodes for each rank: groups of consecutive ranks, the larger the fewer nodes
/// there are, give them to one of them, another one for each size of group. Rank 0 has the coarsest level alone.
fn agglomerated<const R: usize>(step: Coarser<R>) -> Coarser<R> {
    let (total, ranks) = (step.halo.total(), step.halo.ranks().size());
    let most = if total <= Threshold::COARSEST_LIMIT { 1 } else { (total / Threshold::NODES_PER_RANK).max(1) };
    // Powers of two: on coarser levels groups are made of whole groups.
    match ranks.div_ceil(most).next_power_of_two() {
        1 => step,
        group if total <= Threshold::COARSEST_LIMIT => gathered(step, group, 0),
        group => gathered(step, group, group / 2),
    }
}

/// The cycle index of each of the `levels` aggregated levels: [`Threshold::CYCLE_INDEX`] where all visits of the level stay
/// within [`Threshold::VISIT_WORK`]; `sizes` is [`Hierarchy::busiest_sizes`]: the other ranks wait for the busiest one.
fn affordable_cycle_index(sizes: &[(usize, usize)], levels: usize) -> Vec<usize> {
    let largest = sizes[..sizes.len() - 1].iter().map(|(_, entries)| *entries).max().unwrap_or(0);
    let budget = Threshold::VISIT_WORK * largest as f64;
    let mut visits = 1;
    let coarse = sizes.windows(2).enumerate().skip(sizes.len() - 1 - levels).map(|(level, pair)| {
        let coarsest = if level + 2 == sizes.len() { pair[1].1 } else { 0 };
        let affordable = budget / (visits * (pair[0].1 + coarsest).max(1)) as f64;
        let index = (affordable as usize).clamp(1, Threshold::CYCLE_INDEX);
        visits *= index;
        index
    });
    coarse.collect()
}
