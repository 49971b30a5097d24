use super::elastic::{Orthotropic, Voigt};
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

/// Linear elasticity.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Material {
    /// Its name in reports and messages.
    pub name: String,
    /// Young's modulus, stress; of an orthotropic material the mean of three, which only decides who is softer.
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5); not used of an orthotropic material.
    pub poisson: f64,
    /// Mass per volume; zero if gravity does not act on it.
    pub density: f64,
    /// How the strain of linear cells is integrated.
    pub formulation: Formulation,
    /// `None` if isotropic.
    pub orthotropic: Option<Box<Orthotropic>>,
    /// Strain of a free body for each unit of temperature, in the axes of the mesh; `None` if it is not known.
    pub expansion: Option<Voigt>,
    /// The temperature without thermal strain.
    pub reference_temperature: f64,
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
            _ if self.orthotropic.is_some() => false,
            Formulation::Auto => self.poisson > NEARLY_INCOMPRESSIBLE,
            Formulation::Full => false,
            Formulation::BBar => true,
        }
    }

    /// Checks `young > 0`, `-1 < poisson < 0.5` and `density >= 0`, which make the stiffness positive.
    ///
    /// # Errors
    /// If a modulus is out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let bad = |what: String, remedy: &str| Err(Error::new(format!("material \"{}\"", self.name), what, remedy));
        if !(self.young > 0.0 && self.young.is_finite()) {
            return bad(format!("Young's modulus is {}", self.young), "give a positive stress");
        }
        if self.orthotropic.is_none() && !(self.poisson > -1.0 && self.poisson < 0.5) {
            return bad(
                format!("Poisson's ratio is {}", self.poisson),
                "give a number above -1 and below 0.5; for an incompressible material take 0.4999 and hexahedra",
            );
        }
        if !(self.density >= 0.0 && self.density.is_finite()) {
            return bad(format!("the density is {}", self.density), "give mass per volume, zero or positive");
        }
        if self.orthotropic.is_some() && self.formulation == Formulation::BBar {
            let remedy = "take `formulation` out: the dilatation of an orthotropic material has no modulus of its own";
            return bad("B-bar is for isotropic materials, and this one is orthotropic".into(), remedy);
        }
        if !self.reference_temperature.is_finite() || self.expansion.is_some_and(|e| e.iter().any(|v| !v.is_finite())) {
            return bad("expansion or reference temperature is not finite".into(), "give finite numbers");
        }
        Ok(())
    }
}
