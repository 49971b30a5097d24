//! Nodes whose displacement is counted along axes of their own, so that what is prescribed of it is a component.
//!
//! The first axes are the prescribed directions (by Gram-Schmidt, where planes of symmetry meet). Whoever turns an unknown
//! into a vector asks [`DofMap::direction`].

use super::DofMap;
use crate::mesh::v3::{V3, dot, norm, scale, sub};

/// Directions along which displacements are prescribed count as one where the sine of their angle is below this: planes
/// of symmetry come from coordinates of a few digits.
const PARALLEL: f64 = 1e-3;
/// Components of a direction below this part of it are rounding of the turn.
const ROUNDING: f64 = 1e-14;

/// A node and its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotatedNode {
    /// The node.
    pub node: u32,
    /// Orthonormal, in the order of the components.
    pub axes: [V3; 3],
}

impl DofMap {
    /// The axes of a node that is rotated; `None` stands for x, y, z.
    pub fn axes(&self, node: u32) -> Option<&[V3; 3]> {
        // Nearly always there are none at all.
        let node = if self.rotated.is_empty() { node } else { self.mesh_node(node) };
        let place = self.rotated.binary_search_by_key(&node, |rotated| rotated.node).ok()?;
        Some(&self.rotated[place].axes)
    }

    /// The direction in which degree of freedom `dof` moves its node.
    pub fn direction(&self, dof: u32) -> V3 {
        let c = (dof % 3) as usize;
        self.axes(dof / 3).map_or_else(|| [0, 1, 2].map(|k| f64::from(u8::from(k == c))), |axes| axes[c])
    }

    /// Components of the vector `v` at a node.
    pub fn components(&self, node: u32, v: V3) -> V3 {
        self.axes(node).map_or(v, |axes| {
            let length = norm(v);
            axes.map(|axis| dot(axis, v)).map(|c| if c.abs() < ROUNDING * length { 0.0 } else { c })
        })
    }

    /// The vector with components `c` at a node.
    pub fn vector(&self, node: u32, c: V3) -> V3 {
        self.axes(node).map_or(c, |axes| back(axes, c))
    }

    /// Turns vectors at all nodes, `3 i + c` along x, y, z, into components.
    ///
    /// # Panics
    /// If `all` has not three entries for each node.
    pub fn to_components(&self, all: &mut [f64]) {
        for RotatedNode { node, axes } in &self.rotated {
            let v = at(all, *node);
            set(all, *node, axes.map(|axis| dot(axis, v)));
        }
    }

    /// The inverse of [`Self::to_components`].
    ///
    /// # Panics
    /// If `all` has not three entries for each node.
    pub fn to_vectors(&self, all: &mut [f64]) {
        for RotatedNode { node, axes } in &self.rotated {
            let c = at(all, *node);
            set(all, *node, back(axes, c));
        }
    }

    /// Entries along x, y, z at some nodes as entries by degrees of freedom, which may repeat.
    pub fn entries(&self, along_axes: &[(u32, f64)]) -> Vec<(u32, f64)> {
        let turn = |&(dof, value): &(u32, f64)| match self.axes(dof / 3) {
            None => vec![(dof, value)],
            Some(axes) => {
                let (node, c) = (dof / 3, (dof % 3) as usize);
                (0..3).map(|k| (3 * node + k, value * axes[k as usize][c])).collect()
            }
        };
        along_axes.iter().flat_map(turn).collect()
    }
}

fn back(axes: &[V3; 3], c: V3) -> V3 {
    [0, 1, 2].map(|k| axes.iter().zip(c).map(|(axis, c)| axis[k] * c).sum())
}

fn at(all: &[f64], node: u32) -> V3 {
    [0, 1, 2].map(|c| all[3 * node as usize + c])
}

fn set(all: &mut [f64], node: u32, v: V3) {
    (0..3).for_each(|c| all[3 * node as usize + c] = v[c]);
}

/// `R_i K R_jᵀ` for the block of nodes `i` and `j`, to the bit the transpose of that of `j` and `i` if `K` is symmetric.
pub(super) fn turn_block(
    block: &[V3; 3],
    [i, j]: [u32; 2],
    left: Option<&[V3; 3]>,
    right: Option<&[V3; 3]>,
) -> [V3; 3] {
    if left.is_none() && right.is_none() {
        return *block;
    }
    if i > j {
        return transposed(&turn_block(&transposed(block), [j, i], right, left));
    }
    // First the columns of K Rᵀ, then the rows.
    let half = match right {
        Some(axes) => block.map(|row| axes.map(|axis| dot(axis, row))),
        None => *block,
    };
    let columns = transposed(&half);
    let whole = match left {
        Some(axes) => axes.map(|axis| columns.map(|column| dot(axis, column))),
        None => half,
    };
    // Of a block on the diagonal one triangle is as good as the other.
    let symmetric = |a: usize, b: usize| whole[a.min(b)][a.max(b)];
    if i == j { [0, 1, 2].map(|a| [0, 1, 2].map(|b| symmetric(a, b))) } else { whole }
}

