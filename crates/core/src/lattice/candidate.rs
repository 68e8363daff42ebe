//! The cells of a surface at one cell size, within a limit of memory.

use super::assemble::{self, Joined};
use super::bitmap::Bitmap;
use super::grid::Grid;
use super::locate::locate;
use super::report::LatticeReport;
use super::surface::Surface;
use super::voxelise::{Voxels, voxelise};
use super::{Lattice, LatticeError, corners, memory};

/// Bitmaps that voxelising takes at most: cells entered, cells reached, and three for each axis with faces in grid planes.
const BITMAPS: f64 = 11.0;

/// Relative difference of volumes that rounding may make.
const NO_DIFFERENCE: f64 = 1e-3;

/// The cells of an open surface that encloses less than this fraction of them, and no other cells, are a sheet.
const SHEET: f64 = 0.25;

/// Bytes of a row that waits for the flood.
const ROW_BYTES: f64 = 17.0;

/// The cells of a surface at one cell size.
pub(crate) struct Candidate {
    grid: Grid,
    voxels: Voxels,
    joined: Joined,
    /// Number of lattice vertices that they make.
    pub(crate) vertices: usize,
}

/// What each candidate is made from.
pub(crate) struct Request<'a> {
    pub(crate) surface: &'a Surface<'a>,
    pub(crate) join: bool,
    /// Bytes that may be taken.
    pub(crate) limit: u64,
}

impl Request<'_> {
    /// The cells at a cell size. The memory is known before it is taken: that of the grid from its size, that of the lattice from the
    /// bits of the grid.
    pub(crate) fn candidate(&self, cell_size: f64) -> Result<Candidate, LatticeError> {
        let Surface { vertices, triangles, bounds, .. } = self.surface;
        let needed = grid_bytes(Grid::counts(bounds, cell_size));
        memory::check(needed as u64, self.limit, cell_size)?;
        let grid = Grid::new(*bounds, cell_size);
        let too_many =
            LatticeError::TooMuchMemory { cell_size, needed: u64::MAX, limit: self.limit, fitting: None };
        let grid = grid.ok_or(too_many)?;
        let voxels = voxelise(vertices, triangles, &grid);
        let check = |count: usize| memory::check(memory::of_vertices(count as u64), self.limit, cell_size);
        check(corners::count(&voxels.cells))?;
        let joined = assemble::join(voxels.cells.clone(), self.join, cell_size, self.limit)?;
        let vertices = corners::count(&joined.cells);
        check(vertices)?;
        Ok(Candidate { grid, voxels, joined, vertices })
    }

    /// Adds the way out to an error of too much memory.
    pub(crate) fn with_way_out(&self, error: LatticeError) -> LatticeError {
        match error {
            LatticeError::TooMuchMemory { cell_size, needed, limit, .. } => {
                LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: self.fitting(cell_size) }
            }
            other => other,
        }
    }

    /// A cell size that fits where the given one does not; none where even a single cell does not.
    fn fitting(&self, refused: f64) -> Option<f64> {
        let bounds = &self.surface.bounds;
        // No lattice has more vertices than the whole grid has corners.
        let surely = |cell_size: f64| {
            let counts = Grid::counts(bounds, cell_size);
            let corners: f64 = counts.iter().map(|n| n + 1.0).product();
            grid_bytes(counts) <= self.limit as f64 && memory::of_vertices(corners as u64) <= self.limit
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
        // since each try voxelises.
        let mut finer = refused.max(round_up(sure / FINER));
        while let Err(LatticeError::TooMuchMemory { needed, limit, .. }) = self.candidate(finer) {
            if grid_bytes(Grid::counts(bounds, finer)) > self.limit as f64 {
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

/// Bytes that voxelising takes in a grid of so many cells along each axis.
fn grid_bytes(counts: [f64; 3]) -> f64 {
    BITMAPS * Bitmap::bytes(counts) + ROW_BYTES * Bitmap::row_count_of(counts)
}

/// The number itself or somewhat more, with three digits, so that it can be told in full.
fn round_up(x: f64) -> f64 {
    let unit = 10f64.powi(x.log10().floor() as i32 - 2);
    let rounded = (x / unit).ceil() * unit;
    if rounded.is_finite() && rounded >= x { rounded } else { x }
}

impl Candidate {
    /// The lattice of these cells.
    pub(crate) fn build(self, request: &Request<'_>) -> Result<Lattice, LatticeError> {
        let surface = request.surface;
        let Self { grid, voxels, joined, .. } = self;
        let filled_cells = voxels.cells.len() - voxels.surface_cells;
        let mut floating = assemble::floating_parts(&voxels.cells, &joined);
        let mut components_of_part = vec![Vec::new(); joined.parts.count];
        for (component, vertex) in surface.components.iter().enumerate() {
            if let Some(cell) = locate(&voxels.cells, grid.place(&surface.vertices[*vertex as usize])) {
                let part = joined.parts.of_run[voxels.cells.run_of(cell)];
                components_of_part[part as usize].push(component as u32);
            }
        }
        let glued = components_of_part.iter().filter(|components| components.len() > 1).cloned().collect();
        let largest = super::join::largest(&voxels.cells, &joined.parts);
        components_of_part.remove(largest as usize);
        for (part, components) in floating.iter_mut().zip(components_of_part) {
            part.mesh_components = components;
        }
        let report = LatticeReport {
            surface_cells: voxels.surface_cells,
            filled_cells,
            bridge_cells: joined.bridge_cells,
            shell: !surface.closed && is_shell(surface, &voxels, grid.cell_size),
            floating,
            glued,
        };
        assemble::lattice(joined.cells, grid.cell_size, grid.origin(), report, request.limit)
    }
}

/// Whether an open surface let the flood in: what it encloses, coned from its centre, is more than the cells hold, or next to nothing.
fn is_shell(surface: &Surface<'_>, voxels: &Voxels, cell_size: f64) -> bool {
    let measure = surface.measure();
    let cells = voxels.cells.len() as f64 * (cell_size / measure.extent).powi(3);
    let solid = voxels.cells.len() > voxels.surface_cells;
    measure.volume > cells * (1.0 + NO_DIFFERENCE) || (!solid && measure.volume < SHEET * cells)
}
