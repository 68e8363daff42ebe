//! Sleep: a body at rest is not stepped.
//!
//! A body falls asleep at the beginning of a frame if these conditions hold during the last half second:
//!
//! * Every vertex is slower than 1e-3 √(L max(g, 8 L/s²)), with the size L of the body and the gravity g: a thousandth
//!   of the speed after a fall by about the size of the body.
//! * A pin or handle holds every component, or it rests on a collider or a body, or it is exactly still.
//! * No pin, handle or near collider moves, and the body is not leaving a collider.
//!
//! Its velocities are then set to zero.
//!
//! In place of the speed, the positions at the beginnings of frames may show rest: a body that touches others moves no
//! vertex by more than 0.02 cells in the half second, and a body on colliders alone by no more than the lesser of this
//! and a thousandth of L. Where edges are squeezed, contacts come and go, and single vertices jump to and fro by small
//! distances at high speeds. Vertices outside the surface have little mass, and jump farther. So a body on colliders alone
//! also rests if no vertex of its mesh moves by more than this limit, and no lattice vertex by more than four times the
//! limit. A body with a smooth skin does not: its mesh is no mean of the corners of cells.
//!
//! Bodies that touch each other fall asleep and wake up together, if one of them is held or rests on a collider. A body
//! that another one touches wakes up.
//!
//! A sleeping body wakes up when something could move it: a handle or a near collider that moves, a near collider that is
//! enabled or disabled, a pin or handle
//! that begins or ends, a force that changes, an assigned position or velocity, and every changed setting.
//!
//! A force that is the same in every step lets a body sleep, as gravity does. So does one that changes by less than a
//! thousandth of the weight under the gravity max(g, 8 L/s²) at each vertex, such as a drag that the noise of the
//! velocities varies. Any force on a vertex without one counts as a change.

use nalgebra::{Point3, Vector3};

use super::context::StepContext;
use super::parts::{Pipeline, Shape};
use super::soft_body::Body;
use super::surface::Surface;
use crate::contact::Colliders;
use crate::contact::bodies::BodyContact;
use crate::dynamics::{ElasticDamper, effective_gravity};
use crate::parallel::Executor;
use crate::simd::vector::wide;
use crate::skin::SkinKind;
use crate::state::{Interval, Stay};

/// Time in seconds for which a body must be at rest before it falls asleep.
const REST_TIME: f64 = 0.5;

/// Limit of the speed, as a fraction of √(L max(g, 8 L/s²)).
const REST_SPEED: f64 = 1e-3;

/// Greatest distance in cells of a vertex from its place in half a second of rest on colliders, unless [`REST_SHARE`]
/// is less.
const REST_DISTANCE: f64 = 0.02;

/// Greatest distance of a vertex from its place in half a second of rest on colliders, as a fraction of L.
const REST_SHARE: f64 = 1e-3;

/// Greatest distance of a lattice vertex from its place if the mesh stays within the limit, as a multiple of the limit. A
/// choice.
const REST_UNSEEN: f64 = 4.0;

/// Limit of the change of a force on a vertex, as a fraction of m max(g, 8 L/s²).
const REST_FORCE: f64 = 1e-3;

/// Largest velocity of a vertex by rounding errors, in standard deviations: 5 for the largest of 10^6 numbers, times 3
/// for the rounding errors of the sums over the regions.
const NOISE: f64 = 15.0;

/// Greatest limit of the speed for noise, as a multiple of the limit without noise.
const GREATEST_NOISE: f64 = 10.0;

/// Distance in cells below which a moving collider wakes a sleeping body.
const NEAR: f64 = 2.0;

/// Whether a body, or bodies that touch each other, may sleep. The first that holds for one of them counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum RestVote {
    /// Something may move the body.
    Disturbed,
    /// The body has not been at rest for long enough.
    Awake,
    /// The body may fall asleep.
    Rested,
    /// The body sleeps.
    Asleep,
}

impl Body {
    /// Returns whether the body sleeps: it is at rest and is not stepped.
    pub fn is_asleep(&self) -> bool {
        self.state.rest.is_asleep
    }

    /// Wakes the body up. It falls asleep again after half a second of rest.
    pub fn wake(&mut self) {
        if self.is_asleep() {
            // A sleeping body keeps contacts that the bodies at them may have forgotten.
            self.state.touches.forget_search();
        }
        self.state.rest.wake();
    }

    /// Returns at the beginning of a step whether the body may sleep during the step.
    pub(crate) fn rest_vote(&self, context: &StepContext) -> RestVote {
        let (is_asleep, time) = (self.is_asleep(), self.state.rest.time());
        match () {
            _ if !context.sleep => RestVote::Disturbed,
            _ if (is_asleep || time > 0.0) && self.is_disturbed(context) => RestVote::Disturbed,
            _ if is_asleep => RestVote::Asleep,
            _ if context.is_frame_start && time >= REST_TIME => RestVote::Rested,
            _ => RestVote::Awake,
        }
    }

