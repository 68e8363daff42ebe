//! The connected component of each lattice vertex, by its slot.

/// The connected component of each lattice vertex.
#[derive(Clone, Debug)]
pub(crate) enum Components {
    /// One component, which contains all vertices.
    One,
    /// The component of the vertex in each slot.
    Several(Vec<u32>),
}

impl Components {
    /// Returns the component of the vertex in a slot.
    #[inline(always)]
    pub(in crate::dynamics) fn of_slot(&self, slot: u32) -> usize {
        match self {
            Self::One => 0,
            Self::Several(of_slot) => of_slot[slot as usize] as usize,
        }
    }
}
