//! The files of a run on several ranks: a piece from each, and from rank 0 what names them.

use std::path::Path;

use super::bolts::strain;
use super::hash::Hash;
use super::local::Local;
use super::record::{of_all, take_cost};
use super::share::name;
use super::shown::Shown;
use super::solve::{RankedAnswer, axes};
use super::tractions::shear as shear_of;
use crate::Error;
use crate::fem::{Solid, Voigt, cell_stress, von_mises};
use crate::io::pieces::{
    Head, NamedPiece, is_piece, other_solution_name, problem_name, solution_name, write_problem_piece,
    write_solution_piece,
};
use crate::io::pvtu::write_pieces;
use crate::io::vtu::{self, Array, Grid, face_code};
use crate::io::{checksum, folder};
use crate::mesh::v3::{V3, add, scale};
use crate::ranks::{Ranks, Wire, agree, gather_all, to_bytes};
use crate::run::pose::stopwatch;
use crate::run::results::beside::beside;
use crate::run::results::step_file::STATE;
use crate::run::results::sums::{self, Sums};
use crate::run::results::write::{CASE, PVTU, case, remove_listed, remove_pieces};
use crate::run::results::{LEVELS, Origin, REPORT, SUMS, Summary, json, remove_levels};

/// The summary of a folder: a folder that has one is complete.
pub(super) const SUMMARY: &str = "summary.json";

fn piece_name(kind: &str, rank: usize) -> String {
    format!("{kind}-{rank:04}.vtu")
}

/// What is written for people besides the numbers; nothing is where the features `plots` and `report` are off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ForPeople {
    /// Whether pictures are drawn.
    pub pictures: bool,
    /// Whether `report.html` is written.
    pub report: bool,
}

/// What has been written.
#[derive(Debug, Clone, Default)]
pub struct Written {
    /// The names of files, of pieces those that name them.
    pub files: Vec<String>,
    /// Why there is no report, where one was wanted; the results are whole without it.
    pub without_report: Option<Error>,
}

