//! The stages of the display, and their input.

use crate::body::{Body, BodyRef};
use crate::parallel::Executor;
use crate::plan::{BodyPlan, PlannedStage, When};
use crate::volume::VolumeMeasures;

/// The input of an evaluation: a body in a simulation, and the executor.
#[derive(Clone, Debug)]
pub(super) struct Frame<'a> {
    pub(super) body: BodyRef<'a>,
    pub(super) executor: Executor,
}

impl<'a> Frame<'a> {
    pub(super) fn new(body: BodyRef<'a>) -> Self {
        let executor = body.context().map_or_else(Executor::sequential, |context| context.executor.clone());
        Self { body, executor }
    }
}

/// A stage that turns P^ of the dynamics into the displayed surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Untangle,
    Correct,
    UntangleCorrected,
    Skin,
}

/// The stages in execution order. An evaluation runs this list, and the plan prints it with the memory of each stage.
pub(super) const DISPLAY: [Stage; 4] =
    [Stage::Untangle, Stage::Correct, Stage::UntangleCorrected, Stage::Skin];

impl Stage {
    /// Returns whether a body has the stage. A missing stage takes no time and no memory.
    pub(super) fn exists(self, body: &Body) -> bool {
        match self {
            Self::Untangle => true,
            Self::Correct | Self::UntangleCorrected => body.correction().is_some(),
            Self::Skin => body.surface().is_some(),
        }
    }

    /// Returns the name of the stage in the plan; `None` for the stages that act only in frames with cells inside out.
    fn name(self) -> Option<&'static str> {
        match self {
            Self::Untangle | Self::UntangleCorrected => None,
            Self::Correct => Some("volume correction"),
            Self::Skin => Some("mesh update"),
        }
    }

    /// Returns the parameters of the stage, and its memory in bytes.
    fn describe(self, body: &Body) -> (String, usize) {
        match self {
            Self::Untangle | Self::UntangleCorrected => Default::default(),
            Self::Correct => body.correction().map_or_else(Default::default, |correction| {
                let measures = body.built_measures().map_or(0, VolumeMeasures::bytes);
                (format!("measure {}", correction.measure()), correction.bytes() + measures)
            }),
            Self::Skin => body.surface().map_or_else(Default::default, |surface| {
                let vertices = surface.mesh.vertices().len();
                let bytes = surface.embedding.memory() + surface.skin.bytes();
                (format!("{vertices} mesh vertices, {} skin", body.skin().name()), bytes)
            }),
        }
    }
}

impl Body {
    /// Returns the memory of the body in bytes: lattice, state and stages. The mesh and the buffers of a
    /// [`Display`](crate::Display) are not included, nor are the animations that handles follow. The data that the
    /// first volume report builds are included only if the body has a volume correction.
    pub fn memory(&self) -> usize {
        self.plan().bytes()
    }

    /// Returns the stages of a step, then the stages that evaluate the displayed surface, with their memory.
    pub(crate) fn plan(&self) -> BodyPlan {
        let mut plan = self.plan_of_step();
        for stage in DISPLAY {
            let Some(name) = stage.name() else { continue };
            if stage.exists(self) {
                let (detail, bytes) = stage.describe(self);
                plan.stages.push(PlannedStage { when: When::Display, name, detail, bytes });
            } else {
                plan.left_out.push(name);
            }
        }
        plan
    }
}
