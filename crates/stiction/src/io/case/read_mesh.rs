//! `[mesh]` and `[materials]`.

use std::path::Path;

use super::data::{MaterialSpec, MeshSource, MeshSpec, Placing};
use super::read_contact::direction;
use super::read_region::groups;
use super::view::View;
use crate::Error;
use crate::fem::Formulation;
use crate::mesh::{Block, BlockElement, Turn};

/// The mesh; relative paths start at `folder`.
pub(super) fn mesh(case: &View, folder: &Path) -> Result<MeshSpec, Error> {
    let Some(table) = case.table("mesh") else {
        return Err(case.error("mesh", "the case file has no `mesh`", "add [mesh]"));
    };
    let parts = table.tables("parts");
    if parts.is_empty() {
        return part(&table, folder);
    }
    if table.given("scale").is_some() {
        let what = "`scale` is for a mesh file, but the mesh has parts";
        return Err(table.error("scale", what, "take `scale` out, or give it to a part"));
    }
    let read = |(name, view): &(&str, View)| Ok((name.to_string(), part(view, folder)?));
    let parts = parts.iter().map(read).collect::<Result<_, Error>>()?;
    Ok(MeshSpec { source: MeshSource::Parts(parts), placing: placing(&table)?, spot: table.spot() })
}

fn part(table: &View, folder: &Path) -> Result<MeshSpec, Error> {
    let source = match table.table("block") {
        Some(_) if table.given("scale").is_some() => {
            let what = "`scale` is for a mesh file, but the mesh is a block";
            return Err(table.error("scale", what, "take `scale` out and change `size` of the block"));
        }
        Some(block) => MeshSource::Block(self::block(&block)?),
        None => MeshSource::File { path: folder.join(table.text("file")), scale: table.number("scale") },
    };
    Ok(MeshSpec { source, placing: placing(table)?, spot: table.spot() })
}

fn placing(table: &View) -> Result<Placing, Error> {
    let turn = match table.table("turn") {
        Some(turn) => {
            Some(Turn { point: turn.vector("point"), axis: direction(&turn, "axis")?, degrees: turn.number("degrees") })
        }
        None => None,
    };
    Ok(Placing { turn, by: table.vector("move") })
}

fn block(table: &View) -> Result<Block, Error> {
    let cells = table.counts("cells");
    let block = Block {
        size: table.vector("size"),
        cells,
        origin: table.vector("origin"),
        grading: table.vector("grading"),
        element: element(table)?,
    };
    // Nodes are numbered with 32 bits, degrees of freedom are three times as many.
    let nodes = block.nodes();
    if 3.0 * nodes >= f64::from(u32::MAX) {
        let what = format!("{cells:?} cells have {:.0} million nodes, more than can be numbered", nodes / 1e6);
        return Err(table.error("cells", what, "use fewer cells"));
    }
    Ok(block)
}

fn element(table: &View) -> Result<BlockElement, Error> {
    let name = table.text("element");
    if name.starts_with("hex") {
        for key in ["split", "parity"] {
            if table.given(key).is_some() {
                let what = format!("`{key}` is for tet4 and tet10, but the element is {name}, which is not cut");
                return Err(table.error(key, what, format!("take `{key}` out")));
            }
        }
        return Ok(if name == "hex20" { BlockElement::Hex20 } else { BlockElement::Hex8 });
    }
    let quadratic = name == "tet10";
    let split = table.given("split").and_then(|node| node.text()).unwrap_or("five");
    if split == "six" {
        if table.given("parity").is_some() {
            let what = "`parity` is for split = \"five\", but the split is \"six\", the same in every cell";
            return Err(table.error("parity", what, "take `parity` out"));
        }
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
        materials.push(material(name, table));
    }
    Ok(materials)
}

fn material(name: &str, table: &View) -> MaterialSpec {
    MaterialSpec {
        name: name.into(),
        young: table.number("young"),
        poisson: table.number("poisson"),
        density: table.number("density"),
        formulation: match table.text("formulation").as_str() {
            "full" => Formulation::Full,
            "b-bar" => Formulation::BBar,
            _ => Formulation::Auto,
        },
        on: table.given("on").map(|node| groups(table.source, node)),
        spot: table.spot(),
    }
}
