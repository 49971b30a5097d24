//! What rank 0 keeps of the outside of the whole mesh: with it the functions of one machine say what a person should know of the case
//! and of its answer.

use super::local::Local;
use crate::Error;
use crate::contact::{Assembly, ContactSurface, Moved};
use crate::io::case::{Case, ContactSpec};
use crate::mesh::v3::V3;
use crate::mesh::{CellKind, Face, Group, Mesh, MeshArrays, MeshNotes};
use crate::ranks::{gather, put, take};
use crate::run::pose::activity::within;
use crate::run::pose::load_state::translation;
use crate::run::pose::{BoltFacts, ContactFacts, CouplingFacts, FixFacts, SpringFacts, place, surfaces};

/// The outside, with what was found on it when contact was posed. Nodes have its own numbers, faces those of the whole.
#[derive(Debug)]
pub(super) struct Outside {
    /// Faces, their nodes, and the groups of faces; no cells.
    pub mesh: Mesh,
    /// The number of each node in the whole, ascending.
    numbers: Vec<u64>,
    body: Vec<u32>,
    pub surfaces: Vec<ContactSurface>,
    pub contacts: Vec<ContactFacts>,
    /// The contact of the case that each surface is of, and its number.
    pub specs: Vec<ContactSpec>,
    pub contact_of: Vec<usize>,
    pub found: Found,
}

/// What else rank 0 has found in the whole.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub notes: MeshNotes,
    /// Kinds of cells in the order of the mesh.
    pub kinds: Vec<CellKind>,
    /// Where they are of nodes inside, they lack these.
    pub fixes: Vec<FixFacts>,
    pub springs: Vec<SpringFacts>,
    pub bolts: Vec<BoltFacts>,
    pub couplings: Vec<CouplingFacts>,
    /// Displacements that equations hold.
    pub tied: usize,
}

/// Surfaces with their contacts and what was found of them.
pub(super) struct Surfaces {
    pub surfaces: Vec<ContactSurface>,
    pub contacts: Vec<ContactFacts>,
    pub specs: Vec<ContactSpec>,
    pub contact_of: Vec<usize>,
}

impl Outside {
    /// Of a mesh whose nodes have the `numbers` in the whole, if these are not their places.
    pub(super) fn new(
        mesh: &Mesh,
        (numbers, body_of_node): (Option<&[u64]>, &[u32]),
        surfaces: Surfaces,
        found: Found,
    ) -> Outside {
        let Surfaces { surfaces, mut contacts, specs, contact_of } = surfaces;
        let mut places = vec![u32::MAX; mesh.nodes.len()];
        mesh.faces.iter().flat_map(Face::nodes).for_each(|&node| places[node as usize] = 0);
        let nodes: Vec<usize> = (0..places.len()).filter(|&v| places[v] == 0).collect();
        (0..).zip(&nodes).for_each(|(place, &v)| places[v] = place);
        let face = |face: &Face| face.renumbered(|node| places[node as usize]);
        let group = |group: &Group| {
            let (name, faces) = (group.name.clone(), group.faces.clone());
            (!faces.is_empty()).then(|| Group { name, faces, ..Group::default() })
        };
        for contact in &mut contacts {
            contact.surface.nodes.iter_mut().for_each(|node| *node = places[*node as usize]);
        }
        let number = |&v: &usize| numbers.map_or(v as u64, |numbers| numbers[v]);
        Outside {
            mesh: Mesh {
                nodes: nodes.iter().map(|&v| mesh.nodes[v]).collect(),
                cells: Vec::new(),
                faces: mesh.faces.iter().map(face).collect(),
                groups: mesh.groups.iter().filter_map(group).collect(),
                arrays: MeshArrays::default(),
            },
            numbers: nodes.iter().map(number).collect(),
            body: nodes.iter().map(|&v| body_of_node[v]).collect(),
            surfaces,
            contacts,
            specs,
            contact_of,
            found,
        }
    }

    /// What contact is posed on.
    pub(super) fn assembly(&self) -> Assembly<'_> {
        let facts = self.contacts.iter().map(|contact| &contact.surface).collect();
        Assembly { mesh: &self.mesh, body: self.body.clone(), surfaces: &self.surfaces, facts }
    }

    /// The node with this number in the whole.
    pub(super) fn place(&self, number: u64) -> Option<u32> {
        self.numbers.binary_search(&number).ok().map(|place| place as u32)
    }

    /// Nothing has moved.
    pub(super) fn at_rest(&self) -> Moved {
        Moved { u: vec![[0.0; 3]; self.numbers.len()], obstacles: vec![[0.0; 3]; self.surfaces.len()] }
    }

    /// Whether a surface takes no part at time `t`.
    pub(super) fn is_out(&self, case: &Case, surface: usize, t: f64) -> bool {
        !self.specs[surface].periods(&case.steps).iter().any(|&period| within(period, t))
    }

    /// Contacts whose `search` an earlier solve has found too short, and what it is instead; length.
    pub(super) fn widened(case: &Case) -> Vec<(String, f64)> {
        surfaces::widened(&case.contacts)
    }

    fn obstacles(&self, t: f64) -> Result<Vec<V3>, Error> {
        let of = |spec: &ContactSpec| {
            translation(spec.motion.as_ref(), t).map_err(|error| place::instead(&spec.spot, error))
        };
        self.specs.iter().map(of).collect()
    }
}

/// Where the outside has moved to at time `t`, at rank 0; `u` are the displacements of all nodes here, length.
///
/// # Errors
/// If the motion of an obstacle is not finite at `t`, at rank 0.
pub(super) fn moved(local: &Local, u: &[V3], t: f64) -> Result<Option<Moved>, Error> {
    let (piece, division) = (&local.piece, &local.division);
    let mut own: Vec<u32> = piece.mesh.faces.iter().flat_map(Face::nodes).copied().collect();
    own.sort_unstable();
    own.dedup();
    own.retain(|&v| division.is_own(v));
    let mut message = Vec::new();
    put(&own.iter().map(|&v| piece.nodes[v as usize]).collect::<Vec<u64>>(), &mut message);
    put(&own.iter().map(|&v| u[v as usize]).collect::<Vec<V3>>(), &mut message);
    let (Some(messages), Some(outside)) = (gather(&*division.ranks, message), &local.outside) else { return Ok(None) };
    let mut moved = Moved { obstacles: outside.obstacles(t)?, ..outside.at_rest() };
    for message in messages {
        let mut from = &message[..];
        let (numbers, u): (Vec<u64>, Vec<V3>) = (take(&mut from), take(&mut from));
        for (number, u) in numbers.iter().zip(u) {
            if let Ok(place) = outside.numbers.binary_search(number) {
                moved.u[place] = u;
            }
        }
    }
    Ok(Some(moved))
}
