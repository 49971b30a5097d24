//! Pictures of results, drawn into memory and written as PNG: no display and no installed fonts are needed.

mod arrows;
mod camera;
mod canvas;
mod color;
mod convergence;
mod decor;
mod deformed;
mod edges;
mod plane;
mod raster;
mod scene;
mod surface;
mod ticks;

pub use convergence::{ConvergencePoint, convergence};
pub use deformed::{DeformedPlot, deformed};
pub use surface::{MapValues, MapVectors, SurfaceMap, surface_map};

#[cfg(test)]
mod tests;
