//! The contact stage, and the samples of the surface on which contacts with colliders act.

use nalgebra::Vector3;

use super::soft_body::Body;
use super::surface::Surface;
use crate::contact::{Colliders, Contacts, Pressure, RestSurface, SampleCells};
use crate::dynamics::Quantity;

impl Body {
    /// Creates the contact stage if there are colliders, and removes it if there are none. Narrow colliders need more
    /// samples.
    pub(crate) fn update_contact_stage(&mut self, colliders: &Colliders) {
        if self.contact.colliders_resist_rolling != colliders.resist_rolling() {
            self.contact.colliders_resist_rolling = !self.contact.colliders_resist_rolling;
            self.update_elastic_damping();
        }
        if colliders.is_empty() || self.settings.touching.soft_only {
            self.contact.contacts = None;
            self.state.supports.clear();
            if let Some(damping) = &mut self.pipeline.elastic_damping {
                damping.clear_supports();
            }
            return;
        }
        let spacing = colliders.sample_spacing(self.shape.lattice.cell_size());
        if self.contact.contacts.as_ref().is_none_or(|contacts| contacts.spacing() != spacing) {
            self.contact.contacts = Some(self.create_contacts(spacing));
        }
    }

    /// Creates the contact stage with samples at most `spacing` cells apart.
    pub(super) fn create_contacts(&self, spacing: f64) -> Contacts {
        let thickness = self.settings.touching.thickness;
        let mut contacts = Contacts::within(spacing, self.create_samples(spacing), thickness);
        contacts.set_friction_factors(self.settings.parts.on(&self.shape.lattice, Quantity::Friction));
        contacts
    }

    /// Returns the contacts with colliders of the last step, and the force of each in a step of `dt` seconds: pressure,
    /// friction, and its share of the reaction of the elastic damping.
    pub(crate) fn collider_contacts(&self, dt: f64) -> Vec<(Pressure, Vector3<f64>)> {
        let unit = self.impulse_unit() / dt;
        let components = &self.shape.lattice.components().of_vertex;
        let reactions = self.pipeline.elastic_damping.as_ref().map_or(&[][..], |damper| damper.reactions());
        let pressures = self.contact.contacts.as_ref().map_or(&[][..], Contacts::pressures);
        let with_force = |pressure: &Pressure| {
            let support = (components[pressure.vertex as usize], pressure.collider);
            let of_support =
                reactions.iter().find(|reaction| (reaction.component, reaction.collider) == support);
            let reaction =
                of_support.map_or_else(Vector3::zeros, |reaction| reaction.share(pressure.impulse));
            (*pressure, (pressure.normal * pressure.impulse + pressure.friction + reaction) * unit)
        };
        pressures.iter().map(with_force).collect()
    }

    /// Creates the samples on which contacts act, at most `spacing` cells apart: points of the mesh, or of the boundary
    /// of a bare lattice.
    pub(crate) fn create_samples(&self, spacing: f64) -> SampleCells {
        let (slots, masses) = (self.pipeline.matching.layout.slots(), &self.shape.masses);
        let lattice = &self.shape.lattice;
        if self.surface().is_none() {
            return SampleCells::of_lattice_within(spacing, lattice, slots, masses);
        }
        let samples = SampleCells::of_surface(&self.rest_surface(), spacing, slots, masses);
        match self.smoothing() {
            None => samples,
            Some(_) => samples.smoothed(lattice, slots, masses),
        }
    }

    /// Returns the surface at rest, on which contacts act.
    pub(super) fn rest_surface(&self) -> RestSurface<'_> {
        match self.surface() {
            Some(Surface { mesh, embedding, .. }) => {
                RestSurface::of_mesh(mesh, &self.shape.lattice, embedding)
            }
            None => RestSurface::of_lattice(&self.shape.lattice),
        }
    }
}
