//! Defines the fracture of `supple.Body`.

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{BreakLimit, CutSurface, FractureOptions};

use super::Body;
use crate::argument::{Settings, choice, count_u32, wrong_type};
use crate::{arrays, constraint, error};

/// Keys of the fracture, as in a scene.
const KEYS: [&str; 7] = ["strength", "strain", "rotation", "cracks", "noise", "seed", "surface"];

/// Keys whose value may be `None`: the two limits, of which one is given, and one without a default value.
const OPTIONAL: [&str; 3] = ["strength", "strain", "rotation"];

/// Reads the fracture: a dict, or None for a body that does not break.
pub(super) fn read_fracture(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<FractureOptions>> {
    if value.is_none() {
        return Ok(None);
    }
    let dict = value
        .cast::<PyDict>()
        .map_err(|_| wrong_type(value, name, "a dict like {\"strain\": 0.1}, or None"))?;
    let settings = Settings::from_dict(dict, name, &KEYS)?.with_optional(&OPTIONAL);
    let limit = match (settings.number("strength")?, settings.number("strain")?) {
        (Some(stress), None) => BreakLimit::Strength(stress),
        (None, Some(strain)) => BreakLimit::Strain(strain),
        (Some(_), Some(_)) => {
            let message =
                format!("{name}: strength and strain are mutually exclusive; pass only one of them");
            return Err(PyValueError::new_err(message));
        }
        (None, None) => {
            let message = format!("{name} has no limit; pass strength (a stress) or strain");
            return Err(PyValueError::new_err(message));
        }
    };
    let mut fracture = FractureOptions::new(limit);
    fracture.rotation = settings.number("rotation")?;
    fracture.cracks = settings.count_u32("cracks", 1)?.map_or(fracture.cracks, |cracks| cracks as usize);
    fracture.noise = settings.number("noise")?.unwrap_or(fracture.noise);
    fracture.seed =
        settings.read("seed", |seed, name| count_u32(seed, name, 0))?.map_or(fracture.seed, u64::from);
    let surface =
        settings.read("surface", |surface, _| choice(surface, "fracture surface", &CutSurface::NAMED))?;
    fracture.surface = surface.unwrap_or(fracture.surface);
    Ok(Some(fracture))
}

/// Converts the fracture to the equivalent dict.
pub(crate) fn fracture_settings<'py>(
    py: Python<'py>,
    fracture: Option<&FractureOptions>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(fracture) = fracture else { return Ok(None) };
    let FractureOptions { limit, rotation, cracks, noise, seed, surface } = *fracture;
    let settings = PyDict::new(py);
    match limit {
        BreakLimit::Strength(stress) => settings.set_item("strength", stress)?,
        BreakLimit::Strain(strain) => settings.set_item("strain", strain)?,
    }
    settings.set_item("rotation", rotation)?;
    settings.set_item("cracks", cracks)?;
    settings.set_item("noise", noise)?;
    settings.set_item("seed", seed)?;
    settings.set_item("surface", surface.name())?;
    Ok(Some(settings))
}

/// Returns the error that a bare lattice has no faces.
fn no_mesh() -> PyErr {
    PyValueError::new_err("the body is a bare lattice without a mesh; it has no faces")
}

#[pymethods]
impl Body {
    /// Fracture: a dict with strength or strain, rotation, cracks, noise, seed and surface; None if the body breaks
    /// only where it is cut.
    #[getter]
    fn fracture<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        fracture_settings(py, self.read(py, |body| body.fracture().copied())?.as_ref())
    }

    /// Cut the body along a plane: break all joints between cells on different sides of it. Returns their number.
    ///
    /// plane : Plane, pair (point, normal), or dict with point and normal
    ///     In world space. It is carried to the rest shape by the affine motion that fits the body best, so that it is
    ///     met exactly where the body is not bent. The keyframes of a Plane have no effect.
    ///
    /// Vertices on the cut get copies, so that arrays with one row per lattice vertex or mesh vertex grow: see
    /// topology_version. Raises ValueError for a normal of zero.
    fn cut(&self, plane: &Bound<'_, PyAny>) -> PyResult<usize> {
        let [point, normal] = constraint::plane(plane)?;
        self.with(plane.py(), |body| body.cut(point, normal))?.map_err(error::value)
    }

    /// Number of pieces: connected components of the lattice.
    #[getter]
    fn pieces(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, supple::Body::pieces)
    }

    /// Number of broken joints. A joint is the common face of two cells.
    #[getter]
    fn broken_joints(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, supple::Body::broken_joints)
    }

    /// Number of steps and cuts in which joints broke.
    ///
    /// While it stays the same, so do faces, lattice, and the lengths of arrays. When it grows, the vertices of the whole
    /// body keep their numbers, in the lattice and in the mesh, and copies follow them. The numbers of copies can
    /// change each time. Restoring a state restores it too.
    #[getter]
    fn topology_version(&self, py: Python<'_>) -> PyResult<u64> {
        self.read(py, supple::Body::topology_version)
    }

    /// Triangles of the displayed surface as it is now: (m, 3) int64, read-only. Larger faces are fanned from their
    /// first vertex. The surfaces of cracks come last.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let mesh = self.mesh(py)?.ok_or_else(no_mesh)?;
        Ok(mesh.get().faces(py).clone())
    }

    /// Piece of each vertex of the displayed surface, from 0: (k,) int64, read-only. Pieces are numbered by their
    /// first lattice vertices.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[getter]
    fn piece_of_vertex<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let pieces = self.read(py, supple::Body::piece_of_mesh_vertices)?.ok_or_else(no_mesh)?;
        Ok(arrays::frozen(PyArray1::from_iter(py, pieces.into_iter().map(i64::from))))
    }
}
