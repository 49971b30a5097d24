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

/// A picture written anew with a better compression; `None` if it is no PNG of ours.
pub fn compressed(png: &[u8]) -> Option<Vec<u8>> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().ok()?;
    let mut pixels = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut pixels).ok()?;
    let mut out = Vec::new();
    let ours = (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    let pixels = ours.then(|| &pixels[..info.buffer_size()])?;
    // Large even areas: rows as they are compress best.
    let how = (png::Compression::Balanced, png::Filter::NoFilter);
    encode(&mut out, [info.width, info.height], pixels, how).ok()?;
    Some(out)
}

/// Writes rows of red, green and blue as a PNG file.
fn encode(
    file: impl Write,
    [width, height]: [u32; 2],
    rgb: &[u8],
    (compression, filter): (png::Compression, png::Filter),
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_filter(filter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()
}

#[cfg(test)]
mod tests;
