//! `[mesh]` and `[materials]`.

use std::path::Path;

use super::data::{MaterialSpec, MeshSource, MeshSpec, Placing};
use super::read_contact::direction;
use super::read_region::groups;
use super::view::View;
use crate::Error;
use crate::fem::{Formulation, Material, Orthotropic, Voigt, frame, strain_along};
use crate::mesh::{Block, BlockElement, Ring, Turn};

/// The mesh; relative paths start at `folder`.
pub(super) fn mesh(case: &View, folder: &Path) -> Result<MeshSpec, Error> {
    let Some(table) = case.table("mesh") else {
        return Err(case.error("mesh", "the case file has no `mesh`", "add [mesh]"));
    };
    let parts = table.tables("parts");
    if parts.is_empty() {
        return part(&table, folder);
    }
    table.refuse(&["scale"], "is for a mesh file, but the mesh has parts", ", or give it to a part")?;
    let read = |(name, view): &(&str, View)| Ok((name.to_string(), part(view, folder)?));
    let parts = parts.iter().map(read).collect::<Result<_, Error>>()?;
    Ok(MeshSpec { source: MeshSource::Parts(parts), placing: placing(&table)?, spot: table.spot() })
}

fn part(table: &View, folder: &Path) -> Result<MeshSpec, Error> {
    let made = |what: &str, sizes: &str| {
        let why = format!("is for a mesh file, but the mesh is a {what}");
        table.refuse(&["scale"], &why, &format!(" and change {sizes} of the {what}"))
    };
    let source = if let Some(block) = table.table("block") {
        made("block", "`size`")?;
        MeshSource::Block(self::block(&block)?)
    } else if let Some(ring) = table.table("ring") {
        made("ring", "`radii` and `height`")?;
        MeshSource::Ring(self::ring(&ring)?)
    } else {
        MeshSource::File { path: folder.join(table.text("file")), scale: table.number("scale"), include: Vec::new() }
    };
    Ok(MeshSpec { source, placing: placing(table)?, spot: table.spot() })
}

pub(super) fn placing(table: &View) -> Result<Placing, Error> {
    let turn = |turn: View| {
        Ok(Turn { point: turn.vector("point"), axis: direction(&turn, "axis")?, degrees: turn.number("degrees") })
    };
    Ok(Placing { turn: table.table("turn").map(turn).transpose()?, by: table.vector("move") })
}

fn ring(table: &View) -> Result<Ring, Error> {
    let [inner, outer, _] = table.vector("radii");
    if inner >= outer {
        let what = format!("the inner radius {inner} is not smaller than the outer one, {outer}");
        return Err(table.error("radii", what, "give the inner radius first"));
    }
    let element = element(table)?;
    Ok(Ring {
        radii: [inner, outer],
        height: table.number("height"),
        degrees: table.number("degrees"),
        cells: cells(table, element)?,
        grading: table.vector("grading"),
        element,
    })
}

fn block(table: &View) -> Result<Block, Error> {
    let element = element(table)?;
    Ok(Block {
        size: table.vector("size"),
        cells: cells(table, element)?,
        origin: table.vector("origin"),
        grading: table.vector("grading"),
        element,
    })
}

fn cells(table: &View, element: BlockElement) -> Result<[usize; 3], Error> {
    let cells = table.counts("cells");
    // Nodes are numbered with 32 bits, degrees of freedom are three times as many.
    let counted = Block { size: [1.0; 3], cells, origin: [0.0; 3], grading: [1.0; 3], element };
    let nodes = counted.nodes();
    if 3.0 * nodes >= f64::from(u32::MAX) {
        let what = format!("{cells:?} cells have {:.0} million nodes, more than can be numbered", nodes / 1e6);
        return Err(table.error("cells", what, "use fewer cells"));
    }
    Ok(cells)
}

