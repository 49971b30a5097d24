//! Contact of single nodes with a surface: for sets of nodes that make up no face.
//!
//! A node meets the master face nearest to it; its jump is its displacement less that of the point of the face below it,
//! along the normal of the face. Nothing is carried between nodes, so that a uniform pressure is not reproduced by many
//! of them: where nodes make up faces, the faces meet (`pair.rs`).

use rustc_hash::{FxHashMap, FxHashSet};

use super::claims::{Claim, Lost, is_near};
use super::frame::{frame_at, tied_frame_at};
use super::friction_law::{At, law};
use super::held::{Below, is_held_along};
use super::mortar::{FACING, Plane, Row};
use super::pair::{default_search, initial_gap, resolved_gap};
use super::points::{Point, prescribed, refuse_dragging};
use super::slave_choice::face_size;
use super::tributary::tributary_areas;
use super::{ContactSurface, Master, PairFacts, SurfaceFacts, SurfaceFriction};
use crate::Error;
use crate::fem::{DofMap, face_coordinates};
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};
use crate::mesh::{Bounds, Mesh, Tree, nearest_on_triangle};

/// What lies beside the master, seen along its normal, meets nothing: the cosine between the way to the nearest point and
/// the normal is below this.
const BESIDE: f64 = 0.25;
/// Distances below this part of a face's size are rounding: the way there has no direction.
const TOUCHING: f64 = 1e-6;
/// Weights below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Boundary faces at some of the nodes `nodes` (ascending) that look at a face of the master: what the nodes stand for.
pub(crate) fn faces_around(mesh: &Mesh, nodes: &[u32], master: &[u32]) -> Vec<u32> {
    let own: FxHashSet<u32> = master.iter().copied().collect();
    let towards = master.iter().map(|&face| mesh.face_normal(face as usize)).fold([0.0; 3], add);
    let looks = |face: &u32| {
        let has_node = mesh.faces[*face as usize].nodes().iter().any(|node| nodes.binary_search(node).is_ok());
        has_node && !own.contains(face) && dot(mesh.face_normal(*face as usize), towards) < FACING * norm(towards)
    };
    (0..mesh.faces.len() as u32).filter(looks).collect()
}

/// The master, ready to be searched.
struct Search<'a> {
    mesh: &'a Mesh,
    faces: &'a [u32],
    tree: Tree,
    reach: f64,
}

/// Single nodes before the master.
struct Nodes<'a> {
    search: Search<'a>,
    /// Normals of the faces around each.
    outward: FxHashMap<u32, Vec<V3>>,
    /// The area that each stands for.
    area: FxHashMap<u32, f64>,
}

impl<'a> Nodes<'a> {
    fn new(mesh: &'a Mesh, surface: &ContactSurface, master: &'a Master) -> Nodes<'a> {
        let search = Search {
            mesh,
            faces: &master.faces,
            tree: Tree::new(master.faces.iter().map(|&face| Bounds::around(face_coordinates(mesh, face))).collect()),
            reach: master.search.unwrap_or_else(|| reach(mesh, surface, master)),
        };
        let mut outward: FxHashMap<u32, Vec<V3>> = FxHashMap::default();
        for &face in &surface.faces {
            let normal = mesh.face_normal(face as usize);
            mesh.faces[face as usize].nodes().iter().for_each(|&node| outward.entry(node).or_default().push(normal));
        }
        let area = tributary_areas(mesh, &surface.faces).into_iter().map(|patch| (patch.node, patch.area)).collect();
        Nodes { search, outward, area }
    }

    /// The area that a node stands for, and where it meets the master, if it does.
    fn foot(&self, node: u32) -> (f64, Option<Foot>) {
        let area = self.area.get(&node).copied().unwrap_or(0.0);
        let x = self.search.mesh.nodes[node as usize];
        let foot = self.outward.get(&node).and_then(|outward| self.search.foot(x, outward));
        (area, foot.filter(|_| area > 0.0))
    }
}

