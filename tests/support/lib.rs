//! Shapes, measures and readers that the tests of several rooms share: see `rust/`.

mod bits;
mod correction;
pub mod counting_allocator;
mod files;
mod measures;
mod random;
mod shapes;

pub use bits::{BITS_TABLE, differences, hashes_of_scenes};
pub use correction::{UNROTATED, apply, apply_in, enclosed_volume, of_mesh, posed, surface_volume};
pub use files::{bust, data, example, root};
pub use measures::{
    coordinates, greatest_distance, momentum, points, rest, rigid_fit, rms, tolerance, volumes_of_pieces,
    within, worst,
};
pub use random::Random;
pub use shapes::{
    ball, bare, block, block_at, cuboid, difficult_lattices, grid_box, half_cells, lattice, lattice_of,
    mesh_of, plain_box, pull_apart, sphere, square_sheet, surface_of, torus, unit_cube, without_gravity,
};
