//! Contact in the bound: displacements that do not enter the obstacle, tractions that obey the law, and what both miss of
//! each other.
//!
//! On each face openings and slips are polynomials whose Bernstein coefficients bound them: coefficients that are not negative
//! make an opening, and `|sum B c| <= sum B |c|` bounds the length of a slip from above. Tractions are linear, and the law is
//! convex: what holds at the corners holds on the face.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::tets::Tets;
use super::{ContactNode, FlatContact, Limit, NoBound};
use crate::fem::DofMap;
use crate::linalg::symmetric_eigen;
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};

/// Openings and slips below this part of the largest displacement, and pressures below this part of the largest, are what a
/// solver leaves of none. They enter the bound by their square root, so that rounding would be seen.
const ROUNDING: f64 = 1e-8;
/// A friction force that differs from its limit along the slip by less than this part is at the limit.
const AT_LIMIT: f64 = 1e-6;
/// Part of the normal that has to be free to move where a node is moved out of its obstacle.
const FREE: f64 = 0.1;

/// A contact surface with displacements and tractions.
pub(super) struct Surface<'a> {
    contact: &'a FlatContact,
    /// Its faces by their numbers among all faces.
    pub faces: Vec<u32>,
    /// Of each node of the surface.
    opening: HashMap<u32, f64>,
    slip: HashMap<u32, V3>,
    /// At the corners: pressure, shear on the obstacle, largest shear; force per area.
    pub tractions: Vec<(u32, Traction)>,
    /// At the corners of faces that have tractions of their own.
    of_faces: HashMap<u32, [Traction; 3]>,
}

/// A closed face on which contact tractions may change.
#[derive(Clone)]
pub(super) struct Bearing {
    /// Its number among all faces.
    pub face: u32,
    /// Unit vectors: the normal, or three with which the shear is free as well.
    pub directions: Vec<V3>,
    normal: V3,
    area: f64,
    limits: [Limit; 3],
}

impl Bearing {
    /// How much of a change of its tractions times area the law lets through; infinite if it never ends it.
    pub(super) fn reach(&self, tractions: &[V3; 3], change: &[f64; 9]) -> f64 {
        let of_corner = |(a, limit): (usize, &Limit)| {
            // On the obstacle, times area.
            let (now, more) = (scale(-1.0, tractions[a]), [3 * a, 3 * a + 1, 3 * a + 2].map(|k| -change[k]));
            let [pressure, growth] = [now, more].map(|v| dot(v, self.normal));
            let until = |room: f64, taken: f64| if taken > 0.0 { room.max(0.0) / taken } else { f64::INFINITY };
            let lifted = until(pressure, -growth);
            if self.directions.len() < 3 {
                return lifted;
            }
            let [shear, turn] = [(now, pressure), (more, growth)].map(|(v, n)| norm(sub(v, scale(n, self.normal))));
            let slips = match *limit {
                Limit::None => 0.0,
                Limit::Given(most) => until(most * self.area - shear, turn),
                Limit::Coulomb(f) => until(f * pressure - shear, turn - f * growth),
                Limit::Limited { coefficient: f, most } => {
                    until(most * self.area - shear, turn).min(until(f * pressure - shear, turn - f * growth))
                }
            };
            lifted.min(slips)
        };
        self.limits.iter().enumerate().map(of_corner).fold(f64::INFINITY, f64::min)
    }
}

/// What a body exerts on its obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Traction {
    pub pressure: f64,
    pub shear: V3,
    pub limit: f64,
}