fn element(table: &View) -> Result<BlockElement, Error> {
    let name = table.text("element");
    let uncut = [
        ("hex8", BlockElement::Hex8),
        ("hex20", BlockElement::Hex20),
        ("wedge6", BlockElement::Wedge6),
        ("wedge15", BlockElement::Wedge15),
    ];
    if let Some((_, element)) = uncut.into_iter().find(|(known, _)| *known == name) {
        let why = format!("is for tet4 and tet10, but the element is {name}, which is cut in one way only");
        table.refuse(&["split", "parity"], &why, "")?;
        return Ok(element);
    }
    let quadratic = name == "tet10";
    let split = table.given("split").and_then(|node| node.text()).unwrap_or("five");
    if split == "six" {
        table.refuse(&["parity"], "is for split = \"five\", but the split is \"six\", the same in every cell", "")?;
        return Ok(if quadratic { BlockElement::Tet10Six } else { BlockElement::Tet4Six });
    }
    let parity = u8::from(table.given("parity").map_or(0, |_| table.count("parity")) == 1);
    Ok(if quadratic { BlockElement::Tet10Five { parity } } else { BlockElement::Tet4Five { parity } })
}

/// The materials, at least one.
pub(super) fn materials(case: &View) -> Result<Vec<MaterialSpec>, Error> {
    let tables = case.tables("materials");
    let mut materials = Vec::new();
    for (name, table) in &tables {
        if tables.len() > 1 && table.given("on").is_none() {
            let what = format!("material {name:?} does not say where it is, and there are {} materials", tables.len());
            return Err(table.error("on", what, "add on = \"volume-group\", or a list of groups, to each of them"));
        }
        materials.push(material(name, table)?);
    }
    Ok(materials)
}

fn material(name: &str, table: &View) -> Result<MaterialSpec, Error> {
    let orthotropic = orthotropic(table)?;
    let (young, poisson) = match &orthotropic {
        Some(it) => (it.young.iter().sum::<f64>() / 3.0, 0.0),
        None => (table.number("young"), table.number("poisson")),
    };
    if orthotropic.is_some() && table.text("formulation") == "b-bar" {
        let what = "`formulation = \"b-bar\"` is for isotropic materials, and this one is orthotropic";
        return Err(table.error("formulation", what, "take `formulation` out"));
    }
    let material = Material {
        name: name.into(),
        young,
        poisson,
        orthotropic: orthotropic.map(Box::new),
        expansion: expansion(table)?,
        reference_temperature: table.number("reference_temperature"),
        density: table.number("density"),
        formulation: match table.text("formulation").as_str() {
            "full" => Formulation::Full,
            "b-bar" => Formulation::BBar,
            _ => Formulation::Auto,
        },
    };
    Ok(MaterialSpec { material, on: table.given("on").map(|node| groups(table.source, node)), spot: table.spot() })
}

/// The constants of an orthotropic material, if one of them has three values.
fn orthotropic(table: &View) -> Result<Option<Orthotropic>, Error> {
    let three = |key: &str| table.given(key).is_some_and(|node| node.number().is_none());
    if !["young", "poisson", "shear"].into_iter().any(three) {
        if !three("expansion") {
            let why = "is for a material that depends on the direction, but all constants are single numbers";
            table.refuse(&["axes"], why, ", or give young, poisson and shear three values each")?;
        }
        return Ok(None);
    }
    for (key, example) in
        [("young", "[11e9, 0.9e9, 0.5e9]"), ("poisson", "[0.4, 0.4, 0.3]"), ("shear", "[0.7e9, 0.6e9, 0.06e9]")]
    {
        if !three(key) {
            let what = format!("an orthotropic material needs three values of `{key}`");
            return Err(table.error(key, what, format!("write for instance {key} = {example}")));
        }
    }
    let [young, poisson, shear] = ["young", "poisson", "shear"].map(|key| table.vector(key));
    axes(table)?;
    let refused = |what| {
        let remedy =
            "check the order [nu12, nu13, nu23]: nu12 = -strain 2 / strain 1 under tension along 1; nu12/E1 = nu21/E2";
        table.error("poisson", what, remedy)
    };
    Orthotropic::new(young, poisson, shear, table.vectors("axes")).map(Some).map_err(refused)
}

/// The material's own axes.
fn axes(table: &View) -> Result<[[f64; 3]; 3], Error> {
    frame(table.vectors("axes")).map_err(|what| table.error("axes", what, "give two directions that are not parallel"))
}

fn expansion(table: &View) -> Result<Option<Voigt>, Error> {
    let Some(node) = table.given("expansion") else { return Ok(None) };
    match node.number() {
        Some(a) => Ok(Some([a, a, a, 0.0, 0.0, 0.0])),
        None => Ok(Some(strain_along(&axes(table)?, table.vector("expansion")))),
    }
}
