//! The contacts of a body with other bodies in the last step.

use nalgebra::Vector3;

use super::place::{Displacements, Place};
use crate::simd::lanes::Lanes;

/// The contacts of a body with other bodies, and with itself, in the last step. Contact between bodies uses them to
/// tell from which side a sample came.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Touches {
    /// Whether the positions were set since the last step, so that no side is known.
    pub(crate) sides_unknown: bool,
    /// The samples that touched, in increasing order of the other body, then of the sample.
    samples: Vec<SampleTouch>,
    /// The touched bodies: pairs of connected component and body, in increasing order.
    bodies: Vec<(u32, u32)>,
    /// The forces of the contacts, in increasing order of the keys. The next step begins with them.
    forces: Vec<ContactForce>,
    searched: SearchedPlace,
}

/// The place of a body in the last step in which its contacts with other bodies were searched, because it had moved.
/// The next step has to search if there is none.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct SearchedPlace {
    place: Place,
    /// Common translation in cells after the search, from which rest is measured. Zero unless only the body itself was
    /// near, so that a translation needs no search.
    translation: [f64; 3],
}

/// The motion of a body since its contacts with other bodies were searched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchedMotion {
    /// Upper bound of the distance in cells that counts for the search; infinity if the contacts have to be searched.
    pub(crate) distance: f64,
    /// Whether the body stayed in place: it needs no search, and a common translation is within the limit as well.
    pub(crate) is_in_place: bool,
}

impl SearchedMotion {
    /// For a body whose contacts have to be searched.
    pub(crate) const UNKNOWN: Self = Self { distance: f64::INFINITY, is_in_place: false };
}

/// The force on the body by a contact in the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ContactForce {
    pub(crate) key: ContactKey,
    /// In scene units.
    pub(crate) force: [f64; 3],
}

/// The identity of a contact across steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum ContactKey {
    /// A contact with a collider, of the samples nearest to a lattice vertex.
    Collider { collider: u32, vertex: u32 },
    /// A contact of samples of a connected component of the body with one of another body: the other body, both
    /// components, the point of the grid of half the cell size that is nearest to the samples, and the dominant axis of
    /// the normal, 0..6.
    Body { other: u32, components: [u32; 2], node: [i32; 3], axis: u8 },
}

/// A sample that touched a body in the last step, or in the last step in which the body was searched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SampleTouch {
    /// Index of the other body.
    pub(crate) other: u32,
    /// Index of the sample.
    pub(crate) sample: u32,
    /// Whether it touched in the last step.
    pub(crate) is_touching: bool,
    /// Unit normal of the other body, in world space.
    pub(crate) normal: [f32; 3],
    /// The point of the other body that it touches.
    pub(crate) touched: TouchedPoint,
}

/// A point of the surface of a body that a sample of another one touches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct TouchedPoint {
    pub(crate) cell: u32,
    /// Local coordinates in the cell: in [0, 1], at the smooth surface of a crack in [-1, 2].
    pub(crate) local: [f32; 3],
    /// Unit normal at rest, on the side of the sample.
    pub(crate) normal: [f32; 3],
    /// Distance from the surface at which a sample touches it, in cells. Negative where pieces of a body overlapped
    /// when it broke.
    pub(crate) shell: f32,
}

impl Default for Touches {
    fn default() -> Self {
        let searched = SearchedPlace::default();
        Self { sides_unknown: true, samples: Vec::new(), bodies: Vec::new(), forces: Vec::new(), searched }
    }
}

impl SearchedPlace {
    /// Removes the place, so that the next step searches.
    fn forget(&mut self) {
        self.place.forget();
        self.translation = [0.0; 3];
    }

    /// Returns whether the body stayed within `limit` cells of the place from which rest is measured. Otherwise rest is
    /// measured from the present place on.
    fn stays(&mut self, displacements: &Displacements, limit: f64) -> bool {
        let stays = displacements.distance_from(self.translation) <= limit;
        if !stays {
            self.translation = displacements.translation();
        }
        stays
    }
}

impl Touches {
    /// Returns the touches of one body, in increasing order of the samples.
    pub(crate) fn of(&self, other: u32) -> &[SampleTouch] {
        let first = self.samples.partition_point(|touch| touch.other < other);
        let end = self.samples.partition_point(|touch| touch.other <= other);
        &self.samples[first..end]
    }

    /// Returns the samples that touched in the last step.
    pub(crate) fn samples(&self) -> impl Iterator<Item = &SampleTouch> {
        self.samples.iter().filter(|touch| touch.is_touching)
    }

    /// Returns the touched bodies: pairs of connected component and body.
    pub(crate) fn bodies(&self) -> &[(u32, u32)] {
        &self.bodies
    }

    /// Returns the force of a contact in the last step; zero if there was no such contact.
    pub(crate) fn force(&self, key: ContactKey) -> Vector3<f64> {
        let found = self.forces.binary_search_by_key(&key, |force| force.key);
        found.map_or_else(|_| Vector3::zeros(), |index| self.forces[index].force.into())
    }

