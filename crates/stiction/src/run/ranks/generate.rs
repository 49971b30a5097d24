//! Meshes of blocks and rings: each rank makes its own part of them. Rank 0 makes the cells at the boundary beside it.

use std::collections::HashMap;
use std::ops::Range;

use super::parts::{Owners, Part, PartNode, Parts};
use super::share::Whole;
use crate::Error;
use crate::contact::Helpers;
use crate::io::case::{Case, MeshSource, MeshSpec};
use crate::mesh::v3::V3;
use crate::mesh::{CornerBox, Grid, GridMesh, Grids, MeshNotes, MeshPiece, Turn, around};
use crate::ranks::{Ranks, from_bytes, gather_all, to_bytes};
use crate::run::pose::MemoryLimit;
use crate::run::pose::memory::{of_block, posing_fits};

/// The grids of a case whose mesh is made of blocks and rings alone; none where something is asked of the inside of the whole:
/// the cut of a bolt.
fn grids(case: &Case) -> Option<Grids> {
    if !case.bolts.is_empty() {
        return None;
    }
    let moved = |spec: &MeshSpec| (spec.placing.turn, spec.placing.by);
    let grid = |spec: &MeshSpec, placings: Vec<(Option<Turn>, V3)>| match &spec.source {
        MeshSource::Block(block) => Grid::of_block(block, placings).ok(),
        MeshSource::Ring(ring) => Grid::of_ring(ring, placings).ok(),
        _ => None,
    };
    let whole = moved(&case.mesh);
    let MeshSource::Parts(parts) = &case.mesh.source else {
        return Some(Grids::new(vec![(None, grid(&case.mesh, vec![whole])?)]));
    };
    let part = |(name, spec): &(String, MeshSpec)| Some((Some(name.clone()), grid(spec, vec![moved(spec), whole])?));
    Some(Grids::new(parts.iter().map(part).collect::<Option<_>>()?))
}

/// Grids of which this rank divides an equal part of the nodes, by their numbers. Each grid is a body, and its cells a class.
pub(super) struct Made {
    grids: Grids,
    numbers: Range<u64>,
    groups: Vec<Vec<String>>,
    kinds: Vec<Vec<u32>>,
}

impl Made {
    /// None where the mesh is not made of grids.
    pub(super) fn new(case: &Case, ranks: &dyn Ranks) -> Option<Made> {
        let grids = grids(case)?;
        let [count, _] = grids.sizes();
        let at = |rank: usize| (u128::from(count) * rank as u128 / ranks.size() as u128) as u64;
        let numbers = at(ranks.rank())..at(ranks.rank() + 1);
        let groups = (0..grids.len()).map(|k| grids.cell_groups(k)).collect();
        let kinds = (0..grids.len() as u32).map(|k| vec![k]).collect();
        Some(Made { grids, numbers, groups, kinds })
    }

    /// Where in the grids the nodes of this rank are: all ranks tell it of those that they divide.
    fn boxes(&self, owners: &Owners, ranks: &dyn Ranks) -> Vec<(usize, CornerBox)> {
        let mut boxes: HashMap<[u64; 2], CornerBox> = HashMap::new();
        let mut add = |key: [u64; 2], corners| {
            boxes.entry(key).and_modify(|found| *found = around(*found, corners)).or_insert(corners);
        };
        // Nodes that follow one another mostly are of one part: the map is asked where they change.
        let mut last: Option<([u64; 2], CornerBox)> = None;
        // The cells at those that go where others do come with the boundary.
        for number in self.numbers.clone().filter(|&number| !owners.follows(number)) {
            let (grid, corners) = self.grids.corners_of(number);
            let key = [u64::from(owners.of(number, || self.grids.place(number))), grid as u64];
            match &mut last {
                Some((other, found)) if *other == key => *found = around(*found, corners),
                _ => last.replace((key, corners)).into_iter().for_each(|(key, corners)| add(key, corners)),
            }
        }
        last.into_iter().for_each(|(key, corners)| add(key, corners));
        let mut list: Vec<[u64; 8]> =
            boxes.iter().map(|([part, grid], [[a, b, c], [x, y, z]])| [*part, *grid, *a, *b, *c, *x, *y, *z]).collect();
        list.sort_unstable();
        let mut own: Vec<(usize, CornerBox)> = Vec::new();
        for message in gather_all(ranks, to_bytes(&list)) {
            for [part, grid, a, b, c, x, y, z] in from_bytes::<[u64; 8]>(&message) {
                if part != ranks.rank() as u64 {
                    continue;
                }
                let (grid, corners) = (grid as usize, [[a, b, c], [x, y, z]]);
                match own.iter_mut().find(|(other, _)| *other == grid) {
                    Some((_, found)) => *found = around(*found, corners),
                    None => own.push((grid, corners)),
                }
            }
        }
        own
    }
}

impl Parts for Made {
    fn sizes(&self) -> [u64; 2] {
        self.grids.sizes()
    }

    fn bytes(&self) -> f64 {
        self.grids.elements().map(of_block).fold(0.0, f64::max)
    }

    fn groups(&self) -> &[Vec<String>] {
        &self.groups
    }

    fn kinds(&self) -> &[Vec<u32>] {
        &self.kinds
    }

    fn boundary(&mut self, case: &Case, helpers: &Helpers) -> Result<Whole, Error> {
        let limit = MemoryLimit { divided: true, ..MemoryLimit::of(&case.solver) };
        posing_fits(self.grids.boundary_nodes(), 0.0, &limit)?;
        let mut made = self.grids.mesh_with_faces(self.grids.boundary_cells());
        made.mesh.groups = self.grids.groups(&made);
        let GridMesh { mesh, nodes, cells } = made;
        Whole::new(case, (mesh, MeshNotes::default()), (Some([nodes, cells]), self.grids.sizes()), None, helpers)
    }

    fn count(&self) -> usize {
        (self.numbers.end - self.numbers.start) as usize
    }

    fn node(&self, k: usize) -> PartNode {
        let number = self.numbers.start + k as u64;
        PartNode { number, place: self.grids.place(number), kind: self.grids.of_node(number) as u32 }
    }

    fn part(&self, beside: &MeshPiece, owners: &Owners, ranks: &dyn Ranks) -> Part {
        let grids = &self.grids;
        let owner_of = |number: u64| owners.of(number, || grids.place(number));
        let (boxes, own) = (self.boxes(owners, ranks), ranks.rank() as u32);
        let (GridMesh { mesh, nodes, cells }, owner) = grids.part(&boxes, &beside.cells, own, owner_of);
        let kinds: Vec<u32> = nodes.iter().map(|&node| grids.of_node(node) as u32).collect();
        Part {
            classes: cells.iter().map(|&cell| grids.of_cell(cell) as u32).collect(),
            bodies: kinds.clone(),
            kinds,
            piece: MeshPiece { mesh, nodes, owner, cells },
        }
    }
}
