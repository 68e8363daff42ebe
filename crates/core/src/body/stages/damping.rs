//! Region damping, and the damping of the elastic modes.

use super::matching::fitted_state;
use super::stage::{BodyStep, Stage};
use crate::body::parts::{Pipeline, Settings, Shape};
use crate::body::soft_body::Body;
use crate::dynamics::{
    Damping, ElasticDamper, MovingRegions, Quantity, RegionDamper, RegionDamping, VariedDamping,
};
use crate::matching::Purpose;

/// Moves the velocities towards the mean rigid velocity of the regions: v += d (v̄ - v).
///
/// Region damping runs before shape matching. If it ran afterwards, it would spread the accelerations of constrained vertices
/// to other vertices, although the constraints override the velocities of constrained vertices.
pub(in crate::body) struct DampRegions;

impl Stage for DampRegions {
    fn name(&self) -> &'static str {
        "region damping"
    }

    fn exists(&self, body: &Body) -> bool {
        body.pipeline.region_damping.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let BodyStep { context, executor, .. } = *step;
        let mut shared = body.is_one_task().then(|| context.workspaces.lock(executor));
        let Body {
            pipeline: Pipeline { region_damping: Some(region_damping), matching, workspace, .. },
            settings: Settings { material, .. },
            state,
            ..
        } = body
        else {
            return;
        };
        let workspace = shared.as_deref_mut().unwrap_or(workspace);
        if !state.fitted {
            matching.fit(workspace, executor, fitted_state(state), None, Purpose::Regions);
        }
        let fraction = material.region_damping_fraction(context.interval.dt) as f32;
        let moving = MovingRegions {
            rotations: &state.rotations,
            strains: state.strains.as_ref(),
            velocities: &mut state.velocities,
        };
        region_damping.apply(matching, workspace, executor, moving, (fraction, matching.regions.shares()));
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let detail = match body.settings.material.region_damping {
            RegionDamping::PerStep(fraction) => format!("{fraction} per step"),
            RegionDamping::Rate(rate) => format!("{rate} per second"),
        };
        (detail, body.pipeline.region_damping.as_ref().map_or(0, RegionDamper::bytes))
    }

    fn rebuild(&self, body: &mut Body) {
        let is_damped = body.settings.material.has_region_damping();
        body.pipeline.region_damping = is_damped.then(|| RegionDamper::new(&body.pipeline.matching));
    }
}

/// Measures the motion before the step, and computes the motions of the components, towards which the acceleration damps
/// the velocities.
pub(in crate::body) struct DampModes;

impl Stage for DampModes {
    fn name(&self) -> &'static str {
        "elastic damping"
    }

    fn exists(&self, body: &Body) -> bool {
        body.pipeline.elastic_damping.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let rates = body.damping_rates(step.context.interval.dt, step.executor);
        let Body {
            pipeline: Pipeline { elastic_damping: Some(damping), matching, momentum, region_damping, .. },
            constraints,
            state,
            ..
        } = body
        else {
            return;
        };
        // Only region damping changes the velocities since the start of the step.
        if !momentum.is_measured || region_damping.is_some() {
            momentum.measure((matching, state), step.executor);
        }
        damping.begin(constraints.as_ref(), (matching, state), momentum, (rates, step.executor));
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let detail = match body.settings.material.damping() {
            Damping::Ratio(0.0) | Damping::Rate(0.0) => {
                format!("rolling resistance {}", body.rolling_resistance())
            }
            Damping::Ratio(ratio) => format!("ratio {ratio} of the lowest mode"),
            Damping::Rate(rate) => format!("{rate} per second"),
        };
        (detail, body.pipeline.elastic_damping.as_ref().map_or(0, ElasticDamper::bytes))
    }

    fn rebuild(&self, body: &mut Body) {
        let varied = || {
            let Shape { lattice, masses, .. } = &body.shape;
            let factor = body.settings.parts.on(lattice, Quantity::Damping)?;
            let factors = (0..lattice.len() as u32).map(factor).collect();
            Some(VariedDamping::new(factors, lattice, masses, &body.pipeline.matching))
        };
        body.pipeline.elastic_damping = body.needs_damping().then(|| ElasticDamper::new(varied()));
    }
}
