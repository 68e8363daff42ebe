//! The limits of the displayed surface of a body at the bodies that it touches or that are near, and at itself.

use nalgebra::Vector3;

use super::found::Found;
use crate::body::{Body, BodyRef, NearBodies};
use crate::contact::bodies::{BodyView, ContactSurface, GapBody, GapSearch, TouchingBody};
use crate::volume::Limit;

/// Greatest gap in cells to another body that limits the displayed surface.
const GREATEST_GAP: f64 = 1.5;

/// Distance in cells by which a body may have moved since its box was measured.
const BOX_MARGIN: f64 = 1.0;

/// Number of keys of a vertex: one for each dominant axis and sign of the normal of a limit, and six more for soft limits.
const KEYS: u32 = 12;

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
    fn surfaces(self, distance: f64) -> impl Iterator<Item = (BodyView<'a>, &'a ContactSurface)> {
        self.near(distance).filter_map(|other| other.contact_view().zip(other.surface_of_contact()))
    }

    /// Returns whether the parts of the body touch each other.
    fn touches_itself(self) -> bool {
        self.contacts.may_touch(self.index, self.index)
    }

    /// Returns whether another body, or the body itself, may limit its displayed surface.
    pub(super) fn is_any(self) -> bool {
        self.touches_itself() || self.near(GREATEST_GAP).next().is_some()
    }
}

/// Finds the limits of a body for one set of positions, as far as they limit displacements of up to a distance in cells.
/// With them, the displayed surface takes at most half of a gap to another body, and does not move towards a body that it
/// touches.
pub(super) fn find(
    gaps: &mut GapSearch,
    body: BodyRef<'_>,
    near: NearBodies<'_>,
    positions: &[[f32; 3]],
    distance: f64,
    found: &mut Found,
) {
    let Some(surface) = body.get().surface_of_contact() else { return };
    found.begin(KEYS as usize * positions.len());
    let is_in_pieces = body.get().is_in_pieces();
    let mut add = |sample: u32, normal: Vector3<f64>, clearance: f64, is_own: bool| {
        let axis = normal.iamax() as u32;
        let side = axis + if normal[axis as usize] < 0.0 { 3 } else { 0 };
        // Where a body breaks, its pieces overlap. Their volume is more important.
        let is_soft = is_own && is_in_pieces;
        let key = side + if is_soft { KEYS / 2 } else { 0 };
        for vertex in surface.vertices_of(sample) {
            found.add(KEYS * vertex + key, Limit { vertex, normal, clearance, is_soft });
        }
    };
    for touch in body.state().touches.samples() {
        let normal = Vector3::from(touch.normal.map(f64::from));
        add(touch.sample, normal, 0.0, near.index == touch.other);
    }
    let own = GapBody {
        surface,
        lattice: body.get().lattice(),
        positions,
        frame: body.frame(),
        connected_parts_touch: body.get().has_self_contact(),
        touches_itself: near.touches_itself(),
    };
    let distance = distance.min(GREATEST_GAP / 2.0);
    gaps.find(&own, near.surfaces(2.0 * distance), distance, |gap| {
        add(gap.sample, gap.normal, gap.clearance, gap.is_own)
    });
    found.end();
}
