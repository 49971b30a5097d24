//! The contact surfaces of an answer on several ranks, both sides of each pair: what a rank knows of their nodes, its piece of the file, and
//! all of it at rank 0.

use std::collections::HashMap;

use super::gather::of_owners;
use super::local::Local;
use super::share::name;
use super::solve::{RankedAnswer, axes, entries};
use super::steps::slid;
use super::tractions::shear as shear_of;
use crate::contact::Friction;
use crate::mesh::v3::{V3, add, scale, sub};
use crate::mesh::{ascending, border};
use crate::ranks::{Wire, gather, put, take};
use crate::run::results::{FIGURES, Side, SurfaceFields};

/// What is known at a node of a surface: pressure, shear, slip, slid, gap, force, status, area, cohesion; the fields of [`SurfaceFields`].
pub(super) type AtNode = [f64; 17];

/// Where each of them, or the first of three, stands.
pub(super) const PRESSURE: usize = 0;
pub(super) const SHEAR: usize = 1;
pub(super) const SLIP: usize = 4;
pub(super) const SLID: usize = 7;
pub(super) const GAP: usize = 10;
pub(super) const FORCE: usize = 11;
pub(super) const STATUS: usize = 14;
const AREA: usize = 15;
pub(super) const COHESION: usize = 16;

/// At a node without a contact point.
const NOTHING: AtNode = {
    let mut of = [f64::NAN; 17];
    (of[FORCE], of[FORCE + 1], of[FORCE + 2], of[STATUS]) = (0.0, 0.0, 0.0, -1.0);
    of
};

/// A surface, as far as it is here.
pub(super) struct SideHere {
    pub pair: usize,
    pub side: Side,
    /// The nodes of each face here.
    pub faces: Vec<Vec<u32>>,
    /// Known at own nodes, and at all nodes of the faces of this rank.
    known: HashMap<u32, AtNode>,
    /// What load steps have done at own nodes, see [`PointHistory::figures`](crate::run::results::PointHistory::figures).
    figures: HashMap<u32, [f64; FIGURES]>,
}

impl SideHere {
    /// What is known at a node here.
    pub(super) fn at(&self, node: u32) -> AtNode {
        self.known.get(&node).copied().unwrap_or(NOTHING)
    }
}

/// The surfaces of each pair, the other one's after that of its points. All ranks ask together.
pub(super) fn sides(answer: &RankedAnswer) -> Vec<SideHere> {
    let mut all = Vec::new();
    for (pair, between_bodies) in answer.local.between_bodies.iter().enumerate() {
        all.push(slave(answer, pair));
        if *between_bodies {
            all.push(master(answer, pair));
        }
    }
    all
}

fn faces(local: &Local, kind: &str, pair: usize) -> Vec<Vec<u32>> {
    let mesh = &local.piece.mesh;
    let faces = mesh.group(&name(kind, pair)).map_or(&[][..], |group| &group.faces);
    faces.iter().map(|&face| mesh.faces[face as usize].nodes().to_vec()).collect()
}

fn slave(answer: &RankedAnswer, pair: usize) -> SideHere {
    let local = &answer.local;
    let (problem, m) = (&local.problem, local.problem.points());
    let (left, slid) = (problem.gap_and_slip(&answer.free), slid(local, &answer.free));
    let points = problem.labels.pairs.get(pair).map_or(0..0, |of| of.points.clone());
    let at_point = |j: usize| {
        let (node, [normal, t1, t2]) = axes(local, j);
        let along = |of: &dyn Fn(usize) -> f64| add(scale(of(0), t1), scale(of(1), t2));
        let (sign, share, traction) = (local.signs[pair], problem.labels.unity_sum[j], answer.tractions[j]);
        let [a, b, c] = scale(sign, shear_of(traction));
        let [d, e, f] = scale(-sign / share, along(&|k| left[(k + 1) * m + j]));
        let [g, h, i] = scale(sign / share, along(&|k| slid[k * m + j]));
        let friction = along(&|k| answer.lambda[(k + 1) * m + j]);
        let [x, y, z] = scale(sign * share, add(scale(answer.lambda[j], normal), friction));
        let status = f64::from(answer.states[j].code());
        let area = problem.labels.area[j];
        let cohesion = match problem.contact.friction[j] {
            Friction::Cohesive { cohesion, .. } => cohesion / area,
            _ => f64::NAN,
        };
        let (gap, pressure) = (left[j] / share, traction[0]);
        (node, [pressure, a, b, c, d, e, f, g, h, i, gap, x, y, z, status, area * share, cohesion])
    };
    let figures = points.clone().filter_map(|j| Some((local.node_of(j), *answer.figures.get(j)?)));
    SideHere {
        pair,
        side: Side::Slave,
        faces: faces(local, "contact", pair),
        figures: figures.collect(),
        known: points.map(at_point).collect(),
    }
}

