//! From a case to a posed problem.

use std::time::Instant;

use super::facts::{ContactFacts, Facts, MaterialFacts};
use super::loads::{TIME, fixes, loads};
use super::nested::{Coarser, coarser};
use super::solve::may_take_multigrid;
use super::{materials, mesh, place, surfaces};
use crate::Error;
use crate::contact::{ContactProblem, ContactSurface, pose};
use crate::fem::{FeModel, Material, Solid, assemble, notes};
use crate::io::case::{Case, Spot};
use crate::mesh::{Mesh, MeshNotes, info};

/// A case on its mesh, ready to be solved.
#[derive(Debug, Clone)]
pub struct Prepared {
    pub mesh: Mesh,
    /// Where the case describes the mesh, for errors that its size causes.
    pub mesh_spot: Spot,
    pub materials: Vec<Material>,
    /// Index into `materials` for each cell.
    pub material_of_cell: Vec<u32>,
    /// The elastic body; its stiffness has moved to `problem` and is empty here.
    pub model: FeModel,
    pub surfaces: Vec<ContactSurface>,
    pub problem: ContactProblem,
    pub facts: Facts,
    /// The same case on a coarser mesh, where there is one and its solution is worth having.
    pub coarser: Option<Coarser>,
    /// Seconds taken by the mesh, by assembly and by posing the contact.
    pub seconds: [f64; 3],
}

/// Makes or reads the mesh, resolves every name of the case in it, assembles the body and poses the contact.
///
/// # Errors
/// Whatever makes the case impossible to pose, shown at its place in the case file where it has one.
pub fn prepare(case: &Case) -> Result<Prepared, Error> {
    let start = Instant::now();
    let memory = case.solver.memory.map(|gigabytes| (gigabytes * 1e9) as u64);
    let (mesh, mesh_notes) = mesh::mesh(&case.mesh, memory)?;
    let meshed = start.elapsed().as_secs_f64();
    let (materials, material_of_cell) = materials::materials(&mesh, &case.materials)?;
    let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
    let mut surfaces = surfaces::surfaces(&mesh, &case.contacts)?;
    let (fixes, fix_facts) = fixes(&mesh, case)?;
    let (loads, load_facts) = loads(&solid, &case.loads)?;
    let mut model = assemble(&solid, &loads, &fixes, TIME)?;
    let assembled = start.elapsed().as_secs_f64();
    surfaces::assign(&solid, &model.dofs, &mut surfaces);
    let (problem, surface_facts) = pose(&mesh, &mut model, &surfaces).map_err(|error| at_contact(case, error))?;
    problem.validate()?;
    let posed = start.elapsed().as_secs_f64();

    let contacts = surface_facts.into_iter().zip(&surfaces).zip(&case.contacts).map(|((surface, s), spec)| {
        ContactFacts { surface, against: s.against.clone(), names: surfaces::names(spec), friction: s.friction }
    });
    let contacts: Vec<ContactFacts> = contacts.collect();
    let notes = all_notes(&solid, &mesh_notes, &contacts, &surfaces);
    let facts = Facts {
        title: case.title.clone(),
        units: case.units.clone(),
        mesh: info(&mesh),
        materials: material_facts(&solid),
        fixes: fix_facts,
        loads: load_facts,
        contacts,
        unknowns: problem.unknowns(),
        points: problem.points(),
        notes,
    };
    let seconds = [meshed, assembled - meshed, posed - assembled];
    let mesh_spot = case.mesh.spot.clone();
    let coarser = if may_take_multigrid(&case.solver, problem.unknowns()) { coarser(case) } else { None };
    Ok(Prepared { mesh, mesh_spot, materials, material_of_cell, model, surfaces, problem, facts, coarser, seconds })
}

/// An error of `pose`, which knows contacts by their names, at the contact's place in the case file.
fn at_contact(case: &Case, error: Error) -> Error {
    let named = case.contacts.iter().find(|c| error.place == format!("contact \"{}\"", c.name));
    match named {
        Some(contact) => place::at(&contact.spot, error),
        None => error,
    }
}

fn all_notes(
    solid: &Solid,
    mesh_notes: &MeshNotes,
    contacts: &[ContactFacts],
    surfaces: &[ContactSurface],
) -> Vec<String> {
    let mut all: Vec<String> = mesh_notes.0.iter().map(ToString::to_string).collect();
    all.extend(notes(solid));
    all.extend(contacts.iter().flat_map(ContactFacts::notes));
    for (a, b, count) in surfaces::shared(surfaces) {
        all.push(format!("contacts \"{a}\" and \"{b}\" share {count} faces: check that both are meant"));
    }
    all
}

fn material_facts(solid: &Solid) -> Vec<MaterialFacts> {
    let fact = |(number, m): (usize, &Material)| {
        let cells = (0..solid.mesh.cell_count()).filter(|&cell| solid.material_of_cell[cell] as usize == number);
        let (count, volume) = cells.fold((0, 0.0), |(n, v), cell| (n + 1, v + solid.mesh.cell_volume(cell)));
        let Material { name, young, poisson, density, .. } = m.clone();
        MaterialFacts { name, young, poisson, density, cells: count, volume }
    };
    solid.materials.iter().enumerate().map(fact).collect()
}
