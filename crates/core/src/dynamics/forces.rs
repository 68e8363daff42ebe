//! Applies external forces to lattice vertices: in a step, and in several steps.

use std::ops::AddAssign;

use nalgebra::Vector3;

use super::field::FieldAccelerations;
use super::force::Lasting;

use crate::lattice::Lattice;
use crate::state::{Interval, State, Twist};

/// The external-force stage: the forces that last, those of the next step, those with which the body came to rest, and
/// the displacements that the forces of the current frame have caused. All lists are sorted by lattice vertex and have no
/// duplicate vertices.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Forces {
    /// Forces that act in more than the next step, and impulses, in the order in which they were added.
    lasting: Vec<Lasting>,
    /// Lattice vertices and the forces on them in the next step, in scene units of mass × length / s².
    next: Vec<(u32, [f64; 3])>,
    /// The forces of the last step in which the body was not at rest. While it rests, they hold it in place
    /// together with gravity.
    at_rest: Vec<(u32, [f64; 3])>,
    /// The accelerations by fields in the next step.
    fields: FieldAccelerations,
    /// Lattice vertices and their velocity change times dt, in cells. This is f of Eq. (2) in
    /// `volume::external_forces`.
    displacements: Vec<(u32, [f32; 3])>,
}

impl Forces {
    /// Adds forces that last.
    pub(crate) fn add_lasting(&mut self, lasting: Lasting) {
        self.lasting.push(lasting);
    }

    /// Adds forces on lattice vertices, each of which occurs once, to the forces of the next step.
    pub(crate) fn add(&mut self, forces: impl IntoIterator<Item = (u32, [f64; 3])>) {
        add_to(&mut self.next, forces);
    }

    /// Begins a step of `dt` seconds: adds the forces that last to those of the step.
    pub(crate) fn begin_step(&mut self, dt: f64) {
        let Self { lasting, next, .. } = self;
        lasting.retain_mut(|lasting| {
            let share = lasting.take_step(dt);
            add_to(next, lasting.forces.iter().map(|&(vertex, force)| (vertex, force.map(|f| f * share))));
            lasting.lasts()
        });
    }

    /// Ends a call that made steps: removes the forces that last for one call.
    pub(crate) fn end_call(&mut self) {
        self.lasting.retain(|lasting| !lasting.ends_with_call());
    }

    /// Returns the accelerations by fields in the next step, to which fields add theirs: zero for each of the lattice
    /// vertices, in scene units.
    pub(crate) fn begin_fields(&mut self, vertices: usize) -> &mut [[f64; 3]] {
        self.fields.next.clear();
        self.fields.next.resize(vertices, [0.0; 3]);
        &mut self.fields.next
    }

    /// Forgets the accelerations by fields in the next step.
    pub(crate) fn forget_fields(&mut self) {
        self.fields.next = Vec::new();
    }

    /// Returns whether fields act on the body.
    pub(crate) fn has_fields(&self) -> bool {
        !self.fields.next.is_empty()
    }

    /// Returns whether the forces of the next step differ from those with which the body came to rest: by more than
    /// `tolerance`, a force, at a vertex, or at all at a vertex without a force. `mass`: of a vertex. Fields may differ by
    /// the tolerance everywhere.
    pub(crate) fn move_a_body_at_rest(
        &self,
        tolerance: impl Fn(u32) -> f64,
        mass: impl Fn(u32) -> f64,
    ) -> bool {
        if self.fields.differ(|vertex, change| change * mass(vertex) > tolerance(vertex)) {
            return true;
        }
        let (mut next, mut at_rest) = (&self.next[..], &self.at_rest[..]);
        while let Some(vertex) = [next, at_rest].into_iter().filter_map(|list| Some(list.first()?.0)).min() {
            let [now, before] = [&mut next, &mut at_rest].map(|list| match list.split_first() {
                Some((&(other, force), rest)) if other == vertex => {
                    *list = rest;
                    Vector3::from(force)
                }
                _ => Vector3::zeros(),
            });
            let is_new = before == Vector3::zeros() && now != Vector3::zeros();
            if is_new || (now - before).norm() > tolerance(vertex) {
                return true;
            }
        }
        false
    }

