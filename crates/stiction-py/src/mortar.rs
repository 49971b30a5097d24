//! Contact between two surfaces of meshes that do not match, for those who assemble elsewhere.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::Error;
use stiction::contact::{
    ContactRows, ContactSurface, Counterpart, InitialGap, Master, Reason, Role, SurfaceFacts, SurfaceFriction,
    contact_rows,
};
use stiction::fem::DofMap;
use stiction::mesh::{Face, Mesh, build};

use crate::arrays::table;
use crate::case::{Given, raw};
use crate::errors::raised;
use crate::matrix::{rows, triples};
use crate::work::borrowed;

/// Nodes of faces, block by block.
type Faces<'py> = Vec<PyReadonlyArray2<'py, i64>>;

/// Rows, gaps and areas of the nodes of the slave surface. `surfaces` are nodes of faces in the order of the library, checked by
/// the Python side; or the surfaces are the groups "slave" and "master" of `mesh`, whose cells say which side is outside.
/// `held` are prescribed displacements, `3 node + c`, ascending.
#[pyfunction]
#[pyo3(signature = (points, surfaces, mesh, held, search))]
pub(crate) fn mortar<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    surfaces: [Faces<'py>; 2],
    mesh: Option<Given<'py>>,
    held: PyReadonlyArray1<'py, i64>,
    search: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let nodes = triples(&points)?;
    let count = nodes.len();
    let raw = mesh.map(|given| raw(py, &given)).transpose()?;
    let mut faces = [Vec::new(), Vec::new()];
    for (list, blocks) in faces.iter_mut().zip(&surfaces) {
        for block in blocks {
            for nodes in block.as_array().rows() {
                list.extend(Face::of_nodes(&nodes.iter().map(|&node| node as u32).collect::<Vec<u32>>()));
            }
        }
    }
    let held: Vec<u32> = held.as_slice()?.iter().map(|&dof| dof as u32).collect();
    let found = borrowed(py, |_| -> Result<_, Error> {
        let (mesh, kept, faces) = match raw {
            Some(raw) => {
                // Nodes of no cell are left out by the library.
                let mut used = vec![false; count];
                raw.cells.iter().flat_map(|cells| &cells.nodes).for_each(|&node| used[node as usize] = true);
                let kept: Vec<u32> = (0..count as u32).filter(|&node| used[node as usize]).collect();
                let (mesh, _) = build(raw).map_err(|error| error.at("cells"))?;
                let faces = ["slave", "master"].map(|name| of_group(&mesh, name));
                let [slave, master] = faces;
                (mesh, kept, [slave?, master?])
            }
            None => {
                let [slave, master] = faces;
                let numbers = [0..slave.len(), slave.len()..slave.len() + master.len()];
                let mesh = Mesh {
                    nodes,
                    cells: Vec::new(),
                    faces: slave.into_iter().chain(master).collect(),
                    groups: Vec::new(),
                    arrays: Default::default(),
                };
                (mesh, (0..count as u32).collect(), numbers.map(|range| range.map(|i| i as u32).collect()))
            }
        };
        let [slave, master] = faces;
        let against = Counterpart::Surface(Master {
            faces: master,
            gap: InitialGap::AsMeshed,
            search,
            slave: Role::On,
            reason: Reason::Asked,
            nodes: None,
        });
        let surface = ContactSurface {
            name: "mortar".into(),
            faces: slave,
            against,
            friction: SurfaceFriction::None,
            stiffness: None,
            periods: vec![stiction::contact::ALWAYS],
        };
        let (found, facts) = contact_rows(&mesh, &dofs(&kept, &held), &[surface])?;
        if found.gap.is_empty() {
            return Err(nothing(&facts));
        }
        Ok((found, kept))
    })?;
    let (found, kept) = found.map_err(|error| raised(py, error))?;
    let ContactRows { mut B, gap, area, unity_sum, node, axes } = found;
    B.cols = 3 * count;
    B.column.iter_mut().for_each(|column| *column = 3 * kept[*column as usize / 3] + *column % 3);
    let dict = PyDict::new(py);
    dict.set_item("B", rows(py, B)?)?;
    dict.set_item("gap", PyArray1::from_vec(py, gap))?;
    dict.set_item("area", PyArray1::from_vec(py, area))?;
    dict.set_item("unity_sum", PyArray1::from_vec(py, unity_sum))?;
    dict.set_item("nodes", PyArray1::from_iter(py, node.iter().map(|&node| i64::from(kept[node as usize]))))?;
    dict.set_item("axes", table(py, axes.as_flattened().as_flattened(), 9)?)?;
    Ok(dict)
}

/// The boundary faces of a group all of whose faces are such.
fn of_group(mesh: &Mesh, name: &str) -> Result<Vec<u32>, Error> {
    let group = mesh.groups.iter().find(|group| group.name == name);
    let (faces, inside) = group.map_or((&[][..], 0), |group| (&group.faces[..], group.interior_faces.len()));
    if inside > 0 || faces.is_empty() {
        let what = format!("{inside} of its {} faces lie between two cells or are faces of none", inside + faces.len());
        return Err(Error::new(name, what, "give faces on the boundary of `cells`"));
    }
    Ok(faces.to_vec())
}

/// The degrees of freedom of the nodes `kept`, where `held` are prescribed.
fn dofs(kept: &[u32], held: &[u32]) -> DofMap {
    let mut map = DofMap {
        follows: std::collections::HashMap::new(),
        unknown: Vec::new(),
        free: Vec::new(),
        prescribed: Vec::new(),
        value: Vec::new(),
        rotated: Vec::new(),
        layer: Vec::new(),
    };
    for (dof, outside) in kept.iter().flat_map(|&node| (3 * node)..(3 * node + 3)).enumerate() {
        if held.binary_search(&outside).is_ok() {
            map.unknown.push(u32::MAX);
            map.prescribed.push(dof as u32);
            map.value.push(0.0);
        } else {
            map.unknown.push(map.free.len() as u32);
            map.free.push(dof as u32);
        }
    }
    map
}

/// Why there is no contact point.
fn nothing(facts: &[SurfaceFacts]) -> Error {
    let facts = facts.first().cloned().unwrap_or_default();
    let pair = facts.pair.unwrap_or_default();
    if facts.clamped + facts.held_along_normal > 0 {
        let what = "the nodes of the slave surface that meet the other are held";
        return Error::new("slave", what, "make the other surface the slave");
    }
    if pair.averted {
        let what = "its faces and those of the other surface look the same way";
        return Error::new("slave", what, "order nodes counter-clockwise seen from outside, or give `cells`");
    }
    let apart = pair.nearest.map_or(String::new(), |distance| format!(", {distance:.3e} apart"));
    let what = format!("the surfaces do not meet within {:.3e}{apart}", pair.search);
    Error::new("search", what, "give a larger `search`, or other surfaces")
}
