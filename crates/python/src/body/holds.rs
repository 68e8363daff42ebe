//! Adds pins and handles to a body, and lists them.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple::{ConstraintError, Handle, HandleMotion, Pin, Selection, SelectionPose};
use supple_io::counted;

use super::{Body, Hold};
use crate::argument::Settings;
use crate::{animation, constraint, error};

/// Keyword arguments of `pin`.
const PIN: [&str; 13] =
    constraint::with_shapes(["at", "start", "end", "weight", "goal_frequency", "goal_damping"]);

/// Keyword arguments of `pin` that may be `None`.
const OPTIONAL_OF_PIN: [&str; 8] = constraint::with_shapes(["end"]);

/// Keyword arguments of `handle`, beside those of `pin`.
const MOTION: [&str; 5] = ["keys", "interpolation", "follow", "follow_fps", "follow_start"];

/// Keyword arguments of `handle` that may be `None`.
const OPTIONAL_OF_HANDLE: [&str; 11] = constraint::with_shapes(["end", "keys", "follow", "follow_start"]);

#[pymethods]
impl Body {
    /// Pin a part of the body: fix the part in the pose that it has at `start`. Returns a Hold.
    ///
    /// Exactly one of box, sphere, plane, vertices, mesh_vertices, group and map selects the part. A shape is in world space,
    /// and selects the corners of every cell that contains a mesh vertex inside the shape. On a bare lattice a shape selects the lattice
    /// vertices inside the shape.
    ///
    /// box : ((3,), (3,))
    ///     Minimum and maximum corner.
    /// sphere : ((3,), float)
    ///     Center and radius.
    /// plane : ((3,), (3,))
    ///     Point and normal: selects the side that the normal points to.
    /// vertices : (k,) int, or (n,) bool
    ///     Lattice vertices: indices, or a mask, also one of whole numbers 0 and 1.
    /// mesh_vertices : (k,) int, or (n,) bool
    ///     Vertices of the mesh, in input order: selects the corners of their cells.
    /// group : str
    ///     Name of a group of the mesh (Mesh.groups): selects as its mesh vertices do.
    /// map : (n,) float in [0, 1], (n,) bool, or str
    ///     A weight for each mesh vertex, or the name of a map of the mesh (Mesh.maps): a factor of `weight` at each lattice
    ///     vertex, see weights. Vertices with 1 are held, those below are pulled by springs, and those below 0.01 are free.
    /// at : "now" or "start", default "now"
    ///     Pose of the body in which a shape selects: the current one, or that of frame 0.
    /// start, end : float, default 0 and None
    ///     Time window of the pin in seconds. Without end the pin stays active.
    /// weight : float, or list of (time, value), default 1
    ///     In (0, 1]. Below 1 the part is not held, but each vertex is pulled to its place by a spring of the frequency
    ///     goal_frequency x sqrt(weight / (1 - weight)), the same at any step length and on any lattice.
    /// goal_frequency : float, default 5
    ///     Frequency in Hz, above 0, that a weight of 0.5 gives.
    /// goal_damping : float, default 0.2
    ///     Damping ratio of the springs, in [0, 1].
    ///
    /// Parts may overlap: of the pins and handles that are active, the one that was added last moves the
    /// common vertices, and when it ends, the one before it moves them again.
    ///
    /// Raises ValueError for an empty selection; the message gives the distance to the nearest vertex.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, box=None, sphere=None, plane=None, vertices=None, mesh_vertices=None, group=None, map=None, at='now', start=0.0, end=None, weight=1.0, goal_frequency=5.0, goal_damping=0.2)"
    )]
    fn pin(slf: &Bound<'_, Self>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Hold> {
        let settings = Settings::from_call(options, "pin()", &PIN, &OPTIONAL_OF_PIN)?;
        let selection = slf.get().held(slf.py(), &settings, "pin()")?;
        let (goal, window) = (constraint::goal(&settings)?, constraint::window(&settings)?);
        let pin = Pin { goal, selection, window };
        Hold::add(slf, |body| body.pin(&pin))
    }

    /// Move a part of the body along keyframes, or with an animated mesh. Returns a Hold. Exactly one of keys and
    /// follow is given.
    ///
    /// keys : list of (time, translate, rotate), or of dicts with these names
    ///     Keyframes, relative to the pose that the part has at `start`. time: seconds, strictly increasing.
    ///     translate: (3,) length, default 0. rotate: (3,) degrees about the fixed axes x, then y, then z
    ///     through the mean position of the selected lattice vertices at `start`, default 0; or a quaternion x, y, z,
    ///     w, a rotation matrix or a scipy Rotation, which become the angles nearest to those of the keyframe before.
    /// interpolation : "linear", "smooth" or "cubic", default "linear"
    ///     How translations and angles go from one keyframe to the next: "linear", with constant velocity; "smooth",
    ///     from rest to rest; "cubic", through the keyframes with a continuous velocity and without overshoot.
    ///
    /// follow : (f, n, 3) float, or path of a PC2 file
    ///     Positions of the n vertices of the body's mesh at f times: the animation replaces the coordinates of the
    ///     mesh that the body was built from, so that its scale, rotate and translate apply to the animation also. The
    ///     selected lattice vertices move rigidly with the mesh vertices around them that a shape contains, or with
    ///     those of the whole mesh if `vertices` selects the part. Between two frames the mesh moves linearly, before
    ///     the first and after the last frame it is at rest. The part is at the animation's place at any time: it jumps
    ///     at `start` if the body is elsewhere then.
    /// follow_fps : float, > 0, default 30
    ///     Frames per second of the animation.
    /// follow_start : float, default 0, or the time of the first sample in the PC2 file
    ///     Time of the first frame in seconds.
    ///
    /// The other arguments and the errors are the same as for pin, except that shapes select at frame 0 with follow.
    /// Raises ValueError for an animation of another shape,
    /// and for follow on a broken body.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, keys=None, interpolation='linear', follow=None, follow_fps=30.0, follow_start=None, box=None, sphere=None, plane=None, vertices=None, mesh_vertices=None, group=None, map=None, at='now', start=0.0, end=None, weight=1.0, goal_frequency=5.0, goal_damping=0.2)"
    )]
    fn handle(slf: &Bound<'_, Self>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Hold> {
        let settings =
            Settings::from_call(options, "handle()", &[&MOTION[..], &PIN].concat(), &OPTIONAL_OF_HANDLE)?;
        let window = constraint::window(&settings)?;
        let motion = Self::motion(slf, &settings)?;
        let selection = match (&motion, constraint::pose(&settings, "handle()")?) {
            (HandleMotion::Keys(..), _) => slf.get().held(slf.py(), &settings, "handle()")?,
            (HandleMotion::Follow(_), Some(SelectionPose::Now)) => {
                let message = "handle() with follow has only at=\"start\": the shape also selects what the part follows";
                return Err(PyValueError::new_err(message));
            }
            (HandleMotion::Follow(_), _) => {
                constraint::selection(&settings, "handle()", slf.get().counts(slf.py())?)?
            }
        };
        let handle = Handle { goal: constraint::goal(&settings)?, selection, motion, window };
        Hold::add(slf, |body| body.handle(&handle))
    }

    /// Pins and handles that were not released, in the order in which they were added: tuple of Hold.
    ///
    /// Pins and handles of a scene come first: the pins of the body, then its handles.
    #[getter]
    fn holds<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let indices: Vec<usize> =
            slf.get().read(slf.py(), |body| body.constraints().map(supple::Constraint::index).collect())?;
        PyTuple::new(slf.py(), indices.into_iter().map(|index| Hold::new(slf, index)))
    }
}

