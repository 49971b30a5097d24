//! What `check` and `--resume` need of one load step, as NumPy arrays; what all steps share is in the problem's file.

use std::path::Path;

use super::npz::{self, Array, Arrays, Data, count, f64s, scalar, usizes};
use super::problem::{code, damaged, law};
use crate::Error;
use crate::contact::{ContactProblem, Friction};

/// Grows where an array is added or changes its meaning.
const FORMAT: usize = 4;

/// The problem's vectors at the end of a step, and its solution; `n` unknowns, `p` prescribed, `m` contact points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StepFile {
    /// Time at the end of the step.
    pub t: f64,
    /// Load less what the prescribed displacements demand, newton, `n`.
    pub f: Vec<f64>,
    /// Length, `m`.
    pub gap: Vec<f64>,
    /// Length, `2m`.
    pub slip_reference: Vec<f64>,
    /// How far the obstacles have moved along the rows of `B`, length, `3m`.
    pub motion: Vec<f64>,
    /// External forces at the prescribed degrees of freedom, newton, `p`.
    pub support_load: Vec<f64>,
    /// External forces at the unknowns, newton, `n`.
    pub support_free_load: Vec<f64>,
    /// Prescribed displacements, length, `p`.
    pub support_displacement: Vec<f64>,
    /// Cohesion and largest pull that each point has left, newton, `2 j` and `2 j + 1`, where they can be lost; empty where
    /// they cannot.
    pub strength: Vec<f64>,
    /// The law of each point, `m`, where laws change with time; empty where they do not.
    pub laws: Vec<Friction>,
    /// The points that take no part in this step; their gaps are wide.
    pub out: Vec<usize>,
    /// Sums and gaps that ties and bonded points keep from the moment they begin, length.
    pub stood: Vec<f64>,
    /// What the rounding of the data leaves open in gaps and slips, length.
    pub rounding: f64,
    /// Part of the load that stands for strain without stress, newton, `n + p`, and the energy of that strain; empty and
    /// zero where there is none.
    pub initial_load: Vec<f64>,
    /// Energy of the thermal strain and of the shortening of bolts.
    pub initial_energy: f64,
    /// Shortening of each bolt, length.
    pub shortening: Vec<f64>,
    /// Displacements, length, `n`.
    pub u: Vec<f64>,
    /// Newton, `3m`.
    pub lambda: Vec<f64>,
    /// 0 open, 1 stick, 2 slip, `m`.
    pub states: Vec<usize>,
    /// Work, elastic energy, dissipation.
    pub energy: [f64; 3],
    /// Step, increment, part of the increment reached and length of the next part: where the time axis goes on.
    pub position: [usize; 4],
}

impl StepFile {
    /// Makes `problem` that of this step.
    pub fn put_into(&self, problem: &mut ContactProblem) {
        problem.elastic.f.clone_from(&self.f);
        problem.contact.gap.clone_from(&self.gap);
        problem.contact.slip_reference.clone_from(&self.slip_reference);
        problem.contact.rounding = self.rounding;
        problem.contact.friction.iter_mut().zip(&self.laws).for_each(|(law, now)| *law = *now);
        for (law, &strength) in problem.contact.friction.iter_mut().zip(self.strength.as_chunks().0) {
            law.set_strength(strength);
        }
        if let Some(supports) = &mut problem.labels.supports {
            supports.load.clone_from(&self.support_load);
            supports.free_load.clone_from(&self.support_free_load);
            supports.displacement.clone_from(&self.support_displacement);
        }
    }
}

/// Writes a step, as a whole or not at all.
///
/// # Errors
/// If the file cannot be written.
pub fn write_step(path: &Path, step: &StepFile) -> Result<(), Error> {
    npz::write(path, &step_arrays(step))
}

