//! The contacts of a body with other bodies in the last step.

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
        Self { all_count: true, samples: Vec::new(), bodies: Vec::new() }
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

    /// Forgets all sides: the positions were set.
    pub(crate) fn forget(&mut self) {
        self.all_count = true;
        self.samples.clear();
        self.bodies.clear();
    }

    /// Replaces the touches by those of a step. `bodies`: pairs of connected component and body, in any order.
    pub(crate) fn set(
        &mut self,
        samples: impl Iterator<Item = SampleTouch>,
        bodies: impl Iterator<Item = (u32, u32)>,
    ) {
        self.all_count = false;
        self.samples.clear();
        self.samples.extend(samples);
        self.samples.sort_unstable_by_key(|touch| (touch.other, touch.sample));
        self.bodies.clear();
        self.bodies.extend(bodies);
        self.bodies.sort_unstable();
        self.bodies.dedup();
    }

    /// Returns whether the touches can belong to a body with this number of connected components.
    pub(super) fn is_valid(&self, components: usize) -> bool {
        let sorted = self.samples.is_sorted_by_key(|touch| (touch.other, touch.sample));
        let is_finite = self.samples.iter().all(|touch| touch.normal.iter().all(|x| x.is_finite()));
        sorted && is_finite && self.bodies.iter().all(|(component, _)| (*component as usize) < components)
    }
}
