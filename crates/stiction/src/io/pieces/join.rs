use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use super::piece::Piece;
use super::{Head, is_piece, of_node, other_solution_name, problem_name, solution_name};
use crate::Error;
use crate::contact::{Bodies, Body, Contact, ContactProblem, Elastic, Friction, Labels, Pair, Supports};
use crate::io::folder;
use crate::io::npz::{count, f64s, scalar, text, u32s, usizes};
use crate::io::problem::{csr, damaged, law, optional, read_sixes};
use crate::linalg::{Csr, SymmetricCsr};

/// Where what a piece owns stands in the whole, in the order of the piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places {
    /// Of unknowns.
    pub unknowns: Vec<u32>,
    /// Of prescribed displacements.
    pub supports: Vec<u32>,
    /// Of contact points.
    pub points: Vec<u32>,
}

/// What the pieces of a problem make.
#[derive(Debug, Clone)]
pub struct WholeProblem {
    /// Unknowns in the order of nodes and directions, points in that of pairs and nodes.
    pub problem: ContactProblem,
    /// What its solution is held against.
    pub tolerance: f64,
    /// Of each piece.
    pub places: Vec<Places>,
    /// The number of the run.
    run: u64,
    /// Names of its unknowns, prescribed displacements and points.
    pub(super) names: WholeNames,
}

/// Names in the order of the whole.
#[derive(Debug, Clone)]
pub(super) struct WholeNames {
    pub unknowns: Vec<u64>,
    pub supports: Vec<u64>,
    pub points: Vec<[u64; 3]>,
}

/// Reads the pieces of a problem in `folder` and joins them.
///
/// # Errors
/// If a piece is missing, damaged, of another run, or does not fit the others: its name.
pub fn read_pieces(folder: &Path) -> Result<WholeProblem, Error> {
    let first = first_piece(folder)?;
    let head = first.head()?;
    let mut pieces = vec![first];
    for rank in 1..head.ranks {
        let path = folder.join(problem_name(rank));
        if !path.exists() {
            let what = format!("the piece of rank {rank} is missing; there were {} ranks", head.ranks);
            return Err(Error::new(
                path.display().to_string(),
                what,
                "copy all files of the folder, or solve the case again",
            ));
        }
        pieces.push(Piece::read(folder, &problem_name(rank))?);
    }
    for (rank, piece) in pieces.iter().enumerate() {
        piece.expect(&Head { rank, ..head }, &problem_name(0))?;
        if piece.get(|arrays| count(arrays, "format"))? != 1 {
            return piece.get(|_| Err(damaged("the file has another format than this version reads")));
        }
    }
    let tolerance = pieces[0].get(|arrays| scalar(arrays, "tolerance"))?;
    let (problem, places, names) = joined(&pieces)?;
    problem.validate().map_err(|error| error.at(&folder.display().to_string()))?;
    Ok(WholeProblem { problem, tolerance, places, run: head.run, names })
}

/// The piece of rank 0; where it is missing an error says so.
fn first_piece(folder: &Path) -> Result<Piece, Error> {
    let path = folder.join(problem_name(0));
    if !path.exists() && folder::names(folder)?.iter().any(|name| is_piece(name)) {
        let what = "the piece of rank 0 is missing";
        return Err(Error::new(
            path.display().to_string(),
            what,
            "copy all files of the folder, or solve the case again",
        ));
    }
    Piece::read(folder, &problem_name(0))
}

/// What a piece has and owns, by names.
struct Names {
    unknowns: Vec<u64>,
    supports: Vec<u64>,
    own_unknowns: Vec<u64>,
    own_supports: Vec<u64>,
    own_points: Vec<[u64; 3]>,
}

impl Names {
    fn of(piece: &Piece) -> Result<Names, Error> {
        let (unknowns, points) = (piece.numbers("unknowns")?, piece.numbers("points")?);
        let has_supports = piece.arrays.contains_key("supports");
        let supports = if has_supports { piece.numbers("supports")? } else { Vec::new() };
        let own_unknowns: Vec<u64> =
            piece.get(|arrays| Ok(u32s(arrays, "own_unknowns", None)?.iter().map(|&i| i.into()).collect()))?;
        let own_supports = if has_supports { piece.numbers("own_supports")? } else { Vec::new() };
        let own = |places: Vec<u64>, names: &[u64]| -> Result<Vec<u64>, Error> {
            let named = places.iter().map(|&place| names.get(place as usize).copied()).collect::<Option<Vec<u64>>>();
            named.ok_or_else(|| damaged("it owns what it does not have").at(&piece.path))
        };
        let (own_unknowns, own_supports) = (own(own_unknowns, &unknowns)?, own(own_supports, &supports)?);
        let (own_points, []) = points.as_chunks() else {
            return piece.get(|_| Err(damaged("array \"points\" is no list of triples")));
        };
        let own_points = own_points.to_vec();
        Ok(Names { unknowns, supports, own_unknowns, own_supports, own_points })
    }
}

