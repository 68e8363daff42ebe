//! Vertex animation textures: decoded as a player does, the texels give the positions and normals of the frames.

use std::fs;
use std::path::Path;
use std::time::Duration;

use gltf::Gltf;
use supple_io::run::{Job, Outcome};
use supple_io::scene::Scene;
use supple_tests::grid_box;

use crate::run_files::{BLOCK, CopyAfter, StopAfter, written};

const SCENE: &str = r#"
[simulation]
frames = 20
substeps = 4

[output]
format = ["ply", "vat"]

[[body]]
name = "ball"
mesh = "grid.obj"
rotate = [30, 20, 0]
translate = [0, 1.5, 0]

[[body]]
name = "block"
mesh = "block.obj"
translate = [6, 0.2, 0]

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    let (vertices, faces) = grid_box([-0.5; 3], [0.5; 3], [5, 5, 5]);
    let mut text: String = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for face in faces {
        text += &format!(
            "f {}\n",
            face.iter().map(|corner| (corner + 1).to_string()).collect::<Vec<_>>().join(" ")
        );
    }
    fs::write(folder.join("grid.obj"), text).unwrap();
    fs::write(folder.join("block.obj"), BLOCK).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join(out))
}

/// An image with four numbers per texel, in [0, 1].
struct Image {
    width: usize,
    height: usize,
    texels: Vec<[f64; 4]>,
}

impl Image {
    fn read(path: &Path) -> Self {
        if path.extension().is_some_and(|extension| extension == "exr") {
            return Self::read_exr(path);
        }
        let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgba, png::BitDepth::Sixteen));
        let number = |bytes: &[u8]| f64::from(u16::from_be_bytes([bytes[0], bytes[1]])) / 65535.0;
        let texel = |bytes: &[u8; 8]| std::array::from_fn(|k| number(&bytes[2 * k..]));
        let texels = bytes.as_chunks::<8>().0.iter().map(texel).collect();
        Self { width: info.width as usize, height: info.height as usize, texels }
    }

    fn read_exr(path: &Path) -> Self {
        let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
        let channels = &image.layer_data.channel_data.list;
        let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "G", "R"]);
        // Numbers of 32 bits, from the top down.
        let numbers = |channel: usize| match &channels[channel].sample_data {
            exr::prelude::FlatSamples::F32(numbers) => numbers,
            _ => panic!("{} has other numbers", path.display()),
        };
        let [alpha, blue, green, red] = std::array::from_fn(numbers);
        let exr::prelude::Vec2(width, height) = image.layer_data.size;
        let texel = |texel: usize| [red, green, blue, alpha].map(|channel| f64::from(channel[texel]));
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }

    /// Returns the texel at texture coordinates, `frame` rows further down.
    fn at(&self, [u, v]: [f32; 2], frame: usize) -> [f64; 4] {
        let column = (f64::from(u) * self.width as f64) as usize;
        let row = (f64::from(v) * self.height as f64) as usize + frame;
        self.texels[row * self.width + column]
    }
}

/// The textures of a body.
pub(crate) struct Textures {
    first: Vec<[f32; 3]>,
    texels: Vec<[f32; 2]>,
    remap: serde_json::Value,
    offsets: Image,
    normals: Image,
}

impl Textures {
    /// Reads the folder of a body. `encoding`: `png` or `exr`.
    pub(crate) fn read(directory: &Path, body: &str, encoding: &str) -> Self {
        let at = |name: String| directory.join(format!("{body}_vat")).join(name);
        let gltf = Gltf::from_slice(&fs::read(at(format!("{body}.glb"))).unwrap()).unwrap();
        let bytes = gltf.blob.clone().unwrap();
        let primitive = gltf.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&bytes[..]));
        let info: serde_json::Value =
            serde_json::from_slice(&fs::read(at(format!("{body}-remap_info.json"))).unwrap()).unwrap();
        Self {
            first: reader.read_positions().unwrap().collect(),
            texels: reader.read_tex_coords(1).unwrap().into_f32().collect(),
            remap: info["os-remap"].clone(),
            offsets: Image::read(&at(format!("{body}_vat.{encoding}"))),
            normals: Image::read(&at(format!("{body}_vnrm.{encoding}"))),
        }
    }

    /// Returns the least offset along each axis of glTF, and the extent of the offsets.
    fn range(&self) -> [[f64; 3]; 2] {
        let number = |key: &str, axis: usize| self.remap[key][axis].as_f64().unwrap();
        // The axes of Blender, and those of glTF: (x, z, -y).
        let [low, high] = ["Min", "Max"].map(|key| [0, 1, 2].map(|axis| number(key, axis)));
        [[low[0], low[2], -high[1]], [high[0] - low[0], high[2] - low[2], high[1] - low[1]]]
    }

    /// Returns the largest error of a position along each axis: that of a number of the image, `error`, of the extent
    /// of the offsets, and the rounding of positions of 32 bits.
    pub(crate) fn tolerance(&self, error: f64) -> [f64; 3] {
        self.range()[1].map(|extent| error * extent + 2e-6)
    }

    /// Returns the position and the normal of each vertex in a frame.
    pub(crate) fn frame(&self, frame: usize) -> Vec<[[f64; 3]; 2]> {
        let [low, extent] = self.range();
        let vertices = self.first.iter().zip(&self.texels);
        let decoded = vertices.map(|(first, texel)| {
            let turned = |[x, y, z, _]: [f64; 4], flip: f64| [x, z, flip - y];
            let offset = turned(self.offsets.at(*texel, frame), 1.0);
            let normal = turned(self.normals.at(*texel, frame).map(|number| 2.0 * number - 1.0), 0.0);
            let position = |axis| f64::from(first[axis]) + low[axis] + offset[axis] * extent[axis];
            [std::array::from_fn(position), normal]
        });
        decoded.collect()
    }
}

