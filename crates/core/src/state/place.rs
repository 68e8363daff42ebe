//! The place of a body at a time, from which its displacements are measured.

use nalgebra::Vector3;

use crate::simd::bounds::difference_bounds;
use crate::simd::lanes::Lanes;

/// The positions of a body at a time.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Place {
    /// In cells from the origin of the body. No blocks if no place is stored.
    positions: Lanes<3>,
    /// Displacement of the origin, in cells.
    shift: [f64; 3],
}

/// The displacements in cells of the vertices from a place: the box of the displacements of the positions from the
/// origin, and the displacement of the origin.
pub(super) struct Displacements {
    low: [f64; 3],
    high: [f64; 3],
    shift: [f64; 3],
}

impl Place {
    /// Removes the positions. Keeps the capacity.
    pub(super) fn forget(&mut self) {
        self.positions.clear();
        self.shift = [0.0; 3];
    }

    /// Stores positions in cells from an origin that is displaced by `shift` cells.
    pub(super) fn store(&mut self, (positions, shift): (&Lanes<3>, [f64; 3])) {
        self.positions.copy_from(positions);
        self.shift = shift;
    }

    /// Returns the displacements since the positions were stored; `None` if there are none. `occupied` has the bit
    /// mask of the lanes with a vertex, for each block.
    pub(super) fn displacements(
        &self,
        (positions, shift): (&Lanes<3>, [f64; 3]),
        occupied: &[u8],
    ) -> Option<Displacements> {
        if self.positions.blocks().is_empty() {
            return None;
        }
        let (low, high) = difference_bounds(positions, &self.positions, occupied);
        let shift = std::array::from_fn(|a| shift[a] - self.shift[a]);
        Some(Displacements { low: low.map(f64::from), high: high.map(f64::from), shift })
    }

    /// Returns an upper bound of the distance in cells of a vertex from its place: see
    /// [`displacements`](Self::displacements).
    pub(super) fn greatest_distance(&self, present: (&Lanes<3>, [f64; 3]), occupied: &[u8]) -> Option<f64> {
        self.displacements(present, occupied).map(|displacements| displacements.distance_from([0.0; 3]))
    }

    /// Returns the displacement in cells of the vertex of a slot since the positions were stored.
    pub(super) fn displacement(&self, (positions, shift): (&Lanes<3>, [f64; 3]), slot: u32) -> Vector3<f64> {
        let (now, before) = (positions.get(slot), self.positions.get(slot));
        Vector3::from_fn(|a, _| f64::from(now[a] - before[a]) + (shift[a] - self.shift[a]))
    }

    /// Returns whether the place fits a body with this number of blocks of positions.
    pub(super) fn is_valid(&self, blocks: usize) -> bool {
        let stored = self.positions.blocks().len();
        stored == 0 || stored == blocks
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.positions.bytes()
    }
}

impl Displacements {
    /// Returns an upper bound of the distance of a vertex from its place after a common translation.
    pub(super) fn distance_from(&self, translation: [f64; 3]) -> f64 {
        let greatest = |a: usize| {
            let shift = self.shift[a] - translation[a];
            (self.low[a] + shift).abs().max((self.high[a] + shift).abs())
        };
        Vector3::from_fn(|a, _| greatest(a)).norm()
    }

    /// Returns an upper bound of the distance of a vertex from its place after the common translation.
    pub(super) fn relative_distance(&self) -> f64 {
        Vector3::from_fn(|a, _| 0.5 * (self.high[a] - self.low[a])).norm()
    }

    /// Returns the common translation: the middle of the box.
    pub(super) fn translation(&self) -> [f64; 3] {
        std::array::from_fn(|a| 0.5 * (self.low[a] + self.high[a]) + self.shift[a])
    }
}
