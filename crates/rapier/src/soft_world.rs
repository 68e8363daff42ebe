//! The soft bodies of a Rapier world, and the step of both.

use nalgebra::Vector3;
use rapier3d::dynamics::{MultibodyJointSet, RigidBodyHandle, RigidBodySet};
use rapier3d::geometry::{ColliderSet, InteractionGroups};
use rapier3d::math::Vector;
use rapier3d::pipeline::{EventHandler, PhysicsHooks, PhysicsWorld};
use supple::{Body, Simulation, Substeps};

use crate::convert::wide;
use crate::coupled_bodies::CoupledBodies;
use crate::entries::{Entry, found};
use crate::error::Error;
use crate::obstacles::Obstacles;

/// The soft bodies of a Rapier world.
///
/// [`step`](Self::step) makes one step of the soft bodies and one step of Rapier. Programs that step the parts of
/// Rapier themselves call [`begin_step`](Self::begin_step) before Rapier's step and [`end_step`](Self::end_step) after
/// it.
pub struct SoftWorld {
    simulation: Simulation,
    /// Number of soft bodies, the first bodies of the simulation.
    soft: usize,
    groups: InteractionGroups,
    entries: Vec<Entry>,
    is_mapped: bool,
    obstacles: Obstacles,
    coupled: CoupledBodies,
}

impl SoftWorld {
    /// Takes a simulation of the soft bodies, which may have colliders, fields and links of its own. Its gravity and
    /// its step length become those of Rapier; build it with this step length, for which Young's modulus and the
    /// regions of the bodies are chosen. One of its steps is one step of Rapier, and one frame: the number of its steps
    /// per frame becomes 1. Fields act on the soft bodies alone.
    pub fn new(simulation: Simulation) -> Self {
        Self {
            soft: simulation.bodies().len(),
            groups: InteractionGroups::all(),
            entries: Vec::new(),
            is_mapped: false,
            obstacles: Obstacles::new(&simulation),
            coupled: CoupledBodies::new(&simulation),
            simulation,
        }
    }

    /// Sets the collision groups of all soft bodies; default all. They touch the colliders of Rapier whose groups
    /// interact with these: [`InteractionGroups::test`].
    pub fn set_collision_groups(&mut self, groups: InteractionGroups) {
        self.groups = groups;
        self.is_mapped = false;
    }

    /// Returns the simulation of the soft bodies. Its first bodies are the soft ones; the rigid bodies after them
    /// stand for the dynamic bodies of Rapier that are near.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Returns the simulation, to change settings, forces, pins and fields of the soft bodies, and to drive, enable and
    /// disable its own colliders. Its bodies and colliders must stay the same ones. When a fixed or kinematic collider
    /// of Rapier is inserted, removed or changed, a driven collider stays where it is, and a motion of several steps
    /// ends.
    pub fn simulation_mut(&mut self) -> &mut Simulation {
        &mut self.simulation
    }

    /// Returns the soft bodies, in the order in which they were added.
    pub fn bodies(&self) -> &[Body] {
        &self.simulation.bodies()[..self.soft]
    }

    /// Returns the number of dynamic bodies of Rapier that were near a soft body in the last step. Only these take
    /// time.
    pub fn near_bodies(&self) -> usize {
        self.coupled.near_count()
    }

    /// Returns the impulse of the soft bodies on a dynamic body of Rapier in the last step, and the angular impulse
    /// about its center of mass. Zero if nothing touched it; `None` if it is no dynamic body with colliders.
    pub fn impulse_on(&self, body: RigidBodyHandle) -> Option<(Vector3<f64>, Vector3<f64>)> {
        self.coupled.impulse(body).map(|impulse| (impulse.linear, impulse.angular))
    }

    /// Makes one step of the soft bodies and one of Rapier, with Rapier's step length and gravity.
    ///
    /// # Errors
    ///
    /// As [`begin_step`](Self::begin_step). No step is then made.
    pub fn step(&mut self, world: &mut PhysicsWorld) -> Result<(), Error> {
        self.step_with_events(world, &(), &())
    }

    /// As [`step`](Self::step), with the hooks and the event handler of Rapier.
    ///
    /// # Errors
    ///
    /// As [`begin_step`](Self::begin_step). No step is then made.
    pub fn step_with_events(
        &mut self,
        world: &mut PhysicsWorld,
        hooks: &dyn PhysicsHooks,
        events: &dyn EventHandler,
    ) -> Result<(), Error> {
        let (gravity, dt) = (world.gravity, world.integration_parameters.dt);
        self.begin_step((gravity, dt), &mut world.bodies, &world.colliders, &world.multibody_joints)?;
        world.step_with_events(hooks, events);
        self.end_step(&mut world.bodies);
        Ok(())
    }

