//! Which contact a node belongs to that several name: a node has one multiplier at a time. Contacts that never hold together do
//! not compete.
//!
//! It belongs to the one whose counterpart is nearest, obstacles and bodies alike, or lies above a step down to the others. Of those that
//! are as near, or meet other faces across an edge, it is that of an obstacle, for whose points no neighbour could carry, then the one under which more of the
//! node's faces lie. Bonded surfaces come before all others, as far as they meet something.

use std::collections::BTreeSet;
use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

use super::levels::Level;
use super::meeting::AllMet;
use super::node_to_surface::claims_of_nodes;
use super::pair::Matched;
use super::points::claims_on_obstacle;
use super::spans::spans;
use super::{ContactSurface, Counterpart, Master, SurfaceFriction};
use crate::Error;
use crate::fem::DofMap;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, dot};

/// Distances that differ by less than this part of a face's size are the same, if one counterpart lies behind another.
const ROUNDING: f64 = 1e-6;
/// The same where they lie beside one another under the faces of a node: facets of curved surfaces are as uneven.
const UNEVEN: f64 = 0.05;
/// Two counterparts that lie beside one another cover no more than this part of the faces of a node.
const WHOLE: f64 = 1.01;
/// Nodes have normals with a larger cosine on one smooth side.
pub(super) const SIDE: f64 = 0.8;
/// Areas that differ by less than this part are the same.
const SAME_AREA: f64 = 1e-6;

/// What a node, which could carry a multiplier, meets of the counterpart of a contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim {
    /// From the node to the counterpart before any load or given gap, whatever the sign; length.
    pub distance: f64,
    /// The area of the faces around the node under which the counterpart lies, and of all of them.
    pub covered: f64,
    pub whole: f64,
    /// The unit normal of the node.
    pub normal: V3,
    /// Where the counterpart lies, if it may lie beside others.
    pub level: Option<Level>,
}

/// Whether a node and its counterpart touch, or would if they came nearer by the size of the faces around the node, which have the area
/// `whole`.
pub(super) fn is_near(distance: f64, whole: f64) -> bool {
    distance.abs() <= whole.abs().sqrt()
}

impl Claim {
    /// Whether there is no sharp edge between the faces that meet both counterparts.
    fn is_on_side_of(&self, other: &Claim) -> bool {
        dot(self.normal, other.normal) > SIDE
    }

    /// Whether both counterparts lie beside one another under one side, and neither in front of the other.
    fn is_beside(&self, other: &Claim) -> bool {
        let part = |claim: &Claim| claim.covered / claim.whole;
        self.is_on_side_of(other) && part(self) + part(other) <= WHOLE
    }

    /// Whether the counterpart of this lies in front of the other one.
    fn is_in_front_of(&self, other: &Claim) -> bool {
        self.is_on_side_of(other) && !other.is_as_near_as(self)
    }

    fn is_as_near_as(&self, nearest: &Claim) -> bool {
        let (is_beside, size) = (self.is_beside(nearest), self.whole.min(nearest.whole).abs().sqrt());
        let is_lower = || matches!((&self.level, &nearest.level), (Some(a), Some(b)) if a.is_step_down_from(b, size));
        let part = if is_beside { UNEVEN } else { ROUNDING };
        self.distance - nearest.distance <= part * size && !(is_beside && is_lower())
    }
}

/// How a contact has lost a node to another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lost {
    /// The counterpart of the other contact lies in front: nothing is left to carry.
    Behind,
    /// The other contact has met more of the same faces: the neighbours of the node carry for it, if there are any.
    Beside,
    /// The other contact is bonded, or meets other faces, across an edge: the neighbours of the node carry for it.
    AcrossEdge,
}

/// For each surface the nodes that belong to another one.
pub(super) type LostNodes = Vec<FxHashMap<u32, Lost>>;

/// What surfaces meet, and the nodes that several name.
pub(super) struct Claims<'a> {
    mesh: &'a Mesh,
    dofs: &'a DofMap,
    surfaces: &'a [ContactSurface],
    named: Vec<(u32, Vec<usize>)>,
    by_surface: FxHashMap<usize, FxHashMap<u32, Claim>>,
    /// The matches that were made, by surface.
    matched: FxHashMap<usize, Matched<'a>>,
    /// What faces meet, of those that were found before.
    known: AllMet,
    /// See [`places`].
    pub places: Vec<usize>,
}

