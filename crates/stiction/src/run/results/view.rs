//! The interactive view of a result folder, from its files.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

#[cfg(feature = "plots")]
use super::fields::{Side, SurfaceFields};
use super::html::{Field, Frame, View, thin};
use super::summary::Summary;
use crate::Error;
use crate::io::units::Units;
use crate::io::vtu_read::{Fields, Over, Polygons, read_body, read_fields, read_polygons};
use crate::mesh::v3::V3;
use crate::mesh::{CellKind, Mesh, RawCells, RawMesh, build};

/// Most faces of the view: what a browser on a small machine still turns smoothly, some 5 MB of the page.
const MOST_FACES: usize = 150_000;
/// Most bytes of all frames before they are written in base64.
const MOST_FRAME_BYTES: usize = 6_000_000;

const ON_BODY: [(Over, &str); 2] = [(Over::Points, "displacement"), (Over::Cells, "von_mises")];
const ON_CONTACT: [(Over, &str); 8] = [
    (Over::Points, "pressure"),
    (Over::Points, "shear_traction"),
    (Over::Points, "slip"),
    (Over::Points, "gap"),
    (Over::Points, "status"),
    (Over::Points, "node"),
    (Over::Points, "slid"),
    (Over::Points, "side"),
];

/// Vertices of the view by what they are in the files.
struct Vertices {
    node: Vec<u32>,
    /// Point of `contact.vtu`; `u32::MAX` on the body.
    contact: Vec<u32>,
}

/// Reads the surface of the bodies, the contact surfaces and the fields of all steps of the folder.
pub(crate) fn view(folder: &Path, mesh: Option<&Mesh>, summary: &Summary, units: Units) -> Result<View, Error> {
    let steps = &summary.steps;
    let has_contact = summary.answer.contact.points > 0;
    let name = |front: &str, number: usize| match number {
        0 => folder.join(format!("{front}.vtu")),
        _ => folder.join(format!("{front}-{number:04}.vtu")),
    };
    let last = steps.len();
    let read;
    let (mesh, last_body) = match mesh.filter(|mesh| comes_back(mesh)) {
        Some(mesh) => (mesh, read_fields(&name("result", last), &ON_BODY)?),
        None => {
            let body;
            (read, body) = read_body(&name("result", last), &ON_BODY)?;
            (&read, body)
        }
    };
    let (polygons, last_contact) = match has_contact {
        true => read_polygons(&name("contact", last), &ON_CONTACT)?,
        false => Default::default(),
    };
    let (mut view, vertices) = geometry(&mesh.nodes, corners_of(mesh), &polygons, &last_contact)?;
    let stepped = !steps.is_empty();
    view.fields = fields(units, has_contact, stepped);
    let numbers = frames_shown(steps.len(), view.points.len() * (6 + 2 * view.fields.len()));
    if numbers.len() < steps.len() {
        view.notes.push(format!("Of {} load steps the view shows {}.", steps.len(), numbers.len()));
    }
    for number in numbers {
        let (body, contact);
        let (body, contact) = if number == last {
            (&last_body, &last_contact)
        } else {
            // The arrays of several kinds of cells stand in the file in the order of its cells, which the mesh has sorted.
            let path = name("result", number);
            body = if mesh.cells.len() > 1 { read_body(&path, &ON_BODY)?.1 } else { read_fields(&path, &ON_BODY)? };
            let read = |path| read_fields(path, &ON_CONTACT);
            contact = if has_contact { read(&name("contact", number))? } else { Fields::default() };
            (&body, &contact)
        };
        let entry = number.checked_sub(1).and_then(|i| steps.get(i));
        let called = entry.map_or(String::new(), |entry| {
            let name = if entry.name.is_empty() { String::new() } else { format!("{}, ", entry.name) };
            format!("step {number}: {name}t = {}", entry.t)
        });
        let frame = frame(mesh, &vertices, body, contact, stepped).map(|frame| Frame { name: called, ..frame });
        view.frames.push(frame.map_err(|e| e.at(&name("result", number).display().to_string()))?);
    }
    Ok(view)
}

