//! Reads the arguments of pins, handles and forces: the selection (exactly one of [`SHAPES`]), the time window (`start=`, `end=`), the soft goal (`weight=`,
//! `goal_frequency=`, `goal_damping=`) and the keyframes (`keys=`: tuples `(time, translate, rotate)`, or dicts with these
//! names).

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use supple::{Curve, CurveKey, Goal, Interpolation, Key, Map, Selection, SelectionPose, TimeWindow};
use supple_io::scene::GoalTable;

use crate::argument::{Settings, choice, conversion_error, number, text, wrong_type};
use crate::arrays::{self, Axis, vector};
use crate::rotation::rotate;

/// Keyword arguments that give a selection.
pub(crate) const SHAPES: [&str; 7] = ["box", "sphere", "plane", "vertices", "mesh_vertices", "group", "map"];

/// Keyword arguments that give a selection and the pose in which a shape selects.
pub(crate) const SELECTION: [&str; 8] = with_shapes(["at"]);

/// Returns the keyword arguments that give a selection, and `more`. `ALL` is their number.
pub(crate) const fn with_shapes<const N: usize, const ALL: usize>(
    more: [&'static str; N],
) -> [&'static str; ALL] {
    assert!(ALL == SHAPES.len() + N);
    let (mut all, mut place) = ([""; ALL], 0);
    while place < ALL {
        all[place] = if place < SHAPES.len() { SHAPES[place] } else { more[place - SHAPES.len()] };
        place += 1;
    }
    all
}

/// Keyword arguments of a soft goal.
const GOAL: [&str; 3] = ["weight", "goal_frequency", "goal_damping"];

/// Returns whether the arguments give a selection.
pub(crate) fn has_selection(settings: &Settings<'_>) -> PyResult<bool> {
    SHAPES.into_iter().try_fold(false, |found, shape| Ok(found || settings.get(shape)?.is_some()))
}

/// Reads the selection from the arguments of `function`, for a body with as many lattice and mesh vertices as `counts`.
pub(crate) fn selection(settings: &Settings<'_>, function: &str, counts: [usize; 2]) -> PyResult<Selection> {
    let given = |shape| Ok(settings.get(shape)?.map(|value| (shape, value)));
    let given: Vec<_> =
        SHAPES.into_iter().filter_map(|shape| given(shape).transpose()).collect::<PyResult<_>>()?;
    match &given[..] {
        [(shape, value)] => read_shape(shape, value, counts),
        [] => Err(PyTypeError::new_err(format!("{function} needs one of {}", list_of_shapes()))),
        [(first, _), (second, _), ..] => Err(PyTypeError::new_err(format!(
            "{function} accepts only one of {}; {first} and {second} were given",
            list_of_shapes()
        ))),
    }
}

/// Returns the names of the arguments that give a selection, for messages.
fn list_of_shapes() -> String {
    SHAPES.map(|shape| format!("{shape}=")).join(", ")
}

/// Reads the soft goal of a pin or a handle; `None` without one.
pub(crate) fn goal(settings: &Settings<'_>) -> PyResult<Option<Goal>> {
    let given = settings.iter().filter(|(key, _)| GOAL.contains(&key.as_str()));
    let arguments: Vec<_> = given.collect();
    if arguments.is_empty() {
        return Ok(None);
    }
    let GoalTable(goal) = crate::keys::read(arguments, |key, value| match key {
        "weight" => crate::keys::curve(value, key).map(Some),
        _ => crate::keys::value(value, key).map(Some),
    })?;
    Ok(Some(goal))
}

/// Reads `at`; `None` if it is missing.
pub(crate) fn pose(settings: &Settings<'_>, function: &str) -> PyResult<Option<SelectionPose>> {
    let pose = settings.read("at", |value, name| choice(value, name, &SelectionPose::NAMED))?;
    for part in ["vertices", "mesh_vertices", "group", "map"] {
        if pose.is_some() && settings.get(part)?.is_some() {
            let message =
                format!("{function} has at only together with a shape; {part} selects the same in any pose");
            return Err(PyTypeError::new_err(message));
        }
    }
    Ok(pose)
}

/// Reads `start` and `end`, in seconds.
pub(crate) fn window(settings: &Settings<'_>) -> PyResult<TimeWindow> {
    let default = TimeWindow::default();
    let start = settings.number("start")?.unwrap_or(default.start);
    let end = settings.number("end")?.unwrap_or(default.end);
    Ok(TimeWindow { start, end })
}

/// Reads the value of the selection argument `shape`.
fn read_shape(shape: &str, value: &Bound<'_, PyAny>, [lattice, mesh]: [usize; 2]) -> PyResult<Selection> {
    Ok(match shape {
        "box" => {
            let [min, max] = read_pair(value, shape, ["min", "max"])?;
            Selection::Box { min: vector(&min, "box min")?, max: vector(&max, "box max")? }
        }
        "sphere" => {
            let [center, radius] = read_pair(value, shape, ["center", "radius"])?;
            let center = vector(&center, "sphere center")?;
            Selection::Sphere { center, radius: number(&radius, "sphere radius")? }
        }
        "plane" => {
            let [point, normal] = read_pair(value, shape, ["point", "normal"])?;
            let point = vector(&point, "plane point")?;
            Selection::Plane { point, normal: vector(&normal, "plane normal")? }
        }
        "group" => Selection::Group(text(value, shape)?),
        "map" => Selection::Map(map(value, shape)?),
        "mesh_vertices" => Selection::MeshVertices(vertices(value, shape, ("mesh", mesh))?),
        _ => Selection::Vertices(vertices(value, shape, ("lattice", lattice))?),
    })
}

/// Reads the argument `name`, a map of a mesh: a name, or a weight for each vertex.
pub(crate) fn map(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Map> {
    if value.is_instance_of::<PyString>() {
        return Ok(Map::Name(text(value, name)?));
    }
    let weights = match arrays::is_mask(value)? {
        true => {
            let mask = arrays::booleans(value, name, &[Axis::Any("n")])?;
            mask.as_slice()?.iter().map(|&chosen| f32::from(u8::from(chosen))).collect()
        }
        false => {
            let weights = arrays::numbers(value, name, Axis::Any("n"))?;
            weights.into_iter().map(|weight| weight as f32).collect::<Vec<_>>()
        }
    };
    Ok(Map::Weights(weights))
}

/// Reads a plane: an object with a point and a normal, such as `supple.Plane`, a pair or a dict. Returns point and
/// normal.
pub(crate) fn plane(value: &Bound<'_, PyAny>) -> PyResult<[[f64; 3]; 2]> {
    let names = ["point", "normal"];
    let [point, normal] = match value.hasattr("point")? && value.hasattr("normal")? {
        true => [value.getattr("point")?, value.getattr("normal")?],
        false => read_pair(value, "plane", names)?,
    };
    Ok([vector(&point, "plane point")?, vector(&normal, "plane normal")?])
}

/// Reads the two numbers or vectors of a shape, from a pair or from a dict with the keys `names`.
fn read_pair<'py>(
    value: &Bound<'py, PyAny>,
    shape: &str,
    names: [&str; 2],
) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let expected = format!("a pair ({}, {})", names[0], names[1]);
    if let Ok(dict) = value.cast::<PyDict>() {
        let settings = Settings::from_dict(dict, shape, &names)?;
        let missing = |name| PyValueError::new_err(format!("{shape} has no {name}"));
        let part = |name| settings.get(name)?.ok_or_else(|| missing(name));
        return Ok([part(names[0])?, part(names[1])?]);
    }
    if value.is_instance_of::<PyString>() {
        return Err(wrong_type(value, shape, &expected));
    }
    let parts = value.try_iter().map_err(|error| conversion_error(error, value, shape, &expected))?;
    <[_; 2]>::try_from(parts.collect::<PyResult<Vec<_>>>()?).map_err(|parts| {
        PyValueError::new_err(format!("{shape} has {} parts; it must be {expected}", parts.len()))
    })
}

