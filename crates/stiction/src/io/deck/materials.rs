//! `*MATERIAL` and its properties, `*ORIENTATION`, `*SOLID SECTION`.

use super::reader::Reader;
use crate::Error;
use crate::io::abaqus::{Card, Kind, Row};

/// Properties under one `*MATERIAL`.
pub(super) struct MaterialCard<'a> {
    pub name: String,
    pub card: &'a Card,
    pub elastic: Option<Elastic>,
    pub density: f64,
    pub expansion: Option<Expansion>,
    /// What makes it unusable, which counts where a section is made of it.
    pub refused: Option<Error>,
}

/// Constants of `*ELASTIC`.
pub(super) enum Elastic {
    /// Modulus, Poisson's ratio and temperature, by ascending temperature; and where the second of them stands.
    Isotropic(Vec<[f64; 3]>, Option<Error>),
    /// Young's moduli, Poisson's ratios 12 13 23 and shear moduli 12 13 23.
    Orthotropic([[f64; 3]; 3]),
}

/// Coefficients of `*EXPANSION`.
pub(super) enum Expansion {
    Isotropic(f64),
    Orthotropic([f64; 3]),
}

/// `*ORIENTATION`: points on the first axis and in the plane of the first two.
pub(super) struct Orientation {
    pub axes: Result<[[f64; 3]; 2], Error>,
}

/// `*SOLID SECTION`.
pub(super) struct Section {
    /// Name of its set as its first line spells it.
    pub set: String,
    /// Its elements.
    pub elements: Vec<u32>,
    pub material: usize,
    pub orientation: Option<usize>,
}

/// The names of materials and orientations in their order: sections may stand above what they name.
pub(super) struct Names<'a>(Vec<(&'static str, Vec<&'a str>)>);

impl<'a> Names<'a> {
    pub(super) fn new(cards: &'a [Card]) -> Self {
        let of = |keyword| {
            let named = cards.iter().filter(|card| card.keyword.name == keyword);
            (keyword, named.filter_map(|card| card.keyword.get("NAME")).filter(|name| !name.is_empty()).collect())
        };
        Names(["MATERIAL", "ORIENTATION"].map(of).into())
    }

    fn of(&self, keyword: &str) -> &[&'a str] {
        self.0.iter().find(|named| named.0 == keyword).map_or(&[], |named| &named.1)
    }

    fn place(&self, keyword: &str, name: &str) -> Option<usize> {
        self.of(keyword).iter().position(|other| other.eq_ignore_ascii_case(name))
    }
}

