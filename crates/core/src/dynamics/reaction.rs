//! The conditions of supports on the reference motion of a component, and the impulses by which supports meet them: see
//! [`elastic_damping`](super::elastic_damping).
//!
//! The impulses of a support have *limits*, each for itself:
//!
//! * along the normal, the impulse of the contacts in the step along it to take the pressure away, and n p to add to
//!   it, with
//!   the sum p of their normal impulses. Contacts act
//!   on one layer of vertices, and elasticity resists over the n = w + 1/2 layers from the surface to the middle of a
//!   region of half-width w: on all of them, the contacts would press n times as much. For cells n is 1;
//! * across it what is left of the friction, mu p - |F|, with the friction F in the step;
//! * about an axis across the normal p r: the center of pressure moves by at most the radius r of the contact; about
//!   the normal mu p r.
//!
//! Where a condition needs more than the limit, the impulse is the limit, and the condition has no further effect.

use nalgebra::{Vector3, Vector6};

use super::deflection::{axes_without, deflect};
use super::momentum::Projection;
use super::varied_damping::DampingRates;
use crate::state::{Pressing, Support, Twist};

/// Excess over a limit, relative to the limit, that is due to rounding.
const ROUNDING: f64 = 1e-9;

/// What a support can give: see the [module](self).
#[derive(Clone, Copy, Debug)]
pub(super) struct SupportLimits {
    pressing: f64,
    relieving: f64,
    sliding: f64,
    tilt: f64,
    twist: f64,
}

/// The conditions of the supports of a component.
#[derive(Clone, Debug, Default)]
pub(super) struct SupportConditions {
    conditions: Vec<Condition>,
    groups: usize,
}

/// A condition: the speed of the component along `row` is `value`.
#[derive(Clone, Debug)]
pub(super) struct Condition {
    /// Index of the support.
    pub(super) support: u32,
    /// Conditions of one group have perpendicular directions, and one limit for all their impulses.
    group: usize,
    pub(super) row: Vector6<f64>,
    value: f64,
    limits: ImpulseLimits,
    /// Variance in the projection; 0 if earlier conditions determine the speed.
    softness: f64,
    /// Impulse on the component along `row`.
    pub(super) impulse: f64,
    is_limited: bool,
}

/// The greatest impulses against and along a direction, both not negative. Those of several perpendicular directions
/// together are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImpulseLimits(pub(super) [f64; 2]);

/// A direction in which a support meets a condition by an impulse.
#[derive(Clone, Copy, Debug)]
pub(super) enum Direction {
    /// A force along a unit vector at the center of pressure.
    Along(Vector3<f64>),
    /// A torque about a unit vector.
    About(Vector3<f64>),
}

/// Returns the direction of a kind along a unit vector.
type DirectionKind = fn(Vector3<f64>) -> Direction;

/// The directions of the conditions of a support, with their limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct SupportDirections {
    limits: SupportLimits,
    /// Unit normal; zero if normals all around cancel each other.
    normal: Vector3<f64>,
    /// The directions in which the component rolls and slides, without conditions.
    rolling: Option<Vector3<f64>>,
    sliding: Option<Vector3<f64>>,
}

impl ImpulseLimits {
    fn both(limit: f64) -> Self {
        Self([limit; 2])
    }

    /// Returns the limits over a factor.
    pub(super) fn over(self, factor: f64) -> Self {
        Self(self.0.map(|limit| limit / factor))
    }

    /// Returns the impulse within the limits that is nearest to another one; also for limits that are not numbers.
    pub(super) fn nearest(self, impulse: f64) -> f64 {
        impulse.max(-self.0[0]).min(self.0[1])
    }
}

impl Direction {
    /// Returns the row of the condition: its product with (v, ω) is the speed along the direction. `arm`: from the
    /// center of mass to the center of pressure.
    pub(super) fn row(self, arm: Vector3<f64>) -> Vector6<f64> {
        match self {
            Self::Along(axis) => Twist { linear: axis, angular: arm.cross(&axis) }.components(),
            Self::About(axis) => Twist { angular: axis, ..Twist::default() }.components(),
        }
    }

    /// Returns the speed of a surface along the direction.
    fn speed(self, velocity: Vector3<f64>, spin: Vector3<f64>) -> f64 {
        match self {
            Self::Along(axis) => axis.dot(&velocity),
            Self::About(axis) => axis.dot(&spin),
        }
    }
}

