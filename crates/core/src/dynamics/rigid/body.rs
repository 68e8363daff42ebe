//! Advances the pose of a rigid body, and writes the lattice vertices.
//!
//! Symbols: M, I mass and inertia tensor; c center of mass; R rotation from the rest pose; V velocity of the center; L
//! angular momentum about it; ω = R I⁻¹ Rᵀ L; h length of the step.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, dispatch, f32x8, mask32x8};
use nalgebra::{Matrix3, UnitQuaternion, Vector3, Vector6};

use super::holds::{Freedom, HeldVertex, Joint, motion_of};
use super::mass::RigidMass;
use super::rotation::rotated;
use crate::dynamics::momentum::{Mobility, Projection};
use crate::lattice::{Lattice, Layout};
use crate::simd::lanes::{Block, Lanes, Row, load, store};
use crate::simd::level;
use crate::simd::vector::Product;
use crate::state::{RigidMobility, RigidPose, State, Twist};

/// The shape of a rigid body, and its data in a step. Masses are in units of a full cell's mass, lengths in cells.
#[derive(Clone, Debug)]
pub(crate) struct RigidBody {
    mass: RigidMass,
    /// I⁻¹, without axes of no inertia.
    inverse_inertia: Matrix3<f64>,
    /// Position of each vertex from the center of mass in the rest pose, by slot.
    offsets: Lanes<3>,
    /// The greatest length of an offset.
    bounding_radius: f64,
    /// Mass of the lattice vertices, and their center of mass from that of the body in the rest pose.
    lattice_mass: (f64, Vector3<f64>),
    /// Buffer: the vertices that pins and handles hold in the current step.
    pub(crate) held: Vec<HeldVertex>,
    /// Mobility at the pose that was written last.
    mobility: RigidMobility,
    /// Pose before the current step.
    pub(crate) before: RigidPose,
}

impl RigidBody {
    /// Creates a rigid body, with the pose of the lattice of `state`, which is undeformed and turned by `rotation`.
    /// `masses`: of each lattice vertex.
    pub(crate) fn new(
        mass: RigidMass,
        (lattice, layout): (&Lattice, &Layout),
        masses: &[f32],
        (state, rotation): (&State, UnitQuaternion<f64>),
    ) -> (Self, RigidPose) {
        let rest = |vertex: usize| Vector3::from(lattice.indices()[vertex].map(f64::from)) - mass.center;
        let mut offsets = Lanes::zeros(layout.blocks());
        let (mut bounding_radius, mut total, mut moment) = (0.0_f64, 0.0, Vector3::zeros());
        for (vertex, &slot) in layout.slots().iter().enumerate() {
            let offset = rest(vertex);
            offsets.set(slot, offset.map(|x| x as f32).into());
            bounding_radius = bounding_radius.max(offset.norm());
            let mass = f64::from(masses[vertex]);
            total += mass;
            moment += offset * mass;
        }
        let mobility = Mobility::of_body(mass.mass, &mass.inertia);
        let inverse_inertia = Matrix3::from_columns(&[0, 1, 2].map(|c| mobility.turn(Vector3::ith(c, 1.0))));
        let center = state.local(layout.slots()[0]) - rotation * rest(0);
        let pose = RigidPose::at_rest(center, rotation);
        let zero = Matrix3::zeros();
        let mut body = Self {
            mass,
            inverse_inertia,
            offsets,
            bounding_radius,
            lattice_mass: (total, moment / total),
            held: Vec::new(),
            mobility: RigidMobility { center, bounding_radius, linear: zero, coupling: zero, angular: zero },
            before: pose,
        };
        body.mobility = body.mobility_at(&pose);
        (body, pose)
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Self>() + self.offsets.bytes() + self.held.capacity() * size_of::<HeldVertex>()
    }

    /// Returns M.
    pub(crate) fn mass(&self) -> f64 {
        self.mass.mass
    }

    /// Returns the center of mass in the rest pose, in cells from the lattice vertex with the indices 0.
    pub(crate) fn rest_center(&self) -> Vector3<f64> {
        self.mass.center
    }

    /// Returns the change of the motion by impulses at the pose that was written last.
    pub(crate) fn mobility(&self) -> &RigidMobility {
        &self.mobility
    }

