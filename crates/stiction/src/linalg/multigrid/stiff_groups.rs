//! Groups of nodes that are tied far more stiffly to one another than to the nodes around them, such as those of a cell whose corners lie
//! nearly in one plane: meshing programs leave a few of them.
//!
//! A sweep moves one node at a time, and each of these is held by the others, so that the group as a whole does not follow the body around
//! it. Its motion is found by a solve for all of its nodes together, as in overlapping Schwarz methods. On coarse levels a
//! group is in one aggregate, unless it has contact points: its functions are rigid motions there, and the stiffness of the group is in no
//! coarse matrix.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::blocks::{Block, Blocks};
use super::coarsest::CoarsestFactor;
use super::dense::square;
use super::packed::{Packed, Single, add_transposed, double, single, subtract};
use super::truncation::NodeConstraint;

/// Thresholds by which groups are found.
struct Threshold;

impl Threshold {
    /// A node is stiff beside another one whose diagonal block is smaller than its own by this factor. Forty cells of 5e-3, 2e-3, 5e-4 and 2e-5 of
    /// the best quality take 24, 25, 26 and 37 cycles (linear tetrahedra, 17 without such cells) and 37, 37, 30 and 33 (quadratic ones, 20),
    /// without groups 25, 30, 57, a failure and 45, 73, failures. With five shallow cells are missed.
    const SOFTER: f64 = 3.0;
    /// A node is stiff if it is so beside this part of its neighbours.
    const SHARE: f64 = 1.0 / 3.0;
    /// Nodes `i` and `j` are coupled closely if `|A_ij|` is larger than this part of the larger one of their diagonal blocks.
    const CLOSE: f64 = 0.1;
    /// Most nodes of a group, which has a dense matrix. What is larger is no cell of bad shape but a stiff layer or part, and
    /// aggregation follows it.
    const MOST_NODES: usize = 40;
    /// A group has at least so many times as many nodes as are coupled closely with them from outside. Lines of nodes on a layer ten thousand times as
    /// stiff as the next one, of long cells, have about as many outside: as groups they take 33 cycles in place of 16.
    const INSIDE: usize = 2;
}

/// The groups of a matrix among its rows, each ascending; `norms` are those of the diagonal blocks.
///
/// A group is stiff nodes that are coupled closely, directly or over others. Where more than half as many nodes outside are coupled closely with
/// them, they are the border of a stiffer part, which aggregation follows, and no group.
pub(super) fn stiff_groups<const R: usize>(a: &Blocks<R, R>, norms: &[f64]) -> Vec<Vec<u32>> {
    let others = |i: usize| a.row(i).0.iter().map(|&j| j as usize).filter(move |&j| j != i && j < a.rows);
    let is_stiff = |i: usize| {
        let softer = others(i).filter(|&j| Threshold::SOFTER * norms[j] < norms[i]).count();
        softer > 0 && softer as f64 >= Threshold::SHARE * others(i).count() as f64
    };
    let is_stiff: Vec<bool> = (0..a.rows).into_par_iter().map(is_stiff).collect();
    let close = |i: u32| {
        let is_close = move |(j, block): &(u32, &Block<R, R>)| {
            let least = Threshold::CLOSE * norms[i as usize].max(norms[*j as usize]);
            *j != i && square(block) > least.powi(2)
        };
        a.entries_of(i as usize).filter(|(j, _)| (*j as usize) < a.rows).filter(is_close).map(|(j, _)| j)
    };
    let mut is_open = is_stiff.clone();
    let mut groups = Vec::new();
    for first in 0..a.rows as u32 {
        if !std::mem::take(&mut is_open[first as usize]) {
            continue;
        }
        let (mut group, mut next) = (vec![first], 0);
        while let Some(&i) = group.get(next) {
            next += 1;
            group.extend(close(i).filter(|&j| std::mem::take(&mut is_open[j as usize])));
        }
        if (2..=Threshold::MOST_NODES).contains(&group.len()) {
            let outside = group.iter().flat_map(|&i| close(i)).filter(|&j| !is_stiff[j as usize]);
            if Threshold::INSIDE * outside.collect::<HashSet<u32>>().len() <= group.len() {
                group.sort_unstable();
                groups.push(group);
            }
        }
    }
    groups
}

