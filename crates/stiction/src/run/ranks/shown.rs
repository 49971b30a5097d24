//! What pictures and the report show of an answer on several ranks: the boundary of the bodies and the contact surfaces, gathered by
//! rank 0, which has nothing else of the others.

use std::path::Path;

use super::solve::RankedAnswer;
use super::surfaces::{joined, put_part};
use super::write::ForPeople;
use crate::Error;
use crate::fem::{Voigt, von_mises};
use crate::io::units::Units;
use crate::mesh::border;
use crate::mesh::v3::V3;
use crate::ranks::{Ranks, gather};
use crate::run::results::page::{case_in, write_page};
use crate::run::results::pictures::{self, draw, node_error};
use crate::run::results::view::{at_nodes, view_of_surfaces};
use crate::run::results::{Summary, SurfaceFields};

/// The surfaces of all ranks.
#[derive(Debug, Default)]
pub(super) struct Shown {
    /// Nodes of the boundary: places and displacements, length, and von Mises stress.
    pub points: Vec<V3>,
    pub displacement: Vec<V3>,
    pub von_mises: Vec<f64>,
    /// Estimated error at each of them, percent; none without an estimate or any error.
    pub error: Option<Vec<f64>>,
    /// Nodes of each face of the boundary by their places in these lists: corners, then the middles of edges.
    pub faces: Vec<Vec<u32>>,
    /// The contact surfaces; nodes by their places in these lists.
    pub surfaces: Vec<SurfaceFields>,
}

/// Numbers of a node of the boundary: place, displacement, von Mises stress, error.
type OnBoundary = [f64; 8];

impl Shown {
    /// Those of an answer, at rank 0, if any are wanted; `stress` is that of each cell here, `surfaces` are those of contact, at rank 0.
    pub(super) fn gathered(
        answer: &RankedAnswer,
        stress: &[Voigt],
        surfaces: Option<&[SurfaceFields]>,
        wanted: ForPeople,
        ranks: &dyn Ranks,
    ) -> Option<Shown> {
        if wanted == ForPeople::default() {
            return None;
        }
        let piece = &answer.local.piece;
        let mut message = Vec::new();
        let von_mises: Vec<f64> = stress.iter().map(von_mises).collect();
        let von_mises = at_nodes(&piece.mesh, &von_mises);
        let mean = answer.summary.answer.discretisation_error.unwrap_or(0.0);
        let of_cells: Vec<f32> = answer.error.iter().map(|&error| error as f32).collect();
        let error = node_error(&piece.mesh, &of_cells, mean).filter(|_| !of_cells.is_empty());
        let on_boundary = |v: u32| -> OnBoundary {
            let v = v as usize;
            let ([x, y, z], [u, v_, w]) = (piece.mesh.nodes[v], answer.u[v]);
            [x, y, z, u, v_, w, von_mises[v], error.as_ref().map_or(f64::NAN, |error| error[v])]
        };
        let faces: Vec<Vec<u32>> = piece.mesh.faces.iter().map(|face| face.nodes().to_vec()).collect();
        put_part(&answer.local, &faces, &on_boundary, &mut message);
        let all = gather(ranks, message)?;
        let mut from: Vec<&[u8]> = all.iter().map(|message| &message[..]).collect();
        let (numbers, nodes, faces) = joined::<OnBoundary>(&mut from);
        let place = |&number: &i32| numbers.partition_point(|&other| other < number as u64) as i32;
        let by_places = |of: &SurfaceFields| {
            let nodes = of.nodes.iter().map(place).collect();
            SurfaceFields { nodes, ..of.clone() }
        };
        let surfaces = surfaces.unwrap_or_default().iter().filter(|of| !of.faces.is_empty()).map(by_places).collect();
        Some(Shown {
            points: nodes.iter().map(|n| [n[0], n[1], n[2]]).collect(),
            displacement: nodes.iter().map(|n| [n[3], n[4], n[5]]).collect(),
            von_mises: nodes.iter().map(|n| n[6]).collect(),
            error: (mean > 0.0).then(|| nodes.iter().map(|n| n[7]).collect()),
            faces,
            surfaces,
        })
    }

    /// Draws the pictures of the answer and returns their names.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(super) fn draw(&self, answer: &RankedAnswer, folder: &Path) -> Result<Vec<String>, Error> {
        let summary = &answer.summary;
        let borders: Vec<Vec<u32>> = self.faces.iter().map(|nodes| border(nodes)).collect();
        let error = self.error.clone().zip(summary.answer.discretisation_error);
        let shown = pictures::Shown {
            title: &summary.title,
            units: Units::of(summary.units.as_deref()),
            points: &self.points,
            borders: &borders,
            displacement: &self.displacement,
            error,
            surfaces: &self.surfaces,
            convergence: (summary.answer.contact.points > 0)
                .then_some((&answer.history, summary.answer.certificate.tolerance)),
            steps: summary.steps.iter().map(|step| (step.t, &step.answer.contact, Some(&step.balance))).collect(),
        };
        draw(folder, &shown)
    }

    /// Writes `report.html` into the folder of these results.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write_report(&self, summary: &Summary, folder: &Path) -> Result<(), Error> {
        let nodes = (&self.points[..], &self.displacement[..], &self.von_mises[..]);
        let view = view_of_surfaces(
            nodes,
            &self.faces,
            &self.surfaces,
            !summary.steps.is_empty(),
            Units::of(summary.units.as_deref()),
        )?;
        write_page(folder, summary, &case_in(folder)?, &view).map(|_| ())
    }
}
