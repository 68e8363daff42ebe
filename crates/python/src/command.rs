//! Runs the command line of supple in the Python process.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Run the program `supple` with the arguments `sys.argv`, and return its exit code. It may be called once per
/// process, because it handles Ctrl-C.
#[pyfunction]
pub(crate) fn main(py: Python<'_>) -> PyResult<u8> {
    let arguments: Vec<OsString> = py.import("sys")?.getattr("argv")?.extract()?;
    // Python's handler waits until Rust code returns. The default ends the process at once; runs replace it.
    let signal = py.import("signal")?;
    signal.call_method1("signal", (signal.getattr("SIGINT")?, signal.getattr("SIG_DFL")?))?;
    Ok(py.detach(|| supple_cli::main_with(arguments)))
}
