//! What a ray meets, and what is nearest to a point, in `supple.Simulation`.

use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple::{FoundPoint, Touched};

use super::Simulation;
use super::contacts::structured;
use crate::argument::number;
use crate::arrays::{self, Axis, from_vectors};
use crate::error;

/// Fields of the arrays, and their types in numpy.
const FIELDS: [(&str, &str); 6] = [
    ("body", "i4"),
    ("collider", "i4"),
    ("face", "i4"),
    ("distance", "f8"),
    ("point", "3f8"),
    ("normal", "3f8"),
];

#[pymethods]
impl Simulation {
    /// Return what rays meet first: bodies as they are displayed, from either side, and colliders.
    ///
    /// origins : (3,) or (k, 3) float
    ///     Where the rays start, in world space. (3,): all at one point.
    /// directions : (3,) or (k, 3) float
    ///     Their directions, of any length but 0. (3,): all in one direction.
    /// max_distance : float, optional
    ///     Greatest distance. Default: infinity.
    ///
    /// Returns a structured array with one entry per ray, or one entry without an axis if both are (3,), and the fields:
    ///
    /// body, collider : int32
    ///     Index of the body in bodies, or of the collider in colliders; -1 for the other one. Both are -1 where a ray
    ///     meets nothing.
    /// face : int32
    ///     Index of the face of the displayed mesh; -1 for colliders and bare lattices.
    /// distance : float64
    ///     Distance along the ray; infinity where it meets nothing. 0 for a ray that starts in a solid collider.
    /// point, normal : (3,) float64
    ///     The point, and the unit normal, of bodies by the winding of their faces; zeros where a ray meets nothing.
    ///
    /// A call evaluates the surfaces of all bodies and builds a tree of each, which takes about 10 ms for 10,000 faces; a
    /// ray takes about a microsecond more. So many rays in one call are fast. Raises ValueError for a direction of length 0.
    #[pyo3(signature = (origins, directions, max_distance=None))]
    #[pyo3(text_signature = "($self, origins, directions, max_distance=None)")]
    fn raycast<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        max_distance: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let limit = max_distance.map_or(Ok(f64::INFINITY), |limit| number(limit, "max_distance"))?;
        let (origins, directions) = (vectors(origins, "origins")?, vectors(directions, "directions")?);
        let is_one = origins.1 && directions.1;
        let (origins, directions) = match (&origins.0[..], &directions.0[..]) {
            (origins, directions) if origins.len() == directions.len() => {
                (origins.to_vec(), directions.to_vec())
            }
            (&[origin], directions) if origins.1 => (vec![origin; directions.len()], directions.to_vec()),
            (origins, &[direction]) if directions.1 => (origins.to_vec(), vec![direction; origins.len()]),
            (origins, directions) => {
                return Err(PyValueError::new_err(format!(
                    "there are {} origins and {} directions; give as many of both, or one (3,) for all",
                    origins.len(),
                    directions.len()
                )));
            }
        };
        let rays: Vec<_> = origins.into_iter().zip(directions).collect();
        let found = self.shared.with(py, |simulation| simulation.raycast(&rays, limit))?;
        table(py, &found.map_err(error::value)?, is_one)
    }

    /// Return what is nearest to points: bodies as they are displayed, and colliders.
    ///
    /// points : (3,) or (k, 3) float
    ///     In world space.
    ///
    /// Returns an array as raycast does; distance is that from the point, and never negative.
    #[pyo3(text_signature = "($self, points)")]
    fn nearest<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (points, is_one) = vectors(points, "points")?;
        let found = self.shared.with(py, |simulation| simulation.nearest(&points))?;
        table(py, &found.map_err(error::value)?, is_one)
    }
}

/// Reads vectors, and whether they are one without an axis.
fn vectors(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<[f64; 3]>, bool)> {
    let axes = value.py().import("numpy")?.call_method1("ndim", (value,))?.extract::<usize>();
    match axes {
        Ok(1) => Ok((vec![arrays::vector(value, name)?], true)),
        _ => Ok((arrays::vectors(value, name, Axis::Any("k"))?, false)),
    }
}

/// Returns the structured array of points.
fn table<'py>(py: Python<'py>, found: &[Option<FoundPoint>], is_one: bool) -> PyResult<Bound<'py, PyAny>> {
    let array = structured(py, &FIELDS, found.len())?;
    let numbers = |read: fn(&FoundPoint) -> Option<usize>| {
        let read =
            |point: &Option<FoundPoint>| point.as_ref().and_then(read).map_or(-1, |index| index as i32);
        PyArray1::from_vec(py, found.iter().map(read).collect())
    };
    let rows = |read: fn(&FoundPoint) -> [f64; 3]| {
        from_vectors(py, found.iter().map(|point| point.as_ref().map_or([0.0; 3], read)).collect())
    };
    let body = |point: &FoundPoint| if let Touched::Body(index) = point.of { Some(index) } else { None };
    let collider =
        |point: &FoundPoint| if let Touched::Collider(index) = point.of { Some(index) } else { None };
    array.set_item("body", numbers(body))?;
    array.set_item("collider", numbers(collider))?;
    array.set_item("face", numbers(|point| point.face.map(|face| face as usize)))?;
    let distance = |point: &Option<FoundPoint>| point.as_ref().map_or(f64::INFINITY, |point| point.distance);
    array.set_item("distance", PyArray1::from_vec(py, found.iter().map(distance).collect()))?;
    array.set_item("point", rows(|point| point.point.into()))?;
    array.set_item("normal", rows(|point| point.normal.into()))?;
    if is_one { array.get_item(0) } else { Ok(array) }
}
