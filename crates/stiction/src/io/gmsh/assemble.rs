//! From the numbers of a file to a mesh.

use std::collections::{BTreeSet, HashMap};

use super::complete;
use super::contents::{Contents, Physical, Run, unknown};
use super::data::{Place, arrays};
use super::types::{Role, element_type, order};
use crate::Error;
use crate::mesh::{CellKind, Mesh, MeshNote, MeshNotes, RawCells, RawGroup, RawMesh, build};

/// Resolves node tags, collects cells and groups and builds the mesh.
pub(super) fn assemble(mut contents: Contents, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    refuse_unusable(&contents)?;
    resolve(&mut contents)?;
    let mut hexahedra = Vec::new();
    complete::check(&contents, &mut hexahedra)?;
    let (groups, group_of) = groups(&contents);
    let mut raw = RawMesh { groups, ..RawMesh::default() };
    let mut notes = shared_names(&contents);
    notes.append(&mut hexahedra);
    let places = collect(&contents, &group_of, &mut raw, &mut notes);
    if !contents.data.is_empty() {
        raw.array_faces = faces(&contents);
        let cells = raw.cells.iter().map(|block| block.ids.len()).sum();
        raw.arrays = arrays(&mut contents, &places, cells, &mut notes)?;
    }
    raw.nodes = std::mem::take(&mut contents.nodes);
    raw.nodes.iter_mut().flatten().for_each(|x| *x *= scale);
    raw.node_ids = std::mem::take(&mut contents.node_tags);
    drop((contents, places)); // the build needs memory of its own
    let (mesh, built) = build(raw)?;
    notes.extend(built.0);
    Ok((mesh, MeshNotes(notes)))
}

/// An error if there are elements of other types than this program computes with, or no cells.
fn refuse_unusable(contents: &Contents) -> Result<(), Error> {
    let refused = contents.refused.iter().filter_map(|(&number, count)| Some((element_type(number)?, count)));
    // the type of highest dimension tells best what is wrong
    if let Some((kind, _)) = refused.clone().max_by_key(|(kind, _)| kind.dimension) {
        let list: Vec<String> = refused.map(|(kind, count)| format!("{count} x {}", kind.name)).collect();
        let remedy = if let Role::Refused(remedy) = kind.role { remedy } else { "" };
        return Err(Error::new("", format!("elements that cannot be used: {}", list.join(", ")), remedy));
    }
    if contents.runs.iter().any(|run| run.kind.dimension == 3) {
        return Ok(());
    }
    let what = format!("no volume cells among its {} elements", contents.element_tags.len());
    let remedy = "mesh the volume (gmsh -3) and put it into a physical group, or save all elements (Mesh.SaveAll = 1)";
    Err(Error::new("", what, remedy))
}

/// The nodes of all elements as indices, where they are still called by their tags.
fn resolve(contents: &mut Contents) -> Result<(), Error> {
    if contents.nodes_known.take().is_some() {
        return Ok(());
    }
    contents.know_nodes()?;
    let Contents { nodes_known, element_nodes, element_tags, runs, .. } = contents;
    for run in runs {
        let k = run.kind.nodes;
        for (i, node) in element_nodes[run.first_node..][..run.count * k].iter_mut().enumerate() {
            let tag = u64::from(*node);
            let found = nodes_known.as_ref().and_then(|labels| labels.find(tag));
            *node = found.ok_or_else(|| unknown(element_tags.get(run.first + i / k), tag))?;
        }
    }
    Ok(())
}

/// The surface elements in the order of the file.
fn faces(contents: &Contents) -> Vec<[u32; 4]> {
    let runs = contents.runs.iter().filter(|run| run.kind.role == Role::Face);
    runs.flat_map(|run| contents.nodes_of(run).map(corners)).collect()
}

/// Empty groups, those with a name first, and which of them each physical group fills. Equal names share a group.
pub(super) fn groups(contents: &Contents) -> (Vec<RawGroup>, HashMap<Physical, usize>) {
    let mut groups: Vec<RawGroup> = Vec::new();
    let mut by_name = HashMap::new();
    let mut group_of = HashMap::new();
    let mut add = |physical: Physical, name: &str| {
        group_of.entry(physical).or_insert_with(|| {
            *by_name.entry(name.to_string()).or_insert_with(|| {
                groups.push(RawGroup { name: name.to_string(), ..RawGroup::default() });
                groups.len() - 1
            })
        });
    };
    for (dimension, tag, name) in &contents.names {
        add((*dimension, tag.abs()), name);
    }
    let used: BTreeSet<Physical> = contents.runs.iter().flat_map(|run| contents.physicals(run)).collect();
    for physical in used {
        add(physical, &physical.1.to_string());
    }
    (groups, group_of)
}

/// Notes on names, or numbers without a name, that stand for things of several dimensions.
fn shared_names(contents: &Contents) -> Vec<MeshNote> {
    let named: HashMap<Physical, &str> =
        contents.names.iter().map(|(d, tag, name)| ((*d, tag.abs()), name.as_str())).collect();
    let used: BTreeSet<Physical> = contents.runs.iter().flat_map(|run| contents.physicals(run)).collect();
    let mut names: Vec<(String, u8)> =
        used.iter().map(|p| (named.get(p).map_or_else(|| p.1.to_string(), |n| n.to_string()), p.0)).collect();
    names.sort_unstable();
    names.dedup();
    let shared = names.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1);
    shared.map(|same| MeshNote::SharedName { group: same[0].0.clone() }).collect()
}

