use std::collections::HashMap;

use super::layers::Behind;
use crate::contact::ContactProblem;
use crate::linalg::multigrid::{Block, Kernel, Nodes};
use crate::linalg::{Csr, dot};

/// A contact point: its node, its frame, and which of its rows of `B` are nonzero.
#[derive(Debug)]
pub(super) struct Point {
    pub node: usize,
    /// Rows: normal, tangents; orthonormal on the unknowns of the node.
    pub frame: Block<3, 3>,
    /// Displacements along the rows are multiplied by these and forces divided: the orthotropy ratio across the first tangent
    /// makes the ellipse of friction a disc, and where a support holds a part of the normal the other part is shorter than one.
    pub scale: [f64; 3],
    /// Whether a row of the law is nonzero: normal, tangents.
    pub has_row: [bool; 3],
    /// Displacement over force, length/newton: of the point's node and those its rows reach, by the levels of the hierarchy.
    pub compliance: f64,
    /// Whether a row reaches a floating body. Such a point is closed at first, unless the body starts from rigid equilibrium.
    pub floats: bool,
}

impl Point {
    /// Turns displacements of the node into scaled ones in the frame.
    pub(super) fn displacements(&self) -> Block<3, 3> {
        std::array::from_fn(|r| self.frame[r].map(|x| x * self.scale[r]))
    }

    /// Turns the near-kernel at its node into its frame.
    pub(super) fn turn_kernel(&self, kernel: &mut [Kernel<3>]) {
        let (turn, own) = (self.displacements(), &mut kernel[self.node]);
        *own = std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|s| turn[r][s] * own[s][c]).sum()));
    }

    /// Adds the compliance of the node itself, whose diagonal block is `diagonal`, and that of the coarse levels.
    pub(super) fn add_compliance(&mut self, diagonal: &Block<3, 3>, coarse: &[f64; 3]) {
        let coarse = (0..3).map(|c| coarse[c] / (3.0 * self.scale[c] * self.scale[c])).sum::<f64>();
        self.compliance = self.compliance + compliance(diagonal, self.scale, 3.0) + coarse;
    }

    /// Turns forces on the node into those that do the same work there; its transpose turns displacements back.
    pub(super) fn forces(&self) -> Block<3, 3> {
        std::array::from_fn(|r| self.frame[r].map(|x| x / self.scale[r]))
    }
}

/// Displacement over force at a node with the diagonal block `d`: `weight` over its scaled trace.
pub(super) fn compliance(d: &Block<3, 3>, scale: [f64; 3], weight: f64) -> f64 {
    weight / (0..3).map(|c| d[c][c] * scale[c] * scale[c]).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Rows of a point are orthonormal to this accuracy.
const ORTHONORMAL: f64 = 1e-9;
/// The least part of the normal that supports may leave.
const LEAST_NORMAL: f64 = 0.1;

/// The nodes that a point's rows reach beside its own, each with its block of `B`.
pub(super) type OtherNodes = Vec<(u32, Block<3, 3>)>;

/// A contact point without a node of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NoOwnNode {
    /// The point.
    pub point: usize,
    /// A node on which its rows are a frame, if there is one, and another point that reaches it.
    pub shares: Option<(usize, usize)>,
}

