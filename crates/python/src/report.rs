//! Converts reports to the dataclasses of `supple.reports`.

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple::ComponentReport;

/// Creates a report of the class `class` of `supple.reports` from its fields in order.
pub(crate) fn new_report<'py>(
    py: Python<'py>,
    class: &str,
    fields: impl PyCallArgs<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    py.import("supple.reports")?.getattr(class)?.call1(fields)
}

/// Creates a `supple.reports.VolumeReport`.
pub(crate) fn volume_report<'py>(
    py: Python<'py>,
    report: &supple::VolumeReport,
) -> PyResult<Bound<'py, PyAny>> {
    let component = |c: &ComponentReport| {
        new_report(py, "ComponentReport", (c.rest, c.before, c.after, c.lambda, c.residual, c.capped))
    };
    let components = report.components.iter().map(component).collect::<PyResult<Vec<_>>>()?;
    let volumes = PyDict::new(py);
    for (measure, v) in &report.volumes {
        volumes.set_item(measure.name(), (v.rest, v.before, v.after))?;
    }
    let supple::VolumeReport { measure, rest, before, after, lambda, residual, capped, .. } = report;
    let components = PyTuple::new(py, components)?;
    let fields = (measure.name(), rest, before, after, lambda, residual, capped, components, volumes);
    new_report(py, "VolumeReport", fields)
}
