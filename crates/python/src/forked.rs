//! Locks after a fork: what another thread held at that moment is said to be lost, and not waited for.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::sleep;
use std::time::Duration;

use pyo3::PyErr;
use pyo3::exceptions::PyRuntimeError;

/// How often, and after which time each, a lock is tried that no thread of this process is known to hold.
const TRIES: usize = 200;
const PAUSE: Duration = Duration::from_millis(1);

/// The process whose threads use a lock.
///
/// A fork copies one thread. A lock that another one held is never given back in the new process, where waiting for it
/// would be for ever.
pub(crate) struct Owner(AtomicU32);

/// Another thread was at work when the process was forked: what it left is of no use.
pub(crate) struct Forked;

impl Owner {
    /// This process.
    pub(crate) fn new() -> Self {
        Self(AtomicU32::new(std::process::id()))
    }

    /// The lock; `renew` has what it guards first, when this is the first time in a process that was forked.
    ///
    /// # Errors
    ///
    /// If nobody can ever have it.
    pub(crate) fn lock<'a, T>(
        &self,
        mutex: &'a Mutex<T>,
        renew: impl Fn(&mut T),
    ) -> Result<MutexGuard<'a, T>, Forked> {
        let process = std::process::id();
        for _ in 0..TRIES {
            if self.0.load(Ordering::Acquire) == process {
                // Whatever panicked with the lock in hand left things as whole as any.
                return Ok(mutex.lock().unwrap_or_else(PoisonError::into_inner));
            }
            let mut guard = match mutex.try_lock() {
                Ok(guard) => guard,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                // Lost, or for this moment with a thread that is the first to use it.
                Err(TryLockError::WouldBlock) => {
                    sleep(PAUSE);
                    continue;
                }
            };
            renew(&mut guard);
            self.0.store(process, Ordering::Release);
            return Ok(guard);
        }
        Err(Forked)
    }
}

impl From<Forked> for PyErr {
    fn from(_: Forked) -> Self {
        PyRuntimeError::new_err(
            "the process was forked while another thread worked on this simulation or body; build it anew",
        )
    }
}
