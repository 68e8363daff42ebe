//! Defines the number types of output positions and normals.

use fearless_simd::{Simd, SimdBase, f64x4};
use nalgebra::RealField;

/// A number type for output coordinates: `f32` or `f64`.
pub trait Coordinate: RealField + Copy + Send + Sync + Narrow {}

impl Coordinate for f32 {}
impl Coordinate for f64 {}

/// Conversions from the number types of the kernels to a [`Coordinate`].
pub trait Narrow: Sized {
    /// Converts the first three of the four numbers of a register.
    fn narrow<S: Simd>(simd: S, wide: f64x4<S>) -> [Self; 3];

    /// Converts an `f32` number.
    fn of(single: f32) -> Self;
}

impl Narrow for f32 {
    #[inline(always)]
    fn narrow<S: Simd>(simd: S, wide: f64x4<S>) -> [Self; 3] {
        let [x, y, z, ..] = simd.narrow_f64x4(wide, wide).to_array();
        [x, y, z]
    }

    #[inline(always)]
    fn of(single: f32) -> Self {
        single
    }
}

impl Narrow for f64 {
    #[inline(always)]
    fn narrow<S: Simd>(_: S, wide: f64x4<S>) -> [Self; 3] {
        let [x, y, z, _] = wide.to_array();
        [x, y, z]
    }

    #[inline(always)]
    fn of(single: f32) -> Self {
        single.into()
    }
}
