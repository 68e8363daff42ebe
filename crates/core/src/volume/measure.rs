//! Evaluates the volume measures of a body: its volume as a cubic in the scale `lambda`.
//!
//! The measures are sums of determinants; `det[a, b, c]` is the scalar triple product `a . (b × c)`. Each
//! lattice vertex moves along a straight line as `lambda` changes, so each determinant is a cubic in
//! `lambda`.

use fearless_simd::{Simd, dispatch};

use super::adjacency::Adjacency;
use super::line::{CrossFactor, Determinants, Line, Moving, load};
use super::mesh_measure::MeshMeasure;
use super::sums::{CHUNK_DETERMINANTS, ChunkedSum, Scratch};
use super::surface::{self, Surface};
use super::{Preservation, VolumeError, VolumeMeasure};
use crate::lattice::{Lattice, Smoothing};
use crate::parallel::Executor;
use crate::simd::level;

/// Volume of each component of the lattice as an exact cubic in the scale `lambda`.
#[derive(Clone, Debug)]
pub(super) enum Measure {
    Lattice(DeterminantMeasure<6>),
    Cells(DeterminantMeasure<4>),
    Mesh(MeshMeasure),
}

impl Measure {
    /// Creates the chosen measure; `None` for [`Preservation::Off`].
    pub(super) fn choose(
        choice: Preservation,
        lattice: &Lattice,
        surface: Option<Surface<'_>>,
        adjacency: &Adjacency,
    ) -> Result<Option<Self>, VolumeError> {
        let mesh = || surface::measure(surface, lattice, adjacency);
        match choice {
            Preservation::Off => Ok(None),
            Preservation::Auto => {
                Ok(Some(mesh().map_or_else(|_| Self::cells(lattice, adjacency), Self::Mesh)))
            }
            Preservation::By(VolumeMeasure::Lattice) => Ok(Some(Self::lattice(adjacency))),
            Preservation::By(VolumeMeasure::Cells) => Ok(Some(Self::cells(lattice, adjacency))),
            Preservation::By(VolumeMeasure::Mesh) => mesh().map(|mesh| Some(Self::Mesh(mesh))),
        }
    }

    /// Creates the measure `lattice`.
    pub(super) fn lattice(adjacency: &Adjacency) -> Self {
        Self::Lattice(DeterminantMeasure::new(adjacency.neighbors.clone(), adjacency))
    }

    /// Creates the measure `cells`.
    pub(super) fn cells(lattice: &Lattice, adjacency: &Adjacency) -> Self {
        let faces = lattice.boundary_faces().map(|(_, face)| face).collect();
        Self::Cells(DeterminantMeasure::new(faces, adjacency))
    }

    /// Returns the kind of the measure.
    pub(super) fn kind(&self) -> VolumeMeasure {
        match self {
            Self::Lattice(_) => VolumeMeasure::Lattice,
            Self::Cells(_) => VolumeMeasure::Cells,
            Self::Mesh(_) => VolumeMeasure::Mesh,
        }
    }

    /// Returns the stencils of the smooth surface points of the measure `mesh`, if they are smooth.
    pub(super) fn smoothing(&self) -> Option<&Smoothing> {
        match self {
            Self::Mesh(measure) => measure.smoothing(),
            Self::Lattice(_) | Self::Cells(_) => None,
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Lattice(measure) => measure.bytes(),
            Self::Cells(measure) => measure.bytes(),
            Self::Mesh(measure) => measure.bytes(),
        }
    }

    /// Computes `scratch.coefficients` from `scratch.points`.
    pub(super) fn evaluate(&self, executor: &Executor, scratch: &mut Scratch) {
        scratch.coefficients.fill([0.0; 4]);
        match self {
            Self::Lattice(measure) => measure.add_coefficients(
                executor,
                scratch,
                1.0 / 8.0,
                |neighbors, points| dispatch!(level(), simd => vertex_sum(simd, neighbors, points)),
            ),
            Self::Cells(measure) => measure.add_coefficients(
                executor,
                scratch,
                1.0 / 24.0,
                |faces, points| dispatch!(level(), simd => face_sum(simd, faces, points)),
            ),
            Self::Mesh(measure) => measure.add_coefficients(executor, scratch),
        }
    }
}

