//! Boxes of the motion of a body and of its pieces in a step, by which those that may touch each other are found.

use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use crate::simd::lanes::Lanes;
use crate::state::State;

/// Boxes of the motion of a body in a step, by which near bodies are found, and the times at which they are searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionBounds {
    /// Positions at the end of the step without contacts, in world space.
    pub(super) positions: Bounds,
    /// Velocities at the end of the step without contacts, in scene units per second.
    pub(super) velocities: Bounds,
    /// Velocities before the step, in scene units per second.
    pub(super) velocities_before: Bounds,
}

impl MotionBounds {
    /// Of a body without vertices.
    pub(super) const EMPTY: Self =
        Self { positions: Bounds::EMPTY, velocities: Bounds::EMPTY, velocities_before: Bounds::EMPTY };

    /// Returns the greatest relative speeds of two motions, in scene units per second: before the step, and at its end
    /// without contacts.
    pub(super) fn greatest_speeds(&self, other: &Self) -> (f64, f64) {
        let before = self.velocities_before.greatest_difference(&other.velocities_before);
        (before, self.velocities.greatest_difference(&other.velocities))
    }

    /// Returns the box of the positions during a step of `dt` seconds: those at its end, minus parts of the
    /// displacements.
    pub(super) fn swept(&self, dt: f64) -> Bounds {
        let Self { positions, velocities, .. } = self;
        Bounds {
            low: positions.low - velocities.high.coords.sup(&Vector3::zeros()) * dt,
            high: positions.high - velocities.low.coords.inf(&Vector3::zeros()) * dt,
        }
    }
}

/// The lattice vertices of the pieces of a body.
#[derive(Clone, Copy)]
pub(crate) struct PieceVertices<'a> {
    /// Number of pieces.
    pub(crate) count: usize,
    /// Piece of each lattice vertex.
    pub(crate) of_vertex: &'a [u32],
    /// Slot of each lattice vertex.
    pub(crate) slots: &'a [u32],
}

/// Boxes of the motion of each piece of a body in a step; empty if the body is in one piece.
#[derive(Debug, Default)]
pub(super) struct PieceMotions {
    motions: Vec<MotionBounds>,
    /// Buffer: least and greatest coordinates of each piece.
    extents: Vec<[[f32; 3]; 2]>,
}

/// Where and how fast the pieces of a body may touch each other in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearPieces {
    /// Contains the common parts of the boxes of all pairs of pieces.
    pub(super) region: Bounds,
    /// Greatest relative speed before the step of two pieces whose boxes overlap, in scene units per second.
    pub(super) speed_before: f64,
    /// Their greatest relative speed at the end of the step without contacts.
    pub(super) speed: f64,
}

impl PieceMotions {
    /// Removes the boxes: the body is in one piece.
    pub(super) fn clear(&mut self) {
        self.motions.clear();
    }

    /// Stores the velocities before the step.
    pub(super) fn begin(&mut self, state: &State, pieces: PieceVertices<'_>) {
        self.measure_extents(&state.velocities, pieces);
        for (motion, extent) in self.motions.iter_mut().zip(&self.extents) {
            motion.velocities_before = velocity_box(state, *extent);
        }
    }

    /// Measures the positions and velocities at the end of the step without contacts. A smooth surface of a crack lies
    /// at most a cell outside the lattice.
    pub(super) fn measure(&mut self, state: &State, pieces: PieceVertices<'_>) {
        self.measure_extents(&state.positions, pieces);
        for (motion, extent) in self.motions.iter_mut().zip(&self.extents) {
            let [low, high] = extent.map(|corner| state.frame.to_world(Vector3::from(corner.map(f64::from))));
            motion.positions = Bounds { low, high }.enlarged(state.frame.cell_size());
        }
        self.measure_extents(&state.velocities, pieces);
        for (motion, extent) in self.motions.iter_mut().zip(&self.extents) {
            motion.velocities = velocity_box(state, *extent);
        }
    }

    /// Returns where the pieces may touch each other in a step of `dt` seconds, at a distance of up to `margin`; `None`
    /// if they cannot. `order` is a buffer.
    pub(super) fn near(&self, dt: f64, margin: f64, order: &mut Vec<u32>) -> Option<NearPieces> {
        let swept = |piece: u32| self.motions[piece as usize].swept(dt).enlarged(margin);
        order.clear();
        order.extend((0..self.motions.len() as u32).filter(|&piece| !swept(piece).is_empty()));
        order.sort_unstable_by(|&a, &b| swept(a).low.x.total_cmp(&swept(b).low.x).then(a.cmp(&b)));
        let mut near: Option<NearPieces> = None;
        for (place, &a) in order.iter().enumerate() {
            let (own, motion) = (swept(a), &self.motions[a as usize]);
            for &b in order[place + 1..].iter().take_while(|&&b| swept(b).low.x <= own.high.x) {
                let common = own.intersection(&swept(b));
                if common.is_empty() {
                    continue;
                }
                let (speed_before, speed) = motion.greatest_speeds(&self.motions[b as usize]);
                let found = near.get_or_insert(NearPieces { region: common, speed_before, speed });
                found.region = found.region.union(&common);
                found.speed_before = found.speed_before.max(speed_before);
                found.speed = found.speed.max(speed);
            }
        }
        near
    }

    /// Returns whether the body is in pieces.
    pub(super) fn is_any(&self) -> bool {
        !self.motions.is_empty()
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.motions) + size_of_val(&*self.extents)
    }

    /// Measures the least and greatest numbers of the vertices of each piece.
    fn measure_extents(&mut self, lanes: &Lanes<3>, pieces: PieceVertices<'_>) {
        let Self { motions, extents } = self;
        motions.resize(pieces.count, MotionBounds::EMPTY);
        extents.clear();
        extents.resize(pieces.count, [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]]);
        for (&piece, &slot) in pieces.of_vertex.iter().zip(pieces.slots) {
            let [low, high] = &mut extents[piece as usize];
            for (axis, number) in lanes.get(slot).into_iter().enumerate() {
                low[axis] = low[axis].min(number);
                high[axis] = high[axis].max(number);
            }
        }
    }
}

/// Returns the box of velocities in scene units per second.
fn velocity_box(state: &State, extent: [[f32; 3]; 2]) -> Bounds {
    let [low, high] = extent.map(|corner| Point3::from(state.frame.velocity_to_world(corner)));
    Bounds { low, high }
}
