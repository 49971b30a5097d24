//! Pictures of results, drawn into memory and written as PNG: no display and no installed fonts are needed.

mod arrows;
mod camera;
mod canvas;
mod color;
mod convergence;
mod decor;
mod deformed;
mod drawing;
mod edges;
mod history;
mod plane;
mod raster;
mod scene;
mod space;
mod surface;
mod svg;
mod ticks;

pub use convergence::{ConvergencePoint, convergence};
pub use deformed::{DeformedPlot, deformed};
pub use drawing::{Align, Drawing};
pub use history::{HistoryPanel, history};
pub use space::{Axis, FaceColors, SpacePlot, space};
pub use surface::{MapValues, MapVectors, SurfaceMap, surface_map};

#[cfg(test)]
mod tests;
