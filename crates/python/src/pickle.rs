//! Encodes the data of pickles, with a checksum.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error;

/// Size of the checksum at the end of the data: a CRC-32, little endian.
const CHECKSUM: usize = 4;

/// Serializes a value, followed by a checksum.
pub(crate) fn encode<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyBytes>> {
    let mut bytes = postcard::to_stdvec(value).map_err(error::value)?;
    let checksum = crc32(py, &bytes)?;
    bytes.extend(checksum);
    Ok(PyBytes::new(py, &bytes))
}

/// Deserializes a value that [`encode`] serialized.
///
/// # Errors
///
/// `ValueError` if the checksum does not match, or the data is not a value of type `T`.
pub(crate) fn decode<T: DeserializeOwned>(py: Python<'_>, bytes: &[u8]) -> PyResult<T> {
    let damaged =
        || PyValueError::new_err("the pickle is damaged: its checksum does not match; save it again");
    let (data, checksum) = bytes.split_last_chunk::<CHECKSUM>().ok_or_else(damaged)?;
    if crc32(py, data)? != *checksum {
        return Err(damaged());
    }
    let other =
        |error| format!("the pickle was made by a different version of supple; save it again: {error}");
    postcard::from_bytes(data).map_err(|error| PyValueError::new_err(other(error)))
}

/// Computes the CRC-32 of data.
fn crc32(py: Python<'_>, data: &[u8]) -> PyResult<[u8; CHECKSUM]> {
    Ok(py.import("zlib")?.call_method1("crc32", (PyBytes::new(py, data),))?.extract::<u32>()?.to_le_bytes())
}

/// Pickles an object, such as keyword arguments, to a part of the value for [`encode`].
pub(crate) fn dumps(object: &Bound<'_, PyAny>) -> PyResult<Vec<u8>> {
    object.py().import("pickle")?.call_method1("dumps", (object,))?.extract()
}

/// Restores an object that [`dumps`] pickled.
pub(crate) fn loads<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    py.import("pickle")?.call_method1("loads", (PyBytes::new(py, bytes),))
}

/// Returns the checksum in the pickle of a `Mesh` or a `Lattice`. The pickle of a body contains it, so that a
/// reference to another shape is an error.
pub(crate) fn shape_checksum(shape: &Bound<'_, PyAny>) -> PyResult<[u8; CHECKSUM]> {
    let (_, arguments): (Bound<'_, PyAny>, Bound<'_, PyTuple>) =
        shape.call_method0("__reduce__")?.extract()?;
    let data = arguments.get_item(0)?.cast_into::<PyBytes>()?;
    Ok(*data.as_bytes().last_chunk().expect("the data ends with a checksum"))
}

/// Checks that the shape of a body is the shape that was pickled with the body.
pub(crate) fn check_shape(shape: &Bound<'_, PyAny>, checksum: [u8; CHECKSUM]) -> PyResult<()> {
    if shape_checksum(shape)? == checksum {
        return Ok(());
    }
    Err(PyValueError::new_err("the pickle is damaged: a body has the shape of another one; save it again"))
}
