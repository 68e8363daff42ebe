//! What a run says about a scene before its first step: names, numbers and ways out; and the scenes in which it says nothing.

use std::fs;
use std::path::Path;

use supple::Interior;
use supple_io::run::{Caution, Prepared, prepare};
use supple_io::scene::Scene;
use supple_tests::{grid_box, sphere};

type Faces = (Vec<[f64; 3]>, Vec<Vec<u32>>);

fn write_obj(path: &Path, (vertices, faces): &Faces) {
    let vertices = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let corner = |corner: &u32| format!(" {}", corner + 1);
    let faces = faces.iter().map(|face| format!("f{}\n", face.iter().map(corner).collect::<String>()));
    fs::write(path, vertices.chain(faces).collect::<String>()).unwrap();
}

/// Prepares a scene with the meshes `ball.obj`, of radius 0.5, and `other.obj`.
fn prepared(text: &str, other: &Faces) -> Prepared {
    let folder = tempfile::tempdir().unwrap();
    write_obj(&folder.path().join("ball.obj"), &sphere([0.0; 3], 0.5, 8));
    write_obj(&folder.path().join("other.obj"), other);
    let scene = Scene::parse(text, "scene.toml", folder.path(), &[]).unwrap();
    prepare(&scene).unwrap()
}

fn cautions(text: &str, other: &Faces) -> Vec<Caution> {
    prepared(text, other).cautions
}

/// A body of the mesh `ball.obj` with more keys.
fn ball(keys: &str) -> String {
    format!("[[body]]\nname = \"ball\"\nmesh = \"ball.obj\"\nlattice_vertices = 200\n{keys}\n")
}

/// A box of edge 1 whose faces are as large as the cells.
fn fine_box(low: [f64; 3]) -> Faces {
    grid_box(low, low.map(|x| x + 1.0), [6; 3])
}

fn joined((mut vertices, mut faces): Faces, (others, other_faces): Faces) -> Faces {
    let first = vertices.len() as u32;
    vertices.extend(others);
    faces.extend(other_faces.into_iter().map(|face| face.into_iter().map(|corner| corner + first).collect()));
    (vertices, faces)
}

#[test]
fn a_scene_in_order_has_no_cautions() {
    let keys = "translate = [0, 2, 0]\n[[body.handle]]\nsphere = { center = [0, 2, 0], radius = 1 }\nstart = 1\n\
                keys = [{ time = 1 }, { time = 2, translate = [1, 0, 0] }]\n[[collider]]\n\
                plane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    assert_eq!(cautions(&ball(keys), &fine_box([0.0; 3])), []);
}

#[test]
fn a_body_that_cannot_carry_itself_is_named_with_the_modulus_that_carries_it() {
    let found = cautions(&ball("youngs_modulus = 3900"), &fine_box([0.0; 3]));
    let [Caution::TooSoft { body, load: None, modulus, needed }] = &found[..] else { panic!("{found:?}") };
    assert_eq!((body.as_str(), *modulus), ("ball", 3900.0));
    // 2 ρ g L, with the height of the lattice.
    assert!((2.0 * 9810.0..2.4 * 9810.0).contains(needed), "{needed}");
    assert_eq!(cautions(&ball(&format!("youngs_modulus = {}", 1.001 * needed)), &fine_box([0.0; 3])), []);
    let weightless = format!("[simulation]\ngravity = [0, 0, 0]\n{}", ball("youngs_modulus = 3900"));
    assert_eq!(cautions(&weightless, &fine_box([0.0; 3])), []);
    let text = found[0].to_string();
    assert!(text.contains("its own weight") && text.contains("`youngs_modulus` of "), "{text}");
}

