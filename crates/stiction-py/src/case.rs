//! Cases: the keys of a case file, with meshes from memory as well.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use stiction::io::case::{self, MeshSource};
use stiction::io::lock::Lock;
use stiction::linalg::Stop;
use stiction::mesh::{CellArray, CellKind, Mesh, NodeArray, RawCells, RawGroup, RawMesh, build};
use stiction::run::{self, BodyFields, Event, Facts, Origin, Plan, Prepared, Side, Stage, SurfaceFields};
use stiction::{Error, SolveEvent, Status};

use crate::arrays::table;
use crate::errors::{raised, wrong};
use crate::linear::{Body, Matrices};
use crate::matrix::triples;
use crate::problem::{certificate, explained, phase_name, status_name};
use crate::work::{Teller, run as work};

/// A case that was read; its mesh may be that of the caller.
#[pyclass(frozen, module = "stiction._stiction")]
pub(crate) struct Case {
    case: Arc<case::Case>,
    origin: Origin,
    /// Posed for its facts, taken by the next solve.
    posed: Arc<Mutex<Option<Prepared>>>,
}

/// Name of the kind, nodes of each cell.
type Cells<'py> = (String, PyReadonlyArray2<'py, i64>);
/// Name, cells, corners of faces (-1 beyond those of a triangle), nodes.
type Group<'py> = (String, PyReadonlyArray1<'py, i64>, PyReadonlyArray2<'py, i64>, PyReadonlyArray1<'py, i64>);
/// Arrays on nodes: name and values. Arrays on cells: name, values of the cells and of the faces. Corners of the faces (-1 beyond those of
/// a triangle). Arrays that are not one number at each place, and what they are instead.
type Arrays<'py> = (
    Vec<(String, PyReadonlyArray1<'py, f64>)>,
    Vec<(String, PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
    PyReadonlyArray2<'py, i64>,
    Vec<(String, String)>,
);
/// Coordinates, cells, groups and arrays.
pub(crate) type Given<'py> = (PyReadonlyArray2<'py, f64>, Vec<Cells<'py>>, Vec<Group<'py>>, Arrays<'py>);

pub(crate) fn raw(py: Python<'_>, given: &Given<'_>) -> PyResult<RawMesh> {
    let nodes = triples(&given.0)?;
    let number = |name: &str, i: i64, count: usize| match u32::try_from(i) {
        Ok(i) if (i as usize) < count => Ok(i),
        _ => Err(wrong(py, name, format!("there is no number {i} among {count}"), "count from zero")),
    };
    let all = |name: &str, list: &[i64], count: usize| {
        list.iter().map(|&i| number(name, i, count)).collect::<PyResult<Vec<u32>>>()
    };
    let mut raw = RawMesh { nodes, ..RawMesh::default() };
    let count = raw.nodes.len();
    for (name, cells) in &given.1 {
        let Some(kind) = CellKind::ALL.into_iter().find(|kind| kind.name() == name) else {
            return Err(wrong(
                py,
                "mesh",
                format!("{name:?} is no kind of cell"),
                "give tet4, hex8, tet10, hex20, wedge6 or wedge15",
            ));
        };
        let nodes = all(&format!("mesh, cells {name}"), cells.as_slice()?, count)?;
        if nodes.len() % kind.nodes() != 0 {
            let what = format!("the cells {name} do not have {} nodes each", kind.nodes());
            return Err(wrong(py, "mesh", what, "give one row a cell"));
        }
        raw.cells.push(RawCells { kind, nodes, ids: Vec::new() });
    }
    let cell_count: usize = raw.cells.iter().map(|block| block.nodes.len() / block.kind.nodes()).sum();
    for (name, cells, faces, nodes) in &given.2 {
        let place = format!("mesh, group {name:?}");
        let corner = |&i: &i64| if i == -1 { Ok(u32::MAX) } else { number(&place, i, count) };
        let corners = faces.as_slice()?.iter().map(corner).collect::<PyResult<Vec<u32>>>()?;
        raw.groups.push(RawGroup {
            name: name.clone(),
            cells: all(&place, cells.as_slice()?, cell_count)?,
            faces: corners.as_chunks::<4>().0.to_vec(),
            nodes: all(&place, nodes.as_slice()?, count)?,
            ..RawGroup::default()
        });
    }
    let (of_nodes, of_cells, faces, others) = &given.3;
    let corner = |&i: &i64| if i == -1 { Ok(u32::MAX) } else { number("mesh, faces", i, count) };
    raw.array_faces = faces.as_slice()?.iter().map(corner).collect::<PyResult<Vec<u32>>>()?.as_chunks::<4>().0.to_vec();
    for (name, values) in of_nodes {
        let values = lengthy(py, name, values.as_slice()?, count)?;
        raw.arrays.nodes.push(NodeArray { name: name.clone(), values });
    }
    for (name, values, on_faces) in of_cells {
        let values = lengthy(py, name, values.as_slice()?, cell_count)?;
        let on_faces = lengthy(py, name, on_faces.as_slice()?, raw.array_faces.len())?;
        // Not a number: the array has none there.
        let faces = (0..).zip(on_faces).filter(|(_, value)| !value.is_nan()).collect();
        raw.arrays.cells.push(CellArray { name: name.clone(), values, faces });
    }
    raw.arrays.others.clone_from(others);
    raw.turn_wedges();
    Ok(raw)
}

fn lengthy(py: Python<'_>, name: &str, values: &[f64], count: usize) -> PyResult<Vec<f64>> {
    if values.len() != count {
        let what = format!("it has {} values where {count} are needed", values.len());
        return Err(wrong(py, &format!("mesh, array {name:?}"), what, "give one number for each node or each cell"));
    }
    Ok(values.to_vec())
}

#[pymethods]
impl Case {
    /// From the text of a case file, called `name` in messages, or from a file.
    #[new]
    fn new(
        py: Python<'_>,
        text: Option<String>,
        path: Option<PathBuf>,
        name: &str,
        overrides: Vec<(String, String)>,
        mesh: Option<Given<'_>>,
    ) -> PyResult<Self> {
        let read = match (&text, &path) {
            (Some(text), _) => case::parse(text, name, &overrides),
            (None, path) => case::read(path.as_deref().unwrap_or(Path::new("")), &overrides),
        };
        let mut case = read.map_err(|error| raised(py, error))?;
        if let Some(given) = mesh {
            let raw = raw(py, &given)?;
            let built = work(py, 0, move |_, _| build(raw), |(): ()| Ok(true))?;
            let built = built.map_err(|error| raised(py, error.at("mesh")))?;
            case.mesh.source = MeshSource::Given(Arc::new(built));
        }
        let text =
            text.unwrap_or_else(|| path.as_ref().and_then(|p| std::fs::read_to_string(p).ok()).unwrap_or_default());
        let origin = Origin { path, case_text: text, overrides, command: None };
        Ok(Case { case: Arc::new(case), origin, posed: Arc::default() })
    }

    #[getter]
    fn title(&self) -> &str {
        &self.case.title
    }

    /// What was understood of the case.
    fn facts<'py>(&self, py: Python<'py>, threads: usize) -> PyResult<Bound<'py, PyDict>> {
        let (case, posed) = (self.case.clone(), self.posed.clone());
        let facts: Result<Facts, Error> = work(
            py,
            threads,
            move |_, _| {
                let known = posed.try_lock().ok().and_then(|posed| posed.as_ref().map(|posed| posed.facts.clone()));
                if let Some(facts) = known {
                    return Ok(facts);
                }
                let prepared = run::prepare(&case)?;
                let facts = prepared.facts.clone();
                if let Ok(mut posed) = posed.try_lock() {
                    *posed = Some(prepared);
                }
                Ok(facts)
            },
            |(): ()| Ok(true),
        )?;
        let facts = facts.map_err(|error| raised(py, error))?;
        let dict = PyDict::new(py);
        dict.set_item("text", facts.to_string())?;
        dict.set_item("unknowns", facts.unknowns)?;
        dict.set_item("points", facts.points)?;
        dict.set_item("nodes", facts.mesh.nodes)?;
        dict.set_item("cells", facts.mesh.cells.iter().map(|cells| cells.count).sum::<usize>())?;
        dict.set_item("volume", facts.mesh.volume)?;
        dict.set_item("load", facts.resultant().to_vec())?;
        dict.set_item("warnings", &facts.warnings)?;
        dict.set_item("notes", &facts.notes)?;
        let contacts = PyDict::new(py);
        for contact in &facts.contacts {
            let surface = &contact.surface;
            let own = PyDict::new(py);
            own.set_item("points", surface.points)?;
            own.set_item("area", surface.area)?;
            own.set_item("gap", (surface.gap_min, surface.gap_max))?;
            own.set_item("overlapping", surface.overlapping)?;
            contacts.set_item(&surface.name, own)?;
        }
        dict.set_item("contacts", contacts)?;
        Ok(dict)
    }

    /// Solves the case, or all its load steps. `hear` is called with phase, iteration, residual, open, stick, slip, seconds, step,
    /// time and says whether to go on.
    #[pyo3(signature = (*, folder, resume, report, matrices, threads, hear))]
    #[allow(clippy::too_many_arguments)]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        folder: Option<PathBuf>,
        resume: bool,
        report: bool,
        matrices: bool,
        threads: usize,
        hear: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        if resume && folder.is_none() {
            return Err(wrong(py, "resume", "there is no folder to resume from", "give `folder`"));
        }
        let order = Order {
            case: self.case.clone(),
            origin: self.origin.clone(),
            posed: self.posed.clone(),
            folder,
            resume,
            report,
            matrices,
            told: hear.is_some(),
        };
        let found = work(
            py,
            threads,
            move |stop, teller| order.done(&stop, teller),
            |(news, seconds): (News, f64)| match &hear {
                Some(hear) => hear_news(hear, &news, seconds),
                None => Ok(true),
            },
        )?;
        found.map_err(|error| raised(py, error))?.dict(py)
    }
}

