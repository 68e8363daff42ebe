//! Where a body lives: alone, or in a simulation that all its bodies share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyWeakrefMethods, PyWeakrefReference};

use super::Body;
use crate::forked::{Forked, Owner};

/// Where a body lives. A body moves into a simulation once and stays.
pub(crate) enum Storage {
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
///
/// A process that was forked has no threads but one: the first who works on it there takes new ones.
pub(crate) struct World {
    /// A job that steps it holds it as well.
    simulation: Arc<Mutex<supple::Simulation>>,
    threads: usize,
    owner: Owner,
    /// The Python object of the simulation, as long as it lives.
    python: PyOnceLock<Py<PyWeakrefReference>>,
}

impl World {
    pub(crate) fn new(simulation: Arc<Mutex<supple::Simulation>>, threads: usize) -> Self {
        Self { simulation, threads, owner: Owner::new(), python: PyOnceLock::new() }
    }

    /// Threads as asked for; 0 = one for each processor.
    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// Tells the world which Python object is its simulation.
    pub(crate) fn set_python(&self, simulation: &Bound<'_, PyAny>) -> PyResult<()> {
        let reference = PyWeakrefReference::new(simulation)?;
        // A second `__init__` of the same object changes nothing.
        self.python.get_or_init(simulation.py(), || reference.unbind());
        Ok(())
    }

    /// The Python object of the simulation, if it still lives.
    pub(crate) fn python<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        self.python.get(py).and_then(|reference| reference.bind(py).upgrade())
    }

    /// The simulation. To be called without the GIL.
    ///
    /// # Errors
    ///
    /// If another thread was at work on it when the process was forked.
    pub(crate) fn lock(&self) -> Result<MutexGuard<'_, supple::Simulation>, Forked> {
        self.owner.lock(&self.simulation, |simulation| {
            simulation.abandon_threads();
            simulation.set_threads(self.threads).expect("as it was built with");
        })
    }

    /// Lets `work` have the simulation, without the GIL.
    pub(crate) fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Simulation) -> R + Send,
    ) -> PyResult<R> {
        Ok(py.detach(|| self.lock().map(|mut simulation| work(&mut simulation)))?)
    }
}

/// Where a body lives, locked.
enum Place<'a> {
    Alone(&'a mut supple::Body),
    In(&'a mut supple::Simulation, usize),
}

impl Body {
    /// Lets `work` have the body, without the GIL.
    pub(crate) fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Body) -> R + Send,
    ) -> PyResult<R> {
        self.visit(py, |place| match place {
            Place::Alone(body) => work(body),
            Place::In(simulation, index) => work(simulation.body_mut(index)),
        })
    }

    /// Lets `work` have the body as it is shown, without the GIL.
    pub(crate) fn displayed<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Displayed<'_>) -> R + Send,
    ) -> PyResult<R> {
        self.visit(py, |place| {
            let body = match place {
                Place::Alone(body) => body.alone(),
                Place::In(simulation, index) => simulation.body(index),
            };
            let mut display = self.display.lock().unwrap_or_else(PoisonError::into_inner);
            work(&mut display.evaluate(body))
        })
    }

    /// Lets `work` go to where the body lives, under its lock and without the GIL.
    fn visit<R: Send>(&self, py: Python<'_>, work: impl FnOnce(Place<'_>) -> R + Send) -> PyResult<R> {
        let done = py.detach(|| {
            let mut storage = self.storage()?;
            let (world, index) = match &mut *storage {
                Storage::Alone(body) => return Ok(work(Place::Alone(body))),
                Storage::In(world, index) => (world.clone(), *index),
                Storage::Moving => unreachable!("a body moves under its lock"),
            };
            drop(storage);
            world.lock().map(|mut simulation| work(Place::In(&mut simulation, index)))
        });
        Ok(done?)
    }

    /// As [`Body::with`], to read.
    pub(crate) fn read<R: Send>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&supple::Body) -> R + Send,
    ) -> PyResult<R> {
        self.with(py, |body| read(body))
    }

    /// The simulation that the body lives in, and its index there.
    pub(crate) fn world(&self, py: Python<'_>) -> PyResult<Option<(Arc<World>, usize)>> {
        let world = py.detach(|| {
            self.storage().map(|storage| match &*storage {
                Storage::In(world, index) => Some((world.clone(), *index)),
                Storage::Alone(_) | Storage::Moving => None,
            })
        });
        Ok(world?)
    }

    /// The lock on where the body lives. To be called without the GIL.
    pub(crate) fn storage(&self) -> Result<MutexGuard<'_, Storage>, Forked> {
        // A body by itself has no threads.
        self.owner.lock(&self.storage, |_| {})
    }
}