#[test]
fn a_body_under_a_much_heavier_one_is_named_with_it() {
    let scene = |place: &str| {
        let heavy = format!(
            "[[body]]\nname = \"heavy\"\nmesh = \"other.obj\"\nlattice_vertices = 200\ndensity = 1e5\nyoungs_modulus = 1e8\n\
             translate = {place}\n"
        );
        format!("{}{heavy}", ball("youngs_modulus = 1e6\ndensity = 100"))
    };
    let found = cautions(&scene("[-0.5, 0.6, -0.5]"), &fine_box([0.0; 3]));
    let [Caution::TooSoft { load, .. }] = &found[..] else { panic!("{found:?}") };
    assert_eq!(load.as_deref(), Some("heavy"));
    // Nor does it rest on a body that it does not touch.
    let heavy = scene("[-0.5, 0.6, -0.5]");
    let apart = ["[simulation]\ncontact = false\n".to_owned() + &heavy, heavy + "ignore = [\"ball\"]\n"];
    assert!(apart.iter().all(|scene| cautions(scene, &fine_box([0.0; 3])).is_empty()));
    // Beside the body, or below it, the weight does not rest on it.
    for place in ["[4.0, 0.6, 0.0]", "[-0.5, -1.6, -0.5]"] {
        assert_eq!(cautions(&scene(place), &fine_box([0.0; 3])), [], "{place}");
    }
}

#[test]
fn a_handle_that_starts_after_its_keys_jumps() {
    let handle = |time: f64| {
        ball(&format!(
            "[[body.handle]]\nsphere = {{ center = [0, 0, 0], radius = 1 }}\nstart = 2\n\
             keys = [{{ time = {time} }}, {{ time = {}, translate = [1, 0, 0] }}]",
            time + 0.5
        ))
    };
    let found = cautions(&handle(0.0), &fine_box([0.0; 3]));
    let [Caution::Jump { constraint: 0, time, distance, .. }] = &found[..] else { panic!("{found:?}") };
    assert_eq!((*time, *distance), (2.0, 1.0));
    assert!(found[0].to_string().contains("count from the start of the simulation"), "{}", found[0]);
    assert_eq!(cautions(&handle(2.0), &fine_box([0.0; 3])), []);
}

#[test]
fn objects_far_apart_in_a_file_are_named_with_their_bridge() {
    let scene = "[[body]]\nname = \"two\"\nmesh = \"other.obj\"\nlattice_vertices = 400\n";
    let apart = |distance: f64| joined(fine_box([0.0; 3]), fine_box([1.0 + distance, 0.0, 0.0]));
    let found = cautions(scene, &apart(5.0));
    let [Caution::Bridge { parts: 1, length, .. }] = &found[..] else { panic!("{found:?}") };
    assert!((4.5..5.5).contains(length), "{length}");
    assert_eq!(cautions(scene, &apart(0.3)), []);
}

#[test]
fn faces_much_larger_than_the_cells_are_named() {
    let scene = "[[body]]\nname = \"box\"\nmesh = \"other.obj\"\nlattice_vertices = 1000\n";
    let found = cautions(scene, &grid_box([0.0; 3], [1.0; 3], [1; 3]));
    let [Caution::LargeFaces { edge, cell_size, .. }] = &found[..] else { panic!("{found:?}") };
    assert!((edge - 2.0_f64.sqrt()).abs() < 1e-9 && (0.1..0.13).contains(cell_size), "{edge}, {cell_size}");
    assert_eq!(cautions(scene, &fine_box([0.0; 3])), []);
}

