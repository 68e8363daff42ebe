//! All dynamic bodies of a Rapier world, and which of them are near soft bodies.

use nalgebra::{Point3, Vector3};
use rapier3d::dynamics::{MultibodyJointSet, RigidBodyHandle, RigidBodySet};
use supple::{Body, Simulation};

use crate::convert::Twist;
use crate::coupled_body::{CoupledBody, Place};
use crate::entries::{Entry, Role};
use crate::error::Error;

/// Margin around a soft body within which a dynamic body is near, as a fraction of the diagonal of its bounding box.
const MARGIN: f64 = 0.1;

/// A dynamic body leaves the simulation at this multiple of the margin.
const LEAVING: f64 = 2.0;

/// The dynamic bodies, in the order of their first colliders.
#[derive(Default)]
pub(crate) struct CoupledBodies {
    list: Vec<CoupledBody>,
    /// The bounds of the soft bodies in the last step.
    boxes: Vec<(Point3<f64>, Point3<f64>)>,
    /// Number of soft bodies, the first bodies of the simulation.
    soft: usize,
}

impl CoupledBodies {
    pub(crate) fn new(simulation: &Simulation) -> Self {
        let boxes = simulation.bodies().iter().map(bounds).collect();
        Self { list: Vec::new(), boxes, soft: simulation.bodies().len() }
    }

    /// Returns the impulse and the angular impulse of the last step on a body.
    pub(crate) fn impulse(&self, handle: RigidBodyHandle) -> Option<Twist> {
        self.list.iter().find(|coupled| coupled.handle == handle).map(|coupled| coupled.impulse)
    }

    /// Returns the number of bodies in the simulation.
    pub(crate) fn near_count(&self) -> usize {
        self.list.iter().filter(|coupled| matches!(coupled.place, Place::Near(_))).count()
    }

    /// Maps the dynamic bodies anew. `before` are the colliders of the last mapping: bodies with the same ones stay.
    pub(crate) fn map(
        &mut self,
        (before, entries): (&[Entry], &[Entry]),
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
    ) -> Result<(), Error> {
        // All new bodies are built before the list changes: an error leaves it as it was. `None`: a body that stays.
        let mut mapped: Vec<(RigidBodyHandle, Option<CoupledBody>)> = Vec::new();
        for entry in entries.iter().filter(|entry| entry.role == Role::Dynamic) {
            let Some(handle) = entry.parent else { continue };
            let Some(body) = bodies.get(handle) else { continue };
            if mapped.iter().any(|(other, _)| *other == handle) {
                continue;
            }
            let own = |entries: &'_ [Entry]| entries.iter().filter(|e| e.parent == Some(handle)).count();
            let is_same = own(before) == own(entries)
                && of(before, handle).zip(of(entries, handle)).all(|(a, b)| a.is_same(b));
            let stays = |coupled: &CoupledBody| coupled.handle == handle && is_same && coupled.is_like(body);
            let new = match self.list.iter().any(stays) {
                true => None,
                false => Some(CoupledBody::new(handle, body, of(entries, handle))?),
            };
            mapped.push((handle, new));
        }
        let mut old = std::mem::take(&mut self.list);
        self.list.extend(mapped.into_iter().filter_map(|(handle, new)| {
            new.or_else(|| Some(old.remove(old.iter().position(|coupled| coupled.handle == handle)?)))
        }));
        // The removed bodies come last, as long as they are in the simulation.
        let kept = self.list.len();
        self.list.append(&mut old);
        for index in kept..self.list.len() {
            self.remove(index, simulation)?;
        }
        self.list.truncate(kept);
        Ok(())
    }

    /// Returns whether the mass or the locked axes of a body are others than when it was mapped.
    pub(crate) fn any_changed(&self, bodies: &RigidBodySet) -> bool {
        let changed =
            |coupled: &CoupledBody| bodies.get(coupled.handle).is_some_and(|body| !coupled.is_like(body));
        self.list.iter().any(changed)
    }

