//! The planes of the cracks, and their staircases: the faces between cells on opposite sides of a plane.

use nalgebra::{Point3, Vector3};

use crate::lattice::Lattice;
use crate::voxel::step;

/// The plane of a crack, in the model frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackPlane {
    /// A point of the plane.
    pub point: Point3<f64>,
    /// A normal of the plane, of any length. A plane whose normal is zero or not finite does not attract the cut.
    pub normal: Vector3<f64>,
}

impl CrackPlane {
    /// Returns whether the center of a cell is on the positive side of the plane. The joints that a crack breaks are
    /// joints between cells on opposite sides.
    ///
    /// * `cell`: grid index `[x, y, z]` of the cell.
    pub fn is_positive(&self, lattice: &Lattice, cell: [i32; 3]) -> bool {
        self.in_grid(lattice).is_positive(0, cell)
    }
}

/// Grid index of a cell.
pub(super) type Cell = [i32; 3];

/// The face between a cell and the next cell along an axis.
pub(super) type Face = (Cell, usize);

/// The planes of the cracks, with lengths in cells from the origin of the lattice.
pub(in crate::fracture) struct Planes {
    planes: Vec<(Vector3<f64>, f64)>,
    origin: Point3<f64>,
    cell_size: f64,
}

impl Planes {
    pub(super) fn new(lattice: &Lattice, cracks: &[CrackPlane]) -> Self {
        let plane = |crack: &CrackPlane| {
            let normal = crack.normal.try_normalize(0.0).unwrap_or_default();
            let offset = normal.dot(&((crack.point - lattice.origin()) / lattice.cell_size()));
            if normal.iter().all(|x| x.is_finite()) && offset.is_finite() {
                (normal, offset)
            } else {
                (Vector3::zeros(), 0.0)
            }
        };
        let planes = cracks.iter().map(plane).collect();
        Self { planes, origin: lattice.origin(), cell_size: lattice.cell_size() }
    }

    /// Returns the unit normal of a plane, or zero.
    pub(super) fn normal(&self, crack: u32) -> Vector3<f64> {
        self.planes[crack as usize].0
    }

    /// Returns the number of cracks.
    pub(super) fn count(&self) -> u32 {
        self.planes.len() as u32
    }

    /// Iterates over the cracks that have a plane.
    pub(super) fn cracks(&self) -> impl Iterator<Item = u32> {
        (0..self.count()).filter(|&crack| self.normal(crack) != Vector3::zeros())
    }

    /// Returns the distance from a plane within which the corners of its staircase are: half of the extent of a cell
    /// along the normal.
    pub(super) fn half_width(&self, crack: u32) -> f64 {
        0.5 * self.normal(crack).abs().sum()
    }

    /// Returns the signed distance of a point from a plane.
    pub(super) fn distance(&self, crack: u32, point: &Vector3<f64>) -> f64 {
        let (normal, offset) = &self.planes[crack as usize];
        normal.dot(point) - offset
    }

    /// Returns the signed distance in cells of a position in the model frame from a plane.
    pub(super) fn distance_of(&self, crack: u32, position: &Point3<f64>) -> f64 {
        self.distance(crack, &((position - self.origin) / self.cell_size))
    }

    /// Returns whether the center of a cell is on the positive side of a plane.
    pub(super) fn is_positive(&self, crack: u32, cell: Cell) -> bool {
        let center = Vector3::from(cell.map(|x| f64::from(x) + 0.5));
        self.distance(crack, &center) >= 0.0
    }

    /// Returns whether a face is between cells on opposite sides of a plane.
    pub(in crate::fracture) fn is_between(&self, crack: u32, (cell, axis): Face) -> bool {
        self.is_positive(crack, cell) != self.is_positive(crack, step(cell, axis, 1))
    }
}

impl CrackPlane {
    /// Prepares the plane for tests of many joints.
    pub(in crate::fracture) fn in_grid(&self, lattice: &Lattice) -> Planes {
        Planes::new(lattice, std::slice::from_ref(self))
    }
}

/// Returns the faces that share an edge with a face and separate cells on opposite sides of a crack's plane.
pub(super) fn staircase_neighbors(planes: &Planes, crack: u32, (cell, axis): Face) -> Vec<Face> {
    let mut neighbors = Vec::with_capacity(12);
    for other in (0..3).filter(|&other| other != axis) {
        for side in [-1, 1] {
            let beside = step(cell, other, side);
            let (low, high) = (step(cell, other, side.min(0)), step(step(cell, axis, 1), other, side.min(0)));
            neighbors.extend([(beside, axis), (low, other), (high, other)]);
        }
    }
    neighbors.retain(|&face| planes.is_between(crack, face));
    neighbors
}
