//! A component that begins inside colliders leaves them as a whole.
//!
//! The first step, and the step after positions or colliders were set, looks for components inside colliders and
//! chooses a translation out of them (`contact::escape`). So does the end of a step after which a collider is enabled.
//! The component is translated by a quarter of a cell per step, or more where it would take more than 64 steps. It
//! keeps its shape and its velocities: neither gravity nor contacts act on it. A component with an active pin or handle
//! stays, and its samples are pushed out one by one.

use nalgebra::{Point3, Vector3};

use super::context::StepContext;
use super::parts::{ContactData, Leaving, Pipeline, Shape};
use super::soft_body::Body;
use super::surface::Surface;
use crate::contact::{BodyPoints, Colliders, PosedShape};

impl Body {
    /// Lets the next step look for components inside colliders. Called when colliders were set.
    pub(crate) fn search_escapes(&mut self) {
        self.state.escapes.search();
    }

    /// Looks for components inside colliders where needed, and stores the state of the components that leave colliders.
    pub(super) fn begin_escapes(&mut self, context: &StepContext) {
        let Self {
            contact: ContactData { contacts, .. }, pipeline: Pipeline { momentum, .. }, state, ..
        } = self;
        state.escapes.retain(|escape| !momentum.is_constrained(escape.component as usize));
        if state.escapes.searches {
            state.escapes.searches = false;
            if let Some(contacts) = contacts {
                contacts.set_sides(&[]);
            }
            let frame = self.state.frame.body_frame();
            let shapes: Vec<_> = context.colliders.before(context.interval, frame).collect();
            self.find_escapes(&shapes, &shapes, context.gravity);
        }
        let Self {
            contact: ContactData { contacts, leaving, .. },
            shape: Shape { lattice, .. },
            pipeline: Pipeline { matching, .. },
            state,
            ..
        } = self;
        let had_leaving = !leaving.is_empty();
        leaving.clear();
        if !had_leaving && state.escapes.list().is_empty() {
            return;
        }
        let of_vertex = &lattice.components().of_vertex;
        let leaves = |component: u32| state.escapes.of(component).is_some();
        for (&slot, &component) in matching.layout.slots().iter().zip(of_vertex) {
            if leaves(component) {
                let (position, velocity) = (state.local(slot), state.velocities.get(slot));
                leaving.push(Leaving { slot, component, position, velocity });
            }
        }
        if let Some(contacts) = contacts {
            contacts.set_leaving(|vertex| leaves(of_vertex[vertex as usize]));
        }
    }

    /// Follows the colliders that are enabled or disabled next, at `time`, the current time: wakes up near them, and
    /// leaves those that are enabled as a whole.
    pub(crate) fn follow_switches(&mut self, colliders: &Colliders, time: f64, gravity: Vector3<f64>) {
        let frame = self.state.frame.body_frame();
        let (center, radius) = self.ball();
        if colliders.switches_near(time, frame, (&center, radius)) {
            self.wake();
            if !self.state.escapes.list().is_empty() {
                // The next step finds what there is to leave now.
                self.state.escapes.search();
                return;
            }
            let shapes: Vec<_> = colliders.switched(time, frame, |_| true).collect();
            let entered: Vec<_> = colliders.switched(time, frame, |is_enabled| !is_enabled).collect();
            self.find_escapes(&shapes, &entered, gravity);
        }
    }

    /// Finds the escapes from `shapes` of the components without active constraints that are in a shape of `entered`, and
    /// are not leaving colliders.
    fn find_escapes(&mut self, shapes: &[PosedShape<'_>], entered: &[PosedShape<'_>], gravity: Vector3<f64>) {
        // All cells at an inner vertex are full, so that the surface is at least one cell away. An open mesh has no
        // inside.
        let is_solid = self.surface().is_none_or(|Surface { mesh, .. }| mesh.is_closed());
        let Self {
            contact: ContactData { contacts: Some(contacts), .. },
            shape: Shape { lattice, masses, .. },
            pipeline: Pipeline { matching, momentum, .. },
            state,
            ..
        } = self
        else {
            return;
        };
        if !entered.iter().any(|shape| contacts.may_touch(shape, &state.positions)) {
            return;
        }
        let components = lattice.components();
        let mut points = vec![BodyPoints::default(); components.count];
        for (vertex, position) in contacts.samples().positions(|slot| state.local(slot)) {
            points[components.of_vertex[vertex as usize] as usize].samples.push(position);
        }
        for (vertex, &slot) in matching.layout.slots().iter().enumerate() {
            if is_solid && masses[vertex] > 0.999 {
                let position = Point3::from(state.local(slot));
                points[components.of_vertex[vertex] as usize].inner.push(position);
            }
        }
        let up = (-gravity).try_normalize(0.0).unwrap_or_default();
        for (component, points) in (0..).zip(&points) {
            let is_in = || entered.iter().any(|shape| points.is_in(shape));
            let is_leaving = state.escapes.of(component).is_some();
            if is_leaving || momentum.is_constrained(component as usize) || !is_in() {
                continue;
            }
            if let Some(translation) = points.escape_translation(shapes, up) {
                state.escapes.add(component, translation);
            }
        }
    }

    /// Moves the components that leave colliders: their positions before the step plus the translation of the step.
    pub(super) fn move_out(&mut self) {
        let Self { contact: ContactData { leaving, .. }, state, .. } = self;
        if state.escapes.list().is_empty() {
            return;
        }
        for &Leaving { slot, component, position, velocity } in &*leaving {
            let translation = state.escapes.of(component).map_or([0.0; 3], |escape| escape.translation);
            state.set_local(slot, position + Vector3::from(translation));
            state.velocities.set(slot, velocity);
            state.momenta[component as usize] = None;
        }
        state.escapes.advance();
    }
}
