//! The contact points of a whole mesh, for problems on pieces of it.

use std::collections::BTreeMap;
use std::ops::Range;

use rustc_hash::FxHashMap;

use super::meeting::AllMet;
use super::points::Point;
use super::rows::all_points;
use super::{ContactSurface, Friction, InterfaceStiffness, Pair, SurfaceFacts};
use crate::Error;
use crate::fem::DofMap;
use crate::mesh::{Mesh, ascending, beside};
use crate::ranks::{put, take};

/// The contact points of some surfaces: one after the other, with the name of each surface and where its points are.
pub(crate) struct PosedPoints {
    pub(super) points: Vec<Point>,
    pub(super) pairs: Vec<Pair>,
    /// The number of each point in the whole.
    numbers: Vec<u64>,
}

/// Points between more bodies than so many are not followed: middles of edges are measured from their ends, and these from another
/// body.
const LONGEST_CHAIN: usize = 8;

/// A node and its numbers: gap, area, orthotropy, partition of unity, frame, normal, the law, the stiffness (0 of hard contact).
type Numbers = [f64; 22];

impl PosedPoints {
    /// The points of these surfaces on a mesh whose prescribed displacements are those of `dofs`; of the mesh nodes and faces
    /// are read. What faces meet is found unless it is `known`.
    ///
    /// # Errors
    /// As of [`pose`](super::pose()).
    pub(crate) fn new(
        mesh: &Mesh,
        dofs: &DofMap,
        surfaces: &[ContactSurface],
        known: AllMet,
    ) -> Result<(PosedPoints, Vec<SurfaceFacts>), Error> {
        let (points, facts) = all_points(mesh, dofs, surfaces, known)?;
        let mut first = 0;
        let pair = |facts: &SurfaceFacts| {
            first += facts.points;
            Pair { name: facts.name.clone(), points: first - facts.points..first }
        };
        let pairs = facts.iter().map(pair).collect();
        let numbers = (0..points.len() as u64).collect();
        Ok((PosedPoints { points, pairs, numbers }, facts))
    }

