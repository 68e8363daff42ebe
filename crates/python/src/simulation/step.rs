//! Steps: without the GIL, with a chance for Ctrl-C between them.

use std::time::{Duration, Instant};

use pyo3::prelude::*;

use super::Simulation;
use crate::argument;

/// How long steps go on before signals get their chance.
const CHUNK: Duration = Duration::from_millis(10);

#[pymethods]
impl Simulation {
    /// n steps of length dt. Other Python threads run meanwhile; Ctrl-C ends it between two steps.
    #[pyo3(signature = (n=None), text_signature = "($self, n=1)")]
    fn step(&self, py: Python<'_>, n: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let mut left = n.map_or(Ok(1), |n| argument::count(n, "n", 0))? as u64;
        let mut chunk = 1;
        while left > 0 {
            let steps = left.min(chunk);
            let took = self.world.with(py, |simulation| {
                let start = Instant::now();
                simulation.steps(steps);
                start.elapsed()
            })?;
            left -= steps;
            chunk = if took < CHUNK / 2 { chunk * 2 } else { chunk.div_ceil(2) };
            py.check_signals()?;
        }
        Ok(())
    }
}
