//! What pictures and the report show of an answer on several ranks: the boundary of the bodies and the contact surfaces, gathered by
//! rank 0, which has nothing else of the others.

use std::collections::HashMap;
use std::path::Path;

use super::local::Local;
use super::share::name;
use super::solve::RankedAnswer;
use super::write::{AtPoint, ForPeople};
use crate::Error;
use crate::fem::{Voigt, von_mises};
use crate::io::units::Units;
use crate::mesh::v3::V3;
use crate::mesh::{ascending, border};
use crate::ranks::{Ranks, Wire, gather, put, take};
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
    /// The contact surfaces that carry points; nodes by their places in these lists.
    pub surfaces: Vec<SurfaceFields>,
}

/// Numbers of a node of the boundary: place, displacement, von Mises stress, error.
type OnBoundary = [f64; 8];

/// Those of a node of a contact surface: place, pressure, shear, slip, gap, force, state.
type OnContact = [f64; 15];

impl Shown {
    /// Those of an answer, at rank 0, if any are wanted; `stress` is that of each cell here, `points` are those of contact.
    pub(super) fn gathered(
        answer: &RankedAnswer,
        (stress, points): (&[Voigt], &[AtPoint]),
        wanted: ForPeople,
        ranks: &dyn Ranks,
    ) -> Option<Shown> {
        if wanted == ForPeople::default() {
            return None;
        }
        let Local { piece, problem, signs, .. } = &answer.local;
        let mut message = Vec::new();
        let von_mises: Vec<f64> = stress.iter().map(von_mises).collect();
        let von_mises = at_nodes(&piece.mesh, &von_mises);
        let mean = answer.summary.answer.discretisation_error.unwrap_or(0.0);
        let of_cells: Vec<f32> = answer.error.iter().map(|&error| error as f32).collect();
        let error = node_error(&piece.mesh, &of_cells, mean).filter(|_| !of_cells.is_empty());
        let on_boundary = |v: usize| -> OnBoundary {
            let ([x, y, z], [u, v_, w]) = (piece.mesh.nodes[v], answer.u[v]);
            [x, y, z, u, v_, w, von_mises[v], error.as_ref().map_or(f64::NAN, |error| error[v])]
        };
        put_part(&answer.local, piece.mesh.faces.iter().map(|face| face.nodes()).collect(), &on_boundary, &mut message);
        for k in 0..signs.len() {
            let of_surface = points.iter().filter(|point| point.surface == k);
            let here: HashMap<usize, &AtPoint> = of_surface.map(|point| (point.node as usize, point)).collect();
            let on_contact = |v: usize| -> OnContact {
                let [x, y, z] = piece.mesh.nodes[v];
                let Some(AtPoint {
                    pressure, shear: [a, b, c], slip: [d, e, f], gap, force: [g, h, i], status, ..
                }) = here.get(&v)
                else {
                    let mut unknown = [f64::NAN; 15];
                    unknown[..3].copy_from_slice(&[x, y, z]);
                    unknown[11..].copy_from_slice(&[0.0, 0.0, 0.0, -1.0]);
                    return unknown;
                };
                [x, y, z, *pressure, *a, *b, *c, *d, *e, *f, *gap, *g, *h, *i, f64::from(*status)]
            };
            let faces = piece.mesh.group(&name("contact", k)).map_or(&[][..], |group| &group.faces);
            let faces = faces.iter().map(|&face| piece.mesh.faces[face as usize].nodes()).collect();
            put_part(&answer.local, faces, &on_contact, &mut message);
        }
        let all = gather(ranks, message)?;
        let mut from: Vec<&[u8]> = all.iter().map(|message| &message[..]).collect();
        let (numbers, nodes, faces) = joined::<OnBoundary>(&mut from);
        let surface = |k: usize| {
            let of_whole = joined::<OnContact>(&mut from);
            surface(k, problem.labels.pairs.get(k).map_or("", |pair| &pair.name), &of_whole, &numbers)
        };
        let surfaces = (0..signs.len()).map(surface).filter(|surface| !surface.faces.is_empty()).collect();
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
        let view = view_of_surfaces(nodes, &self.faces, &self.surfaces, Units::of(summary.units.as_deref()))?;
        write_page(folder, summary, &case_in(folder)?, &view).map(|_| ())
    }
}

/// Appends own nodes of `faces`, by their numbers in the whole, with what is known of them, and those faces whose first node is own.
fn put_part<T: Wire>(local: &Local, faces: Vec<&[u32]>, known: &dyn Fn(usize) -> T, to: &mut Vec<u8>) {
    let is_own = |v: u32| local.division.is_own(v);
    let number = |v: u32| local.piece.nodes[v as usize];
    let nodes = ascending(faces.iter().flat_map(|nodes| *nodes).copied().filter(|&v| is_own(v)));
    put(&nodes.iter().map(|&v| number(v)).collect::<Vec<u64>>(), to);
    put(&nodes.iter().map(|&v| known(v as usize)).collect::<Vec<T>>(), to);
    let own: Vec<&[u32]> = faces.into_iter().filter(|nodes| is_own(nodes[0])).collect();
    put(&own.iter().map(|nodes| nodes.len() as u8).collect::<Vec<u8>>(), to);
    put(&own.iter().flat_map(|nodes| *nodes).map(|&v| number(v)).collect::<Vec<u64>>(), to);
}

/// Numbers of nodes in the whole, ascending, what is known of them, and faces by places among these.
type Joined<T> = (Vec<u64>, Vec<T>, Vec<Vec<u32>>);

/// What [`put_part`] has put into the messages of all ranks.
fn joined<T: Wire>(from: &mut [&[u8]]) -> Joined<T> {
    let (mut nodes, mut faces): (Vec<(u64, T)>, Vec<Vec<u64>>) = (Vec::new(), Vec::new());
    for message in from {
        let (numbers, known): (Vec<u64>, Vec<T>) = (take(message), take(message));
        nodes.extend(numbers.into_iter().zip(known));
        let (sizes, numbers): (Vec<u8>, Vec<u64>) = (take(message), take(message));
        let mut numbers = numbers.into_iter();
        faces.extend(sizes.iter().map(|&size| numbers.by_ref().take(size.into()).collect()));
    }
    nodes.sort_by_key(|node| node.0);
    let (numbers, known): (Vec<u64>, Vec<T>) = nodes.into_iter().unzip();
    let faces = faces.iter().map(|face| face.iter().map(|&number| place(&numbers, number)).collect()).collect();
    (numbers, known, faces)
}

fn place(numbers: &[u64], number: u64) -> u32 {
    numbers.partition_point(|&other| other < number) as u32
}

/// The fields of a contact surface whose nodes have these numbers; `boundary` are those of all nodes that are shown.
fn surface(pair: usize, name: &str, (numbers, nodes, faces): &Joined<OnContact>, boundary: &[u64]) -> SurfaceFields {
    let vectors = |first: usize| nodes.iter().map(|n| [n[first], n[first + 1], n[first + 2]]).collect::<Vec<V3>>();
    SurfaceFields {
        name: name.into(),
        pair,
        points: vectors(0),
        faces: faces.clone(),
        borders: faces.iter().map(|nodes| border(nodes)).collect(),
        nodes: numbers.iter().map(|&number| place(boundary, number) as i32).collect(),
        pressure: nodes.iter().map(|n| n[3]).collect(),
        shear: vectors(4),
        slip: vectors(7),
        gap: nodes.iter().map(|n| n[10]).collect(),
        lambda: vectors(11),
        status: nodes.iter().map(|n| n[14] as i32).collect(),
        ..SurfaceFields::default()
    }
}
