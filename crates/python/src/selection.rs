//! Which part of a body: exactly one of `box=`, `sphere=`, `plane=`, `vertices=`.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use supple::{Selection, Window};

use crate::argument::{number, wrong_type};
use crate::arrays::{self, Side};
use crate::settings::Settings;

/// The names of the shapes, as keyword arguments.
pub(crate) const SHAPES: [&str; 4] = ["box", "sphere", "plane", "vertices"];

/// What of the arguments of a pin or a handle may be `None`.
pub(crate) const OPTIONAL: [&str; 5] = ["box", "sphere", "plane", "vertices", "until"];

/// The one selection among the arguments of `function`, for a lattice of `count` vertices.
pub(crate) fn read(settings: &Settings<'_>, function: &str, count: usize) -> PyResult<Selection> {
    let mut given = Vec::new();
    for shape in SHAPES {
        if let Some(value) = settings.get(shape)? {
            given.push((shape, value));
        }
    }
    match &given[..] {
        [(shape, value)] => read_shape(shape, value, count),
        [] => Err(PyTypeError::new_err(format!("{function} needs one of box=, sphere=, plane=, vertices="))),
        [(one, _), (other, _), ..] => Err(PyTypeError::new_err(format!(
            "{function} takes one of box=, sphere=, plane=, vertices=; {one} and {other} were given"
        ))),
    }
}

/// `from_` and `until`, in seconds.
pub(crate) fn read_window(settings: &Settings<'_>) -> PyResult<Window> {
    let default = Window::default();
    let from = settings.number("from_")?.unwrap_or(default.from);
    let until = settings.number("until")?.unwrap_or(default.until);
    Ok(Window { from, until })
}

fn read_shape(shape: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Selection> {
    match shape {
        "box" => {
            let [low, high] = pair(value, shape, ["min", "max"])?;
            Ok(Selection::Box {
                min: arrays::vector(&low, "box min")?,
                max: arrays::vector(&high, "box max")?,
            })
        }
        "sphere" => {
            let [center, radius] = pair(value, shape, ["center", "radius"])?;
            let center = arrays::vector(&center, "sphere center")?;
            Ok(Selection::Sphere { center, radius: number(&radius, "sphere radius")? })
        }
        "plane" => {
            let [point, normal] = pair(value, shape, ["point", "normal"])?;
            let point = arrays::vector(&point, "plane point")?;
            Ok(Selection::Plane { point, normal: arrays::vector(&normal, "plane normal")? })
        }
        _ => vertices(value, count).map(Selection::Vertices),
    }
}

/// The two parts of a shape: a pair, or a dict with their names.
fn pair<'py>(value: &Bound<'py, PyAny>, shape: &str, names: [&str; 2]) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let expected = format!("a pair ({}, {})", names[0], names[1]);
    if let Ok(dict) = value.cast::<PyDict>() {
        let settings = Settings::of_dict(dict, shape, &names)?;
        let part = |name: &str| {
            let part = settings.get(name)?;
            part.ok_or_else(|| PyValueError::new_err(format!("{shape} has no {name}")))
        };
        return Ok([part(names[0])?, part(names[1])?]);
    }
    if value.is_instance_of::<PyString>() {
        return Err(wrong_type(value, shape, &expected));
    }
    let parts = value.try_iter().map_err(|_| wrong_type(value, shape, &expected))?;
    let parts: Vec<_> = parts.collect::<PyResult<_>>()?;
    let found = parts.len();
    <[_; 2]>::try_from(parts)
        .map_err(|_| PyValueError::new_err(format!("{shape} has {found} parts; it must be {expected}")))
}

/// Lattice vertices by index, or a mask of all of them.
fn vertices(value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<u32>> {
    if arrays::is_mask(value) {
        let mask = arrays::truths(value, "vertices", &[Side::Is(count)])?;
        let chosen = mask.as_slice()?.iter().enumerate().filter(|(_, chosen)| **chosen);
        return Ok(chosen.map(|(vertex, _)| vertex as u32).collect());
    }
    let list = arrays::integers(value, "vertices", &[Side::Any("k")])?;
    let within = |&vertex: &i64| match u32::try_from(vertex) {
        Ok(inside) if (inside as usize) < count => Ok(inside),
        _ => Err(PyValueError::new_err(format!(
            "vertices: {vertex} is out of range: the lattice has {count} vertices, 0 to {}",
            count - 1
        ))),
    };
    list.as_slice()?.iter().map(within).collect()
}