/// The points with the other nodes that their rows reach.
///
/// # Errors
/// The first point that has no node of its own.
///
/// A point's own node is one on which its rows are a frame and that no other point reaches, but for points whose own node
/// has been found before: those may be relative to it, as the middle of a quadratic edge is to the ends, which are relative
/// to the other body. Where the meshes match both sides of a layer have such a node: then it is that of the layer. Of points that are
/// relative to one another in a cycle it is the node on which they alone are a frame: others reach it less.
pub(super) fn points(
    problem: &ContactProblem,
    nodes: &Nodes,
    layers: &[Option<Behind>],
) -> Result<(Vec<Point>, Vec<OtherNodes>), NoOwnNode> {
    let rows = problem.isotropic_rows();
    let m = problem.points();
    let mut others: Vec<OtherNodes> = (0..m).map(|j| blocks(problem, nodes, j)).collect();
    // Of the points without a node that reach each node, their count and the sum of their numbers: of one, its number.
    let mut reached = vec![(0u32, 0u64); nodes.count];
    for (j, blocks) in others.iter().enumerate() {
        for (v, _) in blocks {
            let (count, sum) = &mut reached[*v as usize];
            (*count, *sum) = (*count + 1, *sum + j as u64);
        }
    }
    let mut points: Vec<Option<Point>> = (0..m).map(|_| None).collect();
    let mut next: Vec<u32> = (0..m as u32).rev().collect();
    while let Some(j) = next.pop() {
        let j = j as usize;
        let in_frame = filled(problem, &problem.contact.B, j);
        let is_own =
            |(v, block): &(u32, Block<3, 3>)| reached[*v as usize] == (1, j as u64) && is_frame(block, &in_frame);
        let in_layer = |other: &(u32, Block<3, 3>)| layers[other.0 as usize].is_some() && is_own(other);
        let own = others[j].iter().position(in_layer).or_else(|| others[j].iter().position(is_own));
        let Some(own) = own.filter(|_| points[j].is_none()) else { continue };
        for (v, _) in &others[j] {
            let (count, sum) = &mut reached[*v as usize];
            (*count, *sum) = (*count - 1, *sum - j as u64);
            next.extend((*count == 1).then_some(*sum as u32));
        }
        let own = others[j].swap_remove(own);
        points[j] = Some(point(problem, own, &mut others[j], in_frame, filled(problem, &rows, j), j));
    }
    let left: Vec<usize> = (0..m).filter(|&j| points[j].is_none()).collect();
    let mut framed: HashMap<u32, usize> = HashMap::new();
    for &j in &left {
        let in_frame = filled(problem, &problem.contact.B, j);
        let frames = others[j].iter().filter(|(_, block)| is_frame(block, &in_frame));
        frames.for_each(|(v, _)| *framed.entry(*v).or_default() += 1);
    }
    for &j in &left {
        let in_frame = filled(problem, &problem.contact.B, j);
        let is_own = |(v, block): &(u32, Block<3, 3>)| framed.get(v) == Some(&1) && is_frame(block, &in_frame);
        let Some(own) = others[j].iter().position(is_own) else { continue };
        let own = others[j].swap_remove(own);
        points[j] = Some(point(problem, own, &mut others[j], in_frame, filled(problem, &rows, j), j));
    }
    if let Some(point) = points.iter().position(Option::is_none) {
        let in_frame = filled(problem, &problem.contact.B, point);
        let framed = others[point].iter().find(|(_, block)| is_frame(block, &in_frame)).map(|(v, _)| *v);
        let reaches = |v: u32, j: usize| points[j].is_none() && others[j].iter().any(|(w, _)| *w == v);
        let shares = framed.and_then(|v| Some((v as usize, (0..m).find(|&j| j != point && reaches(v, j))?)));
        return Err(NoOwnNode { point, shares });
    }
    Ok((points.into_iter().flatten().collect(), others))
}

/// The same where the own node of each point is known.
///
/// # Errors
/// The first point whose rows are no frame there.
pub(super) fn points_at(
    problem: &ContactProblem,
    nodes: &Nodes,
    at: &[u32],
) -> Result<(Vec<Point>, Vec<OtherNodes>), NoOwnNode> {
    let rows = problem.isotropic_rows();
    let mut all = (Vec::new(), Vec::new());
    for (j, &node) in at.iter().enumerate() {
        let mut others = blocks(problem, nodes, j);
        let in_frame = filled(problem, &problem.contact.B, j);
        let own = others.iter().position(|(v, block)| *v == node && is_frame(block, &in_frame));
        let own = others.swap_remove(own.ok_or(NoOwnNode { point: j, shares: None })?);
        all.0.push(point(problem, own, &mut others, in_frame, filled(problem, &rows, j), j));
        all.1.push(others);
    }
    Ok(all)
}

