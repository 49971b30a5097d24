//! Forces at nodes, as tables of a case or as arrays of the mesh.

use std::collections::HashMap;

use super::history::{MOST_TURNS, Value, written};
use super::supports::NONE;
use super::text::{of_card, quoted};
use super::write::{Knots, Writer, classes};
use crate::Error;
use crate::io::abaqus::Card;
use crate::mesh::NodeArray;

/// More values than these at nodes become arrays of the mesh.
const MOST_TABLES: usize = 24;

impl Writer<'_, '_> {
    pub(super) fn forces(&mut self) -> Result<(), Error> {
        let classes = classes(&self.reader.forces, self.reader);
        let card = self.reader.input.cards.iter().find(|card| card.keyword.name == "CLOAD");
        let Some(card) = card else { return Ok(()) };
        if classes.is_empty() {
            return Ok(());
        }
        let spread = self.reader.input.swept().is_some();
        if spread || classes.len() > MOST_TABLES || classes.iter().any(|class| class.1 != NONE) {
            return self.force_arrays(card);
        }
        for (number, (ids, _, nodes)) in classes.iter().enumerate() {
            let values = ids.map(|id| match id {
                NONE => Ok(Value::Number(0.0)),
                id => self.value(id, 0.0, card),
            });
            let [x, y, z] = values;
            let values = [x?, y?, z?];
            if values.iter().all(|value| *value == Value::Number(0.0)) {
                continue;
            }
            let group = self.named(nodes, &format!("force {}", number + 1));
            self.out.table("[[load]]", of_card(card));
            self.out.line("on", &quoted(&group));
            self.out.line("nodal", &format!("[{}]", values.map(|value| value.toml()).join(", ")));
        }
        Ok(())
    }

    /// Forces as arrays of the mesh: one for each component of those that follow the same course in time.
    fn force_arrays(&mut self, card: &Card) -> Result<(), Error> {
        let mut courses: Vec<(Knots, [Vec<f64>; 3])> = Vec::new();
        let nodes = self.reader.used.len();
        let mut known: HashMap<u32, (usize, f64)> = HashMap::new();
        for dof in 0..3 * nodes {
            let id = self.reader.forces[dof];
            if id == NONE {
                continue;
            }
            let (course, size) = match known.get(&id) {
                Some(&found) => found,
                None => {
                    let (shape, size) = shape(&self.knots(id, 0.0), 0.0);
                    if size == 0.0 {
                        continue;
                    }
                    let at = courses.iter().position(|course| same(&course.0, &shape)).unwrap_or_else(|| {
                        courses.push((shape, [0, 1, 2].map(|_| vec![0.0; nodes])));
                        courses.len() - 1
                    });
                    known.insert(id, (at, size));
                    (at, size)
                }
            };
            for (node, part) in self.reader.spread((dof / 3) as u32) {
                let unit = self.reader.unit(node as usize, dof % 3, card)?;
                (0..3).for_each(|k| courses[course].1[k][node as usize] += part * size * unit[k]);
            }
        }
        for (number, (shape, arrays)) in courses.into_iter().enumerate() {
            let ramp = match written(&shape, self.single) {
                Value::Number(1.0) => String::new(),
                value => format!(", ramp = {}", value.toml()),
            };
            let mut values = Vec::new();
            for (axis, array) in ["x", "y", "z"].iter().zip(arrays) {
                if array.iter().all(|&force| force == 0.0) {
                    values.push("0".to_string());
                    continue;
                }
                let name = format!("force {} {axis}", number + 1);
                values.push(format!("{{ array = {}{ramp} }}", quoted(&name)));
                self.arrays.nodes.push(NodeArray { name, values: array });
            }
            if shape.len() > MOST_TURNS && !self.single {
                return Err(card.error("a force turns too often over the steps", "give fewer points or steps"));
            }
            self.out.table("[[load]]", of_card(card));
            self.out.line("nodal", &format!("[{}]", values.join(", ")));
        }
        Ok(())
    }
}

/// A course in time whose largest rise is one, and that rise.
pub(super) fn shape(knots: &[[f64; 2]], start: f64) -> (Vec<[f64; 2]>, f64) {
    let size = knots.iter().map(|knot| knot[1] - start).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let divided = |&[t, v]: &[f64; 2]| [t, if size == 0.0 { 0.0 } else { (v - start) / size }];
    (knots.iter().map(divided).collect(), size)
}

/// Whether two courses are one but for rounding.
pub(super) fn same(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a[0] == b[0] && (a[1] - b[1]).abs() <= 1e-12)
}
