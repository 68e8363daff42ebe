//! Where a body lives: alone, or in a simulation that all its bodies share.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyWeakrefMethods, PyWeakrefReference};

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
///
/// A process that was forked has no threads but one: before its first step it takes new ones.
pub(crate) struct World {
    /// A job that steps it holds it as well.
    simulation: Arc<Mutex<supple::Simulation>>,
    threads: usize,
    process: AtomicU32,
    /// The Python object of the simulation, as long as it lives.
    python: PyOnceLock<Py<PyWeakrefReference>>,
}

impl World {
    pub(crate) fn new(simulation: Arc<Mutex<supple::Simulation>>, threads: usize) -> Self {
        let process = AtomicU32::new(std::process::id());
        Self { simulation, threads, process, python: PyOnceLock::new() }
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

    /// Makes sure that the threads are of this process.
    ///
    /// # Errors
    ///
    /// If another thread was at work when the process was forked: what it left is of no use.
    pub(crate) fn settle(&self) -> Result<(), &'static str> {
        let process = std::process::id();
        if self.process.load(Ordering::Acquire) == process {
            return Ok(());
        }
        let Ok(mut simulation) = self.simulation.try_lock() else {
            return Err(
                "the process was forked while another thread worked on the simulation; build it anew",
            );
        };
        simulation.abandon_threads();
        simulation.set_threads(self.threads).expect("as it was built with");
        self.process.store(process, Ordering::Release);
        Ok(())
    }

    /// The simulation. To be called without the GIL.
    pub(crate) fn lock(&self) -> MutexGuard<'_, supple::Simulation> {
        locked(&self.simulation)
    }

    /// Lets `work` have the simulation, without the GIL.
    pub(crate) fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Simulation) -> R + Send,
    ) -> R {
        py.detach(|| work(&mut self.lock()))
    }
}

impl Body {
    /// Lets `work` have the body, without the GIL.
    pub(crate) fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Body) -> R + Send,
    ) -> R {
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

    /// The simulation that the body lives in, and its index there.
    pub(crate) fn world(&self, py: Python<'_>) -> Option<(Arc<World>, usize)> {
        py.detach(|| match &*self.home() {
            Home::In(world, index) => Some((world.clone(), *index)),
            Home::Alone(_) | Home::Moving => None,
        })
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
