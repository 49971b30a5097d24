//! The deformed body, coloured by displacement.

use super::camera::{Area, Camera, Vec3, add, bounds, norm};
use super::color::{INK, Paint, Rgb, range_of};
use super::decor;
use super::drawing::Drawing;
use super::edges::{Edge, edges_of};
use super::raster::Raster;
use super::scene::{self, Surface};
use super::ticks::{number, round_down};
use crate::Error;

/// What the picture of a deformed body shows.
#[derive(Debug, Clone, Copy)]
pub struct DeformedPlot<'a> {
    /// Coordinates before deformation, length.
    pub points: &'a [[f64; 3]],
    /// Nodes of the boundary faces, three or more each, counter-clockwise seen from outside.
    pub faces: &'a [&'a [u32]],
    /// A vector a point, length.
    pub displacement: &'a [[f64; 3]],
    /// Heading of the picture.
    pub title: &'a str,
    /// Unit of length, such as `m`; may be empty.
    pub unit_label: &'a str,
    /// Factor on the displacement, > 0; chosen if `None`.
    pub scale: Option<f64>,
}

const OUTLINE: Rgb = [150, 150, 150];

/// Draws the body and returns the factor by which the displacement was enlarged.
///
/// # Errors
/// If a face has fewer than three nodes or one that does not exist, there is not one displacement a point, or the scale
/// is not a positive number.
pub fn deformed(plot: &DeformedPlot) -> Result<(Drawing, f64), Error> {
    let undeformed = Surface { points: plot.points, faces: plot.faces };
    undeformed.validate()?;
    if plot.displacement.len() != plot.points.len() {
        let what = format!("{} displacements for {} points", plot.displacement.len(), plot.points.len());
        return Err(Error::new("", what, "give a vector for each point"));
    }
    if let Some(scale) = plot.scale.filter(|s| !(s.is_finite() && *s > 0.0)) {
        let what = format!("the scale factor is {scale}");
        return Err(Error::new("", what, "give a positive number or leave it open"));
    }
    let magnitude: Vec<f64> = plot.displacement.iter().map(|&u| norm(u)).collect();
    let used = undeformed.used();
    let largest = used.iter().map(|&i| magnitude[i as usize]).filter(|m| m.is_finite()).fold(0.0, f64::max);
    let of_used = |points: &[Vec3]| used.iter().map(|&i| points[i as usize]).collect::<Vec<_>>();
    let [low, high] = bounds(of_used(plot.points)).unwrap_or([[0.0; 3]; 2]);
    let size = add(high, -1.0, low);
    let scale = plot.scale.unwrap_or_else(|| readable_scale(largest, norm(size)));
    let moved: Vec<Vec3> = plot.points.iter().zip(plot.displacement).map(|(&p, &u)| add(p, scale, u)).collect();

    let mut drawing = Drawing::new(1400, 1000);
    let area = Area { left: 70.0, top: 130.0, right: 1150.0, bottom: 930.0 };
    let axes = Camera::upright(Camera::diagonal(size));
    let camera = Camera::fit(axes, of_used(plot.points).into_iter().chain(of_used(&moved)), area);
    let toward = camera.axes[2];
    let surface = Surface { points: &moved, faces: plot.faces };
    let paint = Paint::Scalar {
        values: &magnitude,
        range: range_of(&used.iter().map(|&i| magnitude[i as usize]).collect::<Vec<_>>()),
    };
    let [before, after] = edges_of([plot.points, &moved], plot.faces);
    let mut raster = Raster::new(&drawing, area.with_lines());
    scene::draw(&mut raster, &camera, surface, &after, paint, true);
    let seen = |edges: &'_ [Edge]| edges.iter().filter(|e| e.outlines(toward)).map(|e| e.nodes).collect::<Vec<_>>();
    scene::outline(&mut raster, &camera, plot.points, &seen(&before), 1.0, OUTLINE);
    scene::outline(&mut raster, &camera, &moved, &seen(&after), 1.0, INK);
    drawing.image(raster.image());
    if plot.faces.is_empty() {
        scene::dots(&mut drawing, &camera, surface, paint);
    }
    let enlarged = if scale == 1.0 { "true scale".to_string() } else { format!("displacement × {}", number(scale)) };
    let most = format!("largest {} {}", number(largest), plot.unit_label);
    let subtitle = format!("{enlarged}  ·  {}  ·  grey: undeformed", most.trim_end());
    decor::heading(&mut drawing, plot.title, &subtitle);
    let bar = Area { left: 1200.0, top: 190.0, right: 1385.0, bottom: 870.0 };
    decor::key(&mut drawing, bar, paint, "Displacement", plot.unit_label);
    decor::triad(&mut drawing, &camera);
    Ok((drawing, scale))
}

/// A round factor that makes the largest displacement up to 8 % of the size; both lengths.
fn readable_scale(largest: f64, size: f64) -> f64 {
    let wanted = 0.08 * size / largest;
    // Displacements that can be seen anyway are shown as they are, unless they carry the body out of the picture.
    if wanted < 1.0 && largest < 0.5 * size {
        return 1.0;
    }
    let factor = round_down(wanted);
    if factor > 0.0 { factor } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_factors_make_small_displacements_visible_and_leave_large_ones() {
        assert_eq!(readable_scale(1e-5, 3.0), 20_000.0);
        assert_eq!(readable_scale(0.3, 3.0), 1.0);
        assert_eq!(readable_scale(30.0, 3.0), 0.005);
        assert_eq!((readable_scale(0.0, 3.0), readable_scale(1.0, 0.0), readable_scale(0.0, 0.0)), (1.0, 1.0, 1.0));
    }
}
