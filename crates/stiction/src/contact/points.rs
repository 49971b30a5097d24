//! Contact points: on an obstacle, and what all have in common.

use rustc_hash::{FxHashMap, FxHashSet};

use super::claims::{Claim, Lost, is_near};
use super::false_overlap::without_false_overlap;
use super::frame::{frame_at, tied_frame_at};
use super::friction_law::{At, law};
use super::mortar::FACING;
use super::pair::TOUCHING;
use super::rounding::{is_led_into, resolved};
use super::tributary::{TributaryArea, areas_on_obstacle};
use super::{ContactSurface, Friction, InterfaceStiffness, Obstacle, Side, SurfaceFacts, SurfaceFriction, Triangles};
use crate::Error;
use crate::fem::{DofMap, nodal_normals};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};

/// Prescribed displacements below this part of others, and distances below this part of the size of a surface, are rounding.
const ROUNDING: f64 = 1e-12;

/// A contact point: its jump is `u_node + sum(weight u_other)` along its axes.
#[derive(PartialEq)]
pub(super) struct Point {
    pub node: u32,
    /// Before any displacement, the prescribed ones included.
    pub gap: f64,
    pub area: f64,
    pub friction: Friction,
    /// See `ContactProblem::orthotropy`.
    pub orthotropy: f64,
    /// Normal and tangents in the free components of the node, tangents also where the other body moves below a node that is held;
    /// a tangent may be zero.
    pub frame: [[f64; 3]; 3],
    /// The unit normal over all components.
    pub normal: [f64; 3],
    /// Other nodes with their weights; on an obstacle the ends of the edge in whose middle the node is, if it is in one.
    pub others: Vec<(u32, f64)>,
    /// Nodes beside the other cut of a cyclic symmetry, likewise, each with what its directions x, y, z are at the node.
    pub beyond_cut: Vec<(u32, f64, [V3; 3])>,
    /// See `ContactProblem::unity_sum`.
    pub unity_sum: f64,
    pub stiffness: Option<InterfaceStiffness>,
    /// The node in front of its own that stands for it, where the interface yields.
    pub layer: Option<u32>,
}

/// What nodes that could carry a multiplier meet of an obstacle.
pub(super) fn claims_on_obstacle(
    mesh: &Mesh,
    dofs: &DofMap,
    surface: &ContactSurface,
    obstacle: &Obstacle,
) -> FxHashMap<u32, Claim> {
    let facing = faces_that_look(mesh, &surface.faces, obstacle);
    let faces = facing.as_ref().unwrap_or(&surface.faces);
    let of = |(patch, (node, outward)): (TributaryArea, (u32, [f64; 3]))| {
        let (distance, away) = obstacle.distance_facing(mesh.nodes[node as usize], outward)?;
        let free = prescribed(dofs, node).map(|value| value.is_none());
        let tied = || tied_frame_at(dofs, node, free).filter(|_| surface.friction == SurfaceFriction::Bonded);
        frame_at(dofs, node, away.map(|c| 0.0 - c), free, [false; 3]).or_else(tied)?;
        let (area, distance) = (patch.area, distance.abs());
        let claim = Claim { distance, covered: area, whole: area, normal: outward, level: None };
        (facing.is_none() || dot(outward, away) < FACING).then_some((node, claim))
    };
    areas_on_obstacle(mesh, faces).into_iter().zip(nodal_normals(mesh, faces)).filter_map(of).collect()
}

