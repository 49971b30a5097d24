//! Borders of a surface of triangles that lie on one another but for the last digits of their coordinates.

use rustc_hash::FxHashMap;

use crate::mesh::Bounds;
use crate::mesh::v3::{V3, norm, sub};

/// Points of borders that are so near, over the size of the surface, are one. Coordinates in single precision and text of seven
/// digits differ by less; a corner that is meant is larger.
const NEAR: f64 = 1e-6;

/// For each point the one that it is joined to, itself if there is none: the first of the points at `border` that is near. `None` where
/// none is joined.
pub(super) fn joined(points: &[V3], triangles: &[[u32; 3]], border: &[u32]) -> Option<Vec<u32>> {
    let bounds = Bounds::around(triangles.iter().flatten().map(|&p| points[p as usize]));
    let near = NEAR * bounds.diagonal();
    if !near.is_finite() || near <= 0.0 {
        return None;
    }
    // Cells of twice that length: what is near is in the cell of a point or in one beside it.
    let cell = |x: V3| -> [i64; 3] { std::array::from_fn(|c| ((x[c] - bounds.low[c]) / (2.0 * near)).floor() as i64) };
    let mut firsts: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
    let mut to: Vec<u32> = (0..points.len() as u32).collect();
    let mut any = false;
    for &p in border {
        let x = points[p as usize];
        let at = cell(x);
        let around = (0..27).map(|k| [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1]);
        let is_near = |other: &&u32| norm(sub(points[**other as usize], x)) <= near;
        let first = around.filter_map(|cell| firsts.get(&cell)?.iter().find(is_near).copied()).min();
        match first {
            Some(first) => (to[p as usize], any) = (first, true),
            None => firsts.entry(at).or_default().push(p),
        }
    }
    any.then_some(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_border_within_a_millionth_of_the_size_are_joined_to_the_first() {
        let points = [[0.0; 3], [100.0, 0.0, 0.0], [100.0, 5e-5, 0.0], [-3e-5, 0.0, 4e-5], [99.0, 0.0, 0.0]];
        let (triangles, all) = ([[0, 1, 4], [2, 3, 4]], [0, 1, 2, 3, 4]);
        assert_eq!(joined(&points, &triangles, &all), Some(vec![0, 1, 1, 0, 4]));
        // Points inside are left.
        assert_eq!(joined(&points, &triangles, &[0, 1, 4]), None);
        let larger = points.map(|x| x.map(|c| 3.0 * c));
        assert_eq!(joined(&larger, &triangles, &all), Some(vec![0, 1, 1, 0, 4]));
        // A point of no triangle says nothing of the size.
        let with_stray: Vec<V3> = points.into_iter().chain([[1e9, 0.0, 0.0], [f64::INFINITY; 3]]).collect();
        assert_eq!(joined(&with_stray, &triangles, &all), Some(vec![0, 1, 1, 0, 4, 5, 6]));
        assert_eq!(joined(&[], &[], &[]), None);
    }
}
