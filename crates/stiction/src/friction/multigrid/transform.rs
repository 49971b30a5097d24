use std::collections::{HashMap, HashSet};

use super::divided::Border;
use super::layers::{self, Behind};
use super::points::{NoOwnNode, OtherNodes, Point, compliance, points};
use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::rigid::{RigidMotions, rigid_motions};
use crate::linalg::multigrid::{
    Block, Blocks, Hierarchy, Kernel, LinearSpace, NO_NODE, Nodes, RelativeCoordinates, RelativeMatrix,
};
use crate::linalg::{NodeGraph, Stop, fronts, mean_distance};
use crate::ranks::Halo;

/// The transformed problem: `K`, `f` and the near-kernel by nodes, those of contact points in their frames `(n, t1, t2)` and,
/// between bodies, as displacements relative to the other body. Contact conditions then concern single components.
#[derive(Debug)]
pub(super) struct Transformed {
    pub nodes: Nodes,
    pub k: RelativeMatrix,
    pub f: Vec<[f64; 3]>,
    pub points: Vec<Point>,
    /// The rigid motions of floating bodies.
    pub motions: RigidMotions,
    /// The contact points of other ranks that this one is coupled to.
    pub border: Border,
}

/// Why the problem is none for multigrid.
pub(super) fn refused(what: &str) -> Error {
    Error::new("", what, "leave `settings.path` at auto")
}

/// Without `node_of` every unknown is a node of its own, on which no point has a frame.
pub(super) fn no_own_node(problem: &ContactProblem, nodes: &Nodes, NoOwnNode { point, shares }: NoOwnNode) -> Error {
    let needed = "multigrid is for contact points that each have a node of their own";
    let Some(labels) = &problem.elastic.node_of else {
        let what = format!("{needed}, and `elastic.node_of` does not say which unknowns belong to one node");
        let remedy = "give `elastic.node_of` and, for a good rate of convergence, `elastic.near_kernel`, or leave \
                      `settings.path` at auto";
        return Error::new("", what, remedy);
    };
    let named = |j: usize| match problem.labels.pairs.iter().find(|pair| pair.points.contains(&j)) {
        Some(pair) => format!("point {} of pair \"{}\"", j - pair.points.start, pair.name),
        None => format!("point {j}"),
    };
    let label = |v: usize| nodes.of.iter().position(|&(w, _)| w as usize == v).map_or(v as u32, |i| labels[i]);
    // Where a support holds the node along the surface its rows have a prescribed displacement instead of an unknown.
    let held = problem.labels.supports.as_ref().is_some_and(|supports| {
        let m = problem.points();
        [m + point, 2 * m + point].iter().any(|&i| supports.B.row(i).1.iter().any(|&entry| entry != 0.0))
    });
    if shares.is_none() && held {
        let what = format!("{needed}, and a support holds a node of {} along the surface", named(point));
        let remedy = "leave `settings.path` at auto, or put the points (the rows of `contact.B`) on the other body";
        return Error::new("", what, remedy);
    }
    let Some((v, other)) = shares else {
        return refused(&format!("{needed}, and on no node the rows of {} are a frame", named(point)));
    };
    let what = format!("{needed}, and node {} is that of {} and of {}", label(v), named(point), named(other));
    let remedy = "leave `settings.path` at auto, or leave that node out of one of the two surfaces";
    Error::new("", what, remedy)
}

pub(super) fn chained() -> Error {
    refused("contact points are relative to one another along chains too long for multigrid")
}

fn on_stiff_body() -> Error {
    let what = "contact points lie on a body some hundred times stiffer than the one they touch, which multigrid solves \
                slowly or not";
    Error::new(
        "",
        what,
        "put the points (the rows of `contact.B`) on the softer body, or leave `settings.path` at auto",
    )
}

/// A node this many times stiffer than those it is relative to is on a stiff body. A soft node then carries stiff ones along
/// wherever they may slide, and no sweep by nodes smooths its motion: sliding without friction takes 31 cycles at a ratio of
/// ten, 73 at a hundred and 158 at 500.
const MUCH_STIFFER: f64 = 100.0;
/// Part of the points between bodies on stiff bodies from which the problem is refused: single nodes at an edge do not count.
const MOST_ON_STIFF: f64 = 0.25;

