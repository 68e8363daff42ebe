//! Applies forces and impulses to a body.

use nalgebra::{Point3, Vector3};

use super::soft_body::Body;
use crate::dynamics::{
    Field, Force, ForceDuration, Forces, Lasting, Selection, SelectionError, SelectionPose, distribute,
};
use crate::error::Error;
use crate::range::in_range;
use crate::state::Interval;

impl Body {
    /// Applies a force to the selected part of the body: in all steps of the next call of
    /// [`Simulation::step`](crate::Simulation::step), [`steps`](crate::Simulation::steps) or
    /// [`advance`](crate::Simulation::advance), or for another [`ForceDuration`]. Several forces add up.
    ///
    /// The force is distributed over the selected lattice vertices such that they would be accelerated like a rigid
    /// body: without a point and a torque, in proportion to their masses. The vertices keep their parts of the force for
    /// its whole duration. For selections see [`Body::select_at`]; shapes select where the body is now.
    ///
    /// # Errors
    ///
    /// A number that is not finite, a duration of 0 or less, a force that accelerates a vertex by more than 10^15
    /// cells/s^2, an empty selection, or a torque about the line on which all selected vertices lie. No force is then
    /// applied.
    pub fn apply_force(&mut self, force: impl Into<Force>, selection: &Selection) -> Result<(), Error> {
        let force = force.into();
        let forces = self.distributed("force", &force, selection)?;
        self.apply_forces_for(&forces, force.duration)
    }

    /// Applies an impulse to the selected part of the body in the next step, whatever the length of the step: its
    /// momentum changes by the impulse. The impulse is distributed like a force of [`apply_force`](Self::apply_force).
    ///
    /// * `impulse`: `force` is the impulse in kg x length / s, `torque` the angular impulse in kg x length^2 / s; the
    ///   duration has no effect.
    ///
    /// # Errors
    ///
    /// Those of `apply_force`, with a limit of 10^15 cells/s.
    pub fn apply_impulse(&mut self, impulse: impl Into<Force>, selection: &Selection) -> Result<(), Error> {
        let impulses = self.distributed("impulse", &impulse.into(), selection)?;
        self.apply_impulses(&impulses)
    }

    /// Applies impulses to single lattice vertices in the next step: pairs of vertex and impulse, in kg x length / s.
    ///
    /// # Errors
    ///
    /// A vertex out of range, or an impulse that is not finite or changes the velocity of its vertex by more than 10^15
    /// cells/s. No impulse is then applied.
    pub fn apply_impulses(&mut self, impulses: &[(u32, [f64; 3])]) -> Result<(), Error> {
        self.check_forces("impulse", impulses)?;
        self.forces.get_or_insert_default().add_lasting(Lasting::new(impulses.to_vec(), None));
        Ok(())
    }

    /// Applies forces to single lattice vertices during the next call: see
    /// [`apply_forces_for`](Self::apply_forces_for).
    ///
    /// # Errors
    ///
    /// Those of `apply_forces_for`.
    pub fn apply_forces(&mut self, forces: &[(u32, [f64; 3])]) -> Result<(), Error> {
        self.apply_forces_for(forces, ForceDuration::Call)
    }

    /// Applies forces to single lattice vertices. `forces` contains pairs of vertex and force, in kg x length / s^2.
    /// Several forces add up. Forces that are the same in every step let a body fall asleep, and a change wakes it.
    ///
    /// # Errors
    ///
    /// A vertex out of range, a duration of 0 or less, or a force that is not finite or accelerates its vertex by more
    /// than 10^15 cells/s^2. No force is then applied.
    pub fn apply_forces_for(
        &mut self,
        forces: &[(u32, [f64; 3])],
        duration: ForceDuration,
    ) -> Result<(), Error> {
        self.check_forces("force", forces)?;
        if let ForceDuration::Seconds(seconds) = duration {
            in_range("duration", seconds, seconds > 0.0 && seconds.is_finite(), "above 0, in seconds")?;
        }
        let lasting = Lasting::new(forces.to_vec(), Some(duration));
        self.forces.get_or_insert_default().add_lasting(lasting);
        Ok(())
    }

