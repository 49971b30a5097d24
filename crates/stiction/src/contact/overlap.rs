//! Whether surfaces have passed through each other: the judge of what no contact point keeps apart.
//!
//! Points of the outer faces are looked at where they have moved to. A point lies inside a body if what a ray from it
//! meets first of that body's surface is seen from inside. Depths are measured along the inward normal of the face to a
//! face that looks the other way.
//!
//! Where two surfaces are named, what lies beyond their `search` is also judged as contact would: a place and what it looks
//! at along its normal before the load must not approach each other by more than they are apart. That needs no position,
//! and sees bodies that have passed through each other altogether.
//!
//! Not every overlap is one. Meshes of a curved surface overlap by the rise of its arcs ([`Skin::sag`]). Contact points keep
//! averages of gaps from being negative, not every gap. What a mesh overlaps by before anything moves is a matter of the
//! mesh.

use std::sync::OnceLock;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::entered::{Motion, OFF_BORDER, between_nodes, got_in};
use super::mortar::FACING;
use super::skin::{Hit, Outer, Skin, weighted};
use super::slave_choice::face_size;
use super::{ContactSurface, Counterpart, InitialGap, Master, SurfaceFacts, SurfaceFriction};
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};
use crate::mesh::{Bounds, Face, Mesh};

/// Motion of surfaces beyond this part of a face is not small: contact is that of the unmoved bodies. Up to it single
/// places may also overlap where contact points keep the surfaces apart on average.
pub const SMALL_MOTION: f64 = 0.2;
/// Coordinates and displacements are known to this part of the largest.
const ROUNDING: f64 = 1e-12;
/// Triangles that are looked at together first.
const CLUSTER: usize = 16;
/// Most positions between two load states that are looked at.
const MOST_PARTS: usize = 8;

/// Surfaces that lie in each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlap {
    /// What it means.
    pub kind: OverlapKind,
    /// The contact it belongs to, by its place among the surfaces: of a pair, or of the obstacle.
    pub surface: Option<usize>,
    /// The bodies, the one that `place` belongs to first; the same twice for an obstacle and for a body that meets itself.
    pub bodies: [u32; 2],
    /// The faces, in the order of the bodies; `None` for an obstacle.
    pub faces: [Option<u32>; 2],
    /// A point of the undeformed body where it is deepest, length.
    pub place: [f64; 3],
    /// Length, > 0.
    pub depth: f64,
    /// The part of the way from the load state before at which it is so deep: 1 unless bodies have left each other again.
    pub part: f64,
}

/// What an overlap means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OverlapKind {
    /// No contact is named there.
    Unnamed,
    /// The surfaces of a pair meet farther apart than they were looked for; `search` (length) would find them.
    BeyondSearch {
        /// Length.
        search: f64,
    },
    /// A contact is named, and no contact point can be had there.
    OutOfReach,
    /// Contact points are there, and what they keep apart has moved too far for contact of the unmoved bodies.
    InContact,
    /// An obstacle reaches into a face between nodes that it does not touch, and no face beside it has a node that it touches.
    BetweenPoints,
}

impl OverlapKind {
    /// Whether it contradicts the case: contact is named, and none is there.
    pub fn is_refused(self) -> bool {
        matches!(self, OverlapKind::BeyondSearch { .. } | OverlapKind::OutOfReach)
    }
}

/// What contact is posed on.
pub struct Assembly<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The body of each node.
    pub body: Vec<u32>,
    /// The contact surfaces.
    pub surfaces: &'a [ContactSurface],
    /// What was found of each of them.
    pub facts: Vec<&'a SurfaceFacts>,
}

/// Where everything has moved to.
#[derive(Debug, Clone, Default)]
pub struct Moved {
    /// Displacement of each node, length.
    pub u: Vec<[f64; 3]>,
    /// Translation of the obstacle of each surface, length; zero for pairs.
    pub obstacles: Vec<[f64; 3]>,
}

