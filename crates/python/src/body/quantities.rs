//! Defines mass, momenta, energies and sleep of `supple.Body`.

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::Body;
use crate::arrays;

/// Returns a value that a body has only in a simulation.
///
/// # Errors
///
/// `ValueError` if there is none.
pub(super) fn need_simulation<T>(value: Option<T>, name: &str) -> PyResult<T> {
    value.ok_or_else(|| {
        PyValueError::new_err(format!(
            "{name} depends on the step length and the gravity of a simulation; build a Simulation with the body"
        ))
    })
}

/// A rotation (3, 3) and a translation (3,).
type Pose<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

properties! {
    /// Mass: the sum of masses.
    mass: f64 = supple::Body::mass;
    /// Kinetic energy in mass x length^2/s^2.
    ///
    /// Velocities are those of the middle of the last step, and positions those of its end. So the sum of the
    /// energies of an undamped body oscillates by the fraction dt x omega / 2, with the greatest angular frequency
    /// omega of its motion.
    kinetic_energy: f64 = supple::Body::kinetic_energy;
    /// Whether the body is rigid: the argument rigid.
    is_rigid: bool = supple::Body::is_rigid;
    /// Whether the body sleeps: it came to rest and is not stepped until something moves it, or wake() is called.
    ///
    /// A body falls asleep if every vertex was nearly still for half a second while the body was held or rested on a
    /// collider. See the argument sleep of Simulation.
    is_asleep: bool = supple::Body::is_asleep;
}

#[pymethods]
impl Body {
    /// Center of mass: (3,) float64, read-only.
    #[getter]
    fn center_of_mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |body| body.center_of_mass().coords.into())
    }

    /// Rigid motion that fits the body best: a tuple of rotation (3, 3) and translation (3,), float64, read-only.
    ///
    /// It moves the mesh as it was given, after scale, close to its present place: mesh.vertices @ rotation.T +
    /// translation. At frame 0 it is the rotation and the translation of the body's placement.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Pose<'py>> {
        let pose = self.read(py, supple::Body::pose)?;
        let matrix = pose.rotation.to_rotation_matrix();
        let rows = (0..3).map(|row| [0, 1, 2].map(|column| matrix[(row, column)])).collect();
        let translation = PyArray1::from_slice(py, pose.translation.vector.as_slice());
        Ok((arrays::frozen(arrays::from_vectors(py, rows)), arrays::frozen(translation)))
    }

    /// Linear momentum in mass x length/s: (3,) float64, read-only.
    #[getter]
    fn linear_momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |body| body.linear_momentum().into())
    }

    /// Angular momentum about the center of mass in mass x length^2/s: (3,) float64, read-only.
    #[getter]
    fn angular_momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |body| body.angular_momentum().into())
    }

    /// Elastic energy in mass x length^2/s^2: the work that the elastic forces give back when the body returns to
    /// its shape. Raises ValueError outside a simulation.
    #[getter]
    fn elastic_energy(&self, py: Python<'_>) -> PyResult<f64> {
        need_simulation(self.in_context(py, |body| body.elastic_energy())?, "elastic_energy")
    }

    /// Energy in the gravity field, -mass gravity . center_of_mass, in mass x length^2/s^2: zero at the world
    /// origin. Raises ValueError outside a simulation.
    #[getter]
    fn gravity_energy(&self, py: Python<'_>) -> PyResult<f64> {
        need_simulation(self.in_context(py, |body| body.gravity_energy())?, "gravity_energy")
    }

    /// Wake the body up. It falls asleep again after half a second of rest.
    fn wake(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, supple::Body::wake)
    }
}

impl Body {
    /// Computes a vector as a numpy array.
    fn vector<'py>(
        &self,
        py: Python<'py>,
        read: impl FnOnce(&supple::Body) -> [f64; 3] + Send,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(arrays::frozen(PyArray1::from_slice(py, &self.read(py, read)?)))
    }
}
