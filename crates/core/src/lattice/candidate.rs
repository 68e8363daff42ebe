//! The cells of a surface at one cell size, within a limit of memory.

use super::components::{self, Joined};
use super::{Lattice, LatticeError, LatticeReport, assemble, memory};
use crate::mesh::{Component, Mesh, RelativeMeasure};
use crate::voxel::{self, Grid, Voxels, voxelize};

/// Relative difference of volumes that rounding may make.
const NO_DIFFERENCE: f64 = 1e-3;

/// The cells of an open surface that encloses less than this fraction of them, and no other cells, are a sheet.
const SHEET: f64 = 0.25;

/// The cells of a surface at one cell size.
pub(super) struct Candidate {
    grid: Grid,
    voxels: Voxels,
    joined: Joined,
    /// Number of lattice vertices that they make.
    pub(super) vertices: usize,
}

/// What each candidate is made from.
pub(super) struct Request<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) join: bool,
    /// Bytes that may be taken.
    pub(super) limit: u64,
}

impl Request<'_> {
    /// The cells at a cell size. The memory is known before it is taken: that of the grid from its size, that of the lattice from the
    /// bits of the grid.
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

    /// Adds the way out to an error of too much memory.
    pub(super) fn with_way_out(&self, error: LatticeError) -> LatticeError {
        match error {
            LatticeError::TooMuchMemory { cell_size, needed, limit, .. } => {
                LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: self.fitting(cell_size) }
            }
            other => other,
        }
    }

    /// A cell size that fits where the given one does not; none where even a single cell does not.
    fn fitting(&self, refused: f64) -> Option<f64> {
        let bounds = &self.mesh.bounds();
        // No lattice has more vertices than the whole grid has corners.
        let surely = |cell_size: f64| {
            let counts = Grid::counts(bounds, cell_size);
            let corners: f64 = counts.iter().map(|n| n + 1.0).product();
            voxel::bytes(counts) <= self.limit as f64 && memory::of_vertices(corners as u64) <= self.limit
        };
        let mut sure = round_up((bounds.1 - bounds.0).amax());
        if !sure.is_finite() || !surely(sure) {
            return None;
        }
        let mut unsure = refused;
        while sure > unsure * 1.01 {
            let middle = round_up(sure.sqrt() * unsure.sqrt());
            if middle >= sure {
                break;
            }
            if surely(middle) { sure = middle } else { unsure = middle }
        }
        // Most lattices fill little of the grid: see how far a finer one may go. Not far below the size that is sure,
        // since each try voxelizes.
        let mut finer = refused.max(round_up(sure / FINER));
        while let Err(LatticeError::TooMuchMemory { needed, limit, .. }) = self.candidate(finer) {
            if voxel::bytes(Grid::counts(bounds, finer)) > self.limit as f64 {
                return Some(sure);
            }
            finer = round_up(finer * (needed as f64 / limit as f64).sqrt().max(1.05));
            if finer >= sure {
                return Some(sure);
            }
        }
        Some(finer)
    }
}

/// How much finer a lattice that fits is looked for than the size that surely does.
const FINER: f64 = 2.0;

/// The number itself or somewhat more, with three digits, so that it can be told in full.
fn round_up(x: f64) -> f64 {
    let unit = 10f64.powi(x.log10().floor() as i32 - 2);
    let rounded = (x / unit).ceil() * unit;
    if rounded.is_finite() && rounded >= x { rounded } else { x }
}

impl Candidate {
    /// The lattice of these cells.
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

/// Whether an open surface let the flood in: what it encloses, coned from its center, is more than the cells hold, or next to nothing.
fn is_shell(mesh: &Mesh, voxels: &Voxels, cell_size: f64) -> bool {
    if mesh.topology().boundary_edges == 0 {
        return false;
    }
    let measure = RelativeMeasure::of(mesh);
    let cells = voxels.cells.len() as f64 * (cell_size / measure.extent).powi(3);
    let solid = voxels.cells.len() > voxels.surface_cells;
    measure.volume > cells * (1.0 + NO_DIFFERENCE) || (!solid && measure.volume < SHEET * cells)
}