    /// Lets the body sleep, or wakes it up, at the beginning of a step. `vote`: of the body and of all bodies
    /// that it touches.
    pub(crate) fn follow(&mut self, vote: RestVote) {
        match vote {
            RestVote::Disturbed => self.wake(),
            RestVote::Rested if !self.is_asleep() => self.fall_asleep(),
            RestVote::Awake if self.is_asleep() => self.wake(),
            _ => {}
        }
    }

    /// Returns whether a collider, a pin or a handle holds the body, or it is exactly still.
    pub(crate) fn has_own_support(&self) -> bool {
        let Self {
            shape: Shape { lattice, .. }, pipeline: Pipeline { matching, momentum, .. }, state, ..
        } = self;
        let is_still = |&slot: &u32| state.velocities.get(slot) == [0.0; 3];
        !state.supports.list().is_empty()
            || self.constraints.as_ref().is_some_and(|constraints| constraints.pulled().next().is_some())
            || (0..lattice.components().count).any(|component| momentum.is_constrained(component))
            || state.frame.velocity() == Vector3::zeros() && matching.layout.slots().iter().all(is_still)
    }

    /// Updates the time for which the body has been at rest, at the end of a step.
    pub(super) fn track_rest(&mut self, context: &StepContext, executor: &Executor) {
        if !context.sleep {
            return;
        }
        let can_rest = self.state.escapes.list().is_empty() && self.is_supported();
        let is_at_rest =
            can_rest && (self.is_where_it_was_searched() || self.is_slow(self.rest_speed(context, executor)));
        // The place of a body that touches others is that in which they were searched.
        let can_stay =
            can_rest && !self.state.supports.list().is_empty() && self.state.touches.bodies().is_empty();
        let limit = REST_DISTANCE.min(REST_SHARE * self.size() / self.shape.lattice.cell_size());
        let stay = match can_stay {
            true => Stay::Possible { stays: context.is_frame_start.then(|| self.stays_in_place(limit)) },
            false => Stay::Impossible,
        };
        self.state.track_rest(context.interval.dt, is_at_rest, stay);
    }

    /// Returns whether no lattice vertex is farther than `limit` cells from the place in which the body has stayed, or no
    /// vertex of the mesh is, and no lattice vertex is farther than [`REST_UNSEEN`] times `limit`.
    fn stays_in_place(&self, limit: f64) -> bool {
        let occupied = self.pipeline.matching.layout.occupied();
        let Some(distance) = self.state.distance_from_place(occupied) else { return false };
        distance <= limit || distance <= REST_UNSEEN * limit && self.mesh_stays_in_place(limit)
    }

    /// Returns whether no vertex of the mesh is farther than `limit` cells from the place in which the body has stayed.
    /// False for a smooth skin, whose vertices are no means of the corners of their cells.
    fn mesh_stays_in_place(&self, limit: f64) -> bool {
        if self.settings.skin != SkinKind::Linear {
            return false;
        }
        let Some(Surface { embedding, .. }) = self.surface() else { return false };
        let slots = self.pipeline.matching.layout.slots();
        embedding.by_cell().all(|cell| {
            let corners =
                cell.corners.map(|vertex| self.state.displacement_from_place(slots[vertex as usize]));
            let displacement = |point: u32| -> Vector3<f64> {
                let weights = embedding.weights(point as usize);
                corners.iter().zip(weights).map(|(corner, weight)| corner * f64::from(weight)).sum()
            };
            // A point inside its cell moves by no more than the corners. One outside is at no face of the mesh.
            corners.iter().all(|corner| corner.norm() <= limit)
                || cell.points.iter().all(|&point| displacement(point).norm() <= limit)
        })
    }

    /// Returns whether the body touches others, and is where it was when these contacts were searched.
    fn is_where_it_was_searched(&self) -> bool {
        let is_in_place = |contact: &BodyContact| contact.searched.is_in_place;
        !self.state.touches.bodies().is_empty() && self.contact.body_contact.as_ref().is_some_and(is_in_place)
    }

    fn fall_asleep(&mut self) {
        let Self { pipeline: Pipeline { matching, .. }, state, .. } = self;
        state.set_origin_velocity(matching.layout.slots(), Vector3::zeros());
        state.velocities.blocks_mut().iter_mut().flatten().for_each(|row| row.fill(0.0));
        state.momenta.fill(None);
        if let Some(rigid) = &mut state.rigid {
            rigid.stop();
        }
        state.energy_limit = None;
        state.rest.is_asleep = true;
        self.measure_contact_bounds();
    }