/// Writes the answer of all ranks into `folder`, which all of them see. `summary.json` comes when all pieces are on the disk, and only the
/// report after it.
/// `answer` learns how long it took; `origin` says at rank 0 where the case came from.
///
/// # Errors
/// If a file cannot be written, at every rank.
pub fn write_on_ranks(
    answer: &mut RankedAnswer,
    folder: &Path,
    origin: &Origin,
    wanted: ForPeople,
    ranks: &dyn Ranks,
) -> Result<Written, Error> {
    let mut lap = stopwatch();
    let first = ranks.rank() == 0;
    let stepped = !answer.summary.steps.is_empty();
    let refined = answer.summary.accuracy.is_some();
    let ready = || {
        prepare(folder, ranks.size(), stepped)?;
        // Levels of an earlier run are those of another one from now on.
        if refined { Ok(()) } else { remove_levels(folder) }
    };
    agree(ranks, if first { ready() } else { Ok(()) })?;
    let stress = stress(answer);
    let body = body(answer, &stress, ranks.rank());
    let points = at_points(answer);
    let surface = surface(answer, &points);
    let shown = Shown::gathered(answer, (&stress, &points), wanted, ranks);
    drop((stress, points));
    let known = &*answer;
    let (body_name, surface_name) = (piece_name("result", ranks.rank()), piece_name("contact", ranks.rank()));
    let write = |name: &str, grid: &GridFields| -> Result<(), Error> {
        if grid.is_empty() {
            return Ok(());
        }
        vtu::write(&folder.join(name), &grid.grid(), &grid.point_arrays(), &grid.cell_arrays())?;
        folder::sync(folder, &[name.to_string()])
    };
    let write_pieces_of_rank = || {
        agree(ranks, write(&body_name, &body).and_then(|()| write(&surface_name, &surface)))?;
        agree(ranks, judged(known, folder))
    };
    // Rank 0 draws while all write.
    let draw = || shown.as_ref().filter(|_| wanted.pictures).map_or(Ok(Vec::new()), |shown| shown.draw(known, folder));
    let (drawn, judged) =
        if shown.is_some() { beside(draw, write_pieces_of_rank) } else { (draw(), write_pieces_of_rank()) };
    let judged = judged?;
    let pictures = agree(ranks, drawn)?;
    let has: Vec<Vec<u8>> = gather_all(ranks, vec![u8::from(!body.is_empty()), u8::from(!surface.is_empty())]);
    let mut own = judged;
    own.extend((!body.is_empty()).then_some(body_name));
    own.extend((!surface.is_empty()).then_some(surface_name));
    let sums = sums_of_all(ranks, folder, &own)?;
    let named = |kind: &str, which: usize| -> Vec<String> {
        (0..ranks.size()).filter(|&rank| has[rank][which] == 1).map(|rank| piece_name(kind, rank)).collect()
    };
    answer.seconds.output = answer.seconds.output + lap();
    take_cost(&mut answer.summary.answer, &of_all(&answer.seconds, ranks), ranks);
    let (overrides, command) = (origin.overrides(), origin.command.clone());
    let summary = Summary { pictures: pictures.clone(), overrides, command, ..answer.summary.clone() };
    let finish = || -> Result<(), Error> {
        let pieces = [("result.pvtu", named("result", 0), &body), ("contact.pvtu", named("contact", 1), &surface)];
        for (name, pieces, fields) in pieces {
            write_pieces(&folder.join(name), &pieces, &fields.point_arrays(), &fields.cell_arrays())?;
        }
        let mut others: Vec<String> = PVTU.map(String::from).into_iter().chain(pictures.iter().cloned()).collect();
        let copy = folder.join(CASE);
        if !origin.case_text.is_empty() && !origin.is_at(&copy) {
            folder::write_text(&copy, &case(origin))?;
            others.push(CASE.into());
        }
        folder::sync(folder, &others)?;
        let (mut sums, text) = (sums.clone(), json::text(&summary));
        sums.extend(sums::of_files(folder, &others)?);
        // The load steps may be of runs on other numbers of ranks, which this one has gone on from.
        let of_steps = |name: &String| name == STATE || name == LEVELS || is_piece(name) && name.starts_with("step-");
        let of_steps: Vec<String> = folder::names(folder)?.into_iter().filter(of_steps).collect();
        sums.extend(sums::of_files(folder, &of_steps)?);
        sums.insert(SUMMARY.into(), checksum::of_text(&text));
        sums::write(folder, &sums)?;
        folder::write_text_durably(&folder.join(SUMMARY), &text)
    };
    agree(ranks, if first { finish() } else { Ok(()) })?;
    let mut files = [SUMMARY, "result.pvtu", "contact.pvtu"].map(String::from).to_vec();
    files.extend(pictures);
    let report = shown.filter(|_| wanted.report).map(|shown| shown.write_report(&summary, folder));
    files.extend(report.as_ref().filter(|report| report.is_ok()).map(|_| REPORT.to_string()));
    Ok(Written { files, without_report: report.and_then(Result::err) })
}

/// Writes what the independent judge needs of this rank, and returns the names of the files.
fn judged(answer: &RankedAnswer, folder: &Path) -> Result<Vec<String>, Error> {
    let Local { problem, division, .. } = &answer.local;
    let ranks = &*division.ranks;
    let named = named(&answer.local);
    let head = Head { run: run_number(answer, &named), rank: ranks.rank(), ranks: ranks.size() };
    let mut names = vec![problem_name(head.rank), solution_name(head.rank)];
    let tolerance = answer.summary.answer.certificate.tolerance;
    write_problem_piece(&folder.join(&names[0]), &head, &named, problem, tolerance)?;
    write_solution_piece(&folder.join(&names[1]), &head, &named, &answer.free, &answer.lambda)?;
    for (number, [u, lambda]) in (2..).zip(&answer.others) {
        let name = other_solution_name(number, head.rank);
        write_solution_piece(&folder.join(&name), &head, &named, u, lambda)?;
        names.push(name);
    }
    folder::sync(folder, &names)?;
    Ok(names)
}

