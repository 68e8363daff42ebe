//! Sums the momenta and the inertia of each connected component in f64, in a fixed order, and computes the
//! rigid velocity that corrects the momenta. m, x and v are the mass, position and velocity of a vertex.

use fearless_simd::{Simd, SimdBase, f64x4};
use nalgebra::{Matrix3, Vector3};

use super::components::Components;
use super::rigid::{RigidVelocity, principal_axes};
use crate::simd::lanes::{Block, LANES, load};
use crate::simd::vector::Product;
use crate::state::{Momentum, Twist};

/// Sums over the vertices of a component: Σ m v, Σ m x, Σ m x × v and Σ m (xx, yy, zz, xy, xz, yz), where
/// (x, y, z) in the last sum are the coordinates of the position.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums([f64; MOMENTS]);

/// Number of sums.
const MOMENTS: usize = 15;

impl Sums {
    /// Adds the sums `other` over other vertices.
    pub(in crate::dynamics) fn add(&mut self, other: &Self) {
        for (sum, other) in self.0.iter_mut().zip(other.0) {
            *sum += other;
        }
    }

    /// Adds one vertex of mass m.
    #[inline(always)]
    pub(in crate::dynamics) fn add_vertex(&mut self, m: f64, [x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) {
        let cross = [y * w - z * v, z * u - x * w, x * v - y * u];
        let products = [x * x, y * y, z * z, x * y, x * z, y * z];
        let moments = [u, v, w, x, y, z].into_iter().chain(cross).chain(products);
        for (sum, moment) in self.0.iter_mut().zip(moments) {
            *sum += m * moment;
        }
    }

    /// Computes the rigid state of a component from its sums and its mass.
    pub(in crate::dynamics) fn rigid_state(&self, mass: f64) -> RigidState {
        let m = &self.0;
        let linear = Vector3::new(m[0], m[1], m[2]);
        let center = Vector3::new(m[3], m[4], m[5]) / mass;
        let angular = Vector3::new(m[6], m[7], m[8]) - center.cross(&linear);
        let [xx, yy, zz, xy, xz, yz] = [m[9], m[10], m[11], m[12], m[13], m[14]];
        let moment = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - center * center.transpose() * mass;
        let inertia = Matrix3::identity() * moment.trace() - moment;
        let momentum = Momentum { linear: linear.into(), angular: angular.into() };
        RigidState { mass, center, momentum, inertia }
    }
}

/// The vertex data that are summed, for some blocks of eight vertices.
#[derive(Clone, Copy)]
pub(in crate::dynamics) struct Fields<'a> {
    /// m in the first row; the second row is not used.
    pub(in crate::dynamics) weights: &'a [Block<2>],
    pub(in crate::dynamics) positions: &'a [Block<3>],
    pub(in crate::dynamics) velocities: &'a [Block<3>],
}

/// Adds the vertices of consecutive blocks to the sums of their components. `first` is the index of the first
/// block.
#[inline(always)]
pub(in crate::dynamics) fn add<S: Simd>(
    simd: S,
    components: &Components,
    first: usize,
    fields: Fields,
    sums: &mut [Sums],
) {
    match components {
        Components::One => {
            let block_sums = simd.vectorize(
                #[inline(always)]
                || sum(simd, fields),
            );
            sums[0].add(&block_sums);
        }
        Components::Several(of_slot) => add_by_component(of_slot, first, fields, sums),
    }
}

/// Sums over blocks whose vertices all belong to one component, four lanes at a time.
#[inline(always)]
fn sum<S: Simd>(simd: S, fields: Fields) -> Sums {
    let mut total = [f64x4::splat(simd, 0.0); MOMENTS];
    let Fields { weights, positions, velocities } = fields;
    for ((weights, position), velocity) in weights.iter().zip(positions).zip(velocities) {
        let [m] = load(simd, weights);
        let [x, y, z] = load(simd, position);
        let [u, v, w] = load(simd, velocity);
        let (m, x, y, z) =
            (simd.widen_f32x8(m), simd.widen_f32x8(x), simd.widen_f32x8(y), simd.widen_f32x8(z));
        let (u, v, w) = (simd.widen_f32x8(u), simd.widen_f32x8(v), simd.widen_f32x8(w));
        add_moments(&mut total, m.0, [x.0, y.0, z.0], [u.0, v.0, w.0]);
        add_moments(&mut total, m.1, [x.1, y.1, z.1], [u.1, v.1, w.1]);
    }
    let mut sums = Sums::default();
    for i in 0..MOMENTS {
        let [a, b, c, d] = total[i].to_array();
        sums.0[i] = (a + b) + (c + d);
    }
    sums
}

