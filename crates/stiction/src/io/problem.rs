//! Contact problems and their solutions as `.npz`: what is needed to judge a solution anew.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::npz::{self, Array, Arrays, Data, count, f64s, scalar, text, u32s, usizes};
use super::replace::Pending;
use crate::Error;
use crate::contact::{Bodies, Body, Contact, ContactProblem, Elastic, Friction, Labels, Pair, Supports};
use crate::linalg::{Csr, SymmetricCsr};

/// Writes a problem and the tolerance its solution is held against. Sparse matrices are in compressed rows, `K` as its
/// lower triangle `L` with the diagonal, `K = L + Lᵀ - diag L`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_problem(path: &Path, problem: &ContactProblem, tolerance: f64) -> Result<(), Error> {
    begin_problem(path, problem, tolerance)?.commit()
}

/// The same up to giving the file its name.
pub(crate) fn begin_problem(path: &Path, problem: &ContactProblem, tolerance: f64) -> Result<Pending, Error> {
    let tensions: Vec<f64> = problem.contact.friction.iter().map(Friction::tension).collect();
    let laws: Vec<(usize, f64, f64)> = problem.contact.friction.iter().map(|&law| code(law)).collect();
    let law_values: Vec<f64> = laws.iter().map(|law| law.1).collect();
    let law_limits: Vec<f64> = laws.iter().map(|law| law.2).collect();
    let names: Vec<&str> = problem.labels.pairs.iter().map(|pair| pair.name.as_str()).collect();
    let ends: Vec<usize> = problem.labels.pairs.iter().map(|pair| pair.points.end).collect();
    let mut arrays = vec![
        ("format".to_string(), Array::count(1)),
        ("tolerance".to_string(), Array::scalar(tolerance)),
        ("f".to_string(), Array::f64(&problem.elastic.f)),
        ("gap".to_string(), Array::f64(&problem.contact.gap)),
        ("slip_reference".to_string(), Array::f64(&problem.contact.slip_reference)),
        ("friction_law".to_string(), Array::usize(&laws.iter().map(|l| l.0).collect::<Vec<_>>())),
        ("friction_value".to_string(), Array::f64(&law_values)),
        ("friction_limit".to_string(), Array::f64(&law_limits)),
        ("area".to_string(), Array::f64(&problem.labels.area)),
        ("share".to_string(), Array::f64(&problem.labels.unity_sum)),
        ("pair_names".to_string(), Array::text(&names.join("\n"))),
        ("pair_ends".to_string(), Array::usize(&ends)),
    ];
    let rows: Vec<Range<usize>> = (0..problem.elastic.K.rows)
        .map(|i| problem.elastic.K.first[i]..problem.elastic.K.first[i] + problem.elastic.K.row(i).0.len())
        .collect();
    arrays.push(("K_lower_start".into(), Array::usize(&problem.elastic.K.start)));
    arrays.push(("K_lower_column".into(), Array::u32_parts(&problem.elastic.K.column, &rows)));
    arrays.push(("K_lower_value".into(), Array::f64(&problem.elastic.K.value)));
    matrix(&mut arrays, "B", &problem.contact.B);
    if let Some(across) = &problem.contact.orthotropy {
        arrays.push(("friction_across".into(), Array::f64(across)));
    }
    if tensions.iter().any(|&tension| tension != 0.0) {
        arrays.push(("friction_tension".into(), Array::f64(&tensions)));
    }
    arrays.push(("data_rounding".into(), Array::scalar(problem.contact.rounding)));
    if let Some(node_of) = &problem.elastic.node_of {
        arrays.push(("node_of".into(), Array::u32(node_of)));
    }
    if let Some(motions) = &problem.elastic.near_kernel {
        arrays.push(("rigid".into(), sixes(motions)));
    }
    if let Some(middles) = &problem.elastic.middles {
        arrays.push(("middles".into(), Array::u32(middles.as_flattened())));
    }
    if let Some(supports) = &problem.labels.supports {
        matrix(&mut arrays, "support_K", &supports.K);
        matrix(&mut arrays, "support_K_own", &supports.K_own);
        matrix(&mut arrays, "support_B", &supports.B);
        arrays.push(("support_load".into(), Array::f64(&supports.load)));
        arrays.push(("support_free_load".into(), Array::f64(&supports.free_load)));
        arrays.push(("support_displacement".into(), Array::f64(&supports.displacement)));
        arrays.push(("support_rigid".into(), sixes(&supports.rigid)));
        if let Some(springs) = &supports.springs {
            matrix(&mut arrays, "springs", springs);
        }
    }
    if let Some(bodies) = &problem.labels.bodies {
        let names: Vec<&str> = bodies.list.iter().map(|body| body.name.as_str()).collect();
        let places: Vec<f64> = bodies.list.iter().flat_map(|b| b.centre.into_iter().chain([b.radius])).collect();
        arrays.push(("body_names".into(), Array::text(&names.join("\n"))));
        let places = Array { shape: vec![places.len()], data: Data::F64(places.into()) };
        arrays.push(("body_places".into(), places));
        arrays.push(("body_of".into(), Array::u32(&bodies.of)));
        arrays.push(("body_of_support".into(), Array::u32(&bodies.of_support)));
        arrays.push(("body_origin".into(), Array::f64(&bodies.origin)));
    }
    npz::begin(path, &arrays)
}

