//! What the first mesh does not tell of where curved surfaces of contact are. Finer meshes have the shape of the first one.

use std::collections::HashMap;

use super::values::changed_shape;
use crate::contact::{Counterpart, InitialGap, Pair, SurfaceFriction};
use crate::friction::PointState;
use crate::io::text::number;
use crate::mesh::kinks;
use crate::mesh::v3::{add, norm, scale};
use crate::run::pose::Prepared;
use crate::run::pose::frames::frames;
use crate::run::solve::Outcome;

/// On the safe side of what kinks and gaps say of it.
const SAFETY: f64 = 1.5;
/// Gaps that are open by more than this part of what contact changes the shape of its surface by leave area and pressures open: with 0.21 the
/// area of a fit whose rings have eight and six cells a quarter is off by 0.26.
const MOST: f64 = 0.15;
/// From this part on a warning says so.
const WORTH_A_WORD: f64 = 0.1;

/// What is open of the gaps of each contact of a case that is posed on its first mesh, length.
pub(super) fn shapes(prepared: &Prepared) -> Vec<f64> {
    (0..prepared.surfaces.len()).map(|i| shape(prepared, i)).collect()
}

fn shape(prepared: &Prepared, i: usize) -> f64 {
    let (mesh, surface) = (&prepared.mesh, &prepared.surfaces[i]);
    if surface.friction == SurfaceFriction::Bonded {
        return 0.0;
    }
    match &surface.against {
        Counterpart::Obstacle(_) => SAFETY * kinks(mesh, &surface.faces),
        Counterpart::Surface(master) => match master.gap {
            InitialGap::Closed | InitialGap::Uniform(_) => 0.0,
            // Faces that match are off by as much on both sides.
            _ => {
                let off = kinks(mesh, &surface.faces) + kinks(mesh, &master.faces);
                SAFETY * off.min(change_over_a_face(prepared, i))
            }
        },
    }
}

/// By how much gaps differ at the nodes of a face, in the mean; length.
fn change_over_a_face(prepared: &Prepared, i: usize) -> f64 {
    let labels = &prepared.problem.labels;
    let Some(pair) = labels.pairs.get(i) else { return 0.0 };
    // Gaps are those of rows of `B`, times what their functions sum up to.
    let gaps = pair.points.clone().map(|j| prepared.problem.contact.gap[j] / labels.unity_sum[j]);
    let gap: HashMap<u32, f64> = prepared.facts.contacts[i].surface.nodes.iter().copied().zip(gaps).collect();
    let (mut sum, mut area) = (0.0, 0.0);
    for &face in &prepared.surfaces[i].faces {
        let here = prepared.mesh.faces[face as usize].nodes().iter().filter_map(|node| gap.get(node));
        let [low, high] = here.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &gap| [a.min(gap), b.max(gap)]);
        if low < high {
            sum += (high - low) * prepared.mesh.face_area(face as usize);
        }
        area += prepared.mesh.face_area(face as usize);
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

/// What this leaves open of an answer.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Open {
    /// Of how far the bodies are from one another, length.
    pub gap: f64,
    /// Of the energy: the forces times that.
    pub energy: f64,
    /// Of the normal force, as a part of it: what of it is no resultant grows with the square of the width of contact.
    pub force: f64,
    /// Of area and pressures, as a part of them; infinite where it is too much to be told.
    pub area: f64,
    /// Of the gap, over what contact changes the shape of its surface by.
    pub part: f64,
}

/// For each contact.
pub(super) fn open(prepared: &Prepared, outcome: &Outcome, shapes: &[f64]) -> Vec<Open> {
    let (frames, changes) = (frames(prepared), changed_shape(prepared, outcome));
    let of_pair = |((pair, &gap), &change): ((&Pair, &f64), &f64)| {
        let closed = || pair.points.clone().filter(|&j| outcome.solution.states[j] != PointState::Open);
        let force = |j: usize| outcome.solution.lambda[j].abs();
        let total: f64 = closed().map(force).sum();
        if gap == 0.0 || total == 0.0 {
            return Open::default();
        }
        let resultant = norm(closed().fold([0.0; 3], |sum, j| add(sum, scale(force(j), frames[j].normal))));
        let part = gap / change.max(f64::MIN_POSITIVE);
        Open {
            gap,
            energy: total * gap,
            force: 2.0 * part.min(0.5) * (1.0 - resultant / total).max(0.0),
            area: if part > MOST { f64::INFINITY } else { part },
            part,
        }
    };
    prepared.problem.labels.pairs.iter().zip(shapes).zip(&changes).map(of_pair).collect()
}

/// What to say of it.
pub(super) fn warnings(prepared: &Prepared, outcome: &Outcome, shapes: &[f64]) -> Vec<String> {
    let open = open(prepared, outcome, shapes);
    let rough = prepared.problem.labels.pairs.iter().zip(&open).filter(|(_, open)| open.part > WORTH_A_WORD);
    let text = |(pair, open): (&Pair, &Open)| {
        format!(
            "contact \"{}\": faces of the first mesh are up to {} off the smooth surfaces that they stand for, where contact changes their shape \
             by {}, and finer meshes keep that: begin with smaller faces there, or with quadratic cells whose nodes lie on the surface, or \
             give the gap (`gap` under [[contact]])",
            pair.name,
            number(open.gap),
            number(open.gap / open.part)
        )
    };
    rough.map(text).collect()
}