impl Body {
    /// Returns the lattice vertices of the selection in the arguments of `function`, those of a list in its order.
    pub(super) fn select(
        &self,
        py: Python<'_>,
        settings: &Settings<'_>,
        function: &str,
    ) -> PyResult<Vec<u32>> {
        let pose = constraint::pose(settings, function)?.unwrap_or(SelectionPose::Now);
        match constraint::selection(settings, function, self.counts(py)?)? {
            Selection::Vertices(vertices) if !vertices.is_empty() => Ok(vertices),
            selection => self.read(py, |body| body.select_at(&selection, pose))?.map_err(error::from_core),
        }
    }

    /// Returns the selection of a pin or a handle in the arguments of `function`: a map, or lattice vertices.
    fn held(&self, py: Python<'_>, settings: &Settings<'_>, function: &str) -> PyResult<Selection> {
        match settings.get("map")? {
            Some(_) => {
                constraint::pose(settings, function)?;
                constraint::selection(settings, function, self.counts(py)?)
            }
            None => Ok(Selection::Vertices(self.select(py, settings, function)?)),
        }
    }

    /// Reads the motion of a handle.
    fn motion(slf: &Bound<'_, Self>, settings: &Settings<'_>) -> PyResult<HandleMotion> {
        settings.exclusive("keys", "follow")?;
        let unused = |names: &[&str], owner: &str| -> PyResult<()> {
            match names.iter().find_map(|name| Some((name, settings.get(name).transpose()?))) {
                Some((name, _)) => {
                    Err(PyTypeError::new_err(format!("handle() has {name} only together with {owner}")))
                }
                None => Ok(()),
            }
        };
        if let Some(keys) = settings.get("keys")? {
            unused(&animation::TIMES, "follow")?;
            let interpolation = constraint::interpolation(settings)?.unwrap_or_default();
            return Ok(HandleMotion::Keys(constraint::keys(&keys)?, interpolation));
        }
        let Some(follow) = settings.get("follow")? else {
            return Err(PyTypeError::new_err("handle() needs keys= or follow="));
        };
        unused(&["interpolation"], "keys")?;
        let size = |body: &supple::Body| {
            (body.mesh().map(|mesh| mesh.vertices().len()), body.lattice().broken_joints().len())
        };
        let (vertices, broken) = slf.get().read(slf.py(), size)?;
        if broken > 0 {
            let joints = counted(broken, "broken joint");
            return Err(PyValueError::new_err(format!(
                "handle(): follow needs a whole body, and this one has {joints}; add the handle before the body \
                 breaks, or pass keys"
            )));
        }
        let Some(vertices) = vertices else {
            return Err(error::value(ConstraintError::NoMesh));
        };
        Ok(HandleMotion::Follow(animation::followed(&follow, settings, vertices)?))
    }
}
