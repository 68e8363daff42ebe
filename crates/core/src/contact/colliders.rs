//! The validated colliders of a simulation, and their poses: at rest, along keyframes, or driven.

use nalgebra::Point3;

use super::collider::Collider;
use super::collider_motion::ColliderMotion;
use super::deformation::AnimatedSurface;
use super::fault::{ColliderError, ColliderFault};
use super::posed_collider::{PosedCollider, SurfaceMotion};
use super::shape::{PosedShape, Shape};
use crate::motion::{Drive, EulerPose, Pose, Switch};
use crate::range::RangeError;
use crate::state::{BodyFrame, Interval};

/// Radius in cells below which a ball, a capsule or a rod is narrow. Where a fast body hits one, its cells are
/// stretched about four times: samples that are a cell apart then leave holes with a radius of up to 2.8 cells.
const NARROW: f64 = 3.0;

/// Distance of samples relative to the radius of a narrow collider. At the same stretch they leave holes with 0.7 times
/// the radius.
const SPACING: f64 = 0.25;

/// Least distance of samples, in cells.
const LEAST_SPACING: f64 = 0.25;

/// Validated colliders of a scene, for all of its bodies. Without colliders there are no contacts.
#[derive(Clone, Debug, Default)]
pub struct Colliders(Vec<ValidCollider>);

/// Validated collider and its motion.
#[derive(Clone, Debug)]
struct ValidCollider {
    collider: Collider,
    motion: ColliderMotion,
    /// Whether it is enabled now: from the current time until the end of the next step.
    is_enabled: bool,
    /// The surface of an animated mesh. In a box, so that the other colliders are not larger.
    animated: Option<Box<AnimatedSurface>>,
}

/// The motion of a driven collider, as it is saved in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct DrivenCollider {
    /// Index of the collider.
    pub collider: u32,
    pub drive: Drive,
}

impl ValidCollider {
    fn new(collider: &Collider) -> Result<Self, ColliderFault> {
        let motion = ColliderMotion::from_keys(collider.validated_motion()?);
        let animated = match &collider.shape {
            Shape::Mesh { mesh, .. } => AnimatedSurface::new(mesh).map(Box::new),
            _ => None,
        };
        let is_enabled = collider.enabled.value(0.0);
        Ok(Self { collider: collider.clone(), motion, is_enabled, animated })
    }

    /// Returns the shape in a pose, with the surface of an animated mesh before or after the step. `layer`: thickness
    /// of the body in scene units, beside that of the collider; `None` for the shape without a thickness.
    fn posed(&self, pose: &Pose, frame: BodyFrame, layer: Option<f64>, is_after: bool) -> PosedShape<'_> {
        let thickness = layer.map_or(0.0, |layer| (self.collider.thickness + layer) / frame.cell_size);
        let shape = self.collider.shape.posed(pose, frame).thickened(thickness);
        self.with_animation(shape, is_after)
    }

    /// Replaces the surface of an animated mesh by that before or after the step.
    fn with_animation<'a>(&'a self, shape: PosedShape<'a>, is_after: bool) -> PosedShape<'a> {
        match &self.animated {
            Some(animated) => shape.with_surface(animated.surface(is_after)),
            None => shape,
        }
    }
}

impl Colliders {
    /// Validates colliders. Their order changes results at rounding level where they overlap.
    ///
    /// # Errors
    /// Returns the fault of the first invalid collider.
    pub fn new(colliders: &[Collider]) -> Result<Self, ColliderError> {
        let validate =
            |(collider, input)| ValidCollider::new(input).map_err(|fault| ColliderError { collider, fault });
        colliders.iter().enumerate().map(validate).collect::<Result<_, _>>().map(Self)
    }

    /// Returns whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the number of colliders.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the description of a collider.
    pub(crate) fn description(&self, index: usize) -> &Collider {
        &self.0[index].collider
    }

    /// Returns the descriptions of the colliders.
    pub(crate) fn list(&self) -> impl Iterator<Item = &Collider> {
        self.0.iter().map(|collider| &collider.collider)
    }

