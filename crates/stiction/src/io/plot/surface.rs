//! Maps of a contact surface.

use super::arrows::{self, Arrows};
use super::camera::{Area, Camera, Vec3, add, area_vector, dot, norm, unit};
use super::color::{INK, Paint, range_of};
use super::decor;
use super::drawing::Drawing;
use super::edges::{Edge, edges};
use super::plane::{self, Plane};
use super::raster::Raster;
use super::scene::{self, Surface};
use super::ticks::number;
use crate::Error;

/// What colours a map.
#[derive(Debug, Clone, Copy)]
pub enum MapValues<'a> {
    /// A number a vertex; NaN where there is none.
    Scalar(&'a [f64]),
    /// The state of each vertex: 0 open, 1 stick, 2 slip, anything else no contact point.
    Status(&'a [u8]),
}

/// Arrows over a map.
#[derive(Debug, Clone, Copy)]
pub struct MapVectors<'a> {
    /// A vector a vertex; NaN where there is none.
    pub values: &'a [[f64; 3]],
    /// What they are, such as `Shear traction`.
    pub label: &'a str,
    /// Their unit; may be empty.
    pub unit_label: &'a str,
}

/// What the map of a contact surface shows.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceMap<'a> {
    /// Coordinates of the vertices, length.
    pub points: &'a [[f64; 3]],
    /// Vertices of each face, three or more; without faces the vertices are drawn as discs.
    pub faces: &'a [&'a [u32]],
    /// The values that colour it.
    pub values: MapValues<'a>,
    /// Arrows over it.
    pub vectors: Option<MapVectors<'a>>,
    /// Which vertices matter: a flat map is cut down to their surroundings where they take a small part of it.
    pub focus: Option<&'a [bool]>,
    /// Heading of the picture.
    pub title: &'a str,
    /// What the values are, such as `Pressure`; unused for states.
    pub label: &'a str,
    /// Unit of the values; may be empty.
    pub unit_label: &'a str,
    /// Unit of length; may be empty.
    pub length_label: &'a str,
}

/// Draws the map: flat, projected along the average normal, with axes; or, if the normals of the surface differ from
/// their average by more than 60 degrees, as a body in space.
///
/// # Errors
/// If a face has fewer than three vertices or one that does not exist, or there is not one value a vertex.
pub fn surface_map(map: &SurfaceMap) -> Result<Drawing, Error> {
    let surface = Surface { points: map.points, faces: map.faces };
    validate(map, surface)?;
    let paint = match map.values {
        MapValues::Scalar(values) => Paint::Scalar { values, range: range_of(values) },
        MapValues::Status(status) => Paint::Status(status),
    };
    Ok(match orientation(surface) {
        Orientation::Flat(normal) => flat(map, surface, paint, normal),
        Orientation::Curved(toward) => curved(map, surface, paint, toward),
    })
}

fn validate(map: &SurfaceMap, surface: Surface) -> Result<(), Error> {
    surface.validate()?;
    let values = match map.values {
        MapValues::Scalar(values) => values.len(),
        MapValues::Status(status) => status.len(),
    };
    let vectors = map.vectors.map_or(map.points.len(), |v| v.values.len());
    let marks = map.focus.map_or(map.points.len(), |f| f.len());
    for (what, count) in [("values", values), ("vectors", vectors), ("marks of focus", marks)] {
        if count != map.points.len() {
            let what = format!("{count} {what} for {} vertices", map.points.len());
            return Err(Error::new("", what, "give one for each vertex, NaN where there is none"));
        }
    }
    Ok(())
}

enum Orientation {
    /// With its normal.
    Flat(Vec3),
    /// With the direction of an observer who sees most of it.
    Curved(Vec3),
}

