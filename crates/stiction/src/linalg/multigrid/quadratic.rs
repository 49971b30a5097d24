use super::between_ranks::Reach;
use super::blocks::{Block, Blocks, rows_at};
use super::coarsen::{Coarser, Kernel};
use super::dense::add_product;
use super::distance::place;
use super::packed::Packed;
use super::smoother::Level;
use super::stiff_groups::StiffGroups;
use super::truncation::{Support, TouchedRows};
use crate::ranks::Halo;

/// The displacements of a mesh of quadratic elements that are linear on its corners, as the first coarse space: three
/// unknowns a corner.
///
/// Aggregates of quadratic nodes span several elements and miss what lies between the two spaces; a sweep does not smooth it
/// either, and cycles reduce the error half as well. From the linear space on aggregation goes as on any linear mesh. Middles
/// of edges much longer than others at their ends stay as they are.
#[derive(Debug, Clone)]
pub(crate) struct LinearSpace {
    /// From its nodes, and its ghosts, to the nodes of this rank.
    pub prolongation: Blocks<3, 3>,
    /// The near-kernel at its nodes.
    pub kernel: Vec<Kernel<3>>,
    /// How its nodes are divided among ranks: each belongs to the rank of the corner.
    pub halo: Halo,
    /// The ends of the edge of each of its nodes of this rank that is a middle, as far as they are among these; [`NO_NODE`] otherwise.
    pub ends: Vec<[u32; 2]>,
}

/// An end of an edge that is no node: it is prescribed.
pub(crate) const NO_NODE: u32 = u32::MAX;

/// An edge is long if it exceeds this multiple of the shortest one at its ends. Long edges keep their middles: sweeps do not
/// smooth along them, where the matrix couples weakly.
const LONG: f64 = 2.0;

impl LinearSpace {
    /// From the ends of the edge for each node in the middle of one, twice the same for a node at the place of another one, [`NO_NODE`] for
    /// those that are prescribed. The nodes are divided by `halo`; further ones that are here count where edges are compared.
    pub(crate) fn new(ends: &[Option<[u32; 2]>], kernel: &[Kernel<3>], halo: &Halo) -> LinearSpace {
        let keeps = keep_middles(ends, kernel, halo);
        let corners: Vec<usize> = (0..halo.own()).filter(|&v| keeps[v]).collect();
        let (corner_of, coarse) = numbered(&corners, halo);
        // The first three motions are the translations: a row of them is the direction of an unknown.
        let half = |v: usize, end: u32| -> Block<3, 3> {
            let along = |r: usize, c: usize| (0..3).map(|q| kernel[v][r][q] * kernel[end as usize][c][q]).sum::<f64>();
            std::array::from_fn(|r| std::array::from_fn(|c| 0.5 * along(r, c)))
        };
        let is_known = |end: &u32| corner_of.get(*end as usize).is_some_and(|&corner| corner != NO_NODE);
        let ends_of = |v: usize| ends[v].into_iter().flatten().filter(is_known);
        let named = |v: usize, name: &mut dyn FnMut(u32)| match corner_of[v] {
            NO_NODE => ends_of(v).for_each(|end| name(corner_of[end as usize])),
            own => name(own),
        };
        let prolongation = Blocks::from_rows(halo.own(), coarse.len(), named, |v, row| match corner_of[v] {
            NO_NODE => ends_of(v).for_each(|end| add_to(row.at(corner_of[end as usize]), &half(v, end))),
            own => (0..3).for_each(|c| row.at(own)[c][c] = 1.0),
        });
        let own = |end: u32| match corner_of.get(end as usize) {
            Some(&corner) if (corner as usize) < coarse.own() => corner,
            _ => NO_NODE,
        };
        let own_ends = |&v: &usize| ends[v].map_or([NO_NODE; 2], |ends| ends.map(own));
        let ends = corners.iter().map(own_ends).collect();
        LinearSpace { prolongation, kernel: corners.iter().map(|&v| kernel[v]).collect(), halo: coarse, ends }
    }

