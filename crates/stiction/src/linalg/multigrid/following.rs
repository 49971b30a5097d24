//! Friction that grows with the normal force ([`Condition::follows`]): the row of a slipping component loses a multiple of
//! the row of the normal component, which is held.
//!
//! The finest level takes such rows as they are. On the coarse ones the force that holds a node is not what it is on the
//! finest: of a function truncated at held components it is mostly what truncation itself costs. So it is tested by
//! functions that are not truncated: each coarse node has a *lift*, the function of its own whose normal displacements at
//! contact nodes are nearest to what follows there from the tangential ones.
//!
//! Matrices, sweeps and factors of the coarse levels stay symmetric. The force is only part of the residuals between the
//! cycles on the second coarse level and on the ones below, and of what the finest level hands down: repeating symmetric
//! cycles on such residuals solves the unsymmetric system. A cycle costs hardly more; the rows are made anew at each change
//! of the conditions. Sweeps and factors of the unsymmetric matrices themselves saved as many cycles on most meshes, and
//! failed on some.

use super::Multigrid;
use super::blocks::{Block, Blocks};
use super::dense::{add_product, add_transpose_product, inverse};
use super::packed::{Packed, Single, add_transposed, single, subtract};
use super::truncate::{Condition, Local, coarser_change};

/// What the coarse levels know of it.
#[derive(Debug, Clone, Default)]
pub struct Following {
    /// Nodes of the first coarse level that have a lift.
    pub lifts: Vec<(u32, Single<6, 6>)>,
    /// What the touched rows of the second coarse level, and of the ones below, gain.
    rows: Vec<Packed<6, 6>>,
}

/// Share of the diagonal that keeps a lift bounded where contact nodes do not determine it.
const REGULAR: f64 = 1e-3;

impl Multigrid {
    /// Tells the coarse levels what follows under the conditions they were changed to.
    pub(super) fn follow(&mut self, conditions: &[Condition]) {
        let Some(first) = self.coarse.first() else { return };
        if conditions.iter().all(|c| c.follows == [0.0; 2]) {
            return;
        }
        let local = &self.local;
        let lifts: Vec<Option<Block<6, 6>>> = local.touched[0].iter().map(|&k| lift(local, conditions, k)).collect();
        let mut rows = first_rows(local, conditions, &lifts, &first.matrix);
        for (k, prolongation) in self.further.iter().enumerate() {
            rows = coarser_change(&rows, &local.touched[k], prolongation, &local.touched[k + 1]);
            self.following.rows.push(Packed::new(&rows));
        }
        let lifts = local.touched[0].iter().zip(lifts).filter_map(|(&k, lift)| Some((k, single(&lift?))));
        self.following.lifts.extend(lifts);
    }

    /// The residual of the finest level for the first coarse one, after a sweep to `x` that left `residual` in its rows.
    pub(super) fn hand_down(&self, x: &[[f32; 3]], mut residual: Vec<[f32; 3]>) -> Vec<[f32; 6]> {
        let lifts = &self.following.lifts;
        for &(v, follows) in &self.follows {
            // The sweep has met rows less what follows, up to their own nodes. Lifts test rows as they are.
            let normal = residual[v as usize][0] - if lifts.is_empty() { 0.0 } else { self.holding(v, x) };
            (1..3).for_each(|c| residual[v as usize][c] -= follows[c - 1] * normal);
        }
        self.hold(&mut residual);
        let mut coarse = self.first.transpose_times(&residual, self.first_coarse());
        if lifts.is_empty() {
            return coarse;
        }
        let mut normal = vec![[0.0; 6]; coarse.len()];
        for &(v, _) in self.held.iter().filter(|(_, held)| held[0]) {
            let force = [self.holding(v, x), 0.0, 0.0];
            let (columns, blocks) = self.first.row(v as usize);
            columns.iter().zip(blocks).for_each(|(&j, p)| add_transposed(p, &force, &mut normal[j as usize]));
        }
        for (k, lift) in lifts {
            let here = &mut coarse[*k as usize];
            let force: [f32; 6] = std::array::from_fn(|c| here[c] + normal[*k as usize][c]);
            add_transposed(lift, &force.map(|f| -f), here);
        }
        coarse
    }