    /// Returns whether the body was touched in the last step.
    pub(crate) fn has_forces(&self) -> bool {
        !self.forces.is_empty()
    }

    /// Returns the keys of the forces.
    #[cfg(test)]
    pub(crate) fn keys(&self) -> impl Iterator<Item = ContactKey> {
        self.forces.iter().map(|force| force.key)
    }

    /// Forgets all contacts: the positions were set.
    pub(super) fn forget(&mut self) {
        self.clear();
        self.sides_unknown = true;
    }

    /// Replaces all forces by the forces of contacts with colliders, in any order.
    pub(crate) fn set_forces(&mut self, forces: impl Iterator<Item = ContactForce>) {
        self.forces.clear();
        self.forces.extend(forces);
        self.forces.sort_unstable_by_key(|force| force.key);
    }

    /// Forgets all but the forces of contacts with colliders.
    pub(crate) fn forget_bodies(&mut self) {
        self.samples.clear();
        self.bodies.clear();
        self.searched.forget();
        self.sides_unknown = true;
        self.forces.retain(|force| matches!(force.key, ContactKey::Collider { .. }));
    }

    /// Follows the removal of a body of the simulation: forgets its contacts, and lowers the indices above its own.
    /// Returns whether it was touched.
    pub(crate) fn remove_body(&mut self, removed: u32) -> bool {
        let lower = |index: &mut u32| *index -= u32::from(*index > removed);
        let was_touched = self.bodies.iter().any(|(_, other)| *other == removed);
        self.samples.retain(|touch| touch.other != removed);
        self.samples.iter_mut().for_each(|touch| lower(&mut touch.other));
        self.bodies.retain(|(_, other)| *other != removed);
        self.bodies.iter_mut().for_each(|(_, other)| lower(other));
        self.forces.retain(|force| !matches!(force.key, ContactKey::Body { other, .. } if other == removed));
        for force in &mut self.forces {
            if let ContactKey::Body { other, .. } = &mut force.key {
                lower(other);
            }
        }
        was_touched
    }

    /// Forgets the forces: the next step begins without them.
    pub(crate) fn forget_forces(&mut self) {
        self.forces.clear();
    }

    /// Lets the next step search all contacts.
    pub(crate) fn forget_search(&mut self) {
        self.searched.forget();
    }

    /// Returns the motion of the body since its contacts were searched. Beyond `limit` cells they have to be searched,
    /// and the positions are stored as the searched ones. `positions` are in cells from the origin,
    /// which is displaced by `shift` cells; `occupied` has the bit mask of the lanes with a vertex, for each block.
    /// `is_relative`: a common translation does not count for the search, as the body touches itself only.
    pub(super) fn searched_motion(
        &mut self,
        (positions, shift): (&Lanes<3>, [f64; 3]),
        occupied: &[u8],
        limit: f64,
        is_relative: bool,
    ) -> SearchedMotion {
        let Self { searched, .. } = self;
        if let Some(displacements) = searched.place.displacements((positions, shift), occupied) {
            let distance = match is_relative {
                true => displacements.relative_distance(),
                false => displacements.distance_from([0.0; 3]),
            };
            if distance <= limit {
                let is_in_place = !is_relative || searched.stays(&displacements, limit);
                return SearchedMotion { distance, is_in_place };
            }
        }
        searched.place.store((positions, shift));
        searched.translation = [0.0; 3];
        SearchedMotion::UNKNOWN
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { samples, bodies, forces, searched, .. } = self;
        let lists = size_of_val(&**samples) + size_of_val(&**bodies) + size_of_val(&**forces);
        lists + searched.place.bytes()
    }

    /// Removes all contacts: nothing touches.
    pub(crate) fn clear(&mut self) {
        self.searched.forget();
        self.sides_unknown = false;
        self.samples.clear();
        self.bodies.clear();
        self.forces.clear();
    }

    /// Replaces the touches by the touches of a step, in any order. Keeps the touches of the bodies that `keep`
    /// selects. `bodies`: pairs of connected component and body.
    pub(crate) fn set(
        &mut self,
        keep: impl Fn(u32) -> bool,
        samples: impl Iterator<Item = SampleTouch>,
        bodies: impl Iterator<Item = (u32, u32)>,
        forces: impl Iterator<Item = ContactForce>,
    ) {
        self.sides_unknown = false;
        self.samples.retain(|touch| keep(touch.other));
        self.bodies.retain(|(_, other)| keep(*other));
        self.forces.retain(|force| matches!(force.key, ContactKey::Body { other, .. } if keep(other)));
        self.samples.extend(samples);
        self.samples.sort_unstable_by_key(|touch| (touch.other, touch.sample));
        self.bodies.extend(bodies);
        self.bodies.sort_unstable();
        self.bodies.dedup();
        self.forces.extend(forces);
        self.forces.sort_unstable_by_key(|force| force.key);
    }

