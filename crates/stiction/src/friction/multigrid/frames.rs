use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::rigid::{RigidMotions, rigid_motions};
use crate::linalg::NodeGraph;
use crate::linalg::multigrid::{Block, Blocks, Coupling, Kernel, Multigrid, Nodes};

/// The problem by nodes, the nodes of contact points turned into their frames `(n, t1, t2)` and, between bodies, counted
/// from what they may touch: `K`, `f` and the near-kernel in components for which contact is a matter of single unknowns.
#[derive(Debug)]
pub(super) struct Turned {
    pub nodes: Nodes,
    pub k: Blocks<3, 3>,
    pub f: Vec<[f64; 3]>,
    pub points: Vec<Point>,
    /// Where rows of `B` reach other nodes than the point's own.
    coupling: Option<Coupling>,
    /// Of the bodies that contact alone holds.
    pub motions: RigidMotions,
}

/// A contact point: its node, its frame, and which of its rows of `B` are there at all.
#[derive(Debug)]
pub(super) struct Point {
    pub node: usize,
    /// Rows: normal, tangents; orthonormal on the unknowns of the node.
    frame: Block<3, 3>,
    /// Displacements along the rows are counted in these multiples, forces in their inverses: friction across the first
    /// tangent over that along it turns its ellipse into a disc.
    pub scale: [f64; 3],
    pub live: [bool; 3],
    /// Displacement over force of the point's own node and those it is coupled to, as the levels of the hierarchy tell it.
    pub flexibility: f64,
    /// Whether it may hold a body that floats: such a point is taken for closed at first, unless the body starts at rest.
    pub floats: bool,
}

/// Why the primal path is not for a problem.
fn refused(what: &str) -> Error {
    Error::new("", what, "leave `settings.path` at auto")
}

fn on_stiff_body() -> Error {
    let what = "contact points lie on a body some hundred times stiffer than the one they touch, which multigrid solves \
                slowly or not";
    let remedy = "put the points (the rows of `contact.B`) on the softer body, or leave `settings.path` at auto";
    Error::new("", what, remedy)
}

/// Nodes so many times stiffer than those their displacements are counted from. A soft node then carries stiff ones along
/// wherever they may slide, and no sweep by nodes smooths its motion: cycles double from a ratio of ten to a hundred, and
/// several hundred are needed beyond.
const MUCH_STIFFER: f64 = 100.0;
/// Share of the points between bodies of which that may be so: single nodes at an edge say nothing.
const FEW: f64 = 0.25;

/// Whether many points are counted from much softer nodes than their own.
fn on_stiff_bodies(k: &Blocks<3, 3>, points: &[Point], others: &[Others]) -> bool {
    let coupled = others.iter().filter(|o| !o.is_empty()).count();
    let stiff = |(p, others): &(&Point, &Others)| {
        let (mut soft, mut all) = (0.0, 0.0);
        for (v, block) in others.iter() {
            let weight: f64 = block.iter().flatten().map(|c| c * c).sum();
            soft += weight * trace(&k.diagonal(*v as usize));
            all += weight;
        }
        all > 0.0 && trace(&k.diagonal(p.node)) * all > MUCH_STIFFER * soft
    };
    points.iter().zip(others).filter(stiff).count() as f64 > FEW * coupled as f64
}

/// Rows of a point are orthonormal to this accuracy.
const ORTHONORMAL: f64 = 1e-9;

/// The other nodes of a point's rows, each with its block of `B`.
type Others = Vec<(u32, Block<3, 3>)>;

