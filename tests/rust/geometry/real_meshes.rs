//! Meshes as they come from scans, modelling programs and games: concave faces, openings, repeated faces, seams.

use nalgebra::{Point3, Vector3};
use supple::{Body, Interior, Mesh};
use supple_tests::{Random, ball, grid_box, mesh_of, plain_box, unit_cube};

/// Returns the mass of a body at a density of 1000.
fn mass(mesh: &Mesh, lattice_vertices: usize) -> f64 {
    Body::builder(mesh.clone()).lattice_vertices(lattice_vertices).density(1000.0).build().unwrap().mass()
}

/// Returns the part of a mesh whose faces are kept.
fn part(mesh: &Mesh, keep: impl Fn(usize, Point3<f64>) -> bool) -> Mesh {
    let center = |face: &[u32]| {
        let sum: Vector3<f64> = face.iter().map(|&v| mesh.vertices()[v as usize].coords).sum();
        Point3::from(sum / face.len() as f64)
    };
    let faces: Vec<_> =
        mesh.faces().enumerate().filter(|(n, face)| keep(*n, center(face))).map(|(_, face)| face).collect();
    Mesh::new(mesh.vertices().iter().map(|&v| v.into()).collect(), &faces).unwrap()
}

/// Returns a sheet of n by n quads over the unit square, at the height of each point.
fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let at = |k: u32| f64::from(k) / f64::from(n);
    let points = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
    let vertices = points.map(|(i, j)| [at(i), at(j), height(at(i), at(j))]).collect();
    let quads = (0..n).flat_map(|i| (0..n).map(move |j| i * (n + 1) + j));
    (vertices, quads.map(|a| vec![a, a + n + 1, a + n + 2, a + 1]).collect())
}

/// Adds the back of each face.
fn two_sided((vertices, mut faces): (Vec<[f64; 3]>, Vec<Vec<u32>>)) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let backs: Vec<Vec<u32>> = faces.iter().map(|face| face.iter().rev().copied().collect()).collect();
    faces.extend(backs);
    (vertices, faces)
}

/// A U of width 3, height 3 and depth 1 with a slot of 1 by 2, with one face in front and one behind, each from the corner
/// with the given number.
fn letter_u(first: usize) -> Mesh {
    let outline = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
    let vertices: Vec<[f64; 3]> =
        [0.0, 1.0].into_iter().flat_map(|z| outline.map(|[x, y]| [x, y, z])).collect();
    let sides = (0..8).map(|k| vec![k, (k + 1) % 8, (k + 1) % 8 + 8, k + 8]);
    let corner = |k: usize| ((first + k) % 8) as u32;
    let front: Vec<u32> = (0..8).map(|k| corner(k) + 8).collect();
    let back: Vec<u32> = (0..8).rev().map(corner).collect();
    Mesh::new(vertices, &sides.chain([front, back]).collect::<Vec<_>>()).unwrap()
}

#[test]
fn cells_volume_and_area_of_concave_faces_are_those_of_the_shape() {
    for first in 0..8 {
        let mesh = letter_u(first);
        assert!(mesh.is_closed());
        assert!((mesh.volume() - 7.0).abs() < 1e-12, "from corner {first}: {}", mesh.volume());
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| mesh.vertices()[v as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0
        };
        let total: f64 = mesh.triangles().iter().map(area).sum();
        assert!((total - (14.0 + 16.0)).abs() < 1e-12, "from corner {first}: {total}");
        let body = Body::builder(mesh).cell_size(0.2).build().unwrap();
        assert_eq!(body.lattice().cells().len(), 7 * 5 * 5 * 5, "from corner {first}");
    }
}

