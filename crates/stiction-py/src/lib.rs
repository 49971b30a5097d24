//! The module `stiction._stiction`: what the package `stiction` of Python is made of. Users see `python/stiction`.

mod arrays;
mod case;
mod discrete;
mod errors;
mod linear;
mod matrix;
mod mortar;
mod problem;
mod work;

use std::ffi::OsString;

use pyo3::prelude::*;

#[pymodule]
mod _stiction {
    use super::*;

    #[pymodule_export]
    use crate::case::Case;
    #[pymodule_export]
    use crate::discrete::Discrete;
    #[pymodule_export]
    use crate::linear::Matrices;
    #[pymodule_export]
    use crate::mortar::mortar;
    #[pymodule_export]
    use crate::problem::Problem;

    /// The command `stiction` with these arguments, that of the program's name first: its exit code. For a process of its own.
    #[pyfunction]
    fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| stiction_cli::run_command(arguments))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
