//! Bodies that the benches share.

use std::path::Path;

use nalgebra::Point3;
use supple::{Body, BodyBuilder, Lattice, Simulation};

/// A block of `size` lattice vertices along each axis, cells of edge 1.
///
/// # Panics
///
/// If a size is below 2, or the memory is not there.
pub fn block(size: [i32; 3]) -> Lattice {
    let [nx, ny, nz] = size.map(|vertices| vertices - 1);
    let cells: Vec<_> =
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect();
    Lattice::from_cells(&cells, 1.0, Point3::origin(), false).expect("a block is a lattice")
}

/// The bust of the example scenes, with about 1,000 lattice vertices.
///
/// # Panics
///
/// If the example scenes are not there.
pub fn bust() -> BodyBuilder {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/bust.obj");
    Body::builder(supple::obj::read(path).expect("the bust of the example scenes")).lattice_vertices(1000)
}

/// A body stretched and sheared, so that its rotations have something to do.
///
/// # Panics
///
/// Never: the positions are as many as there were.
pub fn deform(body: &mut Body) {
    let positions: Vec<_> =
        body.positions().iter().map(|p| Point3::new(p.x + 0.2 * p.y, 1.1 * p.y, p.z - 0.1 * p.x)).collect();
    body.set_positions(&positions).expect("one finite position per vertex");
}

/// A simulation of one body without gravity.
///
/// # Panics
///
/// Never: its numbers are in range.
pub fn simulation(body: Body, threads: usize) -> Simulation {
    Simulation::builder().body(body).gravity([0.0; 3]).threads(threads).build().expect("numbers in range")
}