    /// Returns whether any collider is not a plane. Only planes need no paths: every point behind them is nearest to
    /// the side from which it came.
    pub(super) fn any_needs_paths(&self) -> bool {
        self.enabled().any(|(_, valid)| !matches!(valid.collider.shape, Shape::Plane { .. }))
    }

    /// Returns the colliders that are enabled now, with their indices.
    fn enabled(&self) -> impl Iterator<Item = (u32, &ValidCollider)> + Clone {
        (0..).zip(&self.0).filter(|(_, valid)| valid.is_enabled)
    }

    /// Returns whether any collider is enabled now.
    pub(crate) fn any_enabled(&self) -> bool {
        self.enabled().next().is_some()
    }

    /// Returns whether a collider is enabled now.
    pub(crate) fn is_enabled(&self, collider: u32) -> bool {
        self.0.get(collider as usize).is_some_and(|valid| valid.is_enabled)
    }

    /// Sets when a collider is enabled. [`switch`](Self::switch) lets it take effect.
    pub(crate) fn set_enabled(&mut self, index: usize, enabled: Switch) {
        self.0[index].collider.enabled = enabled;
    }

    /// Returns the colliders that [`switch`](Self::switch) enables or disables.
    fn switching(&self, time: f64) -> impl Iterator<Item = &ValidCollider> {
        self.0.iter().filter(move |valid| valid.is_enabled != valid.collider.enabled.value(time))
    }

    /// Returns whether [`switch`](Self::switch) enables or disables a collider.
    pub(crate) fn any_switches(&self, time: f64) -> bool {
        self.switching(time).next().is_some()
    }

    /// Returns whether [`switch`](Self::switch) enables or disables a collider that is within `distance` of a point in
    /// the frame of a body, in cells.
    pub(crate) fn switches_near(
        &self,
        time: f64,
        frame: BodyFrame,
        (point, distance): (&Point3<f64>, f64),
    ) -> bool {
        let mut shapes =
            self.switching(time).map(|valid| valid.posed(&valid.motion.pose(time), frame, Some(0.0), true));
        shapes.any(|shape| shape.signed_distance(point).distance <= distance)
    }

