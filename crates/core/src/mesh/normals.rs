//! Vertex normals of a moving surface.

use super::Mesh;

/// Area-weighted vertex normals, prepared for many frames of one surface.
///
/// Vertices that were welded share a normal, so no seam shows. A normal of a vertex without area around it is zero.
#[derive(Clone, Debug)]
pub struct VertexNormals {
    /// The triangles between welded vertices.
    triangles: Vec<[u32; 3]>,
    /// Where each vertex finds its normal.
    weld: Vec<u32>,
    /// A power of two that brings edges near length 1, so that no product leaves the range of `f32`.
    scale: f32,
    /// Sums of area vectors, four lanes each, one per vertex.
    sums: Vec<[f32; 4]>,
}

impl VertexNormals {
    /// Prepares the normals of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        Self::of_triangles(mesh.triangles(), mesh.weld(), (high - low).amax() as f32)
    }

    fn of_triangles(triangles: &[[u32; 3]], weld: &[u32], extent: f32) -> Self {
        let weld_triangle = |triangle: &[u32; 3]| triangle.map(|corner| weld[corner as usize]);
        Self {
            triangles: triangles.iter().map(weld_triangle).collect(),
            weld: weld.to_vec(),
            scale: inverse_power_of_two(extent),
            sums: vec![[0.0; 4]; weld.len()],
        }
    }

    /// Writes the unit normal of each vertex at `positions` (one per vertex) to `out` (one per vertex).
    ///
    /// One thread, one order: the same bits everywhere. Nothing is allocated.
    ///
    /// # Panics
    /// If `positions` or `out` have another length than the mesh has vertices.
    pub fn compute(&mut self, positions: &[[f32; 3]], out: &mut [[f32; 3]]) {
        assert_eq!(positions.len(), self.weld.len(), "one position per vertex");
        assert_eq!(out.len(), self.weld.len(), "one normal per vertex");
        self.sums.fill([0.0; 4]);
        let scale = self.scale;
        for &[a, b, c] in &self.triangles {
            let area = area_vector([a, b, c].map(|corner| positions[corner as usize]), scale);
            for corner in [a, b, c] {
                let sum = &mut self.sums[corner as usize];
                for (sum, area) in sum.iter_mut().zip(area) {
                    *sum += area;
                }
            }
        }
        for (normal, &welded) in out.iter_mut().zip(&self.weld) {
            let [x, y, z, _] = self.sums[welded as usize];
            *normal = unit([x, y, z]);
        }
    }
}

/// Area-weighted vertex normals of one frame: the one-shot form of [`VertexNormals`].
///
/// `triangles` index `positions`; `weld` gives for each vertex the one whose normal it shares (itself, if none);
/// `out` has one normal per vertex.
///
/// # Panics
/// If lengths differ or an index is out of range.
pub fn vertex_normals(triangles: &[[u32; 3]], positions: &[[f32; 3]], weld: &[u32], out: &mut [[f32; 3]]) {
    let largest = |axis: usize| {
        let values = || positions.iter().map(move |position| position[axis]);
        values().fold(f32::MIN, f32::max) - values().fold(f32::MAX, f32::min)
    };
    let extent = largest(0).max(largest(1)).max(largest(2));
    VertexNormals::of_triangles(triangles, weld, extent).compute(positions, out);
}

/// Twice the area vector of a triangle whose edges are scaled first; the fourth lane is zero.
#[inline]
fn area_vector([a, b, c]: [[f32; 3]; 3], scale: f32) -> [f32; 4] {
    let u: [f32; 3] = std::array::from_fn(|axis| (b[axis] - a[axis]) * scale);
    let v: [f32; 3] = std::array::from_fn(|axis| (c[axis] - a[axis]) * scale);
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0], 0.0]
}

/// `vector` at length 1; zero if it has none.
#[inline]
pub(crate) fn unit(vector: [f32; 3]) -> [f32; 3] {
    let squared = vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2];
    if squared >= f32::MIN_POSITIVE {
        let inverse = 1.0 / squared.sqrt();
        return vector.map(|component| component * inverse);
    }
    // The square of a short vector is lost in f32 long before the vector is.
    let wide = vector.map(f64::from);
    let length = (wide[0] * wide[0] + wide[1] * wide[1] + wide[2] * wide[2]).sqrt();
    if length > 0.0 { wide.map(|component| (component / length) as f32) } else { [0.0; 3] }
}

/// The power of two nearest below `1 / extent`, kept within what `f32` can multiply.
fn inverse_power_of_two(extent: f32) -> f32 {
    if extent > 0.0 && extent.is_finite() { (-extent.log2().ceil().clamp(-100.0, 100.0)).exp2() } else { 1.0 }
}
