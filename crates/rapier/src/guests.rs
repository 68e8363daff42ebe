//! All dynamic bodies of a Rapier world, and which of them are near soft bodies.

use nalgebra::{Point3, Vector3};
use rapier3d::dynamics::{MultibodyJointSet, RigidBodyHandle, RigidBodySet};
use supple::{Body, Simulation};

use crate::convert::Twist;
use crate::entries::{Entry, Role};
use crate::error::Error;
use crate::guest::{Guest, Place};

/// Margin around a soft body within which a dynamic body is near, as a fraction of the diagonal of its bounding box.
const MARGIN: f64 = 0.1;

/// A dynamic body leaves the simulation at this multiple of the margin.
const LEAVING: f64 = 2.0;

/// The dynamic bodies, in the order of their first colliders.
#[derive(Default)]
pub(crate) struct Guests {
    list: Vec<Guest>,
    /// The bounding boxes of the soft bodies in the last step.
    boxes: Vec<(Point3<f64>, Point3<f64>)>,
    /// Number of soft bodies, the first bodies of the simulation.
    soft: usize,
}

impl Guests {
    pub(crate) fn new(simulation: &Simulation) -> Self {
        let boxes = simulation.bodies().iter().map(Body::bounds).collect();
        Self { list: Vec::new(), boxes, soft: simulation.bodies().len() }
    }

    /// Returns the impulse and the angular impulse of the last step on a body.
    pub(crate) fn impulse(&self, handle: RigidBodyHandle) -> Option<Twist> {
        self.list.iter().find(|guest| guest.handle == handle).map(|guest| guest.impulse)
    }

    /// Returns the number of bodies in the simulation.
    pub(crate) fn near_count(&self) -> usize {
        self.list.iter().filter(|guest| matches!(guest.place, Place::Near(_))).count()
    }

    /// Maps the dynamic bodies anew. `before` are the colliders of the last mapping: bodies with the same ones stay.
    pub(crate) fn map(
        &mut self,
        (before, entries): (&[Entry], &[Entry]),
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
    ) -> Result<(), Error> {
        let mut old = std::mem::take(&mut self.list);
        for entry in entries.iter().filter(|entry| entry.role == Role::Dynamic) {
            let Some(handle) = entry.parent else { continue };
            let Some(body) = bodies.get(handle) else { continue };
            if self.list.iter().any(|guest| guest.handle == handle) {
                continue;
            }
            let own = |entries: &'_ [Entry]| entries.iter().filter(|e| e.parent == Some(handle)).count();
            let is_same = own(before) == own(entries)
                && of(before, handle).zip(of(entries, handle)).all(|(a, b)| a.is_same(b));
            let kept =
                old.iter().position(|guest| guest.handle == handle && is_same && guest.has_mass_of(body));
            self.list.push(match kept {
                Some(index) => old.remove(index),
                None => Guest::new(handle, body, of(entries, handle))?,
            });
        }
        // The removed bodies come last, as long as they are in the simulation.
        let kept = self.list.len();
        self.list.append(&mut old);
        for index in kept..self.list.len() {
            self.remove(index, simulation)?;
        }
        self.list.truncate(kept);
        Ok(())
    }

    /// Returns whether the mass of a body is another one than when it was mapped.
    pub(crate) fn any_mass_changed(&self, bodies: &RigidBodySet) -> bool {
        let changed = |guest: &Guest| bodies.get(guest.handle).is_some_and(|body| !guest.has_mass_of(body));
        self.list.iter().any(changed)
    }

    /// Takes a rigid body out of the simulation.
    fn remove(&mut self, guest: usize, simulation: &mut Simulation) -> Result<(), Error> {
        let guest = &mut self.list[guest];
        let Place::Near(index) = guest.place else { return Ok(()) };
        let body = simulation.remove_body(index)?;
        guest.place = Place::Away(Some(Box::new(body)));
        guest.leave();
        for other in &mut self.list {
            if let Place::Near(other) = &mut other.place {
                *other -= usize::from(*other > index);
            }
        }
        Ok(())
    }

    /// Adds the rigid bodies that come near a soft body in the next step of `dt` seconds, and removes those that are
    /// away.
    pub(crate) fn update_near(
        &mut self,
        entries: &[Entry],
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
        dt: f64,
    ) -> Result<(), Error> {
        for (soft, past) in simulation.bodies()[..self.soft].iter().zip(&mut self.boxes) {
            let (low, high) = soft.bounds();
            // In the next step the box moves as in the last one, within a factor of 2.
            let (down, up) = ((low - past.0) * 2.0, (high - past.1) * 2.0);
            *past = (low + down.inf(&Vector3::zeros()), high + up.sup(&Vector3::zeros()));
        }
        for index in 0..self.list.len() {
            let guest = &self.list[index];
            let Some(body) = bodies.get(guest.handle) else { continue };
            let (center, radius) = guest.ball(body, dt);
            let is_near = matches!(guest.place, Place::Near(_));
            let factor = if is_near { LEAVING } else { 1.0 };
            let reaches = |(low, high): &(Point3<f64>, Point3<f64>)| {
                let outside = (low.coords - center).sup(&(center - high.coords)).sup(&Vector3::zeros());
                outside.norm() <= radius + factor * MARGIN * (high - low).norm()
            };
            match (self.boxes.iter().any(reaches), is_near) {
                (true, false) => {
                    let guest = &mut self.list[index];
                    let soft = match std::mem::replace(&mut guest.place, Place::Away(None)) {
                        Place::Away(Some(body)) => *body,
                        _ => guest.create(body, of(entries, guest.handle))?,
                    };
                    guest.place = Place::Near(simulation.add_body(soft));
                }
                (false, true) => {
                    self.remove(index, simulation)?;
                }
                _ => {}
            }
        }
        for (soft, past) in simulation.bodies()[..self.soft].iter().zip(&mut self.boxes) {
            *past = soft.bounds();
        }
        Ok(())
    }

    /// Gives the near rigid bodies the motions of their Rapier bodies before a step of `dt` seconds.
    pub(crate) fn begin(
        &mut self,
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
        (gravity, dt): (Vector3<f64>, f64),
    ) -> Result<(), Error> {
        for guest in &mut self.list {
            if let (&Place::Near(index), Some(body)) = (&guest.place, bodies.get(guest.handle)) {
                guest.begin(body, simulation.body_mut(index), (gravity, dt))?;
            }
        }
        Ok(())
    }

    /// Gives the Rapier bodies the impulses of a step of `dt` seconds.
    pub(crate) fn apply(
        &mut self,
        bodies: &mut RigidBodySet,
        multibodies: &MultibodyJointSet,
        simulation: &Simulation,
        dt: f64,
    ) {
        for guest in &mut self.list {
            if let (&Place::Near(index), Some(body)) = (&guest.place, bodies.get_mut(guest.handle)) {
                let is_link = multibodies.rigid_body_link(guest.handle).is_some();
                guest.apply(body, &simulation.bodies()[index], (is_link, dt));
            }
        }
    }

    /// Ends a step, after that of Rapier.
    pub(crate) fn end(&mut self, bodies: &mut RigidBodySet) {
        for guest in self.list.iter_mut().filter(|guest| matches!(guest.place, Place::Near(_))) {
            if let Some(body) = bodies.get_mut(guest.handle) {
                guest.end(body);
            }
        }
    }
}

/// Returns the entries of the colliders of a body.
fn of(entries: &[Entry], body: RigidBodyHandle) -> impl Iterator<Item = &Entry> {
    entries.iter().filter(move |entry| entry.parent == Some(body))
}
