//! Motions that the facets of curved surfaces alone resist.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::contact::equilibrium::in_words;
use crate::contact::facets::{Faceted, held_by_facets};
use crate::contact::{Counterpart, Friction};
use crate::fem::nodal_normals;
use crate::friction::{PointState, Solution, Status};
use crate::mesh::v3::{V3, add, cross, norm, scale, unit};
use crate::run::pose::Prepared;
use crate::run::pose::frames::{entries, frames};

/// See [`Faceted`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FacetedRecord {
    /// The motion, in words.
    pub motion: String,
    /// Degrees.
    pub slope: f64,
    /// Degrees.
    pub angle: f64,
}

impl FacetedRecord {
    pub(crate) fn of(motion: String, found: &Faceted) -> FacetedRecord {
        FacetedRecord { motion, slope: found.slope.to_degrees(), angle: found.angle.to_degrees() }
    }
}

/// Whether friction resists no more where it `slips` or there is none.
pub(crate) fn slides(law: Friction, slips: bool) -> bool {
    law == Friction::None || slips
}

/// The motion of an answer that nothing but facets holds; none where nothing is solved.
pub(crate) fn faceted(prepared: &Prepared, solution: &Solution) -> Option<FacetedRecord> {
    let (problem, motions) = (&prepared.problem, &prepared.motions);
    if motions.is_empty() || solution.status != Status::Solved {
        return None;
    }
    let slides = |j: usize| slides(problem.contact.friction[j], solution.states[j] == PointState::Slip);
    let found = held_by_facets(problem, motions, &solution.lambda, &slides, &angles(prepared))?;
    Some(FacetedRecord::of(in_words(problem, motions, &found.alpha), &found))
}

/// By how much the normals of both surfaces of a pair differ at each point, radians: on the other one that of its nodes, weighted as these count.
/// On an obstacle of triangles by how much its normals are off those of the smooth surface; zero on others, whose normals are exact.
fn angles(prepared: &Prepared) -> Vec<f64> {
    let (mut angles, frames) = (vec![0.0; prepared.problem.points()], frames(prepared));
    for (surface, pair) in prepared.surfaces.iter().zip(&prepared.problem.labels.pairs) {
        let master = match &surface.against {
            Counterpart::Surface(master) => master,
            Counterpart::Obstacle(obstacle) => {
                let of_point = |j: usize| obstacle.normal_error(prepared.mesh.nodes[frames[j].node as usize]);
                pair.points.clone().for_each(|j| angles[j] = of_point(j));
                continue;
            }
        };
        let normals: HashMap<u32, V3> = nodal_normals(&prepared.mesh, &master.faces).into_iter().collect();
        for j in pair.points.clone() {
            let others = entries(prepared, j).filter(|(dof, _)| dof / 3 != frames[j].node);
            let others = others.filter_map(|(dof, value)| Some((*normals.get(&(dof / 3))?, value.abs())));
            angles[j] = between_normals(frames[j].normal, others);
        }
    }
    angles
}

/// The angle between a normal and others with their weights, radians; zero where there is none.
pub(crate) fn between_normals(own: V3, others: impl Iterator<Item = (V3, f64)>) -> f64 {
    let sum = others.fold([0.0; 3], |sum, (normal, weight)| add(sum, scale(weight, normal)));
    let both = unit(own).zip(unit(sum));
    both.map_or(0.0, |(own, other)| norm(cross(own, other)).min(1.0).asin())
}
