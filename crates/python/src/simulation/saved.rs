//! Saves and restores the state of `supple.Simulation`.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use supple_io::saved_state;

use super::Simulation;
use crate::argument::conversion_error;

#[pymethods]
impl Simulation {
    /// Return the state of the simulation as bytes, for restore_state.
    ///
    /// The state has positions, velocities, rotations, pins and handles with the poses that they captured, forces and
    /// impulses that still act, contacts, which bodies sleep, which links are broken, the motion of driven colliders,
    /// time, gravity, fields, the length and number of steps, and the settings of the bodies that can change between
    /// steps. It has neither sleep, threads, the shapes, keyframes and enabled of colliders, the animations that handles
    /// follow, links, nor the callbacks of add_force_field.
    fn save_state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.shared.with(py, |simulation| saved_state::save(simulation))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Restore a state that save_state returned. The simulation then continues bit-identically, and bodies that
    /// slept sleep.
    ///
    /// state : bytes-like
    ///     A state of this simulation, or of one that was built with the same bodies, number of colliders, and fps.
    ///     Pins and handles that were added after the state was saved no longer exist. A body must still have the
    ///     handles that follow an animation, or others with the same selection and animation.
    ///
    /// fields and contacts() are those of the state. Raises ValueError for the state of another simulation, of another
    /// version of supple, and for damaged data; the simulation is then unchanged.
    fn restore_state(&self, state: &Bound<'_, PyAny>) -> PyResult<()> {
        let py = state.py();
        let bytes = match state.cast::<PyBytes>() {
            Ok(bytes) => bytes.clone(),
            // memoryview takes objects with the buffer protocol only; bytes() would also take numbers.
            Err(_) => py
                .import("builtins")?
                .call_method1("memoryview", (state,))
                .and_then(|view| view.call_method0("tobytes"))
                .map_err(|error| conversion_error(error, state, "state", "bytes from save_state()"))?
                .cast_into()?,
        };
        let data = bytes.as_bytes();
        let restored = self.shared.with(py, |simulation| saved_state::restore(simulation, data))?;
        restored.map_err(|error| PyValueError::new_err(format!("state cannot be restored: {error}")))
    }
}
