//! Pictures of results, written as PNG or SVG: no display and no installed fonts are needed.

mod arrows;
mod camera;
mod color;
mod convergence;
mod decor;
mod deformed;
mod drawing;
mod edges;
mod font;
mod history;
mod pixels;
mod plane;
mod raster;
mod scene;
mod space;
mod surface;
mod svg;
mod ticks;

use std::io::Write;

pub use convergence::{ConvergencePoint, convergence};
pub use deformed::{DeformedPlot, deformed};
pub use drawing::{Align, Drawing};
pub use history::{HistoryPanel, history};
pub use space::{Axis, FaceColors, SpacePlot, space};
pub use surface::{MapValues, MapVectors, SurfaceMap, surface_map};

/// Writes rows of red, green and blue as a PNG file.
fn encode(file: impl Write, [width, height]: [u32; 2], rgb: &[u8]) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Half the time of level 3 without filters, for files half as large again: 2 % of a whole run with 200,000 unknowns.
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()
}

#[cfg(test)]
mod tests;