fn orientation(surface: Surface) -> Orientation {
    /// Cosine of 60 degrees.
    const SPREAD: f64 = 0.5;
    let areas: Vec<Vec3> = surface.faces.iter().map(|f| area_vector(surface.points, f)).collect();
    let finite = || areas.iter().filter(|a| a.iter().all(|x| x.is_finite()) && norm(**a) > 0.0);
    let sum = finite().fold([0.0; 3], |sum, &a| add(sum, 1.0, a));
    let average = unit(sum);
    if finite().all(|&a| dot(unit(a), average) >= SPREAD) {
        let up = [0.0, 0.0, 1.0];
        return Orientation::Flat(if norm(average) > 0.0 { average } else { up });
    }
    let side = unit(Camera::diagonal([1.0, 1.0, 1.0]));
    // The parts of a closed surface cancel each other: no side of it is the contact's.
    let one_sided = norm(sum) > 0.2 * finite().map(|&a| norm(a)).sum::<f64>();
    Orientation::Curved(if one_sided { add(average, 0.7, side) } else { side })
}

/// Where the key stands in a picture of the given height.
fn key_area(bottom: f64) -> Area {
    Area { left: 1170.0, top: 140.0, right: 1385.0, bottom }
}

fn flat(map: &SurfaceMap, surface: Surface, paint: Paint, normal: Vec3) -> Drawing {
    let plane = Plane::along(normal);
    let used: Vec<Vec3> = surface.used().iter().map(|&i| surface.points[i as usize]).collect();
    let whole = plane.bounds(&used);
    let detail = detail(map, surface, &plane, whole);
    let extent = detail.unwrap_or(whole);
    let (wide, high) = (extent[0][1] - extent[0][0], extent[1][1] - extent[1][0]);
    // The picture is as high as the surface at full width, within limits.
    let room = 960.0 * high / wide;
    let room = if room.is_finite() { room.clamp(330.0, 780.0) } else { 780.0 };
    let area = Area { left: 130.0, top: 140.0, right: 1110.0, bottom: 140.0 + room };
    let inner =
        Area { left: area.left + 10.0, top: area.top + 10.0, right: area.right - 10.0, bottom: area.bottom - 10.0 };
    let mut drawing = Drawing::new(1400, (area.bottom + 100.0) as usize);
    let corner =
        |i: usize, j: usize| add([0, 1, 2].map(|k| extent[0][i] * plane.axes[0][k]), extent[1][j], plane.axes[1]);
    let shown = if detail.is_some() { vec![corner(0, 0), corner(1, 1)] } else { used };
    let camera = Camera::fit(plane.axes, shown, inner);
    let frame = plane::frame(&camera, extent);
    paint_surface(&mut drawing, &camera, surface, paint, false, frame);
    plane::axes(&mut drawing, &camera, &plane, extent, map.length_label);
    let note = if detail.is_some() { "detail around the contact" } else { "" };
    let note = [note, &plane.note].into_iter().filter(|n| !n.is_empty()).collect::<Vec<_>>().join("  ·  ");
    finish(&mut drawing, &camera, map, paint, area.bottom, frame, &note);
    drawing
}

/// The part of a flat map to show instead of the whole: that of the focus and 20 % more on each side, at least a few
/// faces wide; `None` if that is not much less than the whole.
fn detail(map: &SurfaceMap, surface: Surface, plane: &Plane, whole: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let marked = |n: u32| map.focus.is_some_and(|f| f[n as usize]);
    let near: Vec<&&[u32]> = surface.faces.iter().filter(|f| f.iter().any(|&n| marked(n))).collect();
    let points: Vec<Vec3> = near.iter().flat_map(|f| f.iter()).map(|&n| surface.points[n as usize]).collect();
    let center: Vec<Vec3> =
        (0..map.points.len() as u32).filter(|&n| marked(n)).map(|n| map.points[n as usize]).collect();
    if points.is_empty() || center.is_empty() {
        return None;
    }
    let (inner, outer) = (plane.bounds(&center), plane.bounds(&points));
    let small = (0..2).all(|k| inner[k][1] - inner[k][0] <= 0.5 * (whole[k][1] - whole[k][0]));
    // A face more at each end even where a single vertex matters.
    let wide = (0..2).map(|k| 1.4 * (outer[k][1] - outer[k][0])).fold(0.0, f64::max);
    let around = |k: usize| {
        let (middle, half) = (0.5 * (outer[k][0] + outer[k][1]), 0.5 * wide);
        [(middle - half).max(whole[k][0]), (middle + half).min(whole[k][1])]
    };
    let cut = [around(0), around(1)];
    let less = (0..2).any(|k| cut[k][1] - cut[k][0] < 0.75 * (whole[k][1] - whole[k][0]));
    (small && less && wide.is_finite()).then_some(cut)
}

