//! Converts numpy arrays. Inputs are array-like: lists, tuples, and arrays of any real dtype, strided or
//! read-only. Outputs are new `float64` arrays (read-only for constant data), or the array that the caller
//! passes as `out`. Errors name the argument.

use nalgebra::{Matrix3, Point3};
use numpy::ndarray::{Array2, Array3, Dimension};
use numpy::{
    Element, IntoPyArray, PyArray, PyArray2, PyArray3, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods,
};
use numpy::{PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods, get_array_module};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;

use crate::argument::{is_from_python, wrong_type};

/// The expected length of an array along one axis.
#[derive(Clone, Copy)]
pub(crate) enum Axis {
    /// Any length; messages show this name in place of the length.
    Any(&'static str),
    /// Exactly this length.
    Is(usize),
    /// From the first to the second length, inclusive.
    Between(usize, usize),
}

impl Axis {
    /// Returns whether `length` is a valid length of the axis.
    fn accepts(self, length: usize) -> bool {
        match self {
            Self::Any(_) => true,
            Self::Is(expected) => length == expected,
            Self::Between(min, max) => (min..=max).contains(&length),
        }
    }
}

/// Reads an array of numbers, finite or not, as contiguous `float64`.
pub(crate) fn floats<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Axis],
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let array = array(value, name, shape, "numbers", b"fiu")?;
    contiguous(array, name, "float64")
}

/// Reads an array of integers as contiguous `int64`.
pub(crate) fn integers<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Axis],
) -> PyResult<PyReadonlyArrayDyn<'py, i64>> {
    let array = array(value, name, shape, "integers", b"iu")?;
    // The conversion to int64 below would make values from 2^63 on negative.
    if array.dtype().kind() == b'u' && array.dtype().itemsize() == 8 {
        let unsigned = contiguous::<u64>(array.clone(), name, "uint64")?;
        if let Some(large) = unsigned.as_slice()?.iter().find(|&&x| i64::try_from(x).is_err()) {
            return Err(PyValueError::new_err(format!("{name}: {large} is out of range")));
        }
    }
    contiguous(array, name, "int64")
}

/// Returns whether a value is a mask: an array or a list of booleans.
///
/// # Errors
///
/// An exception that Python code of the value raises, such as `__array__`.
pub(crate) fn is_mask(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    let py = value.py();
    match get_array_module(py)?.call_method1("asarray", (value,)) {
        Ok(array) => Ok(array.cast::<PyUntypedArray>().is_ok_and(|array| array.dtype().kind() == b'b')),
        Err(error) if is_from_python(&error, py) => Err(error),
        Err(_) => Ok(false),
    }
}

/// Reads an array of booleans. Nonzero numbers are true.
pub(crate) fn booleans<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Axis],
) -> PyResult<PyReadonlyArrayDyn<'py, bool>> {
    let array = array(value, name, shape, "booleans", b"bfiu")?;
    if array.dtype().kind() == b'f' {
        check_finite(&contiguous(array.clone(), name, "float64")?, name)?;
    }
    contiguous(array, name, "bool")
}

/// Reads finite `(n, 3)` vectors. `rows` gives the expected `n`.
pub(crate) fn vectors(value: &Bound<'_, PyAny>, name: &str, rows: Axis) -> PyResult<Vec<[f64; 3]>> {
    Ok(finite(value, name, &[rows, Axis::Is(3)])?.as_slice()?.as_chunks().0.to_vec())
}

/// Reads a finite `(n,)` array. `rows` gives the expected `n`.
pub(crate) fn numbers(value: &Bound<'_, PyAny>, name: &str, rows: Axis) -> PyResult<Vec<f64>> {
    Ok(finite(value, name, &[rows])?.as_slice()?.to_vec())
}

/// Reads a finite `(3,)` vector.
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 3]> {
    Ok(finite(value, name, &[Axis::Is(3)])?.as_slice()?.as_chunks().0[0])
}

/// Reads finite `(n, 3, 3)` matrices, row-major.
pub(crate) fn matrices(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f64; 9]>> {
    let array = finite(value, name, &[Axis::Any("n"), Axis::Is(3), Axis::Is(3)])?;
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

/// Reads a finite `(3, 3)` matrix, row-major. Returns `None` for an array with a different number of axes.
pub(crate) fn matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<[f64; 9]>> {
    if value.getattr("ndim").and_then(|axes| axes.extract::<usize>()).ok() != Some(2) {
        return Ok(None);
    }
    Ok(finite(value, name, &[Axis::Is(3), Axis::Is(3)])?.as_slice()?.first_chunk().copied())
}

/// Reads an array like [`floats`], and checks that all numbers are finite.
fn finite<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Axis],
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let array = floats(value, name, shape)?;
    check_finite(&array, name)?;
    Ok(array)
}