/// The deepest overlap of each kind for each contact, obstacle and two bodies at `now`, and on the way there from `before`
/// as far as bodies move farther than they are thick. Displacements are known to the part `accuracy` of the largest.
pub fn overlaps(assembly: &Assembly, before: &Moved, now: &Moved, accuracy: f64) -> Vec<Overlap> {
    let Assembly { mesh, body, .. } = assembly;
    let outer = Outer::new(mesh, body);
    let check = Check::new(assembly, &outer, now, accuracy);
    let mut found = check.beyond_search(now);
    let parts = (check.farthest(before, now) / check.thinnest()).ceil().clamp(1.0, MOST_PARTS as f64) as usize;
    for part in 1..=parts {
        let way = part as f64 / parts as f64;
        let at: Vec<V3> = if part == parts {
            now.u.clone()
        } else {
            before.u.iter().zip(&now.u).map(|(a, b)| add(*a, scale(way, sub(*b, *a)))).collect()
        };
        let here = check.between_bodies(&at).into_iter().map(|overlap| Overlap { part: way, ..overlap });
        // Contact holds at the end of a step.
        found.extend(here.filter(|overlap| part == parts || overlap.kind == OverlapKind::Unnamed));
    }
    found.extend(check.with_obstacles(now));
    deepest(found)
}

/// The deepest of each kind between the same two, of several the first. What is unnamed between bodies whose named
/// surfaces pass through each other follows from that.
fn deepest(found: Vec<Overlap>) -> Vec<Overlap> {
    let ends = |o: &Overlap| [o.bodies[0].min(o.bodies[1]), o.bodies[0].max(o.bodies[1])];
    let mut kept: Vec<Overlap> = Vec::new();
    for overlap in found {
        let kind = std::mem::discriminant(&overlap.kind);
        let same = |o: &&mut Overlap| {
            std::mem::discriminant(&o.kind) == kind && o.surface == overlap.surface && ends(o) == ends(&overlap)
        };
        match kept.iter_mut().find(same) {
            Some(known) => {
                let widest = |a: OverlapKind, b: OverlapKind| match (a, b) {
                    (OverlapKind::BeyondSearch { search: a }, OverlapKind::BeyondSearch { search: b }) => {
                        OverlapKind::BeyondSearch { search: a.max(b) }
                    }
                    (a, _) => a,
                };
                let kind = widest(known.kind, overlap.kind);
                if overlap.depth > known.depth {
                    *known = overlap;
                }
                known.kind = kind;
            }
            None => kept.push(overlap),
        }
    }
    let refused: Vec<[u32; 2]> = kept.iter().filter(|o| o.kind.is_refused()).map(ends).collect();
    kept.retain(|o| o.kind.is_refused() || o.surface.is_some() || !refused.contains(&ends(o)));
    kept
}

struct Check<'a> {
    assembly: &'a Assembly<'a>,
    outer: &'a Outer,
    still: OnceLock<Skin<'a>>,
    /// How far things move relative to one another at most, length.
    spread: f64,
    /// Depths below it are rounding, length.
    rounding: f64,
    /// For each face of a pair its surface, and whether it is one of the slave; ascending.
    roles: Vec<(u32, usize, bool)>,
    /// Nodes with a contact point of each surface, ascending.
    held: Vec<Vec<u32>>,
}

