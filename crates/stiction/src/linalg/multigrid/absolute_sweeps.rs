//! Sweeps that move the nodes that others are measured from, and leave these others where they are.
//!
//! In relative coordinates a step of a node drags along its followers, the nodes that are measured from it. That is right where
//! they stick to it. Where they slide or are open, the motion of the node alone is what the sweeps have to smooth, and it is a combination
//! of steps of many nodes. The functions of this space are those motions: a unit of a component of the node, and the relative
//! displacement by which the free components of its followers stay in place. Their matrix is that of the constrained problem, swept by
//! Gauss-Seidel forward before the coarse correction and backward after it, so that the cycle stays symmetric.
//!
//! Each rank sweeps the functions of its own nodes with its own followers; between ranks these sweeps are Jacobi's, with damped steps.

use super::blocks::{Block, Blocks};
use super::dense::{add_product, add_transpose_product, square};
use super::packed::{Packed, Single, add, add_transposed, double, single, subtract};
use super::relative_coordinates::{RelativeCoordinates, places};
use super::smoother::Level;
use super::truncation::NodeConstraint;
use crate::ranks::Halo;

/// The nodes that others are measured from, and the space of their motions alone.
#[derive(Debug, Clone)]
pub(super) struct AbsoluteSweeps {
    /// Nodes that others are measured from.
    nodes: Vec<u32>,
    /// By the places of the nodes that may be constrained, what each is measured from: columns are places in `nodes`.
    followers: Blocks<3, 3>,
    /// The exchange of steps at nodes that functions may move, and that of values at the ghosts in the rows of these nodes.
    steps: Halo,
    near: Halo,
    /// Which components are constrained in the space.
    constrained: Vec<[bool; 3]>,
    space: Option<Space>,
}

/// The functions for some constraints.
#[derive(Debug, Clone)]
struct Space {
    /// The nodes that the functions move, and the place of each among the nodes that may be constrained; `u32::MAX` if it is none.
    moved: Vec<(u32, u32)>,
    /// The functions at these nodes.
    functions: Packed<3, 3>,
    /// Stiffness that constraints add to the diagonal blocks of these nodes.
    springs: Vec<Single<3, 3>>,
    level: Level<3, 4>,
}

