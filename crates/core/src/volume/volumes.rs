//! A body's volume by every measure, whether it is corrected or not.

use super::adjacency::Adjacency;
use super::measure::{Measure, Scratch};
use super::surface::{self, Surface};
use super::{ComponentReport, Correction, VolumeMeasure, VolumeReport, Volumes};
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// All measures of a body, for reports. Independent of a [`Correction`], so that a body without one has none of it
/// until somebody asks.
#[derive(Clone, Debug)]
pub struct VolumeMeasures {
    measures: Vec<Measured>,
    adjacency: Adjacency,
    cell_size: f64,
}

#[derive(Clone, Debug)]
struct Measured {
    measure: Measure,
    rest: Vec<f64>,
}

impl VolumeMeasures {
    /// `lattice`, `cells`, and `mesh` where the surface is usable as a measure.
    pub fn new(lattice: &Lattice, surface: Option<Surface<'_>>) -> Self {
        let adjacency = Adjacency::new(lattice);
        let mesh = surface::measure(surface, lattice, &adjacency).ok().map(Measure::Mesh);
        let others = [Measure::lattice(&adjacency), Measure::cells(lattice, &adjacency)];
        let cell_size = lattice.cell_size();
        let mut scratch = Scratch::default();
        scratch.place_at_rest(lattice, &adjacency);
        let measured =
            |measure: Measure| Measured { rest: evaluate(&measure, &mut scratch, cell_size), measure };
        let measures = others.into_iter().chain(mesh).map(measured).collect();
        Self { measures, adjacency, cell_size }
    }

    /// The measures that the body has: `lattice`, `cells`, and `mesh` where it is usable.
    pub fn kinds(&self) -> impl Iterator<Item = VolumeMeasure> + '_ {
        self.measures.iter().map(|measured| measured.measure.kind())
    }

    /// The report on a deformed lattice that nobody corrects. `deformed`: (n, 3), in cells, body-local.
    pub fn report(&self, deformed: &[[f32; 3]]) -> VolumeReport {
        let before = self.evaluate(deformed);
        // The last measure is the best that the body has.
        let last = before.len() - 1;
        let volumes = self.volumes(&before, &before);
        let Measured { measure, rest } = &self.measures[last];
        let component = |(&rest, &before): (&f64, &f64)| {
            let residual = (before - rest) / rest;
            ComponentReport { rest, before, after: before, lambda: 0.0, residual, capped: false }
        };
        let components = rest.iter().zip(&before[last]).map(component).collect();
        VolumeReport::new(measure.kind(), components, volumes)
    }

    /// The report on a deformed lattice and what [`Correction::apply`] made of it: `corrected` and `components`.
    pub fn report_corrected(
        &self,
        correction: &Correction,
        components: &[ComponentReport],
        deformed: &[[f32; 3]],
        corrected: &[[f32; 3]],
    ) -> VolumeReport {
        let before = self.evaluate(deformed);
        let after = self.evaluate(corrected);
        let kept = self.measures.iter().position(|measured| measured.measure.kind() == correction.measure());
        let mut components = components.to_vec();
        for (component, &before) in
            components.iter_mut().zip(kept.map(|kept| &before[kept]).into_iter().flatten())
        {
            component.before = before;
        }
        VolumeReport::new(correction.measure(), components, self.volumes(&before, &after))
    }

    /// For each measure the volume of each component, in cubed units of length.
    fn evaluate(&self, positions: &[[f32; 3]]) -> Vec<Vec<f64>> {
        assert_eq!(positions.len(), self.adjacency.len(), "positions and lattice vertices differ in number");
        let mut scratch = Scratch::default();
        scratch.place(positions.iter().map(|p| p.map(f64::from)), &self.adjacency);
        let measures = self.measures.iter();
        measures.map(|measured| evaluate(&measured.measure, &mut scratch, self.cell_size)).collect()
    }

    fn volumes(&self, before: &[Vec<f64>], after: &[Vec<f64>]) -> Vec<(VolumeMeasure, Volumes)> {
        let total = |parts: &[f64]| parts.iter().sum();
        let measures = self.measures.iter().zip(before).zip(after);
        measures
            .map(|((measured, before), after)| {
                let volumes =
                    Volumes { rest: total(&measured.rest), before: total(before), after: total(after) };
                (measured.measure.kind(), volumes)
            })
            .collect()
    }
}

/// The volume of each component, in cubed units of length, where the points are.
fn evaluate(measure: &Measure, scratch: &mut Scratch, cell_size: f64) -> Vec<f64> {
    measure.evaluate(&Executor::sequential(), scratch);
    scratch.coefficients.iter().map(|c| c[0] * cell_size.powi(3)).collect()
}
