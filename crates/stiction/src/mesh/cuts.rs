//! Parts of equal weight by recursive bisection, of nodes that ranks hold some of each.

use std::ops::Range;

use crate::ranks::{Ranks, max, sum};

/// A node to be divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedNode {
    /// Its coordinates, length.
    pub place: [f64; 3],
    /// Its number in the whole; no other has it.
    pub number: u64,
    /// What it counts: a whole number, so that sums are the same in any order.
    pub weight: f64,
}

/// The cuts that divide space into parts: across the longest extent of the nodes into halves of equal weight, again and again.
/// Nodes at the same coordinate are divided by their numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Cuts {
    branches: Vec<Branch>,
}

#[derive(Debug, Clone, PartialEq)]
struct Branch {
    parts: Range<u32>,
    axis: usize,
    /// The first that is beyond the cut; all are before it without one.
    at: Option<Key>,
    /// The branch before the cut, which the one beyond follows.
    next: usize,
}

/// What nodes are put in order by: a number that grows with the coordinate, and that of the node.
type Key = [u64; 2];

/// Values that a byte has.
const BYTE: usize = 256;

fn key(node: &WeightedNode, axis: usize) -> Key {
    let bits = node.place[axis].to_bits();
    // As `f64::total_cmp` puts them in order.
    [if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }, node.number]
}

fn byte(key: Key, digit: usize) -> usize {
    (key[digit / 8] >> (56 - 8 * (digit % 8)) & 0xff) as usize
}

impl Cuts {
    /// The cuts into so many parts, the same on every rank: each gives the nodes it has, and no other gives them.
    ///
    /// The order of a cut is found by its bytes, from the highest: the weights of the 256 values that the next one has are added
    /// over all ranks, so that none of them needs the nodes of another.
    pub fn new(ranks: &dyn Ranks, nodes: &[WeightedNode], parts: usize) -> Cuts {
        let mut highest = [nodes.iter().map(|node| node.number).max().unwrap_or_default() as f64];
        max(ranks, &mut highest);
        // Bytes of numbers that are zero in all of them decide nothing.
        let zeros = (highest[0] as u64).leading_zeros() as usize / 8;
        let digits: Vec<usize> = (0..8).chain(8 + zeros..16).collect();
        let mut cuts = Cuts { branches: vec![Branch::of(0..parts as u32)] };
        let mut branch_of = vec![0u32; nodes.len()];
        let mut level = 0..1;
        while cuts.branches[level.clone()].iter().any(Branch::is_cut) {
            cuts.cut(ranks, nodes, &branch_of, level.clone(), &digits);
            for (branch, node) in branch_of.iter_mut().zip(nodes) {
                *branch = cuts.branches[*branch as usize].follow(node).unwrap_or(*branch as usize) as u32;
            }
            level = level.end..cuts.branches.len();
        }
        cuts
    }

    /// Cuts the branches of a level.
    fn cut(
        &mut self,
        ranks: &dyn Ranks,
        nodes: &[WeightedNode],
        branch_of: &[u32],
        level: Range<usize>,
        digits: &[usize],
    ) {
        let slot = |node: u32| (branch_of[node as usize] as usize).checked_sub(level.start);
        let cut = |&node: &u32| slot(node).is_some_and(|k| self.branches[level.start + k].is_cut());
        let mut left: Vec<u32> = (0..nodes.len() as u32).filter(cut).collect();
        let slot = |node: u32| branch_of[node as usize] as usize - level.start;
        let (mut bounds, mut wholes) = (vec![f64::NEG_INFINITY; 6 * level.len()], vec![0.0; level.len()]);
        for &node in &left {
            let (k, place) = (slot(node), nodes[node as usize].place);
            wholes[k] += nodes[node as usize].weight;
            for (c, x) in place.into_iter().enumerate() {
                bounds[6 * k + c] = bounds[6 * k + c].max(-x);
                bounds[6 * k + 3 + c] = bounds[6 * k + 3 + c].max(x);
            }
        }
        max(ranks, &mut bounds);
        sum(ranks, &mut wholes);
        let axis = |bounds: &[f64]| {
            let extent = |c: usize| bounds[3 + c] + bounds[c];
            (0..3).fold(0, |best, c| if extent(c) > extent(best) { c } else { best })
        };
        let axes: Vec<usize> = bounds.chunks_exact(6).map(axis).collect();
        let wanted: Vec<f64> = (self.branches[level.clone()].iter().zip(&wholes))
            .map(|(branch, whole)| whole * f64::from(branch.middle() - branch.parts.start) / branch.parts.len() as f64)
            .collect();
        // The bytes of the first node with which the weight is more than wanted, and the weight before those that begin so.
        let (mut keys, mut before) = (vec![Some([0u64; 2]); level.len()], vec![0.0; level.len()]);
        for &digit in digits {
            let mut weights = vec![0.0; BYTE * level.len()];
            for &node in &left {
                let k = slot(node);
                weights[BYTE * k + byte(key(&nodes[node as usize], axes[k]), digit)] += nodes[node as usize].weight;
            }
            sum(ranks, &mut weights);
            let mut chosen = vec![BYTE; level.len()];
            for (k, weights) in weights.chunks_exact(BYTE).enumerate() {
                let exceeds = |weight: &f64| {
                    let more = before[k] + weight > wanted[k];
                    before[k] += if more { 0.0 } else { *weight };
                    more
                };
                chosen[k] = weights.iter().position(exceeds).unwrap_or(BYTE);
                let shift = 56 - 8 * (digit % 8);
                keys[k] = keys[k].filter(|_| chosen[k] < BYTE).map(|mut key| {
                    key[digit / 8] |= (chosen[k] as u64) << shift;
                    key
                });
            }
            left.retain(|&node| {
                let k = slot(node);
                byte(key(&nodes[node as usize], axes[k]), digit) == chosen[k]
            });
        }
        for (k, number) in level.enumerate() {
            if self.branches[number].is_cut() {
                let (next, middle) = (self.branches.len(), self.branches[number].middle());
                let parts = self.branches[number].parts.clone();
                self.branches.extend([Branch::of(parts.start..middle), Branch::of(middle..parts.end)]);
                self.branches[number] = Branch { parts, axis: axes[k], at: keys[k], next };
            }
        }
    }