    /// Takes a rigid body out of the simulation.
    fn remove(&mut self, coupled: usize, simulation: &mut Simulation) -> Result<(), Error> {
        let coupled = &mut self.list[coupled];
        let Place::Near(index) = coupled.place else { return Ok(()) };
        let body = simulation.remove_body(index)?;
        coupled.place = Place::Away(Some(Box::new(body)));
        coupled.leave();
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
            let (low, high) = bounds(soft);
            // In the next step the box moves as in the last one, within a factor of 2.
            let (down, up) = ((low - past.0) * 2.0, (high - past.1) * 2.0);
            *past = (low + down.inf(&Vector3::zeros()), high + up.sup(&Vector3::zeros()));
        }
        for index in 0..self.list.len() {
            let coupled = &self.list[index];
            let Some(body) = bodies.get(coupled.handle) else { continue };
            let (center, radius) = coupled.ball(body, dt);
            let is_near = matches!(coupled.place, Place::Near(_));
            let factor = if is_near { LEAVING } else { 1.0 };
            let reaches = |(low, high): &(Point3<f64>, Point3<f64>)| {
                let outside = (low.coords - center).sup(&(center - high.coords)).sup(&Vector3::zeros());
                outside.norm() <= radius + factor * MARGIN * (high - low).norm()
            };
            match (self.boxes.iter().any(reaches), is_near) {
                (true, false) => {
                    let coupled = &mut self.list[index];
                    let soft = match std::mem::replace(&mut coupled.place, Place::Away(None)) {
                        Place::Away(Some(body)) => *body,
                        _ => coupled.create(body, of(entries, coupled.handle))?,
                    };
                    coupled.place = Place::Near(simulation.add_body(soft));
                }
                (false, true) => {
                    self.remove(index, simulation)?;
                }
                _ => {}
            }
        }
        for (soft, past) in simulation.bodies()[..self.soft].iter().zip(&mut self.boxes) {
            *past = bounds(soft);
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
        for coupled in &mut self.list {
            if let (&Place::Near(index), Some(body)) = (&coupled.place, bodies.get(coupled.handle)) {
                coupled.begin(body, simulation.body_mut(index), (gravity, dt))?;
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
        for coupled in &mut self.list {
            if let (&Place::Near(index), Some(body)) = (&coupled.place, bodies.get_mut(coupled.handle)) {
                let is_link = multibodies.rigid_body_link(coupled.handle).is_some();
                coupled.apply(body, &simulation.bodies()[index], (is_link, dt));
            }
        }
    }

    /// Takes back the forces of a step that was not ended.
    pub(crate) fn restore_forces(&mut self, bodies: &mut RigidBodySet) {
        for coupled in self.list.iter_mut().filter(|coupled| coupled.has_forces()) {
            if let Some(body) = bodies.get_mut(coupled.handle) {
                coupled.restore_forces(body);
            }
        }
    }

    /// Ends a step, after that of Rapier.
    pub(crate) fn end(&mut self, bodies: &mut RigidBodySet) {
        for coupled in self.list.iter_mut().filter(|coupled| matches!(coupled.place, Place::Near(_))) {
            if let Some(body) = bodies.get_mut(coupled.handle) {
                coupled.end(body);
            }
        }
    }
}

/// Returns the box in which a soft body touches: its bounding box, and its thickness around it.
fn bounds(soft: &Body) -> (Point3<f64>, Point3<f64>) {
    let (low, high) = soft.bounds();
    let thickness = Vector3::repeat(soft.touching().thickness);
    (low - thickness, high + thickness)
}

/// Returns the entries of the colliders of a body.
fn of(entries: &[Entry], body: RigidBodyHandle) -> impl Iterator<Item = &Entry> {
    entries.iter().filter(move |entry| entry.parent == Some(body))
}
