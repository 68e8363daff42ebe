//! The Python objects of the mesh and the lattice of a body. They are kept, so that their arrays are created once.

use std::sync::{Mutex, PoisonError};

use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;
use pyo3::sync::PyOnceLock;

use crate::lattice::Lattice;
use crate::mesh::Mesh;

/// A body that may be in use by another thread.
pub(super) trait ReadBody {
    /// Calls `read` with the body, without the GIL.
    fn read_body<T: Send>(&self, py: Python<'_>, read: impl FnOnce(&supple::Body) -> T + Send)
    -> PyResult<T>;
}

/// The mesh and the lattice of a body.
#[derive(Default)]
pub(super) struct Shapes {
    mesh: Shape<Mesh>,
    lattice: Shape<Lattice>,
}

impl Shapes {
    /// Returns the mesh of the body as it is now; `None` for a bare lattice.
    pub(super) fn mesh<'py>(
        &self,
        py: Python<'py>,
        body: &impl ReadBody,
    ) -> PyResult<Option<Bound<'py, Mesh>>> {
        let is_same = |known: &Mesh, mesh: &supple::Mesh| {
            known.mesh.vertices() == mesh.vertices() && known.mesh.faces().eq(mesh.faces())
        };
        self.mesh.get(py, body, supple::Body::mesh, is_same, Mesh::from_core)
    }

    /// Returns the lattice of the body as it is now.
    pub(super) fn lattice<'py>(
        &self,
        py: Python<'py>,
        body: &impl ReadBody,
    ) -> PyResult<Bound<'py, Lattice>> {
        let is_same = |known: &Lattice, lattice: &supple::Lattice| known.lattice == *lattice;
        let lattice = self.lattice.get(py, body, |body| Some(body.lattice()), is_same, Lattice::from_core)?;
        Ok(lattice.expect("every body has a lattice"))
    }
}

/// The Python object of a part of a body, while the body is whole and after it broke.
struct Shape<P> {
    whole: PyOnceLock<Option<Py<P>>>,
    /// That of the pieces, when it was last asked for. The body may have broken on since, or a state may have been
    /// restored.
    pieces: Mutex<Option<Py<P>>>,
}

impl<P> Default for Shape<P> {
    fn default() -> Self {
        Self { whole: PyOnceLock::new(), pieces: Mutex::new(None) }
    }
}

impl<P: PyClass<Frozen = True> + Sync> Shape<P>
where
    PyClassInitializer<P>: From<P>,
{
    /// Returns the Python object of `part` of the body; `None` if the body does not have it.
    ///
    /// * `is_same`: whether an object is that of a part.
    /// * `create`: creates the object.
    fn get<'py, T: Clone + Send>(
        &self,
        py: Python<'py>,
        body: &impl ReadBody,
        part: impl Fn(&supple::Body) -> Option<&T> + Sync,
        is_same: impl Fn(&P, &T) -> bool + Sync,
        create: impl Fn(T) -> P,
    ) -> PyResult<Option<Bound<'py, P>>> {
        let pieces = || self.pieces.lock().unwrap_or_else(PoisonError::into_inner);
        let known = pieces().as_ref().map(|known| known.clone_ref(py));
        let has_whole = self.whole.get(py).is_some();
        let (is_whole, new) = body.read_body(py, |body| {
            let is_whole = body.topology_version() == 0;
            let is_known = match (&known, part(body)) {
                _ if is_whole => has_whole,
                (Some(known), Some(part)) => is_same(known.get(), part),
                _ => false,
            };
            (is_whole, if is_known { None } else { part(body).cloned() })
        })?;
        let new = new.map(|part| Py::new(py, create(part))).transpose()?;
        if is_whole {
            let whole = self.whole.get_or_init(py, || new);
            return Ok(whole.as_ref().map(|whole| whole.bind(py).clone()));
        }
        if let Some(new) = &new {
            *pieces() = Some(new.clone_ref(py));
        }
        Ok(new.or(known).map(|object| object.into_bound(py)))
    }
}
