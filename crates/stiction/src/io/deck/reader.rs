//! From cards to what they say together.

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use super::bolts::BoltCard;
use super::contact::{Interaction, Pair};
use super::cyclic::Cuts;
use super::equations::EquationCard;
use super::history::{Amplitude, Histories};
use super::keywords::{HARMLESS, REFUSED};
use super::loads::{OnCells, OnSurface};
use super::materials::{MaterialCard, Names, Orientation, Section};
use super::points::ReferencePoint;
use super::steps::StepCard;
use super::supports::NONE;
use super::transform::Transform;
use crate::Error;
use crate::io::abaqus::{Card, Found, Input, Kind, Resolver, Row, kind_name};

/// Keywords under *MATERIAL that count only where a section is made of the material.
const OF_MATERIALS: [&str; 3] = ["creep", "a plastic material", "a material that is not linear elastic"];

/// Everything the cards say, in the numbers of the input.
pub(super) struct Reader<'a> {
    pub input: &'a Input,
    pub sets: Resolver<'a>,
    /// Whether each node belongs to a cell.
    pub used: Vec<bool>,
    pub title: Option<String>,
    pub notes: Notes,
    pub harmless: BTreeSet<String>,
    /// What sections may name, wherever it stands.
    pub named: Names<'a>,
    pub materials: Vec<MaterialCard<'a>>,
    pub orientations: Vec<Orientation>,
    pub sections: Vec<Section>,
    pub interactions: Vec<Interaction>,
    /// The interaction that the next *FRICTION in this step is of.
    pub changing: Option<usize>,
    /// The same of the next *SURFACE BEHAVIOR.
    pub rewriting: Option<usize>,
    pub pairs: Vec<Pair<'a>>,
    pub bolts: Vec<BoltCard<'a>>,
    pub equations: Vec<EquationCard<'a>>,
    /// Cuts of a sector.
    pub cyclic: Vec<Cuts<'a>>,
    pub amplitudes: Vec<Amplitude>,
    pub amplitude_names: HashMap<String, usize>,
    pub histories: Histories,
    /// History of each displacement, `3 node + component`.
    pub supports: Vec<u32>,
    /// What supports and forces count along, and its place for each node.
    pub transforms: Vec<Transform>,
    pub transform_of: Vec<u32>,
    /// Whether this step releases the supports that it does not name.
    pub released: bool,
    /// Reference points of rigid bodies and couplings.
    pub points: Vec<ReferencePoint<'a>>,
    /// History of each force.
    pub forces: Vec<u32>,
    /// History of the pressure on faces of elements, and these in their order with the line that names them first.
    pub pressures: HashMap<(u32, u8), u32>,
    pub pressed: Vec<((u32, u8), Row<'a>)>,
    pub on_surfaces: Vec<OnSurface<'a>>,
    pub on_cells: Vec<OnCells<'a>>,
    /// History of the temperature of each node, and the first line that gives one.
    pub temperatures: Vec<u32>,
    pub heated: Option<Row<'a>>,
    /// Initial temperature of each node; NaN where none is given.
    pub initial: Vec<f64>,
    /// Nodes that cards name by a set: its name and its nodes.
    pub named_nodes: Vec<(String, Rc<Found>)>,
    pub steps: Vec<StepCard<'a>>,
    pub in_step: bool,
    /// Kinds of cards that have renewed their values in this step.
    renewed: BTreeSet<String>,
}

/// Remarks, each once.
#[derive(Default)]
pub(super) struct Notes(pub Vec<String>);

impl Notes {
    pub(super) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.0.contains(&note) {
            self.0.push(note);
        }
    }
}