/// Checks that all numbers are finite. The error gives the index of the first number that is not finite.
fn check_finite(array: &PyReadonlyArrayDyn<'_, f64>, name: &str) -> PyResult<()> {
    let numbers = array.as_slice()?;
    let Some(mut offset) = numbers.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    let value = numbers[offset];
    let mut index = vec![0; array.ndim()];
    for (index, length) in index.iter_mut().zip(array.shape()).rev() {
        (*index, offset) = (offset % length, offset / length);
    }
    Err(PyValueError::new_err(format!("{name}[{}] = {value} is not finite", joined(&index))))
}

/// Formats the lengths of axes, or indices, as "1, 2, 3".
fn joined(values: &[usize]) -> String {
    values.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// Calls `numpy.asarray`, and checks the shape and the kind of the dtype. `what` names the valid kinds in
/// messages.
fn array<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    shape: &[Axis],
    what: &str,
    kinds: &[u8],
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = value.py();
    let array = get_array_module(py)?.call_method1("asarray", (value,)).map_err(|error| {
        let is_conversion =
            error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyTypeError>(py);
        if is_from_python(&error, py) || !is_conversion {
            return error;
        }
        let reason = error.value(py).to_string();
        let message = format!("{name} must be {what} of shape {}: {reason}", expected(shape));
        match error.is_instance_of::<PyValueError>(py) {
            true => PyValueError::new_err(message),
            false => PyTypeError::new_err(message),
        }
    })?;
    let array = array.cast_into::<PyUntypedArray>().map_err(|_| wrong_type(value, name, "an array"))?;
    // An empty list becomes float64 for any expected kind.
    if !kinds.contains(&array.dtype().kind()) && !array.is_empty() {
        let found = match array.ndim() {
            0 if !value.is_instance_of::<PyUntypedArray>() => value.get_type().qualname()?.to_string(),
            _ => format!("an array of dtype {}", array.dtype()),
        };
        let message = format!("{name} must be {what} of shape {}, not {found}", expected(shape));
        return Err(PyTypeError::new_err(message));
    }
    if array.ndim() != shape.len()
        || !array.shape().iter().zip(shape).all(|(&found, axis)| axis.accepts(found))
    {
        let (found, comma) = (joined(array.shape()), if array.ndim() == 1 { "," } else { "" });
        let expected = expected(shape);
        let message = match (array.ndim(), shape) {
            // Three arguments in place of one vector.
            (0, [Axis::Is(3)]) => {
                format!("{name} is {value}; it must be three numbers in one argument, such as (0, 0, 1)")
            }
            _ => format!("{name} has the shape ({found}{comma}); it must be {expected}"),
        };
        return Err(PyValueError::new_err(message));
    }
    Ok(array)
}

/// Converts an array to `dtype`, contiguous in C order and aligned. Copies only if necessary.
fn contiguous<'py, T: numpy::Element>(
    array: Bound<'py, PyUntypedArray>,
    name: &str,
    dtype: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = array.py();
    let options = [("order", "C".into_pyobject(py)?.into_any())].into_py_dict(py)?;
    options.set_item("copy", !array.is_aligned())?;
    let array = array.call_method("astype", (dtype,), Some(&options))?.cast_into::<PyArrayDyn<T>>()?;
    array.try_readonly().map_err(|_| in_use(name))
}

/// Returns the error that another call writes to the array of an argument.
pub(crate) fn in_use(name: &str) -> PyErr {
    PyValueError::new_err(format!("{name} is in use by another call, in another thread; pass another array"))
}

/// Formats an expected shape, such as `(n, 3)` or `(m, 3) or (m, 4)`.
fn expected(shape: &[Axis]) -> String {
    let format_with = |pick: fn(usize, usize) -> usize| {
        let length = |axis: &Axis| match *axis {
            Axis::Any(name) => name.to_owned(),
            Axis::Is(length) => length.to_string(),
            Axis::Between(min, max) => pick(min, max).to_string(),
        };
        let lengths: Vec<String> = shape.iter().map(length).collect();
        let comma = if lengths.len() == 1 { "," } else { "" };
        format!("({}{comma})", lengths.join(", "))
    };
    let (smallest, largest) = (format_with(|min, _| min), format_with(|_, max| max));
    if smallest == largest { smallest } else { format!("{smallest} or {largest}") }
}

