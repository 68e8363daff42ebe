//! The measures, built from a lattice and its surface.

use super::adjacency::{Adjacency, DIRECTIONS};
use super::cell_measure::{CellMeasure, FACE_CORNERS};
use super::lattice_measure::LatticeMeasure;
use super::line::Moving;
use super::mesh_measure::MeshMeasure;
use super::surface::{self, Surface};
use super::{Preservation, VolumeError, VolumeMeasure};
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// A volume as an exact cubic of the scale `lambda`, for each component of the lattice.
#[derive(Clone, Debug)]
pub(super) enum Measure {
    Lattice(LatticeMeasure),
    Cells(CellMeasure),
    Mesh(MeshMeasure),
}

impl Measure {
    /// The measure that a choice means; none for [`Preservation::Off`].
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

    pub(super) fn lattice(adjacency: &Adjacency) -> Self {
        let rows = adjacency.rows().to_vec();
        Self::Lattice(LatticeMeasure::new(rows, adjacency.components(), adjacency.of_vertex()))
    }

    pub(super) fn cells(lattice: &Lattice, adjacency: &Adjacency) -> Self {
        let faces = boundary_faces(lattice).map(|(_, face)| face).collect();
        Self::Cells(CellMeasure::new(faces, adjacency.components(), adjacency.of_vertex()))
    }

    pub(super) fn kind(&self) -> VolumeMeasure {
        match self {
            Self::Lattice(_) => VolumeMeasure::Lattice,
            Self::Cells(_) => VolumeMeasure::Cells,
            Self::Mesh(_) => VolumeMeasure::Mesh,
        }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Lattice(measure) => measure.bytes(),
            Self::Cells(measure) => measure.bytes(),
            Self::Mesh(measure) => measure.bytes(),
        }
    }

    /// Sets the coefficients of `scratch` to those of its points.
    pub(super) fn evaluate(&self, executor: &Executor, scratch: &mut Scratch) {
        scratch.coefficients.fill([0.0; 4]);
        match self {
            Self::Lattice(measure) => measure.add_coefficients(executor, scratch),
            Self::Cells(measure) => measure.add_coefficients(executor, scratch),
            Self::Mesh(measure) => measure.add_coefficients(executor, scratch),
        }
    }
}

/// Beyond this a position is cut off, so that differences of positions stay finite.
const FARTHEST: f64 = 1e37;

/// Input, output and buffers of an evaluation. Grows to the size of the lattice once, and keeps its capacity.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Lattice vertices, relative to a center near their component, where single precision is fine enough for
    /// determinants.
    pub(super) points: Vec<Moving>,
    /// The coefficients of each component's volume in cubed cells, that of `lambda^k` at index `k`.
    pub(super) coefficients: Vec<[f64; 4]>,
    /// Surface points, and sums over chunks.
    pub(super) carried: Vec<Moving>,
    pub(super) sums: Vec<[f64; 4]>,
    /// Of each component: the sum of its positions, their number, and the center.
    centers: Vec<([f64; 3], f64, [f64; 3])>,
}

impl Scratch {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.points) + size_of_val(&*self.carried) + size_of_val(&*self.sums)
    }

    /// The places become `positions[i]` less the mean of the component; the directions are left as they are.
    pub(super) fn place(&mut self, positions: impl Iterator<Item = [f64; 3]> + Clone, adjacency: &Adjacency) {
        self.points.resize(adjacency.len(), Moving::default());
        self.coefficients.resize(adjacency.components(), [0.0; 4]);
        self.centers.clear();
        self.centers.resize(adjacency.components(), ([0.0; 3], 0.0, [0.0; 3]));
        for (p, &component) in positions.clone().zip(adjacency.of_vertex()) {
            let (sum, count, _) = &mut self.centers[component as usize];
            for (sum, p) in sum.iter_mut().zip(p) {
                *sum += p;
            }
            *count += 1.0;
        }
        for (sum, count, center) in &mut self.centers {
            // Whole cells: the subtraction is then exact for positions on the grid.
            *center = sum.map(|sum| (sum / *count).round());
        }
        for ((p, &component), point) in positions.zip(adjacency.of_vertex()).zip(&mut self.points) {
            let (_, _, center) = &self.centers[component as usize];
            point.set_place(std::array::from_fn(|k| (p[k] - center[k]).clamp(-FARTHEST, FARTHEST) as f32));
        }
    }

    /// The places become those of the lattice at rest.
    pub(super) fn place_at_rest(&mut self, lattice: &Lattice, adjacency: &Adjacency) {
        self.place(lattice.indices().iter().map(|index| index.map(f64::from)), adjacency);
    }
}

