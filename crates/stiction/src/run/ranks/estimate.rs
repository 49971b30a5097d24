//! The estimate of the discretisation error of an answer on several ranks.

use super::bolts::strain;
use super::local::{Local, group};
use super::report::take_accuracy;
use super::solve::RankedAnswer;
use crate::accuracy::{Estimate, OfCell, PATCH, Patches, Straining, parts};
use crate::fem::Solid;
use crate::friction::Status;
use crate::io::case::{Case, LoadKind};
use crate::mesh::v3::V3;
use crate::ranks::{Ranks, all_to_all, from_bytes, sum, to_bytes};

/// Adds the estimate to an answer, unless loads carry a body away.
pub(super) fn add_estimate(case: &Case, answer: &mut RankedAnswer) {
    if answer.summary.answer.status == Status::NoEquilibrium {
        return;
    }
    let (relative, of_cells) = estimate(case, &answer.local, &answer.u, &answer.shortening);
    answer.error = of_cells;
    take_accuracy(&mut answer.summary, Some(relative), None);
}

/// The estimated error of the stresses in the mean, relative (energy norm), and that of each cell here, see
/// [`Estimate::by_cell`]; `u` are the displacements of all nodes here. It is that of one machine, but for polynomials at the boundary that
/// need the cells around the neighbours of a corner: at the border of a rank these are those that the rank has.
pub(super) fn estimate(case: &Case, local: &Local, u: &[V3], shortening: &[f64]) -> (f64, Vec<f64>) {
    let ranks = &*local.division.ranks;
    let solid =
        Solid { mesh: &local.piece.mesh, materials: &local.materials, material_of_cell: &local.material_of_cell };
    let cuts: Vec<_> = local.bolts.iter().map(|bolt| &bolt.bolt.cut).zip(shortening.iter().copied()).collect();
    let straining = Straining {
        displacement: u.as_flattened(),
        initial: &strain(local, shortening),
        rise: &local.initial.rise,
        cuts: &cuts,
        region: &regions(case, local),
    };
    let cells = parts(&solid, &straining, |patches| complete(local, patches, ranks));
    let own = local.piece.mesh.cell_iter().zip(&cells).filter(|((_, nodes), _)| local.division.is_own(nodes[0]));
    let mut sums = own.fold([0.0; 4], |sums: OfCell, (_, of)| std::array::from_fn(|k| sums[k] + of[k]));
    sum(ranks, &mut sums);
    let whole = Estimate::of(&[sums]);
    let of_cell = whole.of_cell();
    (whole.relative(), cells.iter().map(|&[error, _, volume, _]| of_cell(error, volume)).collect())
}

/// The polynomials at nodes of other ranks are those that these have found, from all cells there.
fn complete(local: &Local, patches: &mut Patches, ranks: &dyn Ranks) {
    let owner = |node: u32| local.piece.owner[node as usize] as usize;
    let mut asked: Vec<(Vec<usize>, Vec<[u64; 2]>)> = vec![Default::default(); ranks.size()];
    for (patch, &[region, node]) in patches.list().iter().enumerate().filter(|(_, of)| owner(of[1]) != ranks.rank()) {
        let (places, names) = &mut asked[owner(node)];
        places.push(patch);
        names.push([region.into(), local.piece.nodes[node as usize]]);
    }
    let questions = asked.iter().map(|(_, names)| to_bytes(names)).collect();
    let answer = |names: &Vec<u8>| {
        let of = |[region, number]: [u64; 2]| {
            let node = local.piece.nodes.partition_point(|&other| other < number) as u32;
            patches.get([region as u32, node])
        };
        to_bytes(&from_bytes(names).into_iter().map(of).collect::<Vec<[f64; PATCH]>>())
    };
    let answers = all_to_all(ranks, questions).iter().map(answer).collect();
    for ((places, _), found) in asked.into_iter().zip(all_to_all(ranks, answers)) {
        places.into_iter().zip(from_bytes(&found)).for_each(|(patch, numbers)| patches.put(patch, &numbers));
    }
}

/// As of one machine: cells of one material under one temperature load have the same.
fn regions(case: &Case, local: &Local) -> Vec<u32> {
    let mut region = local.material_of_cell.clone();
    let count = case.materials.len() as u32;
    let heats = |kind: &LoadKind| matches!(kind, LoadKind::Temperature(_) | LoadKind::TemperatureArray { .. });
    let heated = case.loads.iter().enumerate().filter(|(_, load)| heats(&load.kind));
    for (first, (k, _)) in (1..).map(|number| number * count).zip(heated) {
        let cells = group(&local.piece.mesh, "load", k).map_or(&[][..], |group| &group.cells);
        cells.iter().for_each(|&cell| region[cell as usize] = first + local.material_of_cell[cell as usize]);
    }
    region
}
