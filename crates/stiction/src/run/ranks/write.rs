//! The files of a run on several ranks: a piece from each, and from rank 0 what names them.

use std::path::Path;

use super::bolts::strain;
use super::energy::reactions;
use super::gather::of_owners;
use super::hash::Hash;
use super::local::Local;
use super::record::{of_all, take_cost};
use super::shown::Shown;
use super::solve::RankedAnswer;
use super::surfaces::{AtNode, COHESION, FORCE, GAP, PRESSURE, SHEAR, SLID, SLIP, STATUS, SideHere, gathered, sides};
use crate::Error;
use crate::fem::{Solid, Voigt, cell_stress, von_mises};
use crate::io::pieces::{
    Head, NamedPiece, is_piece, other_solution_name, problem_name, solution_name, write_problem_piece,
    write_solution_piece,
};
use crate::io::pvtu::write_pieces;
use crate::io::units::Units;
use crate::io::vtu::{self, Array, Grid, face_code};
use crate::io::{checksum, folder};
use crate::mesh::v3::V3;
use crate::ranks::{Ranks, Wire, agree, gather_all, max, to_bytes};
use crate::run::pose::stopwatch;
use crate::run::results::beside::beside;
use crate::run::results::contact_csv::{CONTACT_CSV, write_csv};
use crate::run::results::step_file::STATE;
use crate::run::results::sums::{self, Sums};
use crate::run::results::write::{CASE, OBSTACLES, PVTU, case, remove_listed, remove_pieces, write_obstacles};
use crate::run::results::{LEVELS, Origin, REPORT, SUMS, Side, Summary, json, remove_levels};

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
    let sides = sides(answer);
    let surface = surface(answer, &sides, stepped);
    let contact = gathered(answer, &sides);
    let surfaces = contact.as_ref().map(|(surfaces, _)| &surfaces[..]);
    let shown = Shown::gathered(answer, &stress, surfaces, wanted, ranks);
    drop((stress, sides));
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
    let finish = || -> Result<Vec<String>, Error> {
        let pieces = [("result.pvtu", named("result", 0), &body), ("contact.pvtu", named("contact", 1), &surface)];
        for (name, pieces, fields) in pieces {
            write_pieces(&folder.join(name), &pieces, &fields.point_arrays(), &fields.cell_arrays())?;
        }
        let mut others: Vec<String> = PVTU.map(String::from).into_iter().chain(pictures.iter().cloned()).collect();
        if let Some((surfaces, figures)) = contact.as_ref().filter(|(surfaces, _)| !surfaces.is_empty()) {
            let units = Units::of(answer.summary.units.as_deref());
            write_csv(&folder.join(CONTACT_CSV), &units, surfaces, stepped.then_some(&figures[..]))?;
            others.push(CONTACT_CSV.into());
        }
        let obstacles = answer.local.outside.as_ref().map_or(&[][..], |outside| &outside.surfaces);
        if write_obstacles(&folder.join(OBSTACLES), obstacles)? {
            others.push(OBSTACLES.into());
        }
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
        folder::write_text_durably(&folder.join(SUMMARY), &text)?;
        Ok(others)
    };
    let others = agree(ranks, if first { finish() } else { Ok(Vec::new()) })?;
    let mut files = [vec![SUMMARY.to_string()], others].concat();
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