impl Turned {
    /// The problem turned, and the multigrid hierarchy of its matrix.
    ///
    /// # Errors
    /// What the primal path is not for: a point without a node of its own on which its rows are an orthonormal frame
    /// (own: no other point's rows reach it) or on a much stiffer body than the one it touches, nodes with more than three
    /// unknowns, a matrix that does not get coarser.
    pub fn new(problem: &ContactProblem) -> Result<(Turned, Multigrid), Error> {
        let graph = NodeGraph::of_symmetric(&problem.elastic.K, problem.elastic.node_of.as_deref());
        let nodes =
            Nodes::new(&graph, problem.unknowns()).ok_or_else(|| refused("a node has more than three unknowns"))?;
        let (mut points, others) = points(problem, &nodes)
            .ok_or_else(|| refused("the multigrid path is for contact points that each have a node of their own"))?;
        let mut frame_of = vec![u32::MAX; nodes.count];
        points.iter().enumerate().for_each(|(j, p)| frame_of[p.node] = j as u32);
        let mut k = nodes.blocks(&problem.elastic.K, &graph);
        if on_stiff_bodies(&k, &points, &others) {
            return Err(on_stiff_body());
        }
        turn_matrix(&mut k, &frame_of, &points);
        let mut others: Vec<Others> = others.into_iter().map(|o| turned(o, &frame_of, &points)).collect();
        let kernel = kernel(problem, &nodes, &points);
        let own: Vec<u32> = points.iter().map(|p| p.node as u32).collect();
        // What is counted from other nodes gives way through them as well. This is about the body, not about its friction.
        let give = |v: usize, scale: [f64; 3], stiffness: f64, k: &Blocks<3, 3>| {
            let d = k.diagonal(v);
            stiffness / (0..3).map(|c| d[c][c] * scale[c] * scale[c]).sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let square = |b: &Block<3, 3>| b.iter().flatten().map(|v| v * v).sum::<f64>();
        for (p, others) in points.iter_mut().zip(&others) {
            p.flexibility = others.iter().map(|(v, b)| give(*v as usize, [1.0; 3], square(b), &k)).sum();
        }
        if points.iter().any(|p| p.scale != [1.0; 3]) {
            scale_matrix(&mut k, &frame_of, &points);
            scale_others(&mut others, &frame_of, &points);
        }
        let coupled = others.iter().any(|o| !o.is_empty());
        let coupling = coupled.then(|| Coupling::new(own.clone(), &others, nodes.count));
        let multigrid = Multigrid::new(&mut k, &kernel, &own, coupling.as_ref())
            .ok_or_else(|| refused("the stiffness matrix does not get coarser by aggregation"))?;
        // What others count from is stiffer or softer now: the function of the corner of a quadratic face grows.
        for (p, coarse) in points.iter_mut().zip(multigrid.coarse_flexibilities()) {
            let coarse = (0..3).map(|c| coarse[c] / (3.0 * p.scale[c] * p.scale[c])).sum::<f64>();
            p.flexibility += give(p.node, p.scale, 3.0, &k) + coarse;
        }
        let motions = if multigrid.is_singular() { rigid_motions(problem) } else { RigidMotions::default() };
        if !motions.is_empty() {
            let mut floating = vec![false; problem.unknowns()];
            motions.bodies.iter().flat_map(|b| &b.unknowns).for_each(|&i| floating[i as usize] = true);
            for (j, p) in points.iter_mut().enumerate() {
                let reached = |i: usize| problem.contact.B.row(i).0.iter().any(|&c| floating[c as usize]);
                p.floats = problem.rows(j).into_iter().any(reached);
            }
        }
        let mut turned = Turned { nodes, k, f: Vec::new(), points, coupling, motions };
        turned.set_load(&problem.elastic.f);
        Ok((turned, multigrid))
    }

    /// Another load for the same body.
    pub fn set_load(&mut self, f: &[f64]) {
        self.f = self.nodes.gather(f);
        for p in &self.points {
            let turned = times(&p.frame, &self.f[p.node]);
            self.f[p.node] = std::array::from_fn(|r| turned[r] / p.scale[r]);
        }
        if let Some(coupling) = &self.coupling {
            coupling.forces(&mut self.f);
        }
    }

    /// Displacements of unknowns in the frames.
    pub fn to_frames(&self, u: &[f64]) -> Vec<[f64; 3]> {
        let mut x = self.nodes.gather(u);
        for p in &self.points {
            let turned = times(&p.frame, &x[p.node]);
            x[p.node] = std::array::from_fn(|r| turned[r] * p.scale[r]);
        }
        if let Some(coupling) = &self.coupling {
            coupling.to_relative(&mut x);
        }
        x
    }

    /// The inverse of [`Self::to_frames`].
    pub fn out_of_frames(&self, x: &[[f64; 3]]) -> Vec<f64> {
        let mut x = x.to_vec();
        if let Some(coupling) = &self.coupling {
            coupling.to_absolute(&mut x);
        }
        for p in &self.points {
            let y: [f64; 3] = std::array::from_fn(|r| x[p.node][r] / p.scale[r]);
            x[p.node] = std::array::from_fn(|c| (0..3).map(|r| p.frame[r][c] * y[r]).sum());
        }
        self.nodes.scatter(&x)
    }
}

fn trace(a: &Block<3, 3>) -> f64 {
    a[0][0] + a[1][1] + a[2][2]
}

/// The near-kernel by nodes, in the frames.
fn kernel(problem: &ContactProblem, nodes: &Nodes, points: &[Point]) -> Vec<Kernel<3>> {
    let mut kernel = vec![[[0.0; 6]; 3]; nodes.count];
    for (i, &(v, c)) in nodes.of.iter().enumerate() {
        let c = c as usize;
        kernel[v as usize][c] = match &problem.elastic.near_kernel {
            Some(rows) => rows[i],
            None => std::array::from_fn(|q| f64::from(u8::from(q == c))),
        };
    }
    for p in points {
        let old = kernel[p.node];
        kernel[p.node] = std::array::from_fn(|r| {
            std::array::from_fn(|q| (0..3).map(|c| p.scale[r] * p.frame[r][c] * old[c][q]).sum())
        });
    }
    kernel
}

fn times(a: &Block<3, 3>, x: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| (0..3).map(|c| a[r][c] * x[c]).sum())
}

