//! A problem whose points have a tensile strength, as one whose points have none.
//!
//! With `t` the strengths, `lambda' = lambda + t` along the normals obeys a law without tension under the load `f + Nᵀ t`:
//! the surfaces are pressed together by their strength beforehand. Displacements stay what they are.
//! Solvers see only such problems; the certificate judges the law with its strengths.

use super::{ContactProblem, Friction};

impl ContactProblem {
    /// The problem without strengths: its displacements are those of this one, its multipliers those of
    /// [`add_strength`](Self::add_strength). `None` where no point has any.
    pub fn without_strength(&self) -> Option<ContactProblem> {
        if self.contact.friction.iter().all(|law| law.tension() == 0.0) {
            return None;
        }
        let mut shifted = self.clone();
        let mut strength = vec![0.0; 3 * self.points()];
        self.add_strength(&mut strength);
        let add = |load: &mut [f64], more: Vec<f64>| load.iter_mut().zip(more).for_each(|(f, more)| *f += more);
        let pressed = self.contact.B.transpose_times(&strength);
        add(&mut shifted.elastic.f, pressed.clone());
        if let Some(supports) = &mut shifted.labels.supports {
            let held = supports.B.transpose_times(&strength);
            add(&mut supports.free_load, pressed);
            add(&mut supports.load, held);
        }
        for law in &mut shifted.contact.friction {
            if let Friction::Cohesive { coefficient, cohesion, tension } = *law {
                let cohesion = (cohesion - coefficient * tension).max(0.0);
                *law = Friction::Cohesive { coefficient, cohesion, tension: 0.0 };
            }
        }
        Some(shifted)
    }

    /// Turns multipliers of this problem, `3m`, into those of the one without strengths.
    pub fn add_strength(&self, lambda: &mut [f64]) {
        lambda.iter_mut().zip(&self.contact.friction).for_each(|(l, law)| *l += law.tension());
    }

    /// Turns multipliers of the problem without strengths, `3m`, into those of this one.
    pub fn take_strength_off(&self, lambda: &mut [f64]) {
        lambda.iter_mut().zip(&self.contact.friction).for_each(|(l, law)| *l -= law.tension());
    }
}
