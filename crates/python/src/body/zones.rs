//! Defines the stiffness factors of `supple.Body`, with which the stiffness varies.

use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{Selection, SelectionPose, Zone};

use super::Body;
use super::build::scene_key;
use crate::argument::{Settings, number};
use crate::arrays::{self, Axis};
use crate::{constraint, error};

#[pymethods]
impl Body {
    /// Multiply the Young's modulus of a part of the body by a factor, its rest volume by a ratio, or another quantity by a
    /// factor, from the next step on.
    ///
    /// Around a shape the logarithms of all decrease linearly to 0 over the length of a cell. With a map, a factor f counts as
    /// f^w at the weight w. The factors of overlapping zones multiply.
    ///
    /// factor : float, default 1
    ///     In (0, 100], and so are the products of overlapping zones.
    /// inflate : float, or keyframes
    ///     As of Body; the products of overlapping zones are limited to [0.1, 10].
    /// density_factor, strength_factor, damping_factor, friction_factor, yield_factor : float, default 1
    ///     In (0, 100], and so are the products: of the density, of the limit at which the body breaks (fracture), of the rate
    ///     of damping_ratio or damping_rate, of the coefficient of friction at colliders and bodies, and of the yield strain
    ///     (plastic).
    /// box, sphere, plane, vertices, mesh_vertices, group, map, at :
    ///     As for pin, but a shape selects the lattice vertices inside it, whether or not it contains mesh vertices.
    ///
    /// Raises ValueError if the shape contains no lattice vertex, for a strength_factor of a body without fracture, and for a
    /// yield_factor of a body that is not plastic.
    #[pyo3(
        signature = (factor=None, **options),
        text_signature = "($self, factor=1.0, *, inflate=None, density_factor=1.0, strength_factor=1.0, damping_factor=1.0, friction_factor=1.0, yield_factor=1.0, box=None, sphere=None, plane=None, vertices=None, mesh_vertices=None, group=None, map=None, at='now')"
    )]
    fn zone(
        &self,
        py: Python<'_>,
        factor: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let mut zone = Zone::new(Selection::Vertices(Vec::new()), 1.0);
        let names = zone.part_factors().map(|(key, _)| key);
        let keys = [&constraint::SELECTION[..], &["inflate"], &names].concat();
        let settings = Settings::from_call(options, "zone()", &keys, &constraint::SHAPES)?;
        let pose = constraint::pose(&settings, "zone()")?.unwrap_or(SelectionPose::Now);
        zone.selection = constraint::selection(&settings, "zone()", self.counts(py)?)?;
        zone.inflate = settings.read("inflate", |ratio, key| scene_key(key, ratio))?.map(|data| data.inflate);
        let mut is_given = factor.is_some() || zone.inflate.is_some();
        for (key, part) in zone.part_factors_mut() {
            if let Some(number) = settings.number(key)? {
                (*part, is_given) = (number, true);
            }
        }
        if !is_given {
            let names = names.join(", ");
            let message = format!(
                "zone() needs factor, of Young's modulus, inflate, the ratio of the rest volume, or one of {names}"
            );
            return Err(PyTypeError::new_err(message));
        }
        zone.factor = factor.map_or(Ok(1.0), |factor| number(factor, "factor"))?;
        self.with(py, |body| body.zone_at(&zone, pose))?.map_err(error::from_core)
    }

    /// Weights of the lattice vertices for a map of the mesh: (n,) float64.
    ///
    /// A vertex of a cell that the surface meets has the mean of the map over the surface around it, with the area and the
    /// trilinear weight of the vertex in its cell; in a face the map is linear. Any other vertex has the mean of its
    /// neighbors, so that a map that is linear in space stays linear inside. The weights depend on neither the size nor the
    /// order of the faces. The vertices of the map are those of the mesh of the body before it broke.
    ///
    /// map : (m,) float in [0, 1], (m,) bool, or str
    ///     A weight for each mesh vertex, or the name of a map of the mesh (Mesh.maps).
    ///
    /// Raises ValueError for a name that the mesh does not have, a weight out of range, and a bare lattice.
    fn weights<'py>(&self, py: Python<'py>, map: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let selection = Selection::Map(constraint::map(map, "map")?);
        let weights = self.read(py, |body| body.weights(&selection))?.map_err(error::from_core)?;
        Ok(PyArray1::from_vec(py, weights.unwrap_or_default()))
    }

    /// Set the stiffness factors, from the next step on: the Young's modulus around each lattice vertex is that of
    /// the body times the factor of the vertex.
    ///
    /// Parts that are smaller than the regions, 2 x half_width + 1 vertices wide, are mixed with their surroundings. In
    /// a simulation, half_width is fixed again at the next step, for the greatest factor.
    ///
    /// factors : (n,) float, or None
    ///     In (0, 100]; factors below 1e-6 act as 1e-6. None removes all factors, also those of zones.
    fn set_stiffness_factors(&self, py: Python<'_>, factors: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let rows = Axis::Is(self.count(py)?);
        let factors = factors.map(|factors| arrays::numbers(factors, "factors", rows)).transpose()?;
        self.with(py, |body| body.set_stiffness_factors(factors.as_deref()))?.map_err(error::from_core)
    }

    /// Stiffness factors of the lattice vertices: (n,) float64, read-only; None if the stiffness does not vary.
    #[getter]
    fn stiffness_factors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let factors = self.read(py, |body| body.stiffness_factors().map(<[f64]>::to_vec))?;
        Ok(factors.map(|factors| arrays::frozen(PyArray1::from_vec(py, factors))))
    }
}
