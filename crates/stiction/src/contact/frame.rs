//! Local axes of contact points.

use super::obstacle::unit;
use crate::fem::DofMap;
use crate::mesh::v3::{cross, norm};

/// [`frame`] at a node: `free` are its components, along its own axes where it is turned. In those that `slides` names the other
/// body moves along the surface: there are tangents as if the node were free.
pub(super) fn frame_at(
    dofs: &DofMap,
    node: u32,
    normal: [f64; 3],
    free: [bool; 3],
    slides: [bool; 3],
) -> Option<[[f64; 3]; 3]> {
    let normal = dofs.components(node, normal);
    let [within, mut first, mut second] = frame(normal, free)?;
    if slides.contains(&true) {
        [_, first, second] = frame(normal, [0, 1, 2].map(|c| free[c] || slides[c]))?;
    }
    Some([within, first, second].map(|v| dofs.vector(node, v)))
}

/// [`tied_frame`] at a node.
pub(super) fn tied_frame_at(dofs: &DofMap, node: u32, free: [bool; 3]) -> Option<[[f64; 3]; 3]> {
    tied_frame(free).map(|axes| axes.map(|v| dofs.vector(node, v)))
}

/// Normal and tangents restricted to the free components, or `None` if no free component has a part of the normal.
fn frame(normal: [f64; 3], free: [bool; 3]) -> Option<[[f64; 3]; 3]> {
    let keep = |v: [f64; 3]| [0, 1, 2].map(|c| if free[c] { v[c] } else { 0.0 });
    let within = keep(normal);
    if norm(within) < 1e-8 {
        return None;
    }
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (first, second) = match free.iter().filter(|&&f| f).count() {
        3 => {
            // The first tangent follows the first axis that is clearly across the normal: x on a horizontal plane.
            let axis = (0..3).find(|&c| normal[c].abs() < 0.8).unwrap_or(0);
            let along = normal[axis];
            let first = unit([0, 1, 2].map(|c| axes[axis][c] - along * normal[c]))?;
            let second = cross(normal, first);
            let largest = (0..3).max_by(|&a, &b| second[a].abs().total_cmp(&second[b].abs())).unwrap_or(0);
            // Tangents point along the axes, not against them: results read as the user's coordinates do.
            (first, if second[largest] < 0.0 { second.map(|c| 0.0 - c) } else { second })
        }
        2 => {
            let fixed = axes[(0..3).find(|&c| !free[c]).unwrap_or(0)];
            let first = unit(cross(fixed, within))?;
            let largest = (0..3).max_by(|&a, &b| first[a].abs().total_cmp(&first[b].abs())).unwrap_or(0);
            (if first[largest] < 0.0 { first.map(|c| 0.0 - c) } else { first }, [0.0; 3])
        }
        _ => ([0.0; 3], [0.0; 3]),
    };
    Some([within, first, second])
}

/// A tied node that cannot move along the normal is still tied in its free directions.
fn tied_frame(free: [bool; 3]) -> Option<[[f64; 3]; 3]> {
    let axis = |c: usize| [0, 1, 2].map(|k| f64::from(u8::from(k == c)));
    let mut axes = (0..3).filter(|&c| free[c]).map(axis);
    Some([[0.0; 3], axes.next()?, axes.next().unwrap_or([0.0; 3])])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::v3::dot;

    #[test]
    fn frames_are_orthonormal_and_follow_the_axes_on_a_floor() {
        let down = [0.0, 0.0, -1.0];
        assert_eq!(frame(down, [true; 3]), Some([down, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
        let oblique = unit([0.3, -0.9, 0.5]).unwrap();
        let [n, t1, t2] = frame(oblique, [true; 3]).unwrap();
        for (a, b, want) in [(n, t1, 0.0), (n, t2, 0.0), (t1, t2, 0.0), (t1, t1, 1.0), (t2, t2, 1.0)] {
            assert!((dot(a, b) - want).abs() < 1e-15);
        }
    }

    #[test]
    fn a_tied_node_held_along_the_normal_keeps_its_free_directions() {
        assert_eq!(tied_frame([true, false, true]), Some([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]));
        assert_eq!(tied_frame([false, true, false]), Some([[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]]));
        assert_eq!(tied_frame([false; 3]), None);
    }

    #[test]
    fn on_a_symmetry_plane_friction_stays_in_the_plane() {
        let n = unit([0.0, 0.6, -0.8]).unwrap();
        let [within, t1, t2] = frame(n, [false, true, true]).unwrap();
        assert_eq!(within, n);
        assert_eq!(t2, [0.0; 3]);
        assert!(t1[0] == 0.0 && dot(t1, n).abs() < 1e-15 && (norm(t1) - 1.0).abs() < 1e-15);
        assert_eq!(frame(n, [true, false, false]), None);
    }
}