/// What `stiction solve` writes besides, and ranks in part. The case stays: it may be the one that is solved.
const OF_ONE_MACHINE: [&str; 6] = [OBSTACLES, "result.pvd", "contact.pvd", CONTACT_CSV, "bound.npz", "log.jsonl"];

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
    material: Vec<i32>,
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
        let Some(CellFields { stress, von_mises, material, rank, error }) = &self.of_cells else { return Vec::new() };
        let error = (!error.is_empty()).then(|| Array::single("error", error));
        let always = [
            Array::tensor("stress", stress),
            Array::single("von_mises", von_mises),
            Array::integer("material", material),
            Array::integer("rank", rank),
        ];
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
    let at_own = reactions(&answer.local, [&answer.free, &answer.lambda], answer.t);
    let reaction = of_owners(&answer.local, &nodes, &|v| at_own[v as usize]);
    GridFields {
        points: nodes.iter().map(|&v| mesh.nodes[v as usize]).collect(),
        numbers: nodes.iter().map(|&v| piece.nodes[v as usize]).collect(),
        cells,
        vectors: vec![("displacement", nodes.iter().map(|&v| answer.u[v as usize]).collect()), ("reaction", reaction)],
        scalars: Vec::new(),
        integers: Vec::new(),
        of_cells: Some(CellFields {
            stress: own.iter().map(|&cell| stress[cell].map(|s| s as f32)).collect(),
            von_mises: own.iter().map(|&cell| von_mises(&stress[cell]) as f32).collect(),
            material: own.iter().map(|&cell| answer.local.material_of_cell[cell] as i32).collect(),
            rank: vec![rank as i32; own.len()],
            error: own.iter().filter_map(|&cell| answer.error.get(cell).map(|&error| error as f32)).collect(),
        }),
    }
}

/// The contact faces of this rank, each of which is that of its first node, as [`write_contact`](crate::run::results::write::write_contact)
/// has them: the surfaces one after the other, a node of two of them twice. With load steps `slid` is what each point has slid since the start.
fn surface(answer: &RankedAnswer, sides: &[SideHere], stepped: bool) -> GridFields {
    let Local { piece, division, .. } = &answer.local;
    let mesh = &piece.mesh;
    let (mut nodes, mut cells, mut known) = (Vec::new(), Vec::new(), Vec::new());
    let (mut pair, mut side) = (Vec::new(), Vec::new());
    for of in sides {
        let own = of.faces.iter().filter(|nodes| division.is_own(nodes[0]));
        let own: Vec<(u8, &[u32])> = own.map(|nodes| (face_code(nodes.len()), &nodes[..])).collect();
        let (of_side, faces) = compact(&own, mesh.nodes.len());
        let first = nodes.len() as u32;
        let moved = |list: Vec<u32>| list.into_iter().map(|v| first + v).collect();
        cells.extend(faces.into_iter().map(|(code, list)| (code, moved(list))));
        known.extend(of_side.iter().map(|&v| of.at(v)));
        pair.extend(vec![of.pair as i32; of_side.len()]);
        side.extend(vec![i32::from(of.side == Side::Master); of_side.len()]);
        nodes.extend(of_side);
    }
    let scalars = |place: usize| known.iter().map(|at: &AtNode| at[place]).collect::<Vec<f64>>();
    let vectors = |first: usize| known.iter().map(|at| [0, 1, 2].map(|c| at[first + c])).collect::<Vec<V3>>();
    let mut of_nodes = vec![("shear_traction", vectors(SHEAR)), ("slip", vectors(SLIP)), ("lambda", vectors(FORCE))];
    of_nodes.extend(stepped.then(|| ("slid", vectors(SLID))));
    let mut of_points = vec![("pressure", scalars(PRESSURE)), ("gap", scalars(GAP))];
    let mut strong = [f64::from(u8::from(known.iter().any(|at| at[COHESION].is_finite())))];
    max(&*division.ranks, &mut strong);
    of_points.extend((strong[0] > 0.0).then(|| ("cohesion", scalars(COHESION))));
    GridFields {
        points: nodes.iter().map(|&v| mesh.nodes[v as usize]).collect(),
        numbers: nodes.iter().map(|&v| piece.nodes[v as usize]).collect(),
        cells,
        vectors: of_nodes,
        scalars: of_points,
        integers: vec![
            ("status", scalars(STATUS).into_iter().map(|status| status as i32).collect()),
            ("pair", pair),
            ("side", side),
        ],
        of_cells: None,
    }
}