/// Reads what [`write_problem`] wrote: a problem whose lengths and values have been checked, and the tolerance.
///
/// # Errors
/// If the file cannot be read or holds no valid problem.
pub fn read_problem(path: &Path) -> Result<(ContactProblem, f64), Error> {
    let arrays = npz::read(path)?;
    problem(&arrays).map_err(|error| error.at(&path.display().to_string()))
}

/// Writes displacements and multipliers.
///
/// # Errors
/// If the file cannot be written.
pub fn write_solution(path: &Path, u: &[f64], lambda: &[f64]) -> Result<(), Error> {
    npz::write(path, &[("u", Array::f64(u)), ("lambda", Array::f64(lambda))])
}

/// Reads displacements and multipliers of `problem`.
///
/// # Errors
/// If the file cannot be read or does not fit `problem`.
pub fn read_solution(path: &Path, problem: &ContactProblem) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let arrays = npz::read(path)?;
    let list = |name: &str, length: usize| f64s(&arrays, name, Some(length)).map(<[f64]>::to_vec);
    let both = list("u", problem.unknowns()).and_then(|u| Ok((u, list("lambda", 3 * problem.points())?)));
    both.map_err(|error| error.at(&path.display().to_string()))
}

fn problem(arrays: &Arrays) -> Result<(ContactProblem, f64), Error> {
    if count(arrays, "format")? != 1 {
        return Err(damaged("the file has another format than this version reads"));
    }
    let tolerance = scalar(arrays, "tolerance")?;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(damaged(format!("the tolerance is {tolerance}")));
    }
    let gap = f64s(arrays, "gap", None)?.to_vec();
    let f = f64s(arrays, "f", None)?.to_vec();
    let (n, m) = (f.len(), gap.len());
    let values = f64s(arrays, "friction_value", Some(m))?;
    let laws = usizes(arrays, "friction_law", Some(m))?;
    let limits = optional(arrays, "friction_limit", m)?.unwrap_or_else(|| vec![0.0; m]);
    let tensions = optional(arrays, "friction_tension", m)?.unwrap_or_else(|| vec![0.0; m]);
    let numbers = values.iter().zip(limits).zip(tensions);
    let friction =
        laws.into_iter().zip(numbers).map(|(kind, ((&value, limit), tension))| law(kind, value, limit, tension));
    let friction = friction.collect::<Result<_, _>>()?;
    let elastic = Elastic {
        K: Arc::new(if arrays.contains_key("K_lower_start") {
            SymmetricCsr::from_lower(&csr(arrays, "K_lower", n, n)?, "K_lower")
                .map_err(|error| damaged(format!("K_lower: {}", error.what)))?
        } else {
            SymmetricCsr::from_full(&csr(arrays, "K", n, n)?, "K")?
        }),
        f,
        node_of: if arrays.contains_key("node_of") { Some(u32s(arrays, "node_of", Some(n))?.to_vec()) } else { None },
        near_kernel: if arrays.contains_key("rigid") { Some(read_sixes(arrays, "rigid", n)?) } else { None },
        middles: if arrays.contains_key("middles") { Some(read_middles(arrays)?) } else { None },
    };
    let contact = Contact {
        B: csr(arrays, "B", 3 * m, n)?,
        gap,
        slip_reference: f64s(arrays, "slip_reference", Some(2 * m))?.to_vec(),
        friction,
        orthotropy: optional(arrays, "friction_across", m)?,
        rounding: scalar(arrays, "data_rounding")?,
        out: Vec::new(),
    };
    let labels = Labels {
        area: f64s(arrays, "area", Some(m))?.to_vec(),
        unity_sum: optional(arrays, "share", m)?.unwrap_or_else(|| vec![1.0; m]),
        pairs: pairs(arrays, m)?,
        supports: if arrays.contains_key("support_load") { Some(supports(arrays, n, m)?) } else { None },
        bodies: if arrays.contains_key("body_of") { Some(bodies(arrays, n)?) } else { None },
    };
    let problem = ContactProblem { elastic, contact, labels };
    problem.validate()?;
    Ok((problem, tolerance))
}

