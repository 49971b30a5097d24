use super::V3;
use super::law::Linearised;

/// `x -> (W + alpha)⁻¹ x`, factorised.
pub type Shifted<'a> = Box<dyn Fn(&[V3]) -> Vec<V3> + 'a>;

/// Velocities of points as an affine function of their impulses, `u = W r + q`, scaled so that the diagonal blocks of
/// `W` have the trace 3 and `q` has length one; `W` is stored or not.
pub trait System {
    /// Coefficients of friction.
    fn mu(&self) -> &[f64];

    /// `q`.
    fn offset(&self) -> &[V3];

    /// `W r + q`.
    fn velocity(&self, r: &[V3]) -> Vec<V3>;

    /// The change of the impulses that solves the linearised laws of all points with `W + alpha`; `None` where the
    /// system is singular to working precision.
    fn step(&self, alpha: f64, points: &[Linearised]) -> Option<Vec<V3>>;

    /// `x -> (W + alpha)⁻¹ x`, factorised once; `None` if singular.
    fn shifted(&self, alpha: f64) -> Option<Shifted<'_>>;

    /// Sweeps over the points, each solved exactly, where `W` is stored; otherwise `false`, and `r` stays.
    fn sweep(&self, r: &mut [V3], sweeps: usize) -> bool;
}
