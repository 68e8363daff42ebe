//! Provides the bodies to measure. All bodies are generated except the bust, which is a mesh of the example
//! scenes.

mod figures;
mod statue;

use std::path::Path;

use nalgebra::Point3;
use supple::{Body, BodyBuilder, Lattice, Material, Mesh, Preservation, Simulation};

pub use figures::Figure;
pub use statue::Statue;

/// Builds the lattice of a block with `size` lattice vertices along x, y and z, each at least 2, and cells of
/// edge 1.
///
/// # Panics
///
/// Panics if a size is below 2, or if the memory does not suffice.
pub fn block(size: [i32; 3]) -> Lattice {
    let [nx, ny, nz] = size.map(|vertices| vertices - 1);
    let cells: Vec<_> =
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect();
    unit_lattice(&cells)
}

/// Builds the lattice of the given cells, with edge 1.
fn unit_lattice(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), false).expect("the cells give a valid lattice")
}

/// Reads the mesh of the bust of the example scenes, which has 4,717 vertices.
///
/// # Panics
///
/// Panics if the file of the bust is missing.
pub fn bust() -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/bust.obj");
    supple_io::obj::read(path).expect("the file of the bust is readable")
}

/// Builds the lattice of the bust with approximately `vertices` vertices.
///
/// # Panics
///
/// Panics if the file of the bust is missing.
pub fn bust_lattice(vertices: usize) -> Lattice {
    let body = Body::builder(bust()).material(Material::fast_lsm()).lattice_vertices(vertices).build();
    body.expect("the mesh and the body options are valid").lattice().clone()
}

/// Builds a simulation of one body without gravity, damping and volume preservation. The body starts
/// deformed, so that it keeps moving and the iteration of the rotations takes several steps.
///
/// # Panics
///
/// Panics if `half_width` is 0.
pub fn in_motion(lattice: &Lattice, half_width: usize, threads: usize) -> Simulation {
    simulation(
        [Body::from_lattice(lattice.clone()).material(Material::fast_lsm()).half_width(half_width)],
        threads,
    )
}

/// Builds a simulation of several deformed bodies without gravity and volume preservation.
///
/// # Panics
///
/// Panics if a body cannot be built.
pub fn simulation(bodies: impl IntoIterator<Item = BodyBuilder>, threads: usize) -> Simulation {
    let mut simulation = Simulation::builder().sleep(false).gravity([0.0; 3]).threads(threads);
    for body in bodies {
        let mut body = body.volume(Preservation::Off).build().expect("the body options are valid");
        deform(&mut body);
        simulation = simulation.body(body);
    }
    simulation.build().expect("the simulation parameters are valid")
}

/// Stretches and shears a body.
///
/// # Panics
///
/// Panics if a position of the body is not finite.
pub fn deform(body: &mut Body) {
    let positions: Vec<_> =
        body.positions().iter().map(|p| Point3::new(p.x + 0.2 * p.y, 1.1 * p.y, p.z - 0.1 * p.x)).collect();
    body.set_positions(&positions).expect("positions are finite, one per vertex");
}
