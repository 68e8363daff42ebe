//! Stores a body outside a simulation, or refers to a simulation that several bodies share.
//!
//! A Python body has a strong reference to its Python simulation. The Python simulation has only the
//! [`SharedBody`] of each body, and a weak reference to its Python object. So there is no cycle of references,
//! and a simulation is freed as soon as neither it nor one of its bodies is used; or, if the function of a force field
//! refers to them, when the garbage collector has run.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyWeakrefReference};
use supple::{BodyRef, Collider, Softened};

use super::fields::Fields;
use super::shapes::{ReadBody, Shapes};
use crate::error;
use crate::forked::{Forked, Owner};
use crate::interrupt::interruptible;

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
    /// See [`generation`](Self::generation). It changes only while `simulation` is locked.
    generation: AtomicU64,
    /// Process that last locked `simulation`.
    owner: Owner,
    /// For each body, what the last step found about its material, so that each change of it warns once.
    pub(crate) softened: Mutex<Vec<Option<Softened>>>,
    /// Whether the next [`with_long`](Self::with_long) is expected to take less than [`LONG`].
    is_quick: AtomicBool,
}

/// After longer work, the next one runs such that Ctrl-C ends the wait for it.
pub(crate) const LONG: Duration = Duration::from_millis(100);

/// Greatest number of steps at once, and the time that they may take, of bodies that are
/// [apart](supple::Simulation::bodies_are_apart). After Ctrl-C, the simulation is busy for up to this time.
pub(crate) const APART: (u32, Duration) = (32, Duration::from_secs(1));

impl SharedSimulation {
    pub(crate) fn new(simulation: Arc<Mutex<supple::Simulation>>, threads: usize) -> Self {
        let (generation, is_quick) = (AtomicU64::new(0), AtomicBool::new(false));
        Self { simulation, threads, generation, owner: Owner::new(), softened: Mutex::default(), is_quick }
    }

    /// Returns the requested number of threads; 0 = one per processor.
    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// Returns how often the colliders were replaced. It does not change while the simulation is locked.
    pub(crate) fn generation(&self) -> u64 {
        self.generation.load(Ordering::Relaxed)
    }

    /// Replaces the colliders, and returns the new [generation](Self::generation).
    ///
    /// # Errors
    ///
    /// The errors of [`with`](Self::with), and an invalid collider.
    pub(crate) fn set_colliders(&self, py: Python<'_>, colliders: &[Collider]) -> PyResult<u64> {
        let generation = self.with(py, |simulation| {
            simulation.set_colliders(colliders)?;
            Ok(self.generation.fetch_add(1, Ordering::Relaxed) + 1)
        })?;
        generation.map_err(|error: supple::Error| error::from_core(error))
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

    /// Ends the forces that act during a call, after its steps. If an exception ended the call, a step can still run in the
    /// background, and Python does not wait for it: the forces then end after this step.
    pub(crate) fn end_call(self: &Arc<Self>, py: Python<'_>, is_complete: bool) -> PyResult<()> {
        if is_complete {
            return self.with(py, supple::Simulation::end_call);
        }
        match self.simulation.try_lock() {
            Ok(mut simulation) => simulation.end_call(),
            Err(_) => {
                let shared = self.clone();
                thread::spawn(move || shared.lock().map(|mut simulation| simulation.end_call()).ok());
            }
        }
        Ok(())
    }

    /// As [`with`](Self::with), for work that can be long. Ctrl-C then ends the wait for it, but not the work.
    pub(crate) fn with_long<R: Send + 'static>(
        self: &Arc<Self>,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Simulation, &Self) -> R + Send + 'static,
    ) -> PyResult<R> {
        let timed = |shared: &Self| {
            let mut simulation = shared.lock()?;
            let start = Instant::now();
            let result = work(&mut simulation, shared);
            // The next call may make many steps after one.
            let factor = if simulation.bodies_are_apart() { APART.0 } else { 1 };
            shared.is_quick.store(start.elapsed() * factor < LONG, Ordering::Relaxed);
            Ok::<_, Forked>(result)
        };
        if self.is_quick.load(Ordering::Relaxed) {
            return Ok(py.detach(|| timed(self))?);
        }
        let shared = self.clone();
        Ok(interruptible(py, move || timed(&shared))??)
    }
}

/// A body whose storage is locked.
enum LockedBody<'a> {
    /// A body outside a simulation.
    Alone(&'a mut supple::Body),
    /// A simulation, and the index of the body in it.
    In(&'a mut supple::Simulation, usize),
}

impl<'a> LockedBody<'a> {
    /// Returns the body with the data of its simulation, if it is in one.
    fn in_context(self) -> BodyRef<'a> {
        match self {
            Self::Alone(body) => body.alone(),
            Self::In(simulation, index) => simulation.body(index),
        }
    }
}

/// The arguments of `supple.Body` from which a body was built: shape and keyword arguments.
pub(crate) type BuildArguments<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

