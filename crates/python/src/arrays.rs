//! Numpy arrays: anything array-like in (lists, tuples, arrays of any number type, strided or read-only), checked by
//! name; fresh `float64` out, read-only where it is constant, or into the caller's `out`.

use nalgebra::{Matrix3, Point3};
use numpy::ndarray::{Array2, Array3};
use numpy::{Element, IntoPyArray, PyArray2, PyArray3, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods};
use numpy::{PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods, get_array_module};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;

use crate::argument::wrong_type;

/// The expected length of an array along one axis.
#[derive(Clone, Copy)]
pub(crate) enum Side {
    /// Any, called so in messages.
    Any(&'static str),
    /// This one.
    Is(usize),
    /// One of these, and what lies between.
    Between(usize, usize),
}

impl Side {
    fn fits(self, length: usize) -> bool {
        match self {
            Self::Any(_) => true,
            Self::Is(expected) => length == expected,
            Self::Between(least, greatest) => (least..=greatest).contains(&length),
        }
    }
}

/// An array of finite or other numbers as `float64`, contiguous.
pub(crate) fn floats<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Side],
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let array = array(value, name, shape, "numbers", b"fiu")?;
    contiguous(array, "float64")
}

/// An array of integers as `int64`, contiguous.
pub(crate) fn integers<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Side],
) -> PyResult<PyReadonlyArrayDyn<'py, i64>> {
    let array = array(value, name, shape, "integers", b"iu")?;
    // As int64 the larger ones would be negative.
    if array.dtype().kind() == b'u' && array.dtype().itemsize() == 8 {
        let unsigned = contiguous::<u64>(array.clone(), "uint64")?;
        if let Some(large) = unsigned.as_slice()?.iter().find(|&&x| i64::try_from(x).is_err()) {
            return Err(PyValueError::new_err(format!("{name}: {large} is out of range")));
        }
    }
    contiguous(array, "int64")
}

/// Whether something is a mask: an array, or a list, of booleans.
pub(crate) fn is_mask(value: &Bound<'_, PyAny>) -> bool {
    let array = || get_array_module(value.py())?.call_method1("asarray", (value,));
    let is_mask = |array: Bound<'_, PyAny>| Some(array.cast::<PyUntypedArray>().ok()?.dtype().kind() == b'b');
    array().ok().and_then(is_mask).unwrap_or(false)
}

/// An array of truth values: booleans, or numbers that are not zero.
pub(crate) fn truths<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Side],
) -> PyResult<PyReadonlyArrayDyn<'py, bool>> {
    let array = array(value, name, shape, "booleans", b"bfiu")?;
    if array.dtype().kind() == b'f' {
        check_finite(&contiguous(array.clone(), "float64")?, name)?;
    }
    contiguous(array, "bool")
}

/// Finite `(n, 3)`; `n` as expected or any.
pub(crate) fn vectors(value: &Bound<'_, PyAny>, name: &str, rows: Side) -> PyResult<Vec<[f64; 3]>> {
    Ok(finite(value, name, &[rows, Side::Is(3)])?.as_slice()?.as_chunks().0.to_vec())
}

/// Finite `(3,)`.
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 3]> {
    Ok(finite(value, name, &[Side::Is(3)])?.as_slice()?.as_chunks().0[0])
}

/// Finite `(n, 3, 3)`, row by row.
pub(crate) fn matrices(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f64; 9]>> {
    let array = finite(value, name, &[Side::Any("n"), Side::Is(3), Side::Is(3)])?;
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

/// Finite `(3, 3)`, row by row; `None` for an array with another number of axes.
pub(crate) fn matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<[f64; 9]>> {
    if value.getattr("ndim").and_then(|axes| axes.extract::<usize>()).ok() != Some(2) {
        return Ok(None);
    }
    Ok(finite(value, name, &[Side::Is(3), Side::Is(3)])?.as_slice()?.first_chunk().copied())
}

/// As [`floats`], all of them finite.
fn finite<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Side],
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let array = floats(value, name, shape)?;
    check_finite(&array, name)?;
    Ok(array)
}

/// Refuses NaN and infinity, and tells where.
fn check_finite(array: &PyReadonlyArrayDyn<'_, f64>, name: &str) -> PyResult<()> {
    let numbers = array.as_slice()?;
    let Some(mut at) = numbers.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    let value = numbers[at];
    let mut index = vec![0; array.ndim()];
    for (place, side) in index.iter_mut().zip(array.shape()).rev() {
        (*place, at) = (at % side, at / side);
    }
    Err(PyValueError::new_err(format!("{name}[{}] = {value} is not finite", joined(&index))))
}

