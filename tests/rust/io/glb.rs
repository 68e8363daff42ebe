//! GLB files: played back, the motion is that of the frames of other formats within the error that was asked; they resume
//! to the same bytes; materials, images and texture coordinates are those of the model.

use std::fs;
use std::path::Path;
use std::time::Duration;

use gltf::animation::Interpolation;
use gltf::animation::util::ReadOutputs;
use gltf::{Gltf, Primitive};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use supple_io::obj::Document;
use supple_io::run::{Job, Note, Observer, Outcome, Recording, RecordingOptions, RunReport};
use supple_io::scene::Scene;

use crate::run_files::{CopyAfter, StopAfter, written};

/// A bar whose ends turn against each other, and a cube that falls.
const SCENE: &str = r#"
[simulation]
frames = 40
fps = 24
substeps = 4

[[body]]
name = "bar"
mesh = "bar.obj"
translate = [0, 3, 0]
lattice_vertices = 200

[[body.handle]]
plane = { point = [0, 3.2, 0], normal = [0, 1, 0] }
keys = [{ time = 0 }, { time = 1, rotate = [0, 90, 30], translate = [0.5, 0.3, 0] }]

[[body]]
name = "cube"
mesh = "cube.obj"
rotate = [30, 20, 0]
translate = [4, 1.5, 0]

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

/// A box with a grid on its sides, as OBJ.
fn grid_obj(half: [f64; 3], counts: [u32; 3]) -> String {
    let (vertices, faces) = supple_tests::grid_box(half.map(|x| -x), half, counts);
    let vertices = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let face = |face: &Vec<u32>| {
        let corners: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        format!("f {}\n", corners.join(" "))
    };
    vertices.chain(faces.iter().map(face)).collect()
}

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    fs::write(folder.join("bar.obj"), grid_obj([0.3, 1.0, 0.3], [2, 8, 2])).unwrap();
    fs::write(folder.join("cube.obj"), grid_obj([0.5; 3], [3, 3, 3])).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let mut job = Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join(out));
    // The name of the run is in the file.
    job.scene_file = Some(folder.join("scene.toml"));
    job
}

/// A file, and its binary chunk.
pub(crate) struct File {
    pub(crate) gltf: Gltf,
    bytes: Vec<u8>,
}

/// A node that is played back.
pub(crate) struct Played {
    /// Number of morph targets.
    targets: usize,
    times: Vec<f32>,
    /// Positions of the vertices in each frame.
    pub(crate) frames: Vec<Vec<Vector3<f64>>>,
    /// Lengths of the normals of the frames, before they are normalized, and the normals.
    pub(crate) normals: Vec<Vec<Vector3<f64>>>,
    /// Whether the scale of each frame is 1, and not 0.
    pub(crate) is_shown: Vec<bool>,
}

impl File {
    pub(crate) fn read(path: &Path) -> Self {
        let gltf = Gltf::from_slice(&fs::read(path).unwrap()).unwrap();
        let bytes = gltf.blob.clone().unwrap();
        Self { gltf, bytes }
    }

