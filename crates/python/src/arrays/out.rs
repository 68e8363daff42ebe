//! The caller's own array, written in place.

use numpy::{Element, PyArray2, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods, get_array_module};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::argument::wrong_type;

/// An `(n, 3)` array of `float32` or `float64` to write to.
pub(crate) enum Out<'py> {
    Single(Bound<'py, PyArray2<f32>>),
    Double(Bound<'py, PyArray2<f64>>),
}

impl<'py> Out<'py> {
    /// What the caller passed as `out`, for `rows` rows.
    pub(crate) fn new(value: &Bound<'py, PyAny>, rows: usize) -> PyResult<Self> {
        let array = value.cast::<PyUntypedArray>().map_err(|_| wrong_type(value, "out", "a numpy array"))?;
        if let Ok(single) = value.cast::<PyArray2<f32>>() {
            return check(array, rows).map(|()| Self::Single(single.clone()));
        }
        if let Ok(double) = value.cast::<PyArray2<f64>>() {
            return check(array, rows).map(|()| Self::Double(double.clone()));
        }
        check(array, rows)?;
        Err(PyTypeError::new_err(format!("out has dtype {}; it must be float32 or float64", array.dtype())))
    }
}

fn check(array: &Bound<'_, PyUntypedArray>, rows: usize) -> PyResult<()> {
    if array.shape() != [rows, 3] {
        let shape: Vec<String> = array.shape().iter().map(usize::to_string).collect();
        let shape = shape.join(", ");
        return Err(PyValueError::new_err(format!("out has the shape ({shape}); it must be ({rows}, 3)")));
    }
    if !array.getattr("flags")?.getattr("writeable")?.extract::<bool>()? {
        return Err(PyValueError::new_err("out is read-only; pass an array that can be written to"));
    }
    Ok(())
}

/// Lets `fill` write to the rows of `array`, directly where they lie one after another.
pub(crate) fn fill<'py, T: Element + Copy>(
    array: &Bound<'py, PyArray2<T>>,
    zero: T,
    fill: impl FnOnce(&mut [[T; 3]]) -> PyResult<()>,
) -> PyResult<()> {
    let mut guard = array.try_readwrite()?;
    // A slice is had of columns one after another, too: those are not rows.
    if array.is_c_contiguous()
        && let Ok(numbers) = guard.as_slice_mut()
    {
        return fill(numbers.as_chunks_mut().0);
    }
    drop(guard);
    let mut rows = vec![[zero; 3]; array.shape()[0]];
    fill(&mut rows)?;
    let flat = numpy::PyArray1::from_vec(array.py(), rows.into_flattened());
    let rows = flat.reshape([array.shape()[0], 3])?;
    get_array_module(array.py())?.call_method1("copyto", (array, rows))?;
    Ok(())
}