/// Reads the argument `name`, vertices of a mesh or a lattice: indices, or a mask of all `count` vertices. A list of only 0
/// and 1 that repeats them is a mask, of all vertices or of something else.
fn vertices(value: &Bound<'_, PyAny>, name: &str, (whole, count): (&str, usize)) -> PyResult<Vec<u32>> {
    if arrays::is_mask(value)? {
        let mask = arrays::booleans(value, name, &[Axis::Is(count)])?;
        let chosen = mask.as_slice()?.iter().enumerate().filter(|(_, chosen)| **chosen);
        return Ok(chosen.map(|(vertex, _)| vertex as u32).collect());
    }
    let list = arrays::integers(value, name, &[Axis::Any("k")])?;
    let checked = |&vertex: &i64| match u32::try_from(vertex) {
        Ok(valid) if (valid as usize) < count => Ok(valid),
        _ => Err(PyValueError::new_err(format!(
            "{name}: {vertex} is out of range: the {whole} has {count} vertices, 0 to {}",
            count as i64 - 1
        ))),
    };
    let list = list.as_slice()?;
    if list.len() > 2 && list.iter().all(|entry| (0..2).contains(entry)) {
        if list.len() != count {
            return Err(PyValueError::new_err(format!(
                "{name} has {} entries, all of them 0 or 1: a mask has one entry for each of the {count} {whole} \
                 vertices, and indices are given once each",
                list.len()
            )));
        }
        return Ok((0..).zip(list).filter(|(_, chosen)| **chosen == 1).map(|(vertex, _)| vertex).collect());
    }
    list.iter().map(checked).collect()
}

