use std::ops::Range;

use super::quadratic::Quadratic;
use super::squares::{Coupling, Squares};
use crate::friction::PointState;
use crate::linalg::{Symmetric, axpy, norm};
use crate::qp::Bounds;

/// The augmented Lagrangian of problem (D)_N (Haslinger, Kucera & Dostal 2004, eq. 4.4): `N` copies of the multipliers,
/// one a square, that are to agree,
///
/// ```text
/// L(x, w) = 1/2 x'A x - b'x + w'C x + rho/2 |C x|²,   A = diag(Q .. Q) / N,   b = (h .. h) / N.
/// ```
/// `x` is kept in the axes of the squares (the paper's second decomposition), `w` and `C x` in those of the problem
/// (its first): the turns change neither lengths nor the iterates.
#[derive(Debug)]
pub(super) struct Lagrangian<'a> {
    pub q: &'a Quadratic<'a>,
    pub squares: Squares,
    pub coupling: Coupling,
    /// `rho`, length per newton.
    pub penalty: f64,
    /// `b` in the axes of the squares.
    b: Vec<f64>,
    /// `Q` in the axes of each square, for blocks of single copies; empty if `Q` is not stored.
    turned: Vec<Symmetric>,
}

/// Copies of the multipliers and the multipliers of their agreement.
#[derive(Debug, Clone)]
pub(super) struct Copies {
    /// `N` copies in the axes of their squares, newton, `3mN`.
    pub x: Vec<f64>,
    /// `w`, length, `3m(N - 1)`.
    pub w: Vec<f64>,
}

/// Some multipliers of some copies: the unknowns of one quadratic program.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub copies: Range<usize>,
    /// Within `0..3m`.
    pub rows: Range<usize>,
}

impl<'a> Lagrangian<'a> {
    /// `one_by_one` prepares blocks of single copies.
    pub(super) fn new(
        q: &'a Quadratic<'a>,
        squares: Squares,
        coupling: Coupling,
        penalty: f64,
        one_by_one: bool,
    ) -> Self {
        let weight = 1.0 / squares.count as f64;
        let h: Vec<f64> = (0..squares.count).flat_map(|_| q.h.iter().map(|h| weight * h)).collect();
        let b = squares.in_own_axes(&h);
        let matrix = |i| q.turned(&|x| squares.turn(i, x), &|x| squares.turn_back(i, x));
        let turned = if one_by_one { (0..squares.count).map_while(matrix).collect() } else { Vec::new() };
        Lagrangian { q, squares, coupling, penalty, b, turned }
    }

    fn count(&self) -> usize {
        self.squares.count
    }

    /// `3m`.
    pub(super) fn size(&self) -> usize {
        self.q.h.len()
    }

    /// `C x`, newton.
    pub(super) fn differences(&self, x: &[f64]) -> Vec<f64> {
        self.coupling.differences(self.count(), self.size(), &self.squares.in_common_axes(x))
    }

    /// `Cᵀ w` in the axes of the squares.
    fn pull(&self, w: &[f64]) -> Vec<f64> {
        self.squares.in_own_axes(&self.coupling.transpose(self.count(), self.size(), w))
    }

    /// `b - Cᵀ w`: minus the gradient of the Lagrangian at zero.
    pub(super) fn load(&self, w: &[f64]) -> Vec<f64> {
        let pulled = self.pull(w);
        self.b.iter().zip(pulled).map(|(b, p)| b - p).collect()
    }

    /// Step 2: `w += rho C x`; the length of the change.
    pub(super) fn ascend(&self, copies: &mut Copies) -> f64 {
        let differences = self.differences(&copies.x);
        axpy(self.penalty, &differences, &mut copies.w);
        self.penalty * norm(&differences)
    }

    /// `|C x| / |x|`.
    pub(super) fn disagreement(&self, x: &[f64]) -> f64 {
        let size = norm(x);
        if size == 0.0 { 0.0 } else { norm(&self.differences(x)) / size }
    }

    /// The state of each point: open (no normal force in any copy), sticking (friction below its bounds in all) or slipping;
    /// `bounds` are those of one copy.
    pub(super) fn state_of_points(&self, x: &[f64], bounds: &Bounds) -> Vec<PointState> {
        let m = self.q.points();
        let tied = |j: usize| bounds.upper[m + j].is_infinite() || bounds.upper[2 * m + j].is_infinite();
        let state = |j: usize| {
            let copies = || x.chunks_exact(3 * m);
            let bound = |copy: &[f64]| [m + j, 2 * m + j].iter().any(|&i| copy[i].abs() >= bounds.upper[i]);
            match () {
                () if tied(j) => PointState::Stick,
                () if copies().all(|copy| copy[j] <= 0.0) => PointState::Open,
                () if copies().any(bound) => PointState::Slip,
                () => PointState::Stick,
            }
        };
        (0..m).map(state).collect()
    }

