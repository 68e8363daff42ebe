//! Voxelizes a surface at one cell size, within a memory limit.

use super::components::{self, Joined};
use super::{Lattice, LatticeError, LatticeReport, assemble, memory};
use crate::mesh::{Component, Mesh, RelativeMeasure};
use crate::voxel::{self, Grid, Voxels, voxelize};

/// Tolerance of the comparison of the mesh volume with the volume of the cells, relative to the latter.
const VOLUME_TOLERANCE: f64 = 1e-3;

/// An open surface is a sheet if it fills no cell and its volume is below this fraction of its cells' volume.
const SHEET_FRACTION: f64 = 0.25;

/// The cells of a surface at one cell size, from which a lattice can be built.
pub(super) struct Candidate {
    grid: Grid,
    voxels: Voxels,
    joined: Joined,
    /// Number of lattice vertices of the joined cells.
    pub(super) vertices: usize,
}

/// The input that all candidates of one lattice share.
pub(super) struct Request<'a> {
    pub(super) mesh: &'a Mesh,
    /// Whether floating parts are joined by bridges.
    pub(super) join: bool,
    /// Memory limit, in bytes.
    pub(super) limit: u64,
}

impl Request<'_> {
    /// Voxelizes the mesh at a cell size and joins its parts.
    ///
    /// Memory is checked before it is allocated: the grid's from the number of its cells, the lattice's from
    /// the number of its vertices.
    pub(super) fn candidate(&self, cell_size: f64) -> Result<Candidate, LatticeError> {
        let bounds = self.mesh.bounds();
        let needed = voxel::bytes(Grid::counts(&bounds, cell_size));
        memory::check(needed as u64, self.limit, cell_size)?;
        let too_many =
            LatticeError::TooMuchMemory { cell_size, needed: u64::MAX, limit: self.limit, fitting: None };
        let grid = Grid::new(bounds, cell_size).ok_or(too_many)?;
        let voxels = voxelize(self.mesh, &grid);
        let check = |count: usize| memory::check(memory::of_vertices(count as u64), self.limit, cell_size);
        check(assemble::count_vertices(&voxels.cells))?;
        let joined = components::join(voxels.cells.clone(), self.join, cell_size, self.limit)?;
        let vertices = assemble::count_vertices(&joined.cells);
        check(vertices)?;
        Ok(Candidate { grid, voxels, joined, vertices })
    }

    /// Adds a cell size that fits to [`LatticeError::TooMuchMemory`].
    pub(super) fn suggest_size(&self, error: LatticeError) -> LatticeError {
        match error {
            LatticeError::TooMuchMemory { cell_size, needed, limit, .. } => {
                LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: self.find_size(cell_size) }
            }
            other => other,
        }
    }

    /// Finds a cell size that fits the memory limit, given one that does not.
    ///
    /// Returns `None` if even a single cell does not fit.
    fn find_size(&self, too_fine: f64) -> Option<f64> {
        let bounds = &self.mesh.bounds();
        // An upper bound: no lattice has more vertices than the whole grid has corners.
        let certainly_fits = |cell_size: f64| {
            let counts = Grid::counts(bounds, cell_size);
            let corners: f64 = counts.iter().map(|n| n + 1.0).product();
            voxel::bytes(counts) <= self.limit as f64 && memory::of_vertices(corners as u64) <= self.limit
        };
        let mut coarse = round_up((bounds.1 - bounds.0).amax());
        if !coarse.is_finite() || !certainly_fits(coarse) {
            return None;
        }
        let mut fine = too_fine;
        while coarse > fine * 1.01 {
            let middle = round_up(coarse.sqrt() * fine.sqrt());
            if middle >= coarse {
                break;
            }
            if certainly_fits(middle) { coarse = middle } else { fine = middle }
        }
        // Most lattices fill a small part of the grid, so a smaller cell size may fit as well. The range of
        // the search is limited because each trial voxelizes the mesh.
        let mut finer = too_fine.max(round_up(coarse / MAX_REFINEMENT));
        while let Err(LatticeError::TooMuchMemory { needed, limit, .. }) = self.candidate(finer) {
            if voxel::bytes(Grid::counts(bounds, finer)) > self.limit as f64 {
                return Some(coarse);
            }
            finer = round_up(finer * (needed as f64 / limit as f64).sqrt().max(1.05));
            if finer >= coarse {
                return Some(coarse);
            }
        }
        Some(finer)
    }
}

/// Ratio of the cell size that certainly fits to the smallest cell size that is tried.
const MAX_REFINEMENT: f64 = 2.0;

/// Rounds a positive number up to three significant digits, so that a message can print it exactly.
///
/// Returns `x` where the result is not finite or is below `x`.
fn round_up(x: f64) -> f64 {
    let unit = 10f64.powi(x.log10().floor() as i32 - 2);
    let rounded = (x / unit).ceil() * unit;
    if rounded.is_finite() && rounded >= x { rounded } else { x }
}

impl Candidate {
    /// Builds the lattice of these cells, with its report.
    pub(super) fn build(self, request: &Request<'_>) -> Result<Lattice, LatticeError> {
        let mesh = request.mesh;
        let Self { grid, voxels, joined, .. } = self;
        let filled_cells = voxels.cells.len() - voxels.surface_cells;
        let mut floating = joined.floating_parts(&voxels.cells);
        let mut components_of_part = vec![Vec::new(); joined.parts.count];
        for (component, Component { first_face, .. }) in mesh.topology().components.iter().enumerate() {
            let vertex = mesh.face(*first_face)[0];
            if let Some(cell) = voxels.cells.locate(grid.place(&mesh.vertices()[vertex as usize])) {
                let part = joined.parts.of_run[voxels.cells.run_of(cell)];
                components_of_part[part as usize].push(component as u32);
            }
        }
        let glued = components_of_part.iter().filter(|components| components.len() > 1).cloned().collect();
        components_of_part.remove(joined.largest as usize);
        for (part, components) in floating.iter_mut().zip(components_of_part) {
            part.mesh_components = components;
        }
        let report = LatticeReport {
            surface_cells: voxels.surface_cells,
            filled_cells,
            bridge_cells: joined.bridge_cells,
            shell: is_shell(mesh, &voxels, grid.cell_size),
            floating,
            glued,
        };
        assemble::lattice(joined.cells, grid.cell_size, grid.origin(), report, request.limit)
    }
}

/// Returns whether the cells of an open surface are a layer along it and not the solid inside it.
///
/// This is so if the volume of the mesh (coned from the center of its bounds) exceeds the volume of the
/// cells, or if no cell is filled and the mesh volume is below [`SHEET_FRACTION`] of the cell volume.
fn is_shell(mesh: &Mesh, voxels: &Voxels, cell_size: f64) -> bool {
    if mesh.topology().boundary_edges == 0 {
        return false;
    }
    let measure = RelativeMeasure::of(mesh);
    let cells = voxels.cells.len() as f64 * (cell_size / measure.extent).powi(3);
    let filled = voxels.cells.len() > voxels.surface_cells;
    measure.volume > cells * (1.0 + VOLUME_TOLERANCE) || (!filled && measure.volume < SHEET_FRACTION * cells)
}
