use super::kernels;

/// The Schur complement `S = L Lᵀ` on a few unknowns, by its dense lower triangular factor.
#[derive(Debug, Clone)]
pub struct Trailing {
    /// The unknowns, in the order of rows and columns.
    pub unknowns: Vec<u32>,
    /// `L` by columns; the upper triangle is zero.
    pub(super) lower: Vec<f64>,
}

impl Trailing {
    /// `S⁻¹ b`, which is `K⁻¹ b` restricted to the unknowns.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.unknowns.len();
        let mut x = b.to_vec();
        kernels::forward(&self.lower, n, n, &mut x);
        kernels::backward(&self.lower, n, n, &mut x);
        x
    }

    /// `S x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let n = self.unknowns.len();
        kernels::lower_times(&self.lower, n, &kernels::lower_transpose_times(&self.lower, n, x))
    }
}
