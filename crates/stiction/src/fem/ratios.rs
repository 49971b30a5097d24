//! Stiffness of linear tetrahedra by sums that do not depend on the material.

use super::elements::Law;
use crate::mesh::v3::V3;

/// Ratios beyond the first so many are not told apart: their cells are added one by one.
const MOST: usize = 4;

/// The ratios `λ/μ = 2ν/(1 - 2ν)` of isotropic materials.
///
/// On linear tetrahedra gradients are constant, and with `G_ij = Σ μ V ∇N_i ⊗ ∇N_j` over all cells of one ratio `r` their
/// part of the stiffness matrix is `r G_ij + G_ijᵀ + tr(G_ij) I`: a cell adds nine products instead of forty-five terms.
pub(super) struct Ratios {
    list: Vec<f64>,
    /// Place of the ratio of each material in the list.
    of_material: Vec<Option<usize>>,
}

impl Ratios {
    /// The ratios of materials with these laws.
    pub fn new(laws: &[Law]) -> Self {
        let mut list: Vec<f64> = Vec::new();
        let mut place = |law: &Law| {
            let ratio = law.lambda / law.mu;
            if law.stiffness.is_some() || !ratio.is_finite() {
                return None;
            }
            if !list.contains(&ratio) && list.len() < MOST {
                list.push(ratio);
            }
            list.iter().position(|&known| known == ratio)
        };
        let of_material = laws.iter().map(&mut place).collect();
        Ratios { list, of_material }
    }

    /// The number of the ratio of a material, if it has one.
    pub fn of(&self, material: u32) -> Option<usize> {
        self.of_material[material as usize]
    }

    /// All ratios with their numbers.
    pub fn each(&self) -> impl Iterator<Item = (usize, f64)> {
        self.list.iter().copied().enumerate()
    }

    /// The block of the stiffness matrix for the sum `g` of the products over cells of this ratio.
    #[inline(always)]
    pub fn block(g: &[V3; 3], ratio: f64) -> [V3; 3] {
        let trace = g[0][0] + g[1][1] + g[2][2];
        let mut block = [[0.0; 3]; 3];
        for a in 0..3 {
            for b in 0..3 {
                block[a][b] = ratio * g[a][b] + g[b][a];
            }
            block[a][a] += trace;
        }
        block
    }
}
