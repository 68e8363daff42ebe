//! The contacts of a body with other bodies in the last step.

use nalgebra::Vector3;

/// The contacts of a body with other bodies, and with itself, in the last step. Contact between bodies uses them to tell
/// from which side a sample came.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Touches {
    /// Whether the positions were set since the last step, so that no side is known.
    pub(crate) all_count: bool,
    /// The samples that touched, in increasing order of the other body, then of the sample.
    samples: Vec<SampleTouch>,
    /// The touched bodies: pairs of connected component and body, in increasing order.
    bodies: Vec<(u32, u32)>,
    /// The impulses of the contacts, in increasing order of the keys. The next step begins with them.
    impulses: Vec<ContactImpulse>,
}

/// The impulse on the body by a contact in the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ContactImpulse {
    pub(crate) key: ContactKey,
    /// In scene units.
    pub(crate) impulse: [f64; 3],
}

/// What a contact of one step has in common with the same contact in the next step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum ContactKey {
    /// A contact with a collider, of the samples nearest to a lattice vertex.
    Collider { collider: u32, vertex: u32 },
    /// A contact of samples of the body with a connected component of another body: the point of the grid of half the
    /// cell size that is nearest to the samples, and the dominant axis of the normal, 0..6.
    Body { other: u32, component: u32, node: [i32; 3], axis: u8 },
}

/// A sample that touched a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SampleTouch {
    /// Index of the other body.
    pub(crate) other: u32,
    /// Index of the sample.
    pub(crate) sample: u32,
    /// Unit normal of the other body, in world space.
    pub(crate) normal: [f32; 3],
}

impl Default for Touches {
    fn default() -> Self {
        Self { all_count: true, samples: Vec::new(), bodies: Vec::new(), impulses: Vec::new() }
    }
}

impl Touches {
    /// Returns the touches of one body, in increasing order of the samples.
    pub(crate) fn of(&self, other: u32) -> &[SampleTouch] {
        let first = self.samples.partition_point(|touch| touch.other < other);
        let end = self.samples.partition_point(|touch| touch.other <= other);
        &self.samples[first..end]
    }

    /// Returns all touches.
    pub(crate) fn samples(&self) -> &[SampleTouch] {
        &self.samples
    }

    /// Returns the touched bodies: pairs of connected component and body.
    pub(crate) fn bodies(&self) -> &[(u32, u32)] {
        &self.bodies
    }

    /// Returns the impulse of a contact in the last step; zero if there was no such contact.
    pub(crate) fn impulse(&self, key: ContactKey) -> Vector3<f64> {
        let found = self.impulses.binary_search_by_key(&key, |impulse| impulse.key);
        found.map_or_else(|_| Vector3::zeros(), |index| self.impulses[index].impulse.into())
    }

    /// Forgets all contacts: the positions were set.
    pub(crate) fn forget(&mut self) {
        self.clear();
        self.all_count = true;
    }

    /// Removes all contacts: nothing touches.
    pub(crate) fn clear(&mut self) {
        self.all_count = false;
        self.samples.clear();
        self.bodies.clear();
        self.impulses.clear();
    }

    /// Replaces the touches by those of a step, each in any order. `bodies`: pairs of connected component and body.
    pub(crate) fn set(
        &mut self,
        samples: impl Iterator<Item = SampleTouch>,
        bodies: impl Iterator<Item = (u32, u32)>,
        impulses: impl Iterator<Item = ContactImpulse>,
    ) {
        self.clear();
        self.samples.extend(samples);
        self.samples.sort_unstable_by_key(|touch| (touch.other, touch.sample));
        self.bodies.extend(bodies);
        self.bodies.sort_unstable();
        self.bodies.dedup();
        self.impulses.extend(impulses);
        self.impulses.sort_unstable_by_key(|impulse| impulse.key);
    }

    /// Returns whether the touches can belong to a body with this number of connected components.
    pub(super) fn is_valid(&self, components: usize) -> bool {
        let sorted = self.samples.is_sorted_by_key(|touch| (touch.other, touch.sample))
            && self.impulses.is_sorted_by_key(|impulse| impulse.key);
        let is_finite = self.samples.iter().all(|touch| touch.normal.iter().all(|x| x.is_finite()))
            && self.impulses.iter().all(|impulse| impulse.impulse.iter().all(|x| x.is_finite()));
        sorted && is_finite && self.bodies.iter().all(|(component, _)| (*component as usize) < components)
    }
}