impl<'a> Reader<'a> {
    pub(super) fn material(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["NAME"])?;
        let name = card.needed("NAME")?.to_string();
        if self.materials.iter().any(|other| other.name.eq_ignore_ascii_case(&name)) {
            return Err(card.error(format!("two materials are called {name}"), "rename one of them"));
        }
        let (elastic, expansion, refused) = (None, None, None);
        self.materials.push(MaterialCard { name, card, elastic, density: 0.0, expansion, refused });
        Ok(())
    }

    /// The material that a card of a property belongs to.
    fn open_material(&mut self, card: &Card) -> Result<&mut MaterialCard<'a>, Error> {
        let title = &card.keyword.title;
        let what = format!("*{title} stands under no *MATERIAL");
        self.materials.last_mut().ok_or_else(|| card.error(what, "write *MATERIAL, NAME=... above it"))
    }

    /// A property that makes the material unusable.
    pub(super) fn refuse_material(&mut self, card: &Card, what: &str, remedy: &str) -> Result<(), Error> {
        let error = card.error(format!("*{} is {what}, which a case cannot hold", card.keyword.title), remedy);
        self.open_material(card)?.refused.get_or_insert(error);
        Ok(())
    }

    pub(super) fn elastic(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["TYPE"])?;
        let kind = card.keyword.get("TYPE").unwrap_or("ISO").to_uppercase();
        let elastic = match kind.replace(' ', "").as_str() {
            "ISO" | "ISOTROPIC" => isotropic(card)?,
            "ORTHO" | "ORTHOTROPIC" => Elastic::Orthotropic(from_stiffness(card, nine(card)?)?),
            "ENGINEERINGCONSTANTS" => {
                let [a, b, c, d, e, f, g, h, i] = nine(card)?;
                Elastic::Orthotropic([[a, b, c], [d, e, f], [g, h, i]])
            }
            _ => {
                let what = format!("*ELASTIC, TYPE={kind} is not read");
                return Err(card.error(what, "give ISO, ORTHO or ENGINEERING CONSTANTS"));
            }
        };
        self.open_material(card)?.elastic = Some(elastic);
        Ok(())
    }

    pub(super) fn density(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&[])?;
        let densities = one_value(card, 1, "the density")?;
        self.open_material(card)?.density = densities[0];
        Ok(())
    }

    pub(super) fn expansion(&mut self, card: &Card) -> Result<(), Error> {
        // The zero of the coefficients matters only where they depend on the temperature.
        card.only(&["TYPE", "ZERO"])?;
        let kind = card.keyword.get("TYPE").unwrap_or("ISO").to_uppercase();
        let expansion = match kind.as_str() {
            "ISO" => Expansion::Isotropic(one_value(card, 1, "the coefficient")?[0]),
            "ORTHO" => {
                let values = one_value(card, 3, "the coefficients")?;
                Expansion::Orthotropic([values[0], values[1], values[2]])
            }
            _ => return Err(card.error(format!("*EXPANSION, TYPE={kind} is not read"), "give ISO or ORTHO")),
        };
        self.open_material(card)?.expansion = Some(expansion);
        Ok(())
    }

    pub(super) fn orientation(&mut self, card: &Card) -> Result<(), Error> {
        card.only(&["NAME", "SYSTEM", "DEFINITION"])?;
        card.needed("NAME")?;
        let axes = axes(card);
        self.orientations.push(Orientation { axes });
        Ok(())
    }

    pub(super) fn solid_section(&mut self, card: &Card) -> Result<(), Error> {
        // Section controls say how elements of few integration points are stabilised.
        card.only(&["ELSET", "MATERIAL", "ORIENTATION", "CONTROLS"])?;
        let (set, name) = (card.needed("ELSET")?, card.needed("MATERIAL")?);
        let material = self.named.place("MATERIAL", name).ok_or_else(|| {
            let names = self.named.of("MATERIAL").join(", ");
            card.error(format!("there is no *MATERIAL {name}"), format!("the materials are {names}"))
        })?;
        let orientation = match card.keyword.get("ORIENTATION") {
            None => None,
            Some(name) => Some(self.named.place("ORIENTATION", name).ok_or_else(|| {
                card.error(format!("there is no *ORIENTATION {name}"), "write it, or take the parameter out")
            })?),
        };
        let (mut elements, mut spelling) = (Vec::new(), set.to_string());
        for scope in self.input.scopes(card.part) {
            let found = self.set(card, scope, Kind::Elements, set)?;
            elements.extend_from_slice(&found.elements);
            spelling = self.sets.spelling(scope, Kind::Elements, set).unwrap_or(set).to_string();
        }
        if let Some(&other) = elements.iter().find(|&&e| self.input.element(e).cell.is_none()) {
            let of = self.input.element(other);
            let what = format!("element {} of the set {set} is of type {}, no solid", of.label, of.type_name);
            return Err(card.error(what, "mesh the part with C3D4, C3D8, C3D10 or C3D20"));
        }
        self.sections.push(Section { set: spelling, elements, material, orientation });
        Ok(())
    }
}

fn isotropic(card: &Card) -> Result<Elastic, Error> {
    let (mut rows, mut second) = (Vec::new(), None);
    for row in card.rows() {
        let values =
            [row.value(0, "Young's modulus")?, row.value(1, "Poisson's ratio")?, row.number(2)?.unwrap_or(0.0)];
        row.ends(3)?;
        if rows.len() == 1 {
            second = Some(depends(&row));
        }
        rows.push(values);
    }
    if rows.is_empty() {
        return Err(card.error("*ELASTIC has no constants", "write Young's modulus and Poisson's ratio below it"));
    }
    if rows.iter().all(|row| row[..2] == rows[0][..2]) {
        rows.truncate(1);
    }
    rows.sort_by(|a, b| a[2].total_cmp(&b[2]));
    Ok(Elastic::Isotropic(rows, second))
}

