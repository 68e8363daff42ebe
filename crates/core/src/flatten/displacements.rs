//! The displacements of the mesh vertices of a body.

use crate::lattice::Embedding;
use crate::simd::xyzx::Xyzx;
use crate::skin::SkinOffsets;

use super::FlattenTable;

/// The cells of a body whose mesh vertices move.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovedCell {
    /// Index in [`Embedding::by_cell`].
    pub(super) cell: u32,
    /// First and end of the ranks of its mesh vertices.
    pub(super) ranks: [u32; 2],
}

/// A mesh vertex that is held by a collider: the share `hold` of a later displacement along `normal` is held back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold {
    pub(crate) rank: u32,
    pub(crate) hold: f32,
    /// Normal of the collider.
    pub(crate) normal: [f32; 3],
}

impl Hold {
    /// Returns a displacement without the share that is held back.
    pub(crate) fn apply(&self, displacement: [f32; 3]) -> [f32; 3] {
        let along: f32 = displacement.iter().zip(&self.normal).map(|(a, b)| a * b).sum();
        std::array::from_fn(|k| displacement[k] - self.hold * along * self.normal[k])
    }
}

/// Displacements of mesh vertices, in cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct Displacements {
    /// Displacement of each rank.
    pub(crate) offsets: Vec<Xyzx>,
    /// The vertices that are held, by collider, in the order of the ranks.
    pub(crate) holds: Vec<Hold>,
    /// Whether mesh vertices of a cell move, for each cell in [`Embedding::by_cell`].
    is_moved: Vec<bool>,
    /// The cells in which mesh vertices move.
    pub(super) moved: Vec<MovedCell>,
}

impl Displacements {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let cells = size_of_val(&*self.is_moved) + size_of_val(&*self.moved);
        size_of_val(&*self.offsets) + size_of_val(&*self.holds) + cells
    }

    /// Returns whether no mesh vertex moves.
    pub(crate) fn is_empty(&self) -> bool {
        self.holds.is_empty()
    }

    /// Removes all displacements.
    pub(super) fn clear(&mut self) {
        self.holds.clear();
        for MovedCell { cell, ranks: [first, end] } in self.moved.drain(..) {
            self.is_moved[cell as usize] = false;
            self.offsets[first as usize..end as usize].fill([0.0; 4]);
        }
    }

    /// Removes all displacements, and prepares for a mesh.
    pub(super) fn begin(&mut self, embedding: &Embedding) {
        self.clear();
        self.offsets.resize(embedding.len(), [0.0; 4]);
        self.is_moved.resize(embedding.by_cell().len(), false);
    }

    /// Marks a cell as one in which mesh vertices move. `ranks`: first and end of the ranks of its mesh vertices.
    pub(super) fn mark(&mut self, cell: u32, ranks: [u32; 2]) {
        if !std::mem::replace(&mut self.is_moved[cell as usize], true) {
            self.moved.push(MovedCell { cell, ranks });
        }
    }

    /// Adds a displacement to that of a rank.
    pub(crate) fn add(&mut self, rank: u32, displacement: [f32; 3]) {
        let offset = &mut self.offsets[rank as usize];
        let [x, y, z] = std::array::from_fn(|k| offset[k] + displacement[k]);
        *offset = [x, y, z, x];
    }

    /// Multiplies displacements by factors. `factor` has the corners of the cell of a mesh vertex and its displacement
    /// as arguments.
    pub(crate) fn scale(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        factor: impl Fn(&[u32; 8], [f32; 3]) -> f32,
    ) {
        for &MovedCell { ranks: [first, end], .. } in &self.moved {
            let corners = embedding.corners(table.vertices[first as usize] as usize);
            for offset in &mut self.offsets[first as usize..end as usize] {
                let &mut [x, y, z, _] = offset;
                if [x, y, z] != [0.0; 3] {
                    let factor = factor(&corners, [x, y, z]);
                    *offset = offset.map(|x| factor * x);
                }
            }
        }
    }

    /// Returns the displacement of a rank.
    pub(crate) fn get(&self, rank: u32) -> [f32; 3] {
        let [x, y, z, _] = self.offsets[rank as usize];
        [x, y, z]
    }
}

/// A body's surface with displacements of its mesh vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlattenedSurface<'a> {
    pub(crate) embedding: &'a Embedding,
    pub(crate) table: &'a FlattenTable,
    pub(crate) displacements: &'a Displacements,
}

impl<'a> FlattenedSurface<'a> {
    /// Returns the displacements as the mesh update reads them.
    pub(crate) fn skin_offsets(self) -> SkinOffsets<'a> {
        let Displacements { offsets, is_moved, .. } = self.displacements;
        SkinOffsets { offsets, is_moved, ranks: &self.table.ranks }
    }
}
