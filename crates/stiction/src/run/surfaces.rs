//! Contact surfaces of a case, on the mesh.

use super::regions;
use crate::Error;
use crate::contact::ContactSurface;
use crate::io::case::ContactSpec;
use crate::mesh::Mesh;

/// The surfaces and what they may touch.
pub(super) fn surfaces(mesh: &Mesh, specs: &[ContactSpec]) -> Result<Vec<ContactSurface>, Error> {
    let surface = |spec: &ContactSpec| {
        Ok(ContactSurface {
            name: spec.name.clone(),
            faces: regions::faces(mesh, &spec.on, &spec.spot, "the contact")?,
            obstacle: spec.against,
            friction: spec.friction,
        })
    };
    specs.iter().map(surface).collect()
}

/// Pairs of surfaces that share faces, and how many.
pub(super) fn shared(surfaces: &[ContactSurface]) -> Vec<(String, String, usize)> {
    let mut shared = Vec::new();
    for (i, a) in surfaces.iter().enumerate() {
        for b in &surfaces[i + 1..] {
            let count = a.faces.iter().filter(|face| b.faces.binary_search(face).is_ok()).count();
            if count > 0 {
                shared.push((a.name.clone(), b.name.clone(), count));
            }
        }
    }
    shared
}
