//! The elastic bodies alone, by the hierarchy that contact is solved with.

use super::directions::norm;
use super::solve::Multigrid;
use crate::Error;
use crate::linalg::Stop;

/// Steps of conjugate gradients at most: the hierarchy reduces errors by a factor of three or more each time.
const MOST_STEPS: usize = 200;

impl Multigrid {
    /// Displacements of the bodies without contact under `forces` on the unknowns, by conjugate gradients with one cycle as
    /// preconditioner, until the residual is `tolerance` times the forces. The hierarchy has to be as it was set up, of a
    /// problem without contact points.
    ///
    /// # Errors
    /// If a body is not held, the tolerance is not reached, or `stop` asks to end.
    pub fn solve_elastic(&self, forces: &[f64], tolerance: f64, stop: &Stop) -> Result<Vec<f64>, Error> {
        let refused = |what: &str| Error::new("", what, "hold every body by prescribed displacements");
        if self.hierarchy.is_singular() {
            return Err(refused("a body can move without strain"));
        }
        let k = &self.transformed.k;
        let mut residual = self.transformed.forces(forces);
        let target = tolerance * norm(&k.halo, &residual);
        let mut x = vec![[0.0; 3]; residual.len()];
        let (mut direction, mut before) = (x.clone(), 1.0);
        for _ in 0..MOST_STEPS {
            if norm(&k.halo, &residual) <= target {
                return Ok(self.transformed.out_of_frames(&x));
            }
            stop.check()?;
            let corrected = self.hierarchy.cycle(&residual);
            let product = inner(&corrected, &residual);
            add_times(1.0, &corrected, product / before, &mut direction);
            before = product;
            let image = k.times(&direction);
            let length = product / inner(&direction, &image);
            add_times(length, &direction, 1.0, &mut x);
            add_times(-length, &image, 1.0, &mut residual);
        }
        Err(refused("conjugate gradients did not solve the elastic problem"))
    }
}

fn inner(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
}

/// `y = a x + b y`.
fn add_times(a: f64, x: &[[f64; 3]], b: f64, y: &mut [[f64; 3]]) {
    y.as_flattened_mut().iter_mut().zip(x.as_flattened()).for_each(|(y, x)| *y = a * x + b * *y);
}
