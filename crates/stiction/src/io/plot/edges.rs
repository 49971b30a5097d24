//! Edges of a surface and which of them outline it.

use super::camera::{Vec3, area_vector, dot, unit};

/// An edge of a surface.
pub(super) struct Edge {
    pub nodes: [u32; 2],
    /// Unit normals of its faces; a border has one, and where more than two faces meet two of them are kept.
    normals: [Option<Vec3>; 2],
}

/// All edges, each once.
pub(super) fn edges(points: &[Vec3], faces: &[&[u32]]) -> Vec<Edge> {
    let [edges] = edges_of([points], faces);
    edges
}

/// The same of several positions of the points.
pub(super) fn edges_of<const P: usize>(positions: [&[Vec3]; P], faces: &[&[u32]]) -> [Vec<Edge>; P] {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(4 * faces.len());
    for (i, face) in faces.iter().enumerate() {
        for (k, &a) in face.iter().enumerate() {
            let b = face[(k + 1) % face.len()];
            sides.push((a.min(b), a.max(b), i as u32));
        }
    }
    sides.sort_unstable();
    let same_edge = |a: &(u32, u32, u32), b: &(u32, u32, u32)| (a.0, a.1) == (b.0, b.1);
    positions.map(|points| {
        let normals: Vec<Vec3> = faces.iter().map(|f| unit(area_vector(points, f))).collect();
        let edge = |side: &[(u32, u32, u32)]| Edge {
            nodes: [side[0].0, side[0].1],
            normals: [Some(normals[side[0].2 as usize]), side.get(1).map(|s| normals[s.2 as usize])],
        };
        sides.chunk_by(same_edge).map(edge).collect()
    })
}

impl Edge {
    /// Whether the edge is a border or a crease, or separates what faces the observer from what does not.
    pub(super) fn outlines(&self, toward: Vec3) -> bool {
        /// Cosine of 35 degrees, between the corners of a cube and those of a faceted cylinder.
        const CREASE: f64 = 0.82;
        match self.normals {
            [Some(a), Some(b)] => dot(a, b) < CREASE || dot(a, toward) * dot(b, toward) < 0.0,
            _ => true,
        }
    }

    /// Whether the edge belongs to one face only.
    pub(super) fn is_border(&self) -> bool {
        self.normals[1].is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_of_triangles_is_outlined_by_its_twelve_edges() {
        let points: Vec<Vec3> = (0..8).map(|i| [i & 1, (i >> 1) & 1, i >> 2].map(f64::from)).collect();
        let quads = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let triangles: Vec<&[u32]> = halves.iter().map(|t| &t[..]).collect();
        let edges = edges(&points, &triangles);
        assert_eq!(edges.len(), 18);
        assert_eq!(edges.iter().filter(|e| e.outlines([0.3, 0.2, 1.0])).count(), 12);
        assert!(!edges.iter().any(Edge::is_border));
    }
}