/// The names of the whole in their order, and where those of each piece stand.
fn order<T: Ord + Copy + Debug>(
    pieces: &[Piece],
    own: &[&[T]],
    says: impl Fn(T) -> String,
) -> Result<(Vec<T>, Vec<Vec<u32>>), Error> {
    let named = |(rank, list): (usize, &&[T])| {
        list.iter().enumerate().map(move |(place, &name)| (name, rank, place)).collect::<Vec<_>>()
    };
    let mut all: Vec<(T, usize, usize)> = own.iter().enumerate().flat_map(named).collect();
    all.sort_unstable();
    if let Some(twice) = all.windows(2).find(|two| two[0].0 == two[1].0) {
        let (a, b) = (twice[0].1, twice[1].1);
        let what = format!("{} is also that of {}", says(twice[0].0), problem_name(a));
        return Err(Error::new(&pieces[b].path, what, "the pieces are not of one run; solve the case again"));
    }
    let mut places: Vec<Vec<u32>> = own.iter().map(|list| vec![0; list.len()]).collect();
    all.iter().enumerate().for_each(|(k, &(_, rank, place))| places[rank][place] = k as u32);
    Ok((all.into_iter().map(|entry| entry.0).collect(), places))
}

/// Where the columns of a piece stand in the whole.
pub(super) fn columns(piece: &Piece, names: &[u64], whole: &[u64]) -> Result<Vec<u32>, Error> {
    let place = |name: &u64| {
        let found = whole.binary_search(name).map(|place| place as u32);
        found.map_err(|_| {
            let what = format!("it is coupled to {}, which no piece owns", of_node(*name));
            Error::new(&piece.path, what, "a file is damaged or of another run; solve the case again")
        })
    };
    names.iter().map(place).collect()
}

/// Numbers of the whole from those of the pieces: `lists` of each one after the other.
pub(super) fn gathered<T: Copy + Default>(values: &[Vec<T>], places: &[Vec<u32>], lists: usize) -> Vec<T> {
    let length: usize = places.iter().map(Vec::len).sum();
    let mut whole = vec![T::default(); lists * length];
    for (values, places) in values.iter().zip(places) {
        for (k, list) in values.chunks_exact(places.len().max(1)).enumerate() {
            list.iter().zip(places).for_each(|(&value, &place)| whole[k * length + place as usize] = value);
        }
    }
    whole
}

/// The rows of the whole from those of the pieces, of which `rows` says where they stand and `columns` where their columns do.
fn stacked(parts: &[Csr], rows: &[Vec<u32>], columns: &[Vec<u32>], cols: usize) -> Csr {
    let count: usize = rows.iter().map(Vec::len).sum();
    let mut from = vec![(0, 0); count];
    for (piece, rows) in rows.iter().enumerate() {
        rows.iter().enumerate().for_each(|(k, &row)| from[row as usize] = (piece, k));
    }
    let entries: usize = parts.iter().map(|part| part.column.len()).sum();
    let mut whole =
        Csr { column: Vec::with_capacity(entries), value: Vec::with_capacity(entries), ..Csr::zero(0, cols) };
    for (piece, k) in from {
        let (row, values) = parts[piece].row(k);
        whole.column.extend(row.iter().map(|&j| columns[piece][j as usize]));
        whole.value.extend_from_slice(values);
        whole.start.push(whole.column.len());
    }
    whole.rows = count;
    whole
}

/// Where three rows a point stand: normal rows, first tangents, second ones.
fn of_points(points: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let m: usize = points.iter().map(Vec::len).sum();
    points.iter().map(|list| (0..3).flat_map(|r| list.iter().map(move |&j| (r * m) as u32 + j)).collect()).collect()
}

