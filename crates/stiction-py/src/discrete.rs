//! Discrete problems of friction, given as matrices.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::discrete::{
    Bilateral, DiscreteProblem, Equalities, Form, GlobalProblem, LocalProblem, Method, Progress, Settings,
};
use stiction::io::Contents;
use stiction::run::algebraic::{Answer, answer, read};
use stiction::{Csr, Error};

use crate::arrays::table;
use crate::errors::{raised, wrong};
use crate::matrix::Rows;
use crate::work::{borrowed, run};

type Reals<'py> = PyReadonlyArray1<'py, f64>;

/// A discrete problem that has been checked.
#[pyclass(frozen, module = "stiction._stiction")]
pub(crate) struct Discrete(Arc<Contents>);

fn csr(py: Python<'_>, name: &str, rows: &Rows<'_>) -> PyResult<Csr> {
    let view = rows.view()?;
    let part = || view.part(0..view.rows, |j| j as u32, view.cols);
    let whole = borrowed(py, |stop| view.check(name, stop).map(|()| part()))?;
    whole.map_err(|error| raised(py, error))
}

fn checked(py: Python<'_>, problem: DiscreteProblem) -> PyResult<Discrete> {
    borrowed(py, |_| problem.validate())?.map_err(|error| raised(py, error))?;
    Ok(Discrete(Arc::new(Contents { problem, solution: None, guesses: Vec::new() })))
}

#[pymethods]
#[allow(non_snake_case)]
impl Discrete {
    /// `u = W r + q + V l`, `V' r + R l + s = 0`.
    #[staticmethod]
    #[pyo3(signature = (W, q, mu, dimension, bilateral))]
    fn local(
        py: Python<'_>,
        W: Rows<'_>,
        q: Reals<'_>,
        mu: Reals<'_>,
        dimension: usize,
        bilateral: Option<(Rows<'_>, Rows<'_>, Reals<'_>)>,
    ) -> PyResult<Self> {
        let bilateral = bilateral.map(|(V, R, s)| -> PyResult<_> {
            Ok(Bilateral { V: csr(py, "V", &V)?, R: csr(py, "R", &R)?, s: s.to_vec()? })
        });
        let bilateral = bilateral.transpose()?;
        let W = csr(py, "W", &W)?;
        checked(py, DiscreteProblem::Local(LocalProblem { dimension, W, q: q.to_vec()?, mu: mu.to_vec()?, bilateral }))
    }

    /// `M v = H r + f + G l`, `u = H' v + w`, `G' v + b = 0`.
    #[staticmethod]
    #[pyo3(signature = (M, H, f, w, mu, dimension, equalities))]
    #[allow(clippy::too_many_arguments)]
    fn global_(
        py: Python<'_>,
        M: Rows<'_>,
        H: Rows<'_>,
        f: Reals<'_>,
        w: Reals<'_>,
        mu: Reals<'_>,
        dimension: usize,
        equalities: Option<(Rows<'_>, Reals<'_>)>,
    ) -> PyResult<Self> {
        let equalities =
            equalities.map(|(G, b)| -> PyResult<_> { Ok(Equalities { G: csr(py, "G", &G)?, b: b.to_vec()? }) });
        let equalities = equalities.transpose()?;
        let (M, H) = (csr(py, "M", &M)?, csr(py, "H", &H)?);
        let (f, w, mu) = (f.to_vec()?, w.to_vec()?, mu.to_vec()?);
        checked(py, DiscreteProblem::Global(GlobalProblem { dimension, M, H, f, w, mu, equalities }))
    }

    /// From a file of FCLib, a NumPy file or a folder of Matrix Market files.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let contents = run(py, 1, move |_, _| read(&path), |(): ()| Ok(true))?;
        Ok(Discrete(Arc::new(contents.map_err(|error| raised(py, error))?)))
    }

    #[getter]
    fn dimension(&self) -> usize {
        self.0.problem.dimension()
    }

    #[getter]
    fn points(&self) -> usize {
        self.0.problem.points()
    }

