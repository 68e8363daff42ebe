//! What is shown, written from a tile.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x4, f64x4};

use crate::mesh::normals::components;
use crate::mesh::rings::Place;
use crate::simd::Coordinate;
use crate::simd::level;
use crate::simd::tile::Tile;
use crate::state::BodyFrame;

/// From cells to the world.
#[derive(Clone, Copy)]
pub(super) struct World<S: Simd> {
    origin: f64x4<S>,
    cell: f64x4<S>,
}

impl<S: Simd> World<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, frame: &BodyFrame) -> Self {
        let [x, y, z] = frame.origin.coords.into();
        Self { origin: f64x4::load_array(simd, [x, y, z, x]), cell: f64x4::splat(simd, frame.cell_size) }
    }

    /// The position in the world of one in cells.
    #[inline(always)]
    pub(super) fn position<T: Coordinate>(self, simd: S, local: f32x4<S>) -> [T; 3] {
        let (local, _) = simd.widen_f32x8(simd.combine_f32x4(local, local));
        T::narrow(simd, local.mul_add(self.cell, self.origin))
    }
}

/// Writes the positions in the tile at `places`.
pub(super) fn write_positions<T: Coordinate>(
    near: &Tile,
    places: impl Iterator<Item = u16>,
    frame: &BodyFrame,
    out: &mut [[T; 3]],
) {
    dispatch!(level(), simd => {
        let world = World::new(simd, frame);
        for (out, place) in out.iter_mut().zip(places) {
            *out = world.position(simd, near.one(simd, place));
        }
    });
}

/// Writes the normals in the tile at `places`.
pub(super) fn write_normals<T: Coordinate>(normals: &Tile, places: &[Place], out: &mut [[T; 3]]) {
    for (out, place) in out.iter_mut().zip(places) {
        *out = components(normals.get(place.normal)).map(T::of);
    }
}
