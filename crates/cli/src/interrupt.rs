//! Ctrl-C: the first press stops after the current frame, the second exits immediately.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::terminal;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler for Ctrl-C.
pub(crate) fn listen() {
    let installed = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            // Complete frames are renamed to their final names, so no file with a final name is incomplete.
            process::exit(130);
        }
        terminal::err("\nstopping after this frame; press Ctrl-C again to exit immediately");
    });
    if let Err(error) = installed {
        terminal::err(format_args!(
            "warning: cannot handle Ctrl-C, so it will not write a checkpoint: {error}"
        ));
    }
}

/// Returns whether Ctrl-C was pressed.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
