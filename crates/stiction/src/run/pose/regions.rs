//! Names and boxes of a case file, as faces, cells and nodes of the mesh.

use crate::Error;
use crate::io::case::{Region, Spot, nearest};
use crate::mesh::{Group, Mesh, ascending};

/// What lies this part of the mesh's diagonal outside a box still counts as inside.
const ROUNDING: f64 = 1e-9;

/// What kind of thing a region is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Faces,
    Cells,
    Nodes,
}

/// Boundary faces of the region, ascending; `user` names who asks, such as "the contact".
pub(crate) fn faces(mesh: &Mesh, region: &Region, spot: &Spot, user: &str) -> Result<Vec<u32>, Error> {
    let corners = |face: &crate::mesh::Face| face.nodes().to_vec();
    match region {
        Region::Groups(names) => collect(names, |(name, spot)| {
            let group = group(mesh, name, spot, Kind::Faces)?;
            if !group.interior_faces.is_empty() {
                let what = format!(
                    "{user} needs boundary faces, but {} faces of group \"{name}\" lie between two cells",
                    group.interior_faces.len()
                );
                return Err(spot.error(what, "name a group on the boundary, or split the mesh along these faces"));
            }
            Ok(&group.faces)
        }),
        _ => inside(mesh, region, spot, "boundary face", mesh.faces.iter().map(corners)),
    }
}

/// Boundary faces of the region, ascending; none where it has none.
pub(crate) fn boundary_faces(mesh: &Mesh, region: &Region, spot: &Spot) -> Vec<u32> {
    match region {
        Region::Groups(names) => {
            let groups = names.iter().filter_map(|(name, _)| mesh.group(name));
            ascending(groups.flat_map(|group| group.faces.iter().copied()))
        }
        _ => faces(mesh, region, spot, "").unwrap_or_default(),
    }
}

/// Cells of the region, ascending.
pub(crate) fn cells(mesh: &Mesh, region: &Region, spot: &Spot) -> Result<Vec<u32>, Error> {
    match region {
        Region::Groups(names) => collect(names, |(name, spot)| Ok(&group(mesh, name, spot, Kind::Cells)?.cells)),
        _ => inside(mesh, region, spot, "cell", mesh.cell_iter().map(|(_, nodes)| nodes.to_vec())),
    }
}

/// Nodes of the region, ascending: all nodes of its cells, faces and points.
pub(crate) fn nodes(mesh: &Mesh, region: &Region, spot: &Spot) -> Result<Vec<u32>, Error> {
    match region {
        Region::Groups(names) => {
            let lists = names.iter().map(|(name, spot)| Ok(mesh.group_nodes(group(mesh, name, spot, Kind::Nodes)?)));
            Ok(ascending(lists.collect::<Result<Vec<_>, Error>>()?.into_iter().flatten()))
        }
        Region::Point(point) => Ok(nearest_node(mesh, *point).into_iter().collect()),
        _ => inside(mesh, region, spot, "node", (0..mesh.nodes.len() as u32).map(|node| vec![node])),
    }
}

/// The region as a person would call it.
pub(crate) fn name(region: &Region) -> String {
    let triple = |x: &[f64; 3]| format!("({}, {}, {})", x[0], x[1], x[2]);
    match region {
        Region::Groups(names) => names.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
        Region::Box { min, max } => format!("box {} to {}", triple(min), triple(max)),
        Region::Point(point) => format!("node nearest to {}", triple(point)),
    }
}

fn nearest_node(mesh: &Mesh, point: [f64; 3]) -> Option<u32> {
    let square = |x: &[f64; 3]| (0..3).map(|c| (x[c] - point[c]).powi(2)).sum::<f64>();
    let best = mesh.nodes.iter().enumerate().min_by(|a, b| square(a.1).total_cmp(&square(b.1)));
    best.map(|(node, _)| node as u32)
}

fn collect<'a>(
    names: &'a [(String, Spot)],
    list: impl Fn(&'a (String, Spot)) -> Result<&'a Vec<u32>, Error>,
) -> Result<Vec<u32>, Error> {
    let lists = names.iter().map(list).collect::<Result<Vec<_>, Error>>()?;
    Ok(ascending(lists.into_iter().flatten().copied()))
}