impl<'a> Reader<'a> {
    /// Reads all cards of an input.
    pub(super) fn read(input: &'a Input) -> Result<Self, Error> {
        let nodes = input.counts()[0];
        let mut reader = Reader {
            input,
            sets: input.sets(),
            used: input.nodes_of_cells(),
            title: None,
            notes: Notes::default(),
            harmless: BTreeSet::new(),
            named: Names::new(&input.cards),
            materials: Vec::new(),
            orientations: Vec::new(),
            sections: Vec::new(),
            interactions: Vec::new(),
            changing: None,
            rewriting: None,
            pairs: Vec::new(),
            bolts: Vec::new(),
            equations: Vec::new(),
            cyclic: Vec::new(),
            amplitudes: Vec::new(),
            amplitude_names: HashMap::new(),
            histories: Histories::default(),
            supports: vec![NONE; 3 * nodes],
            transforms: Vec::new(),
            transform_of: vec![NONE; nodes],
            released: false,
            points: Vec::new(),
            forces: vec![NONE; 3 * nodes],
            pressures: HashMap::new(),
            pressed: Vec::new(),
            on_surfaces: Vec::new(),
            on_cells: Vec::new(),
            temperatures: vec![NONE; nodes],
            heated: None,
            initial: vec![f64::NAN; nodes],
            named_nodes: Vec::new(),
            steps: Vec::new(),
            in_step: false,
            renewed: BTreeSet::new(),
        };
        reader.reference_points()?;
        for card in &input.cards {
            reader.card(card)?;
        }
        if let Some(open) = reader.steps.last().filter(|_| reader.in_step) {
            return Err(open.card.error("this step has no *END STEP", "write it, or the deck again if it is cut off"));
        }
        reader.complete_sweep()?;
        if reader.steps.is_empty() {
            let what = "the deck has no *STEP: it is a mesh without loads";
            let remedy = "name it under [mesh] of a case file, or write a *STEP with *STATIC";
            return Err(Error::new("", what, remedy));
        }
        Ok(reader)
    }

    fn card(&mut self, card: &'a Card) -> Result<(), Error> {
        let name = card.keyword.name.as_str();
        let step_needed = ["CLOAD", "DLOAD", "DSLOAD", "TEMPERATURE"].contains(&name);
        if step_needed && !self.in_step {
            let what = format!("*{} stands outside of a step", card.keyword.title);
            return Err(card.error(what, "move it between *STEP and *END STEP"));
        }
        match name {
            "HEADING" => self.title = card.rows().map(|row| row.fields.join(", ")).find(|line| !line.is_empty()),
            "MATERIAL" => self.material(card)?,
            "ELASTIC" => self.elastic(card)?,
            "DENSITY" => self.density(card)?,
            "EXPANSION" => self.expansion(card)?,
            "ORIENTATION" => self.orientation(card)?,
            "SOLIDSECTION" => self.solid_section(card)?,
            "SURFACEINTERACTION" => self.interaction(card)?,
            "SURFACEBEHAVIOR" => self.surface_behavior(card)?,
            "FRICTION" => self.friction(card)?,
            "CHANGEFRICTION" => self.change_friction(card)?,
            "CHANGESURFACEBEHAVIOR" => self.change_behavior(card)?,
            "CONTACTPAIR" => self.contact_pair(card)?,
            "CLEARANCE" => self.clearance(card)?,
            "TIE" => self.tie(card)?,
            "AMPLITUDE" => self.amplitude(card)?,
            "STEP" => self.step(card)?,
            "ENDSTEP" => self.end_step(card)?,
            "STATIC" => self.statics(card)?,
            "BOUNDARY" => self.boundary(card)?,
            "CLOAD" => self.cload(card)?,
            "DLOAD" => self.dload(card)?,
            "DSLOAD" => self.dsload(card)?,
            "TEMPERATURE" => self.temperature(card)?,
            "INITIALCONDITIONS" => self.initial_conditions(card)?,
            "RESTART" if !card.has("READ") => self.is_harmless(card),
            // Read before all others.
            "RIGIDBODY" | "COUPLING" | "KINEMATIC" | "DISTRIBUTING" => {}
            "MODELCHANGE" => self.model_change(card)?,
            "TRANSFORM" => self.transform(card)?,
            "EQUATION" => self.equation(card)?,
            "CYCLICSYMMETRYMODEL" => self.cyclic_symmetry_model(card)?,
            "PRE-TENSIONSECTION" | "PRETENSIONSECTION" => self.pretension(card)?,
            _ if HARMLESS.contains(&name) => self.is_harmless(card),
            _ => self.refuse(card)?,
        }
        Ok(())
    }

