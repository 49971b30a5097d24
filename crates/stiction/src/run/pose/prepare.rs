//! From a case to a posed problem.

use std::collections::HashSet;

use super::activity::timed_contacts;
use super::axis::Position;
use super::bolts::{bolts, tightened};
use super::coarser::{Coarser, coarser};
use super::couplings::{Coupling, couplings};
use super::cyclic::{Cuts, cuts, refuse_contact_across};
use super::facts::{ContactFacts, CouplingFacts, CyclicFacts, Facts, MaterialFacts};
use super::load_state::{Loading, apply, load_state};
use super::loads::{Fixes, end, fixes, held_by_contact, loads, one_temperature, springs};
use super::memory::{MemoryLimit, is_of_memory};
use super::notes::Noted;
use super::path::multigrid_first;
use super::seconds::{Span, stopwatch};
use super::ties::{Ties, held_along_normal, ties_of_equations, ties_of_supports};
use super::travel::travel;
use super::{coefficients, counts, materials, mesh, place, regions, surfaces};
use crate::Error;
use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, ContactSurface, Counterpart, SurfaceFacts, SurfaceFriction, pose};
use crate::fem::{Entries, FeModel, Material, Solid, add_springs, assemble_part, cells_of_materials};
use crate::io::case::{Case, ContactSpec, CouplingSpec, CyclicSpec, Spot, StepSpec};
use crate::mesh::{Bounds, Mesh, info_with};

/// A case on its mesh, ready to be solved.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The mesh.
    pub mesh: Mesh,
    /// Where the case describes the mesh, for errors that its size causes.
    pub mesh_spot: Spot,
    /// Its materials.
    pub materials: Vec<Material>,
    /// Index into `materials` for each cell.
    pub material_of_cell: Vec<u32>,
    /// The elastic body; its stiffness has moved to `problem` and is empty here.
    pub model: FeModel,
    /// The contact surfaces.
    pub surfaces: Vec<ContactSurface>,
    /// The contact of the case that each of them is of.
    pub contact_of: Vec<usize>,
    /// Where solves before have shown that surfaces meet farther apart than `search`: the contact, and the length that is
    /// taken instead.
    pub widened: Vec<(String, f64)>,
    /// As it stands at the end of the last step, or of the step that is being solved.
    pub problem: ContactProblem,
    /// What acts, as functions of time.
    pub loading: Loading,
    /// What was understood of the case.
    pub facts: Facts,
    /// Motions of bodies that only contact holds.
    pub motions: RigidMotions,
    /// Whether multigrid is tried before the direct path.
    pub multigrid_first: bool,
    /// The same case on a coarser mesh, where there is one and its solution is worth having.
    pub coarser: Option<Coarser>,
    /// Displacements of the unknowns to start from, where an answer on another mesh gives some.
    pub start: Option<Vec<f64>>,
    /// Time taken by the mesh, by assembly and by posing the contact.
    pub seconds: [Span; 3],
}

/// Makes or reads the mesh, resolves every name of the case in it, assembles the body and poses the contact.
///
/// # Errors
/// Whatever makes the case impossible to pose, shown at its place in the case file where it has one.
pub fn prepare(case: &Case) -> Result<Prepared, Error> {
    posed(case, Entries::All)
}

/// The same without what takes the memory: `K` is its diagonal, and motions of bodies that contact alone holds are not looked for.
/// Whoever solves the case has all of it and has refused what cannot be solved; here its answer is looked at.
///
/// # Errors
/// As [`prepare`].
pub(crate) fn prepare_to_look_at(case: &Case) -> Result<Prepared, Error> {
    posed(case, Entries::Diagonal)
}