impl SupportDirections {
    /// Returns the directions of a contact with these limits, and advances its deflections by a step of `dt` seconds.
    ///
    /// * `turning`, `slip`: angular velocity and velocity of the component at the contact, relative to its support.
    /// * `size`: the size that the deflection by sliding is a fraction of.
    pub(super) fn advance(
        pressing: &mut Pressing,
        limits: SupportLimits,
        [turning, slip]: [Vector3<f64>; 2],
        (dt, size): (f64, f64),
    ) -> Self {
        let normal = Vector3::from(pressing.normal);
        let slip = slip - normal * normal.dot(&slip);
        let rolling = deflect(&mut pressing.rotation, turning * dt);
        let sliding = deflect(&mut pressing.sliding, slip * (dt / size));
        Self { limits, normal, rolling, sliding }
    }

    /// Returns groups of perpendicular directions, each with the limits of its impulses together.
    pub(super) fn groups(
        &self,
    ) -> impl Iterator<Item = (impl Iterator<Item = Direction> + Clone, ImpulseLimits)> {
        let &Self { limits, normal, rolling, sliding } = self;
        // A zero vector stands for no direction.
        let exists = |axis: &Vector3<f64>| *axis != Vector3::zeros();
        let twist = rolling.map_or(normal, |rolling| {
            (normal - rolling * rolling.dot(&normal)).try_normalize(1e-3).unwrap_or_default()
        });
        let tilt = match rolling {
            Some(rolling) if exists(&twist) => [rolling.cross(&twist), Vector3::zeros(), Vector3::zeros()],
            _ => axes_without(Some(normal).filter(exists).or(rolling)),
        };
        // The normal has a limit of its own.
        let across = match sliding {
            Some(sliding) if exists(&normal) => [normal.cross(&sliding), Vector3::zeros(), Vector3::zeros()],
            _ => axes_without(Some(normal).filter(exists).or(sliding)),
        };
        let one = |axis| [axis, Vector3::zeros(), Vector3::zeros()];
        let groups: [(DirectionKind, _, _); 4] = [
            (Direction::Along, one(normal), ImpulseLimits([limits.relieving, limits.pressing])),
            (Direction::About, tilt, ImpulseLimits::both(limits.tilt)),
            (Direction::About, one(twist), ImpulseLimits::both(limits.twist)),
            (Direction::Along, across, ImpulseLimits::both(limits.sliding)),
        ];
        let groups = groups.into_iter().filter(|(.., limits)| *limits != ImpulseLimits::both(0.0));
        groups.map(move |(kind, axes, limits)| (axes.into_iter().filter(exists).map(kind), limits))
    }
}

/// The impulse that the damping of a step takes from the support of a component by a collider, in masses of a full cell
/// times cells/s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction {
    /// Index of the connected component.
    pub(crate) component: u32,
    /// Index of the collider.
    pub(crate) collider: u32,
    /// Impulse on the component.
    pub(crate) impulse: Vector3<f64>,
    /// Center of pressure, from the body's origin.
    pub(crate) point: Vector3<f64>,
    /// Sum of the normal impulses of the contacts.
    pub(super) pressure: f64,
}

impl Reaction {
    /// Returns the part of the impulse at a contact with the normal impulse `pressure`: contacts share it in proportion.
    pub(crate) fn share(&self, pressure: f64) -> Vector3<f64> {
        self.impulse * (pressure / self.pressure)
    }
}

/// The numbers of a step that the damping depends on.
#[derive(Clone, Copy)]
pub(crate) struct DampingStep<'a> {
    /// The rates of the damping, with the length of the step.
    pub(crate) rates: DampingRates,
    /// Size of the body in cells.
    pub(crate) size: f64,
    /// Number of layers of vertices from the surface to the middle of a region: see [`reaction`](super::reaction).
    pub(crate) layers: f64,
    /// Returns the coefficient of rolling resistance on a collider.
    pub(crate) rolling_resistance: &'a dyn Fn(u32) -> f64,
    /// Returns the coefficient of friction of a collider.
    pub(crate) friction: &'a dyn Fn(u32) -> f64,
}

