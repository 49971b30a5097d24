//! `*TRANSFORM`: the directions of supports and forces at some nodes.

use super::reader::Reader;
use super::supports::NONE;
use super::text::triple;
use crate::Error;
use crate::fem::{Axes, frame};
use crate::io::abaqus::{Card, Kind};
use crate::mesh::v3::{norm, scale, sub};

/// A `*TRANSFORM` as a case file writes it, and as directions.
pub(super) struct Transform {
    pub text: String,
    pub axes: Axes,
}

impl<'a> Reader<'a> {
    pub(super) fn transform(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["NSET", "TYPE"])?;
        let set = card.needed("NSET")?.to_string();
        let kind = card.keyword.get("TYPE").unwrap_or("R").to_uppercase();
        let row = card.row()?.ok_or_else(|| card.error("*TRANSFORM has no line of data", "give two points"))?;
        let point = |i: usize| -> Result<[f64; 3], Error> {
            Ok([row.value(i, "a coordinate")?, row.value(i + 1, "a coordinate")?, row.value(i + 2, "a coordinate")?])
        };
        let (a, b) = (point(0)?, point(3)?);
        row.ends(6)?;
        let transform = match kind.as_str() {
            "R" => {
                let remedy = "give a point on the local x axis, and one in the plane of local x and y";
                let axes = frame([a, b]).map_err(|what| row.error(what, remedy))?;
                Transform { text: format!("[{}, {}]", triple(a), triple(b)), axes: Axes::Turned(axes) }
            }
            "C" => {
                let along = sub(b, a);
                let length = norm(along);
                if length == 0.0 || !length.is_finite() {
                    return Err(row.error("both points of the axis are one", "give two points of the axis"));
                }
                let text = format!("{{ point = {}, axis = {} }}", triple(a), triple(along));
                Transform { text, axes: Axes::Cylinder { point: a, axis: scale(1.0 / length, along) } }
            }
            _ => {
                let what = format!("*TRANSFORM, TYPE={kind} is not read");
                return Err(card.error(what, "give R for turned axes or C for those of a cylinder"));
            }
        };
        let scope = self.scope(card);
        let found = self.set(card, scope, Kind::Nodes, &set)?;
        self.notes.add("*TRANSFORM: what is printed counts along x, y, z of the mesh");
        let place = self.transforms.len() as u32;
        found.nodes.iter().for_each(|&node| self.transform_of[node as usize] = place);
        self.transforms.push(transform);
        Ok(())
    }

    /// Whether a node has axes of its own.
    pub(super) fn is_turned(&self, node: u32) -> bool {
        self.transform_of[node as usize] != NONE
    }

    /// The vector along x, y, z for a unit along component `c` of a node.
    pub(super) fn unit(&self, node: usize, c: usize, card: &Card) -> Result<[f64; 3], Error> {
        let axes = match self.transform_of[node] {
            NONE => Axes::Global,
            place => self.transforms[place as usize].axes,
        };
        axes.direction(c, self.input.node(node as u32)).ok_or_else(|| {
            let label = self.input.node_label(node as u32);
            let what = format!("node {label} lies on the axis of its *TRANSFORM, where no direction is radial");
            card.error(what, "take the node out of the set of *TRANSFORM")
        })
    }
}
