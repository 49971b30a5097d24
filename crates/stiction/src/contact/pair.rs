//! Contact points between two surfaces of the mesh.
//!
//! Rows of `B` are an orthonormal frame at the slave node and minus `M_jk / D_jj` times the same frame at the master
//! nodes, so that forces are self-equilibrated to rounding and moments up to force times gap. A node that cannot carry a
//! multiplier (prescribed, used by another contact, a node of both surfaces, hardly covered) leaves its function to its
//! neighbours, in whose rows it then appears; their partition-of-unity sum says how much more than their own force they stand for.

use rustc_hash::{FxHashMap, FxHashSet};

use super::claims::{Claim, Lost, is_near};
use super::false_overlap::without_false_overlap;
use super::frame::{frame_at, tied_frame_at};
use super::friction_law::{At, law};
use super::held::{Below, is_held_along};
use super::levels::Level;
use super::mortar::{Edges, Met, Row, Search, edges, meet, rows};
use super::normals::normals;
use super::overhang::Overhang;
use super::patches::Patches;
use super::points::{Point, prescribed, refuse_dragging};
use super::rounding::resolved;
use super::slave_choice::face_size;
use super::surface::SEARCH;
use super::tributary::{TributaryArea, tributary_areas};
use super::{ContactSurface, InitialGap, Master, PairFacts, SurfaceFacts, SurfaceFriction};
use crate::Error;
use crate::fem::DofMap;
use crate::mesh::v3::{V3, add, dot, scale, sub, unit};
use crate::mesh::{Bounds, Mesh, Tree, nearest_on_triangle};

/// A node is dropped if less than this part of its patch of faces looks at the other surface: it lies far outside that
/// surface, whose displacement there would be guessed. Others beyond its edge are dropped by [`Overhang`].
const LEAST_COVER: f64 = 0.02;
/// Nodes of one smooth side have normals with a larger cosine.
const SIDE: f64 = 0.5;
/// Gaps below this part of a face's size are rounding.
pub(super) const TOUCHING: f64 = 1e-6;

/// What two surfaces meet of one another, and which nodes of the slave could carry multipliers.
pub(super) struct Matched<'a> {
    mesh: &'a Mesh,
    surface: &'a ContactSurface,
    master: &'a Master,
    search: f64,
    met: Vec<Met>,
    patches: Patches,
    /// Unit normals of the nodes, ascending.
    outward: Vec<(u32, V3)>,
    /// Of each node the areas of its faces, ascending.
    areas: Vec<TributaryArea>,
    /// Of each node the area under which the master lies, and this times the distance.
    covered: FxHashMap<u32, [f64; 2]>,
    /// The nodes of the master.
    others: FxHashSet<u32>,
    edges: Edges,
    /// The nodes beyond the edge of the master.
    overhang: Overhang,
}

/// How many faces both surfaces of a pair have.
fn common_faces(surface: &ContactSurface, master: &Master) -> usize {
    let own: FxHashSet<u32> = surface.faces.iter().copied().collect();
    master.faces.iter().filter(|face| own.contains(face)).count()
}

/// Whether a pair has surfaces that can meet.
pub(super) fn is_posed(surface: &ContactSurface, master: &Master) -> bool {
    !surface.faces.is_empty() && !master.faces.is_empty() && common_faces(surface, master) == 0
}

/// What becomes of a node.
enum Standing {
    Uncovered,
    Shared,
    /// It cannot move along the normal; altogether held if so said.
    Held(bool),
    BarelyCovered,
    Carries([V3; 3]),
}

