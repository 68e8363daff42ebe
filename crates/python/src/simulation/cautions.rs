//! Warnings about a simulation, such as bodies that overlap.

use std::ffi::CString;

use pyo3::prelude::*;
use supple_io::run::Caution;

/// Warns about what the author of a scene probably does not expect, apart from what only the displayed surface or files
/// show. `level` is that of the calling code on the stack of Python functions.
pub(crate) fn warn(py: Python<'_>, cautions: &[Caution], level: i32) -> PyResult<()> {
    for caution in cautions {
        let category = match caution {
            Caution::Overlap(_) | Caution::InCollider { .. } => "ContactWarning",
            Caution::TooSoft { .. } => "MaterialWarning",
            Caution::Jump { .. } | Caution::Bridge { .. } => "SceneWarning",
            _ => continue,
        };
        let category = py.import("supple.errors")?.getattr(category)?;
        PyErr::warn(py, &category, &CString::new(caution.to_string())?, level)?;
    }
    Ok(())
}
