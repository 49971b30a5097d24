//! Elements that a rank has read, by the numbers that their nodes and they have in the whole.

use std::collections::BTreeSet;

use super::cells::{CellList, Kinds};
use super::homes::{Homes, leader};
use super::numbering::NONE;
use crate::io::ranges::Elements;
use crate::mesh::{CellKind, ascending};
use crate::ranks::{Ranks, all_to_all, from_bytes, gather_all, put, take, to_bytes};

/// Lists of all ranks, each once and in order.
pub(super) fn distinct(ranks: &dyn Ranks, own: impl Iterator<Item = Vec<u32>>) -> Vec<Vec<u32>> {
    let mut message = Vec::new();
    own.for_each(|list| put(&list, &mut message));
    let mut all = BTreeSet::new();
    for message in gather_all(ranks, message) {
        let from = &mut &message[..];
        while !from.is_empty() {
            all.insert(take(from));
        }
    }
    all.into_iter().collect()
}

/// The place of a value in a list that ascends.
pub(super) fn place_of<T: Ord>(list: &[T], value: &T) -> u32 {
    list.partition_point(|other| other < value) as u32
}

/// The elements that a rank has read, and all numbers of nodes that they name.
pub(super) struct Named {
    elements: Elements,
    /// Ascending, and whether a cell names each.
    pub keys: Vec<u64>,
    pub by_cells: Vec<bool>,
}

/// Faces and nodes of groups, by the numbers of their nodes in the whole.
#[derive(Default)]
pub(super) struct Regions {
    /// The group and the corners of each; triangles end in [`NONE`].
    pub faces: Vec<[u64; 5]>,
    pub nodes: Vec<[u64; 2]>,
}

impl Named {
    /// Of faces and lines what is in the groups that are `asked` for.
    pub(super) fn new(mut elements: Elements, asked: &[bool]) -> Named {
        let wanted: Vec<bool> =
            elements.sets.iter().map(|set| set.iter().any(|&group| asked[group as usize])).collect();
        elements.faces.retain(|(_, set)| wanted[*set as usize]);
        elements.nodes.retain(|(_, set)| wanted[*set as usize]);
        let of_cells = ascending(elements.cells.iter().flat_map(|block| block.nodes.iter().copied()));
        let corners = elements.faces.iter().flat_map(|(corners, _)| corners.iter().copied().filter(|&c| c != NONE));
        let others = corners.chain(elements.nodes.iter().map(|(node, _)| *node));
        let keys = ascending(of_cells.iter().copied().chain(others));
        let by_cells = keys.iter().map(|key| of_cells.binary_search(key).is_ok()).collect();
        Named { elements, keys, by_cells }
    }

    /// The cells by their numbers in the whole, each at the ranks that keep the leaders of its faces: these see all cells at a
    /// face. With the groups of each class, and the kinds of all cells.
    pub(super) fn cells(&self, ranks: &dyn Ranks, homes: &Homes, numbers: &[u64]) -> (CellList, Vec<Vec<u32>>, Kinds) {
        let Elements { sets, cells, .. } = &self.elements;
        let used: BTreeSet<u32> = cells.iter().flat_map(|block| block.sets.iter().copied()).collect();
        let classes = distinct(ranks, used.into_iter().map(|set| sets[set as usize].clone()));
        let class_of: Vec<u32> = sets.iter().map(|set| place_of(&classes, set)).collect();
        let counts: Vec<u64> = cells.iter().map(|block| block.sets.len() as u64).collect();
        let all: Vec<Vec<u64>> =
            gather_all(ranks, to_bytes(&counts)).iter().map(|message| from_bytes(message)).collect();
        let (mut out, mut kinds, mut end) = (vec![CellList::default(); ranks.size()], Kinds::default(), 0);
        for (k, (kind, block)) in CellKind::ALL.into_iter().zip(cells).enumerate() {
            let first = end + all[..ranks.rank()].iter().map(|counts| counts[k]).sum::<u64>();
            end += all.iter().map(|counts| counts[k]).sum::<u64>();
            kinds.ends[k] = end;
            for ((number, list), &set) in (first..).zip(block.nodes.chunks_exact(kind.nodes())).zip(&block.sets) {
                let mut nodes = [0; 20];
                let nodes = &mut nodes[..list.len()];
                nodes.iter_mut().zip(list).for_each(|(node, key)| *node = numbers[place_of(&self.keys, key) as usize]);
                let leaders = kind.linear().faces().iter().map(|face| leader(face.iter().map(|&i| nodes[i])));
                for home in ascending(leaders.map(|node| homes.of(node))) {
                    out[home].push(number, class_of[set as usize], nodes);
                }
            }
        }
        let messages = out.into_iter().map(|list| list.to_bytes()).collect();
        (CellList::of(all_to_all(ranks, messages), &kinds), classes, kinds)
    }

    /// Faces of which a node belongs to no cell are none of the mesh.
    pub(super) fn regions(&self, numbers: &[u64]) -> Regions {
        let number = |key: u64| if key == NONE { NONE } else { numbers[place_of(&self.keys, &key) as usize] };
        let Elements { sets, faces, nodes, .. } = &self.elements;
        let mut regions = Regions::default();
        for (keys, set) in faces {
            let corners = keys.map(number);
            if (0..4).all(|k| (corners[k] == NONE) == (keys[k] == NONE)) {
                let face = |&group: &u32| [u64::from(group), corners[0], corners[1], corners[2], corners[3]];
                regions.faces.extend(sets[*set as usize].iter().map(face));
            }
        }
        for (key, set) in nodes.iter().filter(|(key, _)| number(*key) != NONE) {
            regions.nodes.extend(sets[*set as usize].iter().map(|&group| [u64::from(group), number(*key)]));
        }
        regions
    }
}
