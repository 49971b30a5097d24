use crate::contact::ContactProblem;
use crate::linalg::NodeGraph;
use crate::linalg::multigrid::{Block, Blocks, Nodes};

/// The problem by nodes, the nodes of contact points turned into their frames `(n, t1, t2)`: `K`, `f` and the
/// near-kernel in components for which contact is a matter of single unknowns.
#[derive(Debug)]
pub(super) struct Turned {
    pub nodes: Nodes,
    pub k: Blocks<3, 3>,
    pub f: Vec<[f64; 3]>,
    pub kernel: Vec<[[f64; 6]; 3]>,
    pub points: Vec<Point>,
}

/// A contact point: its node, its frame, and which of its rows of `B` are there at all.
#[derive(Debug)]
pub(super) struct Point {
    pub node: usize,
    /// Rows: normal, tangents; orthonormal on the unknowns of the node.
    frame: Block<3, 3>,
    pub live: [bool; 3],
}

/// Rows of a point are orthonormal to this accuracy.
const ORTHONORMAL: f64 = 1e-9;

impl Turned {
    /// `None` if some point's rows are not an orthonormal frame of one node that no other point has, or a node has
    /// more than three unknowns: the primal path is not for such problems.
    pub fn new(problem: &ContactProblem) -> Option<Turned> {
        let graph = NodeGraph::new(&problem.K, problem.node_of.as_deref());
        let nodes = Nodes::new(&graph, problem.unknowns())?;
        let mut taken = vec![u32::MAX; nodes.count];
        let mut points = Vec::with_capacity(problem.points());
        for j in 0..problem.points() {
            let point = point(problem, &nodes, j)?;
            if std::mem::replace(&mut taken[point.node], j as u32) != u32::MAX {
                return None;
            }
            points.push(point);
        }
        let mut k = nodes.blocks(&problem.K, &graph);
        turn_matrix(&mut k, &taken, &points);
        let mut kernel = vec![[[0.0; 6]; 3]; nodes.count];
        for (i, &(v, c)) in nodes.of.iter().enumerate() {
            let c = c as usize;
            kernel[v as usize][c] = match &problem.near_kernel {
                Some(rows) => rows[i],
                None => std::array::from_fn(|q| f64::from(u8::from(q == c))),
            };
        }
        for p in &points {
            let old = kernel[p.node];
            kernel[p.node] =
                std::array::from_fn(|r| std::array::from_fn(|q| (0..3).map(|c| p.frame[r][c] * old[c][q]).sum()));
        }
        let mut turned = Turned { nodes, k, f: Vec::new(), kernel, points };
        turned.set_load(&problem.f);
        Some(turned)
    }

    /// Another load for the same body.
    pub fn set_load(&mut self, f: &[f64]) {
        self.f = self.nodes.gather(f);
        self.points.iter().for_each(|p| self.f[p.node] = times(&p.frame, &self.f[p.node]));
    }

    /// A vector in the frames as one of unknowns.
    pub fn out_of_frames(&self, x: &[[f64; 3]]) -> Vec<f64> {
        let mut x = x.to_vec();
        for p in &self.points {
            let y = x[p.node];
            x[p.node] = std::array::from_fn(|c| (0..3).map(|r| p.frame[r][c] * y[r]).sum());
        }
        self.nodes.scatter(&x)
    }
}

fn times(a: &Block<3, 3>, x: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| (0..3).map(|c| a[r][c] * x[c]).sum())
}

fn point(problem: &ContactProblem, nodes: &Nodes, j: usize) -> Option<Point> {
    let (mut frame, mut live, mut node) = ([[0.0; 3]; 3], [false; 3], None);
    for (r, i) in problem.rows(j).into_iter().enumerate() {
        let (columns, values) = problem.B.row(i);
        for (&column, &value) in columns.iter().zip(values) {
            let (v, c) = nodes.of[column as usize];
            if *node.get_or_insert(v) != v {
                return None;
            }
            frame[r][c as usize] = value;
            live[r] |= value != 0.0;
        }
    }
    let dot = |a: &[f64; 3], b: &[f64; 3]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    for r in 0..3 {
        for s in 0..=r {
            let expected = f64::from(u8::from(r == s));
            if live[r] && live[s] && (dot(&frame[r], &frame[s]) - expected).abs() > ORTHONORMAL {
                return None;
            }
        }
    }
    // Rows that are not there are filled with what completes the frame.
    for r in (0..3).filter(|&r| !live[r]).collect::<Vec<_>>() {
        let mut best = ([0.0; 3], 0.0);
        for c in 0..3 {
            let mut e = [0.0; 3];
            e[c] = 1.0;
            for s in 0..3 {
                let share = frame[s][c];
                (0..3).for_each(|k| e[k] -= share * frame[s][k]);
            }
            let length = dot(&e, &e).sqrt();
            if length > best.1 {
                best = (e.map(|v| v / length), length);
            }
        }
        frame[r] = best.0;
    }
    Some(Point { node: node? as usize, frame, live })
}

/// `R K Rᵀ` with the frames at the nodes that have one.
fn turn_matrix(k: &mut Blocks<3, 3>, taken: &[u32], points: &[Point]) {
    let frame = |v: usize| points.get(taken[v] as usize).map(|p| &p.frame);
    for i in 0..k.rows {
        for place in k.start[i]..k.start[i + 1] {
            let (left, right) = (frame(i), frame(k.column[place] as usize));
            let block = &mut k.value[place];
            if let Some(left) = left {
                let old = *block;
                *block = std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|s| left[r][s] * old[s][c]).sum()));
            }
            if let Some(right) = right {
                let old = *block;
                *block =
                    std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|s| old[r][s] * right[c][s]).sum()));
            }
        }
    }
}
