//! Defines how a `supple.Body` touches other bodies and itself as read-only properties.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::Body;

properties! {
    /// Coulomb friction coefficient at other bodies, >= 0.
    friction: f64 = |body| body.touching().friction;
    /// Coefficient of restitution at other bodies, in [0, 1].
    restitution: f64 = |body| body.touching().restitution;
    /// Coefficient of rolling resistance on colliders, >= 0: the greatest distance of the center of pressure of a contact from its
    /// middle, as a fraction of the radius of the contact. Unless it is set, 0.08 times the damping ratio, or 0.016 with a
    /// damping_rate above 0.
    rolling_resistance: f64 = supple::Body::rolling_resistance;
    /// Distance outside of the surface at which the body touches, in scene units, >= 0.
    thickness: f64 = |body| body.touching().thickness;
    /// Whether parts of the body touch each other: bool, or None if the simulation decides.
    self_contact: Option<bool> = |body| body.touching().self_contact;
}

#[pymethods]
impl Body {
    /// Names of bodies that the body does not touch: tuple of str.
    #[getter]
    fn ignore<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.read(py, |body| body.touching().ignored.clone())?)
    }
}
