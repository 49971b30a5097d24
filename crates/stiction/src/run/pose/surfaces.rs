//! Contact surfaces of a case, on the mesh.

use std::collections::HashSet;
use std::sync::Arc;

use super::{place, regions};
use crate::Error;
use crate::contact::{
    ContactSurface, Counterpart, InitialGap, Master, Obstacle, Reason, Role, Triangles, choose_slave, faces_around,
    may_change_sides, reverse_where_constrained, sides_to_change,
};
use crate::fem::{DofMap, Solid};
use crate::io::case::{AgainstSpec, ContactSpec, CouplingSpec, Placing, Region, Spot, StepSpec, SurfaceFile};
use crate::io::surface;
use crate::mesh::Mesh;
use crate::mesh::v3::add;

/// The surfaces and what they may touch; of a pair the surface of `on` is the slave for now.
pub(crate) fn surfaces(mesh: &Mesh, specs: &[ContactSpec], steps: &[StepSpec]) -> Result<Vec<ContactSurface>, Error> {
    let surface = |spec: &ContactSpec| {
        let against = match &spec.against {
            AgainstSpec::Obstacle(obstacle) => Counterpart::Obstacle(obstacle.clone()),
            AgainstSpec::File(file) => {
                Counterpart::Obstacle(triangles(file).map_err(|error| place::at(&spec.spot, error))?)
            }
            AgainstSpec::Surface { region, gap, closed_at, slave, search, widened } => {
                let nodes = nodes_alone(mesh, spec, *slave)?;
                let closed = closed_at.as_ref().map(|region| regions::nodes(mesh, region, &spec.spot)).transpose()?;
                Counterpart::Surface(Master {
                    faces: regions::faces(mesh, region, &spec.spot, "the contact")?,
                    gap: closed.map_or(gap.clone(), InitialGap::ClosedAt),
                    search: widened.or(*search),
                    slave: slave.unwrap_or(Role::On),
                    reason: match slave {
                        _ if nodes.is_some() => Reason::Nodes,
                        Some(_) => Reason::Asked,
                        None if spec.friction.is_array() => Reason::Array,
                        None => Reason::First,
                    },
                    nodes,
                })
            }
        };
        let faces = match &against {
            Counterpart::Surface(Master { nodes: Some(nodes), faces, .. }) => faces_around(mesh, nodes, faces),
            _ => regions::faces(mesh, &spec.on, &spec.spot, "the contact")?,
        };
        Ok(ContactSurface {
            name: spec.name.clone(),
            faces,
            against,
            friction: spec.friction.clone(),
            stiffness: spec.stiffness,
            periods: spec.periods(steps),
        })
    };
    specs.iter().map(surface).collect()
}

/// The nodes of `on` where it is made of groups of nodes that make up no face.
fn nodes_alone(mesh: &Mesh, spec: &ContactSpec, slave: Option<Role>) -> Result<Option<Vec<u32>>, Error> {
    let Region::Groups(names) = &spec.on else { return Ok(None) };
    let alone = |(name, _): &(String, Spot)| {
        mesh.group(name).is_some_and(|g| {
            !g.nodes.is_empty() && g.faces.is_empty() && g.interior_faces.is_empty() && g.cells.is_empty()
        })
    };
    if names.is_empty() || !names.iter().all(alone) {
        return Ok(None);
    }
    if slave == Some(Role::Against) {
        let what =
            format!("{} is made of nodes without faces, which carry the points of a contact", regions::name(&spec.on));
        return Err(spec.spot.error(what, "take `slave` out, or name a surface of faces in `on`"));
    }
    regions::nodes(mesh, &spec.on, &spec.spot).map(Some)
}

/// The obstacle in a file, put where the case wants it.
fn triangles(file: &SurfaceFile) -> Result<Obstacle, Error> {
    let mut raw = surface::read(&file.path, file.scale)?;
    let Placing { turn, by } = &file.placing;
    for x in &mut raw.points {
        *x = add(turn.as_ref().map_or(*x, |turn| turn.apply(*x)), *by);
    }
    let name = file.path.display().to_string();
    let short = file.path.file_name().map_or(name.clone(), |name| name.to_string_lossy().into_owned());
    let built = Triangles::new(raw, &short, file.side, file.feature_angle).map_err(|error| error.at(&name))?;
    Ok(Obstacle::Surface(Arc::new(built)))
}

