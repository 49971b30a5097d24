//! Contact points of nodes that follow others (cyclic symmetry).
//!
//! Where a node follows another, a point at each says the same twice, and the two share what the one place carries: half of
//! its area lies on either side of the cut. One point with both areas stands for them.

use std::collections::HashMap;

use super::friction_law::{At, law};
use super::points::Point;
use super::{ContactSurface, SurfaceFacts};
use crate::Error;
use crate::fem::Followed;
use crate::mesh::Mesh;

/// Weights that differ by less are the same.
const ROUNDING: f64 = 1e-6;

/// Merges the points of a surface whose nodes follow those of others among them, if both meet the same: where the meshes of two
/// surfaces do not match at the cuts, each point meets nodes on its own side and stays.
pub(super) fn merge(
    mesh: &Mesh,
    surface: &ContactSurface,
    follows: &HashMap<u32, Followed>,
    points: &mut Vec<Point>,
    facts: &mut SurfaceFacts,
) -> Result<(), Error> {
    if follows.is_empty() {
        return Ok(());
    }
    let place: HashMap<u32, usize> = points.iter().enumerate().map(|(j, point)| (point.node, j)).collect();
    let leader = |point: &Point| {
        // One that follows a third node itself may be merged: it cannot take another's area.
        let followed = follows.get(&point.node).filter(|followed| !follows.contains_key(&followed.node))?;
        let i = *place.get(&followed.node)?;
        says_the_same(point, &points[i], follows).then_some(i)
    };
    let leaders: Vec<Option<usize>> = points.iter().map(leader).collect();
    for (j, i) in leaders.iter().enumerate().filter_map(|(j, i)| Some((j, (*i)?))) {
        let area = points[i].area + points[j].area;
        let point = &mut points[i];
        let at = At { node: point.node, x: mesh.nodes[point.node as usize], area, normal: point.normal };
        (point.area, point.friction) = (area, law(&surface.friction, &at, &mut point.frame.clone())?.0);
    }
    let mut stays = leaders.iter().map(Option::is_none);
    points.retain(|_| stays.next().unwrap_or(true));
    facts.nodes = points.iter().map(|point| point.node).collect();
    facts.points = points.len();
    Ok(())
}

/// Whether what a point meets follows what the other meets.
fn says_the_same(point: &Point, leader: &Point, follows: &HashMap<u32, Followed>) -> bool {
    let met = |(other, weight): &(u32, f64)| {
        let led = follows.get(other).map_or(*other, |followed| followed.node);
        leader.others.iter().any(|(node, w)| *node == led && (w - weight).abs() <= ROUNDING)
    };
    point.others.len() == leader.others.len() && point.others.iter().all(met)
}