/// What surfaces that hold together have of the nodes that several of them name.
pub(super) struct Shares {
    pub lost: LostNodes,
    /// Surfaces that meet parts of the same faces.
    beside: Vec<[usize; 2]>,
    /// Surfaces that have lost nodes, which they could hold, to others across an edge.
    without_edge: Vec<usize>,
}

impl<'a> Claims<'a> {
    pub(super) fn new(mesh: &'a Mesh, dofs: &'a DofMap, surfaces: &'a [ContactSurface], known: AllMet) -> Claims<'a> {
        let named = named_by_several(mesh, surfaces);
        let numbers: BTreeSet<usize> = named.iter().flat_map(|(_, by)| by.iter().copied()).collect();
        let (by_surface, matched) = (FxHashMap::default(), FxHashMap::default());
        let places = places(mesh, surfaces);
        let mut claims = Claims { mesh, dofs, surfaces, named, by_surface, matched, known, places };
        for number in numbers {
            let found = claims.of(number);
            claims.by_surface.insert(number, found);
        }
        claims
    }

    /// The match of a pair.
    ///
    /// # Errors
    /// As of [`Matched::new`].
    pub(super) fn matched(&mut self, number: usize, master: &'a Master) -> Result<&Matched<'a>, Error> {
        Ok(match self.matched.entry(number) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(place) => {
                let (pair, known) = ((&self.surfaces[number], master), self.known.0.remove(&number));
                place.insert(Matched::new(self.mesh, self.dofs, pair, known)?)
            }
        })
    }

    /// Gives back the memory of a match that is not asked for again.
    pub(super) fn forget(&mut self, number: usize) {
        self.matched.remove(&number);
    }

    /// Who has what of the nodes where the surfaces of these numbers, ascending, hold together.
    pub(super) fn shares(&self, holding: &[usize]) -> Shares {
        let (surfaces, holds) = (self.surfaces, |number: &usize| holding.binary_search(number).is_ok());
        let lost = vec![FxHashMap::default(); surfaces.len()];
        let mut shares = Shares { lost, beside: Vec::new(), without_edge: Vec::new() };
        let is_obstacle = |number: usize| matches!(surfaces[number].against, Counterpart::Obstacle(_));
        let is_bonded = |number: usize| surfaces[number].friction == SurfaceFriction::Bonded;
        for (node, by) in &self.named {
            let by: Vec<usize> = by.iter().copied().filter(holds).collect();
            if by.iter().all(|&number| is_obstacle(number)) {
                continue;
            }
            let of = |&number: &usize| Some((number, self.by_surface.get(&number)?.get(node)?));
            let candidates: Vec<(usize, &Claim)> = by.iter().filter_map(of).collect();
            let Some((owner, own)) = owner(&candidates, surfaces, &self.places) else { continue };
            for number in by.into_iter().filter(|&number| number != owner) {
                let claim = candidates.iter().find(|(other, _)| *other == number).map(|(_, claim)| *claim);
                let hides = |(other, front): &(usize, &Claim)| {
                    !is_obstacle(*other) && claim.is_some_and(|claim| front.is_in_front_of(claim))
                };
                let is_hidden = is_obstacle(owner) && candidates.iter().any(hides);
                if is_obstacle(number) && !is_hidden && (is_obstacle(owner) || is_bonded(owner) && !is_bonded(number)) {
                    continue; // several obstacles have the node, and what is tied is known to all
                }
                let lost = match claim {
                    Some(_) if is_hidden && is_obstacle(number) => Lost::Behind,
                    None if is_obstacle(owner) && self.hardly_meets(number, *node) => Lost::Behind,
                    None => Lost::AcrossEdge,
                    Some(_) if is_bonded(owner) && !is_bonded(number) => Lost::AcrossEdge,
                    Some(claim) if claim.is_beside(own) => Lost::Beside,
                    Some(claim) if own.is_in_front_of(claim) => Lost::Behind,
                    Some(_) => Lost::AcrossEdge,
                };
                let is_pair = !is_obstacle(owner) && !is_bonded(owner);
                if lost == Lost::Beside || is_pair && claim.is_none() && self.hardly_meets_beside(number, *node, own) {
                    shares.beside.push([owner, number]);
                }
                if lost == Lost::AcrossEdge && claim.is_some() {
                    shares.without_edge.push(number);
                }
                shares.lost[number].insert(*node, lost);
            }
        }
        shares
    }

    /// Whether a node makes no claim because hardly anything of its faces meets the counterpart.
    fn hardly_meets(&self, number: usize, node: u32) -> bool {
        self.matched.get(&number).is_some_and(|matched| matched.hardly_meets(self.dofs, node))
    }

    /// Whether a little of a node's faces meets the counterpart, which makes no claim, on the side of another claim. Both contacts lose
    /// rows of nodes there: each carries for the nodes of the other.
    fn hardly_meets_beside(&self, number: usize, node: u32, other: &Claim) -> bool {
        let normal = self.matched.get(&number).and_then(|matched| matched.meets_on(node));
        self.hardly_meets(number, node) && normal.is_some_and(|normal| dot(normal, other.normal) > SIDE)
    }

    fn of(&mut self, number: usize) -> FxHashMap<u32, Claim> {
        let (mesh, dofs, surface) = (self.mesh, self.dofs, &self.surfaces[number]);
        match &surface.against {
            Counterpart::Obstacle(obstacle) => claims_on_obstacle(mesh, dofs, surface, obstacle),
            Counterpart::Surface(master) => match &master.nodes {
                Some(nodes) => claims_of_nodes(mesh, dofs, surface, master, nodes),
                // What is wrong with the surfaces is said where they get their points.
                None => {
                    self.matched(number, master).map_or_else(|_| FxHashMap::default(), |matched| matched.claims(dofs))
                }
            },
        }
    }
}

/// Nodes that several surfaces name, at least one of them a surface of a pair, and these.
fn named_by_several(mesh: &Mesh, surfaces: &[ContactSurface]) -> Vec<(u32, Vec<usize>)> {
    let of = |(number, surface): (usize, &ContactSurface)| {
        let nodes = match &surface.against {
            Counterpart::Surface(master) => master.nodes.clone(),
            Counterpart::Obstacle(_) => None,
        };
        nodes.unwrap_or_else(|| mesh.face_nodes(&surface.faces)).into_iter().map(move |node| (node, number))
    };
    if surfaces.len() < 2 {
        return Vec::new();
    }
    let mut named: Vec<(u32, usize)> = surfaces.iter().enumerate().flat_map(of).collect();
    named.sort_unstable();
    named.dedup();
    let meets_surface = |run: &&[(u32, usize)]| {
        run.len() > 1 && run.iter().any(|(_, number)| matches!(surfaces[*number].against, Counterpart::Surface(_)))
    };
    let runs = named.chunk_by(|a, b| a.0 == b.0).filter(meets_surface);
    runs.map(|run| (run[0].0, run.iter().map(|(_, number)| *number).collect())).collect()
}

/// For each surface its place in an order that does not depend on how they are listed: by the first nodes of both sides.
fn places(mesh: &Mesh, surfaces: &[ContactSurface]) -> Vec<usize> {
    let first = |faces: &[u32]| mesh.face_nodes(faces).first().copied();
    let key = |surface: &ContactSurface| match &surface.against {
        Counterpart::Surface(master) => (first(&surface.faces), first(&master.faces)),
        Counterpart::Obstacle(_) => (first(&surface.faces), None),
    };
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    order.sort_by_cached_key(|&number| (key(&surfaces[number]), number));
    let mut places = vec![0; surfaces.len()];
    order.iter().enumerate().for_each(|(place, &number)| places[number] = place);
    places
}

/// An obstacle keeps a node unless something lies in front of it: no neighbour could carry for the node.
fn owner<'c>(
    candidates: &[(usize, &'c Claim)],
    surfaces: &[ContactSurface],
    places: &[usize],
) -> Option<(usize, &'c Claim)> {
    let is_bonded = |number: usize| surfaces[number].friction == SurfaceFriction::Bonded;
    let is_obstacle = |number: usize| matches!(surfaces[number].against, Counterpart::Obstacle(_));
    let bonded = candidates.iter().any(|(number, _)| is_bonded(*number));
    let candidates = || candidates.iter().copied().filter(|(number, _)| is_bonded(*number) == bonded);
    let is_free =
        |claim: &Claim| !candidates().any(|(number, other)| !is_obstacle(number) && other.is_in_front_of(claim));
    let nearer = |a: &(usize, &Claim), b: &(usize, &Claim)| {
        a.1.distance.total_cmp(&b.1.distance).then(places[a.0].cmp(&places[b.0]))
    };
    let obstacle = candidates().filter(|(number, claim)| is_obstacle(*number) && is_free(claim)).min_by(nearer);
    if obstacle.is_some() {
        return obstacle;
    }
    let pairs = || candidates().filter(|(number, _)| !is_obstacle(*number));
    let (_, nearest) = pairs().min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))?;
    let mut as_near: Vec<(usize, &Claim)> = pairs().filter(|(_, claim)| claim.is_as_near_as(nearest)).collect();
    as_near.sort_by_key(|(number, _)| places[*number]);
    let more = |a: &Claim, b: &Claim| a.covered > (1.0 + SAME_AREA) * b.covered;
    as_near.into_iter().reduce(|best, next| if more(next.1, best.1) { next } else { best })
}