/// Lets the slave of each pair be what the case asks for, or [`choose_slave`] and what contacts have in common say.
pub(crate) fn assign(solid: &Solid, dofs: &DofMap, couplings: &[CouplingSpec], surfaces: &mut [ContactSurface]) {
    let rigid = rigid_nodes(solid.mesh, couplings);
    let young = |surface: &ContactSurface| match &surface.against {
        Counterpart::Surface(master) => [&surface.faces, &master.faces].map(|faces| young(solid, &rigid, faces)),
        Counterpart::Obstacle(_) => [0.0; 2],
    };
    for surface in surfaces.iter_mut() {
        let Counterpart::Surface(master) = &surface.against else { continue };
        let mut chosen = (master.slave, master.reason);
        if ![Reason::Asked, Reason::Array, Reason::Nodes].contains(&master.reason) {
            chosen = choose_slave(solid.mesh, dofs, surface, young(surface));
        }
        let Counterpart::Surface(master) = &mut surface.against else { continue };
        (master.slave, master.reason) = (Role::On, chosen.1);
        if chosen.0 == Role::Against {
            surface.change_sides();
        }
    }
    let may = |surface: &ContactSurface| may_change_sides(solid.mesh, dofs, surface, young(surface));
    let changing = sides_to_change(solid.mesh, dofs, surfaces, may);
    for surface in surfaces.iter_mut().zip(changing).filter(|(_, changes)| *changes).map(|(surface, _)| surface) {
        surface.change_sides();
        if let Counterpart::Surface(master) = &mut surface.against {
            master.reason = Reason::Unshared;
        }
    }
}

/// Gives the faces of slaves that are prescribed altogether the other role, and returns the contact of the case that each
/// surface is of: a surface that is prescribed in part makes two, the second at the end.
pub(crate) fn reverse(solid: &Solid, dofs: &DofMap, surfaces: &mut Vec<ContactSurface>) -> Vec<usize> {
    let mut of: Vec<usize> = (0..surfaces.len()).collect();
    for number in 0..surfaces.len() {
        if let Some(other) = reverse_where_constrained(solid.mesh, dofs, &mut surfaces[number]) {
            surfaces.push(other);
            of.push(number);
        }
    }
    of
}

/// The nodes that rigid couplings move as a whole.
fn rigid_nodes(mesh: &Mesh, couplings: &[CouplingSpec]) -> HashSet<u32> {
    let rigid = couplings.iter().filter(|spec| spec.is_rigid());
    rigid.flat_map(|spec| regions::nodes(mesh, &spec.on, &spec.spot).unwrap_or_default()).collect()
}

/// Mean modulus of the cells behind the faces; infinite where most of their nodes are `rigid`: nothing determines the forces of single ones.
fn young(solid: &Solid, rigid: &HashSet<u32>, faces: &[u32]) -> f64 {
    let nodes = solid.mesh.face_nodes(faces);
    if 2 * nodes.iter().filter(|&node| rigid.contains(node)).count() > nodes.len() {
        return f64::INFINITY;
    }
    let of = |&face: &u32| {
        let cell = solid.mesh.faces[face as usize].cell as usize;
        solid.materials[solid.material_of_cell[cell] as usize].young
    };
    faces.iter().map(of).sum::<f64>() / faces.len().max(1) as f64
}

/// Contacts whose `search` a solve has found too short, and what it is instead.
pub(crate) fn widened(specs: &[ContactSpec]) -> Vec<(String, f64)> {
    let of = |spec: &ContactSpec| match spec.against {
        AgainstSpec::Surface { widened, .. } => widened.map(|search| (spec.name.clone(), search)),
        AgainstSpec::Obstacle(_) | AgainstSpec::File(_) => None,
    };
    specs.iter().filter_map(of).collect()
}

/// What the case calls a surface and, for a pair, its counterpart.
pub(crate) fn names(spec: &ContactSpec) -> [String; 2] {
    let against = match &spec.against {
        AgainstSpec::Obstacle(_) | AgainstSpec::File(_) => String::new(),
        AgainstSpec::Surface { region, .. } => regions::name(region),
    };
    [regions::name(&spec.on), against]
}

/// Pairs of surfaces that share faces at a time, and how many.
pub(crate) fn shared(surfaces: &[ContactSurface]) -> Vec<(String, String, usize)> {
    let mut shared = Vec::new();
    for (i, a) in surfaces.iter().enumerate() {
        for b in surfaces[i + 1..].iter().filter(|b| a.holds_with(b)) {
            let count = a.faces.iter().filter(|face| b.faces.binary_search(face).is_ok()).count();
            if count > 0 {
                shared.push((a.name.clone(), b.name.clone(), count));
            }
        }
    }
    shared
}
