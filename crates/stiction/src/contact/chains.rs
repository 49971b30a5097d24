//! Which nodes contact points hang on, from one surface to the next.

use std::collections::{HashMap, HashSet};

use super::points::Point;

/// The nodes that the points of some surfaces hang on. Along them no node leads back to itself: both sides of a pair would be
/// held to one another twice.
#[derive(Default)]
pub(super) struct Chains {
    /// Of the node of each point those that it hangs on.
    others: HashMap<u32, Vec<u32>>,
    /// Of each of these the nodes of the points.
    hanging: HashMap<u32, Vec<u32>>,
}

impl Chains {
    /// Adds points of a surface.
    pub(super) fn add(&mut self, points: &[Point]) {
        for point in points {
            others(point).for_each(|other| self.hanging.entry(other).or_default().push(point.node));
            self.others.entry(point.node).or_default().extend(others(point));
        }
    }

    /// Whether there are no points.
    pub(super) fn is_empty(&self) -> bool {
        self.others.is_empty()
    }

    /// Whether a node has a point, or a point of a node of `opposite` hangs on it: where two pairs have points on either side of the same
    /// surfaces, those at the border stand for the same faces.
    pub(super) fn is_taken(&self, node: u32, opposite: &HashSet<u32>) -> bool {
        let hanging = self.hanging.get(&node).into_iter().flatten();
        self.others.contains_key(&node) || hanging.into_iter().any(|other| opposite.contains(other))
    }

    /// The nodes of further points that lead back to themselves: without points there none does.
    pub(super) fn closed_by(&self, points: &[Point]) -> Vec<u32> {
        let ends: Vec<&Point> = points.iter().filter(|point| self.hanging.contains_key(&point.node)).collect();
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
