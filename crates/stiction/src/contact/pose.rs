use std::collections::HashMap;

use super::obstacle::unit;
use super::{Bodies, Body, ContactProblem, Friction, Obstacle, Pair, Supports};
use crate::Error;
use crate::fem::{FeModel, nodal_areas, nodal_normals};
use crate::linalg::Csr;
use crate::mesh::v3::{cross, dot, norm, sub};
use crate::mesh::{self, Mesh};

/// Prescribed displacements below this part of others are rounding.
const ROUNDING: f64 = 1e-12;

/// Friction of a whole surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfaceFriction {
    None,
    Bonded,
    /// Coefficient of Coulomb friction.
    Coulomb(f64),
    /// Given friction as a shear stress; the bound of a point is the stress times its area.
    GivenStress(f64),
    /// Given friction as a force at each point, as in the source paper.
    GivenForce(f64),
}

/// A candidate contact surface of the body and what it may touch.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSurface {
    pub name: String,
    /// Indices into `Mesh::faces`.
    pub faces: Vec<u32>,
    pub obstacle: Obstacle,
    pub friction: SurfaceFriction,
}

/// What was found while posing one surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceFacts {
    pub name: String,
    /// Contact points kept.
    pub points: usize,
    /// Area of the faces.
    pub area: f64,
    pub gap_min: f64,
    pub gap_max: f64,
    /// Points that start inside the obstacle, and the area they stand for.
    pub overlapping: usize,
    pub overlapping_area: f64,
    /// Nodes of the surface whose three components are prescribed: their multipliers are dropped.
    pub clamped: usize,
    /// Nodes that cannot move along the normal, those a bonded surface ties included: dropped as well.
    pub held_along_normal: usize,
    /// Points with one or no free tangential direction, as on a symmetry plane.
    pub guided: usize,
    /// Points whose outward normal does not face the obstacle.
    pub facing_away: usize,
    /// Area of dropped nodes, which carries no contact force.
    pub dropped_area: f64,
}

/// Poses contact of the surfaces on `model`, which was assembled on `mesh`. The stiffness matrix moves from the model
/// into the problem: it is the largest thing there is, and nobody needs it twice.
///
/// Normals and gaps are those of the reference configuration (small sliding). The rows of a point whose node has
/// prescribed components are restricted to the free ones: tangents are chosen among the free directions across the
/// normal, so that on a symmetry plane friction acts within the plane.
///
/// # Errors
/// A surface without faces or without a single free node, an obstacle without a normal at a node, a prescribed
/// displacement that pushes a node into the obstacle, drags it along the surface or moves a bonded one.
pub fn pose(
    mesh: &Mesh,
    model: &mut FeModel,
    surfaces: &[ContactSurface],
) -> Result<(ContactProblem, Vec<SurfaceFacts>), Error> {
    let mut points = Vec::new();
    let mut facts = Vec::new();
    let mut pairs = Vec::new();
    let tied = tied_nodes(mesh, surfaces);
    for (number, surface) in surfaces.iter().enumerate() {
        let first = points.len();
        let tied = |node: u32| tied.get(&node).is_some_and(|&by| by != number);
        facts.push(points_of(mesh, model, surface, tied, &mut points).map_err(|e| e.at(&quoted(&surface.name)))?);
        pairs.push(Pair { name: surface.name.clone(), points: first..points.len() });
    }
    let (free, held) = jump(model, &points);
    let center = centroid(mesh);
    let rigid = |dofs: &[u32]| dofs.iter().map(|&d| rigid_row(mesh, center, d)).collect::<Vec<_>>();
    let mut free_load = model.support_stiffness.transpose_times(&model.dofs.value);
    free_load.iter_mut().zip(&model.load).for_each(|(x, f)| *x += f);
    let problem = ContactProblem {
        K: std::mem::take(&mut model.stiffness),
        f: model.load.clone(),
        B: free,
        gap: points.iter().map(|p| p.gap).collect(),
        slip_reference: vec![0.0; 2 * points.len()],
        friction: points.iter().map(|p| p.friction).collect(),
        area: points.iter().map(|p| p.area).collect(),
        pairs,
        node_of: Some(model.dofs.free.iter().map(|d| d / 3).collect()),
        near_kernel: Some(rigid(&model.dofs.free)),
        supports: Some(Supports {
            K: model.support_stiffness.clone(),
            K_own: model.support_support.clone(),
            load: model.support_load.clone(),
            free_load,
            displacement: model.dofs.value.clone(),
            B: held,
            rigid: rigid(&model.dofs.prescribed),
        }),
        bodies: Some(bodies(mesh, model, center)),
    };
    Ok((problem, facts))
}

