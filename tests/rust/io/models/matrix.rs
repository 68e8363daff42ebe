//! Every format of models with every format of frames: the last frame is that of an OBJ model in OBJ frames, within what
//! the format keeps.

use std::fs;
use std::path::Path;

use supple_io::frames::{Format, read_pc2};
use supple_io::obj::Document;
use supple_io::run::Job;
use supple_io::scene::{Scene, Up};

use super::files::Shape;
use crate::{glb, grids, packages, page_reader, vat};

/// Number of the last frame: the body has met the ground.
const LAST: usize = 20;

/// A box with a grid on its sides, of triangles. Each position is one vertex, in the order in which the triangles use them,
/// as those of STL files.
fn shape() -> Shape {
    let (vertices, faces) = supple_tests::grid_box([-0.4, 0.0, -0.2], [0.5, 1.1, 0.3], [2, 3, 1]);
    let vertices = vertices.iter().map(|p| p.map(|x| x as f32)).collect();
    let Shape { vertices, faces } = Shape { vertices, faces }.triangulated();
    let mut order: Vec<u32> = Vec::new();
    let mut renamed = Vec::new();
    for face in &faces {
        let corner = |corner: &u32| {
            let place = vertices[*corner as usize];
            let known = order.iter().position(|known| vertices[*known as usize] == place);
            known.unwrap_or_else(|| {
                order.push(*corner);
                order.len() - 1
            }) as u32
        };
        renamed.push(face.iter().map(corner).collect());
    }
    Shape { vertices: order.iter().map(|&vertex| vertices[vertex as usize]).collect(), faces: renamed }
}

/// Names and contents of the model in every format of models and encoding.
fn inputs(shape: &Shape) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("obj.obj", shape.obj().into_bytes()),
        ("glb.glb", shape.gltf(false).glb()),
        ("gltf.gltf", shape.gltf(false).embedded()),
        ("stl_text.stl", shape.stl_text(&["box"])),
        ("stl_binary.stl", shape.stl_binary("box")),
        ("ply_text.ply", shape.ply("ascii", "float", false)),
        ("ply_little.ply", shape.ply("binary_little_endian", "float", false)),
        ("ply_big.ply", shape.ply("binary_big_endian", "double", false)),
    ]
}

/// A frame that is read back: its positions, and the largest error along each axis that the format allows.
type Frame = (Vec<[f64; 3]>, [f64; 3]);

fn wide(numbers: &[f32]) -> Vec<[f64; 3]> {
    numbers.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect()
}

/// Returns the points of the last frame of a stage with one body and a plane, by the description of its layout.
fn stage_points(stage: &[u8], points: usize) -> Vec<[f64; 3]> {
    let frame = (8 + 12 * points).next_multiple_of(8) + 8 + 24 + 128;
    let start = 96 + LAST * frame;
    assert_eq!(u64::from_le_bytes(stage[start..start + 8].try_into().unwrap()), points as u64);
    let bytes = stage[start + 8..start + 8 + 12 * points].as_chunks::<4>().0;
    wide(&bytes.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect::<Vec<f32>>())
}

/// Reads the last frame of a body in a format; `None` if the format does not have the surface.
fn read(format: Format, directory: &Path, body: &str, points: usize) -> Option<Frame> {
    let at = |extension: &str| directory.join(format!("{body}_{LAST:04}.{extension}"));
    let whole = |name: &str| fs::read(directory.join(name)).unwrap();
    let exact = |positions: Vec<[f64; 3]>| Some((positions, [0.0; 3]));
    match format.name() {
        "obj" => {
            let mesh = Document::read(at("obj")).unwrap().mesh(None).unwrap();
            exact(mesh.vertices().iter().map(|p| p.cast::<f32>().cast::<f64>().into()).collect())
        }
        "ply" => exact(vat::ply(&at("ply")).into_iter().map(|[position, _]| position).collect()),
        "pc2" => {
            let cache = read_pc2(directory.join(format!("{body}.pc2"))).unwrap();
            exact(wide(cache.positions[LAST * points..].as_flattened()))
        }
        "usd" => exact(stage_points(&whole("supple.usd"), points)),
        "usdz" => exact(stage_points(packages::files(&whole("supple.usdz"))[0].1, points)),
        "vtu" => exact(wide(&grids::Grid::read(&at("vtu")).numbers("Points"))),
        "html" => {
            let runs = page_reader::runs(&String::from_utf8(whole("supple.html")).unwrap());
            let set = &runs[0].sets[LAST][0];
            // Half a step, and the rounding of bounds of 32 bits.
            Some((set.positions.clone(), set.step.map(|step| 0.5 * step + 1e-6)))
        }
        "glb" => {
            let played = glb::File::read(&directory.join("supple.glb")).play(body);
            let positions = played.frames[LAST].iter().map(|&p| p.into()).collect();
            // The default of `output.glb_error` for an extent of 1.1, and the rounding of sums of 32 bits.
            Some((positions, [1.1e-3 + 5e-6; 3]))
        }
        "vat" => {
            let textures = vat::Textures::read(directory, body, "png");
            let positions = textures.frame(LAST).into_iter().map(|[position, _]| position).collect();
            Some((positions, textures.tolerance(vat::PNG_ERROR)))
        }
        "lattice" => {
            let strains = grids::Grid::read(&at("lattice.vtu")).numbers("strain");
            assert!(!strains.is_empty() && strains.iter().all(|strain| strain.is_finite()));
            None
        }
        // A format without a reader here.
        _ => None,
    }
}

#[test]
fn every_format_of_models_gives_the_motion_of_the_obj_file_in_every_format_of_frames() {
    let folder = tempfile::tempdir().unwrap();
    let shape = shape();
    let formats: Vec<String> = Format::ALL.map(|format| format!("\"{format}\"")).to_vec();
    let overrides =
        [format!("output.format=[{}]", formats.join(", ")), "body.0.velocity=[1, 2, 0]".to_owned()];
    let mut expected: Option<Vec<[f64; 3]>> = None;
    for (name, bytes) in inputs(&shape) {
        let (body, _) = name.split_once('.').unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
        let mut scene = Scene::open(folder.path().join(name), Up::Y, &overrides).unwrap();
        scene.simulation.frames = LAST as u32;
        let directory = folder.path().join(format!("frames of {name}"));
        Job::new(scene, &directory).run(&mut ()).unwrap();
        let mut compared = 0;
        for format in Format::ALL {
            let Some((found, tolerance)) = read(format, &directory, body, shape.vertices.len()) else {
                continue;
            };
            compared += 1;
            // The first is the OBJ file, in OBJ frames.
            let expected = expected.get_or_insert_with(|| found.clone());
            assert_eq!(found.len(), expected.len(), "{name} to {format}");
            for (vertex, (found, expected)) in found.iter().zip(expected).enumerate() {
                for axis in 0..3 {
                    let error = (found[axis] - expected[axis]).abs();
                    assert!(
                        error <= tolerance[axis],
                        "{name} to {format}, vertex {vertex}, axis {axis}: {error} above {}",
                        tolerance[axis]
                    );
                }
            }
        }
        assert!(compared >= 9, "{compared}");
    }
    // The body was thrown to the side.
    let expected = expected.unwrap();
    let moved = expected.iter().zip(&shape.vertices).map(|(now, rest)| (f64::from(rest[0]) - now[0]).abs());
    assert!(moved.fold(0.0, f64::max) > 0.3);
}
