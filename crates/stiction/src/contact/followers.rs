//! Contact points of nodes that follow others (cyclic symmetry).
//!
//! Where a node follows another, a point at each says the same twice, and the two share what the one place carries: half of
//! its area lies on either side of the cut. One point with both areas stands for them.

use std::collections::{BTreeMap, HashMap};

use super::friction_law::{At, law};
use super::points::Point;
use super::{ContactSurface, SurfaceFacts};
use crate::Error;
use crate::fem::Followed;
use crate::mesh::Mesh;
use crate::mesh::v3::V3;

/// Merges the points of a surface whose nodes follow those of others among them: one has the mean jump of both, by their areas. Each
/// of them is measured from nodes on its own side of the sector, where the meshes of two bodies need not match at the cuts.
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
        Some((*place.get(&followed.node)?, followed.axes))
    };
    let leaders: Vec<Option<(usize, [V3; 3])>> = points.iter().map(leader).collect();
    for (j, (i, axes)) in leaders.iter().enumerate().filter_map(|(j, found)| Some((j, (*found)?))) {
        let [own, other] = [points[i].area, points[j].area];
        let (area, parts) = (own + other, [own, other].map(|part| part / (own + other)));
        let mean = |[own, other]: [f64; 2]| parts[0] * own + parts[1] * other;
        let mut others: BTreeMap<u32, f64> = points[i].others.iter().map(|&(node, w)| (node, parts[0] * w)).collect();
        let mut beyond_cut: Vec<(u32, f64, [V3; 3])> =
            points[i].beyond_cut.iter().map(|&(node, w, axes)| (node, parts[0] * w, axes)).collect();
        for &(node, weight) in &points[j].others {
            let weight = parts[1] * weight;
            match follows.get(&node).filter(|followed| !follows.contains_key(&followed.node)) {
                Some(followed) => *others.entry(followed.node).or_insert(0.0) += weight,
                None => beyond_cut.push((node, weight, axes)),
            }
        }
        let gap = mean([points[i].gap, points[j].gap]);
        let unity_sum = mean([points[i].unity_sum, points[j].unity_sum]);
        let point = &mut points[i];
        let at = At { node: point.node, x: mesh.nodes[point.node as usize], area, normal: point.normal };
        (point.area, point.friction) = (area, law(&surface.friction, &at, &mut point.frame.clone())?.0);
        (point.gap, point.unity_sum) = (gap, unity_sum);
        (point.others, point.beyond_cut) = (others.into_iter().collect(), beyond_cut);
    }
    let mut stays = leaders.iter().map(Option::is_none);
    points.retain(|_| stays.next().unwrap_or(true));
    facts.nodes = points.iter().map(|point| point.node).collect();
    facts.points = points.len();
    Ok(())
}