/// Adds the moments of four vertices, one in each lane, to the sums.
#[inline(always)]
fn add_moments<S: Simd>(sums: &mut [f64x4<S>; MOMENTS], m: f64x4<S>, x: [f64x4<S>; 3], v: [f64x4<S>; 3]) {
    let mx = [m * x[0], m * x[1], m * x[2]];
    for c in 0..3 {
        let (next, last) = ((c + 1) % 3, (c + 2) % 3);
        sums[c] = m.times_plus(v[c], sums[c]);
        sums[3 + c] += mx[c];
        sums[6 + c] = mx[next].times_plus(v[last], (-mx[last]).times_plus(v[next], sums[6 + c]));
        sums[9 + c] = mx[c].times_plus(x[c], sums[9 + c]);
    }
    sums[12] = mx[0].times_plus(x[1], sums[12]);
    sums[13] = mx[0].times_plus(x[2], sums[13]);
    sums[14] = mx[1].times_plus(x[2], sums[14]);
}

/// Adds each vertex of consecutive blocks to the sums of its component. `of_slot` has the component of each
/// slot, and `first` is the index of the first block.
fn add_by_component(of_slot: &[u32], first: usize, fields: Fields, sums: &mut [Sums]) {
    let Fields { weights, positions, velocities } = fields;
    let blocks = weights.iter().zip(positions).zip(velocities);
    for (((weights, position), velocity), of_lane) in blocks.zip(of_slot[first * LANES..].chunks(LANES)) {
        for (lane, &component) in of_lane.iter().enumerate() {
            let m = f64::from(weights[0][lane]);
            let position = position.map(|row| f64::from(row[lane]));
            let velocity = velocity.map(|row| f64::from(row[lane]));
            sums[component as usize].add_vertex(m, position, velocity);
        }
    }
}

/// The rigid state of a component, measured from its vertices: mass, center of mass, momenta and inertia.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidState {
    pub(crate) mass: f64,
    /// Center of mass, in cells from the body's origin.
    pub(crate) center: Vector3<f64>,
    pub(in crate::dynamics) momentum: Momentum,
    /// Inertia tensor about the center of mass.
    pub(in crate::dynamics) inertia: Matrix3<f64>,
}

impl RigidState {
    /// Computes the kinetic energy of a rigid body with this mass, inertia and momenta.
    pub(super) fn rigid_energy(&self) -> f64 {
        let (linear, angular) = (Vector3::from(self.momentum.linear), Vector3::from(self.momentum.angular));
        0.5 * (linear.norm_squared() / self.mass + angular_velocity(&self.inertia, angular).dot(&angular))
    }

    /// Computes the rigid velocity that changes the momenta to `target`. Returns zero if the rigid velocity
    /// is not finite.
    pub(super) fn correction_to(&self, target: Momentum) -> RigidVelocity {
        let linear = Vector3::from(target.linear) - Vector3::from(self.momentum.linear);
        let angular = Vector3::from(target.angular) - Vector3::from(self.momentum.angular);
        let change = Momentum { linear: linear.into(), angular: angular.into() };
        RigidVelocity::of(self.motion(change), self.center)
    }

    /// Computes the rigid motion with the momenta `momentum`.
    pub(in crate::dynamics) fn motion(&self, momentum: Momentum) -> Twist {
        Twist {
            linear: Vector3::from(momentum.linear) / self.mass,
            angular: angular_velocity(&self.inertia, Vector3::from(momentum.angular)),
        }
    }

    /// Computes the momenta of a rigid motion.
    pub(in crate::dynamics) fn momentum_of(&self, motion: Twist) -> Momentum {
        let (linear, angular) = (motion.linear * self.mass, self.inertia * motion.angular);
        Momentum { linear: linear.into(), angular: angular.into() }
    }

    /// Computes the momenta of a rigid motion, the angular momentum about a point.
    pub(in crate::dynamics) fn momentum_about(&self, point: Vector3<f64>, motion: Twist) -> Momentum {
        let mut momentum = self.momentum_of(motion);
        let moment = (self.center - point).cross(&Vector3::from(momentum.linear));
        momentum.angular = (Vector3::from(momentum.angular) + moment).into();
        momentum
    }

    /// Returns the greatest part of a change, from 0 to 1, with which the energy of a rigid motion is at most `limit`. The
    /// energy without the change is not greater.
    pub(in crate::dynamics) fn part_within(&self, motion: Twist, change: Twist, limit: f64) -> f64 {
        let (before, square) = (self.energy_of(motion), self.energy_of(change));
        let mixed = self.energy_of(motion + change) - before - square;
        // The energy at the part s is before + mixed s + square s².
        let part =
            ((mixed * mixed + 4.0 * square * (limit - before).max(0.0)).sqrt() - mixed) / (2.0 * square);
        if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Computes the kinetic energy of a rigid motion.
    pub(in crate::dynamics) fn energy_of(&self, motion: Twist) -> f64 {
        let Twist { linear, angular } = motion;
        0.5 * (self.mass * linear.norm_squared() + angular.dot(&(self.inertia * angular)))
    }
}

/// Solves I ω = l for the angular velocity ω, with the inertia I and the angular momentum l. ω has no component along
/// the axis of points on a line.
fn angular_velocity(inertia: &Matrix3<f64>, angular: Vector3<f64>) -> Vector3<f64> {
    principal_axes(inertia).map(|(inertia, axis)| axis * (axis.dot(&angular) / inertia)).sum()
}