/// A body that its Python object and its simulation share.
pub(crate) struct SharedBody {
    storage: Mutex<Storage>,
    /// Locked only while the storage or the simulation is locked.
    display: Mutex<supple::Display>,
    /// Process that last locked `storage`.
    owner: Owner,
    /// The shape that the body was built from: a `Mesh` or a `Lattice`.
    shape: Py<PyAny>,
    pub(crate) fields: Fields,
    /// Whether a Python simulation has the body.
    is_in_simulation: AtomicBool,
    /// A copy of the keyword arguments, for pickles.
    settings: Py<PyDict>,
    pub(super) shapes: Shapes,
    /// Weak reference to the Python object of the body.
    pub(super) python: Mutex<Option<Py<PyWeakrefReference>>>,
}

impl ReadBody for SharedBody {
    fn read_body<T: Send>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&supple::Body) -> T + Send,
    ) -> PyResult<T> {
        self.read(py, read)
    }
}

impl SharedBody {
    /// Creates a body without a Python object, with the arguments that the body was built with.
    pub(crate) fn new(storage: Storage, (shape, settings): BuildArguments<'_>) -> Self {
        Self {
            storage: Mutex::new(storage),
            display: Mutex::default(),
            owner: Owner::new(),
            fields: Fields::default(),
            is_in_simulation: AtomicBool::new(false),
            shape: shape.unbind(),
            settings: settings.unbind(),
            shapes: Shapes::default(),
            python: Mutex::new(None),
        }
    }

    /// Notes that a Python simulation has the body, and shows its force fields to the garbage collector.
    pub(crate) fn enter_simulation(&self) {
        self.is_in_simulation.store(true, Ordering::Relaxed);
    }

    /// Returns whether a Python simulation has the body.
    pub(super) fn is_in_simulation(&self) -> bool {
        self.is_in_simulation.load(Ordering::Relaxed)
    }

    /// Returns the arguments that the body was built with.
    pub(crate) fn build_arguments<'py>(&self, py: Python<'py>) -> BuildArguments<'py> {
        (self.shape.bind(py).clone(), self.settings.bind(py).clone())
    }

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
        self.in_context(py, |body| work(&mut self.display().evaluate(body)))
    }

    /// Locks the buffers of the displayed surface. Call it while the storage or the simulation is locked.
    pub(crate) fn display(&self) -> MutexGuard<'_, supple::Display> {
        self.display.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `read` with the body and the data of its simulation, if it is in one, without the GIL.
    pub(crate) fn in_context<R: Send>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(BodyRef<'_>) -> R + Send,
    ) -> PyResult<R> {
        self.with_locked(py, |locked| read(locked.in_context()))
    }

    /// As [`in_context`](Self::in_context), for work that can be long. Ctrl-C ends the wait for it, but not the work.
    pub(crate) fn in_context_long<R: Send + 'static>(
        self: &Arc<Self>,
        py: Python<'_>,
        read: impl FnOnce(BodyRef<'_>) -> R + Send + 'static,
    ) -> PyResult<R> {
        let shared = self.clone();
        Ok(interruptible(py, move || shared.locked(|locked| read(locked.in_context())))??)
    }

    /// Calls `work` with the body while its storage or its simulation is locked, without the GIL.
    fn with_locked<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(LockedBody<'_>) -> R + Send,
    ) -> PyResult<R> {
        Ok(py.detach(|| self.locked(work))?)
    }

    /// Calls `work` with the body while its storage or its simulation is locked. Call it without the GIL.
    fn locked<R>(&self, work: impl FnOnce(LockedBody<'_>) -> R) -> Result<R, Forked> {
        let mut storage = self.storage()?;
        let (shared, index) = match &mut *storage {
            Storage::Alone(body) => return Ok(work(LockedBody::Alone(body))),
            Storage::In(shared, index) => (shared.clone(), *index),
            Storage::Moving => unreachable!("the storage stays locked while the body is moved"),
        };
        drop(storage);
        shared.lock().map(|mut simulation| work(LockedBody::In(&mut simulation, index)))
    }

    /// Calls `read` with the body, without the GIL.
    pub(crate) fn read<R: Send>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&supple::Body) -> R + Send,
    ) -> PyResult<R> {
        self.with(py, |body| read(body))
    }

    /// Returns the index of the body in its simulation, or `None` outside a simulation.
    pub(super) fn index(&self, py: Python<'_>) -> PyResult<Option<usize>> {
        let index = py.detach(|| {
            self.storage().map(|storage| match &*storage {
                Storage::In(_, index) => Some(*index),
                Storage::Alone(_) | Storage::Moving => None,
            })
        });
        Ok(index?)
    }

    /// Locks the storage of the body. Call it without the GIL.
    pub(crate) fn storage(&self) -> Result<MutexGuard<'_, Storage>, Forked> {
        // A body outside a simulation has no threads.
        self.owner.lock(&self.storage, |_| {})
    }
}