    /// The node of each point.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.points.iter().map(|point| point.node)
    }

    /// For each point the label of the node at which its rows of `B` begin: its own, or where the interface yields that of a layer, whose
    /// labels follow on `first`.
    pub(crate) fn labels(&self, first: usize) -> Vec<u32> {
        let mut layers = first as u32..;
        let label = |point: &Point| point.stiffness.and_then(|_| layers.next()).unwrap_or(point.node);
        self.points.iter().map(label).collect()
    }

    /// The numbers of the points that have a layer among all in the whole.
    pub(crate) fn layers(&self) -> Vec<u64> {
        let yields = self.points.iter().zip(&self.numbers).filter(|(point, _)| point.stiffness.is_some());
        yields.map(|(_, number)| *number).collect()
    }

    /// The gap of each point before anything is prescribed, length.
    pub(crate) fn gaps(&self) -> Vec<f64> {
        self.points.iter().map(|point| point.gap).collect()
    }

    /// The node of each point whose jump is measured from other nodes, and then these.
    pub(crate) fn links(&self) -> Vec<Vec<u32>> {
        // The row of `K` of a node with a layer has the springs of the layer, and is complete where the point there is known.
        let with_layer = self.points.iter().filter(|point| point.stiffness.is_some()).map(|point| (point.node, point));
        let with_layer: FxHashMap<u32, &Point> = with_layer.collect();
        let beyond = |node: u32| with_layer.get(&node).into_iter().flat_map(|point| point.others.iter().map(|it| it.0));
        let linked = self.points.iter().filter(|point| !point.others.is_empty());
        let nodes = |point: &Point| {
            let others = || point.others.iter().map(|other| other.0);
            std::iter::once(point.node).chain(others()).chain(others().flat_map(beyond)).collect()
        };
        linked.map(nodes).collect()
    }

    /// Nodes that points are measured from, ascending, each with the node of a point that is not itself one of them: the one at the
    /// end of a chain in which every point depends on the node before it most.
    pub(crate) fn leaders(&self) -> Vec<[u32; 2]> {
        let mut heaviest: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
        for point in &self.points {
            for &(other, weight) in &point.others {
                let best = heaviest.entry(other).or_insert((0.0, point.node));
                if weight.abs() > best.0 {
                    *best = (weight.abs(), point.node);
                }
            }
        }
        let last = |node: u32| -> Option<[u32; 2]> {
            let mut leader = heaviest.get(&node)?.1;
            // Chains that are closed have no end.
            for _ in 0..LONGEST_CHAIN {
                match heaviest.get(&leader) {
                    Some(&(_, next)) => leader = next,
                    None => return Some([node, leader]),
                }
            }
            None
        };
        heaviest.keys().filter_map(|&node| last(node)).collect()
    }

    /// Gives all nodes other numbers.
    pub(crate) fn renumber(&mut self, number: &dyn Fn(u32) -> u32) {
        for point in &mut self.points {
            point.node = number(point.node);
            point.others.iter_mut().for_each(|(node, _)| *node = number(*node));
        }
    }

    /// The points by their nodes, ascending, for [`Self::message`].
    pub(crate) fn by_node(&self) -> Vec<[u32; 2]> {
        ascending(self.nodes().zip(0..).map(|(node, j)| [node, j]))
    }

    /// As a message: the points all of whose nodes are among `nodes`, places in the mesh that ascend, with the places there as their nodes.
    pub(crate) fn message(&self, by_node: &[[u32; 2]], nodes: &[u64]) -> Vec<u8> {
        let place = |node: u32| nodes.binary_search(&u64::from(node)).ok().map(|k| k as u32);
        let here = |point: &Point| -> Option<(u32, Vec<(u32, f64)>)> {
            let others = point.others.iter().map(|&(node, weight)| Some((place(node)?, weight)));
            Some((place(point.node)?, others.collect::<Option<_>>()?))
        };
        let at_node = |&node: &u64| beside(by_node, node as u32).map(|j| j as usize);
        let mut at_nodes = ascending(nodes.iter().flat_map(at_node)).into_iter().peekable();
        let (mut own, mut numbers): (Vec<u32>, Vec<Numbers>) = Default::default();
        let (mut counts, mut others, mut weights): (Vec<u32>, Vec<u32>, Vec<f64>) = Default::default();
        let (mut names, mut ends, mut whole) = (Vec::new(), Vec::new(), Vec::new());
        for pair in &self.pairs {
            while let Some(j) = at_nodes.next_if(|&j| j < pair.points.end) {
                let point = &self.points[j];
                let Some((node, of)) = here(point) else { continue };
                whole.push(self.numbers[j]);
                own.push(node);
                numbers.push(of_point(point));
                counts.push(of.len() as u32);
                others.extend(of.iter().map(|other| other.0));
                weights.extend(of.iter().map(|other| other.1));
            }
            ends.push(own.len() as u64);
            put(pair.name.as_bytes(), &mut names);
        }
        let mut to = Vec::new();
        put(&ends, &mut to);
        to.extend(names);
        put(&own, &mut to);
        put(&numbers, &mut to);
        put(&counts, &mut to);
        put(&others, &mut to);
        put(&weights, &mut to);
        put(&whole, &mut to);
        to
    }

    /// Takes the points out of a message of [`Self::message`].
    ///
    /// # Panics
    /// If the message is none of its making.
    pub(crate) fn take(from: &mut &[u8]) -> PosedPoints {
        let ends: Vec<u64> = take(from);
        let mut first = 0;
        let pair = |end: u64| {
            let points: Range<usize> = first..end as usize;
            first = points.end;
            Pair { name: String::from_utf8_lossy(&take::<u8>(from)).into_owned(), points }
        };
        let pairs = ends.into_iter().map(pair).collect();
        let (own, numbers, counts): (Vec<u32>, Vec<Numbers>, Vec<u32>) = (take(from), take(from), take(from));
        let (others, weights): (Vec<u32>, Vec<f64>) = (take(from), take(from));
        let mut others = others.into_iter().zip(weights);
        let point = |((node, numbers), count): ((u32, Numbers), u32)| {
            point(node, numbers, others.by_ref().take(count as usize).collect())
        };
        let points = own.into_iter().zip(numbers).zip(counts).map(point).collect();
        PosedPoints { points, pairs, numbers: take(from) }
    }
}

fn of_point(point: &Point) -> Numbers {
    let Point { gap, area, friction, orthotropy, frame, normal, unity_sum, stiffness, .. } = point;
    let law = friction.numbers();
    let yields = stiffness.map_or([0.0; 2], |of| [of.normal, of.tangential]);
    let mut numbers = [0.0; 22];
    let all = [&[*gap, *area, *orthotropy, *unity_sum][..], frame.as_flattened(), normal, &law[..], &yields].concat();
    numbers.copy_from_slice(&all);
    numbers
}

fn point(node: u32, numbers: Numbers, others: Vec<(u32, f64)>) -> Point {
    let [gap, area, orthotropy, unity_sum, rest @ ..] = numbers;
    let row = |k: usize| [rest[k], rest[k + 1], rest[k + 2]];
    let friction = Friction::of_numbers([rest[12], rest[13], rest[14], rest[15]]);
    let (frame, normal) = ([row(0), row(3), row(6)], row(9));
    let [normal_stiffness, tangential] = [rest[16], rest[17]];
    let stiffness = (normal_stiffness > 0.0).then_some(InterfaceStiffness { normal: normal_stiffness, tangential });
    // Ranks have no cyclic symmetry.
    let (beyond_cut, layer) = (Vec::new(), None);
    Point { node, gap, area, friction, orthotropy, frame, normal, others, beyond_cut, unity_sum, stiffness, layer }
}