/// By what its nodes receive, as [`pair_fields`](crate::run::results::surface_fields) has it.
fn master(answer: &RankedAnswer, pair: usize) -> SideHere {
    let local = &answer.local;
    let (problem, sign, areas) = (&local.problem, local.signs[pair], &local.masters[pair]);
    let place = |node: u32| areas.binary_search_by_key(&node, |area| area.node).ok();
    let mut force = vec![[0.0; 3]; areas.len()];
    for j in problem.labels.pairs.get(pair).map_or(0..0, |of| of.points.clone()) {
        let own = local.division.points[j];
        for i in problem.rows(j) {
            for (dof, value) in entries(local, i).filter(|(dof, _)| dof / 3 != own) {
                let Some(at) = place(dof / 3) else { continue };
                let entry = scale(value, local.model.dofs.direction(dof));
                force[at] = sub(force[at], scale(answer.lambda[i], entry));
            }
        }
    }
    let received: HashMap<u32, [f64; 4]> = answer.masters[pair].iter().copied().collect();
    let of_own = |node: u32| {
        let mut known = NOTHING;
        let Some(at) = place(node) else { return known };
        if let Some([pressure, shear @ ..]) = received.get(&node) {
            known[PRESSURE] = *pressure;
            known[SHEAR..SHEAR + 3].copy_from_slice(&shear.map(|shear| 0.0 + sign * shear));
        }
        known[FORCE..FORCE + 3].copy_from_slice(&force[at].map(|force| 0.0 + sign * force));
        known[AREA] = areas[at].area * areas[at].unity_sum();
        known
    };
    let faces = faces(local, "master", pair);
    let nodes = ascending(faces.iter().flatten().copied());
    let known = of_owners(local, &nodes, &of_own);
    let known = nodes.into_iter().zip(known).collect();
    SideHere { pair, side: Side::Master, faces, known, figures: HashMap::new() }
}

/// Appends own nodes of `faces`, by their numbers in the whole, with what is known of them, and those faces whose first node is own.
pub(super) fn put_part<T: Wire>(local: &Local, faces: &[Vec<u32>], known: &dyn Fn(u32) -> T, to: &mut Vec<u8>) {
    let is_own = |v: u32| local.division.is_own(v);
    let number = |v: u32| local.piece.nodes[v as usize];
    let nodes = ascending(faces.iter().flatten().copied().filter(|&v| is_own(v)));
    put(&nodes.iter().map(|&v| number(v)).collect::<Vec<u64>>(), to);
    put(&nodes.iter().map(|&v| known(v)).collect::<Vec<T>>(), to);
    let own = || faces.iter().filter(|nodes| is_own(nodes[0]));
    put(&own().map(|nodes| nodes.len() as u8).collect::<Vec<u8>>(), to);
    put(&own().flatten().map(|&v| number(v)).collect::<Vec<u64>>(), to);
}

/// Numbers of nodes in the whole, ascending, what is known of them, and faces by places among these.
pub(super) type Joined<T> = (Vec<u64>, Vec<T>, Vec<Vec<u32>>);

