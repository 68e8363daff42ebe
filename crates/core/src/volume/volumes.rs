//! Evaluates all volume measures of a body for reports, with or without correction.

use super::adjacency::Adjacency;
use super::measure::Measure;
use super::report::residual;
use super::sums::Scratch;
use super::surface::{self, Surface};
use super::{ComponentReport, Correction, VolumeMeasure, VolumeReport, Volumes};
use crate::lattice::{Lattice, SlopeWeights};
use crate::parallel::Executor;

/// All volume measures that a body allows, for reports.
///
/// The measures do not depend on a [`Correction`].
#[derive(Clone, Debug)]
pub struct VolumeMeasures {
    measures: Vec<Measure>,
    /// Rest volume of each component by each measure, in cubed scene units. The outer index is the measure.
    rest: Vec<Vec<f64>>,
    adjacency: Adjacency,
    cell_size: f64,
}

impl VolumeMeasures {
    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        self.measures.iter().map(Measure::bytes).sum::<usize>() + self.adjacency.bytes()
    }

    /// Creates the measures `lattice`, `cells`, and `mesh` if it can use the surface.
    pub fn new(lattice: &Lattice, surface: Option<Surface<'_>>) -> Self {
        let adjacency = Adjacency::new(lattice);
        let mesh = surface::measure(surface, lattice, &adjacency).ok().map(Measure::Mesh);
        let others = [Measure::lattice(&adjacency), Measure::cells(lattice, &adjacency)];
        let measures = others.into_iter().chain(mesh).collect();
        let mut this = Self { measures, rest: Vec::new(), adjacency, cell_size: lattice.cell_size() };
        let mut scratch = Scratch::default();
        scratch.set_rest_positions(lattice, &this.adjacency);
        this.rest = this.evaluate(&mut scratch);
        this
    }

    /// Returns the available measures: `lattice`, `cells`, and `mesh` if it can use the surface.
    pub fn kinds(&self) -> impl Iterator<Item = VolumeMeasure> + '_ {
        self.measures.iter().map(Measure::kind)
    }

    /// Reports the volumes of a deformed lattice without correction. `deformed`: positions of the lattice
    /// vertices, shape (n, 3), in cells, in the body's frame.
    #[cfg(feature = "internals")]
    pub fn report(&self, deformed: &[[f32; 3]]) -> VolumeReport {
        self.report_displayed(deformed, deformed, None)
    }

    /// Reports the volumes of a deformed lattice without correction, before and after it was untangled. `ratios` has
    /// the ratio of the rest volume of each component in force; `None` if all are 1.
    pub(crate) fn report_displayed(
        &self,
        deformed: &[[f32; 3]],
        untangled: &[[f32; 3]],
        ratios: Option<&[f64]>,
    ) -> VolumeReport {
        let rest = self.rest_in_force(ratios);
        let before = self.evaluate_deformed(deformed, deformed);
        let is_same = std::ptr::eq(deformed, untangled);
        let after = if is_same { before.clone() } else { self.evaluate_deformed(untangled, untangled) };
        // The last measure is the most accurate one available.
        let last = before.len() - 1;
        let component = |((&rest, &before), &after): ((&f64, &f64), &f64)| {
            let residual = residual(after - rest, rest);
            ComponentReport { rest, before, after, lambda: 0.0, residual, capped: false }
        };
        let components = rest[last].iter().zip(&before[last]).zip(&after[last]).map(component).collect();
        VolumeReport::new(self.measures[last].kind(), components, self.volumes(&rest, &before, &after))
    }

    /// Reports the volumes of a deformed lattice before and after its correction.
    ///
    /// `corrected` and `components` are the results of [`Correction::apply`] for `deformed`.
    #[cfg(feature = "internals")]
    pub fn report_corrected(
        &self,
        correction: &Correction,
        components: &[ComponentReport],
        deformed: &[[f32; 3]],
        corrected: &[[f32; 3]],
    ) -> VolumeReport {
        self.report_corrected_from(correction, components, deformed, (deformed, corrected), None)
    }

    /// Reports the volumes of a deformed lattice, before and after it was corrected from the positions `start`.
    /// `ratios`: as in [`report_displayed`](Self::report_displayed).
    pub(crate) fn report_corrected_from(
        &self,
        correction: &Correction,
        components: &[ComponentReport],
        deformed: &[[f32; 3]],
        (start, corrected): (&[[f32; 3]], &[[f32; 3]]),
        ratios: Option<&[f64]>,
    ) -> VolumeReport {
        let before = self.evaluate_deformed(deformed, deformed);
        let after = self.evaluate_deformed(corrected, start);
        let mut components = components.to_vec();
        if let Some(preserved) = self.kinds().position(|kind| kind == correction.measure()) {
            components
                .iter_mut()
                .zip(&before[preserved])
                .for_each(|(component, before)| component.before = *before);
        }
        let volumes = self.volumes(&self.rest_in_force(ratios), &before, &after);
        VolumeReport::new(correction.measure(), components, volumes)
    }

    /// Returns the volume of each component of a lattice with the positions `positions` by each measure; see
    /// `evaluate`. `deformed`: the positions without the correction, which determine the slope weights.
    fn evaluate_deformed(&self, positions: &[[f32; 3]], deformed: &[[f32; 3]]) -> Vec<Vec<f64>> {
        assert_eq!(positions.len(), self.adjacency.len(), "positions and lattice vertices differ in number");
        let mut scratch = Scratch::default();
        scratch.set_positions(positions, &self.adjacency);
        if let Some(smoothing) = self.measures.iter().find_map(Measure::smoothing) {
            let mut slope_weights = SlopeWeights::default();
            smoothing.update_slope_weights(deformed, &mut slope_weights);
            scratch.slope_weights.extend_from_slice(slope_weights.values());
        }
        self.evaluate(&mut scratch)
    }

    /// Returns the volume of each component by each measure, in cubed scene units. The outer index is the
    /// measure.
    fn evaluate(&self, scratch: &mut Scratch) -> Vec<Vec<f64>> {
        let volumes = |measure: &Measure| {
            measure.evaluate(&Executor::sequential(), scratch);
            scratch.coefficients.iter().map(|c| c[0] * self.cell_size.powi(3)).collect()
        };
        self.measures.iter().map(volumes).collect()
    }

    /// Returns the rest volume in force of each component by each measure.
    fn rest_in_force(&self, ratios: Option<&[f64]>) -> Vec<Vec<f64>> {
        let mut rest = self.rest.clone();
        if let Some(ratios) = ratios {
            rest.iter_mut()
                .for_each(|rest| rest.iter_mut().zip(ratios).for_each(|(rest, ratio)| *rest *= ratio));
        }
        rest
    }

    /// Returns the total volumes of the body by each measure.
    fn volumes(
        &self,
        rest: &[Vec<f64>],
        before: &[Vec<f64>],
        after: &[Vec<f64>],
    ) -> Vec<(VolumeMeasure, Volumes)> {
        let total = |volumes: &[f64]| volumes.iter().sum();
        let totals = rest.iter().zip(before).zip(after).map(|((rest, before), after)| Volumes {
            rest: total(rest),
            before: total(before),
            after: total(after),
        });
        self.kinds().zip(totals).collect()
    }
}