/// What a caller is told while a case is solved.
enum News {
    Event(Event),
    /// A mesh is solved: its number from 1 and its estimated error.
    Mesh(usize, f64),
}

impl News {
    fn of(stage: &Stage) -> Option<News> {
        match stage {
            Stage::Event(event) => Some(News::Event(**event)),
            Stage::Level(level) => Some(News::Mesh(level.level + 1, level.error)),
            _ => None,
        }
    }
}

fn hear_news(hear: &Bound<'_, PyAny>, news: &News, seconds: f64) -> PyResult<bool> {
    let none = (0, f64::NAN, 0, 0, 0);
    let event = match news {
        News::Event(event) => event,
        News::Mesh(number, error) => {
            return hear.call1(("mesh", number, error, 0, 0, 0, seconds, 0, f64::NAN))?.extract();
        }
    };
    let (phase, (iteration, residual, open, stick, slip), step, t) = match event {
        Event::Solver(SolveEvent::SettingUp { .. }) => ("set-up", none, 0, f64::NAN),
        Event::Solver(SolveEvent::Ordering) => ("ordering", none, 0, f64::NAN),
        Event::Solver(SolveEvent::Factorising { .. }) => ("factorisation", none, 0, f64::NAN),
        Event::Solver(SolveEvent::Solving) => ("solving", none, 0, f64::NAN),
        Event::Solver(SolveEvent::Iteration(p)) => {
            (phase_name(p.phase), (p.iteration, p.residual, p.open, p.stick, p.slip), 0, f64::NAN)
        }
        Event::Coulomb => ("uniqueness", none, 0, f64::NAN),
        Event::OtherStarts => ("other starts", none, 0, f64::NAN),
        Event::Step { number, t, .. } => ("step", none, *number, *t),
        Event::Halved { t, .. } => ("step halved", none, 0, *t),
        Event::Finished(line) => {
            ("step finished", (line.iterations, f64::NAN, line.open, line.stick, line.slip), line.number, line.t)
        }
    };
    hear.call1((phase, iteration, residual, open, stick, slip, seconds, step, t))?.extract()
}

