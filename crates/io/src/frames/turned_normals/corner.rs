//! Normals of the corners of faces, turned with them: four corners at a time.

use fearless_simd::{Level, Select, Simd, SimdBase, SimdFloat, dispatch, f64x4};

/// Corners that are turned together.
const TOGETHER: usize = 4;

/// A corner of a face that has a `vn`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// The vertices of the mesh that span its frame: one, and its neighbours after and before.
    pub(super) vertices: [u32; 3],
    /// `n . m/|m|`, `n . e1`, `n . e2` at rest.
    pub(super) covariant: [f32; 3],
    /// `sqrt |m|` at rest.
    pub(super) root_area: f32,
}

/// Writes the unit normal of each corner where the mesh lies at `positions`; zero if its three vertices span no area.
///
/// In `f64`: products of four edge lengths leave the range of `f32` for small and large models.
pub(super) fn turn(corners: &[Corner], positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
    debug_assert_eq!(corners.len(), normals.len(), "one normal per corner");
    dispatch!(Level::new(), simd => turn_all(simd, corners, positions, normals));
}

#[inline(always)]
fn turn_all<S: Simd>(simd: S, corners: &[Corner], positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
    for (corners, normals) in corners.chunks(TOGETHER).zip(normals.chunks_mut(TOGETHER)) {
        // Where there are fewer, the last one again.
        let mut rows = [[0.0; TOGETHER]; 13];
        for lane in 0..TOGETHER {
            let corner = &corners[lane.min(corners.len() - 1)];
            for vertex in 0..3 {
                let place = &positions[corner.vertices[vertex] as usize];
                for axis in 0..3 {
                    rows[3 * vertex + axis][lane] = f64::from(place[axis]);
                }
                rows[9 + vertex][lane] = f64::from(corner.covariant[vertex]);
            }
            rows[12][lane] = f64::from(corner.root_area);
        }
        let turned = turn_together(simd, &rows);
        for lane in 0..corners.len() {
            for axis in 0..3 {
                normals[lane][axis] = turned[axis][lane] as f32;
            }
        }
    }
}

/// From the places of the three vertices, what the corners were at rest, and the roots of their areas.
#[inline(always)]
fn turn_together<S: Simd>(simd: S, rows: &[[f64; TOGETHER]; 13]) -> [[f64; TOGETHER]; 3] {
    let none = f64x4::splat(simd, 0.0);
    let mut row = [none; 13];
    for k in 0..13 {
        row[k] = f64x4::load_array_ref(simd, &rows[k]);
    }
    let [px, py, pz, nx, ny, nz, qx, qy, qz, along, with_e1, with_e2, root_area] = row;
    let (e1, e2) = ([nx - px, ny - py, nz - pz], [qx - px, qy - py, qz - pz]);
    let m = cross(e1, e2);
    let (along, a, b) = (along * length(m).sqrt() * root_area, cross(e2, m), cross(m, e1));
    // The formula of the module times |m'|^2.
    let mut normal = m;
    for axis in 0..3 {
        normal[axis] = m[axis] * along + a[axis] * with_e1 + b[axis] * with_e2;
    }
    let length = length(normal);
    let any = length.simd_gt(none);
    let mut unit = [[0.0; TOGETHER]; 3];
    for axis in 0..3 {
        any.select(normal[axis] / length, none).store_array(&mut unit[axis]);
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