impl<'a> Surface<'a> {
    /// Moves nodes of `v` out of the obstacle, as far as they are in it, and to where solvers leave rounding only.
    pub(super) fn new(
        tets: &Tets,
        dofs: &DofMap,
        contact: &'a FlatContact,
        faces: Vec<u32>,
        v: &mut [f64],
    ) -> Result<Self, NoBound> {
        let small = ROUNDING * v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let mut surface = Surface {
            contact,
            faces,
            opening: HashMap::new(),
            slip: HashMap::new(),
            tractions: Vec::new(),
            of_faces: HashMap::new(),
        };
        let corners = tets.corners_of(surface.faces.iter().copied());
        let references: HashMap<u32, V3> = contact.nodes.iter().map(|node| (node.node, node.reference)).collect();
        let slides = contact.nodes.iter().any(|node| node.limit != Limit::None);
        let place = |node: u32| tets.mesh().nodes[node as usize];
        let middles = surface.middles(tets);
        let ends = |node: u32| middles.get(&node).copied();
        let mut all: Vec<u32> = middles.keys().copied().collect();
        all.sort_unstable();
        for node in corners.iter().copied().chain(all) {
            let at = |v: &[f64]| -> V3 { std::array::from_fn(|c| v[3 * node as usize + c]) };
            // Of a middle the coefficient: twice its own less half of both ends.
            let mean = |of: &dyn Fn(u32) -> f64| ends(node).map_or(0.0, |[a, b]| 0.25 * (of(a) + of(b)));
            let least = mean(&|end| surface.opening[&end]);
            let opening = contact.offset - dot(contact.normal, add(place(node), at(v)));
            let kept = if opening - least <= small { least } else { opening };
            if kept != opening {
                move_node(dofs, node, scale(opening - kept, contact.normal), v)
                    .ok_or(NoBound::Overlap { node, depth: kept - opening })?;
            }
            surface.opening.insert(node, kept);
            if !slides {
                continue;
            }
            let reference = references.get(&node).copied().unwrap_or([0.0; 3]);
            let slip = surface.tangential(sub(at(v), reference));
            let least: V3 = std::array::from_fn(|c| mean(&|end| surface.slip[&end][c]));
            let kept = if norm(sub(slip, least)) <= small { least } else { slip };
            if kept != slip {
                // What is held already stays: there it does not slip.
                let _ = move_node(dofs, node, sub(kept, slip), v);
            }
            surface.slip.insert(node, kept);
        }
        Ok(surface)
    }

    /// The nodes in the middles of edges with the ends of these; none of linear cells.
    fn middles(&self, tets: &Tets) -> HashMap<u32, [u32; 2]> {
        let of_face = |&face: &u32| {
            let [a, b, c] = tets.faces[face as usize];
            tets.middles_of(face).into_iter().zip([[b, c], [a, c], [a, b]])
        };
        if tets.quadratic() { self.faces.iter().flat_map(of_face).collect() } else { HashMap::new() }
    }

    /// All its nodes.
    pub(super) fn nodes(&self, tets: &Tets) -> Vec<u32> {
        let corners = tets.corners_of(self.faces.iter().copied());
        corners.into_iter().chain(self.middles(tets).into_keys()).collect()
    }

    fn tangential(&self, v: V3) -> V3 {
        sub(v, scale(dot(v, self.contact.normal), self.contact.normal))
    }

    /// Whether nodes that several surfaces share are still where this one needs them.
    pub(super) fn still_open(&self, tets: &Tets, v: &[f64]) -> bool {
        let size = v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        self.opening.iter().all(|(&node, &opening)| {
            let x = tets.mesh().nodes[node as usize];
            let u: V3 = std::array::from_fn(|c| v[3 * node as usize + c]);
            let rounding = 1e-14 * (norm(x) + self.contact.offset.abs()) + 1e-12 * size;
            (self.contact.offset - dot(self.contact.normal, add(x, u)) - opening).abs() <= rounding
        })
    }