fn transposed(block: &[V3; 3]) -> [V3; 3] {
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| block[b][a]))
}

/// What is prescribed at a node: orthonormal directions and the displacements along them.
#[derive(Debug, Clone, Default)]
pub(super) struct Constrained {
    directions: Vec<V3>,
    values: Vec<f64>,
}

impl Constrained {
    /// Adds the displacement `value` along the unit vector `direction`; `Err` is the displacement along it that is already
    /// prescribed and differs.
    pub(super) fn add(&mut self, direction: V3, value: f64) -> Result<(), f64> {
        let (mut rest, mut known) = (direction, 0.0);
        for (q, v) in self.directions.iter().zip(&self.values) {
            let along = dot(direction, *q);
            (rest, known) = (sub(rest, scale(along, *q)), known + along * v);
        }
        let sine = norm(rest);
        if sine < PARALLEL {
            // The directions differ by that much, and so may what is prescribed along them.
            let most = self.values.iter().fold(value.abs(), |most, v| most.max(v.abs()));
            return if (value - known).abs() <= PARALLEL * most { Ok(()) } else { Err(known) };
        }
        // A short remainder has lost digits: it is made orthogonal once more.
        let mut unit = scale(1.0 / sine, rest);
        for q in &self.directions {
            unit = sub(unit, scale(dot(unit, *q), *q));
        }
        self.directions.push(scale(1.0 / norm(unit), unit));
        self.values.push((value - known) / sine);
        Ok(())
    }

    /// Axes of which the first are prescribed, and what.
    pub(super) fn axes(&self) -> ([V3; 3], [Option<f64>; 3]) {
        let mut whole = self.clone();
        let lengths = |e: &V3| norm(self.directions.iter().fold(*e, |e, q| sub(e, scale(dot(e, *q), *q))));
        let mut basis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        // The axis with the longest remainder first: the others follow from it.
        basis.sort_by(|a, b| lengths(b).total_cmp(&lengths(a)));
        for e in basis {
            if whole.directions.len() < 3 {
                // What is prescribed nearly in its direction already is no error: it is passed over.
                let _ = whole.add(e, 0.0);
            }
        }
        let value = |k: usize| self.values.get(k).copied();
        ([0, 1, 2].map(|k| whole.directions[k]), [value(0), value(1), value(2)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_prescribed_along_slanted_directions_holds_along_each_of_them() {
        let unit = |v: V3| scale(1.0 / norm(v), v);
        let u = [0.3, -0.7, 0.2];
        for directions in [vec![[1.0, 1.0, 0.0]], vec![[1.0, 0.0, 0.1], [0.9, 0.0, 0.1]], vec![[1.0, 2.0, 3.0]; 2]] {
            let mut constrained = Constrained::default();
            let directions: Vec<V3> = directions.into_iter().map(unit).collect();
            directions.iter().for_each(|d| constrained.add(*d, dot(*d, u)).unwrap());
            let (axes, values) = constrained.axes();
            for a in 0..3 {
                (0..3).for_each(|b| assert!((dot(axes[a], axes[b]) - f64::from(u8::from(a == b))).abs() < 1e-15));
            }
            for d in directions {
                let along: f64 = (0..3).map(|k| dot(d, axes[k]) * values[k].unwrap_or(0.0)).sum();
                assert!((along - dot(d, u)).abs() < 1e-13);
            }
        }
        let mut constrained = Constrained::default();
        constrained.add([1.0, 0.0, 0.0], 0.5).unwrap();
        assert_eq!(constrained.add(unit([1.0, 1e-5, 0.0]), 0.0), Err(unit([1.0, 1e-5, 0.0])[0] * 0.5));
    }

    #[test]
    fn turned_blocks_stay_symmetric_to_the_bit() {
        let block = [[2.0, 0.3, -0.1], [0.7, 1.9, 0.4], [0.11, -0.6, 3.0]];
        let axes = |d: V3| {
            let mut constrained = Constrained::default();
            constrained.add(scale(1.0 / norm(d), d), 0.0).unwrap();
            constrained.axes().0
        };
        let (left, right) = (axes([1.0, 2.0, -0.7]), axes([0.3, 0.1, 1.0]));
        for (l, r) in [(Some(&left), Some(&right)), (None, Some(&right)), (Some(&left), None)] {
            let one = turn_block(&block, [3, 8], l, r);
            assert_eq!(one, transposed(&turn_block(&transposed(&block), [8, 3], r, l)));
            // energy of any two displacements
            let (u, v) = ([0.2, -0.5, 1.0], [1.0, 0.4, -0.3]);
            let energy = |k: &[V3; 3], u: V3, v: V3| dot(u, k.map(|row| dot(row, v)));
            let of = |axes: Option<&[V3; 3]>, v: V3| axes.map_or(v, |axes| axes.map(|axis| dot(axis, v)));
            assert!((energy(&one, of(l, u), of(r, v)) - energy(&block, u, v)).abs() < 1e-14);
        }
    }
}
