//! Contact of the body with other bodies, and with itself: settings, data, and what the search for contacts needs.

use super::context::StepContext;
use super::parts::{ContactData, Pipeline, Shape};
use super::soft_body::Body;
use super::touching::TouchingOptions;
use crate::contact::bodies::{
    BodyContact, BodyView, Bounds, ContactSurface, PartVertices, SEARCH_DISTANCE, SurfaceProperties,
    TouchingBody,
};
use crate::contact::{Contacts, Parts};
use crate::dynamics::{Constraints, CoupledComponent, Damping, Quantity, RigidBody};
use crate::state::{SearchedMotion, State, Touches};

/// Coefficient of rolling resistance of a body of the damping ratio 1.
const ROLLING_RESISTANCE: f64 = 0.08;

impl Body {
    /// Returns the coefficient of rolling resistance on colliders: see [`TouchingOptions::rolling_resistance`].
    pub fn rolling_resistance(&self) -> f64 {
        self.settings.touching.rolling_resistance.unwrap_or(match self.settings.material.damping() {
            Damping::Ratio(ratio) => ROLLING_RESISTANCE * ratio,
            Damping::Rate(0.0) => 0.0,
            // For the damping ratio 0.2.
            Damping::Rate(_) => 0.2 * ROLLING_RESISTANCE,
        })
    }

    /// Returns how the body touches other bodies.
    pub fn touching(&self) -> &TouchingOptions {
        &self.settings.touching
    }

    /// Returns the bodies that the body touched in the last step: pairs of connected component and body.
    pub(crate) fn touches(&self) -> &[(u32, u32)] {
        self.state.touches.bodies()
    }

    /// Sets whether a part of the body touches itself, and forgets the touches: those of another simulation would name
    /// other bodies.
    pub(crate) fn set_self_contact(&mut self, with_itself: bool) {
        self.settings.has_self_contact = with_itself;
        self.state.touches = Touches::default();
    }

    /// Creates or removes the data of contact with bodies if it is missing or not needed any more.
    pub(crate) fn update_body_contact(&mut self, enabled: bool) {
        if self.contact.body_contact.is_some() != enabled {
            self.state.touches = Touches::default();
            self.contact.body_contact = enabled.then(BodyContact::new);
            self.measure_contact_bounds();
        }
    }

    /// Creates the data of contact with bodies again: the surface of the body changed.
    pub(super) fn renew_body_contact(&mut self) {
        if self.contact.body_contact.take().is_some() {
            self.contact.body_contact = Some(BodyContact::new());
            self.measure_contact_bounds();
        }
    }

    /// Forgets the contacts, and wakes up: the body is in no simulation, or in another one.
    pub(crate) fn leave_simulation(&mut self) {
        self.state.touches.forget_bodies();
        self.state.touches.forget_forces();
        self.state.supports.clear();
        self.contact.contacts.iter_mut().for_each(Contacts::clear_pressures);
        self.wake();
    }

    /// Follows the removal of another body of the simulation.
    pub(crate) fn follow_removal(&mut self, removed: u32) {
        if self.state.touches.remove_body(removed) {
            self.wake();
        }
    }

    /// Lets the contacts of the next step begin without impulses: the colliders are others.
    pub(crate) fn forget_contact_forces(&mut self) {
        self.state.touches.forget_forces();
    }

    /// Creates the surface for contact with bodies, if it does not exist. A body whose surface has no area touches no
    /// bodies.
    pub(crate) fn create_contact_surface(&mut self) {
        if self.contact.body_contact.is_some() && self.surface_of_contact().is_none() {
            self.contact.body_contact = None;
            self.state.touches = Touches::default();
        }
    }

    /// Stores the velocities before the step, for contact with bodies.
    pub(super) fn begin_body_contact(&mut self) {
        self.read_motion(BodyContact::begin);
    }

    /// Measures the boxes of the positions and velocities, by which near bodies are found.
    pub(crate) fn measure_contact_bounds(&mut self) {
        self.read_motion(BodyContact::measure_bounds);
    }

