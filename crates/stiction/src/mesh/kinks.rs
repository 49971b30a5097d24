//! How far the faces of a surface are off the smooth one that they stand for.
//!
//! A smooth surface has one normal everywhere. Where two faces meet at an angle `φ` they are off it by about `φ h / 8`, with the width `h`
//! of a face: exactly so for facets of a cylinder; faces of second degree with their nodes on it are off by `φ h / 32`.

use std::collections::HashMap;

use super::v3::{V3, cross, dot, norm, scale, sub};
use super::{Face, Mesh};

/// Faces that meet at a larger angle meet at an edge of the part, degrees.
const EDGE: f64 = 30.0;

/// How far these faces of a mesh are off the smooth surface that they stand for, in the mean by area; length.
pub fn kinks(mesh: &Mesh, faces: &[u32]) -> f64 {
    let mut meets: HashMap<[u32; 2], (usize, [V3; 2])> = HashMap::with_capacity(2 * faces.len());
    let mut off = vec![0.0f64; faces.len()];
    let areas: Vec<f64> = faces.iter().map(|&face| mesh.face_area(face as usize)).collect();
    for (place, &number) in faces.iter().enumerate() {
        let face = &mesh.faces[number as usize];
        let count = face.corners().len();
        for k in 0..count {
            let [a, b] = [k, (k + 1) % count].map(|k| (face.corners()[k], normal_at(mesh, face, k)));
            let [(a, n), (b, m)] = if a.0 < b.0 { [a, b] } else { [b, a] };
            let Some((other, theirs)) = meets.insert([a, b], (place, [n, m])) else { continue };
            let angle = [angle(n, theirs[0]), angle(m, theirs[1])].into_iter().fold(0.0, f64::max);
            if angle.to_degrees() > EDGE {
                continue;
            }
            let length = norm(sub(mesh.nodes[b as usize], mesh.nodes[a as usize]));
            // Twice the area of a triangle over its edge is its width, once that of a quadrilateral.
            let width = |place: usize, count: usize| if count == 3 { 2.0 } else { 1.0 } * areas[place] / length;
            let height = angle / 8.0 * 0.5 * (width(place, count) + width(other, count));
            [place, other].iter().for_each(|&place| off[place] = off[place].max(height));
        }
    }
    let area: f64 = areas.iter().sum();
    if area == 0.0 { 0.0 } else { off.iter().zip(&areas).map(|(off, area)| off * area).sum::<f64>() / area }
}

/// The normal of a face at its corner `k`, not of unit length.
fn normal_at(mesh: &Mesh, face: &Face, k: usize) -> V3 {
    let (corners, middles) = (face.corners(), &face.nodes()[face.corners().len()..]);
    let count = corners.len();
    let x = |node: u32| mesh.nodes[node as usize];
    // The tangent at `from` of the edge to `to`, whose middle, if it has one, is that of edge `edge`.
    let tangent = |from: usize, to: usize, edge: usize| {
        let chord = sub(x(corners[to]), x(corners[from]));
        match middles.get(edge) {
            Some(&middle) => sub(scale(4.0, sub(x(middle), x(corners[from]))), chord),
            None => chord,
        }
    };
    let before = (k + count - 1) % count;
    cross(tangent(k, (k + 1) % count, k), tangent(k, before, before))
}

fn angle(a: V3, b: V3) -> f64 {
    norm(cross(a, b)).atan2(dot(a, b))
}

#[cfg(test)]
mod tests {
    use super::super::{BlockElement, Ring, ring};
    use super::*;

    /// A quarter of a tube of radius 1: facets are off it by their height, faces of second degree by a^4/32 of half their angle a, of which four
    /// times as much is said.
    #[test]
    fn facets_of_a_tube_are_off_it_by_their_height() {
        for element in [BlockElement::Hex8, BlockElement::Tet4Six, BlockElement::Hex20, BlockElement::Tet10Six] {
            let cells = [2, 8, 3];
            let tube = Ring { radii: [1.0, 2.0], height: 1.0, degrees: 90.0, cells, grading: [1.0; 3], element };
            let mesh = ring(&tube).unwrap();
            let found = kinks(&mesh, &mesh.group("inner").unwrap().faces);
            let half = 45f64.to_radians() / 8.0;
            let expected = if element.is_quadratic() { half.powi(4) / 8.0 } else { 1.0 - half.cos() };
            // Of two triangles at either end one has no kink at all.
            assert!((0.85..1.02).contains(&(found / expected)), "{element:?}: {found:e} {expected:e}");
            let flat = kinks(&mesh, &mesh.group("z-max").unwrap().faces);
            assert!(flat < 1e-15, "{flat}");
        }
    }
}
