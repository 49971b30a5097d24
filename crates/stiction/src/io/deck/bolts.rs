//! `*PRE-TENSION SECTION`: bolts that are tightened through a node of reference.

use super::contact::Named;
use super::reader::Reader;
use super::supports::NONE;
use super::text::{of_card, quoted, triple};
use super::write::Writer;
use crate::Error;
use crate::io::abaqus::Card;
use crate::mesh::v3::{add, cross, dot, scale, sub};

/// A cut through a bolt, whose force and shortening are those of a node in direction 1.
pub(super) struct BoltCard<'a> {
    pub card: &'a Card,
    pub surface: Named,
    normal: Option<[f64; 3]>,
    /// The node of reference.
    pub node: u32,
    /// The step from which on its shortening stays.
    locked: Option<usize>,
}

impl<'a> Reader<'a> {
    pub(super) fn pretension(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["SURFACE", "NODE", "ELEMENT"])?;
        if card.has("ELEMENT") {
            return Err(card.error("a bolt of one beam is not read", "mesh it with solid elements and give SURFACE="));
        }
        let (surface, label) = (card.needed("SURFACE")?.to_string(), card.needed("NODE")?.to_string());
        let scope = self.scope(card);
        let node = label.parse().ok().and_then(|label| self.sets.labelled_in(scope, label, true));
        let Some(node) = node.or_else(|| self.sets.qualified(&label, true)) else {
            return Err(card.error(format!("there is no node {label}"), "give NODE= one of the file"));
        };
        if self.used[node as usize] || self.bolts.iter().any(|bolt| bolt.node == node) {
            let what = format!("node {label} belongs to an element or another bolt");
            return Err(card.error(what, "give each bolt a node of its own, which is of no element"));
        }
        let row = card.row()?;
        let normal = match &row {
            None => None,
            Some(row) => {
                row.ends(3)?;
                Some([row.value(0, "the axis")?, row.value(1, "the axis")?, row.value(2, "the axis")?])
            }
        };
        let surface = self.surface(&card.head(), &surface)?;
        self.bolts.push(BoltCard { card, surface, normal, node, locked: None });
        Ok(())
    }

    /// `*BOUNDARY, FIXED` on these nodes: bolts keep the shortening that they have reached. False where one is no bolt.
    pub(super) fn lock(&mut self, nodes: &[u32]) -> bool {
        let step = self.step_number();
        let all = nodes.iter().all(|node| self.bolts.iter().any(|bolt| bolt.node == *node));
        if all && step > 0 {
            for bolt in self.bolts.iter_mut().filter(|bolt| nodes.contains(&bolt.node)) {
                bolt.locked.get_or_insert(step);
            }
        }
        all && step > 0
    }
}

impl Writer<'_, '_> {
    /// The sum of the normals of faces, out of their elements; of any length.
    fn outward(&self, faces: &[(u32, u8)]) -> [f64; 3] {
        let input = self.reader.input;
        let mut sum = [0.0; 3];
        for &(element, side) in faces {
            let Some(corners) = input.corners(element, side) else { continue };
            let x = corners.map(|node| if node == u32::MAX { None } else { Some(input.node(node)) });
            let [Some(a), Some(b), Some(c), d] = x else { continue };
            let normal = match d {
                Some(d) => cross(sub(c, a), sub(d, b)),
                None => cross(sub(b, a), sub(c, a)),
            };
            let nodes = input.nodes_of(element);
            let middle = nodes.iter().fold([0.0; 3], |sum, &node| add(sum, input.node(node)));
            let middle = scale(1.0 / nodes.len() as f64, middle);
            let is_outward = dot(normal, sub(a, middle)) > 0.0;
            sum = add(sum, if is_outward { normal } else { scale(-1.0, normal) });
        }
        sum
    }

    pub(super) fn bolts(&mut self) -> Result<(), Error> {
        for number in 0..self.reader.bolts.len() {
            let bolt = &self.reader.bolts[number];
            let (card, first) = (bolt.card, 3 * bolt.node as usize);
            let [force, shortening] = [self.reader.forces[first], self.reader.supports[first]];
            let label = self.reader.input.node_label(bolt.node);
            let tightened = match (force, shortening) {
                (NONE, NONE) => {
                    let what = format!("nothing tightens this bolt: node {label} has no force and no displacement");
                    return Err(card.error(what, "give it direction 1 of *CLOAD, or of *BOUNDARY"));
                }
                (force, NONE) => ("force", force),
                (NONE, shortening) => ("shortening", shortening),
                _ => {
                    let what = format!("node {label} of this bolt has a force and a displacement");
                    return Err(card.error(what, "lock the bolt by *BOUNDARY, FIXED in the step after its force"));
                }
            };
            let ends = |id: u32| id != NONE && self.reader.histories.spans(id).iter().any(|span| span.last.is_some());
            if ends(shortening) {
                let what = format!("OP=NEW releases node {label}, by which this bolt is shortened");
                return Err(card.error(what, "name the node again in each such step"));
            }
            let (surface, normal, locked) = (bolt.surface.clone(), bolt.normal, bolt.locked);
            let faces = surface.found.sides.clone();
            let group = self.groups.faces(self.reader.input, &surface.name, &faces, &card.head())?;
            let mut value = self.value(tightened.1, 0.0, card)?;
            if let Some(swept) = self.reader.input.swept().filter(|_| tightened.0 == "force") {
                value = value.times(swept.part);
            }
            self.out.table("[[bolt]]", of_card(card));
            self.out.line("on", &quoted(&group));
            if let Some(normal) = normal {
                // The nodes of the cut move with the cells before it along the axis: here with the elements that are not those of the
                // surface, as in CalculiX.
                let looks_in = dot(normal, self.outward(&faces)) < 0.0;
                if looks_in {
                    value = value.times(-1.0);
                    let note = "*PRE-TENSION SECTION: the vector looks into the elements of the surface: the signs of force and shortening are turned";
                    self.reader.notes.add(note);
                }
                self.out.line("axis", &triple(if looks_in { normal } else { scale(-1.0, normal) }));
            }
            self.out.line(tightened.0, &value.toml());
            if let Some(step) = locked {
                self.out.line("lock", &quoted(&self.reader.steps[step - 1].name));
            }
        }
        Ok(())
    }
}