    /// Moves the pose to the one nearest to the positions of all vertices.
    pub(crate) fn fit_to(&self, pose: &mut RigidPose, vertices: &[HeldVertex]) {
        let joint = Joint::new(vertices);
        let rotation = joint.fitted(vertices, pose.rotation());
        pose.set_rotation(rotation);
        pose.set_center(joint.target - rotation * joint.offset);
    }

    /// Sets the motion to the one nearest to the velocities of all vertices.
    pub(crate) fn fit_motion(&self, pose: &mut RigidPose, vertices: &[HeldVertex]) {
        let state = motion_of(vertices, |vertex| (vertex.target, vertex.velocity));
        let motion = state.motion(state.momentum);
        let linear = motion.velocity_at(&(pose.center() - state.center));
        self.set_motion(pose, Twist { linear, ..motion });
    }

    /// Returns the rest position of a vertex from the center of mass.
    pub(crate) fn offset(&self, slot: u32) -> Vector3<f64> {
        Vector3::from(self.offsets.get(slot).map(f64::from))
    }

    /// Returns the center of mass of the lattice vertices from that of the body, and the factor that gives the vertices
    /// the mass of the body.
    pub(crate) fn lattice_center(&self, pose: &RigidPose) -> (Vector3<f64>, f64) {
        let (mass, center) = self.lattice_mass;
        (pose.rotation() * center, self.mass.mass / mass)
    }

    /// Returns ω.
    pub(crate) fn angular_velocity(&self, pose: &RigidPose) -> Vector3<f64> {
        spin(&self.inverse_inertia, &pose.rotation(), &pose.angular_momentum())
    }

    /// Returns the kinetic energy of the motion relative to a frame that moves with `velocity`.
    pub(crate) fn kinetic_energy(&self, pose: &RigidPose) -> f64 {
        let rotational = pose.angular_momentum().dot(&self.angular_velocity(pose));
        0.5 * (self.mass.mass * pose.velocity().norm_squared() + rotational)
    }

    /// Returns the inertia tensor in world space.
    fn inertia_at(&self, rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
        rotated_tensor(&self.mass.inertia, rotation)
    }

    /// Sets the motion: V and ω.
    pub(crate) fn set_motion(&self, pose: &mut RigidPose, motion: Twist) {
        pose.set_velocity(motion.linear);
        self.set_spin(pose, motion.angular);
    }

    /// Sets ω. V is unchanged.
    pub(crate) fn set_spin(&self, pose: &mut RigidPose, spin: Vector3<f64>) {
        pose.set_angular_momentum(self.inertia_at(&pose.rotation()) * spin);
    }

    /// Advances the pose by a step of `dt` seconds: V += `velocity_change`, c += h V, and the rotation at constant L.
    /// Held vertices move to their targets.
    pub(crate) fn advance(&mut self, pose: &mut RigidPose, velocity_change: Vector3<f64>, dt: f64) {
        pose.set_velocity(pose.velocity() + velocity_change);
        if self.held.is_empty() {
            let momentum = pose.angular_momentum();
            let turned =
                rotated(pose.rotation(), dt, |rotation| spin(&self.inverse_inertia, rotation, &momentum));
            pose.set_rotation(turned);
            pose.set_center(pose.center() + pose.velocity() * dt);
        } else {
            self.advance_held(pose, dt);
        }
    }

    /// Advances the pose of a body with held vertices.
    fn advance_held(&self, pose: &mut RigidPose, dt: f64) {
        let joint = Joint::new(&self.held);
        let rotation = pose.rotation();
        let mut omega = self.held_projection(pose, dt).motion().angular;
        match joint.freedom {
            Freedom::Free | Freedom::Fixed => {}
            Freedom::Hinge => pose.set_rotation(UnitQuaternion::from_scaled_axis(omega * dt) * rotation),
            // The angular momentum about the joint is constant.
            Freedom::Ball => {
                let arm = joint.offset;
                let steiner = Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
                let about_joint = self.mass.inertia + steiner * self.mass.mass;
                let inverse = about_joint.try_inverse().unwrap_or(self.inverse_inertia);
                let momentum = rotated_tensor(&about_joint, &rotation) * omega;
                let turned = rotated(rotation, dt, |rotation| spin(&inverse, rotation, &momentum));
                pose.set_rotation(turned);
                omega = spin(&inverse, &turned, &momentum);
            }
        }
        self.fit_to(pose, &self.held);
        let motion = match joint.freedom {
            Freedom::Fixed => {
                let targets = motion_of(&self.held, |vertex| (vertex.target, vertex.velocity));
                let motion = targets.motion(targets.momentum);
                Twist { linear: motion.velocity_at(&(pose.center() - targets.center)), ..motion }
            }
            _ => {
                let linear = joint.velocity + omega.cross(&(pose.center() - joint.target));
                Twist { linear, angular: omega }
            }
        };
        self.set_motion(pose, motion);
    }

