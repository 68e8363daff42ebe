//! Drops a model on the ground: reads an OBJ file and writes OBJ frames.
//!
//!     cargo run --release -p supple-io --example 01_drop -- [MODEL.obj [DIR [FRAMES]]]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use supple::{Body, Collider, Display, Simulation, Substeps};
use supple_io::frames::{Format, FrameWriter, Sequence, Source};
use supple_io::obj::Document;

const FPS: u32 = 30;
const SUBSTEPS: u32 = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args_os().skip(1);
    let bust = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes/bust.obj");
    let model = args.next().map_or(bust, PathBuf::from);
    let directory = args.next().map_or_else(|| "frames/01_drop".into(), PathBuf::from);
    let last = args.next().map_or(Ok(90), |frames| frames.to_string_lossy().parse())?;

    // The document keeps all bytes of the file, so that frames differ from the file only in positions and
    // normals.
    let document = Arc::new(Document::read(&model)?);
    let part = document.part(None)?;
    let (low, high) = part.mesh().bounds();
    let ground = low.y - 0.2 * (high.y - low.y);

    let body = Body::builder(part.mesh().clone())
        .lattice_vertices(1000)
        .half_width(2)
        .region_damping_rate(4.0)
        .spin([0.0, 0.0, 1.0])
        .build()?;
    let mut simulation = Simulation::builder()
        .body(body)
        .collider(Collider::plane([0.0, ground, 0.0], [0.0, 1.0, 0.0]))
        .fps(FPS.into())
        .substeps(Substeps::Fixed(SUBSTEPS))
        .build()?;

    let sequence =
        Sequence { directory, name: "model".into(), format: Format::Obj, first: 0, every: 1, last };
    let mut writer = FrameWriter::create(sequence, Source::Document(&document, &part))?;
    let mut display = Display::new();
    let mut points = vec![[0.0; 3]; part.mesh().vertices().len()];
    for frame in 0..=last {
        if frame > 0 {
            simulation.advance(1);
        }
        display.evaluate(simulation.body(0)).surface_into(&mut points, None);
        writer.write(frame, &points, &[])?;
    }
    writer.finish()?;
    Ok(())
}
