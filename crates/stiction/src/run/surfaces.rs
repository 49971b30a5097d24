//! Contact surfaces of a case, on the mesh.

use super::regions;
use crate::Error;
use crate::contact::{ContactSurface, Obstacle, Side, SurfaceFriction};
use crate::io::case::{ContactSpec, FrictionSpec, ObstacleSpec, Side as SpecSide};
use crate::mesh::Mesh;

/// The surfaces and what they may touch.
pub(super) fn surfaces(mesh: &Mesh, specs: &[ContactSpec]) -> Result<Vec<ContactSurface>, Error> {
    let surface = |spec: &ContactSpec| {
        Ok(ContactSurface {
            name: spec.name.clone(),
            faces: regions::faces(mesh, &spec.on, &spec.spot, "the contact")?,
            obstacle: obstacle(&spec.against),
            friction: friction(spec.friction),
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

fn obstacle(spec: &ObstacleSpec) -> Obstacle {
    let side = |side: SpecSide| match side {
        SpecSide::Outside => Side::Outside,
        SpecSide::Inside => Side::Inside,
    };
    match *spec {
        ObstacleSpec::Plane { point, normal } => Obstacle::Plane { point, normal },
        ObstacleSpec::Sphere { center, radius, side: s } => Obstacle::Sphere { center, radius, side: side(s) },
        ObstacleSpec::Cylinder { point, axis, radius, side: s } => {
            Obstacle::Cylinder { point, axis, radius, side: side(s) }
        }
    }
}

fn friction(spec: FrictionSpec) -> SurfaceFriction {
    match spec {
        FrictionSpec::None => SurfaceFriction::None,
        FrictionSpec::Bonded => SurfaceFriction::Bonded,
        FrictionSpec::Coulomb(coefficient) => SurfaceFriction::Coulomb(coefficient),
        FrictionSpec::TrescaStress(stress) => SurfaceFriction::GivenStress(stress),
        FrictionSpec::TrescaNodal(force) => SurfaceFriction::GivenForce(force),
    }
}
