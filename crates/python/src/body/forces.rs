//! Applies forces to a body: for the next step, or in every step until they are removed.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple::Selection;

use super::fields::{Field, Force, Source};
use super::{Body, SharedBody};
use crate::argument::Settings;
use crate::arrays::{self, Axis};
use crate::{constraint, error};

/// A force of the next step, with the lattice vertices on which it acts; `None`: all.
type NextForce = (Force, Option<Vec<u32>>);

impl SharedBody {
    /// Returns whether the body has force fields.
    pub(crate) fn has_fields(&self) -> bool {
        !self.fields.lock().is_empty()
    }

    /// Evaluates the force fields at a time, and applies their forces in the next step. If a function raises an error,
    /// no force is applied.
    pub(crate) fn apply_fields(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        let fields = self.fields.lock().clone();
        let is_function = |field: &Arc<Field>| matches!(field.source, Source::Function(_));
        let state = match fields.iter().any(is_function) {
            true => Some(self.read(py, |body| (body.positions(), body.velocities()))?),
            false => None,
        };
        let evaluate = |field: Arc<Field>| -> PyResult<NextForce> {
            let vertices = field.vertices.clone();
            let force = match (&field.source, &state) {
                (Source::Constant(force), _) => force.clone(),
                (Source::Function(function), Some((positions, velocities))) => {
                    let count = vertices.as_ref().map_or(positions.len(), Vec::len);
                    let positions = part(py, &vertices, |vertex| positions[vertex].into(), count);
                    let velocities = part(py, &vertices, |vertex| velocities[vertex].into(), count);
                    let force = function.bind(py).call1((positions, velocities, time))?;
                    read_force(&force, "the result of the force field", Axis::Is(count))?
                }
                (Source::Function(_), None) => unreachable!("the state is read if there is a function"),
            };
            Ok((force, vertices))
        };
        let forces = fields.into_iter().map(evaluate).collect::<PyResult<Vec<_>>>()?;
        self.with(py, |body| forces.into_iter().try_for_each(|force| apply(body, force)))?
            .map_err(error::from_core)
    }

    /// Returns the force fields as pairs of arguments of `add_force_field`: force, and vertices or `None`.
    pub(crate) fn field_arguments<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyTuple>>> {
        let fields = self.fields.lock().clone();
        let vertices = |field: &Field| {
            field.vertices.as_ref().map(|list| PyArray1::from_iter(py, list.iter().map(|&v| i64::from(v))))
        };
        fields.iter().map(|field| (field.source.python(py), vertices(field)).into_pyobject(py)).collect()
    }
}

/// Adds force fields to a body, from pairs of [`SharedBody::field_arguments`].
pub(crate) fn add_fields(body: &Bound<'_, Body>, fields: Vec<Bound<'_, PyTuple>>) -> PyResult<()> {
    for arguments in fields {
        let (force, vertices): (Bound<'_, PyAny>, Option<Vec<u32>>) = arguments.extract()?;
        let source = match force.is_callable() {
            true => Source::Function(force.unbind()),
            // A body can have more vertices than when the field was added, because it broke.
            false => Source::Constant(read_force(&force, "force", Axis::Any("k"))?),
        };
        add(body, source, vertices);
    }
    Ok(())
}

/// Adds a force field to a body.
fn add(body: &Bound<'_, Body>, source: Source, vertices: Option<Vec<u32>>) -> ForceField {
    static NEXT_ID: AtomicU64 = AtomicU64::new(0);
    let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
    body.get().fields.lock().push(Arc::new(Field { id, source, vertices }));
    ForceField { body: body.clone().unbind(), id }
}

/// Returns the rows of selected vertices as an array.
fn part<'py>(
    py: Python<'py>,
    vertices: &Option<Vec<u32>>,
    row: impl Fn(usize) -> [f64; 3],
    count: usize,
) -> Bound<'py, PyArray2<f64>> {
    let rows = match vertices {
        Some(list) => list.iter().map(|&vertex| row(vertex as usize)).collect(),
        None => (0..count).map(row).collect(),
    };
    arrays::frozen(arrays::from_vectors(py, rows))
}

