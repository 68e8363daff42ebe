//! Keyword arguments that a scene has too: converts them to the values of scenes, which the reader of scenes reads, and
//! converts the keys of scenes to Python objects.

use std::mem;

use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use serde::de::DeserializeOwned;
use supple_io::scene::{BodyData, Data, Place, SceneError, Table, Value, read_table};

use crate::argument::{is_from_python, owned, type_name};
use crate::arrays;
use crate::error::Exception;

/// Reads arguments as the keys of a table of a scene. `convert` returns the value of a key; `None` if a scene does not
/// have the key or the value.
///
/// # Errors
///
/// `TypeError` for a value of a wrong type, `ValueError` for another one. The message names the argument.
pub(crate) fn read<'py, T: DeserializeOwned>(
    arguments: impl IntoIterator<Item = (String, Bound<'py, PyAny>)>,
    convert: impl Fn(&str, &Bound<'py, PyAny>) -> PyResult<Option<Value>>,
) -> PyResult<T> {
    let mut table = Table::new();
    for (key, argument) in arguments {
        if let Some(value) = convert(&key, &argument)? {
            table.insert(key, value);
        }
    }
    read_table(&Value { data: Data::Table(table), place: Place::Argument("dict".to_owned()) })
        .map_err(refusal)
}

/// Greatest depth of nested lists and dicts. It bounds the conversion of a list that contains itself.
const MAX_DEPTH: usize = 4;

/// Converts a Python object to the value of a key. Entries of a dict that are None are left out.
pub(crate) fn value(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    value_within(object, name, MAX_DEPTH)
}

/// Converts a Python object with at most `depth` lists and dicts inside each other.
fn value_within(object: &Bound<'_, PyAny>, name: &str, depth: usize) -> PyResult<Value> {
    let data = if let Ok(text) = object.cast::<PyString>() {
        Data::Text(text.to_str()?.to_owned())
    } else if let Ok(boolean) = object.extract() {
        Data::Boolean(boolean)
    } else if let Some(number) = number(object, name)? {
        number
    } else if depth == 0 {
        Data::Other(type_name(object))
    } else if let Ok(dict) = object.cast::<PyDict>() {
        let entry = |(key, object): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let key = owned(&key.str()?);
            let value = value_within(&object, &format!("{name}.{key}"), depth - 1)?;
            Ok((key, value))
        };
        let given = dict.iter().filter(|(_, object)| !object.is_none());
        Data::Table(given.map(entry).collect::<PyResult<_>>()?)
    } else {
        list(object, name, depth - 1)?.unwrap_or_else(|| Data::Other(type_name(object)))
    };
    Ok(Value { data, place: Place::Argument(type_name(object)) })
}

/// Converts a vector to the value of a key.
pub(crate) fn vector(vector: [f64; 3]) -> Value {
    let value = |data| Value { data, place: Place::Argument("float".to_owned()) };
    value(Data::Array(vector.map(|x| value(Data::Float(x))).into()))
}

/// Converts a number, or keyframes of one: a list of (time, value), or a dict with the keys `keys` and `interpolation`.
pub(crate) fn curve(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    let mut curve = value(object, name)?;
    let keys = match &mut curve.data {
        Data::Table(table) => table.get_mut("keys").map(|keys| &mut keys.data),
        data => Some(data),
    };
    let keys = keys.and_then(|keys| if let Data::Array(keys) = keys { Some(keys) } else { None });
    for (index, key) in keys.into_iter().flatten().enumerate() {
        let pair = match &mut key.data {
            Data::Table(_) => continue,
            Data::Array(pair) => mem::take(pair),
            _ => Vec::new(),
        };
        let pair = <[Value; 2]>::try_from(pair)
            .map_err(|_| PyValueError::new_err(format!("{name}[{index}] must be (time, value)")))?;
        key.data = Data::Table(["time", "value"].map(str::to_owned).into_iter().zip(pair).collect());
    }
    Ok(curve)
}

/// Converts a vector, or keyframes of one as [`curve`] takes them.
pub(crate) fn keyed_vector(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    let is_list = |object: &Bound<'_, PyAny>| {
        object.is_instance_of::<PyList>()
            || object.is_instance_of::<PyTuple>()
            || object.is_instance_of::<PyDict>()
    };
    let has_keys = || object.get_item(0).is_ok_and(|first| is_list(&first));
    match object.is_instance_of::<PyDict>() || (is_list(object) && has_keys()) {
        true => curve(object, name),
        false => Ok(vector(arrays::vector(object, name)?)),
    }
}

