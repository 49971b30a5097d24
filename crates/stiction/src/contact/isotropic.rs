//! A problem whose friction differs by direction, as one whose friction does not.
//!
//! With tangential rows of `B` and slips across the first tangent multiplied by `a`, and forces divided by it, the
//! ellipse `|(lambda_1, lambda_2 / a)| <= bound` is a disc and the slip along its normal is along the force; work, the
//! load and the displacements stay what they are.
//!
//! Solvers never see an ellipse: one projection, on a disc, serves all laws. The certificate judges the ellipse itself.

use std::borrow::Cow;

use super::{Contact, ContactProblem, Labels};
use crate::linalg::Csr;

/// An orthotropy ratio below this is solved as none at all: friction across is then beyond what a certificate tells from
/// zero, and rows that short are infinitely stiff beside the others of their point.
const LEAST_RATIO: f64 = 1e-8;

fn solved(ratio: f64) -> f64 {
    if ratio < LEAST_RATIO { 0.0 } else { ratio }
}

impl ContactProblem {
    /// Friction along the second tangent of point `j` over that along its first, as solvers see it.
    pub fn orthotropy_ratio(&self, j: usize) -> f64 {
        self.contact.orthotropy.as_ref().map_or(1.0, |ratios| solved(ratios[j]))
    }

    /// The same problem with discs for ellipses: its displacements are those of this one, its multipliers those of
    /// [`to_isotropic`](Self::to_isotropic). Without supports, which only reports and certificates read.
    pub fn isotropic(&self) -> Cow<'_, ContactProblem> {
        if self.contact.orthotropy.is_none() {
            return Cow::Borrowed(self);
        }
        let contact = Contact {
            B: self.isotropic_rows().into_owned(),
            slip_reference: self.isotropic_slip_reference().into_owned(),
            orthotropy: None,
            ..self.contact.clone()
        };
        let labels = Labels { supports: None, ..self.labels.clone() };
        Cow::Owned(ContactProblem { elastic: self.elastic.clone(), contact, labels })
    }

    /// `B` of the isotropic problem.
    pub fn isotropic_rows(&self) -> Cow<'_, Csr> {
        let Some(ratios) = &self.contact.orthotropy else { return Cow::Borrowed(&self.contact.B) };
        let mut rows = self.contact.B.clone();
        for (j, a) in ratios.iter().enumerate() {
            let row = self.rows(j)[2];
            rows.value[self.contact.B.start[row]..self.contact.B.start[row + 1]]
                .iter_mut()
                .for_each(|v| *v *= solved(*a));
        }
        Cow::Owned(rows)
    }

    /// `slip_reference` of the isotropic problem, length `2m`.
    pub fn isotropic_slip_reference(&self) -> Cow<'_, [f64]> {
        let Some(ratios) = &self.contact.orthotropy else { return Cow::Borrowed(&self.contact.slip_reference) };
        let mut reference = self.contact.slip_reference.clone();
        reference[self.points()..].iter_mut().zip(ratios).for_each(|(s, a)| *s *= solved(*a));
        Cow::Owned(reference)
    }

    /// Turns multipliers of this problem, `3m`, into those of the isotropic one.
    pub fn to_isotropic(&self, lambda: &mut [f64]) {
        let ratios = self.contact.orthotropy.iter().flatten();
        // Where there is no friction across, there is no force.
        lambda[2 * self.points()..].iter_mut().zip(ratios).for_each(|(l, &a)| {
            *l = if solved(a) > 0.0 { *l / a } else { 0.0 };
        });
    }

    /// Turns multipliers of the isotropic problem, `3m`, into those of this one.
    pub fn out_of_isotropic(&self, lambda: &mut [f64]) {
        let ratios = self.contact.orthotropy.iter().flatten();
        lambda[2 * self.points()..].iter_mut().zip(ratios).for_each(|(l, a)| *l *= solved(*a));
    }
}