#[test]
fn a_hole_in_a_ball_changes_its_mass_by_less_than_three_percent_at_any_resolution() {
    let closed = ball(0.5);
    let bottom = Point3::new(0.3, -0.2, -0.4);
    let holed = part(&closed, |_, center| (center - bottom).norm() > 0.15);
    let without_one_face = part(&closed, |face, _| face != 7);
    let flipped: Vec<Vec<u32>> = holed.faces().map(|face| face.iter().rev().copied().collect()).collect();
    let inwards = Mesh::new(holed.vertices().iter().map(|&v| v.into()).collect(), &flipped).unwrap();
    assert_eq!(closed.interior(), Interior::Closed);
    for lattice_vertices in [300, 1_000, 5_000, 20_000] {
        let right = mass(&closed, lattice_vertices);
        assert!((right / 523.6 - 1.0).abs() < 0.03, "{lattice_vertices}: {right}");
        for (name, mesh) in [("holed", &holed), ("one face", &without_one_face), ("inwards", &inwards)] {
            assert_eq!(mesh.interior(), Interior::WindingNumber);
            let mass = mass(mesh, lattice_vertices);
            assert!((mass / right - 1.0).abs() < 0.03, "{name}, {lattice_vertices}: {mass} and {right}");
        }
    }
}

#[test]
fn sides_that_are_not_joined_enclose_the_box_together() {
    let (vertices, faces) = grid_box([0.0; 3], [1.0, 2.0, 1.0], [4; 3]);
    // Each side is moved outwards by a thousandth, so that no edges meet.
    let center = Vector3::new(0.5, 1.0, 0.5);
    let sides = vertices.len() / 6;
    let apart = vertices.iter().enumerate().map(|(n, v)| {
        let side = &vertices[n / sides * sides..][..sides];
        let middle: Vector3<f64> =
            side.iter().map(|v| Vector3::from(*v)).sum::<Vector3<f64>>() / sides as f64;
        (Vector3::from(*v) + 1e-3 * (middle - center)).into()
    });
    let mesh = Mesh::new(apart.collect(), &faces).unwrap();
    assert_eq!((mesh.is_closed(), mesh.interior()), (false, Interior::WindingNumber));
    let mass = mass(&mesh, 1000);
    assert!((mass / 2000.0 - 1.0).abs() < 0.03, "{mass}");
}

#[test]
fn sheets_stay_sheets() {
    let flat = sheet(12, |_, _| 0.0);
    let wavy = sheet(24, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos());
    let bent = sheet(24, |x, y| 0.4 * (1.0 - (2.0 * x - 1.0).powi(2)) + 0.1 * y);
    let half_ball = part(&ball(0.5), |_, center| center.z > 0.1);
    for (name, mesh) in [
        ("flat", mesh_of(flat.clone())),
        ("wavy", mesh_of(wavy.clone())),
        ("bent", mesh_of(bent.clone())),
        ("flat, two-sided", mesh_of(two_sided(flat))),
        ("wavy, two-sided", mesh_of(two_sided(wavy))),
        ("bent, two-sided", mesh_of(two_sided(bent))),
        ("half of a ball", half_ball),
    ] {
        assert_eq!(mesh.interior(), Interior::Sheet, "{name}");
        let body = Body::builder(mesh).lattice_vertices(2000).density(1000.0).build().unwrap();
        let lattice = body.lattice();
        let full = 1000.0 * lattice.cell_size().powi(3) * lattice.cells().len() as f64;
        assert!((body.mass() / full - 1.0).abs() < 1e-6, "{name}");
        // The size from which a default stiffness follows is that of the sheet, and not the root of a volume of nearly 0.
        let simulation = supple::Simulation::builder().body(body).build().unwrap();
        let modulus = simulation.body(0).youngs_modulus().unwrap();
        assert!(modulus > 1e3, "{name}: {modulus}");
    }
}

