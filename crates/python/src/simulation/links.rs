//! The links of a simulation, as dicts with the keys of a scene.

use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde::Deserialize;
use supple::Link;
use supple_io::scene::{LinkTable, nearest};

use super::{Simulation, tables};
use crate::{arrays, error, keys};

/// The argument `links`.
#[derive(Deserialize)]
struct LinkList {
    links: Vec<LinkTable>,
}

#[pymethods]
impl Simulation {
    /// Links between bodies: tuple of dict, with the keys of [[link]] in a scene, and force and broken.
    ///
    /// force, (3,) float64, is the force of the link on its body in the last step, in kg length/s^2; the other body has the
    /// opposite one. broken tells whether the link is broken.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let read = |simulation: &mut supple::Simulation| -> Vec<(Link, [f64; 3], bool)> {
            simulation.links().map(|link| (link.link.clone(), link.force.into(), link.is_broken)).collect()
        };
        let dict = |(link, force, is_broken)| -> PyResult<Bound<'py, PyDict>> {
            let dict = to_dict(py, link)?;
            dict.set_item("force", arrays::frozen(PyArray1::from_slice(py, &<[f64; 3]>::from(force))))?;
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

/// Reads the argument `links`: a list of dicts, or one.
pub(super) fn read(links: &Bound<'_, PyAny>) -> PyResult<Vec<Link>> {
    let LinkList { links } = tables::read(links, "links", &[])?;
    Ok(links.into_iter().map(|LinkTable(link)| link).collect())
}

/// Checks that the bodies that links join are bodies with these names.
pub(super) fn check_bodies(links: &[Link], names: &[&str]) -> PyResult<()> {
    for (index, link) in links.iter().enumerate() {
        link.validate().map_err(error::from_core)?;
        for (key, name) in [("body", Some(&link.body)), ("other", link.other.as_ref())] {
            if let Some(name) = name.filter(|name| !names.contains(&name.as_str())) {
                let way_out = nearest(name, names).map(|name| format!("; the nearest name is {name:?}"));
                return Err(PyValueError::new_err(format!(
                    "links[{index}].{key} is {name:?}, and no body of the simulation has this name{}",
                    way_out.unwrap_or_default()
                )));
            }
        }
    }
    Ok(())
}