impl<'a> Matched<'a> {
    /// What the faces meet is found unless it is `known`.
    ///
    /// # Errors
    /// Surfaces without faces or with common ones.
    pub(super) fn new(
        mesh: &'a Mesh,
        dofs: &DofMap,
        (surface, master): (&'a ContactSurface, &'a Master),
        known: Option<Vec<Met>>,
    ) -> Result<Matched<'a>, Error> {
        for (faces, key) in [(&surface.faces, "on"), (&master.faces, "against")] {
            if faces.is_empty() {
                let remedy = format!("name a group of boundary faces in `{key}`");
                return Err(Error::new("", "a surface of the pair has no faces", remedy));
            }
        }
        let both = common_faces(surface, master);
        if both > 0 {
            let remedy = "name two surfaces without common faces in `on` and `against`";
            return Err(Error::new(
                "",
                format!("{both} faces belong to both surfaces, and no face can touch itself"),
                remedy,
            ));
        }
        let search = master.search.unwrap_or_else(|| default_search(mesh, &surface.faces, &master.faces));
        let tied = surface.friction == SurfaceFriction::Bonded;
        let search_of = Search { length: search, averted: tied };
        let met = known.unwrap_or_else(|| meet(mesh, &surface.faces, &master.faces, search_of));
        let patches = Patches::new(mesh, &surface.faces, &met, tied);
        let outward = normals(mesh, &surface.faces, dofs, &|face, node| patches.shapes(face, node));
        let mut covered: FxHashMap<u32, [f64; 2]> = FxHashMap::default();
        for (&face, met) in surface.faces.iter().zip(&met) {
            for (&node, area) in mesh.faces[face as usize].nodes().iter().zip(met.areas) {
                let area = if patches.carries(face, node) { area } else { 0.0 };
                let [sum, moment] = covered.entry(node).or_default();
                (*sum, *moment) = (*sum + area, *moment + area * met.distance);
            }
        }
        let areas = tributary_areas(mesh, &surface.faces);
        let others = mesh.face_nodes(&master.faces).into_iter().collect();
        let (edges, overhang) = (edges(mesh, &surface.faces), Overhang::default());
        let mut matched =
            Matched { mesh, surface, master, search, met, patches, outward, areas, covered, others, edges, overhang };
        // Forces of a tie have any direction: together their resultant lies where it has to.
        if !tied {
            let carrying: FxHashSet<u32> = matched.carrying(dofs).map(|(node, ..)| node).collect();
            let carries = |face: u32, node: u32| matched.patches.carries(face, node) && carrying.contains(&node);
            matched.overhang = Overhang::new(mesh, &surface.faces, &matched.met, &matched.edges, carries);
        }
        Ok(matched)
    }

    fn standing(&self, dofs: &DofMap, node: u32, normal: V3, whole: f64) -> Standing {
        let free = prescribed(dofs, node).map(|value| value.is_none());
        let tied = self.surface.friction == SurfaceFriction::Bonded;
        let axes = frame_at(dofs, node, normal, free, [false; 3]);
        let axes = axes.or_else(|| if tied { tied_frame_at(dofs, node, free) } else { None });
        let covered = self.covered[&node][0];
        match axes {
            _ if covered == 0.0 => Standing::Uncovered,
            _ if self.others.contains(&node) => Standing::Shared,
            None => Standing::Held(!free.contains(&true)),
            _ if covered < LEAST_COVER * whole || self.overhang.dropped.contains(&node) => Standing::BarelyCovered,
            Some(axes) => Standing::Carries(axes),
        }
    }

    /// From a node that meets something to it.
    fn distance(&self, node: u32) -> f64 {
        let [covered, moment] = self.covered[&node];
        (moment / covered).abs()
    }

    /// Whether a node that could not carry a multiplier is neither held nor one of both surfaces.
    pub(super) fn hardly_meets(&self, dofs: &DofMap, node: u32) -> bool {
        !self.others.contains(&node) && prescribed(dofs, node).iter().all(Option::is_none)
    }

    /// The normal of a node some of whose faces meets the other surface.
    pub(super) fn meets_on(&self, node: u32) -> Option<V3> {
        let meets = self.covered.get(&node).is_some_and(|[area, _]| *area > 0.0);
        let place = self.outward.partition_point(|(other, _)| *other < node);
        self.outward.get(place).filter(|(other, _)| meets && *other == node).map(|(_, normal)| *normal)
    }

    /// Of the nodes that could carry a multiplier.
    pub(super) fn claims(&self, dofs: &DofMap) -> FxHashMap<u32, Claim> {
        let levels = self.levels();
        let of = |(node, normal, whole): (u32, V3, f64)| {
            let (distance, covered) = (self.distance(node), self.covered[&node][0]);
            (node, Claim { distance, covered, whole, normal, level: levels.get(&node).copied() })
        };
        self.carrying(dofs).map(of).collect()
    }

    /// Where each node meets the master, in the mean over its faces.
    fn levels(&self) -> FxHashMap<u32, Level> {
        let mut sums: FxHashMap<u32, (f64, Level)> = FxHashMap::default();
        for (&face, met) in self.surface.faces.iter().zip(&self.met) {
            for (&node, area) in self.mesh.faces[face as usize].nodes().iter().zip(met.areas) {
                if area > 0.0 && self.patches.carries(face, node) {
                    let (sum, level) = sums.entry(node).or_default();
                    *sum += area;
                    level.point = add(level.point, scale(area, met.middle));
                    level.normal = add(level.normal, met.normals);
                }
            }
        }
        let mean = |(node, (area, level)): (u32, (f64, Level))| {
            Some((node, Level { point: scale(1.0 / area, level.point), normal: unit(level.normal)? }))
        };
        sums.into_iter().filter_map(mean).collect()
    }

    /// The nodes that could carry a multiplier, with their normals and areas.
    fn carrying(&self, dofs: &DofMap) -> impl Iterator<Item = (u32, V3, f64)> {
        let all = self.outward.iter().zip(&self.areas);
        let all = all.map(|(&(node, normal), patch)| (node, normal, patch.area));
        all.filter(|&(node, normal, whole)| matches!(self.standing(dofs, node, normal, whole), Standing::Carries(_)))
    }
}