/// Refuses a problem many of whose points are relative to much softer nodes than their own. The first `own` nodes are those of
/// this rank, which counts the points there.
pub(super) fn refuse_stiff_bodies(
    k: &Blocks<3, 3>,
    halo: &Halo,
    layers: &[Option<Behind>],
    points: &[Point],
    others: &[OtherNodes],
) -> Result<(), Error> {
    let mut is_own = vec![false; k.rows];
    points.iter().for_each(|p| is_own[p.node] = true);
    // Nodes of the other body, not the ends of a quadratic edge.
    let masters = |o: &OtherNodes| o.iter().any(|(v, _)| !is_own[*v as usize]);
    let here = || points.iter().zip(others).filter(|(p, _)| p.node < halo.own());
    let stiff = |(p, others): &(&Point, &OtherNodes)| {
        let (mut soft, mut all) = (0.0, 0.0);
        for (v, block) in others.iter().filter(|(v, _)| !is_own[*v as usize]) {
            let weight: f64 = block.iter().flatten().map(|c| c * c).sum();
            soft += weight * trace(&k.diagonal(*v as usize));
            all += weight;
        }
        all > 0.0 && layers::stiffness(k, layers, p.node) * all > MUCH_STIFFER * soft
    };
    let mut counts = [here().filter(stiff).count() as f64, here().filter(|(_, o)| masters(o)).count() as f64];
    halo.sum(&mut counts);
    if counts[0] > MOST_ON_STIFF * counts[1] { Err(on_stiff_body()) } else { Ok(()) }
}

/// Displacement over force of the other nodes of each point, without the scale, which belongs to friction and not to the body.
pub(super) fn compliance_of_others(k: &Blocks<3, 3>, others: &[OtherNodes]) -> Vec<f64> {
    let square = |b: &Block<3, 3>| b.iter().flatten().map(|v| v * v).sum::<f64>();
    let of_node = |(v, b): &(u32, Block<3, 3>)| compliance(&k.diagonal(*v as usize), [1.0; 3], square(b));
    others.iter().map(|others| others.iter().map(of_node).sum()).collect()
}

/// The blocks of the other nodes of each point for displacements in the frames; `count` nodes.
pub(super) fn all_in_frames(points: &[Point], others: Vec<OtherNodes>, count: usize) -> Vec<OtherNodes> {
    let mut frame_of = vec![u32::MAX; count];
    points.iter().enumerate().for_each(|(j, p)| frame_of[p.node] = j as u32);
    let point_of = |v: usize| points.get(frame_of[v] as usize);
    points.iter().zip(others).map(|(p, others)| in_frames(p, others, point_of)).collect()
}

impl Transformed {
    /// The transformed problem and the multigrid hierarchy of its matrix.
    ///
    /// # Errors
    /// If the problem is none for multigrid: a point without a node of its own on which its rows are an orthonormal frame,
    /// or on a much stiffer body than the one it touches; nodes with more than three unknowns; a matrix that aggregation does
    /// not make coarser. If it is stopped: [`Error::interrupted`].
    pub(super) fn new(problem: &ContactProblem, stop: &Stop) -> Result<(Transformed, Hierarchy), Error> {
        stop.check()?;
        let mut graph = NodeGraph::of_symmetric(&problem.elastic.K, problem.elastic.node_of.as_deref());
        if let Some(order) = order(problem, &graph) {
            graph = graph.reordered(&order);
        }
        let nodes =
            Nodes::new(&graph, problem.unknowns()).ok_or_else(|| refused("a node has more than three unknowns"))?;
        let mut k = nodes.blocks(&problem.elastic.K, &graph);
        stop.check()?;
        let layers = layers::layers(&k);
        let found = points(problem, &nodes, &layers);
        let (mut points, others) = found.map_err(|of| no_own_node(problem, &nodes, of))?;
        stop.check()?;
        refuse_stiff_bodies(&k, &Halo::alone(nodes.count), &layers, &points, &others)?;
        let tied = layers::tied(&k, &layers, &points);
        let mut of_others = compliance_of_others(&k, &others);
        tied.iter().for_each(|tied| of_others[tied.point] += tied.compliance);
        let mut others = all_in_frames(&points, others, nodes.count);
        frames_of(&mut k, &points);
        let mut kernel = kernel(problem, &nodes);
        let linear = linear_space(problem, &nodes, &kernel, &points, &layers, &Halo::alone(nodes.count));
        points.iter().for_each(|p| p.turn_kernel(&mut kernel));
        others.extend(layers::rows(&tied, &points));
        let own: Vec<u32> =
            points.iter().map(|p| p.node as u32).chain(tied.iter().map(|tied| tied.behind.node)).collect();
        let are_relative = others.iter().any(|o| !o.is_empty());
        let relative =
            are_relative.then(|| RelativeCoordinates::new(own.clone(), &others, nodes.count).ok_or_else(chained));
        let relative = relative.transpose()?;
        let k = RelativeMatrix::new(k, relative);
        stop.check()?;
        let hierarchy = Hierarchy::new(&k, &kernel, &own, points.len(), linear, stop)?;
        let hierarchy = hierarchy.ok_or_else(|| refused("the stiffness matrix does not get coarser by aggregation"))?;
        // The node's own compliance is that of the relative coordinates.
        for ((p, coarse), of_others) in points.iter_mut().zip(hierarchy.coarse_compliances()).zip(of_others) {
            p.compliance = of_others;
            p.add_compliance(&k.diagonal(p.node), &coarse);
        }
        let motions = if hierarchy.is_singular() { rigid_motions(problem) } else { RigidMotions::default() };
        mark_floating(problem, &motions, points.iter_mut().enumerate());
        let border = Border::default();
        let mut transformed = Transformed { nodes, k, f: Vec::new(), points, motions, border };
        transformed.set_load(&problem.elastic.f);
        Ok((transformed, hierarchy))
    }

