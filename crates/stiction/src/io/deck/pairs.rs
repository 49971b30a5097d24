//! The contacts of the case.

use super::contact::{Gap, Pair};
use super::history::{Value, number};
use super::text::{of_row, quoted};
use super::write::Writer;
use crate::Error;

/// Tied surfaces without a tolerance are tied where they are no farther apart than this part of the size of a face.
const NEAR: f64 = 0.025;

impl Writer<'_, '_> {
    pub(super) fn contacts(&mut self) -> Result<(), Error> {
        let mut names: Vec<String> = Vec::new();
        for number in 0..self.reader.pairs.len() {
            let pair = &self.reader.pairs[number];
            let [on, against] = &pair.surfaces;
            let mut name = if pair.tie { pair.name.clone() } else { on.name.clone() };
            if names.contains(&name) {
                name = format!("{} - {}", on.name, against.name);
            }
            let mut twice = 2;
            while names.contains(&name) {
                name = format!("{} - {} ({twice})", on.name, against.name);
                twice += 1;
            }
            names.push(name.clone());
            if pair.steps(self.reader.steps.len()).contains(&true) {
                self.contact(number, &name)?;
            } else {
                self.reader.notes.add(format!("the contact {name} is taken out in all steps"));
            }
        }
        Ok(())
    }

    /// A pair in the steps in which it is in.
    fn contact(&mut self, number: usize, name: &str) -> Result<(), Error> {
        let pair = &self.reader.pairs[number];
        let [on, against] = &pair.surfaces;
        let input = self.reader.input;
        let on = self.groups.surface(input, &on.name, &on.found, &pair.row)?;
        let against = self.groups.surface(input, &against.name, &against.found, &pair.row)?;
        self.out.table("[[contact]]", of_row(&pair.row));
        if name != on {
            self.out.line("name", &quoted(name));
        }
        self.out.line("on", &quoted(&on));
        self.out.line("against", &quoted(&against));
        self.law(number)?;
        let is_in = self.reader.pairs[number].steps(self.reader.steps.len());
        let out: Vec<String> =
            self.reader.steps.iter().zip(&is_in).filter(|it| !it.1).map(|it| quoted(&it.0.name)).collect();
        if !out.is_empty() {
            self.out.line("without", &format!("[{}]", out.join(", ")));
        }
        Ok(())
    }

    /// Gap and friction of a pair.
    fn law(&mut self, which: usize) -> Result<(), Error> {
        let pair = &self.reader.pairs[which];
        if pair.tie {
            let tolerance = pair.tolerance.filter(|&length| length > 0.0);
            let search = tolerance.or_else(|| self.near(pair));
            match search {
                Some(search) => self.out.line("search", &number(search)),
                None => {
                    let what = "the surfaces of this tie have no faces whose size would tell what is near";
                    return Err(pair.row.error(what, "add POSITION TOLERANCE="));
                }
            }
            self.out.line("friction", "\"bonded\"");
            return Ok(());
        }
        let found = self.reader.interactions.iter().find(|it| it.name.eq_ignore_ascii_case(&pair.name));
        let Some(interaction) = found else {
            let what = format!("there is no *SURFACE INTERACTION {}", pair.name);
            return Err(pair.row.error(what, "write it above the pair"));
        };
        match &pair.gap {
            Gap::AsMeshed => {}
            Gap::Closed => self.out.line("gap", "\"closed\""),
            Gap::ClosedWithin(reach) => self.out.line("gap", &format!("{{ closed_within = {} }}", number(*reach))),
            Gap::ClosedAt(name, found) => {
                let nodes = super::sweep::with_copies(self.reader.input, &found.nodes);
                let group = self.groups.nodes(name, &nodes);
                self.out.line("gap", &format!("{{ closed_at = {} }}", quoted(&group)));
                self.out.line("slave", "\"on\"");
            }
            Gap::Uniform(gap) => self.out.line("gap", &number(*gap)),
        }
        let coefficient = match interaction.changes {
            Some(history) => self.value(history, interaction.friction, pair.row.card)?,
            None => Value::Number(interaction.friction),
        };
        let friction = match (interaction.is_tied(), coefficient, interaction.limit) {
            (true, ..) => "\"bonded\"".to_string(),
            (_, Value::Number(0.0), _) => "\"none\"".to_string(),
            (_, mu, None) => format!("{{ coulomb = {} }}", mu.toml()),
            (_, mu, Some(limit)) => format!("{{ coulomb = {}, limit = {} }}", mu.toml(), number(limit)),
        };
        self.out.line("friction", &friction);
        if let Some(step) = interaction.freed.and_then(|step| self.reader.steps.get(step - 1)) {
            self.out.line("bonded_until", &quoted(&step.name));
        }
        if let ([Some(normal), tangential], false) = (interaction.stiffness, interaction.is_tied()) {
            let tangential = tangential.map_or(String::new(), |it| format!(", tangential = {}", number(it)));
            let stiffness = format!("{{ normal = {}{tangential} }}", number(normal));
            self.out.line("# that of the deck, for contact that yields: stiffness", &stiffness);
        }
        let notes: Vec<String> = match interaction.is_tied() {
            true => Vec::new(),
            false => interaction.notes.iter().map(|note| format!("{}: {note}", interaction.name)).collect(),
        };
        notes.into_iter().for_each(|note| self.reader.notes.add(note));
        Ok(())
    }

    /// A small part of the mean length of the first edges of the faces of the slave.
    fn near(&self, pair: &Pair) -> Option<f64> {
        let input = self.reader.input;
        let lengths = pair.surfaces[0].found.sides.iter().filter_map(|&(element, side)| {
            let [a, b, ..] = input.corners(element, side)?;
            let (a, b) = (input.node(a), input.node(b));
            Some((0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt())
        });
        let (count, sum) = lengths.fold((0, 0.0), |(count, sum), length| (count + 1, sum + length));
        (count > 0 && sum > 0.0).then(|| NEAR * sum / f64::from(count))
    }
}
