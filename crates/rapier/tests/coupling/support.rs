//! Shapes and measures of the tests.

use nalgebra::{Point3, Vector3};
use rapier3d::prelude::{
    ColliderBuilder, PhysicsWorld, RigidBody, RigidBodyBuilder, RigidBodyHandle, Vector,
};
use supple::{Body, BodyBuilder, Mesh, Simulation};
use supple_rapier::SoftWorld;

/// Returns a box with the edges `edges` about the origin.
pub(crate) fn cuboid(edges: [f64; 3]) -> Mesh {
    let corner = |k: usize| [0, 1, 2].map(|a| if k >> a & 1 == 1 { edges[a] / 2.0 } else { -edges[a] / 2.0 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh::new((0..8).map(corner).collect(), &quads).unwrap()
}

/// Returns the builder of a soft cube of the edge 1 with 343 lattice vertices.
pub(crate) fn soft_cube() -> BodyBuilder {
    Body::builder(cuboid([1.0; 3])).cell_size(1.0 / 6.0).youngs_modulus(1e5)
}

pub(crate) fn soft_world(body: BodyBuilder) -> SoftWorld {
    let simulation = Simulation::builder().body(body.build().unwrap()).dt(1.0 / 120.0).threads(1);
    SoftWorld::new(simulation.build().unwrap())
}

/// Returns a Rapier world with steps of 1/120 s.
pub(crate) fn world(gravity: f32) -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, -gravity, 0.0);
    world.integration_parameters.dt = 1.0 / 120.0;
    world
}

/// Inserts a cube with an edge and a density.
pub(crate) fn insert_cube(
    world: &mut PhysicsWorld,
    body: RigidBodyBuilder,
    (edge, density): (f32, f32),
) -> RigidBodyHandle {
    let half = edge / 2.0;
    world.insert(body, ColliderBuilder::cuboid(half, half, half).density(density)).0
}

pub(crate) fn wide(vector: Vector) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z).map(f64::from)
}

/// Linear momentum, and angular momentum about a point.
pub(crate) fn momenta_of_rigid(body: &RigidBody, point: Point3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let linear = wide(body.linvel()) * f64::from(body.mass());
    // The tests have bodies with three equal principal moments.
    let moment = 1.0 / f64::from(body.mass_properties().local_mprops.inv_principal_inertia.x);
    let arm = wide(body.center_of_mass()) - point.coords;
    (linear, wide(body.angvel()) * moment + arm.cross(&linear))
}

/// Linear momentum, and angular momentum about a point.
pub(crate) fn momenta_of_soft(body: &Body, point: Point3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let linear = body.linear_momentum();
    (linear, body.angular_momentum() + (body.center_of_mass() - point).cross(&linear))
}
