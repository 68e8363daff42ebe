//! Times a frame of a fine mesh on a coarse lattice: step, volume correction, and mesh update with normals.

use std::time::Duration;

use supple::{
    Body, BodySnapshot, Display, Material, Preservation, Simulation, SkinKind, VolumeMeasure, VolumeOptions,
};
use supple_benches::Target::AtMost;
use supple_benches::bodies::{Statue, deform};

use crate::measure::{Bench, Sampling, steps, timed};

/// Quads along each edge of the cube that is mapped to the statue; gives 60,002 mesh vertices.
pub(crate) const QUADS: usize = 100;
pub(crate) const LATTICE_VERTICES: usize = 1000;

/// A simulation of the statue, with the display and the buffers for the evaluated surface.
pub(crate) struct DisplayedStatue {
    simulation: Simulation,
    start: BodySnapshot,
    display: Display,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

/// Index of the time of the whole frame among the measured times.
const FRAME: usize = 0;
/// Index of the time of the step.
pub(crate) const STEP: usize = 1;
/// Index of the time of the volume correction.
pub(crate) const CORRECTION: usize = 2;
/// Index of the time of the mesh update.
const UPDATE: usize = 3;
/// Index of the time of the whole frame of a second body, which is simulated without volume preservation.
const UNCORRECTED: usize = 4;

pub(crate) fn bench(bench: &mut Bench) {
    bench.section("frame: 1,000 lattice vertices, w = 2, mesh of 60,002 vertices, two threads");
    let measures = [
        (VolumeMeasure::Lattice, Some(AtMost(0.30))),
        (VolumeMeasure::Cells, None),
        (VolumeMeasure::Mesh, Some(AtMost(0.45))),
    ];
    for (measure, target) in measures {
        let simulations = || {
            let options = [Preservation::By(measure), Preservation::Off];
            options.map(|volume| DisplayedStatue::new(volume.into(), LATTICE_VERTICES, SkinKind::Linear))
        };
        let frames = |[corrected, uncorrected]: &mut [DisplayedStatue; 2], n| {
            let [frame, step, correction, update] = corrected.frames(n);
            [frame, step, correction, update, uncorrected.frames(n)[FRAME]]
        };
        let samples = bench.measure(["frame", measure.name()], Sampling::Many, simulations, frames);
        let Some(samples) = samples else { continue };
        let times: [f64; 5] = std::array::from_fn(|index| samples.seconds(index) * 1e3);
        let comparison = format!("without correction: {:.3} ms", times[UNCORRECTED]);
        let case = format!("step, correction `{measure}`, mesh update with normals");
        bench.row(&case, (times[FRAME], "ms"), target, comparison);
        let percentage = 100.0 * samples.ratio(CORRECTION, FRAME);
        let target = (measure == VolumeMeasure::Lattice).then_some(AtMost(10.0));
        let comparison = format!(
            "step {:.3}, correction {:.3}, mesh update {:.3} ms",
            times[STEP], times[CORRECTION], times[UPDATE]
        );
        bench.row(&format!("share of the correction `{measure}`"), (percentage, "%"), target, comparison);
    }
    smooth(bench);
}

/// Times a frame with a smooth skin relative to a linear skin.
fn smooth(bench: &mut Bench) {
    let simulations = || {
        [SkinKind::Smooth, SkinKind::Linear]
            .map(|skin| DisplayedStatue::new(VolumeOptions::default(), LATTICE_VERTICES, skin))
    };
    let frames = |[smooth, linear]: &mut [DisplayedStatue; 2], n| {
        let ([frame, _, correction, update], [linear, ..]) = (smooth.frames(n), linear.frames(n));
        [frame, linear, correction, update]
    };
    let samples = bench.measure(["frame", "smooth"], Sampling::Many, simulations, frames);
    let Some(samples) = samples else { return };
    let [_, linear, correction, update] = std::array::from_fn(|index| samples.seconds(index) * 1e3);
    let comparison =
        format!("linear: {linear:.3} ms; smooth: correction {correction:.3}, mesh update {update:.3} ms");
    let case = "frame with a smooth skin, relative to a linear skin";
    bench.row(case, (samples.ratio(0, 1), ""), Some(AtMost(1.5)), comparison);
}

impl DisplayedStatue {
    /// Builds the simulation of a deformed statue on two threads.
    pub(crate) fn new(volume: VolumeOptions, lattice_vertices: usize, skin: SkinKind) -> Self {
        let body = Body::builder(Statue::of_quads(QUADS).mesh())
            .material(Material::fast_lsm())
            .lattice_vertices(lattice_vertices)
            .skin(skin);
        let mut body = body.volume(volume).build().expect("the mesh and the body options are valid");
        deform(&mut body);
        let count = body.mesh().map_or(0, |mesh| mesh.vertices().len());
        let start = body.snapshot();
        let simulation = Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).threads(2);
        Self {
            display: Display::new(),
            start,
            simulation: simulation.build().expect("the simulation parameters are valid"),
            positions: vec![[0.0; 3]; count],
            normals: vec![[0.0; 3]; count],
        }
    }

    /// Runs `count` frames of one step each, from the start: later, cells of an undamped body are crushed, and frames in
    /// which cells are untangled take longer. Returns the total times of the frames, of the steps, of the corrections and
    /// of the mesh updates.
    pub(crate) fn frames(&mut self, count: u64) -> [Duration; 4] {
        self.simulation.body_mut(0).restore(&self.start).expect("the snapshot is of this body");
        let [mut step, mut correction, mut update] = [Duration::ZERO; 3];
        let frame = timed(|| {
            for _ in 0..count {
                step += steps(&mut self.simulation, 1);
                let mut evaluated = self.display.evaluate(self.simulation.body(0));
                evaluated.surface_into(&mut self.positions, Some(&mut self.normals));
                correction += evaluated.times().volume;
                update += evaluated.times().mesh_update;
            }
        });
        [frame, step, correction, update]
    }
}
