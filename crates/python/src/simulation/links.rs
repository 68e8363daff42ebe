//! The links of a simulation, as dicts with the keys of a scene.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple::Link;
use supple_io::scene::LinkTable;

use super::Simulation;
use crate::{arrays, keys};

#[pymethods]
impl Simulation {
    /// Links between bodies: tuple of dict, with the keys of [[link]] in a scene, and force and broken.
    ///
    /// force, (3,) float64, is the force of the link on its body in the last step, in kg length/s^2, zero after
    /// restore_state; the other body has the opposite one. broken tells whether the link is broken.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let read = |simulation: &mut supple::Simulation| -> Vec<(Link, [f64; 3], bool)> {
            simulation.links().map(|link| (link.link.clone(), link.force.into(), link.is_broken)).collect()
        };
        let dict = |(link, force, is_broken): (Link, [f64; 3], bool)| -> PyResult<Bound<'py, PyDict>> {
            let dict = to_dict(py, link)?;
            dict.set_item("force", arrays::frozen(PyArray1::from_slice(py, &force)))?;
            dict.set_item("broken", is_broken)?;
            Ok(dict)
        };
        let links = self.shared.with(py, read)?;
        PyTuple::new(py, links.into_iter().map(dict).collect::<PyResult<Vec<_>>>()?)
    }
}

impl Simulation {
    /// Returns the links as the argument `links`.
    pub(super) fn link_arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let read = |simulation: &mut supple::Simulation| -> Vec<Link> {
            simulation.links().map(|link| link.link.clone()).collect()
        };
        let links = self.shared.with(py, read)?.into_iter().map(|link| to_dict(py, link));
        PyTuple::new(py, links.collect::<PyResult<Vec<_>>>()?)
    }
}

/// Returns a link as a dict.
fn to_dict(py: Python<'_>, link: Link) -> PyResult<Bound<'_, PyDict>> {
    let keys = serde_json::Value::Object(LinkTable(link).to_keys());
    Ok(keys::to_python(py, &keys)?.cast_into()?)
}