/// The points of a surface that may touch an obstacle. `lost` are the nodes that belong to other contacts.
pub(super) fn points_on_obstacle(
    mesh: &Mesh,
    dofs: &DofMap,
    surface: &ContactSurface,
    obstacle: &Obstacle,
    (lost, tied_elsewhere): (&FxHashMap<u32, Lost>, &FxHashSet<u32>),
) -> Result<(Vec<Point>, SurfaceFacts), Error> {
    let mut points = Vec::new();
    if surface.faces.is_empty() {
        return Err(Error::new("", "the contact surface has no faces", "name a group of boundary faces in `on`"));
    }
    let mut facts = SurfaceFacts::named(&surface.name);
    let tied = surface.friction == SurfaceFriction::Bonded;
    let mut some_are_tied = false;
    let facing = faces_that_look(mesh, &surface.faces, obstacle);
    let faces = facing.as_ref().unwrap_or(&surface.faces);
    let outward = nodal_normals(mesh, faces);
    if facing.is_some() {
        facts.looking_away = mesh.face_nodes(&surface.faces).len() - outward.len();
        facts.area = area_of(mesh, &surface.faces) - area_of(mesh, faces);
    }
    let negligible = ROUNDING * dofs.value.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
    let distance_of = |node: u32| -> Result<Option<(f64, [f64; 3])>, Error> {
        let x = mesh.nodes[node as usize];
        let place = outward.partition_point(|(other, _)| *other < node);
        let found = outward.get(place).and_then(|(_, outward)| obstacle.distance_facing(x, *outward));
        if found.is_none() && !matches!(obstacle, Obstacle::Surface(_)) {
            let what = format!("the obstacle has no normal at node {} at {x:?}", node + 1);
            return Err(Error::new("", what, "move the obstacle: no node may lie on its axis or centre"));
        }
        Ok(found.map(|(distance, away)| (resolved(distance, [x]), away)))
    };
    'areas: for (patch, &(_, outward)) in areas_on_obstacle(mesh, faces).into_iter().zip(&outward) {
        let (unity_sum, TributaryArea { node, area, others }) = (patch.unity_sum(), patch);
        let x = mesh.nodes[node as usize];
        if area <= 0.0 {
            let what = format!(
                "node {} at {x:?} stands for no area: the quadratic faces around it are too distorted",
                node + 1
            );
            let remedy = "move the nodes in the middles of their edges to the middles, or mesh the surface more evenly";
            return Err(Error::new("", what, remedy));
        }
        facts.area += unity_sum * area;
        let Some((distance, away)) = distance_of(node)? else {
            facts.beyond += 1;
            continue;
        };
        if facing.is_some() && dot(outward, away) >= FACING {
            facts.looking_away += 1;
            facts.dropped_area += unity_sum * area;
            continue;
        }
        let near = is_near(distance, area);
        if let Some(lost) = lost.get(&node) {
            *(if *lost == Lost::Behind { &mut facts.behind } else { &mut facts.taken }) += 1;
            facts.near[1] += usize::from(*lost == Lost::Beside && near);
            continue;
        }
        facts.near[0] += usize::from(near);
        let (mut measured, mut least) = (distance, distance);
        for &(other, weight) in &others {
            let Some((distance, _)) = distance_of(other)? else {
                facts.beyond += 1;
                continue 'areas;
            };
            measured += weight * distance;
            least = least.min(distance);
        }
        let normal = away.map(|c| 0.0 - c); // towards the obstacle; 0 - c keeps zeros positive
        let constrained = prescribed(dofs, node);
        let free = constrained.map(|p| p.is_none());
        if tied {
            refuse_moving_tied(&constrained, negligible, node, x)?;
        }
        let frame = frame_at(dofs, node, normal, free, [false; 3]);
        let frame = frame.or_else(|| if tied { tied_frame_at(dofs, node, free) } else { None });
        let is_tied = tied_elsewhere.contains(&node);
        some_are_tied |= is_tied;
        let frame = frame.filter(|_| !is_tied);
        let along = dofs.components(node, normal);
        let imposed: f64 = (0..3).map(|c| along[c] * constrained[c].unwrap_or(0.0)).sum();
        let gap = distance - imposed;
        let Some(mut frame) = frame else {
            let clamped = constrained.iter().all(Option::is_some);
            *(if clamped { &mut facts.clamped } else { &mut facts.held_along_normal }) += 1;
            facts.dropped_area += unity_sum * area;
            let size = norm(constrained.map(|p| p.unwrap_or(0.0)));
            if is_led_into(distance, imposed, size) {
                refuse_imposed_overlap(gap, node, x, surface)?;
            }
            continue;
        };
        refuse_dragging(&constrained, imposed, along, node, x, &surface.friction, &[])?;
        facts.guided += usize::from(frame[2] == [0.0; 3]);
        facts.facing_away += usize::from(dot(outward, normal) <= 0.0);
        let is_behind = |triangles: &Triangles| triangles.turns_its_back(x, outward, distance);
        facts.behind_backs += usize::from(matches!(obstacle, Obstacle::Surface(triangles) if is_behind(triangles)));
        facts.gap_min = facts.gap_min.min(distance);
        facts.gap_max = facts.gap_max.max(distance);
        if distance < -TOUCHING * area.sqrt() {
            facts.overlapping += 1;
            facts.overlapping_area += unity_sum * area;
        }
        facts.points += 1;
        facts.nodes.push(node);
        let (friction, orthotropy) = law(&surface.friction, &At { node, x, area, normal }, &mut frame)?;
        // A tie keeps the distance it was meshed with.
        let gap = if friction == Friction::Bonded { 0.0 } else { without_false_overlap(measured, least * unity_sum) };
        let (stiffness, layer) = (surface.stiffness, None);
        points.push(Point {
            node,
            gap,
            area,
            friction,
            orthotropy,
            frame,
            normal,
            others,
            beyond_cut: Vec::new(),
            unity_sum,
            stiffness,
            layer,
        });
    }
    if let Obstacle::Surface(triangles) = obstacle {
        refuse_body_outside_of_its_room(mesh, faces, triangles, facts.gap_min)?;
    }
    if facts.points == 0 && (some_are_tied || facts.behind + facts.taken > 0) {
        (facts.gap_min, facts.gap_max) = (0.0, 0.0);
        return Ok((points, facts));
    }
    if facts.points == 0 && facts.beyond > 0 {
        let what = format!(
            "{} nodes of the contact surface lie beyond the border of the obstacle, and none faces it",
            facts.beyond
        );
        return Err(Error::new("", what, "check `scale`, `turn` and `move` of the obstacle, or enlarge it"));
    }
    if facts.points == 0 && facts.looking_away > 0 {
        let what = "no node of the contact surface looks at the obstacle";
        return Err(Error::new("", what, "check the place of the obstacle and its `side`, or mesh the surface finer"));
    }
    if facts.points == 0 {
        let what =
            format!("all {} nodes of the contact surface are prescribed", facts.clamped + facts.held_along_normal);
        return Err(Error::new("", what, "leave nodes of the contact surface free to move towards the obstacle"));
    }
    Ok((points, facts))
}

