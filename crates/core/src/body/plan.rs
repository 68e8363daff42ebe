//! The plan of a body: name, parameters and memory of each stage.

use super::soft_body::Body;
use super::stages::stages;
use crate::dynamics::StiffnessFactors;
use crate::plan::{BodyPlan, PlannedStage, When};

impl Body {
    /// Returns the stages of a step, with their memory. The display adds its own.
    pub(crate) fn plan_of_step(&self) -> BodyPlan {
        let mut plan = BodyPlan {
            name: self.name.clone(),
            lattice_bytes: self.shape.lattice.memory()
                + self.shape.masses.bytes()
                + self.stiffness_factors.as_ref().map_or(0, StiffnessFactors::bytes)
                + self.settings.parts.bytes(),
            state_bytes: self.state.bytes(),
            stages: Vec::new(),
            left_out: Vec::new(),
        };
        for stage in stages() {
            if stage.exists(self) {
                let (detail, bytes) = stage.describe(self);
                plan.stages.push(PlannedStage { when: When::Step, name: stage.name(), detail, bytes });
            } else if stage.is_main() {
                plan.left_out.push(stage.name());
            }
        }
        plan
    }
}
