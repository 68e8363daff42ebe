//! Reads the positions of animated meshes.

use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use supple::{AnimationError, MeshAnimation, Range};
use supple_io::frames::read_pc2;

use crate::argument::{self, Settings, number};
use crate::error;

/// Keyword arguments of a handle that follows an animation, without `follow` itself.
pub(crate) const TIMES: [&str; 2] = ["follow_fps", "follow_start"];

/// Default number of frames per second.
const FPS: f64 = 30.0;

/// Reads an array of positions, shape (frames, `vertices`, 3).
pub(crate) fn positions(value: &Bound<'_, PyAny>, name: &str, vertices: usize) -> PyResult<Vec<[f32; 3]>> {
    let array = value.py().import("numpy")?.call_method1("ascontiguousarray", (value, "float32"))?;
    let array: Bound<'_, PyArray3<f32>> = array
        .cast_into()
        .map_err(|_| PyValueError::new_err(format!("{name} must have the shape (frames, vertices, 3)")))?;
    let array = array.readonly();
    let view = array.as_array();
    let shape = view.shape();
    if shape[0] == 0 || shape[1..] != [vertices, 3] {
        return Err(PyValueError::new_err(format!(
            "{name} has the shape ({}, {}, {}); it must be (frames, {vertices}, 3), with at least one frame",
            shape[0], shape[1], shape[2]
        )));
    }
    Ok(array.as_slice()?.as_chunks::<3>().0.to_vec())
}

/// Returns the positions of an animation: (frames, vertices, 3) float32, read-only.
pub(crate) fn array<'py>(py: Python<'py>, animation: &MeshAnimation) -> PyResult<Bound<'py, PyAny>> {
    let shape = [animation.samples(), animation.vertices(), 3];
    let array = PyArray1::from_slice(py, animation.positions().as_flattened()).reshape(shape)?;
    array.call_method1("setflags", (false,))?;
    Ok(array.into_any())
}

/// Reads `fps`, above 0.
pub(crate) fn fps(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    let fps = number(value, name)?;
    match Range::FPS.contains(fps) {
        true => Ok(fps),
        false => Err(PyValueError::new_err(format!("{name} is {fps}; it must be greater than 0"))),
    }
}

/// Reads the animation that a handle follows: `follow`, an array or the path of a PC2 file, `follow_fps` and
/// `follow_start`. `vertices` is the number of vertices of the mesh.
pub(crate) fn followed(
    follow: &Bound<'_, PyAny>,
    settings: &Settings<'_>,
    vertices: usize,
) -> PyResult<MeshAnimation> {
    let interval = 1.0 / settings.read("follow_fps", fps)?.unwrap_or(FPS);
    let start = settings.number("follow_start")?;
    let invalid = |fault: AnimationError| PyValueError::new_err(format!("follow: {fault}"));
    let is_path = follow.is_instance_of::<PyString>() || follow.hasattr("__fspath__")?;
    if !is_path {
        let positions = positions(follow, "follow", vertices)?;
        return MeshAnimation::new(positions, vertices, start.unwrap_or(0.0), interval).map_err(invalid);
    }
    let path = argument::path(follow, "follow")?;
    let in_file = |problem: String| PyValueError::new_err(format!("follow, {}: {problem}", path.display()));
    let cache = read_pc2(&path).map_err(|fault| match fault.kind() {
        std::io::ErrorKind::InvalidData => in_file(fault.to_string()),
        _ => error::from_io(&path, &fault),
    })?;
    if cache.points != vertices {
        return Err(in_file(AnimationError::Vertices { found: cache.points, vertices }.to_string()));
    }
    let start = start.unwrap_or(cache.first_frame * interval);
    MeshAnimation::new(cache.positions, vertices, start, cache.frames_per_sample * interval)
        .map_err(|fault| in_file(fault.to_string()))
}