    /// Vectors as arrays and matrices as `(rows, columns, indptr, indices, data)`, by their names.
    fn data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let vector = |name: &str, list: &[f64]| dict.set_item(name, PyArray1::from_slice(py, list));
        let matrix = |name: &str, matrix: &Csr| {
            let start = PyArray1::from_iter(py, matrix.start.iter().map(|&i| i as i64));
            let column = PyArray1::from_iter(py, matrix.column.iter().map(|&j| i64::from(j)));
            dict.set_item(name, (matrix.rows, matrix.cols, start, column, PyArray1::from_slice(py, &matrix.value)))
        };
        match &self.0.problem {
            DiscreteProblem::Local(p) => {
                matrix("W", &p.W)?;
                vector("q", &p.q)?;
                vector("mu", &p.mu)?;
                if let Some(Bilateral { V, R, s }) = &p.bilateral {
                    matrix("V", V)?;
                    matrix("R", R)?;
                    vector("s", s)?;
                }
            }
            DiscreteProblem::Global(p) => {
                matrix("M", &p.M)?;
                matrix("H", &p.H)?;
                vector("f", &p.f)?;
                vector("w", &p.w)?;
                vector("mu", &p.mu)?;
                if let Some(Equalities { G, b }) = &p.equalities {
                    matrix("G", G)?;
                    vector("b", b)?;
                }
            }
        }
        if let Some(solution) = &self.0.solution {
            vector("solution", solution)?;
        }
        Ok(dict)
    }

    /// Solves and judges. `hear` is called with iteration, residual, Newton steps and says whether to go on.
    #[pyo3(signature = (*, tolerance, max_iterations, method, form, start, threads, hear))]
    #[allow(clippy::too_many_arguments)]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        tolerance: f64,
        max_iterations: usize,
        method: &str,
        form: &str,
        start: Option<Reals<'py>>,
        threads: usize,
        hear: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let Some(method) = Method::named(method) else {
            let what = format!("{method:?} is no method");
            return Err(wrong(py, "method", what, "give auto, newton, gauss-seidel, gradient or admm"));
        };
        let form = match form {
            "auto" => Form::Auto,
            "condensed" => Form::Condensed,
            "sparse" => Form::Sparse,
            _ => return Err(wrong(py, "form", format!("{form:?} is no form"), "give auto, condensed or sparse")),
        };
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(wrong(py, "tolerance", format!("it is {tolerance}"), "give a positive number, such as 1e-8"));
        }
        let start = start.map(|start| start.to_vec()).transpose()?;
        let (contents, told) = (self.0.clone(), hear.is_some());
        let found: Result<Answer, Error> = run(
            py,
            threads,
            move |stop, teller| {
                let settings = Settings { tolerance, max_iterations, method, start };
                answer(&contents, &settings, form, &mut |progress: &Progress| {
                    let flow = if told { teller.tell(*progress) } else { ControlFlow::Continue(()) };
                    if stop.asked() { ControlFlow::Break(()) } else { flow }
                })
            },
            |progress| match &hear {
                Some(hear) => hear.call1((progress.iteration, progress.residual, progress.newton_steps))?.extract(),
                None => Ok(true),
            },
        )?;
        dict(py, self.dimension(), &found.map_err(|error| raised(py, error))?)
    }
}

fn dict<'py>(py: Python<'py>, dimension: usize, found: &Answer) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("status", found.status())?;
    dict.set_item("r", table(py, &found.solution.r, dimension)?)?;
    dict.set_item("u", table(py, &found.recovered.u, dimension)?)?;
    dict.set_item("v", PyArray1::from_slice(py, &found.recovered.v))?;
    dict.set_item("l", PyArray1::from_slice(py, &found.recovered.l))?;
    dict.set_item("measures", found.measures.all())?;
    dict.set_item("equilibrium", found.recovered.equilibrium)?;
    dict.set_item("tolerance", found.tolerance)?;
    dict.set_item("passed", found.passed())?;
    let c = &found.solution.counts;
    let counts = PyDict::new(py);
    for (name, count) in [
        ("iterations", c.iterations),
        ("newton_steps", c.newton_steps),
        ("sweeps", c.sweeps),
        ("gradients", c.gradients),
        ("alternations", c.alternations),
    ] {
        counts.set_item(name, count)?;
    }
    dict.set_item("counts", counts)?;
    let history =
        found.solution.history.iter().map(|p| [p.iteration as f64, p.residual, p.parameter, p.newton_steps as f64]);
    dict.set_item("history", table(py, history.collect::<Vec<_>>().as_flattened(), 4)?)?;
    Ok(dict)
}
