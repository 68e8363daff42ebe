//! One step of a body: the page that reads like the papers.

use nalgebra::Vector3;

use super::Body;
use crate::dynamics::integrate::Advance;
use crate::dynamics::{Colliders, Interval};
use crate::parallel::Executor;

/// What acts on all bodies in a step.
pub(crate) struct World<'a> {
    /// Scene units per second squared.
    pub(crate) gravity: Vector3<f64>,
    pub(crate) interval: Interval,
    pub(crate) colliders: Option<&'a Colliders>,
    /// Whether this is the first step of a frame.
    pub(crate) opens_frame: bool,
}

impl Body {
    /// One step: goal positions, damping, integration, contacts, pins and handles.
    pub(crate) fn step(&mut self, world: &World, executor: &Executor) {
        self.begin_holds(world);
        self.open_books(executor);
        self.match_shape(world, executor);
        self.damp(world, executor);
        self.advance(world, executor);
        self.touch(world);
        self.hold(world);
    }

    /// Pins and handles that begin now capture what they hold; the momenta of what is held are not its own.
    fn begin_holds(&mut self, world: &World) {
        let Self { kinematics, matching, bookkeeper, state, .. } = self;
        if let Some(kinematics) = kinematics {
            let slots = matching.layout.slots();
            kinematics.begin(world.interval, &state.positions, state.frame.body_frame(), slots);
            bookkeeper.pull(slots, kinematics.held(), &mut state.books);
        }
    }

    /// Measures the momenta that no book has, and keeps the body near its origin.
    fn open_books(&mut self, executor: &Executor) {
        let Self { matching, bookkeeper, state, .. } = self;
        let strayed = state.strayed(matching.layout.slots()[0]);
        if !strayed && !bookkeeper.any_to_open(&state.books) {
            return;
        }
        bookkeeper.measure(executor, &matching.regions.constants, &state.positions, &state.velocities);
        bookkeeper.open(&mut state.books);
        if strayed {
            state.rebase(matching.layout.slots(), bookkeeper.centre());
        }
    }

    /// Goal positions by shape matching, and the velocities that they and gravity give.
    fn match_shape(&mut self, world: &World, executor: &Executor) {
        let Self { matching, bookkeeper, state, .. } = self;
        let dt = world.interval.dt;
        let gain = world.gravity * (dt / self.lattice.cell_size());
        let pull = self.material.alpha(dt) / dt;
        matching.fit(executor, &state.positions, &mut state.rotations);
        matching.accelerate(
            executor,
            &state.positions,
            &mut state.velocities,
            pull as f32,
            gain.map(|g| g as f32).into(),
        );
        bookkeeper.enter(&mut state.books, gain);
    }

    /// Region damping, where the material has any.
    fn damp(&mut self, world: &World, executor: &Executor) {
        if let Some(damping) = &self.damping {
            let share = self.material.damping_share(world.interval.dt);
            let state = &mut self.state;
            damping.apply(
                &mut self.matching,
                executor,
                &state.rotations,
                &mut state.velocities,
                share as f32,
            );
        }
    }

    /// Velocities corrected to the books, positions moved.
    fn advance(&mut self, world: &World, executor: &Executor) {
        let Self { matching, bookkeeper, state, .. } = self;
        let constants = &matching.regions.constants;
        if bookkeeper.any_free() {
            bookkeeper.measure(executor, constants, &state.positions, &state.velocities);
        }
        let (components, corrections) = bookkeeper.corrections(&state.books);
        let advance = Advance { constants, components, corrections, dt: world.interval.dt };
        advance.run(executor, &mut state.positions, &mut state.carry, &mut state.velocities);
    }

    /// Contacts of the visible surface. What they do to the momenta is measured, not booked.
    fn touch(&mut self, world: &World) {
        let (Some(contacts), Some(colliders)) = (&mut self.contacts, world.colliders) else { return };
        if world.opens_frame {
            contacts.clear_pushes();
        }
        let mut state = self.state.shared();
        let report = contacts.resolve(&mut state, colliders, world.interval, world.gravity.into());
        if report.contacts > 0 {
            self.state.books.fill(None);
        }
    }

    /// Held vertices go where their pins and handles have them.
    fn hold(&mut self, world: &World) {
        if let Some(kinematics) = &self.kinematics {
            kinematics.apply(world.interval, &mut self.state.shared(), self.matching.layout.slots());
        }
    }
}