#[test]
fn faces_that_are_there_twice_count_once() {
    let (vertices, faces) = grid_box([0.0; 3], [1.0; 3], [2; 3]);
    let twice = (vertices.clone(), [faces.clone(), faces.clone()].concat());
    // Front and back one after the other, in either order.
    let alternating = faces.iter().enumerate().flat_map(|(n, face)| {
        let back: Vec<u32> = face.iter().rev().copied().collect();
        if n % 3 == 0 { [back, face.clone()] } else { [face.clone(), back] }
    });
    let alternating = (vertices.clone(), alternating.collect());
    // Half of the faces have backs.
    let some: Vec<_> = faces.iter().step_by(2).map(|face| face.iter().rev().copied().collect()).collect();
    let some = (vertices.clone(), [faces.clone(), some].concat());
    let once = mass(&mesh_of((vertices.clone(), faces.clone())), 300);
    assert!((once - 1000.0).abs() < 40.0, "{once}");
    for (name, mesh) in [
        ("twice", mesh_of(twice)),
        ("two-sided", mesh_of(two_sided((vertices, faces)))),
        ("alternating", mesh_of(alternating)),
        ("some", mesh_of(some)),
    ] {
        assert_eq!((mesh.interior(), mesh.volume()), (Interior::Closed, 1.0), "{name}");
        assert_eq!(mass(&mesh, 300), once, "{name}");
        let body = Body::builder(mesh).lattice_vertices(300).build().unwrap();
        assert_eq!(body.alone().volume_report().measure.name(), "mesh", "{name}");
    }
}

