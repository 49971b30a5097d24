//! A problem that is divided among ranks: the parts that one rank has none of.

use std::collections::HashMap;

use super::directions::{MOST_DIRECTIONS, Vector};
use super::divided_bodies::{divided_motions, refuse_unresisted};
use super::equations::equations;
use super::layers::{self, Behind, Tied};
use super::points::{OtherNodes, Point, points, points_at};
use super::transform::{
    Transformed, all_in_frames, chained, compliance_of_others, frames_of, kernel, linear_space, mark_floating,
    no_own_node, order, refuse_stiff_bodies, refused,
};
use crate::Error;
use crate::certificate::{Certificate, certify_divided, ghost_values};
use crate::contact::rigid::{RigidMotions, rigid_motions};
use crate::contact::{ContactProblem, Division, Elastic};
use crate::linalg::multigrid::{Block, Hierarchy, Nodes, RelativeCoordinates, RelativeMatrix, contact_ghosts};
use crate::linalg::{NodeGraph, Stop};
use crate::ranks::{Halo, agree, all_to_all, from_bytes, to_bytes};

/// What is known of a problem of this rank beyond its own points.
#[derive(Debug)]
pub(super) struct Divided {
    /// With the points of other ranks.
    whole: ContactProblem,
    division: Division,
    /// The points of this rank in it, ascending.
    points: Vec<u32>,
    /// The places of equations over many nodes among these, if some rank has such equations.
    equations: Option<Vec<u32>>,
}

/// The contact nodes of other ranks that own rows are coupled to.
#[derive(Debug)]
pub(super) struct Border {
    /// The points of other ranks that are here.
    pub(super) points: Vec<Point>,
    /// The division of the contact points.
    halo: Halo,
    /// A row of this rank, a ghost by its place among the points, and their block.
    entries: Vec<(u32, u32, Block<3, 3>)>,
}

