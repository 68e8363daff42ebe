//! The state of a body after an event in which joints broke.
//!
//! The copies of a split vertex take its position, velocity and rotation, and share its mass, so that mass, momenta and
//! kinetic energy stay the same.

use nalgebra::Matrix3;

use crate::lattice::Lattice;
use crate::matching::Matching;
use crate::simd::lanes::Lanes;
use crate::state::{Rest, State, Supports, Touches};

/// For each vertex after an event, the vertices before.
pub(super) struct Parents {
    /// The vertex before; one of several for the vertices in `merged`.
    pub(super) first: Vec<u32>,
    /// For copies that an event unites, near the front of a crack: triples of a vertex, a vertex before and the mass
    /// that it has from it, in masses of a full cell. Sorted.
    merged: Vec<(u32, u32, f64)>,
    /// The first corner of each cell, before and after.
    of_cells: Vec<(u32, u32)>,
}

impl Parents {
    /// `shares`: the filled share of each cell, by which the cells have their parts of the masses of vertices.
    pub(super) fn new(before: &Lattice, after: &Lattice, shares: &[f64]) -> Self {
        let mut first = vec![u32::MAX; after.len()];
        let mut has_several = vec![false; after.len()];
        let (old_corners, new_corners) = (before.corner_table(), after.corner_table());
        let corners = || old_corners.iter().zip(&*new_corners).map(|(old, new)| old.iter().zip(new));
        for (&old, &new) in corners().flatten() {
            match &mut first[new as usize] {
                entry if *entry == u32::MAX => *entry = old,
                entry => has_several[new as usize] |= *entry != old,
            }
        }
        let mut parts: Vec<(u32, u32, f64)> = corners()
            .zip(shares)
            .flat_map(|(corners, share)| corners.map(move |(&old, &new)| (new, old, share / 8.0)))
            .filter(|(new, ..)| has_several[*new as usize])
            .collect();
        parts.sort_by_key(|&(new, old, _)| (new, old));
        parts.dedup_by(|part, sum| {
            let is_same = (part.0, part.1) == (sum.0, sum.1);
            if is_same {
                sum.2 += part.2;
            }
            is_same
        });
        let of_cells = old_corners.iter().zip(&*new_corners).map(|(old, new)| (old[0], new[0])).collect();
        Self { first, merged: parts, of_cells }
    }

    /// Returns all pairs of a vertex after an event and a vertex before.
    pub(super) fn pairs(&self) -> Vec<(u32, u32)> {
        let merged = self.merged.iter().map(|&(vertex, parent, _)| (vertex, parent));
        let others = merged.filter(|&(vertex, parent)| self.first[vertex as usize] != parent);
        (0..).zip(self.first.iter().copied()).chain(others).collect()
    }

    /// Returns the values of the vertices after an event. United vertices have the mean, weighted
    /// by the masses from the vertices before, so that momentum is kept.
    fn transferred<const N: usize>(
        &self,
        values: &Lanes<N>,
        (before, after): (&Matching, &Matching),
    ) -> Lanes<N> {
        let mut transferred = Lanes::zeros(after.layout.blocks());
        let (old_slots, slots) = (before.layout.slots(), after.layout.slots());
        for (&slot, &parent) in slots.iter().zip(&self.first) {
            transferred.set(slot, values.get(old_slots[parent as usize]));
        }
        for united in self.merged.chunk_by(|a, b| a.0 == b.0) {
            let (mut sum, mut mass) = ([0.0; N], 0.0);
            for &(_, parent, part) in united {
                mass += part;
                let value = values.get(old_slots[parent as usize]);
                (0..N).for_each(|c| sum[c] += part * f64::from(value[c]));
            }
            transferred.set(slots[united[0].0 as usize], sum.map(|sum| (sum / mass) as f32));
        }
        transferred
    }

    /// Gives the first corner of each cell the values of its first corner before, if the regions are cells: copies of
    /// a vertex are the first corners of different cells.
    fn keep_cells<const N: usize>(
        &self,
        values: &Lanes<N>,
        (before, after): (&Matching, &Matching),
        transferred: &mut Lanes<N>,
    ) {
        if !after.regions.half_width().is_cell() {
            return;
        }
        let (old_slots, slots) = (before.layout.slots(), after.layout.slots());
        for &(old, new) in &self.of_cells {
            transferred.set(slots[new as usize], values.get(old_slots[old as usize]));
        }
    }
}

