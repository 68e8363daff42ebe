//! Builds a simulation from Python bodies, which move into it.

use std::mem;
use std::sync::{Arc, Mutex};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple::{Field, Link, SimulationBuilder};
use supple_io::scene::nearest;

use super::tables::{check_fields, check_links};
use crate::argument::{conversion_error, wrong_type};
use crate::body::{Body, SharedBody, SharedSimulation, Storage};
use crate::error;
use crate::interrupt::interruptible;

/// Builds the simulation of `bodies`, and returns it with the bodies. All bodies move into the simulation; if there is
/// an error, no body moves.
pub(super) fn simulation(
    bodies: &Bound<'_, PyAny>,
    (builder, fields, links): (SimulationBuilder, Vec<Field>, Vec<Link>),
    threads: usize,
) -> PyResult<(Arc<SharedSimulation>, Vec<Arc<SharedBody>>)> {
    let py = bodies.py();
    let bodies = read_bodies(bodies)?;
    builder.validate().map_err(error::from_core)?;
    if bodies.is_empty() {
        return Err(error::from_core(supple::Error::NoBody));
    }
    if let Some((first, second)) = find_duplicate(&bodies) {
        let message =
            format!("bodies[{second}] is the same Body as bodies[{first}]; build a separate Body for each");
        return Err(PyValueError::new_err(message));
    }
    check_ignored(py, &bodies)?;
    let name = |body: &Bound<'_, Body>| body.get().read(py, |body| body.name().to_owned());
    let names = bodies.iter().map(name).collect::<PyResult<Vec<_>>>()?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    check_fields(&fields, &names)?;
    check_links(&links, &names)?;
    let builder = fields.into_iter().fold(builder, SimulationBuilder::field);
    let builder = links.into_iter().fold(builder, SimulationBuilder::link);
    let parts = bodies.iter().map(Body::share).collect::<PyResult<Vec<_>>>()?;
    let moving = parts.clone();
    let shared = interruptible(py, move || move_in(&moving, builder, threads))??;
    Ok((shared, parts))
}

/// Checks that the bodies that a body does not touch are other bodies of the simulation.
fn check_ignored(py: Python<'_>, bodies: &[Bound<'_, Body>]) -> PyResult<()> {
    let read = |body: &Bound<'_, Body>| {
        body.get().read(py, |body| (body.name().to_owned(), body.touching().ignored.clone()))
    };
    let bodies = bodies.iter().map(read).collect::<PyResult<Vec<_>>>()?;
    for (index, (_, ignored)) in bodies.iter().enumerate() {
        let others = || bodies.iter().enumerate().filter(|(other, _)| *other != index);
        let is_missing = |name: &&String| !others().any(|(_, (other, _))| other == *name);
        if let Some(name) = ignored.iter().find(is_missing) {
            let others: Vec<&str> = others().map(|(_, (name, _))| name.as_str()).collect();
            let way_out = match nearest(name, &others) {
                Some(nearest) => format!("the nearest name is {nearest:?}"),
                None => "the simulation has no other body".to_owned(),
            };
            return Err(PyValueError::new_err(format!(
                "bodies[{index}]: ignore names {name:?}, and no other body has this name; {way_out}"
            )));
        }
    }
    Ok(())
}

/// Moves the bodies from their storages to a shared simulation. If there is an error, no body moves.
fn move_in(
    bodies: &[Arc<SharedBody>],
    mut builder: SimulationBuilder,
    threads: usize,
) -> PyResult<Arc<SharedSimulation>> {
    // The bodies are locked in the order of their addresses, so that two threads that move the same bodies
    // cannot deadlock.
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    order.sort_by_key(|&index| Arc::as_ptr(&bodies[index]));
    let storage = |&index: &usize| bodies[index].storage().map(|storage| (index, storage));
    let mut storages = order.iter().map(storage).collect::<Result<Vec<_>, _>>()?;
    storages.sort_by_key(|(index, _)| *index);
    if let Some((index, _)) = storages.iter().find(|(_, storage)| !matches!(**storage, Storage::Alone(_))) {
        return Err(PyValueError::new_err(format!(
            "bodies[{index}] already belongs to a simulation, its `simulation`, or to one whose building was interrupted; build another Body for this one"
        )));
    }
    for (_, storage) in &mut storages {
        if let Storage::Alone(body) = mem::replace(&mut **storage, Storage::Moving) {
            builder = builder.body(*body);
        }
    }
    let simulation = builder.build().map_err(error::from_core)?;
    let shared = Arc::new(SharedSimulation::new(Arc::new(Mutex::new(simulation)), threads));
    for (index, storage) in &mut storages {
        **storage = Storage::In(shared.clone(), *index);
    }
    Ok(shared)
}

/// Returns the indices of two entries that are the same body, if there are any.
fn find_duplicate(bodies: &[Bound<'_, Body>]) -> Option<(usize, usize)> {
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    order.sort_by_key(|&index| (bodies[index].as_ptr(), index));
    order.windows(2).find(|pair| bodies[pair[0]].is(&bodies[pair[1]])).map(|pair| (pair[0], pair[1]))
}

/// Reads the `bodies` argument: a list or one body.
fn read_bodies<'py>(bodies: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, Body>>> {
    if let Ok(body) = bodies.cast::<Body>() {
        return Ok(vec![body.clone()]);
    }
    let items = bodies
        .try_iter()
        .map_err(|error| conversion_error(error, bodies, "bodies", "a list of Body, or a Body"))?;
    let body = |(index, item): (usize, PyResult<Bound<'py, PyAny>>)| {
        let item = item?;
        item.cast_into::<Body>()
            .map_err(|error| wrong_type(&error.into_inner(), &format!("bodies[{index}]"), "a Body"))
    };
    items.enumerate().map(body).collect()
}