/// The groups without those that have one of these nodes, at which components may be constrained: what is left of a rigid motion of a group
/// then is none, and a coarse function as stiff as the group.
pub(super) fn without(groups: &[Vec<u32>], nodes: &[u32]) -> Vec<Vec<u32>> {
    if groups.is_empty() {
        return Vec::new();
    }
    let nodes: HashSet<u32> = nodes.iter().copied().collect();
    groups.iter().filter(|group| !group.iter().any(|v| nodes.contains(v))).cloned().collect()
}

/// Each group becomes part of the aggregate of its first node. Returns the number of aggregates, which are numbered anew.
pub(super) fn merge(groups: &[Vec<u32>], of: &mut [u32], count: usize) -> usize {
    if groups.is_empty() {
        return count;
    }
    for group in groups {
        let first = of[group[0] as usize];
        group.iter().for_each(|&v| of[v as usize] = first);
    }
    let mut number = vec![u32::MAX; count];
    let mut next = 0;
    for aggregate in of {
        let number = &mut number[*aggregate as usize];
        if *number == u32::MAX {
            *number = next;
            next += 1;
        }
        *aggregate = *number;
    }
    next as usize
}

/// The groups of a level, and their matrices.
#[derive(Debug, Clone, Default)]
pub(super) struct StiffGroups {
    groups: Vec<Group>,
}

#[derive(Debug, Clone)]
struct Group {
    nodes: Vec<u32>,
    /// The places of these nodes among those that may be constrained.
    places: Vec<Option<u32>>,
    /// The part of the matrix at these nodes, by rows.
    matrix: Vec<f64>,
    /// What constraints add to the diagonal block of each node, and the components that they take away.
    springs: Vec<Single<3, 3>>,
    constrained: Vec<[bool; 3]>,
    /// The Coulomb coupling of each node, which the forces contain and the matrix does not.
    coulomb: Vec<[f32; 2]>,
    factor: CoarsestFactor,
}

impl StiffGroups {
    /// Of a level with `own` nodes on this rank, of which only `contact_nodes` can be constrained later; `rows` gives the rows of nodes.
    /// Nodes that are coupled with those of other ranks are left out.
    pub(super) fn new(
        groups: &[Vec<u32>],
        own: usize,
        contact_nodes: &[u32],
        rows: impl FnOnce(&[u32]) -> Blocks<3, 3>,
    ) -> Self {
        if groups.is_empty() {
            return StiffGroups::default();
        }
        let place: HashMap<u32, u32> = contact_nodes.iter().zip(0..).map(|(&v, place)| (v, place)).collect();
        let all = groups.concat();
        let rows = rows(&all);
        let is_inner = |k: &usize| rows.row(*k).0.iter().all(|&j| (j as usize) < own);
        let mut end = 0;
        let of = |group: &Vec<u32>| {
            end += group.len();
            let inner: Vec<usize> = (end - group.len()..end).filter(is_inner).collect();
            let nodes: Vec<u32> = inner.iter().map(|&k| all[k]).collect();
            (nodes.len() > 1).then(|| {
                let mut group = Group {
                    matrix: vec![0.0; 9 * nodes.len().pow(2)],
                    places: nodes.iter().map(|v| place.get(v).copied()).collect(),
                    springs: vec![[[0.0; 3]; 3]; nodes.len()],
                    constrained: vec![[false; 3]; nodes.len()],
                    coulomb: vec![[0.0; 2]; nodes.len()],
                    factor: CoarsestFactor::default(),
                    nodes,
                };
                inner.iter().enumerate().for_each(|(k, &i)| group.set_row(k, rows.entries_of(i)));
                group.factorise();
                group
            })
        };
        StiffGroups { groups: groups.iter().filter_map(of).collect() }
    }