/// A number that is the same at every rank, and another one where the answer or what it answers differs.
fn run_number(answer: &RankedAnswer, named: &NamedPiece) -> u64 {
    let (problem, ranks) = (&answer.local.problem, &*answer.local.division.ranks);
    let mut hash = Hash::default();
    named.of_unknowns(&named.unknowns).into_iter().for_each(|name| hash.word(name));
    let (K, B) = (&problem.elastic.K, &problem.contact.B);
    for &i in &named.own_unknowns {
        K.row(i as usize).1.iter().for_each(|value| hash.word(value.to_bits()));
    }
    let lists: [&[f64]; 5] =
        [&B.value, &problem.contact.gap, &problem.contact.slip_reference, &answer.lambda, &answer.free];
    lists.into_iter().flatten().for_each(|value| hash.word(value.to_bits()));
    named.of_unknowns(&problem.elastic.f).iter().for_each(|value| hash.word(value.to_bits()));
    hash.text(&format!("{:?} {}", problem.contact.friction, answer.summary.answer.certificate.tolerance));
    let mut all = Hash::default();
    gather_all(ranks, to_bytes(&[hash.value()])).iter().for_each(|bytes| all.word(u64::read(bytes)));
    all.value()
}

/// Checksums of the files of all ranks, at every rank.
pub(super) fn sums_of_all(ranks: &dyn Ranks, folder: &Path, own: &[String]) -> Result<Sums, Error> {
    let found = agree(ranks, sums::of_files(folder, own))?;
    let text: String = found.iter().map(|(name, sum)| format!("{sum} {name}\n")).collect();
    let all = gather_all(ranks, text.into_bytes()).concat();
    let lines = String::from_utf8_lossy(&all).into_owned();
    let entries = lines.lines().filter_map(|line| line.split_once(' '));
    Ok(entries.map(|(sum, name)| (name.to_string(), sum.to_string())).collect())
}

/// Names of what a rank has, for its files.
pub(super) fn named(local: &Local) -> NamedPiece {
    let dofs = &local.model.dofs;
    NamedPiece::new(&local.problem, &local.division, [&dofs.free, &dofs.prescribed])
}

/// Makes the folder and takes away what tells of another run. Load steps that have been kept are of this one.
fn prepare(folder: &Path, size: usize, stepped: bool) -> Result<(), Error> {
    folder::create(folder)?;
    // The summary first: without one the folder is none of a finished run.
    withdraw(folder, &|name| !(stepped && name.starts_with("step-")))?;
    if !stepped {
        folder::withdraw(&folder.join(STATE))?;
    }
    // Pieces of an earlier run on more ranks.
    for kind in ["result", "contact"] {
        for rank in 0.. {
            let path = folder.join(piece_name(kind, rank));
            if rank >= size && !path.exists() {
                break;
            }
            folder::remove(&path)?;
        }
    }
    Ok(())
}

/// Makes the result in a folder none, whoever has written it, and removes its pieces as far as `which` says so.
pub(super) fn withdraw(folder: &Path, which: &dyn Fn(&str) -> bool) -> Result<(), Error> {
    folder::withdraw(&folder.join(SUMMARY))?;
    remove_listed(folder, &OF_ONE_MACHINE)?;
    for name in [SUMS, REPORT, "result.vtu", "contact.vtu", "problem.npz", "solution.npz"] {
        folder::remove(&folder.join(name))?;
    }
    remove_pieces(folder, which)
}

/// What `stiction solve` writes besides and ranks do not. The case stays: it may be the one that is solved.
const OF_ONE_MACHINE: [&str; 6] =
    ["obstacles.vtu", "result.pvd", "contact.pvd", "contact.csv", "bound.npz", "log.jsonl"];

