//! How a command ends, and its exit code.

use std::process::ExitCode;

use supple_io::run::RunError;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Everything that was asked for is there.
    Done,
    /// Something failed while it ran.
    Failed,
    /// Arguments, scene or mesh are wrong; nothing was written.
    Input,
    /// Ended by Ctrl-C.
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
