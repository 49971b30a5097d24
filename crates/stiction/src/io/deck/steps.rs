//! `*STEP`, `*STATIC` and `*AMPLITUDE`: the time axis.

use super::history::{Amplitude, Course};
use super::reader::Reader;
use crate::Error;
use crate::io::abaqus::Card;

/// How much longer an increment that converged well is than the one before it, in the programs decks are written for.
const GROWTH: f64 = 1.5;
/// Increments of a step at most.
const MOST_INCREMENTS: usize = 1000;

/// A step of a deck.
pub(super) struct StepCard<'a> {
    pub card: &'a Card,
    pub name: String,
    /// Beginning and end, in the time of all steps.
    pub span: [f64; 2],
    /// Increments that its lines ask for, where friction or an amplitude makes them matter.
    pub increments: usize,
    /// Whether they are asked for, not only where it is necessary.
    pub direct: bool,
    /// Whether *STATIC was read.
    statics: bool,
    /// How values without an amplitude are reached.
    pub course: Course,
}

impl<'a> Reader<'a> {
    pub(super) fn step(&mut self, card: &'a Card) -> Result<(), Error> {
        if self.in_step {
            return Err(card.error("a step begins inside a step", "write *END STEP above it"));
        }
        card.only(&["NLGEOM", "INC", "INCF", "NAME", "AMPLITUDE", "UNSYMM", "EXTRAPOLATION", "CONVERTSDI"])?;
        if card.keyword.get("NLGEOM").is_some_and(|value| !value.eq_ignore_ascii_case("NO")) {
            self.notes.add("NLGEOM: displacements, strains and slips are taken as small");
        }
        let number = self.steps.len() + 1;
        let name = card.keyword.get("NAME").filter(|name| !name.is_empty());
        let mut name = name.map_or(format!("step {number}"), str::to_string);
        // A deck may repeat names, to which nothing in it refers.
        while self.steps.iter().any(|step| step.name == name) {
            name += &format!(" ({number})");
        }
        let course = match card.keyword.get("AMPLITUDE").map(str::to_uppercase).as_deref() {
            None | Some("RAMP") => Course::Ramp,
            Some("STEP") => Course::Instant,
            Some(other) => return Err(card.error(format!("AMPLITUDE={other} is not read"), "give RAMP or STEP")),
        };
        let begin = self.steps.last().map_or(0.0, |step| step.span[1]);
        let span = [begin, begin + 1.0];
        self.steps.push(StepCard { card, name, span, increments: 1, direct: false, statics: false, course });
        self.in_step = true;
        self.begin_step();
        Ok(())
    }

    pub(super) fn end_step(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&[])?;
        if !self.in_step {
            return Err(card.error("*END STEP stands outside of a step", "take it out"));
        }
        self.in_step = false;
        match self.steps.last() {
            Some(step) if !step.statics => {
                Err(step.card.error("this step has no *STATIC", "write *STATIC below it: other steps are not read"))
            }
            _ => self.finish_step(),
        }
    }

    pub(super) fn statics(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["DIRECT", "SOLVER", "STABILIZE", "ALLSDTOL", "CONTINUE"])?;
        let row = card.row()?;
        let number = |i: usize| row.as_ref().map_or(Ok(None), |row| row.number(i));
        let (first, period, longest) = (number(0)?, number(1)?, number(3)?);
        let period = period.filter(|&period| period != 0.0).unwrap_or(1.0);
        let first = first.filter(|&first| first != 0.0).unwrap_or(period);
        if !(period > 0.0 && first > 0.0) {
            return Err(card.error("the times of *STATIC are not positive", "give the first increment and the period"));
        }
        let direct = card.has("DIRECT") && !card.keyword.get("DIRECT").is_some_and(|v| v.eq_ignore_ascii_case("NO"));
        let step = match self.steps.last_mut() {
            Some(step) if self.in_step => step,
            _ => return Err(card.error("*STATIC stands outside of a step", "write *STEP above it")),
        };
        step.statics = true;
        step.span[1] = step.span[0] + period;
        let increments = match direct {
            true => (period / first).round().max(1.0) as usize,
            false => growing(first.min(period), longest.unwrap_or(period).max(first.min(period)), period),
        };
        if increments > MOST_INCREMENTS {
            let what = format!("*STATIC asks for {increments} increments or more");
            return Err(card.error(what, "give a longer first increment"));
        }
        (step.increments, step.direct) = (increments, direct);
        Ok(())
    }

    pub(super) fn amplitude(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["NAME", "TIME", "DEFINITION", "VALUE", "SMOOTH"])?;
        let name = card.needed("NAME")?.to_uppercase();
        let is = |key: &str, wanted: &str| card.keyword.get(key).is_none_or(|value| value.eq_ignore_ascii_case(wanted));
        if !is("DEFINITION", "TABULAR") || !is("VALUE", "RELATIVE") || !is("SMOOTH", "0") {
            return Err(card.error("only a table of relative values is read", "write times and values below it"));
        }
        let total = match card.keyword.get("TIME").map(|time| time.to_uppercase().replace(' ', "")).as_deref() {
            None | Some("STEPTIME") => false,
            Some("TOTALTIME") => true,
            Some(other) => return Err(card.error(format!("TIME={other} is not read"), "give TOTAL TIME or STEP TIME")),
        };
        let mut points: Vec<[f64; 2]> = Vec::new();
        for row in card.rows() {
            for i in (0..row.fields.len()).step_by(2).filter(|&i| row.word(i).is_some()) {
                let point = [row.value(i, "a time")?, row.value(i + 1, "a value")?];
                if points.last().is_some_and(|last| last[0] >= point[0]) {
                    return Err(row.error("the times do not ascend", "write each time once, in their order"));
                }
                points.push(point);
            }
        }
        if points.is_empty() {
            return Err(card.error("*AMPLITUDE has no points", "write times and values below it"));
        }
        if self.amplitude_names.insert(name.clone(), self.amplitudes.len()).is_some() {
            return Err(card.error(format!("two amplitudes are called {name}"), "rename one of them"));
        }
        self.amplitudes.push(Amplitude { points, total });
        Ok(())
    }

    /// How the values of a card are reached.
    pub(super) fn course(&self, card: &Card) -> Result<Course, Error> {
        if card.has("TIMEDELAY") {
            return Err(card.error("TIME DELAY is not read", "shift the times of the amplitude"));
        }
        let Some(name) = card.keyword.get("AMPLITUDE") else {
            return Ok(self.steps.last().map_or(Course::Ramp, |step| step.course));
        };
        match self.amplitude_names.get(&name.to_uppercase()) {
            Some(&number) => Ok(Course::Amplitude(number)),
            None => Err(card.error(format!("there is no *AMPLITUDE {name}"), "write it above this card")),
        }
    }
}

/// How many increments reach the end, each longer than the one before it up to the longest.
fn growing(first: f64, longest: f64, period: f64) -> usize {
    let (mut t, mut increment, mut count) = (0.0, first, 0);
    while t < period * (1.0 - 1e-9) && count <= MOST_INCREMENTS {
        t += increment;
        increment = (GROWTH * increment).min(longest);
        count += 1;
    }
    count
}