    /// The part that a node is in.
    pub fn part(&self, place: [f64; 3], number: u64) -> u32 {
        let node = WeightedNode { place, number, weight: 0.0 };
        let mut branch = &self.branches[0];
        while let Some(next) = branch.follow(&node) {
            branch = &self.branches[next];
        }
        branch.parts.start
    }
}

impl Branch {
    fn of(parts: Range<u32>) -> Branch {
        Branch { parts, axis: 0, at: None, next: 0 }
    }

    fn is_cut(&self) -> bool {
        self.parts.len() > 1
    }

    fn middle(&self) -> u32 {
        self.parts.start + self.parts.len() as u32 / 2
    }

    /// The branch after this one that a node is in; none after the last.
    fn follow(&self, node: &WeightedNode) -> Option<usize> {
        let beyond = self.at.is_some_and(|at| key(node, self.axis) >= at);
        self.is_cut().then_some(self.next + usize::from(beyond))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranks::{Alone, threads};

    /// By sorting all of them, again and again.
    fn by_sorting(nodes: &mut [WeightedNode], parts: Range<u32>, part: &mut Vec<(u64, u32)>) {
        if parts.len() < 2 {
            return part.extend(nodes.iter().map(|node| (node.number, parts.start)));
        }
        let extent = |c: usize| {
            let at = || nodes.iter().map(|node| node.place[c]);
            at().fold(f64::NEG_INFINITY, f64::max) - at().fold(f64::INFINITY, f64::min)
        };
        let axis = (0..3).fold(0, |best, c| if extent(c) > extent(best) { c } else { best });
        nodes.sort_by(|a, b| a.place[axis].total_cmp(&b.place[axis]).then(a.number.cmp(&b.number)));
        let middle = parts.start + parts.len() as u32 / 2;
        let whole: f64 = nodes.iter().map(|node| node.weight).sum();
        let (wanted, mut sum) = (whole * f64::from(middle - parts.start) / parts.len() as f64, 0.0);
        let cut = nodes.iter().take_while(|node| {
            sum += node.weight;
            sum <= wanted
        });
        let cut = cut.count();
        let (low, high) = nodes.split_at_mut(cut);
        by_sorting(low, parts.start..middle, part);
        by_sorting(high, middle..parts.end, part);
    }

    #[test]
    fn cuts_by_bytes_are_those_of_sorted_nodes_and_the_same_however_ranks_hold_them() {
        let mut seed = 7u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / f64::from(1 << 24)
        };
        // Many at the same coordinates, on both sides of zero; some with numbers of more than 32 bits.
        let mut nodes: Vec<WeightedNode> = (0..3000u64)
            .map(|k| WeightedNode {
                place: [4.0 * random() - 2.0, (9.0 * random()).floor() - 4.0, 0.3 * (5.0 * random()).floor()],
                number: 977 * k + if k % 3 == 0 { 1 << 33 } else { 0 },
                weight: [0.0, 1.0, 1.0, 6.0][(4.0 * random()) as usize],
            })
            .collect();
        for parts in [1, 2, 3, 7, 16] {
            let mut expected = Vec::new();
            by_sorting(&mut nodes.clone(), 0..parts, &mut expected);
            expected.sort_unstable();
            nodes.sort_by_key(|node| node.number);
            let alone = Cuts::new(&Alone, &nodes, parts as usize);
            let found: Vec<(u64, u32)> =
                nodes.iter().map(|node| (node.number, alone.part(node.place, node.number))).collect();
            assert_eq!(found, expected, "{parts} parts");
            let spread = |ranks: std::sync::Arc<dyn Ranks>| {
                let own = nodes.iter().skip(ranks.rank()).step_by(ranks.size()).copied().collect::<Vec<_>>();
                // One rank has none.
                let own = if ranks.rank() == 3 { Vec::new() } else { own };
                let third: Vec<WeightedNode> = nodes.iter().skip(3).step_by(4).copied().collect();
                let own = if ranks.rank() == 0 { [own, third].concat() } else { own };
                Cuts::new(&*ranks, &own, parts as usize)
            };
            threads(4, spread).into_iter().for_each(|cuts| assert_eq!(cuts, alone));
        }
        let none = Cuts::new(&Alone, &[], 4);
        assert!(none.part([1.0; 3], 5) < 4);
    }
}