    /// An upper bound of the largest eigenvalue of `A + rho CᵀC` and of all its blocks.
    pub(super) fn largest(&self) -> f64 {
        self.q.largest_bound() / self.count() as f64 + self.penalty * self.coupling.largest(self.count())
    }

    /// The entries of `x` that belong to the block.
    pub(super) fn take(&self, block: &Block, x: &[f64]) -> Vec<f64> {
        let size = self.size();
        let part = |i: usize| &x[i * size + block.rows.start..i * size + block.rows.end];
        block.copies.clone().flat_map(part).copied().collect()
    }

    /// Writes the entries of the block into `x`.
    pub(super) fn put(&self, block: &Block, part: &[f64], x: &mut [f64]) {
        let size = self.size();
        for (i, part) in block.copies.clone().zip(part.chunks_exact(block.rows.len().max(1))) {
            x[i * size + block.rows.start..i * size + block.rows.end].copy_from_slice(part);
        }
    }

    fn is_whole(&self, block: &Block) -> bool {
        block.rows.len() == self.size()
    }

    /// `A + rho CᵀC` among the unknowns of the block.
    pub(super) fn times(&self, block: &Block, x: &[f64]) -> Vec<f64> {
        let i = block.copies.start;
        if block.copies.len() == 1 && self.turned.len() > i {
            // The other copies rest, so that of the coupling only the diagonal remains.
            let mut y = self.q.block_times(&self.turned[i], block.rows.clone(), block.rows.clone(), x);
            let (weight, stiff) = (1.0 / self.count() as f64, self.penalty * self.coupling.entry(self.count(), i, i));
            y.iter_mut().zip(x).for_each(|(y, x)| *y = weight * *y + stiff * x);
            return y;
        }
        let mut all = vec![0.0; self.count() * self.size()];
        self.put(block, x, &mut all);
        let common = self.squares.in_common_axes(&all);
        let mut y = self.coupling.transpose(
            self.count(),
            self.size(),
            &self.coupling.differences(self.count(), self.size(), &common),
        );
        y.iter_mut().for_each(|y| *y *= self.penalty);
        let span = block.copies.start * self.size()..block.copies.end * self.size();
        axpy(1.0 / self.count() as f64, &self.q.times(&common[span.clone()]), &mut y[span]);
        self.take(block, &self.squares.in_own_axes(&y))
    }

    /// The linear term of the block while the other unknowns rest at their values in `x`; `load` is `b - Cᵀ w`.
    pub(super) fn block_load(&self, block: &Block, load: &[f64], x: &[f64]) -> Vec<f64> {
        let mut part = self.take(block, load);
        if self.is_whole(block) && block.copies.len() == self.count() {
            return part;
        }
        let mut rest = x.to_vec();
        self.put(block, &vec![0.0; part.len()], &mut rest);
        let pulled = self.take(block, &self.pull(&self.differences(&rest)));
        axpy(-self.penalty, &pulled, &mut part);
        if !self.is_whole(block) {
            let weight = -1.0 / self.count() as f64;
            axpy(weight, &self.q_of_the_rest(block, &rest), &mut part);
        }
        part
    }

    /// `Q` times what the copies of the block have outside it.
    fn q_of_the_rest(&self, block: &Block, rest: &[f64]) -> Vec<f64> {
        let size = self.size();
        let i = block.copies.start;
        if block.copies.len() == 1 && self.turned.len() > i {
            let mut sum = vec![0.0; block.rows.len()];
            for columns in [0..block.rows.start, block.rows.end..size].into_iter().filter(|c| !c.is_empty()) {
                let x = &rest[i * size + columns.start..i * size + columns.end];
                axpy(1.0, &self.q.block_times(&self.turned[i], block.rows.clone(), columns, x), &mut sum);
            }
            return sum;
        }
        let common = self.squares.in_common_axes(rest);
        let span = i * size..block.copies.end * size;
        let mut y = vec![0.0; rest.len()];
        y[span.clone()].copy_from_slice(&self.q.times(&common[span]));
        self.take(block, &self.squares.in_own_axes(&y))
    }

    /// Floating-point operations of [`Lagrangian::times`], counted as with `Q` stored in the axes of the squares:
    /// two an entry of the block of `Q`, two a multiplier and term of the coupling.
    pub(super) fn flops_of_product(&self, block: &Block) -> f64 {
        let (copies, rows) = (block.copies.len() as f64, block.rows.len() as f64);
        let coupled = if block.copies.len() == 1 { 3.0 } else { 2.0 + 4.0 * (copies - 1.0) / copies + 12.0 };
        copies * rows * (2.0 * rows + coupled)
    }

    /// Those of [`Lagrangian::block_load`].
    pub(super) fn flops_of_load(&self, block: &Block) -> f64 {
        let (copies, rows, size) = (block.copies.len() as f64, block.rows.len() as f64, self.size() as f64);
        copies * rows * (2.0 * (size - rows) + 4.0)
    }
}