/// Refuses a closed surface around the body where the body is not in it: its triangles are turned inwards, or `side` is wrong. What is
/// behind the contact faces would lie deeper in the obstacle than they do, `-gap_min` where they overlap.
fn refuse_body_outside_of_its_room(mesh: &Mesh, faces: &[u32], surface: &Triangles, gap_min: f64) -> Result<(), Error> {
    if !surface.is_room() {
        return Ok(());
    }
    let deepest = gap_min.min(0.0) - ROUNDING * surface.size;
    let is_outside = |face: &&u32| {
        let (_, nodes) = mesh.cell(mesh.faces[**face as usize].cell as usize);
        let sum = nodes.iter().fold([0.0; 3], |sum, &node| add(sum, mesh.nodes[node as usize]));
        surface.distance(scale(1.0 / nodes.len() as f64, sum), None).is_some_and(|(distance, _)| distance < deepest)
    };
    let outside = faces.iter().filter(is_outside).count();
    if 2 * outside <= faces.len() {
        return Ok(());
    }
    let what = format!("the body does not lie in the closed surface {}, whose normals look into it", surface.name);
    let remedy = match surface.side {
        Side::Outside => "turn the triangles the other way around, or set `side = \"inside\"`",
        Side::Inside => "take `side` out, or turn the triangles the other way around",
    };
    Err(Error::new("", what, remedy))
}

