//! Bodies move into a simulation.

use std::mem;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple::SimulationBuilder;

use super::Simulation;
use crate::argument::wrong_type;
use crate::body::{Body, Home, World};
use crate::error;

/// The simulation of `bodies`, all of which move in, or none.
pub(super) fn simulation(bodies: &Bound<'_, PyAny>, builder: SimulationBuilder) -> PyResult<Simulation> {
    let py = bodies.py();
    let bodies = list(bodies)?;
    builder.validate().map_err(error::of)?;
    if bodies.is_empty() {
        return Err(error::of(supple::Error::NoBody));
    }
    let shared: Vec<&Body> = bodies.iter().map(|body| body.get()).collect();
    let built = py.detach(|| {
        let taken = take(&shared)?;
        let simulation = taken.into_iter().fold(builder, |builder, body| builder.body(*body)).build();
        simulation.map_err(Refusal::Error)
    });
    let world = Arc::new(World::new(built.map_err(|refusal| refusal.into_error(&bodies))?));
    for (index, body) in shared.iter().enumerate() {
        py.detach(|| *body.home() = Home::In(world.clone(), index));
    }
    Ok(Simulation { world, bodies: bodies.iter().map(|body| body.clone().unbind()).collect() })
}

/// Why bodies stay where they are.
enum Refusal {
    Taken(usize),
    Error(supple::Error),
}

impl Refusal {
    fn into_error(self, bodies: &[Bound<'_, Body>]) -> PyErr {
        match self {
            Self::Error(error) => error::of(error),
            Self::Taken(index) => {
                let twice = bodies[..index].iter().position(|body| body.is(&bodies[index]));
                PyValueError::new_err(match twice {
                    Some(first) => format!("bodies[{index}] is bodies[{first}]; build a body for each"),
                    None => format!(
                        "bodies[{index}] already belongs to a simulation; build another Body for this one"
                    ),
                })
            }
        }
    }
}

/// Takes all bodies out of their homes, or none.
fn take(bodies: &[&Body]) -> Result<Vec<Box<supple::Body>>, Refusal> {
    let mut taken = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let mut home = body.home();
        match mem::replace(&mut *home, Home::Moving) {
            Home::Alone(alone) => taken.push(alone),
            elsewhere => {
                *home = elsewhere;
                drop(home);
                for (body, alone) in bodies.iter().zip(taken) {
                    *body.home() = Home::Alone(alone);
                }
                return Err(Refusal::Taken(index));
            }
        }
    }
    Ok(taken)
}

fn list<'py>(bodies: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, Body>>> {
    let items = match bodies.is_instance_of::<Body>() {
        true => None,
        false => bodies.try_iter().ok(),
    };
    let items = items.ok_or_else(|| wrong_type(bodies, "bodies", "a list of Body"))?;
    let body = |(index, item): (usize, PyResult<Bound<'py, PyAny>>)| {
        let item = item?;
        item.cast_into::<Body>()
            .map_err(|error| wrong_type(&error.into_inner(), &format!("bodies[{index}]"), "a Body"))
    };
    items.enumerate().map(body).collect()
}
