//! What a user may change between steps: half-width, stiffness, damping, and how the volume is kept.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{Damping, RegionSize, Stiffness};

use super::Body;
use super::build::{read_volume, volume_settings};
use crate::argument::{count, number};
use crate::error;

#[pymethods]
impl Body {
    /// Half-width of the regions in cells: as given, at most the extent of the lattice. Can be set, which replaces a
    /// stiffness_radius and takes as long as building the regions does.
    #[getter]
    fn half_width(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, supple::Body::half_width)
    }

    #[setter]
    fn set_half_width(&self, py: Python<'_>, half_width: &Bound<'_, PyAny>) -> PyResult<()> {
        let cells = count(half_width, "half_width", 1)?;
        self.with(py, |body| body.set_region_size(RegionSize::Cells(cells)))?.map_err(error::value)
    }

    /// Half-width of the regions as a length, > 0; None where it is set in cells. Can be set, which replaces that.
    #[getter]
    fn stiffness_radius(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.read(py, |body| match body.material().region_size {
            RegionSize::Cells(_) => None,
            RegionSize::Radius(radius) => Some(radius),
        })
    }

    #[setter]
    fn set_stiffness_radius(&self, py: Python<'_>, radius: &Bound<'_, PyAny>) -> PyResult<()> {
        let radius = number(radius, "stiffness_radius")?;
        self.with(py, |body| body.set_region_size(RegionSize::Radius(radius)))?.map_err(error::value)
    }

    /// alpha per step, in (0, 1]; None where a frequency is set. Can be set, which replaces a frequency.
    #[getter]
    fn stiffness(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.read(py, |body| match body.material().stiffness {
            Stiffness::PerStep(alpha) => Some(alpha),
            Stiffness::Frequency(_) => None,
        })
    }

    #[setter]
    fn set_stiffness(&self, py: Python<'_>, stiffness: &Bound<'_, PyAny>) -> PyResult<()> {
        let stiffness = number(stiffness, "stiffness")?;
        self.with(py, |body| body.set_stiffness(Stiffness::PerStep(stiffness)))?.map_err(error::value)
    }

    /// Frequency of a vertex about its goal in Hz, > 0; None where alpha is set. Can be set, which replaces alpha.
    #[getter]
    fn frequency(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.read(py, |body| match body.material().stiffness {
            Stiffness::PerStep(_) => None,
            Stiffness::Frequency(hertz) => Some(hertz),
        })
    }

    #[setter]
    fn set_frequency(&self, py: Python<'_>, frequency: &Bound<'_, PyAny>) -> PyResult<()> {
        let frequency = number(frequency, "frequency")?;
        self.with(py, |body| body.set_stiffness(Stiffness::Frequency(frequency)))?.map_err(error::value)
    }

    /// Region damping per step, in [0, 1]; None where a rate is set. Can be set, which replaces a rate.
    #[getter]
    fn damping(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.read(py, |body| match body.material().damping {
            Damping::PerStep(share) => Some(share),
            Damping::Rate(_) => None,
        })
    }

    #[setter]
    fn set_damping(&self, py: Python<'_>, damping: &Bound<'_, PyAny>) -> PyResult<()> {
        let damping = number(damping, "damping")?;
        self.with(py, |body| body.set_damping(Damping::PerStep(damping)))?.map_err(error::value)
    }

    /// Region damping as a rate in 1/s, >= 0; None where it is set per step. Can be set, which replaces that.
    #[getter]
    fn damping_rate(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.read(py, |body| match body.material().damping {
            Damping::PerStep(_) => None,
            Damping::Rate(rate) => Some(rate),
        })
    }

    #[setter]
    fn set_damping_rate(&self, py: Python<'_>, rate: &Bound<'_, PyAny>) -> PyResult<()> {
        let rate = number(rate, "damping_rate")?;
        self.with(py, |body| body.set_damping(Damping::Rate(rate)))?.map_err(error::value)
    }

    /// How the volume is kept in what is shown: a dict with measure, scope, field, max_correction. Can be set to such a
    /// dict, or to the name of a measure, or to "off"; takes as long as building the correction does.
    #[getter]
    fn volume_options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let options = self.read(py, supple::Body::volume_options)?;
        volume_settings(py, &options)
    }

    #[setter]
    fn set_volume_options(&self, py: Python<'_>, volume: &Bound<'_, PyAny>) -> PyResult<()> {
        let options = read_volume(volume)?;
        self.with(py, |body| body.set_volume(options))?.map_err(error::value)
    }

    /// Mass per volume.
    #[getter]
    fn density(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |body| body.material().density)
    }
}
