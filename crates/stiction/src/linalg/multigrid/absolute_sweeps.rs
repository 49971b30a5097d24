//! Sweeps that move the nodes that others are measured from, and leave these others where they are.
//!
//! In relative coordinates a step of a node drags along its followers, the nodes that are measured from it. That is right where
//! they stick to it. Where they slide or are open, the motion of the node alone is what the sweeps have to smooth, and it is a combination
//! of steps of many nodes. The functions of this space are those motions: a unit of a component of the node, and the relative
//! displacement by which the free components of its followers stay in place. Their matrix is that of the constrained problem, swept by
//! Gauss-Seidel forward before the coarse correction and backward after it, so that the cycle stays symmetric.
//!
//! Each rank sweeps the functions of its own nodes with its own followers; between ranks these sweeps are Jacobi's, with damped steps.

use super::blocks::{Block, Blocks, by_columns};
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
    /// The constraints of the space; a spring is that of its matrix.
    held: Vec<NodeConstraint>,
    space: Option<Space>,
}

/// A spring whose change is smaller than this part of it and of the body at the node is the same to the matrix of the functions: 300 random
/// cases take 5,979 cycles with the matrix made anew in every change, 5,956 with 0.1 and 5,908 with 0.5.
const SAME_SPRING: f64 = 0.5;