/// Converts a number; `None` for another object.
fn number(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<Data>> {
    let py = object.py();
    // An array of one element would convert to a number.
    if object.cast::<PyUntypedArray>().is_ok_and(|array| array.ndim() > 0) {
        return Ok(None);
    }
    let number =
        object.extract().map(Data::Integer).or_else(|error: PyErr| match is_from_python(&error, py) {
            true => Err(error),
            false => object.extract().map(Data::Float),
        });
    number.map(Some).or_else(|error| match error.is_instance_of::<PyOverflowError>(py) {
        _ if is_from_python(&error, py) => Err(error),
        true => Err(PyValueError::new_err(format!("{name} is too large for a float"))),
        false => Ok(None),
    })
}

/// Converts a list, tuple, array or other iterable with items of at most `depth` levels; `None` for another object.
fn list(object: &Bound<'_, PyAny>, name: &str, depth: usize) -> PyResult<Option<Data>> {
    let items = match object.try_iter() {
        Ok(items) => items.enumerate(),
        Err(error) if is_from_python(&error, object.py()) => return Err(error),
        Err(_) => return Ok(None),
    };
    let values = items.map(|(index, item)| value_within(&item?, &format!("{name}[{index}]"), depth));
    values.collect::<PyResult<_>>().map(|values| Some(Data::Array(values)))
}

/// Converts an error of the reader of scenes.
fn refusal(error: SceneError) -> PyErr {
    let split = |key: &str| -> (String, String) {
        let (parent, key) = key.rsplit_once('.').unwrap_or(("", key));
        (argument(parent), key.to_owned())
    };
    match error {
        SceneError::WrongType { key, expected, found, .. } => {
            PyTypeError::new_err(format!("{} must be {}, not {found}", argument(&key), in_python(&expected)))
        }
        SceneError::OutOfRange { key, value, range, .. } => {
            let (name, range) = (argument(&key), in_python(&range));
            let message = match value.parse::<f64>() {
                Ok(_) => format!("{name} = {value} is out of range: it must be {range}"),
                Err(_) => {
                    let text = value.strip_prefix("the string ").map(str::to_owned);
                    format!("{name} is {}; it must be {range}", text.unwrap_or_else(|| in_python(&value)))
                }
            };
            match key.as_str() {
                "lattice_vertices" | "cell_size" => Exception::Lattice.with(message),
                _ => PyValueError::new_err(message),
            }
        }
        SceneError::UnknownKey { key, way_out, .. } => {
            let (parent, key) = split(&key);
            PyValueError::new_err(format!("{parent} has no key {key:?}; {}", in_python(&way_out)))
        }
        SceneError::Missing { key, hint, .. } => {
            PyValueError::new_err(format!("{} is missing: {}", argument(&key), in_python(&hint)))
        }
        SceneError::Exclusive { key, other, .. } => {
            let (parent, key) = split(&key);
            let place = if parent.is_empty() { parent } else { format!("{parent}: ") };
            let message = format!("{place}{other} and {key} are mutually exclusive; pass only one of them");
            PyValueError::new_err(message)
        }
        error => PyValueError::new_err(error.to_string()),
    }
}

/// Writes the full key of a value as in Python: `ignore.0` as `ignore[0]`.
fn argument(key: &str) -> String {
    let mut name = String::new();
    for part in key.split('.') {
        match part.parse::<usize>() {
            Ok(index) => name.push_str(&format!("[{index}]")),
            Err(_) if name.is_empty() => name.push_str(part),
            Err(_) => name.extend([".", part]),
        }
    }
    name
}

/// Writes the description of a value in the words of Python.
fn in_python(description: &str) -> String {
    let words = [
        ("`", "\""),
        ("a table", "a dict"),
        ("true or false", "True or False"),
        ("true, false", "True, False"),
        ("a string in quotes", "a string"),
    ];
    words.iter().fold(description.to_owned(), |text, (scene, python)| text.replace(scene, python))
}

/// Returns the value of a key of a body as a Python object; `None` if the key has no value.
pub(crate) fn of_body<'py>(
    py: Python<'py>,
    body: &BodyData,
    key: &str,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    body.to_keys().get(key).map(|value| to_python(py, value)).transpose()
}

/// Converts the value of a key to a Python object.
pub(crate) fn to_python<'py>(py: Python<'py>, value: &serde_json::Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        serde_json::Value::Null => Ok(py.None().into_bound(py)),
        serde_json::Value::Bool(value) => value.into_bound_py_any(py),
        serde_json::Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into_bound_py_any(py),
            None => number.as_f64().into_bound_py_any(py),
        },
        serde_json::Value::String(text) => text.into_bound_py_any(py),
        serde_json::Value::Array(values) => {
            let values = values.iter().map(|value| to_python(py, value));
            Ok(PyTuple::new(py, values.collect::<PyResult<Vec<_>>>()?)?.into_any())
        }
        serde_json::Value::Object(entries) => {
            let dict = PyDict::new(py);
            for (key, value) in entries {
                dict.set_item(key, to_python(py, value)?)?;
            }
            Ok(dict.into_any())
        }
    }
}