    /// Makes one step of the soft bodies with the gravity and the step length that Rapier's next step has, and gives
    /// the impulses of the contacts to the dynamic bodies of Rapier. Bodies and colliders that were inserted, removed
    /// or changed since the last step are followed. Call it just before Rapier's step, and
    /// [`end_step`](Self::end_step) just after it: forces of the user that change between both calls are lost. If the
    /// last step was not ended, its forces are taken back first.
    ///
    /// # Errors
    ///
    /// A collider with a shape that soft bodies cannot touch, or a step length, a gravity or a pose out of range. No
    /// step is then made.
    pub fn begin_step(
        &mut self,
        (gravity, dt): (Vector, f32),
        bodies: &mut RigidBodySet,
        colliders: &ColliderSet,
        multibodies: &MultibodyJointSet,
    ) -> Result<(), Error> {
        self.coupled.restore_forces(bodies);
        let (gravity, step) = (wide(gravity), f64::from(dt));
        // An automatic number would be chosen in the step, and change the step length.
        if self.simulation.has_automatic_substeps() || self.simulation.substeps() != 1 {
            self.simulation.set_substeps(Substeps::Fixed(1))?;
        }
        if self.simulation.dt() != step {
            self.simulation.set_dt(step)?;
        }
        if Vector3::from(self.simulation.gravity()) != gravity {
            self.simulation.set_gravity(<[f64; 3]>::from(gravity))?;
        }
        self.name_bodies_of_fields()?;
        self.follow(bodies, colliders)?;
        self.obstacles.drive(bodies, &mut self.simulation, dt)?;
        self.coupled.update_near(&self.entries, bodies, &mut self.simulation, step)?;
        self.coupled.begin(bodies, &mut self.simulation, (gravity, step))?;
        self.simulation.step();
        self.coupled.apply(bodies, multibodies, &self.simulation, step);
        Ok(())
    }

    /// Ends a step, after Rapier's step: takes back the forces that acted in the step.
    pub fn end_step(&mut self, bodies: &mut RigidBodySet) {
        self.coupled.end(bodies);
    }

    /// Lets fields of all bodies act on the soft ones alone.
    fn name_bodies_of_fields(&mut self) -> Result<(), Error> {
        if self.simulation.fields().iter().any(|field| field.bodies.is_empty()) {
            let mut fields = self.simulation.fields().to_vec();
            let names: Vec<String> = self.bodies().iter().map(|body| body.name().to_owned()).collect();
            for field in fields.iter_mut().filter(|field| field.bodies.is_empty()) {
                field.bodies.clone_from(&names);
            }
            self.simulation.set_fields(fields)?;
        }
        Ok(())
    }

    /// Maps the colliders of Rapier if they are others than in the last step, or if a kinematic body has jumped.
    fn follow(&mut self, bodies: &RigidBodySet, colliders: &ColliderSet) -> Result<(), Error> {
        let has_jumped = self.obstacles.any_jumped(bodies);
        if self.is_mapped && !has_jumped && self.is_as_before(bodies, colliders) {
            return Ok(());
        }
        let entries: Vec<Entry> = found(bodies, colliders, self.groups).map(|found| found.entry()).collect();
        let are_same = |role: fn(&Entry) -> bool| {
            let [old, new] = [&self.entries, &entries].map(|list| list.iter().filter(|entry| role(entry)));
            self.is_mapped
                && old.clone().count() == new.clone().count()
                && old.zip(new).all(|(a, b)| a.is_same(b))
        };
        if has_jumped || !are_same(Entry::is_obstacle) {
            self.is_mapped = false;
            self.obstacles.map(&entries, bodies, &mut self.simulation)?;
        }
        self.coupled.map((&self.entries, &entries), bodies, &mut self.simulation)?;
        self.entries = entries;
        self.is_mapped = true;
        Ok(())
    }

    fn is_as_before(&self, bodies: &RigidBodySet, colliders: &ColliderSet) -> bool {
        let mut entries = self.entries.iter();
        let are_like = found(bodies, colliders, self.groups)
            .all(|found| entries.next().is_some_and(|entry| found.is_like(entry)));
        are_like && entries.next().is_none() && !self.coupled.any_changed(bodies)
    }
}
