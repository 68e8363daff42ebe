//! The class of a force that acts on a body in every step.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::{PyTraverseError, PyVisit};
use supple_io::counted;

use super::Body;
use super::fields::{Field, Force, Source};
use crate::arrays;

/// A force that acts on a body in every step. Body.add_force_field returns it, and Body.force_fields lists those
/// that were not removed.
#[pyclass(frozen, module = "supple")]
pub(crate) struct ForceField {
    pub(super) body: Py<Body>,
    pub(super) id: u64,
}

impl ForceField {
    /// Returns the field.
    fn field(&self) -> PyResult<Arc<Field>> {
        let fields = self.body.get().fields.lock();
        fields.iter().find(|field| field.id == self.id).cloned().ok_or_else(|| {
            PyValueError::new_err("the force field was removed; add another one with body.add_force_field()")
        })
    }
}

#[pymethods]
impl ForceField {
    /// Body on which the force acts.
    #[getter]
    fn body(&self, py: Python<'_>) -> Py<Body> {
        self.body.clone_ref(py)
    }

    /// Force as it was given: (3,) or (k, 3) float64, read-only, or a callable. k is the number of vertices then.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.field()?.source.python(py))
    }

    /// Lattice vertices on which the force acts: (k,) int64, read-only. Copies that a break made come last.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let field = self.field()?;
        let vertices = |body: &supple::Body| match field.part.vertices(body.lattice()) {
            Some(list) => list.into_iter().map(i64::from).collect(),
            None => (0..body.lattice().len() as i64).collect::<Vec<_>>(),
        };
        Ok(arrays::frozen(PyArray1::from_vec(py, self.body.get().read(py, vertices)?)))
    }

    /// Whether the field was removed.
    #[getter]
    fn removed(&self) -> bool {
        self.field().is_err()
    }

    /// Remove the field, from the next step on. A second call has no effect.
    fn remove(&self) {
        let mut fields = self.body.get().fields.lock();
        let removed: Vec<_> = fields.extract_if(.., |field| field.id == self.id).collect();
        drop(fields);
        drop(removed);
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.body)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.id == other.id
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.id.hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let name = self.body.get().read(py, |body| body.name().to_owned())?;
        let Ok(field) = self.field() else {
            return Ok(format!("<supple.ForceField of body {name:?}: removed>"));
        };
        let part =
            self.body.get().read(py, |body| field.part.vertices(body.lattice()).map(|list| list.len()))?;
        let part = part.map_or_else(|| "all lattice vertices".to_owned(), |k| counted(k, "lattice vertex"));
        let force = match &field.source {
            Source::Constant(Force::Total([x, y, z])) => format!("({x}, {y}, {z})"),
            Source::Constant(Force::Each(_)) => "a constant force on each".to_owned(),
            Source::Function(function) => function.bind(py).repr()?.to_string(),
        };
        Ok(format!("<supple.ForceField of body {name:?}: {force}, on {part}>"))
    }
}