/// What single nodes that could carry a multiplier meet.
pub(super) fn claims_of_nodes(
    mesh: &Mesh,
    dofs: &DofMap,
    surface: &ContactSurface,
    master: &Master,
    nodes: &[u32],
) -> FxHashMap<u32, Claim> {
    let found = Nodes::new(mesh, surface, master);
    let others: FxHashSet<u32> = mesh.face_nodes(&master.faces).into_iter().collect();
    let of = |&node: &u32| {
        let (area, foot) = found.foot(node);
        let Foot { normal, distance, .. } = foot.filter(|_| !others.contains(&node))?;
        let free = prescribed(dofs, node).map(|value| value.is_none());
        let tied = || tied_frame_at(dofs, node, free).filter(|_| surface.friction == SurfaceFriction::Bonded);
        frame_at(dofs, node, normal, free, [false; 3]).or_else(tied)?;
        Some((node, Claim { distance, covered: area, whole: area, normal, level: None }))
    };
    nodes.iter().filter_map(of).collect()
}

/// Where a node meets the master.
struct Foot {
    /// The nodes of the face with their weights.
    weights: Vec<(u32, f64)>,
    /// Towards the master.
    normal: V3,
    /// Length.
    distance: f64,
}

impl Search<'_> {
    /// The nearest point of the master below `x`, among faces that look at one of `outward`.
    fn foot(&self, x: V3, outward: &[V3]) -> Option<Foot> {
        let mesh = self.mesh;
        let nearest = |i: u32| {
            let nodes = mesh.faces[self.faces[i as usize] as usize].border();
            let at = |k: usize| mesh.nodes[nodes[k] as usize];
            let triangles = (1..nodes.len() - 1).map(|k| [at(0), at(k), at(k + 1)]);
            let points = triangles.map(|triangle| nearest_on_triangle(x, triangle));
            points.min_by(|&a, &b| norm(sub(x, a)).total_cmp(&norm(sub(x, b))))
        };
        let distance2 = |i: u32| {
            let normal = mesh.face_normal(self.faces[i as usize] as usize);
            let looks = outward.iter().any(|&own| dot(own, normal) < FACING);
            nearest(i).filter(|_| looks).map_or(f64::INFINITY, |p| dot(sub(x, p), sub(x, p)))
        };
        let (i, _) = self.tree.nearest(x, self.reach * self.reach, distance2)?;
        let face = self.faces[i as usize];
        let (plane, point) = (Plane::of_face(mesh, face)?, nearest(i)?);
        let (way, normal) = (sub(x, point), plane.axes[2]);
        let size = mesh.face_area(face as usize).sqrt();
        if norm(way) > TOUCHING * size && dot(way, normal).abs() < BESIDE * norm(way) {
            return None;
        }
        let seen = plane.see(&face_coordinates(mesh, face));
        let from = sub(point, plane.origin);
        let shape = seen.flat.shape([dot(from, plane.axes[0]), dot(from, plane.axes[1])]);
        let weights = mesh.faces[face as usize].nodes().iter().zip(shape).filter(|w| w.1.abs() > ROUNDING);
        let weights = weights.map(|(&node, w)| (node, w)).collect();
        Some(Foot { weights, normal: scale(-1.0, normal), distance: norm(way) })
    }
}

