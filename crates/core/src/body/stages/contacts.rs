//! Contacts with colliders, and of bodies with each other.

use super::stage::{BodyStep, Stage, check_owner};
use crate::body::context::StepContext;
use crate::body::parts::{ContactData, Shape};
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::body::transfer::Parents;
use crate::contact::Side;
use crate::contact::bodies::BodyContactPart;
use crate::error::StateError;
use crate::plan::CONTACT_OF_BODIES;

/// Finds the components inside colliders, and stores the velocities before the impacts of the step.
pub(super) struct BeginContacts;

impl Stage for BeginContacts {
    fn name(&self) -> &'static str {
        "begin contacts"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        body.contact.contacts.is_some() || body.contact.body_contact.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.begin_contacts(step.context);
    }

    fn describe(&self, _body: &Body) -> (String, usize) {
        ("stores the velocities before shape matching".to_owned(), 0)
    }
}

/// Applies the impulses at bodies and colliders, of a body that touches another one or itself.
pub(super) struct TouchBodies;

impl Stage for TouchBodies {
    fn name(&self) -> &'static str {
        CONTACT_OF_BODIES
    }

    fn exists(&self, body: &Body) -> bool {
        body.contact.body_contact.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.resolve_body_contacts(step.context, step.part, step.executor);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        match body.planned_body_contact() {
            Some((Some(samples), bytes)) => (format!("{samples} samples"), bytes),
            Some((None, bytes)) => ("no samples before a body is near".to_owned(), bytes),
            None => Default::default(),
        }
    }

    fn follow(&self, body: &mut Body, _parents: &Parents) {
        body.renew_body_contact();
    }

    fn restore(&self, body: &mut Body, _snapshot: &BodySnapshot) {
        if body.contact.body_contact.is_none() {
            body.state.touches.forget_bodies();
        }
        body.measure_contact_bounds();
    }
}

/// Applies the impulses at colliders, of a body that touches no other one, and stores what supports the body.
pub(super) struct TouchColliders;

impl Stage for TouchColliders {
    fn name(&self) -> &'static str {
        "contacts"
    }

    fn exists(&self, body: &Body) -> bool {
        body.contact.contacts.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        // If bodies are near, the contacts were found before.
        if matches!(step.part, BodyContactPart::Alone) {
            body.detect_contacts(step.context);
        }
        if !matches!(step.part, BodyContactPart::InIsland { .. }) {
            body.finish_alone(step.context);
        }
        body.finish_contacts(step.context);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        body.contact.contacts.as_ref().map_or_else(Default::default, |contacts| {
            (format!("{} samples", contacts.samples().count()), contacts.bytes())
        })
    }

    fn follow(&self, body: &mut Body, parents: &Parents) {
        if let Some(before) = body.contact.contacts.take() {
            let mut contacts = body.create_contacts(before.spacing());
            contacts.continue_from(&before, &parents.first, &body.shape.lattice);
            body.contact.contacts = Some(contacts);
        }
    }

    fn save(&self, body: &Body, snapshot: &mut BodySnapshot) {
        if let Some(contacts) = &body.contact.contacts {
            snapshot.displacements = contacts.all_displacements().to_vec();
            snapshot.sides = contacts.sides().to_vec();
        }
    }

    fn check(&self, body: &Body, snapshot: &BodySnapshot, _vertices: usize) -> Result<(), StateError> {
        check_owner(body, "contacts", snapshot.sides.iter().all(Side::is_valid))
    }

    fn restore(&self, body: &mut Body, snapshot: &BodySnapshot) {
        if let Some(contacts) = &mut body.contact.contacts {
            contacts.set_displacements(&snapshot.displacements);
            contacts.clear_pressures();
            contacts.set_sides(&snapshot.sides);
        }
    }
}

impl Body {
    /// Stores the velocities before the impacts of this step.
    pub(in crate::body) fn begin_contacts(&mut self, context: &StepContext) {
        self.begin_body_contact();
        self.begin_rigid_contacts();
        self.begin_escapes(context);
        if let Some(contacts) = &mut self.contact.contacts {
            contacts.begin(&self.state.velocities);
        }
    }