    /// Tractions at the corners from the forces of the nodes, within the law.
    ///
    /// The force of a middle goes to both ends of its edge, and its normal part wholly to the closed one where the other is
    /// open, with the shear if that is limited by the pressure; over the integral of the function of the corner it is a traction. Corners without a contact point are held: there
    /// tractions are continued from the corners around.
    pub(super) fn find_tractions(&mut self, tets: &Tets) {
        let corners = tets.corners_of(self.faces.iter().copied());
        let mut area: HashMap<u32, f64> = HashMap::new();
        for &face in &self.faces {
            let part = tets.area(face) / 3.0;
            tets.faces[face as usize].iter().for_each(|&node| *area.entry(node).or_default() += part);
        }
        let middles = self.middles(tets);
        let mut force: HashMap<u32, [V3; 2]> = HashMap::new();
        let mut give = |node: u32, normal: V3, tangential: V3| {
            let [n, t] = force.entry(node).or_default();
            (*n, *t) = (add(*n, normal), add(*t, tangential));
        };
        let mut known: HashSet<u32> = HashSet::new();
        for node in &self.contact.nodes {
            let Some(whole) = node.force else { continue };
            known.insert(node.node);
            let tangential = self.tangential(whole);
            let normal = sub(whole, tangential);
            let Some(ends) = middles.get(&node.node) else {
                give(node.node, normal, tangential);
                continue;
            };
            let closed = ends.map(|end| self.opening[&end] == 0.0);
            let parts = match closed {
                [true, false] => [1.0, 0.0],
                [false, true] => [0.0, 1.0],
                _ => [0.5, 0.5],
            };
            // Shear goes where its limit does.
            let with_pressure = matches!(node.limit, Limit::Coulomb(_) | Limit::Limited { .. });
            let of_shear = if with_pressure { parts } else { [0.5, 0.5] };
            (0..2).for_each(|e| give(ends[e], scale(parts[e], normal), scale(of_shear[e], tangential)));
        }
        let limits: HashMap<u32, Limit> = self.contact.nodes.iter().map(|node| (node.node, node.limit)).collect();
        let found = corners.iter().map(|&node| {
            let [n, t] = force.get(&node).copied().unwrap_or_default();
            let area = area[&node];
            (node, dot(n, self.contact.normal).max(0.0) / area, scale(1.0 / area, t))
        });
        let mut found: Vec<(u32, f64, V3)> = found.collect();
        self.continue_to_supports(tets, &mut found, known);
        let most = found.iter().map(|found| found.1).fold(0.0, f64::max);
        self.tractions = found
            .into_iter()
            .map(|(node, pressure, shear)| {
                let open = self.opening[&node] > 0.0 && pressure <= ROUNDING * most;
                let pressure = if open { 0.0 } else { pressure };
                let limit = limits.get(&node).copied().unwrap_or(Limit::None).at(pressure);
                (node, Traction { pressure, shear: self.within(node, shear, limit), limit })
            })
            .collect();
    }

