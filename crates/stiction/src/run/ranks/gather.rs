//! An answer of the whole mesh, as rank 0 has it: gathered from the ranks, or found by rank 0 and handed out to them. Points go by
//! their surface and their node.

use std::collections::HashMap;

use super::local::Local;
use super::solve::Everywhere;
use crate::contact::{Contact, Friction};
use crate::fem::full_displacement;
use crate::friction::{PointState, Solution};
use crate::mesh::v3::V3;
use crate::ranks::{Ranks, Wire, all_to_all, from_bytes, gather, put, take, to_bytes};
use crate::run::pose::Prepared;
use crate::run::solve::Outcome;

/// What is known of a contact point.
#[derive(Debug, Clone, Copy)]
struct Point {
    state: PointState,
    /// Multipliers, newton.
    lambda: [f64; 3],
    /// Slip reference and gap, length.
    reference: [f64; 2],
    gap: f64,
    law: [f64; 4],
}

/// The displacements of all nodes, and what is known of all points.
#[derive(Debug, Clone, Default)]
pub(super) struct WholeAnswer {
    /// Along x, y, z, length.
    pub u: Vec<V3>,
    /// Of each bolt, length.
    pub shortening: Vec<f64>,
    points: HashMap<[u64; 2], Point>,
}

/// What of an answer the points of one problem have, in their order; `3m` and `2m` numbers of multipliers and slip references.
pub(super) struct AtPoints {
    pub lambda: Vec<f64>,
    pub states: Vec<PointState>,
    slip_reference: Vec<f64>,
    gap: Vec<f64>,
    friction: Vec<Friction>,
}

impl AtPoints {
    /// Puts what acts at the points into a problem.
    pub(super) fn put_into(&mut self, contact: &mut Contact) {
        // They are states of the last step where points take part in some steps only, or lose their strength.
        contact.slip_reference = std::mem::take(&mut self.slip_reference);
        contact.gap = std::mem::take(&mut self.gap);
        contact.friction = std::mem::take(&mut self.friction);
    }
}

impl WholeAnswer {
    /// That of a problem that is posed on the whole mesh.
    pub(super) fn of_outcome(prepared: &Prepared, outcome: &Outcome) -> Self {
        Self::of_solution(prepared, &outcome.solution)
    }

    /// Another one of the same problem.
    pub(super) fn of_solution(prepared: &Prepared, solution: &Solution) -> Self {
        let contact = &prepared.problem.contact;
        let all = full_displacement(&prepared.model, &solution.u);
        let point = |(j, name)| (name, point(contact, &solution.lambda, solution.states[j], j));
        WholeAnswer {
            u: all.as_chunks().0[..prepared.mesh.nodes.len()].to_vec(),
            shortening: prepared.loading.initial.shortening.clone(),
            points: names(prepared).enumerate().map(point).collect(),
        }
    }

    /// That of all ranks, at rank 0.
    pub(super) fn gathered(local: &Local, here: &Everywhere, shortening: &[f64]) -> Option<Self> {
        let (division, contact) = (&local.division, &local.problem.contact);
        let own = (0..here.u.len()).filter(|&v| division.is_own(v as u32));
        let (nodes, u): (Vec<u64>, Vec<V3>) = own.map(|v| (local.piece.nodes[v], here.u[v])).unzip();
        let mut message = Vec::new();
        put(&nodes, &mut message);
        put(&u, &mut message);
        let points: Vec<usize> = (0..local.problem.points()).filter(|&j| division.is_own(division.points[j])).collect();
        let of = |&j: &usize| (local.name_of(j), point(contact, &here.lambda, here.states[j], j));
        put_points(points.iter().map(of), &mut message);
        let all = gather(&*division.ranks, message)?;
        let mut whole = WholeAnswer {
            u: vec![[0.0; 3]; local.sizes[0] as usize],
            shortening: shortening.to_vec(),
            points: HashMap::new(),
        };
        for message in all {
            let mut from = &message[..];
            let (nodes, u): (Vec<u64>, Vec<V3>) = (take(&mut from), take(&mut from));
            nodes.iter().zip(u).for_each(|(&node, u)| whole.u[node as usize] = u);
            whole.points.extend(take_points(&mut from));
        }
        Some(whole)
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut message = Vec::new();
        put(&self.u, &mut message);
        put(&self.shortening, &mut message);
        put_points(self.points.iter().map(|(name, point)| (*name, *point)), &mut message);
        message
    }

    pub(super) fn take(from: &mut &[u8]) -> Self {
        let (u, shortening) = (take(from), take(from));
        WholeAnswer { u, shortening, points: take_points(from).collect() }
    }

    /// What of it the points of a rank have; `None` if one of them is not known.
    pub(super) fn at_points_of(&self, local: &Local) -> Option<AtPoints> {
        self.at_points((0..local.problem.points()).map(|j| local.name_of(j)), local.problem.points())
    }

    /// The same of a problem that is posed on the whole mesh.
    pub(super) fn at_points_of_whole(&self, prepared: &Prepared) -> Option<AtPoints> {
        self.at_points(names(prepared), prepared.problem.points())
    }

    fn at_points(&self, names: impl Iterator<Item = [u64; 2]>, count: usize) -> Option<AtPoints> {
        let points: Vec<&Point> = names.map_while(|name| self.points.get(&name)).collect();
        (points.len() == count).then(|| AtPoints {
            lambda: (0..3).flat_map(|r| points.iter().map(move |point| point.lambda[r])).collect(),
            states: points.iter().map(|point| point.state).collect(),
            slip_reference: (0..2).flat_map(|r| points.iter().map(move |point| point.reference[r])).collect(),
            gap: points.iter().map(|point| point.gap).collect(),
            friction: points.iter().map(|point| Friction::of_numbers(point.law)).collect(),
        })
    }
}

