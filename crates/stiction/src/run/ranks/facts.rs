//! What a case amounts to, as `stiction solve` shows it before it solves: rank 0 has found the outside, what is inside the ranks count.

use super::local::{Local, group, loads};
use super::outside::Outside;
use super::solve::unknowns;
use crate::Error;
use crate::fem::{Load, Solid, cells_of_materials, external_forces};
use crate::io::case::{Case, LoadSpec, Region};
use crate::mesh::{CellInfo, CellKind, CellShape, MeshInfo, info_with};
use crate::ranks::{Ranks, agree, from_bytes, gather_all, max, sum, to_bytes};
use crate::run::pose::loads::{describe, end, temperatures};
use crate::run::pose::notes::Noted;
use crate::run::pose::{ContactFacts, Facts, FixFacts, LoadFacts, MaterialFacts};

/// The facts of the whole at rank 0.
///
/// # Errors
/// If a load is not finite, at every rank.
pub(super) fn facts(case: &Case, local: &Local) -> Result<Option<Facts>, Error> {
    let ranks = &*local.division.ranks;
    let solid =
        Solid { mesh: &local.piece.mesh, materials: &local.materials, material_of_cell: &local.material_of_cell };
    let shapes = solid.mesh.cell_shapes();
    let kinds = kinds(local, &shapes);
    let materials = materials(local, &shapes);
    let used = used(&solid, ranks);
    let fixes = fixes(case, local);
    let load_facts = agree(ranks, load_facts(case, local, &solid, &shapes))?;
    let volume = kinds.iter().map(|kind| kind.volume).sum();
    let loads = all_loads(case, load_facts, volume, ranks);
    let unknowns = unknowns(local);
    let Some(outside) = &local.outside else { return Ok(None) };
    let bodies = local.problem.labels.bodies.as_ref().map_or(1, |bodies| bodies.list.len());
    let of_outside = |(facts, of): (&FixFacts, &[f64; 4])| {
        let [count, x, y, z] = *of;
        FixFacts { nodes: count as usize, at: facts.at.map(|_| [x, y, z]), ..facts.clone() }
    };
    let noted = Noted {
        mesh: &outside.found.notes,
        nodes_of: &outside.mesh,
        materials: &local.materials,
        used,
        contacts: &outside.contacts,
        surfaces: &outside.surfaces,
        specs: &outside.specs,
        travel: [0.0; 3],
        widened: &Outside::widened(case),
        case,
    };
    Ok(Some(Facts {
        title: case.title.clone(),
        units: case.units.clone(),
        mesh: MeshInfo {
            nodes: local.sizes[0] as usize,
            cells: cell_infos(&kinds, &outside.found.kinds),
            volume,
            ..info_with(&outside.mesh, &[], bodies)
        },
        materials,
        fixes: outside.found.fixes.iter().zip(&fixes).map(of_outside).collect(),
        springs: outside.found.springs.clone(),
        loads,
        bolts: outside.found.bolts.clone(),
        couplings: outside.found.couplings.clone(),
        cyclic: Vec::new(),
        warnings: outside.contacts.iter().filter_map(ContactFacts::warning).collect(),
        contacts: outside.contacts.clone(),
        steps: case.steps.last().map(|last| (case.steps.iter().map(|step| step.increments).sum(), last.until)),
        unknowns,
        equations: (!case.equations.is_empty()).then_some([case.equations.len(), outside.found.tied]),
        points: outside.contacts.iter().map(|contact| contact.surface.points).sum(),
        notes: noted.sentences(),
    }))
}

/// Cells that this rank counts: the owner of the first node does.
pub(super) fn own_cells(local: &Local) -> Vec<bool> {
    local.piece.mesh.cell_iter().map(|(_, nodes)| local.division.is_own(nodes[0])).collect()
}

/// Number, volume, quality and worst cell of a kind.
#[derive(Clone, Copy)]
struct Kind {
    count: f64,
    volume: f64,
    /// The sum of all, the least, and the number of its cell.
    quality: [f64; 3],
}

/// Of each kind, over all ranks.
fn kinds(local: &Local, shapes: &[CellShape]) -> Vec<Kind> {
    let none = [0.0, 0.0, 0.0, f64::INFINITY, 0.0];
    let mut own = [none; CellKind::ALL.len()];
    let cells = local.piece.mesh.cell_iter().zip(shapes).zip(&local.piece.cells).zip(own_cells(local));
    for ((((kind, _), shape), &number), _) in cells.filter(|(_, own)| *own) {
        let Some(of) = CellKind::ALL.iter().position(|other| *other == kind).map(|place| &mut own[place]) else {
            continue;
        };
        of[0] += 1.0;
        of[1] += shape.volume;
        of[2] += shape.quality;
        if shape.quality < of[3] {
            (of[3], of[4]) = (shape.quality, number as f64);
        }
    }
    let mut all = [none; CellKind::ALL.len()];
    for message in gather_all(&*local.division.ranks, to_bytes(&own)) {
        for (of, more) in all.iter_mut().zip(from_bytes::<[f64; 5]>(&message)) {
            (0..3).for_each(|k| of[k] += more[k]);
            if more[3] < of[3] {
                (of[3], of[4]) = (more[3], more[4]);
            }
        }
    }
    all.map(|[count, volume, quality @ ..]| Kind { count, volume, quality }).to_vec()
}

