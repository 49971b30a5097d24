//! `$NodeData` and `$ElementData`: numbers at nodes and elements, written alike in both versions of the format.

use super::contents::Contents;
use super::cursor::{Cursor, DAMAGED};
use crate::Error;
use crate::io::labels::Labels;
use crate::mesh::{CellArray, MeshArrays, MeshNote, NodeArray};

/// Memory in bytes that arrays may take: this many times the file, and so much besides. A section may name one node and
/// still has a number for each.
const TIMES_INPUT: usize = 8;
const BESIDES: usize = 64 << 20;
/// Arrays of different names; a step of time has the name of the others.
const MOST: usize = 1000;

/// A section of numbers.
pub(super) struct Data {
    pub name: String,
    /// Whether they belong to nodes rather than elements.
    pub nodal: bool,
    /// Numbers of nodes or elements in the file, with their values; empty unless there is one component.
    pub values: Vec<(u64, f64)>,
    /// What they are instead if they are not one number at each place.
    pub unfit: Option<String>,
}

/// Reads a section: texts of which the first is the name, real numbers, whole numbers (time step, components, count), and the
/// records. All but the records is text in binary files too.
pub(super) fn read(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let nodal = at.section == "$NodeData";
    let mut name = String::new();
    for i in 0..at.text_integer("the number of texts")? {
        at.skip_space();
        let line = String::from_utf8_lossy(at.line()).trim().trim_matches('"').to_string();
        if i == 0 {
            name = line;
        } else if line.is_empty() {
            return Err(at.fail("the section ends among its texts", DAMAGED));
        }
    }
    for _ in 0..at.text_integer("the number of real numbers")? {
        at.text_float("a real number, such as the time")?;
    }
    let mut whole = [0; 3];
    let start = at.pos;
    for i in 0..at.text_integer("the number of whole numbers")? {
        let value = at.text_integer("the time step, the components or the number of values")?;
        if let Some(slot) = whole.get_mut(i as usize) {
            *slot = value;
        }
    }
    let [_, components, count] = whole;
    let (Ok(components @ 1..=9), Ok(count)) = (usize::try_from(components), u64::try_from(count)) else {
        let what = format!("{count} values of {components} components are no data");
        return Err(at.fail_at(start, what, DAMAGED));
    };
    if at.binary() {
        at.line();
    }
    let mut data = Data { name, nodal, values: Vec::new(), unfit: None };
    if components != 1 {
        data.unfit = Some(format!("it has {components} components"));
    }
    let record = if at.binary() { 4 + 8 * components } else { 2 + 2 * components };
    let count = at.room(count, "values", record)?;
    if data.unfit.is_none() {
        data.values.reserve_exact(count);
    }
    for _ in 0..count {
        let tag = at.natural("the number of a node or an element")?;
        for _ in 0..components {
            let value = at.float("a value")?;
            if data.unfit.is_none() {
                data.values.push((tag, value));
            }
        }
    }
    // The last time step counts.
    contents.data.retain(|other| other.name != data.name || other.nodal != data.nodal);
    add(at, contents, data)
}

/// A section `$ElementNodeData`, of which nothing but the name is read.
pub(super) fn refuse(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    at.text_integer("the number of texts")?;
    at.skip_space();
    let name = String::from_utf8_lossy(at.line()).trim().trim_matches('"').to_string();
    let unfit = Some("it has a number for each node of each element".into());
    add(at, contents, Data { name, nodal: false, values: Vec::new(), unfit })?;
    at.skip_section()
}

fn add(at: &Cursor, contents: &mut Contents, data: Data) -> Result<(), Error> {
    if contents.data.len() >= MOST {
        return Err(at.fail(format!("there are more than {MOST} arrays"), "save only the arrays that the case names"));
    }
    contents.data.push(data);
    Ok(())
}

/// What an element of the file has become.
#[derive(Clone, Copy)]
pub(super) enum Place {
    Cell(u32),
    /// An index into `RawMesh::array_faces`.
    Face(u32),
    Other,
}

/// The arrays of a mesh with the nodes in the order of the file; `places` are those of the elements in that order.
pub(super) fn arrays(
    contents: &mut Contents,
    places: &[Place],
    cells: usize,
    notes: &mut Vec<MeshNote>,
) -> Result<MeshArrays, Error> {
    let data = std::mem::take(&mut contents.data);
    let mut arrays = MeshArrays::default();
    let needed: usize = data.iter().map(|data| 8 * if data.nodal { contents.nodes.len() } else { cells }).sum();
    if needed > TIMES_INPUT * contents.bytes + BESIDES {
        let what = format!("its {} arrays need {needed} bytes, far more than the file", data.len());
        return Err(Error::new("", what, "save only the arrays that the case names"));
    }
    let twice =
        |what: &'static str| move |tag: u64| Error::new(format!("{what} {tag}"), "it is given more than once", DAMAGED);
    // Gmsh gives elements that MSH 2.2 leaves out the number of the last it saved: the first value is the right one.
    let first = |slot: &mut f64, value: f64| *slot = if slot.is_nan() { value } else { *slot };
    let of_nodes = Labels::new(contents.node_tags.iter().copied()).map_err(twice("node"))?;
    let of_elements = match data.iter().any(|data| !data.nodal && data.unfit.is_none()) {
        true => Some(Labels::new(contents.element_tags.iter()).map_err(twice("element"))?),
        false => None,
    };
    for Data { name, nodal, values, unfit } in data {
        if let Some(what) = unfit {
            notes.push(MeshNote::NotRead { what: vec![format!("array \"{name}\"")] });
            arrays.others.push((name, what));
            continue;
        }
        let mut missing = 0;
        if nodal {
            let mut all = vec![f64::NAN; contents.nodes.len()];
            for (tag, value) in values {
                match of_nodes.find(tag) {
                    Some(node) => first(&mut all[node as usize], value),
                    None => missing += 1,
                }
            }
            arrays.nodes.push(NodeArray { name: name.clone(), values: all });
        } else {
            let mut array = CellArray { name: name.clone(), values: vec![f64::NAN; cells], faces: Vec::new() };
            for (tag, value) in values {
                match of_elements.as_ref().and_then(|labels| labels.find(tag)).map(|element| places[element as usize]) {
                    Some(Place::Cell(cell)) => first(&mut array.values[cell as usize], value),
                    Some(Place::Face(face)) => array.faces.push((face, value)),
                    Some(Place::Other) => {}
                    None => missing += 1,
                }
            }
            arrays.cells.push(array);
        }
        if missing > 0 {
            // Gmsh saves fields whole and of the mesh only what is in physical groups.
            let what = format!("{missing} values of array \"{name}\" at places that the file does not hold");
            notes.push(MeshNote::NotRead { what: vec![what] });
        }
    }
    Ok(arrays)
}