impl AbsoluteSweeps {
    /// Of the contact nodes of the finest level; all ranks make theirs together.
    pub(super) fn new(relative: Option<&RelativeCoordinates>, contact_nodes: &[u32], fine: &Level<3, 4>) -> Self {
        let own = fine.matrix.rows;
        let rows = relative.map(|relative| relative.rows_of(contact_nodes));
        let measured_from = |i: usize| rows.iter().flat_map(move |rows| rows(i)).filter(|(j, _)| (*j as usize) < own);
        let mut nodes: Vec<u32> = (0..contact_nodes.len()).flat_map(|i| measured_from(i).map(|(j, _)| j)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = places(&nodes, own);
        let named = |i: usize, name: &mut dyn FnMut(u32)| measured_from(i).for_each(|(j, _)| name(place[j as usize]));
        let followers: Blocks<3, 3> = Blocks::from_rows(contact_nodes.len(), nodes.len(), named, |i, row| {
            measured_from(i).for_each(|(j, block)| *row.at(place[j as usize]) = *block);
        });
        let follows = |i: &usize| !followers.row(*i).0.is_empty();
        let moved = (0..contact_nodes.len()).filter(follows).map(|i| contact_nodes[i]).chain(nodes.iter().copied());
        let moved: Vec<u32> = moved.collect();
        let steps = fine.halo.of_flagged(&moved);
        let near = fine.halo.only(moved.iter().flat_map(|&v| fine.matrix.row(v as usize).0).copied());
        AbsoluteSweeps { nodes, followers, steps, near, constrained: Vec::new(), space: None }
    }

    /// Takes the constraints of the contact nodes. The functions change where components are constrained or released, or if
    /// `renewed`; otherwise only the springs do.
    pub(super) fn constrain(
        &mut self,
        constraints: &[NodeConstraint],
        contact_nodes: &[u32],
        fine: &Packed<3, 3>,
        renewed: bool,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let constrained = constraints.iter().map(|c| c.constrained);
        if renewed || !constrained.clone().eq(self.constrained.iter().copied()) {
            self.constrained = constrained.collect();
            self.space = self.space(constraints, contact_nodes, fine);
        } else if let Some(Space { moved, springs, .. }) = &mut self.space {
            springs
                .iter_mut()
                .zip(moved)
                .for_each(|(spring, (_, place))| *spring = single(&spring_at(constraints, *place)));
        }
    }

    /// The space for these constraints; `None` where all followers stick.
    fn space(&self, constraints: &[NodeConstraint], contact_nodes: &[u32], fine: &Packed<3, 3>) -> Option<Space> {
        let contact = places(contact_nodes, fine.rows);
        // Components that are unknowns: others have empty rows.
        let free = |v: u32| -> [bool; 3] {
            let (columns, blocks) = fine.row(v as usize);
            let block = columns.binary_search(&v).map_or([[0.0; 3]; 3], |place| blocks[place]);
            let held = self.constrained.get(contact[v as usize] as usize).copied().unwrap_or_default();
            std::array::from_fn(|c| !held[c] && block[c][c] > 0.0)
        };
        let follows: Vec<[bool; 3]> = contact_nodes.iter().map(|&v| free(v)).collect();
        // A node is left in place only where a free component of it is measured from the other one.
        let is_dragged = |i: usize, block: &Block<3, 3>| (0..3).any(|r| follows[i][r] && block[r] != [0.0; 3]);
        let dragged_by = |i: usize| {
            let all = self.followers.entries_of(i);
            all.filter(move |(_, block)| is_dragged(i, block))
        };
        let is_follower = |i: usize| dragged_by(i).next().is_some();
        let followers: Vec<usize> = (0..contact_nodes.len()).filter(|&i| is_follower(i)).collect();
        let mut alone: Vec<u32> = followers.iter().flat_map(|&i| dragged_by(i).map(|(k, _)| k)).collect();
        alone.sort_unstable();
        alone.dedup();
        if alone.is_empty() {
            return None;
        }
        let column = places(&alone, self.nodes.len());
        let nodes: Vec<u32> = alone.iter().map(|&k| self.nodes[k as usize]).collect();
        let own_column = places(&nodes, fine.rows);
        let mut moved: Vec<u32> = followers.iter().map(|&i| contact_nodes[i]).chain(nodes.iter().copied()).collect();
        moved.sort_unstable();
        moved.dedup();
        let moved: Vec<(u32, u32)> = moved.into_iter().map(|v| (v, contact[v as usize])).collect();
        let moves: Vec<[bool; 3]> = nodes.iter().map(|&v| free(v)).collect();
        let as_follower = |place: u32| Some(place as usize).filter(|&i| i < follows.len() && is_follower(i));
        let named = |t: usize, name: &mut dyn FnMut(u32)| {
            let (v, place) = moved[t];
            Some(own_column[v as usize]).filter(|k| *k != u32::MAX).into_iter().for_each(&mut *name);
            as_follower(place).into_iter().for_each(|i| dragged_by(i).for_each(|(k, _)| name(column[k as usize])));
        };
        let functions: Blocks<3, 3> = Blocks::from_rows(moved.len(), nodes.len(), named, |t, row| {
            let (v, place) = moved[t];
            if let Some(k) = Some(own_column[v as usize]).filter(|k| *k != u32::MAX) {
                let block = row.at(k);
                (0..3).filter(|&c| moves[k as usize][c]).for_each(|c| block[c][c] += 1.0);
            }
            let Some(i) = as_follower(place) else { return };
            for (k, block) in dragged_by(i) {
                let k = column[k as usize];
                let target = row.at(k);
                for r in (0..3).filter(|&r| follows[i][r]) {
                    (0..3).filter(|&c| moves[k as usize][c]).for_each(|c| target[r][c] += block[r][c]);
                }
            }
        });
        let springs: Vec<Block<3, 3>> = moved.iter().map(|(_, place)| spring_at(constraints, *place)).collect();
        let matrix = galerkin(fine, &moved, &springs, &functions);
        let springs = springs.iter().map(single).collect();
        let mut level = Level::new(&matrix, Halo::alone(nodes.len()));
        if !self.steps.is_alone() {
            self.damp(&mut level, fine, &moved, &functions, &matrix);
        }
        Some(Space { moved, functions: Packed::new(&functions), springs, level })
    }

    /// Damps the steps of functions that are coupled with those of other ranks, as [`Level::damp`] does. Their diagonal blocks count
    /// as that of the function itself, and norms of blocks as those of multiples of the identity: `|A| |F| / (3 |D|)^1/2` in Frobenius'
    /// norms. Without the root two bodies of hexahedra of twenty nodes take 30 cycles on 8 ranks in place of 27.
    fn damp(
        &self,
        level: &mut Level<3, 4>,
        fine: &Packed<3, 3>,
        moved: &[(u32, u32)],
        functions: &Blocks<3, 3>,
        matrix: &Blocks<3, 3>,
    ) {
        let mut is_moved = vec![false; self.steps.len()];
        let ghosts = self.steps.neighbours().0.iter().flat_map(|(_, places)| places);
        ghosts.for_each(|&g| is_moved[g as usize] = true);
        let mut sums = vec![0.0; functions.cols];
        for (t, &(v, _)) in moved.iter().enumerate() {
            let coupled = fine.entries_of(v as usize).filter(|(j, _)| is_moved[*j as usize]);
            let coupled: f64 = coupled.map(|(_, block)| square(&double(block)).sqrt()).sum();
            if coupled > 0.0 {
                functions.entries_of(t).for_each(|(k, f)| sums[k as usize] += coupled * square(f).sqrt());
            }
        }
        for (k, sum) in sums.into_iter().enumerate().filter(|(_, sum)| *sum > 0.0) {
            let sum = sum / (3.0 * square(&matrix.diagonal(k))).sqrt();
            let damping = if sum > 1.0 { (2.0 / (1.0 + sum)) as f32 } else { 1.0 };
            level.inverse[k].iter_mut().flatten().for_each(|value| *value *= damping);
        }
    }

    /// Sweeps forward for `residual`, adds the step to `x`, and takes what it balances off the residual. `coulomb` are the nodes with a
    /// Coulomb coupling, whose rows come without it. `x` has its ghosts, before and after.
    pub(super) fn forward(
        &self,
        fine: &Level<3, 4>,
        x: &mut [[f32; 3]],
        residual: &mut [[f32; 3]],
        coulomb: &[(u32, [f32; 2])],
    ) {
        let own = fine.matrix.rows;
        let mut step = Vec::new();
        if let Some(space) = &self.space {
            let (y, _) = space.level.forward(&space.tested(coulomb, own, |t| residual[space.moved[t].0 as usize]));
            step = space.steps(&y);
            for ((&(v, _), step), spring) in space.moved.iter().zip(&step).zip(&space.springs) {
                (0..3).for_each(|c| x[v as usize][c] += step[c]);
                let minus = step.map(|s| -s);
                // The matrix is symmetric: its columns are its rows.
                for (j, a) in fine.matrix.entries_of(v as usize).filter(|(j, _)| (*j as usize) < own) {
                    add_transposed(a, &minus, &mut residual[j as usize]);
                }
                subtract(spring, step, &mut residual[v as usize]);
            }
        }
        if self.steps.is_alone() {
            return;
        }
        let mut all = vec![[0.0; 3]; own];
        let moved = self.space.iter().flat_map(|space| &space.moved);
        moved.zip(step).for_each(|((v, _), step)| all[*v as usize] = step);
        self.steps.update(&mut all);
        if self.steps.neighbours().0.is_empty() {
            return;
        }
        x[own..].iter_mut().zip(&all[own..]).for_each(|(x, step)| (0..3).for_each(|c| x[c] += step[c]));
        fine.subtract_ghosts(&all, residual);
    }

    /// Sweeps backward for `A x = b` from `x`, whose ghosts are set before and not after; `coulomb` as for [`Self::forward`].
    pub(super) fn backward(
        &self,
        fine: &Packed<3, 3>,
        b: &[[f32; 3]],
        x: &mut Vec<[f32; 3]>,
        coulomb: &[(u32, [f32; 2])],
    ) {
        self.near.update(x);
        let Some(space) = &self.space else { return };
        let left = |t: usize| {
            let v = space.moved[t].0 as usize;
            let mut left = b[v];
            fine.entries_of(v).for_each(|(j, a)| subtract(a, &x[j as usize], &mut left));
            subtract(&space.springs[t], &x[v], &mut left);
            left
        };
        let mut y = vec![[0.0; 3]; space.level.matrix.rows];
        space.level.backward(&space.tested(coulomb, fine.rows, left), &mut y);
        for (&(v, _), step) in space.moved.iter().zip(space.steps(&y)) {
            (0..3).for_each(|c| x[v as usize][c] += step[c]);
        }
    }
}

impl Space {
    /// The forces on the functions, by the residual at each moved node in rows without the Coulomb coupling.
    fn tested(&self, coulomb: &[(u32, [f32; 2])], nodes: usize, residual: impl Fn(usize) -> [f32; 3]) -> Vec<[f32; 3]> {
        let coupling = places(&coulomb.iter().map(|(v, _)| *v).collect::<Vec<_>>(), nodes);
        let coupled = |(t, (v, _)): (usize, &(u32, u32))| {
            let mut force = residual(t);
            if let Some((_, factors)) = coulomb.get(coupling[*v as usize] as usize) {
                let normal = force[0];
                (1..3).for_each(|c| force[c] -= factors[c - 1] * normal);
            }
            force
        };
        let forces: Vec<[f32; 3]> = self.moved.iter().enumerate().map(coupled).collect();
        self.functions.transpose_times(&forces, self.level.matrix.rows)
    }

