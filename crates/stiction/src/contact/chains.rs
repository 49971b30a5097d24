//! Which nodes contact points hang on, from one surface to the next.

use rustc_hash::{FxHashMap, FxHashSet};

use super::points::Point;

/// Along a cycle of points the weights by which they hang on one another fade by this factor at least from point to point. Each of two
/// contacts then carries for nodes of the other, beside their border: no constraint follows from others. Those of both sides of a pair do
/// not fade.
const FADING: f64 = 0.7;
/// Points after which the factor is taken.
const LINKS: usize = 32;

/// The nodes that the points of some surfaces hang on. Along them no node leads back to itself but in a cycle that [fades](FADING): both
/// sides of a pair would be held to one another twice.
#[derive(Default)]
pub(super) struct Chains {
    /// Of the node of each point those that it hangs on, with their weights.
    others: FxHashMap<u32, Vec<(u32, f64)>>,
    /// Of each of these the nodes of the points.
    hanging: FxHashMap<u32, Vec<u32>>,
}

impl Chains {
    /// Adds points of a surface.
    pub(super) fn add(&mut self, points: &[Point]) {
        for point in points {
            others(point).for_each(|(other, _)| self.hanging.entry(other).or_default().push(point.node));
            self.others.entry(point.node).or_default().extend(others(point));
        }
    }

    /// Whether there are no points.
    pub(super) fn is_empty(&self) -> bool {
        self.others.is_empty()
    }

    /// Whether a node has a point, or a point of a node of `opposite` hangs on it: where two pairs have points on either side of the same
    /// surfaces, those at the border stand for the same faces.
    pub(super) fn is_taken(&self, node: u32, opposite: &FxHashSet<u32>) -> bool {
        let hanging = self.hanging.get(&node).into_iter().flatten();
        self.others.contains_key(&node) || hanging.into_iter().any(|other| opposite.contains(other))
    }

    /// The nodes of further points that lead back to themselves, and do not [fade](FADING): without points there none does.
    pub(super) fn closed_by(&self, points: &[Point]) -> Vec<u32> {
        let ends: Vec<&Point> = points.iter().filter(|point| self.hanging.contains_key(&point.node)).collect();
        if ends.is_empty() {
            return Vec::new();
        }
        let new: FxHashMap<u32, &Point> = points.iter().map(|point| (point.node, point)).collect();
        let links = |node: u32| {
            let old = self.others.get(&node).into_iter().flatten().copied();
            old.chain(new.get(&node).into_iter().flat_map(|point| others(point)))
        };
        let mut is_closed: FxHashMap<u32, bool> = FxHashMap::default();
        for end in &ends {
            if is_closed.contains_key(&end.node) {
                continue;
            }
            let cycle = cycle(end.node, &links);
            let closed = factor(&cycle, &links) > FADING;
            is_closed.insert(end.node, closed);
            is_closed.extend(cycle.into_iter().map(|node| (node, closed)));
        }
        ends.iter().map(|end| end.node).filter(|node| is_closed[node]).collect()
    }
}

/// The nodes to which links lead from a node, and from which they lead back to it.
fn cycle<I: Iterator<Item = (u32, f64)>>(node: u32, links: &impl Fn(u32) -> I) -> FxHashSet<u32> {
    let mut back: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let (mut seen, mut open) = (FxHashSet::from_iter([node]), vec![node]);
    while let Some(at) = open.pop() {
        for (other, _) in links(at) {
            back.entry(other).or_default().push(at);
            if seen.insert(other) {
                open.push(other);
            }
        }
    }
    let (mut cycle, mut open) = (FxHashSet::default(), vec![node]);
    while let Some(at) = open.pop() {
        open.extend(back.get(&at).into_iter().flatten().filter(|&&from| cycle.insert(from)));
    }
    cycle
}

/// By which factor weights fade along a cycle, from above: the powers of their sizes, applied to ones, grow with the spectral radius.
fn factor<I: Iterator<Item = (u32, f64)>>(cycle: &FxHashSet<u32>, links: &impl Fn(u32) -> I) -> f64 {
    let mut sizes: FxHashMap<u32, f64> = cycle.iter().map(|&node| (node, 1.0)).collect();
    for _ in 0..LINKS {
        let sum = |node: u32| links(node).map(|(other, weight)| weight.abs() * sizes.get(&other).unwrap_or(&0.0)).sum();
        sizes = cycle.iter().map(|&node| (node, sum(node))).collect();
    }
    sizes.into_values().fold(0.0, f64::max).powf(1.0 / LINKS as f64)
}

fn others(point: &Point) -> impl Iterator<Item = (u32, f64)> {
    point.others.iter().copied().chain(point.beyond_cut.iter().map(|other| (other.0, other.1)))
}