fn posed(case: &Case, entries: Entries) -> Result<Prepared, Error> {
    let mut lap = stopwatch();
    let is_solved_here = entries == Entries::All;
    let limit = MemoryLimit { divided: !is_solved_here, ..MemoryLimit::of(&case.solver) };
    if is_solved_here {
        counts::before_the_mesh(case, &limit)?;
    }
    let (mesh, mesh_notes) = mesh::mesh(&case.mesh, &limit)?;
    let meshed = lap();
    let (materials, material_of_cell) = materials::materials(&mesh, &case.materials)?;
    let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
    let mut surfaces = surfaces::surfaces(&mesh, &case.contacts, &case.steps)?;
    let Fixes { held: mut fixes, spots: mut fix_spots, timed, facts: fix_facts } = fixes(&mesh, case)?;
    let cuts = cuts(&mesh, &case.cyclic)?;
    for (fix, spot) in cuts.iter().filter_map(Cuts::on_axis) {
        fixes.push(fix);
        fix_spots.push(spot);
    }
    if is_solved_here {
        counts::before_assembly(&mesh, &fixes, case, &limit)?;
    }
    let (loads, load_facts) = loads(&solid, &case.loads, end(case))?;
    one_temperature(&mesh, &loads, &case.loads)?;
    let (springs, spring_facts) = springs(&mesh, &case.springs)?;
    let of_the_mesh = |error| if is_of_memory(&error) { place::at(&case.mesh.spot, limit.named(error)) } else { error };
    let mut model = assemble_part(&solid, &loads, &fixes, end(case), entries).map_err(of_the_mesh)?;
    add_springs(&mesh, &springs, &mut model)?;
    model.dofs.follows = cuts.iter().flat_map(Cuts::followers).collect();
    let assembled = lap();
    surfaces::assign(&solid, &model.dofs, &case.couplings, &mut surfaces);
    let of = surfaces::reverse(&solid, &model.dofs, &mut surfaces);
    let widened = surfaces::widened(&case.contacts);
    refuse_loss_without_steps(&case.contacts, &case.steps)?;
    let named =
        |(surface, i): (&ContactSurface, usize)| ContactSpec { name: surface.name.clone(), ..case.contacts[i].clone() };
    let case = &Case { contacts: surfaces.iter().zip(of.iter().copied()).map(named).collect(), ..case.clone() };
    coefficients::read(&mesh, &case.contacts, &mut surfaces, end(case))?;
    refuse_contact_across(&mesh, &cuts, &surfaces, &case.contacts)?;
    let (problem, shapes) = rayon::join(|| pose(&mesh, &mut model, &surfaces), || mesh.cell_shapes());
    let (mut problem, surface_facts) = problem.map_err(|error| at_contact(case, error))?;
    let mut ties = ties_of_equations(&mesh, &model.dofs, &case.equations)?;
    let held = ties.iter().flat_map(|tie| tie.entries.keys()).collect::<HashSet<_>>().len();
    ties.extend(cuts.iter().flat_map(|cuts| cuts.ties(&model.dofs)));
    let (couplings, of_couplings) = couplings(&solid, &model.dofs, case, ties.len())?;
    ties.extend(of_couplings);
    ties.extend(ties_of_supports(&mesh, &model.dofs, &timed)?);
    let diagonal = Bounds::around(mesh.nodes.iter().copied()).diagonal();
    let points = problem.labels.pairs.iter().map(|pair| pair.points.clone());
    refuse_states_of_changing_points(&case.contacts, &surface_facts)?;
    let out = surface_facts.iter().map(|facts| &facts.out[..]);
    let timed_points = case.contacts.iter().zip(points).zip(out).map(|((contact, points), out)| (contact, points, out));
    let (mut activity, put_in) = timed_contacts(&case.steps, diagonal, timed_points);
    let on_obstacles = on_obstacles_at_rest(&surface_facts, &surfaces, &case.contacts);
    activity.take_out(held_along_normal(&mesh, &model.dofs, &problem, &on_obstacles, &timed));
    let ties = Ties::new(&model.dofs, ties, &mut problem, &mut activity)?;
    problem.validate()?;
    let found = surface_facts.into_iter().zip(&surfaces).zip(&case.contacts);
    let contacts: Vec<ContactFacts> = found.map(|((facts, s), spec)| ContactFacts::new(facts, s, spec)).collect();
    let motions = match entries {
        Entries::All => held_by_contact(&mesh, &model.dofs, &problem, case, &contacts)?,
        Entries::Diagonal => RigidMotions::default(),
    };
    let (bolts, bolt_facts) = bolts(&solid, &model.dofs, case, end(case))?;
    let loading = Loading {
        bolts,
        ties,
        couplings,
        activity,
        put_in,
        fix_spots,
        ..Loading::new(case, loads, fixes).on(&problem)
    };

    let travel = travel(&mesh, &model, &model.dofs);
    let noted = Noted {
        mesh: &mesh_notes,
        nodes_of: &mesh,
        materials: &materials,
        used: cells_of_materials(&solid),
        contacts: &contacts,
        surfaces: &surfaces,
        specs: &case.contacts,
        travel,
        widened: &widened,
        case,
    };
    let notes = noted.sentences();
    let mut made_of: Vec<MaterialFacts> = materials.iter().map(MaterialFacts::of).collect();
    shapes.iter().zip(&material_of_cell).for_each(|(shape, &number)| made_of[number as usize].add(1, shape.volume));
    let facts = Facts {
        title: case.title.clone(),
        units: case.units.clone(),
        mesh: info_with(&mesh, &shapes, problem.labels.bodies.as_ref().map_or(1, |bodies| bodies.list.len())),
        materials: made_of,
        fixes: fix_facts,
        springs: spring_facts,
        loads: load_facts,
        bolts: bolt_facts,
        cyclic: cyclic_facts(&mesh, case)?,
        couplings: coupling_facts(&mesh, case, &loading.couplings)?,
        warnings: contacts.iter().filter_map(ContactFacts::warning).collect(),
        contacts,
        steps: case.steps.last().map(|last| (case.steps.iter().map(|step| step.increments).sum(), last.until)),
        unknowns: problem.unknowns(),
        equations: (!case.equations.is_empty()).then_some([case.equations.len(), held]),
        points: loading.ties.points().start,
        notes,
    };
    let seconds = [meshed, assembled, lap()];
    let mesh_spot = case.mesh.spot.clone();
    let multigrid_first = is_solved_here && multigrid_first(&case.solver, &problem);
    // A step starts from the one before it, which is nearer than any coarser problem.
    let coarser = if multigrid_first && case.steps.is_empty() { coarser(case) } else { None };
    let mut prepared = Prepared {
        mesh,
        mesh_spot,
        materials,
        material_of_cell,
        model,
        surfaces,
        contact_of: of,
        widened,
        problem,
        loading,
        facts,
        multigrid_first,
        motions,
        coarser,
        start: None,
        seconds,
    };
    for t in planned(case) {
        load_state(&prepared, t)?;
    }
    let loading = &prepared.loading;
    let changes =
        loading.moves() || !loading.couplings.is_empty() || !loading.ties.is_empty() || !loading.activity.is_constant();
    if changes || loading.strains() || loading.is_stressed() || travel != [0.0; 3] {
        let unslid = vec![0.0; 2 * prepared.problem.points()];
        let last = load_state(&prepared, end(case))?;
        let last = tightened(&prepared, last, &prepared.loading.given_shortening(end(case))?);
        apply(&mut prepared, &last, &unslid);
    }
    Ok(prepared)
}

