//! `*CONTACT PAIR`, `*TIE` and what they refer to.

use std::rc::Rc;

use super::history::Course;
use super::reader::Reader;
use crate::Error;
use crate::io::abaqus::{Card, Found, Kind, Row};

/// `*SURFACE INTERACTION` with the cards below it.
pub(super) struct Interaction {
    pub name: String,
    /// Surfaces that stay together.
    pub tied: bool,
    /// The step with which tied surfaces begin to be in contact.
    pub freed: Option<usize>,
    /// Coefficient of friction.
    pub friction: f64,
    /// What it is over the steps, where it changes.
    pub changes: Option<u32>,
    /// Largest shear stress.
    pub limit: Option<f64>,
    /// Pressure over overlap, and shear over slip where it sticks, stress per length: the deck's, which is not solved with.
    pub stiffness: [Option<f64>; 2],
    /// What the deck regularises and this program does not.
    pub notes: Vec<String>,
}

impl Interaction {
    /// Whether the surfaces stay together in all steps.
    pub(super) fn is_tied(&self) -> bool {
        self.tied && self.freed.is_none()
    }
}

/// Two surfaces of a `*CONTACT PAIR` or a `*TIE`.
pub(super) struct Pair<'a> {
    pub row: Row<'a>,
    /// Name of the tie, or of the interaction.
    pub name: String,
    pub tie: bool,
    /// The surface that carries the points, and its counterpart.
    pub surfaces: [Named; 2],
    pub gap: Gap,
    /// How far apart tied surfaces may be.
    pub tolerance: Option<f64>,
    /// The steps from which on it is out (false) or in again.
    pub changes: Vec<(usize, bool)>,
}

impl Pair<'_> {
    /// Whether it is in, for each of so many steps.
    pub(super) fn steps(&self, count: usize) -> Vec<bool> {
        let of = |step: usize| self.changes.iter().rev().find(|change| change.0 <= step).is_none_or(|change| change.1);
        (0..count).map(of).collect()
    }
}

/// A surface with the name of its first line.
#[derive(Clone)]
pub(super) struct Named {
    pub name: String,
    pub found: Rc<Found>,
}

/// What the deck says of the gap.
#[derive(Clone)]
pub(super) enum Gap {
    AsMeshed,
    Closed,
    ClosedWithin(f64),
    /// At the nodes of a set.
    ClosedAt(String, Rc<Found>),
    Uniform(f64),
}

