//! Nodes that a support holds along the surface.
//!
//! Where the other body moves along with the node, or is held as well, nothing slides: so it is on a plane of symmetry, on which
//! nodes of both surfaces lie. Otherwise there is slip in the direction in which the node is held, and friction acts on the other
//! body and on the support. Then the rows of the point have the unknowns of the other body, and of its own node what is prescribed.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::SurfaceFriction;
use super::mortar::{Met, Search, meet};
use super::points::prescribed;
use crate::Error;
use crate::fem::DofMap;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, dot, norm, sub};

/// Parts of a direction below this are none: planes of symmetry come from coordinates of a few digits.
const ROUNDING: f64 = 1e-3;
/// Prescribed displacements that differ by less than this part of the larger are the same.
const SAME: f64 = 1e-9;
/// Nodes this part of a face's size off a plane lie in it.
const IN_PLANE: f64 = 1e-2;

/// What the other body does at a node, in a direction in which the node is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Other {
    /// What the node does.
    Same,
    /// What the forces of contact make it do.
    Moves,
    /// What supports make it do, and that is not what the node does.
    Driven,
}

/// The nodes of the other surface that some nodes meet, and the size of a face, length.
pub(super) struct Below {
    masters: FxHashMap<u32, BTreeSet<u32>>,
    size: f64,
}

impl Below {
    /// What the nodes held in some component meet of the master, by the faces of which they carry their part.
    pub(super) fn new(
        mesh: &Mesh,
        dofs: &DofMap,
        (faces, met): (&[u32], &[Met]),
        carries: &dyn Fn(u32, u32) -> bool,
        size: f64,
    ) -> Below {
        let mut masters: FxHashMap<u32, BTreeSet<u32>> = FxHashMap::default();
        for (&face, met) in faces.iter().zip(met).filter(|(_, met)| met.covered > 0.0) {
            let held = |node: &&u32| held_in_part(dofs, **node) && carries(face, **node);
            for &node in mesh.faces[face as usize].nodes().iter().filter(held) {
                masters.entry(node).or_default().extend(met.masters.iter().map(|(master, _)| *master));
            }
        }
        Below { masters, size }
    }

    /// What one node meets.
    pub(super) fn of_node(node: u32, masters: impl Iterator<Item = u32>, size: f64) -> Below {
        Below { masters: FxHashMap::from_iter([(node, masters.collect())]), size }
    }

    /// In which components a node is held while the other body moves there.
    ///
    /// # Errors
    /// If friction is to act where supports alone say what slides over what.
    pub(super) fn slides(
        &self,
        mesh: &Mesh,
        dofs: &DofMap,
        node: u32,
        normal: V3,
        friction: &SurfaceFriction,
    ) -> Result<[bool; 3], Error> {
        let mut slides = [false; 3];
        if *friction == SurfaceFriction::None {
            return Ok(slides);
        }
        let Some(masters) = self.masters.get(&node) else { return Ok(slides) };
        for (c, slides) in slides.iter_mut().enumerate() {
            if dofs.unknown[3 * node as usize + c] != u32::MAX || along_normal(dofs, node, c, normal) {
                continue;
            }
            match self.other(mesh, dofs, node, c, masters) {
                Other::Same => (),
                Other::Moves => *slides = true,
                Other::Driven if *friction == SurfaceFriction::Bonded => (),
                Other::Driven => return Err(driven(mesh, node)),
            }
        }
        Ok(slides)
    }

    fn other(&self, mesh: &Mesh, dofs: &DofMap, node: u32, c: usize, masters: &BTreeSet<u32>) -> Other {
        let (x, direction) = (mesh.nodes[node as usize], dofs.direction(3 * node + c as u32));
        let own = prescribed(dofs, node)[c].unwrap_or(0.0);
        let (mut moves, mut along_with, mut driven) = (false, false, false);
        for &master in masters {
            let (along, held) = (dofs.components(master, direction), prescribed(dofs, master));
            if (0..3).any(|c| held[c].is_none() && along[c].abs() > ROUNDING) {
                moves = true;
                continue;
            }
            let value: f64 = (0..3).map(|c| along[c] * held[c].unwrap_or(0.0)).sum();
            let same = (value - own).abs() <= SAME * value.abs().max(own.abs());
            let away = dot(direction, sub(mesh.nodes[master as usize], x));
            driven |= !same;
            along_with |= same && away.abs() <= IN_PLANE * self.size;
        }
        match () {
            // Rows reach beyond the plane of symmetry on which both are held.
            () if along_with => Other::Same,
            () if moves => Other::Moves,
            () if driven => Other::Driven,
            () => Other::Same,
        }
    }
}

