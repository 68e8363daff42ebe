//! Rotation matrices from quaternions.

use fearless_simd::{Simd, SimdFloat};

/// Computes rotation matrices from unit quaternions (x, y, z, w), one in each lane. The result has the nine
/// entries of the matrices, column by column.
#[inline(always)]
pub(crate) fn columns<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, [x, y, z, w]: [V; 4]) -> [V; 9] {
    let one = V::splat(simd, 1.0);
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    [one - (yy + zz), xy + wz, xz - wy, xy - wz, one - (xx + zz), yz + wx, xz + wy, yz - wx, one - (xx + yy)]
}
