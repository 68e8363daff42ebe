//! The contact stage of a body: stores the velocities before the step, and detects contacts. `finish` applies the
//! impulses.
//!
//! A row is an index into `SampleCells::vertices`.

use nalgebra::{Point3, Vector3};

use super::SKIN;
use super::colliders::Colliders;
use super::constraint::{SurfacePoint, mean, mean_factor, mean_position};
use super::detection::{ContactReport, Detection};
use super::memory::buffer_bytes;
use super::patch::Patch;
use super::pressure::Pressure;
use super::samples::SampleCells;
use super::shape::PosedShape;
use super::solver::Solver;
use super::vec4::{Vec4, narrow, read, wide};
use crate::simd::lanes::Lanes;
use crate::state::{BodyState, ContactKey, Interval, RigidMobility, Twist};

/// Least speed of approach that bounces, divided by the speed that one step of free fall adds. A body with
/// slower impacts comes to rest.
pub(super) const MIN_BOUNCE_STEPS: f64 = 2.0;

/// Penetration that is tolerated without a push between bodies, and in an escape from a collider, in cells.
pub(super) const ALLOWED_DEPTH: f64 = 3e-4;

/// Speed in cells per step up to which a contact begins with the impulse of the step before, where gravity does not
/// give a greater one.
const SLOW: f64 = 1e-3;

/// Greatest push-out in a step, in cells. Deeper samples leave the collider over several steps, because a
/// greater push-out would flatten the body on the surface, and its elastic energy would then throw it up.
pub(super) const PUSH_LIMIT: f64 = 0.25;

/// Contact stage of one body. Its buffers are reused, and grow if more contacts than before occur at once.
#[derive(Clone, Debug)]
pub struct Contacts {
    pub(super) samples: SampleCells,
    /// Greatest distance of the samples in cells.
    spacing: f64,
    /// Thickness of the body, in scene units.
    pub(super) thickness: f64,
    /// Velocity of the vertex of each row before the step.
    velocities_before: Vec<Vec4>,
    /// Velocity of the vertex of each row at the end of the step, before the impulses.
    velocities: Vec<Vec4>,
    pub(super) detection: Detection,
    pub(super) solver: Solver,
    /// Factor of the coefficient of friction at the vertex of each row; empty if all are 1.
    friction_factors: Vec<f32>,
    /// Whether all contacts of the step are with one plane, nothing else moves their vertices, and the samples follow
    /// them linearly.
    pub(super) is_on_plane: bool,
    /// Rows of the components that leave colliders. They have no contacts.
    pub(super) leaving: Vec<u32>,
    /// The contacts of the last step.
    pub(super) pressures: Vec<Pressure>,
    /// Impulses with which the solution begins, in the order of the contacts. Empty if it begins without.
    pub(super) begin: Vec<Vec4>,
    /// Speed in cells/s from which on a contact begins without an impulse.
    pub(super) slow: f32,
    /// The contacts with which a sleeping body fell asleep, while `pressures` has the contacts of a step.
    kept_pressures: Vec<Pressure>,
    has_kept: bool,
    /// Rows of the vertices that the contacts of the last step may have moved.
    pub(super) touched: Vec<u32>,
    /// Contact displacement of the vertex of each row since `clear_displacements`, in cells; see
    /// [`displacements`](Self::displacements).
    pub(super) displacements: Vec<[f32; 3]>,
    /// The mobility of a rigid body: see `rigid_stage`.
    pub(super) rigid: Option<RigidMobility>,
    /// Buffer: the impulses on the rigid body.
    pub(super) rigid_totals: Vec<Twist>,
}

impl Contacts {
    /// Creates the stage of a body with these surface samples, at most one cell apart.
    #[cfg(feature = "internals")]
    pub fn new(samples: SampleCells) -> Self {
        Self::within(1.0, samples, 0.0)
    }

    /// Creates the stage of a body with these surface samples, at most `spacing` cells apart. Contacts act at the
    /// distance `thickness` from them, in scene units.
    pub(crate) fn within(spacing: f64, samples: SampleCells, thickness: f64) -> Self {
        let rows = samples.vertices.len();
        Self {
            velocities_before: vec![Vec4::zeros(); rows],
            velocities: vec![Vec4::zeros(); rows],
            detection: Detection::new(rows),
            solver: Solver::new(rows),
            friction_factors: Vec::new(),
            is_on_plane: false,
            leaving: Vec::new(),
            pressures: Vec::new(),
            begin: Vec::new(),
            slow: 0.0,
            kept_pressures: Vec::new(),
            has_kept: false,
            touched: Vec::new(),
            displacements: vec![[0.0; 3]; rows],
            rigid: None,
            rigid_totals: Vec::new(),
            spacing,
            thickness,
            samples,
        }
    }