/// Applies a force in the next step. Leaves out vertices with a force of zero.
fn apply(body: &mut supple::Body, (force, vertices): NextForce) -> Result<(), supple::Error> {
    let vertices = vertices.unwrap_or_else(|| (0..body.lattice().len() as u32).collect());
    match force {
        Force::Total([0.0, 0.0, 0.0]) => Ok(()),
        Force::Total(force) => body.apply_force(force, &Selection::Vertices(vertices)),
        Force::Each(forces) => {
            let forces = vertices.into_iter().zip(forces).filter(|(_, force)| *force != [0.0; 3]);
            match forces.collect::<Vec<_>>() {
                forces if forces.is_empty() => Ok(()),
                forces => body.apply_forces(&forces),
            }
        }
    }
}

/// Reads a force: (3,), the total, or one row per vertex.
fn read_force(value: &Bound<'_, PyAny>, name: &str, rows: Axis) -> PyResult<Force> {
    let array = value.py().import("numpy")?.call_method1("asarray", (value,));
    let axes = array.and_then(|array| array.getattr("ndim")?.extract::<usize>());
    match axes {
        Ok(2) => Ok(Force::Each(arrays::vectors(value, name, rows)?)),
        _ => Ok(Force::Total(arrays::vector(value, name)?)),
    }
}

/// Reads the selection of a force; `None`: all vertices.
fn read_vertices(
    body: &Body,
    py: Python<'_>,
    options: Option<&Bound<'_, PyDict>>,
    function: &str,
) -> PyResult<Option<Vec<u32>>> {
    let settings = Settings::from_call(options, function, &constraint::SHAPES, &constraint::SHAPES)?;
    if !constraint::has_selection(&settings)? {
        return Ok(None);
    }
    match constraint::selection(&settings, function, body.count(py)?)? {
        Selection::Vertices(vertices) if !vertices.is_empty() => Ok(Some(vertices)),
        shape => Ok(Some(body.read(py, |body| body.select(&shape))?.map_err(error::from_core)?)),
    }
}

#[pymethods]
impl Body {
    /// Apply a force in the next step. Several forces add up.
    ///
    /// force : (3,) or (k, 3) float
    ///     In kg length/s^2. (3,): the total force, which is distributed over the selected lattice vertices in
    ///     proportion to their masses. (k, 3): one force for each of the k selected vertices, in the order of the
    ///     indices `vertices`, otherwise in increasing order.
    /// box, sphere, plane, vertices
    ///     Selection of a part, as for pin. Default: the whole body, k = n.
    ///
    /// Raises ValueError for an empty selection or a force that accelerates by more than 1e15 cells/s^2.
    #[pyo3(
        signature = (force, **options),
        text_signature = "($self, force, *, box=None, sphere=None, plane=None, vertices=None)"
    )]
    fn apply_force(
        &self,
        py: Python<'_>,
        force: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let vertices = read_vertices(self, py, options, "apply_force()")?;
        let count = vertices.as_ref().map_or_else(|| self.count(py), |list| Ok(list.len()))?;
        let force = read_force(force, "force", Axis::Is(count))?;
        self.with(py, |body| apply(body, (force, vertices)))?.map_err(error::from_core)
    }

    /// Apply a force in every step, until the field is removed. Returns a ForceField.
    ///
    /// force : (3,) or (k, 3) float, or callable
    ///     A constant force as for apply_force; or a function force(positions, velocities, time) that returns it. It is
    ///     called before each step, with the (k, 3) positions and velocities of the selected lattice vertices,
    ///     read-only, and the time in seconds.
    /// box, sphere, plane, vertices
    ///     Selection of a part, as for pin. Default: the whole body. It is made once, now.
    ///
    /// Several fields add up, with apply_force too. A body falls asleep under forces that stay the same, to a
    /// thousandth of the weight on each vertex, and wakes when they change. A function is called from step and advance,
    /// which let an exception pass: the step then is not made. Each step with fields takes some microseconds more, with
    /// a function some tens of microseconds for 1,000 lattice vertices. Pickles and copies contain fields, states of
    /// save_state do not.
    #[pyo3(
        signature = (force, **options),
        text_signature = "($self, force, *, box=None, sphere=None, plane=None, vertices=None)"
    )]
    fn add_force_field(
        slf: &Bound<'_, Self>,
        force: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<ForceField> {
        let (py, this) = (slf.py(), slf.get());
        let vertices = read_vertices(this, py, options, "add_force_field()")?;
        let source = if force.is_callable() {
            Source::Function(force.clone().unbind())
        } else {
            let count = vertices.as_ref().map_or_else(|| this.count(py), |list| Ok(list.len()))?;
            Source::Constant(read_force(force, "force", Axis::Is(count))?)
        };
        Ok(add(slf, source, vertices))
    }

    /// Force fields that were not removed, in the order in which they were added: tuple of ForceField.
    #[getter]
    fn force_fields<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let ids: Vec<u64> = slf.get().fields.lock().iter().map(|field| field.id).collect();
        PyTuple::new(slf.py(), ids.into_iter().map(|id| ForceField { body: slf.clone().unbind(), id }))
    }
}

