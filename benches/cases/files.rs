//! Times reading a large OBJ file, and simulating and writing frames.

use std::path::Path;
use std::time::{Duration, Instant};

use supple_benches::Target::AtLeast;
use supple_benches::bodies::Statue;
use supple_io::frames::Format;
use supple_io::run::{Job, Observer};
use supple_io::scene::Scene;
use tempfile::TempDir;

use crate::build;
use crate::frame::{LATTICE_VERTICES, QUADS};
use crate::measure::{Bench, Sampling, timed};

pub(crate) fn bench(bench: &mut Bench) {
    reading(bench);
    writing(bench);
}

/// A temporary directory with the OBJ file of a statue.
struct StatueDirectory {
    directory: TempDir,
    /// Size of the OBJ file.
    bytes: usize,
}

/// Name of the OBJ file of the statue.
const FILE: &str = "statue.obj";

impl StatueDirectory {
    fn with(statue: &Statue) -> Self {
        let directory = tempfile::tempdir().expect("a temporary directory can be created");
        let text = statue.obj();
        std::fs::write(directory.path().join(FILE), &text).expect("the temporary directory is writable");
        Self { directory, bytes: text.len() }
    }

    fn path(&self) -> &Path {
        self.directory.path()
    }
}

fn reading(bench: &mut Bench) {
    bench.section("reading OBJ: 501,128 vertices with normals and texture coordinates, 1,002,252 triangles");
    let mut bytes = 0;
    let directory = || StatueDirectory::with(&Statue::of_triangles(build::QUADS));
    let samples = bench.measure(["files", "read obj"], Sampling::Few, directory, |directory, n| {
        bytes = directory.bytes;
        [timed(|| (0..n).for_each(|_| drop(supple_io::obj::read(directory.path().join(FILE)))))]
    });
    if let Some(samples) = samples {
        let megabytes = bytes as f64 / 1e6;
        let comparison = format!("{megabytes:.1} MB in {:.2} s", samples.seconds(0));
        bench.row("reading", (megabytes / samples.seconds(0), "MB/s"), Some(AtLeast(50.0)), comparison);
    }
}

fn writing(bench: &mut Bench) {
    bench.section(
        "frames: 1,000 lattice vertices, 2 steps, mesh of 60,002 vertices, with correction, two threads",
    );
    for (format, frames, target) in [
        (Format::Obj, 40, Some(AtLeast(40.0))),
        (Format::Ply, 40, None),
        (Format::Pc2, 200, Some(AtLeast(500.0))),
    ] {
        let directory = || StatueDirectory::with(&Statue::of_quads(QUADS));
        let mut written = 0;
        let name = format!("write {frames} frames {format}");
        let samples = bench.measure(["files", &name], Sampling::Few, directory, |directory, n| {
            let time = (0..n).map(|_| run(directory.path(), format, frames)).sum();
            written = bytes_per_frame(directory.path(), format);
            [time]
        });
        if let Some(samples) = samples {
            let seconds = samples.seconds(0) / f64::from(frames);
            let comparison = format!("{:.2} ms and {:.2} MB per frame", seconds * 1e3, written as f64 / 1e6);
            bench.row(
                &format!("{format}, simulated and written"),
                (1.0 / seconds, "frames/s"),
                target,
                comparison,
            );
        }
    }
}

/// Simulates the statue, writes its frames, and returns the time from the first step until the last frame is
/// on disk.
fn run(directory: &Path, format: Format, frames: u32) -> Duration {
    let text = format!(
        "[simulation]\nframes = {}\nsubsteps = 2\nthreads = 2\nsleep = false\n\n[output]\nformat = \"{format}\"\n\n\
         [[body]]\nname = \"statue\"\nmesh = \"{FILE}\"\nlattice_vertices = {LATTICE_VERTICES}\n\
         half_width = 2\nstiffness = 1\ndamping_ratio = 0\nregion_damping_rate = 4.0\nspin = [1, 0, 0]\n\n\
         [[collider]]\nplane = {{ point = [0, -1, 0], normal = [0, 1, 0] }}\n",
        // Frame 0 counts as a frame.
        frames - 1
    );
    let scene = Scene::parse(&text, "bench.toml", directory, &[]).expect("the scene is valid");
    let mut start_time = StartTime(None);
    Job::new(scene, directory.join("frames")).run(&mut start_time).expect("the frames can be written");
    start_time.0.map_or(Duration::ZERO, |start| start.elapsed())
}

/// Records when the first step begins, after the meshes are read and the bodies are built.
struct StartTime(Option<Instant>);

impl Observer for StartTime {
    fn started(&mut self, _: u32, _: u32) {
        self.0 = Some(Instant::now());
    }
}

/// Returns the bytes per frame. For OBJ and PLY this is the size of the first file; for PC2, which stores all
/// frames in one file, it is 12 bytes per vertex.
fn bytes_per_frame(directory: &Path, format: Format) -> u64 {
    let size =
        |name: &str| std::fs::metadata(directory.join("frames").join(name)).map_or(0, |file| file.len());
    match format {
        Format::Pc2 => 12 * (6 * QUADS * QUADS + 2) as u64,
        _ => size(&format!("statue_0000.{format}")),
    }
}
