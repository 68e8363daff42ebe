//! `supple._core`: array checks, errors and classes over the `supple` crate.

use pyo3::prelude::*;

/// The compiled part of `supple`.
#[pymodule]
fn _core(_module: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