    /// Where supports take the forces, tractions are free: the mean of the corners around goes on as smoothly as is known.
    fn continue_to_supports(&self, tets: &Tets, tractions: &mut [(u32, f64, V3)], mut known: HashSet<u32>) {
        loop {
            let mut sums: BTreeMap<u32, (f64, f64, V3)> = BTreeMap::new();
            for &face in &self.faces {
                let nodes = tets.faces[face as usize];
                let pairs = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| (a, b)));
                for (unknown, other) in pairs.filter(|(a, b)| !known.contains(a) && known.contains(b)) {
                    let place = tractions.partition_point(|(node, ..)| *node < other);
                    let (_, pressure, shear) = tractions[place];
                    let sum = sums.entry(unknown).or_default();
                    *sum = (sum.0 + 1.0, sum.1 + pressure, add(sum.2, shear));
                }
            }
            if sums.is_empty() {
                return;
            }
            for (node, (count, pressure, shear)) in sums {
                let place = tractions.partition_point(|(other, ..)| *other < node);
                tractions[place] = (node, pressure / count, scale(1.0 / count, shear));
                known.insert(node);
            }
        }
    }

    /// A shear within its limit, at the limit and along the slip where it is so but for rounding.
    fn within(&self, node: u32, shear: V3, limit: f64) -> V3 {
        let slip = self.slip.get(&node).copied().unwrap_or_default();
        let length = norm(slip);
        if length > 0.0 {
            let along = scale(limit / length, slip);
            if norm(sub(shear, along)) <= AT_LIMIT * limit {
                return along;
            }
        }
        let size = norm(shear);
        // A little below, so that rounding does not leave the law.
        if size > limit { scale(limit / size * (1.0 - f64::EPSILON), shear) } else { shear }
    }

    /// The force per area of the body on its obstacle at a corner.
    pub(super) fn on_obstacle(&self, node: u32) -> V3 {
        let at = self.at(node);
        add(scale(at.pressure, self.contact.normal), at.shear)
    }

    /// Adds the forces of the tractions on the nodes of the body.
    pub(super) fn add_forces(&self, tets: &Tets, forces: &mut [f64]) {
        self.add_forces_of(tets, forces, |node| self.on_obstacle(node));
    }

    fn add_forces_of(&self, tets: &Tets, forces: &mut [f64], on_obstacle: impl Fn(u32) -> V3) {
        for &face in &self.faces {
            let area = tets.area(face);
            let on_body = tets.faces[face as usize].map(|node| scale(-area, on_obstacle(node)));
            tets.add_traction(face, &on_body, forces);
        }
    }

    /// How tractions change with a motion: the pressure times its parts along the normal and, with friction, the surface.
    fn change(&self, (node, traction): &(u32, Traction), motion: &[f64]) -> V3 {
        let r: V3 = std::array::from_fn(|c| motion[3 * *node as usize + c]);
        let normal = scale(dot(r, self.contact.normal), self.contact.normal);
        scale(traction.pressure, if traction.limit > 0.0 { r } else { normal })
    }

    /// Adds to the tractions, within the law.
    fn add_changes(&mut self, motions: &[Vec<f64>], factors: &[f64]) {
        let limits: HashMap<u32, Limit> = self.contact.nodes.iter().map(|node| (node.node, node.limit)).collect();
        let old = std::mem::take(&mut self.tractions);
        let changed = old.iter().map(|of| {
            let change = motions
                .iter()
                .zip(factors)
                .fold([0.0; 3], |sum, (motion, &factor)| add(sum, scale(factor, self.change(of, motion))));
            let (node, traction) = *of;
            let pressure = (traction.pressure + dot(change, self.contact.normal)).max(0.0);
            let limit = limits.get(&node).copied().unwrap_or(Limit::None).at(pressure);
            let shear = self.within(node, add(traction.shear, self.tangential(change)), limit);
            (node, Traction { pressure, shear, limit })
        });
        self.tractions = changed.collect();
    }

    /// Unit normal towards the obstacle, and where it is.
    pub(super) fn plane(&self) -> (V3, f64) {
        (self.contact.normal, self.contact.offset)
    }

    /// How much shear friction allows at a node.
    pub(super) fn limit(&self, node: u32) -> Limit {
        self.node(node).map_or(Limit::None, |own| own.limit)
    }

    /// Opening and slip of a node, and the displacement that is no slip.
    pub(super) fn kinematics(&self, node: u32) -> (f64, V3, V3) {
        let opening = self.opening.get(&node).copied().unwrap_or_default();
        let slip = self.slip.get(&node).copied().unwrap_or_default();
        (opening, slip, self.node(node).map_or([0.0; 3], |own| own.reference))
    }

    fn node(&self, node: u32) -> Option<&ContactNode> {
        let place = self.contact.nodes.binary_search_by_key(&node, |own| own.node).ok();
        place.map(|place| &self.contact.nodes[place])
    }

    /// Closed faces whose tractions may change: no term of the bound has them, as nothing is open, and where shears are free
    /// nothing slips.
    pub(super) fn bearings(&self, tets: &Tets) -> Vec<Bearing> {
        let of_face = |&face: &u32| {
            let corners = tets.faces[face as usize];
            let middles = if tets.quadratic() { tets.middles_of(face).to_vec() } else { Vec::new() };
            let nodes = || corners.iter().chain(&middles);
            let at = corners.map(|node| self.at(node));
            let slips = nodes().any(|node| self.slip.get(node).is_some_and(|&slip| slip != [0.0; 3]));
            if nodes().any(|node| self.opening[node] != 0.0) || at.iter().any(|at| at.pressure <= 0.0) {
                return None;
            }
            let limits = corners.map(|node| self.limit(node));
            let with_pressure = |at: &Traction, limit: &Limit| {
                matches!(limit, Limit::Coulomb(_) | Limit::Limited { .. }) && at.limit > 0.0
            };
            let sticks = !slips && at.iter().all(|at| norm(at.shear) < at.limit);
            let n = self.contact.normal;
            let directions = match sticks {
                true => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                false if at.iter().zip(&limits).any(|(at, limit)| with_pressure(at, limit)) => return None,
                false => vec![n],
            };
            Some(Bearing { face, directions, normal: n, area: tets.area(face), limits })
        };
        self.faces.iter().filter_map(of_face).collect()
    }

    /// Takes over the tractions times area of a face.
    pub(super) fn take(&mut self, tets: &Tets, bearing: &Bearing, tractions: &[V3; 3]) {
        let corners = tets.faces[bearing.face as usize];
        let of_corner = |a: usize| {
            let on_obstacle = scale(-1.0 / bearing.area, tractions[a]);
            let pressure = dot(on_obstacle, bearing.normal).max(0.0);
            let limit = bearing.limits[a].at(pressure);
            let shear = match bearing.directions.len() {
                3 => self.within(corners[a], self.tangential(on_obstacle), limit),
                _ => self.at(corners[a]).shear,
            };
            Traction { pressure, shear, limit }
        };
        self.of_faces.insert(bearing.face, std::array::from_fn(of_corner));
    }

    /// The tractions at the corners of a face.
    pub(super) fn on_face(&self, tets: &Tets, face: u32) -> [Traction; 3] {
        let of_corners = || tets.faces[face as usize].map(|node| self.at(node));
        self.of_faces.get(&face).copied().unwrap_or_else(of_corners)
    }

    fn at(&self, node: u32) -> Traction {
        let place = self.tractions.partition_point(|(other, _)| *other < node);
        self.tractions.get(place).map_or(Traction::default(), |found| found.1)
    }

    /// `∫ p (g - v_n)`, `∫ (s |slip| - q·slip)` and `∫ s |slip|`, the lengths of slips bounded from above; energies.
    pub(super) fn gaps(&self, tets: &Tets) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for &face in &self.faces {
            let nodes = tets.faces[face as usize];
            let area = tets.area(face);
            let tractions = self.on_face(tets, face);
            let mut take = |a: usize, weight: f64, opening: f64, slip: V3| {
                let Traction { pressure, shear, limit } = tractions[a];
                let work = limit * norm(slip);
                let part = [pressure * opening.max(0.0), (work - dot(shear, slip)).max(0.0), work];
                (0..3).for_each(|k| sums[k] += area * weight * part[k]);
            };
            let slip = |node: u32| self.slip.get(&node).copied().unwrap_or_default();
            let middles = tets.quadratic().then(|| tets.middles_of(face));
            for a in 0..3 {
                for b in 0..3 {
                    let weight = match (tets.quadratic(), a == b) {
                        (false, true) => 1.0 / 6.0,
                        (false, false) => 1.0 / 12.0,
                        (true, true) => 0.1,
                        (true, false) => 1.0 / 30.0,
                    };
                    take(a, weight, self.opening[&nodes[b]], slip(nodes[b]));
                    let Some(middle) = middles.map(|middles| middles[b]) else { continue };
                    // The edge across from corner b.
                    let [p, q] = [(b + 1) % 3, (b + 2) % 3].map(|end| nodes[end]);
                    let opening = 2.0 * self.opening[&middle] - 0.5 * (self.opening[&p] + self.opening[&q]);
                    let bulge = sub(scale(2.0, slip(middle)), scale(0.5, add(slip(p), slip(q))));
                    take(a, if a == b { 1.0 / 30.0 } else { 1.0 / 15.0 }, opening, bulge);
                }
            }
        }
        sums
    }
}