/// The nodes of bonded surfaces, each with the first such surface: the tie holds them in every free direction, so that
/// multipliers of other surfaces there could not be told from its own.
fn tied_nodes(mesh: &Mesh, surfaces: &[ContactSurface]) -> HashMap<u32, usize> {
    let mut tied = HashMap::new();
    for (number, surface) in surfaces.iter().enumerate().filter(|(_, s)| s.friction == SurfaceFriction::Bonded) {
        mesh.face_nodes(&surface.faces).into_iter().for_each(|node| {
            tied.entry(node).or_insert(number);
        });
    }
    tied
}

/// A contact point with its three rows over the components of its node.
struct Point {
    node: u32,
    gap: f64,
    area: f64,
    friction: Friction,
    /// Normal and tangents in the free components; a tangent may be zero.
    frame: [[f64; 3]; 3],
    /// The unit normal over all components.
    normal: [f64; 3],
}

fn quoted(name: &str) -> String {
    format!("contact \"{name}\"")
}

fn points_of(
    mesh: &Mesh,
    model: &FeModel,
    surface: &ContactSurface,
    tied_elsewhere: impl Fn(u32) -> bool,
    points: &mut Vec<Point>,
) -> Result<SurfaceFacts, Error> {
    if surface.faces.is_empty() {
        return Err(Error::new("", "the contact surface has no faces", "name a group of boundary faces in `on`"));
    }
    let mut facts = SurfaceFacts {
        name: surface.name.clone(),
        gap_min: f64::INFINITY,
        gap_max: f64::NEG_INFINITY,
        ..Default::default()
    };
    let outward = nodal_normals(mesh, &surface.faces);
    let negligible = ROUNDING * model.dofs.value.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
    for ((node, area), (_, outward)) in nodal_areas(mesh, &surface.faces).into_iter().zip(outward) {
        let x = mesh.nodes[node as usize];
        let (distance, away) = surface.obstacle.distance(x).ok_or_else(|| {
            let what = format!("the obstacle has no normal at node {} at {x:?}", node + 1);
            Error::new("", what, "move the obstacle: no node may lie on its axis or centre")
        })?;
        facts.area += area;
        let normal = away.map(|c| 0.0 - c); // towards the obstacle; 0 - c keeps zeros positive
        let prescribed = [0, 1, 2].map(|c| prescribed_value(model, 3 * node + c));
        let free = prescribed.map(|p| p.is_none());
        let tied = surface.friction == SurfaceFriction::Bonded;
        if tied {
            refuse_moving_tied(&prescribed, negligible, node, x)?;
        }
        let frame = frame(normal, free).or_else(|| if tied { tied_frame(free) } else { None });
        let frame = frame.filter(|_| !tied_elsewhere(node));
        let imposed: f64 = (0..3).map(|c| normal[c] * prescribed[c].unwrap_or(0.0)).sum();
        let gap = distance - imposed;
        let Some(frame) = frame else {
            let clamped = prescribed.iter().all(Option::is_some);
            *(if clamped { &mut facts.clamped } else { &mut facts.held_along_normal }) += 1;
            facts.dropped_area += area;
            refuse_imposed_overlap(gap, distance, node, x, surface)?;
            continue;
        };
        refuse_dragging(&prescribed, imposed, normal, node, x, surface.friction)?;
        facts.guided += usize::from(frame[2] == [0.0; 3]);
        facts.facing_away += usize::from(dot(outward, normal) <= 0.0);
        facts.gap_min = facts.gap_min.min(distance);
        facts.gap_max = facts.gap_max.max(distance);
        if distance < 0.0 {
            facts.overlapping += 1;
            facts.overlapping_area += area;
        }
        facts.points += 1;
        let friction = law(surface.friction, area);
        // A tie keeps the distance it was meshed with.
        let gap = if friction == Friction::Bonded { -imposed } else { gap };
        points.push(Point { node, gap, area, friction, frame, normal });
    }
    if facts.points == 0 {
        let what =
            format!("all {} nodes of the contact surface are prescribed", facts.clamped + facts.held_along_normal);
        return Err(Error::new("", what, "leave nodes of the contact surface free to move towards the obstacle"));
    }
    Ok(facts)
}