impl<'a> Check<'a> {
    fn new(assembly: &'a Assembly, outer: &'a Outer, now: &Moved, accuracy: f64) -> Check<'a> {
        let mut roles = Vec::new();
        for (i, surface) in assembly.surfaces.iter().enumerate() {
            if let Counterpart::Surface(Master { faces, .. }) = &surface.against {
                roles.extend(surface.faces.iter().map(|&face| (face, i, true)));
                roles.extend(faces.iter().map(|&face| (face, i, false)));
            }
        }
        roles.sort_unstable();
        let sorted = |facts: &&SurfaceFacts| {
            let mut nodes = facts.nodes.clone();
            nodes.sort_unstable();
            nodes
        };
        let held = assembly.facts.iter().map(sorted).collect();
        let skin = assembly.mesh.faces.iter().flat_map(Face::nodes).map(|&node| now.u[node as usize]);
        let way = Bounds::around(skin.chain(now.obstacles.iter().copied()));
        let spread = way.diagonal();
        let largest = Bounds::around(assembly.mesh.nodes.iter().copied().chain([[0.0; 3]])).diagonal()
            + way.with(&Bounds::around([[0.0; 3]])).diagonal();
        let rounding = accuracy * spread + ROUNDING * largest;
        Check { assembly, outer, still: OnceLock::new(), spread, rounding, roles, held }
    }

    /// The surface before anything has moved.
    fn still(&self) -> &Skin<'a> {
        self.still.get_or_init(|| Skin::new(self.assembly.mesh, self.outer, self.assembly.mesh.nodes.clone()))
    }

    /// How far things move relative to one another between two states.
    fn farthest(&self, before: &Moved, now: &Moved) -> f64 {
        let way = before.u.iter().zip(&now.u).map(|(a, b)| sub(*b, *a));
        Bounds::around(way).diagonal()
    }

    /// The least extent of a body along an axis.
    fn thinnest(&self) -> f64 {
        let Assembly { mesh, body, .. } = self.assembly;
        let count = body.iter().max().map_or(0, |&last| last as usize + 1);
        let mut bounds = vec![Bounds::around([]); count];
        body.iter().zip(&mesh.nodes).for_each(|(&body, &x)| {
            let around = &mut bounds[body as usize];
            *around = around.with(&Bounds { low: x, high: x });
        });
        let least = |b: &Bounds| (0..3).map(|c| b.high[c] - b.low[c]).fold(f64::INFINITY, f64::min);
        bounds.iter().map(least).fold(f64::INFINITY, f64::min)
    }

    fn roles(&self, face: u32) -> &[(u32, usize, bool)] {
        let from = self.roles.partition_point(|role| role.0 < face);
        let count = self.roles[from..].iter().take_while(|role| role.0 == face).count();
        &self.roles[from..from + count]
    }

    fn is_held(&self, surface: usize, face: u32) -> bool {
        let nodes = self.assembly.mesh.faces[face as usize].nodes();
        nodes.iter().any(|node| self.held[surface].binary_search(node).is_ok())
    }

    /// The pair that names two faces as slave and master, and whether contact points keep them apart; of several the one
    /// that does.
    fn pair(&self, a: u32, b: u32) -> Option<(usize, bool)> {
        let theirs = self.roles(b);
        let common = self.roles(a).iter().filter(|mine| theirs.iter().any(|t| t.1 == mine.1 && t.2 != mine.2));
        let pairs = common.map(|&(_, i, slave)| (i, self.is_held(i, if slave { a } else { b })));
        pairs.max_by_key(|&(i, held)| (held, std::cmp::Reverse(i)))
    }

    /// Places of named surfaces without contact point that approach what they look at by more than they are apart.
    fn beyond_search(&self, now: &Moved) -> Vec<Overlap> {
        let mut found = Vec::new();
        for (i, surface) in self.assembly.surfaces.iter().enumerate() {
            let (Counterpart::Surface(master), Some(pair)) = (&surface.against, &self.assembly.facts[i].pair) else {
                continue;
            };
            if self.spread <= pair.search {
                continue; // so far apart nothing comes together
            }
            let against: FxHashSet<u32> = master.faces.iter().copied().collect();
            let faces = surface.faces.par_iter().filter(|&&face| !self.is_held(i, face));
            let of_face = |&face: &u32| {
                let triangles = self.outer.of_face(face);
                triangles.flat_map(|t| self.approach(i, t, pair.search, &against, now)).collect::<Vec<Overlap>>()
            };
            found.extend(faces.flat_map_iter(of_face).collect::<Vec<Overlap>>());
        }
        found
    }

    fn approach(&self, i: usize, t: u32, search: f64, against: &FxHashSet<u32>, now: &Moved) -> Vec<Overlap> {
        let skin = self.still();
        let normal = skin.normal[t as usize];
        let moved =
            |hit: u32, weights| weighted(self.outer.triangles[hit as usize].map(|n| now.u[n as usize]), weights);
        let mut found = Vec::new();
        for weights in samples() {
            let hits = skin.hits(t, skin.point(t, weights), normal, self.spread);
            let Some(&Hit { triangle, distance, weights: there }) = hits.first() else { continue };
            let looks_back = dot(skin.normal[triangle as usize], normal) < FACING;
            if !looks_back || !against.contains(&self.outer.face[triangle as usize]) {
                continue;
            }
            let approach = dot(normal, sub(moved(t, weights), moved(triangle, there)));
            // Within reach the points around keep it apart on average, if there are any.
            let within = distance <= search;
            let small = SMALL_MOTION * self.assembly.mesh.face_area(self.outer.face[t as usize] as usize).sqrt();
            if approach - distance > self.rounding + if within { small } else { 0.0 } {
                // A tie over that distance is not what was asked for.
                let tied = self.assembly.surfaces[i].friction == SurfaceFriction::Bonded;
                let beyond = OverlapKind::BeyondSearch { search: approach };
                let kind = if within || tied { OverlapKind::OutOfReach } else { beyond };
                found.push(self.overlap(kind, Some(i), t, triangle, weights, approach - distance));
            }
        }
        found
    }

    fn overlap(
        &self,
        kind: OverlapKind,
        surface: Option<usize>,
        t: u32,
        other: u32,
        weights: [f64; 3],
        depth: f64,
    ) -> Overlap {
        let corners = self.outer.triangles[t as usize].map(|node| self.assembly.mesh.nodes[node as usize]);
        Overlap {
            kind,
            surface,
            bodies: [t, other].map(|t| self.outer.body[t as usize]),
            faces: [t, other].map(|t| Some(self.outer.face[t as usize])),
            place: weighted(corners, weights),
            depth,
            part: 1.0,
        }
    }

    /// Faces that lie in a body with the nodes displaced by `u`.
    fn between_bodies(&self, u: &[V3]) -> Vec<Overlap> {
        let mesh = self.assembly.mesh;
        let at = mesh.nodes.iter().zip(u).map(|(x, u)| add(*x, *u)).collect();
        let skin = Skin::new(mesh, self.outer, at);
        let clusters = skin.tree.things().par_chunks(CLUSTER).filter(|cluster| self.may_lie_inside(&skin, cluster));
        let mut near: Vec<u32> = clusters.flat_map_iter(|cluster| cluster.iter().copied()).collect();
        near.sort_unstable();
        near.into_par_iter().flat_map_iter(|t| self.inside(&skin, t)).collect()
    }

    /// Whether a face that looks back may lie behind one of these triangles: one look at the tree tells it of most.
    fn may_lie_inside(&self, skin: &Skin, cluster: &[u32]) -> bool {
        let around = cluster.iter().fold(Bounds::around([]), |around, &t| around.with(&self.behind(skin, t)));
        let normals = Bounds::around(cluster.iter().map(|&t| skin.normal[t as usize]));
        let least = |n: V3| (0..3).map(|c| (n[c] * normals.low[c]).min(n[c] * normals.high[c])).sum::<f64>();
        skin.tree.meeting(&around).iter().any(|&other| least(skin.normal[other as usize]) < FACING)
    }

    /// The box in which triangle `t` may have come to lie inside something: what has come in from outside has not come
    /// farther than things move.
    fn behind(&self, skin: &Skin, t: u32) -> Bounds {
        let (corners, reach) = (skin.corners(t), scale(self.reach(), skin.normal[t as usize]));
        Bounds::around(corners.into_iter().chain(corners.map(|x| sub(x, reach))))
    }

    /// How far along its inward normal a triangle may be from a face that looks back.
    fn reach(&self) -> f64 {
        self.spread / -FACING
    }

    /// Where samples of triangle `t` lie inside a body: behind faces that look back.
    fn inside(&self, skin: &Skin, t: u32) -> Vec<Overlap> {
        let (normal, reach) = (skin.normal[t as usize], self.reach());
        let inwards = scale(-1.0, normal);
        let looks_back = |other: &u32| dot(skin.normal[*other as usize], normal) < FACING && !skin.adjacent(t, *other);
        // Surfaces in contact lie on one another: what has no corner behind the triangle is hit nowhere.
        let x = skin.corners(t)[0];
        let is_behind = |other: &u32| skin.corners(*other).iter().any(|y| dot(inwards, sub(*y, x)) > self.rounding);
        let near = skin.tree.meeting(&self.behind(skin, t)).into_iter();
        let candidates: Vec<u32> = near.filter(|other| looks_back(other) && is_behind(other)).collect();
        if candidates.is_empty() {
            return Vec::new();
        }
        let mut found = Vec::new();
        for weights in samples() {
            let x = skin.point(t, weights);
            let mut hits: Vec<Hit> = candidates.iter().filter_map(|&o| skin.hit(o, x, inwards, reach)).collect();
            hits.retain(|hit| hit.distance > self.rounding);
            hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            let mut seen: Vec<u32> = Vec::new();
            for hit in hits {
                let body = self.outer.body[hit.triangle as usize];
                // Of each body the first way out.
                if !seen.contains(&body) {
                    seen.push(body);
                    found.extend(self.judged(skin, t, weights, &hit));
                }
            }
        }
        found
    }

    /// What it means that the sample of triangle `t` may lie behind what it hits inwards.
    fn judged(&self, skin: &Skin, t: u32, weights: [f64; 3], hit: &Hit) -> Option<Overlap> {
        let Assembly { mesh, surfaces, facts, .. } = self.assembly;
        let [face, other] = [t, hit.triangle].map(|t| self.outer.face[t as usize]);
        let (x, normal) = (skin.point(t, weights), skin.normal[t as usize]);
        let body = self.outer.body[hit.triangle as usize];
        let sag = || skin.sag(t) + skin.sag(hit.triangle);
        // One ray; the sag looks at the tree a dozen times.
        let outside = || skin.way_out(t, x, normal, body).filter(|&out| out > self.rounding);
        let Some((i, held)) = self.pair(face, other) else {
            let depth = hit.distance.min(outside()?);
            let allowed = self.rounding + sag();
            if hit.distance <= allowed {
                return None;
            }
            let grown = depth - self.before(t, weights, body);
            return (grown > allowed)
                .then(|| self.overlap(OverlapKind::Unnamed, None, t, hit.triangle, weights, depth));
        };
        // What the two are apart before the load, and what the case says they are.
        let [from, to] = [(t, weights), (hit.triangle, hit.weights)].map(|(t, weights)| {
            weighted(self.outer.triangles[t as usize].map(|node| mesh.nodes[node as usize]), weights)
        });
        let meshed = dot(normal, sub(to, from));
        let Counterpart::Surface(master) = &surfaces[i].against else { return None };
        if held && surfaces[i].stiffness.is_some() {
            return None; // the points keep apart what yields between the surfaces
        }
        let stated = match &master.gap {
            _ if surfaces[i].friction == SurfaceFriction::Bonded => 0.0,
            InitialGap::AsMeshed => meshed,
            InitialGap::Closed => 0.0,
            InitialGap::ClosedWithin(reach) if meshed <= *reach => 0.0,
            InitialGap::ClosedWithin(_) => meshed,
            // Overlaps may be closed at any node of the two.
            InitialGap::ClosedAt(_) => meshed.max(0.0),
            InitialGap::Uniform(gap) => *gap,
        };
        let size = [face, other].map(|face| mesh.face_area(face as usize).sqrt());
        let allowed = self.rounding + SMALL_MOTION * size[0].min(size[1]) + (stated - meshed).max(0.0);
        if hit.distance <= allowed {
            return None;
        }
        outside()?;
        if hit.distance <= allowed + sag() {
            return None;
        }
        let search = facts[i].pair.as_ref().map_or(0.0, |pair| pair.search);
        let kind = match held {
            true => OverlapKind::InContact,
            false if meshed.abs() > search && surfaces[i].friction != SurfaceFriction::Bonded => {
                OverlapKind::BeyondSearch { search: meshed.abs() + hit.distance }
            }
            false => OverlapKind::OutOfReach,
        };
        Some(self.overlap(kind, Some(i), t, hit.triangle, weights, hit.distance))
    }

    /// How deep a sample lies in a body before anything has moved.
    fn before(&self, t: u32, weights: [f64; 3], body: u32) -> f64 {
        let skin = self.still();
        let (x, normal) = (skin.point(t, weights), skin.normal[t as usize]);
        let inwards = scale(-1.0, normal);
        let leaves = |hit: &&Hit| {
            let of = hit.triangle as usize;
            self.outer.body[of] == body && dot(skin.normal[of], normal) < FACING
        };
        let hits = skin.hits(t, x, inwards, skin.size);
        let Some(deep) = hits.iter().find(leaves).map(|hit| hit.distance) else { return 0.0 };
        skin.way_out(t, x, normal, body).map_or(0.0, |out| deep.min(out))
    }

    /// Nodes that have got into an obstacle.
    fn with_obstacles(&self, now: &Moved) -> Vec<Overlap> {
        let mesh = self.assembly.mesh;
        let mut is_outer = vec![false; mesh.nodes.len()];
        mesh.faces.iter().flat_map(Face::nodes).for_each(|&node| is_outer[node as usize] = true);
        let mut found = Vec::new();
        for (i, surface) in self.assembly.surfaces.iter().enumerate() {
            let Counterpart::Obstacle(obstacle) = &surface.against else { continue };
            if surface.friction == SurfaceFriction::Bonded {
                continue; // keeps the distance it was meshed with
            }
            let named = mesh.face_nodes(&surface.faces);
            let small = SMALL_MOTION * face_size(mesh, &surface.faces);
            // Where the interface yields the body sinks into the obstacle, with its sides beside the contact.
            let depth_of = |&node: &u32| {
                let way = sub(now.u[node as usize], now.obstacles[i]);
                got_in(obstacle, mesh.nodes[node as usize], way, true, self.rounding).unwrap_or(0.0)
            };
            let yields = surface.stiffness.is_some();
            let sunk = if yields { self.held[i].iter().map(depth_of).fold(0.0, f64::max) } else { 0.0 };
            let of_node = |node: u32| {
                if !is_outer[node as usize] {
                    return None;
                }
                let way = sub(now.u[node as usize], now.obstacles[i]);
                let is_named = named.binary_search(&node).is_ok();
                let is_held = self.held[i].binary_search(&node).is_ok();
                if is_held && yields {
                    return None;
                }
                let allowed = self.rounding + if is_named { small } else { sunk };
                if norm(way) <= allowed {
                    return None;
                }
                let x = mesh.nodes[node as usize];
                let depth = got_in(obstacle, x, way, is_held, self.rounding).filter(|&depth| depth > allowed)?;
                let kind = match (is_named, is_held) {
                    (_, true) => OverlapKind::InContact,
                    (true, false) => OverlapKind::OutOfReach,
                    (false, false) => OverlapKind::Unnamed,
                };
                let bodies = [self.assembly.body[node as usize]; 2];
                Some(Overlap { kind, surface: Some(i), bodies, faces: [None; 2], place: x, depth, part: 1.0 })
            };
            found.extend((0..mesh.nodes.len() as u32).into_par_iter().filter_map(of_node).collect::<Vec<Overlap>>());
            if !yields {
                let way = |node: u32| sub(now.u[node as usize], now.obstacles[i]);
                let (still, rounding) = (self.still(), self.rounding);
                let motion = Motion { mesh, outer: self.outer, still, way: &way, rounding };
                found.extend(between_nodes(&motion, obstacle, &surface.faces).into_iter().map(|entered| Overlap {
                    kind: OverlapKind::BetweenPoints,
                    surface: Some(i),
                    bodies: [self.assembly.body[entered.node as usize]; 2],
                    faces: [None; 2],
                    place: entered.place,
                    depth: entered.depth,
                    part: 1.0,
                }));
            }
        }
        found
    }
}

/// Weights of the corners of a triangle at the points that are looked at.
fn samples() -> [[f64; 3]; 4] {
    let at = |corner: usize| std::array::from_fn(|i| if i == corner { 1.0 - 2.0 * OFF_BORDER } else { OFF_BORDER });
    [[1.0 / 3.0; 3], at(0), at(1), at(2)]
}