/// That of the last increment of several ranks, whose pieces of the bodies and of the contact surfaces these are; the bodies have so many
/// nodes. It is `stepped` where there are load steps.
pub(crate) fn view_of_pieces(
    [bodies, surfaces]: &[Vec<PathBuf>; 2],
    nodes: u64,
    stepped: bool,
    units: Units,
) -> Result<View, Error> {
    let (mesh, body) = read_bodies(bodies, nodes)?;
    let (polygons, contact) = read_surfaces(surfaces)?;
    let (mut view, vertices) = geometry(&mesh.nodes, corners_of(&mesh), &polygons, &contact)?;
    view.fields = fields(units, contact.points > 0, stepped);
    view.frames.push(frame(&mesh, &vertices, &body, &contact, stepped)?);
    Ok(view)
}

/// That of the surfaces of an answer: nodes of the boundary with their displacements, length, and von Mises stress; the nodes of each
/// face of it; and the contact surfaces, by places among these nodes. It is `stepped` where there are load steps.
#[cfg(feature = "plots")]
pub(crate) fn view_of_surfaces(
    (nodes, displacement, von_mises): (&[V3], &[V3], &[f64]),
    faces: &[Vec<u32>],
    surfaces: &[SurfaceFields],
    stepped: bool,
    units: Units,
) -> Result<View, Error> {
    let (mut polygons, mut contact) = (Polygons::default(), Fields::default());
    let mut arrays = vec![Vec::new(); ON_CONTACT.len()];
    for of in surfaces {
        let first = polygons.points.len() as u32;
        polygons.points.extend(&of.points);
        polygons.faces.extend(of.faces.iter().map(|face| face.iter().map(|&v| first + v).collect()));
        let numbers = |list: &[i32]| list.iter().map(|&number| f64::from(number)).collect();
        let (pressure, gap) = (of.pressure.clone(), of.gap.clone());
        let (shear, slip) = (of.shear.concat(), of.slip.concat());
        let side = vec![f64::from(u8::from(of.side == Side::Master)); of.points.len()];
        let all = [pressure, shear, slip, gap, numbers(&of.status), numbers(&of.nodes), of.slid.concat(), side];
        arrays.iter_mut().zip(all).for_each(|(to, from): (&mut Vec<f64>, Vec<f64>)| to.extend(from));
    }
    contact.points = polygons.points.len();
    contact.arrays = arrays.into_iter().map(Some).collect();
    let (mut view, vertices) = geometry(nodes, faces.iter().map(|face| corners(face)), &polygons, &contact)?;
    view.fields = fields(units, contact.points > 0, stepped);
    view.frames.push(frame_of((displacement, von_mises), &vertices, &contact, stepped)?);
    Ok(view)
}

const NODE: (Over, &str) = (Over::Points, "node");

