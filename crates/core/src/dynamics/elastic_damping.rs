//! Damps the elastic modes of a body: moves the velocity of each vertex towards the reference motion of its component.
//!
//! The reference motion is the rigid motion that is closest to the velocities in the metric of the mass and meets the
//! conditions of the surroundings: it moves like the constrained vertices, and, as far as the contacts give the
//! impulses for it, it does not move into or out of a collider that presses on the component. A step multiplies the
//! difference of the velocities to the reference motion by exp(-2 c dt), so that the amplitude of a mode with an
//! angular frequency above c decays as exp(-c t). A free component keeps its momenta: its reference motion is the rigid
//! motion with its momenta, so that flight and spin are undamped.
//!
//! A body that rests on a collider also sways on it: its base stays, and most of it moves like a rigid body. Such a
//! motion is elastic, but the velocities of one step do not distinguish it from rolling or sliding. The displacement
//! does: each [`Support`] has a [`Deflection`], the rotation or the sliding of the component since the
//! motion last reversed, up to a limit, as the bristles of a model of friction have (Dahl 1968). Below the limit, the
//! reference motion does not take part; at the limit it does, in the direction of the deflection. So a body that
//! rolls or slides is damped only at the start, over an angle of [`LEAST_LIMIT`](super::deflection) or that part of
//! its size, and one that sways is damped after each reversal. A reversal doubles the limit, up to
//! [`GREATEST_LIMIT`](super::deflection), and a long displacement in one direction lowers it again, so that
//! oscillations over short displacements are damped most.
//!
//! A step damps in two parts. Before the acceleration the velocities move towards the rigid motion of the component, or
//! towards its projection on the motion of the constrained vertices: this keeps the momenta of free components. After
//! the contacts the velocities get the difference to the reference motion that also meets the conditions of the
//! supports, times the same fraction. It is a rigid motion, by impulses of the supports, whose limits follow from the
//! contacts of the step: see [`reaction`](super::reaction). Where zones change the rate, the body is damped in the
//! metric of other masses: see [`varied_damping`](super::varied_damping).

use nalgebra::{Vector3, Vector6};

use super::constrained::ConstrainedVertices;
use super::constraints::Constraints;
use super::coupling::CoupledComponent;
use super::momentum::{Mobility, MomentumTracker, Projection, RigidState, RigidVelocity};
use super::reaction::{DampingStep, Reaction, SupportConditions};
use super::rolling::resistance;
use super::varied_damping::{DampingRates, VariedDamping};
use crate::matching::Matching;
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;
use crate::state::{Momentum, State, Support, Twist};

/// The elastic-damping stage.
#[derive(Clone, Debug, Default)]
pub(crate) struct ElasticDamper {
    constrained: ConstrainedVertices,
    damped: Damped,
    /// Component and index of each support, in increasing order.
    supports: Vec<(u32, u32)>,
    conditions: SupportConditions,
    /// The motion of each component after the contacts; empty if nothing supports the body.
    motions: Vec<SupportedMotion>,
    /// The reactions of the supports in the last step, one per support.
    reactions: Vec<Reaction>,
    /// Velocities that the supports add.
    added: Vec<RigidVelocity>,
    /// Fraction of the differences to the reference motions that a step takes away.
    fraction: f64,
    /// `None` if the rate is the same everywhere.
    varied: Option<VariedDamping>,
}

/// The motion of a component after the contacts.
#[derive(Clone, Debug)]
struct SupportedMotion {
    /// Rigid motion with the momenta of the component.
    motion: Twist,
    /// The rigid motion without and with the supports.
    free: Twist,
    reference: Twist,
    /// Whether the component has constrained vertices.
    is_held: bool,
    /// Impulse of other bodies in the step, by the coupling.
    coupled: Vector3<f64>,
    /// Change of the linear momentum in the step.
    given: Vector3<f64>,
    /// The change of the rigid motion in a step by rolling resistance.
    rolling: Twist,
    projection: Projection,
}

/// The damping of a step: velocities v become `keep` v + r, with a rigid velocity r of each component.
#[derive(Clone, Debug, Default)]
pub(crate) struct Damped {
    pub(super) keep: f32,
    /// 1 - `keep` times the rigid motion of each component.
    pub(crate) rigid: Vec<RigidVelocity>,
}