impl Local {
    /// The name that point `j` has on all ranks: its surface and its node.
    fn name_of(&self, j: usize) -> [u64; 2] {
        [self.pair_of(j) as u64, self.piece.nodes[self.node_of(j) as usize]]
    }
}

/// The names of the points of a problem on the whole mesh: those of ties are the last.
fn names(prepared: &Prepared) -> impl Iterator<Item = [u64; 2]> + '_ {
    let contacts = prepared.facts.contacts.iter().map(|contact| &contact.surface.nodes[..]);
    let pairs = contacts.chain([prepared.loading.ties.nodes()]).enumerate();
    pairs.flat_map(|(k, nodes)| nodes.iter().map(move |&node| [k as u64, node.into()]))
}

fn point(contact: &Contact, lambda: &[f64], state: PointState, j: usize) -> Point {
    let m = contact.gap.len();
    Point {
        state,
        lambda: [0, 1, 2].map(|r| lambda[r * m + j]),
        reference: [0, 1].map(|r| contact.slip_reference[r * m + j]),
        gap: contact.gap[j],
        law: contact.friction[j].numbers(),
    }
}

fn put_points(points: impl Iterator<Item = ([u64; 2], Point)>, to: &mut Vec<u8>) {
    let numbers = |point: Point| {
        let ([l, a, b], [s, t], [k, c, d, e]) = (point.lambda, point.reference, point.law);
        [l, a, b, s, t, point.gap, k, c, d, e]
    };
    let (names, numbers): (Vec<[u64; 3]>, Vec<[f64; 10]>) =
        points.map(|([surface, node], point)| ([surface, node, u64::from(point.state.code())], numbers(point))).unzip();
    put(&names, to);
    put(&numbers, to);
}

fn take_points(from: &mut &[u8]) -> impl Iterator<Item = ([u64; 2], Point)> {
    let (names, numbers): (Vec<[u64; 3]>, Vec<[f64; 10]>) = (take(from), take(from));
    let point = |([surface, node, code], [l, a, b, s, t, gap, k, c, d, e]): ([u64; 3], [f64; 10])| {
        let state = PointState::of_code(code as usize).unwrap_or(PointState::Open);
        ([surface, node], Point { state, lambda: [l, a, b], reference: [s, t], gap, law: [k, c, d, e] })
    };
    names.into_iter().zip(numbers).map(point)
}

/// Of a list that rank 0 has the entries `wanted` here.
pub(super) fn scattered<T: Wire>(ranks: &dyn Ranks, wanted: &[u64], list: &[T]) -> Vec<T> {
    let of = |wanted: &[u64]| wanted.iter().map(|&number| list[number as usize]).collect::<Vec<T>>();
    if ranks.rank() > 0 {
        let mut message = Vec::new();
        put(wanted, &mut message);
        ranks.exchange(vec![(0, message)], &[]);
        return take(&mut &ranks.exchange(Vec::new(), &[0]).swap_remove(0)[..]);
    }
    for rank in 1..ranks.size() {
        let asked = ranks.exchange(Vec::new(), &[rank]).swap_remove(0);
        let mut message = Vec::new();
        put(&of(&take::<u64>(&mut &asked[..])), &mut message);
        ranks.exchange(vec![(rank, message)], &[]);
    }
    of(wanted)
}

/// What the owners of nodes here know of them; `own` says it of own nodes. All ranks ask together.
pub(super) fn of_owners<T: Wire>(local: &Local, nodes: &[u32], own: &dyn Fn(u32) -> T) -> Vec<T> {
    let (piece, ranks) = (&local.piece, &*local.division.ranks);
    let owner = |node: u32| piece.owner[node as usize] as usize;
    let mut asked: Vec<(Vec<usize>, Vec<u64>)> = vec![Default::default(); ranks.size()];
    for (place, &node) in nodes.iter().enumerate().filter(|(_, node)| owner(**node) != ranks.rank()) {
        let (places, numbers) = &mut asked[owner(node)];
        places.push(place);
        numbers.push(piece.nodes[node as usize]);
    }
    let questions = asked.iter().map(|(_, numbers)| to_bytes(numbers)).collect();
    let answer = |numbers: &Vec<u8>| {
        let of = |number: u64| own(piece.nodes.partition_point(|&other| other < number) as u32);
        to_bytes(&from_bytes(numbers).into_iter().map(of).collect::<Vec<T>>())
    };
    let answers = all_to_all(ranks, questions).iter().map(answer).collect();
    // Those of other ranks are filled in below.
    let mut all: Vec<T> = nodes.iter().map(|&node| own(node)).collect();
    for ((places, _), found) in asked.into_iter().zip(all_to_all(ranks, answers)) {
        places.into_iter().zip(from_bytes(&found)).for_each(|(place, value)| all[place] = value);
    }
    all
}

/// What rank 0 answers this rank, where `answer` makes of the messages of all ranks one for each.
pub(super) fn answered_by_first(
    ranks: &dyn Ranks,
    message: Vec<u8>,
    answer: impl FnOnce(&[Vec<u8>]) -> Vec<Vec<u8>>,
) -> Vec<u8> {
    match gather(ranks, message) {
        None => ranks.exchange(Vec::new(), &[0]).swap_remove(0),
        Some(messages) => {
            let mut replies = answer(&messages);
            let own = replies.remove(0);
            ranks.exchange(replies.into_iter().zip(1..).map(|(reply, rank)| (rank, reply)).collect(), &[]);
            own
        }
    }
}
