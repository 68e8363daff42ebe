//! Builds the bodies of the cases.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

use nalgebra::{Matrix3, Point3, Vector3};
use supple::{
    Accuracy, Body, BodyBuilder, Collider, ElasticLaw, HalfWidth, Lattice, Material, Mesh, Preservation,
    Simulation, SimulationBuilder, Substeps,
};
use supple_io::obj::Document;

/// Gravity in m/s².
pub(super) const GRAVITY: f64 = 9.81;

/// Frames per second of the simulations with automatic steps.
pub(super) const FPS: f64 = 60.0;

/// The mesh of the example scenes, a bust, so that an installed program needs no file.
const BUST: &[u8] = include_bytes!("bust.obj");

/// Creates a builder of a bar of 1 x 1 x `length` with its lower end at z = 0, and `cells` cells per unit of length. Its
/// regions are the widest.
pub(super) fn bar(cells: i32, length: i32) -> Result<BodyBuilder, supple::Error> {
    let block: Vec<_> = (0..length * cells)
        .flat_map(|z| (0..cells).flat_map(move |y| (0..cells).map(move |x| [x, y, z])))
        .collect();
    let lattice = Lattice::from_cells(&block, 1.0 / f64::from(cells), Point3::origin(), false)?;
    Ok(Body::from_lattice(lattice).volume(Preservation::Off).accuracy(Accuracy::Fast))
}

/// Returns the number of lattice vertices of the bar [`bar`].
pub(super) fn bar_vertices(cells: i32, length: i32) -> usize {
    ((cells + 1) * (cells + 1) * (length * cells + 1)) as usize
}

/// Returns the radius R of the regions of a bar with Young's modulus `modulus` and the default density, in steps of
/// `dt` seconds: with the least half-width for which alpha is at most 1.
pub(super) fn region_radius(cells: i32, modulus: f64, dt: f64) -> f64 {
    let law = ElasticLaw {
        density: Material::default().density,
        cell_size: 1.0 / f64::from(cells),
        dt,
        poisson_ratio: 0.0,
    };
    let is_sufficient = |&half_width: &usize| law.alpha(half_width, modulus) <= 1.0;
    let half_width = (1..).find(is_sufficient).unwrap_or(1);
    law.cell_size * HalfWidth::from(half_width).radius()
}

/// Creates a builder of the bar [`bar`] as a mesh that is turned about the origin, and so across the cells.
pub(super) fn turned_bar(cells: i32, length: i32, turn: &Matrix3<f64>) -> Result<BodyBuilder, supple::Error> {
    let body = Body::builder(block([1.0, 1.0, f64::from(length)], turn)?).cell_size(1.0 / f64::from(cells));
    Ok(body.volume(Preservation::Off).accuracy(Accuracy::Fast))
}

/// Returns a block of 6 quads with a corner at the origin, turned about it.
pub(super) fn block(size: [f64; 3], turn: &Matrix3<f64>) -> Result<Mesh, supple::MeshError> {
    let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { size[axis] } else { 0.0 });
    let corners = (0..8).map(|k| (turn * corner(k)).into()).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh::new(corners, &quads)
}

/// Returns a ball of the radius 1/2 about the origin: a cube of 60 x 60 quads per side, projected. A ball of larger
/// facets loses speed when it rolls over their edges.
pub(super) fn ball() -> Result<Mesh, supple::Error> {
    const QUADS: i32 = 60;
    let (mut vertices, mut indices, mut quads) = (Vec::new(), BTreeMap::new(), Vec::new());
    // Sides share the vertices on their common edges. The lines of a side are at equal angles.
    let mut vertex = |point: [i32; 3]| -> u32 {
        let angle =
            |k: i32| ((f64::from(2 * k) / f64::from(QUADS) - 1.0) * std::f64::consts::FRAC_PI_4).tan();
        *indices.entry(point).or_insert_with(|| {
            vertices.push((0.5 * Vector3::from(point.map(angle)).normalize()).into());
            vertices.len() as u32 - 1
        })
    };
    for (axis, outer) in (0..3).flat_map(|axis| [(axis, 0), (axis, QUADS)]) {
        for k in 0..QUADS * QUADS {
            let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                let mut point = [0; 3];
                point[axis] = outer;
                point[(axis + 1) % 3] = k % QUADS + u;
                point[(axis + 2) % 3] = k / QUADS + v;
                vertex(point)
            });
            // Counter-clockwise, seen from outside.
            if outer == 0 {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    Ok(Mesh::new(vertices, &quads)?)
}

/// Returns the bust of the example scenes, 3.52 units high.
pub(super) fn bust() -> Result<Mesh, Box<dyn Error>> {
    Ok(Document::from_bytes(PathBuf::from("bust.obj"), BUST.to_vec())?.mesh(None)?)
}

/// Returns a plane with friction 1 at y = 0.
pub(super) fn ground() -> Collider {
    Collider { friction: 1.0, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) }
}

/// Creates a builder of a simulation of a body on one thread, without sleep, in steps of `dt` seconds.
pub(super) fn stepped(body: Body, gravity: [f64; 3], dt: f64) -> SimulationBuilder {
    Simulation::builder().body(body).gravity(gravity).dt(dt).sleep(false).threads(1)
}

/// Creates a builder of a simulation of a body on one thread, with automatic steps at 60 frames per second.
pub(super) fn automatic(body: Body, gravity: [f64; 3]) -> SimulationBuilder {
    Simulation::builder().body(body).gravity(gravity).fps(FPS).substeps(Substeps::Auto).threads(1)
}

/// Returns the greatest speed of a vertex.
pub(super) fn greatest_speed(body: &Body) -> f64 {
    body.velocities().iter().map(|velocity| velocity.norm()).fold(0.0, f64::max)
}

/// Returns the velocity of the center of mass.
pub(super) fn mean_velocity(body: &Body) -> Vector3<f64> {
    body.linear_momentum() / body.mass()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_closed_and_have_their_volumes() {
        let turn = supple::euler_degrees([30.0, 30.0, 0.0]);
        let bar = turned_bar(4, 5, &turn).unwrap().build().unwrap();
        // The quads are planar, so the volume is exact.
        assert!((bar.mesh().unwrap().signed_volume() - 5.0).abs() < 1e-12);
        let ball = ball().unwrap();
        // A chord of the angle π/120 is at most (π/120)²/8 = 0.01 % of the radius inside the sphere, and so the volume
        // is less by at most three times that for each of the two directions of a quad.
        let ratio = ball.signed_volume() / (std::f64::consts::PI / 6.0);
        assert!(ball.is_closed() && ratio < 1.0 && ratio > 1.0 - 6e-4, "{ratio}");
        let bust = bust().unwrap();
        assert!(bust.is_closed() && bust.vertices().len() == 4_717);
        assert_eq!(super::bar(4, 5).unwrap().build().unwrap().lattice().len(), bar_vertices(4, 5));
    }
}