/// The points of one pair. `lost` are the nodes that belong to other contacts, and `taken` has those that have points of others, or from
/// which chains of points would lead back to them.
///
/// A point hangs on its own node and on the master nodes by the weighted jump of [`rows`]; its gap is that jump of the
/// coordinates along the averaged normal, so that gap and displacement mean the same whatever the meshes. Nodes that
/// cannot carry a multiplier leave it to their neighbours.
pub(super) fn points_of_pair(
    matched: &Matched,
    dofs: &DofMap,
    lost: &FxHashMap<u32, Lost>,
    taken: &FxHashSet<u32>,
) -> Result<(Vec<Point>, SurfaceFacts), Error> {
    let mut points = Vec::new();
    let Matched { mesh, surface, master, search, ref met, ref patches, ref edges, ref overhang, .. } = *matched;
    let tied = surface.friction == SurfaceFriction::Bonded;
    let sizes = [face_size(mesh, &surface.faces), face_size(mesh, &master.faces)];
    let mut facts = PairFacts {
        slave: master.slave,
        reason: master.reason,
        faces: [surface.faces.len(), master.faces.len()],
        face_size: sizes,
        search,
        covered_area: met.iter().map(|met| met.covered).sum(),
        flat_area: met.iter().map(|met| met.flat).sum(),
        averted: met.iter().any(|met| met.averted),
        ..PairFacts::default()
    };
    let mut found = SurfaceFacts::named(&surface.name);
    let frames = frames(matched, dofs, (lost, taken), &mut facts, &mut found)?;
    let outward: FxHashMap<u32, V3> = matched.outward.iter().copied().collect();
    let distances = distances(mesh, &surface.faces, met, patches);
    // Faces that do not count for a node are left to others than those that do: what lies behind is at another distance.
    let keep = |face: u32, node: u32| match (patches.carries(face, node), frames.contains_key(&node)) {
        (true, true) => Ok(()),
        (true, false) => Err(u32::MAX),
        (false, _) => Err(patches.side(face)),
    };
    let leaves_out = |node: u32| lost.get(&node) == Some(&Lost::Behind);
    let (rows, lost_area) = rows(mesh, &surface.faces, met, (edges, overhang), keep, leaves_out);
    found.dropped_area = lost_area;
    for row in rows {
        let (normal, mut frame) = frames[&row.node];
        let x = mesh.nodes[row.node as usize];
        let constrained = prescribed(dofs, row.node);
        let along = dofs.components(row.node, normal);
        let imposed: f64 = (0..3).map(|c| along[c] * constrained[c].unwrap_or(0.0)).sum();
        let tangents = [frame[1], frame[2]].map(|tangent| dofs.components(row.node, tangent));
        refuse_dragging(&constrained, imposed, along, row.node, x, &surface.friction, &tangents)?;
        let gap = initial_gap(mesh, &row, normal, &master.gap, &outward);
        let gap = resolved_gap(mesh, &row, gap_among(&distances[&row.node], gap, &row, &master.gap), &master.gap);
        let visible = gap / row.unity_sum;
        found.guided += usize::from(frame[2] == [0.0; 3]);
        found.held_along_surface += usize::from(is_held_along(dofs, row.node, &tangents));
        (found.gap_min, found.gap_max) = (found.gap_min.min(visible), found.gap_max.max(visible));
        if visible.abs() <= TOUCHING * sizes[0] {
            facts.touching_area += row.area * row.unity_sum;
        } else if visible < 0.0 {
            found.overlapping += 1;
            found.overlapping_area += row.area * row.unity_sum;
        }
        // A tie keeps the distance it was meshed with.
        let gap = if tied { 0.0 } else { gap };
        let Row { node, area, unity_sum, others } = row;
        let (friction, orthotropy) = law(&surface.friction, &At { node, x, area, normal }, &mut frame)?;
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
        found.nodes.push(node);
    }
    found.points = found.nodes.len();
    if found.points == 0 {
        facts.nearest = nearest(mesh, &surface.faces, &master.faces);
        (found.gap_min, found.gap_max) = (0.0, 0.0);
    }
    found.pair = Some(facts);
    Ok((points, found))
}

