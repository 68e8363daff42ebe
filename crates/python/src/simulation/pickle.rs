//! Pickles of simulations: recipes of the bodies, settings, and the state to go on from bit for bit.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyTuple};
use supple::SimulationState;

use super::Simulation;
use crate::body::{Body, Recipe, decode, encode};
use crate::error;

#[pymethods]
impl Simulation {
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, this) = (slf.py(), slf.get());
        let state = this.world.with(py, |simulation| simulation.state())?;
        let state = PyBytes::new(py, &encode(&state)?);
        let bodies = PyList::new(py, this.bodies.iter().map(|body| body.get().recipe(py)))?;
        let settings = PyDict::new(py);
        settings.set_item("dt", this.dt(py)?)?;
        settings.set_item("colliders", this.colliders(py))?;
        settings.set_item("threads", this.world.threads())?;
        settings.set_item("substeps", this.substeps(py)?)?;
        (py.get_type::<Self>().getattr("_restore")?, (bodies, settings, state)).into_pyobject(py)
    }

    /// A simulation made anew, in the state that another was in.
    #[classmethod]
    fn _restore<'py>(
        class: &Bound<'py, pyo3::types::PyType>,
        bodies: Vec<Recipe<'py>>,
        settings: &Bound<'py, PyDict>,
        state: &[u8],
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = class.py();
        let state: SimulationState = decode(state)?;
        let body = |(shape, settings): &Recipe<'py>| py.get_type::<Body>().call((shape,), Some(settings));
        let bodies: Vec<_> = bodies.iter().map(body).collect::<PyResult<_>>()?;
        let simulation = class.call((bodies,), Some(settings))?;
        let world = &simulation.cast::<Self>()?.get().world;
        world.with(py, |simulation| simulation.restore(&state))?.map_err(error::of)?;
        Ok(simulation)
    }
}