    /// Lets the contact with bodies, if there is one, read the state of the body and of its parts.
    fn read_motion(&mut self, read: impl FnOnce(&mut BodyContact, &State, &PartVertices<'_>)) {
        let Self {
            contact: ContactData { body_contact: Some(contact), .. },
            shape: Shape { lattice, .. },
            pipeline: Pipeline { matching, .. },
            state,
            ..
        } = self
        else {
            return;
        };
        let (slots, occupied) = (matching.layout.slots(), matching.layout.occupied());
        read(contact, state, &PartVertices { parts: Parts::new(lattice), slots, occupied });
    }

    /// Returns the surface for contact with bodies, which is created if it does not exist; `None` if the body can touch
    /// none.
    pub(crate) fn surface_of_contact(&self) -> Option<&ContactSurface> {
        self.contact.body_contact.as_ref()?.surface_or(|| ContactSurface::new(self.rest_surface()))
    }

    /// Returns the box in which the body has been since it was measured last; `None` if the body can touch none.
    pub(crate) fn contact_bounds(&self) -> Option<Bounds> {
        self.contact.body_contact.as_ref().map(BodyContact::bounds)
    }

    /// Returns the number of samples of the surface at which the body touches other bodies or itself, or `None` if it
    /// can touch none. A simulation creates the samples when another body is near for the first time; before, this
    /// function creates them each time.
    pub fn contact_samples(&self) -> Option<usize> {
        let contact = self.contact.body_contact.as_ref()?;
        match contact.created_surface() {
            Some(surface) => Some(surface.sample_count()),
            None => ContactSurface::new(self.rest_surface()).map(|surface| surface.sample_count()),
        }
    }

    /// Returns the samples and the memory in bytes of contact with bodies, or `None` if the body can touch none. There
    /// are no samples before another body is near.
    pub(super) fn planned_body_contact(&self) -> Option<(Option<usize>, usize)> {
        let samples = |contact: &BodyContact| contact.created_surface().map(ContactSurface::sample_count);
        self.contact.body_contact.as_ref().map(|contact| (samples(contact), contact.bytes()))
    }

    /// Returns the reference motion of a connected component for the coupling of the damping of bodies that press on
    /// each other, or `None` if the body is not damped. `index`: of the body.
    pub(crate) fn coupled_component(&self, index: u32, component: u32) -> Option<CoupledComponent> {
        let is_valid = !self.is_asleep() && (component as usize) < self.shape.lattice.components().count;
        let damping = self.pipeline.elastic_damping.as_ref().filter(|_| is_valid)?;
        let sizes = (self.size(), self.cell_mass(), self.contact_layers());
        damping.coupled((index, component), (&self.state, &self.pipeline.momentum), sizes)
    }

    /// Returns the number of layers of vertices from the surface to the middle of a region.
    pub(in crate::body) fn contact_layers(&self) -> f64 {
        self.half_width().cells() + 0.5
    }

    /// Changes the reference motion of the damping by a coupling.
    pub(crate) fn add_coupling(&mut self, component: &CoupledComponent) {
        let sizes = (self.cell_mass(), self.shape.lattice.cell_size());
        if let Some(damping) = &mut self.pipeline.elastic_damping {
            damping.add_change(component, &self.pipeline.momentum, sizes);
        }
    }

    /// Prepares the body for the search of contacts with bodies: finds the contacts with colliders. `is_alone`: only
    /// the body itself is near.
    pub(crate) fn prepare_body_contact(&mut self, context: &StepContext, is_alone: bool) {
        self.create_contact_surface();
        if self.is_asleep() {
            self.begin_contacts(context);
            if let Some(contacts) = &mut self.contact.contacts {
                contacts.keep_pressures();
            }
        }
        // Pins and handles move the body, so the velocities at its contacts follow from their motion.
        if self.is_rigid() {
            self.read_held(context.interval);
            self.hold_rigidly();
        } else {
            self.apply_constraints(context);
        }
        self.detect_contacts(context);
        let is_asleep = self.is_asleep();
        let Self {
            pipeline: Pipeline { matching, .. },
            contact: ContactData { body_contact, .. },
            state,
            ..
        } = self;
        if let Some(contact) = body_contact {
            let occupied = matching.layout.occupied();
            let mut motion = || state.searched_motion(occupied, SEARCH_DISTANCE, is_alone);
            contact.searched = if is_asleep { SearchedMotion::UNKNOWN } else { motion() };
        }
    }
}

impl TouchingBody for Body {
    fn contact_view(&self) -> Option<BodyView<'_>> {
        Some(BodyView {
            lattice: &self.shape.lattice,
            slots: self.pipeline.matching.layout.slots(),
            masses: &self.shape.masses,
            cell_mass: self.cell_mass(),
            constrained: Constraints::constrained_by(self.constraints.as_ref()),
            touches_itself: self.settings.has_self_contact,
            state: &self.state,
            contact: self.contact.body_contact.as_ref()?,
            properties: SurfaceProperties {
                friction: self.settings.touching.friction,
                restitution: self.settings.touching.restitution,
                thickness: self.settings.touching.thickness,
            },
            friction_factors: self.settings.parts.of(Quantity::Friction),
            contacts: self.contact.contacts.as_ref(),
            rigid: self.rigid.as_deref().map(RigidBody::mobility),
        })
    }

    fn list_near_cells(&mut self) {
        let Some(contact) = &mut self.contact.body_contact else { return };
        let mut cells = std::mem::take(&mut contact.near_cells);
        if let Some(view) = self.contact_view() {
            view.list_near_cells(&mut cells, self.pipeline.matching.layout.occupied());
        }
        if let Some(contact) = &mut self.contact.body_contact {
            contact.near_cells = cells;
        }
    }

    fn is_asleep(&self) -> bool {
        self.state.rest.is_asleep
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use crate::{Body, Collider, Lattice, Simulation};

    /// Both halves of a cut block press on a plate at the cut, at the same point of the grid.
    #[test]
    fn forces_of_contacts_of_pieces_have_keys_of_their_own() {
        let block = |size: [i32; 3]| {
            let [x, y, z] = size;
            let cells: Vec<_> = (0..x * y * z).map(|k| [k % x, k / x % y, k / (x * y)]).collect();
            Body::from_lattice(Lattice::from_cells(&cells, 0.25, Point3::origin(), false).unwrap())
        };
        let plate = block([8, 2, 8]).build().unwrap();
        let mut upper = block([4, 4, 4]).translate([0.5, 0.5, 0.5]).build().unwrap();
        upper.cut([1.0; 3], [1.0, 0.0, 0.0]).unwrap();
        assert_eq!(upper.pieces(), 2);
        let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let builder = Simulation::builder().body(plate).body(upper).collider(ground).dt(0.01);
        let mut simulation = builder.build().unwrap();
        simulation.steps(30);
        let keys: Vec<_> = simulation.body(1).state.touches.keys().collect();
        assert!(keys.len() > 20, "{}", keys.len());
        assert!(keys.is_sorted_by(|a, b| a < b), "{keys:?}");
    }
}
