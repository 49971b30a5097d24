use std::path::Path;

use super::join::{Places, WholeProblem, columns, gathered, lists};
use super::piece::Piece;
use super::{Head, step_name};
use crate::Error;
use crate::contact::Friction;
use crate::io::problem::damaged;
use crate::io::step::{StepFile, step_of};

impl WholeProblem {
    /// A load step of the whole, from the pieces of step `number`, from 1, in `folder`; there may be more or fewer of them than of
    /// the problem.
    ///
    /// # Errors
    /// If a piece is missing or damaged, or does not fit the problem.
    pub fn step(&self, folder: &Path, number: usize) -> Result<StepFile, Error> {
        let first = Piece::read(folder, &step_name(number, 0))?;
        let head = first.head()?;
        let mut pieces = vec![first];
        for rank in 1..head.ranks {
            pieces.push(Piece::read(folder, &step_name(number, rank))?);
        }
        for (rank, piece) in pieces.iter().enumerate() {
            piece.expect(&Head { rank, ..head }, &step_name(number, 0))?;
        }
        let places: Vec<Places> = pieces.iter().map(|piece| self.places_of(piece)).collect::<Result<_, _>>()?;
        let read = |(piece, places): (&Piece, &Places)| {
            let [n, p, m] = [&places.unknowns, &places.supports, &places.points].map(Vec::len);
            piece.get(|arrays| step_of(arrays, [n, p, m]))
        };
        let all: Vec<StepFile> = pieces.iter().zip(&places).map(read).collect::<Result<_, _>>()?;
        let counts = |of: fn(&Places) -> &Vec<u32>| places.iter().map(|places| of(places).len()).sum::<usize>();
        let found = [counts(|p| &p.unknowns), counts(|p| &p.supports), counts(|p| &p.points)];
        if found != [self.names.unknowns.len(), self.names.supports.len(), self.names.points.len()] {
            return pieces[0].get(|_| Err(damaged("the pieces of its step are not all of the problem")));
        }
        if let Some(k) = all.iter().position(|step| step.t != all[0].t) {
            return pieces[k].get(|_| Err(damaged(format!("its time is not that of {}", step_name(number, 0)))));
        }
        Ok(joined_step(&all, &places))
    }

    /// Where what is in a piece of a load step stands.
    fn places_of(&self, piece: &Piece) -> Result<Places, Error> {
        let points = piece.numbers("points")?;
        let no_point = || damaged("it has a point that the problem has not");
        let place = |name: &[u64; 3]| self.names.points.binary_search(name).map(|k| k as u32).map_err(|_| no_point());
        let points = points.as_chunks().0.iter().map(place).collect::<Result<_, Error>>();
        Ok(Places {
            unknowns: columns(piece, &piece.numbers("unknowns")?, &self.names.unknowns)?,
            supports: columns(piece, &piece.numbers("supports")?, &self.names.supports)?,
            points: piece.get(|_| points)?,
        })
    }
}

fn joined_step(all: &[StepFile], places: &[Places]) -> StepFile {
    let [unknowns, supports, points] = lists(places);
    let list = |of: fn(&StepFile) -> &Vec<f64>, places: &[Vec<u32>], lists: usize| {
        gathered(&all.iter().map(|step| of(step).clone()).collect::<Vec<_>>(), places, lists)
    };
    let states: Vec<Vec<usize>> = all.iter().map(|step| step.states.clone()).collect();
    let laws: Vec<Vec<[f64; 4]>> = all.iter().map(|step| step.laws.iter().map(Friction::numbers).collect()).collect();
    let strengths: Vec<Vec<[f64; 2]>> = all.iter().map(|step| step.strength.as_chunks().0.to_vec()).collect();
    // Ranks without points have empty lists.
    let any = |empty: bool| if empty { &[][..] } else { &points[..] };
    let laws = gathered(&laws, any(laws.iter().all(Vec::is_empty)), 1);
    let strengths = gathered(&strengths, any(strengths.iter().all(Vec::is_empty)), 1);
    let out = all.iter().zip(&points).flat_map(|(step, places)| step.out.iter().map(|&j| places[j] as usize));
    let mut out: Vec<usize> = out.collect();
    out.sort_unstable();
    StepFile {
        t: all[0].t,
        f: list(|s| &s.f, &unknowns, 1),
        gap: list(|s| &s.gap, &points, 1),
        slip_reference: list(|s| &s.slip_reference, &points, 2),
        strength: strengths.into_flattened(),
        laws: laws.into_iter().map(Friction::of_numbers).collect(),
        out,
        motion: list(|s| &s.motion, &points, 3),
        support_load: list(|s| &s.support_load, &supports, 1),
        support_free_load: list(|s| &s.support_free_load, &unknowns, 1),
        support_displacement: list(|s| &s.support_displacement, &supports, 1),
        rounding: all.iter().map(|step| step.rounding).fold(0.0, f64::max),
        initial_load: match all.iter().all(|step| step.initial_load.is_empty()) {
            true => Vec::new(),
            false => [of_initial_load(all, &unknowns, true), of_initial_load(all, &supports, false)].concat(),
        },
        initial_energy: all.iter().map(|step| step.initial_energy).sum(),
        shortening: all[0].shortening.clone(),
        u: list(|s| &s.u, &unknowns, 1),
        lambda: list(|s| &s.lambda, &points, 3),
        states: gathered(&states, &points, 1),
        ..StepFile::default()
    }
}

/// That of the unknowns, or of the prescribed displacements, which stand behind them.
fn of_initial_load(all: &[StepFile], places: &[Vec<u32>], unknowns: bool) -> Vec<f64> {
    let part = |step: &StepFile| {
        let (first, rest) = step.initial_load.split_at(step.u.len().min(step.initial_load.len()));
        if unknowns { first.to_vec() } else { rest.to_vec() }
    };
    gathered(&all.iter().map(part).collect::<Vec<_>>(), places, 1)
}

/// The displacements of a load step by the names of their unknowns, from the pieces called `files` in `folder`: each is
/// handed to `put`.
///
/// # Errors
/// If a piece is missing or damaged.
pub(crate) fn displacements_of_step(
    folder: &Path,
    files: &[String],
    mut put: impl FnMut(u64, f64),
) -> Result<(), Error> {
    for name in files {
        let piece = Piece::read(folder, name)?;
        let unknowns = piece.numbers("unknowns")?;
        let values = piece.f64s("u", unknowns.len())?;
        unknowns.into_iter().zip(values).for_each(|(unknown, value)| put(unknown, value));
    }
    Ok(())
}

/// So many lists of numbers of each point at the end of a load step, by the names of the points; as [`displacements_of_step`]. They stand
/// list by list in the array, or `together` point by point.
///
/// # Errors
/// If a piece is missing or damaged.
pub(crate) fn of_points_of_step<const N: usize>(
    folder: &Path,
    files: &[String],
    (array, together): (&str, bool),
    mut put: impl FnMut([u64; 3], [f64; N]),
) -> Result<(), Error> {
    for name in files {
        let piece = Piece::read(folder, name)?;
        let names = piece.numbers("points")?;
        let (names, m) = (names.as_chunks().0, names.len() / 3);
        let values = piece.f64s(array, N * m)?;
        let place = |j: usize, k: usize| if together { N * j + k } else { k * m + j };
        names.iter().enumerate().for_each(|(j, &point)| put(point, std::array::from_fn(|k| values[place(j, k)])));
    }
    Ok(())
}
