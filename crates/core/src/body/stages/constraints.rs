//! Pins and handles: the begin of those that become active, and their targets at the end of a step.

use super::stage::{BodyStep, Stage, check_owner};
use crate::body::context::StepContext;
use crate::body::parts::{Pipeline, Shape};
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::body::transfer::Parents;
use crate::dynamics::{Constraints, RegionDamper};
use crate::error::StateError;

/// Activates and deactivates pins and handles according to their time windows. Those that become active capture the positions
/// of their vertices.
pub(super) struct BeginConstraints;

impl Stage for BeginConstraints {
    fn name(&self) -> &'static str {
        "begin pins, handles"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        body.constraints.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let Body { pipeline: Pipeline { matching, .. }, constraints: Some(constraints), state, .. } = body
        else {
            return;
        };
        let vertices = (&state.body_state(), matching.layout.slots());
        if constraints.begin(step.context.interval, vertices, step.executor) {
            body.track_constraints();
        }
    }

    fn describe(&self, _body: &Body) -> (String, usize) {
        ("captured positions, targets".to_owned(), 0)
    }
}

/// Pulls the vertices of soft pins and handles to their targets.
pub(super) struct PullToGoals;

impl Stage for PullToGoals {
    fn name(&self) -> &'static str {
        "soft goals"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        body.constraints.as_ref().is_some_and(Constraints::any_soft)
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let dt = step.context.interval.dt;
        if body.is_rigid() {
            body.pull_rigidly(dt);
            return;
        }
        let Body { pipeline, constraints: Some(constraints), shape, state, .. } = body else { return };
        let slots = pipeline.matching.layout.slots();
        constraints.pull(dt, state, (&shape.lattice, slots));
    }

    fn describe(&self, _body: &Body) -> (String, usize) {
        ("springs to the targets of pins and handles".to_owned(), 0)
    }
}

/// Moves constrained vertices to the targets of their pins and handles.
pub(super) struct ApplyConstraints;

impl Stage for ApplyConstraints {
    fn name(&self) -> &'static str {
        "pins and handles"
    }

    fn exists(&self, body: &Body) -> bool {
        body.constraints.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        if body.is_rigid() {
            body.hold_rigidly();
        } else {
            body.apply_constraints(step.context);
        }
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        body.constraints.as_ref().map_or_else(Default::default, |constraints| {
            let list = constraints.list();
            let count: usize = list.iter().map(|constraint| constraint.vertices().len()).sum();
            (format!("{} on {count} lattice vertices", list.len()), constraints.bytes())
        })
    }

    fn rebuild(&self, body: &mut Body) {
        body.track_constraints();
    }

    fn follow(&self, body: &mut Body, parents: &Parents) {
        if let Some(constraints) = &mut body.constraints {
            constraints.transfer(&parents.first);
        }
    }

    fn save(&self, body: &Body, snapshot: &mut BodySnapshot) {
        snapshot.constraints = body.constraints.clone();
    }

    fn check(&self, body: &Body, snapshot: &BodySnapshot, vertices: usize) -> Result<(), StateError> {
        let Some(constraints) = &snapshot.constraints else { return Ok(()) };
        check_owner(body, "pins and handles", constraints.is_valid(vertices))?;
        match constraints.unresolved(body.constraints.as_ref()) {
            Some(index) => Err(StateError::Animation { body: body.name.clone(), index }),
            None => Ok(()),
        }
    }

    fn restore(&self, body: &mut Body, snapshot: &BodySnapshot) {
        let mut constraints = snapshot.constraints.clone();
        if let (Some(constraints), Some(before)) = (&mut constraints, &body.constraints) {
            constraints.resolve(before);
        }
        body.replace_constraints(constraints);
    }
}

impl Body {
    /// Replaces all pins and handles.
    pub(in crate::body) fn replace_constraints(&mut self, constraints: Option<Constraints>) {
        let before = std::mem::replace(&mut self.constraints, constraints);
        let constrained = Constraints::constrained_by(self.constraints.as_ref());
        if constrained != Constraints::constrained_by(before.as_ref()) {
            self.track_constraints();
        }
    }

    /// Updates which components have constrained vertices. The momenta of such components are not conserved.
    pub(in crate::body) fn track_constraints(&mut self) {
        let Self { pipeline: Pipeline { matching, momentum, .. }, constraints, state, .. } = self;
        let constrained = Constraints::constrained_by(constraints.as_ref());
        momentum.set_constrained(matching.layout.slots(), constrained, &mut state.momenta);
        self.update_fit_masses();
    }

    /// Gives the constrained vertices more mass in the fits of the regions: see `Regions::constraint_factors`.
    ///
    /// The rigid motion of a region that a constraint holds at one side would otherwise be the motion of its larger
    /// free side, although nothing moves the held side. A bar of the length L that hangs from one layer of vertices
    /// would slip out of the constraint by about 2 g L h²/(alpha s²) cells, with the step length h and the cell size
    /// s. Only the fits use these masses, so that momenta and forces use the masses of the vertices.
    fn update_fit_masses(&mut self) {
        let Self {
            shape: Shape { masses, .. },
            pipeline: Pipeline { matching, momentum, region_damping, .. },
            constraints,
            ..
        } = self;
        let constrained = Constraints::constrained_by(constraints.as_ref());
        let factors = matching.regions.constraint_factors(&matching.layout, constrained);
        let fit_masses: Vec<f32> = masses.iter().zip(factors).map(|(mass, factor)| mass * factor).collect();
        let slots = matching.layout.slots().iter();
        if slots.zip(&fit_masses).all(|(&slot, &mass)| matching.regions.weights.get(slot)[0] == mass) {
            return;
        }
        matching.set_masses(&fit_masses);
        momentum.set_masses(matching.layout.slots(), fit_masses.iter().copied());
        if let Some(damper) = region_damping {
            *damper = RegionDamper::new(matching);
        }
    }

    /// Moves constrained vertices to the targets of their pins and handles.
    pub(in crate::body) fn apply_constraints(&mut self, context: &StepContext) {
        if let Some(constraints) = &self.constraints {
            let slots = self.pipeline.matching.layout.slots();
            constraints.apply(context.interval, &mut self.state.body_state(), slots);
        }
    }
}
