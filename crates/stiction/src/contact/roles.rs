use crate::fem::DofMap;
use crate::mesh::Mesh;

/// One of the two surfaces of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    On,
    Against,
}

/// Why a surface carries the contact points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    Asked,
    /// Its friction is given by an array of the mesh on it.
    Array,
    /// Most nodes of the other surface are prescribed.
    Free,
    /// Its faces are smaller.
    Finer,
    /// Its body is softer.
    Softer,
    /// Neither differs; it was named first.
    First,
}

/// Sizes of faces whose ratio is below this are alike.
const ALIKE: f64 = 1.25;
/// Elastic moduli whose ratio is below this are alike.
const AS_STIFF: f64 = 1.01;

/// Which of two surfaces carries the contact points, the slave: one that is free to move rather than one whose nodes are
/// mostly prescribed; then the one with the smaller faces, whose nodes could otherwise sink in between those of the
/// other; then that of the softer body, which adapts to the other; then the first.
pub fn choose_slave(mesh: &Mesh, dofs: &DofMap, faces: [&[u32]; 2], young: [f64; 2]) -> (Role, Reason) {
    let held = faces.map(|faces| mostly_held(mesh, dofs, faces));
    if held[0] != held[1] {
        return (if held[0] { Role::Against } else { Role::On }, Reason::Free);
    }
    let smaller = |a: f64, b: f64, alike: f64| match () {
        () if alike * a < b => Some(Role::On),
        () if alike * b < a => Some(Role::Against),
        () => None,
    };
    let [a, b] = faces.map(|faces| face_size(mesh, faces));
    if let Some(finer) = smaller(a, b, ALIKE) {
        return (finer, Reason::Finer);
    }
    match smaller(young[0], young[1], AS_STIFF) {
        Some(softer) => (softer, Reason::Softer),
        None => (Role::On, Reason::First),
    }
}

/// Root of the mean area of the faces; length.
pub(super) fn face_size(mesh: &Mesh, faces: &[u32]) -> f64 {
    let area: f64 = faces.iter().map(|&face| mesh.face_area(face as usize)).sum();
    (area / faces.len().max(1) as f64).sqrt()
}

/// Whether more than half of the nodes are prescribed altogether.
fn mostly_held(mesh: &Mesh, dofs: &DofMap, faces: &[u32]) -> bool {
    let nodes = mesh.face_nodes(faces);
    let held = |node: &&u32| (0..3).all(|c| dofs.unknown[(3 * **node + c) as usize] == u32::MAX);
    2 * nodes.iter().filter(held).count() > nodes.len()
}