fn curved(map: &SurfaceMap, surface: Surface, paint: Paint, toward: Vec3) -> Drawing {
    let mut drawing = Drawing::new(1400, 1000);
    let area = Area { left: 70.0, top: 150.0, right: 1110.0, bottom: 930.0 };
    let used = surface.used();
    let camera = Camera::fit(Camera::upright(toward), used.iter().map(|&i| surface.points[i as usize]), area);
    paint_surface(&mut drawing, &camera, surface, paint, true, area.with_lines());
    decor::triad(&mut drawing, &camera);
    finish(&mut drawing, &camera, map, paint, 880.0, area, "");
    drawing
}

/// Draws the surface, which is lit where it is curved, within `area`.
fn paint_surface(drawing: &mut Drawing, camera: &Camera, surface: Surface, paint: Paint, lit: bool, area: Area) {
    let edges = edges(surface.points, surface.faces);
    let mut raster = Raster::new(drawing, area);
    scene::draw(&mut raster, camera, surface, &edges, paint, lit);
    let border = |e: &&Edge| e.is_border() || (lit && e.outlines(camera.axes[2]));
    let border: Vec<[u32; 2]> = edges.iter().filter(border).map(|e| e.nodes).collect();
    scene::outline(&mut raster, camera, surface.points, &border, 1.0, INK);
    drawing.image(raster.image());
    if surface.faces.is_empty() {
        scene::dots(drawing, camera, surface, paint);
    }
}

/// Arrows within `area`, a key that ends at `bottom`, and title.
fn finish(drawing: &mut Drawing, camera: &Camera, map: &SurfaceMap, paint: Paint, bottom: f64, area: Area, note: &str) {
    let surface = Surface { points: map.points, faces: map.faces };
    let drawn = map.vectors.and_then(|v| {
        let scale = Arrows::scaled(v.values)?;
        let arrows = scale.on(camera, area, surface, v.values);
        // Where none is seen, their scale would only puzzle.
        (!arrows.is_empty()).then_some((v, scale, arrows))
    });
    let key = key_area(if drawn.is_some() { bottom - 110.0 } else { bottom });
    let end = decor::key(drawing, key, paint, map.label, map.unit_label);
    if let Some((vectors, scale, arrows)) = drawn {
        arrows.iter().for_each(|&[from, to]| arrows::haloed(drawing, from, to));
        scale.reference(drawing, [key.left, end + 40.0], vectors.label, vectors.unit_label);
    }
    let summary = match map.values {
        MapValues::Scalar(values) => {
            let [low, high] = extremes(values);
            format!("{} to {} {}", number(low), number(high), map.unit_label)
        }
        MapValues::Status(status) => {
            let count = |s: u8| status.iter().filter(|&&x| x == s).count();
            format!("{} open, {} stick, {} slip", count(0), count(1), count(2))
        }
    };
    let subtitle = if note.is_empty() { summary } else { format!("{}  ·  {note}", summary.trim_end()) };
    decor::heading(drawing, map.title, &subtitle);
}

/// Smallest and largest finite value; NaN without any.
fn extremes(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    finite.fold([f64::NAN; 2], |[low, high], v| [low.min(v), high.max(v)])
}
