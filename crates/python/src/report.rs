//! Reports, as the dataclasses of `supple.reports`.

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};

/// The dataclasses of `supple.reports`.
#[derive(Clone, Copy)]
pub(crate) enum Report {
    Volume,
    Component,
    Progress,
    Body,
    Run,
}

impl Report {
    /// A report with its fields in their order.
    pub(crate) fn make<'py>(
        self,
        py: Python<'py>,
        fields: impl PyCallArgs<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        static CLASSES: [PyOnceLock<Py<PyType>>; 5] = [const { PyOnceLock::new() }; 5];
        let name = match self {
            Self::Volume => "VolumeReport",
            Self::Component => "ComponentReport",
            Self::Progress => "Progress",
            Self::Body => "BodyReport",
            Self::Run => "RunReport",
        };
        CLASSES[self as usize].import(py, "supple.reports", name)?.call1(fields)
    }
}

/// A `supple.reports.VolumeReport`.
pub(crate) fn of_volume<'py>(py: Python<'py>, report: &supple::VolumeReport) -> PyResult<Bound<'py, PyAny>> {
    let mut components = Vec::with_capacity(report.components.len());
    for c in &report.components {
        let fields = (c.rest, c.before, c.after, c.lambda, c.residual, c.capped);
        components.push(Report::Component.make(py, fields)?);
    }
    let volumes = PyDict::new(py);
    for (measure, v) in &report.volumes {
        volumes.set_item(measure.name(), (v.rest, v.before, v.after))?;
    }
    let supple::VolumeReport { measure, rest, before, after, lambda, residual, capped, .. } = report;
    let components = PyTuple::new(py, components)?;
    let fields = (measure.name(), rest, before, after, lambda, residual, capped, components, volumes);
    Report::Volume.make(py, fields)
}