    /// Whether contact alone supports some body; the same on all ranks.
    pub(super) fn floats(&self) -> bool {
        self.halo().any(self.points.iter().any(|p| p.floats))
    }

    /// How the nodes are divided among ranks.
    pub(super) fn halo(&self) -> &Halo {
        &self.k.halo
    }

    /// Whether rows of `B` reach other nodes than the points' own.
    pub(super) fn relates_points(&self) -> bool {
        self.k.relative.is_some()
    }

    /// Replaces the load.
    pub(super) fn set_load(&mut self, f: &[f64]) {
        self.f = self.forces(f);
    }

    /// Forces on the unknowns in the frames.
    pub(super) fn forces(&self, f: &[f64]) -> Vec<[f64; 3]> {
        let mut f = self.nodes.gather(f);
        for p in self.points.iter().chain(&self.border.points) {
            f[p.node] = times(&p.forces(), &f[p.node]);
        }
        if let Some(relative) = &self.k.relative {
            relative.forces(&mut f);
        }
        f.truncate(self.k.len());
        f
    }

    /// Displacements of unknowns in the frames, at the nodes of this rank.
    pub(super) fn to_frames(&self, u: &[f64]) -> Vec<[f64; 3]> {
        let mut x = self.nodes.gather(u);
        for p in self.points.iter().chain(&self.border.points) {
            x[p.node] = times(&p.displacements(), &x[p.node]);
        }
        if let Some(relative) = &self.k.relative {
            relative.to_relative(&mut x);
        }
        x.truncate(self.k.len());
        x
    }

    /// The inverse of [`Self::to_frames`]; zero at nodes of other ranks.
    pub(super) fn out_of_frames(&self, x: &[[f64; 3]]) -> Vec<f64> {
        let mut x = x.to_vec();
        if let Some(relative) = &self.k.relative {
            // Nodes may be relative to nodes of other ranks.
            self.halo().update(&mut x);
            x.resize(self.nodes.count, [0.0; 3]);
            relative.to_absolute(&mut x);
            x.truncate(self.k.len());
        }
        for p in &self.points {
            let (y, back) = (x[p.node], p.forces());
            x[p.node] = std::array::from_fn(|c| (0..3).map(|r| back[r][c] * y[r]).sum());
        }
        x.resize(self.nodes.count, [0.0; 3]);
        self.nodes.scatter(&x)
    }
}

/// Marks the points, given with their numbers, that reach a floating body.
pub(super) fn mark_floating<'a>(
    problem: &ContactProblem,
    motions: &RigidMotions,
    points: impl Iterator<Item = (usize, &'a mut Point)>,
) {
    let mut floating = vec![false; problem.unknowns()];
    motions.bodies.iter().flat_map(|b| &b.unknowns).for_each(|&i| floating[i as usize] = true);
    for (j, p) in points.filter(|_| !motions.is_empty()) {
        let reached = |i: usize| problem.contact.B.row(i).0.iter().any(|&c| floating[c as usize]);
        p.floats = problem.rows(j).into_iter().any(reached);
    }
}

fn trace(a: &Block<3, 3>) -> f64 {
    a[0][0] + a[1][1] + a[2][2]
}

/// The near-kernel by nodes.
pub(super) fn kernel(problem: &ContactProblem, nodes: &Nodes) -> Vec<Kernel<3>> {
    let mut kernel = vec![[[0.0; 6]; 3]; nodes.count];
    for (i, &(v, c)) in nodes.of.iter().enumerate() {
        let c = c as usize;
        kernel[v as usize][c] = match &problem.elastic.near_kernel {
            Some(rows) => rows[i],
            None => std::array::from_fn(|q| f64::from(u8::from(q == c))),
        };
    }
    kernel
}

/// Where neighbours have numbers this many times as far apart as in the order of fronts, the latter is taken. Mesh generators
/// that insert nodes one by one leave them hundreds of times as far, blocks and rings less than twice. On 50 000 nodes of such
/// a mesh the set-up then takes two thirds of the time, and 17 cycles suffice where 20 were taken.
const SCATTERED: f64 = 4.0;

