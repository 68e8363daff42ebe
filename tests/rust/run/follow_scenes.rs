//! Handles of scenes that follow an animated mesh: keys, errors, and runs that continue.

use std::path::Path;

use supple_io::run::{Flow, Job, Observer, Outcome, Progress, prepare};
use supple_io::scene::Scene;

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    o inner\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// Returns a point cache of corners that move by 0.1 along x from sample to sample, one every two frames from frame 3 on.
fn cache(corners: &[[f32; 3]], samples: i32) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend(1_i32.to_le_bytes());
    bytes.extend((corners.len() as i32).to_le_bytes());
    bytes.extend([3.0_f32, 2.0].iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend(samples.to_le_bytes());
    for sample in 0..samples {
        for &[x, y, z] in corners {
            bytes.extend([x + 0.1 * sample as f32, y, z].iter().flat_map(|x| x.to_le_bytes()));
        }
    }
    bytes
}

/// Writes the files of a scene, and reads it with these lines in its handle.
fn scene(folder: &Path, body: &str, handle: &str) -> Result<Scene, supple_io::scene::SceneError> {
    std::fs::write(folder.join("cube.obj"), CUBE).unwrap();
    std::fs::write(folder.join("walk.pc2"), cache(&CORNERS, 6)).unwrap();
    std::fs::write(folder.join("seven.pc2"), cache(&CORNERS[..7], 6)).unwrap();
    let text = format!(
        "[simulation]\nframes = 12\nfps = 10\n[[body]]\nname = \"cube\"\nmesh = \"cube.obj\"\n\
         lattice_vertices = 64\n{body}\n[[body.handle]]\n\
         box = {{ min = [-9, 0.9, -9], max = [9, 9, 9] }}\n{handle}\n"
    );
    Scene::parse(&text, "scene.toml", folder, &[])
}

#[test]
fn a_handle_has_the_times_of_the_file_unless_the_scene_states_others() {
    let folder = tempfile::tempdir().unwrap();
    let times = |lines: &str| {
        let scene = scene(folder.path(), "", &format!("follow = \"walk.pc2\"\n{lines}")).unwrap();
        let written = Scene::parse(&scene.to_toml(), "scene.toml", folder.path(), &[]).unwrap();
        assert_eq!(written, scene);
        let simulation = prepare(&scene).unwrap().simulation;
        let (animation, _) = simulation.bodies()[0].constraint(0).unwrap().followed().unwrap();
        assert_eq!((animation.samples(), animation.vertices()), (6, 8));
        [animation.start(), animation.interval()]
    };
    for (lines, expected) in [
        ("", [0.3, 0.2]),
        ("follow_fps = 20", [0.15, 0.1]),
        ("follow_start = -1", [-1.0, 0.2]),
        ("follow_fps = 5\nfollow_start = 0.5\nstart = 0.1\nend = 3", [0.5, 0.4]),
    ] {
        let found = times(lines);
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{lines}: {found:?}");
    }
}

#[test]
fn bodies_share_the_positions_of_a_file_and_paths_are_written_absolute() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = scene(folder.path(), "", "follow = \"walk.pc2\"").unwrap();
    let mut second = scene.bodies[0].clone();
    second.name = "second".to_owned();
    scene.bodies.push(second);
    let simulation = prepare(&scene).unwrap().simulation;
    let [a, b] =
        [0, 1].map(|body| simulation.bodies()[body].constraint(0).unwrap().followed().unwrap().0.positions());
    assert!(std::ptr::eq(a, b));
    let text = scene.relocated(None).unwrap().to_toml();
    let path = std::fs::canonicalize(folder.path()).unwrap().join("walk.pc2");
    assert!(text.contains(&format!("follow = \"{}\"", path.display())), "{text}");
    let handle = "body.cube.handle.0.keys=[{ time = 0 }]".to_owned();
    let replaced = Scene::parse(&text, "scene.toml", Path::new(""), &[handle]).unwrap();
    assert!(replaced.bodies[0].handles[0].follow.is_none(), "an override replaces the animation");
}