#[test]
fn a_room_holds_its_body_inside_whichever_way_its_faces_point() {
    let (vertices, faces) = grid_box([-2.0; 3], [2.0; 3], [2; 3]);
    let inwards = faces.iter().map(|face| face.iter().rev().copied().collect()).collect();
    for (name, room) in [("outwards", (vertices.clone(), faces)), ("inwards", (vertices, inwards))] {
        let scene = |inside: &str| {
            let keys = format!("velocity = [3, 0, 1]\n[[collider]]\nmesh = \"other.obj\"\n{inside}");
            format!("[simulation]\nframes = 60\n{}", ball(&keys))
        };
        let found = cautions(&scene(""), &room);
        assert!(matches!(found[..], [Caution::InCollider { collider: 0, .. }]), "{name}: {found:?}");
        assert!(found[0].to_string().contains("`inside = true`"), "{}", found[0]);

        let Prepared { mut simulation, cautions, substeps, .. } = prepared(&scene("inside = true"), &room);
        assert_eq!(cautions, [], "{name}");
        for _ in 0..60 * substeps {
            simulation.step();
            let depth = 0.1 * simulation.bodies()[0].lattice().cell_size();
            for position in simulation.body(0).surface().positions {
                assert!(position.coords.amax() < 2.0 + depth, "{name}: {position}");
            }
        }
        // It fell to the floor.
        assert!(simulation.bodies()[0].center_of_mass().y < -1.0, "{name}");
    }
    // An open mesh holds bodies on either side anyway.
    let (vertices, faces) = grid_box([-2.0; 3], [2.0; 3], [1; 3]);
    let folder = tempfile::tempdir().unwrap();
    write_obj(&folder.path().join("ball.obj"), &sphere([0.0; 3], 0.5, 8));
    write_obj(&folder.path().join("other.obj"), &(vertices, faces[1..].to_vec()));
    let text = ball("[[collider]]\nmesh = \"other.obj\"\ninside = true");
    let error =
        prepare(&Scene::parse(&text, "scene.toml", folder.path(), &[]).unwrap()).unwrap_err().to_string();
    assert!(error.contains("collider.0.inside") && error.contains("4 edges of this one are open"), "{error}");
}

#[test]
fn a_surface_with_openings_says_how_its_inside_is_found() {
    let scene = "[[body]]\nname = \"scan\"\nmesh = \"other.obj\"\nlattice_vertices = 500\n";
    let (vertices, mut faces) = sphere([0.0; 3], 0.5, 12);
    faces.drain(0..4);
    let found = cautions(scene, &(vertices.clone(), faces.clone()));
    let [Caution::NotClosed { interior: Interior::WindingNumber, mass, .. }] = &found[..] else {
        panic!("{found:?}")
    };
    assert!((mass / 523.6 - 1.0).abs() < 0.03, "{mass}");
    assert!(!found[0].is_warning());
    // Half of the sphere is a sheet.
    faces.retain(|face| face.iter().all(|&corner| vertices[corner as usize][2] >= -1e-9));
    let found = cautions(scene, &(vertices, faces));
    assert!(matches!(found[..], [Caution::NotClosed { interior: Interior::Sheet, .. }]), "{found:?}");
}

#[test]
fn positions_far_from_the_origin_keep_their_shape_where_the_scene_brings_them_back() {
    // Coordinates of a map, in a file with six decimals.
    let offset = [512_345.0, 100.0, 5_412_345.0];
    let (vertices, faces) = sphere([0.0; 3], 0.5, 8);
    let far: Vec<[f64; 3]> =
        vertices.iter().map(|p| std::array::from_fn(|a| ((p[a] + offset[a]) * 1e6).round() / 1e6)).collect();
    let back = "[[body]]\nname = \"far\"\nmesh = \"other.obj\"\nlattice_vertices = 500\ntranslate = [-512345, -100, -5412345]\n";
    let prepared = prepared(back, &(far.clone(), faces.clone()));
    assert_eq!(prepared.cautions, []);
    let surface = prepared.simulation.body(0).surface();
    for position in &surface.positions {
        assert!((position.coords.norm() - 0.5).abs() < 2e-6, "{position}");
    }
    // Where it stays, the run says that its frames lose the shape.
    let stays = "[[body]]\nname = \"far\"\nmesh = \"other.obj\"\nlattice_vertices = 500\n";
    let found = cautions(stays, &(far, faces));
    let [Caution::CoarseNumbers { spacing, .. }] = &found[..] else { panic!("{found:?}") };
    assert_eq!(*spacing, 0.5);
}