    fn is_harmless(&mut self, card: &Card) {
        self.harmless.insert(format!("*{}", card.keyword.title));
    }

    fn refuse(&mut self, card: &Card) -> Result<(), Error> {
        let title = &card.keyword.title;
        if let Some((_, what, remedy)) = REFUSED.iter().find(|entry| entry.0.contains(&card.keyword.name.as_str())) {
            if OF_MATERIALS.contains(what) && !self.in_step {
                return self.refuse_material(card, what, remedy);
            }
            return Err(card.error(format!("*{title} is {what}, which a case cannot hold"), *remedy));
        }
        let what = match card.keyword.name.as_str() {
            "ELEMENT" => format!("elements of type {} are no solids", card.keyword.get("TYPE").unwrap_or("")),
            "SURFACE" => format!("a surface of type {} is not read", card.keyword.get("TYPE").unwrap_or("")),
            _ => format!("*{title} is not read"),
        };
        Err(card.error(what, "take it out if it changes nothing"))
    }

    /// Where the labels and names of a card hold.
    pub(super) fn scope(&self, card: &Card) -> usize {
        self.input.scopes(card.part).first().copied().unwrap_or(0)
    }

    /// The number of the present step; before the first it is the first.
    pub(super) fn step_number(&self) -> usize {
        self.steps.len().saturating_sub(1)
    }

    /// A set by its name.
    pub(super) fn set(&mut self, card: &Card, scope: usize, kind: Kind, name: &str) -> Result<Rc<Found>, Error> {
        match self.sets.find(scope, kind, name) {
            Some(found) => found,
            None => {
                let names = self.sets.names(scope, kind);
                let shown = names[..names.len().min(20)].join(", ");
                let what = format!("*{} names the {} {name}, which there is not", card.keyword.title, kind_name(kind));
                Err(card.error(what, format!("those of the input are {shown}")))
            }
        }
    }

    /// Nodes that a line names by number or set.
    pub(super) fn nodes(&mut self, row: &Row, i: usize) -> Result<Vec<u32>, Error> {
        let word = row.needed(i, "a node or a set")?;
        let scope = self.scope(row.card);
        let only = match row.whole(i) {
            Some(label) => u32::try_from(label).ok().and_then(|label| self.sets.labelled_in(scope, label, true)),
            None => self.sets.qualified(word, true),
        };
        if let Some(node) = only {
            return Ok(vec![node]);
        }
        if row.whole(i).is_some() {
            return Err(row.error(format!("there is no node {word}"), "name one of the file"));
        }
        let kind = Kind::Nodes;
        let found = match self.sets.find(scope, kind, word) {
            Some(found) => found?,
            None => {
                let names = self.sets.names(scope, kind);
                let remedy = format!("those of the input are {}", names[..names.len().min(20)].join(", "));
                return Err(row.error(format!("there is no node set {word}"), remedy));
            }
        };
        let spelling = self.sets.spelling(scope, kind, word).unwrap_or(word).to_string();
        if !self.named_nodes.iter().any(|named| named.0 == spelling) {
            self.named_nodes.push((spelling, found.clone()));
        }
        Ok(found.nodes.clone())
    }

    pub(super) fn begin_step(&mut self) {
        self.renewed.clear();
        (self.released, self.changing, self.rewriting) = (false, None, None);
    }

    pub(super) fn finish_step(&mut self) -> Result<(), Error> {
        self.end_supports();
        Ok(())
    }

    /// Whether this card ends the values of earlier steps that its kind has given: the first in a step with OP=NEW.
    pub(super) fn renews(&mut self, card: &Card) -> Result<bool, Error> {
        match card.keyword.get("OP").map(str::to_uppercase).as_deref() {
            None | Some("MOD") => Ok(false),
            Some("NEW") => {
                // Pressures on faces and surfaces end together.
                let kind = if card.keyword.name == "DSLOAD" { "DLOAD" } else { &card.keyword.name };
                Ok(self.renewed.insert(kind.to_string()) && self.steps.len() > 1)
            }
            Some(other) => Err(card.error(format!("OP={other} is not read"), "give MOD or NEW")),
        }
    }
}