fn joined(pieces: &[Piece]) -> Result<(ContactProblem, Vec<Places>, WholeNames), Error> {
    let names: Vec<Names> = pieces.iter().map(Names::of).collect::<Result<_, _>>()?;
    let lists = |of: fn(&Names) -> &[u64]| names.iter().map(of).collect::<Vec<&[u64]>>();
    let (unknowns, u_places) = order(pieces, &lists(|names| &names.own_unknowns), of_node)?;
    let (held, s_places) = order(pieces, &lists(|names| &names.own_supports), of_node)?;
    let points: Vec<&[[u64; 3]]> = names.iter().map(|names| &names.own_points[..]).collect();
    let says = |[pair, node, _]: [u64; 3]| format!("the point of contact {} at node {node}", pair + 1);
    let (points, p_places) = order(pieces, &points, says)?;
    let both = pieces.iter().zip(&names);
    let to_u: Vec<Vec<u32>> =
        both.clone().map(|(piece, names)| columns(piece, &names.unknowns, &unknowns)).collect::<Result<_, _>>()?;
    let to_s: Vec<Vec<u32>> =
        both.map(|(piece, names)| columns(piece, &names.supports, &held)).collect::<Result<_, _>>()?;
    let whole = Joined { pieces, u_places: &u_places, s_places: &s_places, p_places: &p_places };
    let n = unknowns.len();
    let supports = whole.supports(n, held.len(), &to_u, &to_s)?;
    let K = whole.matrix("K_lower", &u_places, &to_u, n)?;
    K.validate("K_lower").map_err(|error| error.at(&pieces[0].path))?;
    let K = SymmetricCsr::from_lower(&K, "K_lower").map_err(|error| error.at(&pieces[0].path))?;
    let has_motions = pieces.iter().all(|piece| piece.arrays.contains_key("rigid"));
    let elastic = Elastic {
        K: Arc::new(K),
        f: whole.of_unknowns("f")?,
        // Names are those of nodes in the whole mesh.
        node_of: Some(unknowns.iter().map(|name| (name / 3) as u32).collect()),
        near_kernel: if has_motions { Some(whole.sixes("rigid", &u_places)?) } else { None },
        // Where quadratic elements have nodes in the middle matters to a solver alone.
        middles: None,
    };
    let m = points.len();
    let rounding = pieces.iter().map(|piece| piece.get(|arrays| scalar(arrays, "data_rounding")));
    let contact = Contact {
        B: whole.matrix("B", &of_points(&p_places), &to_u, n)?,
        gap: whole.of_points("gap", 1)?,
        slip_reference: whole.of_points("slip_reference", 2)?,
        friction: whole.friction()?,
        orthotropy: whole.orthotropy()?,
        rounding: rounding.collect::<Result<Vec<f64>, _>>()?.into_iter().fold(0.0, f64::max),
        out: Vec::new(),
    };
    let labels = Labels {
        area: whole.of_points("area", 1)?,
        unity_sum: whole.of_points("share", 1)?,
        pairs: whole.pairs(&points, m)?,
        supports,
        bodies: whole.bodies()?,
    };
    let [u, s, p] = [&u_places, &s_places, &p_places].map(Clone::clone);
    let places = u.into_iter().zip(s).zip(p);
    let places = places.map(|((unknowns, supports), points)| Places { unknowns, supports, points }).collect();
    let names = WholeNames { unknowns, supports: held, points };
    Ok((ContactProblem { elastic, contact, labels }, places, names))
}

/// The pieces with their places in the whole.
struct Joined<'a> {
    pieces: &'a [Piece],
    u_places: &'a [Vec<u32>],
    s_places: &'a [Vec<u32>],
    p_places: &'a [Vec<u32>],
}