    /// Returns whether the touches can belong to a body with this number of blocks of positions and connected
    /// components.
    pub(super) fn is_valid(&self, blocks: usize, components: usize) -> bool {
        let sorted = self.samples.is_sorted_by_key(|touch| (touch.other, touch.sample))
            && self.bodies.is_sorted()
            && self.forces.is_sorted_by_key(|force| force.key);
        let is_valid_touch = |touch: &SampleTouch| {
            let TouchedPoint { local, normal, shell, .. } = touch.touched;
            let is_unit = |vector: [f32; 3]| (0.5..2.0).contains(&Vector3::from(vector).norm());
            // The smooth surface of a crack lies outside the cells of its piece in part.
            let is_inside =
                local.iter().all(|u| (-1.0..=2.0).contains(u)) && shell.is_finite() && shell >= -1.0;
            is_inside && is_unit(touch.normal) && is_unit(normal)
        };
        let are_valid = self.samples.iter().all(is_valid_touch)
            && self.forces.iter().all(|force| force.force.iter().all(|x| x.is_finite()));
        sorted
            && are_valid
            && self.searched.place.is_valid(blocks)
            && self.searched.translation.iter().all(|x| x.is_finite())
            && self.bodies.iter().all(|(component, _)| (*component as usize) < components)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(other: u32, sample: u32) -> SampleTouch {
        let touched = TouchedPoint { cell: 0, local: [0.5; 3], normal: [0.0, 1.0, 0.0], shell: 0.0 };
        SampleTouch { other, sample, is_touching: true, normal: [0.0, 1.0, 0.0], touched }
    }

    fn force(other: u32) -> ContactForce {
        let key = ContactKey::Body { other, components: [0; 2], node: [0; 3], axis: 1 };
        ContactForce { key, force: [0.0, f64::from(other), 0.0] }
    }

    #[test]
    fn touches_of_kept_bodies_remain_and_those_of_other_bodies_are_replaced() {
        let none = |_: u32| false;
        let mut touches = Touches::default();
        let samples = [touch(7, 3), touch(2, 5), touch(2, 1)].into_iter();
        touches.set(none, samples, [(0, 2), (0, 7)].into_iter(), [force(7), force(2)].into_iter());
        assert!(touches.is_valid(0, 1));
        // The next step finds body 4, does not search body 7, and no longer touches body 2.
        touches.set(
            |other| other == 7,
            [touch(4, 9)].into_iter(),
            [(0, 4)].into_iter(),
            [force(4)].into_iter(),
        );
        assert!(touches.is_valid(0, 1));
        let samples: Vec<_> = touches.samples().map(|touch| (touch.other, touch.sample)).collect();
        assert_eq!(samples, [(4, 9), (7, 3)]);
        assert_eq!(touches.bodies(), [(0, 4), (0, 7)]);
        let forces = [2, 4, 7].map(|other| touches.force(force(other).key).y);
        assert_eq!(forces, [0.0, 4.0, 7.0]);
        touches.set(none, std::iter::empty(), std::iter::empty(), std::iter::empty());
        assert_eq!(touches.samples().count() + touches.bodies().len(), 0);
    }

    /// A body that only touches itself is searched when it deforms, and is in place until it moves.
    #[test]
    fn a_common_translation_needs_no_search_and_is_no_rest() {
        let mut touches = Touches::default();
        let positions = |offset: [f32; 3]| {
            let mut positions = Lanes::zeros(1);
            positions.set(0, offset);
            positions.set(1, [1.0 + offset[0], offset[1], offset[2]]);
            positions
        };
        let mut motion = |offset: [f32; 3], shift: f64| {
            let motion =
                touches.searched_motion((&positions(offset), [shift, 0.0, 0.0]), &[0b11], 0.02, true);
            (motion.distance.is_finite(), motion.is_in_place)
        };
        assert_eq!(motion([0.0; 3], 0.0), (false, false));
        assert_eq!(motion([0.01, 0.0, 0.0], 0.0), (true, true));
        assert_eq!(motion([0.03, 0.0, 0.0], 0.0), (true, false));
        assert_eq!(motion([0.04, 0.0, 0.0], 0.0), (true, true));
        // The origin moves and the positions do not.
        assert_eq!(motion([0.04, 0.0, 0.0], 2.0), (true, false));
        assert_eq!(motion([-1.96, 0.01, 0.0], 4.0), (true, true));
    }

    #[test]
    fn invalid_touches_are_found() {
        let valid = |change: fn(&mut SampleTouch)| {
            let mut touch = touch(1, 2);
            change(&mut touch);
            let mut touches = Touches::default();
            touches.set(|_| false, [touch].into_iter(), std::iter::empty(), std::iter::empty());
            touches.is_valid(0, 1)
        };
        assert!(valid(|_| {}));
        assert!(!valid(|touch| touch.touched.local[1] = 2.5));
        assert!(!valid(|touch| touch.touched.normal = [f32::NAN, 0.0, 0.0]));
        assert!(!valid(|touch| touch.normal = [0.0; 3]));
        assert!(!valid(|touch| touch.touched.shell = f32::INFINITY));
    }
}