/// The order of nodes for sweeps, if not that of the mesh: by [fronts] where neighbours would otherwise lie far from one
/// another in memory, and nodes in the middle of edges before corners. Sweeps that begin with the middles leave errors that
/// the linear space represents better. Hexahedra of 20 nodes take 14 instead of 21 cycles.
pub(super) fn order(problem: &ContactProblem, graph: &NodeGraph) -> Option<Vec<u32>> {
    let mut order = fronts(graph);
    let mut place = vec![0; graph.len()];
    order.iter().enumerate().for_each(|(k, &v)| place[v as usize] = k as u32);
    let scattered = mean_distance(graph, |v| v) > SCATTERED * mean_distance(graph, |v| place[v as usize]);
    if !scattered {
        order.sort_unstable();
    }
    let (Some(middles), Some(labels)) = (&problem.elastic.middles, &problem.elastic.node_of) else {
        return scattered.then_some(order);
    };
    let middles: HashSet<u32> = middles.iter().map(|middle| middle[0]).collect();
    let is_middle =
        |&v: &u32| graph.unknowns_of(v as usize).first().is_some_and(|&i| middles.contains(&labels[i as usize]));
    let (mut order, corners): (Vec<u32>, Vec<u32>) = order.into_iter().partition(is_middle);
    order.extend(corners);
    Some(order)
}

/// The displacements that are linear on the edges of quadratic elements, where some rank has such elements; `kernel` is that out
/// of the frames of the points, at all nodes here. A node of a layer moves with that of the mesh behind it.
pub(super) fn linear_space(
    problem: &ContactProblem,
    nodes: &Nodes,
    kernel: &[Kernel<3>],
    points: &[Point],
    layers: &[Option<Behind>],
    halo: &Halo,
) -> Option<LinearSpace> {
    if !halo.any(problem.elastic.middles.is_some()) {
        return None;
    }
    let (middles, labels) = (problem.elastic.middles.as_deref().unwrap_or_default(), problem.elastic.node_of.as_ref()?);
    let node_of: HashMap<u32, u32> = labels.iter().zip(&nodes.of).map(|(&label, &(v, _))| (label, v)).collect();
    let mut ends = vec![None; nodes.count];
    for [middle, a, b] in middles {
        if let Some(&v) = node_of.get(middle) {
            ends[v as usize] = Some([a, b].map(|end| node_of.get(end).copied().unwrap_or(NO_NODE)));
        }
    }
    for (v, behind) in layers.iter().enumerate() {
        if let &Some(behind) = behind {
            ends[v] = Some(ends[behind.node as usize].unwrap_or([behind.node; 2]));
        }
    }
    let mut space = LinearSpace::new(&ends, kernel, halo);
    points.iter().filter(|p| p.node < halo.own()).for_each(|p| space.turn(p.node, &p.displacements()));
    Some(space)
}

/// `A B`.
fn product<const C: usize>(a: &Block<3, 3>, b: &Block<3, C>) -> Block<3, C> {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|s| a[r][s] * b[s][c]).sum()))
}

fn times(a: &Block<3, 3>, x: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| (0..3).map(|c| a[r][c] * x[c]).sum())
}

/// The blocks of the other nodes of a point for displacements in its frame and in those of the nodes that have one.
fn in_frames<'a>(p: &Point, others: OtherNodes, point_of: impl Fn(usize) -> Option<&'a Point>) -> OtherNodes {
    let convert = |(v, mut block): (u32, Block<3, 3>)| {
        (0..3).for_each(|r| block[r] = block[r].map(|x| p.scale[r] * x));
        (v, point_of(v as usize).map_or(block, |other| times_transposed(&block, &other.forces())))
    };
    others.into_iter().map(convert).collect()
}

/// [`matrix_in_frames`] of these points.
pub(super) fn frames_of(k: &mut Blocks<3, 3>, points: &[Point]) {
    let mut frame_of = vec![u32::MAX; k.rows];
    points.iter().enumerate().for_each(|(j, p)| frame_of[p.node] = j as u32);
    matrix_in_frames(k, |v| points.get(frame_of[v] as usize));
}

/// `F K Fᵀ` with the [forces](Point::forces) in the frames `F` at the nodes that have one.
fn matrix_in_frames<'a>(k: &mut Blocks<3, 3>, point_of: impl Fn(usize) -> Option<&'a Point>) {
    for i in 0..k.rows {
        for place in k.start[i]..k.start[i + 1] {
            let (left, right) = (point_of(i), point_of(k.column[place] as usize));
            let block = &mut k.value[place];
            if let Some(left) = left {
                *block = product(&left.forces(), block);
            }
            if let Some(right) = right {
                *block = times_transposed(block, &right.forces());
            }
        }
    }
}

/// `A Bᵀ`.
fn times_transposed(a: &Block<3, 3>, b: &Block<3, 3>) -> Block<3, 3> {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|s| a[r][s] * b[c][s]).sum()))
}