/// Creates an `(n, 3)` array from vectors.
pub(crate) fn from_vectors<T: Element>(py: Python<'_>, vectors: Vec<[T; 3]>) -> Bound<'_, PyArray2<T>> {
    let rows = Array2::from_shape_vec((vectors.len(), 3), vectors.into_flattened());
    rows.expect("the length is a multiple of 3").into_pyarray(py)
}

/// Creates a read-only `(n, 3)` array from vectors.
pub(crate) fn read_only<T: Element>(py: Python<'_>, vectors: Vec<[T; 3]>) -> Py<PyArray2<T>> {
    frozen(from_vectors(py, vectors)).unbind()
}

/// Makes a new array read-only, so that an assignment to its entries raises an error.
pub(crate) fn frozen<T: Element, D: Dimension>(array: Bound<'_, PyArray<T, D>>) -> Bound<'_, PyArray<T, D>> {
    array.readwrite().make_nonwriteable();
    array
}

/// Creates an `(n, 3)` array from points.
pub(crate) fn from_points<'py>(py: Python<'py>, points: Vec<Point3<f64>>) -> Bound<'py, PyArray2<f64>> {
    from_vectors(py, points.into_iter().map(Into::into).collect())
}

/// Creates an `(n, 3, 3)` array from matrices.
pub(crate) fn from_matrices<'py>(py: Python<'py>, matrices: &[Matrix3<f64>]) -> Bound<'py, PyArray3<f64>> {
    let n = matrices.len();
    // nalgebra is column-major, numpy row-major.
    let numbers: Vec<f64> = matrices.iter().flat_map(|m| m.transpose().data.0).flatten().collect();
    Array3::from_shape_vec((n, 3, 3), numbers).expect("the length is 9 n").into_pyarray(py)
}

/// Checks an output argument: a writable numpy array of shape `(rows, 3)`, float32 or float64. `is_broken`: whether the
/// rows are of a body that broke, which the message about another shape says.
pub(crate) fn check_out<'py>(
    out: &Bound<'py, PyAny>,
    name: &str,
    (rows, is_broken): (usize, bool),
) -> PyResult<()> {
    let array = out.cast::<PyUntypedArray>().map_err(|_| wrong_type(out, name, "a numpy array"))?;
    if array.shape() != [rows, 3] {
        let (shape, comma) = (joined(array.shape()), if array.ndim() == 1 { "," } else { "" });
        let reason = if is_broken { ", because the body broke; see topology_version" } else { "" };
        return Err(PyValueError::new_err(format!(
            "{name} has the shape ({shape}{comma}); it must be ({rows}, 3){reason}"
        )));
    }
    if !array.getattr("flags")?.getattr("writeable")?.extract::<bool>()? {
        return Err(PyValueError::new_err(format!("{name} is read-only; pass a writable array")));
    }
    if out.cast::<PyArray2<f32>>().is_err() && out.cast::<PyArray2<f64>>().is_err() {
        let dtype = array.dtype();
        return Err(PyTypeError::new_err(format!("{name} has dtype {dtype}; it must be float32 or float64")));
    }
    Ok(())
}

/// Calls `fill` with the rows of `array`. `fill` writes directly to a contiguous array. For another array it
/// writes to a buffer, which is then copied to `array`.
pub(crate) fn fill<'py, T: Element + Copy>(
    array: &Bound<'py, PyArray2<T>>,
    zero: T,
    fill: impl FnOnce(&mut [[T; 3]]) -> PyResult<()>,
) -> PyResult<()> {
    let mut guard = array.try_readwrite().map_err(|_| in_use("out"))?;
    // A column-major array is also contiguous, but its slice does not consist of rows. The slice of an array
    // that is not aligned is an error.
    if array.is_c_contiguous()
        && let Ok(numbers) = guard.as_slice_mut()
    {
        return fill(numbers.as_chunks_mut().0);
    }
    drop(guard);
    let mut rows = vec![[zero; 3]; array.shape()[0]];
    fill(&mut rows)?;
    get_array_module(array.py())?.call_method1("copyto", (array, from_vectors(array.py(), rows)))?;
    Ok(())
}