impl Default for Border {
    fn default() -> Self {
        Border { halo: Halo::alone(0), entries: Vec::new(), points: Vec::new() }
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
        let Border { halo, entries, .. } = &self.border;
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
    /// As [`Transformed::new`], at all ranks; if points hang on nodes of other points, or nothing resists a motion of a body.
    pub(super) fn divided(
        whole: &ContactProblem,
        division: &Division,
        stop: &Stop,
    ) -> Result<(Transformed, Hierarchy, Divided), Error> {
        let ranks = &division.ranks;
        let equations = equations(whole, Some(division));
        let beside: Vec<u32> = (0..whole.points() as u32).filter(|j| equations.binary_search(j).is_err()).collect();
        let part = (!equations.is_empty()).then(|| of_points(whole, division, &beside));
        let (problem, divided) = part.as_ref().map_or((whole, division), |(problem, division)| (problem, division));
        let (graph, halo) = divided_graph(problem, divided)?;
        let nodes = Nodes::new(&graph, whole.unknowns()).ok_or_else(|| refused("a node has more than three unknowns"));
        let nodes = agree(&**ranks, nodes)?;
        let mut k = nodes.blocks(&whole.elastic.K, &graph);
        let layers = layers::layers(&k);
        let found = points_here(problem, divided, (&graph, &nodes, &layers));
        let (points, others) = agree(&**ranks, found)?;
        stop.check()?;
        refuse_stiff_bodies(&k, &halo, &layers, &points, &others)?;
        let mut of_others = compliance_of_others(&k, &others);
        let tied = layers::tied_here(&halo, &layers, layers::tied(&k, &layers, &points), &points);
        tied.iter().for_each(|tied| of_others[tied.point] += tied.compliance);
        let mut others = all_in_frames(&points, others, nodes.count);
        others.extend(layers::rows(&tied, &points));
        frames_of(&mut k, &points);
        let mut kernel = kernel(whole, &nodes);
        let linear = linear_space(whole, &nodes, &kernel, &points, &layers, &halo);
        kernel.truncate(halo.own());
        let here = points.iter().filter(|p| p.node < halo.own());
        here.for_each(|p| p.turn_kernel(&mut kernel));
        let relative = relative(&halo, (&points, &tied), &others, nodes.count);
        let relative = agree(&**ranks, relative)?;
        let k = RelativeMatrix::divided(k, halo, relative);
        let is_own = |(_, p): &(usize, Point)| p.node < k.len();
        let (own, ghosts): (Vec<_>, Vec<_>) = points.into_iter().enumerate().partition(is_own);
        let (own_points, mut points): (Vec<u32>, Vec<Point>) = own.into_iter().map(|(j, p)| (j as u32, p)).unzip();
        let contact: Vec<u32> = points.iter().map(|p| p.node as u32).collect();
        let own_tied = tied.iter().map(|tied| tied.behind.node).filter(|&v| (v as usize) < k.len());
        let with_tied: Vec<u32> = contact.iter().copied().chain(own_tied).collect();
        let border = Border::new(&k, &contact, ghosts.into_iter().map(|(_, p)| p).collect());
        let hierarchy = Hierarchy::new(&k, &kernel, &with_tied, contact.len(), linear, stop)?;
        let hierarchy = hierarchy.ok_or_else(|| refused("the stiffness matrix does not get coarser by aggregation"))?;
        for ((p, coarse), &j) in points.iter_mut().zip(hierarchy.coarse_compliances()).zip(&own_points) {
            p.compliance = of_others[j as usize];
            p.add_compliance(&k.diagonal(p.node), &coarse);
        }
        let motions = match hierarchy.is_singular() {
            true if k.halo.is_alone() => rigid_motions(whole),
            true => divided_motions(whole, division),
            false => RigidMotions::default(),
        };
        let own_beside = || own_points.iter().map(|&j| beside[j as usize]);
        let is_own = |j: &u32| division.is_own(division.points[*j as usize]);
        let own_equations: Vec<u32> = equations.iter().copied().filter(is_own).collect();
        let mut own: Vec<u32> = own_beside().chain(own_equations.iter().copied()).collect();
        own.sort_unstable();
        if !motions.is_empty() {
            refuse_unresisted(whole, division, &motions, &own)?;
            mark_floating(whole, &motions, own_beside().map(|j| j as usize).zip(&mut points));
        }
        let places = || own_equations.iter().map(|j| own.partition_point(|i| i < j) as u32).collect();
        let equations = k.halo.any(!own_equations.is_empty()).then(places);
        let mut transformed = Transformed { nodes, k, f: Vec::new(), points, motions, border };
        transformed.set_load(&whole.elastic.f);
        let divided = Divided { whole: whole.clone(), division: division.clone(), points: own, equations };
        Ok((transformed, hierarchy, divided))
    }
}

/// The problem of these points alone.
fn of_points(whole: &ContactProblem, division: &Division, points: &[u32]) -> (ContactProblem, Division) {
    let at = points.iter().map(|&j| division.points[j as usize]).collect();
    (whole.of_points(points), Division { points: at, ..division.clone() })
}

/// The nodes here: own ones, then the ghosts, then further ones; with how they are divided. Ghosts are all nodes that the rows of
/// own ones are coupled to, in relative coordinates too.
fn divided_graph(whole: &ContactProblem, division: &Division) -> Result<(NodeGraph, Halo), Error> {
    let ranks = &division.ranks;
    let labels = whole.elastic.node_of.as_deref().unwrap_or_default();
    let graph = NodeGraph::of_symmetric(&whole.elastic.K, Some(labels));
    let label = |v: u32| labels[graph.unknowns_of(v as usize)[0] as usize];
    let is_own: Vec<bool> = (0..graph.len() as u32).map(|v| division.is_own(label(v))).collect();
    let is_near = near(&graph, &is_own, &links(whole, division, &graph));
    let order = order(whole, &graph).unwrap_or_else(|| (0..graph.len() as u32).collect());
    let (own, others): (Vec<u32>, Vec<u32>) = order.into_iter().partition(|&v| is_own[v as usize]);
    let (ghosts, far): (Vec<u32>, Vec<u32>) = others.into_iter().partition(|&v| is_near[v as usize]);
    agree(&**ranks, if own.is_empty() { Err(no_nodes()) } else { Ok(()) })?;
    let [own_labels, near_labels] = [&own, &ghosts].map(|list| list.iter().map(|&v| label(v)).collect::<Vec<u32>>());
    let numbers = agree(&**ranks, numbers(division, &own_labels, &near_labels))?;
    let mut ghosts: Vec<(u64, u32)> = numbers.into_iter().zip(ghosts).collect();
    ghosts.sort_unstable();
    let order: Vec<u32> = own.iter().copied().chain(ghosts.iter().map(|g| g.1)).chain(far).collect();
    let halo = Halo::divided(ranks, own.len(), ghosts.iter().map(|g| g.0).collect());
    Ok((graph.reordered(&order), halo))
}

/// The number of the node of each label; [`u32::MAX`] of those without unknowns.
fn node_of_label(whole: &ContactProblem, division: &Division, graph: &NodeGraph) -> Vec<u32> {
    let labels = whole.elastic.node_of.as_deref().unwrap_or_default();
    let mut node = vec![u32::MAX; division.owner.len()];
    (0..graph.len()).for_each(|v| node[labels[graph.unknowns_of(v)[0] as usize] as usize] = v as u32);
    node
}

/// For each point its node and the others that its rows reach; and the node behind that of a layer.
fn links(whole: &ContactProblem, division: &Division, graph: &NodeGraph) -> Vec<(u32, Vec<u32>)> {
    let labels = whole.elastic.node_of.as_deref().unwrap_or_default();
    let node = node_of_label(whole, division, graph);
    let of_point = |(j, &own): (usize, &u32)| {
        let columns = whole.rows(j).into_iter().flat_map(|i| whole.contact.B.row(i).0);
        let mut others: Vec<u32> = columns.map(|&c| labels[c as usize]).filter(|&label| label != own).collect();
        others.sort_unstable();
        others.dedup();
        (node[own as usize], others.into_iter().map(|label| node[label as usize]).collect())
    };
    let mut links: Vec<(u32, Vec<u32>)> = division.points.iter().enumerate().map(of_point).collect();
    // What a layer is in front of may be measured from it.
    let behind = |&(v, _): &(u32, Vec<u32>)| match graph.neighbours_of(v as usize) {
        &[behind] => Some((behind, vec![v])),
        _ => None,
    };
    links.extend(links.iter().filter_map(behind).collect::<Vec<_>>());
    links
}

/// The nodes that rows of own nodes are coupled to where nodes are measured from others: `links` are nodes with these.
fn near(graph: &NodeGraph, is_own: &[bool], links: &[(u32, Vec<u32>)]) -> Vec<bool> {
    // The rows of a node measured from others are added to theirs.
    let mut added = is_own.to_vec();
    until_unchanged(links, |(v, others)| {
        let more = !added[*v as usize] && others.iter().any(|&w| added[w as usize]);
        added[*v as usize] |= more;
        more
    });
    let mut near = added.clone();
    let rows = (0..graph.len()).filter(|&v| added[v]);
    rows.flat_map(|v| graph.neighbours_of(v)).for_each(|&w| near[w as usize] = true);
    // And its column is added to theirs.
    until_unchanged(links, |(v, others)| {
        let more = near[*v as usize] && others.iter().any(|&w| !near[w as usize]);
        others.iter().filter(|_| more).for_each(|&w| near[w as usize] = true);
        more
    });
    near
}

fn until_unchanged<T>(list: &[T], mut changes: impl FnMut(&T) -> bool) {
    while list.iter().fold(false, |any, item| changes(item) | any) {}
}

/// All points here, and the other nodes that their rows reach.
fn points_here(
    whole: &ContactProblem,
    division: &Division,
    (graph, nodes, layers): (&NodeGraph, &Nodes, &[Option<Behind>]),
) -> Result<(Vec<Point>, Vec<OtherNodes>), Error> {
    // All points together decide which node is whose; a rank sees a part of them, and takes what they were posed on.
    let found = if division.ranks.size() == 1 {
        points(whole, nodes, layers)
    } else {
        let node = node_of_label(whole, division, graph);
        let at: Vec<u32> = division.points.iter().map(|&label| node[label as usize]).collect();
        points_at(whole, nodes, &at)
    };
    found.map_err(|of| no_own_node(whole, nodes, of))
}

/// The relative coordinates of all points here; `None` where no rank has points between bodies.
fn relative(
    halo: &Halo,
    (points, tied): (&[Point], &[Tied]),
    others: &[OtherNodes],
    count: usize,
) -> Result<Option<RelativeCoordinates>, Error> {
    if !halo.any(others.iter().any(|o| !o.is_empty())) {
        return Ok(None);
    }
    let nodes = points.iter().map(|p| p.node as u32).chain(tied.iter().map(|tied| tied.behind.node)).collect();
    RelativeCoordinates::new(nodes, others, count).ok_or_else(chained).map(Some)
}

impl Border {
    fn new(k: &RelativeMatrix, contact: &[u32], points: Vec<Point>) -> Border {
        let (halo, ghosts) = contact_ghosts(k, contact);
        let place: HashMap<u32, u32> = ghosts.iter().copied().zip(halo.own() as u32..).collect();
        let row = |i: usize| k.entries_of(i).filter_map(|(j, block)| Some((*place.get(&j)?, *block)));
        let entries = (0..k.len()).flat_map(|i| row(i).map(move |(ghost, block)| (i as u32, ghost, block)));
        Border { entries: entries.collect(), halo, points }
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
    /// Takes another problem on the same points.
    pub(super) fn renew(&mut self, whole: &ContactProblem) {
        self.whole = whole.clone();
    }

    /// The problem with the points of this rank alone.
    pub(super) fn own(&self) -> ContactProblem {
        let (contact, labels) = self.whole.contact_of_points(&self.points);
        // The hierarchy has been set up: who solves reads no node and no motion any more.
        let Elastic { K, f, .. } = &self.whole.elastic;
        let elastic = Elastic { K: K.clone(), f: f.clone(), node_of: None, near_kernel: None, middles: None };
        ContactProblem { elastic, contact, labels }
    }

    /// Takes the strengths of all points here off; returns the problem with them.
    pub(super) fn take_strengths_off(&mut self) -> ContactProblem {
        let shifted = self.whole.without_strength().unwrap_or_else(|| self.whole.clone());
        std::mem::replace(&mut self.whole, shifted)
    }

    /// Displacements of all unknowns here, those of other ranks asked of them.
    pub(super) fn everywhere(&self, u: &[f64]) -> Vec<f64> {
        ghost_values(&self.whole, &self.division, u, &vec![0.0; 3 * self.whole.points()]).0
    }

    /// Judges displacements of all unknowns here and multipliers of own points; what belongs to other ranks is theirs.
    pub(super) fn certify(&self, u: &[f64], lambda: &[f64], tolerance: f64) -> Certificate {
        let everywhere = self.whole.of_all_points(&self.points, lambda);
        certify_divided(&self.whole, &self.division, u, &everywhere, tolerance)
    }

    /// The places of equations over many nodes among the points of this rank, ascending, if some rank has such equations.
    pub(super) fn equations(&self) -> Option<&[u32]> {
        self.equations.as_deref()
    }

    /// The points of this rank, by their places in the problem.
    pub(super) fn points(&self) -> &[u32] {
        &self.points
    }
}
