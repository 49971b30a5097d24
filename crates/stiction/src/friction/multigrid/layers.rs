//! Interfaces that yield: each of their points is at a node in front of the mesh, which springs tie to one node of it.

use std::collections::HashMap;

use super::points::{OtherNodes, Point};
use crate::linalg::multigrid::{Block, Blocks};
use crate::ranks::Halo;

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
        (columns[own] as usize == v && are_springs).then_some(if own == 0 { b } else { a })
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

/// The same where nodes are divided among ranks: those of this rank, and then those of others among its ghosts.
pub(super) fn tied_here(halo: &Halo, mut tied: Vec<(u32, usize)>, points: &[Point]) -> Vec<(u32, usize)> {
    /// The number of a node in front of none.
    const NONE: u64 = u64::MAX;
    tied.retain(|&(v, _)| (v as usize) < halo.own());
    if halo.is_alone() {
        return tied;
    }
    let mut front = vec![NONE; halo.own()];
    tied.iter().for_each(|&(v, j)| front[v as usize] = halo.global(points[j].node));
    halo.update(&mut front);
    let point_of: HashMap<usize, usize> = points.iter().enumerate().map(|(j, p)| (p.node, j)).collect();
    let of_ghost = |v: usize| Some((v as u32, *point_of.get(&halo.place(front[v])?)?));
    tied.extend((halo.own()..halo.len()).filter_map(of_ghost));
    tied
}

/// What these nodes are measured from: minus the displacement of the point, which is in its frame.
pub(super) fn rows(tied: &[(u32, usize)], points: &[Point]) -> Vec<OtherNodes> {
    let row = |&(_, j): &(u32, usize)| {
        let back = points[j].forces();
        let minus = std::array::from_fn(|c| std::array::from_fn(|r| -back[r][c]));
        vec![(points[j].node as u32, minus)]
    };
    tied.iter().map(row).collect()
}

fn trace(a: &Block<3, 3>) -> f64 {
    a[0][0] + a[1][1] + a[2][2]
}
