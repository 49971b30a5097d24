//! From what the cards say to the text of a case file, with the groups and arrays it names.

use std::collections::HashMap;

use super::forces::{same, shape};
use super::groups::Groups;
use super::history::{MOST_TURNS, Span, Value, number, written};
use super::loads::CellLoad;
use super::materials::{Elastic, Expansion};
use super::reader::Reader;
use super::supports::NONE;
use super::text::{Text, list, of_card, of_row, quoted, triple};
use crate::Error;
use crate::fem::Axes;
use crate::io::abaqus::Card;
use crate::io::case::CYLINDRICAL;
use crate::mesh::{MeshArrays, NodeArray};

/// Time and value wherever something turns.
pub(super) type Knots = Vec<[f64; 2]>;
/// An element and its face.
type Side = (u32, u8);

/// Supports of more values are refused: a case has one table for each.
const MOST_SUPPORTS: usize = 2000;

/// A case with what its mesh has to have.
pub(super) struct Written {
    pub text: Text,
    pub groups: Groups,
    pub arrays: MeshArrays,
    pub notes: Vec<String>,
}

/// What is written, under way.
pub(super) struct Writer<'r, 'a> {
    pub reader: &'r mut Reader<'a>,
    pub out: Text,
    pub groups: Groups,
    pub arrays: MeshArrays,
    /// Beginning and end of each step.
    spans: Vec<[f64; 2]>,
    /// Whether the case has no load steps: all acts at once.
    pub single: bool,
}

/// Writes the case of a deck that is called `name`.
pub(super) fn write(reader: &mut Reader, name: &str) -> Result<Written, Error> {
    let increments = increments(reader);
    let spans: Vec<[f64; 2]> = reader.steps.iter().map(|step| step.span).collect();
    let single = increments == [1];
    let (out, groups, arrays) = (Text::default(), Groups::default(), MeshArrays::default());
    let mut writer = Writer { reader, out, groups, arrays, spans, single };
    writer.materials()?;
    writer.supports()?;
    writer.equations()?;
    writer.cyclic()?;
    writer.couplings()?;
    writer.forces()?;
    writer.pressures()?;
    writer.on_cells()?;
    writer.temperatures()?;
    writer.contacts()?;
    writer.bolts()?;
    let Writer { out, groups, arrays, .. } = writer;
    let mut out = out;
    if !single {
        for (step, count) in reader.steps.iter().zip(&increments) {
            out.table("[[step]]", of_card(step.card));
            out.line("name", &quoted(&step.name));
            out.line("until", &number(step.span[1]));
            out.line("increments", &count.to_string());
        }
    }
    let (head, notes) = head(reader, name);
    let shift = head.len();
    let marks = out.marks.into_iter().map(|(at, spot)| (at + shift, spot)).collect();
    Ok(Written { text: Text { text: head + &out.text, marks }, groups, arrays, notes })
}

/// Increments of each step: one where nothing depends on the path.
fn increments(reader: &Reader) -> Vec<usize> {
    let friction = |name: &str| {
        let found = reader.interactions.iter().find(|it| it.name.eq_ignore_ascii_case(name));
        found.is_some_and(|it| (it.friction > 0.0 || it.changes.is_some()) && !it.is_tied())
    };
    let path = !reader.amplitudes.is_empty() || reader.pairs.iter().any(|pair| !pair.tie && friction(&pair.name));
    reader.steps.iter().map(|step| if path || step.direct { step.increments } else { 1 }).collect()
}

/// The beginning of the file, and the remarks in it.
fn head(reader: &Reader, name: &str) -> (String, Vec<String>) {
    let mut notes = reader.notes.0.clone();
    if !reader.harmless.is_empty() {
        let list: Vec<&str> = reader.harmless.iter().map(String::as_str).collect();
        notes.push(format!("changes nothing here: {}", list.join(", ")));
    }
    let loose: Vec<&str> = reader.input.types().iter().filter(|kind| !kind.1).map(|kind| kind.0).collect();
    if !loose.is_empty() {
        notes.push(format!("elements of type {} are in no section and left out", loose.join(", ")));
    }
    let title = reader.title.clone().unwrap_or_else(|| name.to_string());
    let mut text = format!("# The case that the deck {name} poses.\n");
    notes.iter().for_each(|note| text += &format!("# {}\n", note.replace(|c: char| c.is_control(), " ")));
    text += &format!("title = {}\n\n[mesh]\nfile = \"mesh.vtu\"\n", quoted(title.trim()));
    (text, notes)
}

