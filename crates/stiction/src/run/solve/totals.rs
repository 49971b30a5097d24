//! Forces, counts and areas of contact, over all pairs and for each.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Outcome;
use super::record::{or_nan, or_nans};
use super::tractions::{Tractions, tractions};
use crate::friction::PointState;
use crate::mesh::v3::norm;
use crate::run::pose::Prepared;
use crate::run::pose::activity::within;
use crate::run::pose::frames::{PointFrame, frames};

/// Sums and extremes over contact points.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Totals {
    /// Number of points.
    pub points: usize,
    /// Points that are open.
    pub open: usize,
    /// Points that stick.
    pub stick: usize,
    /// Points that slip.
    pub slip: usize,
    /// Area of the points that are open, length squared.
    pub open_area: f64,
    /// Area of the points that stick.
    pub stick_area: f64,
    /// Area of the points that slip.
    pub slip_area: f64,
    /// Sum of `lambda_n`, with what points carry for dropped neighbours.
    #[serde(deserialize_with = "or_nan")]
    pub normal_force: f64,
    /// Resultant of friction as a force on the body; of a pair, on the body of `on`.
    #[serde(deserialize_with = "or_nans")]
    pub tangential_force: [f64; 3],
    /// The largest normal force of a point, newton.
    pub max_lambda_n: f64,
    /// Largest `|lambda_t|`.
    pub max_lambda_t: f64,
    /// The largest pressure at a contact point.
    pub max_pressure: f64,
    /// Where it is.
    pub max_pressure_at: Option<[f64; 3]>,
    /// The largest shear at a contact point.
    pub max_shear: f64,
    /// The largest pressure at a node of the other surface, whose means those at points are; zero against obstacles. At nodes
    /// just beyond the rim, of which hardly anything is covered, it overshoots.
    #[serde(default)]
    pub max_other_pressure: f64,
}

/// The totals of all pairs together.
pub fn totals(prepared: &Prepared, outcome: &Outcome) -> Totals {
    all_totals(prepared, outcome).0
}

/// The totals of each pair with its name.
pub fn pair_totals(prepared: &Prepared, outcome: &Outcome) -> Vec<(String, Totals)> {
    all_totals(prepared, outcome).1
}

/// The totals of all pairs together, and of each with its name.
pub(super) fn all_totals(prepared: &Prepared, outcome: &Outcome) -> (Totals, Vec<(String, Totals)>) {
    let frames = frames(prepared);
    let tractions = tractions(prepared, outcome, &frames);
    let gives_way = gives_way(prepared);
    let of = |points: Range<usize>| {
        let counted: Vec<usize> = points.filter(|&j| !gives_way[j]).collect();
        over(prepared, outcome, &frames, &tractions, &counted)
    };
    // Points of equations are of no surface.
    let surfaces = prepared.problem.labels.pairs.iter().take(prepared.surfaces.len());
    let received = tractions.masters.iter().map(|nodes| nodes.iter().flatten().fold(0.0, |a: f64, t| a.max(t[0])));
    let pairs = surfaces.zip(received).map(|(pair, received)| {
        (pair.name.clone(), Totals { max_other_pressure: received, ..of(pair.points.clone()) })
    });
    let pairs: Vec<(String, Totals)> = pairs.collect();
    let received = pairs.iter().fold(0.0, |a: f64, pair| a.max(pair.1.max_other_pressure));
    (Totals { max_other_pressure: received, ..of(0..prepared.facts.points) }, pairs)
}

/// Whether a point gives way to others now, which have its area.
fn gives_way(prepared: &Prepared) -> Vec<bool> {
    let Prepared { problem, facts, loading, .. } = prepared;
    let mut gives_way = vec![false; problem.points()];
    for (contact, pair) in facts.contacts.iter().zip(&problem.labels.pairs) {
        let now = contact.surface.out.iter().filter(|(_, period)| within(*period, loading.t));
        now.for_each(|(place, _)| gives_way[pair.points.start + place] = true);
    }
    gives_way
}

fn over(
    prepared: &Prepared,
    outcome: &Outcome,
    frames: &[PointFrame],
    tractions: &Tractions,
    points: &[usize],
) -> Totals {
    let (m, lambda) = (prepared.problem.points(), &outcome.solution.lambda);
    let mut t = Totals { points: points.len(), ..Totals::default() };
    for &j in points {
        let (area, share) = (prepared.problem.labels.area[j], prepared.problem.labels.unity_sum[j]);
        let (count, sum) = match outcome.solution.states[j] {
            PointState::Open => (&mut t.open, &mut t.open_area),
            PointState::Stick => (&mut t.stick, &mut t.stick_area),
            PointState::Slip => (&mut t.slip, &mut t.slip_area),
        };
        *count += 1;
        *sum += area * share;
        let (normal, friction) = (lambda[j], [lambda[m + j], lambda[2 * m + j]]);
        let size = friction[0].hypot(friction[1]);
        t.normal_force += share * normal;
        let along = frames[j].tangential(friction);
        (0..3).for_each(|c| t.tangential_force[c] -= frames[j].sign * share * along[c]);
        t.max_lambda_n = t.max_lambda_n.max(normal);
        t.max_lambda_t = t.max_lambda_t.max(size);
        let [pressure, shear @ ..] = tractions.points[j];
        t.max_shear = t.max_shear.max(norm(shear));
        if pressure > t.max_pressure {
            t.max_pressure = pressure;
            t.max_pressure_at = prepared.mesh.nodes.get(frames[j].node as usize).copied();
        }
    }
    t
}
