//! Converts the outcome of a command to an exit code.

use supple_io::run::RunError;

/// Outcome of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// The command completed.
    Done,
    /// The run failed, one of several inputs failed, or a case of a study failed.
    Failed,
    /// The arguments, the scene or a mesh are invalid; nothing was written.
    Input,
    /// The user pressed Ctrl-C.
    Interrupted,
    /// The program received SIGTERM.
    Terminated,
}

impl From<&RunError> for Exit {
    fn from(error: &RunError) -> Self {
        if error.is_input() { Self::Input } else { Self::Failed }
    }
}

impl Exit {
    /// Returns the exit code of the process.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failed => 1,
            Self::Input => 2,
            Self::Interrupted => 130,
            Self::Terminated => 143,
        }
    }
}
