//! Where a body lives: alone, or in a simulation that all its bodies share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;

use super::Body;

/// Where a body lives. A body moves into a simulation once and stays.
pub(crate) enum Home {
    /// By itself, with no time.
    Alone(Box<supple::Body>),
    /// In a simulation, by its index.
    In(Arc<World>, usize),
    /// On its way into one.
    Moving,
}

/// A simulation that its own Python object and those of its bodies share.
///
/// Whoever works on it holds the lock and not the GIL; nobody waits for the lock with the GIL in hand, so neither can
/// wait for the other.
pub(crate) struct World {
    simulation: Mutex<supple::Simulation>,
}

impl World {
    pub(crate) fn new(simulation: supple::Simulation) -> Self {
        Self { simulation: Mutex::new(simulation) }
    }

    /// The simulation. To be called without the GIL.
    pub(crate) fn lock(&self) -> MutexGuard<'_, supple::Simulation> {
        locked(&self.simulation)
    }

    /// Lets `work` have the simulation, without the GIL.
    pub(crate) fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut supple::Simulation) -> R + Send) -> R {
        py.detach(|| work(&mut self.lock()))
    }
}

impl Body {
    /// Lets `work` have the body, without the GIL.
    pub(crate) fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut supple::Body) -> R + Send) -> R {
        py.detach(|| {
            let mut home = locked(&self.home);
            let (world, index) = match &mut *home {
                Home::Alone(body) => return work(body),
                Home::In(world, index) => (world.clone(), *index),
                Home::Moving => unreachable!("a body moves under its lock"),
            };
            drop(home);
            work(world.lock().body_mut(index))
        })
    }

    /// As [`Body::with`], to look at.
    pub(crate) fn read<R: Send>(&self, py: Python<'_>, look: impl FnOnce(&supple::Body) -> R + Send) -> R {
        self.with(py, |body| look(body))
    }

    /// The lock on where the body lives. To be called without the GIL.
    pub(crate) fn home(&self) -> MutexGuard<'_, Home> {
        locked(&self.home)
    }
}

/// Whatever panicked with the lock in hand left a body as whole as any.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
