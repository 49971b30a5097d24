//! A contact problem from matrices: made, solved, judged.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::contact::Supports;
use stiction::friction::{Phase, PointState, tied_rows};
use stiction::io::case::SolverSpec;
use stiction::linalg::Stop;
use stiction::run::{Escape, MemoryLimit};
use stiction::{
    Certificate, ContactProblem, Csr, Error, Friction, Kept, Settings, Solution, SolveEvent, SolverPath, Status,
    SymmetricCsr, certify, solve_with_kept,
};

use crate::arrays::{pointwise, stacked, table};
use crate::errors::{raised, wrong};
use crate::linear::Matrices;
use crate::matrix::{DROPPED, Rows, View, rows, triples};
use crate::work::{borrowed, run};

/// A validated problem with what its solves keep.
#[pyclass(frozen, module = "stiction._stiction")]
pub(crate) struct Problem {
    problem: Arc<ContactProblem>,
    /// Where displacements are prescribed.
    supports: Option<Arc<Supports>>,
    /// Factor or hierarchy; taken while a solve uses it. Shared by problems of the same `K` and `B`.
    kept: Arc<Mutex<Option<Kept>>>,
}

type Reals<'py> = PyReadonlyArray1<'py, f64>;

/// Codes of the laws, values (coefficient or bound), limits or cohesions, tensile strengths; `m` each.
type Laws<'py> = (PyReadonlyArray1<'py, u8>, Reals<'py>, Reals<'py>, Reals<'py>);

fn laws(laws: &Laws<'_>) -> PyResult<Vec<Friction>> {
    let (codes, values) = (laws.0.as_slice()?, laws.1.as_slice()?);
    let (limits, tensions) = (laws.2.as_slice()?, laws.3.as_slice()?);
    let law = |((&code, &value), (&limit, &tension)): ((&u8, &f64), (&f64, &f64))| match code {
        1 => Friction::Coulomb { coefficient: value },
        2 => Friction::Given { slip_bound: value },
        3 => Friction::Limited { coefficient: value, limit },
        4 => Friction::Bonded,
        5 => Friction::Cohesive { coefficient: value, cohesion: limit, tension },
        _ => Friction::None,
    };
    Ok(codes.iter().zip(values).zip(limits.iter().zip(tensions)).map(law).collect())
}

/// Coordinates of nodes, the node of each unknown and its direction (0, 1, 2).
type Nodes<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, i64>, PyReadonlyArray1<'py, u8>);

