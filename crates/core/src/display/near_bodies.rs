//! The bodies of a simulation that are near one of them.

use crate::body::{Body, NearBodies};
use crate::contact::bodies::{BodyView, ContactSurface, TouchingBody};

/// Greatest gap in cells to another body that limits the displayed surface.
pub(super) const GREATEST_GAP: f64 = 1.5;

/// Distance in cells by which a body may have moved since its box was measured.
const BOX_MARGIN: f64 = 1.0;

impl<'a> NearBodies<'a> {
    /// Iterates over the bodies that the body may touch and that may be within a distance of it in cells.
    fn near(self, distance: f64) -> impl Iterator<Item = &'a Body> {
        let own = &self.bodies[self.index as usize];
        let cell_size = own.lattice().cell_size();
        let bounds = own.contact_bounds();
        (0..).zip(self.bodies).filter_map(move |(index, other)| {
            let margin = (distance + BOX_MARGIN) * cell_size + BOX_MARGIN * other.lattice().cell_size();
            let is_near = index != self.index
                && other.contact_bounds()?.intersects(&bounds?.enlarged(margin))
                && self.contacts.may_touch(self.index, index);
            is_near.then_some(other)
        })
    }

    /// As [`near`](Self::near), with the surfaces.
    pub(super) fn surfaces(self, distance: f64) -> impl Iterator<Item = (BodyView<'a>, &'a ContactSurface)> {
        self.near(distance).filter_map(|other| other.contact_view().zip(other.surface_of_contact()))
    }

    /// Returns whether the parts of the body touch each other.
    pub(super) fn touches_itself(self) -> bool {
        self.contacts.may_touch(self.index, self.index)
    }

    /// Returns whether another body, or the body itself, may limit its displayed surface.
    pub(super) fn is_any(self) -> bool {
        self.touches_itself() || self.near(GREATEST_GAP).next().is_some()
    }
}
