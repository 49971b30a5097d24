//! Between the order of the library, one component after the other, and that of Python, one point after the other.

use numpy::ndarray::Array2;
use numpy::{PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// `[a; b; ..]` of `m` numbers each as an array of shape `(m, components)`.
pub(crate) fn pointwise<'py>(py: Python<'py>, list: &[f64], components: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let m = list.len() / components;
    Ok(Array2::from_shape_fn((m, components), |(j, c)| list[c * m + j]).to_pyarray(py))
}

/// The other way.
pub(crate) fn stacked(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<f64>> {
    let array = array.as_array();
    Ok(array.columns().into_iter().flat_map(|column| column.to_vec()).collect())
}

/// Rows of `columns` numbers, one after the other.
pub(crate) fn table<'py>(py: Python<'py>, list: &[f64], columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = list.len() / columns;
    let table = Array2::from_shape_vec((rows, columns), list[..rows * columns].to_vec());
    Ok(table.map_err(|error| PyRuntimeError::new_err(error.to_string()))?.to_pyarray(py))
}
