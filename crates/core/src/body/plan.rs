//! The plan of a body: name, parameters and memory of each stage.

use super::soft_body::Body;
use super::step::{Stage, stages};
use crate::dynamics::{Damping, Inflation, RegionDamping, StiffnessFactors};
use crate::plan::{BodyPlan, CONTACT_OF_BODIES, PlannedStage, When};

impl Body {
    /// Returns the stages of a step, with their memory. The display adds its own.
    pub(crate) fn plan_of_step(&self) -> BodyPlan {
        let mut plan = BodyPlan {
            name: self.name.clone(),
            lattice_bytes: self.lattice.memory()
                + self.masses.bytes()
                + self.stiffness_factors.as_ref().map_or(0, StiffnessFactors::bytes),
            state_bytes: self.state.bytes(),
            stages: Vec::new(),
            left_out: Vec::new(),
        };
        for stage in stages() {
            if self.has(stage) {
                plan.stages.push(self.describe(stage));
            } else if stage.is_main() {
                plan.left_out.push(stage.name());
            }
        }
        plan
    }

    /// Returns the name, the parameters and the memory of a stage.
    fn describe(&self, stage: Stage) -> PlannedStage {
        let (detail, bytes) = match stage {
            Stage::BeginConstraints => ("captured positions, targets".to_owned(), 0),
            Stage::Constraints => self.constraints.as_ref().map_or_else(Default::default, |constraints| {
                let list = constraints.list();
                let count: usize = list.iter().map(|constraint| constraint.vertices().len()).sum();
                (format!("{} on {count} lattice vertices", list.len()), constraints.bytes())
            }),
            Stage::Forces => (
                "next step's forces, this frame's displacements".to_owned(),
                self.forces.as_ref().map_or(0, |forces| forces.bytes()),
            ),
            Stage::Inflation => {
                let inflation = self.inflation.as_ref();
                ("ratios of rest volumes".to_owned(), inflation.map_or(0, Inflation::bytes))
            }
            Stage::Momentum => (
                format!("momenta in f64, connected components: {}", self.state.momenta.len()),
                self.momentum.bytes(),
            ),
            Stage::RegionDamping => {
                let detail = match self.material.region_damping {
                    RegionDamping::PerStep(fraction) => format!("{fraction} per step"),
                    RegionDamping::Rate(rate) => format!("{rate} per second"),
                };
                (detail, self.region_damping.as_ref().map_or(0, |damping| damping.bytes()))
            }
            Stage::ElasticDamping => {
                let detail = match self.material.damping() {
                    Damping::Ratio(0.0) | Damping::Rate(0.0) => {
                        format!("rolling resistance {}", self.rolling_resistance())
                    }
                    Damping::Ratio(ratio) => format!("ratio {ratio} of the lowest mode"),
                    Damping::Rate(rate) => format!("{rate} per second"),
                };
                (detail, self.elastic_damping.as_ref().map_or(0, |damping| damping.bytes()))
            }
            Stage::BeginContacts => ("stores the velocities before shape matching".to_owned(), 0),
            Stage::Matching => {
                let limiter = self.energy.as_ref();
                let plastic = if self.state.strains.is_some() { ", plastic shapes" } else { "" };
                let suffix = if limiter.is_some() { ", energy limiter" } else { "" };
                let (width, blocks) = (self.half_width(), self.matching.layout.blocks());
                let bytes = self.matching.bytes() + self.workspace.bytes() + limiter.map_or(0, |l| l.bytes());
                (
                    format!(
                        "half-width {width}, window sums along x, y, z, SIMD blocks: {blocks}{plastic}{suffix}"
                    ),
                    bytes,
                )
            }
            Stage::Fracture => {
                let cracks = self.fracture().map_or(0, |options| options.cracks);
                (
                    format!("cracks that grow at a time: {cracks}, broken joints: {}", self.broken_joints()),
                    self.breaking_bytes(),
                )
            }
            Stage::Integration => (format!("{} lattice vertices, f32", self.lattice.len()), 0),
            Stage::BodyContacts => match self.planned_body_contact() {
                Some((Some(samples), bytes)) => (format!("{samples} samples"), bytes),
                Some((None, bytes)) => ("no samples before a body is near".to_owned(), bytes),
                None => Default::default(),
            },
            Stage::Contacts => self.contacts.as_ref().map_or_else(Default::default, |contacts| {
                (format!("{} samples", contacts.samples().count()), contacts.bytes())
            }),
        };
        PlannedStage { when: When::Step, name: stage.name(), detail, bytes }
    }
}

impl Stage {
    /// Returns the name of the stage in the plan.
    fn name(self) -> &'static str {
        match self {
            Self::BeginConstraints => "begin pins, handles",
            Self::Forces => "external forces",
            Self::Inflation => "inflation",
            Self::Momentum => "momentum tracker",
            Self::RegionDamping => "region damping",
            Self::ElasticDamping => "elastic damping",
            Self::BeginContacts => "begin contacts",
            Self::Matching => "shape matching",
            Self::Fracture => "fracture",
            Self::Integration => "integration",
            Self::BodyContacts => CONTACT_OF_BODIES,
            Self::Contacts => "contacts",
            Self::Constraints => "pins and handles",
        }
    }

    /// Returns whether the plan lists this stage as left out if the body does not have it. Stages that only
    /// prepare a later stage are not listed.
    fn is_main(self) -> bool {
        !matches!(self, Self::BeginConstraints | Self::BeginContacts)
    }
}
