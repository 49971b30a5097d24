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

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
