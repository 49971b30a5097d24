//! Interfaces that yield: each of their points is at a node in front of the mesh, which springs tie to one node of it.

use std::collections::HashMap;

use super::points::{OtherNodes, Point, compliance};
use crate::linalg::multigrid::{Block, Blocks};
use crate::ranks::Halo;

/// Springs that are stiffer than this many times what else holds the node of the mesh tie it. With 1 a block on a plane whose interface
/// yields along the surface a hundred times as much as across it, at 1e5 N/mm³, takes 79 cycles instead of 14: there some of its nodes
/// are tied and others not.
const STIFF: f64 = 4.0;
/// Entries of springs are equal to this accuracy.
const ROUNDING: f64 = 1e-9;

/// What is behind a node of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Behind {
    pub node: u32,
    /// For each unknown of that node the one of the layer that springs tie it to. Where a support holds a component behind, the springs
    /// end there.
    to: [Option<usize>; 3],
}

/// For each node the other one that springs tie it to, if there is nothing else at it; `k` has the rows of the nodes, not yet in frames.
pub(super) fn layers(k: &Blocks<3, 3>) -> Vec<Option<Behind>> {
    (0..k.rows).map(|v| behind(k, v)).collect()
}

fn behind(k: &Blocks<3, 3>, v: usize) -> Option<Behind> {
    let (columns, blocks) = k.row(v);
    let &[a, b] = columns else { return None };
    let (node, own, other) = if a as usize == v { (b, &blocks[0], &blocks[1]) } else { (a, &blocks[1], &blocks[0]) };
    let least = ROUNDING * own.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let mut to = [None; 3];
    for c in (0..3).filter(|&c| other.iter().any(|row| row[c] != 0.0)) {
        let is_minus = |&d: &usize| own.iter().zip(other).all(|(x, y)| (x[d] + y[c]).abs() <= least);
        to[c] = Some((0..3).find(is_minus)?);
    }
    ((node as usize) < k.rows && to != [None; 3]).then_some(Behind { node, to })
}

/// What springs a node of a layer and what else the node behind it is held by, along the unknowns that they tie; force per length.
fn held(k: &Blocks<3, 3>, node: usize, Behind { node: behind, to }: Behind) -> [f64; 2] {
    let (springs, whole) = (k.diagonal(node), k.diagonal(behind as usize));
    let sum = |of: &dyn Fn(usize, usize) -> f64| (0..3).filter_map(|c| Some(of(c, to[c]?))).sum::<f64>();
    [sum(&|_, d| springs[d][d]), sum(&|c, d| whole[c][c] - springs[d][d])]
}

/// What holds the node of a point: the springs of a layer and what is behind them in series, so that the softer of both counts; force
/// per length.
pub(super) fn stiffness(k: &Blocks<3, 3>, layers: &[Option<Behind>], node: usize) -> f64 {
    match layers.get(node).copied().flatten() {
        Some(behind) => held(k, node, behind).into_iter().fold(f64::INFINITY, f64::min),
        None => {
            let own = k.diagonal(node);
            own[0][0] + own[1][1] + own[2][2]
        }
    }
}

/// A node of the mesh behind stiff springs, and the place of the point in front of it. It is measured from the point: as nodes of their
/// own, displacements of both would have to change together, which sweeps by nodes do not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tied {
    pub behind: Behind,
    pub point: usize,
    /// The axes of the frame of the point along which the springs are stiff: an interface may yield along the surface alone.
    along: [bool; 3],
    /// Displacement over force of the springs, which the diagonal block of the point does not have any more; length/newton.
    pub compliance: f64,
}

/// Along which axes of the frame of a point the springs to the node behind it are stiffer than what else holds that.
fn stiff_axes(k: &Blocks<3, 3>, p: &Point, Behind { node, to }: Behind) -> [bool; 3] {
    let (springs, whole) = (k.diagonal(p.node), k.diagonal(node as usize));
    p.frame.map(|axis| {
        let along = |c: usize| to[c].map_or(0.0, |d| axis[d]);
        let quadratic = |a: &Block<3, 3>, x: [f64; 3]| -> f64 {
            a.iter().zip(x).map(|(row, x_r)| x_r * row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>()).sum()
        };
        let by_springs = quadratic(&springs, axis);
        let all = quadratic(&whole, std::array::from_fn(along));
        (0..3).any(|c| along(c) != 0.0) && by_springs > STIFF * (all - by_springs)
    })
}

/// Those behind these points.
pub(super) fn tied(k: &Blocks<3, 3>, layers: &[Option<Behind>], points: &[Point]) -> Vec<Tied> {
    let mut taken: Vec<bool> = vec![false; k.rows];
    points.iter().for_each(|p| taken[p.node] = true);
    let mut tied = Vec::new();
    for (point, p) in points.iter().enumerate() {
        let Some(behind) = layers[p.node] else { continue };
        let along = stiff_axes(k, p, behind);
        if along != [false; 3] && !std::mem::replace(&mut taken[behind.node as usize], true) {
            let compliance = compliance(&k.diagonal(p.node), [1.0; 3], 3.0);
            tied.push(Tied { behind, point, along, compliance });
        }
    }
    tied
}

/// The same where nodes are divided among ranks: those of this rank, and then those of others among its ghosts.
pub(super) fn tied_here(halo: &Halo, layers: &[Option<Behind>], mut tied: Vec<Tied>, points: &[Point]) -> Vec<Tied> {
    /// The number of a node in front of none.
    const NONE: u64 = u64::MAX;
    tied.retain(|tied| (tied.behind.node as usize) < halo.own());
    if halo.is_alone() {
        return tied;
    }
    // Whose row is complete here alone knows along what; an axis is a power of two.
    let axes = |along: [bool; 3]| (0..3).map(|r| u64::from(along[r]) << r).sum::<u64>();
    let (mut front, mut along) = (vec![NONE; halo.own()], vec![0; halo.own()]);
    for tied in &tied {
        let v = tied.behind.node as usize;
        (front[v], along[v]) = (halo.global(points[tied.point].node), axes(tied.along));
    }
    halo.update(&mut front);
    halo.update(&mut along);
    let point_of: HashMap<usize, usize> = points.iter().enumerate().map(|(j, p)| (p.node, j)).collect();
    let of_ghost = |v: usize| {
        let node = halo.place(front[v])?;
        let along = std::array::from_fn(|r| along[v] >> r & 1 == 1);
        Some(Tied { behind: layers[node]?, point: *point_of.get(&node)?, along, compliance: 0.0 })
    };
    tied.extend((halo.own()..halo.len()).filter_map(of_ghost));
    tied
}

/// What these nodes are measured from: minus the displacement of the point, which is in its frame, along the axes of stiff springs.
pub(super) fn rows(tied: &[Tied], points: &[Point]) -> Vec<OtherNodes> {
    let row = |tied: &Tied| {
        let (p, to) = (&points[tied.point], tied.behind.to);
        let back = p.forces();
        let minus = |c: usize, r: usize| to[c].filter(|_| tied.along[r]).map_or(0.0, |d| -back[r][d]);
        let minus = std::array::from_fn(|c| std::array::from_fn(|r| minus(c, r)));
        vec![(p.node as u32, minus)]
    };
    tied.iter().map(row).collect()
}
