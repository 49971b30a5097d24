//! Interfaces that yield: each of their points is at a node in front of the mesh, which springs tie to one node of it.

use super::points::Point;
use crate::linalg::multigrid::{Block, Blocks};

/// Springs that are stiffer than this part of what else holds the node of the mesh tie it.
const STIFF: f64 = 1.0;
/// Entries of springs are equal to this accuracy.
const ROUNDING: f64 = 1e-9;

/// For each node the other one that springs tie it to, if there is nothing else at it; `k` has the rows of the nodes, not yet in frames.
pub(super) fn layers(k: &Blocks<3, 3>) -> Vec<Option<u32>> {
    let partner = |v: usize| {
        let (columns, blocks) = k.row(v);
        let &[a, b] = columns else { return None };
        let (own, other) = if a as usize == v { (0, 1) } else { (1, 0) };
        let largest = blocks[own].iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        let pairs = blocks[own].iter().flatten().zip(blocks[other].iter().flatten());
        let are_springs = pairs.into_iter().all(|(x, y)| (x + y).abs() <= ROUNDING * largest);
        (columns[own] as usize == v && are_springs).then(|| if own == 0 { b } else { a })
    };
    (0..k.rows).map(partner).collect()
}

/// What holds the node of a point: the springs of a layer and what is behind them in series, so that the softer of both counts; force
/// per length.
pub(super) fn stiffness(k: &Blocks<3, 3>, layers: &[Option<u32>], node: usize) -> f64 {
    let own = trace(&k.diagonal(node));
    match layers.get(node).copied().flatten() {
        Some(behind) => own.min(trace(&k.diagonal(behind as usize)) - own),
        None => own,
    }
}

/// The nodes of the mesh behind stiff springs, each with the place of the point in front of it. They are measured from the point: as
/// nodes of their own, displacements of both would have to change together, which sweeps by nodes do not.
pub(super) fn tied(k: &Blocks<3, 3>, layers: &[Option<u32>], points: &[Point]) -> Vec<(u32, usize)> {
    let mut taken: Vec<bool> = vec![false; k.rows];
    points.iter().for_each(|p| taken[p.node] = true);
    let mut tied = Vec::new();
    for (j, p) in points.iter().enumerate() {
        let Some(behind) = layers[p.node] else { continue };
        let springs = trace(&k.diagonal(p.node));
        let body = trace(&k.diagonal(behind as usize)) - springs;
        if springs > STIFF * body && !std::mem::replace(&mut taken[behind as usize], true) {
            tied.push((behind, j));
        }
    }
    tied
}

/// Minus the displacement of a point, which is in its frame: what takes it off that of a node.
pub(super) fn minus(p: &Point) -> Block<3, 3> {
    let back = p.forces();
    std::array::from_fn(|c| std::array::from_fn(|r| -back[r][c]))
}

fn trace(a: &Block<3, 3>) -> f64 {
    a[0][0] + a[1][1] + a[2][2]
}