impl Writer<'_, '_> {
    /// What a history is, as a value of the case.
    pub(super) fn value(&self, id: u32, start: f64, card: &Card) -> Result<Value, Error> {
        let knots = self.knots(id, start);
        if knots.len() > MOST_TURNS && !self.single {
            let what = format!("a value of this card turns {} times over the steps", knots.len());
            return Err(card.error(what, format!("give an amplitude of at most {MOST_TURNS} points, or fewer steps")));
        }
        Ok(written(&knots, self.single))
    }

    pub(super) fn knots(&self, id: u32, start: f64) -> Vec<[f64; 2]> {
        self.reader.histories.knots(id, start, &self.spans, &self.reader.amplitudes)
    }

    fn materials(&mut self) -> Result<(), Error> {
        let elements = self.reader.input.counts()[1];
        let mut of = vec![usize::MAX; elements];
        for (number, section) in self.reader.sections.iter().enumerate() {
            section.elements.iter().for_each(|&element| of[element as usize] = number);
        }
        // One table for each material with its directions, in the order of the sections.
        let mut kinds: Vec<(usize, Option<usize>, Vec<usize>)> = Vec::new();
        for (number, section) in self.reader.sections.iter().enumerate() {
            let directed = !matches!(self.reader.materials[section.material].elastic, Some(Elastic::Isotropic(..)));
            let key = (section.material, section.orientation.filter(|_| directed));
            match kinds.iter_mut().find(|kind| (kind.0, kind.1) == key) {
                Some(kind) => kind.2.push(number),
                None => kinds.push((key.0, key.1, vec![number])),
            }
        }
        for (number, (material, orientation, sections)) in kinds.iter().enumerate() {
            let mut on = Vec::new();
            for &section in sections {
                let it = &self.reader.sections[section];
                let own: Vec<u32> = it.elements.iter().copied().filter(|&e| of[e as usize] == section).collect();
                if !own.is_empty() {
                    on.push(self.groups.cells(self.reader.input, &it.set, &own));
                }
            }
            if on.is_empty() {
                continue;
            }
            on.dedup();
            let twice = kinds.iter().take(number).filter(|kind| kind.0 == *material).count();
            let name = &self.reader.materials[*material].name;
            let name = if twice == 0 { name.clone() } else { format!("{name} ({})", twice + 1) };
            self.material(*material, *orientation, &name, &on)?;
        }
        Ok(())
    }

    fn material(
        &mut self,
        material: usize,
        orientation: Option<usize>,
        name: &str,
        on: &[String],
    ) -> Result<(), Error> {
        let initial = self.initial();
        let it = &self.reader.materials[material];
        if let Some(refused) = &it.refused {
            return Err(refused.clone());
        }
        self.out.table(&format!("[materials.{}]", quoted(name)), of_card(it.card));
        self.out.line("on", &list(on));
        match &it.elastic {
            None => return Err(it.card.error(format!("{name} has no *ELASTIC"), "write its constants below it")),
            Some(Elastic::Isotropic(rows, second)) => {
                let [young, poisson] = match (&rows[..], initial, self.reader.heated.is_some()) {
                    ([only], ..) => [only[0], only[1]],
                    (rows, Some(t), false) => at_temperature(rows, t),
                    _ => {
                        let other = it.card.error("*ELASTIC depends on the temperature", "give one line");
                        return Err(second.clone().unwrap_or(other));
                    }
                };
                self.out.line("young", &number(young));
                self.out.line("poisson", &number(poisson));
            }
            Some(Elastic::Orthotropic(constants)) => {
                for (key, values) in ["young", "poisson", "shear"].iter().zip(constants) {
                    self.out.line(key, &triple(*values));
                }
                if let Some(which) = orientation {
                    let [a, b] = self.reader.orientations[which].axes.clone()?;
                    self.out.line("axes", &format!("[{}, {}]", triple(a), triple(b)));
                }
            }
        }
        if it.density != 0.0 {
            self.out.line("density", &number(it.density));
        }
        match &it.expansion {
            Some(Expansion::Isotropic(a)) => self.out.line("expansion", &number(*a)),
            Some(Expansion::Orthotropic(a)) if a[0] == a[1] && a[1] == a[2] => {
                self.out.line("expansion", &number(a[0]));
            }
            Some(Expansion::Orthotropic(a)) => {
                if matches!(it.elastic, Some(Elastic::Isotropic(..))) {
                    let what = format!("{name} expands differently along its axes, and is isotropic otherwise");
                    return Err(it.card.error(what, "give *ELASTIC, TYPE=ENGINEERING CONSTANTS too"));
                }
                self.out.line("expansion", &triple(*a));
            }
            None => {}
        }
        if let Some(t) = initial.filter(|&t| t != 0.0 && it.expansion.is_some()) {
            self.out.line("reference_temperature", &number(t));
        }
        Ok(())
    }

