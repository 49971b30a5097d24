use super::V3;
use crate::friction::system::System;

/// `x -> (W + shift)⁻¹ x`, factorised.
pub(super) type Shifted<'a> = Box<dyn Fn(&[V3]) -> Vec<V3> + 'a>;

/// Points under Coulomb's law with their velocities as an affine function of their impulses, `u = W r + q`, scaled so
/// that the diagonal blocks of `W` have the trace 3 and `q` has length one; `W` is stored or not. As a [`System`] the
/// impulses are the multipliers, the velocities `v`, and the parameter of the law is one.
pub(super) trait Discrete: System {
    /// Coefficients of friction.
    fn mu(&self) -> &[f64];

    /// `q`.
    fn offset(&self) -> &[V3];

    /// `W r + q`.
    fn velocity(&self, r: &[V3]) -> Vec<V3>;

    /// `x -> (W + shift)⁻¹ x`, factorised once; `None` if singular.
    fn shifted(&self, shift: f64) -> Option<Shifted<'_>>;

    /// Sweeps over the points, each solved exactly, where `W` is stored; otherwise `false`, and `r` stays.
    fn sweep(&self, r: &mut [V3], sweeps: usize) -> bool;
}