/// The area of the slave that meets the other surface once its nodes are moved, and all of it; length squared.
pub(crate) fn area_met_when_moved(
    mesh: &Mesh,
    surface: &ContactSurface,
    master: &Master,
    moved: &dyn Fn([f64; 3]) -> [f64; 3],
) -> [f64; 2] {
    let search = master.search.unwrap_or_else(|| default_search(mesh, &surface.faces, &master.faces));
    let mut there = mesh.clone();
    for node in mesh.face_nodes(&surface.faces) {
        there.nodes[node as usize] = moved(mesh.nodes[node as usize]);
    }
    let tied = surface.friction == SurfaceFriction::Bonded;
    let met = meet(&there, &surface.faces, &master.faces, Search { length: search, averted: tied });
    let whole = surface.faces.iter().map(|&face| mesh.face_area(face as usize)).sum();
    [met.iter().map(|met| met.covered).sum(), whole]
}

/// A quarter of the diagonal of the smaller surface.
pub(super) fn default_search(mesh: &Mesh, slave: &[u32], master: &[u32]) -> f64 {
    let diagonal = |faces: &[u32]| {
        Bounds::around(mesh.face_nodes(faces).into_iter().map(|node| mesh.nodes[node as usize])).diagonal()
    };
    SEARCH * diagonal(slave).min(diagonal(master))
}

/// Normal and frame of each node that keeps its multipliers; counts those that do not.
fn frames(
    matched: &Matched,
    dofs: &DofMap,
    (lost, taken): (&FxHashMap<u32, Lost>, &FxHashSet<u32>),
    facts: &mut PairFacts,
    found: &mut SurfaceFacts,
) -> Result<FxHashMap<u32, (V3, [V3; 3])>, Error> {
    let Matched { mesh, surface, ref met, ref patches, .. } = *matched;
    let carries = |face: u32, node: u32| patches.carries(face, node);
    let below = Below::new(mesh, dofs, (&surface.faces, met), &carries, facts.face_size[0]);
    let mut frames = FxHashMap::default();
    for (&(node, normal), tributary) in matched.outward.iter().zip(&matched.areas) {
        let whole = tributary.area;
        found.area += tributary.unity_sum() * whole;
        let standing = matched.standing(dofs, node, normal, whole);
        let lost = lost.get(&node);
        let is_taken = lost.is_some() || taken.contains(&node);
        let near = matches!(standing, Standing::Carries(_)) && is_near(matched.distance(node), whole);
        if near && ![Some(&Lost::Behind), Some(&Lost::AcrossEdge)].contains(&lost) {
            found.near[usize::from(is_taken)] += 1;
        }
        match standing {
            Standing::Uncovered => facts.uncovered += 1,
            Standing::Shared => facts.shared += 1,
            _ if lost == Some(&Lost::Behind) => found.behind += 1,
            _ if is_taken => found.taken += 1,
            Standing::Held(true) => found.clamped += 1,
            Standing::Held(false) => found.held_along_normal += 1,
            Standing::BarelyCovered => facts.barely_covered += 1,
            Standing::Carries(axes) => {
                let free = prescribed(dofs, node).map(|value| value.is_none());
                let slides = below.slides(mesh, dofs, node, normal, &surface.friction)?;
                let axes = frame_at(dofs, node, normal, free, slides).unwrap_or(axes);
                frames.insert(node, (normal, axes));
            }
        }
    }
    Ok(frames)
}

/// What a node looks at: the least and the largest distance, and whether these are parts that do not hang together.
struct Distances {
    low: f64,
    high: f64,
    several: bool,
}

