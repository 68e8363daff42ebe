//! Builds the bodies and colliders of the cases.

use nalgebra::{Point3, Vector3};
use supple::reference::{Mass, Momenta};
use supple::{Body, BodyBuilder, Collider, Error, HalfWidth, Key, Lattice, Material, Selection, Simulation};

/// Returns the cells of a block with `size` cells along x, y and z.
pub(super) fn block(size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect()
}

/// Returns the cells of two blocks of 4 x 4 x 4 cells. The second block is translated by `offset` cells.
pub(super) fn two_blocks(offset: [i32; 3]) -> Vec<[i32; 3]> {
    let second = block([4; 3]).into_iter().map(|cell| [0, 1, 2].map(|c| cell[c] + offset[c]));
    block([4; 3]).into_iter().chain(second).collect()
}

/// Creates a builder for a body of cells of edge 1 with regions of half-width `half_width`.
pub(super) fn of_cells(cells: &[[i32; 3]], half_width: impl Into<HalfWidth>) -> Result<BodyBuilder, Error> {
    of_sized_cells(cells, 1.0, half_width)
}

/// Creates a builder for a body of cells of edge `cell_size` with regions of half-width `half_width`.
pub(super) fn of_sized_cells(
    cells: &[[i32; 3]],
    cell_size: f64,
    half_width: impl Into<HalfWidth>,
) -> Result<BodyBuilder, Error> {
    let lattice = Lattice::from_cells(cells, cell_size, Point3::origin(), false)?;
    Ok(Body::from_lattice(lattice).material(Material::fast_lsm()).half_width(half_width))
}

/// Builds a simulation of one body without gravity and colliders, on one thread.
pub(super) fn alone(body: Body) -> Result<Simulation, Error> {
    Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).threads(1).build()
}

/// Sets random velocities with components of up to `size` cells per step of 1/60 s, and subtracts the rigid
/// motion, so that linear and angular momentum are zero.
pub(super) fn shake(body: &mut Body, size: f64) -> Result<(), Error> {
    let mut random = fastrand::Rng::with_seed(3);
    let max_component = 60.0 * size * body.lattice().cell_size();
    let mut component = || max_component * (2.0 * random.f64() - 1.0);
    let (masses, positions) = (body.masses(), body.positions());
    let points: Vec<Mass> = masses
        .iter()
        .zip(&positions)
        .map(|(&mass, x)| {
            let velocity = Vector3::new(component(), component(), component());
            Mass { mass, position: x.coords, velocity }
        })
        .collect();
    let momenta = Momenta::of(points.iter().copied());
    let (drift, spin) = momenta.missing(&Momenta::default(), points.iter().copied());
    let velocities = points.iter().map(|p| p.velocity + drift + spin.cross(&(p.position - momenta.center)));
    body.set_velocities(&velocities.collect::<Vec<_>>())?;
    Ok(())
}

/// Applies `deform` to the positions relative to their mean.
pub(super) fn deform(
    body: &mut Body,
    deform: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
) -> Result<(), Error> {
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    let mean = positions.iter().sum::<Vector3<f64>>() / positions.len() as f64;
    let relative: Vec<_> = positions.iter().map(|x| x - mean).collect();
    let moved: Vec<_> = deform(&relative).into_iter().map(|x| Point3::from(x + mean)).collect();
    body.set_positions(&moved)?;
    Ok(())
}

/// Selects the lattice vertices of a block of cells whose index along x is `x`.
pub(super) fn layer(block: [i32; 3], x: i32) -> Selection {
    let [nx, ny, nz] = block.map(|cells| cells + 1);
    // Lattice vertices are sorted by z, then y, then x.
    Selection::Vertices((0..ny * nz).map(|row| (row * nx + x) as u32).collect())
}

/// Creates a plate: a horizontal plane at the height `y` whose normal is `normal` (1 or -1) along y. It moves
/// along y by `travel` within 1 s, rests for 1 s, and returns within 0.5 s.
pub(super) fn plate(y: f64, normal: f64, travel: f64) -> Collider {
    let key = |(time, travel)| Key { time, translate: [0.0, travel, 0.0], rotate: [0.0; 3] };
    let keys = [(0.0, 0.0), (1.0, travel), (2.0, travel), (2.5, 0.0)].map(key).to_vec();
    Collider { keys, ..Collider::plane([0.0, y, 0.0], [0.0, normal, 0.0]) }
}
