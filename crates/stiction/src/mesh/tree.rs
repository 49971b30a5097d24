//! A tree of boxes over many small things in space: which of them meet a box, which is nearest to a point.

use super::v3::{V3, add, dot, scale, sub};

/// Lowest and highest coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner with the least coordinates, length.
    pub low: V3,
    /// The corner with the largest coordinates, length.
    pub high: V3,
}

impl Bounds {
    /// The smallest box around points; reversed and infinite around none.
    pub fn around(points: impl IntoIterator<Item = V3>) -> Bounds {
        let empty = Bounds { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        points.into_iter().fold(empty, |b, x| b.with(&Bounds { low: x, high: x }))
    }

    /// The smallest box around both.
    pub fn with(&self, other: &Bounds) -> Bounds {
        Bounds {
            low: [0, 1, 2].map(|c| self.low[c].min(other.low[c])),
            high: [0, 1, 2].map(|c| self.high[c].max(other.high[c])),
        }
    }

    /// The box that is larger by a length on all sides.
    pub(crate) fn grown(&self, by: f64) -> Bounds {
        Bounds { low: self.low.map(|x| x - by), high: self.high.map(|x| x + by) }
    }

    /// Whether they share a point, their boundaries included.
    pub fn meets(&self, other: &Bounds) -> bool {
        (0..3).all(|c| self.low[c] <= other.high[c] && other.low[c] <= self.high[c])
    }

    /// Length of the diagonal; 0 around no point.
    pub fn diagonal(&self) -> f64 {
        let d = sub(self.high, self.low).map(|c| c.max(0.0));
        dot(d, d).sqrt()
    }

    /// Square of the distance of `x`; 0 inside.
    fn distance2(&self, x: V3) -> f64 {
        (0..3).map(|c| (self.low[c] - x[c]).max(x[c] - self.high[c]).max(0.0).powi(2)).sum()
    }

    /// Whether the segment from `x` to `x + way` meets it, its boundary included.
    fn crossed_by(&self, x: V3, way: V3) -> bool {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for c in 0..3 {
            if way[c] == 0.0 {
                if x[c] < self.low[c] || self.high[c] < x[c] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((self.low[c] - x[c]) / way[c], (self.high[c] - x[c]) / way[c]);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        // A segment through a flat box that is not along the axes meets it up to rounding only.
        from <= to + GRAZING
    }

    fn middle(&self, c: usize) -> f64 {
        self.low[c] + self.high[c]
    }
}

/// What a segment misses a box by, as a part of its length, where rounding may be all that parts them.
const GRAZING: f64 = 1e-12;

/// Things in a leaf at most.
const LEAF: usize = 4;

/// Boxes of things numbered from 0, halved by number along their longest extent until few are left: building takes
/// `O(n log² n)`, a query `O(log n)` and what it finds.
#[derive(Debug, Clone)]
pub struct Tree {
    /// The root first; the children of a branch stand side by side.
    branches: Vec<Branch>,
    /// Numbers of the things, those of a leaf side by side.
    things: Vec<u32>,
    /// The box of each thing by its number.
    bounds: Vec<Bounds>,
}

#[derive(Debug, Clone, Copy)]
struct Branch {
    bounds: Bounds,
    /// The first child, or in a leaf the place of the first thing.
    first: u32,
    /// Things of a leaf; 0 for a branch with children.
    count: u32,
}

impl Tree {
    /// The tree over these boxes.
    pub fn new(bounds: Vec<Bounds>) -> Tree {
        let mut tree = Tree { branches: Vec::new(), things: (0..bounds.len() as u32).collect(), bounds };
        let around = tree.around(0, tree.things.len());
        tree.branches.push(Branch { bounds: around, first: 0, count: 0 });
        // Branches wait with the range of their things until they are split.
        let mut open = vec![(0usize, 0usize, tree.things.len())];
        while let Some((branch, from, to)) = open.pop() {
            if to - from <= LEAF {
                (tree.branches[branch].first, tree.branches[branch].count) = (from as u32, (to - from) as u32);
                continue;
            }
            let middle = tree.split(branch, from, to);
            tree.branches[branch].first = tree.branches.len() as u32;
            for (from, to) in [(from, middle), (middle, to)] {
                open.push((tree.branches.len(), from, to));
                let bounds = tree.around(from, to);
                tree.branches.push(Branch { bounds, first: 0, count: 0 });
            }
        }
        tree
    }

    fn around(&self, from: usize, to: usize) -> Bounds {
        let boxes = self.things[from..to].iter().map(|&i| self.bounds[i as usize]);
        boxes.fold(Bounds::around([]), |a, b| a.with(&b))
    }

    /// Sorts the things of a branch by the middles of their boxes so that the lower half comes first; returns where the
    /// upper begins.
    fn split(&mut self, branch: usize, from: usize, to: usize) -> usize {
        let (bounds, things) = (&self.bounds, &mut self.things[from..to]);
        let extent = sub(self.branches[branch].bounds.high, self.branches[branch].bounds.low);
        let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
        let half = things.len() / 2;
        let middle = |i: u32| bounds[i as usize].middle(axis);
        things.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        from + half
    }

    /// All things; what is near in the list is near in space.
    pub(crate) fn things(&self) -> &[u32] {
        &self.things
    }

    /// The things whose boxes meet `range`, ascending.
    pub fn meeting(&self, range: &Bounds) -> Vec<u32> {
        self.all(|bounds| bounds.meets(range))
    }

    /// The things whose boxes the segment from `x` to `x + way` meets, ascending.
    pub fn along(&self, x: V3, way: V3) -> Vec<u32> {
        self.all(|bounds| bounds.crossed_by(x, way))
    }

    /// The things with boxes that are wanted, ascending; a box around a wanted one is wanted.
    fn all(&self, is_wanted: impl Fn(&Bounds) -> bool) -> Vec<u32> {
        let mut found = Vec::new();
        let mut open = vec![0usize];
        while let Some(branch) = open.pop() {
            let Branch { bounds, first, count } = self.branches[branch];
            if self.things.is_empty() || !is_wanted(&bounds) {
                continue;
            }
            let first = first as usize;
            let leaf = &self.things[first.min(self.things.len())..][..count as usize];
            found.extend(leaf.iter().filter(|&&i| is_wanted(&self.bounds[i as usize])));
            if count == 0 {
                open.extend([first, first + 1]);
            }
        }
        found.sort_unstable();
        found
    }

    /// The thing nearest to `x` and the square of its distance, which `distance2` tells of a thing; of several the one
    /// with the lowest number. `None` if none is nearer than the root of `limit2`.
    pub fn nearest(&self, x: V3, limit2: f64, distance2: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut open = vec![0usize];
        while let Some(branch) = open.pop() {
            let Branch { bounds, first, count } = self.branches[branch];
            if self.things.is_empty() || bounds.distance2(x) > best.map_or(limit2, |b| b.1) {
                continue;
            }
            let first = first as usize;
            for &i in &self.things[first.min(self.things.len())..][..count as usize] {
                let d = distance2(i);
                let nearer = best.map_or(d < limit2, |(j, b)| d < b || (d == b && i < j));
                best = if nearer { Some((i, d)) } else { best };
            }
            if count == 0 {
                let away = |child: usize| self.branches[child].bounds.distance2(x);
                let nearer_last = away(first) < away(first + 1);
                open.extend(if nearer_last { [first + 1, first] } else { [first, first + 1] });
            }
        }
        best
    }
}

/// The point of a triangle that is nearest to `x`.
pub fn nearest_on_triangle(x: V3, [a, b, c]: [V3; 3]) -> V3 {
    let weights = weights_on_triangle(x, [a, b, c]);
    if let Some(corner) = weights.iter().position(|&w| w == 1.0) {
        return [a, b, c][corner];
    }
    add(a, add(scale(weights[1], sub(b, a)), scale(weights[2], sub(c, a))))
}

/// The weights of the corners in the point of a triangle that is nearest to `x`: exactly 0 for corners it does not
/// depend on, on an edge or at a corner (Ericson, Real-Time Collision Detection, 2005, 5.1.5).
pub fn weights_on_triangle(x: V3, [a, b, c]: [V3; 3]) -> [f64; 3] {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let along = |p: V3| [dot(ab, sub(x, p)), dot(ac, sub(x, p))];
    let ([a1, a2], [b1, b2], [c1, c2]) = (along(a), along(b), along(c));
    if a1 <= 0.0 && a2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if b1 >= 0.0 && b2 <= b1 {
        return [0.0, 1.0, 0.0];
    }
    if c2 >= 0.0 && c1 <= c2 {
        return [0.0, 0.0, 1.0];
    }
    let (on_bc, on_ac, on_ab) = (b1 * c2 - c1 * b2, c1 * a2 - a1 * c2, a1 * b2 - b1 * a2);
    if on_ab <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        let t = a1 / (a1 - b1);
        return [1.0 - t, t, 0.0];
    }
    if on_ac <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        let t = a2 / (a2 - c2);
        return [1.0 - t, 0.0, t];
    }
    if on_bc <= 0.0 && b2 >= b1 && c1 >= c2 {
        let t = (b2 - b1) / ((b2 - b1) + (c1 - c2));
        return [0.0, 1.0 - t, t];
    }
    let sum = on_bc + on_ac + on_ab;
    [on_bc, on_ac, on_ab].map(|area| area / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1) without a pattern.
    fn noise() -> impl FnMut() -> f64 {
        let mut state = 0x9e37_79b9_7f4a_7c15u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    #[test]
    fn the_tree_finds_what_a_look_at_every_triangle_finds() {
        let mut noise = noise();
        for count in [0usize, 1, 4, 5, 700] {
            let mut triangles: Vec<[V3; 3]> = Vec::new();
            for _ in 0..count {
                let at: V3 = std::array::from_fn(|_| noise());
                triangles.push(std::array::from_fn(|_| std::array::from_fn(|c| at[c] + 0.1 * noise())));
            }
            if count > 5 {
                triangles[7] = triangles[6]; // the same place twice
            }
            let bounds: Vec<Bounds> = triangles.iter().map(|t| Bounds::around(*t)).collect();
            let tree = Tree::new(bounds.clone());
            let distance2 = |x: V3, i: u32| {
                let d = sub(x, nearest_on_triangle(x, triangles[i as usize]));
                dot(d, d)
            };
            for _ in 0..200 {
                let x: V3 = std::array::from_fn(|_| 1.4 * noise() - 0.2);
                let range = Bounds::around([x, [0, 1, 2].map(|c| x[c] + 0.1 * noise())]);
                let all: Vec<u32> = (0..count as u32).filter(|&i| bounds[i as usize].meets(&range)).collect();
                assert_eq!(tree.meeting(&range), all);
                let limit2 = 0.5 * noise() * noise();
                let near = (0..count as u32).map(|i| (i, distance2(x, i))).filter(|(_, d)| *d < limit2);
                let best = near.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
                assert_eq!(tree.nearest(x, limit2, |i| distance2(x, i)), best);
                // A segment finds at least the boxes that its points lie in.
                let way: V3 = std::array::from_fn(|c| if noise() < 0.2 { 0.0 } else { noise() - 0.3 * c as f64 });
                let found = tree.along(x, way);
                let on = |s: i32| add(x, scale(f64::from(s) / 50.0, way));
                let within = |b: &Bounds| (0..=50).any(|s| b.meets(&Bounds::around([on(s)])));
                assert!((0..count as u32).all(|i| found.contains(&i) || !within(&bounds[i as usize])));
                assert!(found.iter().all(|&i| bounds[i as usize].meets(&Bounds::around([x, on(50)]))));
            }
        }
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_nearer_than_a_fine_net_of_others() {
        let mut noise = noise();
        for _ in 0..300 {
            let t: [V3; 3] = std::array::from_fn(|_| std::array::from_fn(|_| noise()));
            let x: V3 = std::array::from_fn(|_| 3.0 * noise() - 1.0);
            let found = nearest_on_triangle(x, t);
            let distance = |p: V3| dot(sub(p, x), sub(p, x)).sqrt();
            let n = 24;
            let net = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [i, j, n - i - j].map(|k| k as f64 / n as f64)));
            let best = net
                .map(|w| distance([0, 1, 2].map(|c| w[0] * t[0][c] + w[1] * t[1][c] + w[2] * t[2][c])))
                .fold(f64::INFINITY, f64::min);
            assert!(distance(found) <= best + 1e-12 && distance(found) > best - 0.1);
        }
    }
}