/// Reads `interpolation`; `None` if it is missing.
pub(crate) fn interpolation(settings: &Settings<'_>) -> PyResult<Option<Interpolation>> {
    settings.read("interpolation", |value, name| choice(value, name, &Interpolation::NAMED))
}

/// Reads keyframes, in the given order.
pub(crate) fn keys(keys: &Bound<'_, PyAny>) -> PyResult<Vec<Key>> {
    let expected = "a list of (time, translate, rotate)";
    if keys.is_instance_of::<PyString>() || keys.is_instance_of::<PyDict>() {
        return Err(wrong_type(keys, "keys", expected));
    }
    let items = keys.try_iter().map_err(|error| conversion_error(error, keys, "keys", expected))?;
    let mut list: Vec<Key> = Vec::new();
    for (index, key) in items.enumerate() {
        let near = list.last().map_or([0.0; 3], |before| before.rotate);
        list.push(read_key(&key?, &format!("keys[{index}]"), near)?);
    }
    Ok(list)
}

/// Converts a keyed number to a number, a list of (time, value), or a dict with the keys `keys` and `interpolation`.
pub(crate) fn curve_to_python<'py>(py: Python<'py>, curve: &Curve) -> PyResult<Bound<'py, PyAny>> {
    let keys = || -> Vec<_> { curve.keys().iter().map(|key| (key.time, key.value)).collect() };
    match (curve.keys(), curve.interpolation()) {
        (&[CurveKey { value, .. }], _) => value.into_bound_py_any(py),
        (_, Interpolation::Linear) => keys().into_bound_py_any(py),
        (_, interpolation) => {
            let dict = PyDict::new(py);
            dict.set_item("keys", keys())?;
            dict.set_item("interpolation", interpolation.name())?;
            Ok(dict.into_any())
        }
    }
}

/// Reads a keyframe: a sequence or a dict. `near` has the angles of the one before.
fn read_key(key: &Bound<'_, PyAny>, name: &str, near: [f64; 3]) -> PyResult<Key> {
    if let Ok(dict) = key.cast::<PyDict>() {
        let settings = Settings::from_dict(dict, name, &["time", "translate", "rotate"])?;
        let missing = || PyValueError::new_err(format!("{name} has no time"));
        let time = settings.number("time")?.ok_or_else(missing)?;
        let translate = settings.read("translate", vector)?.unwrap_or_default();
        let rotate = settings.read("rotate", |value, name| rotate(value, name, near))?.unwrap_or_default();
        return Ok(Key { time, translate, rotate });
    }
    let expected = "(time, translate, rotate)";
    if key.is_instance_of::<PyString>() {
        return Err(wrong_type(key, name, expected));
    }
    let parts = key.try_iter().and_then(|parts| parts.collect::<PyResult<Vec<_>>>());
    let parts = parts.map_err(|error| conversion_error(error, key, name, expected))?;
    let part = |index: usize| parts.get(index).filter(|value| !value.is_none());
    if parts.is_empty() || parts.len() > 3 {
        let message = format!("{name} has {} parts; it must be (time, translate, rotate)", parts.len());
        return Err(PyValueError::new_err(message));
    }
    let time = number(&parts[0], &format!("{name}.time"))?;
    let translate = part(1).map_or(Ok([0.0; 3]), |value| vector(value, &format!("{name}.translate")))?;
    let rotate = part(2).map_or(Ok([0.0; 3]), |value| rotate(value, &format!("{name}.rotate"), near))?;
    Ok(Key { time, translate, rotate })
}