/// The arrays of a step by their names.
pub(super) fn step_arrays(step: &StepFile) -> Vec<(&'static str, Array<'_>)> {
    let laws = || step.laws.iter().map(|&law| code(law));
    vec![
        ("format", Array::count(FORMAT)),
        ("t", Array::scalar(step.t)),
        ("f", Array::f64(&step.f)),
        ("gap", Array::f64(&step.gap)),
        ("slip_reference", Array::f64(&step.slip_reference)),
        ("strength", Array::f64(&step.strength)),
        ("law", Array::usize(&laws().map(|law| law.0).collect::<Vec<_>>())),
        ("law_value", Array::f64_owned(laws().map(|law| law.1).collect())),
        ("law_limit", Array::f64_owned(laws().map(|law| law.2).collect())),
        ("law_tension", Array::f64_owned(step.laws.iter().map(Friction::tension).collect())),
        ("out", Array::usize(&step.out)),
        ("stood", Array::f64(&step.stood)),
        ("motion", Array::f64(&step.motion)),
        ("support_load", Array::f64(&step.support_load)),
        ("support_free_load", Array::f64(&step.support_free_load)),
        ("support_displacement", Array::f64(&step.support_displacement)),
        ("data_rounding", Array::scalar(step.rounding)),
        ("initial_load", Array::f64(&step.initial_load)),
        ("initial_energy", Array::scalar(step.initial_energy)),
        ("shortening", Array::f64(&step.shortening)),
        ("u", Array::f64(&step.u)),
        ("lambda", Array::f64(&step.lambda)),
        ("states", Array::usize(&step.states)),
        ("energy", Array::f64(&step.energy)),
        ("position", Array::usize(&step.position)),
    ]
}

/// Reads a step of a problem with `n` unknowns, `p` prescribed displacements and `m` contact points.
///
/// # Errors
/// If the file is missing, damaged, or of another problem.
pub fn read_step(path: &Path, n: usize, p: usize, m: usize) -> Result<StepFile, Error> {
    let arrays = npz::read(path)?;
    step_of(&arrays, [n, p, m]).map_err(|error| error.at(&path.display().to_string()))
}

/// The same from its arrays, among which others may be.
pub(super) fn step_of(arrays: &Arrays, [n, p, m]: [usize; 3]) -> Result<StepFile, Error> {
    let list = |name: &str, length: usize| f64s(arrays, name, Some(length)).map(<[f64]>::to_vec);
    if count(arrays, "format")? != FORMAT {
        return Err(damaged("the file has another format than this version reads"));
    }
    let states = usizes(arrays, "states", Some(m))?;
    if let Some(state) = states.iter().find(|&&state| state > 2) {
        return Err(damaged(format!("there is no state of contact {state}")));
    }
    // Displacements and forces are judged by the certificate, the rest enters the problem or stands beside it.
    for (name, array) in arrays {
        if let (Data::F64(values), false) = (&array.data, ["u", "lambda"].contains(&&name[..]))
            && let Some(i) = values.iter().position(|v| !v.is_finite())
        {
            return Err(damaged(format!("entry {i} of array \"{name}\" is {}", values[i])));
        }
    }
    let energy = list("energy", 3)?;
    let position = usizes(arrays, "position", Some(4))?;
    Ok(StepFile {
        t: scalar(arrays, "t")?,
        f: list("f", n)?,
        gap: list("gap", m)?,
        slip_reference: list("slip_reference", 2 * m)?,
        laws: match usizes(arrays, "law", None)?.as_slice() {
            [] => Vec::new(),
            _ => {
                let (codes, values) = (usizes(arrays, "law", Some(m))?, list("law_value", m)?);
                let strengths = list("law_limit", m)?.into_iter().zip(list("law_tension", m)?);
                let all = codes.iter().zip(values).zip(strengths);
                all.map(|((&code, value), (limit, tension))| law(code, value, limit, tension))
                    .collect::<Result<_, _>>()?
            }
        },
        strength: match f64s(arrays, "strength", None)? {
            [] => Vec::new(),
            _ => list("strength", 2 * m)?,
        },
        out: {
            let out = usizes(arrays, "out", None)?.to_vec();
            if out.iter().any(|&point| point >= m) {
                return Err(damaged("a point that is out is none of the problem"));
            }
            out
        },
        stood: f64s(arrays, "stood", None)?.to_vec(),
        motion: list("motion", 3 * m)?,
        support_load: list("support_load", p)?,
        support_free_load: list("support_free_load", n)?,
        support_displacement: list("support_displacement", p)?,
        rounding: scalar(arrays, "data_rounding")?,
        initial_load: match f64s(arrays, "initial_load", None)? {
            [] => Vec::new(),
            _ => list("initial_load", n + p)?,
        },
        initial_energy: scalar(arrays, "initial_energy")?,
        shortening: f64s(arrays, "shortening", None)?.to_vec(),
        u: list("u", n)?,
        lambda: list("lambda", 3 * m)?,
        states,
        energy: [energy[0], energy[1], energy[2]],
        position: [position[0], position[1], position[2], position[3]],
    })
}