/// The points of single nodes, ascending, on the surface of `master`. `lost` are the nodes that belong to other contacts, and
/// `taken` has those that may not be used either.
///
/// # Errors
/// A master without faces; a node that is dragged along it by a prescribed displacement.
pub(super) fn points_of_nodes(
    mesh: &Mesh,
    dofs: &DofMap,
    surface: &ContactSurface,
    master: &Master,
    nodes: &[u32],
    (lost, taken): (&FxHashMap<u32, Lost>, &FxHashSet<u32>),
) -> Result<(Vec<Point>, SurfaceFacts), Error> {
    let mut points = Vec::new();
    if master.faces.is_empty() {
        let remedy = "name a group of boundary faces in `against`";
        return Err(Error::new("", "a surface of the pair has no faces", remedy));
    }
    let single = Nodes::new(mesh, surface, master);
    let mut facts = PairFacts {
        slave: master.slave,
        reason: master.reason,
        faces: [surface.faces.len(), master.faces.len()],
        face_size: [face_size(mesh, &surface.faces), face_size(mesh, &master.faces)],
        search: single.search.reach,
        ..PairFacts::default()
    };
    let mut found = SurfaceFacts::named(&surface.name);
    let others: FxHashSet<u32> = mesh.face_nodes(&master.faces).into_iter().collect();
    let tied = surface.friction == SurfaceFriction::Bonded;
    for &node in nodes {
        let x = mesh.nodes[node as usize];
        let (area, foot) = single.foot(node);
        found.area += area;
        let Some(Foot { weights, normal, distance }) = foot else {
            facts.uncovered += 1;
            continue;
        };
        let near = is_near(distance, area);
        let constrained = prescribed(dofs, node);
        let free = constrained.map(|value| value.is_none());
        let frame = frame_at(dofs, node, normal, free, [false; 3]);
        let frame = frame.or_else(|| if tied { tied_frame_at(dofs, node, free) } else { None });
        let mut frame = match frame {
            _ if others.contains(&node) => {
                facts.shared += 1;
                continue;
            }
            _ if lost.get(&node) == Some(&Lost::Behind) => {
                found.behind += 1;
                continue;
            }
            _ if lost.contains_key(&node) || taken.contains(&node) => {
                found.taken += 1;
                found.near[1] += usize::from(near && lost.get(&node) != Some(&Lost::AcrossEdge));
                continue;
            }
            None => {
                *(if free.contains(&true) { &mut found.held_along_normal } else { &mut found.clamped }) += 1;
                found.dropped_area += area;
                continue;
            }
            Some(frame) => frame,
        };
        found.near[0] += usize::from(near);
        let below = Below::of_node(node, weights.iter().map(|weight| weight.0), facts.face_size[1]);
        let slides = below.slides(mesh, dofs, node, normal, &surface.friction)?;
        frame = frame_at(dofs, node, normal, free, slides).unwrap_or(frame);
        let along = dofs.components(node, normal);
        let imposed: f64 = (0..3).map(|c| along[c] * constrained[c].unwrap_or(0.0)).sum();
        let tangents = [frame[1], frame[2]].map(|tangent| dofs.components(node, tangent));
        refuse_dragging(&constrained, imposed, along, node, x, &surface.friction, &tangents)?;
        let others = weights.into_iter().map(|(other, weight)| (other, -weight)).collect();
        let row = Row { node, area, unity_sum: 1.0, others };
        let gap = initial_gap(mesh, &row, normal, &master.gap, &FxHashMap::default());
        let gap = resolved_gap(mesh, &row, gap, &master.gap);
        found.guided += usize::from(frame[2] == [0.0; 3]);
        found.held_along_surface += usize::from(is_held_along(dofs, node, &tangents));
        (found.gap_min, found.gap_max) = (found.gap_min.min(gap), found.gap_max.max(gap));
        facts.covered_area += area;
        if gap.abs() <= TOUCHING * facts.face_size[0] {
            facts.touching_area += area;
        } else if gap < 0.0 {
            found.overlapping += 1;
            found.overlapping_area += area;
        }
        // A tie keeps the distance it was meshed with.
        let gap = if tied { 0.0 } else { gap };
        let (friction, orthotropy) = law(&surface.friction, &At { node, x, area, normal }, &mut frame)?;
        let (stiffness, layer) = (surface.stiffness, None);
        let Row { unity_sum, others, .. } = row;
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
        found.nodes.push(node);
    }
    found.points = found.nodes.len();
    if found.points == 0 {
        (found.gap_min, found.gap_max) = (0.0, 0.0);
    }
    found.pair = Some(facts);
    Ok((points, found))
}

/// A part of the size of the smaller surface; of the master where nodes have no face that looks at it.
fn reach(mesh: &Mesh, surface: &ContactSurface, master: &Master) -> f64 {
    let slave = if surface.faces.is_empty() { &master.faces } else { &surface.faces };
    default_search(mesh, slave, &master.faces)
}
