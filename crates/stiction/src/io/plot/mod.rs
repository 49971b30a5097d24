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
    let mut encoder = png::Encoder::new(&mut out, info.width, info.height);
    encoder.set_color(info.color_type);
    encoder.set_depth(info.bit_depth);
    encoder.set_compression(png::Compression::Balanced);
    // Large even areas: rows as they are compress best.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(&pixels[..info.buffer_size()]).ok()?;
    writer.finish().ok()?;
    Some(out)
}

#[cfg(test)]
mod tests;
