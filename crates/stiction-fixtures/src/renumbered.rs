//! A case on the mesh it has and on the same mesh with nodes and cells in another order: the answers are compared.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use stiction::fem::full_displacement;
use stiction::io::case::{self, Case, MeshSource, MeshSpec};
use stiction::mesh::{CellKind, Mesh, block, ring};
use stiction::run::{Outcome, Prepared, read_mesh};

use crate::folder::Folder;
use crate::fuzz::Random;
use crate::random_case::solved_case;

/// How far two answers are apart, each in the largest of its kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Difference {
    /// Load steps compared; one without load steps.
    pub steps: usize,
    /// Nodal contact forces.
    pub forces: f64,
    /// Nodal displacements.
    pub displacements: f64,
}

/// Solves the case at `path` to `tolerance` on its mesh and on a renumbered one.
///
/// # Errors
/// If the case or its mesh cannot be read, written or solved, or the steps are not the same.
pub fn compare(path: &Path, tolerance: f64, seed: u64) -> Result<Difference, Box<dyn Error>> {
    let mut case = case::read(path, &[])?;
    case.solver.tolerance = tolerance;
    let folder = Folder::new("renumbered");
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let (mut other, mut order) = (case.clone(), Vec::new());
    renumber(&mut other.mesh, &folder, &mut random, &mut order)?;
    let before = answers(case)?;
    let after = answers(other)?;
    if before.iter().map(|a| a.t).ne(after.iter().map(|a| a.t)) {
        return Err("the load steps are not the same".into());
    }
    let mut found = Difference { steps: before.len(), ..Difference::default() };
    // In the largest of all steps: a step may end without load.
    let largest =
        |of: fn(&Answer) -> &Vec<[f64; 3]>| before.iter().flat_map(of).flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
    let [force, length] = [largest(|a| &a.forces), largest(|a| &a.u)];
    for (before, after) in before.iter().zip(&after) {
        // Written with all their digits and read again: the same nodes.
        assert!(order.iter().zip(&after.x).all(|(&old, x)| before.x[old] == *x), "the nodes are others");
        let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            let pairs = order.iter().zip(b).flat_map(|(&old, b)| a[old].into_iter().zip(*b));
            pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        found.forces = found.forces.max(apart(&before.forces, &after.forces) / force);
        found.displacements = found.displacements.max(apart(&before.u, &after.u) / length);
    }
    Ok(found)
}

/// What a load step ends with, node by node.
struct Answer {
    t: f64,
    x: Vec<[f64; 3]>,
    u: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
}

fn answers(case: Case) -> Result<Vec<Answer>, String> {
    let mut found: Vec<Answer> = Vec::new();
    solved_case(case, &mut |t, prepared: &Prepared, outcome: &Outcome| {
        // From its beginning again with a wider search.
        found.retain(|answer| answer.t < t);
        let nodal = |u: &[f64]| full_displacement(&prepared.model, u).as_chunks().0.to_vec();
        let (u, none) = (nodal(&outcome.solution.u), nodal(&vec![0.0; outcome.solution.u.len()]));
        // The axes of a node are turned back with what is prescribed, which is taken off again.
        let mut forces = nodal(&prepared.problem.contact.B.transpose_times(&outcome.solution.lambda));
        forces.iter_mut().flatten().zip(none.iter().flatten()).for_each(|(f, x)| *f -= x);
        found.push(Answer { t, x: prepared.mesh.nodes.clone(), u, forces });
    })?;
    Ok(found)
}

/// Writes every mesh of `spec` with its nodes and cells in another order, and has it read instead; `order` tells the old
/// number of each new node.
fn renumber(
    spec: &mut MeshSpec,
    folder: &Folder,
    random: &mut Random,
    order: &mut Vec<usize>,
) -> Result<(), Box<dyn Error>> {
    let mesh = match &mut spec.source {
        MeshSource::Parts(parts) => {
            return parts.iter_mut().try_for_each(|(_, part)| renumber(part, folder, random, order));
        }
        MeshSource::Block(description) => block(description)?,
        MeshSource::Ring(description) => ring(description)?,
        MeshSource::File { path, scale, include } => read_mesh(path, *scale, include)?.0,
        MeshSource::Given(given) => given.0.clone(),
    };
    if !(mesh.arrays.nodes.is_empty() && mesh.arrays.cells.is_empty()) {
        return Err("its mesh has arrays, which are not written again".into());
    }
    let nodes = shuffled(mesh.nodes.len(), random);
    let path = folder.write(&format!("{}.inp", order.len()), deck(&mesh, &nodes, random));
    spec.source = MeshSource::File { path, scale: 1.0, include: Vec::new() };
    let first = order.len();
    order.extend(nodes.iter().map(|old| first + old));
    Ok(())
}

fn shuffled(n: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    (1..n).for_each(|k| order.swap(k, random.below(k + 1)));
    order
}

/// An input of Abaqus with all groups: faces as shells, cells as element sets, nodes as node sets.
fn deck(mesh: &Mesh, nodes: &[usize], random: &mut Random) -> String {
    let mut new = vec![0; nodes.len()];
    nodes.iter().enumerate().for_each(|(k, &old)| new[old] = k + 1);
    let mut text = String::from("*NODE\n");
    for (k, &old) in nodes.iter().enumerate() {
        let [x, y, z] = mesh.nodes[old];
        line(&mut text, k + 1, format_args!("{x}, {y}, {z}"));
    }
    let cells: Vec<(CellKind, &[u32])> = mesh.cell_iter().collect();
    let (order, mut number) = (shuffled(cells.len(), random), 0);
    let mut label = vec![0; cells.len()];
    for kind in CellKind::ALL {
        text += &format!("*ELEMENT, TYPE=C3D{}\n", kind.nodes());
        for &old in order.iter().filter(|&&old| cells[old].0 == kind) {
            number += 1;
            label[old] = number;
            element(&mut text, number, cells[old].1, &new);
        }
    }
    for group in &mesh.groups {
        let name = &group.name;
        let faces = group.faces.iter().map(|&f| mesh.faces[f as usize].nodes().to_vec());
        let interior = group.interior_faces.iter().map(|f| f.iter().copied().filter(|&i| i != u32::MAX).collect());
        for face in faces.chain(interior) {
            number += 1;
            text += &format!("*ELEMENT, TYPE={}, ELSET={name}\n", ["S3", "S4", "", "STRI65", "", "S8"][face.len() - 3]);
            element(&mut text, number, &face, &new);
        }
        if !group.cells.is_empty() {
            text += &format!("*ELSET, ELSET={name}\n");
            group.cells.iter().for_each(|&cell| text += &format!("{}\n", label[cell as usize]));
        }
        if group.faces.is_empty() && group.interior_faces.is_empty() && group.cells.is_empty() {
            text += &format!("*NSET, NSET={name}\n");
            group.nodes.iter().for_each(|&node| text += &format!("{}\n", new[node as usize]));
        }
    }
    text
}

fn element(text: &mut String, number: usize, nodes: &[u32], new: &[usize]) {
    let nodes: Vec<String> = nodes.iter().map(|&node| new[node as usize].to_string()).collect();
    line(text, number, format_args!("{}", nodes.join(", ")));
}

fn line(text: &mut String, number: usize, what: std::fmt::Arguments) {
    writeln!(text, "{number}, {what}").unwrap_or(()); // a string takes everything
}
