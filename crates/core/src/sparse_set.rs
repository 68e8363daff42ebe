//! Sparse sets of the numbers `0..n`: insertion and look-up take constant time, clearing takes the time of the members
//! (Briggs & Torczon 1993).

/// Entry of `SparseSet::indices` for a number that is not in the set.
const NONE: u32 = u32::MAX;

/// Sparse set of numbers. The index of a member is the number of members that were added before it.
#[derive(Clone, Debug, Default)]
pub(crate) struct SparseSet {
    /// The members, by index.
    members: Vec<u32>,
    /// Index in `members` of every possible member, or `NONE`.
    indices: Vec<u32>,
}

impl SparseSet {
    /// Creates an empty set. The possible members are `0..n`.
    pub(crate) fn new(n: usize) -> Self {
        Self { members: Vec::new(), indices: vec![NONE; n] }
    }

    /// Empties the set and changes the possible members to `0..n`. Keeps the capacity of the buffers.
    pub(crate) fn resize(&mut self, n: usize) {
        self.clear();
        self.indices.resize(n, NONE);
    }

    /// Returns the memory of the set in bytes, by its capacity.
    pub(crate) fn bytes(&self) -> usize {
        (self.members.capacity() + self.indices.capacity()) * size_of::<u32>()
    }

    /// Empties the set. Keeps the capacity of the buffers.
    pub(crate) fn clear(&mut self) {
        for member in self.members.drain(..) {
            self.indices[member as usize] = NONE;
        }
    }

    /// Returns the index of a member. Adds the member if it is not in the set.
    #[inline(always)]
    pub(crate) fn index_or_insert(&mut self, member: u32) -> u32 {
        let index = &mut self.indices[member as usize];
        if *index == NONE {
            *index = self.members.len() as u32;
            self.members.push(member);
        }
        *index
    }

    /// Returns the members in increasing order, with their indices.
    pub(crate) fn increasing(&self) -> impl Iterator<Item = (u32, u32)> {
        (0..).zip(&self.indices).filter(|(_, index)| **index != NONE).map(|(member, index)| (member, *index))
    }

    /// Returns the members in the order of their indices.
    pub(crate) fn list(&self) -> &[u32] {
        &self.members
    }
}