/// Those that there are, as far as known in the order of the mesh.
fn cell_infos(kinds: &[Kind], order: &[CellKind]) -> Vec<CellInfo> {
    let mut infos: Vec<CellInfo> = Vec::new();
    for &kind in order.iter().chain(&CellKind::ALL) {
        let of = CellKind::ALL.iter().zip(kinds).find(|(other, of)| **other == kind && of.count > 0.0);
        let Some((_, of)) = of.filter(|_| !infos.iter().any(|info| info.kind == kind)) else { continue };
        let [sum, min_quality, worst] = of.quality;
        let (count, worst) = (of.count as usize, worst as usize);
        infos.push(CellInfo { kind, count, min_quality, mean_quality: sum / of.count, worst });
    }
    infos
}

/// The materials, on every rank.
fn materials(local: &Local, shapes: &[CellShape]) -> Vec<MaterialFacts> {
    let mut sums = vec![0.0; 2 * local.materials.len()];
    let cells = shapes.iter().zip(&local.material_of_cell).zip(own_cells(local));
    for ((shape, &number), _) in cells.filter(|(_, own)| *own) {
        sums[2 * number as usize] += 1.0;
        sums[2 * number as usize + 1] += shape.volume;
    }
    sum(&*local.division.ranks, &mut sums);
    let mut facts: Vec<MaterialFacts> = local.materials.iter().map(MaterialFacts::of).collect();
    facts
        .iter_mut()
        .zip(sums.as_chunks::<2>().0)
        .for_each(|(facts, [count, volume])| facts.add(*count as usize, *volume));
    facts
}

/// The cells of each material on all ranks.
fn used(solid: &Solid, ranks: &dyn Ranks) -> Vec<[bool; 3]> {
    let here = cells_of_materials(solid);
    let mut used: Vec<f64> = here.iter().flatten().map(|used| f64::from(u8::from(*used))).collect();
    max(ranks, &mut used);
    used.as_chunks::<3>().0.iter().map(|used| used.map(|used| used > 0.0)).collect()
}

/// The nodes of each support and, of one at a point, where its node is.
fn fixes(case: &Case, local: &Local) -> Vec<[f64; 4]> {
    let mesh = &local.piece.mesh;
    let mut sums = Vec::new();
    for (k, spec) in case.fixes.iter().enumerate() {
        let nodes = group(mesh, "fix", k).map_or(&[][..], |group| &group.nodes);
        let own = || nodes.iter().filter(|&&v| local.division.is_own(v));
        let first = own().next().filter(|_| matches!(spec.on, Region::Point(_)));
        let [x, y, z] = first.map_or([0.0; 3], |&v| mesh.nodes[v as usize]);
        sums.extend([own().count() as f64, x, y, z]);
    }
    sum(&*local.division.ranks, &mut sums);
    sums.as_chunks().0.to_vec()
}

/// What this rank counts of a load: extent, resultant, lowest and highest temperature.
type Part = ([f64; 4], [f64; 2]);

const NO_TEMPERATURE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn load_facts(case: &Case, local: &Local, solid: &Solid, shapes: &[CellShape]) -> Result<Vec<Part>, Error> {
    let (mesh, t) = (solid.mesh, end(case));
    let is_own = |v: u32| local.division.is_own(v);
    let mut parts = vec![([0.0; 4], NO_TEMPERATURE); case.loads.len()];
    let here = (0..case.loads.len()).filter(|&k| group(mesh, "load", k).is_some());
    let (list, _) = loads(mesh, case, &local.moments, t)?;
    for (k, load) in here.zip(&list) {
        let (of, range) = &mut parts[k];
        let own_face = |face: &&u32| is_own(mesh.faces[**face as usize].nodes()[0]);
        of[0] = match load {
            Load::Traction { faces, .. }
            | Load::Pressure { faces, .. }
            | Load::Force { faces, .. }
            | Load::Resultant { faces, .. }
            | Load::Hydrostatic { faces, .. } => {
                faces.iter().filter(own_face).map(|&face| mesh.face_area(face as usize)).sum()
            }
            Load::Nodal { nodes, .. } => nodes.iter().filter(|&&v| is_own(v)).count() as f64,
            Load::Gravity { cells, .. } | Load::Rotation { cells, .. } | Load::Temperature { cells, .. } => {
                let own = cells.iter().filter(|&&cell| is_own(mesh.cell(cell as usize).1[0]));
                own.map(|&cell| shapes[cell as usize].volume).sum()
            }
        };
        let forces = external_forces(solid, std::slice::from_ref(load), t)?;
        let own = forces.iter().enumerate().filter(|(dof, _)| is_own(*dof as u32 / 3));
        own.for_each(|(dof, force)| of[1 + dof % 3] += force);
        *range = temperatures(solid, load, t).unwrap_or(NO_TEMPERATURE);
    }
    Ok(parts)
}

/// The loads of all ranks, on every one, in a body of this `volume`.
fn all_loads(case: &Case, parts: Vec<Part>, volume: f64, ranks: &dyn Ranks) -> Vec<LoadFacts> {
    let mut sums: Vec<f64> = parts.iter().flat_map(|(sums, _)| *sums).collect();
    let mut ranges: Vec<f64> = parts.iter().flat_map(|(_, [low, high])| [-low, *high]).collect();
    sum(ranks, &mut sums);
    max(ranks, &mut ranges);
    let fact = |((spec, [extent, x, y, z]), [low, high]): ((&LoadSpec, &[f64; 4]), &[f64; 2])| {
        // Ranks have the cells with mass of those on which weight acts.
        let extent = if spec.on.is_none() && !spec.kind.at_nodes() { &volume } else { extent };
        let range = (*high > f64::NEG_INFINITY).then_some([-low, *high]);
        LoadFacts { extent: *extent, range, ..describe(spec, [*x, *y, *z]) }
    };
    case.loads.iter().zip(sums.as_chunks().0).zip(ranges.as_chunks().0).map(fact).collect()
}
