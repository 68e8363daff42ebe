//! The volume correction of a displayed lattice: P~ = P^ + lambda V (Takamatsu & Kanai 2009, Eq. (1)).

use super::lattice::DisplayedLattice;
use super::stages::Frame;
use crate::body::Body;
use crate::clearance::{Clearance, Mover};
use crate::matching::{Purpose, RegionFit, Workspace};
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;
use crate::volume::{ComponentReport, Correction, CorrectionWorkspace, ExternalForce, Limits};

/// The buffers of the volume correction.
#[derive(Debug, Default)]
pub(super) struct Correcting {
    pub(super) workspace: CorrectionWorkspace,
    matching: Workspace,
    /// Rotations fitted to the current positions, by slot (see [`Lanes`]). The rotations of the state are
    /// fitted to the positions one step earlier.
    slot_rotations: Lanes<4>,
    /// `slot_rotations` in vertex order.
    rotations: Vec<[f32; 4]>,
    external_forces: Vec<ExternalForce>,
    pub(super) components: Vec<ComponentReport>,
}

impl Correcting {
    /// Fits the rotations to the current positions. The field V is rotated by them.
    pub(super) fn fit(&mut self, frame: &Frame<'_>) {
        let Self { matching: workspace, slot_rotations, rotations, .. } = self;
        let (state, matching) = (frame.body.get().state(), frame.body.get().matching());
        slot_rotations.copy_from(&state.rotations);
        let fitted = RegionFit {
            positions: &state.positions,
            rotations: &mut *slot_rotations,
            shapes: frame.body.get().shapes(),
        };
        matching.fit(workspace, &frame.executor, fitted, None, Purpose::Regions);
        matching.rotations_at_vertices(slot_rotations, rotations);
    }

    /// Runs the correction: sets the constrained vertices, removes the directions of external forces from the field
    /// (Eq. (2)), solves for lambda (Eq. (1)) and limits the correction at colliders and bodies.
    pub(super) fn correct(
        &mut self,
        frame: &Frame<'_>,
        correction: &Correction,
        lattice: &mut DisplayedLattice,
        clearance: &mut Clearance,
    ) {
        let Self { workspace, rotations, external_forces, components, .. } = self;
        let DisplayedLattice { deformed, corrected, slope_weights, .. } = lattice;
        let (body, executor) = (frame.body, &frame.executor);
        correction.set_constrained(workspace, body.constrained_vertices());
        external_forces.clear();
        external_forces.extend(
            body.context().into_iter().flat_map(|context| external_forces_on(body.get(), context.dt)),
        );
        correction.solve(workspace, executor, deformed, rotations, external_forces, slope_weights.values());
        corrected.resize(deformed.len(), [0.0; 3]);
        let mut solved = Solved { correction, workspace, executor, deformed, corrected, components };
        clearance.move_clear(body, deformed, 0.0, &mut solved);
    }

    /// Evaluates the volumes of the corrected lattice, after it was changed.
    pub(super) fn evaluate(
        &mut self,
        frame: &Frame<'_>,
        correction: &Correction,
        lattice: &DisplayedLattice,
    ) {
        let DisplayedLattice { corrected, slope_weights, .. } = lattice;
        let reports =
            correction.replace(&mut self.workspace, &frame.executor, corrected, slope_weights.values());
        self.components.clear();
        self.components.extend_from_slice(reports);
    }

    /// Returns positions in vertex order by slot, in the place of the rotations, which are not needed any more.
    pub(super) fn by_slot(&mut self, slots: &[u32], positions: &[[f32; 3]]) -> &Lanes<4> {
        for (&slot, &[x, y, z]) in slots.iter().zip(positions) {
            self.slot_rotations.set(slot, [x, y, z, 0.0]);
        }
        &self.slot_rotations
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { workspace, matching, slot_rotations, rotations, external_forces, components } = self;
        let forces_reports = size_of_val(&**external_forces) + size_of_val(&**components);
        workspace.bytes()
            + matching.bytes()
            + slot_rotations.bytes()
            + size_of_val(&**rotations)
            + forces_reports
    }
}

/// A correction that was solved without limits.
struct Solved<'a> {
    correction: &'a Correction,
    workspace: &'a mut CorrectionWorkspace,
    executor: &'a Executor,
    deformed: &'a [[f32; 3]],
    corrected: &'a mut [[f32; 3]],
    components: &'a mut Vec<ComponentReport>,
}

impl Mover for Solved<'_> {
    fn move_within(&mut self, limits: &Limits) -> &[[f32; 3]] {
        self.correction.solve_within(self.workspace, self.executor, limits);
        let reports = self.correction.write(self.workspace, self.deformed, self.corrected);
        self.components.clear();
        self.components.extend_from_slice(reports);
        self.corrected
    }

    fn remove_soft(&mut self, limits: &mut Limits) -> bool {
        self.correction.remove_soft(self.workspace, limits)
    }
}

/// Returns the external forces of Eq. (2): the displacements by contacts and forces since the frame
/// began, divided by alpha. Because of the division, a displacement has more effect on the correction of
/// a softer body, which has a smaller alpha.
fn external_forces_on(body: &Body, dt: f64) -> impl Iterator<Item = ExternalForce> {
    let scale = (1.0 / body.alpha(dt)) as f32;
    let contacts = body.contacts().into_iter().flat_map(|contacts| contacts.displacements());
    let forces = body.forces().into_iter().flat_map(|forces| forces.displacements());
    contacts
        .chain(forces)
        .map(move |(vertex, offset)| ExternalForce { vertex, force: offset.map(|x| x * scale) })
}