/// The links of a lattice.
pub(super) fn adjacency(lattice: &Lattice) -> Adjacency {
    let row = |i: u32| lattice.neighbours(i).map(|j| j.unwrap_or(i));
    let components = lattice.components();
    Adjacency::new(
        (0..lattice.len() as u32).map(row).collect(),
        components.of_vertex.clone(),
        components.count,
    )
}

/// The faces of cells that no other cell shares: the sides that they are, in neighbour order, and their corners,
/// counter-clockwise seen from outside.
pub(super) fn boundary_faces(lattice: &Lattice) -> impl Iterator<Item = (usize, [u32; 4])> {
    lattice.cells().iter().enumerate().flat_map(|(cell, index)| {
        let corners = lattice.cell_corners(cell as u32);
        let outer = DIRECTIONS.iter().zip(FACE_CORNERS).enumerate().filter(|(_, (direction, _))| {
            lattice.cell_at(std::array::from_fn(|k| index[k] + direction[k])).is_none()
        });
        outer.map(move |(side, (_, face))| (side, face.map(|corner| corners[corner])))
    })
}

/// Which of the eight cells around each vertex are occupied, as `boundary_normals` numbers them.
pub(super) fn octants(lattice: &Lattice) -> Vec<u8> {
    let mut octants = vec![0; lattice.len()];
    for cell in 0..lattice.cells().len() as u32 {
        for (corner, vertex) in lattice.cell_corners(cell).into_iter().enumerate() {
            // Seen from its corner `k`, a cell lies towards the opposite corner.
            octants[vertex as usize] |= 1 << (7 - corner);
        }
    }
    octants
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::lattice::Embedding;
    use crate::mesh::Mesh;

    /// Numbers with six bits after the point, so that `p + lambda v` below is exact in single precision.
    fn dyadic(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 22) as f32 / 64.0 - 8.0
    }

    fn measures(lattice: &Lattice, adjacency: &Adjacency) -> [Measure; 3] {
        // The boundary of the cells' box, a quarter of a cell inside it.
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
        let points = (0..n).map(|_| Moving::new(vector(), vector())).collect();
        Scratch { points, coefficients: vec![[0.0; 4]], ..Scratch::default() }
    }

    #[test]
    fn coefficients_are_those_of_direct_evaluation() {
        let lattice = block([3, 2, 2]);
        let adjacency = adjacency(&lattice);
        let mut scratch = random_points(lattice.len());
        let executor = Executor::sequential();
        for measure in measures(&lattice, &adjacency) {
            measure.evaluate(&executor, &mut scratch);
            let c = scratch.coefficients[0];
            for lambda in [-3.0_f32, -1.0, -0.5, 0.0, 0.25, 1.5, 7.0] {
                let mut moved = scratch.clone();
                for point in &mut moved.points {
                    let (p, v) = (point.place(), point.direction());
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
    fn threads_change_no_bit() {
        let lattice = block([40, 30, 20]);
        let adjacency = adjacency(&lattice);
        let mut scratch = random_points(lattice.len());
        let two = Executor::new(2);
        for measure in measures(&lattice, &adjacency) {
            let mut evaluated = |executor| {
                measure.evaluate(executor, &mut scratch);
                scratch.coefficients[0].map(f64::to_bits)
            };
            assert_eq!(evaluated(&Executor::sequential()), evaluated(&two));
        }
    }
}
