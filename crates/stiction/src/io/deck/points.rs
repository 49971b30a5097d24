//! `*RIGID BODY` and `*COUPLING`: nodes that move with a reference point.

use super::contact::Named;
use super::history::{Course, Span, Value};
use super::loads::courses;
use super::reader::Reader;
use super::supports::{NONE, direction};
use super::text::{of_card, quoted, triple};
use super::write::Writer;
use crate::Error;
use crate::io::abaqus::{Card, Found, Kind, Row};

/// A reference point with what moves with it.
pub(super) struct ReferencePoint<'a> {
    pub card: &'a Card,
    /// The node whose directions are displacements 1 to 3 and rotations 4 to 6.
    node: u32,
    /// The node whose directions 1 to 3 are the rotations.
    turns: Option<u32>,
    follows: Follows,
    /// Histories of displacements and rotations.
    pub motion: [u32; 6],
    /// Histories of forces and moments.
    pub load: [u32; 6],
}

/// What moves with a point.
enum Follows {
    /// The nodes of a set, or of a set of elements.
    Nodes(String, Vec<u32>),
    /// A surface as a rigid body, in these components.
    Rigid(Named, [bool; 3]),
    /// A surface in the mean.
    Mean(Named),
}

impl<'a> Reader<'a> {
    /// Reads the cards of all reference points: loads and supports may name their nodes before these cards.
    pub(super) fn reference_points(&mut self) -> Result<(), Error> {
        let input = self.input;
        let mut coupling: Option<&'a Card> = None;
        for card in &input.cards {
            match card.keyword.name.as_str() {
                "RIGIDBODY" => self.rigid_body(card)?,
                "COUPLING" => {
                    open(coupling)?;
                    coupling = Some(card);
                }
                "KINEMATIC" | "DISTRIBUTING" => match coupling.take() {
                    Some(of) => self.coupling(of, card)?,
                    None => {
                        let what = format!("*{} stands under no *COUPLING", card.keyword.title);
                        return Err(card.error(what, "write *COUPLING, REF NODE=, SURFACE= above it"));
                    }
                },
                _ => open(coupling)?,
            }
        }
        open(coupling)
    }

