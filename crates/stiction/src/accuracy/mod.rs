//! How far the mesh is from fine enough: an estimate of the discretisation error of an answer.
//!
//! The stress of an element is less smooth than that of the body. [`estimate`] recovers a smooth stress from it and takes the
//! difference of both, in the energy norm. Around each corner of the mesh a polynomial is fitted to the cells there: to their
//! stress at points where it is superconvergent (Zienkiewicz and Zhu 1992, "The superconvergent patch recovery and a
//! posteriori error estimates"), or, in tetrahedra with ten nodes, which have no such points, to the displacements of their
//! nodes, which is then differentiated (Zhang and Naga 2005, "A new finite element gradient recovery method:
//! superconvergence property"). It needs no constant, bounds nothing, and knows neither contact nor friction but through the
//! stress they cause.
//!
//! Where stress may jump nothing is averaged: cells of different [`region`](Straining::region)s have polynomials of their
//! own, and bodies in contact share no node.

pub mod bound;
mod cells;
mod nodal;
mod patches;

pub use bound::{Bound, NoBound, Standing, bound};
pub use cells::Straining;
pub(crate) use nodal::nodal_stress_at;
pub use nodal::{NodalStress, nodal_stress};

use cells::Body;
pub(crate) use patches::{PATCH, Patches};
use rayon::prelude::*;

use crate::fem::Solid;

/// An estimate of the discretisation error.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Estimate {
    /// Squared energy norm of the estimated error of the stress of each cell, energy.
    pub cells: Vec<f64>,
    /// Volume of each cell.
    pub volumes: Vec<f64>,
    /// Squared energy norm of the stress that was found, energy.
    pub norm2: f64,
    /// The same of the stress that would suppress all strain without stress, and of a part of what a rigid motion could be taken for; energy.
    pub suppressed2: f64,
}

/// Stress below this part of what thermal strain could cause, and of a part of what displacements could, is what the solver leaves of none.
const ROUNDING: f64 = 1e-7;

impl Estimate {
    /// That of the cells that add these parts.
    pub(crate) fn of(cells: &[OfCell]) -> Estimate {
        let sum = |part: usize| cells.iter().map(|parts| parts[part]).sum();
        let each = |part: usize| cells.iter().map(|parts| parts[part]).collect();
        Estimate { cells: each(0), volumes: each(2), norm2: sum(1), suppressed2: sum(3) }
    }

    /// Squared energy norm of the estimated error, energy.
    pub fn error2(&self) -> f64 {
        self.cells.iter().sum()
    }

    /// The estimated error over the energy norm of the exact stress, whose square is taken as that of the stress found and
    /// that of the error together; between 0 and 1, and 0 where there is no stress.
    pub fn relative(&self) -> f64 {
        let whole = self.whole2();
        if whole == 0.0 { 0.0 } else { (self.error2() / whole).sqrt() }
    }

    /// Of each cell the root of its squared error per volume over that of the whole squared norm per volume: the relative
    /// error where all cells are as bad, whatever their sizes.
    pub fn by_cell(&self) -> Vec<f64> {
        let of_cell = self.of_cell();
        let cells = self.cells.par_iter().zip(&self.volumes).with_min_len(4096);
        cells.map(|(&error, &volume)| of_cell(error, volume)).collect()
    }

    /// The same of a cell with this squared error, energy, and volume.
    pub(crate) fn of_cell(&self) -> impl Fn(f64, f64) -> f64 + Sync {
        let whole = self.whole2();
        let density = whole / self.volumes.iter().sum::<f64>();
        move |error, volume| if whole == 0.0 { 0.0 } else { (error / volume / density).sqrt() }
    }

    /// The squared norm that errors are compared with; zero where all stress is rounding.
    pub(crate) fn whole2(&self) -> f64 {
        let whole = self.norm2 + self.error2();
        if whole <= ROUNDING * ROUNDING * self.suppressed2 { 0.0 } else { whole }
    }
}

/// Estimates the discretisation error of the stress of a body; the result does not depend on the number of threads.
///
/// # Panics
/// If the lengths of `straining` do not fit the mesh.
pub fn estimate(solid: &Solid, straining: &Straining) -> Estimate {
    Estimate::of(&parts(solid, straining, |_| {}))
}

/// What a cell adds to an estimate: squared energy norms of the error and of the stress, energy; its volume; and the squared norm of the
/// stress that would suppress its strain without stress, energy.
pub(crate) type OfCell = [f64; 4];

/// What each cell of a body, or of a part of one, adds to its estimate. Where a part ends `complete` may replace polynomials of stress,
/// which lack the cells beyond.
pub(crate) fn parts(solid: &Solid, straining: &Straining, complete: impl FnOnce(&mut Patches)) -> Vec<OfCell> {
    let body = Body::new(solid, straining);
    let samples = body.samples();
    let mut patches = Patches::new(&body, &samples);
    complete(&mut patches);
    body.errors(&samples, &patches)
}
