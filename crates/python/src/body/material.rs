//! What a user may change between steps: stiffness and damping.

use pyo3::prelude::*;
use supple::{Damping, Stiffness};

use super::Body;
use crate::error;

#[pymethods]
impl Body {
    /// alpha per step, in (0, 1]; None where a frequency is set. Can be set, which replaces a frequency.
    #[getter]
    fn stiffness(&self, py: Python<'_>) -> Option<f64> {
        self.read(py, |body| match body.material().stiffness {
            Stiffness::PerStep(alpha) => Some(alpha),
            Stiffness::Frequency(_) => None,
        })
    }

    #[setter]
    fn set_stiffness(&self, py: Python<'_>, stiffness: f64) -> PyResult<()> {
        self.with(py, |body| body.set_stiffness(Stiffness::PerStep(stiffness))).map_err(error::value)
    }

    /// Frequency of a vertex about its goal in Hz, > 0; None where alpha is set. Can be set, which replaces alpha.
    #[getter]
    fn frequency(&self, py: Python<'_>) -> Option<f64> {
        self.read(py, |body| match body.material().stiffness {
            Stiffness::PerStep(_) => None,
            Stiffness::Frequency(hertz) => Some(hertz),
        })
    }

    #[setter]
    fn set_frequency(&self, py: Python<'_>, frequency: f64) -> PyResult<()> {
        self.with(py, |body| body.set_stiffness(Stiffness::Frequency(frequency))).map_err(error::value)
    }

    /// Region damping per step, in [0, 1]; None where a rate is set. Can be set, which replaces a rate.
    #[getter]
    fn damping(&self, py: Python<'_>) -> Option<f64> {
        self.read(py, |body| match body.material().damping {
            Damping::PerStep(share) => Some(share),
            Damping::Rate(_) => None,
        })
    }

    #[setter]
    fn set_damping(&self, py: Python<'_>, damping: f64) -> PyResult<()> {
        self.with(py, |body| body.set_damping(Damping::PerStep(damping))).map_err(error::value)
    }

    /// Region damping as a rate in 1/s, >= 0; None where it is set per step. Can be set, which replaces that.
    #[getter]
    fn damping_rate(&self, py: Python<'_>) -> Option<f64> {
        self.read(py, |body| match body.material().damping {
            Damping::PerStep(_) => None,
            Damping::Rate(rate) => Some(rate),
        })
    }

    #[setter]
    fn set_damping_rate(&self, py: Python<'_>, rate: f64) -> PyResult<()> {
        self.with(py, |body| body.set_damping(Damping::Rate(rate))).map_err(error::value)
    }

    /// Mass per volume.
    #[getter]
    fn density(&self, py: Python<'_>) -> f64 {
        self.read(py, |body| body.material().density)
    }
}