    fn rigid_body(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["NSET", "ELSET", "REFNODE", "ROTNODE"])?;
        let scope = self.scope(card);
        let follows = match (card.keyword.get("NSET"), card.keyword.get("ELSET")) {
            (Some(name), None) => {
                Follows::Nodes(name.to_string(), self.set(card, scope, Kind::Nodes, name)?.nodes.clone())
            }
            (None, Some(name)) => {
                let found: std::rc::Rc<Found> = self.set(card, scope, Kind::Elements, name)?;
                let mut nodes: Vec<u32> = found.elements.iter().flat_map(|&e| self.input.nodes_of(e)).collect();
                nodes.sort_unstable();
                nodes.dedup();
                Follows::Nodes(name.to_string(), nodes)
            }
            _ => return Err(card.error("*RIGID BODY has neither NSET= nor ELSET=, or both", "give one of them")),
        };
        let node = self.reference(card, "REF NODE")?;
        let turns = match card.has("ROTNODE") {
            true => Some(self.reference(card, "ROT NODE")?),
            false => None,
        };
        self.add_point(card, node, turns, follows)
    }

    fn coupling(&mut self, of: &'a Card, kind: &'a Card) -> Result<(), Error> {
        of.only(&["CONSTRAINTNAME", "REFNODE", "SURFACE"])?;
        kind.only(&[])?;
        let mut named = [false; 6];
        for row in kind.rows() {
            let first = direction(&row, 0)?;
            let last = if row.word(1).is_some() { direction(&row, 1)? } else { first };
            row.ends(2)?;
            if first > last || last > 6 {
                return Err(row.error(format!("there are no directions {first} to {last}"), "give some from 1 to 6"));
            }
            named[first - 1..last].iter_mut().for_each(|it| *it = true);
        }
        let name = of.needed("SURFACE")?.to_string();
        let surface = self.surface(&of.head(), &name)?;
        let follows = if kind.keyword.name == "DISTRIBUTING" {
            // All translations are distributed, whatever is named; rotations that are not carry no load.
            if surface.found.sides.is_empty() && surface.found.skin.is_empty() {
                return Err(of.error("a distributing coupling needs faces", "give a *SURFACE of element faces"));
            }
            Follows::Mean(surface)
        } else {
            if named == [false; 6] {
                return Err(kind.error("*KINEMATIC names no direction", "write 1, 3 below it"));
            }
            Follows::Rigid(surface, [named[0], named[1], named[2]])
        };
        let node = self.reference(of, "REF NODE")?;
        self.add_point(of, node, None, follows)
    }

    /// The node under a parameter; it is of no element.
    fn reference(&mut self, card: &Card, key: &str) -> Result<u32, Error> {
        let short = key.replace(' ', "");
        let Some(label) = card.keyword.get(&short).filter(|label| !label.is_empty()) else {
            let title = &card.keyword.title;
            return Err(card.error(format!("*{title} has no {key}="), format!("write *{title}, {key}=...")));
        };
        let scope = self.scope(card);
        let node = label.parse().ok().and_then(|label| self.sets.labelled_in(scope, label, true));
        let node = node.or_else(|| self.sets.qualified(label, true));
        // Some programs name a set of the one node.
        let node = match node {
            Some(node) => Some(node),
            None => match self.sets.find(scope, Kind::Nodes, label) {
                Some(found) => found?.nodes.first().copied().filter(|_| label.parse::<u32>().is_err()),
                None => None,
            },
        };
        let Some(node) = node else {
            return Err(card.error(format!("there is no node {label}"), format!("give {key}= one of the file")));
        };
        if self.used[node as usize] || self.is_reference(node) {
            let what = format!("node {label} belongs to an element or to another reference point");
            return Err(card.error(what, format!("give {key}= a node of its own, which is of no element")));
        }
        Ok(node)
    }

    fn add_point(&mut self, card: &'a Card, node: u32, turns: Option<u32>, follows: Follows) -> Result<(), Error> {
        if turns == Some(node) {
            return Err(card.error("REF NODE and ROT NODE are the same node", "give each a node of its own"));
        }
        self.points.push(ReferencePoint { card, node, turns, follows, motion: [NONE; 6], load: [NONE; 6] });
        Ok(())
    }

    /// Whether a node is one of a reference point.
    pub(super) fn is_reference(&self, node: u32) -> bool {
        self.points.iter().any(|point| point.node == node || point.turns == Some(node))
    }

    /// The place of a direction of a reference node, or an error.
    fn motion_of(&self, row: &Row, node: u32, component: usize) -> Result<(usize, usize), Error> {
        let at = self.points.iter().position(|point| point.node == node || point.turns == Some(node)).unwrap_or(0);
        if self.points.get(at).is_some_and(|point| point.turns == Some(node)) {
            if component > 3 {
                let what = format!("direction {component} of a ROT NODE: its directions 1 to 3 are the rotations");
                return Err(row.error(what, "give 1, 2 or 3"));
            }
            return Ok((at, component + 2));
        }
        if component > 6 {
            return Err(row.error(format!("there is no direction {component}"), "give 1 to 6"));
        }
        Ok((at, component - 1))
    }

    pub(super) fn prescribe_points(
        &mut self,
        row: &Row,
        nodes: &[u32],
        directions: &[usize],
        value: f64,
        course: Course,
    ) -> Result<(), Error> {
        let step = self.step_number();
        for &node in nodes {
            if course == Course::Stays {
                return Err(row.error("FIXED holds a reference point where it stands", "give the values of its motion"));
            }
            let turns = self.points.iter().any(|point| point.turns == Some(node));
            for &component in directions.iter().filter(|&&c| !turns || c <= 3) {
                let (at, k) = self.motion_of(row, node, component)?;
                let history = &mut self.points[at].motion[k];
                let old = (*history != NONE).then_some(*history);
                *history = self.histories.change(old, step, value, course, false).unwrap_or(NONE);
            }
        }
        Ok(())
    }

    pub(super) fn load_points(
        &mut self,
        row: &Row,
        nodes: &[u32],
        component: usize,
        value: f64,
        course: Course,
    ) -> Result<(), Error> {
        let step = self.step_number();
        for &node in nodes {
            let (at, k) = self.motion_of(row, node, component)?;
            let history = &mut self.points[at].load[k];
            let old = (*history != NONE).then_some(*history);
            *history = self.histories.change(old, step, value, course, true).ok_or_else(|| courses(row))?;
        }
        Ok(())
    }
}