impl Joined<'_> {
    fn list(&self, name: &str, places: &[Vec<u32>], lists: usize) -> Result<Vec<f64>, Error> {
        let of = |(piece, places): (&Piece, &Vec<u32>)| piece.f64s(name, lists * places.len());
        let values: Vec<Vec<f64>> = self.pieces.iter().zip(places).map(of).collect::<Result<_, _>>()?;
        Ok(gathered(&values, places, lists))
    }

    fn of_unknowns(&self, name: &str) -> Result<Vec<f64>, Error> {
        self.list(name, self.u_places, 1)
    }

    fn of_points(&self, name: &str, lists: usize) -> Result<Vec<f64>, Error> {
        self.list(name, self.p_places, lists)
    }

    fn sixes(&self, name: &str, places: &[Vec<u32>]) -> Result<Vec<[f64; 6]>, Error> {
        let of = |(piece, places): (&Piece, &Vec<u32>)| piece.get(|arrays| read_sixes(arrays, name, places.len()));
        let rows: Vec<Vec<[f64; 6]>> = self.pieces.iter().zip(places).map(of).collect::<Result<_, _>>()?;
        Ok(gathered(&rows, places, 1))
    }

    fn matrix(&self, name: &str, rows: &[Vec<u32>], columns: &[Vec<u32>], cols: usize) -> Result<Csr, Error> {
        let of = |k: usize| self.pieces[k].get(|arrays| csr(arrays, name, rows[k].len(), columns[k].len()));
        let parts: Vec<Csr> = (0..self.pieces.len()).map(of).collect::<Result<_, _>>()?;
        Ok(stacked(&parts, rows, columns, cols))
    }

    fn supports(&self, n: usize, p: usize, to_u: &[Vec<u32>], to_s: &[Vec<u32>]) -> Result<Option<Supports>, Error> {
        if !self.pieces.iter().all(|piece| piece.arrays.contains_key("supports")) {
            return Ok(None);
        }
        let springs = if self.pieces.iter().all(|piece| piece.arrays.contains_key("springs_start")) {
            let after = |list: &Vec<u32>| list.iter().map(|&k| n as u32 + k).collect::<Vec<u32>>();
            let joint = |(u, s): (&Vec<u32>, &Vec<u32>)| [u.clone(), after(s)].concat();
            let rows: Vec<Vec<u32>> = self.u_places.iter().zip(self.s_places).map(joint).collect();
            let columns: Vec<Vec<u32>> = to_u.iter().zip(to_s).map(joint).collect();
            Some(self.matrix("springs", &rows, &columns, n + p)?)
        } else {
            None
        };
        Ok(Some(Supports {
            K: self.matrix("support_K", self.s_places, to_u, n)?,
            K_own: self.matrix("support_K_own", self.s_places, to_s, p)?,
            load: self.list("support_load", self.s_places, 1)?,
            free_load: self.of_unknowns("support_free_load")?,
            displacement: self.list("support_displacement", self.s_places, 1)?,
            B: self.matrix("support_B", &of_points(self.p_places), to_s, p)?,
            rigid: self.sixes("support_rigid", self.s_places)?,
            springs,
        }))
    }

    fn friction(&self) -> Result<Vec<Friction>, Error> {
        let of_piece = |piece: &Piece| {
            piece.get(|arrays| {
                let codes = usizes(arrays, "friction_law", None)?;
                let list = |name: &str| f64s(arrays, name, Some(codes.len()));
                let numbers =
                    list("friction_value")?.iter().zip(list("friction_limit")?).zip(list("friction_tension")?);
                codes.iter().zip(numbers).map(|(&code, ((&v, &l), &t))| law(code, v, l, t)).collect()
            })
        };
        let laws: Vec<Vec<Friction>> = self.pieces.iter().map(of_piece).collect::<Result<_, _>>()?;
        if let Some(k) = (0..laws.len()).find(|&k| laws[k].len() != self.p_places[k].len()) {
            return self.pieces[k].get(|_| Err(damaged("its laws of friction are not those of its points")));
        }
        let laws: Vec<Vec<Option<Friction>>> =
            laws.into_iter().map(|list| list.into_iter().map(Some).collect()).collect();
        Ok(gathered(&laws, self.p_places, 1).into_iter().flatten().collect())
    }

    fn orthotropy(&self) -> Result<Option<Vec<f64>>, Error> {
        let of = |(piece, places): (&Piece, &Vec<u32>)| {
            piece.get(|arrays| optional(arrays, "friction_across", places.len()))
        };
        let found: Vec<Option<Vec<f64>>> = self.pieces.iter().zip(self.p_places).map(of).collect::<Result<_, _>>()?;
        if found.iter().all(Option::is_none) {
            return Ok(None);
        }
        let round =
            found.into_iter().zip(self.p_places).map(|(list, places)| list.unwrap_or_else(|| vec![1.0; places.len()]));
        Ok(Some(gathered(&round.collect::<Vec<_>>(), self.p_places, 1)))
    }

    fn pairs(&self, points: &[[u64; 3]], m: usize) -> Result<Vec<Pair>, Error> {
        let names = self.same_text("pair_names")?;
        let end = |k: usize| points.partition_point(|point| point[0] <= k as u64);
        let names = names.split('\n').enumerate();
        let pairs: Vec<Pair> = names
            .map(|(k, name)| Pair { name: name.into(), points: if k == 0 { 0 } else { end(k - 1) }..end(k) })
            .collect();
        match pairs.last() {
            Some(last) if last.points.end == m => Ok(pairs),
            _ => self.pieces[0].get(|_| Err(damaged("the pairs do not cover the contact points"))),
        }
    }

    fn bodies(&self) -> Result<Option<Bodies>, Error> {
        if !self.pieces.iter().all(|piece| piece.arrays.contains_key("body_of")) {
            return Ok(None);
        }
        let names = self.same_text("body_names")?;
        let names: Vec<&str> = names.split('\n').collect();
        let first = &self.pieces[0];
        let places = first.f64s("body_places", 4 * names.len())?;
        let list = names.iter().zip(places.as_chunks::<4>().0);
        let list =
            list.map(|(name, &[x, y, z, radius])| Body { name: (*name).into(), centre: [x, y, z], radius }).collect();
        let origin = first.f64s("body_origin", 3)?;
        let of = |name: &str, places: &[Vec<u32>]| -> Result<Vec<u32>, Error> {
            let of = |(piece, places): (&Piece, &Vec<u32>)| {
                piece.get(|arrays| u32s(arrays, name, Some(places.len())).map(<[u32]>::to_vec))
            };
            let lists: Vec<Vec<u32>> = self.pieces.iter().zip(places).map(of).collect::<Result<_, _>>()?;
            Ok(gathered(&lists, places, 1))
        };
        Ok(Some(Bodies {
            list,
            of: of("body_of", self.u_places)?,
            of_support: of("body_of_support", self.s_places)?,
            origin: [origin[0], origin[1], origin[2]],
        }))
    }

    /// A text that is the same in all pieces.
    fn same_text(&self, name: &str) -> Result<String, Error> {
        let first = self.pieces[0].get(|arrays| text(arrays, name).map(str::to_string))?;
        for piece in self.pieces {
            if piece.get(|arrays| text(arrays, name).map(|other| other != first))? {
                return piece.get(|_| Err(damaged(format!("its \"{name}\" are not those of {}", problem_name(0)))));
            }
        }
        Ok(first)
    }
}

