//! Arrays in: lists, tuples, arrays of any number type, strided or read-only.

use numpy::{PyArrayDescrMethods, get_array_module};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
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
        let numbers = contiguous::<f64>(array.clone(), "float64")?;
        check_finite(numbers.as_slice()?, numbers.shape(), name)?;
    }
    contiguous(array, "bool")
}

/// Finite `(n, 3)`; `n` as expected or any.
pub(crate) fn vectors(value: &Bound<'_, PyAny>, name: &str, rows: Side) -> PyResult<Vec<[f64; 3]>> {
    let array = floats(value, name, &[rows, Side::Is(3)])?;
    let numbers = array.as_slice()?;
    check_finite(numbers, array.shape(), name)?;
    Ok(numbers.as_chunks().0.to_vec())
}

/// Finite `(3,)`.
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 3]> {
    let array = floats(value, name, &[Side::Is(3)])?;
    let numbers = array.as_slice()?;
    check_finite(numbers, array.shape(), name)?;
    Ok([numbers[0], numbers[1], numbers[2]])
}

/// Finite `(n, 3, 3)`, row by row.
pub(crate) fn matrices(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f64; 9]>> {
    let array = floats(value, name, &[Side::Any("n"), Side::Is(3), Side::Is(3)])?;
    let numbers = array.as_slice()?;
    check_finite(numbers, array.shape(), name)?;
    Ok(numbers.as_chunks().0.to_vec())
}

/// Finite `(3, 3)`, row by row; `None` for an array with another number of axes.
pub(crate) fn matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<[f64; 9]>> {
    if value.getattr("ndim").and_then(|axes| axes.extract::<usize>()).ok() != Some(2) {
        return Ok(None);
    }
    let array = floats(value, name, &[Side::Is(3), Side::Is(3)])?;
    let numbers = array.as_slice()?;
    check_finite(numbers, array.shape(), name)?;
    Ok(numbers.first_chunk().copied())
}

/// Refuses NaN and infinity, and tells where.
fn check_finite(numbers: &[f64], shape: &[usize], name: &str) -> PyResult<()> {
    let Some(mut at) = numbers.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    let value = numbers[at];
    let mut index = vec![0; shape.len()];
    for (place, side) in index.iter_mut().zip(shape).rev() {
        (*place, at) = (at % side, at / side);
    }
    let index: Vec<String> = index.iter().map(usize::to_string).collect();
    Err(PyValueError::new_err(format!("{name}[{}] = {value} is not finite", index.join(", "))))
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
        let found: Vec<String> = array.shape().iter().map(usize::to_string).collect();
        let comma = if found.len() == 1 { "," } else { "" };
        return Err(PyValueError::new_err(format!(
            "{name} has the shape ({}{comma}); it must be {}",
            found.join(", "),
            expected(shape)
        )));
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
