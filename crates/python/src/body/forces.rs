//! Applies forces to a body: during the next call, for a time, or in every step until they are removed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::{Point3, Vector3};
use numpy::PyArray2;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use supple::{Force as AppliedForce, ForceDuration, Selection};

use super::fields::{Field, Force, Part, Source};
use super::force_field::ForceField;
use super::{Body, SharedBody};
use crate::argument::Settings;
use crate::arrays::{self, Axis};
use crate::pickle::{decode, encode};
use crate::{constraint, error};

/// Positions and velocities of a body, and the vertices of each of its force fields; `None`: all.
type Sampled = (Vec<Point3<f64>>, Vec<Vector3<f64>>, Vec<Option<Vec<u32>>>);

/// The forces of the fields of a body, evaluated for a step.
pub(crate) struct FieldForces {
    fields: Vec<Arc<Field>>,
    /// The results of the functions; `None` for the other fields.
    results: Vec<Option<Force>>,
}

impl SharedBody {
    /// Returns whether the body has force fields.
    pub(crate) fn has_fields(&self) -> bool {
        !self.fields.lock().is_empty()
    }

    /// Evaluates the force fields at a time.
    pub(crate) fn field_forces(&self, py: Python<'_>, time: f64) -> PyResult<FieldForces> {
        let fields = self.fields.lock().clone();
        let is_function = |field: &Arc<Field>| matches!(field.source, Source::Function(_));
        let sample = |body: &supple::Body| -> Sampled {
            let parts = fields.iter().map(|field| match is_function(field) {
                true => field.part.vertices(body.lattice()),
                false => None,
            });
            (body.positions(), body.velocities(), parts.collect())
        };
        let (positions, velocities, parts) = match fields.iter().any(is_function) {
            true => self.read(py, sample)?,
            false => Sampled::default(),
        };
        // The results of the functions; the other fields need none.
        let mut results = Vec::with_capacity(fields.len());
        for (index, field) in fields.iter().enumerate() {
            let Source::Function(function) = &field.source else {
                results.push(None);
                continue;
            };
            let vertices = &parts[index];
            let count = vertices.as_ref().map_or(positions.len(), Vec::len);
            let positions = rows(py, vertices, |vertex| positions[vertex].into(), count);
            let velocities = rows(py, vertices, |vertex| velocities[vertex].into(), count);
            let force = function.bind(py).call1((positions, velocities, time))?;
            results.push(Some(read_force(&force, "the result of the force field", Axis::Is(count))?));
        }
        Ok(FieldForces { fields, results })
    }

    /// Applies the forces of force fields in the next step.
    pub(crate) fn apply_fields(&self, py: Python<'_>, forces: FieldForces) -> PyResult<()> {
        let FieldForces { fields, results } = forces;
        let apply_all = |body: &mut supple::Body| -> Result<Option<usize>, supple::Error> {
            let duration = ForceDuration::Step;
            for (index, (field, result)) in fields.iter().zip(results).enumerate() {
                let vertices = field.part.vertices(body.lattice());
                let total = |force: [f64; 3]| AppliedForce { duration, ..force.into() };
                match (&field.source, result) {
                    (Source::Constant(Force::Total(force)), _) => apply_total(body, total(*force), vertices)?,
                    (_, Some(Force::Total(force))) => apply_total(body, total(force), vertices)?,
                    (Source::Constant(Force::Each(forces)), _) => {
                        let forces = field.part.forces(body, forces);
                        apply_each(body, forces, duration)?;
                    }
                    (_, Some(Force::Each(forces))) => {
                        let vertices = vertices.unwrap_or_else(|| (0..body.lattice().len() as u32).collect());
                        if vertices.len() != forces.len() {
                            return Ok(Some(index));
                        }
                        apply_each(body, vertices.into_iter().zip(forces).collect(), duration)?;
                    }
                    (Source::Function(_), None) => unreachable!("each function has a result"),
                }
            }
            Ok(None)
        };
        match self.with(py, apply_all)?.map_err(error::from_core)? {
            None => Ok(()),
            Some(index) => Err(PyValueError::new_err(format!(
                "force_fields[{index}]: the body broke in another thread while the function was called"
            ))),
        }
    }

    /// Returns the force fields as pairs of the force and the encoded part.
    pub(crate) fn field_arguments<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyTuple>>> {
        let fields = self.fields.lock().clone();
        let pair = |field: &Arc<Field>| (field.source.python(py), encode(py, &field.part)?).into_pyobject(py);
        fields.iter().map(pair).collect()
    }
}

/// Adds force fields to a body, from pairs of [`SharedBody::field_arguments`].
pub(crate) fn add_fields(body: &Bound<'_, Body>, fields: Vec<Bound<'_, PyTuple>>) -> PyResult<()> {
    for arguments in fields {
        let (force, part): (Bound<'_, PyAny>, Bound<'_, PyBytes>) = arguments.extract()?;
        let source = match force.is_callable() {
            true => Source::Function(force.unbind()),
            // A body can have more vertices than when the field was added, because it broke.
            false => Source::Constant(read_force(&force, "force", Axis::Any("k"))?),
        };
        add(body, source, decode(body.py(), part.as_bytes())?);
    }
    Ok(())
}