#[pymethods]
impl Problem {
    /// `b` by points or, if `block`, as the library has it; `held` and `values` are the prescribed unknowns and what is prescribed.
    #[new]
    #[pyo3(signature = (k, b, f, gap, friction, *, block, across, slip_reference, held, values, nodes))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        k: Rows<'_>,
        b: Rows<'_>,
        f: Reals<'_>,
        gap: Reals<'_>,
        friction: Laws<'_>,
        block: bool,
        across: Option<Reals<'_>>,
        slip_reference: Reals<'_>,
        held: PyReadonlyArray1<'_, i64>,
        values: Reals<'_>,
        nodes: Option<Nodes<'_>>,
    ) -> PyResult<Self> {
        let (k, b, f, gap) = (k.view()?, b.view()?, f.as_slice()?, gap.as_slice()?);
        let (held, values) = (held.as_slice()?, values.as_slice()?);
        let nodes = nodes.as_ref().map(|(places, of, direction)| -> PyResult<_> {
            Ok(Motions { places: triples(places)?, of: of.as_slice()?, direction: direction.as_slice()? })
        });
        let nodes = nodes.transpose()?;
        let friction = laws(&friction)?;
        let across = across.map(|list| list.to_vec()).transpose()?;
        let reference = slip_reference.as_slice()?;
        let made = borrowed(py, |stop| -> Result<_, Error> {
            k.check("K", stop)?;
            b.check("B", stop)?;
            let split = Split::new(k.rows, held);
            let (stiffness, mut supports) = split.elastic(&k, f, values, nodes.as_ref(), stop)?;
            let m = gap.len();
            let order = |row: usize| if block { row } else { row % m * 3 + row / m };
            let jump = b.part((0..3 * m).map(order), |j| split.place[j], split.free.len());
            let imposed = b.part((0..3 * m).map(order), |j| split.place_of_held[j], held.len());
            let load = split.free.iter().map(|&i| f[i as usize]).collect();
            let mut problem = ContactProblem::from_matrices(stiffness, load, jump, gap.to_vec(), friction);
            problem.contact.orthotropy = across;
            if let Some(nodes) = &nodes {
                problem.elastic.node_of = Some(split.free.iter().map(|&i| nodes.of[i as usize] as u32).collect());
                problem.elastic.near_kernel = Some(nodes.rows(&split.free));
            }
            if let Some(supports) = &mut supports {
                supports.B = imposed;
                push(supports, &mut problem);
                let motions = problem.elastic.near_kernel.as_deref();
                if motions.is_some_and(|motions| strain_nothing(&problem.elastic.K, supports, motions, stop)) {
                    problem.labels.supports = Some(supports.clone());
                }
            }
            offset(&mut problem, supports.as_ref(), gap, reference);
            refuse_dragged(&problem)?;
            stop.check()?;
            problem.validate()?;
            Ok((problem, supports))
        })?;
        let (problem, supports) = made.map_err(|error| raised(py, error))?;
        Ok(Problem { problem: Arc::new(problem), supports: supports.map(Arc::new), kept: Arc::default() })
    }

    /// The same `K` and `B` with other laws or loads; what is `None` stays.
    #[pyo3(signature = (*, friction, across, f, gap, slip_reference, free, held))]
    #[allow(clippy::too_many_arguments)]
    fn varied(
        &self,
        py: Python<'_>,
        friction: Option<Laws<'_>>,
        across: Option<Reals<'_>>,
        f: Option<Reals<'_>>,
        gap: Reals<'_>,
        slip_reference: Reals<'_>,
        free: PyReadonlyArray1<'_, i64>,
        held: PyReadonlyArray1<'_, i64>,
    ) -> PyResult<Self> {
        let friction = friction.as_ref().map(laws).transpose()?;
        let across = across.map(|list| list.to_vec()).transpose()?;
        let f = f.as_ref().map(|f| f.as_slice()).transpose()?;
        let (gap, reference) = (gap.as_slice()?, slip_reference.as_slice()?);
        let (free, held) = (free.as_slice()?, held.as_slice()?);
        let made = borrowed(py, |_| -> Result<_, Error> {
            let (mut problem, mut supports) = (ContactProblem::clone(&self.problem), self.supports.clone());
            if let Some(friction) = friction {
                problem.contact.friction = friction;
                problem.contact.orthotropy = across;
            }
            if let Some(f) = f {
                let at = |places: &[i64]| places.iter().map(|&i| f[i as usize]).collect::<Vec<f64>>();
                problem.elastic.f = at(free);
                if let Some(supports) = &mut supports {
                    let supports = Arc::make_mut(supports);
                    supports.load = at(held);
                    supports.free_load = problem.elastic.f.clone();
                    push(supports, &mut problem);
                    if let Some(judged) = &mut problem.labels.supports {
                        judged.clone_from(supports);
                    }
                }
            }
            offset(&mut problem, supports.as_deref(), gap, reference);
            refuse_dragged(&problem)?;
            problem.validate()?;
            Ok((problem, supports))
        })?;
        let (problem, supports) = made.map_err(|error| raised(py, error))?;
        Ok(Problem { problem: Arc::new(problem), supports, kept: self.kept.clone() })
    }

    /// The answer, certified or not. `hear` is called with phase, iteration, residual, open, stick, slip, seconds and
    /// says whether to go on.
    #[pyo3(signature = (*, tolerance, max_iterations, method, memory_limit, forces, u, threads, hear))]
    #[allow(clippy::too_many_arguments)]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        tolerance: f64,
        max_iterations: usize,
        method: &str,
        memory_limit: Option<u64>,
        forces: Option<PyReadonlyArray2<'py, f64>>,
        u: Option<Reals<'py>>,
        threads: usize,
        hear: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let path = match method {
            "auto" => SolverPath::Auto,
            "dense" => SolverPath::Dense,
            "solves" => SolverPath::Solves,
            "multigrid" => SolverPath::Multigrid,
            _ => {
                return Err(wrong(
                    py,
                    "method",
                    format!("{method:?} is no method"),
                    "give auto, dense, solves or multigrid",
                ));
            }
        };
        let memory_limit = memory_limit.or_else(|| MemoryLimit::of(&SolverSpec::default()).bytes);
        let start = forces.map(|forces| stacked(&forces)).transpose()?;
        let start_displacement = u.map(|u| u.to_vec()).transpose()?;
        let (problem, shared, told) = (self.problem.clone(), self.kept.clone(), hear.is_some());
        let found = run(
            py,
            threads,
            move |stop, teller| {
                let settings =
                    Settings { tolerance, max_iterations, path, memory_limit, start, start_displacement, stop };
                let begin = Instant::now();
                let mut kept = shared.try_lock().ok().and_then(|mut kept| kept.take()).unwrap_or_default();
                let mut observer = |event: &SolveEvent| match told {
                    true => teller.tell((*event, begin.elapsed().as_secs_f64())),
                    false => ControlFlow::Continue(()),
                };
                let found = solve_with_kept(&problem, &settings, &mut kept, &mut observer);
                if let Ok(mut place) = shared.try_lock() {
                    *place = Some(kept);
                }
                found.map(|found| Answer::new(&problem, found))
            },
            |event| match &hear {
                Some(hear) => hear_event(hear, &event),
                None => Ok(true),
            },
        )?;
        found.map_err(|error| raised(py, error))?.dict(py, self.problem.clone())
    }

    /// The certificate of `u` (unknowns only) and forces by point.
    fn check<'py>(
        &self,
        py: Python<'py>,
        u: Reals<'py>,
        forces: PyReadonlyArray2<'py, f64>,
        tolerance: f64,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (u, lambda, problem) = (u.to_vec()?, stacked(&forces)?, self.problem.clone());
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(wrong(py, "tolerance", format!("it is {tolerance}"), "give a positive number, such as 1e-8"));
        }
        if u.len() != problem.unknowns() || lambda.len() != 3 * problem.points() {
            return Err(wrong(py, "u", "the lengths do not fit the problem", "give u (n) and forces (m, 3)"));
        }
        let judged = run(py, threads, move |_, _| certify(&problem, &u, &lambda, tolerance), |(): ()| Ok(true))?;
        certificate(py, &judged)
    }

    /// Forces of the supports on the body at the prescribed unknowns.
    fn reactions<'py>(
        &self,
        py: Python<'py>,
        u: Reals<'py>,
        forces: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (u, lambda) = (u.as_slice()?, stacked(&forces)?);
        let Some(supports) = &self.supports else { return Ok(PyArray1::from_vec(py, Vec::new())) };
        let force = borrowed(py, |_| {
            let mut force = supports.K.times(u);
            for (sign, part) in [
                (1.0, supports.K_own.times(&supports.displacement)),
                (1.0, supports.B.transpose_times(&lambda)),
                (-1.0, supports.load.clone()),
            ] {
                force.iter_mut().zip(part).for_each(|(force, part)| *force += sign * part);
            }
            force
        })?;
        Ok(PyArray1::from_vec(py, force))
    }

    /// The rows of `B` that hold in the states with these codes.
    fn tied<'py>(&self, py: Python<'py>, states: PyReadonlyArray1<'py, u8>) -> PyResult<Bound<'py, PyAny>> {
        let states = states_of(py, states.as_slice()?, self.problem.points())?;
        rows(py, borrowed(py, |_| tied_rows(&self.problem, &states))?)
    }
}

