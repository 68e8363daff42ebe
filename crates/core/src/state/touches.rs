//! The contacts of a body with other bodies in the last step.

use nalgebra::Vector3;

use crate::simd::bounds::difference_bounds;
use crate::simd::lanes::Lanes;

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
    searched: SearchedPositions,
}

/// The positions of a body in the last step in which its contacts with other bodies were searched, because it had moved.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct SearchedPositions {
    /// In cells from the origin of the body. No blocks if the next step has to search.
    positions: Lanes<3>,
    /// Displacement of the origin, in cells.
    shift: [f64; 3],
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
    pub(crate) foot: Foot,
}

/// A point of the surface of a body that a sample of another one touches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Foot {
    pub(crate) cell: u32,
    /// Local coordinates in the cell, in [0, 1].
    pub(crate) local: [f32; 3],
    /// Unit normal at rest, on the side of the sample.
    pub(crate) normal: [f32; 3],
    /// Distance from the surface at which a sample touches it, in cells.
    pub(crate) shell: f32,
}

impl Default for Touches {
    fn default() -> Self {
        let searched = SearchedPositions::default();
        Self { all_count: true, samples: Vec::new(), bodies: Vec::new(), impulses: Vec::new(), searched }
    }
}

impl SearchedPositions {
    /// Removes the positions, so that the next step searches.
    fn forget(&mut self) {
        self.positions.clear();
        self.shift = [0.0; 3];
    }

    /// Returns an upper bound of the distance in cells by which a vertex of the body moved since the positions were stored;
    /// infinity if there are none.
    fn distance(&self, positions: &Lanes<3>, shift: [f64; 3], occupied: &[u8]) -> f64 {
        if self.positions.blocks().is_empty() {
            return f64::INFINITY;
        }
        let (low, high) = difference_bounds(positions, &self.positions, occupied);
        let greatest = |a: usize| {
            let shift = shift[a] - self.shift[a];
            (f64::from(low[a]) + shift).abs().max((f64::from(high[a]) + shift).abs())
        };
        Vector3::from_fn(|a, _| greatest(a)).norm()
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

    /// Lets the next step search all contacts.
    pub(crate) fn forget_search(&mut self) {
        self.searched.forget();
    }

    /// Returns an upper bound of the distance in cells by which a vertex of the body moved since its contacts were searched;
    /// infinity if they have to be searched because that is more than `limit`. In this case it is taken that they are searched
    /// now. `positions` are in cells from the origin, which is displaced by `shift` cells; `occupied` has the bit mask of the
    /// lanes with a vertex, for each block.
    pub(super) fn search_distance(
        &mut self,
        (positions, shift): (&Lanes<3>, [f64; 3]),
        occupied: &[u8],
        limit: f64,
    ) -> f64 {
        let distance = self.searched.distance(positions, shift, occupied);
        if distance <= limit {
            return distance;
        }
        self.searched.positions.copy_from(positions);
        self.searched.shift = shift;
        f64::INFINITY
    }

    /// Returns the memory of the positions in bytes.
    pub(super) fn position_bytes(&self) -> usize {
        self.searched.positions.bytes()
    }

    /// Removes all contacts: nothing touches.
    pub(crate) fn clear(&mut self) {
        self.searched.forget();
        self.remove_all();
    }

    fn remove_all(&mut self) {
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
        self.remove_all();
        self.samples.extend(samples);
        self.samples.sort_unstable_by_key(|touch| (touch.other, touch.sample));
        self.bodies.extend(bodies);
        self.bodies.sort_unstable();
        self.bodies.dedup();
        self.impulses.extend(impulses);
        self.impulses.sort_unstable_by_key(|impulse| impulse.key);
    }

    /// Returns whether the touches can belong to a body with this number of blocks of positions and connected components.
    pub(super) fn is_valid(&self, blocks: usize, components: usize) -> bool {
        let sorted = self.samples.is_sorted_by_key(|touch| (touch.other, touch.sample))
            && self.impulses.is_sorted_by_key(|impulse| impulse.key);
        let is_finite_touch = |touch: &SampleTouch| {
            let Foot { local, normal, shell, .. } = touch.foot;
            let vectors = [touch.normal, normal, local].into_iter().flatten();
            vectors.chain([shell]).all(f32::is_finite)
        };
        let is_finite = self.samples.iter().all(is_finite_touch)
            && self.impulses.iter().all(|impulse| impulse.impulse.iter().all(|x| x.is_finite()));
        let searched = self.searched.positions.blocks().len();
        sorted
            && is_finite
            && (searched == 0 || searched == blocks)
            && self.bodies.iter().all(|(component, _)| (*component as usize) < components)
    }
}
