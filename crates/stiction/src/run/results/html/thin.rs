//! A coarser surface where there are too many faces.

use std::collections::{HashMap, HashSet};

use super::View;
use crate::mesh::Bounds;
use crate::mesh::v3::sub;

/// Merges the vertices within the cubes of a grid (J. Rossignac, P. Borrel 1993, vertex clustering) until at most
/// `most` faces are left, and returns which vertex stands for each that is left; `None` if there are no more from the
/// start. Vertices of contact surfaces and others are not merged with each other. The frames must be empty.
pub(crate) fn thin(view: &mut View, most: usize) -> Option<Vec<u32>> {
    if view.faces.len() <= most {
        return None;
    }
    let Bounds { low, high } = Bounds::around(view.points.iter().copied());
    let size = sub(high, low).into_iter().fold(0.0, f64::max);
    // A cube has six sides of n x n faces.
    let mut cells = (most as f64 / 6.0).sqrt();
    loop {
        let (kept, cluster) = clusters(view, size / cells.max(1.0));
        let mut known = HashSet::new();
        let mut first_contact_face = 0;
        let mut faces = Vec::new();
        for (number, face) in view.faces.iter().enumerate() {
            let face = face.map(|v| cluster[v as usize]);
            let mut key = face;
            key.sort_unstable();
            let corners = 1 + (0..3).filter(|&i| key[i] != key[i + 1]).count();
            if corners >= 3 && known.insert(key) {
                faces.push(simple(face));
                first_contact_face += usize::from(number < view.first_contact_face);
            }
        }
        if faces.len() <= most || cells < 2.0 {
            view.faces = faces;
            view.first_contact_face = first_contact_face;
            view.first_contact_point = kept.partition_point(|&v| (v as usize) < view.first_contact_point);
            view.points = kept.iter().map(|&v| view.points[v as usize]).collect();
            return Some(kept);
        }
        cells *= 0.8;
    }
}

/// The first vertex of each cube of the given size, and the number of each vertex's cube among them.
fn clusters(view: &View, size: f64) -> (Vec<u32>, Vec<u32>) {
    let mut number = HashMap::new();
    let (mut kept, mut cluster) = (Vec::new(), Vec::with_capacity(view.points.len()));
    for (v, x) in (0..).zip(&view.points) {
        let key = (x.map(|c| (c / size).floor() as i64), v as usize >= view.first_contact_point);
        cluster.push(*number.entry(key).or_insert_with(|| {
            kept.push(v);
            kept.len() as u32 - 1
        }));
    }
    (kept, cluster)
}

/// A quadrilateral of which two neighbouring corners have become one, as a triangle.
fn simple([a, b, c, d]: [u32; 4]) -> [u32; 4] {
    if a == b || a == d {
        [b, c, d, d]
    } else if b == c {
        [a, b, d, d]
    } else {
        [a, b, c, d]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square of n x n quadrilaterals, its right half a contact surface.
    fn square(n: u32) -> View {
        let mut view = View::default();
        for (low, high) in [(0, n / 2), (n / 2, n)] {
            let first = view.points.len() as u32;
            let width = high - low + 1;
            let points = (0..=n).flat_map(|j| (low..=high).map(move |i| [f64::from(i), f64::from(j), 0.0]));
            view.points.extend(points.map(|x| x.map(|c| c / f64::from(n))));
            let at = |i: u32, j: u32| first + i + width * j;
            if low > 0 {
                (view.first_contact_point, view.first_contact_face) = (first as usize, view.faces.len());
            }
            for (i, j) in (0..n).flat_map(|j| (0..width - 1).map(move |i| (i, j))) {
                view.faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        view
    }

    /// Area of the faces in the x-y plane.
    fn area(view: &View) -> f64 {
        let cross =
            |a: [f64; 3], b: [f64; 3], c: [f64; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let of = |f: &[u32; 4]| {
            let [a, b, c, d] = f.map(|v| view.points[v as usize]);
            (cross(a, b, c) + cross(a, c, d)) / 2.0
        };
        view.faces.iter().map(of).sum()
    }

    #[test]
    fn a_thinned_square_is_still_covered_once_and_keeps_its_halves() {
        let mut view = square(64);
        let full = view.clone();
        assert_eq!(thin(&mut view.clone(), 64 * 64), None);
        let kept = thin(&mut view, 400).unwrap();
        assert!(view.faces.len() <= 400 && view.faces.len() > 50, "{}", view.faces.len());
        assert!(kept.iter().zip(&view.points).all(|(&v, x)| full.points[v as usize] == *x));
        // What is left may fall short of the square by a cube along two sides.
        assert!(area(&view) <= 1.0 + 1e-12 && area(&view) > 0.6, "{}", area(&view));
        for (number, face) in view.faces.iter().enumerate() {
            let contact = number >= view.first_contact_face;
            assert!(face.iter().all(|&v| (v as usize >= view.first_contact_point) == contact));
        }
    }
}
