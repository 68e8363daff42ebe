//! The bodies of the cases, made of cells.

use nalgebra::{Point3, Vector3};
use supple::{Body, Error, Lattice, Selection, Simulation};

use super::rigid::without_momenta;

/// The cells of a block.
pub(crate) fn block(size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect()
}

/// Two blocks of 4 x 4 x 4 cells whose nearest corners are `apart` cells away from one another.
pub(crate) fn two_blocks(apart: [i32; 3]) -> Vec<[i32; 3]> {
    let other = block([4; 3]).into_iter().map(|cell| [0, 1, 2].map(|c| cell[c] + apart[c]));
    block([4; 3]).into_iter().chain(other).collect()
}

/// A lattice of cells of edge 1.
pub(crate) fn lattice(cells: &[[i32; 3]]) -> Result<Lattice, Error> {
    sized(cells, 1.0)
}

/// A lattice of cells of a given edge.
pub(crate) fn sized(cells: &[[i32; 3]], cell_size: f64) -> Result<Lattice, Error> {
    Ok(Lattice::from_cells(cells, cell_size, Point3::origin(), false)?)
}

/// A simulation of one body on which nothing acts, on one thread.
pub(crate) fn alone(body: Body) -> Result<Simulation, Error> {
    Simulation::builder().body(body).gravity([0.0; 3]).threads(1).build()
}

/// Gives each vertex a velocity of its own, each component up to `size` cells a step of 1/60 s, all without linear and
/// angular momentum.
pub(crate) fn shake(body: &mut Body, size: f64) -> Result<(), Error> {
    let mut random = fastrand::Rng::with_seed(3);
    let unit = 60.0 * size * body.lattice().cell_size();
    let mut number = || unit * (2.0 * random.f64() - 1.0);
    let noise: Vec<_> =
        (0..body.lattice().len()).map(|_| Vector3::new(number(), number(), number())).collect();
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    body.set_velocities(&without_momenta(&body.masses(), &positions, &noise))?;
    Ok(())
}

/// Sets the positions to what `deform` makes of those about their mean.
pub(crate) fn deform(
    body: &mut Body,
    deform: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
) -> Result<(), Error> {
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    let middle = positions.iter().sum::<Vector3<f64>>() / positions.len() as f64;
    let about: Vec<_> = positions.iter().map(|x| x - middle).collect();
    let moved: Vec<_> = deform(&about).into_iter().map(|x| Point3::from(x + middle)).collect();
    body.set_positions(&moved)?;
    Ok(())
}

/// All vertices of a lattice whose index along `axis` is `at`, as a pin or a handle takes them.
pub(crate) fn layer(lattice: &Lattice, axis: usize, at: i32) -> Selection {
    let indices = (0..).zip(lattice.indices());
    Selection::Vertices(indices.filter(|(_, index)| index[axis] == at).map(|(vertex, _)| vertex).collect())
}
