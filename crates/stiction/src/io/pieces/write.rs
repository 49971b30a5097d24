use std::ops::Range;
use std::path::Path;

use super::{Head, NamedPiece};
use crate::Error;
use crate::contact::{ContactProblem, Friction, Supports};
use crate::io::npz::{self, Array};
use crate::io::problem::{code, matrix, sixes};
use crate::io::step::{StepFile, step_arrays};
use crate::linalg::Csr;

type Arrays<'a> = Vec<(String, Array<'a>)>;

/// Numbers of what a piece has or owns.
fn numbers(list: &[u64]) -> Array<'static> {
    Array::usize(&list.iter().map(|&number| number as usize).collect::<Vec<_>>())
}

fn head(head: &Head) -> Arrays<'static> {
    vec![
        ("format".into(), Array::count(1)),
        ("run".into(), Array::text(&format!("{:016x}", head.run))),
        ("piece".into(), Array::usize(&[head.rank, head.ranks])),
    ]
}

/// The rows `own` of a matrix.
fn own_rows(matrix: &Csr, own: impl Iterator<Item = usize>) -> Csr {
    matrix.select_rows(&own.map(|i| i as u32).collect::<Vec<_>>())
}

/// The rows of the own points: normal rows, first tangents, second ones.
fn own_points(named: &NamedPiece, matrix: &Csr) -> Csr {
    let m = named.points.len();
    own_rows(matrix, (0..3).flat_map(|r| named.own_points.iter().map(move |&j| r * m + j as usize)))
}

/// Writes the piece of a problem that belongs to this rank, and the tolerance its solution is held against. Of matrices there are
/// the rows at own nodes; their columns are places in the lists of names.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write_problem_piece(
    path: &Path,
    of: &Head,
    named: &NamedPiece,
    problem: &ContactProblem,
    tolerance: f64,
) -> Result<(), Error> {
    let (elastic, contact, labels) = (&problem.elastic, &problem.contact, &problem.labels);
    let (K, B) = (&elastic.K, own_points(named, &contact.B));
    // Up to the diagonals: names ascend here as in the whole.
    let own = || named.own_unknowns.iter().map(|&i| i as usize);
    let columns: Vec<Range<usize>> = own().map(|i| K.first[i]..K.first[i] + K.row(i).0.len()).collect();
    let values: Vec<Range<usize>> = own().map(|i| K.start[i]..K.start[i + 1]).collect();
    let ends = values.iter().scan(0, |end, row| {
        *end += row.len();
        Some(*end)
    });
    let start: Vec<usize> = std::iter::once(0).chain(ends).collect();
    let motions = elastic.near_kernel.as_ref().map(|motions| named.of_unknowns(motions));
    let mut arrays = head(of);
    arrays.push(("tolerance".into(), Array::scalar(tolerance)));
    arrays.push(("data_rounding".into(), Array::scalar(contact.rounding)));
    arrays.push(("unknowns".into(), numbers(&named.unknowns)));
    arrays.push(("own_unknowns".into(), Array::u32(&named.own_unknowns)));
    arrays.push(("f".into(), Array::f64_owned(named.of_unknowns(&elastic.f))));
    arrays.push(("K_lower_start".into(), Array::usize(&start)));
    arrays.push(("K_lower_column".into(), Array::u32_parts(&K.column, &columns)));
    arrays.push(("K_lower_value".into(), Array::f64_parts(&K.value, &values)));
    if let Some(motions) = &motions {
        arrays.push(("rigid".into(), sixes(motions)));
    }
    points(&mut arrays, named, problem);
    matrix(&mut arrays, "B", &B);
    let own_supports = labels.supports.as_ref().map(|supports| SupportRows::new(named, supports));
    if let (Some(rows), Some(all)) = (&own_supports, &labels.supports) {
        rows.put(&mut arrays, named, all);
    }
    let (of, of_support);
    if let Some(bodies) = &labels.bodies {
        let names: Vec<&str> = bodies.list.iter().map(|body| body.name.as_str()).collect();
        let places: Vec<f64> = bodies.list.iter().flat_map(|b| b.centre.into_iter().chain([b.radius])).collect();
        (of, of_support) = (named.of_unknowns(&bodies.of), named.of_supports(&bodies.of_support));
        arrays.push(("body_names".into(), Array::text(&names.join("\n"))));
        arrays.push(("body_places".into(), Array::f64_owned(places)));
        arrays.push(("body_of".into(), Array::u32(&of)));
        arrays.push(("body_of_support".into(), Array::u32(&of_support)));
        arrays.push(("body_origin".into(), Array::f64(&bodies.origin)));
    }
    npz::begin(path, &arrays)?.commit()
}

