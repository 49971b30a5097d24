//! Coulomb coupling: the derivative of the slip bound by the normal force ([`NodeConstraint::coulomb`]). The row of a slipping
//! component loses a multiple of the row of the normal component, which is constrained, so that the matrix is unsymmetric.
//!
//! The finest level uses such rows as they are. On the coarse levels the constraint force of a function truncated at
//! constrained components is mostly an artefact of the truncation. It is therefore tested by functions that are not
//! truncated: each coarse node has a *lift*, the function of its own whose normal displacements at the contact nodes are the
//! least-squares fit to the coupled tangential ones.
//!
//! Matrices, sweeps and factors of the coarse levels stay symmetric. The coupling enters the residual that the finest level
//! restricts and the residuals between the cycles on the second coarse level and below it; repeated symmetric cycles on
//! these residuals solve the unsymmetric system. Unsymmetric sweeps and factors are not used because they fail on some meshes.

use super::Hierarchy;
use super::blocks::{Block, Blocks};
use super::dense::{add_product, add_transpose_product, inverse};
use super::packed::{Packed, Single, add_to, add_transposed, single, subtract};
use super::truncation::{NodeConstraint, Truncation, coarser_change};

/// The coupling on the coarse levels.
#[derive(Debug, Clone, Default)]
pub(super) struct CoulombCoupling {
    /// Whether some rank has a lift.
    pub active: bool,
    /// Nodes of the first coarse level that have a lift.
    pub lifts: Vec<(u32, Single<6, 6>)>,
    /// The coupling's part of the touched rows of the second coarse level and of those below.
    rows: Vec<Packed<6, 6>>,
}

/// Thresholds of the coupling on the coarse levels.
struct Threshold;

impl Threshold {
    /// Tikhonov term of the fit over the trace of its matrix: it bounds a lift that few contact nodes determine.
    const REGULAR: f64 = 1e-3;
    /// Largest part of a node's stiffness that the coupling may cancel in the sweeps. Beyond it the node is swept without
    /// coupling, and the directions of the iteration account for it a cycle later.
    const MOST_COUPLED: f64 = 0.5;
}

impl Hierarchy {
    /// Sets the coupling of the coarse levels, after their matrices were changed for the same constraints.
    pub(super) fn couple_coarse_levels(&mut self, constraints: &[NodeConstraint]) {
        let Some(first) = self.coarse.first() else { return };
        let truncation = &self.truncation;
        let reach = &truncation.touched[0];
        let fits: Vec<Fit> = reach.reach.iter().map(|&k| fit(truncation, constraints, k)).collect();
        let fits = reach.values(fits, Fit::default(), |sum, fit| {
            sum.iter_mut().flatten().flatten().zip(fit.iter().flatten().flatten()).for_each(|(a, b)| *a += b);
        });
        let lifts: Vec<Option<Block<6, 6>>> = fits.iter().map(lift).collect();
        let mut rows = first_rows(truncation, constraints, &lifts, &first.matrix, self.halos[0].len());
        for (k, prolongation) in truncation.further.iter().enumerate() {
            let (here, next) = (&truncation.touched[k], &truncation.touched[k + 1]);
            rows = next.rows(coarser_change(&rows, &here.touched, prolongation, &next.reach));
            self.coulomb_coupling.rows.push(Packed::new(&rows));
        }
        let lifts = reach.touched.iter().zip(lifts).filter_map(|(&k, lift)| Some((k, single(&lift?))));
        self.coulomb_coupling.lifts.extend(lifts);
        self.coulomb_coupling.active = true;
    }

    /// The residual of the finest level on functions truncated at constrained components, after a sweep to `x` that left
    /// `residual` in its rows.
    pub(super) fn truncated_residual(&self, x: &[[f32; 3]], mut residual: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        for &(v, coulomb) in &self.coulomb {
            // The sweep has solved the coupled rows up to their own nodes; lifts test the rows of the matrix itself.
            let normal = residual[v as usize][0] - if self.has_lifts() { self.normal_residual(v, x) } else { 0.0 };
            (1..3).for_each(|c| residual[v as usize][c] -= coulomb[c - 1] * normal);
        }
        self.zero_constrained(&mut residual);
        residual
    }

