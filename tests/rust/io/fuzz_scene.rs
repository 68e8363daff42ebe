//! Fuzzing of the scene reader: it returns a scene or an error, and a written scene reads back the same.

use std::path::Path;

use crate::fuzz::{Target, fuzz};
use supple_io::scene::Scene;

const WORDS: [&str; 56] = [
    "simulation",
    "output",
    "body",
    "pin",
    "handle",
    "collider",
    "keys",
    "name",
    "mesh",
    "object",
    "scale",
    "rotate",
    "translate",
    "lattice_vertices",
    "cell_size",
    "join",
    "half_width",
    "stiffness_radius",
    "stiffness",
    "poisson_ratio",
    "inflate",
    "{ keys = [{ time = 0, value = 1 }, { time = 1, value = 1.5 }], interpolation = \"smooth\" }",
    "[{ time = 0, value = 0.5 }]",
    "zone",
    "factor",
    "accuracy",
    "frequency",
    "region_damping",
    "region_damping_rate",
    "density",
    "plastic",
    "{ yield = 0.05, creep = 5.0, max = 1.0 }",
    "fracture",
    "{ strain = 0.1, rotation = 20, cracks = 2, noise = 0.1, seed = 1, surface = \"cells\" }",
    "volume",
    "velocity",
    "spin",
    "box",
    "sphere",
    "plane",
    "capsule",
    "center",
    "radius",
    "start",
    "end",
    "friction",
    "thickness",
    "restitution",
    "frames",
    "fps",
    "substeps",
    "gravity",
    "\"auto\"",
    "true",
    "[0, 1, 2]",
    "{ measure = \"mesh\", scope = \"regional\", field = \"paper\", max_correction = 1.0 }",
];

fn read(input: &[u8]) -> String {
    let text = String::from_utf8_lossy(input);
    // The lines after the first `#set` are overrides.
    let (text, overrides) = text.split_once("#set\n").unwrap_or((&text, ""));
    let overrides: Vec<String> = overrides.lines().map(str::to_owned).collect();
    match Scene::parse(text, "scene.toml", Path::new(""), &overrides) {
        Err(error) => error.to_string(),
        Ok(scene) => {
            let written = scene.to_toml();
            let again = Scene::parse(&written, "written.toml", Path::new(""), &[]);
            assert_eq!(again.as_ref().ok(), Some(&scene), "{written}");
            format!(
                "a scene of {} bodies, {} colliders",
                "some ".repeat(scene.bodies.len().min(4)),
                "few ".repeat(scene.colliders.len().min(4))
            )
        }
    }
}

#[test]
fn mutated_scenes_are_read_or_refused_without_panics() {
    let folder = supple_tests::example("");
    let names = ["bust_parts", "drop", "squeeze", "stretch_and_drop", "twist"];
    let mut corpus: Vec<Vec<u8>> = names
        .iter()
        .map(|name| std::fs::read(folder.join(format!("{name}.toml"))).expect("a shipped scene"))
        .collect();
    corpus.push(
        b"[[body]]\nmesh = \"a.obj\"\npoisson_ratio = 0.45\ninflate = 0.75\n[[body.zone]]\nvertices = [0]\nfactor = 2\n\
          inflate = [{ time = 0, value = 1 }, { time = 2, value = 1.5 }]\n"
            .to_vec(),
    );
    corpus.push(b"[[body]]\nmesh = \"a.obj\"\n#set\nbody.a.half_width=3\nsimulation.frames = 60\n".to_vec());
    fuzz(&Target { name: "scene", words: &WORDS, read }, corpus);
}