/// A piece of a file: cells and fields.
struct GridFields {
    points: Vec<V3>,
    /// The number of each in the whole.
    numbers: Vec<u64>,
    cells: Vec<(u8, Vec<u32>)>,
    vectors: Vec<(&'static str, Vec<V3>)>,
    scalars: Vec<(&'static str, Vec<f64>)>,
    integers: Vec<(&'static str, Vec<i32>)>,
    of_cells: Option<CellFields>,
}

/// Fields of the cells of a body.
struct CellFields {
    stress: Vec<[f32; 6]>,
    von_mises: Vec<f32>,
    rank: Vec<i32>,
    /// Empty without an estimate.
    error: Vec<f32>,
}

impl GridFields {
    fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    fn grid(&self) -> Grid<'_> {
        let mut grid = Grid::new(&self.points);
        self.cells.iter().for_each(|(code, nodes)| grid.push(*code, nodes));
        grid
    }

    fn point_arrays(&self) -> Vec<Array<'_>> {
        let vectors = self.vectors.iter().map(|(name, values)| Array::vector(name, values));
        let scalars = self.scalars.iter().map(|(name, values)| Array::scalar(name, values));
        let integers = self.integers.iter().map(|(name, values)| Array::integer(name, values));
        vectors.chain(scalars).chain(integers).chain([Array::number("node", &self.numbers)]).collect()
    }

    fn cell_arrays(&self) -> Vec<Array<'_>> {
        let Some(CellFields { stress, von_mises, rank, error }) = &self.of_cells else { return Vec::new() };
        let error = (!error.is_empty()).then(|| Array::single("error", error));
        let always =
            [Array::tensor("stress", stress), Array::single("von_mises", von_mises), Array::integer("rank", rank)];
        always.into_iter().chain(error).collect()
    }
}

/// The nodes of some cells and faces of a mesh with so many nodes, ascending, and the cells with their places among these.
fn compact(lists: &[(u8, &[u32])], nodes: usize) -> (Vec<u32>, Vec<(u8, Vec<u32>)>) {
    let mut place = vec![None; nodes];
    lists.iter().flat_map(|(_, list)| *list).for_each(|&v| place[v as usize] = Some(0));
    let mut used = Vec::new();
    for (place, v) in place.iter_mut().zip(0..).filter(|(place, _)| place.is_some()) {
        *place = Some(used.len() as u32);
        used.push(v);
    }
    let places = |list: &[u32]| list.iter().filter_map(|&v| place[v as usize]).collect();
    let cells = lists.iter().map(|(code, list)| (*code, places(list))).collect();
    (used, cells)
}

/// The stress of each cell here.
fn stress(answer: &RankedAnswer) -> Vec<Voigt> {
    let Local { piece, materials, material_of_cell, .. } = &answer.local;
    let solid = Solid { mesh: &piece.mesh, materials, material_of_cell };
    cell_stress(&solid, answer.u.as_flattened(), &strain(&answer.local, &answer.shortening))
}

/// The cells of this rank, each of which is that of its first node.
fn body(answer: &RankedAnswer, stress: &[Voigt], rank: usize) -> GridFields {
    let Local { piece, division, .. } = &answer.local;
    let mesh = &piece.mesh;
    let whole = Grid::from_mesh(mesh);
    let own: Vec<usize> = (mesh.cell_iter().enumerate())
        .filter(|(_, (_, nodes))| division.is_own(nodes[0]))
        .map(|(cell, _)| cell)
        .collect();
    let all: Vec<&[u32]> = mesh.cell_iter().map(|(_, nodes)| nodes).collect();
    let lists: Vec<(u8, &[u32])> = own.iter().map(|&cell| (whole.codes[cell], all[cell])).collect();
    let (nodes, cells) = compact(&lists, mesh.nodes.len());
    GridFields {
        points: nodes.iter().map(|&v| mesh.nodes[v as usize]).collect(),
        numbers: nodes.iter().map(|&v| piece.nodes[v as usize]).collect(),
        cells,
        vectors: vec![("displacement", nodes.iter().map(|&v| answer.u[v as usize]).collect())],
        scalars: Vec::new(),
        integers: Vec::new(),
        of_cells: Some(CellFields {
            stress: own.iter().map(|&cell| stress[cell].map(|s| s as f32)).collect(),
            von_mises: own.iter().map(|&cell| von_mises(&stress[cell]) as f32).collect(),
            rank: vec![rank as i32; own.len()],
            error: own.iter().filter_map(|&cell| answer.error.get(cell).map(|&error| error as f32)).collect(),
        }),
    }
}

