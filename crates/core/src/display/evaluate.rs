//! Evaluates the displayed surface of a body. Nothing here feeds back into the dynamics.
//!
//! The volume correction moves the lattice vertices from their positions P^ to P~ = P^ + lambda V, with the
//! scale lambda and the field V (Takamatsu & Kanai 2009, Eq. (1); module `volume`). The mesh update then
//! interpolates the mesh in the cells of P~, trilinearly or smoothly, and computes its normals (module `skin`).

use nalgebra::Point3;
use web_time::Instant;

use super::buffers::{Display, DisplayTimes};
use super::displayed::{Displayed, DisplayedSurface};
use super::stages::{DISPLAY, Frame, Stage};
use super::untangle::may_be_inverted;
use super::untangling::Untangling;
use crate::body::BodyRef;
use crate::volume::{Correction, VolumeReport};

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
    /// Evaluates the lattice of a body at its current positions: runs all stages of the display but the last one,
    /// which [`Displayed`] runs for each mesh or set of normals that is asked for.
    pub fn evaluate<'a>(&'a mut self, body: impl Into<BodyRef<'a>>) -> Displayed<'a> {
        let start = Instant::now();
        let frame = Frame::new(body.into());
        let body = frame.body.get();
        self.lattice.begin(body);
        self.clearance.begin();
        self.times = DisplayTimes::default();
        if let Some(correction) = body.correction() {
            body.set_rest_volumes(correction, &mut self.correcting.workspace);
        }
        if let Some(untangling) = &mut self.untangling {
            untangling.begin(self.lattice.deformed.len());
        }
        for stage in DISPLAY.into_iter().filter(|stage| stage.exists(body)) {
            self.run(stage, &frame);
        }
        let was_untangled = self.untangling.as_ref().is_some_and(|untangling| untangling.is_present());
        if body.correction().is_some() || was_untangled {
            self.times.volume = start.elapsed();
        }
        Displayed { display: self, body, executor: frame.executor }
    }

    /// Runs one stage.
    fn run(&mut self, stage: Stage, frame: &Frame<'_>) {
        let correction = frame.body.get().correction();
        match (stage, correction) {
            // untangle: P^ without cells inside out.
            (Stage::Untangle, _) => self.untangle_deformed(frame),
            // volume: P~ = P^ + lambda V.
            (Stage::Correct, Some(correction)) => {
                let Self { lattice, correcting, clearance, .. } = self;
                correcting.fit(frame);
                correcting.correct(frame, correction, lattice, clearance);
            }
            // untangle: P~ without cells inside out, corrected again.
            (Stage::UntangleCorrected, Some(correction)) => self.untangle_corrected(frame, correction),
            // skin: the mesh in the cells of P~, which `Displayed` writes when it is asked for.
            (Stage::Skin, _) | (_, None) => {}
        }
    }

    /// Untangles the deformed lattice, if a cell is inside out.
    fn untangle_deformed(&mut self, frame: &Frame<'_>) {
        let body = frame.body.get();
        if may_be_inverted(&body.matching().layout, &body.state().positions) {
            self.untangle_inverted(frame);
        }
        self.lattice.update_slope_weights(body);
    }

    /// Untangles the deformed lattice, if a cell is inside out. Most frames do not come here.
    #[cold]
    fn untangle_inverted(&mut self, frame: &Frame<'_>) {
        let Self { untangling, lattice, clearance, correcting, .. } = self;
        let body = frame.body.get();
        let untangling = Untangling::prepared(untangling, body);
        if !untangling.untangler.is_inverted(&lattice.deformed) {
            return;
        }
        if let Some(correction) = body.correction() {
            lattice.update_slope_weights(body);
            let (deformed, slope_weights) = (&lattice.deformed, lattice.slope_weights.values());
            let workspace = &mut correcting.workspace;
            untangling.volumes.extend(correction.volumes(
                workspace,
                &frame.executor,
                deformed,
                slope_weights,
            ));
        }
        let deformed = &mut lattice.deformed;
        untangling.deformed.extend_from_slice(deformed);
        untangling.untangler.limit_if_crushed(deformed);
        untangling.untangle(frame.body, clearance, deformed);
    }

    /// Untangles the corrected lattice, if a cell is inside out, and corrects the volume again, until no cell is inside
    /// out. If the volume cannot be restored without such a cell, the corrected lattice stays as it was.
    fn untangle_corrected(&mut self, frame: &Frame<'_>, correction: &Correction) {
        // The scales of the scope `regional` would lead back to the same inverted cells.
        if !correction.is_regional() {
            self.untangle_in_rounds(frame, correction);
        }
        if let Some(untangling) = &self.untangling {
            for (component, before) in self.correcting.components.iter_mut().zip(&untangling.volumes) {
                component.before = *before;
            }
        }
    }

    fn untangle_in_rounds(&mut self, frame: &Frame<'_>, correction: &Correction) {
        let body = frame.body.get();
        let layout = &body.matching().layout;
        for round in 1..=ROUNDS {
            let by_slot = self.correcting.by_slot(layout.slots(), &self.lattice.corrected);
            if !may_be_inverted(layout, by_slot) || !self.untangle_once(frame.body) {
                break;
            }
            let Self { lattice, correcting, clearance, untangling, .. } = self;
            let is_stuck = lattice.deformed == lattice.corrected;
            lattice.deformed.clone_from(&lattice.corrected);
            lattice.update_slope_weights(body);
            if is_stuck || round == ROUNDS {
                correcting.evaluate(frame, correction, lattice);
                break;
            }
            correcting.correct(frame, correction, lattice, clearance);
            if let Some(untangling) = untangling {
                untangling.first.add_scales(&correcting.components);
            }
        }
        let Some(untangling) = &self.untangling else { return };
        if untangling.first.is_better_than(&self.correcting.components, correction.caps()) {
            self.restore_first_correction(frame, correction);
        } else {
            untangling.first.write_scales(&mut self.correcting.components);
        }
    }

    /// Replaces the corrected lattice by the result of the first correction of the frame.
    #[cold]
    fn restore_first_correction(&mut self, frame: &Frame<'_>, correction: &Correction) {
        let Self { untangling: Some(untangling), lattice, correcting, .. } = self else { return };
        lattice.deformed.copy_from_slice(&untangling.first.start);
        lattice.corrected.copy_from_slice(&untangling.first.corrected);
        lattice.update_slope_weights(frame.body.get());
        correcting.evaluate(frame, correction, lattice);
        correcting.components.clone_from(&untangling.first.components);
    }

    /// Untangles the corrected lattice. Returns whether a cell was inside out.
    #[cold]
    fn untangle_once(&mut self, body: BodyRef<'_>) -> bool {
        let Self { untangling, lattice, clearance, correcting, .. } = self;
        let (deformed, corrected) = (&lattice.deformed, &mut lattice.corrected);
        let untangling = Untangling::prepared(untangling, body.get());
        if !untangling.untangler.is_inverted(corrected) {
            return false;
        }
        if !untangling.is_present() {
            untangling.volumes.extend(correcting.components.iter().map(|component| component.before));
            untangling.deformed.extend_from_slice(deformed);
        }
        untangling.first.keep(deformed, corrected, &correcting.components);
        if untangling.untangler.is_inverted(deformed) {
            untangling.untangle(body, clearance, corrected);
        } else {
            untangling.untangler.shorten(deformed, corrected);
        }
        true
    }
}
