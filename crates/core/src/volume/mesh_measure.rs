//! The exact signed volume of the embedded surface.

use super::line::{Line, Moving, determinant};
use super::sums::{ChunkedSum, add};
use crate::parallel::Executor;

/// Surface points in a chunk: what one thread embeds at a time.
const CHUNK: usize = 1024;

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
#[derive(Clone, Debug)]
pub(super) struct MeshMeasure {
    points: Vec<SurfacePoint>,
    triangles: Vec<[u32; 3]>,
    embedded: Vec<Batch>,
    sums: ChunkedSum,
}

/// The embedded points of a chunk.
#[derive(Clone, Debug)]
struct Batch {
    first: usize,
    points: Vec<Moving>,
}

impl MeshMeasure {
    /// `triangles` of `points`, turned outwards (inwards for a cavity), grouped by component: `counts[c]` in each.
    pub(super) fn new(points: Vec<SurfacePoint>, triangles: Vec<[u32; 3]>, counts: &[usize]) -> Self {
        let embedded = (0..points.len())
            .step_by(CHUNK)
            .map(|first| Batch { first, points: vec![Moving::default(); CHUNK.min(points.len() - first)] })
            .collect();
        Self { points, triangles, embedded, sums: ChunkedSum::new(counts) }
    }

    pub(super) fn coefficients(&mut self, executor: &Executor, lattice: &[Moving], out: &mut [[f64; 4]]) {
        let points = &self.points;
        executor.each(&mut self.embedded, |batch| {
            let points = &points[batch.first..];
            for (embedded, point) in batch.points.iter_mut().zip(points) {
                *embedded = embed(point, lattice);
            }
        });
        let (embedded, triangles) = (&self.embedded, &self.triangles);
        let line = |i: u32| -> Line { embedded[i as usize / CHUNK].points[i as usize % CHUNK].line() };
        self.sums.sum(executor, 1.0 / 6.0, out, |range| {
            let mut sum = [0.0; 4];
            for triangle in &triangles[range] {
                let [a, b, c] = triangle.map(line);
                add(&mut sum, &determinant(a, b.minus(a), c.minus(a)));
            }
            sum
        });
    }
}

/// Trilinear interpolation, along x, then y, then z.
#[inline]
fn embed(point: &SurfacePoint, lattice: &[Moving]) -> Moving {
    let [x, y, z] = point.local;
    let edge =
        |k: usize| lattice[point.corners[k] as usize].towards(&lattice[point.corners[k + 1] as usize], x);
    let [front, back] = [0, 4].map(|k| edge(k).towards(&edge(k + 2), y));
    front.towards(&back, z)
}
