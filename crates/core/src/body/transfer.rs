//! The state of a body after an event in which joints broke.
//!
//! The copies of a split vertex take its position, velocity and rotation, and share its mass, so that mass, momenta and
//! kinetic energy stay the same.

use crate::lattice::Lattice;
use crate::matching::Matching;
use crate::simd::lanes::Lanes;
use crate::state::{Rest, State, Supports, Touches};

/// For each vertex after an event, the vertices before.
pub(super) struct Parents {
    /// A vertex before; the only one but for `merged`.
    pub(super) first: Vec<u32>,
    /// Further pairs of a vertex and a vertex before: copies that an event unites, near the front of a crack. Sorted.
    merged: Vec<(u32, u32)>,
}

impl Parents {
    pub(super) fn new(before: &Lattice, after: &Lattice) -> Self {
        let (mut first, mut merged) = (vec![u32::MAX; after.len()], Vec::new());
        for cell in 0..after.cells().len() as u32 {
            for (old, new) in before.cell_corners(cell).into_iter().zip(after.cell_corners(cell)) {
                match &mut first[new as usize] {
                    entry if *entry == u32::MAX => *entry = old,
                    entry if *entry != old => merged.push((new, old)),
                    _ => {}
                }
            }
        }
        merged.sort_unstable();
        merged.dedup();
        Self { first, merged }
    }

    /// Returns all pairs of a vertex after an event and a vertex before.
    pub(super) fn pairs(&self) -> Vec<(u32, u32)> {
        (0..).zip(self.first.iter().copied()).chain(self.merged.iter().copied()).collect()
    }

    /// Returns the values of the vertices after an event. United vertices have the mean, weighted by the masses before.
    fn transferred<const N: usize>(
        &self,
        values: &Lanes<N>,
        masses: &[f32],
        (before, after): (&Matching, &Matching),
    ) -> Lanes<N> {
        let mut transferred = Lanes::zeros(after.layout.blocks());
        let (old_slots, slots) = (before.layout.slots(), after.layout.slots());
        for (&slot, &parent) in slots.iter().zip(&self.first) {
            transferred.set(slot, values.get(old_slots[parent as usize]));
        }
        for united in self.merged.chunk_by(|a, b| a.0 == b.0) {
            let vertex = united[0].0 as usize;
            let parents = united.iter().map(|(_, parent)| *parent).chain([self.first[vertex]]);
            let (mut sum, mut mass) = ([0.0; N], 0.0);
            for parent in parents {
                let weight = f64::from(masses[parent as usize]);
                mass += weight;
                let value = values.get(old_slots[parent as usize]);
                (0..N).for_each(|c| sum[c] += weight * f64::from(value[c]));
            }
            transferred.set(slots[vertex], sum.map(|sum| (sum / mass) as f32));
        }
        transferred
    }
}

/// Returns the state after an event. Contacts, supports and momenta are found again in the next step.
pub(super) fn transfer(
    state: &State,
    parents: &Parents,
    masses: &[f32],
    (before, after): (&Matching, &Matching),
    lattice: &Lattice,
) -> State {
    let stages = (before, after);
    let mut rotations = parents.transferred(&state.rotations, masses, stages);
    for &(vertex, _) in &parents.merged {
        let slot = after.layout.slots()[vertex as usize];
        let quaternion = nalgebra::Vector4::from(rotations.get(slot));
        rotations.set(slot, quaternion.try_normalize(0.0).unwrap_or_else(nalgebra::Vector4::w).into());
    }
    let mut transferred = State {
        frame: state.frame,
        positions: parents.transferred(&state.positions, masses, stages),
        compensation: parents.transferred(&state.compensation, masses, stages),
        velocities: parents.transferred(&state.velocities, masses, stages),
        rotations,
        strains: state.strains.as_ref().map(|strains| parents.transferred(strains, masses, stages)),
        fitted: false,
        momenta: vec![None; lattice.components().count],
        energy_limit: None,
        supports: Supports::default(),
        touches: Touches::default(),
        escapes: state.escapes.clone(),
        rest: Rest::default(),
    };
    // The ways belong to components that no longer exist.
    if !transferred.escapes.list().is_empty() {
        transferred.escapes.search();
    }
    transferred
}