    /// The residual in the normal row of a node that holds it, where the load is zero.
    fn holding(&self, v: u32, x: &[[f32; 3]]) -> f32 {
        let (columns, blocks) = self.fine.matrix.row(v as usize);
        let mut force = [0.0; 3];
        columns.iter().zip(blocks).for_each(|(&j, a)| subtract(a, &x[j as usize], &mut force));
        force[0]
    }

    /// Takes what follows from `x` off the residual of a coarse level.
    pub(super) fn subtract_following(&self, level: usize, x: &[[f32; 6]], residual: &mut [[f32; 6]]) {
        let Some(rows) = level.checked_sub(1).and_then(|k| self.following.rows.get(k)) else { return };
        for (t, &i) in self.local.touched[level].iter().enumerate() {
            let (columns, blocks) = rows.row(t);
            columns.iter().zip(blocks).for_each(|(&j, a)| subtract(a, &x[j as usize], &mut residual[i as usize]));
        }
    }
}

/// What following may take of the resistance of a node at most; beyond, its sweeps leave it to the next cycle.
const FOLLOWED: f64 = 0.5;

/// The inverse of the free block of `A - [0; follows] e1' A`, applied to rows less `follows` times the first: from that of
/// the free block of `A` by the formula of Sherman & Morrison (1950).
pub(super) fn following(inverse: &Block<3, 3>, a: &Block<3, 3>, follows: [f64; 2]) -> Block<3, 3> {
    let f = [0.0, follows[0], follows[1]];
    let left: [f64; 3] = std::array::from_fn(|r| (0..3).map(|c| inverse[r][c] * f[c]).sum());
    let right: [f64; 3] = std::array::from_fn(|c| (0..3).map(|r| a[0][r] * inverse[r][c]).sum());
    let taken: f64 = (0..3).map(|r| a[0][r] * left[r]).sum();
    if follows == [0.0; 2] || taken > FOLLOWED {
        return *inverse;
    }
    let share = 1.0 / (1.0 - taken);
    let mut result: Block<3, 3> =
        std::array::from_fn(|r| std::array::from_fn(|c| inverse[r][c] + share * left[r] * right[c]));
    (1..3).for_each(|r| result[r][0] = -share * left[r]);
    result
}

/// The lift of a node of the first coarse level; none where nothing follows.
fn lift(local: &Local, conditions: &[Condition], k: u32) -> Option<Block<6, 6>> {
    let (mut gram, mut right) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
    for (i, p) in local.p_column(k) {
        add_transpose_product(p, p, &mut gram);
        let follows = conditions[i].follows;
        if follows != [0.0; 2] {
            let normal = std::array::from_fn(|c| follows[0] * p[1][c] + follows[1] * p[2][c]);
            add_transpose_product(p, &[normal, [0.0; 6], [0.0; 6]], &mut right);
        }
    }
    if right == [[0.0; 6]; 6] {
        return None;
    }
    let trace: f64 = (0..6).map(|c| gram[c][c]).sum();
    (0..6).for_each(|c| gram[c][c] += REGULAR * trace);
    let mut lift = [[0.0; 6]; 6];
    add_product(&inverse(&gram), &right, &mut lift);
    Some(lift)
}

/// What the touched rows of the first coarse level gain: `-Lᵀ Pᵀ A (I - S) P` with the lifts `L` and the projector `S` on held
/// components.
fn first_rows(
    local: &Local,
    conditions: &[Condition],
    lifts: &[Option<Block<6, 6>>],
    matrix: &Packed<6, 6>,
) -> Blocks<6, 6> {
    let touched = &local.touched[0];
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
        for (&j, a) in row(t).iter().zip(&local.free[0][free[t]..free[t + 1]]) {
            add_transpose_product(&minus, a, target.at(j));
        }
        for (i, part) in local.a_times_p_column(touched[t]) {
            let held = conditions[i].held;
            if held == [false; 3] {
                continue;
            }
            let held: Block<3, 6> = std::array::from_fn(|r| if held[r] { part[r] } else { [0.0; 6] });
            let mut lifted = [[0.0; 6]; 3];
            add_product(&held, lift, &mut lifted);
            let (columns, blocks) = local.p.row(i);
            let within = columns.iter().zip(blocks).filter(|(j, _)| row(t).binary_search(j).is_ok());
            within.for_each(|(&j, p)| add_transpose_product(&lifted, p, target.at(j)));
        }
    })
}
