//! The origin of a body, from which its positions and velocities are measured: it stays near the body, so that they are
//! small.

use nalgebra::Vector3;

use super::State;
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::vector::wide;

impl State {
    /// Changes the velocity of the origin to `velocity`, in cells/s. The world velocities of the vertices do
    /// not change. `slots` has the slot of each vertex.
    pub(crate) fn set_origin_velocity(&mut self, slots: &[u32], velocity: Vector3<f64>) {
        let change = self.frame.velocity() - velocity;
        if change == Vector3::zeros() {
            return;
        }
        for &slot in slots {
            let local = wide(self.velocities.get(slot)) + change;
            self.velocities.set(slot, local.map(|v| v as f32).into());
        }
        self.frame.velocity = velocity.into();
        self.momenta.fill(None);
    }

    /// Returns whether the body is so far from its origin that [`rebase`](Self::rebase) is needed: a coordinate of the
    /// vertex in `slot` has a magnitude above two quanta, and the center of mass is not near the origin (it may stay
    /// there if pieces fly apart). A quantum (`Frame::quantum`) is at least the extent of the body in the rest
    /// pose. `weights` has the mass of each vertex in its first row.
    pub(crate) fn needs_rebase(&self, slot: u32, weights: &Lanes<2>) -> bool {
        let is_far = |x: &f32| f64::from(x.abs()) > 2.0 * self.frame.quantum;
        self.positions.get(slot).iter().any(is_far)
            && self.frame.nearest(self.center(weights)) != Vector3::zeros()
    }

    /// Returns the center of mass, in cells from the origin. `weights` is as in [`needs_rebase`](Self::needs_rebase).
    fn center(&self, weights: &Lanes<2>) -> Vector3<f64> {
        let (mut sums, mut mass) = ([[0.0; LANES]; 3], 0.0);
        for (block, [masses, _]) in self.positions.blocks().iter().zip(weights.blocks()) {
            for (sums, coordinates) in sums.iter_mut().zip(block) {
                for ((sum, m), x) in sums.iter_mut().zip(masses.iter()).zip(coordinates.iter()) {
                    *sum += f64::from(*m) * f64::from(*x);
                }
            }
            mass += masses.iter().map(|m| f64::from(*m)).sum::<f64>();
        }
        Vector3::from(sums.map(|sums| sums.iter().sum::<f64>())) / mass
    }

    /// Moves the origin near `center`, a point in cells from the current origin. Each coordinate of the
    /// origin changes by a multiple of the quantum. The world positions of the vertices do not change.
    /// `slots` has the slot of each vertex.
    pub(crate) fn rebase(&mut self, slots: &[u32], center: Vector3<f64>) {
        let offset = self.frame.nearest(center);
        if offset == Vector3::zeros() {
            return;
        }
        self.frame.shift = (Vector3::from(self.frame.shift) + offset).into();
        for &slot in slots {
            self.set_local(slot, self.local(slot) - offset);
        }
        if let Some(rigid) = &mut self.rigid {
            rigid.set_center(rigid.center() - offset);
        }
        self.supports.shift(-offset);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::lattice::{Lattice, Layout};
    use crate::state::Placement;

    #[test]
    fn pieces_that_fly_apart_need_no_rebase_while_their_center_stays() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [4, 0, 0]], 1.0, Point3::origin(), false).unwrap();
        let layout = Layout::new(&lattice);
        let mut state = State::at_rest(&lattice, &layout, &Placement::default());
        let mut weights = Lanes::zeros(layout.blocks());
        layout.slots().iter().for_each(|&slot| weights.set(slot, [1.0, 1.0]));
        let mut needs_rebase = |offsets: [f64; 2]| {
            for (vertex, &slot) in layout.slots().iter().enumerate() {
                let piece = lattice.components().of_vertex[vertex] as usize;
                state.set_local(slot, Vector3::new(offsets[piece], 0.0, 0.0));
            }
            state.needs_rebase(layout.slots()[0], &weights)
        };
        assert!(!needs_rebase([0.0, 4.0]));
        assert!(!needs_rebase([-1000.0, 1000.0]));
        assert!(needs_rebase([-1000.0, 900.0]));
        assert!(needs_rebase([1000.0, 1004.0]));
    }
}
