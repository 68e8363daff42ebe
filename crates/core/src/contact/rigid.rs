//! The rigid bodies of a contact problem.
//!
//! A contact point of a rigid body has the velocity V + ω × r, with the arm r from the center of mass. An impulse p there
//! is an impulse p and an angular impulse r × p on the body. In place of links to lattice vertices, a contact has a link to
//! the body. The response of a contact s (module `jacobi`) is the bound √a_s Σ √a_t over all contacts t of the body, with
//! the greatest velocity change a_s of the point of s by a unit impulse at s: a matrix of the velocity changes has at most
//! the norm √(a_s a_t).

use nalgebra::{Matrix3, Vector3};

use super::memory::buffer_bytes;
use super::vec4::{Vec4, narrow, wide};
use crate::state::{RigidMobility, Twist};

/// A 3 x 3 matrix by columns.
type Columns = [Vec4; 3];

/// Index of no rigid body.
const NONE: u32 = u32::MAX;

/// A rigid body of a contact problem, in the units of the problem.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidMember {
    linear: Columns,
    coupling: Columns,
    /// Transpose of `coupling`.
    coupling_transposed: Columns,
    angular: Columns,
    /// Change of the motion by all impulses.
    change: (Vec4, Vec4),
    /// Scratch: impulses of a pass, or in the first component the sum of √a.
    sum: (Vec4, Vec4),
}

impl RigidMember {
    /// Returns a_s of a contact point: a bound of the norm of the symmetric matrix of velocity changes, by its greatest
    /// sum of a column.
    fn own_response(&self, arm: &Vec4) -> f32 {
        let Self { linear, coupling, coupling_transposed, angular, .. } = self;
        let mut greatest = 0.0_f32;
        for axis in 0..3 {
            let mut impulse = Vec4::zeros();
            impulse[axis] = 1.0;
            let moment = cross(arm, &impulse);
            let velocity = product(linear, &impulse) + product(coupling, &moment);
            let omega = product(coupling_transposed, &impulse) + product(angular, &moment);
            greatest = greatest.max((velocity + cross(&omega, arm)).abs().sum());
        }
        greatest
    }
}

/// Link between a contact and a rigid body.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidLink {
    /// Index of the rigid body in the problem, or [`NONE`].
    body: u32,
    /// 1, or -1 if the body is the other side of the contact.
    sign: f32,
    /// Position of the contact point from the center of mass.
    arm: Vec4,
    /// √a_s.
    root: f32,
}

impl RigidLink {
    fn none() -> Self {
        Self { body: NONE, sign: 0.0, arm: Vec4::zeros(), root: 0.0 }
    }
}

/// The rigid bodies of a contact problem, and their links. Empty in a problem without rigid bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct RigidMembers {
    bodies: Vec<RigidMember>,
    /// The links of each constraint.
    links: Vec<[RigidLink; 2]>,
}

impl RigidMembers {
    pub(super) fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    pub(super) fn bytes(&self) -> usize {
        buffer_bytes(&self.bodies) + buffer_bytes(&self.links)
    }

    /// Removes all bodies and links.
    pub(super) fn clear(&mut self) {
        self.bodies.clear();
        self.links.clear();
    }

    /// Adds a body, and returns its index. `length`: the unit of length of the mobility in the units of the problem;
    /// `mobility_factor`: the factor of inverse masses.
    pub(super) fn add(&mut self, mobility: &RigidMobility, length: f32, mobility_factor: f32) -> u32 {
        let factor = f64::from(mobility_factor);
        let columns = |matrix: Matrix3<f64>, lengths: i32| {
            let scale = factor / f64::from(length).powi(lengths);
            [0, 1, 2].map(|c| narrow(matrix.column(c) * scale))
        };
        let zero = (Vec4::zeros(), Vec4::zeros());
        self.bodies.push(RigidMember {
            linear: columns(mobility.linear, 0),
            coupling: columns(mobility.coupling, 1),
            coupling_transposed: columns(mobility.coupling.transpose(), 1),
            angular: columns(mobility.angular, 2),
            change: zero,
            sum: zero,
        });
        self.bodies.len() as u32 - 1
    }

    /// Links a constraint with a body. `sign`: 1, or -1 if the body is the other side.
    pub(super) fn link(&mut self, constraint: usize, body: u32, sign: f32, arm: Vec4) {
        self.complete(constraint + 1);
        let [first, second] = &mut self.links[constraint];
        *(if first.body == NONE { first } else { second }) = RigidLink { body, sign, arm, root: 0.0 };
    }

    /// Gives links to all constraints.
    pub(super) fn complete(&mut self, constraints: usize) {
        if !self.bodies.is_empty() && self.links.len() < constraints {
            self.links.resize(constraints, [RigidLink::none(); 2]);
        }
    }

    /// Copies the links of a constraint of another problem, with its only body. `body`: its index in this problem;
    /// `length`: as for [`add`](Self::add).
    pub(super) fn append(
        &mut self,
        constraint: usize,
        other: &Self,
        of_other: usize,
        body: u32,
        length: f32,
    ) {
        let link = other.links[of_other][0];
        if link.body != NONE {
            self.link(constraint, body, link.sign, link.arm * length);
        }
    }

    /// Returns the change of the velocity of a constraint.
    #[inline(always)]
    pub(super) fn velocity(&self, constraint: usize) -> Vec4 {
        let mut velocity = Vec4::zeros();
        for RigidLink { body, sign, arm, .. } in &self.links[constraint] {
            if *body != NONE {
                let (linear, angular) = self.bodies[*body as usize].change;
                velocity += (linear + cross(&angular, arm)) * *sign;
            }
        }
        velocity
    }