/// States from their codes, one for each of `m` points.
fn states_of(py: Python<'_>, codes: &[u8], m: usize) -> PyResult<Vec<PointState>> {
    let states: Option<Vec<PointState>> = codes.iter().map(|&code| PointState::of_code(code.into())).collect();
    match states.filter(|states| states.len() == m) {
        Some(states) => Ok(states),
        None => {
            let what = format!("{} states of {m} points, not all from 0 to 2", codes.len());
            Err(wrong(py, "state", what, "give the state of a solution of this problem"))
        }
    }
}

/// What rounding leaves of numbers that cancel, as a part of their terms.
const CANCELLED: f64 = 8.0 * f64::EPSILON;

/// Gap and slip reference as given, less what the prescribed displacements do to the jumps.
fn offset(problem: &mut ContactProblem, supports: Option<&Supports>, gap: &[f64], reference: &[f64]) {
    let m = gap.len();
    let given = gap.iter().chain(reference).copied();
    let all: Vec<f64> = match supports {
        Some(supports) => {
            let moved: Vec<f64> = supports.displacement.iter().map(|u| u.abs()).collect();
            let less = |(i, (given, jump)): (usize, (f64, f64))| {
                let terms = supports.B.entries_of(i).map(|(p, b)| b.abs() * moved[p as usize]).sum::<f64>();
                // What rounding leaves where a point is carried exactly to its counterpart is no gap.
                let left = given - jump;
                let rounding = left.is_finite() && left.abs() <= CANCELLED * given.abs().max(terms);
                if rounding { 0.0 } else { left }
            };
            given.zip(supports.B.times(&supports.displacement)).enumerate().map(less).collect()
        }
        None => given.collect(),
    };
    let (gap, reference) = all.split_at(m);
    (problem.contact.gap, problem.contact.slip_reference) = (gap.to_vec(), reference.to_vec());
}

