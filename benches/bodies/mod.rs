//! Bodies to measure. All are generated except the bust of the example scenes.

mod figures;
mod statue;

use std::path::Path;

use nalgebra::Point3;
use supple::{Body, BodyBuilder, Lattice, Mesh, Preservation, Simulation};

pub use figures::Figure;
pub use statue::Statue;

/// Builds a block of `size` lattice vertices along x, y and z (each at least 2) with cells of edge 1.
///
/// # Panics
///
/// If a size is below 2, or the memory does not suffice.
pub fn block(size: [i32; 3]) -> Lattice {
    let [nx, ny, nz] = size.map(|vertices| vertices - 1);
    let cells: Vec<_> =
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect();
    bare(&cells)
}

/// Builds the lattice of cells of edge 1.
fn bare(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), false).expect("cells make a lattice")
}

/// Reads the mesh of the bust of the example scenes: 4,682 vertices.
///
/// # Panics
///
/// If the example scenes are missing.
pub fn bust() -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/bust.obj");
    supple_io::obj::read(path).expect("the bust of the example scenes")
}

/// Builds the lattice of the bust with about `vertices` vertices.
///
/// # Panics
///
/// If the example scenes are missing.
pub fn bust_lattice(vertices: usize) -> Lattice {
    Body::builder(bust()).lattice_vertices(vertices).build().expect("the bust is a body").lattice().clone()
}

/// Builds a simulation of one deformed body without gravity, damping and volume preservation. The deformation
/// gives the rotations work.
///
/// # Panics
///
/// If a half-width is 0.
pub fn in_motion(lattice: &Lattice, half_width: usize, threads: usize) -> Simulation {
    simulation([Body::from_lattice(lattice.clone()).half_width(half_width)], threads)
}

/// Builds a simulation like [`in_motion`] with several bodies.
///
/// # Panics
///
/// If a body cannot be built.
pub fn simulation(bodies: impl IntoIterator<Item = BodyBuilder>, threads: usize) -> Simulation {
    let mut simulation = Simulation::builder().gravity([0.0; 3]).threads(threads);
    for body in bodies {
        let mut body = body.volume(Preservation::Off).build().expect("a body of the benches");
        deform(&mut body);
        simulation = simulation.body(body);
    }
    simulation.build().expect("numbers in range")
}

/// Stretches and shears a body.
///
/// # Panics
///
/// Never: the number of positions does not change.
pub fn deform(body: &mut Body) {
    let positions: Vec<_> =
        body.positions().iter().map(|p| Point3::new(p.x + 0.2 * p.y, 1.1 * p.y, p.z - 0.1 * p.x)).collect();
    body.set_positions(&positions).expect("one finite position per vertex");
}
