//! Evaluates the displayed surface of a body. Nothing here feeds back into the dynamics.
//!
//! The volume correction moves the lattice vertices from their positions P^ to P~ = P^ + lambda V, with the
//! scale lambda and the field V (Takamatsu & Kanai 2009, Eq. (1); module `volume`). The mesh update then
//! interpolates the mesh in the cells of P~, trilinearly or smoothly, and computes its normals (module `skin`).

use nalgebra::Point3;
use web_time::Instant;

use super::buffers::{Display, DisplayTimes};
use super::displayed::{Displayed, DisplayedSurface};
use super::surroundings::surroundings;
use super::untangle::may_be_inverted;
use super::untangling::Untangling;
use crate::body::{Body, BodyRef};
use crate::matching::Purpose;
use crate::parallel::Executor;
use crate::volume::{Correction, ExternalForce, VolumeReport};

/// The displayed surface. For many frames, reusing one [`Display`] is faster.
impl BodyRef<'_> {
    /// Evaluates the displayed surface: the mesh, deformed by the lattice after the volume correction. For
    /// many frames, reusing one [`Display`] is faster.
    pub fn surface(self) -> DisplayedSurface {
        Display::new().evaluate(self).surface()
    }

    /// Returns the lattice positions after the volume correction, shape `(n, 3)`. Without a correction they
    /// equal the positions before the correction.
    pub fn corrected_positions(self) -> Vec<Point3<f64>> {
        Display::new().evaluate(self).positions().collect()
    }

    /// Returns the volumes by all measures, before and after the correction.
    pub fn volume_report(self) -> VolumeReport {
        Display::new().evaluate(self).volume_report()
    }

    /// Returns the volume after the correction, in cubed scene units, by the measure of the correction.
    /// Without a correction, uses the measure that `auto` would choose.
    pub fn volume(self) -> f64 {
        self.volume_report().after
    }
}

/// Greatest number of times that the corrected lattice is untangled, and corrected again.
const ROUNDS: usize = 8;

impl Display {
    /// Corrects the volume of a body at its current positions: P~ = P^ + lambda V (Takamatsu & Kanai 2009,
    /// Eq. (1)).
    pub fn evaluate<'a>(&'a mut self, body: impl Into<BodyRef<'a>>) -> Displayed<'a> {
        let body = body.into();
        let start = Instant::now();
        let executor = body.context().map_or_else(Executor::sequential, |context| context.executor.clone());
        let (state, matching) = (body.get().state(), body.get().matching());
        let correction = body.get().correction();
        let slots = matching.layout.slots();
        self.deformed.clear();
        self.deformed.extend(slots.iter().map(|&slot| state.positions.get(slot)));
        self.times = DisplayTimes::default();
        if let Some(correction) = correction {
            body.get().set_rest_volumes(correction, &mut self.correction);
        }
        if let Some(untangling) = &mut self.untangling {
            untangling.begin(self.deformed.len());
        }
        if may_be_inverted(&matching.layout, &state.positions) {
            self.untangle_deformed(body, &executor);
        }
        self.update_trust(body);
        if let Some(correction) = correction {
            // The field V is rotated by the region rotations at the current positions.
            self.slot_rotations.copy_from(&state.rotations);
            let fitted = (&state.positions, &mut self.slot_rotations, body.get().shapes());
            let workspace = &mut self.matching_workspace;
            matching.fit(workspace, &executor, fitted, None, Purpose::Regions);
            matching.rotations_at_vertices(&self.slot_rotations, &mut self.rotations);
            self.correct(body, correction, &executor);
            // The scales of the scope `regional` would lead back to the same inverted cells.
            if !correction.is_regional() {
                self.untangle_corrected(body, correction, &executor);
            }
            if let Some(untangling) = &self.untangling {
                for (component, before) in self.components.iter_mut().zip(untangling.volumes()) {
                    component.before = *before;
                }
            }
        }
        if body.get().correction().is_some()
            || self.untangling.as_ref().is_some_and(|untangling| untangling.is_present())
        {
            self.times.volume = start.elapsed();
        }
        Displayed { display: self, body: body.get(), executor }
    }