/// Positions and normals of a PLY frame.
pub(crate) fn ply(path: &Path) -> Vec<[[f64; 3]; 2]> {
    let bytes = fs::read(path).unwrap();
    let start = bytes.windows(11).position(|text| text == b"end_header\n").unwrap() + 11;
    let head = std::str::from_utf8(&bytes[..start]).unwrap();
    let count = head.lines().find_map(|line| line.strip_prefix("element vertex ")).unwrap().parse().unwrap();
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let vector = |at: usize| std::array::from_fn(|axis| number(at + 4 * axis));
    (0..count).map(|vertex| [vector(start + 24 * vertex), vector(start + 24 * vertex + 12)]).collect()
}

#[test]
fn texels_give_the_positions_and_normals_of_the_frames() {
    check_texels("png", PNG_ERROR);
}

#[test]
fn texels_with_a_floating_point_give_the_positions_and_normals_of_the_frames() {
    // Two subtractions, a division, and the extent by which the texel is divided are rounded, each by half of 2^-23.
    check_texels("exr", 4.0 * 0.5 * f64::from(f32::EPSILON));
}

/// The largest error of a number of an image of 16 bits: half a step.
pub(crate) const PNG_ERROR: f64 = 0.5 / 65535.0;

/// Compares the texels of a run with its frames. `error`: largest error of a number of the image.
fn check_texels(encoding: &str, error: f64) {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "out", &[&format!("output.vat_encoding={encoding}")]);
    job.run(&mut ()).unwrap();
    for body in ["ball", "block"] {
        let textures = Textures::read(&job.directory, body, encoding);
        assert_eq!(textures.remap["Frames"], 21);
        for frame in 0..21 {
            let expected = ply(&job.directory.join(format!("{body}_{frame:04}.ply")));
            let found = textures.frame(frame);
            assert_eq!(expected.len(), found.len());
            for ([position, normal], [found, found_normal]) in expected.iter().zip(&found) {
                for (axis, tolerance) in textures.tolerance(error).into_iter().enumerate() {
                    let found_error = (found[axis] - position[axis]).abs();
                    assert!(found_error <= tolerance, "{body}, frame {frame}: {found_error} > {tolerance}");
                    // A normal has twice the error of its texel; its length is 1 but for rounding.
                    let found_error = (found_normal[axis] - normal[axis]).abs();
                    assert!(found_error <= 2.0 * error + 4.0 * f64::from(f32::EPSILON), "{found_error}");
                }
            }
        }
    }
}

#[test]
fn stopped_and_killed_runs_have_the_textures_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let files = |directory: &Path| -> Vec<Vec<u8>> {
        let names = ["ball.glb", "ball_vat.png", "ball_vnrm.png", "ball-remap_info.json"];
        names.map(|name| fs::read(directory.join("ball_vat").join(name)).unwrap()).to_vec()
    };
    let mut whole = job(folder.path(), "whole", &["output.format=vat"]);
    whole.checkpoint_interval = Duration::ZERO;
    let (from, to) = (at("whole"), at("killed"));
    whole.run(&mut CopyAfter { frame: 9, from, to: to.clone() }).unwrap();
    let expected = files(&at("whole"));
    let mut resumed = whole.clone();
    (resumed.directory, resumed.resume, resumed.verify) = (to, true.into(), true);
    resumed.run(&mut ()).unwrap();
    assert!(files(&at("killed")) == expected && !at("killed/ball.vat.pc2.part").exists());
    let mut stopped = whole.clone();
    stopped.directory = at("stopped");
    stopped.run(&mut StopAfter(7)).unwrap();
    assert!(files(&stopped.directory) != expected && at("stopped/ball.vat.pc2.part").exists());
    stopped.resume = true.into();
    stopped.run(&mut ()).unwrap();
    assert!(files(&stopped.directory) == expected);
    assert_eq!(stopped.run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
}

