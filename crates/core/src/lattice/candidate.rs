//! Voxelizes a surface at one cell size, within a memory limit.
//!
//! A *part* is a connected component of the cells before joining.

use super::components::{self, Joined};
use super::{Lattice, LatticeError, LatticeReport, assemble, memory};
use crate::mesh::{Component, Interior, Mesh, RelativeMeasure};
use crate::voxel::{Grid, TooMany, Voxels, voxelize};

/// Tolerance for the comparison of the mesh volume with the volume of the cells, as a fraction of the volume
/// of the cells.
const VOLUME_TOLERANCE: f64 = 1e-3;

/// An open surface that fills no cell gives a shell if the mesh volume is below this fraction of the volume
/// of the cells.
const SHELL_FRACTION: f64 = 0.25;

/// The cells of a surface at one cell size, from which a lattice can be built.
pub(super) struct Candidate {
    grid: Grid,
    voxels: Voxels,
    joined: Joined,
    /// Number of lattice vertices of the joined cells.
    pub(super) vertices: usize,
}

/// The input that all candidates of one lattice share.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub(super) mesh: &'a Mesh,
    /// Whether floating parts are joined by bridges.
    pub(super) join: bool,
    /// Memory limit, in bytes.
    pub(super) limit: u64,
}

impl Request<'_> {
    /// Voxelizes the mesh at a cell size and joins the parts of the cells.
    ///
    /// Voxelizing ends as soon as there is more than a lattice within the memory limit can have. The memory of the
    /// lattice follows from the number of its vertices.
    pub(super) fn candidate(&self, cell_size: f64) -> Result<Candidate, LatticeError> {
        let too_much =
            |needed| LatticeError::TooMuchMemory { cell_size, needed, limit: self.limit, fitting: None };
        let grid = Grid::new(self.mesh.bounds(), cell_size).ok_or_else(|| too_much(u64::MAX))?;
        let maxima = memory::maxima(self.limit);
        let voxels = voxelize(self.mesh, &grid, maxima).map_err(|too_many| {
            too_much(match too_many {
                TooMany::Cells(cells) => memory::needed_bytes_of_cells(cells),
                TooMany::Faces(faces) => memory::needed_bytes(faces),
            })
        })?;
        let check = |count: usize| memory::check(memory::needed_bytes(count as u64), self.limit, cell_size);
        let mut vertices = assemble::count_vertices(&voxels.cells);
        check(vertices)?;
        let joined = components::join(voxels.cells.clone(), self.join, cell_size, self.limit)?;
        if joined.bridge_cells > 0 {
            vertices = assemble::count_vertices(&joined.cells);
            check(vertices)?;
        }
        Ok(Candidate { grid, voxels, joined, vertices })
    }

    /// Sets `fitting` in [`LatticeError::TooMuchMemory`] to a cell size that fits the memory limit.
    ///
    /// Returns any other error unchanged.
    pub(super) fn suggest_size(&self, error: LatticeError) -> LatticeError {
        match error {
            LatticeError::TooMuchMemory { cell_size, needed, limit, .. } => {
                LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: self.find_size(cell_size) }
            }
            other => other,
        }
    }

    /// Finds a cell size that fits the memory limit, given a smaller cell size that does not fit.
    ///
    /// Returns `None` if even a single cell does not fit.
    fn find_size(&self, too_small: f64) -> Option<f64> {
        let bounds = &self.mesh.bounds();
        // Assumes that all cells of the grid are occupied, which needs the most memory.
        let certainly_fits = |cell_size: f64| {
            let corners: f64 = Grid::counts(bounds, cell_size).iter().map(|n| n + 1.0).product();
            memory::needed_bytes(corners as u64) <= self.limit
        };
        let mut certain = round_up((bounds.1 - bounds.0).amax());
        if !certain.is_finite() || !certainly_fits(certain) {
            return None;
        }
        // Bisection between a cell size that certainly fits and a cell size that possibly does not.
        let mut uncertain = too_small;
        while certain > uncertain * 1.01 {
            let middle = round_up(certain.sqrt() * uncertain.sqrt());
            if middle >= certain {
                break;
            }
            if certainly_fits(middle) { certain = middle } else { uncertain = middle }
        }
        // Most lattices occupy a small fraction of the grid, so a smaller cell size may fit as well. The
        // range of the search is limited because each trial voxelizes the mesh.
        let mut trial = too_small.max(round_up(certain / MAX_REFINEMENT));
        while let Err(LatticeError::TooMuchMemory { needed, limit, .. }) = self.candidate(trial) {
            trial = round_up(trial * (needed as f64 / limit as f64).sqrt().max(1.05));
            if trial >= certain {
                return Some(certain);
            }
        }
        Some(trial)
    }
}

/// Maximum ratio of the cell size that certainly fits to the smallest cell size that is tried.
const MAX_REFINEMENT: f64 = 2.0;

/// Rounds a positive number up to three significant digits, so that a message can print it exactly.
///
/// Returns `x` unchanged if the result would not be finite or would be below `x`.
fn round_up(x: f64) -> f64 {
    let unit = libm::pow(10.0, libm::log10(x).floor() - 2.0);
    let rounded = (x / unit).ceil() * unit;
    if rounded.is_finite() && rounded >= x { rounded } else { x }
}

impl Candidate {
    /// Returns the least cell size with which the grid around the mesh has as many cells along each axis, or `None` if not
    /// all cells of the grid are occupied.
    pub(super) fn least_size_of_box(&self, mesh: &Mesh) -> Option<f64> {
        let counts = self.grid.size();
        let (low, high) = mesh.bounds();
        let is_box = self.vertices == counts.map(|count| count + 1).iter().product();
        is_box.then(|| (0..3).map(|axis| (high[axis] - low[axis]) / counts[axis] as f64).fold(0.0, f64::max))
    }

    /// Builds the lattice of these cells, with its report.
    ///
    /// A mesh component belongs to the part that contains the first vertex of its first face.
    pub(super) fn build(self, request: &Request<'_>) -> Result<Lattice, LatticeError> {
        let mesh = request.mesh;
        let Self { grid, voxels, joined, .. } = self;
        let filled_cells = voxels.cells.len() - voxels.surface_cells;
        let mut floating = joined.floating_parts(&voxels.cells);
        let mut components_of_part = vec![Vec::new(); joined.parts.count];
        for (component, Component { first_face, .. }) in mesh.topology().components.iter().enumerate() {
            let vertex = mesh.face(*first_face)[0];
            if let Some(cell) = voxels.cells.locate(grid.cell_space(&mesh.vertices()[vertex as usize])) {
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

/// Returns whether the cells of an open surface are a shell: a layer along the surface, and not the solid
/// inside it.
///
/// The mesh volume is the sum of the signed volumes of the tetrahedra from the center of the bounding box to
/// the triangles. The cells are a shell if the mesh volume exceeds the volume of the cells, or if no cell is
/// filled and the mesh volume is below [`SHELL_FRACTION`] of the volume of the cells. The cells of a surface with
/// an interior are not a shell.
fn is_shell(mesh: &Mesh, voxels: &Voxels, cell_size: f64) -> bool {
    if mesh.interior() != Interior::Sheet || mesh.topology().boundary_edges == 0 {
        return false;
    }
    let measure = RelativeMeasure::new(mesh);
    let cells = voxels.cells.len() as f64 * (cell_size / measure.extent).powi(3);
    let filled = voxels.cells.len() > voxels.surface_cells;
    measure.volume > cells * (1.0 + VOLUME_TOLERANCE) || (!filled && measure.volume < SHELL_FRACTION * cells)
}