fn distances(mesh: &Mesh, slave: &[u32], met: &[Met], patches: &Patches) -> FxHashMap<u32, Distances> {
    let mut all: FxHashMap<u32, Distances> = FxHashMap::default();
    for (&face, met) in slave.iter().zip(met) {
        for &node in mesh.faces[face as usize].nodes() {
            let empty = Distances { low: f64::INFINITY, high: f64::NEG_INFINITY, several: false };
            let of = all.entry(node).or_insert(empty);
            of.several |= met.several;
            if met.covered > 0.0 && patches.carries(face, node) {
                (of.low, of.high) = (of.low.min(met.distances[0]), of.high.max(met.distances[1]));
            }
        }
    }
    all
}

/// A weighted gap whose weights add up to `unity_sum`: a mean lies among what it is of, but the dual functions, negative in places, may
/// take it beyond.
fn gap_among(of: &Distances, gap: f64, row: &Row, stated: &InitialGap) -> f64 {
    let [low, high] = [of.low, of.high].map(|distance| distance * row.unity_sum);
    match stated {
        _ if low > high => gap,
        InitialGap::ClosedAt(nodes) if nodes.binary_search(&row.node).is_ok() => gap,
        InitialGap::AsMeshed if of.several => gap.max(low).min(high),
        InitialGap::AsMeshed | InitialGap::ClosedAt(_) => without_false_overlap(gap, low),
        _ => gap,
    }
}

/// The weighted jump of the coordinates along the normal, or what the case says it is: the weighted jump of a field as
/// long as the gap along the normals of the slave surface, which turn where that is curved.
pub(super) fn initial_gap(mesh: &Mesh, row: &Row, normal: V3, gap: &InitialGap, outward: &FxHashMap<u32, V3>) -> f64 {
    let x = mesh.nodes[row.node as usize];
    let meshed = || {
        let along = |&(other, weight): &(u32, f64)| weight * dot(normal, sub(mesh.nodes[other as usize], x));
        0.0 - row.others.iter().map(along).sum::<f64>()
    };
    match gap {
        InitialGap::AsMeshed => meshed(),
        InitialGap::Closed => 0.0,
        InitialGap::ClosedWithin(reach) => Some(meshed()).filter(|gap| *gap > reach * row.unity_sum).unwrap_or(0.0),
        InitialGap::ClosedAt(nodes) if nodes.binary_search(&row.node).is_ok() => 0.0,
        InitialGap::ClosedAt(_) => meshed(),
        InitialGap::Uniform(gap) => {
            // A node that is carried for across a sharp edge has a normal of its own there.
            let along = |cosine: f64| if cosine < SIDE { 1.0 } else { cosine };
            let of = |&(other, weight): &(u32, f64)| Some(weight * along(dot(normal, *outward.get(&other)?)));
            gap * (1.0 + row.others.iter().filter_map(of).sum::<f64>())
        }
    }
}

/// What the coordinates tell of a gap that they are to tell.
pub(super) fn resolved_gap(mesh: &Mesh, row: &Row, gap: f64, stated: &InitialGap) -> f64 {
    let places = row.others.iter().map(|&(other, _)| other).chain([row.node]);
    match stated {
        InitialGap::Closed | InitialGap::Uniform(_) => gap,
        _ => resolved(gap, places.map(|node| mesh.nodes[node as usize])),
    }
}

/// Smallest distance of a node of the first surface from the second.
fn nearest(mesh: &Mesh, from: &[u32], to: &[u32]) -> Option<f64> {
    let at = |node: &u32| mesh.nodes[*node as usize];
    let triangles: Vec<[V3; 3]> = (to.iter())
        .flat_map(|&face| {
            let nodes = mesh.faces[face as usize].border();
            (1..nodes.len() - 1).map(|i| [at(&nodes[0]), at(&nodes[i]), at(&nodes[i + 1])]).collect::<Vec<_>>()
        })
        .collect();
    let tree = Tree::new(triangles.iter().map(|t| Bounds::around(*t)).collect());
    let mut best: Option<f64> = None;
    for node in mesh.face_nodes(from) {
        let distance2 = |i: u32| {
            let d = sub(at(&node), nearest_on_triangle(at(&node), triangles[i as usize]));
            dot(d, d)
        };
        let nearer = tree.nearest(at(&node), best.unwrap_or(f64::INFINITY), distance2);
        best = nearer.map(|found| found.1).or(best);
    }
    best.map(f64::sqrt)
}
