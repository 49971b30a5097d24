//! Fields over the body and over the contact surfaces, in global axes.

use rayon::prelude::*;

use crate::contact::Friction;
use crate::fem::{Solid, cell_stress_as, full_displacement, von_mises};
use crate::mesh::v3::{add, norm};
use crate::run::pose::Prepared;
use crate::run::pose::frames::PointFrame;
use crate::run::solve::Outcome;
use crate::run::solve::quantities::reaction;
use crate::run::solve::tractions::Tractions;

/// Fields over the whole body, in global axes.
#[derive(Debug, Clone)]
pub struct BodyFields {
    /// Of each node, length.
    pub displacement: Vec<[f64; 3]>,
    /// Force of the supports on the body at each node, springs included, newton; zero away from them.
    pub reaction: Vec<[f64; 3]>,
    /// xx, yy, zz, xy, yz, xz of each cell; in single precision, beyond which a mean over a cell has no meaning.
    pub stress: Vec<[f32; 6]>,
    /// Von Mises stress of each cell.
    pub von_mises: Vec<f32>,
    /// Estimated error of the stress of each cell, see [`Estimate::by_cell`](crate::accuracy::Estimate::by_cell); empty
    /// without an estimate.
    pub error: Vec<f32>,
    /// Mean over each cell of the stress whose error [`Bound::mean_error`](crate::accuracy::Bound::mean_error) bounds; empty
    /// without a bound.
    pub mean_stress: Vec<[f32; 6]>,
}

/// The fields over the body of an answer.
pub fn body(prepared: &Prepared, outcome: &Outcome) -> BodyFields {
    let Prepared { mesh, materials, material_of_cell, model, .. } = prepared;
    let u = full_displacement(model, &outcome.solution.u);
    let reaction = reaction(prepared, outcome);
    let solid = Solid { mesh, materials, material_of_cell };
    let single = |stress: [f64; 6]| (stress.map(|s| s as f32), von_mises(&stress) as f32);
    let (stress, von_mises) = cell_stress_as(&solid, &u, &prepared.loading.initial.strain, single).unzip();
    let displacement = u.as_chunks().0.iter().map(|&u| add(u, prepared.loading.travel)).collect();
    let error = outcome.estimate.as_ref().map_or(Vec::new(), |estimate| estimate.by_cell());
    let error = error.into_iter().map(|error| error as f32).collect();
    let mean = |stress: &[f64; 6]| stress.map(|s| s as f32);
    let bound = outcome.bound.as_ref().and_then(|bound| bound.as_ref().ok());
    let mean_stress = bound.map_or(Vec::new(), |bound| bound.mean_stress.iter().map(mean).collect());
    BodyFields { displacement, reaction, stress, von_mises, error, mean_stress }
}

/// Which of the two surfaces of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// That with the contact points.
    #[default]
    Slave,
    /// The other one, where it is a surface of a body.
    Master,
}

/// Fields over the nodes of one contact surface. Nodes that carry no contact point have the status -1, no force, and
/// NaN where nothing is known.
#[derive(Debug, Clone, Default)]
pub struct SurfaceFields {
    /// Name of the contact.
    pub name: String,
    /// Number of the pair.
    pub pair: usize,
    /// Which of its two surfaces.
    pub side: Side,
    /// Coordinates of the nodes, length.
    pub points: Vec<[f64; 3]>,
    /// Faces by indices into `points`: corners, then the middles of edges.
    pub faces: Vec<Vec<u32>>,
    /// The same in the order of their border.
    #[cfg_attr(not(feature = "plots"), expect(dead_code, reason = "only pictures show them"))]
    pub(crate) borders: Vec<Vec<u32>>,
    /// Number of the node in the mesh.
    pub nodes: Vec<i32>,
    /// The area that pressure and shear of the node act on: those of all nodes add up to the surface.
    pub area: Vec<f64>,
    /// Unit normal at each contact point, out of the body it belongs to.
    pub normal: Vec<[f64; 3]>,
    /// Force over area at each node, positive in compression: that of the point against an obstacle, between bodies a mean over
    /// the nodes of the other surface that it shares area with.
    pub pressure: Vec<f64>,
    /// What the body exerts on its counterpart along its surface, force over area.
    pub shear: Vec<[f64; 3]>,
    /// Sliding of the body over its counterpart, with load steps that of the last one; length.
    pub slip: Vec<[f64; 3]>,
    /// The same since the start of the first step.
    pub slid: Vec<[f64; 3]>,
    /// Work of friction in the last load step, energy per area.
    pub step_work: Vec<f64>,
    /// Pressure times slip in the last load step, energy per area.
    pub step_pressed: Vec<f64>,
    /// The gap that is left; of a bonded surface the opening.
    pub gap: Vec<f64>,
    /// 0 open, 1 stick, 2 slip, -1 no contact point.
    pub status: Vec<i32>,
    /// Shear strength without pressure that is left, stress; NaN where the law has none.
    pub cohesion: Vec<f64>,
    /// Force of the body on its counterpart, newton.
    pub lambda: Vec<[f64; 3]>,
}