    fn primitive(&self, node: &str) -> Primitive<'_> {
        let mut nodes = self.gltf.nodes();
        let node = nodes.find(|found| found.name() == Some(node)).unwrap();
        node.mesh().unwrap().primitives().next().unwrap()
    }

    /// Plays a node: base, targets and weights, then rotation and translation.
    pub(crate) fn play(&self, name: &str) -> Played {
        let wide = |x: [f32; 3]| Vector3::from(x.map(f64::from));
        let buffer = |_| Some(&self.bytes[..]);
        let node = self.gltf.nodes().find(|node| node.name() == Some(name)).unwrap();
        let primitive = self.primitive(name);
        let reader = primitive.reader(buffer);
        let base: Vec<_> = reader.read_positions().unwrap().map(wide).collect();
        let normals: Vec<_> = reader.read_normals().unwrap().map(wide).collect();
        let targets: Vec<[Vec<Vector3<f64>>; 2]> = reader
            .read_morph_targets()
            .map(|(positions, normals, _)| {
                [positions.unwrap().map(wide).collect(), normals.unwrap().map(wide).collect()]
            })
            .collect();
        let (mut times, mut rotations, mut translations, mut weights) = (vec![], vec![], vec![], vec![]);
        let mut is_shown = Vec::new();
        let shows = |scale: [f32; 3]| {
            assert!(scale == [0.0; 3] || scale == [1.0; 3], "{scale:?}");
            scale == [1.0; 3]
        };
        for channel in self.gltf.animations().flat_map(|animation| animation.channels()) {
            if channel.target().node().index() != node.index() {
                continue;
            }
            let reader = channel.reader(buffer);
            times = reader.read_inputs().unwrap().collect();
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(found) => translations = found.map(wide).collect(),
                ReadOutputs::Rotations(found) => {
                    rotations = found
                        .into_f32()
                        .map(|x| UnitQuaternion::from_quaternion(Quaternion::from(x.map(f64::from))))
                        .collect();
                }
                ReadOutputs::MorphTargetWeights(found) => weights = found.into_f32().collect(),
                ReadOutputs::Scales(found) => {
                    assert_eq!(channel.sampler().interpolation(), Interpolation::Step);
                    is_shown = found.map(shows).collect();
                }
            }
        }
        // A collider that rests has no channel.
        if times.is_empty() {
            let channel = self.gltf.animations().next().unwrap().channels().next().unwrap();
            times = channel.reader(buffer).read_inputs().unwrap().collect();
        }
        let (translation, rotation, scale) = node.transform().decomposed();
        let rotation = UnitQuaternion::from_quaternion(Quaternion::from(rotation.map(f64::from)));
        translations.resize(times.len(), wide(translation));
        rotations.resize(times.len(), rotation);
        is_shown.resize(times.len(), shows(scale));
        assert_eq!(is_shown[0], shows(scale));
        let (frames, normals_of) = (Vec::new(), Vec::new());
        let mut played = Played { targets: targets.len(), times, frames, normals: normals_of, is_shown };
        for frame in 0..played.times.len() {
            let weights = &weights[frame * targets.len()..(frame + 1) * targets.len()];
            assert!(weights.iter().all(|weight| (0.0..=1.0).contains(weight)));
            let sum = |base: &[Vector3<f64>], kind: usize, vertex: usize| {
                let moved = weights.iter().zip(&targets);
                base[vertex]
                    + moved
                        .map(|(&weight, target)| target[kind][vertex] * f64::from(weight))
                        .sum::<Vector3<f64>>()
            };
            let all = 0..base.len();
            let place = |vertex| rotations[frame] * sum(&base, 0, vertex) + translations[frame];
            played.frames.push(all.clone().map(place).collect());
            played
                .normals
                .push(all.map(|vertex| rotations[frame] * sum(&normals, 1, vertex).normalize()).collect());
        }
        played
    }
}

fn obj_points(path: &Path) -> Vec<Vector3<f64>> {
    let mesh = Document::read(path).unwrap().part(None).unwrap().into_mesh();
    mesh.vertices().iter().map(|vertex| vertex.coords).collect()
}

/// Returns the largest distance of a vertex from its place, and the number of morph targets of the first body.
fn difference(directory: &Path, bodies: &[&str], last: usize) -> (f64, usize) {
    let file = File::read(&directory.join("supple.glb"));
    let (mut largest, targets) = (0.0_f64, file.play(bodies[0]).targets);
    for body in bodies {
        let played = file.play(body);
        assert_eq!(played.frames.len(), last + 1);
        for (frame, positions) in played.frames.iter().enumerate() {
            let expected = obj_points(&directory.join(format!("{body}_{frame:04}.obj")));
            // The meshes have neither normals nor texture coordinates, so that no vertex is split.
            assert_eq!(positions.len(), expected.len());
            let distances = positions.iter().zip(&expected).map(|(a, b)| (a - b).norm());
            largest = largest.max(distances.fold(0.0, f64::max));
        }
    }
    (largest, targets)
}

#[test]
fn the_motion_is_that_of_the_frames_within_the_error_that_is_asked() {
    let folder = tempfile::tempdir().unwrap();
    let mut before = usize::MAX;
    // The largest extents of the bodies are below 2.01.
    for error in [1e-2, 1e-3, 1e-4] {
        let set = format!("output.glb_error={error}");
        let job = job(folder.path(), &format!("out{error}"), &["output.format=[\"obj\", \"glb\"]", &set]);
        let report = job.run(&mut ()).unwrap();
        let (largest, targets) = difference(&job.directory, &["bar", "cube"], 40);
        // Positions of 32 bits have an error of 1e-7 of the coordinates, and the sums of targets a few times that.
        assert!(largest <= 2.01 * error + 5e-6, "{largest} for {error}");
        assert!(targets > 0 && targets < 40, "{targets} targets for {error}");
        assert!(
            before == usize::MAX || targets > before,
            "{targets} targets for {error}, {before} for ten times it"
        );
        before = targets;
        assert_eq!(report.files.len(), 2);
        assert!(report.files[0].contains("supple.glb: body bar: "), "{}", report.files[0]);
    }
}