/// Which rows of a point are not zero. A tangent without friction is no row of the law, but it belongs to the frame.
fn filled(problem: &ContactProblem, of: &Csr, j: usize) -> [bool; 3] {
    problem.rows(j).map(|i| of.row(i).1.iter().any(|&v| v != 0.0))
}

/// The normal row gets the length one, at the other nodes too.
fn point(
    problem: &ContactProblem,
    (node, mut frame): (u32, Block<3, 3>),
    others: &mut OtherNodes,
    in_frame: [bool; 3],
    has_row: [bool; 3],
    j: usize,
) -> Point {
    let normal = normal_length(&frame, &in_frame);
    if normal != 1.0 {
        let blocks = std::iter::once(&mut frame).chain(others.iter_mut().map(|(_, block)| block));
        blocks.flat_map(|block| &mut block[0]).for_each(|entry| *entry /= normal);
    }
    complete(&mut frame, &in_frame);
    let scale = [normal, 1.0, if has_row[2] { problem.orthotropy_ratio(j) } else { 1.0 }];
    Point { node: node as usize, frame, scale, has_row, compliance: 0.0, floats: false }
}

/// The rows of a point by nodes.
fn blocks(problem: &ContactProblem, nodes: &Nodes, j: usize) -> OtherNodes {
    let mut blocks: OtherNodes = Vec::new();
    for (r, i) in problem.rows(j).into_iter().enumerate() {
        let (columns, values) = problem.contact.B.row(i);
        for (&column, &value) in columns.iter().zip(values).filter(|(_, v)| **v != 0.0) {
            let (v, c) = nodes.of[column as usize];
            let place = blocks.iter().position(|(w, _)| *w == v).unwrap_or_else(|| {
                blocks.push((v, [[0.0; 3]; 3]));
                blocks.len() - 1
            });
            blocks[place].1[r][c as usize] = value;
        }
    }
    blocks
}

/// The length of the normal row at the own node of a point: one, but where a support holds a part of the normal.
fn normal_length(block: &Block<3, 3>, in_frame: &[bool; 3]) -> f64 {
    let length = dot(&block[0], &block[0]).sqrt();
    if in_frame[0] && (length - 1.0).abs() > ORTHONORMAL { length } else { 1.0 }
}

/// Whether the rows in the frame are orthonormal, the normal one but for a length that is less than one.
fn is_frame(block: &Block<3, 3>, in_frame: &[bool; 3]) -> bool {
    let normal = normal_length(block, in_frame);
    let length = |r: usize| if r == 0 { normal } else { 1.0 };
    (LEAST_NORMAL..=1.0).contains(&normal)
        && (0..3).all(|r| {
            (0..=r).all(|s| {
                let expected = if r == s { length(r) * length(s) } else { 0.0 };
                !(in_frame[r] && in_frame[s]) || (dot(&block[r], &block[s]) - expected).abs() <= ORTHONORMAL
            })
        })
}

/// Completes the frame by the rows that are not in it.
fn complete(frame: &mut Block<3, 3>, in_frame: &[bool; 3]) {
    for r in (0..3).filter(|&r| !in_frame[r]) {
        let mut best = ([0.0; 3], 0.0);
        for c in 0..3 {
            let mut e = [0.0; 3];
            e[c] = 1.0;
            for s in 0..3 {
                let cosine = frame[s][c];
                (0..3).for_each(|k| e[k] -= cosine * frame[s][k]);
            }
            let length = dot(&e, &e).sqrt();
            if length > best.1 {
                best = (e.map(|v| v / length), length);
            }
        }
        frame[r] = best.0;
    }
}
