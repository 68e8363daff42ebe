//! Times the volume correction with each measure and scope, and a step for comparison. Also times the
//! construction of a correction with each field.

use supple::internals::{Correction, Embedding, Surface};
use supple::{
    FieldKind, Lattice, LatticeOptions, Preservation, Resolution, SkinKind, VolumeMeasure, VolumeOptions,
    VolumeScope,
};
use supple_benches::Target::AtMost;
use supple_benches::bodies::Statue;

use crate::frame::{CORRECTION, DisplayedStatue, QUADS, STEP};
use crate::measure::{Bench, Sampling, timed};

const LATTICE_VERTICES: [usize; 2] = [1000, 100_000];

pub(crate) fn bench(bench: &mut Bench) {
    for vertices in LATTICE_VERTICES {
        bench.section(&format!(
            "volume correction: {vertices} lattice vertices, mesh of 60,002 vertices, two threads"
        ));
        for measure in [VolumeMeasure::Lattice, VolumeMeasure::Cells, VolumeMeasure::Mesh] {
            scopes(bench, vertices, measure);
        }
        for field in [FieldKind::Paper, FieldKind::Cells, FieldKind::Surface] {
            build_field(bench, vertices, field);
        }
    }
}

/// Measures the correction with both scopes. Its cost does not depend on the field.
fn scopes(bench: &mut Bench, vertices: usize, measure: VolumeMeasure) {
    let simulations = || {
        [VolumeScope::Global, VolumeScope::Regional].map(|scope| {
            let measure = Preservation::By(measure);
            DisplayedStatue::new(
                VolumeOptions { measure, scope, ..VolumeOptions::default() },
                vertices,
                SkinKind::Linear,
            )
        })
    };
    let corrections = |[global, regional]: &mut [DisplayedStatue; 2], n| {
        let (global, regional) = (global.frames(n), regional.frames(n));
        [global[CORRECTION], regional[CORRECTION], global[STEP]]
    };
    let name = format!("{measure} {vertices}");
    let samples = bench.measure(["volume", &name], Sampling::Many, simulations, corrections);
    let Some(samples) = samples else { return };
    let step = format!("step without correction: {:.3} ms", samples.seconds(2) * 1e3);
    bench.row(&format!("`{measure}`, global"), (samples.seconds(0) * 1e3, "ms"), None, step);
    let regional = format!("{:.3} ms", samples.seconds(1) * 1e3);
    let row = format!("`{measure}`, regional against global");
    bench.row(&row, (samples.ratio(1, 0), "times"), Some(AtMost(2.0)), regional);
}

/// Measures the construction of a correction with a field and the measure `mesh`, on one thread. A body
/// constructs its correction when it is built and when its volume options are set.
fn build_field(bench: &mut Bench, vertices: usize, field: FieldKind) {
    let prepare = || {
        let mesh = Statue::of_quads(QUADS).mesh();
        let resolution = Resolution::Vertices(vertices);
        let options = LatticeOptions { resolution, ..LatticeOptions::default() };
        let lattice = Lattice::from_mesh(&mesh, &options).expect("the lattice options are valid");
        let embedding = Embedding::new(&lattice, mesh.vertices());
        // The topology is cached in the mesh; compute it outside the timing.
        mesh.topology();
        (mesh, lattice, embedding)
    };
    let options = VolumeOptions { field, ..VolumeMeasure::Mesh.into() };
    let name = format!("field {} {vertices}", field.name());
    let samples =
        bench.measure(["volume", &name], Sampling::Few, prepare, |(mesh, lattice, embedding), n| {
            let surface = Surface { mesh, embedding };
            [timed(|| (0..n).for_each(|_| drop(Correction::new(lattice, Some(surface), &options))))]
        });
    if let Some(samples) = samples {
        let row = format!("building the correction: field `{}`, measure `mesh`", field.name());
        bench.row(&row, (samples.seconds(0) * 1e3, "ms"), None, "");
    }
}
