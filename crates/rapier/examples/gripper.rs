//! A gripper with motors lifts a soft ball: two fingers of Rapier press on it, and a carriage raises them.
//!
//!     cargo run --release -p supple-rapier --example gripper

use rapier3d::prelude::*;
use supple::{Body, Mesh, Simulation};
use supple_rapier::SoftWorld;

/// The force of the finger that presses, in newtons.
const GRIP: f32 = 40.0;
/// The height by which the carriage rises.
pub(crate) const LIFT: f32 = 0.3;
/// The radius of the ball.
pub(crate) const RADIUS: f64 = 0.1;
/// Stiffness of the motor of the carriage, in N/m.
pub(crate) const STIFFNESS: f32 = 1e5;

/// The gripper, the ball and the world.
pub(crate) struct Gripper {
    pub(crate) world: PhysicsWorld,
    pub(crate) soft: SoftWorld,
    pub(crate) fingers: [RigidBodyHandle; 2],
    lift: ImpulseJointHandle,
}

impl Gripper {
    /// Creates the gripper with open fingers, and the ball on the ground between them.
    pub(crate) fn new(threads: usize) -> Result<Self, Box<dyn std::error::Error>> {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = 1.0 / 240.0;
        let (ground, _) =
            world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Y)));
        let place = |x, y| RigidBodyBuilder::dynamic().translation(Vector::new(x, y, 0.0));
        let (carriage, _) =
            world.insert(place(0.0, 0.4), ColliderBuilder::cuboid(0.3, 0.02, 0.05).density(1000.0));
        let rail = PrismaticJointBuilder::new(Vector::Y).local_anchor1(Vector::Y * 0.4);
        let rail = rail.motor_model(MotorModel::ForceBased).motor_position(0.0, STIFFNESS, 2e3);
        let lift = world.insert_impulse_joint(ground, carriage, rail.contacts_enabled(false));
        let fingers = [-1.0, 1.0].map(|side| {
            let shape = ColliderBuilder::cuboid(0.02, 0.1, 0.1).density(1000.0).friction(0.8);
            let (finger, _) = world.insert(place(0.18 * side, 0.12), shape);
            let slide = PrismaticJointBuilder::new(Vector::X * -side);
            let slide = slide.local_anchor1(Vector::new(0.18 * side, -0.28, 0.0)).contacts_enabled(false);
            let slide = slide.motor_model(MotorModel::ForceBased);
            // One finger moves to its place, the other one presses with a force.
            let slide = match side < 0.0 {
                true => slide.motor_position(0.085, 5e3, 5e2),
                false => slide.motor_velocity(0.2, 1e4).motor_max_force(GRIP),
            };
            world.insert_impulse_joint(carriage, finger, slide);
            finger
        });
        let ball = Body::builder(ball()).lattice_vertices(500).density(500.0).youngs_modulus(5e4);
        let ball = ball.friction(0.8).damping_ratio(0.5).translate([0.0, RADIUS, 0.0]).build()?;
        let dt = world.integration_parameters.dt.into();
        let soft = SoftWorld::new(Simulation::builder().body(ball).dt(dt).threads(threads).build()?);
        Ok(Self { world, soft, fingers, lift })
    }

    /// Makes a step. The fingers close during the first 0.6 s; the carriage rises in the second after.
    pub(crate) fn step(&mut self) -> Result<(), supple_rapier::Error> {
        let height = LIFT * (self.soft.simulation().time() as f32 - 0.6).clamp(0.0, 1.0);
        if let Some(joint) = self.world.impulse_joints.get_mut(self.lift, true) {
            joint.data.set_motor_position(JointAxis::LinX, height, STIFFNESS, 2e3);
        }
        self.soft.step(&mut self.world)
    }

    /// Returns the height of the center of the ball.
    pub(crate) fn ball_height(&self) -> f64 {
        self.soft.bodies()[0].center_of_mass().y
    }

    /// Returns the mean height of the fingers.
    pub(crate) fn finger_height(&self) -> f64 {
        self.fingers.map(|finger| f64::from(self.world.bodies[finger].translation().y)).iter().sum::<f64>()
            / 2.0
    }
}

/// Returns a ball about the origin.
fn ball() -> Mesh {
    let (vertices, faces) = rapier3d::parry::shape::Ball::new(RADIUS as f32).to_trimesh(24, 12);
    let vertices = vertices.into_iter().map(|p| [p.x, p.y, p.z].map(f64::from)).collect();
    Mesh::new(vertices, &faces).expect("the triangles of a ball are valid")
}

#[allow(dead_code, clippy::print_stdout, reason = "the test of the gripper uses the scene alone")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut gripper = Gripper::new(0)?;
    println!("    time    ball  fingers");
    for step in 0..528 {
        if step % 48 == 0 {
            let (ball, fingers) = (gripper.ball_height(), gripper.finger_height());
            println!("{:8.2} {ball:7.3} {fingers:8.3}", gripper.soft.simulation().time());
        }
        gripper.step()?;
    }
    assert!(gripper.ball_height() > 0.37, "the ball slipped: {}", gripper.ball_height());
    Ok(())
}