impl SurfaceFields {
    fn place(&self, frame: &PointFrame) -> usize {
        self.nodes.partition_point(|&node| node < frame.node as i32)
    }
}

/// The fields of each contact surface, from frames and tractions of all points.
pub(crate) fn surfaces_with(
    prepared: &Prepared,
    outcome: &Outcome,
    frames: &[PointFrame],
    tractions: &Tractions,
) -> Vec<SurfaceFields> {
    let gap_and_slip = prepared.problem.gap_and_slip(&outcome.solution.u);
    let pairs = prepared.surfaces.iter().zip(&prepared.problem.labels.pairs).enumerate();
    pairs
        .map(|(number, (surface, pair))| {
            let mut fields = empty(prepared, &surface.name, &surface.faces);
            fields.pair = number;
            // Of points on one node that take part at different times that which does now is shown.
            let out = &prepared.problem.contact.out;
            let (last, first): (Vec<usize>, Vec<usize>) =
                pair.points.clone().partition(|&j| out.binary_search(&(j as u32)).is_err());
            first.into_iter().chain(last).for_each(|j| {
                fill(&mut fields, prepared, outcome, &frames[j], &gap_and_slip, j);
                let (at, [pressure, shear @ ..]) = (fields.place(&frames[j]), tractions.points[j]);
                fields.pressure[at] = pressure;
                fields.shear[at] = shear.map(|shear| frames[j].sign * shear);
                [fields.step_work[at], fields.step_pressed[at]] = tractions.rubbing[j];
            });
            fields
        })
        .collect()
}

/// Nothing known on these faces of the mesh.
pub(crate) fn empty(prepared: &Prepared, name: &str, faces: &[u32]) -> SurfaceFields {
    let mesh = &prepared.mesh;
    let nodes = mesh.face_nodes(faces);
    let local = |node: &u32| nodes.partition_point(|other| other < node) as u32;
    let count = nodes.len();
    SurfaceFields {
        name: name.into(),
        pair: 0,
        side: Side::Slave,
        points: nodes.iter().map(|&node| mesh.nodes[node as usize]).collect(),
        faces: faces.iter().map(|&f| mesh.faces[f as usize].nodes().iter().map(local).collect()).collect(),
        borders: faces.iter().map(|&f| mesh.faces[f as usize].border().iter().map(local).collect()).collect(),
        area: vec![f64::NAN; count],
        normal: vec![[f64::NAN; 3]; count],
        pressure: vec![f64::NAN; count],
        shear: vec![[f64::NAN; 3]; count],
        slip: vec![[f64::NAN; 3]; count],
        slid: vec![[f64::NAN; 3]; count],
        step_work: vec![f64::NAN; count],
        step_pressed: vec![f64::NAN; count],
        gap: vec![f64::NAN; count],
        status: vec![-1; count],
        cohesion: vec![f64::NAN; count],
        lambda: vec![[0.0; 3]; count],
        nodes: nodes.iter().map(|&node| node as i32).collect(),
    }
}

fn fill(
    fields: &mut SurfaceFields,
    prepared: &Prepared,
    outcome: &Outcome,
    frame: &PointFrame,
    gap_and_slip: &[f64],
    j: usize,
) {
    let (problem, lambda) = (&prepared.problem, &outcome.solution.lambda);
    let m = problem.points();
    let at = fields.place(frame);
    let (normal, friction) = (lambda[j], frame.tangential([lambda[m + j], lambda[2 * m + j]]));
    let share = problem.labels.unity_sum[j];
    let scale = frame.sign / share;
    fields.area[at] = problem.labels.area[j] * share;
    let length = norm(frame.normal);
    fields.normal[at] = frame.normal.map(|n| n / length);
    fields.slip[at] = frame.tangential([-gap_and_slip[m + j], -gap_and_slip[2 * m + j]]).map(|slip| scale * slip);
    fields.gap[at] = gap_and_slip[j] / share;
    let before = &prepared.loading.slid;
    fields.slid[at] = frame
        .tangential([before[j] - gap_and_slip[m + j], before[m + j] - gap_and_slip[2 * m + j]])
        .map(|slip| scale * slip);
    if let Friction::Cohesive { cohesion, .. } = problem.contact.friction[j] {
        fields.cohesion[at] = cohesion / problem.labels.area[j];
    }
    fields.status[at] = outcome.solution.states[j].code().into();
    fields.lambda[at] = [0, 1, 2].map(|c| frame.sign * share * (normal * frame.normal[c] + friction[c]));
}