/// The bodies, and arrays as [`ON_BODY`], of which each piece has some cells.
fn read_bodies(pieces: &[PathBuf], nodes: u64) -> Result<(Mesh, Fields), Error> {
    let read = |path: &PathBuf| read_body(path, &[ON_BODY[0], ON_BODY[1], NODE]);
    let read: Vec<(Mesh, Fields)> = pieces.iter().map(read).collect::<Result<_, Error>>()?;
    // No memory is taken for nodes that no piece can have, whatever the summary says.
    let most: usize = read.iter().map(|(mesh, _)| mesh.nodes.len()).sum();
    let count = usize::try_from(nodes).ok().filter(|&count| count <= most).ok_or_else(unfit)?;
    let mut raw = RawMesh { nodes: vec![[f64::NAN; 3]; count], ..RawMesh::default() };
    let block = |kind| (RawCells { kind, nodes: Vec::new(), ids: Vec::new() }, Vec::new());
    let mut blocks: [(RawCells, Vec<f64>); CellKind::ALL.len()] = CellKind::ALL.map(block);
    let mut displacement = vec![f64::NAN; 3 * count];
    for ((mesh, fields), path) in read.into_iter().zip(pieces) {
        let unfit_here = || unfit().at(&path.display().to_string());
        let array = |i: usize, length: usize| fields.arrays[i].as_ref().filter(|array| array.len() == length);
        let [u, von_mises, numbers] = [
            array(0, 3 * mesh.nodes.len()).ok_or_else(unfit_here)?,
            array(1, mesh.cell_count()).ok_or_else(unfit_here)?,
            array(2, mesh.nodes.len()).ok_or_else(unfit_here)?,
        ];
        let place = |number: &f64| Some(*number as usize).filter(|&place| *number >= 0.0 && place < count);
        let places: Vec<usize> = numbers.iter().map(place).collect::<Option<_>>().ok_or_else(unfit_here)?;
        for ((&place, x), u) in places.iter().zip(&mesh.nodes).zip(u.chunks_exact(3)) {
            raw.nodes[place] = *x;
            displacement[3 * place..][..3].copy_from_slice(u);
        }
        let mut von_mises = von_mises.iter();
        for cells in &mesh.cells {
            let of_kind = blocks.iter_mut().find(|(block, _)| block.kind == cells.kind);
            let Some((block, values)) = of_kind else { continue };
            block.nodes.extend(cells.nodes.iter().map(|&node| places[node as usize] as u32));
            values.extend(von_mises.by_ref().take(cells.len()));
        }
    }
    // A node without a place is of a piece that is not there.
    if raw.nodes.iter().any(|x| x[0].is_nan()) {
        return Err(unfit());
    }
    let (cells, values): (Vec<RawCells>, Vec<Vec<f64>>) = blocks.into_iter().unzip();
    raw.cells = cells;
    let von_mises = values.concat();
    let (mesh, _) = build(raw)?;
    let arrays = vec![Some(displacement), Some(von_mises)];
    Ok((mesh, Fields { points: count, cells: values.iter().map(Vec::len).sum(), arrays }))
}

/// The contact surfaces, and arrays as [`ON_CONTACT`].
fn read_surfaces(pieces: &[PathBuf]) -> Result<(Polygons, Fields), Error> {
    let (mut polygons, mut all) = (Polygons::default(), Fields::default());
    all.arrays = vec![None; ON_CONTACT.len()];
    for path in pieces {
        let (piece, fields) = read_polygons(path, &ON_CONTACT)?;
        let first = polygons.points.len() as u32;
        polygons.points.extend(piece.points);
        let moved = |face: Vec<u32>| face.iter().map(|&v| first + v).collect();
        polygons.faces.extend(piece.faces.into_iter().map(moved));
        all.points += fields.points;
        all.cells += fields.cells;
        for (to, from) in all.arrays.iter_mut().zip(fields.arrays) {
            from.into_iter().for_each(|from| to.get_or_insert_default().extend(from));
        }
    }
    Ok((polygons, all))
}

/// Whether reading the file of a mesh gives its cells in their order: kinds are sorted when it is read.
fn comes_back(mesh: &Mesh) -> bool {
    let place = |kind: CellKind| CellKind::ALL.iter().position(|&k| k == kind);
    mesh.cells.windows(2).all(|pair| place(pair[0].kind) < place(pair[1].kind))
}

/// Numbers of the steps that fit, the last among them; 0 stands for a result without steps.
fn frames_shown(steps: usize, bytes: usize) -> Vec<usize> {
    let fit = (MOST_FRAME_BYTES / bytes.max(1)).max(1);
    match steps {
        0 => vec![0],
        n if n <= fit => (1..=n).collect(),
        n => (1..=fit).map(|i| i * n / fit).collect(),
    }
}

fn fields(Units { length, stress, .. }: Units, has_contact: bool, stepped: bool) -> Vec<Field> {
    let scalar = |label, unit: &str| Field { label, unit: unit.to_string(), status: false };
    let mut fields = vec![scalar("Von Mises stress", stress)];
    if has_contact {
        fields.extend([
            scalar("Contact pressure", stress),
            scalar("Shear traction", stress),
            scalar("Slip", length),
            scalar("Gap", length),
            Field { label: "State of contact", unit: String::new(), status: true },
        ]);
        if stepped {
            fields.push(scalar("Slid since the start", length));
        }
    }
    fields
}

