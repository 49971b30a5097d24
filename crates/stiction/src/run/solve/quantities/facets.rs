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

/// The motion of an answer that nothing but facets holds; none where nothing is solved.
pub(crate) fn faceted(prepared: &Prepared, solution: &Solution) -> Option<FacetedRecord> {
    let (problem, motions) = (&prepared.problem, &prepared.motions);
    if motions.is_empty() || solution.status != Status::Solved {
        return None;
    }
    let slides = |j: usize| problem.contact.friction[j] == Friction::None || solution.states[j] == PointState::Slip;
    let Faceted { alpha, slope, angle } =
        held_by_facets(problem, motions, &solution.lambda, &slides, &angles(prepared))?;
    let motion = in_words(problem, motions, &alpha);
    Some(FacetedRecord { motion, slope: slope.to_degrees(), angle: angle.to_degrees() })
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
            let mut sum = [0.0; 3];
            for (dof, value) in entries(prepared, j).filter(|(dof, _)| dof / 3 != frames[j].node) {
                if let Some(&normal) = normals.get(&(dof / 3)) {
                    sum = add(sum, scale(value.abs(), normal));
                }
            }
            if let (Some(own), Some(other)) = (unit(frames[j].normal), unit(sum)) {
                angles[j] = norm(cross(own, other)).min(1.0).asin();
            }
        }
    }
    angles
}