    /// Whether some function of the first aggregated level has a lift.
    pub(super) fn has_lifts(&self) -> bool {
        self.coulomb_coupling.active
    }

    /// Subtracts the forces on the lifts from those on the truncated functions of the first aggregated level, after a sweep to `x`
    /// on the finest.
    pub(super) fn subtract_lifted(&self, x: &[[f32; 3]], coarse: &mut [[f32; 6]]) {
        let halo = &self.transfers[0];
        if !self.has_lifts() {
            return;
        }
        let mut normal = vec![[0.0; 6]; halo.len()];
        for &(place, _) in self.constrained.iter().filter(|(_, constrained)| constrained[0]) {
            let force = self.normal_residual(self.truncation.node(place), x);
            for (j, p) in self.truncation.support.p.entries_of(place as usize) {
                (0..6).for_each(|c| normal[j as usize][c] += p[0][c] as f32 * force);
            }
        }
        halo.add(&mut normal, add_to);
        for (k, lift) in &self.coulomb_coupling.lifts {
            let here = &mut coarse[*k as usize];
            let force: [f32; 6] = std::array::from_fn(|c| here[c] + normal[*k as usize][c]);
            add_transposed(lift, &force.map(|f| -f), here);
        }
    }

    /// The residual in the normal row of a node whose normal component is constrained; the load is zero there.
    fn normal_residual(&self, v: u32, x: &[[f32; 3]]) -> f32 {
        let (columns, blocks) = self.fine.matrix.row(v as usize);
        let mut force = [0.0; 3];
        columns.iter().zip(blocks).for_each(|(&j, a)| subtract(a, &x[j as usize], &mut force));
        force[0]
    }

    /// Subtracts the coupling's part of `A x` from the residual of a coarse level; `x` has its ghosts.
    pub(super) fn subtract_coulomb(&self, level: usize, x: &[[f32; 6]], residual: &mut [[f32; 6]]) {
        let Some(rows) = level.checked_sub(1).and_then(|k| self.coulomb_coupling.rows.get(k)) else { return };
        for (t, &i) in self.truncation.touched[level].touched.iter().enumerate() {
            rows.entries_of(t).for_each(|(j, a)| subtract(a, &x[j as usize], &mut residual[i as usize]));
        }
    }
}

/// The inverse of the free block of `A - [0; coulomb] e1' A` for right-hand sides less `coulomb` times their first row, by
/// the formula of Sherman & Morrison (1950) from `inverse`, that of the free block of `A`.
pub(super) fn coupled_inverse(inverse: &Block<3, 3>, a: &Block<3, 3>, coulomb: [f64; 2]) -> Block<3, 3> {
    let f = [0.0, coulomb[0], coulomb[1]];
    let left: [f64; 3] = std::array::from_fn(|r| (0..3).map(|c| inverse[r][c] * f[c]).sum());
    let right: [f64; 3] = std::array::from_fn(|c| (0..3).map(|r| a[0][r] * inverse[r][c]).sum());
    let taken: f64 = (0..3).map(|r| a[0][r] * left[r]).sum();
    if coulomb == [0.0; 2] || taken > Threshold::MOST_COUPLED {
        return *inverse;
    }
    let factor = 1.0 / (1.0 - taken);
    let mut result: Block<3, 3> =
        std::array::from_fn(|r| std::array::from_fn(|c| inverse[r][c] + factor * left[r] * right[c]));
    (1..3).for_each(|r| result[r][0] = -factor * left[r]);
    result
}

/// The least-squares problem of a lift: its matrix and its right-hand side.
type Fit = [Block<6, 6>; 2];