/// Names, gaps and laws of the own points.
fn points(arrays: &mut Arrays, named: &NamedPiece, problem: &ContactProblem) {
    let (contact, labels) = (&problem.contact, &problem.labels);
    let names: Vec<u64> = named.of_points(&named.points).into_iter().flatten().collect();
    let laws: Vec<Friction> = named.of_points(&contact.friction);
    let codes: Vec<(usize, f64, f64)> = laws.iter().map(|&law| code(law)).collect();
    let pairs: Vec<&str> = labels.pairs.iter().map(|pair| pair.name.as_str()).collect();
    arrays.push(("pair_names".into(), Array::text(&pairs.join("\n"))));
    arrays.push(("points".into(), numbers(&names)));
    arrays.push(("friction_law".into(), Array::usize(&codes.iter().map(|law| law.0).collect::<Vec<_>>())));
    let mut list = |name: &str, values: Vec<f64>| arrays.push((name.into(), Array::f64_owned(values)));
    list("friction_value", codes.iter().map(|law| law.1).collect());
    list("friction_limit", codes.iter().map(|law| law.2).collect());
    list("friction_tension", laws.iter().map(Friction::tension).collect());
    list("gap", named.of_points(&contact.gap));
    list("slip_reference", named.of_points(&contact.slip_reference));
    list("area", named.of_points(&labels.area));
    list("share", named.of_points(&labels.unity_sum));
    if let Some(across) = &contact.orthotropy {
        list("friction_across", named.of_points(across));
    }
}

/// The rows at own prescribed displacements.
struct SupportRows {
    K: Csr,
    K_own: Csr,
    B: Csr,
    rigid: Vec<[f64; 6]>,
    springs: Option<Csr>,
}

impl SupportRows {
    fn new(named: &NamedPiece, all: &Supports) -> SupportRows {
        let own = || named.own_supports.iter().map(|&i| i as usize);
        let n = named.unknowns.len();
        let both = || named.own_unknowns.iter().map(|&i| i as usize).chain(own().map(move |i| n + i));
        SupportRows {
            K: own_rows(&all.K, own()),
            K_own: own_rows(&all.K_own, own()),
            B: own_points(named, &all.B),
            rigid: named.of_supports(&all.rigid),
            springs: all.springs.as_ref().map(|springs| own_rows(springs, both())),
        }
    }

    fn put<'a>(&'a self, arrays: &mut Arrays<'a>, named: &NamedPiece, all: &Supports) {
        arrays.push(("supports".into(), numbers(&named.supports)));
        arrays.push(("own_supports".into(), Array::usize(&places(&named.own_supports))));
        matrix(arrays, "support_K", &self.K);
        matrix(arrays, "support_K_own", &self.K_own);
        matrix(arrays, "support_B", &self.B);
        arrays.push(("support_rigid".into(), sixes(&self.rigid)));
        let mut list = |name: &str, values: Vec<f64>| arrays.push((name.into(), Array::f64_owned(values)));
        list("support_load", named.of_supports(&all.load));
        list("support_displacement", named.of_supports(&all.displacement));
        list("support_free_load", named.of_unknowns(&all.free_load));
        if let Some(springs) = &self.springs {
            matrix(arrays, "springs", springs);
        }
    }
}

fn places(list: &[u32]) -> Vec<usize> {
    list.iter().map(|&place| place as usize).collect()
}

/// Writes the own displacements and multipliers; `u` and `lambda` are those of all that this rank has.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write_solution_piece(
    path: &Path,
    of: &Head,
    named: &NamedPiece,
    u: &[f64],
    lambda: &[f64],
) -> Result<(), Error> {
    let mut arrays = head(of);
    arrays.push(("u".into(), Array::f64_owned(named.of_unknowns(u))));
    arrays.push(("lambda".into(), Array::f64_owned(named.of_points(lambda))));
    npz::begin(path, &arrays)?.commit()
}

/// Writes the own part of a load step, with the names of what is in it; `history` has what each point has been through, the own ones'
/// numbers one after the other.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write_step_piece(
    path: &Path,
    of: &Head,
    named: &NamedPiece,
    own: &StepFile,
    history: &[f64],
) -> Result<(), Error> {
    let mut arrays: Arrays = head(of);
    // The step has its own number of the format.
    arrays.remove(0);
    arrays.extend(step_arrays(own).into_iter().map(|(name, array)| (name.to_string(), array)));
    arrays.push(("unknowns".into(), numbers(&named.of_unknowns(&named.unknowns))));
    arrays.push(("supports".into(), numbers(&named.of_supports(&named.supports))));
    let points: Vec<u64> = named.of_points(&named.points).into_iter().flatten().collect();
    arrays.push(("points".into(), numbers(&points)));
    arrays.push(("history".into(), Array::f64(history)));
    npz::begin(path, &arrays)?.commit()
}