/// Measure that is a sum of determinants, each of which depends on `N` lattice vertices.
#[derive(Clone, Debug)]
pub(super) struct DeterminantMeasure<const N: usize> {
    /// Lattice vertices of each determinant, sorted by component.
    terms: Vec<[u32; N]>,
    sums: ChunkedSum,
}

impl<const N: usize> DeterminantMeasure<N> {
    fn new(mut terms: Vec<[u32; N]>, adjacency: &Adjacency) -> Self {
        // All vertices of a term are in the same component.
        let component = |term: &[u32; N]| adjacency.component(term[0] as usize);
        let mut counts = vec![0; adjacency.component_count];
        terms.iter().for_each(|term| counts[component(term)] += 1);
        if counts.len() > 1 {
            terms.sort_by_key(component);
        }
        Self { terms, sums: ChunkedSum::new(&counts, CHUNK_DETERMINANTS) }
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.terms)
    }

    /// Adds `factor` times the sum of the determinants to the coefficients of each component. `sum`: returns
    /// the sum of the determinants of several terms.
    fn add_coefficients(
        &self,
        executor: &Executor,
        scratch: &mut Scratch,
        factor: f64,
        sum: fn(&[[u32; N]], &[Moving]) -> [f64; 4],
    ) {
        let Scratch { points, sums, coefficients, .. } = scratch;
        self.sums.add_to(executor, factor, sums, coefficients, |range| sum(&self.terms[range], points));
    }
}

/// Returns eight times the sum of the measure `lattice` (Takamatsu & Kanai 2009) over several vertices.
///
/// `neighbors`: the neighbors of each vertex, as in [`Adjacency::neighbors`].
///
/// The volume of a vertex is the volume of a parallelepiped around the vertex. Its edge vectors are `dx / 2`,
/// `dy / 2` and `dz / 2`, where `da` is the difference of the two neighbors along axis `a`. The volume is
/// therefore `det[dx, dy, dz] / 8`. A missing neighbor is replaced by the vertex itself. At rest a vertex on
/// a face of a box then has the volume of half a cell, on an edge a quarter of a cell and at a corner an
/// eighth of a cell, so that the volume of a box of cells is exact.
#[inline(always)]
fn vertex_sum<S: Simd>(simd: S, neighbors: &[[u32; 6]], points: &[Moving]) -> [f64; 4] {
    let mut sum = Determinants::zero(simd);
    for vertex_neighbors in neighbors {
        let [x0, x1, y0, y1, z0, z1] = load(simd, points, vertex_neighbors);
        sum.add(Line::zxy(simd, x1 - x0), CrossFactor::new(simd, y1 - y0), CrossFactor::new(simd, z1 - z0));
    }
    sum.coefficients()
}

