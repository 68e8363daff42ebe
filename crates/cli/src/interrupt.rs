//! Handles Ctrl-C: the first press stops after the current frame or study point, and the second exits
//! immediately.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::terminal;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler for Ctrl-C.
pub(crate) fn install_handler() {
    let installed = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            // Exiting here leaves no incomplete file with a final name, because a file gets its final name
            // only when it is complete.
            process::exit(130);
        }
        terminal::print_to_stderr(
            "\nstopping after the current frame or study point; press Ctrl-C again to exit immediately",
        );
    });
    if let Err(error) = installed {
        terminal::print_to_stderr(format_args!(
            "warning: cannot install the handler for Ctrl-C; Ctrl-C will exit without a checkpoint: {error}"
        ));
    }
}

/// Returns whether Ctrl-C was pressed.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