impl ElasticDamper {
    /// Creates the stage. `varied`: the rates of a body on which they vary.
    pub(crate) fn new(varied: Option<VariedDamping>) -> Self {
        Self { varied, ..Self::default() }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.constrained.bytes()
            + size_of_val(self.motions.as_slice())
            + size_of_val(self.added.as_slice())
            + size_of_val(self.supports.as_slice())
            + size_of_val(self.reactions.as_slice())
            + self.conditions.bytes()
            + size_of_val(self.damped.rigid.as_slice())
            + self.varied.as_ref().map_or(0, VariedDamping::bytes)
    }

    /// Returns the damping of the step.
    pub(crate) fn damped(&self) -> &Damped {
        &self.damped
    }

    /// Returns the change of the velocity of a vertex of a component by the damping of the step, in cells/s. `position`
    /// and `velocity` are in cells and cells/s from the origin of the body.
    pub(crate) fn change(
        &self,
        (component, slot): (usize, u32),
        position: Vector3<f64>,
        velocity: Vector3<f64>,
    ) -> Vector3<f64> {
        let Damped { keep, rigid } = &self.damped;
        let RigidVelocity { linear, angular } = rigid[component];
        let [linear, angular] = [linear, angular].map(|v| Vector3::from(v.map(f64::from)));
        let change = velocity * (f64::from(*keep) - 1.0) + linear + angular.cross(&position);
        self.shares().map_or(change, |shares| change * f64::from(shares.get(slot)[0]))
    }

    /// Returns the share of each vertex in the damping; `None` if all are 1.
    pub(crate) fn shares(&self) -> Option<&Lanes<1>> {
        self.varied.as_ref().map(|varied| &varied.shares)
    }

    /// Returns the least factor of the rate.
    pub(crate) fn least_factor(&self) -> f64 {
        self.varied.as_ref().map_or(1.0, |varied| varied.least)
    }

    /// Returns the last measurement of each component by `momentum`, or in the metric of the shares.
    pub(crate) fn states<'a>(&'a self, momentum: &'a MomentumTracker) -> &'a [RigidState] {
        self.varied.as_ref().map_or(momentum, |varied| &varied.tracker).states()
    }

    /// Returns exp(-2 c dt) with the greatest rate c of the body, and measures the state in the metric of the shares.
    fn keep(&mut self, rates: DampingRates, moved: (&Matching, &State), executor: &Executor) -> f64 {
        let Some(varied) = &mut self.varied else { return rates.kept(1.0) };
        varied.measure(rates, moved, executor);
        rates.kept(varied.greatest)
    }

    /// Returns the reactions of the supports in the last step.
    pub(crate) fn reactions(&self) -> &[Reaction] {
        &self.reactions
    }

    /// Returns the impulse that the damping took from the constrained vertices of a component after the contacts of the
    /// last step, and from its colliders.
    pub(crate) fn taken_from_surroundings(&self, component: usize) -> Vector3<f64> {
        self.motions.get(component).map_or_else(Vector3::zeros, |moved| moved.given - moved.coupled)
    }

    /// Begins a step: computes the motions towards which the velocities are damped before the acceleration. `momentum`
    /// has measured the state.
    pub(crate) fn begin(
        &mut self,
        constraints: Option<&Constraints>,
        (matching, state): (&Matching, &State),
        momentum: &MomentumTracker,
        (rates, executor): (DampingRates, &Executor),
    ) {
        let keep = self.keep(rates, (matching, state), executor);
        self.constrained.read(constraints, (matching, state), momentum);
        self.damped.keep = keep as f32;
        self.damped.rigid.clear();
        for component in 0..momentum.states().len() {
            let rigid = self.states(momentum)[component];
            let motion = rigid.motion(rigid.momentum);
            let free = match self.constrained.of_component(component) {
                None => motion,
                Some(vertices) => {
                    let mobility = Mobility::of_body(rigid.mass, &rigid.inertia);
                    projection_of(&mobility, motion, rigid.center, Some(&vertices)).motion()
                }
            };
            self.damped.rigid.push(RigidVelocity::of(free * (1.0 - keep), rigid.center));
        }
    }

