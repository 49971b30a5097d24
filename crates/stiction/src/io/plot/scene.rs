//! A coloured surface in the picture.

use super::camera::{Camera, Vec3, add, area_vector, dot, norm, unit};
use super::color::{INK, MAP, MAP_STEPS, MISSING, Paint, Rgb};
use super::drawing::Drawing;
use super::edges::Edge;
use super::raster::{FINE, Raster, opaque};
use crate::Error;

/// A surface as it is drawn: faces of three or more nodes in the order of their border; with six and eight nodes every
/// other one is the middle of an edge that may be curved.
#[derive(Clone, Copy)]
pub(super) struct Surface<'a> {
    pub points: &'a [Vec3],
    pub faces: &'a [&'a [u32]],
}

impl Surface<'_> {
    /// Checks that faces are faces and have their points.
    pub(super) fn validate(&self) -> Result<(), Error> {
        for (i, face) in self.faces.iter().enumerate() {
            if face.len() < 3 {
                return Err(Error::new(
                    format!("face {i}"),
                    format!("it has {} nodes", face.len()),
                    "give at least three",
                ));
            }
            if let Some(node) = face.iter().find(|&&n| n as usize >= self.points.len()) {
                let what = format!("it has node {node}, but there are {} points", self.points.len());
                return Err(Error::new(format!("face {i}"), what, "number nodes from zero"));
            }
        }
        Ok(())
    }

    /// The points that the faces use; all points if there are no faces.
    pub(super) fn used(&self) -> Vec<u32> {
        if self.faces.is_empty() {
            return (0..self.points.len() as u32).collect();
        }
        let mut used = vec![false; self.points.len()];
        self.faces.iter().for_each(|f| f.iter().for_each(|&n| used[n as usize] = true));
        (0..used.len() as u32).filter(|&i| used[i as usize]).collect()
    }
}

/// Draws the surface, in the light of a lamp behind the observer's left shoulder if `lit`, with its edges where
/// these are far enough apart to be distinguished. Points without any face become discs.
pub(super) fn draw(raster: &mut Raster, camera: &Camera, surface: Surface, edges: &[Edge], paint: Paint, lit: bool) {
    let at: Vec<Vec3> = surface.points.iter().map(|&p| camera.project(p)).collect();
    let [right, up, toward] = camera.axes;
    let lamp = unit(add(add(toward, 0.6, up), -0.35, right));
    let normals: Vec<Vec3> = surface.faces.iter().map(|f| unit(area_vector(surface.points, f))).collect();
    // What faces the observer comes first: the rest is mostly hidden by it, and what is hidden costs no colour.
    for front in [true, false] {
        for (face, &normal) in surface.faces.iter().zip(&normals) {
            if (dot(normal, toward) >= 0.0) == front {
                // A face seen from behind is lit from behind.
                let facing = if front { 1.0 } else { -1.0 };
                let light = if lit { 0.72 + 0.28 * (facing * dot(normal, lamp)).max(0.0) } else { 1.0 };
                draw_face(raster, &at, face, paint, light);
            }
        }
    }
    let length = |e: &Edge| {
        let d = add(at[e.nodes[1] as usize], -1.0, at[e.nodes[0] as usize]);
        norm([d[0], d[1], 0.0])
    };
    let mean = edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
    if mean > 7.0 {
        // Fading in with the length of the edges, so that fine meshes do not darken the colours.
        let opacity = (0.02 * mean).min(0.35);
        edges.iter().for_each(|e| raster.line(at[e.nodes[0] as usize], at[e.nodes[1] as usize], 1, INK, opacity));
    }
}

/// Weights of the nodes at even and at odd places in the centre of a face: the mean, on quadratic faces (corners at even
/// places, middles of edges at odd ones) the values of the shape functions there, without which curved faces have dents.
fn center_weights(nodes: usize) -> [f64; 2] {
    match nodes {
        6 => [-1.0 / 9.0, 4.0 / 9.0],
        8 => [-0.25, 0.5],
        _ => [1.0 / nodes as f64; 2],
    }
}

/// Draws a face with its points `at` in the picture; `light` in 0..1.
fn draw_face(raster: &mut Raster, at: &[Vec3], face: &[u32], paint: Paint, light: f64) {
    let part = (256.0 * light) as u16;
    let shade = |color: Rgb| opaque(color.map(|c| ((u16::from(c) * part) >> 8) as u8));
    let corner = |k: usize| face[k % face.len()] as usize;
    let weights = center_weights(face.len());
    // Triangles around the centre: fewer would favour one diagonal, which shows in steep gradients.
    let center =
        std::array::from_fn(|k| face.iter().enumerate().map(|(i, &n)| weights[i % 2] * at[n as usize][k]).sum());
    if let Paint::Status(_) = paint {
        // Each place takes the state of its nearest vertex: two triangles a vertex, up to the middles of its edges.
        for k in 0..face.len() {
            let (a, b) = (corner(k), corner(k + 1));
            let middle = std::array::from_fn(|k| 0.5 * (at[a][k] + at[b][k]));
            for n in [a, b] {
                let color = shade(paint.vertex(n));
                raster.triangle([at[n], middle, center], [0.0; 3], |_| color);
            }
        }
        return;
    }
    let mean: f64 = face.iter().enumerate().map(|(i, &n)| weights[i % 2] * paint.place(n as usize)).sum();
    let map = &*MAP;
    let mut part = |corners: [Vec3; 3], places: [f64; 3]| {
        if mean.is_nan() {
            raster.triangle(corners, [0.0; 3], |_| shade(MISSING));
            return;
        }
        // Half a step more, as the conversion cuts off; it also takes what rounding puts below zero to zero.
        let places = places.map(|t| MAP_STEPS as f64 * t + 0.5);
        raster.triangle(corners, places, |place| shade(map[(place as u32).min(MAP_STEPS as u32) as usize]));
    };
    if let &[a, b, c] = face {
        // On a plane the parts around the centre show what the whole does.
        let corners = [a, b, c].map(|n| n as usize);
        return part(corners.map(|n| at[n]), corners.map(|n| paint.place(n)));
    }
    for k in 0..face.len() {
        let (a, b) = (corner(k), corner(k + 1));
        part([at[a], at[b], center], [paint.place(a), paint.place(b), mean]);
    }
}

/// Draws the points as discs; for surfaces known by their points only.
pub(super) fn dots(drawing: &mut Drawing, camera: &Camera, surface: Surface, paint: Paint) {
    for (i, &p) in surface.points.iter().enumerate() {
        let [x, y, _] = camera.project(p);
        drawing.disc([x, y], 4.5, INK);
        drawing.disc([x, y], 4.0, paint.vertex(i));
    }
}

/// Draws chosen edges as an outline of `width` pixels.
pub(super) fn outline(
    raster: &mut Raster,
    camera: &Camera,
    points: &[Vec3],
    edges: &[[u32; 2]],
    width: f64,
    color: Rgb,
) {
    let width = (width * FINE as f64).round() as i32;
    for nodes in edges {
        let [a, b] = nodes.map(|n| camera.project(points[n as usize]));
        raster.line(a, b, width, color, 1.0);
    }
}
