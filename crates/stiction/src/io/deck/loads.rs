//! `*CLOAD`, `*DLOAD`, `*DSLOAD`, `*TEMPERATURE` and `*INITIAL CONDITIONS`.

use std::rc::Rc;

use super::contact::Named;
use super::history::Course;
use super::reader::Reader;
use super::supports::{NONE, direction};
use crate::Error;
use crate::io::abaqus::{Card, Found, Kind, Row};

/// Gravity or a rotation on a set of elements.
pub(super) struct OnCells<'a> {
    pub row: Row<'a>,
    /// The set, or `element 12`.
    pub name: String,
    pub elements: Vec<u32>,
    pub label: String,
    pub kind: CellLoad,
}

/// What acts on the mass.
pub(super) enum CellLoad {
    /// Unit direction and the history of the acceleration.
    Gravity([f64; 3], u32),
    /// Point, axis and the history of the squared speed.
    Rotation([f64; 3], [f64; 3], u32),
}

impl CellLoad {
    fn history(&self) -> u32 {
        match self {
            CellLoad::Gravity(_, id) | CellLoad::Rotation(_, _, id) => *id,
        }
    }
}

/// Unit directions that differ by less are one.
const ONE_DIRECTION: f64 = 1e-10;

/// A pressure on a surface.
pub(super) struct OnSurface<'a> {
    pub row: Row<'a>,
    pub surface: Named,
    pub history: u32,
}