    /// Takes new rows `touched` of the matrix, ascending, whose blocks are one after the other.
    pub(super) fn set_rows(&mut self, touched: &[u32], a: &Packed<3, 3>, blocks: &[Block<3, 3>]) {
        if self.groups.is_empty() {
            return;
        }
        let (mut begin, mut end) = (Vec::with_capacity(touched.len()), 0);
        for &v in touched {
            begin.push(end);
            end += a.row(v as usize).0.len();
        }
        for group in &mut self.groups {
            let mut is_new = false;
            for k in 0..group.nodes.len() {
                let v = group.nodes[k];
                let Ok(t) = touched.binary_search(&v) else { continue };
                group.set_row(k, a.row(v as usize).0.iter().copied().zip(&blocks[begin[t]..]));
                is_new = true;
            }
            if is_new {
                group.factorise();
            }
        }
    }

    /// Takes the constraints of contact nodes.
    pub(super) fn constrain(&mut self, constraints: &[NodeConstraint]) {
        for group in &mut self.groups {
            let mut is_new = false;
            for (k, place) in group.places.iter().enumerate() {
                let Some(constraint) = place.and_then(|place| constraints.get(place as usize)) else { continue };
                let (constrained, spring) = (constraint.constrained, single(&constraint.spring));
                is_new |= constrained != group.constrained[k] || spring != group.springs[k];
                (group.constrained[k], group.springs[k]) = (constrained, spring);
                group.coulomb[k] = constraint.coulomb.map(|f| f as f32);
            }
            if is_new {
                group.factorise();
            }
        }
    }

    /// Solves for one group after the other, for `residual`, adds the steps to `x`, and takes what they balance off the residual.
    pub(super) fn forward(&self, a: &Packed<3, 3>, x: &mut [[f32; 3]], residual: &mut [[f32; 3]]) {
        for group in &self.groups {
            let step = group.step(|k| residual[group.nodes[k] as usize]);
            for ((&v, step), spring) in group.nodes.iter().zip(&step).zip(&group.springs) {
                (0..3).for_each(|c| x[v as usize][c] += step[c]);
                let minus = step.map(|s| -s);
                // The matrix is symmetric: its columns are its rows.
                a.entries_of(v as usize).for_each(|(j, a)| add_transposed(a, &minus, &mut residual[j as usize]));
                subtract(spring, step, &mut residual[v as usize]);
            }
        }
    }

    /// The same backwards for `A x = b` from `x`.
    pub(super) fn backward(&self, a: &Packed<3, 3>, b: &[[f32; 3]], x: &mut [[f32; 3]]) {
        for group in self.groups.iter().rev() {
            let step = group.step(|k| {
                let v = group.nodes[k] as usize;
                let mut left = b[v];
                a.entries_of(v).for_each(|(j, a)| subtract(a, &x[j as usize], &mut left));
                subtract(&group.springs[k], &x[v], &mut left);
                left
            });
            for (&v, step) in group.nodes.iter().zip(&step) {
                (0..3).for_each(|c| x[v as usize][c] += step[c]);
            }
        }
    }
}

