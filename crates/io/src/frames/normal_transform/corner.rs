//! Transforms the normals of face corners, four corners at a time in the lanes of SIMD vectors. The docs of
//! the parent module define `n`, `m`, `e1` and `e2`.

use fearless_simd::{Level, Select, Simd, SimdBase, SimdFloat, dispatch, f64x4};

/// Number of corners that are transformed together.
const LANES: usize = 4;

/// A face corner with a `vn`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Mesh vertices: the vertex at which `e1` and `e2` start, then the ends of `e1` and `e2`.
    pub(super) vertices: [u32; 3],
    /// `n . m/|m|`, `n . e1` and `n . e2` at rest.
    pub(super) covariant: [f32; 3],
    /// `sqrt(|m|)` at rest.
    pub(super) root_area: f32,
}

/// Writes the unit normal of each corner to `normals`, for mesh vertices at `positions`. The normal is zero
/// if the three vertices of the corner span no area.
///
/// Computes in `f64`, because products of four edge lengths exceed the range of `f32` for very small and very
/// large models.
pub(super) fn transform(corners: &[Corner], positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
    debug_assert_eq!(corners.len(), normals.len(), "one normal per corner");
    dispatch!(Level::new(), simd => transform_all(simd, corners, positions, normals));
}

#[inline(always)]
fn transform_all<S: Simd>(simd: S, corners: &[Corner], positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
    for (corners, normals) in corners.chunks(LANES).zip(normals.chunks_mut(LANES)) {
        // Unused lanes repeat the last corner.
        // `rows[k][lane]` is quantity `k` of the corner in `lane`; [`transform_lanes`] lists the quantities.
        let mut rows = [[0.0; LANES]; 13];
        for lane in 0..LANES {
            let corner = &corners[lane.min(corners.len() - 1)];
            for vertex in 0..3 {
                let position = &positions[corner.vertices[vertex] as usize];
                for axis in 0..3 {
                    rows[3 * vertex + axis][lane] = f64::from(position[axis]);
                }
                rows[9 + vertex][lane] = f64::from(corner.covariant[vertex]);
            }
            rows[12][lane] = f64::from(corner.root_area);
        }
        let normal_rows = transform_lanes(simd, &rows);
        for lane in 0..corners.len() {
            for axis in 0..3 {
                normals[lane][axis] = normal_rows[axis][lane] as f32;
            }
        }
    }
}

/// Returns the x, y and z of the unit normals of the corners, with one corner per lane. The `rows` are x, y
/// and z of the three vertices, then [`Corner::covariant`] and [`Corner::root_area`].
#[inline(always)]
fn transform_lanes<S: Simd>(simd: S, rows: &[[f64; LANES]; 13]) -> [[f64; LANES]; 3] {
    let zero = f64x4::splat(simd, 0.0);
    let mut row = [zero; 13];
    for k in 0..13 {
        row[k] = f64x4::load_array_ref(simd, &rows[k]);
    }
    let [px, py, pz, nx, ny, nz, qx, qy, qz, n_m, n_e1, n_e2, root_area] = row;
    let (e1, e2) = ([nx - px, ny - py, nz - pz], [qx - px, qy - py, qz - pz]);
    let m = cross(e1, e2);
    let (n_m, a, b) = (n_m * length(m).sqrt() * root_area, cross(e2, m), cross(m, e1));
    // The formula in the docs of the parent module, times |m'|^2, which does not change the direction. Here
    // `m` is m', `a` is |m'|^2 d1 and `b` is |m'|^2 d2.
    let mut normal = m;
    for axis in 0..3 {
        normal[axis] = m[axis] * n_m + a[axis] * n_e1 + b[axis] * n_e2;
    }
    let length = length(normal);
    let has_area = length.simd_gt(zero);
    let mut unit = [[0.0; LANES]; 3];
    for axis in 0..3 {
        has_area.select(normal[axis] / length, zero).store_array(&mut unit[axis]);
    }
    unit
}

#[inline(always)]
fn cross<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> [f64x4<S>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn length<S: Simd>(a: [f64x4<S>; 3]) -> f64x4<S> {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}