/// Those of the faces that look at the obstacle; `None` where all do, or none does. A side face that shares an edge with them would
/// add to what the nodes there stand for.
pub(super) fn faces_that_look(mesh: &Mesh, faces: &[u32], obstacle: &Obstacle) -> Option<Vec<u32>> {
    let looks = |face: &u32| {
        let corners = mesh.faces[*face as usize].corners();
        let sum = corners.iter().fold([0.0; 3], |sum, &corner| add(sum, mesh.nodes[corner as usize]));
        let normal = mesh.face_normal(*face as usize);
        let found = obstacle.distance_facing(scale(1.0 / corners.len() as f64, sum), normal);
        found.is_none_or(|(_, away)| dot(normal, away) < FACING)
    };
    let looking: Vec<u32> = faces.iter().copied().filter(looks).collect();
    (!looking.is_empty() && looking.len() < faces.len()).then_some(looking)
}

fn area_of(mesh: &Mesh, faces: &[u32]) -> f64 {
    faces.iter().map(|&face| mesh.face_area(face as usize)).sum()
}

/// The prescribed components of a node, along its own axes where it is turned.
pub(super) fn prescribed(dofs: &DofMap, node: u32) -> [Option<f64>; 3] {
    let value = |c: u32| dofs.prescribed.binary_search(&(3 * node + c)).ok().map(|i| dofs.value[i]);
    [0, 1, 2].map(value)
}

fn refuse_imposed_overlap(gap: f64, node: u32, x: [f64; 3], surface: &ContactSurface) -> Result<(), Error> {
    if surface.friction == SurfaceFriction::Bonded {
        return Ok(());
    }
    let what = format!("the prescribed displacement pushes node {} at {x:?} {:.3e} into the obstacle", node + 1, -gap);
    Err(Error::new("", what, surface.remedy_of_overlap()))
}

/// A tie holds its node where it was meshed, as a prescribed zero would; a prescribed displacement contradicts it.
fn refuse_moving_tied(prescribed: &[Option<f64>; 3], negligible: f64, node: u32, x: [f64; 3]) -> Result<(), Error> {
    if prescribed.iter().flatten().all(|value| value.abs() <= negligible) {
        return Ok(());
    }
    let value = prescribed.map(|value| value.map_or("free".to_string(), |v| v.to_string())).join(", ");
    let what = format!("node {} at {x:?} is bonded to an obstacle at rest, and prescribed to move: {value}", node + 1);
    Err(Error::new(
        "",
        what,
        "take the node out of the bonded surface or out of what is prescribed, or prescribe zero there",
    ))
}

/// Refuses what is prescribed along the surface, but along the tangents that have rows: components of unit vectors or of zeros.
#[allow(clippy::too_many_arguments)]
pub(super) fn refuse_dragging(
    prescribed: &[Option<f64>; 3],
    imposed: f64,
    normal: [f64; 3],
    node: u32,
    x: [f64; 3],
    friction: &SurfaceFriction,
    with_rows: &[[f64; 3]],
) -> Result<(), Error> {
    let mut along = [0, 1, 2].map(|c| prescribed[c].unwrap_or(0.0) - imposed * normal[c]);
    for tangent in with_rows {
        along = sub(along, scale(dot(along, *tangent), *tangent));
    }
    let size = norm([0, 1, 2].map(|c| prescribed[c].unwrap_or(0.0)));
    if *friction == SurfaceFriction::None || norm(along) <= ROUNDING * size || size == 0.0 {
        return Ok(());
    }
    let what =
        format!("node {} at {x:?} of the contact surface is dragged along it by a prescribed displacement", node + 1);
    Err(Error::new("", what, "prescribe all its components, or none; or make the contact frictionless"))
}