    /// What the functions with the factors `y` move the nodes by.
    fn steps(&self, y: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let step = |t: usize| {
            let mut step = [0.0; 3];
            self.functions.entries_of(t).for_each(|(k, f)| add(f, &y[k as usize], &mut step));
            step
        };
        (0..self.moved.len()).map(step).collect()
    }
}

/// What the constraint of the node at a place adds to its diagonal block.
fn spring_at(constraints: &[NodeConstraint], place: u32) -> Block<3, 3> {
    constraints.get(place as usize).map_or([[0.0; 3]; 3], |constraint| constraint.spring)
}

/// `Fᵀ (A + springs) F` with the functions `F`, which vanish but at the nodes `moved`.
fn galerkin(
    fine: &Packed<3, 3>,
    moved: &[(u32, u32)],
    springs: &[Block<3, 3>],
    functions: &Blocks<3, 3>,
) -> Blocks<3, 3> {
    let at = places(&moved.iter().map(|(v, _)| *v).collect::<Vec<_>>(), fine.rows);
    let near = |t: usize| {
        let entries = fine
            .entries_of(moved[t].0 as usize)
            .map(|(j, block)| (at.get(j as usize).copied().unwrap_or(u32::MAX), block));
        entries.filter(|(place, _)| *place != u32::MAX)
    };
    let reached = |t: usize, name: &mut dyn FnMut(u32)| {
        near(t).for_each(|(place, _)| functions.row(place as usize).0.iter().for_each(|&k| name(k)));
        functions.row(t).0.iter().for_each(|&k| name(k));
    };
    let right: Blocks<3, 3> = Blocks::from_rows(moved.len(), functions.cols, reached, |t, row| {
        for (place, block) in near(t) {
            let block = double(block);
            functions.entries_of(place as usize).for_each(|(k, f)| add_product(&block, f, row.at(k)));
        }
        functions.entries_of(t).for_each(|(k, f)| add_product(&springs[t], f, row.at(k)));
    });
    let (start, entry) = functions.by_columns(moved.len());
    let from = |k: usize| entry[start[k]..start[k + 1]].iter();
    let reached = |k: usize, name: &mut dyn FnMut(u32)| {
        from(k).for_each(|&(t, _)| right.row(t as usize).0.iter().for_each(|&j| name(j)));
    };
    Blocks::from_rows(functions.cols, functions.cols, reached, |k, row| {
        for &(t, place) in from(k) {
            let function = &functions.value[place as usize];
            right.entries_of(t as usize).for_each(|(j, block)| add_transpose_product(function, block, row.at(j)));
        }
    })
}
