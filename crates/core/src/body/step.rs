//! One step of a body: the page that reads like the papers.

use nalgebra::Vector3;

use super::{Body, unlocked};
use crate::dynamics::Kinematics;
use crate::dynamics::energy::EnergyGuard;
use crate::dynamics::integrate::Advance;
use crate::parallel::{CHUNK, Executor};
use crate::state::Interval;

/// What acts on all bodies in a step.
pub(crate) struct World {
    /// Scene units per second squared.
    pub(crate) gravity: Vector3<f64>,
    pub(crate) interval: Interval,
    /// Whether this is the first step of a frame.
    pub(crate) opens_frame: bool,
}

impl Body {
    /// Whether a step cannot be shared out among threads.
    pub(crate) fn is_one_task(&self) -> bool {
        self.matching.layout.blocks() <= CHUNK
    }

    /// One step: forces, damping, goal positions, integration, contacts, pins and handles.
    pub(crate) fn step(&mut self, world: &World, executor: &Executor) {
        self.begin_holds(world);
        self.pull(world.interval.dt, world.opens_frame);
        self.open_books(executor);
        let gain = self.fall(world);
        self.damp(world, executor);
        if let Some(contacts) = &mut self.contacts {
            contacts.begin(&self.state.velocities);
        }
        self.match_shape(world, gain, executor);
        self.advance(world, executor);
        self.touch(world);
        self.hold(world);
        self.surroundings.time = world.interval.end;
    }

    /// Pins and handles that begin now capture what they hold.
    fn begin_holds(&mut self, world: &World) {
        let Self { kinematics, matching, state, .. } = self;
        let Some(kinematics) = kinematics else { return };
        if kinematics.begin(world.interval, &state.shared(), matching.layout.slots()) {
            self.book_holds();
        }
    }

    /// Whether nothing holds the body and nothing can touch it.
    fn flies(&self) -> bool {
        self.contacts.is_none() && !self.kinematics.as_ref().is_some_and(Kinematics::holds_any)
    }

    /// Measures the momenta that no book has, and keeps the origin with the body: near it, and flying with it.
    fn open_books(&mut self, executor: &Executor) {
        let flies = self.flies();
        let Self { matching, bookkeeper, state, .. } = self;
        let slots = matching.layout.slots();
        if !flies {
            state.set_origin_velocity(slots, Vector3::zeros());
        }
        if !flies || state.books.contains(&None) {
            state.energy = None;
        }
        let (strayed, to_open) = (state.strayed(slots[0]), bookkeeper.any_to_open(&state.books));
        if !strayed && !to_open {
            return;
        }
        let shares = &matching.regions.shares;
        let bounds = unlocked(&mut self.cascade).bounds();
        bookkeeper.measure(executor, bounds, shares, &state.positions, &state.velocities);
        if strayed {
            state.rebase(slots, bookkeeper.centre());
        }
        if to_open && flies {
            state.set_origin_velocity(slots, state.frame.velocity() + bookkeeper.velocity());
            bookkeeper.measure(executor, bounds, shares, &state.positions, &state.velocities);
        }
        bookkeeper.open(&mut state.books);
    }

    /// Gravity: the origin of a body that flies falls as a whole. Returns what the vertices gain beside it, in
    /// cells/s.
    fn fall(&mut self, world: &World) -> Vector3<f64> {
        let dt = world.interval.dt;
        let gain = world.gravity * (dt / self.lattice.cell_size());
        if !self.flies() {
            return gain;
        }
        self.state.frame.fly(gain, dt);
        Vector3::zeros()
    }

    /// Region damping, where the material has any: of the velocities that contacts, pins and handles left. After the
    /// matching, held vertices would hand on the pull that they do not follow.
    fn damp(&mut self, world: &World, executor: &Executor) {
        let Some(damping) = &self.damping else { return };
        let (state, cascade) = (&mut self.state, unlocked(&mut self.cascade));
        if !state.fitted {
            self.matching.fit(cascade, executor, &state.positions, &mut state.rotations);
        }
        let share = self.material.damping_share(world.interval.dt);
        damping.apply(&self.matching, cascade, executor, state, share as f32);
    }

