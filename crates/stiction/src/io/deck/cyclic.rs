//! `*TIE, CYCLIC SYMMETRY` and `*CYCLIC SYMMETRY MODEL`: one sector of a body of many.

use super::contact::Named;
use super::history::number;
use super::reader::Reader;
use super::text::{of_row, quoted, triple};
use super::write::Writer;
use crate::Error;
use crate::io::abaqus::{Card, Row};
use crate::mesh::v3::sub;

/// Two cuts of a sector.
pub(super) struct Cuts<'a> {
    row: Row<'a>,
    name: String,
    /// The one that follows, and the one it follows.
    surfaces: [Named; 2],
    tolerance: Option<f64>,
    model: Option<Model>,
}

/// How many sectors there are, around which axis.
struct Model {
    sectors: i64,
    /// Two points of the axis.
    axis: [[f64; 3]; 2],
}

impl<'a> Reader<'a> {
    pub(super) fn cuts(&mut self, card: &'a Card, name: &str, tolerance: Option<f64>) -> Result<(), Error> {
        if self.cyclic.iter().any(|cuts| cuts.name.eq_ignore_ascii_case(name)) {
            return Err(card.error(format!("two ties with cyclic symmetry are called {name}"), "rename one of them"));
        }
        let row = card.row()?.ok_or_else(|| card.error("this tie has no surfaces", "give slave and master"))?;
        let surfaces = self.two_surfaces(&row)?;
        self.cyclic.push(Cuts { row, name: name.to_string(), surfaces, tolerance, model: None });
        Ok(())
    }

    pub(super) fn cyclic_symmetry_model(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["N", "NGRAPH", "TIE", "ELSET", "CHECK"])?;
        if self.in_step {
            return Err(card.error("*CYCLIC SYMMETRY MODEL stands in a step", "move it above the steps"));
        }
        let sectors = card.needed("N")?;
        let sectors = sectors.parse::<i64>().ok().filter(|n| *n >= 2);
        let sectors = sectors.ok_or_else(|| card.error("N is no number of sectors", "give at least two"))?;
        let row = card.row()?.ok_or_else(|| card.error("the axis is missing", "give two points of it"))?;
        let point = |i: usize| -> Result<[f64; 3], Error> {
            Ok([row.value(i, "a coordinate")?, row.value(i + 1, "a coordinate")?, row.value(i + 2, "a coordinate")?])
        };
        let axis = [point(0)?, point(3)?];
        row.ends(6)?;
        if axis[0] == axis[1] {
            return Err(row.error("both points of the axis are one", "give two points of the axis"));
        }
        let cuts = match card.keyword.get("TIE").filter(|name| !name.is_empty()) {
            Some(name) => self.cyclic.iter_mut().find(|cuts| cuts.name.eq_ignore_ascii_case(name)),
            None => self.cyclic.last_mut(),
        };
        let what = "no *TIE, CYCLIC SYMMETRY with this name stands above";
        let cuts = cuts.ok_or_else(|| card.error(what, "write *TIE, CYCLIC SYMMETRY, NAME= with the two cuts"))?;
        cuts.model = Some(Model { sectors, axis });
        Ok(())
    }
}

impl Writer<'_, '_> {
    pub(super) fn cyclic(&mut self) -> Result<(), Error> {
        for Cuts { row, name, surfaces, tolerance, model } in std::mem::take(&mut self.reader.cyclic) {
            let Some(Model { sectors, axis }) = model else {
                let what = format!("no *CYCLIC SYMMETRY MODEL belongs to the tie {name}");
                return Err(row.error(what, format!("add *CYCLIC SYMMETRY MODEL, N=..., TIE={name} with its axis")));
            };
            let [on, against] = &surfaces;
            let on = self.groups.surface(self.reader.input, &on.name, &on.found, &row)?;
            let against = self.groups.surface(self.reader.input, &against.name, &against.found, &row)?;
            self.out.table("[[cyclic]]", of_row(&row));
            self.out.line("on", &quoted(&on));
            self.out.line("against", &quoted(&against));
            self.out.line("sectors", &sectors.to_string());
            self.out.line("axis", &triple(sub(axis[1], axis[0])));
            self.out.line("point", &triple(axis[0]));
            if let Some(search) = tolerance.filter(|&length| length > 0.0) {
                self.out.line("search", &number(search));
            }
        }
        Ok(())
    }
}