fn law(friction: SurfaceFriction, area: f64) -> Friction {
    match friction {
        SurfaceFriction::None => Friction::None,
        SurfaceFriction::Bonded => Friction::Bonded,
        SurfaceFriction::Coulomb(coefficient) => Friction::Coulomb { coefficient },
        SurfaceFriction::GivenStress(stress) => Friction::Given { slip_bound: stress * area },
        SurfaceFriction::GivenForce(slip_bound) => Friction::Given { slip_bound },
    }
}

fn prescribed_value(model: &FeModel, dof: u32) -> Option<f64> {
    model.dofs.prescribed.binary_search(&dof).ok().map(|i| model.dofs.value[i])
}

/// Normal and tangents restricted to the free components, or `None` if no free component has a share of the normal.
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

fn refuse_imposed_overlap(
    gap: f64,
    distance: f64,
    node: u32,
    x: [f64; 3],
    surface: &ContactSurface,
) -> Result<(), Error> {
    // A node meshed slightly inside and held there is an overlap of the mesh, not one that was imposed.
    if surface.friction == SurfaceFriction::Bonded || gap >= 0.0 || gap >= distance {
        return Ok(());
    }
    let what = format!("the prescribed displacement pushes node {} at {x:?} {:.3e} into the obstacle", node + 1, -gap);
    Err(Error::new("", what, "reduce the prescribed displacement, or take the node out of the contact surface"))
}

/// A tie holds its node where it was meshed, as a prescribed zero would; a prescribed displacement contradicts it.
fn refuse_moving_tied(prescribed: &[Option<f64>; 3], negligible: f64, node: u32, x: [f64; 3]) -> Result<(), Error> {
    if prescribed.iter().flatten().all(|value| value.abs() <= negligible) {
        return Ok(());
    }
    let value = prescribed.map(|value| value.map_or("free".to_string(), |v| v.to_string())).join(", ");
    let what = format!("node {} at {x:?} is bonded to an obstacle at rest, and prescribed to move: {value}", node + 1);
    Err(Error::new("", what, "take the node out of the bonded surface or out of the [[fix]], or prescribe zero there"))
}

fn refuse_dragging(
    prescribed: &[Option<f64>; 3],
    imposed: f64,
    normal: [f64; 3],
    node: u32,
    x: [f64; 3],
    friction: SurfaceFriction,
) -> Result<(), Error> {
    let along = [0, 1, 2].map(|c| prescribed[c].unwrap_or(0.0) - imposed * normal[c]);
    let size = norm([0, 1, 2].map(|c| prescribed[c].unwrap_or(0.0)));
    if friction == SurfaceFriction::None || norm(along) <= ROUNDING * size || size == 0.0 {
        return Ok(());
    }
    let what =
        format!("node {} at {x:?} of the contact surface is dragged along it by a prescribed displacement", node + 1);
    Err(Error::new("", what, "prescribe all its components, or none; or make the contact frictionless"))
}

