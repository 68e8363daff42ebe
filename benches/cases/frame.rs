//! The cost of a frame of a fine mesh on a coarse lattice: step, volume correction, mesh update with normals.

use std::time::Duration;

use supple::{Body, Display, Preservation, Simulation, VolumeMeasure, VolumeOptions};
use supple_benches::Target::AtMost;
use supple_benches::bodies::{Statue, deform};

use crate::measure::{Bench, Sampling, steps, timed};

/// Quads along an edge of the statue's cube: 60,002 mesh vertices.
pub(crate) const QUADS: usize = 100;
pub(crate) const LATTICE_VERTICES: usize = 1000;

/// A simulation with its display and output buffers.
pub(crate) struct Displayed {
    simulation: Simulation,
    display: Display,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

/// Indices of the measured times: the whole frame, its step, its correction, its mesh update.
const FRAME: usize = 0;
pub(crate) const STEP: usize = 1;
pub(crate) const CORRECTION: usize = 2;
const UPDATE: usize = 3;
/// The whole frame of a body without volume preservation.
const PLAIN: usize = 4;

pub(crate) fn bench(bench: &mut Bench) {
    bench.part("frame: 1,000 lattice vertices, w = 2, mesh of 60,002 vertices, two threads");
    let measures = [
        (VolumeMeasure::Lattice, Some(AtMost(0.30))),
        (VolumeMeasure::Cells, None),
        (VolumeMeasure::Mesh, Some(AtMost(0.45))),
    ];
    for (measure, target) in measures {
        let pair = || {
            let preserved = [Preservation::By(measure), Preservation::Off];
            preserved.map(|preserved| Displayed::new(preserved.into(), LATTICE_VERTICES))
        };
        let frames = |[preserved, plain]: &mut [Displayed; 2], n| {
            let [whole, step, correction, update] = preserved.frames(n);
            [whole, step, correction, update, plain.frames(n)[FRAME]]
        };
        let Some(samples) = bench.measure(["frame", measure.name()], Sampling::Many, pair, frames) else {
            continue;
        };
        let times: [f64; 5] = std::array::from_fn(|part| samples.seconds(part) * 1e3);
        let comparison = format!("without correction: {:.3} ms", times[PLAIN]);
        let case = format!("step, correction `{measure}`, mesh update with normals");
        bench.row(&case, (times[FRAME], "ms"), target, comparison);
        let share = 100.0 * samples.ratio(CORRECTION, FRAME);
        let target_share = (measure == VolumeMeasure::Lattice).then_some(AtMost(10.0));
        let parts = format!(
            "step {:.3}, correction {:.3}, mesh update {:.3} ms",
            times[STEP], times[CORRECTION], times[UPDATE]
        );
        bench.row(&format!("share of the correction `{measure}`"), (share, "%"), target_share, parts);
    }
}

impl Displayed {
    pub(crate) fn new(volume: VolumeOptions, lattice_vertices: usize) -> Self {
        let body = Body::builder(Statue::of_quads(QUADS).mesh()).lattice_vertices(lattice_vertices);
        let mut body = body.volume(volume).build().expect("a closed surface is a body");
        deform(&mut body);
        let count = body.mesh().map_or(0, |mesh| mesh.vertices().len());
        let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(2);
        Self {
            display: Display::new(),
            simulation: simulation.build().expect("numbers in range"),
            positions: vec![[0.0; 3]; count],
            normals: vec![[0.0; 3]; count],
        }
    }

    /// Runs `count` frames of one step each. Returns the total times of the frames, steps, corrections and
    /// mesh updates.
    pub(crate) fn frames(&mut self, count: u64) -> [Duration; 4] {
        let mut parts = [Duration::ZERO; 3];
        let whole = timed(|| {
            for _ in 0..count {
                parts[0] += steps(&mut self.simulation, 1);
                let mut evaluated = self.display.evaluate(self.simulation.body(0));
                evaluated.surface_into(&mut self.positions, Some(&mut self.normals));
                parts[1] += evaluated.times().volume;
                parts[2] += evaluated.times().embed;
            }
        });
        [whole, parts[0], parts[1], parts[2]]
    }
}