/// Distributes the elements to cells and groups; tells where each has gone if there are data on elements.
fn collect(
    contents: &Contents,
    group_of: &HashMap<Physical, usize>,
    raw: &mut RawMesh,
    notes: &mut Vec<MeshNote>,
) -> Vec<Place> {
    let wanted = contents.data.iter().any(|data| !data.nodal);
    let mut places = vec![Place::Other; if wanted { contents.element_tags.len() } else { 0 }];
    for kind in CellKind::ALL {
        let mut cells = RawCells { kind, nodes: Vec::new(), ids: Vec::new() };
        let before: usize = raw.cells.iter().map(|block| block.ids.len()).sum();
        let runs: Vec<&Run> = contents.runs.iter().filter(|run| run.kind.role == Role::Cell(kind)).collect();
        let mut copies = Copies::new(&runs);
        let total: usize = runs.iter().map(|run| run.count).sum();
        cells.nodes.reserve_exact(total * kind.nodes());
        cells.ids.reserve_exact(total);
        for run in runs {
            let targets: Vec<usize> = contents.physicals(run).iter().filter_map(|p| group_of.get(p)).copied().collect();
            if !copies.may_hold(run) {
                let first = before + cells.ids.len();
                cells.ids.extend((run.first..run.first + run.count).map(|i| contents.element_tags.get(i)));
                let nodes = contents.nodes_of(run).flat_map(|nodes| order(kind).iter().map(|&i| nodes[i]));
                cells.nodes.extend(nodes);
                let numbers = first as u32..(first + run.count) as u32;
                targets.iter().for_each(|&g| raw.groups[g].cells.extend(numbers.clone()));
                if wanted {
                    places[run.first..][..run.count].iter_mut().zip(numbers).for_each(|(at, n)| *at = Place::Cell(n));
                }
                continue;
            }
            for (i, nodes) in contents.nodes_of(run).enumerate() {
                let number = copies.find_or_insert(run, nodes, before + cells.ids.len());
                if number == before + cells.ids.len() {
                    cells.nodes.extend(order(kind).iter().map(|&i| nodes[i]));
                    cells.ids.push(contents.element_tags.get(run.first + i));
                }
                targets.iter().for_each(|&g| raw.groups[g].cells.push(number as u32));
                if wanted {
                    places[run.first + i] = Place::Cell(number as u32);
                }
            }
        }
        raw.cells.push(cells);
    }
    if wanted {
        let faces = contents.runs.iter().filter(|run| run.kind.role == Role::Face);
        let elements = faces.flat_map(|run| run.first..run.first + run.count);
        elements.enumerate().for_each(|(face, element)| places[element] = Place::Face(face as u32));
    }
    let mut skipped = [0; 3];
    for run in contents.runs.iter().filter(|run| run.kind.dimension < 3) {
        let targets: Vec<usize> = contents.physicals(run).iter().filter_map(|p| group_of.get(p)).copied().collect();
        if targets.is_empty() {
            skipped[run.kind.dimension as usize] += run.count;
        }
        for g in targets {
            match run.kind.role {
                Role::Face => raw.groups[g].faces.extend(contents.nodes_of(run).map(corners)),
                _ => contents.nodes_of(run).for_each(|nodes| raw.groups[g].nodes.extend(nodes)),
            }
        }
    }
    for (what, count) in ["point element", "curve element", "surface element"].into_iter().zip(skipped) {
        if count > 0 {
            notes.push(MeshNote::Skipped { what: what.into(), count });
        }
    }
    places
}

/// Corners come first, of triangles three.
fn corners(nodes: &[u32]) -> [u32; 4] {
    [nodes[0], nodes[1], nodes[2], if matches!(nodes.len(), 3 | 6) { u32::MAX } else { nodes[3] }]
}

/// MSH 2.2 repeats a cell under a new number for each further physical group of its volume.
#[derive(Default)]
struct Copies {
    /// Volumes in several physical groups.
    entities: BTreeSet<i64>,
    /// Their cells: number, and the physical group it came with.
    cells: HashMap<Vec<u32>, (usize, i64)>,
}

impl Copies {
    fn new(runs: &[&Run]) -> Self {
        let mut first: HashMap<i64, i64> = HashMap::new();
        let several = |run: &&&Run| *first.entry(run.entity).or_insert(run.physical) != run.physical;
        Copies { entities: runs.iter().filter(several).map(|run| run.entity).collect(), cells: HashMap::new() }
    }

    /// Whether a cell of the run may have come before.
    fn may_hold(&self, run: &Run) -> bool {
        self.entities.contains(&run.entity)
    }

    /// The number of an equal cell of another physical group, or `next` if the cell is new; of a run that [may have come
    /// before](Self::may_hold). An equal cell of the same group is not merged: the file says twice what it should say once.
    fn find_or_insert(&mut self, run: &Run, nodes: &[u32], next: usize) -> usize {
        let (number, physical) = *self.cells.entry(nodes.to_vec()).or_insert((next, run.physical));
        if physical == run.physical { next } else { number }
    }
}
