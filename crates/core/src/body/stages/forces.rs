//! External forces.

use super::stage::{BodyStep, Stage, check_owner};
use crate::body::context::StepContext;
use crate::body::parts::{Pipeline, Shape};
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::body::transfer::Parents;
use crate::dynamics::Forces;
use crate::error::StateError;

/// Applies the external forces of the step.
pub(super) struct ApplyForces;

impl Stage for ApplyForces {
    fn name(&self) -> &'static str {
        "external forces"
    }

    fn exists(&self, body: &Body) -> bool {
        body.forces.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        if body.is_rigid() {
            body.apply_forces_rigidly(step.context);
        } else {
            body.apply_external_forces(step.context);
        }
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let bytes = body.forces.as_ref().map_or(0, Forces::bytes);
        ("next step's forces, this frame's displacements".to_owned(), bytes)
    }

    fn follow(&self, body: &mut Body, parents: &Parents) {
        if let Some(forces) = &mut body.forces {
            forces.transfer(&parents.pairs(), &body.shape.masses);
        }
    }

    fn save(&self, body: &Body, snapshot: &mut BodySnapshot) {
        snapshot.forces = body.forces.clone();
    }

    fn check(&self, body: &Body, snapshot: &BodySnapshot, vertices: usize) -> Result<(), StateError> {
        let fits = snapshot.forces.as_ref().is_none_or(|forces| forces.is_valid(vertices));
        check_owner(body, "forces", fits)
    }

    fn restore(&self, body: &mut Body, snapshot: &BodySnapshot) {
        body.forces = snapshot.forces.clone();
        // The fields of the simulation may be others: the next step evaluates them.
        if let Some(forces) = &mut body.forces {
            forces.forget_fields();
        }
    }
}

impl Body {
    /// Applies external forces: v += h f/m and x += h² f/m. Removes the stage when it has no more data.
    pub(super) fn apply_external_forces(&mut self, context: &StepContext) {
        let cell_mass = self.cell_mass();
        let Self {
            shape: Shape { lattice, masses, .. },
            pipeline: Pipeline { matching, .. },
            forces: Some(forces),
            state,
            ..
        } = self
        else {
            return;
        };
        let mass = |vertex: u32| cell_mass * f64::from(masses[vertex as usize]);
        let timing = (context.interval, context.is_frame_start);
        forces.apply(timing, (lattice, matching.layout.slots()), mass, state);
        if forces.is_empty() {
            self.forces = None;
        }
    }
}