/// "1, 2, 3".
fn joined(numbers: &[usize]) -> String {
    numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// `numpy.asarray`, with its shape and the kind of its dtype checked.
fn array<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Side],
    what: &str,
    kinds: &[u8],
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = value.py();
    let array = get_array_module(py)?.call_method1("asarray", (value,)).map_err(|error| {
        let reason = error.value(py).to_string();
        let message = format!("{name} must be {what} of shape {}: {reason}", expected(shape));
        match error.is_instance_of::<PyValueError>(py) {
            true => PyValueError::new_err(message),
            false => PyTypeError::new_err(message),
        }
    })?;
    let array = array.cast_into::<PyUntypedArray>().map_err(|_| wrong_type(value, name, "an array"))?;
    // An empty list is float64, whatever it should have held.
    if !kinds.contains(&array.dtype().kind()) && !array.is_empty() {
        let found = match array.ndim() {
            0 if !value.is_instance_of::<PyUntypedArray>() => value.get_type().qualname()?.to_string(),
            _ => format!("an array of dtype {}", array.dtype()),
        };
        let message = format!("{name} must be {what} of shape {}, not {found}", expected(shape));
        return Err(PyTypeError::new_err(message));
    }
    if array.ndim() != shape.len() || !array.shape().iter().zip(shape).all(|(&found, side)| side.fits(found))
    {
        let (found, comma) = (joined(array.shape()), if array.ndim() == 1 { "," } else { "" });
        let expected = expected(shape);
        let message = format!("{name} has the shape ({found}{comma}); it must be {expected}");
        return Err(PyValueError::new_err(message));
    }
    Ok(array)
}

fn contiguous<'py, T: numpy::Element>(
    array: Bound<'py, PyUntypedArray>,
    dtype: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = array.py();
    let options = [("order", "C".into_pyobject(py)?.into_any())].into_py_dict(py)?;
    options.set_item("copy", false)?;
    let array = array.call_method("astype", (dtype,), Some(&options))?;
    Ok(array.cast_into::<PyArrayDyn<T>>()?.try_readonly()?)
}

/// `(n, 3)`; `(m, 3) or (m, 4)`.
fn expected(shape: &[Side]) -> String {
    let one = |pick: fn(usize, usize) -> usize| {
        let side = |side: &Side| match *side {
            Side::Any(name) => name.to_owned(),
            Side::Is(length) => length.to_string(),
            Side::Between(least, greatest) => pick(least, greatest).to_string(),
        };
        let sides: Vec<String> = shape.iter().map(side).collect();
        let comma = if sides.len() == 1 { "," } else { "" };
        format!("({}{comma})", sides.join(", "))
    };
    let (least, greatest) = (one(|least, _| least), one(|_, greatest| greatest));
    if least == greatest { least } else { format!("{least} or {greatest}") }
}

/// A fresh `(n, 3)`.
pub(crate) fn of_vectors<T: Element>(py: Python<'_>, vectors: Vec<[T; 3]>) -> Bound<'_, PyArray2<T>> {
    let rows = Array2::from_shape_vec((vectors.len(), 3), vectors.into_flattened());
    rows.expect("three numbers a row").into_pyarray(py)
}

/// A read-only `(n, 3)`.
pub(crate) fn constant<T: Element>(py: Python<'_>, vectors: Vec<[T; 3]>) -> Py<PyArray2<T>> {
    let array = of_vectors(py, vectors);
    array.readwrite().make_nonwriteable();
    array.unbind()
}

/// A fresh `(n, 3)`.
pub(crate) fn of_points<'py>(py: Python<'py>, points: Vec<Point3<f64>>) -> Bound<'py, PyArray2<f64>> {
    of_vectors(py, points.into_iter().map(Into::into).collect())
}

/// A fresh `(n, 3, 3)`.
pub(crate) fn of_matrices<'py>(py: Python<'py>, matrices: &[Matrix3<f64>]) -> Bound<'py, PyArray3<f64>> {
    let n = matrices.len();
    // nalgebra stores columns; a numpy array has rows.
    let numbers: Vec<f64> = matrices.iter().flat_map(|m| m.transpose().data.0).flatten().collect();
    Array3::from_shape_vec((n, 3, 3), numbers).expect("nine numbers a matrix").into_pyarray(py)
}

/// The caller's own array; refuses one of another shape than `(rows, 3)`, or a read-only one.
pub(crate) fn check_out<'a, 'py>(
    out: &'a Bound<'py, PyAny>,
    rows: usize,
) -> PyResult<&'a Bound<'py, PyUntypedArray>> {
    let array = out.cast::<PyUntypedArray>().map_err(|_| wrong_type(out, "out", "a numpy array"))?;
    if array.shape() != [rows, 3] {
        let shape = joined(array.shape());
        return Err(PyValueError::new_err(format!("out has the shape ({shape}); it must be ({rows}, 3)")));
    }
    if !array.getattr("flags")?.getattr("writeable")?.extract::<bool>()? {
        return Err(PyValueError::new_err("out is read-only; pass an array that can be written to"));
    }
    Ok(array)
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
    get_array_module(array.py())?.call_method1("copyto", (array, of_vectors(array.py(), rows)))?;
    Ok(())
}
