//! Converts Rust errors to the exceptions of `supple.errors`.

use std::io;
use std::path::Path;

use pyo3::exceptions::{PyIsADirectoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use supple_io::Escaped;
use supple_io::frames::OutputError;
use supple_io::model::ModelError;

use crate::argument::is_from_python;

/// The exceptions of `supple.errors`. A variant has the name of its exception without `Error`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Exception {
    Mesh,
    Lattice,
    Scene,
    Output,
}

impl Exception {
    /// Creates the exception with a message.
    pub(crate) fn with(self, message: String) -> PyErr {
        Python::attach(|py| {
            let class =
                py.import("supple.errors").and_then(|errors| errors.getattr(format!("{self:?}Error")));
            class.and_then(|class| class.call1((message,))).map_or_else(|error| error, PyErr::from_value)
        })
    }

    /// Converts a `ValueError` to this exception, which is a subclass of it. Returns other errors unchanged, and
    /// errors from Python code.
    pub(crate) fn wrap_value_error(self, error: PyErr) -> PyErr {
        Python::attach(|py| match error.is_instance_of::<PyValueError>(py) {
            true if !is_from_python(&error, py) => self.with(error.value(py).to_string()),
            _ => error,
        })
    }
}

/// Converts an error of the core.
pub(crate) fn from_core(error: impl Into<supple::Error>) -> PyErr {
    match error.into() {
        supple::Error::Mesh(error) => Exception::Mesh.with(error.to_string()),
        supple::Error::Lattice(error) => Exception::Lattice.with(error.to_string()),
        error => value(error),
    }
}

/// Converts an error of a model file.
pub(crate) fn from_model(error: ModelError) -> PyErr {
    match error {
        ModelError::Read { path, source } => from_io(&path, &source),
        error => Exception::Mesh.with(error.to_string()),
    }
}

/// Converts an error of output files.
pub(crate) fn output(error: OutputError) -> PyErr {
    match error.is_input() {
        true => value(error),
        false => Exception::Output.with(error.to_string()),
    }
}

/// Converts any error to a `ValueError`.
pub(crate) fn value(error: impl std::error::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Converts an I/O error of a file: `FileNotFoundError`, `PermissionError`, ...
pub(crate) fn from_io(path: &Path, error: &io::Error) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            let text = error.to_string();
            let reason = text.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((number, reason, path.as_os_str().to_owned()))
        }
        None => {
            let message = format!("{}: {error}", Escaped(path.display()));
            match error.kind() {
                io::ErrorKind::IsADirectory => PyIsADirectoryError::new_err(message),
                _ => PyOSError::new_err(message),
            }
        }
    }
}
