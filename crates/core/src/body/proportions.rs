//! The size of a body, and how long and how wide it is.

use nalgebra::Matrix3;

use super::surface::Surface;
use crate::dynamics::vertex_moments;
use crate::lattice::Lattice;
use crate::mesh::{Interior, Mesh, RelativeMeasure};
use crate::state::index_bounds;
use crate::volume::MIN_VOLUME_FRACTION;

/// Least size L of a body without volume, as a fraction of its largest extent: the bounding box of a flat sheet has
/// none.
const LEAST_SIZE: f64 = 0.1;

/// The lengths of a body, of the volume inside its mesh, or of the cells of a bare lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proportions {
    /// The size L in scene units: the cube root of the volume. Without volume, that of the bounding box, at least
    /// [`LEAST_SIZE`] of its longest side. It is the length scale of presets and of the limit of sleep.
    pub(super) size: f64,
    /// Ratio of the length to the width: the root of the ratio of the greatest two principal second moments of the
    /// volume. It is 1 for a body without volume, for cubes, balls and plates, and s for a bar of 1 x 1 x s.
    pub(super) slenderness: f64,
    /// The least width in scene units: that of a box with the least principal second moment of the volume, but at most
    /// 6 V/A with the volume V and the area A, three times the thickness of a thin wall. It is 0 for a body without volume.
    /// Meshes of rough or overlapping parts have more area, and so less width; open ones have less area.
    pub(super) least_width: f64,
}

impl Proportions {
    /// Measures a body. `masses`: those of the vertices, in full cells.
    pub(super) fn of(lattice: &Lattice, surface: Option<&Surface>, masses: &[f32]) -> Self {
        let mesh = surface.map(|surface| &surface.mesh);
        let Some(volume) = volume_of(lattice, mesh, masses) else {
            let (low, high) = mesh.map(Mesh::bounds).unwrap_or_default();
            let extents = high - low;
            let size = libm::cbrt(extents.product()).max(LEAST_SIZE * extents.max());
            return Self { size, slenderness: 1.0, least_width: 0.0 };
        };
        let cell = lattice.cell_size().powi(2);
        let moments = match mesh {
            Some(mesh) if mesh.interior() == Interior::Closed => mesh.second_moments(),
            _ => cell * second_moments_of_cells(lattice, masses),
        };
        let area = match mesh.map(RelativeMeasure::new) {
            Some(measure) => measure.area * measure.extent.powi(2),
            None => cell * free_faces(lattice) as f64,
        };
        let mut moments = moments.symmetric_eigenvalues();
        moments.as_mut_slice().sort_by(f64::total_cmp);
        // A body is at least as wide as a cell.
        let [least, middle, greatest] = [0, 1, 2].map(|k| moments[k].max(cell / 12.0));
        Self {
            size: libm::cbrt(volume),
            slenderness: (greatest / middle).sqrt(),
            least_width: (12.0 * least).sqrt().min(6.0 * volume / area),
        }
    }
}

/// Returns the volume inside the mesh, or that of the cells of a bare lattice. `None` for a sheet and for a mesh that
/// encloses next to nothing.
fn volume_of(lattice: &Lattice, mesh: Option<&Mesh>, masses: &[f32]) -> Option<f64> {
    let cell_volume = lattice.cell_size().powi(3);
    let cells = cell_volume * lattice.cells().len() as f64;
    let Some(mesh) = mesh else { return Some(cells) };
    let volume = match mesh.interior() {
        Interior::Closed => mesh.volume(),
        Interior::WindingNumber => cell_volume * masses.iter().map(|&mass| f64::from(mass)).sum::<f64>(),
        Interior::Sheet => 0.0,
    };
    (volume > MIN_VOLUME_FRACTION * cells).then_some(volume)
}

/// Returns the second moments of the mass of a lattice about its center, relative to the mass, in squared cells.
fn second_moments_of_cells(lattice: &Lattice, masses: &[f32]) -> Matrix3<f64> {
    let (mass, _, moments) = vertex_moments(lattice, masses);
    // The mass of a cell is at its corners: 1/4 per axis in place of 1/12.
    moments / mass - Matrix3::identity() / 6.0
}

/// Returns the number of faces of cells that no other cell has.
fn free_faces(lattice: &Lattice) -> usize {
    let faces_after = |&[x, y, z]: &[i32; 3]| {
        let after = [[x + 1, y, z], [x, y + 1, z], [x, y, z + 1]];
        after.iter().filter(|&&cell| lattice.cell_at(cell).is_some()).count()
    };
    let shared: usize = lattice.cells().iter().map(faces_after).sum();
    6 * lattice.cells().len() - 2 * shared
}

/// Returns the longest side of the bounding box of the mesh, or of a bare lattice.
pub(super) fn longest_side(lattice: &Lattice, surface: Option<&Surface>) -> f64 {
    match surface {
        Some(Surface { mesh, .. }) => {
            let (low, high) = mesh.bounds();
            (high - low).max()
        }
        None => extent(lattice) as f64 * lattice.cell_size(),
    }
}

/// Returns the largest extent of a lattice along an axis, in cells.
pub(super) fn extent(lattice: &Lattice) -> usize {
    let (low, high) = index_bounds(lattice.indices());
    (0..3).map(|c| high[c].abs_diff(low[c]) as usize).max().unwrap_or(1)
}