    /// Runs the volume correction: sets the constrained vertices, removes the directions of external forces
    /// from the field (Eq. (2)), solves for lambda (Eq. (1)) and limits the correction at colliders.
    fn correct(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        let Self {
            correction: workspace,
            deformed,
            corrected,
            rotations,
            external_forces,
            body_limits,
            trust,
            ..
        } = self;
        correction.set_constrained(workspace, body.constrained_vertices());
        external_forces.clear();
        external_forces.extend(
            body.context().into_iter().flat_map(|context| external_forces_on(body.get(), context.dt)),
        );
        correction.solve(workspace, executor, deformed, rotations, external_forces, trust.values());
        corrected.resize(deformed.len(), [0.0; 3]);
        if let Some(surroundings) = surroundings(body) {
            correction.limit_at_obstacles(
                workspace,
                executor,
                (surroundings.samples(), &surroundings.obstacles),
                &mut body_limits.finder(body),
                deformed,
                corrected,
            );
        }
        self.components.clear();
        self.components.extend_from_slice(correction.write(workspace, deformed, corrected));
    }

    /// Untangles the deformed lattice, if a cell is inside out.
    #[cold]
    fn untangle_deformed(&mut self, body: BodyRef<'_>, executor: &Executor) {
        let Self { untangling, deformed, body_limits, correction: workspace, trust, .. } = self;
        let untangling = Untangling::prepared(untangling, body.get());
        if !untangling.is_inverted(deformed) {
            return;
        }
        if let Some(correction) = body.get().correction() {
            if let Some(smoothing) = body.get().smoothing() {
                smoothing.update_trust(deformed, trust);
            }
            untangling.set_volumes(correction.volumes(workspace, executor, deformed, trust.values()));
        }
        untangling.set_deformed(deformed);
        untangling.limit_if_crushed(deformed);
        untangling.untangle(surroundings(body), &mut body_limits.finder(body), deformed);
    }

    /// Untangles the corrected lattice, if a cell is inside out, and corrects the volume again, until no cell is inside
    /// out. If the volume cannot be restored without such a cell, the corrected lattice stays as it was.
    fn untangle_corrected(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        for round in 1..=ROUNDS {
            let layout = &body.matching().layout;
            // The rotations by slot are not needed any more.
            for (&slot, &[x, y, z]) in layout.slots().iter().zip(&self.corrected) {
                self.slot_rotations.set(slot, [x, y, z, 0.0]);
            }
            if !may_be_inverted(layout, &self.slot_rotations) || !self.untangle_once(body) {
                break;
            }
            let is_stuck = self.deformed == self.corrected;
            self.deformed.clone_from(&self.corrected);
            self.update_trust(body);
            if is_stuck || round == ROUNDS {
                self.evaluate_corrected(correction, executor);
                break;
            }
            self.correct(body, correction, executor);
            if let Some(untangling) = &mut self.untangling {
                untangling.first.add_scales(&self.components);
            }
        }
        let Some(untangling) = &self.untangling else { return };
        if untangling.first.is_better_than(&self.components, correction.caps()) {
            self.restore_first_correction(body, correction, executor);
        } else {
            untangling.first.write_scales(&mut self.components);
        }
    }

    /// Replaces the corrected lattice by that of the first correction of the frame.
    #[cold]
    fn restore_first_correction(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        let Some(untangling) = &self.untangling else { return };
        self.deformed.copy_from_slice(&untangling.first.start);
        self.corrected.copy_from_slice(&untangling.first.corrected);
        self.update_trust(body);
        self.evaluate_corrected(correction, executor);
        if let Some(untangling) = &self.untangling {
            self.components.clone_from(&untangling.first.components);
        }
    }

    /// Updates the trust in the slopes of the deformed lattice, if the skin is smooth.
    fn update_trust(&mut self, body: BodyRef<'_>) {
        if let Some(smoothing) = body.get().smoothing() {
            smoothing.update_trust(&self.deformed, &mut self.trust);
        }
    }

    /// Evaluates the volumes of the corrected lattice, after it was changed.
    fn evaluate_corrected(&mut self, correction: &Correction, executor: &Executor) {
        let trust = self.trust.values();
        let reports = correction.replace(&mut self.correction, executor, &self.corrected, trust);
        self.components.clear();
        self.components.extend_from_slice(reports);
    }

    /// Untangles the corrected lattice. Returns whether a cell was inside out.
    #[cold]
    fn untangle_once(&mut self, body: BodyRef<'_>) -> bool {
        let Self { untangling, deformed, corrected, body_limits, components, .. } = self;
        let untangling = Untangling::prepared(untangling, body.get());
        if !untangling.is_inverted(corrected) {
            return false;
        }
        if !untangling.is_present() {
            untangling.set_volumes(components.iter().map(|component| component.before));
            untangling.set_deformed(deformed);
        }
        untangling.first.keep(deformed, corrected, components);
        if untangling.is_inverted(deformed) {
            untangling.untangle(surroundings(body), &mut body_limits.finder(body), corrected);
        } else {
            untangling.shorten(deformed, corrected);
        }
        true
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
