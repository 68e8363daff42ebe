//! Returns a tangled body to its rest shape.
//!
//! A body that starts tangled, with vertices at random places for example, can come to rest in itself: twisted, with no cell
//! inside out, and in equilibrium, so that nothing in a cell shows it. The wider the regions the rarer this is, because
//! they span what is twisted. So a body of which many cells are inside out at once follows the widest region of all, the
//! whole body, until its vertices are near their places: a vertex at x has the velocity of the rigid
//! motion of the body, plus β (g - x)/h with its goal g = c + R (x⁰ - c⁰) by the rotation R that fits the body best
//! (Müller et al. 2005, section 3.3). Plastic shapes and inflation have no part in this goal; the cells bring them back. The
//! second term has no momenta: Σ m (g - x) = 0, and Σ m (x - c) × (g - x) = 0 at
//! the best rotation.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::momentum::RigidState;
use crate::lattice::{Lattice, Layout};
use crate::matching::rotations_near;
use crate::simd::bounds::bounds;
use crate::simd::lanes::Lanes;
use crate::state::State;

/// A body is tangled if more than this share of its cells are inside out. A choice: a body that plates press has some of its
/// cells inside out at most, and one whose vertices are at random places about half of them.
const TANGLED_SHARE: f64 = 0.25;

/// A body that is spread over more than this multiple of its extent along an axis is not tangled: its cells pull it together
/// first, and faster. A choice.
const GREATEST_SPREAD: f64 = 2.0;

/// Greatest β: the share of the distance to its goal that a vertex moves in a step. A choice.
const GREATEST_RATE: f64 = 0.1;

/// Greatest distance in cells that a vertex moves in a step, as a multiple of √α with the stiffness α of the step. The kinetic
/// energy of a unit of mass is then at most α/(32 h²). In a cell that is inside out it has an elastic energy of at least
/// α/(2 h²) times its mean squared distance from a rigid shape, so that a recovery takes energy.
const GREATEST_DISTANCE: f64 = 0.25;

/// Distance in cells of the farthest vertex to its goal at which the recovery ends. No cell can then be inside out.
const NEAR: f64 = 0.25;

/// Greatest number of steps of a recovery.
const MOST_STEPS: f64 = 1e6;

/// Returns whether a body is tangled. `extent` is that of its lattice along the longest axis, in cells.
pub(crate) fn is_tangled(lattice: &Lattice, layout: &Layout, extent: usize, state: &State) -> bool {
    let (low, high) = bounds(&state.positions, layout.occupied());
    if (0..3).any(|a| f64::from(high[a]) - f64::from(low[a]) > GREATEST_SPREAD * extent as f64) {
        return false;
    }
    let slots = layout.slots();
    let is_inside_out = |&cell: &u32| {
        let corners = lattice.cell_corners(cell).map(|vertex| state.local(slots[vertex as usize]));
        // The gradient of the mean deformation of the cell, times 4.
        let column = |bit: usize| {
            let signed = |(i, x): (usize, &Vector3<f64>)| if i >> bit & 1 == 0 { -x } else { *x };
            corners.iter().enumerate().map(signed).sum::<Vector3<f64>>()
        };
        Matrix3::from_columns(&[column(0), column(1), column(2)]).determinant() < 0.0
    };
    let count = lattice.cells().len() as u32;
    let limit = (TANGLED_SHARE * f64::from(count)) as usize;
    // Ends at the first cell beyond the limit.
    (0..count).filter(is_inside_out).nth(limit).is_some()
}

/// Returns the number of steps after which a recovery ends even if something keeps the vertices from their goals: four
/// times as many as a vertex needs for `extent` cells.
pub(crate) fn most_steps(extent: usize, alpha: f64) -> u32 {
    (4.0 * (64.0 + extent as f64 / (GREATEST_DISTANCE * alpha.sqrt()))).min(MOST_STEPS) as u32
}

/// Sets the velocities of a step of `dt` seconds with the stiffness `alpha`, of a body of one component. Returns
/// whether the vertices are near their goals.
///
/// `measured` is the state of the component with the velocities of the step, `weights` has the mass of each vertex in
/// its first row, and `slots` the slot of each vertex.
pub(crate) fn recover(
    (lattice, slots): (&Lattice, &[u32]),
    weights: &Lanes<2>,
    measured: &RigidState,
    state: &mut State,
    (alpha, dt): (f64, f64),
) -> bool {
    let vertices = || {
        let vertices = slots.iter().zip(lattice.indices());
        vertices.map(|(&slot, index)| (slot, Vector3::from(index.map(f64::from))))
    };
    let mass = |slot: u32| f64::from(weights.get(slot)[0]);
    let center = measured.center;
    let rest_center = vertices().map(|(slot, rest)| rest * mass(slot)).sum::<Vector3<f64>>() / measured.mass;
    let moments: Matrix3<f64> = vertices()
        .map(|(slot, rest)| (state.local(slot) - center) * (rest - rest_center).transpose() * mass(slot))
        .sum();
    let rotation = rotations_near(&[moments], &UnitQuaternion::identity())[0];
    let goal = |rest| center + rotation * (rest - rest_center);
    let farthest = vertices().map(|(slot, rest)| (goal(rest) - state.local(slot)).norm()).fold(0.0, f64::max);
    let rate = GREATEST_RATE.min(GREATEST_DISTANCE * alpha.sqrt() / farthest);
    let motion = measured.motion(measured.momentum);
    for (slot, rest) in vertices() {
        let position = state.local(slot);
        let rigid = motion.velocity_at(&(position - center));
        let velocity = rigid + (goal(rest) - position) * (rate / dt);
        state.velocities.set(slot, velocity.map(|v| v as f32).into());
    }
    farthest < NEAR
}
