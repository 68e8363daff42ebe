//! The exact signed volume of the embedded surface.

use super::line::{Line, Moving, determinant};
use super::patch::Patch;
use super::sums::{ChunkedSum, DETERMINANTS, add};
use crate::parallel::Executor;

/// Surface points in a batch: what one thread embeds at a time.
const BATCH: usize = 1024;

/// Patches in a chunk.
const PATCHES: usize = 64;

/// One mesh vertex that the measure needs: where it lies in its cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    /// Lattice vertices at the corners of the cell; corner `k` lies at `(k & 1, k >> 1 & 1, k >> 2 & 1)`.
    pub(super) corners: [u32; 8],
    /// Trilinear coordinates in the cell.
    pub(super) local: [f32; 3],
}

/// Sum over the triangles of `det[a, b, c] / 6`. The surface is linear in the lattice: a point on it moves along a
/// straight line as the lattice vertices do, and the volume is an exact cubic.
///
/// Where many triangles lie in one cell they are a [`Patch`]; of a fine mesh in a coarse lattice, that leaves those
/// that cross from cell to cell.
#[derive(Clone, Debug)]
pub(super) struct MeshMeasure {
    patches: Vec<Patch>,
    patch_sums: ChunkedSum,
    points: Vec<SurfacePoint>,
    triangles: Vec<[u32; 3]>,
    triangle_sums: ChunkedSum,
    embedded: Vec<Batch>,
}

/// The parts of a [`MeshMeasure`], one component after the other.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) patches: Vec<Patch>,
    /// Patches of each component.
    pub(super) patch_counts: Vec<usize>,
    /// Other triangles, of `points`, turned outwards (inwards for a cavity).
    pub(super) triangles: Vec<[u32; 3]>,
    /// Other triangles of each component.
    pub(super) triangle_counts: Vec<usize>,
    pub(super) points: Vec<SurfacePoint>,
}

/// The embedded points of a batch.
#[derive(Clone, Debug)]
struct Batch {
    first: usize,
    points: Vec<Moving>,
}

impl MeshMeasure {
    pub(super) fn new(parts: Parts) -> Self {
        let Parts { patches, patch_counts, triangles, triangle_counts, points } = parts;
        let batch = |first: usize| {
            let count = BATCH.min(points.len() - first);
            Batch { first, points: vec![Moving::default(); count] }
        };
        Self {
            patches,
            patch_sums: ChunkedSum::new(&patch_counts, PATCHES),
            embedded: (0..points.len()).step_by(BATCH).map(batch).collect(),
            points,
            triangles,
            triangle_sums: ChunkedSum::new(&triangle_counts, DETERMINANTS),
        }
    }

    /// Adds the coefficients of each component to `out`.
    pub(super) fn add_coefficients(&mut self, executor: &Executor, lattice: &[Moving], out: &mut [[f64; 4]]) {
        let patches = &self.patches;
        self.patch_sums.add_to(executor, 1.0 / 6.0, out, |range| {
            let mut sum = [0.0; 4];
            for patch in &patches[range] {
                add(&mut sum, &patch.coefficients(lattice));
            }
            sum
        });
        let points = &self.points;
        executor.each(&mut self.embedded, |batch| {
            for (embedded, point) in batch.points.iter_mut().zip(&points[batch.first..]) {
                *embedded = embed(point, lattice);
            }
        });
        let (embedded, triangles) = (&self.embedded, &self.triangles);
        let line = |i: u32| -> Line { embedded[i as usize / BATCH].points[i as usize % BATCH].line() };
        self.triangle_sums.add_to(executor, 1.0 / 6.0, out, |range| {
            let mut sum = [0.0; 4];
            for triangle in &triangles[range] {
                let [a, b, c] = triangle.map(line);
                add(&mut sum, &determinant(a, b.minus(a), c.minus(a)));
            }
            sum
        });
    }
}

/// Trilinear interpolation, as the weighted sum of the corners.
#[inline]
fn embed(point: &SurfacePoint, lattice: &[Moving]) -> Moving {
    let [x, y, z] = point.local;
    let (x, y, z) = ([1.0 - x, x], [1.0 - y, y], [1.0 - z, z]);
    let mut sum = Moving::default();
    for (k, &corner) in point.corners.iter().enumerate() {
        sum.add_weighted(&lattice[corner as usize], x[k & 1] * y[k >> 1 & 1] * z[k >> 2 & 1]);
    }
    sum
}
