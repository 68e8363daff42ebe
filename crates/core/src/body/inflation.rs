//! Inflation: the ratios by which rest volumes change.

use super::soft_body::Body;
use crate::dynamics::Inflation;
use crate::motion::Curve;
use crate::range::RangeError;
use crate::state::Interval;
use crate::volume::{Correction, CorrectionWorkspace, RestRatios};

impl Body {
    /// Sets the ratio of the rest volume of the body to that of its mesh, from the next step on: a number, or
    /// keyframes over the time of the simulation. The body grows or shrinks to it in all directions, as fast as its
    /// material and damping let it, and the volume correction keeps the volume of the mesh times this ratio. Zones
    /// have [ratios of their own](crate::Zone::inflate) beside it.
    ///
    /// # Errors
    ///
    /// A ratio out of [0.1, 10].
    pub fn set_inflate(&mut self, ratio: impl Into<Curve>) -> Result<(), RangeError> {
        let curve = ratio.into();
        Inflation::validate(&curve)?;
        if self.inflation.is_some() || curve.constant() != Some(1.0) {
            self.inflation.get_or_insert_default().set_curve(curve);
        }
        Ok(())
    }

    /// Returns the ratio of the rest volume of the body to that of its mesh, over time: 1 unless it was set.
    pub fn inflate(&self) -> Curve {
        self.inflation.as_ref().map_or_else(|| 1.0.into(), |inflation| inflation.curve().clone())
    }

    /// Returns the ratio of the rest volume around each lattice vertex to that of the lattice, as of the last step: the
    /// product of the ratios of the body and of the zones. All are 1 before the first step.
    pub fn rest_volume_ratios(&self) -> Vec<f64> {
        (0..self.shape.lattice.len()).map(|vertex| self.rest_volume_ratio(vertex)).collect()
    }

    fn rest_volume_ratio(&self, vertex: usize) -> f64 {
        self.inflation.as_ref().map_or(1.0, |inflation| inflation.ratio(vertex))
    }

    /// Wakes the body if the ratios change in a step.
    pub(super) fn wake_to_inflate(&mut self, interval: Interval) {
        if self.inflation.as_ref().is_some_and(|inflation| inflation.changes_at(interval.end)) {
            self.wake();
        }
    }

    /// Updates the ratios to the end of a step. Removes the stage when all are 1 and stay so.
    pub(super) fn update_inflation(&mut self, interval: Interval) {
        let Some(inflation) = self.inflation.as_mut().filter(|inflation| inflation.changes_at(interval.end))
        else {
            return;
        };
        inflation.update(interval.end);
        if inflation.is_idle() {
            self.inflation = None;
        }
        self.state.energy_limit = None;
        self.update_shapes();
        self.pass_inflation();
    }

    /// Passes the ratios as of the last step to the shape matching.
    pub(super) fn pass_inflation(&mut self) {
        match &mut self.inflation {
            None => self.pipeline.matching.set_inflation(None),
            Some(inflation) => {
                inflation.measure_means(self.shape.lattice.components(), &self.shape.masses);
                inflation.pass(|ratios| self.pipeline.matching.set_inflation(ratios));
            }
        }
    }

    /// Sets the rest volumes of a volume correction to those in force.
    pub(crate) fn set_rest_volumes(&self, correction: &Correction, workspace: &mut CorrectionWorkspace) {
        let components = self.component_ratios();
        let of_vertex = &|vertex| self.rest_volume_ratio(vertex);
        let ratios = components.map(|components| RestRatios { components, of_vertex });
        correction.set_rest(workspace, ratios.as_ref());
    }

    /// Returns the ratios of the rest volume of the components, or `None` if all are 1.
    pub(crate) fn component_ratios(&self) -> Option<&[f64]> {
        self.inflation.as_ref()?.means()
    }
}
