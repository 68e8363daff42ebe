//! The ways to a lattice: from a mesh, from given cells.

use nalgebra::Point3;

use super::candidate::Request;
use super::{
    Lattice, LatticeError, LatticeOptions, LatticeReport, Resolution, assemble, components, memory,
    resolution,
};
use crate::mesh::Mesh;
use crate::voxel::{GridSet, HIGHEST_INDEX};

impl Lattice {
    /// The lattice of a surface mesh: the cells that the surface passes through and those that it encloses.
    ///
    /// The bounding box is centerd on the grid. A cell that the surface merely touches is not occupied; a face that lies in a grid plane
    /// belongs to the cell on its inner side, so that a cube of n cells gives n^3, and a flat sheet one layer. A cell is enclosed
    /// iff no way leads to it from outside: an open mesh gives a layer of cells along the surface, where its openings are wider than
    /// a cell. That is told in the [report](Self::report).
    ///
    /// # Errors
    ///
    /// A cell size that is not positive and finite, fewer than 8 wished vertices, or more memory than allowed, with a cell size that
    /// would fit.
    pub fn from_mesh(mesh: &Mesh, options: &LatticeOptions) -> Result<Self, LatticeError> {
        let request = Request { mesh, join: options.join, limit: memory::limit(options.memory_limit) };
        let candidate = match options.resolution {
            Resolution::CellSize(cell_size) => {
                check_cell_size(cell_size)?;
                request.candidate(cell_size)
            }
            Resolution::Vertices(wished) => resolution::search(&request, wished),
        };
        candidate.and_then(|candidate| candidate.build(&request)).map_err(|error| request.with_way_out(error))
    }

    /// The lattice `factor` times as large, about the origin.
    ///
    /// # Errors
    ///
    /// If the factor, or what comes out, is not a positive, finite length.
    pub fn scaled(mut self, factor: f64) -> Result<Self, LatticeError> {
        check_cell_size(factor)?;
        self.cell_size *= factor;
        self.origin *= factor;
        check_cell_size(self.cell_size)?;
        Ok(self)
    }

    /// The lattice of the given cells, with their indices kept.
    ///
    /// * `cells`: grid indices `[x, y, z]` of the occupied cells, in any order; repeated ones count once. Each index lies between
    ///   -2^30 and 2^30.
    /// * `cell_size`: edge of a cell, a positive length.
    /// * `origin`: where vertex index `[0, 0, 0]` lies.
    /// * `join`: whether parts that float apart are tied together by bridges of cells, each along a shortest path from face to face.
    ///   Without, each is a component of its own.
    ///
    /// # Errors
    ///
    /// No cells, an index out of range, a cell size that is not positive and finite, an origin that is not finite, or more cells
    /// than half of the machine's memory holds.
    pub fn from_cells(
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
        let limit = memory::limit(None);
        memory::check(memory::of_vertices(cells.len() as u64), limit, cell_size)?;
        let mut sorted = cells.to_vec();
        sorted.sort_unstable_by_key(|&[x, y, z]| (z, y, x));
        let given = GridSet::from_sorted(&sorted);
        let joined = components::join(given.clone(), join, cell_size, limit)?;
        let report = LatticeReport {
            surface_cells: given.len(),
            bridge_cells: joined.bridge_cells,
            floating: joined.floating_parts(&given),
            ..LatticeReport::default()
        };
        assemble::lattice(joined.cells, cell_size, origin, report, limit)
    }
}

/// Refuses a cell size that is no positive, finite length.
fn check_cell_size(cell_size: f64) -> Result<(), LatticeError> {
    if cell_size > 0.0 && cell_size.is_finite() { Ok(()) } else { Err(LatticeError::CellSize(cell_size)) }
}