impl<'a> Reader<'a> {
    pub(super) fn cload(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["OP", "AMPLITUDE", "TIMEDELAY"])?;
        if self.renews(card)? {
            let step = self.step_number();
            for history in self.forces.iter_mut().filter(|history| **history != NONE) {
                *history = self.histories.change(Some(*history), step, 0.0, Course::Ramp, false).unwrap_or(NONE);
            }
            let Self { points, histories, .. } = self;
            for history in points.iter_mut().flat_map(|point| &mut point.load).filter(|history| **history != NONE) {
                *history = histories.change(Some(*history), step, 0.0, Course::Ramp, false).unwrap_or(NONE);
            }
        }
        let (course, step) = (self.course(card)?, self.step_number());
        for row in card.rows() {
            let nodes = self.nodes(&row, 0)?;
            let component = direction(&row, 1)?;
            let value = row.value(2, "the force")?;
            row.ends(3)?;
            let (points, nodes): (Vec<u32>, Vec<u32>) = nodes.into_iter().partition(|&node| self.is_reference(node));
            self.load_points(&row, &points, component, value, course)?;
            if nodes.is_empty() {
                continue;
            }
            if component > 3 {
                let what =
                    format!("direction {component} is a moment or another quantity, and solids have no rotations");
                return Err(row.error(what, "give forces in directions 1, 2 and 3"));
            }
            let tightens = |node: &u32| component == 1 && self.bolts.iter().any(|bolt| bolt.node == *node);
            if let Some(&loose) = nodes.iter().find(|&node| !self.used[*node as usize] && !tightens(node)) {
                let what = format!("node {} belongs to no solid element", self.input.node_label(loose));
                return Err(row.error(what, "load nodes of the body"));
            }
            for &node in &nodes {
                let history = &mut self.forces[3 * node as usize + component - 1];
                let old = (*history != NONE).then_some(*history);
                *history = self.histories.change(old, step, value, course, true).ok_or_else(|| courses(&row))?;
            }
        }
        Ok(())
    }

    pub(super) fn dload(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["OP", "AMPLITUDE", "TIMEDELAY"])?;
        self.renew_distributed(card)?;
        let course = self.course(card)?;
        for row in card.rows() {
            let (name, elements) = self.elements(&row, 0)?;
            let label = row.needed(1, "the kind of load")?.to_uppercase();
            match label.strip_prefix('P').and_then(|face| face.parse::<u8>().ok()).filter(|face| (1..=6).contains(face))
            {
                Some(face) => self.pressure(&row, &elements, face - 1, course)?,
                None if label.starts_with("GRAV") => self.gravity(row, name, elements, label, course)?,
                None if label.starts_with("CENTRIF") => self.rotation(row, name, elements, label, course)?,
                None => {
                    let what = format!("the load {label} is not read");
                    return Err(row.error(what, "give a pressure P1 to P6, GRAV or CENTRIF"));
                }
            }
        }
        Ok(())
    }

    fn pressure(&mut self, row: &Row<'a>, elements: &[u32], face: u8, course: Course) -> Result<(), Error> {
        let (value, step) = (row.value(2, "the pressure")?, self.step_number());
        row.ends(3)?;
        for &element in elements {
            super::groups::corners(self.input, (element, face), row)?;
            let old = self.pressures.get(&(element, face)).copied();
            let id = self.histories.change(old, step, value, course, true).ok_or_else(|| courses(row))?;
            if self.pressures.insert((element, face), id).is_none() {
                self.pressed.push(((element, face), row.clone()));
            }
        }
        Ok(())
    }

    fn gravity(
        &mut self,
        row: Row<'a>,
        name: String,
        elements: Vec<u32>,
        label: String,
        course: Course,
    ) -> Result<(), Error> {
        let size = row.value(2, "the acceleration")?;
        let along = [row.value(3, "its direction")?, row.value(4, "its direction")?, row.value(5, "its direction")?];
        row.ends(6)?;
        let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 || !length.is_finite() {
            return Err(row.error("the acceleration has no direction", "give a vector as the last three fields"));
        }
        let along = along.map(|x| x / length);
        let step = self.step_number();
        // Accelerations of different directions add up.
        let is_along = |kind: &CellLoad| match kind {
            CellLoad::Gravity(other, _) => (0..3).all(|c| (along[c] - other[c]).abs() <= ONE_DIRECTION),
            CellLoad::Rotation(..) => false,
        };
        let found = self.on_the_same(&label, &elements).into_iter().find(|&i| is_along(&self.on_cells[i].kind));
        let before = found.map(|i| self.on_cells[i].kind.history());
        let id = self.histories.change(before, step, size, course, true).ok_or_else(|| courses(&row))?;
        let kind = CellLoad::Gravity(along, id);
        match found {
            Some(i) => self.on_cells[i].kind = kind,
            None => self.on_cells.push(OnCells { row, name, elements, label, kind }),
        }
        Ok(())
    }

    fn rotation(
        &mut self,
        row: Row<'a>,
        name: String,
        elements: Vec<u32>,
        label: String,
        course: Course,
    ) -> Result<(), Error> {
        let square = row.value(2, "the squared speed")?;
        let point = [row.value(3, "a point")?, row.value(4, "a point")?, row.value(5, "a point")?];
        let axis = [row.value(6, "the axis")?, row.value(7, "the axis")?, row.value(8, "the axis")?];
        row.ends(9)?;
        if square < 0.0 {
            return Err(row.error("the squared speed is negative", "give the square of radians per time"));
        }
        if axis == [0.0; 3] {
            return Err(row.error("the axis has no direction", "give a vector as the last three fields"));
        }
        let step = self.step_number();
        let found = self.on_the_same(&label, &elements).first().copied();
        let before = match found.map(|i| &self.on_cells[i].kind) {
            Some(CellLoad::Rotation(p, a, id)) if *p == point && *a == axis => Some(*id),
            Some(_) => return Err(row.error("the rotation has another axis in an earlier step", "keep its axis")),
            None => None,
        };
        let id = self.histories.change(before, step, square, course, true).ok_or_else(|| courses(&row))?;
        let kind = CellLoad::Rotation(point, axis, id);
        match found {
            Some(i) => self.on_cells[i].kind = kind,
            None => self.on_cells.push(OnCells { row, name, elements, label, kind }),
        }
        Ok(())
    }

    /// Loads of one kind on these elements that were given before.
    fn on_the_same(&self, label: &str, elements: &[u32]) -> Vec<usize> {
        let is_one = |&i: &usize| self.on_cells[i].label == label && self.on_cells[i].elements == elements;
        (0..self.on_cells.len()).filter(is_one).collect()
    }

    pub(super) fn dsload(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["OP", "AMPLITUDE", "TIMEDELAY"])?;
        self.renew_distributed(card)?;
        let (course, step) = (self.course(card)?, self.step_number());
        for row in card.rows() {
            let surface = self.surface(&row, row.needed(0, "a surface")?)?;
            let label = row.needed(1, "the kind of load")?;
            if !label.eq_ignore_ascii_case("P") {
                return Err(row.error(format!("the load {label} is not read"), "give a pressure, P"));
            }
            let value = row.value(2, "the pressure")?;
            row.ends(3)?;
            let old = self.on_surfaces.iter().position(|it| it.surface.name == surface.name);
            let before = old.map(|at| self.on_surfaces[at].history);
            let history = self.histories.change(before, step, value, course, true).ok_or_else(|| courses(&row))?;
            match old {
                Some(at) => self.on_surfaces[at].history = history,
                None => self.on_surfaces.push(OnSurface { row, surface, history }),
            }
        }
        Ok(())
    }

    /// With OP=NEW the loads of earlier steps end.
    fn renew_distributed(&mut self, card: &Card) -> Result<(), Error> {
        if !self.renews(card)? {
            return Ok(());
        }
        let step = self.step_number();
        let Self { histories, pressures, on_cells, on_surfaces, .. } = self;
        let mut end = |id: &mut u32| *id = histories.change(Some(*id), step, 0.0, Course::Ramp, false).unwrap_or(NONE);
        pressures.values_mut().for_each(&mut end);
        on_surfaces.iter_mut().for_each(|it| end(&mut it.history));
        for load in on_cells {
            match &mut load.kind {
                CellLoad::Gravity(_, id) | CellLoad::Rotation(_, _, id) => end(id),
            }
        }
        Ok(())
    }

    pub(super) fn temperature(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["OP", "AMPLITUDE", "TIMEDELAY"])?;
        if self.renews(card)? && self.temperatures.iter().any(|&id| id != NONE) {
            return Err(card.error("OP=NEW ends temperatures of earlier steps", "give the temperatures of each step"));
        }
        let course = match self.course(card)? {
            Course::Amplitude(which) => Course::Anew(which),
            course => course,
        };
        let step = self.step_number();
        for row in card.rows() {
            let nodes = self.nodes(&row, 0)?;
            let value = row.value(1, "the temperature")?;
            row.ends(2)?;
            for &node in &nodes {
                let history = &mut self.temperatures[node as usize];
                let old = (*history != NONE).then_some(*history);
                // Temperatures begin at the initial ones, whose value is known at the end of the deck.
                *history = self.histories.change(old, step, value, course, false).unwrap_or(NONE);
            }
            self.heated.get_or_insert(row);
        }
        Ok(())
    }

    pub(super) fn initial_conditions(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["TYPE"])?;
        let kind = card.needed("TYPE")?.to_uppercase();
        if kind != "TEMPERATURE" {
            let what = format!("*INITIAL CONDITIONS, TYPE={kind} is not read");
            return Err(card.error(what, "a case begins without stress and at rest: take it out"));
        }
        for row in card.rows() {
            let nodes = self.nodes(&row, 0)?;
            let value = row.value(1, "the temperature")?;
            row.ends(2)?;
            nodes.iter().for_each(|&node| self.initial[node as usize] = value);
        }
        Ok(())
    }

    /// Elements that a line names, and what they are called.
    fn elements(&mut self, row: &Row, i: usize) -> Result<(String, Vec<u32>), Error> {
        let word = row.needed(i, "an element or a set")?.to_string();
        let scope = self.scope(row.card);
        let only = match row.whole(i) {
            Some(label) => u32::try_from(label).ok().and_then(|label| self.sets.labelled_in(scope, label, false)),
            None => self.sets.qualified(&word, false),
        };
        if let Some(element) = only {
            return Ok((format!("element {word}"), vec![element]));
        }
        if row.whole(i).is_some() {
            return Err(row.error(format!("there is no element {word}"), "name one of the file"));
        }
        let found: Rc<Found> = self.set(row.card, scope, Kind::Elements, &word)?;
        let spelling = self.sets.spelling(scope, Kind::Elements, &word).unwrap_or(&word).to_string();
        Ok((spelling, found.elements.clone()))
    }
}

/// Two courses of one value.
pub(super) fn courses(row: &Row) -> Error {
    row.error("this step loads the same place by another amplitude already", "give loads at one place one amplitude")
}
