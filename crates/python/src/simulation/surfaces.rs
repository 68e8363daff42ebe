//! Evaluates the displayed surfaces of all bodies of `supple.Simulation`, on all threads.

use numpy::{Element, PyArray2, PyArrayMethods, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;
use supple::{Coordinate, Executor};

use super::Simulation;
use crate::argument::conversion_error;
use crate::arrays::{self, in_use};
use crate::body::{SharedBody, mesh_size};

/// The rows of an array to which a surface is written.
enum Rows<'a> {
    Single(&'a mut [[f32; 3]]),
    Double(&'a mut [[f64; 3]]),
}

/// An array to which a surface is written, locked.
enum Guard<'py> {
    Single(PyReadwriteArray2<'py, f32>),
    Double(PyReadwriteArray2<'py, f64>),
}

impl<'py> Guard<'py> {
    /// Locks an array whose rows are contiguous; `None` for another one.
    fn new(array: &Bound<'py, PyAny>) -> PyResult<Option<Self>> {
        if let Ok(array) = array.cast::<PyArray2<f32>>() {
            Ok(lock(array)?.map(Self::Single))
        } else if let Ok(array) = array.cast::<PyArray2<f64>>() {
            Ok(lock(array)?.map(Self::Double))
        } else {
            Ok(None)
        }
    }

    fn rows(&mut self) -> PyResult<Rows<'_>> {
        Ok(match self {
            Self::Single(array) => Rows::Single(rows(array)?),
            Self::Double(array) => Rows::Double(rows(array)?),
        })
    }
}

/// Locks an array if its rows are contiguous and aligned.
fn lock<'py, T: Element>(array: &Bound<'py, PyArray2<T>>) -> PyResult<Option<PyReadwriteArray2<'py, T>>> {
    let guard = array.try_readwrite().map_err(|_| in_use("out"))?;
    Ok((array.is_c_contiguous() && array.is_aligned()).then_some(guard))
}

/// Returns the rows of a locked array.
fn rows<'a, T: Element + Coordinate>(array: &'a mut PyReadwriteArray2<'_, T>) -> PyResult<&'a mut [[T; 3]]> {
    Ok(array.as_slice_mut()?.as_chunks_mut().0)
}

#[pymethods]
impl Simulation {
    /// Evaluate the displayed surfaces of all bodies, on all threads: a list of (k, 3) arrays in the order of
    /// bodies.
    ///
    /// out : list of (k, 3) float32 or float64, optional
    ///     Arrays to write to and return, one per body. Default: new float64 arrays.
    ///
    /// The arrays are those of body.surface(), bit for bit. That of a bare lattice, which has no mesh, has no rows.
    #[pyo3(signature = (out=None))]
    fn surfaces<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyList>> {
        // Another thread can break a body between the two locks; the lengths are then compared again.
        loop {
            let counts = self.shared.with(py, |simulation| mesh_sizes(simulation))?;
            let new = |&(count, _): &(usize, bool)| PyArray2::<f64>::zeros(py, [count, 3], false).into_any();
            let arrays = match out {
                Some(out) => read_out(out, &counts)?,
                None => counts.iter().map(new).collect(),
            };
            if self.write_surfaces(py, &arrays, &counts)? {
                return PyList::new(py, arrays);
            }
        }
    }
}

impl Simulation {
    /// Evaluates the displayed surfaces into `arrays`. Returns false if they do not have the numbers of rows `counts`.
    fn write_surfaces(
        &self,
        py: Python<'_>,
        arrays: &[Bound<'_, PyAny>],
        counts: &[(usize, bool)],
    ) -> PyResult<bool> {
        let mut guards = arrays.iter().map(Guard::new).collect::<PyResult<Vec<_>>>()?;
        let mut tasks: Vec<(usize, &SharedBody, Rows<'_>)> = Vec::new();
        let mut others = Vec::new();
        for (index, guard) in guards.iter_mut().enumerate().filter(|(index, _)| counts[*index].0 > 0) {
            match guard {
                Some(guard) => tasks.push((index, &self.bodies[index], guard.rows()?)),
                None => others.push(index),
            }
        }
        let sequential = Executor::sequential();
        let is_written = self.shared.with(py, |simulation| {
            if mesh_sizes(simulation) != counts {
                return false;
            }
            // With fewer bodies than threads, the threads share the work on each body.
            let all = simulation.executor();
            let of_body = if tasks.len() < all.threads() { all } else { &sequential };
            all.for_each(tasks.into_iter(), |(index, body, rows)| {
                let mut display = body.display();
                let mut displayed = display.evaluate(simulation.body(index).with_executor(of_body));
                match rows {
                    Rows::Single(rows) => displayed.surface_into(rows, None),
                    Rows::Double(rows) => displayed.surface_into(rows, None),
                }
            });
            true
        })?;
        drop(guards);
        if is_written {
            for index in others {
                self.bodies[index].write_surface(&arrays[index])?;
            }
        }
        Ok(is_written)
    }
}

/// Returns the number of vertices of the mesh of each body, zero for a bare lattice, and whether it broke.
fn mesh_sizes(simulation: &supple::Simulation) -> Vec<(usize, bool)> {
    simulation.bodies().iter().map(|body| mesh_size(body).unwrap_or_default()).collect()
}

/// Reads the `out` argument, one array per body. `counts`: the number of rows of each, and whether its body is broken.
fn read_out<'py>(out: &Bound<'py, PyAny>, counts: &[(usize, bool)]) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let expected = "a list of arrays, one per body";
    let items = out.try_iter().map_err(|error| conversion_error(error, out, "out", expected))?;
    let arrays = items.collect::<PyResult<Vec<_>>>()?;
    if arrays.len() != counts.len() {
        let (found, bodies) = (arrays.len(), counts.len());
        return Err(PyValueError::new_err(format!(
            "out has {found} entries; it must have {bodies}, one per body"
        )));
    }
    for (index, (array, &count)) in arrays.iter().zip(counts).enumerate() {
        arrays::check_out(array, &format!("out[{index}]"), count)?;
    }
    Ok(arrays)
}