impl Group {
    fn set_row<'a>(&mut self, k: usize, row: impl Iterator<Item = (u32, &'a Block<3, 3>)>) {
        let n = 3 * self.nodes.len();
        self.matrix[3 * k * n..3 * (k + 1) * n].fill(0.0);
        for (j, block) in row {
            if let Ok(j) = self.nodes.binary_search(&j) {
                for (r, entries) in block.iter().enumerate() {
                    self.matrix[(3 * k + r) * n + 3 * j..][..3].copy_from_slice(entries);
                }
            }
        }
    }

    /// Factorises the matrix on the free components.
    fn factorise(&mut self) {
        let n = 3 * self.nodes.len();
        let mut lower = self.matrix.clone();
        for (k, (spring, constrained)) in self.springs.iter().zip(&self.constrained).enumerate() {
            let spring = double(spring);
            (0..9).for_each(|rc| lower[(3 * k + rc / 3) * n + 3 * k + rc % 3] += spring[rc / 3][rc % 3]);
            for i in (0..3).filter(|&c| constrained[c]).map(|c| 3 * k + c) {
                (0..n).for_each(|j| (lower[i * n + j], lower[j * n + i]) = (0.0, 0.0));
            }
        }
        self.factor = CoarsestFactor::of(n, lower);
    }

    /// The steps of the nodes for the residual at each of them.
    fn step(&self, residual: impl Fn(usize) -> [f32; 3]) -> Vec<[f32; 3]> {
        let force = |k: usize| {
            let mut force = residual(k);
            let normal = force[0];
            (1..3).for_each(|c| force[c] -= self.coulomb[k][c - 1] * normal);
            force.map(f64::from)
        };
        let mut x: Vec<f64> = (0..self.nodes.len()).flat_map(force).collect();
        self.factor.solve_in_place(&mut x);
        x.as_chunks().0.iter().map(|c: &[f64; 3]| c.map(|v| v as f32)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::aggregate::diagonal_norms;
    use super::super::blocks::rows_at;
    use super::super::tests::lattice;
    use super::super::{CoarseLevels, Hierarchy, Kernel, RelativeMatrix};
    use super::*;
    use crate::linalg::Stop;

    /// The lattice with `stiffness` between the means of both pairs of opposite corners of a square, as a flat tetrahedron has it.
    fn with_flat_cells(stiffness: f64, squares: &[[u32; 4]]) -> (Blocks<3, 3>, Vec<Kernel<3>>) {
        let (mut a, kernel) = lattice([9, 8, 8], [1.0; 3]);
        for square in squares {
            for (k, &i) in square.iter().enumerate() {
                for (l, &j) in square.iter().enumerate() {
                    let place = a.place(i as usize, j as usize).unwrap();
                    let sign = if (k + l) % 2 == 0 { 1.0 } else { -1.0 };
                    (0..3).for_each(|c| a.value[place][c][c] += sign * stiffness);
                }
            }
        }
        (a, kernel)
    }

    /// The corners of a square across x, in turn, at a node of the lattice.
    fn square(at: u32) -> [u32; 4] {
        [at, at + 1, at + 9, at + 8]
    }

    #[test]
    fn the_nodes_of_flat_cells_are_groups_and_those_of_a_layer_are_not() {
        let found = |stiffness: f64, squares: &[[u32; 4]]| {
            let (a, _) = with_flat_cells(stiffness, squares);
            stiff_groups(&a, &diagonal_norms(&a))
        };
        let sorted = |square: [u32; 4]| {
            let mut square = square.to_vec();
            square.sort_unstable();
            square
        };
        let few = [square(9), square(200), square(300)];
        assert_eq!(found(0.0, &few), [[0; 0]; 0]);
        assert_eq!(found(1e4, &few), few.map(sorted));
        // All nodes of the plane x = 0 that have a square.
        let layer: Vec<[u32; 4]> = (0..55).filter(|at| at % 8 < 7).map(square).collect();
        assert_eq!(found(1e4, &layer), [[0; 0]; 0]);
    }

    #[test]
    fn aggregates_of_the_nodes_of_a_group_become_one_and_none_is_empty() {
        let mut of = [0, 0, 1, 2, 2, 3];
        assert_eq!(merge(&[vec![1, 2]], &mut of, 4), 3);
        assert_eq!(of, [0, 0, 0, 1, 1, 2]);
    }

    /// Forces that the coupled rows balance, a normal one and what friction bears of it, move nothing; the same without friction do.
    #[test]
    fn coupled_forces_in_balance_leave_a_group_where_it_is() {
        let (a, _) = with_flat_cells(1e3, &[square(200)]);
        let level = Packed::new(&a);
        let groups = stiff_groups(&a, &diagonal_norms(&a));
        let rows = |nodes: &[u32]| rows_at(nodes, a.cols, |v| a.row(v as usize));
        let mut stiff = StiffGroups::new(&groups, a.rows, &[200], rows);
        let constrained = [true, false, false];
        stiff.constrain(&[NodeConstraint { constrained, coulomb: [0.3, -0.2], ..NodeConstraint::default() }]);
        let moved = |force: [f32; 3]| {
            let (mut x, mut residual) = (vec![[0.0; 3]; a.rows], vec![[0.0; 3]; a.rows]);
            residual[200] = force;
            stiff.forward(&level, &mut x, &mut residual);
            let mut back = vec![[0.0; 3]; a.rows];
            let mut b = vec![[0.0; 3]; a.rows];
            b[200] = force;
            stiff.backward(&level, &b, &mut back);
            assert_eq!(x, back);
            assert_eq!(x[200][0], 0.0);
            x.iter().flatten().any(|v| *v != 0.0)
        };
        assert!(!moved([1.0, 0.3, -0.2]) && moved([1.0, 0.0, 0.0]) && moved([1.0, -0.3, 0.2]));
    }

    fn dot(x: &[[f64; 3]], y: &[[f64; 3]]) -> f64 {
        x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum()
    }

    /// Steps of conjugate gradients with cycles until the residual has fallen by eight digits, with a component of a node constrained.
    fn steps(a: &RelativeMatrix, hierarchy: &Hierarchy, node: usize) -> usize {
        let free = |x: &mut [[f64; 3]]| x[node][0] = 0.0;
        let mut r: Vec<[f64; 3]> = (0..a.len()).map(|i| [(i as f64).sin(), 1.0, (0.3 * i as f64).cos()]).collect();
        free(&mut r);
        let mut z = hierarchy.cycle(&r);
        let (mut p, mut rz, least) = (z.clone(), dot(&r, &z), 1e-16 * dot(&r, &r));
        for step in 0..300 {
            if dot(&r, &r) <= least {
                return step;
            }
            let mut ap = a.times(&p);
            free(&mut ap);
            let alpha = rz / dot(&p, &ap);
            r.iter_mut().flatten().zip(ap.iter().flatten()).for_each(|(r, a)| *r -= alpha * a);
            z = hierarchy.cycle(&r);
            let new = dot(&r, &z);
            p.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(p, z)| *p = z + new / rz * *p);
            rz = new;
        }
        300
    }

    /// The cycle is symmetric with groups as well, one with a constrained component among them, and flat cells take no more steps than their
    /// absence; without the groups they take many more.
    #[test]
    fn flat_cells_take_no_more_steps_of_conjugate_gradients_and_the_cycle_stays_symmetric() {
        let squares = [square(9), square(200), square(300), square(420)];
        let run = |stiffness: f64| {
            let (a, kernel) = with_flat_cells(stiffness, &squares);
            let a = RelativeMatrix::new(a, None);
            let mut hierarchy = Hierarchy::new(&a, &kernel, &[200], 1, None, &Stop::never()).unwrap().unwrap();
            let constraint = NodeConstraint { constrained: [true, false, false], ..NodeConstraint::default() };
            hierarchy.constrain(&[constraint], CoarseLevels::Change, true);
            let [mut x, mut y] = [1.0, 0.7].map(|f: f64| {
                (0..a.len()).map(|i| [(f * i as f64).sin(), (2.0 * f * i as f64).cos(), f]).collect::<Vec<[f64; 3]>>()
            });
            (x[200][0], y[200][0]) = (0.0, 0.0);
            let (xy, yx) = (dot(&x, &hierarchy.cycle(&y)), dot(&y, &hierarchy.cycle(&x)));
            // What single precision leaves of the stiffness.
            let rounding = 1e-6 + 1e-8 * stiffness;
            assert!((xy - yx).abs() <= rounding * xy.abs(), "{stiffness}: {xy} {yx}");
            let with = steps(&a, &hierarchy, 200);
            hierarchy.stiff = StiffGroups::default();
            (with, steps(&a, &hierarchy, 200))
        };
        let ((usual, _), (with, without)) = (run(0.0), run(1e5));
        run(1e2);
        assert!(with <= usual + 3 && without >= 2 * with, "{usual} {with} {without}");
    }
}