/// Adds a force field to a body.
fn add(body: &Bound<'_, Body>, source: Source, part: Part) -> ForceField {
    static NEXT_ID: AtomicU64 = AtomicU64::new(0);
    let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
    body.get().fields.lock().push(Arc::new(Field { id, source, part }));
    ForceField { body: body.clone().unbind(), id }
}

/// Returns the rows of selected vertices as an array.
fn rows<'py>(
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

/// Applies a total force to vertices. Leaves out a force of zero.
fn apply_total(
    body: &mut supple::Body,
    force: AppliedForce,
    vertices: Option<Vec<u32>>,
) -> Result<(), supple::Error> {
    if force.force == [0.0; 3] && force.torque == [0.0; 3] {
        return Ok(());
    }
    body.apply_force(force, &part_of(body, vertices))
}

/// Returns the selection of vertices; `None`: all.
fn part_of(body: &supple::Body, vertices: Option<Vec<u32>>) -> Selection {
    Selection::Vertices(vertices.unwrap_or_else(|| (0..body.lattice().len() as u32).collect()))
}

/// Applies forces to vertices. Leaves out vertices with a force of zero.
fn apply_each(
    body: &mut supple::Body,
    mut forces: Vec<(u32, [f64; 3])>,
    duration: ForceDuration,
) -> Result<(), supple::Error> {
    forces.retain(|(_, force)| *force != [0.0; 3]);
    if forces.is_empty() { Ok(()) } else { body.apply_forces_for(&forces, duration) }
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
    let settings = Settings::from_call(options, function, &constraint::SELECTION, &constraint::SHAPES)?;
    selected_vertices(body, py, &settings, function)
}

/// Reads the selection of a force from the arguments of a function; `None`: all vertices.
fn selected_vertices(
    body: &Body,
    py: Python<'_>,
    settings: &Settings<'_>,
    function: &str,
) -> PyResult<Option<Vec<u32>>> {
    if !constraint::has_selection(settings)? {
        return match constraint::pose(settings, function)? {
            Some(_) => Err(PyTypeError::new_err(format!("{function} has at only together with a shape"))),
            None => Ok(None),
        };
    }
    body.select(py, settings, function).map(Some)
}

/// A force or an impulse on vertices.
enum Applied {
    Total(AppliedForce),
    Each(Vec<(u32, [f64; 3])>),
}

/// Keyword arguments of an impulse. All but the last may be `None`.
const IMPULSE: [&str; 10] = constraint::with_shapes(["point", "torque", "at"]);

/// Keyword arguments of a force. All but the last may be `None`.
const FORCE: [&str; 11] = constraint::with_shapes(["point", "torque", "duration", "at"]);