/// Whether each contact point belongs to a master.
fn on_master(contact: &Fields) -> Vec<bool> {
    match contact.arrays.get(7) {
        Some(Some(side)) if side.len() == contact.points => side.iter().map(|&side| side > 0.0).collect(),
        _ => vec![false; contact.points],
    }
}

/// `values`, `width` a point, where a node of several masters has the mean of what the pairs tell: each of them covers a
/// part of the faces around it.
fn brought_together(contact: &Fields, mut values: Vec<f64>, width: usize) -> Vec<f64> {
    let nodes = contact.arrays[5].as_deref().unwrap_or(&[]);
    let masters: Vec<(usize, u64)> = (nodes.iter().map(|node| node.to_bits()).enumerate())
        .zip(on_master(contact))
        .filter(|(_, m)| *m)
        .map(|(p, _)| p)
        .collect();
    for c in 0..width {
        let mut sums: HashMap<u64, (f64, f64)> = HashMap::new();
        for &(point, node) in &masters {
            let value = values[width * point + c];
            if !value.is_nan() {
                let (sum, count) = sums.entry(node).or_default();
                (*sum, *count) = (*sum + value, *count + 1.0);
            }
        }
        let mean = |node| sums.get(node).map_or(f64::NAN, |(sum, count)| sum / count);
        masters.iter().for_each(|(point, node)| values[width * point + c] = mean(node));
    }
    values
}

/// The boundary of the mesh without contact surfaces, then these: slaves, and masters where no slave is; coarser where they have too
/// many faces.
fn geometry(
    nodes: &[V3],
    boundary: impl Iterator<Item = [u32; 4]>,
    polygons: &Polygons,
    contact: &Fields,
) -> Result<(View, Vertices), Error> {
    let own_node = nodes_of(polygons, contact, nodes.len())?;
    let key = |corners: [u32; 4]| {
        let mut key = corners;
        key.sort_unstable();
        key
    };
    let master = on_master(contact);
    let key_of = |face: &[u32]| key(corners(face).map(|v| own_node[v as usize]));
    let is_master = |face: &[u32]| master.get(face[0] as usize) == Some(&true);
    let mut in_contact: HashSet<[u32; 4]> =
        polygons.faces.iter().filter(|face| !is_master(face)).map(|face| key_of(face)).collect();
    // Of a face in several pairs one is enough, and the slave has more fields.
    let shown: Vec<&Vec<u32>> =
        polygons.faces.iter().filter(|face| !is_master(face) || in_contact.insert(key_of(face))).collect();
    let free = boundary.filter(|&face| !in_contact.contains(&key(face)));
    let mut vertex = vec![u32::MAX; nodes.len()];
    let mut vertices = Vertices { node: Vec::new(), contact: Vec::new() };
    let mut view = View::default();
    for face in free {
        view.faces.push(face.map(|node| {
            let slot = &mut vertex[node as usize];
            if *slot == u32::MAX {
                *slot = vertices.node.len() as u32;
                vertices.node.push(node);
            }
            *slot
        }));
    }
    let first = vertices.node.len() as u32;
    vertices.contact = vec![u32::MAX; vertices.node.len()];
    vertices.contact.extend(0..own_node.len() as u32);
    vertices.node.extend(&own_node);
    view.first_contact_point = first as usize;
    view.first_contact_face = view.faces.len();
    view.faces.extend(shown.iter().map(|face| corners(face).map(|v| first + v)));
    view.points = vertices.node.iter().map(|&node| nodes[node as usize]).collect();
    let before = view.faces.len();
    if let Some(kept) = thin(&mut view, MOST_FACES) {
        vertices.node = kept.iter().map(|&v| vertices.node[v as usize]).collect();
        vertices.contact = kept.iter().map(|&v| vertices.contact[v as usize]).collect();
        view.notes.push(format!(
            "The view shows a coarser surface, {} of {before} faces; the numbers at its vertices are those of the mesh.",
            view.faces.len()
        ));
    }
    Ok((view, vertices))
}