#[test]
fn with_an_error_of_zero_there_is_a_target_per_frame_and_the_frames_are_exact() {
    let folder = tempfile::tempdir().unwrap();
    let formats = "output.format=[\"obj\", \"glb\"]";
    let job = job(folder.path(), "out", &[formats, "output.glb_error=0", "simulation.frames=6"]);
    job.run(&mut ()).unwrap();
    let (largest, targets) = difference(&job.directory, &["bar", "cube"], 6);
    assert_eq!(targets, 6);
    assert!(largest <= 2e-6, "{largest}");
}

#[test]
fn normals_follow_the_motion_and_times_are_those_of_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "out", &["output.format=[\"ply\", \"glb\"]"]);
    job.every = 4;
    job.start_frame = 1001;
    job.run(&mut ()).unwrap();
    let played = File::read(&job.directory.join("supple.glb")).play("bar");
    let expected: Vec<f32> = (0..11).map(|frame| (f64::from(4 * frame) / 24.0) as f32).collect();
    assert_eq!(played.times, expected);
    for (index, normals) in played.normals.iter().enumerate() {
        let bytes = fs::read(job.directory.join(format!("bar_{}.ply", 1001 + 4 * index))).unwrap();
        let start = bytes.windows(11).position(|text| text == b"end_header\n").unwrap() + 11;
        let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        for (vertex, normal) in normals.iter().enumerate() {
            let at = start + 24 * vertex + 12;
            let expected = Vector3::new(number(at), number(at + 4), number(at + 8)).cast::<f64>();
            // The targets are those of the positions, in which the normals are not linear.
            assert!(
                normal.angle(&expected) < 0.1,
                "frame {index}, vertex {vertex}: {}",
                normal.angle(&expected)
            );
        }
    }
}

#[test]
fn stopped_and_killed_runs_have_the_file_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let format = "output.format=glb";
    let mut whole = job(folder.path(), "whole", &[format, "simulation.frames=12"]);
    whole.checkpoint_interval = Duration::ZERO;
    for frame in [0, 5] {
        let to = at(&format!("killed{frame}"));
        whole.run(&mut CopyAfter { frame, from: at("whole"), to: to.clone() }).unwrap();
        assert!(to.join("supple.glb.pc2.part").exists() && !to.join("supple.glb").exists());
    }
    let expected = written(&at("whole"));
    assert_eq!(expected.keys().collect::<Vec<_>>(), ["supple.glb"]);
    let mut resumed = whole.clone();
    resumed.resume = true.into();
    resumed.verify = true;
    for frame in [0, 5] {
        resumed.directory = at(&format!("killed{frame}"));
        resumed.run(&mut ()).unwrap();
        assert!(written(&resumed.directory) == expected, "killed after frame {frame}");
    }
    // A run that is stopped has a file of its frames so far, and continues.
    let mut stopped = whole.clone();
    stopped.directory = at("stopped");
    stopped.run(&mut StopAfter(7)).unwrap();
    assert_eq!(File::read(&at("stopped/supple.glb")).play("bar").times.len(), 8);
    stopped.resume = true.into();
    stopped.run(&mut ()).unwrap();
    assert!(written(&stopped.directory) == expected);
    let report: RunReport = stopped.run(&mut ()).unwrap();
    assert_eq!(report.outcome, Outcome::AlreadyFinished);

    // A complete file is not continued: the run starts again, and says why. So it does if the file is another one.
    struct Reasons(Vec<String>);
    impl Observer for Reasons {
        fn note(&mut self, note: &Note) {
            if let Note::Restarted { reason } = note {
                self.0.push(reason.clone());
            }
        }
    }
    let mut longer = job(folder.path(), "stopped", &[format, "simulation.frames=14"]);
    longer.resume = true.into();
    let mut reasons = Reasons(Vec::new());
    longer.run(&mut reasons).unwrap();
    assert!(reasons.0.len() == 1 && reasons.0[0].contains("is complete"), "{:?}", reasons.0);
    fs::copy(at("whole/supple.glb"), at("stopped/supple.glb")).unwrap();
    longer.run(&mut reasons).unwrap();
    assert!(reasons.0.len() == 2 && reasons.0[1].contains("has other frames"), "{:?}", reasons.0);
}