    /// Applies the impulses of contacts with colliders alone, beginning with the impulses of the step before.
    fn finish_alone(&mut self, context: &StepContext) {
        let unit = self.impulse_unit() / context.interval.dt;
        let Self { contact: ContactData { contacts: Some(contacts), .. }, state, .. } = self else { return };
        contacts.begin_with(|key| state.touches.force(key) / unit);
        if self.rigid.is_some() {
            self.finish_alone_rigidly(context);
            return;
        }
        contacts.finish_alone(&mut state.body_state(), context.colliders, context.interval);
    }

    /// Stores the forces of the contacts with colliders after a step of `dt` seconds in which no body was touched.
    pub(in crate::body) fn keep_contact_forces(&mut self, dt: f64) {
        let unit = self.impulse_unit() / dt;
        if self.contact.body_contact.is_some() {
            self.state.touches.clear();
        }
        let pressures = self.contact.contacts.iter().flat_map(|contacts| contacts.pressures());
        self.state.touches.set_forces(pressures.map(|pressure| pressure.force(unit)));
    }

    /// Returns the unit of the impulses of contacts with colliders, in scene units.
    pub(in crate::body) fn impulse_unit(&self) -> f64 {
        self.cell_mass() * self.shape.lattice.cell_size()
    }

    /// Moves components out of colliders in which they began, and finds the contacts with colliders.
    pub(in crate::body) fn detect_contacts(&mut self, context: &StepContext) {
        if self.is_rigid() {
            self.move_out_rigidly();
            self.pass_mobility();
        } else {
            self.move_out();
        }
        let is_asleep = self.is_asleep();
        let Self { contact: ContactData { contacts: Some(contacts), .. }, state, .. } = self else { return };
        if context.is_frame_start && !is_asleep {
            contacts.clear_displacements();
        }
        let (colliders, interval) = (context.colliders, context.interval);
        contacts.detect(&state.body_state(), colliders, interval, context.gravity.into());
    }

    /// Invalidates the momenta of the components that touched colliders, which the next step measures, and stores what
    /// supports the body.
    fn finish_contacts(&mut self, context: &StepContext) {
        let Self {
            contact: ContactData { contacts: Some(contacts), .. },
            shape: Shape { lattice, .. },
            state,
            ..
        } = self
        else {
            return;
        };
        for vertex in contacts.touched() {
            state.invalidate_momentum(lattice, vertex);
        }
        if self.pipeline.elastic_damping.is_some() || context.sleep || self.rigid.is_some() {
            state.supports.set(contacts.pressures().iter().filter(|pressure| pressure.impulse > 0.0).map(
                |pressure| {
                    let component = lattice.components().of_vertex[pressure.vertex as usize];
                    pressure.support_of(component)
                },
            ));
        }
        self.resist_rolling(context);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::contact::Colliders;
    use crate::matching::Workspaces;
    use crate::state::Interval;
    use crate::{Collider, Lattice, Material, Selection, Simulation};

    fn known_momenta(simulation: &Simulation) -> Vec<bool> {
        simulation.body(0).state.momenta.iter().map(Option::is_some).collect()
    }

    #[test]
    fn contacts_and_forces_invalidate_momenta_of_their_components_only() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [4, 0, 0], [8, 0, 0]], 1.0, Point3::origin(), false);
        let mut body = Body::from_lattice(lattice.unwrap()).material(Material::fast_lsm()).build().unwrap();
        body.apply_forces(&[(2, [1.0, 0.0, 0.0])]).unwrap();
        let ball = Collider::sphere([8.5, -1.0, 0.5], 1.5);
        let mut simulation =
            Simulation::builder().body(body).collider(ball).gravity([0.0; 3]).build().unwrap();
        simulation.step();
        assert_eq!(known_momenta(&simulation), [true, false, false]);
        simulation.step();
        assert_eq!(known_momenta(&simulation), [true, true, false]);
        let body = simulation.body_mut(0);
        body.apply_force([1.0; 3], &Selection::Vertices(vec![2])).unwrap();
        let (gravity, interval) = (Vector3::zeros(), Interval::of_step(1, 1.0));
        let colliders = &Colliders::new(&[]).unwrap();
        let workspaces = &Workspaces::default();
        let context = StepContext {
            gravity,
            greatest_gravity: 0.0,
            interval,
            is_frame_start: true,
            colliders,
            sleep: false,
            workspaces,
        };
        body.begin_forces(&[], interval);
        body.apply_external_forces(&context);
        assert_eq!(known_momenta(&simulation), [true, false, false]);
    }
}
