//! The class `supple.Body`, and the Python object of a body.

use std::ops::Deref;
use std::sync::{Arc, OnceLock, PoisonError};

use pyo3::prelude::*;
use pyo3::types::{PyWeakrefMethods, PyWeakrefReference};

use super::storage::{BuildArguments, SharedBody, Storage};

/// A soft body: a lattice with a material and a state, and the mesh that the lattice deforms.
///
/// shape : Mesh, Lattice, path, an object with vertices and faces, or a mesh of trimesh, meshio, Open3D or PyVista
///     Path of an OBJ, GLB, glTF, STL or PLY file, or of an OFF or 3MF file, which trimesh reads. A body from a Lattice
///     has no mesh to display.
/// name : str, default "body"
/// object : str
///     If the shape is a path: reads only the object or group with this name.
/// scale : float or (3,) float, default 1
///     Factor of the lengths of the shape, > 0, applied first; or, of a mesh, one for each of its axes, not 0, of which
///     negative ones mirror it.
/// refine : str, default "off"
///     "auto": faces of the mesh that are larger than cells are divided, so that the surface bends between its vertices.
///     The mesh of the body then has more vertices, after those of the given mesh.
/// rotate : (3,), (4,) or (3, 3) float, or scipy Rotation, default 0
///     Degrees about the fixed axes x, then y, then z; or a quaternion x, y, z, w, as in scipy; or a rotation matrix.
/// translate : (3,) float, default 0
///     Offset in scene units, applied last.
/// rigid : bool, default False
///     Whether the body is rigid: it moves with six degrees of freedom, and does not deform. Its mass and inertia are exact for
///     a closed mesh, and those of the lattice for an open mesh and a Lattice. Arguments of soft bodies, from material to
///     poisson_ratio, inflate, damping, plastic and fracture, and a volume measure exclude it.
/// lattice_vertices : int, default 1000, and 300 if rigid; or cell_size : float
///     Resolution of the lattice of a mesh: target number of vertices, at least 8, or edge of a cell, > 0.
/// join : bool, default True
///     Whether bridges of cells join separate parts of a mesh. If False, each part is a separate component.
/// memory_limit : int, default half of the machine's memory
///     Limit in bytes of the memory of the body.
/// material : "jelly", "flesh" (default), "rubber" or "firm"; or youngs_modulus : float or keyframes
///     What the body is made of. A named material keeps the shape of a body of any size under any gravity: its
///     Young's modulus is k x density x L x max(g, 8 L/s^2), with k = 20, 80, 300 or 1500, the size L (cube root of
///     the volume) and the gravity g, times (s/4)^(8/3) if the body is s > 4 times as long as it is wide.
///     youngs_modulus: force per area in scene units, > 0, a number or keyframes as of inflate.
/// half_width : 0.5 or int, default 2; or stiffness_radius : float
///     In place of a material, the parameters of FastLSM. Half-width of the regions: in cells, at least 1, or 0.5 for
///     regions of one cell; or as a length, > 0. Larger regions are stiffer.
/// stiffness : float, default 1; or frequency : float
///     Also in place of a material: alpha per step, in (0, 1], or the frequency of a vertex about its goal in Hz, > 0.
/// accuracy : str, default "balanced"
///     How the half-width of the regions is chosen for a material or youngs_modulus: "fast" (wide regions, narrower
///     in thin bodies: the fewest steps), "balanced" (the least half-width with which a second of
///     a scene takes at most 0.12 seconds, by an estimate; at most 1 in a body that is plastic or breaks by itself), or
///     "exact" (regions of one cell: layers that are held or touched strain as the others do).
/// poisson_ratio : float or keyframes
///     In [0, 0.47]: stretched by the share s, the body becomes narrower by this times s. Default 0.45 for "jelly" and
///     "flesh", 0.4 for "rubber", 0.3 for "firm", otherwise 0: it keeps its width.
///     Steps are shorter for large ones: 2.6 times as many at 0.45.
/// inflate : float or keyframes, default 1
///     Ratio of the rest volume to that of the mesh, in [0.1, 10]: a number, a list of (time, value), or a dict with the keys
///     keys and interpolation ("linear", "smooth" or "cubic"). The body grows or shrinks to it.
/// damping_ratio : float or keyframes; or damping_rate : float
///     Damping of the elastic modes; flight, spin, sliding and swinging are undamped. Damping ratio of the lowest
///     mode, in [0, 1]; default 0.1 for "jelly", 0.3 for "flesh", otherwise 0.2. Or the rate in 1/s, >= 0, at which
///     the amplitude of every mode decays.
/// region_damping : float, default 0; or region_damping_rate : float
///     Damping of the non-rigid velocity within regions: fraction removed per step, in [0, 1], or rate in
///     1/s, >= 0.
/// density : float, default 1000
///     Mass per volume, > 0.
/// plastic : dict or True, default None
///     Makes the body plastic: parts that are strained beyond a limit keep a part of their deformation. A dict with the
///     keys yield (strain, in (0, 1], beyond which it flows; default 0.05), creep (rate in 1/s, > 0, at which the
///     strain beyond it becomes plastic; default 5) and max (greatest plastic strain, in (0, 2]; default 1); True for
///     these defaults. The regions must be small beside the parts that are deformed.
/// fracture : dict, default None
///     Makes the body break. A dict with either strength (tensile stress, > 0, at which it breaks) or strain (tensile
///     strain, > 0), and the keys rotation (degrees, in (0, 180], between neighboring cells at which it breaks too;
///     default None), cracks (greatest number of cracks that grow at a time in each piece, from 1 to 1,000,000; default
///     1), noise (relative variation of the limit, in [0, 0.5]; default 0.05), seed (of the noise; default 0) and
///     surface (of the cracks: "smooth", the default, or "cells"). Arrays with one row per vertex grow when the body
///     breaks: see topology_version.
/// volume : str or dict, default "auto"
///     Volume correction: "off", or the volume measure to preserve ("auto", "mesh", "cells" or "lattice"); or
///     a dict with the keys measure, scope ("global", or "regional" to correct where the volume changed),
///     field (deformation field of the correction: "auto", "surface", "cells" or "paper") and max_correction (cap of
///     the scale, >= 0, as a fraction of the thickness of the body).
/// skin : str, default "linear"
///     How the mesh follows the lattice: "linear" (trilinear in each cell), or "smooth" (first derivatives are
///     continuous across the faces of the cells, which reduces creases; trilinear where the lattice is bent or
///     crushed very strongly).
/// friction : float or keyframes, default 0.5
///     Coulomb coefficient at other bodies, >= 0. That of two bodies is the geometric mean of theirs; at a collider,
///     that of the collider holds.
/// restitution : float, default 0
///     Ratio of the speeds of the touching points after and before an impact on another body, in [0, 1]. That of two
///     bodies is the greater of theirs; at a collider, that of the collider holds.
/// rolling_resistance : float
///     Coefficient of rolling resistance on colliders, >= 0: the greatest distance of the center of pressure of a contact from
///     its middle, as a fraction of the radius of the contact. Default 0.08 times the damping ratio, or 0.016 with a damping_rate above 0.
/// thickness : float, default 0
///     Distance outside of the surface at which the body touches, in scene units, from 0 to half of the longest side of
///     the body. Bodies rest at the sum of their thicknesses, and on a collider at the sum with its thickness.
/// ignore : list of str, default empty
///     Names of bodies that the body does not touch, whichever of the two names the other.
/// self_contact : bool
///     Whether parts of the body touch each other; by default the simulation decides.
/// velocity : (3,) float, default 0
///     Initial velocity in length/s.
/// spin : (3,) float, default 0
///     Initial angular velocity in rad/s about the center of mass.
///
/// Arrays with one row per lattice vertex have the order of lattice.indices. A body belongs to at most one
/// Simulation, and stays usable when it is in a Simulation. Raises ValueError for a value out of range,
/// MeshError and LatticeError for an invalid mesh or lattice, and TypeError for a wrong type.
#[pyclass(frozen, module = "supple", weakref)]
pub(crate) struct Body {
    pub(super) shared: Arc<SharedBody>,
    /// The Python object of the simulation, which the body keeps alive. Empty outside a simulation.
    pub(super) simulation: OnceLock<Py<PyAny>>,
}