    /// Discards the forces of the next step of a body that sleeps.
    pub(crate) fn discard(&mut self) {
        self.next.clear();
    }

    /// Forgets the displacements of the frame before, and stores the forces with which a body comes to rest.
    fn begin_applying(&mut self, is_frame_start: bool, is_awake: bool) {
        if is_frame_start {
            self.displacements.clear();
        }
        if is_awake {
            self.at_rest.clone_from(&self.next);
            self.fields.at_rest.clone_from(&self.fields.next);
        }
    }

    /// Applies the forces f of the next step: v += h f/m and x += h² f/m, with the step length h and the `mass` m of a
    /// vertex: see [`State::accelerate`]. `slots` has the slot of each lattice vertex: its index in the storage order.
    pub(crate) fn apply(
        &mut self,
        (step, is_frame_start): (Interval, bool),
        (lattice, slots): (&Lattice, &[u32]),
        mass: impl Fn(u32) -> f64,
        state: &mut State,
    ) {
        self.begin_applying(is_frame_start, state.rest.time() == 0.0);
        self.fields.apply(step, (lattice, slots), state);
        if self.next.is_empty() {
            return;
        }
        for (vertex, force) in self.next.drain(..) {
            let velocity_change = Vector3::from(force) * (step.dt / (mass(vertex) * lattice.cell_size()));
            state.accelerate((lattice, slots), vertex, velocity_change, step.dt);
            self.displacements.push((vertex, (velocity_change * step.dt).map(|x| x as f32).into()));
        }
        // A vertex has at most two entries, whose sum does not depend on their order. So the sort may be
        // unstable; an unstable sort does not allocate.
        self.displacements.sort_unstable_by_key(|&(vertex, _)| vertex);
        sum_duplicates(&mut self.displacements);
    }

    /// Takes the forces of the next step of a rigid body: returns their sum, and their torque about its center of mass in
    /// force x cells. A field acts on the mass of the body: its sum over the vertices is multiplied by a factor, and its
    /// torque is the one about the center of mass of the vertices, so that a uniform field exerts none.
    ///
    /// * `is_frame_start`, `is_awake`: whether a frame begins, and whether the body is not at rest.
    /// * `arm`, `lattice_center`: a vertex, and the center of mass of all vertices, from the center of mass in cells.
    /// * `mass`, `factor`: of a vertex, and the mass of the body relative to that of the vertices.
    pub(crate) fn take_sum(
        &mut self,
        (is_frame_start, is_awake): (bool, bool),
        (arm, lattice_center): (impl Fn(u32) -> Vector3<f64>, Vector3<f64>),
        (mass, factor): (impl Fn(u32) -> f64, f64),
    ) -> Twist {
        self.begin_applying(is_frame_start, is_awake);
        let mut sum = Twist::default();
        let mut add = |force: Vector3<f64>, arm: Vector3<f64>| {
            sum.linear += force;
            sum.angular += arm.cross(&force);
        };
        for (vertex, acceleration) in (0..).zip(&self.fields.next) {
            let force = Vector3::from(*acceleration) * (mass(vertex) * factor);
            add(force, arm(vertex) - lattice_center);
        }
        for (vertex, force) in self.next.drain(..) {
            add(force.into(), arm(vertex));
        }
        sum
    }

