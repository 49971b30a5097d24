//! Groups that the case of a deck names.

use std::collections::HashMap;

use crate::Error;
use crate::io::abaqus::{Found, Input, Row};
use crate::mesh::RawGroup;

/// The groups so far.
#[derive(Default)]
pub(super) struct Groups {
    pub list: Vec<RawGroup>,
    by_name: HashMap<String, usize>,
}

impl Groups {
    /// Adds a group and returns its name: the one wanted, or with a number where that is another group's.
    pub(super) fn add(&mut self, wanted: &str, group: RawGroup) -> String {
        let mut name = wanted.to_string();
        for number in 2.. {
            let Some(&at) = self.by_name.get(&name) else { break };
            if (RawGroup { name: name.clone(), ..group.clone() }) == self.list[at] {
                return name;
            }
            name = format!("{wanted} ({number})");
        }
        self.by_name.insert(name.clone(), self.list.len());
        self.list.push(RawGroup { name: name.clone(), ..group });
        name
    }

    /// Nodes, and the faces they make up.
    pub(super) fn nodes(&mut self, wanted: &str, nodes: &[u32]) -> String {
        self.add(wanted, RawGroup { nodes: nodes.to_vec(), faces_of_nodes: true, ..RawGroup::default() })
    }

    /// The cells among some elements.
    pub(super) fn cells(&mut self, input: &Input, wanted: &str, elements: &[u32]) -> String {
        let cells = elements.iter().filter_map(|&e| input.element(e).cell.map(|cell| cell.1)).collect();
        self.add(wanted, RawGroup { cells, ..RawGroup::default() })
    }

    /// Faces of elements.
    pub(super) fn faces(
        &mut self,
        input: &Input,
        wanted: &str,
        sides: &[(u32, u8)],
        row: &Row,
    ) -> Result<String, Error> {
        let faces = sides.iter().map(|&side| corners(input, side, row)).collect::<Result<_, _>>()?;
        Ok(self.add(wanted, RawGroup { faces, ..RawGroup::default() }))
    }

    /// A surface as the deck defines it.
    pub(super) fn surface(&mut self, input: &Input, wanted: &str, found: &Found, row: &Row) -> Result<String, Error> {
        let mut sides = found.sides.clone();
        let mut skin = Vec::new();
        for &element in &found.skin {
            match input.swept().and_then(|swept| swept.outline(element)) {
                Some(outline) => sides.extend(outline.into_iter().map(|side| (element, side))),
                None => skin.extend(input.element(element).cell.map(|cell| cell.1)),
            }
        }
        let faces = sides.into_iter().map(|side| corners(input, side, row)).collect::<Result<_, _>>()?;
        let nodes = super::sweep::with_copies(input, &found.nodes);
        let faces_of_nodes = !nodes.is_empty();
        Ok(self.add(wanted, RawGroup { faces, skin, nodes, faces_of_nodes, ..RawGroup::default() }))
    }
}

/// The corners of a face of a cell.
pub(super) fn corners(input: &Input, (element, side): (u32, u8), row: &Row) -> Result<[u32; 4], Error> {
    input.corners(element, side).ok_or_else(|| {
        let of = input.element(element);
        let what = format!("element {} of type {} has no face {}", of.label, of.type_name, side + 1);
        row.error(what, "name faces of elements: tetrahedra have four, wedges five, hexahedra six; plane elements their edges off the axis")
    })
}
