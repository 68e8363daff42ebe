//! Times the work that a run does once per body: building the lattice of a large mesh, the whole body, and
//! the field of the volume correction.

use supple::internals::{Correction, Embedding, Surface};
use supple::{Body, Lattice, LatticeOptions, Material, Mesh, Preservation, Resolution, VolumeMeasure};
use supple_benches::Target::{self, AtMost};
use supple_benches::bodies::Statue;

use crate::measure::{Bench, Samples, Sampling, timed};

/// Quads along each edge of the cube that is mapped to the statue; gives 1,002,252 triangles.
pub(crate) const QUADS: usize = 289;
const LATTICE_VERTICES: usize = 1_000_000;

pub(crate) fn bench(bench: &mut Bench) {
    bench.section("building: mesh of 1,002,252 triangles, 1,000,000 lattice vertices");
    let mesh = || Statue::of_triangles(QUADS).mesh();
    let options =
        LatticeOptions { resolution: Resolution::Vertices(LATTICE_VERTICES), ..LatticeOptions::default() };
    let lattice = |mesh: &Mesh| Lattice::from_mesh(mesh, &options).expect("the lattice options are valid");

    let samples = bench.measure(["build", "lattice"], Sampling::Few, mesh, |mesh, n| {
        [timed(|| (0..n).for_each(|_| drop(lattice(mesh))))]
    });
    row(bench, "lattice with a given number of vertices", samples, Some(AtMost(1.0)));

    let samples = bench.measure(["build", "body"], Sampling::Few, mesh, |mesh, n| {
        let body = || {
            Body::builder(mesh.clone())
                .material(Material::fast_lsm())
                .resolution(options.resolution)
                .volume(Preservation::Off)
                .build()
        };
        [timed(|| (0..n).for_each(|_| drop(body())))]
    });
    row(bench, "the whole body without a correction", samples, None);

    let prepare = || {
        let mesh = mesh();
        let lattice = lattice(&mesh);
        let embedding = Embedding::new(&lattice, mesh.vertices());
        // The topology is cached in the mesh; compute it outside the timing.
        mesh.topology();
        (mesh, lattice, embedding)
    };
    let samples =
        bench.measure(["build", "field"], Sampling::Few, prepare, |(mesh, lattice, embedding), n| {
            let surface = Surface { mesh, embedding };
            let correction = || Correction::new(lattice, Some(surface), &VolumeMeasure::Mesh.into());
            [timed(|| (0..n).for_each(|_| drop(correction())))]
        });
    row(bench, "field and measure of the volume correction", samples, Some(AtMost(1.0)));
}

/// Adds a row if the case was measured.
fn row(bench: &mut Bench, case: &str, samples: Option<Samples<1>>, target: Option<Target>) {
    if let Some(samples) = samples {
        bench.row(case, (samples.seconds(0), "s"), target, "");
    }
}