fn supports(arrays: &Arrays, n: usize, m: usize) -> Result<Supports, Error> {
    let load = f64s(arrays, "support_load", None)?.to_vec();
    let p = load.len();
    Ok(Supports {
        K: csr(arrays, "support_K", p, n)?,
        K_own: csr(arrays, "support_K_own", p, p)?,
        free_load: f64s(arrays, "support_free_load", Some(n))?.to_vec(),
        displacement: f64s(arrays, "support_displacement", Some(p))?.to_vec(),
        B: csr(arrays, "support_B", 3 * m, p)?,
        rigid: read_sixes(arrays, "support_rigid", p)?,
        springs: if arrays.contains_key("springs_start") { Some(csr(arrays, "springs", n + p, n + p)?) } else { None },
        load,
    })
}

fn bodies(arrays: &Arrays, n: usize) -> Result<Bodies, Error> {
    let names = text(arrays, "body_names")?;
    let names: Vec<&str> = names.split('\n').collect();
    let places = f64s(arrays, "body_places", Some(4 * names.len()))?.as_chunks::<4>().0;
    let body = |(name, &[x, y, z, radius]): (&str, &[f64; 4])| Body { name: name.into(), centre: [x, y, z], radius };
    let origin = f64s(arrays, "body_origin", Some(3))?;
    Ok(Bodies {
        list: names.into_iter().zip(places).map(body).collect(),
        of: u32s(arrays, "body_of", Some(n))?.to_vec(),
        of_support: u32s(arrays, "body_of_support", None)?.to_vec(),
        origin: [origin[0], origin[1], origin[2]],
    })
}

fn pairs(arrays: &Arrays, m: usize) -> Result<Vec<Pair>, Error> {
    let ends = usizes(arrays, "pair_ends", None)?;
    let names = text(arrays, "pair_names")?;
    let names: Vec<&str> = if ends.is_empty() { Vec::new() } else { names.split('\n').collect() };
    let ascend = ends.windows(2).all(|w| w[0] <= w[1]);
    if names.len() != ends.len() || !ascend || ends.last().copied().unwrap_or(0) != m {
        return Err(damaged("the pairs do not cover the contact points"));
    }
    let starts = std::iter::once(0).chain(ends.iter().copied());
    let pair = |((name, start), &end): ((&str, usize), &usize)| Pair { name: name.to_string(), points: start..end };
    Ok(names.into_iter().zip(starts).zip(&ends).map(pair).collect())
}

