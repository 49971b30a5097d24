//! What the certificate needs to judge a bound.

use std::collections::HashMap;

use super::contact::Surface;
use super::equilibrate::OnFace;
use super::fill::Map;
use super::tets::{NONE, Shape, Tets};
use super::{Acting, Limit, collect, out_of};
use crate::certificate::{BoundFields, BoundSide, BoundUnknown, FlatObstacle, Touch};
use crate::fem::Voigt;
use crate::fem::elements::Law;
use crate::mesh::v3::{V3, add};

/// The record of the admissible displacements `v` and of the stress of the tractions.
pub(super) fn fields(
    tets: &Tets,
    acting: &Acting,
    surfaces: &[Surface],
    held: &[Vec<V3>],
    shapes: &[Shape],
    tractions: &[OnFace],
    v: Vec<f64>,
) -> BoundFields {
    let solid = &tets.solid;
    let obstacle = |surface: &Surface| {
        let (normal, offset) = surface.plane();
        FlatObstacle { normal, offset }
    };
    let unknown = |&dof: &u32| BoundUnknown { node: dof / 3, direction: acting.dofs.direction(dof) };
    BoundFields {
        nodes: tets.mesh().nodes.clone(),
        corners: tets.corners.clone(),
        middles: tets.middles.clone(),
        stiffness: solid.materials.iter().map(|material| stiffness(&Law::new(material))).collect(),
        material: solid.material_of_cell.to_vec(),
        initial: acting.initial.to_vec(),
        body_force: acting.body_force.to_vec(),
        unknowns: acting.dofs.free.iter().map(unknown).collect(),
        found: acting.displacement.to_vec(),
        displacement: v,
        stress: collect(tets, |cell| Map::new(&shapes[cell]).parts(&out_of(tets, cell, tractions))),
        obstacles: surfaces.iter().map(obstacle).collect(),
        sides: sides(tets, acting, surfaces, held),
    }
}

/// All boundary faces with what is given there.
fn sides(tets: &Tets, acting: &Acting, surfaces: &[Surface], held: &[Vec<V3>]) -> Vec<BoundSide> {
    let mut loads: HashMap<u32, [V3; 3]> = HashMap::new();
    for &(face, at_corners) in acting.loads {
        let sum = loads.entry(tets.of_boundary[face as usize]).or_default();
        sum.iter_mut().zip(tets.in_order(face, at_corners)).for_each(|(sum, load)| *sum = add(*sum, load));
    }
    let mut touches: HashMap<u32, Vec<Touch>> = HashMap::new();
    for (number, surface) in surfaces.iter().enumerate() {
        for &face in &surface.faces {
            touches.entry(face).or_default().push(touch(tets, surface, number as u32, face));
        }
    }
    let boundary = (0..tets.faces.len()).filter(|&face| tets.cells_of[face][1] == NONE);
    let side = |face: usize| BoundSide {
        corners: tets.faces[face],
        held: held[face].clone(),
        load: loads.get(&(face as u32)).copied().unwrap_or_default(),
        touches: touches.remove(&(face as u32)).unwrap_or_default(),
    };
    boundary.map(side).collect()
}

fn touch(tets: &Tets, surface: &Surface, obstacle: u32, face: u32) -> Touch {
    let corners = tets.faces[face as usize];
    let at = surface.on_face(tets, face);
    // In linear cells middles are not looked at.
    let middles = if tets.quadratic() { tets.middles_of(face) } else { corners };
    let ([a, b, c], [d, e, f]) = (corners, middles);
    let nodes = [a, b, c, d, e, f].map(|node| surface.kinematics(node));
    Touch {
        obstacle,
        pressure: at.map(|at| at.pressure),
        shear: at.map(|at| at.shear),
        law: corners.map(|node| law(surface.limit(node))),
        opening: nodes.map(|node| node.0),
        slip: nodes.map(|node| node.1),
        reference: nodes.map(|node| node.2),
    }
}

/// Coefficient of friction and largest shear, infinite where there is none.
fn law(limit: Limit) -> [f64; 2] {
    match limit {
        Limit::None => [f64::INFINITY, 0.0],
        Limit::Given(most) => [f64::INFINITY, most],
        Limit::Coulomb(coefficient) => [coefficient, f64::INFINITY],
        Limit::Limited { coefficient, most } => [coefficient, most],
    }
}

fn stiffness(law: &Law) -> [Voigt; 6] {
    // The stress of a unit strain is a column, and the matrix is symmetric.
    std::array::from_fn(|k| law.stress(&std::array::from_fn(|i| f64::from(u8::from(i == k)))))
}