impl SupportLimits {
    /// Returns the limits of a contact. `friction`: its coefficient of friction. `layers`: n, see the [module](self).
    /// Lengths are in the unit of `cell_size`. A grip, whose normals all around cancel each other, has only the limits of
    /// friction and of the tilt.
    pub(super) fn new(pressing: &Pressing, friction: f64, (cell_size, layers): (f64, f64)) -> Self {
        let &Pressing { impulse: pressure, grip, aligned, .. } = pressing;
        let radius = pressing.radius(cell_size);
        let rubbed = Vector3::from(pressing.friction).norm();
        Self {
            pressing: layers * pressure,
            relieving: pressure * aligned,
            sliding: (friction * grip - rubbed).max(0.0),
            tilt: pressure * radius,
            twist: friction * grip * radius,
        }
    }
}

impl SupportConditions {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.conditions.as_slice())
    }

    pub(super) fn clear(&mut self) {
        self.conditions.clear();
        self.groups = 0;
    }

    pub(super) fn list(&self) -> &[Condition] {
        &self.conditions
    }

    /// Adds the conditions of a support: the component moves like it, except for rolling and sliding. `arm`: from the
    /// center of mass of the component to the center of pressure. `motion`: velocity and angular velocity of the
    /// surface of the support.
    pub(super) fn add_support(
        &mut self,
        support: u32,
        arm: Vector3<f64>,
        [velocity, spin]: [Vector3<f64>; 2],
        directions: &SupportDirections,
    ) {
        for (directions, limits) in directions.groups() {
            self.groups += 1;
            self.conditions.extend(directions.map(|direction| Condition {
                support,
                group: self.groups,
                row: direction.row(arm),
                value: direction.speed(velocity, spin),
                limits,
                softness: 0.0,
                impulse: 0.0,
                is_limited: false,
            }));
        }
    }

    /// Adds the conditions of a support of a component with a motion about its center of mass, and advances its
    /// deflections.
    pub(super) fn rest_on(
        &mut self,
        (index, support): (u32, &mut Support),
        step: &DampingStep<'_>,
        motion: Twist,
        center: Vector3<f64>,
    ) {
        let &mut Support { collider, ref mut pressing, velocity, spin, .. } = support;
        let [point, velocity, spin] = [pressing.point, velocity, spin].map(Vector3::from);
        let arm = point - center;
        let relative = [motion.angular - spin, motion.velocity_at(&arm) - velocity];
        let limits = SupportLimits::new(pressing, (step.friction)(collider), (1.0, step.layers));
        let directions = SupportDirections::advance(pressing, limits, relative, (step.rates.dt, step.size));
        self.add_support(index, arm, [velocity, spin], &directions);
    }

    /// Projects a motion on the conditions. `project`: creates the projection of a motion on all other conditions.
    /// `fraction`: the part of the impulses that acts in the step, which the limits hold for. `free`: returns the change
    /// of the motion by an impulse, without conditions.
    pub(super) fn project(
        &mut self,
        fraction: f64,
        mut motion: Vector6<f64>,
        project: impl Fn(Vector6<f64>) -> Projection,
        free: impl Fn(&Vector6<f64>) -> Vector6<f64>,
    ) -> Projection {
        loop {
            let mut projection = project(motion);
            for condition in self.conditions.iter_mut().filter(|condition| !condition.is_limited) {
                condition.softness = projection.fix_softly(condition.row, condition.value);
            }
            let projected = projection.motion().components();
            let mut is_within = true;
            for group in self.conditions.chunk_by_mut(|a, b| a.group == b.group) {
                if group[0].is_limited {
                    continue;
                }
                let mut squared = 0.0;
                for condition in &mut *group {
                    let missing = condition.value - condition.row.dot(&projected);
                    // The multiplier of a soft condition of a least-squares problem.
                    let impulse = if condition.softness > 0.0 { missing / condition.softness } else { 0.0 };
                    condition.impulse = if impulse.is_finite() { impulse } else { 0.0 };
                    squared += condition.impulse * condition.impulse;
                }
                let ImpulseLimits([against, along]) = group[0].limits;
                let limit = if group[0].impulse < 0.0 { against } else { along };
                let needed = squared.sqrt() * fraction;
                if needed > limit * (1.0 + ROUNDING) {
                    is_within = false;
                    for condition in group {
                        condition.impulse *= limit / needed;
                        condition.is_limited = true;
                        motion += free(&condition.row) * condition.impulse;
                    }
                }
            }
            if is_within {
                return projection;
            }
        }
    }

    /// Multiplies all impulses by a factor.
    pub(super) fn scale(&mut self, factor: f64) {
        self.conditions.iter_mut().for_each(|condition| condition.impulse *= factor);
    }
}