#[test]
fn a_run_with_fewer_frames_keeps_the_file_and_the_frames_of_a_longer_one() {
    let folder = tempfile::tempdir().unwrap();
    let formats = "output.format=[\"obj\", \"glb\"]";
    let of = |frames: u32, resume: bool| {
        let mut job = job(folder.path(), "out", &[formats, &format!("simulation.frames={frames}")]);
        job.resume = resume.into();
        job
    };
    of(12, false).run(&mut StopAfter(7)).unwrap();
    let stopped = written(&folder.path().join("out"));
    assert_eq!(of(5, true).run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
    assert!(written(&folder.path().join("out")) == stopped);
    assert_eq!(of(12, true).run(&mut ()).unwrap().resumed_after, Some(7));
    let finished = written(&folder.path().join("out"));
    assert_eq!(of(5, true).run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
    assert!(written(&folder.path().join("out")) == finished);
    // A damaged file is not taken for a whole one.
    fs::write(folder.path().join("out/supple.glb"), &finished["supple.glb"][..1000]).unwrap();
    of(12, true).run(&mut ()).unwrap();
    assert!(written(&folder.path().join("out")) == finished);
    let mut other = job(folder.path(), "out", &[formats, "simulation.frames=12", "output.glb_error=0.1"]);
    other.resume = true.into();
    let error = other.run(&mut ()).unwrap_err().to_string();
    assert!(error.contains("`output.glb_error` of the files changed from 0.001 to 0.1"), "{error}");
}

#[test]
fn long_runs_keep_the_error_too() {
    let folder = tempfile::tempdir().unwrap();
    // More frames than components are combined of at first, and more than one block of points.
    for error in ["0", "1e-5"] {
        let set = [
            "output.format=[\"obj\", \"glb\"]",
            "simulation.frames=420",
            "simulation.fps=100",
            "simulation.substeps=1",
            &format!("output.glb_error={error}"),
        ];
        let job = job(folder.path(), "out", &set);
        job.run(&mut ()).unwrap();
        let (largest, targets) = difference(&job.directory, &["bar", "cube"], 420);
        let tolerance = error.parse::<f64>().unwrap();
        assert!(largest <= 2.01 * tolerance + 1e-5, "{largest} for {error}");
        assert!((targets == 420) == (error == "0"), "{targets}");
    }
}

#[test]
fn materials_images_and_texture_coordinates_are_those_of_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("skin.png"), [0x89, b'P', b'N', b'G', 1, 2, 3]).unwrap();
    fs::write(at("film.tga"), [0; 5]).unwrap();
    let library = "newmtl red\nKd 1 0 0\nd 0.5\nnewmtl skin\nmap_Kd skin.png\nnewmtl film\nmap_Kd film.tga\n";
    fs::write(at("box.mtl"), library).unwrap();
    let text = "mtllib box.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n\
                usemtl red\nf 1/1/1 4/4/1 3/3/1 2/2/1\nf 5/1/2 6/2/2 7/3/2 8/4/2\n\
                usemtl skin\nf 1/1/3 2/2/3 6/3/3 5/4/3\nf 4/1/4 8/4/4 7/3/4 3/2/4\n\
                usemtl film\nf 1/1/5 5/2/5 8/3/5 4/4/5\nf 2/1/6 3/2/6 7/3/6 6/4/6\n";
    fs::write(at("box.obj"), text).unwrap();
    let scene = "[simulation]\nframes = 3\ngravity = [0, 0, -9.81]\n[output]\nformat = [\"obj\", \"glb\"]\n\
                 meters_per_unit = 0.01\n[[body]]\nname = \"box\"\nmesh = \"box.obj\"\nrotate = [0, 30, 0]\n";
    let job = Job::new(Scene::parse(scene, "scene.toml", folder.path(), &[]).unwrap(), at("out"));
    let report = job.run(&mut ()).unwrap();
    assert!(report.files.iter().any(|line| line.contains("film.tga")), "{:?}", report.files);
    let file = File::read(&at("out/supple.glb"));
    let materials: Vec<_> =
        file.gltf.materials().map(|material| material.name().unwrap().to_owned()).collect();
    assert_eq!(materials, ["red", "skin", "film"]);
    let red = file.gltf.materials().next().unwrap();
    assert_eq!(red.pbr_metallic_roughness().base_color_factor(), [1.0, 0.0, 0.0, 0.5]);
    let skin = file.gltf.materials().nth(1).unwrap().pbr_metallic_roughness();
    let texture = skin.base_color_texture().unwrap().texture();
    let gltf::image::Source::View { view, mime_type } = texture.source().unwrap().source() else {
        panic!("a view")
    };
    let image = &file.bytes[view.offset()..view.offset() + view.length()];
    assert_eq!((mime_type, image), ("image/png", &[0x89, b'P', b'N', b'G', 1, 2, 3][..]));
    let primitives: Vec<_> = file.gltf.meshes().next().unwrap().primitives().collect();
    assert_eq!(primitives.len(), 3);
    let reader = primitives[0].reader(|_| Some(&file.bytes[..]));
    // Each corner of a cube has three normals.
    assert_eq!(reader.read_positions().unwrap().len(), 24);
    let coordinates: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(corners.len(), 12);
    // The first corner of the first face has `vt` (0, 0), whose image row is the last one.
    assert_eq!(coordinates[corners[0] as usize], [0.0, 1.0]);
    // z up in the scene, y up in the file; centimeters in the scene.
    let played = file.play("box");
    let frame = obj_points(&at("out/box_0003.obj"));
    let last = &played.frames[3];
    for [x, y, z] in frame.iter().map(|point| <[f64; 3]>::from(*point)) {
        let expected = Vector3::new(x, z, -y) * 0.01;
        let nearest = last.iter().map(|point| (point - expected).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest <= 2e-5, "{nearest}");
    }
    let normals = primitives[0].reader(|_| Some(&file.bytes[..])).read_normals().unwrap();
    assert!(normals.map(Vector3::from).all(|normal| (normal.norm() - 1.0).abs() < 1e-6));
}