/// What [`put_part`] has put into the messages of all ranks.
pub(super) fn joined<T: Wire>(from: &mut [&[u8]]) -> Joined<T> {
    let (mut nodes, mut faces): (Vec<(u64, T)>, Vec<Vec<u64>>) = (Vec::new(), Vec::new());
    for message in from {
        let (numbers, known): (Vec<u64>, Vec<T>) = (take(message), take(message));
        nodes.extend(numbers.into_iter().zip(known));
        let (sizes, numbers): (Vec<u8>, Vec<u64>) = (take(message), take(message));
        let mut numbers = numbers.into_iter();
        faces.extend(sizes.iter().map(|&size| numbers.by_ref().take(size.into()).collect()));
    }
    nodes.sort_by_key(|node| node.0);
    let (numbers, known): (Vec<u64>, Vec<T>) = nodes.into_iter().unzip();
    let place = |number: &u64| numbers.partition_point(|other| other < number) as u32;
    let faces = faces.iter().map(|face| face.iter().map(place).collect()).collect();
    (numbers, known, faces)
}

/// The surfaces of all ranks with the figures of their nodes, one after the other, at rank 0.
pub(super) fn gathered(answer: &RankedAnswer, sides: &[SideHere]) -> Option<(Vec<SurfaceFields>, Vec<[f64; FIGURES]>)> {
    let Local { piece, problem, division, .. } = &answer.local;
    let mut message = Vec::new();
    for side in sides {
        let known = |v: u32| {
            let mut sent: Sent = [f64::NAN; 3 + 17 + FIGURES];
            sent[..3].copy_from_slice(&piece.mesh.nodes[v as usize]);
            sent[3..20].copy_from_slice(&side.at(v));
            side.figures.get(&v).iter().for_each(|figures| sent[20..].copy_from_slice(*figures));
            sent
        };
        put_part(&answer.local, &side.faces, &known, &mut message);
    }
    let all = gather(&*division.ranks, message)?;
    let mut from: Vec<&[u8]> = all.iter().map(|message| &message[..]).collect();
    let (mut surfaces, mut figures) = (Vec::new(), Vec::new());
    for &SideHere { pair, side, .. } in sides {
        let (numbers, nodes, faces) = joined::<Sent>(&mut from);
        figures.extend(nodes.iter().map(|node| std::array::from_fn(|k| node[20 + k])));
        let name = problem.labels.pairs.get(pair).map_or("", |pair| &pair.name);
        surfaces.push(fields((pair, side, name), &numbers, &nodes, faces));
    }
    Some((surfaces, figures))
}

/// What is sent of a node: where it is, what is known there, and its figures.
type Sent = [f64; 3 + 17 + FIGURES];

fn fields(
    (pair, side, name): (usize, Side, &str),
    numbers: &[u64],
    nodes: &[Sent],
    faces: Vec<Vec<u32>>,
) -> SurfaceFields {
    let scalars = |place: usize| nodes.iter().map(|node| node[3 + place]).collect::<Vec<f64>>();
    let vectors = |first: usize| nodes.iter().map(|node| [0, 1, 2].map(|c| node[3 + first + c])).collect::<Vec<V3>>();
    SurfaceFields {
        name: name.into(),
        pair,
        side,
        points: nodes.iter().map(|node| [node[0], node[1], node[2]]).collect(),
        borders: faces.iter().map(|nodes| border(nodes)).collect(),
        faces,
        nodes: numbers.iter().map(|&number| number as i32).collect(),
        pressure: scalars(PRESSURE),
        shear: vectors(SHEAR),
        slip: vectors(SLIP),
        slid: vectors(SLID),
        gap: scalars(GAP),
        lambda: vectors(FORCE),
        status: scalars(STATUS).into_iter().map(|status| status as i32).collect(),
        area: scalars(AREA),
        cohesion: scalars(COHESION),
        ..SurfaceFields::default()
    }
}
