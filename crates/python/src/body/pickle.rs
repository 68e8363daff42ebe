//! Pickles of bodies: what they were made of, and the state that they are in.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use supple::BodySnapshot;

use super::Body;
use crate::error;

/// How a body is made anew: its shape and its keyword arguments.
pub(crate) type Recipe<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

#[pymethods]
impl Body {
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let class = py.get_type::<Self>();
        let shared = slf.get().world(py)?;
        // A body of a living simulation goes where that goes, as one of its bodies.
        if let Some((world, index)) = shared
            && let Some(simulation) = world.python(py)
        {
            return (class.getattr("_of")?, (simulation, index)).into_pyobject(py);
        }
        let snapshot = slf.get().read(py, supple::Body::snapshot)?;
        let state = PyBytes::new(py, &encode(&snapshot)?);
        let (shape, settings) = slf.get().recipe(py);
        (class.getattr("_restore")?, (shape, settings, state)).into_pyobject(py)
    }

    /// The body of a simulation that has this index.
    #[staticmethod]
    fn _of<'py>(simulation: &Bound<'py, PyAny>, index: usize) -> PyResult<Bound<'py, PyAny>> {
        simulation.getattr("bodies")?.get_item(index)
    }

    /// A body made anew, in the state that another was in.
    #[staticmethod]
    fn _restore(
        py: Python<'_>,
        shape: &Bound<'_, PyAny>,
        settings: &Bound<'_, PyDict>,
        state: &[u8],
    ) -> PyResult<Self> {
        let snapshot: BodySnapshot = decode(state)?;
        let body = Self::new(shape, Some(settings))?;
        body.with(py, |body| body.restore(&snapshot))?.map_err(error::of)?;
        Ok(body)
    }
}

impl Body {
    /// What the body was made of.
    pub(crate) fn recipe<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        (self.shape.bind(py).clone(), self.settings.bind(py).clone())
    }
}

/// The bytes of a state.
pub(crate) fn encode(state: &impl serde::Serialize) -> PyResult<Vec<u8>> {
    postcard::to_stdvec(state).map_err(error::value)
}

/// The state of bytes that `encode` made.
pub(crate) fn decode<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> PyResult<T> {
    postcard::from_bytes(bytes).map_err(|error| {
        PyValueError::new_err(format!("the pickle is not of this version of supple: {error}"))
    })
}
