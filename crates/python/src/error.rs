//! Rust errors as the exceptions of `supple.errors`.

use std::io;
use std::path::Path;

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use supple_io::obj::{ObjError, ObjProblem};

/// The exceptions of `supple.errors`, by their names without `Error`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Exception {
    Mesh,
    Lattice,
    Scene,
    Output,
}

impl Exception {
    /// The exception with a message.
    pub(crate) fn with(self, message: String) -> PyErr {
        Python::attach(|py| {
            let class =
                py.import("supple.errors").and_then(|errors| errors.getattr(format!("{self:?}Error")));
            class.and_then(|class| class.call1((message,))).map_or_else(|error| error, PyErr::from_value)
        })
    }

    /// A `ValueError` of an argument as this exception, which is one too; others as they are.
    pub(crate) fn of_value_error(self, error: PyErr) -> PyErr {
        Python::attach(|py| match error.is_instance_of::<PyValueError>(py) {
            true => self.with(error.value(py).to_string()),
            false => error,
        })
    }
}

/// Any error of the core.
pub(crate) fn of(error: impl Into<supple::Error>) -> PyErr {
    match error.into() {
        supple::Error::Mesh(error) => Exception::Mesh.with(error.to_string()),
        supple::Error::Lattice(error) => Exception::Lattice.with(error.to_string()),
        error => value(error),
    }
}

/// What is wrong with an OBJ file.
pub(crate) fn of_obj(error: ObjError) -> PyErr {
    match error {
        ObjError { path, problem: ObjProblem::Read(source), .. } => of_file(&path, &source),
        error => Exception::Mesh.with(error.to_string()),
    }
}

/// A wrong value.
pub(crate) fn value(error: impl std::error::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// What the system said about a file: `FileNotFoundError`, `PermissionError`, ...
pub(crate) fn of_file(path: &Path, error: &io::Error) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            let text = error.to_string();
            let reason = text.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((number, reason, path.as_os_str().to_owned()))
        }
        None => PyOSError::new_err(format!("{}: {error}", path.display())),
    }
}
