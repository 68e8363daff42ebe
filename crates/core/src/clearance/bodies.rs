//! The limits of the displayed surface of a body at the bodies that it touches or that are near, and at itself.

use nalgebra::Vector3;

use super::found::Found;
use crate::body::{Body, BodyRef, NearBodies};
use crate::contact::bodies::{BodyView, ContactSurface, Gap, GapSearch, SIDES, TouchingBody, side};
use crate::simd::vector::wide;
use crate::volume::Limit;

/// Distance in cells by which a body may have moved since its box was measured.
const BOX_MARGIN: f64 = 1.0;

/// Number of keys of a vertex: one for each side of the normal of a limit, and as many for soft limits.
const KEYS: usize = 2 * SIDES;

impl<'a> NearBodies<'a> {
    /// Iterates over the bodies that the body may touch and that may be within a distance of it in cells.
    fn near(self, distance: f64) -> impl Iterator<Item = &'a Body> {
        let own = &self.bodies[self.index as usize];
        let cell_size = own.lattice().cell_size();
        let bounds = own.contact_bounds();
        (0..).zip(self.bodies).filter_map(move |(index, other)| {
            let layers = own.touching().thickness + other.touching().thickness;
            let margin =
                (distance + BOX_MARGIN) * cell_size + BOX_MARGIN * other.lattice().cell_size() + layers;
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

    /// Returns whether another body, or the body itself, may limit its displayed surface, which moves less than the size
    /// of the body.
    pub(super) fn is_any(self) -> bool {
        let own = &self.bodies[self.index as usize];
        let size = own.contact_bounds().map_or(0.0, |bounds| bounds.longest_side());
        self.touches_itself() || self.near(2.0 * size / own.lattice().cell_size()).next().is_some()
    }
}

/// Finds the limits of a body, as far as they limit displacements from `start` of up to `reach` in cells, both with one entry
/// per lattice vertex. With them, the displayed surface takes at most half of a gap between the bodies of the dynamics, and
/// does not move towards a body that it touches.
pub(super) fn find(
    gaps: &mut GapSearch,
    body: BodyRef<'_>,
    near: NearBodies<'_>,
    (start, reach): (&[[f32; 3]], &[f32]),
    found: &mut Found,
) {
    let (state, slots) = (body.state(), body.get().matching().layout.slots());
    let is_in_pieces = body.get().is_in_pieces();
    // Clearances are measured from the positions of the dynamics, from which the start differs in a tangled frame.
    let moved = |vertex: u32| {
        let (from, to) = (state.positions.get(slots[vertex as usize]), start[vertex as usize]);
        Vector3::from_fn(|k, _| f64::from(to[k] - from[k]))
    };
    let distance = |vertex: u32| f64::from(reach[vertex as usize]) + moved(vertex).norm();
    let farthest = (0..start.len() as u32).map(distance).fold(0.0, f64::max);
    if !near.touches_itself() && near.near(2.0 * farthest).next().is_none() {
        return;
    }
    let (Some(surface), Some(view)) = (body.get().surface_of_contact(), body.get().contact_view()) else {
        return;
    };
    found.begin(KEYS * start.len());
    let mut add = |Gap { sample, normal, clearance, is_own }: Gap| {
        // Where a body breaks, its pieces overlap. Their volume is more important.
        let is_soft = is_own && is_in_pieces;
        let key = side(&normal) + if is_soft { SIDES } else { 0 };
        for vertex in surface.vertices_of(sample) {
            let clearance = clearance + normal.dot(&moved(vertex));
            found.add(KEYS as u32 * vertex + key as u32, Limit { vertex, normal, clearance, is_soft });
        }
    };
    for touch in state.touches.samples() {
        let normal = wide(touch.normal);
        add(Gap { sample: touch.sample, normal, clearance: 0.0, is_own: near.index == touch.other });
    }
    gaps.find((view, surface), |distance| near.surfaces(distance), near.touches_itself(), distance, add);
    found.end();
}
