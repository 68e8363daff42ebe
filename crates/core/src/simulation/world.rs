//! The simulation and its values.

use nalgebra::Vector3;

use super::clock::Clock;
use super::contact_point::ContactPoint;
use super::groups::{ContactSettings, Groups};
use super::links::{LinkRef, Links};
use super::substeps::ChosenSubsteps;
use crate::body::{Body, BodyRef, DisplayContext, NearBodies};
use crate::contact::Colliders;
use crate::contact::bodies::BodyContacts;
use crate::dynamics::Field;
use crate::matching::Workspaces;
use crate::motion::Curve;
use crate::parallel::Executor;
use crate::plan::Plan;
use crate::state::PairSupports;

/// Simulates bodies that touch each other and colliders.
///
/// Results are bit-identical for any number of threads.
#[derive(Debug)]
pub struct Simulation {
    pub(super) bodies: Vec<Body>,
    /// Gravity in force: that of `gravity_curve` at the current time.
    pub(super) gravity: Vector3<f64>,
    pub(super) gravity_curve: Curve<[f64; 3]>,
    pub(super) clock: Clock,
    pub(super) colliders: Colliders,
    pub(super) fields: Vec<Field>,
    pub(super) links: Links,
    /// The contacts between bodies, if bodies can touch.
    pub(super) contacts: Option<BodyContacts>,
    pub(super) contact: ContactSettings,
    pub(super) pair_supports: PairSupports,
    /// The contacts of a restored state: all until the next step, then those of bodies that have slept since.
    pub(super) restored_contacts: Vec<ContactPoint>,
    pub(super) groups: Groups,
    /// Frames per second, if they were given in place of the step length.
    pub(super) fps: Option<f64>,
    /// Number of steps per frame.
    pub(super) substeps: u64,
    /// The last choice of the number of steps per frame, if it is automatic.
    pub(super) chosen: Option<ChosenSubsteps>,
    /// Whether the next step chooses the number of steps per frame.
    pub(super) choose_at_next_step: bool,
    pub(super) sleep: bool,
    pub(super) workspaces: Workspaces,
    pub(super) executor: Executor,
}

impl Simulation {
    /// Returns the stages of a step and of the evaluation of the displayed surface, with their memory.
    pub fn plan(&self) -> Plan {
        let bodies = self.bodies.iter().map(Body::plan).collect();
        Plan {
            dt: self.dt(),
            substeps: self.substeps,
            threads: self.threads(),
            bodies,
            contact_bytes: self.contacts.as_ref().map(BodyContacts::bytes),
            window_sum_bytes: self.workspaces.bytes(),
        }
    }

    /// Returns the length of a step in seconds.
    pub fn dt(&self) -> f64 {
        self.clock.dt()
    }

    /// Returns the time in seconds. It is computed as the time at which `dt` or the time was last set, plus
    /// the number of steps since then times `dt`, so that rounding does not accumulate.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Returns the number of steps so far.
    pub fn step_count(&self) -> u64 {
        self.clock.steps()
    }

    /// Returns the number of steps per frame. If it is automatic, it may change until the first step, because bodies
    /// can get handles.
    pub fn substeps(&self) -> u64 {
        self.substeps
    }

    /// Returns whether the number of steps per frame is automatic: as it was last set.
    pub fn has_automatic_substeps(&self) -> bool {
        self.chosen.is_some() || self.choose_at_next_step
    }

    /// Returns why the number of steps per frame was chosen, or `None` if it is fixed.
    pub fn chosen_substeps(&self) -> Option<ChosenSubsteps> {
        self.chosen
    }

    /// Returns the number of frames per second, or `None` if the step length was given.
    pub fn fps(&self) -> Option<f64> {
        self.fps
    }

    /// Returns the executor that runs the steps and evaluates displayed surfaces.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// Returns the number of threads.
    pub fn threads(&self) -> usize {
        self.executor.threads()
    }

    /// Returns the number of colliders.
    pub fn collider_count(&self) -> usize {
        self.colliders.len()
    }

    /// Returns the fields, in the order in which they were added.
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// Returns the links, in the order in which they were added, with their forces in the last step: zero after a restored
    /// state.
    pub fn links(&self) -> impl ExactSizeIterator<Item = LinkRef<'_>> {
        self.links.iter()
    }

    /// Returns gravity in force, in scene units per second squared: that at the current time, with which the next step
    /// begins.
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity.into()
    }

    /// Returns gravity at all times, as it was set.
    pub fn gravity_curve(&self) -> &Curve<[f64; 3]> {
        &self.gravity_curve
    }

    /// Returns whether bodies at rest fall asleep.
    pub fn sleep(&self) -> bool {
        self.sleep
    }

    /// Returns whether bodies touch each other, as it was set:
    /// [`SimulationBuilder::contact`](super::SimulationBuilder::contact).
    pub fn contact(&self) -> bool {
        self.contact.between
    }

    /// Returns the default self-contact, for bodies without a setting of their own:
    /// [`SimulationBuilder::self_contact`](super::SimulationBuilder::self_contact).
    pub fn self_contact(&self) -> bool {
        self.contact.with_itself
    }

    /// Returns the bodies, in the order in which they were added. To evaluate the displayed surface of a
    /// body, use [`Simulation::body`].
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the index of the first body with a name; `None` if there is none.
    pub fn body_index(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.name() == name)
    }

    /// Returns the bodies for modification.
    pub fn bodies_mut(&mut self) -> &mut [Body] {
        &mut self.bodies
    }

    /// Returns a reference to a body, with the data of the simulation that evaluating the displayed surface
    /// needs.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a body.
    pub fn body(&self, index: usize) -> BodyRef<'_> {
        let Self { bodies, contacts, colliders, executor, gravity, .. } = self;
        let near = contacts.as_ref().map(|contacts| NearBodies { bodies, index: index as u32, contacts });
        let (time, dt, gravity) = (self.time(), self.dt(), *gravity);
        BodyRef::new(&bodies[index], DisplayContext { colliders, time, dt, gravity, executor, near })
    }

    /// Returns a body for modification.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a body.
    pub fn body_mut(&mut self, index: usize) -> &mut Body {
        &mut self.bodies[index]
    }
}
