//! Boxes of the motion of the parts of a body in a step, by which those that may touch each other are found.

use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use crate::contact::parts::Parts;
use crate::simd::bounds::bounds;
use crate::simd::lanes::Lanes;
use crate::simd::vector::wide;
use crate::state::State;

/// Boxes of the motion of a body or a part in a step, by which those that are near are found, and the times at which
/// they are searched.
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

    /// Returns how fast two motions are relative to each other in the common part of their boxes.
    pub(super) fn nearness(&self, other: &Self, region: Bounds) -> Nearness {
        let speed_before = self.velocities_before.greatest_difference(&other.velocities_before);
        Nearness { region, speed_before, speed: self.velocities.greatest_difference(&other.velocities) }
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

/// The lattice vertices of the parts of a body.
#[derive(Clone, Copy)]
pub(crate) struct PartVertices<'a> {
    pub parts: Parts<'a>,
    /// Slot of each lattice vertex.
    pub slots: &'a [u32],
    /// Bit mask of the lanes with a vertex, for each block of eight slots.
    pub occupied: &'a [u8],
}

/// Boxes of the motion of the parts of a body in a step.
#[derive(Debug)]
pub(super) struct PartMotions {
    /// Of all parts together.
    pub(super) all: MotionBounds,
    parts: Vec<MotionBounds>,
    /// Buffer: least and greatest coordinates of each part.
    extents: Vec<([f32; 3], [f32; 3])>,
}

/// Where and how fast two bodies, or the parts of a body, may touch each other in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearness {
    /// Contains the common parts of their boxes.
    pub(super) region: Bounds,
    /// Greatest relative speed before the step, in scene units per second.
    pub(super) speed_before: f64,
    /// Greatest relative speed at the end of the step without contacts.
    pub(super) speed: f64,
}

impl Nearness {
    /// Returns where and how fast the parts of one or the other of two pairs may touch each other.
    fn union(&self, other: &Self) -> Self {
        Self {
            region: self.region.union(&other.region),
            speed_before: self.speed_before.max(other.speed_before),
            speed: self.speed.max(other.speed),
        }
    }
}

impl PartMotions {
    /// Of a body without vertices.
    pub(super) const EMPTY: Self = Self { all: MotionBounds::EMPTY, parts: Vec::new(), extents: Vec::new() };

    /// Stores the velocities before the step.
    pub(super) fn begin(&mut self, state: &State, vertices: &PartVertices<'_>) {
        let velocity = |local| Point3::from(state.frame.velocity_to_world(local));
        self.measure(&state.velocities, vertices, velocity, |motion| &mut motion.velocities_before);
    }

    /// Measures the positions and velocities at the end of the step without contacts.
    pub(super) fn end(&mut self, state: &State, vertices: &PartVertices<'_>) {
        let velocity = |local| Point3::from(state.frame.velocity_to_world(local));
        self.measure(&state.velocities, vertices, velocity, |motion| &mut motion.velocities);
        let position = |local: [f32; 3]| state.frame.to_world(wide(local));
        self.measure(&state.positions, vertices, position, |motion| &mut motion.positions);
        let overhang = vertices.parts.overhang * state.frame.cell_size();
        for motion in self.parts.iter_mut().chain([&mut self.all]) {
            motion.positions = motion.positions.enlarged(overhang);
        }
    }

    /// Returns where the parts may touch each other in a step of `dt` seconds, at a distance of up to `margin`; `None`
    /// if they cannot. `with_itself`: whether a part touches itself. `order` is a buffer.
    pub(super) fn near(
        &self,
        with_itself: bool,
        dt: f64,
        margin: f64,
        order: &mut Vec<u32>,
    ) -> Option<Nearness> {
        let swept = |part: u32| self.parts[part as usize].swept(dt).enlarged(margin);
        let mut near: Option<Nearness> = None;
        Bounds::for_each_pair(self.parts.len() as u32, swept, with_itself, order, |a, b| {
            let [first, second] = [a, b].map(|part| &self.parts[part as usize]);
            let found = first.nearness(second, swept(a).intersection(&swept(b)));
            near = Some(near.map_or(found, |near| near.union(&found)));
        });
        near
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.parts) + size_of_val(&*self.extents)
    }

    /// Measures a box of each part and of all. `world`: converts numbers of a vertex to the space of the box.
    fn measure(
        &mut self,
        lanes: &Lanes<3>,
        vertices: &PartVertices<'_>,
        world: impl Fn([f32; 3]) -> Point3<f64>,
        field: fn(&mut MotionBounds) -> &mut Bounds,
    ) {
        let Self { all, parts, extents } = self;
        vertices.measure_extents(lanes, extents);
        parts.resize(extents.len(), MotionBounds::EMPTY);
        *field(all) = Bounds::EMPTY;
        for (motion, &(low, high)) in parts.iter_mut().zip(&*extents) {
            let bounds = Bounds { low: world(low), high: world(high) };
            *field(motion) = bounds;
            *field(all) = field(all).union(&bounds);
        }
    }
}

impl PartVertices<'_> {
    /// Measures the least and greatest numbers of the vertices of each part.
    fn measure_extents(&self, lanes: &Lanes<3>, extents: &mut Vec<([f32; 3], [f32; 3])>) {
        extents.clear();
        if self.parts.count == 1 {
            extents.push(bounds(lanes, self.occupied));
            return;
        }
        extents.resize(self.parts.count, ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]));
        for (vertex, &slot) in (0..).zip(self.slots) {
            let (low, high) = &mut extents[self.parts.of_vertex(vertex) as usize];
            for (axis, number) in lanes.get(slot).into_iter().enumerate() {
                low[axis] = low[axis].min(number);
                high[axis] = high[axis].max(number);
            }
        }
    }
}