    /// Returns the shapes at `time` of the colliders that are enabled after [`switch`](Self::switch) and that satisfy a
    /// condition of whether they are enabled before it, in the frame of a body, without a thickness.
    pub(crate) fn switched(
        &self,
        time: f64,
        frame: BodyFrame,
        condition: impl Fn(bool) -> bool,
    ) -> impl Iterator<Item = PosedShape<'_>> {
        let after = self.0.iter().filter(move |valid| valid.collider.enabled.value(time));
        let found = after.filter(move |valid| condition(valid.is_enabled));
        found.map(move |valid| valid.posed(&valid.motion.pose(time), frame, None, true))
    }

    /// Enables and disables the colliders for `time`, in seconds, which is the current time.
    pub(crate) fn switch(&mut self, time: f64) {
        for valid in &mut self.0 {
            valid.is_enabled = valid.collider.enabled.value(time);
        }
    }

    /// Returns the greatest distance of samples, in cells, at which no collider fits between them: one cell, or less
    /// for narrow colliders. A body that falls on one is stretched there, and with it the distances of its samples.
    pub(crate) fn sample_spacing(&self, cell_size: f64) -> f64 {
        let radius =
            self.list().filter_map(|collider| collider.shape.narrow_radius()).fold(f64::INFINITY, f64::min);
        match radius / cell_size {
            radius if radius < NARROW => (radius * SPACING).max(LEAST_SPACING),
            _ => 1.0,
        }
    }

    /// Returns the coefficient of rolling resistance of a collider; `None` if that of the body holds.
    pub(crate) fn rolling_resistance(&self, collider: u32) -> Option<f64> {
        self.0.get(collider as usize).and_then(|valid| valid.collider.rolling_resistance)
    }

    /// Returns the coefficient of friction of a collider.
    pub(crate) fn friction(&self, collider: u32) -> f64 {
        self.0.get(collider as usize).map_or(0.0, |valid| valid.collider.friction)
    }

    /// Returns whether bodies that roll freely have a resistance on a collider.
    pub(crate) fn resist_rolling(&self) -> bool {
        self.0
            .iter()
            .any(|valid| valid.collider.rolling_resistance.is_some_and(|coefficient| coefficient > 0.0))
    }

    /// Returns whether any enabled collider may move.
    pub(crate) fn any_moves(&self) -> bool {
        self.enabled()
            .any(|(_, valid)| valid.animated.is_some() || !matches!(valid.motion, ColliderMotion::Rest))
    }

    /// Returns whether the colliders need no update in the course of time: none is driven or has an animated mesh, and
    /// none is enabled or disabled. Colliders with keyframes may move.
    pub(crate) fn need_no_update(&self) -> bool {
        self.0.iter().all(|valid| {
            let is_driven = matches!(valid.motion, ColliderMotion::Driven(_));
            let is_constant = valid.collider.enabled.constant() == Some(valid.is_enabled);
            !is_driven && valid.animated.is_none() && is_constant
        })
    }

    /// Returns whether a collider that moves during a step comes within `distance` of a point in the frame of a body,
    /// in cells, beside its thickness.
    pub(crate) fn moves_near(
        &self,
        step: Interval,
        frame: BodyFrame,
        point: &Point3<f64>,
        distance: f64,
    ) -> bool {
        self.during(step, frame, 0.0).any(|PosedCollider { shape_before, shape, .. }| {
            shape != shape_before
                && [shape_before, shape].iter().any(|shape| shape.signed_distance(point).distance <= distance)
        })
    }

    /// Returns the poses of a collider before and after a step.
    pub(crate) fn poses(&self, index: usize, step: Interval) -> [EulerPose; 2] {
        self.0[index].motion.euler_poses(step)
    }

    /// Drives a collider from its pose at `time`, the current time, to `target` in `duration` seconds; `None`:
    /// in one step. This replaces its keyframes and a motion that has not ended.
    ///
    /// # Errors
    /// The errors of [`Drive::new`]. The collider is then unchanged.
    pub(crate) fn drive(
        &mut self,
        index: usize,
        time: f64,
        target: EulerPose,
        duration: Option<f64>,
    ) -> Result<(), RangeError> {
        let motion = &mut self.0[index].motion;
        match motion {
            ColliderMotion::Rest => {
                *motion = ColliderMotion::driven(Drive::new(EulerPose::default(), target, duration)?);
            }
            ColliderMotion::Keys(keys) => {
                *motion = ColliderMotion::driven(Drive::new(keys.euler_pose(time), target, duration)?);
            }
            ColliderMotion::Driven(drive) => **drive = Drive::new(drive.current(), target, duration)?,
        }
        Ok(())
    }

    /// Advances the driven colliders by a step of `dt` seconds.
    pub(crate) fn advance(&mut self, dt: f64) {
        for ValidCollider { motion, .. } in &mut self.0 {
            if let ColliderMotion::Driven(drive) = motion {
                drive.advance(dt);
            }
        }
    }

    /// Returns the motions of the driven colliders, in the order of the colliders.
    pub(crate) fn driven(&self) -> Vec<DrivenCollider> {
        let drive = |(index, ValidCollider { motion, .. }): (usize, &ValidCollider)| match motion {
            ColliderMotion::Driven(drive) => Some(DrivenCollider { collider: index as u32, drive: **drive }),
            _ => None,
        };
        self.0.iter().enumerate().filter_map(drive).collect()
    }

    /// Replaces the motions of the driven colliders. All other colliders follow their keyframes again.
    /// The indices must be less than [`len`](Self::len).
    pub(crate) fn set_driven(&mut self, driven: &[DrivenCollider]) {
        for ValidCollider { collider, motion, .. } in &mut self.0 {
            if let ColliderMotion::Driven(_) = motion {
                let keys = collider.validated_motion().expect("the collider was validated");
                *motion = ColliderMotion::from_keys(keys);
            }
        }
        for &DrivenCollider { collider, drive } in driven {
            self.0[collider as usize].motion = ColliderMotion::driven(drive);
        }
    }

    /// Computes the surfaces of animated meshes at the start and at the end of a step.
    pub(crate) fn animate(&mut self, step: Interval) {
        self.animate_meshes([step.start, step.end]);
    }

    /// Enables and disables the colliders, and computes the surfaces of animated meshes, at a time in seconds.
    pub(crate) fn set_time(&mut self, time: f64) {
        self.switch(time);
        self.animate_to(time);
    }

    /// Computes the surfaces of animated meshes at a time in seconds.
    pub(crate) fn animate_to(&mut self, time: f64) {
        self.animate_meshes([time; 2]);
    }

    fn animate_meshes(&mut self, times: [f64; 2]) {
        let animated = self.0.iter_mut().filter_map(|collider| collider.animated.as_mut());
        animated.for_each(|animated| animated.advance(times));
    }

    /// Returns the shape of each enabled collider at `time` (in seconds), in the frame of a body with the thickness
    /// `layer` in scene units: with the thickness of both. Animated meshes are as at the end of the last step, or at
    /// the time that was set.
    pub(crate) fn at(
        &self,
        time: f64,
        frame: BodyFrame,
        layer: f64,
    ) -> impl Iterator<Item = PosedShape<'_>> + Clone {
        self.enabled()
            .map(move |(_, collider)| collider.posed(&collider.motion.pose(time), frame, Some(layer), true))
    }

    /// Returns the shape of each enabled collider at `time` as [`at`](Self::at), in world space and scene units, and
    /// without a thickness, that of shells included, with the index of the collider.
    pub(crate) fn surfaces_at(&self, time: f64) -> impl Iterator<Item = (usize, PosedShape<'_>)> {
        self.enabled().map(move |(index, valid)| {
            let pose = valid.motion.pose(time);
            let shape = valid.collider.shape.posed(&pose, BodyFrame::WORLD);
            (index as usize, valid.with_animation(shape, true))
        })
    }

    /// Returns the shape of each enabled collider at the start of a step, in the frame of a body, without a thickness.
    pub(crate) fn before(&self, step: Interval, frame: BodyFrame) -> impl Iterator<Item = PosedShape<'_>> {
        self.enabled().map(move |(_, valid)| valid.posed(&valid.motion.pose(step.start), frame, None, false))
    }

    /// Returns each enabled collider during one step, in the frame of a body with the thickness `layer` in scene units.
    pub(super) fn during(
        &self,
        step: Interval,
        frame: BodyFrame,
        layer: f64,
    ) -> impl Iterator<Item = PosedCollider<'_>> {
        self.enabled().map(move |(index, valid)| {
            let ValidCollider { collider, motion, animated, .. } = valid;
            let ([start, end], is_moving) = motion.poses(step);
            let posed = |pose, is_after| valid.posed(pose, frame, Some(layer), is_after);
            let (shape_before, shape) = (posed(&start, false), posed(&end, true));
            let deformation = match (animated, shape_before, shape) {
                (Some(animated), PosedShape::Mesh(before), PosedShape::Mesh(after)) => {
                    animated.deformation(before, after)
                }
                _ => None,
            };
            PosedCollider {
                index,
                shape_before,
                shape,
                deformation,
                friction: collider.friction,
                restitution: collider.restitution,
                start,
                end,
                center: collider.shape.center(),
                frame,
                rate: 1.0 / step.dt,
                motion: is_moving.then(|| SurfaceMotion {
                    center: Point3::from((collider.shape.center() - frame.origin) / frame.cell_size),
                    rotation_to_start: start.rotation * end.rotation.transpose(),
                    translation_at_start: start.translate / frame.cell_size,
                    translation_at_end: end.translate / frame.cell_size,
                }),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colliders_that_are_not_driven_store_nothing_for_it() {
        assert_eq!(size_of::<ColliderMotion>(), size_of::<crate::motion::Motion>());
        let mut colliders = Colliders::new(&[Collider::plane([0.0; 3], [0.0, 1.0, 0.0])]).unwrap();
        assert!(colliders.driven().is_empty());
        assert!(!colliders.0[0].motion.poses(Interval::of_step(0, 0.1)).1);
        colliders.drive(0, 0.0, EulerPose { translate: [1.0; 3], rotate: [0.0; 3] }, None).unwrap();
        assert!(colliders.0[0].motion.poses(Interval::of_step(0, 0.1)).1);
        colliders.advance(0.1);
        assert!(!colliders.0[0].motion.poses(Interval::of_step(1, 0.1)).1);
        assert_eq!(colliders.driven().len(), 1);
    }
}
