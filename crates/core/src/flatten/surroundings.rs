//! The lattice near a plane: distances of its vertices, and their derivatives.

use nalgebra::{Point3, Vector3};

use super::table::FlattenTable;
use crate::simd::xyzx::Xyzx;

/// The lattice near a plane.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    /// Signed distance of each lattice vertex.
    pub(super) distances: Vec<f32>,
    /// Derivatives of the distance along the axes of the rest shape at each lattice vertex, or NaN if they are not
    /// known.
    gradients: Vec<[f32; 3]>,
}

impl Surroundings {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.distances) + size_of_val(&*self.gradients)
    }

    /// Prepares for a lattice and a plane with a unit normal and an offset.
    pub(super) fn begin(&mut self, lattice: &[Xyzx], (normal, offset): (Vector3<f64>, f64)) {
        self.distances.clear();
        self.distances.extend(lattice.iter().map(|&[x, y, z, _]| {
            let [x, y, z] = [x, y, z].map(f64::from);
            (normal.x * x + normal.y * y + normal.z * z - offset) as f32
        }));
        self.gradients.clear();
        self.gradients.resize(lattice.len(), [f32::NAN; 3]);
    }

    /// Returns false only if no point of a cell is within a distance of the plane.
    pub(super) fn is_near(&self, corners: &[u32; 8], distance: f32) -> bool {
        corners.iter().any(|&corner| self.distances[corner as usize] < distance)
    }

    /// Returns the derivatives of the distance along the axes of the rest shape at a lattice vertex.
    pub(super) fn gradient(&mut self, vertex: u32, table: &FlattenTable) -> [f32; 3] {
        let Self { distances, gradients } = self;
        let gradient = &mut gradients[vertex as usize];
        if gradient[0].is_nan() {
            *gradient = table.stencils[vertex as usize].slopes(|vertex| distances[vertex as usize]);
        }
        *gradient
    }
}

/// Returns the center and half the size of the box around the corners of a cell.
pub(super) fn bounds(corners: &[u32; 8], lattice: &[Xyzx]) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for &corner in corners {
        let position = to_xyz(lattice[corner as usize]);
        low = std::array::from_fn(|k| low[k].min(position[k]));
        high = std::array::from_fn(|k| high[k].max(position[k]));
    }
    center_and_half(low, high)
}

/// Returns the center of a box and half its size.
pub(super) fn center_and_half(low: [f32; 3], high: [f32; 3]) -> (Point3<f64>, Vector3<f64>) {
    let [low, high] = [low, high].map(|corner| Vector3::from(corner.map(f64::from)));
    (Point3::from((low + high) / 2.0), (high - low) / 2.0)
}

pub(super) fn to_xyz([x, y, z, _]: Xyzx) -> [f32; 3] {
    [x, y, z]
}

/// Returns a position plus a displacement.
pub(super) fn displaced(position: [f32; 3], offset: [f32; 3]) -> Point3<f64> {
    Point3::from(std::array::from_fn(|k| f64::from(position[k]) + f64::from(offset[k])))
}
