//! Defines the material of `supple.Body` as properties that can be set between steps.

use numpy::PyArray1;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple::{Damping, Elasticity, KeyedMaterial, Material, RegionDamping, RegionSize, Stiffness};

use super::Body;
use super::build::{self, scene_key};
use super::quantities::need_simulation;
use crate::argument::number;
use crate::constraint::curve_to_python;
use crate::error;

impl Body {
    /// Sets a number of the material: its keyframes if it has any, and otherwise by `set`.
    fn set_number(
        &self,
        py: Python<'_>,
        keyed: KeyedMaterial,
        set: impl FnOnce(&mut supple::Body) -> Result<(), supple::RangeError> + Send,
    ) -> PyResult<()> {
        let set_keyed = |body: &mut supple::Body| {
            let before = body.keyed().cloned().unwrap_or_default();
            body.set_keyed(before.replaced_by(keyed.clone()))
        };
        let set = |body: &mut supple::Body| match keyed.is_empty() {
            true => Ok(set(body)?),
            false => set_keyed(body),
        };
        self.with(py, set)?.map_err(error::from_core)
    }
}

#[pymethods]
impl Body {
    /// Name of the material: "jelly", "flesh", "rubber" or "firm". None if youngs_modulus or the regions are set.
    ///
    /// Settable; replaces youngs_modulus and the settings of the regions.
    #[getter]
    fn material(&self, py: Python<'_>) -> PyResult<Option<&'static str>> {
        self.read(py, |body| match body.material().elasticity {
            Elasticity::Preset(preset) => Some(preset.name()),
            _ => None,
        })
    }

    #[setter]
    fn set_material(&self, py: Python<'_>, name: &Bound<'_, PyAny>) -> PyResult<()> {
        let elasticity = scene_key("material", name)?.material.elasticity;
        self.with(py, |body| body.set_elasticity(elasticity))?.map_err(error::value)
    }

    /// Young's modulus, force per area in scene units (Pa if these are m, kg and s).
    ///
    /// In a simulation: the modulus in force. It is that of the material, or less if steps of this length cannot
    /// reach it; supple.MaterialWarning then tells both. Outside a simulation: the value that was set; raises
    /// ValueError if none was set, because it then depends on the gravity or the step length of a simulation.
    /// Settable, > 0, a number or keyframes (time, value); replaces material and the settings of the regions.
    #[getter]
    fn youngs_modulus(&self, py: Python<'_>) -> PyResult<f64> {
        self.in_context(py, |body| body.youngs_modulus())?.ok_or_else(|| {
            PyValueError::new_err(
                "youngs_modulus was not set, so it depends on the gravity and the step length of a simulation; \
                 set body.youngs_modulus, or build a Simulation with the body",
            )
        })
    }

    #[setter]
    fn set_youngs_modulus(&self, py: Python<'_>, modulus: &Bound<'_, PyAny>) -> PyResult<()> {
        let data = scene_key("youngs_modulus", modulus)?;
        self.set_number(py, data.keyed, |body| body.set_elasticity(data.material.elasticity))
    }

    /// Poisson's ratio, in [0, 0.47]: stretched by the share s, the body becomes narrower by this times s. Settable, a number or
    /// keyframes (time, value); None sets the one of the material.
    #[getter]
    fn poisson_ratio(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |body| body.material().poisson_ratio())
    }

    #[setter]
    fn set_poisson_ratio(&self, py: Python<'_>, ratio: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let data = ratio.map(|ratio| scene_key("poisson_ratio", ratio)).transpose()?.unwrap_or_default();
        self.set_number(py, data.keyed, |body| body.set_poisson_ratio(data.material.poisson_ratio))
    }

