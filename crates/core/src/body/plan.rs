//! What is done for a body, from the stages that it has.

use super::{Body, Damping};
use crate::plan::{BodyPlan, When};

impl Body {
    /// Memory that the body takes: its lattice, and what its stages hold. What a first look needs is not in it before.
    pub fn memory(&self) -> usize {
        self.lattice.memory() + self.plan().bytes()
    }

    /// The stages of a step and of a look, in order.
    pub(crate) fn plan(&self) -> BodyPlan {
        let mut plan = BodyPlan { name: self.name.clone(), stages: Vec::new(), left_out: Vec::new() };
        let width = self.half_width();
        let vertices = self.lattice.len();

        let holds = self.kinematics.as_ref().map(|kinematics| {
            let held: usize = kinematics.holds().iter().map(|hold| hold.vertices().len()).sum();
            (kinematics.holds().len(), held)
        });
        let detail = holds.map(|(count, held)| format!("{count}, of {held} lattice vertices"));
        plan.stage(When::Step, "pins and handles", detail, holds.map_or(0, |(_, held)| 28 * held + vertices));
        let components = self.state.books.len();
        let books = format!("f64, components: {components}");
        plan.stage(When::Step, "momentum books", Some(books), self.bookkeeper.bytes());
        let energy = self.energy.as_ref();
        let guarded = energy.map(|_| "f64, near two best rotations of a region".to_owned());
        plan.stage(When::Step, "energy book", guarded, energy.map_or(0, |guard| guard.bytes()));
        let sums = format!("half-width {width}, x y z, blocks: {}", self.matching.layout.blocks());
        let cascade = super::look::locked(&self.cascade).bytes();
        plan.stage(When::Step, "region sums", Some(sums), self.matching.bytes() + cascade);
        let state = format!("{vertices} lattice vertices, f32");
        plan.stage(When::Step, "rotations, goals", Some(state), self.state.bytes());
        let damping = self.damping.as_ref();
        let rate = damping.map(|_| match self.material.damping {
            Damping::PerStep(share) => format!("{share} a step"),
            Damping::Rate(rate) => format!("{rate} a second"),
        });
        plan.stage(When::Step, "region damping", rate, damping.map_or(0, |damping| damping.bytes()));
        plan.stage(When::Step, "integration", Some("corrected to the books".to_owned()), 0);
        let samples = self.contacts.as_ref().map(|contacts| contacts.samples().len());
        plan.stage(
            When::Step,
            "contacts",
            samples.map(|count| format!("{count} samples")),
            samples.map_or(0, |n| 12 * n),
        );

        let view = super::look::locked(&self.view);
        let measure = view.measure();
        let detail = measure.map(|measure| format!("measure {measure}, turned with the positions shown"));
        plan.stage(When::Look, "volume correction", detail, view.correction_bytes());
        let surface = self.surface.as_ref();
        let mesh = surface.map(|surface| format!("{} mesh vertices", surface.mesh.vertices().len()));
        let bytes = surface.map_or(0, |surface| surface.embedding.memory() + view.update_bytes());
        plan.stage(When::Look, "mesh update", mesh, bytes);
        plan
    }
}