impl Body {
    /// Reads a force or an impulse and its part, and applies it. `apply` has the vertices of the part; `None`: all.
    fn apply(
        &self,
        py: Python<'_>,
        (name, value): (&str, &Bound<'_, PyAny>),
        settings: &Settings<'_>,
        function: &str,
        apply: impl FnOnce(&mut supple::Body, Applied, Option<Vec<u32>>) -> Result<(), supple::Error> + Send,
    ) -> PyResult<()> {
        let vertices = selected_vertices(self, py, settings, function)?;
        let count = vertices.as_ref().map_or_else(|| self.count(py), |list| Ok(list.len()))?;
        let (point, torque) =
            (settings.read("point", arrays::vector)?, settings.read("torque", arrays::vector)?);
        let applied = match read_force(value, name, Axis::Is(count))? {
            Force::Total(force) => {
                Applied::Total(AppliedForce { point, torque: torque.unwrap_or_default(), ..force.into() })
            }
            Force::Each(_) if point.is_some() || torque.is_some() => {
                return Err(PyTypeError::new_err(format!(
                    "{function} has point and torque only together with a total {name} (3,)"
                )));
            }
            Force::Each(forces) => {
                let all = || (0..count as u32).collect();
                Applied::Each(vertices.clone().unwrap_or_else(all).into_iter().zip(forces).collect())
            }
        };
        self.with(py, |body| apply(body, applied, vertices))?.map_err(error::from_core)
    }
}

#[pymethods]
impl Body {
    /// Apply a force in all steps of the next call of step or advance. Several forces add up.
    ///
    /// force : (3,) or (k, 3) float
    ///     In kg length/s^2. (3,): the total force, which is distributed over the selected lattice vertices such that they
    ///     would be accelerated like a rigid body: without point and torque, in proportion to their masses. (k, 3): one
    ///     force for each of the k selected vertices, in the order of the indices `vertices`, otherwise in increasing
    ///     order; without point and torque.
    /// box, sphere, plane, vertices, mesh_vertices, group, map, at
    ///     Selection of a part, as for pin. Default: the whole body, k = n.
    /// point : (3,) float, optional
    ///     World point at which the total force acts. Default: the center of mass of the part.
    /// torque : (3,) float, optional
    ///     Torque about the center of mass of the part, in kg length^2/s^2, besides that of the force.
    /// duration : float, optional
    ///     Seconds, above 0, for which the force acts. In a last step that is longer than the rest of the time it is as
    ///     much smaller: the whole impulse is force x duration. Default: the next call of step(n) or advance(n), however
    ///     long it is.
    ///
    /// Raises ValueError for an empty selection, a force that accelerates by more than 1e15 cells/s^2, or a torque about
    /// the line on which all selected vertices lie.
    #[pyo3(
        signature = (force, **options),
        text_signature = "($self, force, *, box=None, sphere=None, plane=None, vertices=None, mesh_vertices=None, group=None, map=None, at='now', point=None, \
                          torque=None, duration=None)"
    )]
    fn apply_force(
        &self,
        py: Python<'_>,
        force: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let settings = Settings::from_call(options, "apply_force()", &FORCE, &FORCE[..FORCE.len() - 1])?;
        let duration = settings.number("duration")?.map_or(ForceDuration::Call, ForceDuration::Seconds);
        self.apply(py, ("force", force), &settings, "apply_force()", move |body, force, vertices| match force
        {
            Applied::Total(force) => apply_total(body, AppliedForce { duration, ..force }, vertices),
            Applied::Each(forces) => apply_each(body, forces, duration),
        })
    }

    /// Apply an impulse in the next step: the momentum changes by it, whatever the length of the step.
    ///
    /// impulse : (3,) or (k, 3) float
    ///     In kg length/s, distributed like the force of apply_force.
    /// box, sphere, plane, vertices, mesh_vertices, group, map, at
    ///     Selection of a part, as for pin. Default: the whole body, k = n.
    /// point : (3,) float, optional
    ///     World point at which the total impulse acts. Default: the center of mass of the part.
    /// torque : (3,) float, optional
    ///     Angular impulse about the center of mass of the part, in kg length^2/s, besides that of the impulse.
    ///
    /// Raises ValueError as apply_force does.
    #[pyo3(
        signature = (impulse, **options),
        text_signature = "($self, impulse, *, box=None, sphere=None, plane=None, vertices=None, mesh_vertices=None, group=None, map=None, at='now', point=None, \
                          torque=None)"
    )]
    fn apply_impulse(
        &self,
        py: Python<'_>,
        impulse: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let settings =
            Settings::from_call(options, "apply_impulse()", &IMPULSE, &IMPULSE[..IMPULSE.len() - 1])?;
        self.apply(py, ("impulse", impulse), &settings, "apply_impulse()", |body, impulse, vertices| {
            match impulse {
                Applied::Total(impulse) => body.apply_impulse(impulse, &part_of(body, vertices)),
                Applied::Each(impulses) => body.apply_impulses(&impulses),
            }
        })
    }

    /// Apply a force in every step, until the field is removed. Returns a ForceField.
    ///
    /// force : (3,) or (k, 3) float, or callable
    ///     A constant force as for apply_force; or a function force(positions, velocities, time) that returns it. It is
    ///     called before each step, with the (k, 3) positions and velocities of the selected lattice vertices,
    ///     read-only, and the time in seconds.
    /// box, sphere, plane, vertices, mesh_vertices, group, map, at
    ///     Selection of a part, as for pin. Default: the whole body. It is made once, now.
    ///
    /// A field follows a body that breaks: it acts on all copies of its vertices, and k grows. A vertex and its copies
    /// share a constant force (k, 3) on the vertex in proportion to their masses. A function gets the rows of the
    /// selected vertices first, then those of their copies in increasing order, and returns one force for each.
    ///
    /// Several fields add up, with apply_force too. A body falls asleep under forces that stay the same, to a
    /// thousandth of the weight on each vertex, and wakes when they change. A function is called from step and advance,
    /// which let an exception pass: the step then is not made. Each step with fields takes some microseconds more, with
    /// a function some tens of microseconds for 1,000 lattice vertices. Pickles and copies contain fields, states of
    /// save_state do not.
    #[pyo3(
        signature = (force, **options),
        text_signature = "($self, force, *, box=None, sphere=None, plane=None, vertices=None, mesh_vertices=None, group=None, map=None, at='now')"
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
        let part = this.read(py, |body| Part::new(body.lattice(), vertices))?;
        let changed =
            "add_force_field(): the vertices of the body changed in another thread; select them again";
        let part = part.ok_or_else(|| PyValueError::new_err(changed))?;
        Ok(add(slf, source, part))
    }

    /// Force fields that were not removed, in the order in which they were added: tuple of ForceField.
    #[getter]
    fn force_fields<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let ids: Vec<u64> = slf.get().fields.lock().iter().map(|field| field.id).collect();
        PyTuple::new(slf.py(), ids.into_iter().map(|id| ForceField { body: slf.clone().unbind(), id }))
    }
}