    /// Returns the greatest distance of the samples in cells.
    pub(crate) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Returns the samples on which contacts act.
    pub fn samples(&self) -> &SampleCells {
        &self.samples
    }

    /// Returns the memory of the samples and the buffers in bytes.
    pub fn bytes(&self) -> usize {
        let velocities = buffer_bytes(&self.velocities_before) + buffer_bytes(&self.velocities);
        let scratch =
            velocities + self.detection.bytes() + self.solver.bytes() + buffer_bytes(&self.pressures);
        let lists = buffer_bytes(&self.leaving) + buffer_bytes(&self.touched) + buffer_bytes(&self.begin);
        let rigid = buffer_bytes(&self.rigid_totals);
        let rows = buffer_bytes(&self.displacements) + buffer_bytes(&self.friction_factors);
        self.samples.bytes() + scratch + lists + rows + rigid
    }

    /// Returns false only if no sample is in the shape. May return true in this case as well.
    pub(crate) fn may_touch(&mut self, shape: &PosedShape<'_>, positions: &Lanes<3>) -> bool {
        self.detection.read(positions, &self.samples.slots, &[]);
        self.detection.may_touch(shape, &self.samples, 0.0)
    }

    /// Sets the lattice vertices that have no contacts: the vertices of components that leave colliders.
    pub(crate) fn set_leaving(&mut self, is_leaving: impl Fn(u32) -> bool) {
        let rows = (0..).zip(&self.samples.vertices).filter(|(_, vertex)| is_leaving(**vertex));
        self.leaving.clear();
        self.leaving.extend(rows.map(|(row, _)| row));
    }

    /// Sets the factor of the coefficient of friction of each lattice vertex; `None` for 1.
    pub(crate) fn set_friction_factors(&mut self, factor: Option<impl Fn(u32) -> f64>) {
        self.friction_factors.clear();
        if let Some(factor) = factor {
            self.friction_factors.extend(self.samples.vertices.iter().map(|&vertex| factor(vertex) as f32));
        }
    }

    /// Stores the velocities before the step. Called first in each step, before the shape matching.
    pub fn begin(&mut self, velocities: &Lanes<3>) {
        read(&mut self.velocities_before, velocities, &self.samples.slots);
    }

    /// Resolves the contacts. Called second in each step, after the integration of the positions.
    ///
    /// Normal and friction impulses change the velocities. The positions change by these velocity changes
    /// times the step. Samples that are then more than 0.01 cells inside a collider are pushed out by a change of the
    /// positions alone, by at most a quarter of a cell per step. The solution begins with the impulses of the call
    /// before. Components that leave colliders as a whole ([`set_leaving`](Self::set_leaving)) have no contacts.
    /// `gravity` is in scene units per second squared.
    #[cfg(feature = "internals")]
    pub fn resolve(
        &mut self,
        state: &mut BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
        gravity: [f64; 3],
    ) -> ContactReport {
        let mut before = crate::state::Touches::default();
        before.set_forces(self.pressures.iter().map(|pressure| pressure.force(1.0)));
        let report = self.detect(state, colliders, step, gravity);
        self.begin_with(|key| before.force(key));
        self.finish_alone(state, colliders, step);
        report
    }

    /// Sets the initial impulses of the solution: the impulses of the step before. `impulse` returns the impulse of
    /// a contact, in the unit of [`Pressure::impulse`].
    pub(crate) fn begin_with(&mut self, impulse: impl Fn(ContactKey) -> Vector3<f64>) {
        self.begin.clear();
        self.begin.extend(self.pressures.iter().map(|found| narrow(impulse(found.key()))));
    }

