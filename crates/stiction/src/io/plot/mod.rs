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

/// Red, green and blue of `t` in 0..1 on the map of numbers.
pub fn map_color(t: f64) -> [u8; 3] {
    color::viridis(t)
}

/// Names and colours of the states of a contact point: open, stick, slip, and none of them.
pub fn states() -> [(&'static str, [u8; 3]); 4] {
    let [open, stick, slip] = color::STATUS;
    [open, stick, slip, color::OUTSIDE]
}

/// Labels of length, force and stress in a text such as `m, N, Pa`; empty where it does not name them.
pub fn units(text: Option<&str>) -> [&str; 3] {
    let parts: Vec<&str> = text.unwrap_or("").split(',').map(str::trim).collect();
    match parts[..] {
        [length, force, stress, ..] => [length, force, stress],
        _ => [""; 3],
    }
}

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
