//! Lets Ctrl-C end the wait for long work.
//!
//! Python runs its signal handlers in the main thread, between two operations of the interpreter. Long work therefore
//! runs in a thread of its own, while the caller looks for signals.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

use pyo3::prelude::*;

/// Interval at which signals are looked for.
const INTERVAL: Duration = Duration::from_millis(50);

/// Stack of the thread in bytes, as large as that of the main thread usually is.
const STACK: usize = 8 << 20;

/// Runs `work` without the GIL, and returns its result. Starting the thread takes some tens of microseconds.
///
/// # Errors
///
/// The exception of a signal handler, such as `KeyboardInterrupt`. The work then ends in the background, and its result
/// is dropped: what it has locked stays locked until then.
pub(crate) fn interruptible<R: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> R + Send + 'static,
) -> PyResult<R> {
    let (sender, mut receiver) = channel();
    let thread = Builder::new().stack_size(STACK).spawn(move || {
        // There is no receiver after an interrupt.
        let _ = sender.send(work());
    })?;
    loop {
        let receiver = &mut receiver;
        match py.detach(move || receiver.recv_timeout(INTERVAL)) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => match py.detach(|| thread.join()) {
                Err(panic) => resume_unwind(panic),
                Ok(()) => unreachable!("the thread sends a result or panics"),
            },
        }
    }
}
