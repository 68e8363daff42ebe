//! Constructors of [`Lattice`]: from a surface mesh, or from given cells.

use nalgebra::Point3;

use super::candidate::Request;
use super::{
    Lattice, LatticeError, LatticeOptions, LatticeReport, Resolution, assemble, components, memory,
    resolution,
};
use crate::mesh::Mesh;
use crate::voxel::{GridSet, HIGHEST_INDEX};

impl Lattice {
    /// Builds the lattice of a surface mesh: the cells that the surface passes through or encloses.
    ///
    /// The grid is centered on the bounding box of the mesh. A cell that the surface only touches is not
    /// occupied. A face that lies in a grid plane belongs to the cell on its inner side, so that a cube with
    /// edges of n cells gives n^3 cells, and a flat surface gives one layer of cells. A cell is enclosed iff
    /// no path of empty cells leads to it from outside, or if its center is inside an open surface by the
    /// winding number. A sheet, which encloses nothing, gives a layer of cells along the surface; `shell` is then
    /// true in the [report](Self::report).
    ///
    /// # Errors
    ///
    /// If the cell size is not positive and finite, if fewer than 8 vertices are requested, or if the lattice
    /// needs more memory than allowed. The error for too much memory gives a cell size that would fit.
    pub fn from_mesh(mesh: &Mesh, options: &LatticeOptions) -> Result<Self, LatticeError> {
        let request = Request { mesh, join: options.join, limit: memory::limit(options.memory_limit) };
        let candidate = match options.resolution {
            Resolution::CellSize(cell_size) => {
                check_cell_size(cell_size)?;
                request.candidate(cell_size)
            }
            Resolution::Vertices(requested) => resolution::search(&request, requested),
        };
        candidate.and_then(|candidate| candidate.build(&request)).map_err(|error| request.suggest_size(error))
    }

    /// Scales the lattice by `factor` about the origin of the model frame.
    ///
    /// # Errors
    ///
    /// If the factor or the resulting cell size is not positive and finite.
    pub fn scaled(mut self, factor: f64) -> Result<Self, LatticeError> {
        check_cell_size(factor)?;
        self.cell_size *= factor;
        self.origin *= factor;
        check_cell_size(self.cell_size)?;
        Ok(self)
    }

    /// Builds the lattice of the given cells and keeps their indices.
    ///
    /// * `cells`: grid indices `[x, y, z]` of the occupied cells, in any order. Repeated cells count once.
    ///   Each index is between -2^30 and 2^30.
    /// * `cell_size`: edge length of a cell, positive.
    /// * `origin`: position of corner 0 of cell `[0, 0, 0]`.
    /// * `join`: whether parts (connected components of the cells) are joined by bridges of cells. A bridge
    ///   is a shortest path of steps through faces. If false, each part is a component of the lattice.
    ///
    /// # Errors
    ///
    /// If there are no cells, if an index is out of range, if the cell size is not positive and finite, if
    /// the origin is not finite, or if the lattice and a simulation of it need more than 4 GiB.
    pub fn from_cells(
        cells: &[[i32; 3]],
        cell_size: f64,
        origin: impl Into<Point3<f64>>,
        join: bool,
    ) -> Result<Self, LatticeError> {
        Self::from_cells_within(LatticeOptions::DEFAULT_MEMORY_LIMIT, cells, cell_size, origin, join)
    }

    /// Builds the lattice of the given cells as [`Lattice::from_cells`] does, with another memory limit.
    ///
    /// * `memory_limit`: as [`LatticeOptions::memory_limit`], in bytes.
    ///
    /// # Errors
    ///
    /// As [`Lattice::from_cells`].
    pub fn from_cells_within(
        memory_limit: u64,
        cells: &[[i32; 3]],
        cell_size: f64,
        origin: impl Into<Point3<f64>>,
        join: bool,
    ) -> Result<Self, LatticeError> {
        check_cell_size(cell_size)?;
        let origin = origin.into();
        if !origin.iter().all(|x| x.is_finite()) {
            return Err(LatticeError::Origin(origin.x, origin.y, origin.z));
        }
        if cells.is_empty() {
            return Err(LatticeError::NoCells);
        }
        for (cell, index) in cells.iter().enumerate() {
            if let Some(&index) = index.iter().find(|i| i.unsigned_abs() > HIGHEST_INDEX as u32) {
                return Err(LatticeError::IndexRange { cell, index });
            }
        }
        let limit = memory::limit(Some(memory_limit));
        memory::check(memory::needed_bytes(cells.len() as u64), limit, cell_size)?;
        let input = GridSet::new(cells.to_vec());
        let joined = components::join(input.clone(), join, cell_size, limit)?;
        let report = LatticeReport {
            surface_cells: input.len(),
            bridge_cells: joined.bridge_cells,
            floating: joined.floating_parts(&input),
            ..LatticeReport::default()
        };
        assemble::lattice(joined.cells, cell_size, origin, report, limit)
    }
}

/// Returns an error if the cell size is not positive and finite.
fn check_cell_size(cell_size: f64) -> Result<(), LatticeError> {
    if cell_size > 0.0 && cell_size.is_finite() { Ok(()) } else { Err(LatticeError::CellSize(cell_size)) }
}