    /// Finds the contacts: the first part of the stage.
    pub(crate) fn detect(
        &mut self,
        state: &BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
        gravity: [f64; 3],
    ) -> ContactReport {
        let touches_nothing = !colliders.any_enabled() || self.is_away_from_planes(state, colliders, step);
        let Self { samples, velocities_before, velocities, detection, solver, pressures, touched, .. } = self;
        let (leaving, rigid) = (&self.leaving, self.rigid.as_ref());
        let (thickness, friction_factors) = (self.thickness, &self.friction_factors);
        pressures.clear();
        touched.clear();
        solver.clear();
        solver.begin_rigid(rigid);
        self.begin.clear();
        let mut report = ContactReport::default();
        self.is_on_plane = rigid.is_none() && samples.stencils().is_none();
        if touches_nothing {
            return report;
        }
        detection.read(state.positions, &samples.slots, leaving);
        if colliders.any_needs_paths() {
            detection.begin_paths(state.velocities, &samples.slots, step.dt);
        }
        let min_bounce = MIN_BOUNCE_STEPS * Vector3::from(gravity).norm() / state.frame.cell_size * step.dt;
        self.slow = min_bounce.max(SLOW / step.dt) as f32;
        for collider in colliders.during(step, state.frame, thickness) {
            let untouched = report.contacts == 0;
            detection.find(&collider, samples, SKIN, &mut report);
            if untouched && report.contacts > 0 {
                read(velocities, state.velocities, &samples.slots);
            }
            let is_touched = detection.patches().next().is_some();
            self.is_on_plane &= !is_touched || pressures.is_empty() && collider.shape.plane().is_some();
            for patch in detection.patches() {
                let vertices = patch.vertices();
                let position = mean_position(vertices.iter(), &detection.positions);
                let point = SurfacePoint {
                    position,
                    offset: samples.offset(patch, &collider.shape, &position),
                    side: patch.side(),
                    deepest: patch.deepest,
                    velocity: mean(vertices.iter(), |row| velocities[row]),
                    velocity_before: mean(vertices.iter(), |row| velocities_before[row]),
                    friction_factor: mean_factor(vertices.iter(), friction_factors),
                };
                let contact = point.contact(&collider, step.dt, min_bounce);
                let (normal, position) = (wide(&contact.normal), point.position);
                pressures.push(Pressure {
                    collider: collider.index,
                    vertex: samples.vertices[patch.nearest_row() as usize],
                    impulse: 0.0,
                    friction_factor: point.friction_factor,
                    friction: Vector3::zeros(),
                    depth: patch.deepest,
                    point: position.coords,
                    normal,
                    velocity: collider.velocity_at(&position),
                    spin: collider.spin(),
                });
                solver.add_patch(contact, (&vertices, || point.position), samples, rigid);
            }
        }
        report
    }

    /// Keeps the contacts of the last step of a sleeping body, before a search because another body is near.
    pub(crate) fn keep_pressures(&mut self) {
        std::mem::swap(&mut self.pressures, &mut self.kept_pressures);
        self.has_kept = true;
    }

    /// Restores the contacts that were [kept](Self::keep_pressures), if any: the body still sleeps.
    pub(crate) fn restore_pressures(&mut self) {
        if std::mem::take(&mut self.has_kept) {
            std::mem::swap(&mut self.pressures, &mut self.kept_pressures);
            self.kept_pressures.clear();
        }
    }

    /// Forgets the contacts of the last step.
    pub(crate) fn clear_pressures(&mut self) {
        self.pressures.clear();
        self.kept_pressures.clear();
        self.has_kept = false;
    }

    /// Returns the contacts of the last step, by collider.
    pub(crate) fn pressures(&self) -> &[Pressure] {
        &self.pressures
    }

    /// Returns the lattice vertices that the contacts of the last step may have moved, in increasing order.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().map(|&row| self.samples.vertices[row as usize])
    }

    /// Sets the contact displacements to zero. Called at the start of each frame.
    pub fn clear_displacements(&mut self) {
        self.displacements.fill([0.0; 3]);
    }

    /// Returns the contact displacements in cells since [`clear_displacements`](Self::clear_displacements).
    ///
    /// Each step adds the displacement by the normal impulses and by the push-out, and the velocity change by
    /// the normal impulses times the step. Returns pairs of lattice vertex and displacement in increasing
    /// order of the vertices, without the vertices that contacts did not displace.
    pub fn displacements(&self) -> impl Iterator<Item = (u32, [f32; 3])> + '_ {
        let all = self.samples.vertices.iter().copied().zip(self.displacements.iter().copied());
        all.filter(|(_, displacement)| *displacement != [0.0; 3])
    }
}

impl SampleCells {
    /// Returns the mean distance of the touching samples of a patch from the shape, minus the distance of the contact
    /// point: contacts act on the smooth surface, and move it by the trilinear weights of the samples. Zero if the skin
    /// is linear, which uses the distance of the contact point, and if the patch has a side. `position`: contact point
    /// of the patch.
    pub(super) fn offset(&self, patch: &Patch, shape: &PosedShape<'_>, position: &Point3<f64>) -> f64 {
        match self.stencils().filter(|_| patch.side().is_none()) {
            None => 0.0,
            Some(_) => patch.mean_distance() - shape.signed_distance(position).distance,
        }
    }
}