    /// Returns the forces on the vertices of a selection. `name`: of the force, for errors.
    fn distributed(
        &self,
        name: &'static str,
        force: &Force,
        selection: &Selection,
    ) -> Result<Vec<(u32, [f64; 3])>, Error> {
        let &Force { force, point, torque, .. } = force;
        for number in force.into_iter().chain(torque).chain(point.unwrap_or_default()) {
            in_range(name, number, number.is_finite(), "finite")?;
        }
        let vertices = self.select_at(selection, SelectionPose::Now)?;
        let place = |&vertex: &u32| (self.vertex_motion(vertex).0, self.mass_of(vertex));
        let places: Vec<_> = vertices.iter().map(place).collect();
        // The center of mass of a rigid body is not that of its lattice vertices.
        let is_whole_rigid = self.is_rigid() && vertices.len() == self.shape.lattice.len();
        let point = point.or_else(|| is_whole_rigid.then(|| self.center_of_mass().into()));
        let (force, torque) = (Vector3::from(force), Vector3::from(torque));
        let about = |center: Point3<f64>| {
            let lever = point.map_or_else(Vector3::zeros, |point| Point3::from(point) - center);
            torque + lever.cross(&force)
        };
        let forces = distribute(&places, force, about).ok_or(SelectionError::NoTorque)?;
        Ok(vertices.into_iter().zip(forces.into_iter().map(Into::into)).collect())
    }

    /// Checks forces or impulses on vertices.
    fn check_forces(&self, name: &'static str, forces: &[(u32, [f64; 3])]) -> Result<(), Error> {
        let count = self.shape.lattice.len();
        for &(vertex, force) in forces {
            if vertex as usize >= count {
                return Err(SelectionError::VertexOutOfRange { vertex, count }.into());
            }
            let limit = self.coordinate_limit() * self.mass_of(vertex);
            for f in force {
                in_range(name, f, f.abs() <= limit, "finite, and accelerate by at most 1e15 cells/s^2")?;
            }
        }
        Ok(())
    }

    /// Begins a step: the forces that last act in it, and the fields that act on the body.
    pub(crate) fn begin_forces(&mut self, fields: &[Field], step: Interval) {
        if let Some(forces) = &mut self.forces {
            forces.begin_step(step.dt);
        }
        self.begin_fields(fields, step);
    }

    /// Evaluates the accelerations by fields in a step.
    fn begin_fields(&mut self, fields: &[Field], step: Interval) {
        let own = || fields.iter().filter(|field| field.acts_on(&self.name));
        let has_fields = self.forces.as_ref().is_some_and(Forces::has_fields);
        if own().next().is_none() {
            if let Some(forces) = self.forces.as_mut().filter(|_| has_fields) {
                forces.forget_fields();
            }
            return;
        }
        // A body that sleeps has the accelerations of the step in which it fell asleep.
        if self.state.rest.is_asleep && has_fields && own().all(Field::is_steady) {
            return;
        }
        let slots = self.pipeline.matching.layout.slots();
        let limit = self.coordinate_limit();
        let accelerations = self.forces.get_or_insert_default().begin_fields(slots.len());
        for field in own().map(|field| field.in_step(step)).filter(|field| !field.is_zero()) {
            for (acceleration, &slot) in accelerations.iter_mut().zip(slots) {
                let point = self.state.frame.to_world(self.state.local(slot));
                let velocity = self.state.frame.velocity_to_world(self.state.velocities.get(slot));
                let sum = Vector3::from(*acceleration) + field.acceleration(&point, &velocity);
                *acceleration = sum.map(|a| a.clamp(-limit, limit)).into();
            }
        }
    }

    /// Ends the forces that last for one call.
    pub(crate) fn end_call(&mut self) {
        if let Some(forces) = &mut self.forces {
            forces.end_call();
        }
    }
}