    /// The initial temperature where it is one for all nodes of cells.
    fn initial(&self) -> Option<f64> {
        let nodes = self.reader.initial.iter().zip(&self.reader.used).filter(|(_, used)| **used);
        let mut values = nodes.map(|(&t, _)| if t.is_nan() { 0.0 } else { t });
        let first = values.next()?;
        values.all(|t| t == first).then_some(first)
    }

    fn supports(&mut self) -> Result<(), Error> {
        let classes = supported(self.reader);
        // Planes of symmetry of swept elements have no card of their own.
        let named = |name: &str| self.reader.input.cards.iter().find(|card| card.keyword.name == name);
        let card = named("BOUNDARY").or_else(|| named("SOLIDSECTION"));
        let Some(card) = card else { return Ok(()) };
        if classes.len() > MOST_SUPPORTS {
            let what = format!("*BOUNDARY prescribes {} different values", classes.len());
            return Err(card.error(what, format!("prescribe at most {MOST_SUPPORTS}")));
        }
        for (number, (ids, transform, nodes)) in classes.iter().enumerate() {
            let group = self.named(nodes, &format!("support {}", number + 1));
            let spans = ids.map(|id| if id == NONE { Vec::new() } else { self.reader.histories.spans(id) });
            let mut stretches: Vec<Span> = Vec::new();
            for &span in spans.iter().flatten() {
                if !stretches.contains(&span) {
                    stretches.push(span);
                }
            }
            for stretch in stretches {
                let held: Vec<usize> = (0..3).filter(|&c| spans[c].contains(&stretch)).collect();
                self.out.table("[[fix]]", of_card(card));
                self.out.line("on", &quoted(&group));
                let mut names = ["x", "y", "z"];
                if let Some(transform) = self.reader.transforms.get(*transform as usize) {
                    self.out.line("axes", &transform.text);
                    if matches!(transform.axes, Axes::Cylinder { .. }) {
                        names = CYLINDRICAL;
                    }
                }
                if held.len() < 3 {
                    let names: String = held.iter().map(|&c| names[c]).collect();
                    self.out.line("components", &quoted(&names));
                }
                self.during(stretch.first, stretch.last);
                if stretch.stays {
                    self.out.line("condition", "\"as-it-stands\"");
                    continue;
                }
                if stretch.at_once && stretch.first > 0 {
                    self.out.line("condition", "\"at-once\"");
                }
                let values = held.iter().map(|&c| self.value(ids[c], 0.0, card)).collect::<Result<Vec<_>, _>>()?;
                if values.iter().any(|value| *value != Value::Number(0.0)) {
                    let values: Vec<String> = values.iter().map(Value::toml).collect();
                    self.out.line("value", &format!("[{}]", values.join(", ")));
                }
            }
        }
        Ok(())
    }

    /// The steps in which something holds, where these are not all.
    pub(super) fn during(&mut self, first: usize, last: Option<usize>) {
        if first > 0 {
            self.out.line("from", &quoted(&self.reader.steps[first].name));
        }
        if let Some(last) = last {
            self.out.line("until", &quoted(&self.reader.steps[last].name));
        }
    }

    /// The group of some nodes: the set of the deck that has these and no other nodes of the body, or a new one.
    pub(super) fn named(&mut self, nodes: &[u32], otherwise: &str) -> String {
        let used = &self.reader.used;
        let same = |found: &[u32]| found.iter().filter(|&&node| used[node as usize]).eq(nodes);
        let name = self.reader.named_nodes.iter().find(|named| same(&named.1.nodes)).map(|named| named.0.clone());
        self.groups.nodes(name.as_deref().unwrap_or(otherwise), nodes)
    }

