//! The state of vertices that leave colliders.

use nalgebra::Vector3;

/// The state of a vertex of a component that leaves colliders, before the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaving {
    pub(super) slot: u32,
    /// Index of the connected component.
    pub(super) component: u32,
    /// Position and velocity in cells and cells/s.
    pub(super) position: Vector3<f64>,
    pub(super) velocity: [f32; 3],
}