    /// Goal positions by shape matching, and the velocities that they and `gain` give.
    ///
    /// Near two best rotations of a region the body is held to its energy: then the sums are made twice.
    fn match_shape(&mut self, world: &World, gain: Vector3<f64>, executor: &Executor) {
        let flies = self.flies();
        let Self { matching, bookkeeper, state, energy, .. } = self;
        let cascade = unlocked(&mut self.cascade);
        let dt = world.interval.dt;
        let pull = self.material.alpha(dt) / dt;
        let unsettled = matching.fit(cascade, executor, &state.positions, &mut state.rotations);
        self.unsettled += unsettled;
        state.fitted = true;
        let guard =
            (flies && unsettled > 0).then(|| energy.get_or_insert_with(|| EnergyGuard::new(matching)));
        if let Some(guard) = &guard {
            let (positions, rotations) = (&state.positions, &mut state.rotations);
            matching.fit_summing(cascade, executor, positions, rotations, Some(guard.matched()));
        }
        let guard = guard.map(|guard| {
            guard.begin(&state.velocities);
            &*guard
        });
        let drift = gain.map(|g| g as f32).into();
        matching.accelerate(cascade, executor, state, (pull as f32, drift), bookkeeper);
        if let Some(guard) = guard {
            guard.hold((pull, dt), &matching.regions.shares, state, bookkeeper);
        }
        bookkeeper.enter(&mut state.books, gain);
    }

    /// Velocities corrected to the books, positions moved.
    fn advance(&mut self, world: &World, executor: &Executor) {
        let Self { matching, bookkeeper, state, .. } = self;
        let occupied = matching.layout.occupied();
        let (components, corrections) = bookkeeper.corrections(&state.books);
        let advance = Advance { occupied, components, corrections, dt: world.interval.dt };
        advance.run(executor, &mut state.positions, &mut state.carry, &mut state.velocities);
    }

    /// Contacts of the visible surface. What they do to the momenta is measured, not booked.
    fn touch(&mut self, world: &World) {
        let Some(contacts) = &mut self.contacts else { return };
        if world.opens_frame {
            contacts.clear_pushes();
        }
        let mut state = self.state.shared();
        contacts.resolve(&mut state, &self.surroundings.colliders, world.interval, world.gravity.into());
        for vertex in contacts.touched() {
            self.state.shut_book(&self.lattice, vertex);
        }
    }

    /// Held vertices go where their pins and handles have them.
    fn hold(&mut self, world: &World) {
        if let Some(kinematics) = &self.kinematics {
            kinematics.apply(world.interval, &mut self.state.shared(), self.matching.layout.slots());
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use crate::{Body, Collider, Lattice, Selection, Simulation};

    #[test]
    fn only_the_books_of_what_is_touched_or_pulled_are_shut() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [4, 0, 0], [8, 0, 0]], 1.0, Point3::origin(), false);
        let mut body = Body::from_lattice(lattice.unwrap()).build().unwrap();
        body.apply_forces(&[(2, [1.0, 0.0, 0.0])]).unwrap();
        let ball = Collider::sphere([8.5, -1.0, 0.5], 1.5);
        let mut simulation =
            Simulation::builder().body(body).collider(ball).gravity([0.0; 3]).build().unwrap();
        simulation.step();
        let open = |simulation: &Simulation| {
            simulation.body(0).state.books.iter().map(Option::is_some).collect::<Vec<_>>()
        };
        assert_eq!(open(&simulation), [true, true, false]);
        let body = simulation.body_mut(0);
        body.apply_force([1.0; 3], &Selection::Vertices(vec![2])).unwrap();
        body.pull(1.0, true);
        assert_eq!(open(&simulation), [true, false, false]);
    }
}