/// Strength that can be lost needs load steps.
pub(crate) fn refuse_loss_without_steps(contacts: &[ContactSpec], steps: &[StepSpec]) -> Result<(), Error> {
    match contacts.iter().find(|contact| contact.friction.is_brittle()) {
        Some(brittle) if steps.is_empty() => {
            let what = "cohesion is lost on slip, which depends on the load path, and the case has no load steps";
            let remedy = "add [[step]] until = 1, increments = 10, or cohesion_lost = \"never\"";
            Err(brittle.friction_spot.error(what, remedy))
        }
        _ => Ok(()),
    }
}

/// What an interface has lost, or carried before anything was loaded, is known of a point: where another contact takes nodes for a
/// time, points give way to others.
fn refuse_states_of_changing_points(contacts: &[ContactSpec], facts: &[SurfaceFacts]) -> Result<(), Error> {
    let has_state = |contact: &ContactSpec| contact.friction.is_brittle() || contact.initial_stress.is_some();
    let changing = contacts.iter().zip(facts).find(|(contact, facts)| has_state(contact) && !facts.out.is_empty());
    let Some((contact, _)) = changing else { return Ok(()) };
    let what = format!(
        "contact \"{}\" has cohesion that is lost on slip or an initial stress, and another contact that holds in some steps has nodes \
         of it then",
        contact.name
    );
    Err(contact.spot.error(what, "let both hold in the same steps, or name surfaces without common nodes"))
}