/// A property that depends on the temperature.
fn depends(row: &Row) -> Error {
    let what = format!("*{} depends on the temperature", row.card.keyword.title);
    row.error(what, "keep the line of the temperature that the part has")
}

/// The first `count` numbers of lines that differ in the temperature alone.
fn one_value(card: &Card, count: usize, what: &str) -> Result<Vec<f64>, Error> {
    let mut first: Option<Vec<f64>> = None;
    for row in card.rows() {
        let values = (0..count).map(|i| row.value(i, what)).collect::<Result<Vec<_>, _>>()?;
        row.number(count)?;
        row.ends(count + 1)?;
        if first.as_ref().is_some_and(|first| *first != values) {
            return Err(depends(&row));
        }
        first.get_or_insert(values);
    }
    first.ok_or_else(|| card.error(format!("*{} has no line", card.keyword.title), format!("write {what} below it")))
}

/// Nine constants on lines of eight; a tenth is their temperature.
fn nine(card: &Card) -> Result<[f64; 9], Error> {
    let mut values = Vec::new();
    for (number, row) in card.rows().enumerate() {
        if number > 1 {
            return Err(depends(&row));
        }
        let count = if number == 0 { 8 } else { 1 };
        for i in 0..count {
            values.push(row.value(i, "a constant")?);
        }
        row.number(count)?;
        row.ends(count + 1)?;
    }
    let count = values.len();
    values.try_into().map_err(|_| {
        let what = format!("*{} has {count} constants instead of nine", card.keyword.title);
        card.error(what, "write eight on the first line and the ninth on the second")
    })
}

/// Engineering constants of the stiffness D1111 D1122 D2222 D1133 D2233 D3333 D1212 D1313 D2323.
fn from_stiffness(card: &Card, d: [f64; 9]) -> Result<[[f64; 3]; 3], Error> {
    let [a, b, c, e, f, g, s12, s13, s23] = d;
    // Cofactors of the symmetric matrix [a b e; b c f; e f g]; its inverse is the compliance.
    let (aa, ab, ae) = (c * g - f * f, e * f - b * g, b * f - c * e);
    let (cc, cf, gg) = (a * g - e * e, b * e - a * f, a * c - b * b);
    let determinant = a * aa + b * ab + e * ae;
    if !(aa > 0.0 && cc > 0.0 && gg > 0.0 && determinant > 0.0 && a > 0.0) {
        return Err(card.error("this stiffness is not positive definite", "correct the constants"));
    }
    let young = [aa, cc, gg].map(|cofactor| determinant / cofactor);
    Ok([young, [-ab / aa, -ae / aa, -cf / cc], [s12, s13, s23]])
}

/// Directions 1 and 2 of an orientation: of points on the first axis and in the plane of the first two.
fn axes(card: &Card) -> Result<[[f64; 3]; 2], Error> {
    let system = card.keyword.get("SYSTEM").unwrap_or("RECTANGULAR").to_uppercase();
    if !system.starts_with('R') {
        let what = format!("*ORIENTATION, SYSTEM={system} is not read");
        return Err(card.error(what, "give SYSTEM=RECTANGULAR, one for each set of elements"));
    }
    if card.keyword.get("DEFINITION").is_some_and(|d| !d.eq_ignore_ascii_case("COORDINATES")) {
        return Err(card.error("*ORIENTATION is read by coordinates only", "give two points"));
    }
    let mut rows = card.rows();
    let Some(row) = rows.next() else {
        return Err(card.error("*ORIENTATION has no points", "write the coordinates of two points below it"));
    };
    let at = |i: usize| row.value(i, "a coordinate");
    let axes = [[at(0)?, at(1)?, at(2)?], [at(3)?, at(4)?, at(5)?]];
    row.ends(6)?;
    if let Some(turn) = rows.next()
        && turn.number(1)?.is_some_and(|angle| angle != 0.0)
    {
        return Err(turn.error("an additional rotation is not read", "turn the two points instead"));
    }
    Ok(axes)
}
