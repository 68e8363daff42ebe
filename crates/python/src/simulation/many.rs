//! `supple.step_all`: steps of many simulations at once.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::Simulation;
use super::steps::{Batch, apply_fields, warn_softened, warnings_about_materials};
use crate::argument::{self, Given, type_name};
use crate::body::{LONG, SharedSimulation};
use crate::forked::Forked;
use crate::interrupt::interruptible;

/// Advance many simulations by n steps each, in parallel.
///
/// sims : sequence of Simulation
///     Each at most once. They need not be alike.
/// n : int, default 1
///     Number of steps of each, at least 0.
///
/// The simulations are distributed over the processors, and each is stepped by one thread, whatever its threads are. The
/// results have the bits of sim.step(n) for each. Forces of Body.apply_force act during the call, and functions of
/// add_force_field are called before each step. Other Python threads continue to run. Ctrl-C and warnings are as for
/// Simulation.step; after Ctrl-C, the simulations may have made different numbers of steps.
///
/// Raises TypeError for an item that is no Simulation, and ValueError for one that is given twice.
#[pyfunction]
#[pyo3(signature = (sims, n=Given(None)), text_signature = "(sims, n=1)")]
pub(crate) fn step_all<'py>(py: Python<'py>, sims: &Bound<'py, PyAny>, n: Given<'py>) -> PyResult<()> {
    let simulations = simulations(sims)?;
    let count = n.read("n", |n, name| argument::count(n, name, 0))?.unwrap_or(1) as u64;
    if count == 0 || simulations.is_empty() {
        return Ok(());
    }
    let result = steps(py, &simulations, count);
    for simulation in &simulations {
        simulation.get().shared.end_call(py, result.is_ok())?;
    }
    result
}

/// Reads the argument `sims`.
fn simulations<'py>(sims: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, Simulation>>> {
    let expected = |found: &Bound<'py, PyAny>, what: &str| {
        PyTypeError::new_err(format!(
            "sims must be a sequence of supple.Simulation, not {what}{}",
            type_name(found)
        ))
    };
    if sims.is_instance_of::<Simulation>() {
        return Err(expected(sims, "one "));
    }
    let mut simulations: Vec<Bound<'py, Simulation>> = Vec::new();
    for item in sims.try_iter().map_err(|_| expected(sims, ""))? {
        let item = item?;
        let simulation =
            item.cast::<Simulation>().map_err(|_| expected(&item, "one with an item of type "))?;
        simulations.push(simulation.clone());
    }
    let mut addresses: Vec<(usize, usize)> = simulations
        .iter()
        .enumerate()
        .map(|(index, item)| (Arc::as_ptr(&item.get().shared) as usize, index))
        .collect();
    addresses.sort_unstable();
    match addresses.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(PyValueError::new_err(format!(
            "sims[{}] and sims[{}] are the same simulation; give each once, and more steps with n",
            pair[0].1, pair[1].1
        ))),
        None => Ok(simulations),
    }
}

/// Makes the steps, and checks for signals about every 10 ms.
fn steps(py: Python<'_>, simulations: &[Bound<'_, Simulation>], count: u64) -> PyResult<()> {
    let shared: Arc<[Arc<SharedSimulation>]> =
        simulations.iter().map(|item| item.get().shared.clone()).collect();
    let (mut remaining, mut batch, mut is_quick) = (count, Batch::new(false), false);
    while remaining > 0 {
        let steps = batch.next_of(remaining, apply_fields(py, simulations.iter().map(Bound::get))?);
        // The first step can choose the number of steps per frame, and warn.
        let is_first = remaining == count;
        let shared = shared.clone();
        let work = move || {
            let start = Instant::now();
            in_parallel(&shared, steps, is_first).map(|warnings| (warnings, start.elapsed()))
        };
        let (warnings, elapsed) = if is_quick { py.detach(work)? } else { interruptible(py, work)?? };
        warn_softened(py, warnings)?;
        is_quick = elapsed < LONG;
        remaining -= steps;
        batch.follow(steps, elapsed);
        py.check_signals()?;
    }
    Ok(())
}

/// Makes steps of all simulations. Returns warnings about materials if `warns` is set, in the order of the simulations.
fn in_parallel(
    simulations: &[Arc<SharedSimulation>],
    steps: u64,
    warns: bool,
) -> Result<Vec<String>, Forked> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    let drain = || {
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && let Some(shared) = simulations.get(index)
        {
            let result = shared.lock().map(|mut simulation| {
                simulation.make_sequential_steps(steps);
                if warns { warnings_about_materials(&simulation, shared) } else { Vec::new() }
            });
            results.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    let processors = thread::available_parallelism().map_or(1, usize::from);
    // Threads of a call of its own exist after a fork too, and start in some tens of microseconds.
    thread::scope(|scope| {
        (1..processors.min(simulations.len())).for_each(|_| drop(scope.spawn(drain)));
        drain();
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_unstable_by_key(|(index, _)| *index);
    let warnings = results.into_iter().map(|(_, result)| result).collect::<Result<Vec<_>, _>>()?;
    Ok(warnings.into_iter().flatten().collect())
}
