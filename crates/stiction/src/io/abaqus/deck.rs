//! What an input says, in its own numbers.

use std::collections::HashMap;

use super::cards::Card;
use super::elements::Role;
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};

/// Everything that was read. Part 0 holds what stands in no part: all of a deck without parts, the sets of an assembly.
pub(super) struct Deck {
    pub parts: Vec<Part>,
    pub instances: Vec<Instance>,
    /// Keywords that were not read, in the order of the file, each once.
    pub skipped: Vec<String>,
    /// Bytes of all files.
    pub bytes: usize,
    /// The cards that say nothing of the mesh, in the order of the file; `None` where nobody asked for them.
    pub cards: Option<Vec<Card>>,
}

/// Nodes, elements and sets that share their numbers.
#[derive(Default)]
pub(super) struct Part {
    pub name: String,
    pub node_labels: Vec<u32>,
    /// Coordinates, not yet scaled.
    pub nodes: Vec<[f64; 3]>,
    pub blocks: Vec<Block>,
    /// Of each [`Kind`].
    pub sets: [Sets; 3],
}

/// Elements of one `*ELEMENT` line.
#[derive(Clone)]
pub(super) struct Block {
    pub role: Role,
    /// As the file calls the type, in capitals.
    pub type_name: String,
    pub labels: Vec<u32>,
    /// Nodes by their labels, `role.nodes()` an element.
    pub nodes: Vec<u32>,
    /// `line 12`.
    pub place: String,
}

/// Named sets in the order of the file. Names are the same whatever their case.
#[derive(Default)]
pub(super) struct Sets {
    pub list: Vec<Set>,
    by_name: HashMap<String, usize>,
}

/// A set as it is written.
#[derive(Default)]
pub(super) struct Set {
    /// In the spelling of its first line.
    pub name: String,
    pub internal: bool,
    /// `line 12`: where it was named first.
    pub place: String,
    pub members: Vec<Members>,
}

/// What one keyword says about a set.
#[derive(Default)]
pub(super) struct Members {
    /// The instance that labels and names belong to, if it is named.
    pub instance: Option<String>,
    pub labels: Vec<u32>,
    /// First, last and step.
    pub ranges: Vec<[u32; 3]>,
    pub names: Vec<Name>,
    /// Faces of elements, by label (surfaces).
    pub faces: Vec<(u32, FaceLabel)>,
    /// Members are nodes though this is a surface (`TYPE=NODE`).
    pub nodal: bool,
}

/// A set named within another, `None` for the faces that lie on the boundary.
pub(super) struct Name {
    pub name: String,
    pub kind: Kind,
    pub face: FaceLabel,
}

/// Kinds of sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::io) enum Kind {
    Nodes,
    Elements,
    Surface,
}

/// Which face of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceLabel {
    /// S1 is 0.
    Side(u8),
    /// All faces on the boundary; for shells and plane elements, the element itself.
    Boundary,
}

/// A part somewhere in space.
pub(super) struct Instance {
    pub name: String,
    pub part: usize,
    pub motion: Motion,
}

/// A translation, then a rotation about the axis through two points.
#[derive(Default, Clone, Copy)]
pub(super) struct Motion {
    /// Length.
    pub translation: V3,
    /// Two points of the axis and the angle in degrees.
    pub rotation: Option<(V3, V3, f64)>,
}

impl Motion {
    /// Where a point goes (Rodrigues' formula).
    pub(super) fn apply(&self, x: V3) -> V3 {
        let x = add(x, self.translation);
        let Some((a, b, degrees)) = self.rotation else { return x };
        let axis = sub(b, a);
        let axis = scale(1.0 / norm(axis), axis);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let r = sub(x, a);
        let turned = add(scale(cos, r), add(scale(sin, cross(axis, r)), scale((1.0 - cos) * dot(axis, r), axis)));
        add(a, turned)
    }
}

impl Sets {
    /// The set called `name`, made at `place` if there is none yet.
    pub(super) fn at(&mut self, name: &str, place: impl Fn() -> String) -> &mut Set {
        let next = self.list.len();
        let number = *self.by_name.entry(name.to_uppercase()).or_insert(next);
        if number == next {
            self.list.push(Set { name: name.to_string(), place: place(), ..Set::default() });
        }
        &mut self.list[number]
    }

    /// The number of the set called `name`.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.by_name.get(&name.to_uppercase()).copied()
    }
}