impl WholeProblem {
    fn pieces(&self, folder: &Path, name: impl Fn(usize) -> String) -> Result<Vec<Piece>, Error> {
        let ranks = self.places.len();
        let piece = |rank: usize| {
            let piece = Piece::read(folder, &name(rank))?;
            piece.expect(&Head { run: self.run, rank, ranks }, &problem_name(0))?;
            Ok(piece)
        };
        (0..ranks).map(piece).collect()
    }

    /// Displacements and multipliers of the whole, from the pieces in `folder`.
    ///
    /// # Errors
    /// If a piece is missing, damaged, or of another run.
    pub fn solution(&self, folder: &Path) -> Result<(Vec<f64>, Vec<f64>), Error> {
        self.joined_solution(folder, solution_name)
    }

    /// Those of solution `number`, from 2.
    ///
    /// # Errors
    /// As [`Self::solution`].
    pub(crate) fn other_solution(&self, folder: &Path, number: usize) -> Result<(Vec<f64>, Vec<f64>), Error> {
        self.joined_solution(folder, |rank| other_solution_name(number, rank))
    }

    fn joined_solution(&self, folder: &Path, name: impl Fn(usize) -> String) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let pieces = self.pieces(folder, name)?;
        let list = |name: &str, places: &[Vec<u32>], lists: usize| -> Result<Vec<f64>, Error> {
            let of = |(piece, places): (&Piece, &Vec<u32>)| piece.f64s(name, lists * places.len());
            let values: Vec<Vec<f64>> = pieces.iter().zip(places).map(of).collect::<Result<_, _>>()?;
            Ok(gathered(&values, places, lists))
        };
        let [unknowns, _, points] = lists(&self.places);
        Ok((list("u", &unknowns, 1)?, list("lambda", &points, 3)?))
    }
}

pub(super) fn lists(places: &[Places]) -> [Vec<Vec<u32>>; 3] {
    let of = |of: fn(&Places) -> &Vec<u32>| places.iter().map(|places| of(places).clone()).collect();
    [of(|p| &p.unknowns), of(|p| &p.supports), of(|p| &p.points)]
}