/// The numbers of the things whose nodes all lie in a box.
fn inside(
    mesh: &Mesh,
    region: &Region,
    spot: &Spot,
    thing: &str,
    things: impl Iterator<Item = Vec<u32>>,
) -> Result<Vec<u32>, Error> {
    let Region::Box { min, max } = region else {
        return Err(spot.error(format!("a point has no {thing}"), "give a group or a box"));
    };
    let [low, high] = mesh.bounding_box();
    let within = in_box([*min, *max], [low, high]);
    let found = things.enumerate().filter(|(_, nodes)| nodes.iter().all(|&node| within(mesh.nodes[node as usize])));
    let found: Vec<u32> = found.map(|(number, _)| number as u32).collect();
    if found.is_empty() {
        let what = format!("no {thing} lies inside the box from {min:?} to {max:?}");
        return Err(spot.error(what, format!("enlarge the box; the mesh reaches from {low:?} to {high:?}")));
    }
    Ok(found)
}

/// Whether a place lies in a box, in a whole mesh with the bounding box `low` to `high`; lengths.
pub(crate) fn in_box([min, max]: [[f64; 3]; 2], [low, high]: [[f64; 3]; 2]) -> impl Fn([f64; 3]) -> bool + Sync {
    let slack = ROUNDING * (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f64>().sqrt();
    move |x| (0..3).all(|c| min[c] - slack <= x[c] && x[c] <= max[c] + slack)
}

/// The group called `name`, which must have what it is asked for.
fn group<'m>(mesh: &'m Mesh, name: &str, spot: &Spot, kind: Kind) -> Result<&'m Group, Error> {
    let group = mesh.group(name).ok_or_else(|| missing(mesh, name, spot, kind))?;
    let has = holds(group, kind) || (kind == Kind::Faces && !group.interior_faces.is_empty());
    if has {
        return Ok(group);
    }
    let wanted = match kind {
        Kind::Faces => "boundary faces",
        Kind::Cells => "cells",
        Kind::Nodes => "nodes",
    };
    let found: Vec<String> = [("cells", group.cells.len()), ("faces", group.faces.len()), ("nodes", group.nodes.len())]
        .into_iter()
        .filter(|(_, count)| *count > 0)
        .map(|(what, count)| format!("{count} {what}"))
        .collect();
    let found = if found.is_empty() { "it is empty".to_string() } else { format!("it has {}", found.join(", ")) };
    Err(spot.error(format!("group \"{name}\" has no {wanted}: {found}"), suitable(mesh, kind)))
}

fn holds(group: &Group, kind: Kind) -> bool {
    match kind {
        Kind::Faces => !group.faces.is_empty(),
        Kind::Cells => !group.cells.is_empty(),
        Kind::Nodes => {
            [&group.cells, &group.faces, &group.nodes].iter().any(|l| !l.is_empty()) || !group.interior_faces.is_empty()
        }
    }
}

fn missing(mesh: &Mesh, name: &str, spot: &Spot, kind: Kind) -> Error {
    let right = || mesh.groups.iter().filter(|g| holds(g, kind)).map(|g| g.name.as_str());
    let guess = nearest(name, right()).map_or(String::new(), |g| format!("did you mean \"{g}\"? "));
    spot.error(format!("the mesh has no group \"{name}\""), guess + &suitable(mesh, kind))
}

/// Which groups would do.
fn suitable(mesh: &Mesh, kind: Kind) -> String {
    /// More names than this are no help.
    const SHOWN: usize = 20;
    let names: Vec<&str> = mesh.groups.iter().filter(|g| holds(g, kind)).map(|g| g.name.as_str()).collect();
    let what = match kind {
        Kind::Faces => "boundary faces",
        Kind::Cells => "cells",
        Kind::Nodes => "nodes",
    };
    if names.is_empty() {
        return format!(
            "no group of the mesh has {what}: name groups in the mesher; `on` also takes {{ box = [[...], [...]] }}"
        );
    }
    let more = names.len().saturating_sub(SHOWN);
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("groups with {what}: {}{more}", names[..names.len().min(SHOWN)].join(", "))
}