/// What the contact nodes of this rank contribute to the lift of a node of the first coarse level.
fn fit(truncation: &Truncation, constraints: &[NodeConstraint], k: u32) -> Fit {
    let [mut gram, mut right] = Fit::default();
    for (i, p) in truncation.support.p_column(k) {
        add_transpose_product(p, p, &mut gram);
        let coulomb = constraints[i].coulomb;
        if coulomb != [0.0; 2] {
            let normal = std::array::from_fn(|c| coulomb[0] * p[1][c] + coulomb[1] * p[2][c]);
            add_transpose_product(p, &[normal, [0.0; 6], [0.0; 6]], &mut right);
        }
    }
    [gram, right]
}

/// The lift; `None` without coupled contact nodes in its support.
fn lift([gram, right]: &Fit) -> Option<Block<6, 6>> {
    if *right == [[0.0; 6]; 6] {
        return None;
    }
    let mut gram = *gram;
    let trace: f64 = (0..6).map(|c| gram[c][c]).sum();
    (0..6).for_each(|c| gram[c][c] += Threshold::REGULAR * trace);
    let mut lift = [[0.0; 6]; 6];
    add_product(&inverse(&gram), right, &mut lift);
    Some(lift)
}

/// The coupling's part of the touched rows of the first coarse level: `-Lᵀ Pᵀ A (I - S) P` with the lifts `L` and the projector `S` on constrained
/// components; `lifts` are those of touched rows, and the level has `cols` nodes here.
fn first_rows(
    truncation: &Truncation,
    constraints: &[NodeConstraint],
    lifts: &[Option<Block<6, 6>>],
    matrix: &Packed<6, 6>,
    cols: usize,
) -> Blocks<6, 6> {
    let reach = &truncation.touched[0];
    let numbers: Vec<u32> = lifts.iter().map(|lift| u32::from(lift.is_some())).collect();
    let values: Vec<Block<6, 6>> = lifts.iter().map(|lift| lift.unwrap_or_default()).collect();
    // The contact nodes of this rank reach rows of others, whose lifts are those of their owners.
    let (has, values) = (reach.back(&numbers, 0), reach.back(&values, [[0.0; 6]; 6]));
    let mut free = vec![0];
    reach.touched.iter().for_each(|&i| free.push(free[free.len() - 1] + matrix.row(i as usize).0.len()));
    // Where each row of `reach` stands among the touched ones of this rank: the first part of a row comes from its owner.
    let owned = |t: usize| reach.owned(t);
    let named = |t: usize, name: &mut dyn FnMut(u32)| {
        if has[t] == 0 {
            return;
        }
        match owned(t) {
            Some(own) => matrix.row(reach.touched[own] as usize).0.iter().for_each(|&j| name(j)),
            None => {
                let nodes = truncation.support.a_times_p_column(reach.reach[t]);
                nodes.for_each(|(i, _)| truncation.support.p.row(i).0.iter().for_each(|&j| name(j)));
            }
        }
    };
    let rows = Blocks::from_rows(
        reach.reach.len(),
        cols,
        named,
        #[inline(always)]
        |t, target| {
            if has[t] == 0 {
                return;
            }
            let (lift, own) = (&values[t], owned(t));
            if let Some(own) = own {
                let minus = lift.map(|row| row.map(|v| -v));
                let columns = matrix.row(reach.touched[own] as usize).0;
                for (&j, a) in columns.iter().zip(&truncation.rows[0].free[free[own]..free[own + 1]]) {
                    add_transpose_product(&minus, a, target.at(j));
                }
            }
            for (i, part) in truncation.support.a_times_p_column(reach.reach[t]) {
                let constrained = constraints[i].constrained;
                if constrained == [false; 3] {
                    continue;
                }
                let constrained: Block<3, 6> = std::array::from_fn(|r| if constrained[r] { part[r] } else { [0.0; 6] });
                let mut lifted = [[0.0; 6]; 3];
                add_product(&constrained, lift, &mut lifted);
                let (columns, blocks) = truncation.support.p.row(i);
                let within =
                    |j: &u32| own.is_none_or(|own| matrix.row(reach.touched[own] as usize).0.binary_search(j).is_ok());
                let within = columns.iter().zip(blocks).filter(|(j, _)| within(j));
                for (&j, p) in within {
                    add_transpose_product(&lifted, p, target.at(j));
                }
            }
        },
    );
    reach.rows(rows)
}