/// How nodes of a surface are held along it while the other surface moves below them; what comes later is worse for its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Held {
    /// None is.
    Nowhere,
    /// Some are held where forces of contact move the other surface.
    WhereItMoves,
    /// Some are held where supports alone move it, which is refused.
    WhereItIsDriven,
}

/// How nodes of the surface with the faces `own` are held while that with the faces `master` moves.
pub(super) fn held_along(
    mesh: &Mesh,
    dofs: &DofMap,
    [own, master]: [&[u32]; 2],
    (search, size): (f64, f64),
    friction: &SurfaceFriction,
) -> Held {
    let held = |face: &u32| mesh.faces[*face as usize].nodes().iter().any(|&node| held_in_part(dofs, node));
    let faces: Vec<u32> = own.iter().copied().filter(held).collect();
    if faces.is_empty() || *friction == SurfaceFriction::None {
        return Held::Nowhere;
    }
    let met = meet(mesh, &faces, master, Search { length: search, averted: *friction == SurfaceFriction::Bonded });
    let below = Below::new(mesh, dofs, (&faces, &met), &|_, _| true, size);
    let of_face = |&face: &u32| {
        let normal = mesh.face_normal(face as usize);
        let of_node = |&node: &u32| match below.slides(mesh, dofs, node, normal, friction) {
            Err(_) => Held::WhereItIsDriven,
            Ok(slides) if slides.contains(&true) => Held::WhereItMoves,
            Ok(_) => Held::Nowhere,
        };
        let carries =
            |node: &&u32| (0..3).any(|c| is_free(dofs, **node, c) && part(dofs, **node, c, normal) > ROUNDING);
        mesh.faces[face as usize].nodes().iter().filter(carries).map(of_node).max()
    };
    faces.iter().filter_map(of_face).max().unwrap_or(Held::Nowhere)
}

/// Whether one of the tangents, components along the axes of the node, has a part that is prescribed.
pub(super) fn is_held_along(dofs: &DofMap, node: u32, tangents: &[V3; 2]) -> bool {
    tangents.iter().any(|tangent| (0..3).any(|c| !is_free(dofs, node, c) && tangent[c] != 0.0))
}

fn is_free(dofs: &DofMap, node: u32, c: usize) -> bool {
    dofs.unknown[3 * node as usize + c] != u32::MAX
}

/// Whether some components of a node are prescribed, not all.
fn held_in_part(dofs: &DofMap, node: u32) -> bool {
    let free = (0..3).filter(|&c| is_free(dofs, node, c)).count();
    free == 1 || free == 2
}

/// The part of the unit normal along component `c`.
fn part(dofs: &DofMap, node: u32, c: usize, normal: V3) -> f64 {
    dofs.components(node, normal)[c].abs()
}

/// Whether component `c` has no part along the surface.
fn along_normal(dofs: &DofMap, node: u32, c: usize, normal: V3) -> bool {
    let along = dofs.components(node, normal);
    let across = [0, 1, 2].map(|k| f64::from(u8::from(k == c)) - along[c] * along[k]);
    norm(across) <= ROUNDING
}

fn driven(mesh: &Mesh, node: u32) -> Error {
    let x = mesh.nodes[node as usize];
    let what = format!(
        "node {} at {x:?} is held in a direction in which supports move the other surface over it: no unknown is left on which \
         friction could act",
        node + 1
    );
    Error::new(
        "",
        what,
        "hold none of its components, let both surfaces move together, or make the contact frictionless",
    )
}