    fn pressures(&mut self) -> Result<(), Error> {
        let mut classes: Vec<(u32, Vec<Side>, usize)> = Vec::new();
        let mut at: HashMap<u32, usize> = HashMap::new();
        for (i, (side, _)) in self.reader.pressed.iter().enumerate() {
            let id = self.reader.pressures[side];
            let next = classes.len();
            let class = *at.entry(id).or_insert(next);
            if class == next {
                classes.push((id, Vec::new(), i));
            }
            classes[class].1.push(*side);
        }
        for (number, (id, sides, first)) in classes.iter().enumerate() {
            let row = self.reader.pressed[*first].1.clone();
            if number >= MOST_SUPPORTS {
                let what = format!("*DLOAD gives {} different pressures", classes.len());
                return Err(row.error(what, format!("give at most {MOST_SUPPORTS}")));
            }
            let value = self.value(*id, 0.0, row.card)?;
            if value == Value::Number(0.0) {
                continue;
            }
            let group = self.groups.faces(self.reader.input, &format!("pressure {}", number + 1), sides, &row)?;
            self.out.table("[[load]]", of_row(&row));
            self.out.line("on", &quoted(&group));
            self.out.line("pressure", &value.toml());
        }
        for i in 0..self.reader.on_surfaces.len() {
            let it = &self.reader.on_surfaces[i];
            let value = self.value(it.history, 0.0, it.row.card)?;
            if value == Value::Number(0.0) {
                continue;
            }
            let group = self.groups.surface(self.reader.input, &it.surface.name, &it.surface.found, &it.row)?;
            self.out.table("[[load]]", of_row(&it.row));
            self.out.line("on", &quoted(&group));
            self.out.line("pressure", &value.toml());
        }
        Ok(())
    }

    fn on_cells(&mut self) -> Result<(), Error> {
        for i in 0..self.reader.on_cells.len() {
            let it = &self.reader.on_cells[i];
            let group = self.groups.cells(self.reader.input, &it.name, &it.elements);
            self.out.table("[[load]]", of_row(&it.row));
            self.out.line("on", &quoted(&group));
            match &it.kind {
                CellLoad::Gravity(direction, id) => {
                    let size = self.value(*id, 0.0, it.row.card)?;
                    let [x, y, z] =
                        direction.map(|c| if c == 0.0 { Value::Number(0.0) } else { size.clone().times(c) });
                    self.out.line("gravity", &format!("[{}, {}, {}]", x.toml(), y.toml(), z.toml()));
                }
                CellLoad::Rotation(point, axis, id) => {
                    let speed = match self.value(*id, 0.0, it.row.card)? {
                        Value::Number(square) => Value::Number(square.sqrt()),
                        Value::Expression(text) => Value::Expression(format!("sqrt(max({text}, 0))")),
                    };
                    let (axis, point) = (triple(*axis), triple(*point));
                    let value = format!("{{ axis = {axis}, point = {point}, speed = {} }}", speed.toml());
                    self.out.line("rotation", &value);
                }
            }
        }
        Ok(())
    }

