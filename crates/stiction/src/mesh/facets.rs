//! Normals of a surface of triangles that stands for a smooth one between its sharp edges.

use super::v3::{V3, add, cross, dot, norm, scale, sub, unit};

/// No neighbour: an edge on the border of an open surface.
pub(crate) const BORDER: u32 = u32::MAX;

/// The unit normal of a triangle; zero if it has no area.
pub(crate) fn normal(points: &[V3], corners: [u32; 3]) -> V3 {
    let [a, b, c] = corners.map(|p| points[p as usize]);
    unit(cross(sub(b, a), sub(c, a))).unwrap_or([0.0; 3])
}

/// The normal of a triangle times its angle at corner `k`.
pub(crate) fn weighted_normal(points: &[V3], corners: [u32; 3], k: usize) -> V3 {
    let [a, b, c] = [0, 1, 2].map(|i| points[corners[(k + i) % 3] as usize]);
    let (ab, ac) = (sub(b, a), sub(c, a));
    let angle = norm(cross(ab, ac)).atan2(dot(ab, ac));
    scale(angle, normal(points, corners))
}

/// The normal of each corner as an index into the second list.
pub(crate) fn corner_normals(
    points: &[V3],
    triangles: &[[u32; 3]],
    across: &[[u32; 3]],
    sharp: &[[bool; 3]],
) -> (Vec<[u32; 3]>, Vec<V3>) {
    // Corners at one point that no sharp edge parts belong together (union by the lower number, paths halved).
    let mut root: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    let find = |root: &mut [u32], mut i: u32| {
        while root[i as usize] != i {
            root[i as usize] = root[root[i as usize] as usize];
            i = root[i as usize];
        }
        i
    };
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let other = across[t][k];
            if other == BORDER || sharp[t][k] {
                continue;
            }
            for own in [k, (k + 1) % 3] {
                let Some(at) = triangles[other as usize].iter().position(|&p| p == corners[own]) else { continue };
                let (a, b) = (find(&mut root, (3 * t + own) as u32), find(&mut root, 3 * other + at as u32));
                root[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut place: Vec<u32> = vec![u32::MAX; root.len()];
    let mut normals: Vec<V3> = Vec::new();
    let mut corner = Vec::with_capacity(triangles.len());
    for (t, corners) in triangles.iter().enumerate() {
        corner.push([0, 1, 2].map(|k| {
            let root = find(&mut root, (3 * t + k) as u32) as usize;
            if place[root] == u32::MAX {
                place[root] = normals.len() as u32;
                normals.push([0.0; 3]);
            }
            let sum = &mut normals[place[root] as usize];
            *sum = add(*sum, weighted_normal(points, *corners, k));
            place[root]
        }));
    }
    normals.iter_mut().for_each(|n| *n = unit(*n).unwrap_or(*n));
    (corner, normals)
}