/// Scales a plastic shape S, the mean of several, to the determinant 1. Takes and returns S - 1.
fn of_volume_one(strain: [f32; 6]) -> [f32; 6] {
    let [xx, yy, zz, xy, xz, yz] = strain.map(f64::from);
    let shape = Matrix3::new(1.0 + xx, xy, xz, xy, 1.0 + yy, yz, xz, yz, 1.0 + zz);
    // Means of matrices with positive eigenvalues and determinant 1 have a determinant of at least 1.
    let scale = libm::cbrt(shape.determinant()).recip();
    let diagonal = [xx, yy, zz].map(|strain| ((1.0 + strain) * scale - 1.0) as f32);
    let [xy, xz, yz] = [xy, xz, yz].map(|strain| (strain * scale) as f32);
    [diagonal[0], diagonal[1], diagonal[2], xy, xz, yz]
}

/// Returns the state after an event. Contacts, supports and momenta are found again in the next step.
pub(super) fn transfer(
    state: &State,
    parents: &Parents,
    (before, after): (&Matching, &Matching),
    lattice: &Lattice,
) -> State {
    let stages = (before, after);
    let mut rotations = parents.transferred(&state.rotations, stages);
    for &(vertex, ..) in &parents.merged {
        let slot = after.layout.slots()[vertex as usize];
        let quaternion = nalgebra::Vector4::from(rotations.get(slot));
        rotations.set(slot, quaternion.try_normalize(0.0).unwrap_or_else(nalgebra::Vector4::w).into());
    }
    parents.keep_cells(&state.rotations, stages, &mut rotations);
    let strains = state.strains.as_ref().map(|before| {
        let mut strains = parents.transferred(before, stages);
        for &(vertex, ..) in &parents.merged {
            let slot = after.layout.slots()[vertex as usize];
            strains.set(slot, of_volume_one(strains.get(slot)));
        }
        parents.keep_cells(before, stages, &mut strains);
        strains
    });
    let mut transferred = State {
        frame: state.frame,
        positions: parents.transferred(&state.positions, stages),
        compensation: parents.transferred(&state.compensation, stages),
        velocities: parents.transferred(&state.velocities, stages),
        rotations,
        strains,
        fitted: false,
        momenta: vec![None; lattice.components().count],
        energy_limit: None,
        recovery_steps: 0,
        supports: Supports::default(),
        touches: Touches::default(),
        escapes: state.escapes.clone(),
        rigid: None,
        rest: Rest::default(),
    };
    // The escapes belong to components that no longer exist.
    if !transferred.escapes.list().is_empty() {
        transferred.escapes.search();
    }
    transferred
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point3};

    use crate::matching::symmetric;
    use crate::{Body, Lattice, Material, Plasticity};

    /// Two halves with different plastic shapes become one body again: the vertices between them have means.
    #[test]
    fn plastic_shapes_of_united_vertices_have_the_determinant_1() {
        let cells: Vec<[i32; 3]> = (0..64).map(|k| [k % 4, k / 4 % 4, k / 16]).collect();
        let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let material = Material { plastic: Some(Plasticity::default()), ..Material::fast_lsm() };
        let mut body = Body::from_lattice(lattice).material(material).build().unwrap();
        body.cut([2.0; 3], [1.0, 0.0, 0.0]).unwrap();
        assert_eq!(body.pieces(), 2);
        let slots = body.pipeline.matching.layout.slots().to_vec();
        let strains = body.state.strains.as_mut().unwrap();
        for (&slot, &piece) in slots.iter().zip(&body.shape.lattice.components().of_vertex) {
            let stretch = if piece == 0 { 1.5_f32 } else { 0.5 };
            strains.set(slot, [stretch - 1.0, 1.0 / stretch - 1.0, 0.0, 0.0, 0.0, 0.0]);
        }
        body.restore_cracks(None);
        assert_eq!(body.pieces(), 1);
        let strains = body.state.strains.as_ref().unwrap();
        let shapes = body.pipeline.matching.layout.slots().iter().map(|&slot| symmetric(strains.get(slot)));
        let determinants = shapes.map(|strain| (Matrix3::identity() + strain).determinant());
        assert!(determinants.clone().count() == 125);
        determinants.for_each(|determinant| assert!((determinant - 1.0).abs() < 1e-6, "{determinant}"));
    }
}
