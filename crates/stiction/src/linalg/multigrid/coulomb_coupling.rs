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
use super::packed::{Packed, Single, add_transposed, single, subtract};
use super::truncation::{NodeConstraint, Truncation, coarser_change};

/// The coupling on the coarse levels.
#[derive(Debug, Clone, Default)]
pub(super) struct CoulombCoupling {
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
        if constraints.iter().all(|c| c.coulomb == [0.0; 2]) {
            return;
        }
        let truncation = &self.truncation;
        let lifts: Vec<Option<Block<6, 6>>> =
            truncation.touched[0].iter().map(|&k| lift(truncation, constraints, k)).collect();
        let mut rows = first_rows(truncation, constraints, &lifts, &first.matrix);
        for (k, prolongation) in self.further.iter().enumerate() {
            rows = coarser_change(&rows, &truncation.touched[k], prolongation, &truncation.touched[k + 1]);
            self.coulomb_coupling.rows.push(Packed::new(&rows));
        }
        let lifts = truncation.touched[0].iter().zip(lifts).filter_map(|(&k, lift)| Some((k, single(&lift?))));
        self.coulomb_coupling.lifts.extend(lifts);
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
        !self.coulomb_coupling.lifts.is_empty()
    }

    /// Subtracts the forces on the lifts from those on the truncated functions of the first aggregated level, after a sweep to
    /// `x` on the finest.
    pub(super) fn subtract_lifted(&self, x: &[[f32; 3]], coarse: &mut [[f32; 6]]) {
        if !self.has_lifts() {
            return;
        }
        let mut normal = vec![[0.0; 6]; coarse.len()];
        for &(place, _) in self.constrained.iter().filter(|(_, constrained)| constrained[0]) {
            let force = self.normal_residual(self.truncation.node(place), x);
            for (j, p) in self.truncation.support.p.entries_of(place as usize) {
                (0..6).for_each(|c| normal[j as usize][c] += p[0][c] as f32 * force);
            }
        }
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

    /// Subtracts the coupling's part of `A x` from the residual of a coarse level.
    pub(super) fn subtract_coulomb(&self, level: usize, x: &[[f32; 6]], residual: &mut [[f32; 6]]) {
        let Some(rows) = level.checked_sub(1).and_then(|k| self.coulomb_coupling.rows.get(k)) else { return };
        for (t, &i) in self.truncation.touched[level].iter().enumerate() {
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

/// The lift of a node of the first coarse level; `None` without coupled contact nodes in its support.
fn lift(truncation: &Truncation, constraints: &[NodeConstraint], k: u32) -> Option<Block<6, 6>> {
    let (mut gram, mut right) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
    for (i, p) in truncation.support.p_column(k) {
        add_transpose_product(p, p, &mut gram);
        let coulomb = constraints[i].coulomb;
        if coulomb != [0.0; 2] {
            let normal = std::array::from_fn(|c| coulomb[0] * p[1][c] + coulomb[1] * p[2][c]);
            add_transpose_product(p, &[normal, [0.0; 6], [0.0; 6]], &mut right);
        }
    }
    if right == [[0.0; 6]; 6] {
        return None;
    }
    let trace: f64 = (0..6).map(|c| gram[c][c]).sum();
    (0..6).for_each(|c| gram[c][c] += Threshold::REGULAR * trace);
    let mut lift = [[0.0; 6]; 6];
    add_product(&inverse(&gram), &right, &mut lift);
    Some(lift)
}

/// The coupling's part of the touched rows of the first coarse level: `-Lᵀ Pᵀ A (I - S) P` with the lifts `L` and the projector `S` on constrained
/// components.
fn first_rows(
    truncation: &Truncation,
    constraints: &[NodeConstraint],
    lifts: &[Option<Block<6, 6>>],
    matrix: &Packed<6, 6>,
) -> Blocks<6, 6> {
    let touched = &truncation.touched[0];
    let row = |t: usize| matrix.row(touched[t] as usize).0;
    let mut free = vec![0];
    (0..touched.len()).for_each(|t| free.push(free[t] + row(t).len()));
    let reached = |t: usize, name: &mut dyn FnMut(u32)| {
        if lifts[t].is_some() {
            row(t).iter().for_each(|&j| name(j));
        }
    };
    Blocks::from_rows(touched.len(), matrix.rows, reached, |t, target| {
        let Some(lift) = &lifts[t] else { return };
        let minus = lift.map(|row| row.map(|v| -v));
        for (&j, a) in row(t).iter().zip(&truncation.free[0][free[t]..free[t + 1]]) {
            add_transpose_product(&minus, a, target.at(j));
        }
        for (i, part) in truncation.support.a_times_p_column(touched[t]) {
            let constrained = constraints[i].constrained;
            if constrained == [false; 3] {
                continue;
            }
            let constrained: Block<3, 6> = std::array::from_fn(|r| if constrained[r] { part[r] } else { [0.0; 6] });
            let mut lifted = [[0.0; 6]; 3];
            add_product(&constrained, lift, &mut lifted);
            let (columns, blocks) = truncation.support.p.row(i);
            let within = columns.iter().zip(blocks).filter(|(j, _)| row(t).binary_search(j).is_ok());
            within.for_each(|(&j, p)| add_transpose_product(&lifted, p, target.at(j)));
        }
    })
}
