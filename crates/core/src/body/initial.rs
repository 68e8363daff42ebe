//! The state that a body was built with, for [`Simulation::reset`](crate::Simulation::reset).

use super::elasticity::initial_half_width;
use super::parts::Shape;
use super::snapshot::BodySnapshot;
use super::soft_body::Body;
use crate::lattice::Layout;
use crate::motion::Curve;
use crate::simd::lanes::Lanes;
use crate::state::State;

impl Body {
    /// Returns the state at frame 0 with the present settings, pins and handles: the body is whole and in its placement,
    /// and pins and handles have captured nothing.
    pub(crate) fn initial_snapshot(&self) -> BodySnapshot {
        let (lattice, masses) = self.whole();
        let (layout, placement) = (Layout::new(&lattice), &self.shape.placement);
        let mut state = State::at_rest(&lattice, &layout, placement);
        state.set_initial_velocities(masses, &layout, placement);
        state.strains = self.settings.material.plastic.map(|_| Lanes::zeros(layout.blocks()));
        state.escapes.search();
        // The first vertices of a broken lattice are those of the whole one.
        let whole: Vec<u32> = (0..lattice.len() as u32).collect();
        let constraints = self.constraints.as_ref().map(|constraints| constraints.at_start(&whole));
        let inflation = self.inflation.as_ref().map(|inflation| inflation.at_start(&whole));
        BodySnapshot {
            constraints,
            inflation,
            material: self.material_at_start(),
            stiffness_factors: self.stiffness_factors().map(|factors| factors[..whole.len()].to_vec()),
            keyed: self.keyed.as_deref().cloned(),
            friction: self.keyed.as_ref().and_then(|keyed| keyed.friction.as_ref()).map(Curve::greatest),
            ..self.snapshot_of(state)
        }
    }

    /// Resets what a state does not contain, after [`initial_snapshot`](Self::initial_snapshot) was restored and the
    /// elasticity was fixed. `gravity` and `dt` are those with which a new body joins the simulation.
    pub(crate) fn finish_reset(&mut self, gravity: f64, dt: f64) {
        self.pipeline.fast_vertex = 0;
        self.pipeline.unconverged = 0;
        self.forget_elastic_measures();
        self.wake();
        // The regions of a new body change in this order, and are fitted again after a change.
        let Shape { lattice, extent, .. } = &self.shape;
        let built = initial_half_width(&self.settings.material, lattice, *extent);
        let joined = self.half_width_to_fix(gravity, dt).unwrap_or(built);
        self.state.fitted = built == joined && joined == self.half_width();
    }
}
