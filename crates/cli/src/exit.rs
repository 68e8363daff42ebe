//! The outcome of a command and its exit code.

use std::process::ExitCode;

use supple_io::run::RunError;

/// Outcome of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// The command completed.
    Done,
    /// A failure during the run.
    Failed,
    /// Invalid arguments, scene or mesh; nothing was written.
    Input,
    /// The user pressed Ctrl-C.
    Interrupted,
}

impl From<&RunError> for Exit {
    fn from(error: &RunError) -> Self {
        if error.is_input() { Self::Input } else { Self::Failed }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::Input => 2,
            Exit::Interrupted => 130,
        })
    }
}
