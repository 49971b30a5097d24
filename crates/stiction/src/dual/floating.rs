use crate::contact::ContactProblem;
use crate::contact::rigid::{RigidMotions, rigid_motions};
use crate::linalg::{Csr, SymmetricCsr, axpy};

/// What the dual operator knows of bodies that nothing but contact holds: their rigid motions `R`, of which there are
/// `k`, and the springs that stand for the missing supports in the factor. Without such bodies `k = 0`.
///
/// `u = K⁺ (f - Bᵀ lambda) + R alpha` where forces are in balance, `Gᵀ lambda = Rᵀ f` with `G = B R`; `K⁺` is the
/// inverse of `K` with the springs, which carry nothing then. Out of balance it is the answer of a body that the
/// springs hold at `alpha`.
#[derive(Debug)]
pub struct Floating {
    /// Their rigid motions.
    pub motions: RigidMotions,
    /// The jumps `G = B R` of these, `3m x k`.
    pub jumps: Csr,
    /// Unknowns that hold a spring, and its stiffness, force per length.
    pub(super) springs: Vec<(u32, f64)>,
}

impl Floating {
    pub(super) fn new(problem: &ContactProblem) -> Self {
        let motions = rigid_motions(problem);
        let jumps = motions.jumps(&problem.isotropic_rows());
        // As stiff as the body itself is there: neither the springs nor the body decide the condition.
        let springs: Vec<(u32, f64)> =
            motions.fixing().into_iter().map(|i| (i, problem.elastic.K.diagonal(i as usize))).collect();
        Floating { motions, jumps, springs }
    }

    /// Number of rigid motions `k`.
    pub fn len(&self) -> usize {
        self.jumps.cols
    }

    /// Whether every body is held.
    pub fn is_empty(&self) -> bool {
        self.jumps.cols == 0
    }

    /// `Rᵀ f - Gᵀ lambda`: what the forces lack of balance, for `resultant = Rᵀ f`.
    pub fn imbalance(&self, resultant: &[f64], lambda: &[f64]) -> Vec<f64> {
        resultant.iter().zip(self.jumps.transpose_times(lambda)).map(|(e, held)| e - held).collect()
    }

    /// `v -= G alpha`: the motions close gaps as displacements do.
    pub fn close(&self, alpha: &[f64], v: &mut [f64]) {
        if !self.is_empty() {
            axpy(-1.0, &self.jumps.times(alpha), v);
        }
    }

    /// `K` with the springs.
    pub(super) fn held(&self, k: &SymmetricCsr) -> SymmetricCsr {
        let mut held = k.clone();
        for &(i, stiffness) in &self.springs {
            held.entry_mut(i as usize, i as usize).into_iter().for_each(|entry| *entry += stiffness);
        }
        held
    }
}
