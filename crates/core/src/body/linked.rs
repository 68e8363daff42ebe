//! Points of a body to which links tie the vertices of another one.

use nalgebra::{Matrix3, Point3, Vector3};

use super::soft_body::Body;
use crate::lattice::Embedding;
use crate::state::{RigidMobility, Twist};

/// A point of a body: a mean of the corners of a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub(crate) corners: [u32; 8],
    pub(crate) weights: [f64; 8],
    /// The place of the point at frame 0.
    pub(crate) place: Point3<f64>,
    /// The distance in cells of the given place from the cell.
    pub(crate) beyond: f64,
}

/// The change of the motion of a rigid body by the impulses of links in a step. In scene units, of world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidLinked {
    mobility: RigidMobility,
    center: Point3<f64>,
    cell_mass: f64,
    cell_size: f64,
    /// Change of the velocity of the center of mass, and of the angular velocity.
    change: Twist,
}

impl RigidLinked {
    /// Returns the change of the motion by an impulse at a point.
    fn response(&self, point: &Point3<f64>, impulse: &Vector3<f64>) -> Twist {
        let linear = impulse / (self.cell_mass * self.cell_size);
        let arm = (point - self.center) / self.cell_size;
        let Twist { linear, angular } = self.mobility.change(&Twist { linear, angular: arm.cross(&linear) });
        Twist { linear: linear * self.cell_size, angular }
    }

    /// Returns the change of the velocity of a point so far.
    pub(crate) fn velocity_change(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.change.velocity_at(&(point - self.center))
    }

    /// Returns the matrix of the velocity change of a point by an impulse on it.
    pub(crate) fn mobility_at(&self, point: &Point3<f64>) -> Matrix3<f64> {
        let response = |axis: usize| self.response(point, &Vector3::ith(axis, 1.0));
        let column = |axis: usize| response(axis).velocity_at(&(point - self.center));
        Matrix3::from_columns(&[0, 1, 2].map(column))
    }

    /// Adds an impulse at a point.
    pub(crate) fn add(&mut self, point: &Point3<f64>, impulse: &Vector3<f64>) {
        self.change = self.change + self.response(point, impulse);
    }
}

impl Body {
    /// Returns the response of a rigid body to links; `None` of a soft one.
    pub(crate) fn rigid_linked(&self) -> Option<RigidLinked> {
        let mobility = *self.rigid.as_ref()?.mobility();
        let center = self.state.frame.to_world(mobility.center);
        let (cell_mass, cell_size) = (self.cell_mass(), self.shape.lattice.cell_size());
        Some(RigidLinked { mobility, center, cell_mass, cell_size, change: Twist::default() })
    }

    /// Returns, for places at frame 0, the point of the body that is there by extrapolation from the nearest cell, or the
    /// point of this cell that is nearest.
    pub(crate) fn anchors_at_start(&self, places: &[Point3<f64>], nearest: bool) -> Vec<Anchor> {
        let to_model = self.shape.model_to_world.inverse();
        let points: Vec<Point3<f64>> = places.iter().map(|place| to_model * place).collect();
        let embedding = Embedding::new(&self.shape.lattice, &points);
        let anchor = |point: usize| {
            let local = embedding.local(point).map(f64::from);
            let inside = local.map(|x| x.clamp(0.0, 1.0));
            let beyond = Vector3::from(std::array::from_fn::<f64, 3, _>(|a| local[a] - inside[a])).norm();
            let chosen = if nearest { inside } else { local };
            let corners = embedding.corners(point);
            // Corner k of a cell is at (k & 1, k >> 1 & 1, k >> 2 & 1).
            let factor = |k: usize, a: usize| if k >> a & 1 == 1 { chosen[a] } else { 1.0 - chosen[a] };
            let weights = std::array::from_fn(|k| (0..3).map(|a| factor(k, a)).product());
            let mut place = self.start_of(corners[0]);
            let first = place;
            for (&corner, weight) in corners.iter().zip(weights) {
                let weight: f64 = weight;
                place += (self.start_of(corner) - first) * weight;
            }
            Anchor { corners, weights, place, beyond }
        };
        (0..places.len()).map(anchor).collect()
    }

    /// Returns the position and the velocity of a lattice vertex in world space.
    pub(crate) fn vertex_motion(&self, vertex: u32) -> (Point3<f64>, Vector3<f64>) {
        let slot = self.pipeline.matching.layout.slots()[vertex as usize];
        let position = self.state.frame.to_world(self.state.local(slot));
        (position, self.state.frame.velocity_to_world(self.state.velocities.get(slot)))
    }

    /// Adds forces in the next step, on vertices each of which occurs once. Forces of zero leave a body at rest asleep.
    pub(crate) fn add_step_forces(&mut self, forces: &[(u32, [f64; 3])]) {
        self.forces.get_or_insert_default().add(forces.iter().copied());
    }
}