/// Of the pairs that `may` change sides those that do: the counterpart of another contact lies under some of the faces with their
/// points, and under those of their other sides none does, nor has another contact the nodes at their edge, without which a body would
/// tip over what is left. All that change do so together, in whatever order they are listed.
pub(crate) fn sides_to_change(
    mesh: &Mesh,
    dofs: &DofMap,
    surfaces: &[ContactSurface],
    may: impl Fn(&ContactSurface) -> bool,
) -> Vec<bool> {
    let shares = |surfaces: &[ContactSurface]| -> Vec<Shares> {
        let claims = Claims::new(mesh, dofs, surfaces, AllMet::default());
        spans(surfaces).iter().map(|span| claims.shares(&span.surfaces)).collect()
    };
    let (mut changing, mut lose_edges) = (vec![false; surfaces.len()], vec![false; surfaces.len()]);
    let mut beside: Vec<[usize; 2]> = Vec::new();
    for share in shares(surfaces) {
        share.without_edge.into_iter().for_each(|number| lose_edges[number] = true);
        beside.extend(share.beside);
    }
    beside.iter().flatten().for_each(|&number| changing[number] = true);
    changing.iter_mut().zip(surfaces).for_each(|(changes, surface)| *changes = *changes && may(surface));
    while changing.contains(&true) {
        let mut changed = surfaces.to_vec();
        let those = changed.iter_mut().zip(&changing).filter(|(_, changes)| **changes);
        those.for_each(|(surface, _)| surface.change_sides());
        let mut stay = vec![false; surfaces.len()];
        for share in shares(&changed) {
            share.beside.into_iter().flatten().for_each(|number| stay[number] = true);
            let loses = share.without_edge.into_iter().filter(|&number| changing[number] && !lose_edges[number]);
            loses.for_each(|number| stay_together(number, &beside, &mut stay));
        }
        if changing.iter().zip(&stay).all(|(changes, stay)| !(*changes && *stay)) {
            break;
        }
        changing.iter_mut().zip(stay).for_each(|(changes, stay)| *changes &= !stay);
    }
    changing
}

/// Marks a surface and all that meet parts of the same faces as these do, one `beside` the other: where one of them changed alone, points would
/// lead around the joint of its body and theirs.
fn stay_together(number: usize, beside: &[[usize; 2]], stay: &mut [bool]) {
    let (mut seen, mut open) = (BTreeSet::from([number]), vec![number]);
    while let Some(number) = open.pop() {
        stay[number] = true;
        let partners = beside.iter().filter(|pair| pair.contains(&number)).flatten();
        open.extend(partners.copied().filter(|&partner| seen.insert(partner)));
    }
}