/// What is to be done.
struct Order {
    case: Arc<case::Case>,
    origin: Origin,
    posed: Arc<Mutex<Option<Prepared>>>,
    folder: Option<PathBuf>,
    resume: bool,
    report: bool,
    /// Whether stiffness and masses are kept for whoever asks for modes.
    matrices: bool,
    told: bool,
}

/// A load step as it is kept for Python.
struct StepFields {
    t: f64,
    body: BodyFields,
    surfaces: Vec<SurfaceFields>,
}

/// What came of it.
struct Done {
    mesh: Mesh,
    status: Status,
    certificate: stiction::Certificate,
    why: Option<String>,
    summary: String,
    body: BodyFields,
    surfaces: Vec<SurfaceFields>,
    steps: Vec<StepFields>,
    files: Vec<String>,
    matrices: Option<Matrices>,
}

type Told = Teller<(News, f64), Result<Done, Error>>;

impl Order {
    /// The way of the command: solved again where contact turns up that was not looked for, then written.
    fn done(self, stop: &Stop, teller: &Told) -> Result<Done, Error> {
        // Held until all is written.
        let _lock = self.folder.as_deref().map(Lock::take).transpose()?;
        if let Some(folder) = &self.folder {
            run::writable(folder)?;
        }
        let begin = Instant::now();
        let mut steps = Vec::new();
        let mut hear = |stage: Stage| {
            match stage {
                // Of a mesh that was refined, or without contact that has been found since.
                Stage::Posing => steps.clear(),
                Stage::Step(prepared, step) => steps.push(StepFields {
                    t: step.records.last().map_or(f64::NAN, |record| record.t),
                    body: run::body_fields(prepared, step.outcome),
                    surfaces: run::surface_fields(prepared, step.outcome),
                }),
                _ => {}
            }
            let told = News::of(&stage).filter(|_| self.told);
            let told = told.map(|news| teller.tell((news, begin.elapsed().as_secs_f64())));
            if stop.asked() { ControlFlow::Break(()) } else { told.unwrap_or(ControlFlow::Continue(())) }
        };
        let posed = self.posed.try_lock().ok().and_then(|mut posed| posed.take());
        let plan = Plan { folder: self.folder.as_deref(), resume: self.resume, pictures: true };
        let (prepared, mut outcome, ahead) = run::solve_case(&self.case, &plan, stop, posed, &mut hear)?;
        let mut files = Vec::new();
        if let Some(folder) = &self.folder {
            files = run::write_with(&prepared, &mut outcome, &self.origin, folder, ahead)?;
            if self.report {
                run::write_report_on(folder, Some(&prepared.mesh))?;
                files.push(run::REPORT.into());
            }
        }
        let status = outcome.solution.status;
        let why = match status {
            Status::NoEquilibrium => run::escape_of(&prepared, status).map(explained),
            Status::PassesThrough => run::passes_through(&prepared, &outcome),
            _ => run::limit_load(&prepared, &outcome),
        };
        let summary = run::summary(&prepared, &outcome, &self.origin);
        let (body, surfaces) = (run::body_fields(&prepared, &outcome), run::surface_fields(&prepared, &outcome));
        let certificate = outcome.solution.certificate.clone();
        let (mesh, matrices) = match self.matrices {
            true => (
                prepared.mesh.clone(),
                Some(Matrices {
                    states: outcome.solution.states,
                    problem: Arc::new(prepared.problem),
                    body: Some(Body {
                        mesh: prepared.mesh,
                        materials: prepared.materials,
                        material_of_cell: prepared.material_of_cell,
                        dofs: prepared.model.dofs,
                    }),
                }),
            ),
            false => (prepared.mesh, None),
        };
        Ok(Done { mesh, status, certificate, why, summary, body, surfaces, steps, files, matrices })
    }
}