/// Refuses a point that `held` unknowns alone drag along its counterpart: friction there acts on the support, and no force of the body
/// takes part in it.
fn refuse_dragged(problem: &ContactProblem) -> Result<(), Error> {
    let (contact, m) = (&problem.contact, problem.points());
    let is_dragged = |i: usize| contact.slip_reference[i] != 0.0 && contact.B.entries_of(m + i).all(|(_, b)| b == 0.0);
    for (j, law) in contact.friction.iter().enumerate() {
        if *law == Friction::Bonded || law.bound(f64::MAX) == 0.0 {
            continue;
        }
        if let Some(i) = [j, m + j].into_iter().find(|&i| is_dragged(i)) {
            let what = format!(
                "all unknowns of a tangential row of point {j} are held, and it slides by {} there",
                -contact.slip_reference[i]
            );
            let remedy =
                "leave one of them free, or set `mu` of this point to zero and add its friction to the support";
            return Err(Error::new("held", what, remedy));
        }
    }
    Ok(())
}

/// What the prescribed displacements demand of the load.
fn push(supports: &Supports, problem: &mut ContactProblem) {
    let push = supports.K.transpose_times(&supports.displacement);
    problem.elastic.f.iter_mut().zip(push).for_each(|(f, push)| *f -= push);
}

/// Whether the stiffness is one of bodies alone: rigid motions of all unknowns, free and prescribed, cost no force. Otherwise
/// (springs to the ground, constraints) reactions are not all the forces from outside, and there is no balance to judge.
fn strain_nothing(stiffness: &SymmetricCsr, supports: &Supports, motions: &[[f64; 6]], stop: &Stop) -> bool {
    (0..6).all(|k| {
        if stop.asked() {
            return false;
        }
        let [free, held] = [motions, &supports.rigid].map(|rows| rows.iter().map(|row| row[k]).collect::<Vec<f64>>());
        let size = |list: &[f64]| list.iter().map(|x| x.abs()).collect::<Vec<f64>>();
        let mut force = stiffness.times(&free);
        force.iter_mut().zip(supports.K.transpose_times(&held)).for_each(|(force, part)| *force += part);
        let mut terms = stiffness.magnitude_times(&free);
        let mut coupling = supports.K.clone();
        coupling.value.iter_mut().for_each(|value| *value = value.abs());
        terms.iter_mut().zip(coupling.transpose_times(&size(&held))).for_each(|(terms, part)| *terms += part);
        let largest = terms.iter().fold(0.0, |a: f64, b| a.max(*b));
        force.iter().all(|force| force.abs() <= NO_ENERGY * largest)
    })
}