    /// Returns the force and the torque about the center of mass, times the step, that the held vertices exert in a step
    /// of `dt` seconds with `velocity_change` by gravity.
    pub(crate) fn reaction(&self, pose: &RigidPose, velocity_change: Vector3<f64>, dt: f64) -> Twist {
        let mut free = *pose;
        free.set_velocity(pose.velocity() + velocity_change);
        let motion = self.held_projection(&free, dt).motion();
        Twist {
            linear: (motion.linear - free.velocity()) * self.mass.mass,
            angular: self.inertia_at(&pose.rotation()) * motion.angular - free.angular_momentum(),
        }
    }

    /// Returns the projection of the motion on motions that move the held vertices to their targets in `dt` seconds.
    fn held_projection(&self, pose: &RigidPose, dt: f64) -> Projection {
        let mobility = Mobility::of_body(self.mass.mass, &self.inertia_at(&pose.rotation()));
        let motion = Twist { linear: pose.velocity(), angular: self.angular_velocity(pose) };
        let mut projection = Projection::new(mobility, motion, pose.center());
        let place = |vertex: &HeldVertex| pose.center() + pose.rotation() * vertex.offset;
        projection.fix_vertices(&motion_of(&self.held, |vertex| {
            (place(vertex), (vertex.target - place(vertex)) / dt)
        }));
        projection
    }

    /// Returns the mobility at a pose.
    fn mobility_at(&self, pose: &RigidPose) -> RigidMobility {
        let (center, rotation) = (pose.center(), pose.rotation());
        if self.held.is_empty() {
            return RigidMobility {
                center,
                bounding_radius: self.bounding_radius,
                linear: Matrix3::identity() / self.mass.mass,
                coupling: Matrix3::zeros(),
                angular: rotated_tensor(&self.inverse_inertia, &rotation),
            };
        }
        // The mobility does not depend on the targets, nor on the time.
        let projection = self.held_projection(pose, 1.0);
        let mut blocks = [Matrix3::zeros(); 3];
        for c in 0..6 {
            let motion = projection.mobility().response(&Vector6::ith(c, 1.0)).motion;
            let (v, omega) = (motion.fixed_rows::<3>(0), motion.fixed_rows::<3>(3));
            if c < 3 {
                blocks[0].set_column(c, &v);
            } else {
                blocks[1].set_column(c - 3, &v);
                blocks[2].set_column(c - 3, &omega);
            }
        }
        let [linear, coupling, angular] = blocks;
        RigidMobility { center, bounding_radius: self.bounding_radius, linear, coupling, angular }
    }

    /// Applies an impulse of a step of `dt` seconds: changes the motion, and the pose by the change times `dt`.
    pub(crate) fn apply_impulse(&self, pose: &mut RigidPose, impulse: Twist, dt: f64) {
        let change = self.mobility.change(&impulse);
        if self.held.is_empty() {
            pose.set_velocity(pose.velocity() + change.linear);
            pose.set_angular_momentum(pose.angular_momentum() + impulse.angular);
        } else {
            let motion = Twist {
                linear: pose.velocity() + change.linear,
                angular: self.angular_velocity(pose) + change.angular,
            };
            self.set_motion(pose, motion);
        }
        self.displace(pose, Twist { linear: change.linear * dt, angular: change.angular * dt });
    }

    /// Displaces the pose. V and L are unchanged.
    pub(crate) fn displace(&self, pose: &mut RigidPose, displacement: Twist) {
        pose.set_center(pose.center() + displacement.linear);
        pose.set_rotation(UnitQuaternion::from_scaled_axis(displacement.angular) * pose.rotation());
    }

