//! Stores a body outside a simulation, or refers to a simulation that several bodies share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyWeakrefMethods, PyWeakrefReference};

use super::Body;
use crate::forked::{Forked, Owner};

/// The storage of a body. A body moves into a simulation at most once and then stays in it.
pub(crate) enum Storage {
    /// Outside a simulation.
    Alone(Box<supple::Body>),
    /// In a simulation, at this index.
    In(Arc<SharedSimulation>, usize),
    /// The body is being moved into a simulation; the storage is locked.
    Moving,
}

/// A simulation that its Python object and the Python objects of its bodies share.
///
/// A thread releases the GIL before it waits for the lock of the simulation, and works without the GIL. The
/// lock and the GIL therefore cannot deadlock.
///
/// A forked process has only one thread. The first access in a forked process starts a new thread pool.
pub(crate) struct SharedSimulation {
    /// A [`Job`](supple_io::run::Job) that runs the simulation also has a reference to it.
    simulation: Arc<Mutex<supple::Simulation>>,
    /// The requested number of threads; 0 = one per processor.
    threads: usize,
    /// Process that last locked `simulation`.
    owner: Owner,
    /// Weak reference to the Python object of the simulation.
    python: PyOnceLock<Py<PyWeakrefReference>>,
}

impl SharedSimulation {
    pub(crate) fn new(simulation: Arc<Mutex<supple::Simulation>>, threads: usize) -> Self {
        Self { simulation, threads, owner: Owner::new(), python: PyOnceLock::new() }
    }

    /// Returns the requested number of threads; 0 = one per processor.
    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// Sets the Python object of the simulation.
    pub(crate) fn set_python_object(&self, simulation: &Bound<'_, PyAny>) -> PyResult<()> {
        let reference = PyWeakrefReference::new(simulation)?;
        // A second `__init__` of the same object changes nothing.
        self.python.get_or_init(simulation.py(), || reference.unbind());
        Ok(())
    }

    /// Returns the Python object of the simulation, if it still exists.
    pub(crate) fn python_object<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        self.python.get(py).and_then(|reference| reference.bind(py).upgrade())
    }

    /// Locks the simulation. Call it without the GIL.
    ///
    /// # Errors
    ///
    /// An error if another thread used the simulation when the process was forked.
    pub(crate) fn lock(&self) -> Result<MutexGuard<'_, supple::Simulation>, Forked> {
        self.owner.lock(&self.simulation, |simulation| {
            simulation.abandon_threads();
            simulation.set_threads(self.threads).expect("the number of threads is valid");
        })
    }

    /// Calls `work` with the simulation, without the GIL.
    pub(crate) fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Simulation) -> R + Send,
    ) -> PyResult<R> {
        Ok(py.detach(|| self.lock().map(|mut simulation| work(&mut simulation)))?)
    }
}

/// A body whose storage is locked.
enum LockedBody<'a> {
    /// A body outside a simulation.
    Alone(&'a mut supple::Body),
    /// A simulation, and the index of the body in it.
    In(&'a mut supple::Simulation, usize),
}

impl Body {
    /// Calls `work` with the body, without the GIL.
    pub(crate) fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Body) -> R + Send,
    ) -> PyResult<R> {
        self.with_locked(py, |locked| match locked {
            LockedBody::Alone(body) => work(body),
            LockedBody::In(simulation, index) => work(simulation.body_mut(index)),
        })
    }

    /// Calls `work` with the body evaluated for display, without the GIL.
    pub(crate) fn displayed<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Displayed<'_>) -> R + Send,
    ) -> PyResult<R> {
        self.with_locked(py, |locked| {
            let body = match locked {
                LockedBody::Alone(body) => body.alone(),
                LockedBody::In(simulation, index) => simulation.body(index),
            };
            let mut display = self.display.lock().unwrap_or_else(PoisonError::into_inner);
            work(&mut display.evaluate(body))
        })
    }

    /// Calls `work` with the body while its storage or its simulation is locked, without the GIL.
    fn with_locked<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(LockedBody<'_>) -> R + Send,
    ) -> PyResult<R> {
        let result = py.detach(|| {
            let mut storage = self.storage()?;
            let (shared, index) = match &mut *storage {
                Storage::Alone(body) => return Ok(work(LockedBody::Alone(body))),
                Storage::In(shared, index) => (shared.clone(), *index),
                Storage::Moving => unreachable!("the storage stays locked while the body is moved"),
            };
            drop(storage);
            shared.lock().map(|mut simulation| work(LockedBody::In(&mut simulation, index)))
        });
        Ok(result?)
    }

    /// Calls `read` with the body, without the GIL.
    pub(crate) fn read<R: Send>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&supple::Body) -> R + Send,
    ) -> PyResult<R> {
        self.with(py, |body| read(body))
    }

    /// Returns the simulation of the body, and the index of the body in it.
    pub(crate) fn shared_simulation(
        &self,
        py: Python<'_>,
    ) -> PyResult<Option<(Arc<SharedSimulation>, usize)>> {
        let shared = py.detach(|| {
            self.storage().map(|storage| match &*storage {
                Storage::In(shared, index) => Some((shared.clone(), *index)),
                Storage::Alone(_) | Storage::Moving => None,
            })
        });
        Ok(shared?)
    }

    /// Locks the storage of the body. Call it without the GIL.
    pub(crate) fn storage(&self) -> Result<MutexGuard<'_, Storage>, Forked> {
        // A body outside a simulation has no threads.
        self.owner.lock(&self.storage, |_| {})
    }
}
