//! Arrays of mesh files that a case names.

use crate::Error;
use crate::io::case::{Spot, nearest};
use crate::mesh::{CellArray, Mesh, NodeArray};

/// An array of the mesh; where points and cells have one of the same name, that of the points.
pub(crate) enum Found<'m> {
    Nodes(&'m NodeArray),
    Cells(&'m CellArray),
}

/// The array called `name`, or what is wrong with that name and which there are.
pub(crate) fn find<'m>(mesh: &'m Mesh, name: &str, spot: &Spot) -> Result<Found<'m>, Error> {
    let arrays = &mesh.arrays;
    if let Some(array) = arrays.nodes.iter().find(|array| array.name == name) {
        return Ok(Found::Nodes(array));
    }
    if let Some(array) = arrays.cells.iter().find(|array| array.name == name) {
        return Ok(Found::Cells(array));
    }
    if let Some((_, what)) = arrays.others.iter().find(|other| other.0 == name) {
        let remedy = format!("write one floating-point number for each point or cell; {}", there_are(mesh));
        return Err(spot.error(format!("the array \"{name}\" of the mesh cannot be used: {what}"), remedy));
    }
    let names = arrays.nodes.iter().map(|a| &a.name).chain(arrays.cells.iter().map(|a| &a.name));
    let guess = nearest(name, names.map(String::as_str)).map_or(String::new(), |g| format!("did you mean \"{g}\"? "));
    Err(spot.error(format!("the mesh has no array \"{name}\""), guess + &there_are(mesh)))
}

/// Which arrays the mesh has.
fn there_are(mesh: &Mesh) -> String {
    let list = |names: Vec<&str>| names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let points = list(mesh.arrays.nodes.iter().map(|array| array.name.as_str()).collect());
    let cells = list(mesh.arrays.cells.iter().map(|array| array.name.as_str()).collect());
    match (points.is_empty(), cells.is_empty()) {
        (true, true) => "give the mesh as a .vtu file with an array of numbers on its points or cells, or as a .msh file with $NodeData or \
                         $ElementData"
            .into(),
        (false, true) => format!("its point arrays are {points}, its cells have none"),
        (true, false) => format!("its cell arrays are {cells}, its points have none"),
        (false, false) => format!("its point arrays are {points}, its cell arrays {cells}"),
    }
}