    /// Returns the limit of the speeds of a body at rest, in cells/s.
    ///
    /// Each step adds the rounding error of the f32 positions times alpha/dt to the velocities, and damping lets the
    /// sum decay. The noise of a body at rest is this velocity over √(1 - keep²), with the fraction `keep` that
    /// damping keeps. On fine lattices it exceeds the limit of the speed, so a damped body may be as fast as its noise.
    fn rest_speed(&self, context: &StepContext, executor: &Executor) -> f64 {
        let (gravity, dt) = (context.gravity.norm(), context.interval.dt);
        let (size, cell_size) = (self.size(), self.shape.lattice.cell_size());
        let speed = REST_SPEED * (size * effective_gravity(size, gravity)).sqrt() / cell_size;
        if self.is_rigid() {
            return speed;
        }
        let least = self.pipeline.elastic_damping.as_ref().map_or(1.0, ElasticDamper::least_factor);
        let keep = self.damping_rates(dt, executor).kept(least);
        let rounding = f64::from(f32::EPSILON) * self.shape.extent as f64 / 2.0;
        let noise = NOISE * self.alpha_of_stiffest(dt) / dt * rounding / (1.0 - keep * keep).sqrt();
        speed.max(noise.min(GREATEST_NOISE * speed))
    }

    /// Returns whether every vertex is slower than `limit`, in cells/s.
    ///
    /// Most bodies in motion are recognized by one vertex, the first that was too fast in an earlier step.
    fn is_slow(&mut self, limit: f64) -> bool {
        let Self { pipeline: Pipeline { matching, fast_vertex, .. }, state, .. } = self;
        let slots = matching.layout.slots();
        let origin = state.frame.velocity();
        let is_fast = |&slot: &u32| {
            let velocity = wide(state.velocities.get(slot)) + origin;
            let squared = velocity.norm_squared();
            squared >= limit * limit || squared.is_nan()
        };
        if is_fast(&slots[*fast_vertex]) {
            return false;
        }
        match slots.iter().position(is_fast) {
            Some(vertex) => {
                *fast_vertex = vertex;
                false
            }
            None => true,
        }
    }

    /// Returns whether each component has a constrained vertex, rests on a collider, or is exactly still.
    fn is_supported(&self) -> bool {
        let Self {
            shape: Shape { lattice, .. }, pipeline: Pipeline { matching, momentum, .. }, state, ..
        } = self;
        let touched = state.touches.bodies();
        let pulled = self.constraints.as_ref().filter(|constraints| constraints.any_soft());
        let is_pulled = |component: usize| {
            let mut vertices = pulled.into_iter().flat_map(|constraints| constraints.pulled());
            vertices.any(|vertex| lattice.components().of_vertex[vertex as usize] as usize == component)
        };
        let is_held = |component: usize| {
            let first = touched.partition_point(|(found, _)| (*found as usize) < component);
            momentum.is_constrained(component)
                || is_pulled(component)
                || touched.get(first).is_some_and(|(found, _)| *found as usize == component)
                || state.supports.list().iter().any(|support| support.component as usize == component)
        };
        if (0..lattice.components().count).all(is_held) {
            return true;
        }
        let is_still = |slot: u32| state.velocities.get(slot) == [0.0; 3];
        state.frame.velocity() == Vector3::zeros()
            && matching
                .layout
                .slots()
                .iter()
                .zip(&lattice.components().of_vertex)
                .all(|(&slot, &component)| is_still(slot) || is_held(component as usize))
    }

    /// Returns whether something may move a body at rest in this step.
    fn is_disturbed(&self, context: &StepContext) -> bool {
        let Self { constraints, forces, state, .. } = self;
        let acceleration = REST_FORCE * effective_gravity(self.size(), context.gravity.norm());
        let tolerance = |vertex: u32| acceleration * self.mass_of(vertex);
        forces
            .as_ref()
            .is_some_and(|forces| forces.move_a_body_at_rest(tolerance, |vertex| self.mass_of(vertex)))
            || constraints.as_ref().is_some_and(|constraints| !constraints.is_static(context.interval))
            || self.is_near_moving_collider(context.colliders, context.interval)
            // In a restored state, whose colliders were others.
            || state.supports.list().iter().any(|support| !context.colliders.is_enabled(support.collider))
    }

    /// Returns whether a collider that moves during a step is near the body.
    fn is_near_moving_collider(&self, colliders: &Colliders, interval: Interval) -> bool {
        if !colliders.any_moves() {
            return false;
        }
        let (center, radius) = self.ball();
        colliders.moves_near(interval, self.state.frame.body_frame(), &center, radius)
    }

    /// Returns center and radius of a ball around the body, in cells in its frame, in which colliders are near.
    pub(super) fn ball(&self) -> (Point3<f64>, f64) {
        let (low, high) = self.local_bounds();
        let layer = self.settings.touching.thickness / self.shape.lattice.cell_size();
        (Point3::from((low + high) / 2.0), (high - low).norm() / 2.0 + NEAR + layer)
    }
}