/// What is known at a contact point.
pub(super) struct AtPoint {
    /// Its node here.
    pub node: u32,
    /// The surface that it is of.
    #[cfg_attr(not(all(feature = "plots", feature = "report")), expect(dead_code, reason = "only pictures show it"))]
    pub surface: usize,
    /// Stress.
    pub pressure: f64,
    pub shear: V3,
    /// Length.
    pub slip: V3,
    pub gap: f64,
    /// Of the body on its counterpart.
    pub force: V3,
    /// 0 open, 1 stick, 2 slip.
    pub status: i32,
}

/// All contact points here.
fn at_points(answer: &RankedAnswer) -> Vec<AtPoint> {
    let Local { problem, signs, .. } = &answer.local;
    let m = problem.points();
    let left = problem.gap_and_slip(&answer.free);
    let at_point = |j: usize| {
        let (node, [normal, t1, t2]) = axes(&answer.local, j);
        let [l, a, b] = [0, 1, 2].map(|r| answer.lambda[r * m + j]);
        let friction = add(scale(a, t1), scale(b, t2));
        let surface = answer.local.pair_of(j);
        let (sign, share, traction) = (signs[surface], problem.labels.unity_sum[j], answer.tractions[j]);
        AtPoint {
            node,
            surface,
            pressure: traction[0],
            shear: scale(sign, shear_of(traction)),
            slip: scale(-sign / share, add(scale(left[m + j], t1), scale(left[2 * m + j], t2))),
            gap: left[j] / share,
            force: scale(sign * share, add(scale(l, normal), friction)),
            status: answer.states[j].code().into(),
        }
    };
    (0..answer.local.timed.contact_points()).map(at_point).collect()
}

/// The contact faces of this rank, each of which is that of its first node, with the fields of the contact points at their
/// nodes; the status is -1 where there is none.
fn surface(answer: &RankedAnswer, points: &[AtPoint]) -> GridFields {
    let Local { piece, division, signs, .. } = &answer.local;
    let mesh = &piece.mesh;
    let groups = (0..signs.len()).filter_map(|k| mesh.group(&name("contact", k)));
    let faces = groups.flat_map(|group| &group.faces).map(|&f| mesh.faces[f as usize].nodes());
    let own: Vec<(u8, &[u32])> =
        faces.filter(|nodes| division.is_own(nodes[0])).map(|nodes| (face_code(nodes.len()), nodes)).collect();
    let (nodes, cells) = compact(&own, mesh.nodes.len());
    let n = nodes.len();
    let [mut pressure, mut gap] = [vec![f64::NAN; n], vec![f64::NAN; n]];
    let [mut shear, mut slip, mut force] = [vec![[f64::NAN; 3]; n], vec![[f64::NAN; 3]; n], vec![[0.0; 3]; n]];
    let mut status = vec![-1; n];
    for point in points {
        let Ok(at) = nodes.binary_search(&point.node) else { continue };
        (pressure[at], gap[at], status[at]) = (point.pressure, point.gap, point.status);
        (shear[at], slip[at], force[at]) = (point.shear, point.slip, point.force);
    }
    GridFields {
        points: nodes.iter().map(|&v| mesh.nodes[v as usize]).collect(),
        numbers: nodes.iter().map(|&v| piece.nodes[v as usize]).collect(),
        cells,
        vectors: vec![("shear", shear), ("slip", slip), ("lambda", force)],
        scalars: vec![("pressure", pressure), ("gap", gap)],
        integers: vec![("status", status)],
        of_cells: None,
    }
}
