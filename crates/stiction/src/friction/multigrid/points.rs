use crate::contact::ContactProblem;
use crate::linalg::dot;
use crate::linalg::multigrid::{Block, Nodes};

/// A contact point: its node, its frame, and which of its rows of `B` are nonzero.
#[derive(Debug)]
pub(super) struct Point {
    pub node: usize,
    /// Rows: normal, tangents; orthonormal on the unknowns of the node.
    pub frame: Block<3, 3>,
    /// Displacements along the rows are multiplied by these and forces divided: the orthotropy ratio across the first tangent
    /// makes the ellipse of friction a disc.
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

    /// Turns forces on the node into those that do the same work there; its transpose turns displacements back.
    pub(super) fn forces(&self) -> Block<3, 3> {
        std::array::from_fn(|r| self.frame[r].map(|x| x / self.scale[r]))
    }
}

/// Rows of a point are orthonormal to this accuracy.
const ORTHONORMAL: f64 = 1e-9;

/// The nodes that a point's rows reach beside its own, each with its block of `B`.
pub(super) type OtherNodes = Vec<(u32, Block<3, 3>)>;

/// The points with the other nodes that their rows reach; `None` if one has no node of its own.
///
/// A point's own node is one that no other point's rows reach, or the only one that its rows reach. Rows of other points may
/// reach such a single node, as those of the middle of a quadratic edge reach its ends; chains of relative displacements do
/// not occur.
pub(super) fn points(problem: &ContactProblem, nodes: &Nodes) -> Option<(Vec<Point>, Vec<OtherNodes>)> {
    let blocks: Vec<OtherNodes> = (0..problem.points()).map(|j| blocks(problem, nodes, j)).collect();
    let mut reached = vec![0u32; nodes.count];
    blocks.iter().flatten().for_each(|(v, _)| reached[*v as usize] += 1);
    let rows = problem.isotropic_rows();
    let mut taken = vec![false; nodes.count];
    let mut points = Vec::with_capacity(blocks.len());
    let mut others = Vec::with_capacity(blocks.len());
    for (j, mut blocks) in blocks.into_iter().enumerate() {
        let has_row = problem.rows(j).map(|i| rows.row(i).1.iter().any(|&v| v != 0.0));
        // A tangent without friction is no row of the law, but it belongs to the frame.
        let in_frame = problem.rows(j).map(|i| problem.contact.B.row(i).1.iter().any(|&v| v != 0.0));
        let alone = blocks.len() == 1;
        let is_own = |v: u32| if alone { !taken[v as usize] } else { reached[v as usize] == 1 };
        let own = blocks.iter().position(|(v, block)| is_own(*v) && is_frame(block, &in_frame))?;
        let (node, mut frame) = blocks.swap_remove(own);
        taken[node as usize] = true;
        complete(&mut frame, &in_frame);
        let scale = [1.0, 1.0, if has_row[2] { problem.orthotropy_ratio(j) } else { 1.0 }];
        points.push(Point { node: node as usize, frame, scale, has_row, compliance: 0.0, floats: false });
        others.push(blocks);
    }
    Some((points, others))
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

/// Whether the rows in the frame are orthonormal.
fn is_frame(block: &Block<3, 3>, in_frame: &[bool; 3]) -> bool {
    (0..3).all(|r| {
        (0..=r).all(|s| {
            let expected = f64::from(u8::from(r == s));
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
