//! A problem that is divided among ranks: the parts that one rank has none of.

use std::collections::HashMap;

use super::directions::{MOST_DIRECTIONS, Vector};
use super::points::points;
use super::transform::{Transformed, frames_of, kernel, order, refused};
use crate::Error;
use crate::certificate::{Certificate, certify_divided};
use crate::contact::rigid::RigidMotions;
use crate::contact::{Contact, ContactProblem, Division, Elastic, Labels, Pair};
use crate::linalg::multigrid::{Block, Hierarchy, Nodes, RelativeMatrix, contact_ghosts};
use crate::linalg::{Csr, NodeGraph, Stop};
use crate::ranks::{Halo, agree, all_to_all, from_bytes, to_bytes};

/// What is known of a problem of this rank beyond its own points.
#[derive(Debug)]
pub(super) struct Divided {
    /// With the points of other ranks.
    whole: ContactProblem,
    division: Division,
    /// The points of this rank in it.
    points: Vec<u32>,
}

/// The contact nodes of other ranks that own rows are coupled to.
#[derive(Debug)]
pub(super) struct Border {
    /// The division of the contact points.
    halo: Halo,
    /// A row of this rank, a ghost by its place among the points, and their block.
    entries: Vec<(u32, u32, Block<3, 3>)>,
}

impl Default for Border {
    fn default() -> Self {
        Border { halo: Halo::alone(0), entries: Vec::new() }
    }
}

impl Transformed {
    /// Adds to each of `y` the columns of `K` at the contact nodes of other ranks times their `changes`: of the first vector,
    /// then of the others.
    pub(super) fn add_columns_of_ghosts<'a>(
        &self,
        mut changes: Vec<[[f64; 3]; MOST_DIRECTIONS]>,
        y: impl Iterator<Item = &'a mut Vector>,
    ) {
        let Border { halo, entries } = &self.border;
        halo.update(&mut changes);
        for (d, y) in y.enumerate() {
            for (i, ghost, block) in entries {
                let change = changes[*ghost as usize][d];
                (0..3).for_each(|r| y[*i as usize][r] += (0..3).map(|c| block[r][c] * change[c]).sum::<f64>());
            }
        }
    }

    /// The transformed problem of one rank and its hierarchy, and what else is known.
    ///
    /// # Errors
    /// As [`Transformed::new`], at all ranks; if contact points relate nodes, or nothing but contact holds the body.
    pub(super) fn divided(
        whole: &ContactProblem,
        division: &Division,
        stop: &Stop,
    ) -> Result<(Transformed, Hierarchy, Divided), Error> {
        let ranks = &division.ranks;
        let labels = whole.elastic.node_of.as_deref().unwrap_or_default();
        let mut graph = NodeGraph::of_symmetric(&whole.elastic.K, Some(labels));
        let label = |graph: &NodeGraph, v: usize| labels[graph.unknowns_of(v)[0] as usize];
        let is_own = |v: &u32| division.is_own(label(&graph, *v as usize));
        let order = order(whole, &graph).unwrap_or_else(|| (0..graph.len() as u32).collect());
        let (own, others): (Vec<u32>, Vec<u32>) = order.into_iter().partition(is_own);
        let mut is_near = vec![false; graph.len()];
        own.iter().flat_map(|&v| graph.neighbours_of(v as usize)).for_each(|&w| is_near[w as usize] = true);
        let (near, far): (Vec<u32>, Vec<u32>) = others.into_iter().partition(|&v| is_near[v as usize]);
        let nodes_here = agree(&**ranks, if own.is_empty() { Err(no_nodes()) } else { Ok(()) });
        nodes_here?;
        let own_labels: Vec<u32> = own.iter().map(|&v| label(&graph, v as usize)).collect();
        let near_labels: Vec<u32> = near.iter().map(|&v| label(&graph, v as usize)).collect();
        let numbers = numbers(division, &own_labels, &near_labels);
        let mut ghosts: Vec<(u64, u32)> = agree(&**ranks, numbers)?.into_iter().zip(near).collect();
        ghosts.sort_unstable();
        let order: Vec<u32> = own.iter().copied().chain(ghosts.iter().map(|g| g.1)).chain(far).collect();
        graph = graph.reordered(&order);
        let halo = Halo::divided(ranks, own.len(), ghosts.iter().map(|g| g.0).collect());

        let found = Nodes::new(&graph, whole.unknowns()).ok_or_else(|| refused("a node has more than three unknowns"));
        let found = found.and_then(|nodes| match points(whole, &nodes) {
            Ok((points, others)) if others.iter().all(Vec::is_empty) => Ok((nodes, points)),
            _ => Err(refused("contact points that relate several nodes are not divided among ranks")),
        });
        let (nodes, all_points) = agree(&**ranks, found)?;
        stop.check()?;
        let mut k = nodes.blocks(&whole.elastic.K, &graph);
        frames_of(&mut k, &all_points);
        let entries = k.start[own.len()];
        k.start.truncate(own.len() + 1);
        (k.rows, k.cols) = (own.len(), halo.len());
        k.column.truncate(entries);
        k.value.truncate(entries);
        let mut kernel = kernel(whole, &nodes);
        kernel.truncate(own.len());
        let mut own_points = Vec::new();
        let mut points = Vec::new();
        for (j, p) in all_points.into_iter().enumerate().filter(|(_, p)| p.node < own.len()) {
            p.turn_kernel(&mut kernel);
            own_points.push(j as u32);
            points.push(p);
        }
        let contact: Vec<u32> = points.iter().map(|p| p.node as u32).collect();
        let k = RelativeMatrix::divided(k, halo);
        let border = Border::new(&k, &contact);
        let hierarchy = Hierarchy::new(&k, &kernel, &contact, None, stop)?;
        let hierarchy = hierarchy.ok_or_else(|| refused("the stiffness matrix does not get coarser by aggregation"))?;
        if hierarchy.is_singular() {
            let what = "nothing but contact holds the body, which is not divided among ranks";
            return Err(Error::new("", what, "hold it by prescribed displacements, or solve on one machine"));
        }
        for (p, coarse) in points.iter_mut().zip(hierarchy.coarse_compliances()) {
            p.add_compliance(&k.diagonal(p.node), &coarse);
        }
        let motions = RigidMotions::default();
        let mut transformed = Transformed { nodes, k, f: Vec::new(), points, motions, border };
        transformed.set_load(&whole.elastic.f);
        let divided = Divided { whole: whole.clone(), division: division.clone(), points: own_points };
        Ok((transformed, hierarchy, divided))
    }
}