#[test]
fn what_cannot_be_written_is_refused_before_the_frames_of_an_earlier_run_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), "out", &["output.format=ply"]).run(&mut ()).unwrap();
    let frames = written(&folder.path().join("out"));
    let refused = |overrides: &[&str]| {
        let error = job(folder.path(), "out", overrides).run(&mut ()).unwrap_err();
        assert!(written(&folder.path().join("out")) == frames);
        error.to_string()
    };
    let error = refused(&["simulation.frames=9000"]);
    assert!(error.contains("in 9001 frames are more texels"), "{error}");
    fs::write(folder.path().join("out/ball_vat"), "a file").unwrap();
    let error = job(folder.path(), "out", &[]).run(&mut ()).unwrap_err().to_string();
    assert!(error.contains("ball_vat"), "{error}");
    assert!(folder.path().join("out/ball_0020.ply").exists());
    fs::remove_file(folder.path().join("out/ball_vat")).unwrap();
    let error = refused(&["output.format=[\"vtu\", \"lattice\"]", "body.1.name=ball.lattice"]);
    assert!(error.contains("two bodies would write") && error.contains("ball.lattice.pvd"), "{error}");
}

#[test]
fn an_input_in_the_folder_of_textures_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let first = job(folder.path(), "out", &["output.format=vat"]);
    first.run(&mut ()).unwrap();
    let mesh = "body.ball.mesh=out/ball_vat/ball.glb";
    let error = job(folder.path(), "out", &["output.format=vat", mesh]).run(&mut ()).unwrap_err();
    assert!(error.is_input() && error.to_string().contains("ball.glb is an input"), "{error}");
    assert!(first.directory.join("ball_vat/ball-remap_info.json").exists());
}

#[test]
fn a_run_whose_textures_are_damaged_starts_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "out", &["output.format=vat", "simulation.frames=3"]);
    job.run(&mut ()).unwrap();
    job.resume = true.into();
    let image = job.directory.join("ball_vat/ball_vat.png");
    let whole = fs::read(&image).unwrap();
    assert_eq!(job.run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
    fs::write(&image, &whole[..whole.len() - 1]).unwrap();
    assert_eq!(job.run(&mut ()).unwrap().outcome, Outcome::Finished);
    fs::remove_file(&image).unwrap();
    assert_eq!(job.run(&mut ()).unwrap().outcome, Outcome::Finished);
    assert!(fs::read(&image).unwrap() == whole);
}

#[test]
fn images_of_another_encoding_are_removed_and_a_change_of_the_encoding_is_no_continuation() {
    let folder = tempfile::tempdir().unwrap();
    let job = |encoding: &str| {
        let encoding = format!("output.vat_encoding={encoding}");
        job(folder.path(), "out", &["output.format=vat", "simulation.frames=3", &encoding])
    };
    let names = || {
        let entries = fs::read_dir(folder.path().join("out/ball_vat")).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    job("png").run(&mut ()).unwrap();
    assert_eq!(names(), ["ball-remap_info.json", "ball.glb", "ball_vat.png", "ball_vnrm.png"]);
    let mut exr = job("exr");
    exr.resume = true.into();
    let error = exr.run(&mut ()).unwrap_err().to_string();
    assert!(error.contains("`output.vat_encoding` of the files changed from png to exr"), "{error}");
    exr.resume = false.into();
    exr.run(&mut ()).unwrap();
    assert_eq!(names(), ["ball-remap_info.json", "ball.glb", "ball_vat.exr", "ball_vnrm.exr"]);
    let manifest = fs::read_to_string(exr.directory.join("manifest.json")).unwrap();
    assert!(manifest.contains("ball_vat/ball_vat.exr") && !manifest.contains(".png"), "{manifest}");
    exr.resume = true.into();
    assert_eq!(exr.run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
    fs::remove_file(exr.directory.join("ball_vat/ball_vnrm.exr")).unwrap();
    assert_eq!(exr.run(&mut ()).unwrap().outcome, Outcome::Finished);
    let error = Scene::parse(SCENE, "scene.toml", folder.path(), &["output.vat_encoding=jpg".to_owned()]);
    let error = error.unwrap_err().to_string();
    assert!(error.contains("vat_encoding") && error.contains("png"), "{error}");
}
