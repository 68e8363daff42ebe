//! Ctrl-C: once ends after the current frame, twice at once.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::say;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens to Ctrl-C from here on.
pub(crate) fn listen() {
    let listening = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            // Frames are renamed when they are whole, so that nothing half written has a final name.
            process::exit(130);
        }
        say::err("\nending after this frame; Ctrl-C again ends at once");
    });
    if let Err(error) = listening {
        say::err(format_args!("warning: Ctrl-C will not keep a checkpoint: {error}"));
    }
}

/// Whether Ctrl-C was pressed.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