    /// Adds an impulse of a constraint to the sums of its bodies.
    #[inline(always)]
    pub(super) fn add_impulse(&mut self, constraint: usize, impulse: &Vec4) {
        for RigidLink { body, sign, arm, .. } in &self.links[constraint] {
            if *body != NONE {
                let (linear, angular) = &mut self.bodies[*body as usize].sum;
                let impulse = impulse * *sign;
                *linear += impulse;
                *angular += cross(arm, &impulse);
            }
        }
    }

    /// Sets the sums to zero.
    pub(super) fn begin_pass(&mut self) {
        self.bodies.iter_mut().for_each(|body| body.sum = (Vec4::zeros(), Vec4::zeros()));
    }

    /// Adds the changes by the summed impulses.
    pub(super) fn end_pass(&mut self) {
        for RigidMember { linear, coupling, coupling_transposed, angular, change, sum } in &mut self.bodies {
            change.0 += product(linear, &sum.0) + product(coupling, &sum.1);
            change.1 += product(coupling_transposed, &sum.0) + product(angular, &sum.1);
        }
    }

    /// Multiplies the changes by `scale`.
    pub(super) fn scale_changes(&mut self, scale: f32) {
        for RigidMember { change, .. } in &mut self.bodies {
            change.0 *= scale;
            change.1 *= scale;
        }
    }

    /// Computes √a of the constraints and its sums, for [`response`](Self::response).
    pub(super) fn find_responses(&mut self) {
        self.begin_pass();
        let Self { bodies, links } = self;
        for link in links.as_flattened_mut().iter_mut().filter(|link| link.body != NONE) {
            let body = &mut bodies[link.body as usize];
            link.root = body.own_response(&link.arm).sqrt();
            body.sum.0.x += link.root;
        }
    }

    /// Returns the response of a constraint by its rigid bodies.
    pub(super) fn response(&self, constraint: usize) -> f32 {
        let links = self.links[constraint].iter().filter(|link| link.body != NONE);
        links.map(|link| link.root * self.bodies[link.body as usize].sum.0.x).sum()
    }

    /// Returns the impulses on each body in f64, from the impulses of the constraints, in the units of the problem.
    pub(super) fn totals<'a>(&self, impulses: impl Iterator<Item = Vec4> + 'a, totals: &mut Vec<Twist>) {
        totals.clear();
        totals.resize(self.bodies.len(), Twist::default());
        for (links, impulse) in self.links.iter().zip(impulses) {
            for RigidLink { body, sign, arm, .. } in links.iter().filter(|link| link.body != NONE) {
                let impulse: Vector3<f64> = wide(&impulse) * f64::from(*sign);
                let total = &mut totals[*body as usize];
                total.linear += impulse;
                total.angular += wide(arm).cross(&impulse);
            }
        }
    }

    /// Returns the change of the motion of a body.
    pub(super) fn change(&self, body: u32) -> Twist {
        let (linear, angular) = &self.bodies[body as usize].change;
        Twist { linear: wide(linear), angular: wide(angular) }
    }
}

#[inline(always)]
fn cross(a: &Vec4, b: &Vec4) -> Vec4 {
    Vec4::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x, 0.0)
}

#[inline(always)]
fn product(matrix: &Columns, vector: &Vec4) -> Vec4 {
    matrix[0] * vector.x + matrix[1] * vector.y + matrix[2] * vector.z
}

#[cfg(test)]
mod tests {
    use super::super::constraint::Contact;
    use super::super::jacobi::Tolerance;
    use super::super::solver::Solver;
    use super::*;

    /// A cube of the edge 2 and the mass 1, with its center at the origin.
    fn mobility() -> RigidMobility {
        let inertia = 4.0 / 6.0;
        RigidMobility {
            center: Vector3::zeros(),
            bounding_radius: 3.0_f64.sqrt(),
            linear: Matrix3::identity(),
            coupling: Matrix3::zeros(),
            angular: Matrix3::identity() / inertia,
        }
    }

    fn vector(x: f32, y: f32, z: f32) -> Vec4 {
        Vec4::new(x, y, z, 0.0)
    }

    /// Solves contacts at points below the cube, which falls at the speed 1, and returns the change of its motion.
    fn landed(points: &[(f32, f32)]) -> Twist {
        let mut solver = Solver::new(0);
        let body = solver.rigid.add(&mobility(), 1.0, 1.0);
        for &(x, z) in points {
            let (normal, velocity) = (vector(0.0, 1.0, 0.0), vector(0.0, -1.0, 0.0));
            let contact = Contact { normal, velocity, approach: 1.0, ..Contact::default() };
            solver.add(contact, std::iter::empty());
            solver.rigid.link(solver.len() - 1, body, 1.0, vector(x, -1.0, z));
        }
        solver.solve(Tolerance { passes: 101, relative: 0.0, absolute: 1e-7 });
        solver.rigid.change(body)
    }

    #[test]
    fn impulses_stop_a_cube_at_its_corners() {
        let change = landed(&[(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]);
        assert!((change.linear - Vector3::y()).norm() < 1e-5, "{change:?}");
        assert!(change.angular.norm() < 1e-5, "{change:?}");
    }

    /// p = 1 / (1/M + r²/I) at one corner of the edge below.
    #[test]
    fn impulse_at_one_point_has_the_effective_mass_of_the_point() {
        let change = landed(&[(1.0, 0.0)]);
        let impulse = 1.0 / (1.0 + 6.0 / 4.0);
        assert!((change.linear - Vector3::y() * impulse).norm() < 1e-5, "{change:?}");
        assert!((change.angular - Vector3::z() * (impulse * 1.5)).norm() < 1e-5, "{change:?}");
    }
}