    /// Transfers the lists to a lattice whose vertices were split. `pairs` has pairs of a vertex and a vertex before.
    /// Copies share the force on their vertex in proportion to their `masses`, and have its displacement.
    pub(crate) fn transfer(&mut self, pairs: &[(u32, u32)], masses: &[f32]) {
        let mass = |vertex: u32| f64::from(masses[vertex as usize]);
        let mut sums = std::collections::BTreeMap::new();
        pairs.iter().for_each(|&(vertex, before)| *sums.entry(before).or_insert(0.0) += mass(vertex));
        let lasting = self.lasting.iter_mut().map(|lasting| &mut lasting.forces);
        for list in [&mut self.next, &mut self.at_rest].into_iter().chain(lasting) {
            *list = transferred(list, pairs, |(vertex, before), force| {
                let share = mass(vertex) / sums[&before];
                force.map(|x| x * share)
            });
            sum_duplicates(list);
        }
        self.fields.transfer(pairs);
        self.displacements = transferred(&self.displacements, pairs, |_, displacement| displacement);
        self.displacements.dedup_by_key(|(vertex, _)| *vertex);
    }

    /// Returns the displacements by the forces of the current frame: pairs of a lattice vertex and its
    /// velocity change times dt, in cells.
    pub(crate) fn displacements(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        self.displacements.iter().copied()
    }

    /// Returns whether all lists are empty.
    pub(crate) fn is_empty(&self) -> bool {
        let lists = [&self.next, &self.at_rest];
        self.lasting.is_empty()
            && lists.iter().all(|list| list.is_empty())
            && self.fields.is_empty()
            && self.displacements.is_empty()
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let lasting: usize = self.lasting.iter().map(|lasting| lasting.forces.capacity()).sum();
        (self.next.capacity() + self.at_rest.capacity() + lasting) * size_of::<(u32, [f64; 3])>()
            + self.displacements.capacity() * size_of::<(u32, [f32; 3])>()
            + self.fields.bytes()
    }

    /// Checks deserialized data. Returns whether all vertex indices are less than `vertices`.
    pub(crate) fn is_valid(&self, vertices: usize) -> bool {
        let in_range = |vertex: u32| (vertex as usize) < vertices;
        let lasting = self.lasting.iter().flat_map(|lasting| &lasting.forces);
        self.next.iter().chain(&self.at_rest).chain(lasting).all(|&(vertex, _)| in_range(vertex))
            && self.displacements.iter().all(|&(vertex, _)| in_range(vertex))
            && self.fields.is_valid(vertices)
    }
}

/// Returns the entries of a list, sorted by vertex, for each pair of a vertex and a vertex before whose latter is in
/// the list: with the value that `value` returns for the pair and the value before. Sorted.
fn transferred<T: Copy>(
    list: &[(u32, T)],
    pairs: &[(u32, u32)],
    value: impl Fn((u32, u32), T) -> T,
) -> Vec<(u32, T)> {
    let entry = |&pair: &(u32, u32)| {
        let place = list.binary_search_by_key(&pair.1, |&(vertex, _)| vertex).ok()?;
        Some((pair.0, value(pair, list[place].1)))
    };
    let mut entries: Vec<_> = pairs.iter().filter_map(entry).collect();
    entries.sort_by_key(|&(vertex, _)| vertex);
    entries
}

/// Adds entries, in which each vertex occurs once, to a sorted list.
fn add_to(list: &mut Vec<(u32, [f64; 3])>, entries: impl IntoIterator<Item = (u32, [f64; 3])>) {
    list.extend(entries);
    // A vertex has at most two entries, whose sum does not depend on their order. So the sort may be unstable; an
    // unstable sort does not allocate.
    list.sort_unstable_by_key(|&(vertex, _)| vertex);
    sum_duplicates(list);
}

/// Replaces the entries of each vertex by one entry, their sum. `list` must be sorted by vertex.
pub(super) fn sum_duplicates<T: Copy + AddAssign>(list: &mut Vec<(u32, [T; 3])>) {
    list.dedup_by(|(vertex, value), (previous, sum)| {
        let is_duplicate = vertex == previous;
        if is_duplicate {
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += *value);
        }
        is_duplicate
    });
}