#[test]
fn a_material_with_an_image_has_its_color_where_faces_have_no_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("skin.png"), [0x89, b'P', b'N', b'G']).unwrap();
    fs::write(folder.path().join("skin.mtl"), "newmtl skin\nKd 1 0 0\nmap_Kd skin.png\n").unwrap();
    let mut job = job(folder.path(), "out", &["output.format=glb", "simulation.frames=1"]);
    let text = fs::read_to_string(folder.path().join("cube.obj")).unwrap();
    fs::write(folder.path().join("cube.obj"), format!("mtllib skin.mtl\nusemtl skin\n{text}")).unwrap();
    job.every = 1;
    job.run(&mut ()).unwrap();
    let file = File::read(&job.directory.join("supple.glb"));
    let skin = file.gltf.materials().find(|material| material.name() == Some("skin")).unwrap();
    let skin = skin.pbr_metallic_roughness();
    assert!(skin.base_color_texture().is_none() && file.gltf.images().count() == 0);
    assert_eq!(skin.base_color_factor(), [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_recording_has_the_frames_of_a_simulation_and_a_single_frame_is_no_animation() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = supple_tests::mesh_of(supple_tests::unit_cube());
    let body = supple::Body::builder(mesh).name("cube").cell_size(0.5).build().unwrap();
    let mut simulation = supple::Simulation::builder().body(body).build().unwrap();
    let none =
        Recording::create(&folder.path().join("0.glb"), &simulation, &RecordingOptions::default()).unwrap();
    assert!(none.finish().unwrap_err().to_string().contains("it has no frames"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    for frames in [1, 2, 20] {
        let path = folder.path().join(format!("{frames}.glb"));
        let mut recording = Recording::create(&path, &simulation, &RecordingOptions::default()).unwrap();
        for _ in 0..frames {
            recording.write(&simulation).unwrap();
            simulation.step();
        }
        recording.finish().unwrap();
        let names: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert!(names.iter().all(|name| name.to_str().unwrap().ends_with(".glb")), "{names:?}");
        let file = File::read(&path);
        assert_eq!(file.gltf.animations().count(), usize::from(frames > 1));
        assert_eq!(
            file.primitive("cube").reader(|_| Some(&file.bytes[..])).read_positions().unwrap().len(),
            8
        );
        if frames > 1 {
            // A free fall: the node moves, and nothing is left for targets.
            let played = file.play("cube");
            assert_eq!((played.targets, played.times.len()), (0, frames));
        }
    }
}

#[test]
fn a_body_that_can_break_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "out", &["output.format=glb", "body.bar.fracture.strain=0.2"]);
    let error = job.run(&mut ()).unwrap_err();
    assert!(
        error.is_input() && error.to_string().contains("glb has the same faces in all frames"),
        "{error}"
    );
}