/// A force that acts on a body in every step. Body.add_force_field returns it, and Body.force_fields lists those
/// that were not removed.
#[pyclass(frozen, module = "supple")]
pub(crate) struct ForceField {
    body: Py<Body>,
    id: u64,
}

impl ForceField {
    /// Returns the field.
    fn field(&self) -> PyResult<Arc<Field>> {
        let fields = self.body.get().fields.lock();
        fields.iter().find(|field| field.id == self.id).cloned().ok_or_else(|| {
            PyValueError::new_err("the force field was removed; add another one with body.add_force_field()")
        })
    }
}

#[pymethods]
impl ForceField {
    /// Body on which the force acts.
    #[getter]
    fn body(&self, py: Python<'_>) -> Py<Body> {
        self.body.clone_ref(py)
    }

    /// Force as it was given: (3,) or (k, 3) float64, read-only, or a callable.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.field()?.source.python(py))
    }

    /// Lattice vertices on which the force acts: (k,) int64, read-only.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let vertices: Vec<i64> = match &self.field()?.vertices {
            Some(list) => list.iter().map(|&vertex| vertex.into()).collect(),
            None => (0..self.body.get().count(py)? as i64).collect(),
        };
        Ok(arrays::frozen(PyArray1::from_vec(py, vertices)))
    }

    /// Whether the field was removed.
    #[getter]
    fn removed(&self) -> bool {
        self.field().is_err()
    }

    /// Remove the field, from the next step on. A second call has no effect.
    fn remove(&self) {
        self.body.get().fields.lock().retain(|field| field.id != self.id);
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.id == other.id
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.id.hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let name = self.body.get().read(py, |body| body.name().to_owned())?;
        let Ok(field) = self.field() else {
            return Ok(format!("<supple.ForceField of body {name:?}: removed>"));
        };
        let part = match &field.vertices {
            Some(list) if list.len() == 1 => "1 lattice vertex".to_owned(),
            Some(list) => format!("{} lattice vertices", list.len()),
            None => "all lattice vertices".to_owned(),
        };
        let force = match &field.source {
            Source::Constant(Force::Total([x, y, z])) => format!("({x}, {y}, {z})"),
            Source::Constant(Force::Each(_)) => "a constant force on each".to_owned(),
            Source::Function(function) => function.bind(py).repr()?.to_string(),
        };
        Ok(format!("<supple.ForceField of body {name:?}: {force}, on {part}>"))
    }
}