/// Rounds of balancing at most: the law may take back what one adds.
const ROUNDS: usize = 20;
/// What may be left of the work of all forces on a motion, as part of the sum of its terms.
const BALANCED: f64 = 1e-13;
/// The same where no further round makes it less.
const NEARLY_BALANCED: f64 = 1e-10;
/// Motions whose tractions have less than this part of the largest work are resisted by none.
const NOT_RESISTED: f64 = 1e-9;

/// Changes the tractions so that they balance the loads on motions that nothing else resists.
pub(super) fn balance(
    tets: &Tets,
    surfaces: &mut [Surface],
    motions: &[Vec<f64>],
    outer: &[f64],
) -> Result<(), NoBound> {
    let work = |forces: &[f64], motion: &[f64]| forces.iter().zip(motion).map(|(f, r)| f * r).sum::<f64>();
    let mut last = f64::INFINITY;
    for _ in 0..ROUNDS {
        let mut forces = vec![0.0; outer.len()];
        surfaces.iter().for_each(|surface| surface.add_forces(tets, &mut forces));
        let size = |motion: &Vec<f64>| {
            let of = |forces: &[f64]| forces.iter().zip(motion).map(|(f, r)| (f * r).abs()).sum::<f64>();
            of(outer) + of(&forces)
        };
        let sizes: Vec<f64> = motions.iter().map(size).collect();
        let rest: Vec<f64> = motions.iter().map(|motion| work(outer, motion) + work(&forces, motion)).collect();
        let off =
            rest.iter().zip(&sizes).map(|(rest, size)| rest.abs() / size.max(f64::MIN_POSITIVE)).fold(0.0, f64::max);
        if off <= BALANCED || (off <= NEARLY_BALANCED && off >= last) {
            return Ok(());
        }
        last = off;
        // The work of the change with each motion on all others.
        let of_changes = |motion: &Vec<f64>| {
            let mut forces = vec![0.0; outer.len()];
            for surface in surfaces.iter() {
                let at = |node: u32| {
                    let place = surface.tractions.partition_point(|(other, _)| *other < node);
                    surface.tractions.get(place).map_or([0.0; 3], |of| surface.change(of, motion))
                };
                surface.add_forces_of(tets, &mut forces, at);
            }
            motions.iter().map(|other| -work(&forces, other)).collect::<Vec<f64>>()
        };
        let matrix: Vec<Vec<f64>> = motions.iter().map(of_changes).collect();
        let (values, vectors) = symmetric_eigen(&matrix);
        let largest = values.iter().copied().fold(0.0, f64::max);
        let mut factors = vec![0.0; motions.len()];
        for (value, vector) in values.iter().zip(&vectors).filter(|(value, _)| **value > NOT_RESISTED * largest) {
            let part = vector.iter().zip(&rest).map(|(v, r)| v * r).sum::<f64>() / value;
            factors.iter_mut().zip(vector).for_each(|(factor, v)| *factor += part * v);
        }
        surfaces.iter_mut().for_each(|surface| surface.add_changes(motions, &factors));
    }
    if motions.is_empty() { Ok(()) } else { Err(NoBound::Floating) }
}

/// Moves a node by `by` along what is free of it; `None` if too little is.
fn move_node(dofs: &DofMap, node: u32, by: V3, v: &mut [f64]) -> Option<()> {
    let mut components = dofs.components(node, by);
    for (c, component) in components.iter_mut().enumerate() {
        if dofs.unknown[3 * node as usize + c] == u32::MAX {
            *component = 0.0;
        }
    }
    let free = dofs.vector(node, components);
    let part = dot(free, by) / dot(by, by);
    if part.is_nan() || part < FREE {
        return None;
    }
    (0..3).for_each(|c| v[3 * node as usize + c] += free[c] / part);
    Some(())
}