impl<'a> Reader<'a> {
    pub(super) fn interaction(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["NAME"])?;
        let name = card.needed("NAME")?.to_string();
        if self.interactions.iter().any(|other| other.name.eq_ignore_ascii_case(&name)) {
            return Err(card.error(format!("two interactions are called {name}"), "rename one of them"));
        }
        self.interactions.push(Interaction {
            name,
            tied: false,
            freed: None,
            friction: 0.0,
            changes: None,
            limit: None,
            stiffness: [None; 2],
            notes: Vec::new(),
        });
        Ok(())
    }

    fn open_interaction(&mut self, card: &Card) -> Result<&mut Interaction, Error> {
        let what = format!("*{} stands under no *SURFACE INTERACTION", card.keyword.title);
        self.interactions.last_mut().ok_or_else(|| card.error(what, "write *SURFACE INTERACTION, NAME=... above it"))
    }

    pub(super) fn surface_behavior(&mut self, card: &Card) -> Result<(), Error> {
        // The methods of constraint enforcement are one and the same here.
        card.only(&["PRESSURE-OVERCLOSURE", "DIRECT", "PENALTY", "AUGMENTEDLAGRANGE", "METHOD"])?;
        let law = card.keyword.get("PRESSURE-OVERCLOSURE").unwrap_or("HARD").to_uppercase();
        let rows = card.rows().collect::<Vec<_>>();
        for row in &rows {
            (0..row.fields.len()).try_for_each(|i| row.number(i).map(|_| ()))?;
        }
        let first = rows.first().map_or(Ok(None), |row| row.number(0))?;
        if self.in_step {
            return self.change_behavior_to(card, &law);
        }
        let interaction = self.open_interaction(card)?;
        let hard = "contact is solved hard";
        match (law.as_str(), first) {
            ("HARD", _) => {}
            ("TIED", _) => interaction.tied = true,
            ("LINEAR", Some(stiffness)) => {
                interaction.stiffness[0] = Some(stiffness).filter(|&stiffness| stiffness > 0.0);
                interaction.notes.push(format!(
                    "{hard}: the stiffness {stiffness} of the deck would add an overlap of pressure/{stiffness}"
                ));
            }
            ("LINEAR", None) => interaction.notes.push(format!("{hard}: a stiffness of the deck would add overlap")),
            ("EXPONENTIAL", _) => {
                interaction.notes.push(format!("{hard}: the deck's exponential law would press over a clearance"))
            }
            ("TABULAR", _) => {
                interaction.notes.push(format!("{hard}: the deck's table would add the overlap of each pressure"));
            }
            _ => {
                let what = format!("PRESSURE-OVERCLOSURE={law} is not read");
                return Err(card.error(what, "give HARD, LINEAR, EXPONENTIAL, TABULAR or TIED"));
            }
        }
        Ok(())
    }

    pub(super) fn friction(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["TAUMAX", "SLIPTOLERANCE", "ELASTICSLIP", "LAGRANGE"])?;
        let row = card.row()?;
        let coefficient = match &row {
            Some(row) => row.value(0, "the coefficient of friction")?,
            None => 0.0,
        };
        let stick = row.as_ref().map_or(Ok(None), |row| row.number(1))?;
        row.as_ref().map_or(Ok(()), |row| row.ends(2))?;
        if coefficient < 0.0 {
            return Err(card.error(format!("the coefficient of friction is {coefficient}"), "it is at least zero"));
        }
        let number = |text: &str| text.parse::<f64>().ok().filter(|limit| limit.is_finite() && *limit > 0.0);
        let limit = match card.keyword.get("TAUMAX") {
            None => None,
            Some(text) => Some(number(text).ok_or_else(|| card.error("TAUMAX is no positive number", "correct it"))?),
        };
        if self.in_step {
            return self.change_friction_to(card, coefficient, limit);
        }
        let interaction = self.open_interaction(card)?;
        (interaction.friction, interaction.limit) = (coefficient, limit);
        if let Some(slope) = stick.filter(|_| coefficient > 0.0) {
            interaction.stiffness[1] = Some(slope).filter(|&slope| slope > 0.0);
            let note = "friction sticks without giving way";
            interaction
                .notes
                .push(format!("{note}: the stick slope {slope} of the deck would add a slip of shear/{slope}"));
        }
        Ok(())
    }

    /// `*CHANGE FRICTION`: the `*FRICTION` below it holds from the beginning of this step on.
    pub(super) fn change_friction(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["INTERACTION"])?;
        let name = card.needed("INTERACTION")?;
        let which = self.interactions.iter().position(|it| it.name.eq_ignore_ascii_case(name));
        let which = which.ok_or_else(|| {
            card.error(format!("there is no *SURFACE INTERACTION {name}"), "name one that stands above the steps")
        })?;
        if !self.in_step {
            return Err(card.error("*CHANGE FRICTION stands outside of a step", "move it below *STEP"));
        }
        self.changing = Some(which);
        Ok(())
    }

    /// `*CHANGE SURFACE BEHAVIOR`: hard contact stays hard contact whatever its law, and a tie may become contact.
    pub(super) fn change_behavior(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["INTERACTION"])?;
        let name = card.needed("INTERACTION")?;
        let Some(which) = self.interactions.iter().position(|it| it.name.eq_ignore_ascii_case(name)) else {
            let what = format!("there is no *SURFACE INTERACTION {name}");
            return Err(card.error(what, "name one that stands above the steps"));
        };
        if !self.in_step {
            return Err(card.error("*CHANGE SURFACE BEHAVIOR stands outside of a step", "move it below *STEP"));
        }
        self.rewriting = Some(which);
        Ok(())
    }

    fn change_behavior_to(&mut self, card: &Card, law: &str) -> Result<(), Error> {
        let what = "*SURFACE BEHAVIOR stands in a step without *CHANGE SURFACE BEHAVIOR";
        let which = self.rewriting.take();
        let which = which.ok_or_else(|| card.error(what, "write *CHANGE SURFACE BEHAVIOR above it"))?;
        let step = self.step_number();
        let interaction = &mut self.interactions[which];
        let name = interaction.name.clone();
        if !["HARD", "LINEAR", "EXPONENTIAL", "TABULAR"].contains(&law) {
            let what = format!("{name} changes to PRESSURE-OVERCLOSURE={law}");
            return Err(card.error(what, "make a deck of each state: ties become contact, contact becomes no tie"));
        }
        match (interaction.is_tied(), step) {
            // Before the first step nothing has been tied.
            (true, 0) => interaction.tied = false,
            (true, _) => {
                interaction.freed = Some(step);
                self.notes.add(format!("{name}: contact is solved hard once it is tied no longer"));
            }
            (false, _) => self.notes.add(format!("{name}: contact is solved hard before and after its law changes")),
        }
        Ok(())
    }

    fn change_friction_to(&mut self, card: &Card, coefficient: f64, limit: Option<f64>) -> Result<(), Error> {
        let what = "*FRICTION stands in a step without *CHANGE FRICTION";
        let which = self.changing.take().ok_or_else(|| card.error(what, "write *CHANGE FRICTION above it"))?;
        let step = self.step_number();
        let interaction = &mut self.interactions[which];
        if interaction.is_tied() || interaction.limit != limit {
            let what = format!("TAUMAX of {} changes, or it is tied", interaction.name);
            return Err(card.error(what, "change the coefficient alone"));
        }
        let old = interaction.changes;
        interaction.changes = self.histories.change(old, step, coefficient, Course::Instant, false);
        Ok(())
    }

    pub(super) fn contact_pair(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["INTERACTION", "TYPE", "ADJUST", "SMALLSLIDING", "MECHANICALCONSTRAINT", "CPSET"])?;
        let name = card.needed("INTERACTION")?.to_string();
        let kind = card.keyword.get("TYPE").unwrap_or("").to_uppercase().replace([' ', '-'], "");
        let kinds = ["", "NODETOSURFACE", "SURFACETOSURFACE", "MORTAR", "LINMORTAR", "PGLINMORTAR", "MASSLESS"];
        if !kinds.contains(&kind.as_str()) {
            let what = format!("*CONTACT PAIR, TYPE={kind} is not read");
            return Err(card.error(what, "give NODE TO SURFACE, SURFACE TO SURFACE or MORTAR"));
        }
        let adjust = card.keyword.get("ADJUST").filter(|word| !word.is_empty());
        for row in card.rows() {
            let surfaces = self.two_surfaces(&row)?;
            let (gap, tolerance) = (self.adjusted(card, adjust, &surfaces[0])?, None);
            let (name, changes) = (name.clone(), Vec::new());
            self.pairs.push(Pair { row, name, tie: false, surfaces, gap, tolerance, changes });
        }
        Ok(())
    }

    /// The gap where nodes of the slave are moved onto the master: those nearer than a length, or those of a set.
    fn adjusted(&mut self, card: &Card, adjust: Option<&str>, slave: &Named) -> Result<Gap, Error> {
        let Some(adjust) = adjust else { return Ok(Gap::AsMeshed) };
        match adjust.parse::<f64>() {
            Ok(length) if length >= 0.0 && length.is_finite() => return Ok(Gap::ClosedWithin(length)),
            Ok(_) => {
                return Err(
                    card.error(format!("ADJUST={adjust} is no length"), "give a positive one, or 0 for overlaps alone")
                );
            }
            Err(_) => {}
        }
        let scope = self.scope(card);
        let moved = self.set(card, scope, Kind::Nodes, adjust)?;
        let corners = slave.found.sides.iter().filter_map(|&(element, side)| self.input.corners(element, side));
        let corners = corners.flatten().filter(|&node| node != u32::MAX && !super::sweep::is_copy(self.input, node));
        let nodes = corners.chain(slave.found.nodes.iter().copied());
        let (mut all, mut any) = (slave.found.skin.is_empty(), !slave.found.skin.is_empty());
        for node in nodes {
            let is_moved = moved.nodes.binary_search(&node).is_ok();
            (all, any) = (all && is_moved, any || is_moved);
        }
        if all {
            return Ok(Gap::Closed);
        }
        if !any {
            let what = format!("no corner of the surface {} is in the set {adjust} of ADJUST", slave.name);
            return Err(card.error(what, "name a set of nodes of the slave, the first surface, or a length"));
        }
        let name = self.sets.spelling(scope, Kind::Nodes, adjust).unwrap_or(adjust).to_string();
        Ok(Gap::ClosedAt(name, moved))
    }

    pub(super) fn tie(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["NAME", "ADJUST", "POSITIONTOLERANCE", "TYPE", "CYCLICSYMMETRY"])?;
        let name = card.keyword.get("NAME").filter(|name| !name.is_empty()).unwrap_or("tie").to_string();
        let tolerance = match card.keyword.get("POSITIONTOLERANCE") {
            None => None,
            Some(text) => {
                let number = text.parse::<f64>().ok().filter(|length| length.is_finite() && *length >= 0.0);
                Some(number.ok_or_else(|| card.error("POSITION TOLERANCE is no length", "correct it"))?)
            }
        };
        if card.has("CYCLICSYMMETRY") {
            return self.cuts(card, &name, tolerance);
        }
        for row in card.rows() {
            let surfaces = self.two_surfaces(&row)?;
            let (name, gap, changes) = (name.clone(), Gap::AsMeshed, Vec::new());
            self.pairs.push(Pair { row, name, tie: true, surfaces, gap, tolerance, changes });
        }
        Ok(())
    }

    /// The slave and the master of a line.
    pub(super) fn two_surfaces(&mut self, row: &Row) -> Result<[Named; 2], Error> {
        let [slave, master] = [0, 1].map(|i| row.needed(i, "a surface").map(str::to_string));
        row.ends(2)?;
        Ok([self.surface(row, &slave?)?, self.surface(row, &master?)?])
    }

    /// The surface called `name`.
    pub(super) fn surface(&mut self, row: &Row, name: &str) -> Result<Named, Error> {
        let scope = self.scope(row.card);
        let found = match self.sets.find(scope, Kind::Surface, name) {
            Some(found) => found?,
            None => {
                let names = self.sets.names(scope, Kind::Surface);
                let remedy = format!("the surfaces are {}", names[..names.len().min(20)].join(", "));
                return Err(row.error(format!("there is no *SURFACE {name}"), remedy));
            }
        };
        let name = self.sets.spelling(scope, Kind::Surface, name).unwrap_or(name).to_string();
        Ok(Named { name, found })
    }

    /// `*MODEL CHANGE, TYPE=CONTACT PAIR`: pairs are taken out, or put in again, with this step.
    pub(super) fn model_change(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["TYPE", "ADD", "REMOVE", "MECHANICALSTRAINATREACTIVATION"])?;
        let kind = card.needed("TYPE")?.to_uppercase().replace(' ', "");
        if kind != "CONTACTPAIR" {
            let what = format!("*MODEL CHANGE, TYPE={kind} is not read");
            return Err(card.error(what, "only contact pairs are taken out and put in: make a deck of each state"));
        }
        let adds = match (card.has("ADD"), card.has("REMOVE")) {
            (true, false) => true,
            (false, true) => false,
            _ => return Err(card.error("*MODEL CHANGE says neither ADD nor REMOVE, or both", "write one of them")),
        };
        if !self.in_step {
            return Err(card.error("*MODEL CHANGE stands outside of a step", "move it below *STEP"));
        }
        let step = self.step_number();
        for row in card.rows() {
            let (slave, master) = (row.needed(0, "a surface")?, row.needed(1, "a surface")?);
            row.ends(2)?;
            let meant = |pair: &&mut Pair| {
                let [s, m] = &pair.surfaces;
                !pair.tie && s.name.eq_ignore_ascii_case(slave) && m.name.eq_ignore_ascii_case(master)
            };
            let Some(pair) = self.pairs.iter_mut().find(meant) else {
                let what = format!("no *CONTACT PAIR has the slave {slave} and the master {master}");
                return Err(row.error(what, "name the surfaces as the pair does"));
            };
            pair.changes.push((step, adds));
        }
        Ok(())
    }

    pub(super) fn clearance(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["MASTER", "SLAVE", "VALUE"])?;
        let (master, slave) = (card.needed("MASTER")?, card.needed("SLAVE")?);
        let value = card.needed("VALUE")?;
        let Some(value) = value.parse::<f64>().ok().filter(|x| x.is_finite()) else {
            return Err(card.error(format!("VALUE={value} is no length"), "give a number"));
        };
        let meant = |pair: &&mut Pair| {
            let [s, m] = &pair.surfaces;
            !pair.tie && s.name.eq_ignore_ascii_case(slave) && m.name.eq_ignore_ascii_case(master)
        };
        match self.pairs.iter_mut().find(meant) {
            Some(pair) => pair.gap = Gap::Uniform(value),
            None => {
                let what = format!("no *CONTACT PAIR above has the slave {slave} and the master {master}");
                return Err(card.error(what, "write the pair above its *CLEARANCE"));
            }
        }
        Ok(())
    }
}