    /// Ratio of the rest volume to that of the mesh, in [0.1, 10]: a float, or what keyframes were set. Settable: a number, a list
    /// of (time, value), or a dict with the keys keys and interpolation ("linear", "smooth" or "cubic").
    ///
    /// From the next step on the body grows or shrinks to it, and the volume correction keeps the volume of the mesh times
    /// this ratio. Zones have ratios of their own beside it.
    #[getter]
    fn inflate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        curve_to_python(py, &self.read(py, supple::Body::inflate)?)
    }

    #[setter]
    fn set_inflate(&self, py: Python<'_>, ratio: &Bound<'_, PyAny>) -> PyResult<()> {
        let ratio = scene_key("inflate", ratio)?.inflate;
        self.with(py, |body| body.set_inflate(ratio))?.map_err(error::value)
    }

    /// Ratios of the rest volume around each lattice vertex to that of the lattice, as of the last step: (n,) float64.
    #[getter]
    fn rest_volume_ratios<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.read(py, supple::Body::rest_volume_ratios)?))
    }

    /// How the half-width of the regions is chosen for a material or youngs_modulus: "fast", "balanced" or "exact". Settable; the
    /// steps stay as long as they are.
    #[getter]
    fn accuracy(&self, py: Python<'_>) -> PyResult<&'static str> {
        self.read(py, |body| body.material().accuracy.name())
    }

    #[setter]
    fn set_accuracy(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let accuracy = scene_key("accuracy", value)?.material.accuracy;
        self.with(py, |body| body.set_accuracy(accuracy))
    }

    /// Half-width of the regions in cells: 0.5, so that each region is a cell, or a whole number of at least 1, at most the
    /// extent of the lattice.
    ///
    /// It is the value that was set. With a material or youngs_modulus, it is the one of the accuracy, or, if steps of the
    /// length that the simulation had when the body joined it are too long for that one, the least whole one that reaches
    /// Young's modulus; 2 outside a simulation. Settable; replaces stiffness_radius, material and youngs_modulus, and rebuilds the regions.
    #[getter]
    fn half_width<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let half_width = self.read(py, supple::Body::half_width)?;
        match half_width.whole_cells() {
            Some(cells) => cells.into_bound_py_any(py),
            None => half_width.cells().into_bound_py_any(py),
        }
    }

    #[setter]
    fn set_half_width(&self, py: Python<'_>, half_width: &Bound<'_, PyAny>) -> PyResult<()> {
        let cells = build::half_width(half_width)?;
        self.with(py, |body| body.set_region_size(RegionSize::Cells(cells)))?.map_err(error::value)
    }

    /// Frequency of the lowest elastic mode of the body without pins, handles and colliders, in Hz, to 2 %.
    ///
    /// The first call computes the mode. Raises ValueError outside a simulation.
    #[getter]
    fn lowest_frequency(&self, py: Python<'_>) -> PyResult<f64> {
        need_simulation(self.shared.in_context_long(py, |body| body.lowest_frequency())?, "lowest_frequency")
    }

    /// Mass per volume, > 0. Settable: the masses change in proportion; Young's modulus stays the same.
    #[getter]
    fn density(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |body| body.material().density)
    }

    #[setter]
    fn set_density(&self, py: Python<'_>, density: &Bound<'_, PyAny>) -> PyResult<()> {
        let density = number(density, "density")?;
        self.with(py, |body| body.set_density(density))?.map_err(error::value)
    }
}

/// Defines properties for settings of the material that have two alternative keys. A property is None if its
/// alternative is set. Setting a property replaces its alternative.
macro_rules! alternatives {
    ($($(#[$doc:meta])* $key:ident, $set:ident: $material:pat => $found:ident, $value:expr, by $change:ident;)*) => {
        #[pymethods]
        impl Body {$(
            $(#[$doc])*
            #[getter]
            fn $key(&self, py: Python<'_>) -> PyResult<Option<f64>> {
                self.read(py, |body| {
                    let Material { elasticity, region_damping, .. } = *body.material();
                    match (elasticity, body.material().damping(), region_damping) {
                        $material => Some($found),
                        _ => None,
                    }
                })
            }

            #[setter]
            fn $set(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
                let value = number(value, stringify!($key))?;
                self.with(py, |body| body.$change(($value)(value)))?.map_err(error::value)
            }
        )*}
    };
}

alternatives! {
    /// Half-width of the regions as a length, > 0; None unless it is set. Settable; replaces half_width, material
    /// and youngs_modulus.
    stiffness_radius, set_stiffness_radius:
        (Elasticity::Regions { size: RegionSize::Radius(radius), .. }, ..) => radius,
        RegionSize::Radius, by set_region_size;
    /// Stiffness alpha per step, in (0, 1]; None if a frequency, a material or youngs_modulus is set. Settable;
    /// replaces these.
    stiffness, set_stiffness:
        (Elasticity::Regions { stiffness: Stiffness::PerStep(alpha), .. }, ..) => alpha,
        Stiffness::PerStep, by set_stiffness;
    /// Frequency of a vertex about its goal in Hz, > 0; None unless it is set. Settable; replaces stiffness,
    /// material and youngs_modulus.
    frequency, set_frequency:
        (Elasticity::Regions { stiffness: Stiffness::Frequency(hertz), .. }, ..) => hertz,
        Stiffness::Frequency, by set_stiffness;
    /// Damping ratio of the lowest elastic mode, in [0, 1]; None if damping_rate is set. Settable; replaces
    /// damping_rate. Unless it is set, it is that of the material, and 0.2 without one.
    damping_ratio, set_damping_ratio:
        (_, Damping::Ratio(ratio), _) => ratio,
        |ratio| Some(Damping::Ratio(ratio)), by set_damping;
    /// Rate at which the elastic modes decay in 1/s, >= 0; None if damping_ratio is set. Settable; replaces
    /// damping_ratio.
    damping_rate, set_damping_rate:
        (_, Damping::Rate(rate), _) => rate,
        |rate| Some(Damping::Rate(rate)), by set_damping;
    /// Region damping per step, in [0, 1]; None if a rate is set. Settable; replaces region_damping_rate.
    region_damping, set_region_damping:
        (.., RegionDamping::PerStep(fraction)) => fraction,
        RegionDamping::PerStep, by set_region_damping;
    /// Region damping as a rate in 1/s, >= 0; None if it is set per step. Settable; replaces region_damping.
    region_damping_rate, set_region_damping_rate:
        (.., RegionDamping::Rate(rate)) => rate,
        RegionDamping::Rate, by set_region_damping;
}