impl Prepared {
    /// Lets solves start from displacements along x, y, z of all nodes, `3 i + c`, where they go by multigrid.
    ///
    /// # Panics
    /// If there are not three for each node.
    pub fn start_from(&mut self, mut all: Vec<f64>) {
        let dofs = &self.model.dofs;
        dofs.to_components(&mut all);
        self.start = Some(dofs.free.iter().map(|&dof| all[dofs.mesh_dof(dof) as usize]).collect());
    }
}

pub(crate) fn coupling_facts(mesh: &Mesh, case: &Case, couplings: &[Coupling]) -> Result<Vec<CouplingFacts>, Error> {
    let facts = |(spec, coupling): (&CouplingSpec, &Coupling)| {
        let nodes = regions::nodes(mesh, &spec.on, &spec.spot)?.len();
        let (name, on, point) = (spec.name.clone(), regions::name(&spec.on), spec.point);
        let [x, y, z, ..] = coupling.load(end(case))?;
        Ok(CouplingFacts { name, on, nodes, point, distributing: spec.distributing, force: [x, y, z] })
    };
    case.couplings.iter().zip(couplings).map(facts).collect()
}

/// Contact points that press on obstacles at rest, with their nodes. Bonded ones keep their place when a support ends, and those of
/// interfaces that yield carry what their layer does.
fn on_obstacles_at_rest(
    facts: &[SurfaceFacts],
    surfaces: &[ContactSurface],
    contacts: &[ContactSpec],
) -> Vec<(usize, u32)> {
    let (mut points, mut first) = (Vec::new(), 0);
    for ((facts, surface), contact) in facts.iter().zip(surfaces).zip(contacts) {
        let bonded = contact.bonded_until.is_some() || surface.friction == SurfaceFriction::Bonded;
        let yields = surface.stiffness.is_some() || contact.motion.is_some();
        if matches!(surface.against, Counterpart::Obstacle(_)) && !bonded && !yields {
            points.extend((first..).zip(facts.nodes.iter().copied()));
        }
        first += facts.nodes.len();
    }
    points
}

fn cyclic_facts(mesh: &Mesh, case: &Case) -> Result<Vec<CyclicFacts>, Error> {
    let facts = |spec: &CyclicSpec| {
        let nodes = regions::nodes(mesh, &spec.on, &spec.spot)?.len();
        Ok(CyclicFacts { cuts: [&spec.on, &spec.against].map(regions::name), nodes, sectors: spec.sectors })
    };
    case.cyclic.iter().map(facts).collect()
}

/// The times at which steps end, unless they are halved: the load states then are checked before anything is solved.
pub(crate) fn planned(case: &Case) -> Vec<f64> {
    let (mut at, mut times) = (Position::start(), Vec::new());
    while let Some([_, t]) = at.span(&case.steps) {
        times.push(t);
        at = at.advance(&case.steps);
    }
    times
}

/// An error of `pose`, which knows contacts by their names, at the contact's place in the case file.
fn at_contact(case: &Case, error: Error) -> Error {
    let named = case.contacts.iter().find(|c| error.place == format!("contact \"{}\"", c.name));
    match named {
        Some(contact) => place::at(&contact.spot, error),
        None => error,
    }
}