/// `B` over the unknown and over the prescribed degrees of freedom.
fn jump(model: &FeModel, points: &[Point]) -> (Csr, Csr) {
    let m = points.len();
    let (mut free, mut held) = (Vec::new(), Vec::new());
    for (j, point) in points.iter().enumerate() {
        for c in 0..3u32 {
            let dof = 3 * point.node + c;
            let unknown = model.dofs.unknown[dof as usize];
            if unknown != u32::MAX {
                for (k, row) in point.frame.iter().enumerate() {
                    if row[c as usize] != 0.0 {
                        free.push((k * m + j, unknown as usize, row[c as usize]));
                    }
                }
            } else if let Ok(p) = model.dofs.prescribed.binary_search(&dof)
                && point.normal[c as usize] != 0.0
            {
                held.push((j, p, point.normal[c as usize]));
            }
        }
    }
    let n = model.dofs.free.len();
    (Csr::from_triplets(3 * m, n, &free), Csr::from_triplets(3 * m, model.dofs.prescribed.len(), &held))
}

/// The bodies by the names of the groups of cells they are, otherwise by their numbers.
fn bodies(mesh: &Mesh, model: &FeModel, origin: [f64; 3]) -> Bodies {
    let of_node = mesh::bodies(mesh);
    let count = of_node.iter().max().map_or(0, |&last| last as usize + 1);
    let of_cell: Vec<u32> = mesh.cell_iter().map(|(_, nodes)| of_node[nodes[0] as usize]).collect();
    let (mut cells, mut nodes) = (vec![0; count], vec![Vec::new(); count]);
    of_cell.iter().for_each(|&body| cells[body as usize] += 1);
    of_node.iter().zip(&mesh.nodes).for_each(|(&body, &x)| nodes[body as usize].push(x));
    let group_of = |body: usize| {
        let is = |group: &&mesh::Group| {
            group.cells.len() == cells[body] && group.cells.iter().all(|&c| of_cell[c as usize] as usize == body)
        };
        mesh.groups.iter().find(is).map(|group| group.name.clone())
    };
    let list = (0..count).map(|body| {
        let size = nodes[body].len().max(1) as f64;
        let centre = [0, 1, 2].map(|c| nodes[body].iter().map(|x| x[c]).sum::<f64>() / size);
        let radius = nodes[body].iter().map(|&x| norm(sub(x, centre))).fold(0.0, f64::max);
        Body { name: group_of(body).unwrap_or_else(|| (body + 1).to_string()), centre, radius }
    });
    let of = |dofs: &[u32]| dofs.iter().map(|&dof| of_node[dof as usize / 3]).collect();
    Bodies { list: list.collect(), of: of(&model.dofs.free), of_support: of(&model.dofs.prescribed), origin }
}

fn centroid(mesh: &Mesh) -> [f64; 3] {
    let count = mesh.nodes.len().max(1) as f64;
    [0, 1, 2].map(|c| mesh.nodes.iter().map(|x| x[c]).sum::<f64>() / count)
}

/// The displacement of degree of freedom `dof` under unit translations along and rotations about the three axes.
fn rigid_row(mesh: &Mesh, center: [f64; 3], dof: u32) -> [f64; 6] {
    let c = (dof % 3) as usize;
    let x = mesh.nodes[(dof / 3) as usize];
    let [dx, dy, dz] = [x[0] - center[0], x[1] - center[1], x[2] - center[2]];
    let mut row = [0.0; 6];
    row[c] = 1.0;
    let rotations = [[0.0, -dz, dy], [dz, 0.0, -dx], [-dy, dx, 0.0]]; // e_k x r, by axis k
    (0..3).for_each(|k| row[3 + k] = rotations[k][c]);
    row
}

#[cfg(test)]
mod tests {
    use super::*;

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