    /// Writes the positions, velocities and rotations of the lattice vertices. `occupied` has, for each block, the bit mask
    /// of the lanes with a vertex.
    pub(crate) fn write(&mut self, state: &mut State, occupied: &[u8]) {
        let Some(pose) = state.rigid else { return };
        self.mobility = self.mobility_at(&pose);
        let omega = self.angular_velocity(&pose).map(|x| x as f32);
        let velocity = pose.velocity() - state.frame.velocity();
        let matrix = pose.rotation().to_rotation_matrix().into_inner();
        let center = pose.center();
        let motion = VertexMotion {
            rotation: matrix.map(|x| x as f32),
            center: center.map(|x| x as f32).into(),
            center_low: center.map(|x| (x - f64::from(x as f32)) as f32).into(),
            velocity: velocity.map(|x| x as f32).into(),
            omega: omega.into(),
        };
        let quaternion = pose.rotation();
        let rotations = [quaternion.i, quaternion.j, quaternion.k, quaternion.w].map(|x| Row::all(x as f32));
        let State { positions, compensation, velocities, .. } = state;
        let (positions, compensation) = (positions.blocks_mut(), compensation.blocks_mut());
        let vertices = positions.iter_mut().zip(compensation).zip(velocities.blocks_mut());
        let vertices = vertices.zip(self.offsets.blocks().iter().zip(occupied));
        dispatch!(level(), simd => write_vertices(simd, &motion, vertices));
        state.rotations.blocks_mut().fill(rotations);
        state.fitted = true;
    }
}

/// The rigid motion of the vertices, in f32.
#[derive(Clone, Copy)]
struct VertexMotion {
    rotation: Matrix3<f32>,
    center: [f32; 3],
    /// Rounding error of `center`.
    center_low: [f32; 3],
    velocity: [f32; 3],
    omega: [f32; 3],
}

/// Writes blocks: x = c + R r, with the rounding error of the sum beside it, and v = V + ω × R r.
#[inline(always)]
fn write_vertices<'a, S: Simd>(
    simd: S,
    motion: &VertexMotion,
    vertices: impl Iterator<
        Item = (((&'a mut Block<3>, &'a mut Block<3>), &'a mut Block<3>), (&'a Block<3>, &'a u8)),
    >,
) {
    let zero = f32x8::splat(simd, 0.0);
    let (mut rotation, mut center, mut center_low) = ([[zero; 3]; 3], [zero; 3], [zero; 3]);
    let (mut linear, mut omega) = ([zero; 3], [zero; 3]);
    for c in 0..3 {
        for k in 0..3 {
            rotation[c][k] = f32x8::splat(simd, motion.rotation[(c, k)]);
        }
        center[c] = f32x8::splat(simd, motion.center[c]);
        center_low[c] = f32x8::splat(simd, motion.center_low[c]);
        linear[c] = f32x8::splat(simd, motion.velocity[c]);
        omega[c] = f32x8::splat(simd, motion.omega[c]);
    }
    for (((x, low), v), (offset, &occupied)) in vertices {
        let occupied = mask32x8::from_bitmask(simd, u64::from(occupied));
        let r: [f32x8<S>; 3] = load(simd, offset);
        let (mut arm, mut position, mut error, mut velocity) = ([zero; 3], [zero; 3], [zero; 3], [zero; 3]);
        for c in 0..3 {
            arm[c] = r[0].times_plus(rotation[c][0], r[1].times_plus(rotation[c][1], r[2] * rotation[c][2]));
        }
        for c in 0..3 {
            let sum = center[c] + arm[c];
            // The error of the sum is exact whichever of the two is greater (Knuth 1969).
            let part = sum - center[c];
            let rounding = (center[c] - (sum - part)) + (arm[c] - part) + center_low[c];
            position[c] = occupied.select(sum, zero);
            error[c] = occupied.select(rounding, zero);
            let (next, last) = ((c + 1) % 3, (c + 2) % 3);
            let turning = omega[next] * arm[last] - omega[last] * arm[next];
            velocity[c] = occupied.select(linear[c] + turning, zero);
        }
        store(position, x);
        store(error, low);
        store(velocity, v);
    }
}

/// Returns the angular velocity R I⁻¹ Rᵀ L.
fn spin(
    inverse_inertia: &Matrix3<f64>,
    rotation: &UnitQuaternion<f64>,
    momentum: &Vector3<f64>,
) -> Vector3<f64> {
    rotation * (inverse_inertia * rotation.inverse_transform_vector(momentum))
}

/// Returns the tensor R T Rᵀ.
fn rotated_tensor(tensor: &Matrix3<f64>, rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let matrix = rotation.to_rotation_matrix().into_inner();
    matrix * tensor * matrix.transpose()
}