/// Returns 24 times the sum over several boundary faces of their contributions to the measure `cells`, the
/// exact volume of the trilinear cells.
///
/// The contributions of interior faces cancel. A face of a trilinear cell is a bilinear patch with the
/// corners a, b, c, d, in counter-clockwise order seen from outside. Its contribution is the mean of the
/// contributions of its two triangulations: `(a + b + c + d) . ((c - a) × (d - b)) / 24`.
#[inline(always)]
fn face_sum<S: Simd>(simd: S, faces: &[[u32; 4]], points: &[Moving]) -> [f64; 4] {
    let mut sum = Determinants::zero(simd);
    for face in faces {
        let [a, b, c, d] = load(simd, points, face);
        let corner_sum =
            Line::zxy(simd, a).plus(Line::zxy(simd, b)).plus(Line::zxy(simd, c).plus(Line::zxy(simd, d)));
        sum.add(corner_sum, CrossFactor::new(simd, c - a), CrossFactor::new(simd, d - b));
    }
    sum.coefficients()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::lattice::{Embedding, FACE_CORNERS};
    use crate::mesh::Mesh;

    /// Returns a pseudo-random number with six fractional bits, so that `p + lambda v` in the test below is
    /// exact in f32.
    fn dyadic(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 22) as f32 / 64.0 - 8.0
    }

    /// Creates the three measures of a box of cells.
    fn measures(lattice: &Lattice, adjacency: &Adjacency) -> [Measure; 3] {
        // A box a quarter of a cell inside the bounding box of the cells.
        let corner = |k: i32| [k & 1, k >> 1 & 1, k >> 2 & 1];
        let high = [0, 1, 2].map(|a| lattice.cells().iter().map(|cell| cell[a] + 1).max().unwrap());
        let vertices = (0..8).map(|k| {
            let k = corner(k);
            std::array::from_fn(|a| if k[a] == 0 { 0.25 } else { f64::from(high[a]) - 0.25 })
        });
        let mesh = Mesh::new(vertices.collect(), &FACE_CORNERS.map(|f| f.map(|k| k as u32))).unwrap();
        let embedding = Embedding::new(lattice, mesh.vertices());
        let surface = Some(Surface { mesh: &mesh, embedding: &embedding });
        let mesh = Preservation::By(VolumeMeasure::Mesh);
        let mesh = Measure::choose(mesh, lattice, surface, adjacency).unwrap().unwrap();
        [Measure::lattice(adjacency), Measure::cells(lattice, adjacency), mesh]
    }

    fn block(n: [i32; 3]) -> Lattice {
        let cells: Vec<_> =
            (0..n[0] * n[1] * n[2]).map(|i| [i % n[0], i / n[0] % n[1], i / n[0] / n[1]]).collect();
        Lattice::from_cells(&cells, 1.0, Point3::origin(), true).unwrap()
    }

    fn random_points(n: usize) -> Scratch {
        let mut state = 7;
        let mut vector = || std::array::from_fn(|_| dyadic(&mut state));
        let mut scratch = Scratch::default();
        scratch.points = (0..n).map(|_| Moving::new(vector(), vector())).collect();
        scratch.coefficients = vec![[0.0; 4]];
        scratch
    }

    #[test]
    fn cubic_coefficients_match_direct_evaluation() {
        let lattice = block([3, 2, 2]);
        let adjacency = Adjacency::new(&lattice);
        let mut scratch = random_points(lattice.len());
        let executor = Executor::sequential();
        for measure in measures(&lattice, &adjacency) {
            measure.evaluate(&executor, &mut scratch);
            let c = scratch.coefficients[0];
            for lambda in [-3.0_f32, -1.0, -0.5, 0.0, 0.25, 1.5, 7.0] {
                let mut moved = scratch.clone();
                for point in &mut moved.points {
                    let (p, v) = (point.position(), point.direction());
                    *point = Moving::new(std::array::from_fn(|k| p[k] + lambda * v[k]), [0.0; 3]);
                }
                measure.evaluate(&executor, &mut moved);
                let direct = moved.coefficients[0];
                let x = f64::from(lambda);
                let value = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
                let size =
                    c[0].abs() + x.abs() * (c[1].abs() + x.abs() * (c[2].abs() + x.abs() * c[3].abs()));
                assert!(
                    (value - direct[0]).abs() <= 1e-13 * size,
                    "{} at {x}: {value} {}",
                    measure.kind(),
                    direct[0]
                );
                assert_eq!(direct[1..], [0.0; 3]);
            }
        }
    }

    #[test]
    fn measures_are_thread_count_independent() {
        let lattice = block([40, 30, 20]);
        let adjacency = Adjacency::new(&lattice);
        let mut scratch = random_points(lattice.len());
        let two_threads = Executor::new(2);
        for measure in measures(&lattice, &adjacency) {
            let mut evaluated = |executor| {
                measure.evaluate(executor, &mut scratch);
                scratch.coefficients[0].map(f64::to_bits)
            };
            assert_eq!(evaluated(&Executor::sequential()), evaluated(&two_threads));
        }
    }
}
