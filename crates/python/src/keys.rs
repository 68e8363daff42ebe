//! Keys of a motion: `[(time, translate, rotate), ...]`, or dicts with these names.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use supple::Key;

use crate::argument::{number, wrong_type};
use crate::arrays::vector;
use crate::settings::Settings;

/// Keys in the order given.
pub(crate) fn read(keys: &Bound<'_, PyAny>) -> PyResult<Vec<Key>> {
    if keys.is_instance_of::<PyString>() || keys.is_instance_of::<PyDict>() {
        return Err(wrong_type(keys, "keys", "a list of (time, translate, rotate)"));
    }
    let iterator =
        keys.try_iter().map_err(|_| wrong_type(keys, "keys", "a list of (time, translate, rotate)"))?;
    iterator.enumerate().map(|(index, key)| read_one(&key?, index)).collect()
}

fn read_one(key: &Bound<'_, PyAny>, index: usize) -> PyResult<Key> {
    if let Ok(dict) = key.cast::<PyDict>() {
        let settings = Settings::of_dict(dict, &format!("keys[{index}]"), &["time", "translate", "rotate"])?;
        let time = settings.number("time")?;
        let time = time.ok_or_else(|| PyValueError::new_err(format!("keys[{index}] has no time")))?;
        let translate = settings.vector("translate")?.unwrap_or_default();
        let rotate = settings.vector("rotate")?.unwrap_or_default();
        return Ok(Key { time, translate, rotate });
    }
    let name = format!("keys[{index}]");
    let parts: Vec<Bound<'_, PyAny>> = match key.is_instance_of::<PyString>() {
        true => None,
        false => key.try_iter().ok().and_then(|parts| parts.collect::<PyResult<_>>().ok()),
    }
    .ok_or_else(|| wrong_type(key, &name, "(time, translate, rotate)"))?;
    let part = |at: usize, what: &str| match parts.get(at) {
        Some(value) if !value.is_none() => vector(value, &format!("{name}.{what}")),
        _ => Ok([0.0; 3]),
    };
    if parts.is_empty() || parts.len() > 3 {
        let message = format!("{name} has {} parts; it must be (time, translate, rotate)", parts.len());
        return Err(PyValueError::new_err(message));
    }
    let time = number(&parts[0], &format!("{name}.time"))?;
    Ok(Key { time, translate: part(1, "translate")?, rotate: part(2, "rotate")? })
}
