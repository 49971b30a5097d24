//! Which nodes contact points hang on, from one surface to the next.

use std::collections::{HashMap, HashSet};

use super::points::Point;

/// The nodes that the points of some surfaces hang on. Along them no node leads back to itself: both sides of a pair would be
/// held to one another twice.
#[derive(Default)]
pub(super) struct Chains {
    others: HashMap<u32, Vec<u32>>,
    ends: HashSet<u32>,
}

impl Chains {
    /// Adds points of a surface.
    pub(super) fn add(&mut self, points: &[Point]) {
        for point in points {
            self.ends.extend(others(point));
            self.others.entry(point.node).or_default().extend(others(point));
        }
    }

    /// Whether a node has a point.
    pub(super) fn has_point(&self, node: u32) -> bool {
        self.others.contains_key(&node)
    }

    /// Whether a point hangs on a node.
    pub(super) fn is_end(&self, node: u32) -> bool {
        self.ends.contains(&node)
    }

    /// The nodes of further points that lead back to themselves: without points there none does.
    pub(super) fn closed_by(&self, points: &[Point]) -> Vec<u32> {
        let ends: Vec<&Point> = points.iter().filter(|point| self.is_end(point.node)).collect();
        if ends.is_empty() {
            return Vec::new();
        }
        let new: HashMap<u32, &Point> = points.iter().map(|point| (point.node, point)).collect();
        let closes = |point: &&Point| {
            let (mut seen, mut reached) = (HashSet::new(), others(point).collect::<Vec<u32>>());
            while let Some(node) = reached.pop() {
                if node == point.node {
                    return true;
                }
                if seen.insert(node) {
                    reached.extend(self.others.get(&node).into_iter().flatten());
                    reached.extend(new.get(&node).into_iter().flat_map(|point| others(point)));
                }
            }
            false
        };
        ends.into_iter().filter(closes).map(|point| point.node).collect()
    }
}

fn others(point: &Point) -> impl Iterator<Item = u32> {
    point.others.iter().map(|other| other.0).chain(point.beyond_cut.iter().map(|other| other.0))
}
