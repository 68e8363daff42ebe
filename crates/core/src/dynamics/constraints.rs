//! Applies constraints: the pins and handles of one body.

use nalgebra::Vector3;

use super::constraint::Constraint;
use super::constraint_error::ConstraintError;
use crate::lattice::Lattice;
use crate::motion::Motion;
use crate::parallel::Executor;
use crate::state::{BodyState, Interval, State};

/// The constraint stage: the pins and handles of one body. Of the active constraints that have a vertex in
/// common, the constraint that was added last has priority.
///
/// Released constraints are removed. Constraints whose time window has ended are kept, because they become
/// active again if the time is set back.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraints {
    /// The constraints in the order in which they were added, so in increasing order of their indices.
    /// The next step removes released ones.
    constraints: Vec<Constraint>,
    /// Number of constraints added so far, including released ones: the index of the next constraint.
    count: usize,
    /// Whether each lattice vertex is constrained in the current step.
    held: Vec<bool>,
}

impl Constraints {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let lists: usize = self.constraints.iter().map(Constraint::bytes).sum();
        self.held.len() + size_of_val(self.constraints.as_slice()) + lists
    }

    /// Creates the stage for a lattice of `vertex_count` vertices.
    pub fn new(vertex_count: usize, constraints: Vec<Constraint>) -> Self {
        let mut stage = Self { constraints: Vec::new(), count: 0, held: vec![false; vertex_count] };
        constraints.into_iter().for_each(|constraint| stage.add(constraint));
        stage
    }

    /// Adds a constraint, which has priority over the existing constraints, and sets its index.
    pub fn add(&mut self, mut constraint: Constraint) {
        constraint.index = self.count;
        self.constraints.push(constraint);
        self.count += 1;
    }

    /// Returns the number of constraints added so far, including released ones.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Releases a constraint permanently, from the next step on. Releasing a released constraint has no
    /// effect.
    ///
    /// # Errors
    /// If the index is out of range.
    pub fn release(&mut self, index: usize) -> Result<(), ConstraintError> {
        match self.find(index) {
            Ok(place) => self.constraints[place].window.end = f64::NEG_INFINITY,
            Err(ConstraintError::Released { .. }) => {}
            Err(error) => return Err(error),
        }
        // Bounds the memory between two steps. Active constraints stay until the next step updates `held`.
        while self.constraints.pop_if(|last| last.is_released() && !last.is_active()).is_some() {}
        Ok(())
    }

    /// Replaces the motion of a constraint. The motion is relative to the captured positions.
    ///
    /// # Errors
    /// If the index is out of range, or the constraint was released.
    pub fn set_motion(&mut self, index: usize, motion: Motion) -> Result<(), ConstraintError> {
        let place = self.find(index)?;
        self.constraints[place].set_motion(motion);
        Ok(())
    }

    /// Returns a constraint.
    ///
    /// # Errors
    /// If the index is out of range, or the constraint was released.
    pub fn get(&self, index: usize) -> Result<&Constraint, ConstraintError> {
        self.find(index).map(|place| &self.constraints[place])
    }

    /// Returns the place of a constraint in the list.
    fn find(&self, index: usize) -> Result<usize, ConstraintError> {
        let count = self.count;
        if index >= count {
            return Err(ConstraintError::NoSuchConstraint { index, count });
        }
        match self.constraints.binary_search_by_key(&index, Constraint::index) {
            Ok(place) if !self.constraints[place].is_released() => Ok(place),
            _ => Err(ConstraintError::Released { index }),
        }
    }

    /// Checks deserialized data. Returns whether all indices and lengths are valid for a lattice of
    /// `vertex_count` vertices.
    pub(crate) fn is_valid(&self, vertex_count: usize) -> bool {
        self.held.len() == vertex_count
            && self.constraints.is_sorted_by(|a, b| a.index < b.index)
            && self.constraints.last().is_none_or(|last| last.index < self.count)
            && self.constraints.iter().all(|constraint| constraint.is_valid(vertex_count))
    }

    /// Takes the animations of serialized constraints from the constraints of a body.
    pub(crate) fn resolve(&mut self, others: &Self) {
        for constraint in self.constraints.iter_mut().filter(|constraint| !constraint.is_resolved()) {
            others.constraints.iter().for_each(|other| constraint.resolve(other));
        }
    }

    /// Returns the index of a constraint that follows an animation that neither it nor a constraint of a body has.
    pub(crate) fn unresolved(&self, others: Option<&Self>) -> Option<usize> {
        let is_in_body = |constraint: &Constraint| {
            let mut constraint = constraint.clone();
            others.into_iter().flat_map(Self::list).for_each(|other| constraint.resolve(other));
            constraint.is_resolved()
        };
        let missing = |constraint: &&Constraint| !constraint.is_resolved() && !is_in_body(constraint);
        self.constraints.iter().find(missing).map(Constraint::index)
    }

    /// Transfers the constraints to a lattice whose vertices were split: `parents` has the vertex before of each
    /// vertex. Copies are held like the vertices before, except by handles that follow an animation.
    pub(crate) fn transfer(&mut self, parents: &[u32]) {
        for constraint in &mut self.constraints {
            constraint.transfer(parents);
        }
        let mut held = vec![false; parents.len()];
        self.constraints.iter().flat_map(Constraint::held).for_each(|vertex| held[vertex as usize] = true);
        self.held = held;
    }

    /// Returns the constraints before the first step, on a lattice in which each vertex has the vertex `parents` of this
    /// one: no constraint is active or has captured positions.
    pub(crate) fn at_start(&self, parents: &[u32]) -> Self {
        let mut stage = self.clone();
        stage.constraints.iter_mut().for_each(Constraint::restart);
        stage.transfer(parents);
        stage
    }

    /// Removes the handles that follow an animation.
    pub(crate) fn remove_followers(&mut self) {
        self.constraints.retain(|constraint| !constraint.is_following());
    }

    /// Continues those of the constraints `before` that hold the same vertices from the same time on, with the positions
    /// that they captured.
    pub(crate) fn continue_from(&mut self, before: &Self) {
        let mut others: Vec<&Constraint> = before.constraints.iter().collect();
        for constraint in &mut self.constraints {
            if let Some(place) = others.iter().position(|other| constraint.continues(other)) {
                constraint.continue_from(others.remove(place));
            }
        }
        let parents: Vec<u32> = (0..self.held.len() as u32).collect();
        self.transfer(&parents);
    }

    /// Returns the constraints in the order in which they were added, also released ones until the next step
    /// begins.
    pub fn list(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Returns whether a vertex is moved by a constraint, and not by a later one.
    pub(crate) fn is_moved_by(&self, constraint: &Constraint, vertex: u32) -> bool {
        let later = self.constraints.iter().rev().take_while(|other| other.index > constraint.index);
        constraint.holds(vertex) && !later.into_iter().any(|other| other.holds(vertex))
    }

    /// Returns whether no constraint moves, begins, ends or is removed in a step.
    pub(crate) fn is_static(&self, step: Interval) -> bool {
        self.constraints.iter().all(|constraint| constraint.is_static(step))
    }

    /// Begins a step, before positions change. Constraints that become active for the first time capture the
    /// positions of their vertices. Released constraints are removed. Returns whether any constraint begins or ends
    /// to prescribe positions; [`constrained`](Self::constrained) is then updated, and stays valid until the next
    /// step begins.
    ///
    /// `slots` has the slot of each lattice vertex: its index in the storage order.
    pub fn begin(
        &mut self,
        step: Interval,
        (state, slots): (&BodyState<'_>, &[u32]),
        executor: &Executor,
    ) -> bool {
        let mut changed = false;
        for constraint in &mut self.constraints {
            changed |= constraint.begin(step, (state, slots), executor);
        }
        self.constraints.retain(|constraint| !constraint.is_released());
        if changed {
            self.held.fill(false);
            for vertex in self.constraints.iter().flat_map(Constraint::held) {
                self.held[vertex as usize] = true;
            }
        }
        changed
    }

    /// Ends a step: sets the position and the velocity of each constrained vertex from the motion of its
    /// constraint.
    pub fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        for constraint in &self.constraints {
            constraint.apply(step, state, slots);
        }
    }

    /// Applies the accelerations of soft goals: see [`Constraint::accelerations`]. Invalidates the momenta of the
    /// components that they pull.
    pub(crate) fn pull(&mut self, dt: f64, state: &mut State, (lattice, slots): (&Lattice, &[u32])) {
        let factor = dt / lattice.cell_size();
        for (vertex, acceleration) in self.pulls() {
            state.accelerate((lattice, slots), vertex, acceleration * factor, dt);
        }
        self.clear_pulls();
    }

    /// Returns the vertices that soft goals pull in the current step, with their accelerations.
    pub(crate) fn pulls(&self) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        self.constraints.iter().flat_map(Constraint::pulls)
    }

    /// Forgets the accelerations of soft goals, which were applied.
    pub(crate) fn clear_pulls(&mut self) {
        self.constraints.iter_mut().for_each(Constraint::clear_pulls);
    }

    /// Returns whether a soft goal may pull vertices.
    pub(crate) fn any_soft(&self) -> bool {
        self.constraints.iter().any(|constraint| constraint.goal().is_some())
    }

    /// Returns the vertices that soft goals pull in the current step.
    pub(crate) fn pulled(&self) -> impl Iterator<Item = u32> {
        self.constraints.iter().flat_map(Constraint::pulled)
    }

    /// Returns whether each lattice vertex is constrained in the current step.
    pub fn constrained(&self) -> &[bool] {
        &self.held
    }

    /// As [`constrained`](Self::constrained), of a body that may have no constraints: then the list is empty.
    pub(crate) fn constrained_by(constraints: Option<&Self>) -> &[bool] {
        constraints.map_or(&[], Self::constrained)
    }

    /// Returns whether any constraint is active in the current step.
    pub fn any_active(&self) -> bool {
        self.constraints.iter().any(Constraint::is_active)
    }
}