/// Rigid motions from coordinates.
struct Motions<'a> {
    places: Vec<[f64; 3]>,
    of: &'a [i64],
    direction: &'a [u8],
}

impl Motions<'_> {
    /// What unit translations and rotations about the mean of all nodes do at unknowns.
    fn rows(&self, unknowns: &[u32]) -> Vec<[f64; 6]> {
        let count = self.places.len().max(1) as f64;
        let centre: [f64; 3] = std::array::from_fn(|c| self.places.iter().map(|x| x[c]).sum::<f64>() / count);
        let row = |&i: &u32| {
            let place = self.places[self.of[i as usize] as usize];
            let r: [f64; 3] = std::array::from_fn(|c| place[c] - centre[c]);
            let c = usize::from(self.direction[i as usize]);
            let mut row = [0.0; 6];
            row[c] = 1.0;
            // (e_k x r) . e_c
            row[3 + (c + 1) % 3] = r[(c + 2) % 3];
            row[3 + (c + 2) % 3] = -r[(c + 1) % 3];
            row
        };
        unknowns.iter().map(row).collect()
    }
}

/// What is free and what is prescribed.
struct Split<'a> {
    free: Vec<u32>,
    held: &'a [i64],
    /// The number of each unknown among the free ones.
    place: Vec<u32>,
    /// The number among the prescribed ones.
    place_of_held: Vec<u32>,
}

/// Rigid motions strain the bodies of a matrix by this part of its entries at most, or it is more than bodies.
const NO_ENERGY: f64 = 1e-9;

impl<'a> Split<'a> {
    /// The Python side has checked `held`.
    fn new(n: usize, held: &'a [i64]) -> Self {
        let mut place_of_held = vec![DROPPED; n];
        held.iter().enumerate().for_each(|(p, &i)| place_of_held[i as usize] = p as u32);
        let free: Vec<u32> = (0..n as u32).filter(|&i| place_of_held[i as usize] == DROPPED).collect();
        let mut place = vec![DROPPED; n];
        (0..).zip(&free).for_each(|(new, &i)| place[i as usize] = new);
        Split { free, held, place, place_of_held }
    }

    /// Stiffness of the free unknowns, and the supports without their jumps.
    fn elastic(
        &self,
        k: &View<'_>,
        f: &[f64],
        values: &[f64],
        nodes: Option<&Motions<'_>>,
        stop: &Stop,
    ) -> Result<(SymmetricCsr, Option<Supports>), Error> {
        let stiffness = k.symmetric(&self.place, self.free.len(), "K", stop)?;
        if self.held.is_empty() {
            return Ok((stiffness, None));
        }
        let rows = || self.held.iter().map(|&i| i as usize);
        let p = self.held.len();
        let mut supports = Supports {
            K: k.part(rows(), |j| self.place[j], self.free.len()),
            K_own: k.part(rows(), |j| self.place_of_held[j], p),
            load: rows().map(|i| f[i]).collect(),
            free_load: self.free.iter().map(|&i| f[i as usize]).collect(),
            displacement: values.to_vec(),
            B: Csr::zero(0, p),
            rigid: vec![[0.0; 6]; p],
            springs: None,
        };
        if let Some(nodes) = nodes {
            let held: Vec<u32> = rows().map(|i| i as u32).collect();
            supports.rigid = nodes.rows(&held);
        }
        Ok((stiffness, Some(supports)))
    }
}

fn hear_event(hear: &Bound<'_, PyAny>, event: &(SolveEvent, f64)) -> PyResult<bool> {
    let (event, seconds) = event;
    let (phase, p) = match event {
        SolveEvent::SettingUp { .. } => ("set-up", None),
        SolveEvent::Ordering => ("ordering", None),
        SolveEvent::Factorising { .. } => ("factorisation", None),
        SolveEvent::Solving => ("solving", None),
        SolveEvent::Iteration(p) => (phase_name(p.phase), Some(p)),
    };
    let numbers = p.map_or((0, f64::NAN, 0, 0, 0), |p| (p.iteration, p.residual, p.open, p.stick, p.slip));
    let (iteration, residual, open, stick, slip) = numbers;
    hear.call1((phase, iteration, residual, open, stick, slip, seconds))?.extract()
}