/// Node of the mesh of each contact point.
fn nodes_of(polygons: &Polygons, contact: &Fields, nodes: usize) -> Result<Vec<u32>, Error> {
    if polygons.points.is_empty() {
        return Ok(Vec::new());
    }
    let numbers = contact.arrays[5].as_deref().unwrap_or(&[]);
    let own: Vec<u32> = numbers.iter().map(|&n| n as u32).collect();
    let whole = own.len() == polygons.points.len() && own.iter().all(|&n| (n as usize) < nodes);
    let polygonal = polygons.faces.iter().all(|face| face.len() >= 3);
    if whole && polygonal { Ok(own) } else { Err(unfit()) }
}

fn unfit() -> Error {
    Error::new("", "the files of the result do not fit one another", "solve the case again")
}

/// Corners of a face of any order, a triangle's last one twice.
fn corners(face: &[u32]) -> [u32; 4] {
    match face.len() {
        3 | 6 => [face[0], face[1], face[2], face[2]],
        _ => [face[0], face[1], face[2], face[3]],
    }
}

/// Corners of the faces of a mesh.
fn corners_of(mesh: &Mesh) -> impl Iterator<Item = [u32; 4]> {
    mesh.faces.iter().map(|face| corners(face.nodes()))
}

/// An array of so many numbers.
fn array(fields: &Fields, i: usize, length: usize) -> Result<Vec<f64>, Error> {
    fields.arrays.get(i).cloned().flatten().filter(|a| a.len() == length).ok_or_else(unfit)
}

fn frame(mesh: &Mesh, vertices: &Vertices, body: &Fields, contact: &Fields, stepped: bool) -> Result<Frame, Error> {
    let displacement = array(body, 0, 3 * mesh.nodes.len())?;
    let von_mises = at_nodes(mesh, &array(body, 1, mesh.cell_count())?);
    frame_of((displacement.as_chunks().0, &von_mises), vertices, contact, stepped)
}

/// A frame of displacements, length, and von Mises stress at nodes.
fn frame_of(
    (displacement, von_mises): (&[V3], &[f64]),
    vertices: &Vertices,
    contact: &Fields,
    stepped: bool,
) -> Result<Frame, Error> {
    let mut values = vec![vertices.node.iter().map(|&node| von_mises[node as usize]).collect::<Vec<f64>>()];
    if contact.points > 0 {
        let count = contact.points;
        let size = |v: &[f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let all_sizes = |v: Vec<f64>| v.as_chunks().0.iter().map(size).collect::<Vec<f64>>();
        let sizes = |i| array(contact, i, 3 * count).map(all_sizes);
        let pressure = brought_together(contact, array(contact, 0, count)?, 1);
        let shear = all_sizes(brought_together(contact, array(contact, 1, 3 * count)?, 3));
        let mut on_contact = vec![pressure, shear, sizes(2)?, array(contact, 3, count)?, array(contact, 4, count)?];
        if stepped {
            on_contact.push(sizes(6)?);
        }
        for field in on_contact {
            values.push(vertices.contact.iter().map(|&v| field.get(v as usize).copied().unwrap_or(f64::NAN)).collect());
        }
    }
    let displacement = vertices.node.iter().map(|&node| displacement[node as usize]).collect();
    Ok(Frame { name: String::new(), displacement, values })
}

/// The mean over the cells at each node.
pub(crate) fn at_nodes(mesh: &Mesh, of_cells: &[f64]) -> Vec<f64> {
    let (mut sum, mut count) = (vec![0.0; mesh.nodes.len()], vec![0.0; mesh.nodes.len()]);
    for ((_, nodes), value) in mesh.cell_iter().zip(of_cells) {
        for &node in nodes {
            sum[node as usize] += value;
            count[node as usize] += 1.0;
        }
    }
    sum.iter().zip(&count).map(|(sum, count)| sum / count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_do_not_fit_are_left_out_but_never_the_last() {
        assert_eq!(frames_shown(0, 100), [0]);
        assert_eq!(frames_shown(3, 100), [1, 2, 3]);
        assert_eq!(frames_shown(10, MOST_FRAME_BYTES / 4), [2, 5, 7, 10]);
        assert_eq!(frames_shown(7, usize::MAX), [7]);
    }
}
