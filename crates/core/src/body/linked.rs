//! Points of a body to which links tie the vertices of another one.

use nalgebra::{Point3, Vector3};

use super::soft_body::Body;
use crate::lattice::Embedding;

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

impl Body {
    /// Returns, for places at frame 0, the point of the body that is there by extrapolation from the nearest cell, or the
    /// point of this cell that is nearest.
    pub(crate) fn anchors_at_start(&self, places: &[Point3<f64>], nearest: bool) -> Vec<Option<Anchor>> {
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
        (0..places.len()).map(|point| Some(anchor(point))).collect()
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