    /// The temperature is that of a case where all nodes have one, or an array with a course in time.
    fn temperatures(&mut self) -> Result<(), Error> {
        let Some(row) = self.reader.heated.clone() else { return Ok(()) };
        let uniform = self.initial();
        let nodes: Vec<u32> = (0..self.reader.used.len() as u32).filter(|&n| self.reader.used[n as usize]).collect();
        let first = nodes.first().map_or(NONE, |&node| self.reader.temperatures[node as usize]);
        if nodes.iter().all(|&node| self.reader.temperatures[node as usize] == NONE) {
            self.reader.notes.add("*TEMPERATURE names nodes of no solid element alone, and changes nothing");
            return Ok(());
        }
        if let Some(start) = uniform.filter(|_| nodes.iter().all(|&n| self.reader.temperatures[n as usize] == first)) {
            self.out.table("[[load]]", of_row(&row));
            let value = self.value(first, start, row.card)?;
            self.out.line("temperature", &value.toml());
            return Ok(());
        }
        // From the initial temperature of each node to what one course in time leads it to.
        let mut course: Option<Vec<[f64; 2]>> = None;
        let mut values = vec![f64::NAN; self.reader.used.len()];
        let mut known: HashMap<(u32, u64), f64> = HashMap::new();
        for &node in &nodes {
            let id = self.reader.temperatures[node as usize];
            let start = Some(self.reader.initial[node as usize]).filter(|t| !t.is_nan()).unwrap_or(0.0);
            let rise = match known.get(&(id, start.to_bits())) {
                Some(&rise) => rise,
                None if id == NONE => 0.0,
                None => {
                    let (shape, size) = shape(&self.knots(id, start), start);
                    if size != 0.0 && !same(course.get_or_insert(shape.clone()), &shape) {
                        let what = "the temperatures of different nodes follow different courses in time";
                        return Err(
                            row.error(what, "let all of them change in proportion, or make a deck of each step")
                        );
                    }
                    size
                }
            };
            known.insert((id, start.to_bits()), rise);
            values[node as usize] = rise + uniform.unwrap_or(0.0);
        }
        if course.as_ref().is_some_and(|course| course.len() > MOST_TURNS) {
            return Err(row.error("the temperatures turn too often over the steps", "give fewer points or steps"));
        }
        let ramp = match course.map(|course| written(&course, self.single)) {
            None => String::new(),
            Some(Value::Number(1.0)) => String::new(),
            Some(value) => format!(", ramp = {}", value.toml()),
        };
        self.out.table("[[load]]", of_row(&row));
        self.out.line("temperature", &format!("{{ array = \"temperature\"{ramp} }}"));
        self.arrays.nodes.push(NodeArray { name: "temperature".into(), values });
        Ok(())
    }
}

/// Nodes with the same histories of their three components and the same `*TRANSFORM`, in the order of their first node;
/// nodes of no cell are left out.
pub(super) fn classes(histories: &[u32], reader: &Reader) -> Vec<([u32; 3], u32, Vec<u32>)> {
    let mut classes: Vec<([u32; 3], u32, Vec<u32>)> = Vec::new();
    let mut at: HashMap<([u32; 3], u32), usize> = HashMap::new();
    for (node, ids) in histories.as_chunks::<3>().0.iter().enumerate() {
        if !reader.used[node] || *ids == [NONE; 3] {
            continue;
        }
        let (next, transform) = (classes.len(), reader.transform_of[node]);
        let class = *at.entry((*ids, transform)).or_insert(next);
        if class == next {
            classes.push((*ids, transform, Vec::new()));
        }
        classes[class].2.push(node as u32);
    }
    classes
}

/// Nodes of one history along each direction, those of several directions together where they are the same: the middle of an edge is
/// held on finer meshes where a group has both of its ends, also where planes of symmetry meet.
fn supported(reader: &Reader) -> Vec<([u32; 3], u32, Vec<u32>)> {
    let mut along: Vec<(usize, u32, u32, Vec<u32>)> = Vec::new();
    let mut at: HashMap<(usize, u32, u32), usize> = HashMap::new();
    for (node, ids) in reader.supports.as_chunks::<3>().0.iter().enumerate().filter(|(node, _)| reader.used[*node]) {
        let transform = reader.transform_of[node];
        for (c, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NONE) {
            let next = along.len();
            let place = *at.entry((c, id, transform)).or_insert(next);
            if place == next {
                along.push((c, id, transform, Vec::new()));
            }
            along[place].3.push(node as u32);
        }
    }
    let mut classes: Vec<([u32; 3], u32, Vec<u32>)> = Vec::new();
    for (c, id, transform, nodes) in along {
        match classes.iter_mut().find(|of| of.0[c] == NONE && of.1 == transform && of.2 == nodes) {
            Some(of) => of.0[c] = id,
            None => {
                let mut ids = [NONE; 3];
                ids[c] = id;
                classes.push((ids, transform, nodes));
            }
        }
    }
    classes
}

/// Constants between those of the neighbouring temperatures.
fn at_temperature(rows: &[[f64; 3]], t: f64) -> [f64; 2] {
    let after = rows.partition_point(|row| row[2] < t);
    match (after.checked_sub(1).map(|i| rows[i]), rows.get(after)) {
        (Some(a), Some(b)) => [0, 1].map(|k| a[k] + (b[k] - a[k]) * (t - a[2]) / (b[2] - a[2])),
        (Some(row), None) | (None, Some(&row)) => [row[0], row[1]],
        (None, None) => [f64::NAN; 2],
    }
}
