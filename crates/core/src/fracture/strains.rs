//! The strain of the joints of a deformed lattice.

use nalgebra::{Matrix3, Quaternion, Vector3, Vector4};

use crate::lattice::{Joint, Lattice, Layout};
use crate::matching::HalfWidth;
use crate::simd::lanes::{Lanes, block_and_lane};

/// The deformation of a body in a step, beside the gradients of its regions.
pub(crate) struct Deformation<'a> {
    pub lattice: &'a Lattice,
    pub layout: &'a Layout,
    /// Rotation of the region around each vertex: unit quaternions (x, y, z, w).
    pub rotations: &'a Lanes<4>,
    pub half_width: HalfWidth,
    /// Young's modulus in force, without the stiffness factors.
    pub modulus: f64,
    /// Returns the factor of Young's modulus in force around a vertex; `None` if all are 1.
    pub factors: Option<&'a dyn Fn(u32) -> f64>,
    /// Returns the factor of the limits around a vertex; `None` if all are 1.
    pub strengths: Option<&'a dyn Fn(u32) -> f64>,
    /// Whether each lattice vertex is held by a pin or handle; empty if none is.
    pub held: &'a [bool],
}

impl Deformation<'_> {
    /// Returns the mean deformation gradient of the regions around the corners of a joint that holds, or of its cells
    /// if the regions are cells. Regions whose vertices lie in a plane, which occur at the fronts of cracks, have
    /// none.
    pub(super) fn gradient(&self, gradients: &Lanes<9>, joint: Joint) -> Matrix3<f64> {
        let Self { lattice, layout, .. } = self;
        let (mut sum, mut count) = (Matrix3::zeros(), 0.0);
        let (cells, corners);
        let vertices: &[u32] = if self.half_width.is_cell() {
            cells = self.cells_of(joint).map(|cell| lattice.first_corner(cell));
            &cells
        } else {
            corners = lattice.joint_corners(joint);
            &corners
        };
        for &vertex in vertices {
            let gradient =
                Matrix3::from_column_slice(&gradients.get(layout.slots()[vertex as usize]).map(f64::from));
            if gradient != Matrix3::zeros() {
                sum += gradient;
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { Matrix3::identity() }
    }

    /// Returns the strain of a joint along a direction at rest.
    pub(super) fn strain_along(&self, gradients: &Lanes<9>, joint: Joint, direction: &Vector3<f64>) -> f64 {
        (self.gradient(gradients, joint) * direction).norm() - 1.0
    }

    /// Returns the factor of Young's modulus at a joint: the mean of the regions around its corners, or of its cells
    /// if the regions are cells.
    pub(super) fn factor(&self, joint: Joint) -> f64 {
        match self.factors {
            Some(factor) if self.half_width.is_cell() => {
                self.corners_of_cells(joint).map(factor).sum::<f64>() / 16.0
            }
            factor => self.mean_of_corners(joint, factor),
        }
    }

    /// Returns the factor of the limits of a joint: the mean over its corners.
    pub(super) fn strength(&self, joint: Joint) -> f64 {
        self.mean_of_corners(joint, self.strengths)
    }

    /// Returns the mean of a factor over the corners of a joint; 1 without one.
    fn mean_of_corners(&self, joint: Joint, factor: Option<&dyn Fn(u32) -> f64>) -> f64 {
        let mean = |factor| self.lattice.joint_corners(joint).into_iter().map(factor).sum::<f64>() / 4.0;
        factor.map_or(1.0, mean)
    }

    /// Returns whether pins or handles hold all corners of the cells of a joint.
    pub(super) fn is_held(&self, joint: Joint) -> bool {
        self.are_held(joint).all(|is_held| is_held)
    }

    /// Returns whether pins or handles hold any corner of the cells of a joint.
    pub(super) fn is_beside_held(&self, joint: Joint) -> bool {
        !self.held.is_empty() && self.are_held(joint).any(|is_held| is_held)
    }

    /// Returns whether pins or handles hold each corner of the cells of a joint.
    fn are_held(&self, joint: Joint) -> impl Iterator<Item = bool> {
        self.corners_of_cells(joint).map(|corner| self.held.get(corner as usize).copied().unwrap_or(false))
    }

    /// Returns the corners of the two cells of a joint.
    fn corners_of_cells(&self, joint: Joint) -> impl Iterator<Item = u32> {
        self.cells_of(joint).into_iter().flat_map(|cell| self.lattice.cell_corners(cell))
    }

    /// Returns the two cells of a joint.
    fn cells_of(&self, joint: Joint) -> [u32; 2] {
        self.lattice.joint_cells(joint).unwrap_or([joint.cell; 2])
    }
}

/// Finds the cells, in order, that have a corner whose region is stretched; if the regions are cells, those that have a
/// corner in common with the first corner of a stretched one. The mean of gradients stretches no vector more than
/// each of them, so that no other joint is stretched. `stretched` has a bit mask of the lanes of each block.
pub(super) fn cells_beside(deformation: &Deformation, stretched: &[u8], cells: &mut Vec<u32>) {
    let Deformation { lattice, layout, .. } = deformation;
    cells.clear();
    if stretched.iter().all(|&lanes| lanes == 0) {
        return;
    }
    for ((vertex, &slot), &index) in (0..).zip(layout.slots()).zip(lattice.indices()) {
        let (block, lane) = block_and_lane(slot);
        if stretched[block] >> lane & 1 != 0 {
            let around = (0..8).filter_map(|octant| lattice.cell_around(index, octant));
            // Copies of a vertex have cells of their own around the same index.
            cells.extend(around.filter(|&cell| lattice.cell_corners(cell).contains(&vertex)));
        }
    }
    cells.sort_unstable();
    cells.dedup();
}

/// Returns the greatest stretch of a gradient, and its direction at rest. `None` if the gradient is not finite.
pub(super) fn greatest_stretch(gradient: &Matrix3<f64>) -> Option<(f64, Vector3<f64>)> {
    let eigen = (gradient.transpose() * gradient).try_symmetric_eigen(f64::EPSILON, 100)?;
    let greatest = eigen.eigenvalues.imax();
    let stretch = eigen.eigenvalues[greatest].max(0.0).sqrt();
    stretch.is_finite().then(|| (stretch, eigen.eigenvectors.column(greatest).into_owned()))
}

/// The mean rotation of the regions around the corners of each cell; its own if the regions are cells.
#[derive(Clone, Debug)]
pub(super) struct CellRotations(Vec<Vector4<f64>>);

impl CellRotations {
    pub(super) fn new(cells: usize) -> Self {
        Self(vec![Vector4::zeros(); cells])
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }

    pub(super) fn compute(&mut self, deformation: &Deformation) {
        let Deformation { lattice, layout, rotations, half_width, .. } = deformation;
        for (cell, mean) in (0..).zip(&mut self.0) {
            let of_vertex =
                |vertex: u32| Vector4::from(rotations.get(layout.slots()[vertex as usize]).map(f64::from));
            if half_width.is_cell() {
                *mean = of_vertex(lattice.first_corner(cell));
                continue;
            }
            let corners = lattice.cell_corners(cell).map(of_vertex);
            // q and -q are the same rotation.
            let sum: Vector4<f64> = corners.iter().map(|q| q * q.dot(&corners[0]).signum()).sum();
            *mean = sum.try_normalize(0.0).unwrap_or_else(|| *Quaternion::identity().as_vector());
        }
    }

    /// Returns the angle between the rotations of the cells of a joint, in radians.
    pub(super) fn angle(&self, lattice: &Lattice, joint: Joint) -> f64 {
        let cells = lattice.joint_cells(joint).unwrap_or([joint.cell; 2]);
        let [a, b] = cells.map(|cell| self.0[cell as usize]);
        // The angle of 4-vectors is half of the angle of the rotations. The sine is exact for small angles.
        4.0 * libm::asin(((a - b * a.dot(&b).signum()).norm() / 2.0).min(1.0))
    }
}