    /// Displacements of a node in other coordinates.
    pub(crate) fn turn(&mut self, node: usize, to: &Block<3, 3>) {
        let range = self.prolongation.start[node]..self.prolongation.start[node + 1];
        for block in &mut self.prolongation.value[range] {
            let old = std::mem::replace(block, [[0.0; 3]; 3]);
            add_product(to, &old, block);
        }
    }
}

fn add_to(sum: &mut Block<3, 3>, block: &Block<3, 3>) {
    sum.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(sum, x)| *sum += x);
}

/// The place in the linear space of each node and ghost, [`NO_NODE`] of those that it does not keep, from its nodes among those of
/// this rank; and how they are divided.
fn numbered(corners: &[usize], halo: &Halo) -> (Vec<u32>, Halo) {
    /// The number of a node that is not kept.
    const NONE: u64 = u64::MAX;
    let first = match halo.is_alone() {
        true => 0,
        false => Halo::divided(halo.ranks(), corners.len(), Vec::new()).first(),
    };
    let mut number = vec![NONE; halo.own()];
    corners.iter().zip(first..).for_each(|(&v, k)| number[v] = k);
    halo.update(&mut number);
    let coarse = match halo.is_alone() {
        true => Halo::alone(corners.len()),
        false => {
            let mut ghosts: Vec<u64> = number[halo.own()..].iter().copied().filter(|&k| k != NONE).collect();
            ghosts.sort_unstable();
            Halo::divided(halo.ranks(), corners.len(), ghosts)
        }
    };
    let place = |&k: &u64| coarse.place(k).map_or(NO_NODE, |place| place as u32);
    (number.iter().map(place).collect(), coarse)
}

/// Which nodes of this rank the linear space keeps: corners and middles of long edges.
fn keep_middles(ends: &[Option<[u32; 2]>], kernel: &[Kernel<3>], halo: &Halo) -> Vec<bool> {
    let length = |v: usize, end: u32| -> f64 {
        let (a, b) = (place(&kernel[v]), place(&kernel[end as usize]));
        2.0 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
    };
    let known = |v: usize| ends[v].into_iter().flatten().filter(|&end| end != NO_NODE);
    let mut shortest = vec![f64::INFINITY; ends.len()];
    for v in 0..ends.len() {
        for end in known(v) {
            let length = length(v, end);
            shortest[end as usize] =
                if length > 0.0 { shortest[end as usize].min(length) } else { shortest[end as usize] };
        }
    }
    // All edges at a corner are at hand on its own rank.
    halo.update(&mut shortest);
    let known = |v: usize| known(v).filter(|&end| (end as usize) < shortest.len());
    let is_long = |v: usize| {
        let limit = known(v).map(|end| shortest[end as usize]).fold(0.0, f64::max);
        known(v).any(|end| length(v, end) > LONG * limit)
    };
    (0..halo.own()).map(|v| ends[v].is_none() || is_long(v)).collect()
}

/// The level of the linear space.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    pub level: Level<3, 4>,
    /// From this level to the finest.
    pub prolongation: Packed<3, 3>,
    /// What the nodes that may be constrained contribute.
    pub support: Support<3>,
    /// The nodes whose rows may change, and these rows.
    pub reach: Reach,
    pub rows: TouchedRows<3>,
    /// Solved for together after the sweeps.
    pub stiff: StiffGroups,
}

impl Linear {
    /// With its stiff groups, the contact nodes of this rank, and then its ghosts among those of others.
    pub(super) fn new(step: &Coarser<3, 3>, groups: &[Vec<u32>], contact_nodes: &[u32]) -> Linear {
        let support = Support::of_step(step, contact_nodes);
        let reach = Reach::new(&step.halo, support.touched());
        let rows = TouchedRows::of(&step.matrix, &reach.touched);
        let mut level = Level::new(&step.matrix, step.halo.clone());
        level.expect_changes(&reach.touched);
        level.damp_less();
        let prolongation = Packed::new(&step.prolongation);
        let rows_of = |nodes: &[u32]| rows_at(nodes, step.matrix.cols, |v| step.matrix.row(v as usize));
        let stiff = StiffGroups::new(groups, step.halo.own(), &[], rows_of);
        Linear { level, prolongation, support, reach, rows, stiff }
    }
}
