//! The bodies of `supple.Simulation` as a collection, and its reset.

use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyString};

use super::Simulation;
use crate::body::Body;

#[pymethods]
impl Simulation {
    /// Return the number of bodies.
    fn __len__(&self) -> usize {
        self.bodies.len()
    }

    /// Iterate over the bodies.
    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        slf.getattr("bodies")?.try_iter()
    }

    /// Return whether a body has this name, or is this body.
    fn __contains__(slf: &Bound<'_, Self>, item: &Bound<'_, PyAny>) -> PyResult<bool> {
        if let Ok(name) = item.cast::<PyString>() {
            let name = name.to_str()?;
            let has = |simulation: &mut supple::Simulation| {
                simulation.bodies().iter().any(|body| body.name() == name)
            };
            return slf.get().shared.with(slf.py(), has);
        }
        let is_body = item.is_instance_of::<Body>();
        Ok(is_body && slf.getattr("bodies")?.try_iter()?.any(|body| body.is_ok_and(|body| body.is(item))))
    }

    /// Set the simulation back to time 0, and the bodies to the state in which they were built.
    ///
    /// Placement, velocity and spin are those of the start; the bodies are whole, and have no plastic shapes, forces and
    /// contacts. Pins and handles capture positions anew, and colliders follow their keyframes. Settings, keyframes, pins,
    /// handles, fields, force fields and colliders stay as they are now. The next steps have the bits of a simulation that
    /// is built with them. With substeps="auto", the next step chooses the number of steps per frame.
    ///
    /// No copy of the first state is kept. It takes about as long as a step, and longer for a broken body.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.shared.with(py, supple::Simulation::reset)
    }
}