    /// Computes the motions that meet the conditions of the supports after the contacts of a step, and advances the
    /// deflections. `momentum` has measured the state.
    pub(crate) fn begin_supports(
        &mut self,
        constraints: Option<&Constraints>,
        (matching, state): (&Matching, &mut State),
        momentum: &MomentumTracker,
        (step, executor): (DampingStep<'_>, &Executor),
    ) {
        self.fraction = 1.0 - self.keep(step.rates, (matching, state), executor);
        self.constrained.read(constraints, (matching, state), momentum);
        let supports = state.supports.list_mut();
        let mut sorted = std::mem::take(&mut self.supports);
        sorted.clear();
        sorted.extend(supports.iter().zip(0..).map(|(support, index)| (support.component, index)));
        sorted.sort_unstable();
        let mut motions = std::mem::take(&mut self.motions);
        motions.clear();
        self.reactions.clear();
        let mut rest = &*sorted;
        for component in 0..momentum.states().len() {
            let rigid = self.states(momentum)[component];
            let count = rest.partition_point(|(supported, _)| *supported as usize == component);
            let (own, others) = rest.split_at(count);
            rest = others;
            motions.push(self.supported((component, &rigid), (supports, own), step));
        }
        (self.supports, self.motions) = (sorted, motions);
    }

    /// Ends a step in which nothing supports the body.
    pub(crate) fn clear_supports(&mut self) {
        self.motions.clear();
        self.reactions.clear();
    }

    /// Completes the damping of a step: returns the velocities that the supports add to the components, with the share of
    /// each vertex, or `None` if they add none. Adds them to the momenta that are tracked, `momenta`.
    pub(crate) fn finish_supports(
        &mut self,
        momenta: &mut [Option<Momentum>],
        momentum: &MomentumTracker,
    ) -> Option<(&[RigidVelocity], Option<&Lanes<1>>)> {
        let Self { motions, added, fraction, varied, .. } = self;
        added.clear();
        let states = varied.as_ref().map_or(momentum, |varied| &varied.tracker).states();
        let moved = momentum.states().iter().zip(states).zip(motions).zip(momenta);
        for (((body, rigid), moved), tracked) in moved {
            let change = (moved.reference - moved.free) * *fraction + moved.rolling;
            moved.given = change.linear * rigid.mass;
            if let Some(tracked) = tracked {
                tracked.add(rigid.momentum_about(body.center, change));
            }
            added.push(RigidVelocity::of(change, rigid.center));
        }
        let adds = added.iter().any(|velocity| *velocity != RigidVelocity::default());
        adds.then_some((added, varied.as_ref().map(|varied| &varied.shares)))
    }

    /// Returns the reference motion of a component that presses on other bodies, to be coupled with theirs. `size` is
    /// the size of the body in scene units; for `layers` see [`DampingStep`].
    pub(crate) fn coupled(
        &self,
        side: (u32, u32),
        (state, momentum): (&State, &MomentumTracker),
        (size, cell_mass, layers): (f64, f64, f64),
    ) -> Option<CoupledComponent> {
        let (frame, measured) = (state.frame, &self.states(momentum)[side.1 as usize]);
        let SupportedMotion { motion, reference, projection, .. } = self.motions.get(side.1 as usize)?;
        let cell_size = frame.cell_size();
        let world = |motion: &Twist| Twist {
            linear: (motion.linear + frame.velocity()) * cell_size,
            angular: motion.angular,
        };
        Some(CoupledComponent {
            side,
            center: frame.to_world(measured.center).coords,
            motion: world(motion),
            reference: world(reference).components(),
            mobility: projection.mobility().clone().in_units(cell_size, cell_mass),
            fraction: self.fraction,
            size,
            cell_size,
            layers,
            change: Vector6::zeros(),
            impulse: Vector3::zeros(),
        })
    }

    /// Changes the reference motion of a component by the change of a coupling. `cell_mass` and `cell_size` are in scene
    /// units.
    pub(crate) fn add_change(
        &mut self,
        component: &CoupledComponent,
        momentum: &MomentumTracker,
        (cell_mass, cell_size): (f64, f64),
    ) {
        let Twist { linear, angular } = Twist::from_components(&component.change);
        let index = component.side.1;
        let mass = self.states(momentum)[index as usize].mass;
        let moved = &mut self.motions[index as usize];
        moved.reference = moved.reference + Twist { linear: linear / cell_size, angular };
        moved.coupled = component.impulse / (cell_mass * cell_size);
        if moved.is_held {
            return;
        }
        // The supports of the component take a part of the impulses: the difference to the change of its momentum.
        let changed = linear * (mass / cell_size * component.fraction);
        let taken = changed - moved.coupled;
        let own = || self.reactions.iter().filter(|reaction| reaction.component == index);
        let pressure: f64 = own().map(|reaction| reaction.pressure).sum();
        for reaction in self.reactions.iter_mut().filter(|reaction| reaction.component == index) {
            reaction.impulse += taken * (reaction.pressure / pressure);
        }
    }

    /// Returns the motion of a component after the contacts, and advances the deflections of its supports. `own` has
    /// its supports, as in `self.supports`.
    fn supported(
        &mut self,
        (component, rigid): (usize, &RigidState),
        (supports, own): (&mut [Support], &[(u32, u32)]),
        step: DampingStep<'_>,
    ) -> SupportedMotion {
        let vertices = self.constrained.of_component(component);
        let Self { conditions, reactions, fraction, .. } = self;
        let motion = rigid.motion(rigid.momentum);
        let mobility = Mobility::of_body(rigid.mass, &rigid.inertia);
        let project = |motion| projection_of(&mobility, motion, rigid.center, vertices.as_ref());
        let mut rolling = Twist::default();
        let projection = project(motion);
        let free = projection.motion();
        let moved = |reference, rolling, projection| SupportedMotion {
            motion,
            free,
            reference,
            is_held: vertices.is_some(),
            coupled: Vector3::zeros(),
            given: Vector3::zeros(),
            rolling,
            projection,
        };
        if own.is_empty() {
            return moved(free, rolling, projection);
        }
        // Colliders at rest add no energy: the damped velocities lie between the velocities and the reference motion.
        let mut limit = rigid.energy_of(free);
        conditions.clear();
        for &(_, index) in own {
            let support = &mut supports[index as usize];
            conditions.rest_on((index, support), &step, motion, rigid.center);
            limit += 0.5 * rigid.mass * Vector3::from(support.velocity).norm_squared();
            let coefficient = (step.rolling_resistance)(support.collider);
            if coefficient > 0.0 && vertices.is_none() {
                rolling = rolling + resistance(support, coefficient, &mobility, motion + rolling);
            }
        }
        let projection = conditions.project(
            *fraction,
            motion.components(),
            |motion| project(Twist::from_components(&motion)),
            |row| mobility.free_change(row),
        );
        let mut reference = projection.motion();
        if vertices.is_none() && rigid.energy_of(reference) > limit {
            let part = rigid.part_within(free, reference - free, limit);
            reference = free + (reference - free) * part;
            conditions.scale(part);
        }
        for &(_, index) in own {
            let Support { component, collider, pressing, .. } = supports[index as usize];
            let own = conditions.list().iter().filter(|condition| condition.support == index);
            let sum: Vector6<f64> =
                own.map(|condition| condition.row * (condition.impulse * *fraction)).sum();
            let impulse = Twist::from_components(&sum).linear;
            let (point, pressure) = (pressing.point.into(), pressing.impulse);
            reactions.push(Reaction { component, collider, impulse, point, pressure });
        }
        moved(reference, rolling, projection)
    }
}

/// Returns the projection of a motion of a component about its center of mass on the motion of its constrained vertices.
fn projection_of(
    mobility: &Mobility,
    motion: Twist,
    center: Vector3<f64>,
    vertices: Option<&RigidState>,
) -> Projection {
    let mut projection = Projection::new(mobility.clone(), motion, center);
    vertices.inspect(|vertices| projection.fix_vertices(vertices));
    projection
}
