//! Locks that stay usable after a fork: a lock that another thread held during the fork gives an error, not a
//! deadlock.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::sleep;
use std::time::Duration;

use pyo3::PyErr;
use pyo3::exceptions::PyRuntimeError;

/// Number of attempts, and the pause between them, to take a lock whose owner may not exist in this process.
const TRIES: usize = 200;
const PAUSE: Duration = Duration::from_millis(1);

/// The id of the process that last took a lock.
///
/// A fork copies only the calling thread. A lock that another thread held during the fork is never released
/// in the child process, and waiting for it would block forever.
pub(crate) struct Owner(AtomicU32);

/// Another thread held the lock when the process was forked, so that the data may be inconsistent.
pub(crate) struct Forked;

impl Owner {
    /// Creates an owner for the current process.
    pub(crate) fn new() -> Self {
        Self(AtomicU32::new(std::process::id()))
    }

    /// Takes the lock. In a forked process, the first call passes the guarded data to `reinitialize`.
    ///
    /// # Errors
    ///
    /// If another thread held the lock when the process was forked.
    pub(crate) fn lock<'a, T>(
        &self,
        mutex: &'a Mutex<T>,
        reinitialize: impl Fn(&mut T),
    ) -> Result<MutexGuard<'a, T>, Forked> {
        let process = std::process::id();
        for _ in 0..TRIES {
            if self.0.load(Ordering::Acquire) == process {
                // Ignores poisoning: a panic leaves the data in a usable state.
                return Ok(mutex.lock().unwrap_or_else(PoisonError::into_inner));
            }
            let mut guard = match mutex.try_lock() {
                Ok(guard) => guard,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                // Held by a thread that does not exist any more, or by another thread of this process.
                Err(TryLockError::WouldBlock) => {
                    sleep(PAUSE);
                    continue;
                }
            };
            reinitialize(&mut guard);
            self.0.store(process, Ordering::Release);
            return Ok(guard);
        }
        Err(Forked)
    }
}

impl From<Forked> for PyErr {
    fn from(_: Forked) -> Self {
        PyRuntimeError::new_err(
            "the process was forked while another thread used this simulation or body; build it again",
        )
    }
}
