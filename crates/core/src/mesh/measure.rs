//! Computes the volume and the area of a surface, relative to its extent.

use nalgebra::Vector3;

use super::polygons::Mesh;

/// Volume and area of a surface, relative to the longest side of its bounding box.
pub(crate) struct RelativeMeasure {
    /// Length of the longest side of the bounding box.
    pub extent: f64,
    /// Magnitude of the signed volume about the center of the bounding box, divided by `extent^3`.
    pub volume: f64,
    /// Area, divided by `extent^2`.
    pub area: f64,
}

impl RelativeMeasure {
    /// Measures a mesh.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let extent = (high - low).amax();
        let (mut volume, mut area) = (0.0, 0.0);
        for triangle in mesh.surface() {
            let [a, b, c] =
                triangle.map(|vertex| (mesh.vertices()[vertex as usize] - mesh.center()) / extent);
            volume += a.dot(&b.cross(&c)) / 6.0;
            area += Vector3::cross(&(b - a), &(c - a)).norm() / 2.0;
        }
        Self { extent, volume: volume.abs(), area }
    }
}