pub(crate) fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Newton => "newton",
        Phase::Gradient => "gradient",
        Phase::FixedPoint => "fixed point",
        Phase::Proximal => "proximal",
        Phase::Uzawa => "uzawa",
        Phase::Multigrid => "multigrid",
    }
}

pub(crate) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::MaxIterations => "max_iterations",
        Status::Stalled => "stalled",
        Status::NoEquilibrium => "no_equilibrium",
        Status::Uncertified => "uncertified",
        Status::PassesThrough => "passes_through",
        Status::Interrupted => "interrupted",
    }
}

/// Why nothing balances the loads, with the remedy, if the status says so.
pub(crate) fn no_equilibrium(problem: &ContactProblem, status: Status) -> Option<String> {
    stiction::run::escape(problem, status).map(explained)
}

/// The same in one sentence.
pub(crate) fn explained(escape: Escape) -> String {
    format!("there is no equilibrium: {}; {}", escape.sentence(), escape.remedy)
}

/// A solution with the jumps at the points.
struct Answer {
    solution: Solution,
    /// `[gap - N u; slip_reference - T u]`.
    jumps: Vec<f64>,
}

impl Answer {
    fn new(problem: &ContactProblem, solution: Solution) -> Self {
        Answer { jumps: problem.gap_and_slip(&solution.u), solution }
    }

    fn dict(self, py: Python<'_>, problem: Arc<ContactProblem>) -> PyResult<Bound<'_, PyDict>> {
        let Answer { solution, mut jumps } = self;
        let m = solution.states.len();
        jumps[m..].iter_mut().for_each(|slip| *slip = 0.0 - *slip);
        let dict = PyDict::new(py);
        dict.set_item("status", status_name(solution.status))?;
        dict.set_item("why", no_equilibrium(&problem, solution.status))?;
        let path = match solution.path {
            SolverPath::Multigrid => "multigrid",
            SolverPath::Solves => "solves",
            SolverPath::Dense | SolverPath::Auto => "dense",
        };
        dict.set_item("method", path)?;
        dict.set_item("forces", pointwise(py, &solution.lambda, 3)?)?;
        dict.set_item("slip", pointwise(py, &jumps[m..], 2)?)?;
        jumps.truncate(m);
        dict.set_item("gap", PyArray1::from_vec(py, jumps))?;
        dict.set_item("state", PyArray1::from_iter(py, solution.states.iter().map(|state| state.code())))?;
        dict.set_item("certificate", certificate(py, &solution.certificate)?)?;
        let c = &solution.counts;
        let counts = PyDict::new(py);
        for (name, count) in [
            ("newton_steps", c.newton_steps),
            ("restarts", c.restarts),
            ("fixed_point_steps", c.fixed_point_steps),
            ("products", c.products),
            ("solves", c.solves),
            ("cycles", c.cycles),
        ] {
            counts.set_item(name, count)?;
        }
        dict.set_item("counts", counts)?;
        let history = solution
            .history
            .iter()
            .map(|p| [p.iteration as f64, p.residual, p.products as f64, p.open as f64, p.stick as f64, p.slip as f64]);
        dict.set_item("history", table(py, history.collect::<Vec<_>>().as_flattened(), 6)?)?;
        dict.set_item("u", PyArray1::from_vec(py, solution.u))?;
        let matrices = Matrices { problem, states: solution.states, body: None };
        dict.set_item("matrices", Py::new(py, matrices)?)?;
        Ok(dict)
    }
}

pub(crate) fn certificate<'py>(py: Python<'py>, judged: &Certificate) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("measures", judged.measures())?;
    let parts = judged.parts.iter().map(|part| (part.part.name(), part.name.clone(), part.residual));
    dict.set_item("parts", parts.collect::<Vec<_>>())?;
    dict.set_item("worst", judged.worst)?;
    dict.set_item("tolerance", judged.tolerance)?;
    dict.set_item("part_tolerance", judged.part_tolerance())?;
    dict.set_item("passed", judged.passed)?;
    dict.set_item("error_bound", judged.duality_gap)?;
    Ok(dict)
}