/// The points with the other nodes they are coupled to; `None` if one has no node of its own.
///
/// Own is a node that no other point's rows reach, or the only one a point reaches: rows of others may count from such a
/// node, as those of the middle of a quadratic face's edge do from its ends, but nothing is counted from what is itself
/// counted from something.
fn points(problem: &ContactProblem, nodes: &Nodes) -> Option<(Vec<Point>, Vec<Others>)> {
    let blocks: Vec<Others> = (0..problem.points()).map(|j| blocks(problem, nodes, j)).collect();
    let mut reached = vec![0u32; nodes.count];
    blocks.iter().flatten().for_each(|(v, _)| reached[*v as usize] += 1);
    let rows = problem.isotropic_rows();
    let mut taken = vec![false; nodes.count];
    let mut points = Vec::with_capacity(blocks.len());
    let mut others = Vec::with_capacity(blocks.len());
    for (j, mut blocks) in blocks.into_iter().enumerate() {
        let live = problem.rows(j).map(|i| rows.row(i).1.iter().any(|&v| v != 0.0));
        // A tangent without friction is no row of the law but one of the frame, which others are counted along.
        let there = problem.rows(j).map(|i| problem.contact.B.row(i).1.iter().any(|&v| v != 0.0));
        let alone = blocks.len() == 1;
        let is_own = |v: u32| if alone { !taken[v as usize] } else { reached[v as usize] == 1 };
        let own = blocks.iter().position(|(v, block)| is_own(*v) && is_frame(block, &there))?;
        let (node, mut frame) = blocks.swap_remove(own);
        taken[node as usize] = true;
        complete(&mut frame, &there);
        let scale = [1.0, 1.0, if live[2] { problem.across(j) } else { 1.0 }];
        points.push(Point { node: node as usize, frame, scale, live, flexibility: 0.0, floats: false });
        others.push(blocks);
    }
    Some((points, others))
}

/// The rows of a point by nodes.
fn blocks(problem: &ContactProblem, nodes: &Nodes, j: usize) -> Others {
    let mut blocks: Others = Vec::new();
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

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The blocks for displacements in the frames of those of the nodes that have one.
fn turned(others: Others, frame_of: &[u32], points: &[Point]) -> Others {
    let turn = |(v, block): (u32, Block<3, 3>)| match points.get(frame_of[v as usize] as usize) {
        Some(Point { frame, .. }) => {
            let entry = |r: usize, c: usize| (0..3).map(|s| block[r][s] * frame[c][s]).sum();
            (v, std::array::from_fn(|r| std::array::from_fn(|c| entry(r, c))))
        }
        None => (v, block),
    };
    others.into_iter().map(turn).collect()
}

/// Whether the rows that are there are orthonormal.
fn is_frame(block: &Block<3, 3>, there: &[bool; 3]) -> bool {
    (0..3).all(|r| {
        (0..=r).all(|s| {
            let expected = f64::from(u8::from(r == s));
            !(there[r] && there[s]) || (dot(&block[r], &block[s]) - expected).abs() <= ORTHONORMAL
        })
    })
}

/// Fills rows that are not there with what completes the frame.
fn complete(frame: &mut Block<3, 3>, there: &[bool; 3]) {
    for r in (0..3).filter(|&r| !there[r]) {
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

/// `S⁻¹ K S⁻¹` with the scales at the nodes that have them.
fn scale_matrix(k: &mut Blocks<3, 3>, taken: &[u32], points: &[Point]) {
    let scale = |v: usize| points.get(taken[v] as usize).map_or([1.0; 3], |p| p.scale);
    for i in 0..k.rows {
        for place in k.start[i]..k.start[i + 1] {
            let (left, right) = (scale(i), scale(k.column[place] as usize));
            let block = &mut k.value[place];
            (0..3).for_each(|r| (0..3).for_each(|c| block[r][c] /= left[r] * right[c]));
        }
    }
}

/// The blocks for displacements counted in the multiples of their own points and of the nodes they reach.
fn scale_others(others: &mut [Others], taken: &[u32], points: &[Point]) {
    for (p, others) in points.iter().zip(others) {
        for (v, block) in others {
            let reached = points.get(taken[*v as usize] as usize).map_or([1.0; 3], |p| p.scale);
            (0..3).for_each(|r| (0..3).for_each(|c| block[r][c] *= p.scale[r] / reached[c]));
        }
    }
}
