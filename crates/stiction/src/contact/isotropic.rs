//! A problem whose friction differs by direction, as one whose friction does not.
//!
//! With tangential rows of `B` and slips across the first tangent multiplied by `a`, and forces divided by it, the
//! ellipse `|(lambda_1, lambda_2 / a)| <= bound` is a disc and the slip along its normal is along the force; work, the
//! load and the displacements stay what they are.

use std::borrow::Cow;

use super::ContactProblem;
use crate::linalg::Csr;

impl ContactProblem {
    /// Friction along the second tangent of point `j` over that along its first.
    pub fn across(&self, j: usize) -> f64 {
        self.friction_across.as_ref().map_or(1.0, |across| across[j])
    }

    /// The same problem with discs for ellipses: its displacements are those of this one, its multipliers those of
    /// [`to_isotropic`](Self::to_isotropic). Without supports, which only reports and certificates read.
    pub fn isotropic(&self) -> Cow<'_, ContactProblem> {
        if self.friction_across.is_none() {
            return Cow::Borrowed(self);
        }
        Cow::Owned(ContactProblem {
            K: self.K.clone(),
            f: self.f.clone(),
            B: self.isotropic_rows().into_owned(),
            gap: self.gap.clone(),
            slip_reference: self.isotropic_slip_reference().into_owned(),
            friction: self.friction.clone(),
            friction_across: None,
            area: self.area.clone(),
            share: self.share.clone(),
            pairs: self.pairs.clone(),
            node_of: self.node_of.clone(),
            near_kernel: self.near_kernel.clone(),
            supports: None,
            bodies: self.bodies.clone(),
        })
    }

    /// `B` of the isotropic problem.
    pub fn isotropic_rows(&self) -> Cow<'_, Csr> {
        let Some(across) = &self.friction_across else { return Cow::Borrowed(&self.B) };
        let mut rows = self.B.clone();
        for (j, a) in across.iter().enumerate() {
            let row = self.rows(j)[2];
            rows.value[self.B.start[row]..self.B.start[row + 1]].iter_mut().for_each(|v| *v *= a);
        }
        Cow::Owned(rows)
    }

    /// `slip_reference` of the isotropic problem, length `2m`.
    pub fn isotropic_slip_reference(&self) -> Cow<'_, [f64]> {
        let Some(across) = &self.friction_across else { return Cow::Borrowed(&self.slip_reference) };
        let mut reference = self.slip_reference.clone();
        reference[self.points()..].iter_mut().zip(across).for_each(|(s, a)| *s *= a);
        Cow::Owned(reference)
    }

    /// Turns multipliers of this problem, `3m`, into those of the isotropic one.
    pub fn to_isotropic(&self, lambda: &mut [f64]) {
        let across = self.friction_across.iter().flatten();
        // Where there is no friction across, there is no force to be told.
        lambda[2 * self.points()..].iter_mut().zip(across).for_each(|(l, &a)| *l = if a > 0.0 { *l / a } else { 0.0 });
    }

    /// Turns multipliers of the isotropic problem, `3m`, into those of this one.
    pub fn out_of_isotropic(&self, lambda: &mut [f64]) {
        let across = self.friction_across.iter().flatten();
        lambda[2 * self.points()..].iter_mut().zip(across).for_each(|(l, a)| *l *= a);
    }
}