impl Done {
    fn dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("status", status_name(self.status))?;
        dict.set_item("certificate", certificate(py, &self.certificate)?)?;
        dict.set_item("why", self.why)?;
        dict.set_item("summary", self.summary)?;
        dict.set_item("files", self.files)?;
        dict.set_item("points", table(py, self.mesh.nodes.as_flattened(), 3)?)?;
        let cells = self.mesh.cells.iter().map(|cells| {
            let nodes = cells.nodes.iter().map(|&node| i64::from(node)).collect::<Vec<i64>>();
            (cells.kind.name(), PyArray1::from_vec(py, nodes))
        });
        dict.set_item("cells", PyList::new(py, cells)?)?;
        body(py, &dict, &self.body)?;
        dict.set_item("surfaces", surfaces(py, &self.surfaces)?)?;
        let steps = PyList::empty(py);
        for step in &self.steps {
            let own = PyDict::new(py);
            own.set_item("t", step.t)?;
            body(py, &own, &step.body)?;
            own.set_item("surfaces", surfaces(py, &step.surfaces)?)?;
            steps.append(own)?;
        }
        dict.set_item("steps", steps)?;
        dict.set_item("matrices", self.matrices.map(|matrices| Py::new(py, matrices)).transpose()?)?;
        Ok(dict)
    }
}

fn body(py: Python<'_>, dict: &Bound<'_, PyDict>, fields: &BodyFields) -> PyResult<()> {
    dict.set_item("displacement", table(py, fields.displacement.as_flattened(), 3)?)?;
    dict.set_item("reaction", table(py, fields.reaction.as_flattened(), 3)?)?;
    dict.set_item("stress", singles(py, &fields.stress)?)?;
    dict.set_item("von_mises", PyArray1::from_slice(py, &fields.von_mises))?;
    dict.set_item("cell_error", PyArray1::from_slice(py, &fields.error))
}

fn singles<'py>(py: Python<'py>, stress: &[[f32; 6]]) -> PyResult<Bound<'py, PyArray2<f32>>> {
    use numpy::PyArrayMethods;
    PyArray1::from_slice(py, stress.as_flattened()).reshape([stress.len(), 6])
}

fn surfaces<'py>(py: Python<'py>, all: &[SurfaceFields]) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for surface in all {
        let dict = PyDict::new(py);
        dict.set_item("name", &surface.name)?;
        dict.set_item("master", surface.side == Side::Master)?;
        dict.set_item("nodes", PyArray1::from_iter(py, surface.nodes.iter().map(|&node| i64::from(node))))?;
        dict.set_item("points", table(py, surface.points.as_flattened(), 3)?)?;
        dict.set_item("faces", PyList::new(py, &surface.faces)?)?;
        dict.set_item("state", PyArray1::from_slice(py, &surface.status))?;
        for (name, list) in [("pressure", &surface.pressure), ("gap", &surface.gap)] {
            dict.set_item(name, PyArray1::from_slice(py, list))?;
        }
        for (name, vectors) in
            [("shear", &surface.shear), ("slip", &surface.slip), ("slid", &surface.slid), ("forces", &surface.lambda)]
        {
            dict.set_item(name, table(py, vectors.as_flattened(), 3)?)?;
        }
        list.append(dict)?;
    }
    Ok(list)
}