/// An error if a coupling is still without its kind.
fn open(coupling: Option<&Card>) -> Result<(), Error> {
    match coupling {
        None => Ok(()),
        Some(card) => {
            let what = "*COUPLING is not followed by *KINEMATIC or *DISTRIBUTING";
            Err(card.error(what, "write one of them directly below it"))
        }
    }
}

impl Writer<'_, '_> {
    pub(super) fn couplings(&mut self) -> Result<(), Error> {
        for number in 0..self.reader.points.len() {
            let (input, point) = (self.reader.input, &self.reader.points[number]);
            let (card, label) = (point.card, self.reader.input.node_label(point.node));
            let (motion, load) = (point.motion, point.load);
            let (group, kind) = match &point.follows {
                Follows::Nodes(name, nodes) => (self.groups.nodes(name, nodes), String::new()),
                Follows::Rigid(surface, components) => {
                    let group = self.groups.surface(input, &surface.name, &surface.found, &card.head())?;
                    let held: String =
                        ["x", "y", "z"].iter().zip(components).filter(|it| *it.1).map(|it| *it.0).collect();
                    (group, if held.len() < 3 { quoted(&held) } else { String::new() })
                }
                Follows::Mean(surface) => {
                    (self.groups.surface(input, &surface.name, &surface.found, &card.head())?, "mean".to_string())
                }
            };
            let place = input.node(point.node);
            // A table for each stretch of steps; loads stand in the first.
            for (count, stretch) in self.stretches(&motion).into_iter().enumerate() {
                let again = if count == 0 { String::new() } else { format!(" - {}", count + 1) };
                self.out.table("[[coupling]]", of_card(card));
                self.out.line("name", &quoted(&format!("node {label}{again}")));
                self.out.line("on", &quoted(&group));
                self.out.line("point", &triple(place));
                match kind.as_str() {
                    "" => {}
                    "mean" => self.out.line("kind", "\"distributing\""),
                    held => self.out.line("components", held),
                }
                if let Some(span) = stretch {
                    self.prescribed(&motion, span, card)?;
                    self.during(span.first, span.last);
                }
                if count == 0 {
                    self.loads_of_point(&load, card)?;
                }
            }
        }
        Ok(())
    }

    /// The motions that are prescribed in a stretch of steps.
    fn prescribed(&mut self, motion: &[u32; 6], span: Span, card: &Card) -> Result<(), Error> {
        for (key, ids) in [("motion", &motion[..3]), ("rotation", &motion[3..])] {
            let mut parts = Vec::new();
            for (axis, &id) in ["x", "y", "z"].iter().zip(ids).filter(|it| *it.1 != NONE) {
                if self.reader.histories.spans(id).contains(&span) {
                    parts.push(format!("{axis} = {}", self.value(id, 0.0, card)?.toml()));
                }
            }
            if !parts.is_empty() {
                self.out.line(key, &format!("{{ {} }}", parts.join(", ")));
            }
        }
        Ok(())
    }

    fn loads_of_point(&mut self, load: &[u32; 6], card: &Card) -> Result<(), Error> {
        for (key, ids) in [("force", &load[..3]), ("moment", &load[3..])] {
            let value = |&id: &u32| if id == NONE { Ok(Value::Number(0.0)) } else { self.value(id, 0.0, card) };
            let values = ids.iter().map(value).collect::<Result<Vec<_>, _>>()?;
            if values.iter().any(|value| *value != Value::Number(0.0)) {
                let values: Vec<String> = values.iter().map(Value::toml).collect();
                self.out.line(key, &format!("[{}]", values.join(", ")));
            }
        }
        Ok(())
    }

    /// The stretches of steps in which motions of a point are prescribed; one without, if there are none.
    fn stretches(&self, motion: &[u32; 6]) -> Vec<Option<Span>> {
        let mut all: Vec<Option<Span>> = Vec::new();
        for span in motion.iter().filter(|&&id| id != NONE).flat_map(|&id| self.reader.histories.spans(id)) {
            if !all.contains(&Some(span)) {
                all.push(Some(span));
            }
        }
        if all.is_empty() { vec![None] } else { all }
    }
}
