//! Reports, as the dataclasses of `supple.reports`.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};

/// A `supple.reports.VolumeReport`.
pub(crate) fn of_volume<'py>(py: Python<'py>, report: &supple::VolumeReport) -> PyResult<Bound<'py, PyAny>> {
    static REPORT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    static COMPONENT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let component = COMPONENT.import(py, "supple.reports", "ComponentReport")?;
    let mut components = Vec::with_capacity(report.components.len());
    for c in &report.components {
        components.push(component.call1((c.rest, c.before, c.after, c.lambda, c.residual, c.capped))?);
    }
    let volumes = PyDict::new(py);
    for (measure, v) in &report.volumes {
        volumes.set_item(measure.name(), (v.rest, v.before, v.after))?;
    }
    REPORT.import(py, "supple.reports", "VolumeReport")?.call1((
        report.measure.name(),
        report.rest,
        report.before,
        report.after,
        report.lambda,
        report.residual,
        report.capped,
        PyTuple::new(py, components)?,
        volumes,
    ))
}