#[test]
fn an_object_follows_its_own_vertices_or_those_of_the_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let shifted = |line: &str| {
        let corners = line.split_whitespace().skip(1).map(|corner| corner.parse::<u32>().unwrap() + 1);
        format!("f {}", corners.map(|corner| corner.to_string()).collect::<Vec<_>>().join(" "))
    };
    let lines = CUBE.lines().map(|line| if line.starts_with('f') { shifted(line) } else { line.to_owned() });
    let text = format!("v 9 9 9\n{}\n", lines.collect::<Vec<_>>().join("\n"));
    let of = |file: &str| {
        let scene = scene(folder.path(), "object = \"inner\"", &format!("follow = \"{file}\"")).unwrap();
        std::fs::write(folder.path().join("cube.obj"), &text).unwrap();
        let nine: Vec<[f32; 3]> = std::iter::once([9.0; 3]).chain(CORNERS).collect();
        std::fs::write(folder.path().join("nine.pc2"), cache(&nine, 6)).unwrap();
        let simulation = prepare(&scene).unwrap().simulation;
        simulation.bodies()[0].constraint(0).unwrap().followed().unwrap().0.positions().to_vec()
    };
    assert_eq!(of("nine.pc2"), of("walk.pc2"));
}

#[test]
fn invalid_handles_are_errors_that_name_the_key_and_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    for (lines, words) in [
        ("", "`body.cube.handle.0.keys` is missing"),
        ("keys = [{ time = 0 }]\nfollow = \"walk.pc2\"", "`body.cube.handle.0.follow` and `keys` exclude"),
        ("follow = \"walk.pc2\"\ninterpolation = \"cubic\"", "left out, because only `keys` has it"),
        ("keys = [{ time = 0 }]\nfollow_fps = 3", "left out, because only `follow` has it"),
        ("follow = \"\"", "the path of a PC2 file"),
        ("follow = 3", "`body.cube.handle.0.follow`"),
        ("follow = \"walk.pc2\"\nfollow_fps = 0", "frames per second, > 0"),
        ("follow = \"walk.pc2\"\nfollow_star = 0", "`follow_start`"),
    ] {
        let error = scene(folder.path(), "", lines).unwrap_err().to_string();
        assert!(error.contains(words), "{lines}: {error}");
    }
    for (file, words) in [
        ("missing.pc2", vec!["missing.pc2", "cannot read"]),
        ("seven.pc2", vec!["seven.pc2", "it has 7 vertices, and the mesh has 8; export the animation"]),
        ("cube.obj", vec!["not a PC2 file"]),
    ] {
        let scene = scene(folder.path(), "", &format!("follow = \"{file}\"")).unwrap();
        let error = prepare(&scene).unwrap_err();
        assert!(error.is_input());
        let error = error.to_string();
        assert!(error.contains("body.cube.handle.0.follow"), "{error}");
        assert!(words.iter().all(|words| error.contains(words)), "{error}");
    }
}

/// Stops a job after a frame.
struct Stop(Option<u32>);

impl Observer for Stop {
    fn frame(&mut self, progress: &Progress) -> Flow {
        if self.0 == Some(progress.frame) { Flow::Stop } else { Flow::Continue }
    }
}

#[test]
fn a_run_that_continues_has_the_same_bits_and_refuses_another_animation() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), "material = \"jelly\"", "follow = \"walk.pc2\"\nend = 1.0").unwrap();
    let path = |name: &str| folder.path().join(name);
    let whole = Job::new(scene.clone(), path("whole"));
    whole.run(&mut Stop(None)).unwrap();
    let mut parts = Job::new(scene, path("parts"));
    parts.run(&mut Stop(Some(7))).unwrap();
    parts.resume = true.into();
    std::fs::write(path("walk.pc2"), cache(&CORNERS, 7)).unwrap();
    let error = parts.run(&mut Stop(None)).unwrap_err().to_string();
    assert!(error.contains("the animation file has changed"), "{error}");
    std::fs::write(path("walk.pc2"), cache(&CORNERS, 6)).unwrap();
    let report = parts.run(&mut Stop(None)).unwrap();
    assert_eq!((report.outcome, report.resumed_after), (Outcome::Finished, Some(7)));
    for frame in 0..=12 {
        let [a, b] = ["whole", "parts"]
            .map(|run| std::fs::read(path(run).join(format!("cube_{frame:04}.obj"))).unwrap());
        assert!(a == b, "frame {frame}");
    }
}