impl Deref for Body {
    type Target = SharedBody;

    fn deref(&self) -> &SharedBody {
        &self.shared
    }
}

impl Body {
    /// Creates the Python object of a body outside a simulation.
    pub(super) fn alone(body: supple::Body, arguments: BuildArguments<'_>) -> Self {
        let shared = SharedBody::new(Storage::Alone(Box::new(body)), arguments);
        Self { shared: Arc::new(shared), simulation: OnceLock::new() }
    }

    /// Returns the shared body of a Python object, which becomes the object that
    /// [`SharedBody::python_object`] returns.
    pub(crate) fn share(body: &Bound<'_, Self>) -> PyResult<Arc<SharedBody>> {
        let shared = body.get().shared.clone();
        shared.set_python_object(body)?;
        Ok(shared)
    }
}

impl SharedBody {
    /// Returns the Python object of the body in a simulation. Creates the object if it does not exist.
    pub(crate) fn python_object<'py>(
        self: &Arc<Self>,
        simulation: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, Body>> {
        let py = simulation.py();
        if let Some(body) = self.existing_python_object(py) {
            return Ok(body);
        }
        let simulation = OnceLock::from(simulation.clone().unbind());
        let body = Bound::new(py, Body { shared: self.clone(), simulation })?;
        self.set_python_object(&body)?;
        Ok(body)
    }

    /// Makes the Python object of the body, if it exists, keep the Python object of its simulation alive.
    pub(crate) fn attach(&self, simulation: &Bound<'_, PyAny>) {
        if let Some(body) = self.existing_python_object(simulation.py()) {
            // A second `__init__` of the same simulation changes nothing.
            body.get().simulation.get_or_init(|| simulation.clone().unbind());
        }
    }

    fn set_python_object(&self, body: &Bound<'_, Body>) -> PyResult<()> {
        let reference = PyWeakrefReference::new(body)?.unbind();
        *self.python.lock().unwrap_or_else(PoisonError::into_inner) = Some(reference);
        Ok(())
    }

    fn existing_python_object<'py>(&self, py: Python<'py>) -> Option<Bound<'py, Body>> {
        let python = self.python.lock().unwrap_or_else(PoisonError::into_inner);
        let body = python.as_ref()?.bind(py).upgrade()?;
        body.cast_into().ok()
    }
}
