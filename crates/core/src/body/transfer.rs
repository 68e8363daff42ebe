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

/// Scales a plastic shape S, the mean of several, to the determinant 1. Takes and returns S - 1.
fn of_volume_one(strain: [f32; 6]) -> [f32; 6] {
    let [xx, yy, zz, xy, xz, yz] = strain.map(f64::from);
    let shape = Matrix3::new(1.0 + xx, xy, xz, xy, 1.0 + yy, yz, xz, yz, 1.0 + zz);
    // Means of matrices with positive eigenvalues and determinant 1 have a determinant of at least 1.
    let scale = shape.determinant().cbrt().recip();
    let diagonal = [xx, yy, zz].map(|strain| ((1.0 + strain) * scale - 1.0) as f32);
    let [xy, xz, yz] = [xy, xz, yz].map(|strain| (strain * scale) as f32);
    [diagonal[0], diagonal[1], diagonal[2], xy, xz, yz]
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
    let strains = state.strains.as_ref().map(|strains| {
        let mut strains = parents.transferred(strains, masses, stages);
        for &(vertex, _) in &parents.merged {
            let slot = after.layout.slots()[vertex as usize];
            strains.set(slot, of_volume_one(strains.get(slot)));
        }
        strains
    });
    let mut transferred = State {
        frame: state.frame,
        positions: parents.transferred(&state.positions, masses, stages),
        compensation: parents.transferred(&state.compensation, masses, stages),
        velocities: parents.transferred(&state.velocities, masses, stages),
        rotations,
        strains,
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
        let slots = body.matching.layout.slots().to_vec();
        let strains = body.state.strains.as_mut().unwrap();
        for (&slot, &piece) in slots.iter().zip(&body.lattice.components().of_vertex) {
            let stretch = if piece == 0 { 1.5_f32 } else { 0.5 };
            strains.set(slot, [stretch - 1.0, 1.0 / stretch - 1.0, 0.0, 0.0, 0.0, 0.0]);
        }
        body.restore_cracks(None).unwrap();
        assert_eq!(body.pieces(), 1);
        let strains = body.state.strains.as_ref().unwrap();
        let shapes = body.matching.layout.slots().iter().map(|&slot| symmetric(strains.get(slot)));
        let determinants = shapes.map(|strain| (Matrix3::identity() + strain).determinant());
        assert!(determinants.clone().count() == 125);
        determinants.for_each(|determinant| assert!((determinant - 1.0).abs() < 1e-6, "{determinant}"));
    }
}
