//! The step of a body: runs its [stages](super::stages).

use super::context::StepContext;
use super::soft_body::Body;
use super::stages::{ADVANCE, BodyStep, END, FINISH, Stage, stages};
use super::transfer::Parents;
use crate::contact::bodies::BodyContactPart;
use crate::parallel::Executor;

impl Body {
    /// Runs a step of a body that no other one can touch.
    pub(crate) fn step_alone(&mut self, context: &StepContext, executor: &Executor) {
        self.advance_step(context, executor);
        self.finish_step(context, &BodyContactPart::Alone, executor);
        self.end_step(context, executor);
    }

    /// Begins a step: runs the existing stages of the body up to the contacts, unless it sleeps.
    pub(crate) fn advance_step(&mut self, context: &StepContext, executor: &Executor) {
        self.update_contact_stage(context.colliders);
        self.complete_elasticity(context.greatest_gravity, context.interval.dt);
        self.wake_to_inflate(context.interval);
        self.wake_to_change(context.interval);
        if !self.is_asleep() {
            self.rebase_rigidly();
            self.run_all(ADVANCE, context, &BodyContactPart::Alone, executor);
            self.measure_contact_bounds();
        } else if let Some(forces) = &mut self.forces {
            forces.discard();
        }
    }

    /// Continues a step: runs the existing stages of the contacts, unless the body sleeps and touches nothing.
    pub(crate) fn finish_step(&mut self, context: &StepContext, part: &BodyContactPart, executor: &Executor) {
        let is_in_island = matches!(part, BodyContactPart::InIsland { .. });
        if self.is_asleep() && !is_in_island {
            if let Some(contacts) = &mut self.contact.contacts {
                contacts.restore_pressures();
            }
            return;
        }
        self.run_all(FINISH, context, part, executor);
        if !is_in_island {
            self.keep_contact_forces(context.interval.dt);
        }
    }

    /// Ends a step after the contacts of all bodies, unless the body sleeps.
    pub(crate) fn end_step(&mut self, context: &StepContext, executor: &Executor) {
        if !self.is_asleep() {
            self.run_all(END, context, &BodyContactPart::Alone, executor);
            self.track_rest(context, executor);
        }
    }

    /// Runs the stages that the body has.
    fn run_all(
        &mut self,
        stages: &[&dyn Stage],
        context: &StepContext,
        part: &BodyContactPart,
        executor: &Executor,
    ) {
        for stage in stages {
            if stage.exists(self) {
                stage.run(self, &BodyStep { context, part, executor });
            }
        }
    }

    /// Builds the data of the stages from the lattice, the regions and the material, which are new or were changed.
    pub(super) fn rebuild_stages(&mut self) {
        stages().for_each(|stage| stage.rebuild(self));
    }

    /// Moves the data of the stages to a lattice whose vertices were split.
    pub(super) fn follow_in_stages(&mut self, parents: &Parents) {
        stages().for_each(|stage| stage.follow(self, parents));
    }
}