/// Number of a law, its value, and its limit or its cohesion.
pub(super) fn code(law: Friction) -> (usize, f64, f64) {
    match law {
        Friction::None => (0, 0.0, 0.0),
        Friction::Given { slip_bound } => (1, slip_bound, 0.0),
        Friction::Coulomb { coefficient } => (2, coefficient, 0.0),
        Friction::Bonded => (3, 0.0, 0.0),
        Friction::Limited { coefficient, limit } => (4, coefficient, limit),
        Friction::Cohesive { coefficient, cohesion, .. } => (5, coefficient, cohesion),
    }
}

/// The list of `length` numbers called `name`, if there is one.
pub(super) fn optional(arrays: &Arrays, name: &str, length: usize) -> Result<Option<Vec<f64>>, Error> {
    let read = || f64s(arrays, name, Some(length)).map(<[f64]>::to_vec);
    arrays.contains_key(name).then(read).transpose()
}

pub(super) fn law(code: usize, value: f64, limit: f64, tension: f64) -> Result<Friction, Error> {
    match code {
        0 => Ok(Friction::None),
        1 => Ok(Friction::Given { slip_bound: value }),
        2 => Ok(Friction::Coulomb { coefficient: value }),
        3 => Ok(Friction::Bonded),
        4 => Ok(Friction::Limited { coefficient: value, limit }),
        5 => Ok(Friction::Cohesive { coefficient: value, cohesion: limit, tension }),
        _ => Err(damaged(format!("there is no law of friction {code}"))),
    }
}

pub(super) fn matrix<'a>(arrays: &mut Vec<(String, Array<'a>)>, name: &str, matrix: &'a Csr) {
    arrays.push((format!("{name}_start"), Array::usize(&matrix.start)));
    arrays.push((format!("{name}_column"), Array::u32(&matrix.column)));
    arrays.push((format!("{name}_value"), Array::f64(&matrix.value)));
}

pub(super) fn csr(arrays: &Arrays, name: &str, rows: usize, cols: usize) -> Result<Csr, Error> {
    let matrix = Csr {
        rows,
        cols,
        start: usizes(arrays, &format!("{name}_start"), Some(rows + 1))?,
        column: u32s(arrays, &format!("{name}_column"), None)?.to_vec(),
        value: f64s(arrays, &format!("{name}_value"), None)?.to_vec(),
    };
    matrix.validate(name)?;
    Ok(matrix)
}

pub(super) fn sixes(rows: &[[f64; 6]]) -> Array<'_> {
    Array { shape: vec![rows.len(), 6], data: Data::F64(rows.as_flattened().into()) }
}

pub(super) fn read_sixes(arrays: &Arrays, name: &str, rows: usize) -> Result<Vec<[f64; 6]>, Error> {
    let array = npz::get(arrays, name)?;
    match &array.data {
        Data::F64(values) if array.shape == [rows, 6] => Ok(values.as_chunks().0.to_vec()),
        _ => Err(damaged(format!("array \"{name}\" is not {rows} rows of six numbers"))),
    }
}

/// Triples, one after the other.
fn read_middles(arrays: &Arrays) -> Result<Vec<[u32; 3]>, Error> {
    match u32s(arrays, "middles", None)?.as_chunks() {
        (middles, []) => Ok(middles.to_vec()),
        _ => Err(damaged("array \"middles\" is no list of triples")),
    }
}

/// What is wrong with a file that a run has written.
pub(crate) fn damaged(what: impl Into<String>) -> Error {
    Error::new("", what, "the file is damaged or not of this program; solve the case again")
}
