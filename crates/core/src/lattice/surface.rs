//! What the lattice needs to know of a surface mesh.

use nalgebra::{Point3, Vector3};

/// What the lattice needs to know of a surface mesh.
pub(crate) struct Surface<'a> {
    pub(crate) vertices: &'a [Point3<f64>],
    pub(crate) triangles: &'a [[u32; 3]],
    /// Bounding box of the vertices of all triangles.
    pub(crate) bounds: (Point3<f64>, Point3<f64>),
    /// Whether it has no boundary edge.
    pub(crate) closed: bool,
    /// A vertex of each component.
    pub(crate) components: Vec<u32>,
}

impl Surface<'_> {
    /// Magnitude of the volume, and area, as fractions of the powers of the longest side of the bounding box; that side.
    pub(crate) fn measure(&self) -> Measure {
        let (low, high) = self.bounds;
        let extent = (high - low).amax();
        let centre = nalgebra::center(&low, &high);
        let (mut volume, mut area) = (0.0, 0.0);
        for triangle in self.triangles {
            let [a, b, c] =
                triangle.map(|vertex| (self.vertices[vertex as usize] - centre).map(|x| relative(x, extent)));
            volume += a.dot(&b.cross(&c)) / 6.0;
            area += Vector3::cross(&(b - a), &(c - a)).norm() / 2.0;
        }
        Measure { extent, volume: volume.abs(), area }
    }
}

/// `x / extent`, 0 where there is no extent.
fn relative(x: f64, extent: f64) -> f64 {
    if extent > 0.0 { x / extent } else { 0.0 }
}

/// Size of a surface.
pub(crate) struct Measure {
    /// Longest side of the bounding box.
    pub(crate) extent: f64,
    /// Magnitude of the volume about the centre of the box, over the cube of the extent.
    pub(crate) volume: f64,
    /// Area over the square of the extent.
    pub(crate) area: f64,
}
