use crate::Error;

/// How the strain of a hexahedron is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Formulation {
    /// B-bar where Poisson's ratio exceeds 0.45, full integration elsewhere.
    #[default]
    Auto,
    /// 2 x 2 x 2 Gauss points.
    Full,
    /// Mean dilatation (Hughes 1980): the volumetric strain is averaged over the cell, which avoids locking.
    BBar,
}

/// Isotropic linear elasticity.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    pub name: String,
    /// Young's modulus, stress.
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Mass per volume; zero if gravity does not act on it.
    pub density: f64,
    pub formulation: Formulation,
}

/// Above this Poisson's ratio [`Formulation::Auto`] takes B-bar for hexahedra, and linear tetrahedra are said to lock.
pub const NEARLY_INCOMPRESSIBLE: f64 = 0.45;

impl Material {
    /// Lamé's parameters `(lambda, mu)`, both stress; `mu` is the shear modulus.
    pub fn lame(&self) -> (f64, f64) {
        let (e, nu) = (self.young, self.poisson);
        (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
    }

    /// Whether hexahedra of this material average the dilatation over the cell.
    pub fn averages_dilatation(&self) -> bool {
        match self.formulation {
            Formulation::Auto => self.poisson > NEARLY_INCOMPRESSIBLE,
            Formulation::Full => false,
            Formulation::BBar => true,
        }
    }

    /// Checks `young > 0`, `-1 < poisson < 0.5` and `density >= 0`, which make the stiffness positive.
    pub fn validate(&self) -> Result<(), Error> {
        let bad = |what: String, remedy: &str| Err(Error::new(format!("material \"{}\"", self.name), what, remedy));
        if !(self.young > 0.0 && self.young.is_finite()) {
            return bad(format!("Young's modulus is {}", self.young), "give a positive stress");
        }
        if !(self.poisson > -1.0 && self.poisson < 0.5) {
            return bad(
                format!("Poisson's ratio is {}", self.poisson),
                "give a number above -1 and below 0.5; for an incompressible material take 0.4999 and hexahedra",
            );
        }
        if !(self.density >= 0.0 && self.density.is_finite()) {
            return bad(format!("the density is {}", self.density), "give mass per volume, zero or positive");
        }
        Ok(())
    }
}