/// The functions for some constraints.
#[derive(Debug, Clone)]
struct Space {
    /// The nodes that the functions move alone, by their places in those that others are measured from.
    alone: Vec<u32>,
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
        AbsoluteSweeps { nodes, followers, steps, near, held: Vec::new(), space: None }
    }

    /// There are no sweeps until the next constraints, which make all of the matrix anew.
    pub(super) fn forget(&mut self) {
        self.held.clear();
        self.space = None;
    }

    /// Takes the constraints of the contact nodes. The functions change where components are constrained or released, or if
    /// `renewed` also where springs do; otherwise only the springs do.
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
        let differs = |(new, old): (&NodeConstraint, &NodeConstraint)| new.constrained != old.constrained;
        let is_first = self.held.len() != constraints.len();
        if !renewed && !is_first && !constraints.iter().zip(&self.held).any(differs) {
            if let Some(Space { moved, springs, .. }) = &mut self.space {
                springs
                    .iter_mut()
                    .zip(moved)
                    .for_each(|(spring, (_, place))| *spring = single(&spring_at(constraints, *place)));
            }
            return;
        }
        self.held.resize(constraints.len(), NodeConstraint::default());
        let is_other = |(new, old): (&NodeConstraint, &NodeConstraint), v: u32| {
            let change = |r: usize, c: usize| new.spring[r][c] - old.spring[r][c];
            let change = largest_entry(&std::array::from_fn(|r| std::array::from_fn(|c| change(r, c))));
            let size = || largest_entry(&old.spring) + largest_entry(&diagonal(fine, v));
            is_first || differs((new, old)) || (change > 0.0 && change > SAME_SPRING * size())
        };
        let mut changed = vec![false; self.nodes.len()];
        let place = places(&self.nodes, fine.rows);
        for (i, (new, old)) in constraints.iter().zip(&mut self.held).enumerate() {
            if is_other((new, old), contact_nodes[i]) {
                self.followers.row(i).0.iter().for_each(|&k| changed[k as usize] = true);
                changed.get_mut(place[contact_nodes[i] as usize] as usize).into_iter().for_each(|own| *own = true);
                *old = *new;
            }
        }
        self.space = self.space(constraints, contact_nodes, fine, &changed);
    }

    /// The space for these constraints, which differ from those before at the `changed` nodes and their followers; `None` where all
    /// followers stick.
    fn space(
        &self,
        constraints: &[NodeConstraint],
        contact_nodes: &[u32],
        fine: &Packed<3, 3>,
        changed: &[bool],
    ) -> Option<Space> {
        let contact = places(contact_nodes, fine.rows);
        // Components that are unknowns: others have empty rows.
        let free = |v: u32| -> [bool; 3] {
            let block = diagonal(fine, v);
            let held = constraints.get(contact[v as usize] as usize).map(|c| c.constrained).unwrap_or_default();
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
        let matrix = self.matrix(&alone, changed, |rows| galerkin(fine, &moved, &springs, &functions, rows));
        let springs = springs.iter().map(single).collect();
        let at = |k: usize| diagonal(&matrix, k as u32);
        let diagonals: Vec<Block<3, 3>> = (0..matrix.rows).map(at).collect();
        let mut level = Level::of(matrix, Halo::alone(nodes.len()), |k| diagonals[k]);
        if !self.steps.is_alone() {
            self.damp(&mut level, fine, &moved, &functions, &diagonals);
        }
        Some(Space { alone, moved, functions: Packed::new(&functions), springs, level })
    }

    /// The matrix of the functions `alone`, of which `rows` computes some rows: those of the `changed` ones. The others are as they were, but for
    /// the columns of these. Late in an iteration a handful of points changes in a cycle, and all rows take as long as several cycles: of
    /// plates stacked on one another (190 000 unknowns) half of the time.
    fn matrix(&self, alone: &[u32], changed: &[bool], rows: impl Fn(&[u32]) -> Packed<3, 3>) -> Packed<3, 3> {
        let old = self.space.as_ref().map(|space| (&space.alone, &space.level.matrix));
        let mut before = vec![u32::MAX; self.nodes.len()];
        let known = old.iter().flat_map(|(alone, _)| alone.iter().enumerate());
        known.for_each(|(k, &place)| before[place as usize] = k as u32);
        let is_new = |k: usize| changed[alone[k] as usize] || before[alone[k] as usize] == u32::MAX;
        let new: Vec<u32> = (0..alone.len()).filter(|&k| is_new(k)).map(|k| k as u32).collect();
        let computed = rows(&new);
        let Some((old_alone, old)) = old.filter(|_| new.len() < alone.len()) else { return computed };
        // The place of each old column that is kept.
        let now = places(alone, self.nodes.len());
        let kept = |&place: &u32| Some(now[place as usize]).filter(|&k| k != u32::MAX && !is_new(k as usize));
        let kept: Vec<u32> = old_alone.iter().map(|place| kept(place).unwrap_or(u32::MAX)).collect();
        let (start, entry) = by_columns(&computed.start, &computed.column, alone.len());
        let mut matrix = Packed { rows: alone.len(), start: vec![0], ..Packed::default() };
        matrix.column.reserve(old.column.len() + computed.column.len());
        matrix.value.reserve(old.column.len() + computed.column.len());
        let mut next = new.iter().enumerate().peekable();
        for k in 0..alone.len() {
            if let Some((t, _)) = next.next_if(|(_, row)| **row as usize == k) {
                let (columns, blocks) = computed.row(t);
                matrix.column.extend_from_slice(columns);
                matrix.value.extend_from_slice(blocks);
            } else {
                let mut across = entry[start[k]..start[k + 1]].iter().peekable();
                let mut push = |column: u32, value: Single<3, 3>| {
                    matrix.column.push(column);
                    matrix.value.push(value);
                };
                let transposed = |place: u32| {
                    let value = &computed.value[place as usize];
                    std::array::from_fn(|c| std::array::from_fn(|r| value[r][c]))
                };
                for (j, value) in old.entries_of(before[alone[k] as usize] as usize) {
                    let j = kept[j as usize];
                    if j == u32::MAX {
                        continue;
                    }
                    while let Some(&(t, place)) = across.next_if(|(t, _)| new[*t as usize] < j) {
                        push(new[t as usize], transposed(place));
                    }
                    push(j, *value);
                }
                across.for_each(|&(t, place)| push(new[t as usize], transposed(place)));
            }
            matrix.start.push(matrix.column.len());
        }
        matrix
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
        diagonals: &[Block<3, 3>],
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
            let sum = sum / (3.0 * square(&diagonals[k])).sqrt();
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

/// The block at a node on the diagonal; zero where none is stored.
fn diagonal(matrix: &Packed<3, 3>, v: u32) -> Block<3, 3> {
    let (columns, blocks) = matrix.row(v as usize);
    columns.binary_search(&v).map_or([[0.0; 3]; 3], |place| double(&blocks[place]))
}

fn largest_entry(block: &Block<3, 3>) -> f64 {
    block.iter().flatten().fold(0.0, |largest, v| v.abs().max(largest))
}

/// The rows `rows` of `Fᵀ (A + springs) F` with the functions `F`, which vanish but at the nodes `moved`.
fn galerkin(
    fine: &Packed<3, 3>,
    moved: &[(u32, u32)],
    springs: &[Block<3, 3>],
    functions: &Blocks<3, 3>,
    rows: &[u32],
) -> Packed<3, 3> {
    let at = places(&moved.iter().map(|(v, _)| *v).collect::<Vec<_>>(), fine.rows);
    let near = |t: usize| {
        let entries = fine
            .entries_of(moved[t].0 as usize)
            .map(|(j, block)| (at.get(j as usize).copied().unwrap_or(u32::MAX), block));
        entries.filter(|(place, _)| *place != u32::MAX)
    };
    let (start, entry) = functions.by_columns(moved.len());
    let from = |r: usize| entry[start[rows[r] as usize]..start[rows[r] as usize + 1]].iter();
    let mut reached: Vec<u32> = (0..rows.len()).flat_map(|r| from(r).map(|(t, _)| *t)).collect();
    reached.sort_unstable();
    reached.dedup();
    let named = |i: usize, name: &mut dyn FnMut(u32)| {
        let t = reached[i] as usize;
        near(t).for_each(|(place, _)| functions.row(place as usize).0.iter().for_each(|&k| name(k)));
        functions.row(t).0.iter().for_each(|&k| name(k));
    };
    let right: Packed<3, 3> = Packed::from_rows(
        reached.len(),
        functions.cols,
        named,
        #[inline(always)]
        |i, row| {
            let t = reached[i] as usize;
            for (place, block) in near(t) {
                let block = double(block);
                functions.entries_of(place as usize).for_each(|(k, f)| add_product(&block, f, row.at(k)));
            }
            functions.entries_of(t).for_each(|(k, f)| add_product(&springs[t], f, row.at(k)));
        },
    );
    let place = places(&reached, moved.len());
    let named = |r: usize, name: &mut dyn FnMut(u32)| {
        from(r).for_each(|&(t, _)| right.row(place[t as usize] as usize).0.iter().for_each(|&j| name(j)));
    };
    Packed::from_rows(
        rows.len(),
        functions.cols,
        named,
        #[inline(always)]
        |r, row| {
            for &(t, function) in from(r) {
                let function = &functions.value[function as usize];
                let right = right.entries_of(place[t as usize] as usize);
                right.for_each(|(j, block)| add_transpose_product(function, &double(block), row.at(j)));
            }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::super::relative_coordinates::tests::{chains, dot, relative, two_bodies, vector};
    use super::super::{CoarseLevels, Hierarchy, NodeConstraint};
    use crate::linalg::Stop;

    /// What is kept of the functions of nodes alone where some constraints change is what they are when all are made anew.
    #[test]
    fn cycles_after_changes_of_constraints_are_those_of_the_constraints_alone() {
        for (a, kernel, coordinates) in [two_bodies(), chains()] {
            let relative = relative(&a, &coordinates);
            let count = coordinates.nodes.len();
            let stiffness = 0.01 * a.diagonal(coordinates.nodes[0] as usize)[0][0];
            let constraint = |constrained: [bool; 3]| {
                let spring = std::array::from_fn(|r| {
                    std::array::from_fn(|c| if r == c && !constrained[c] { stiffness } else { 0.0 })
                });
                NodeConstraint { constrained, spring, coulomb: [0.0; 2] }
            };
            let states = [[false; 3], [true, false, false], [true; 3]];
            let state =
                |i: usize, step: usize| constraint(states[(i / 3 + (step + i).is_multiple_of(5) as usize * step) % 3]);
            let multigrid = || {
                let of = &coordinates.nodes;
                Hierarchy::new(&relative, &kernel, of, count, None, &Stop::never()).unwrap().unwrap()
            };
            let mut changing = multigrid();
            for step in 0..6 {
                let constraints: Vec<NodeConstraint> = (0..count).map(|i| state(i, step)).collect();
                changing.constrain(&constraints, CoarseLevels::ChangeCoupled, true);
                let mut anew = multigrid();
                anew.constrain(&constraints, CoarseLevels::ChangeCoupled, true);
                let mut b = vector(a.rows, 0.618);
                for (c, &v) in constraints.iter().zip(&coordinates.nodes) {
                    (0..3).filter(|&r| c.constrained[r]).for_each(|r| b[v as usize][r] = 0.0);
                }
                let (x, expected) = (changing.cycle(&b), anew.cycle(&b));
                let apart: Vec<[f64; 3]> =
                    x.iter().zip(&expected).map(|(x, y)| std::array::from_fn(|c| x[c] - y[c])).collect();
                assert!(dot(&apart, &apart) < 1e-10 * dot(&expected, &expected), "{step}");
                // What a run begins with does not depend on the runs before, to the bit.
                let mut forgetful = changing.clone();
                forgetful.forget_coarse_constraints();
                forgetful.constrain(&constraints, CoarseLevels::ChangeCoupled, true);
                assert_eq!(forgetful.cycle(&b), expected, "{step}");
            }
        }
    }
}
