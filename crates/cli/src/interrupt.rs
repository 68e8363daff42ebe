//! Handles Ctrl-C and SIGTERM: the first one stops after the current frame or study point, and a second Ctrl-C exits
//! immediately.

use std::process;
use std::sync::OnceLock;

use crate::exit::Exit;
use crate::terminal;

/// The first signal that arrived.
static REQUESTED: OnceLock<Signal> = OnceLock::new();

/// A signal that stops the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    /// Ctrl-C, SIGINT.
    Interrupt,
    /// SIGTERM, which schedulers of render farms and `docker stop` send. Windows has no such signal.
    #[cfg_attr(not(unix), expect(dead_code))]
    Terminate,
}

impl Signal {
    /// Returns the outcome of a command that the signal stopped.
    pub(crate) fn exit(self) -> Exit {
        match self {
            Self::Interrupt => Exit::Interrupted,
            Self::Terminate => Exit::Terminated,
        }
    }
}

/// Installs the handlers for Ctrl-C and SIGTERM.
pub(crate) fn install_handler() {
    if let Err(error) = ctrlc::set_handler(|| stop(Signal::Interrupt)) {
        terminal::print_warning(format_args!(
            "cannot install the handler for Ctrl-C; Ctrl-C will exit without a checkpoint: {error}"
        ));
    }
    #[cfg(unix)]
    if let Err(error) = handle_termination() {
        terminal::print_warning(format_args!(
            "cannot install the handler for SIGTERM; SIGTERM will exit without a checkpoint: {error}"
        ));
    }
}

/// Installs the handler for SIGTERM. The feature `termination` of `ctrlc` does not tell the signals apart, and also
/// takes SIGHUP, which `nohup` ignores.
#[cfg(unix)]
fn handle_termination() -> std::io::Result<()> {
    use signal_hook::{consts::SIGTERM, iterator::Signals};
    let mut signals = Signals::new([SIGTERM])?;
    let handle = move || signals.forever().for_each(|_| stop(Signal::Terminate));
    std::thread::Builder::new().name("sigterm".into()).spawn(handle).map(drop)
}

/// Stops after the current frame or study point; exits immediately at a second Ctrl-C.
fn stop(signal: Signal) {
    if REQUESTED.set(signal).is_err() {
        // A scheduler that signals all programs of a task, and a script that passes its signal on, send two SIGTERM at
        // once. They have SIGKILL for programs that do not end.
        if signal == Signal::Terminate {
            return;
        }
        // Exiting here leaves no incomplete file with a final name, because a file gets its final name
        // only when it is complete.
        process::exit(requested().unwrap_or(signal).exit().code().into());
    }
    terminal::print_to_stderr(match signal {
        Signal::Interrupt => {
            "\nstopping after the current frame or study point; press Ctrl-C again to exit immediately"
        }
        Signal::Terminate => "stopping after the current frame or study point because of SIGTERM",
    });
}

/// Returns the signal that stops the program, if there was one.
pub(crate) fn requested() -> Option<Signal> {
    REQUESTED.get().copied()
}

/// Returns the outcome of a command that was stopped.
pub(crate) fn exit() -> Exit {
    requested().map_or(Exit::Interrupted, Signal::exit)
}