#[test]
fn two_sided_walls_inside_a_body_do_not_open_it() {
    let (mut vertices, mut faces) = unit_cube();
    let side = mesh_of((vertices.clone(), faces.clone()));
    // A wall on four corners of the cube.
    let wall = vec![0, 1, 7, 6];
    faces.extend([wall.clone(), wall.into_iter().rev().collect()]);
    let mesh = mesh_of((vertices.clone(), faces.clone()));
    assert_eq!((mesh.interior(), mesh.volume()), (Interior::Closed, 1.0));
    assert_eq!(mass(&mesh, 200), mass(&side, 200));
    // A two-sided card that hangs on a corner is not a part of the surface either.
    vertices.extend([[2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
    faces.extend([vec![1, 8, 9], vec![9, 8, 1]]);
    let mesh = mesh_of((vertices, faces));
    assert_eq!((mesh.interior(), mesh.volume()), (Interior::Closed, 1.0));
}

#[test]
fn seams_that_differ_by_rounding_are_closed() {
    let (vertices, faces) = grid_box([-0.3; 3], [0.7, 0.4, 0.9], [3; 3]);
    let right = mass(&mesh_of((vertices.clone(), faces.clone())), 500);
    // The coordinates of the sides, computed in another way: they differ in the last digit.
    let moved: Vec<[f64; 3]> = vertices
        .iter()
        .enumerate()
        .map(|(n, v)| v.map(|x| if n % 2 == 0 { x } else { (x * 3.0) / 3.0 + 1e-16 }))
        .collect();
    assert!(moved.iter().zip(&vertices).any(|(a, b)| a != b));
    let mesh = mesh_of((moved, faces.clone()));
    assert!(mesh.is_closed());
    assert_eq!(
        mesh.topology().seam_vertices,
        mesh_of((vertices.clone(), faces.clone())).topology().seam_vertices
    );
    assert!((mass(&mesh, 500) / right - 1.0).abs() < 1e-9);
    // Coordinates in f32 differ in the last digit of f32.
    let moved: Vec<[f64; 3]> = vertices
        .iter()
        .enumerate()
        .map(|(n, v)| v.map(|x| f64::from(x as f32 * if n % 2 == 0 { 1.0 } else { 1.0 + f32::EPSILON })))
        .collect();
    assert!(mesh_of((moved, faces.clone())).is_closed());
    // A gap that can be meant is left open.
    let moved: Vec<[f64; 3]> =
        vertices.iter().enumerate().map(|(n, v)| v.map(|x| if n < 16 { x + 1e-6 } else { x })).collect();
    assert!(!mesh_of((moved, faces)).is_closed());
}

/// Details that are finer than the tolerance of seams: the tops of two boxes, whose faces would count once.
#[test]
fn vertices_near_each_other_do_not_open_a_closed_mesh() {
    let step = 2.0_f64.powi(-22);
    let (mut vertices, mut faces) = plain_box([0.0; 3], [1.0; 3]);
    let (others, boxes) = plain_box([0.0, 0.0, -1.0], [1.0, 1.0, 1.0 + step]);
    let first = vertices.len() as u32;
    vertices.extend(others);
    faces.extend(boxes.into_iter().map(|face| face.into_iter().map(|v| first + v).collect::<Vec<_>>()));
    let mesh = mesh_of((vertices, faces));
    assert!(mesh.is_closed());
    assert!((mesh.volume() - 3.0).abs() < 1e-5, "{}", mesh.volume());
}

/// A cube without one face, twice at the same place with other diagonals: the surface winds around the inside twice.
#[test]
fn an_open_surface_that_lies_there_twice_encloses_its_space() {
    let (vertices, faces) = grid_box([0.0; 3], [1.0; 3], [4, 4, 4]);
    let is_open = |face: &Vec<u32>| {
        face.iter().all(|&v| vertices[v as usize][2] == 1.0 && vertices[v as usize][0] < 0.6)
    };
    let quads: Vec<Vec<u32>> = faces.into_iter().filter(|face| !is_open(face)).collect();
    let split = |first: usize| {
        quads.iter().flat_map(move |quad| {
            let corner = |k: usize| quad[(first + k) % 4];
            [vec![corner(0), corner(1), corner(2)], vec![corner(0), corner(2), corner(3)]]
        })
    };
    let once = mesh_of((vertices.clone(), split(0).collect()));
    let twice = mesh_of((vertices.clone(), split(0).chain(split(1)).collect()));
    assert_eq!((once.interior(), twice.interior()), (Interior::WindingNumber, Interior::WindingNumber));
    let (once, twice) = (mass(&once, 1000), mass(&twice, 1000));
    // Around the inside of the doubled surface the number exceeds 1/2 somewhat farther out of the opening.
    assert!((twice / once - 1.0).abs() < 0.05 && (once - 1000.0).abs() < 60.0, "{once} and {twice}");
}

/// A leaf inside a ball is a sheet, although the ball winds around it.
#[test]
fn a_sheet_inside_a_solid_stays_a_sheet() {
    let ball = ball(2.0);
    let mut vertices: Vec<[f64; 3]> = ball.vertices().iter().map(|&vertex| vertex.into()).collect();
    let mut faces: Vec<Vec<u32>> = ball.faces().map(<[u32]>::to_vec).collect();
    let (leaf, quads) = sheet(6, |x, y| 0.1 * x * y);
    let first = vertices.len() as u32;
    vertices.extend(leaf.into_iter().map(|[x, y, z]| [x - 0.5, y - 0.5, z]));
    faces.extend(quads.into_iter().map(|face| face.into_iter().map(|v| first + v).collect::<Vec<_>>()));
    let both = mass(&mesh_of((vertices, faces)), 1000);
    let alone = mass(&ball, 1000);
    assert!((both / alone - 1.0).abs() < 0.03, "{both} and {alone}");
}

/// Five thousand triangles across the whole mesh enclose nothing, so that the time of a lattice stays bounded.
#[test]
fn a_soup_of_large_triangles_is_a_sheet() {
    let mut random = Random(5);
    let vertices: Vec<[f64; 3]> = (0..15_000).map(|_| random.vector().into()).collect();
    let faces: Vec<Vec<u32>> = (0..5_000).map(|k| vec![3 * k, 3 * k + 1, 3 * k + 2]).collect();
    assert_eq!(mesh_of((vertices, faces)).interior(), Interior::Sheet);
}
