//! Locks mutexes in a way that stays usable after a fork: a mutex that another thread had locked during the
//! fork gives an error, not a deadlock.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::sleep;
use std::time::Duration;

use pyo3::PyErr;
use pyo3::exceptions::PyRuntimeError;

/// Number of attempts to lock a mutex that may be locked by a thread that does not exist in this process.
const ATTEMPTS: usize = 200;

/// Pause between two attempts.
const PAUSE: Duration = Duration::from_millis(1);

/// The id of the process that last locked a mutex.
///
/// A fork copies only the calling thread. A mutex that another thread had locked during the fork stays locked
/// in the child process, so a thread that waits for it never continues.
pub(crate) struct Owner(AtomicU32);

/// Error: another thread had locked the mutex when the process was forked, so the data may be inconsistent.
pub(crate) struct Forked;

impl Owner {
    /// Creates an owner for the current process.
    pub(crate) fn new() -> Self {
        Self(AtomicU32::new(std::process::id()))
    }

    /// Locks `mutex`. In a forked process, the first call passes the guarded data to `reinitialize`.
    ///
    /// # Errors
    ///
    /// [`Forked`] if another thread had locked the mutex when the process was forked.
    pub(crate) fn lock<'a, T>(
        &self,
        mutex: &'a Mutex<T>,
        reinitialize: impl Fn(&mut T),
    ) -> Result<MutexGuard<'a, T>, Forked> {
        let process = std::process::id();
        for _ in 0..ATTEMPTS {
            if self.0.load(Ordering::Acquire) == process {
                // Ignores poisoning: a panic leaves the data in a usable state.
                return Ok(mutex.lock().unwrap_or_else(PoisonError::into_inner));
            }
            let mut guard = match mutex.try_lock() {
                Ok(guard) => guard,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                // Locked by a thread that does not exist in this process, or by another thread of this
                // process.
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