impl Border {
    fn new(k: &RelativeMatrix, contact: &[u32]) -> Border {
        let (halo, ghosts) = contact_ghosts(k, contact);
        let place: HashMap<u32, u32> = ghosts.iter().copied().zip(halo.own() as u32..).collect();
        let row = |i: usize| k.entries_of(i).filter_map(|(j, block)| Some((*place.get(&j)?, *block)));
        let entries = (0..k.len()).flat_map(|i| row(i).map(move |(ghost, block)| (i as u32, ghost, block)));
        Border { entries: entries.collect(), halo }
    }
}

fn no_nodes() -> Error {
    Error::new("", "a rank has no node with an unknown displacement", "use fewer ranks")
}

/// The numbers of nodes of other ranks, each asked of its owner.
fn numbers(division: &Division, own: &[u32], near: &[u32]) -> Result<Vec<u64>, Error> {
    let ranks = &*division.ranks;
    let first = Halo::divided(&division.ranks, own.len(), Vec::new()).first();
    let number: HashMap<u64, u64> = own.iter().map(|&label| division.global[label as usize]).zip(first..).collect();
    let owner = |label: u32| division.owner[label as usize] as usize;
    let asked = |rank: usize| -> Vec<u64> {
        near.iter().filter(|&&l| owner(l) == rank).map(|&l| division.global[l as usize]).collect()
    };
    let questions = all_to_all(ranks, (0..ranks.size()).map(|rank| to_bytes(&asked(rank))).collect());
    let answer = |bytes: &Vec<u8>| -> Vec<u64> {
        from_bytes::<u64>(bytes).iter().map(|g| number.get(g).copied().unwrap_or(u64::MAX)).collect()
    };
    let answers = all_to_all(ranks, questions.iter().map(|bytes| to_bytes(&answer(bytes))).collect());
    let mut lists: Vec<_> = answers.iter().map(|bytes| from_bytes::<u64>(bytes).into_iter()).collect();
    let found = near.iter().map(|&label| lists[owner(label)].next().filter(|&n| n != u64::MAX));
    let what = "a node has an unknown displacement on one rank and none on another";
    found
        .collect::<Option<_>>()
        .ok_or_else(|| Error::new("", what, "report this: the ranks have divided the case wrongly"))
}

impl Divided {
    /// The problem with the points of this rank alone.
    pub(super) fn own(&self) -> ContactProblem {
        let ContactProblem { elastic, contact, labels } = &self.whole;
        let (m, own) = (self.points.len(), &self.points);
        let at = |list: &[f64]| -> Vec<f64> { own.iter().map(|&j| list[j as usize]).collect() };
        let mut rows = Vec::new();
        for (place, &j) in own.iter().enumerate() {
            for (r, i) in self.whole.rows(j as usize).into_iter().enumerate() {
                let (columns, values) = contact.B.row(i);
                rows.extend(columns.iter().zip(values).map(|(&c, &v)| (r * m + place, c as usize, v)));
            }
        }
        let all = self.whole.points();
        let contact = Contact {
            B: Csr::from_triplets(3 * m, contact.B.cols, &rows),
            gap: at(&contact.gap),
            slip_reference: [at(&contact.slip_reference[..all]), at(&contact.slip_reference[all..])].concat(),
            friction: own.iter().map(|&j| contact.friction[j as usize]).collect(),
            orthotropy: contact.orthotropy.as_ref().map(|ratios| at(ratios)),
            rounding: contact.rounding,
        };
        let before = |j: usize| own.partition_point(|&k| (k as usize) < j);
        let pair =
            |pair: &Pair| Pair { name: pair.name.clone(), points: before(pair.points.start)..before(pair.points.end) };
        let labels = Labels {
            area: at(&labels.area),
            unity_sum: at(&labels.unity_sum),
            pairs: labels.pairs.iter().map(pair).collect(),
            supports: None,
            bodies: None,
        };
        // The hierarchy has been set up: who solves reads no node and no motion any more.
        let Elastic { K, f, .. } = elastic;
        let elastic = Elastic { K: K.clone(), f: f.clone(), node_of: None, near_kernel: None, middles: None };
        ContactProblem { elastic, contact, labels }
    }

    /// Judges displacements of all unknowns here and multipliers of own points; what belongs to other ranks is theirs.
    pub(super) fn certify(&self, u: &[f64], lambda: &[f64], tolerance: f64) -> Certificate {
        let (m, all) = (self.points.len(), self.whole.points());
        let mut everywhere = vec![0.0; 3 * all];
        for (place, &j) in self.points.iter().enumerate() {
            (0..3).for_each(|r| everywhere[r * all + j as usize] = lambda[r * m + place]);
        }
        certify_divided(&self.whole, &self.division, u, &everywhere, tolerance)
    }

    /// The points of this rank, by their places in the problem.
    pub(super) fn points(&self) -> &[u32] {
        &self.points
    }
}
