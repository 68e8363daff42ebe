//! The smooth skin: continuous derivatives, exact affine motions, gaps, crushed lattices, volume, contact.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use supple::internals::Embedding;
use supple::{
    Body, Collider, Display, Lattice, Mesh, Preservation, Preset, Simulation, SkinKind, Substeps, VolumeScope,
};

use supple_tests::{ball, block, block_at, enclosed_volume, lattice, posed};

/// Distance of two points on the two sides of a face of a cell, in cells.
const STEP: f64 = 1.0 / 256.0;

/// A pseudo-random number in [-1, 1].
fn random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// Returns the rest positions of the lattice vertices, in cells, each moved by up to `amount` along each axis.
fn shaken(lattice: &Lattice, amount: f32) -> Vec<[f32; 3]> {
    let mut state = 5;
    let mut positions = posed(lattice, |p| p);
    positions.iter_mut().flatten().for_each(|x| *x += amount * random(&mut state));
    positions
}

/// Interpolates points, given in cells.
fn interpolated(
    lattice: &Lattice,
    points: &[Point3<f64>],
    positions: &[[f32; 3]],
    skin: SkinKind,
) -> Vec<Vector3<f64>> {
    let embedding = Embedding::new(lattice, points);
    let embedding = if skin == SkinKind::Smooth { embedding.smoothed(lattice) } else { embedding };
    let mut out = vec![[f32::NAN; 3]; points.len()];
    embedding.interpolate(positions, &mut out);
    out.into_iter().map(|p| p.map(f64::from).into()).collect()
}

/// Returns the greatest jump of the first derivatives across the faces between the cells of a block, in cells per cell.
fn greatest_jump(lattice: &Lattice, positions: &[[f32; 3]], skin: SkinKind) -> f64 {
    let mut greatest = 0.0_f64;
    let mut state = 11;
    for axis in 0..3 {
        for _ in 0..200 {
            let mut point = Vector3::from_fn(|_, _| 1.5 + 1.4 * f64::from(random(&mut state)));
            point[axis] = if random(&mut state) > 0.0 { 1.0 } else { 2.0 };
            let along = Vector3::from_fn(|a, _| if a == axis { STEP } else { 0.0 });
            // Derivatives by one-sided differences of second order.
            let at = |k: f64| Point3::from(point + along * k);
            let points = [-2.0, -1.0, 0.0, 1.0, 2.0].map(at);
            let [a, b, c, d, e] = *interpolated(lattice, &points, positions, skin) else { panic!() };
            let before = (c * 3.0 - b * 4.0 + a) / (2.0 * STEP);
            let after = (d * 4.0 - c * 3.0 - e) / (2.0 * STEP);
            greatest = greatest.max((after - before).norm());
        }
    }
    greatest
}

#[test]
fn first_derivatives_are_continuous_across_the_faces_of_cells() {
    let lattice = lattice(&block([3, 3, 3]));
    let positions = shaken(&lattice, 0.05);
    // The differences have an error of h²/3 times the third derivative of the cells. It is at most 12 times the greatest
    // change of slope, 4 x 0.05 sqrt(3). Positions of up to 3 cells in f32 add four rounding errors.
    let bend = 4.0 * 0.05 * 3.0_f64.sqrt();
    let bound = 2.0 * STEP * STEP / 3.0 * 12.0 * bend + 16.0 * 3.0 * f64::from(f32::EPSILON) / STEP;
    let jump = greatest_jump(&lattice, &positions, SkinKind::Smooth);
    assert!(jump < bound, "{jump} {bound}");
    let linear = greatest_jump(&lattice, &positions, SkinKind::Linear);
    assert!(linear > 0.1, "the linear skin has creases: {linear}");
}

#[test]
fn affine_motions_are_exact_inside_and_outside_the_cells() {
    let cells = [&block([3, 2, 2])[..], &block_at([3, 0, 0], [2, 1, 1]), &[[5, 0, 0]]].concat();
    let lattice = lattice(&cells);
    let stretch = Matrix3::from_diagonal(&Vector3::new(1.7, 0.6, 1.1));
    let turn = Rotation3::new(Vector3::new(0.3, -2.0, 0.8)).matrix() * stretch;
    let motion = |p: Vector3<f64>| turn * p + Vector3::new(4.0, 5.0, -6.0);
    let positions = posed(&lattice, |p| motion(Vector3::from(p.map(f64::from))).map(|x| x as f32).into());
    let mut state = 3;
    let mut point = || Point3::from(Vector3::from_fn(|_, _| 2.0 + 4.0 * f64::from(random(&mut state))));
    let points: Vec<_> = (0..1000).map(|_| point()).collect();
    for (point, found) in points.iter().zip(interpolated(&lattice, &points, &positions, SkinKind::Smooth)) {
        let expected = motion(point.coords);
        // 32 terms of at most 2 x 10 cells.
        let bound = 32.0 * 20.0 * f64::from(f32::EPSILON);
        assert!((found - expected).norm() < bound, "{point}: {found} {expected}");
    }
}

#[test]
fn a_part_across_a_gap_has_no_effect() {
    // Two bars along x, one cell apart, joined at their ends.
    let cells = [&block([6, 1, 1])[..], &block_at([0, 2, 0], [6, 1, 1]), &[[0, 1, 0]]].concat();
    let lattice = lattice(&cells);
    let points = [[3.3, 0.9, 0.4], [4.1, 0.99, 0.7], [5.7, 1.0, 0.5]].map(Point3::from);
    let rest = posed(&lattice, |p| p);
    // The other bar moves, from x = 3 on: its vertices are beside the points, but two links farther than the bars' joint.
    let moved = posed(&lattice, |[x, y, z]| if y >= 2.0 && x >= 3.0 { [x, y + 0.4, z] } else { [x, y, z] });
    let found = [&rest, &moved].map(|positions| interpolated(&lattice, &points, positions, SkinKind::Smooth));
    assert_eq!(found[0], found[1]);
}

/// Returns the least determinant of the derivatives at points of the cells, and the number of points where it is not
/// positive.
fn least_determinant(lattice: &Lattice, positions: &[[f32; 3]], skin: SkinKind) -> (f64, usize) {
    let step = 1.0 / 64.0;
    let mut points = Vec::new();
    for cell in lattice.cells() {
        for k in 0..64 {
            let local = [k & 3, k >> 2 & 3, k >> 4 & 3].map(|i| (f64::from(i) + 0.5) / 4.0);
            let point = Vector3::from_fn(|a, _| f64::from(cell[a]) + local[a]);
            points.push(Point3::from(point));
            points.extend((0..3).map(|axis| Point3::from(point + Vector3::ith(axis, step))));
        }
    }
    let found = interpolated(lattice, &points, positions, skin);
    let determinant =
        |p: &[Vector3<f64>]| (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0])) / step.powi(3);
    let determinants: Vec<f64> = found.chunks(4).map(determinant).collect();
    let least = determinants.iter().copied().fold(f64::INFINITY, f64::min);
    (least, determinants.iter().filter(|d| **d <= 0.0).count())
}

#[test]
fn a_crushed_lattice_folds_the_smooth_skin_no_more_than_the_linear_skin() {
    let lattice = lattice(&block([6, 6, 6]));
    for amount in [0.1, 0.2, 0.3, 0.5, 1.0] {
        let positions = shaken(&lattice, amount);
        let (least, folded) = least_determinant(&lattice, &positions, SkinKind::Smooth);
        let (linear_least, linear_folded) = least_determinant(&lattice, &positions, SkinKind::Linear);
        assert!(folded <= linear_folded, "{amount}: {folded} {linear_folded}");
        // Where the slope weights are 0 the skin is trilinear, up to the rounding of differences over 1/64 cell.
        assert!(amount < 0.7 || (least - linear_least).abs() < 1e-3, "{amount}: {least} {linear_least}");
    }
    // Layers of alternately 1 and `thin` cells, which slopes by central differences do not show.
    for thin in [0.5, 0.2, 0.05, 0.01] {
        let height =
            |z: f32| z * (1.0 + thin) / 2.0 + if z as i32 % 2 == 1 { (1.0 - thin) / 2.0 } else { 0.0 };
        let positions = posed(&lattice, |[x, y, z]| [x, y, height(z)]);
        let (least, folded) = least_determinant(&lattice, &positions, SkinKind::Smooth);
        assert!(folded == 0 && least > 0.0, "{thin}: {folded}");
    }
}

/// Returns the volume that a mesh encloses with its vertices at `points`.
fn volume(mesh: &Mesh, points: &[Point3<f64>]) -> f64 {
    enclosed_volume(mesh, &points.iter().map(|point| point.coords).collect::<Vec<_>>())
}

/// Asserts that each vertex of the displayed surface is within `tolerance` of its position in the embedding.
fn assert_displays_embedding(body: &Body, tolerance: f64) {
    let mesh = body.mesh().unwrap();
    let embedding = Embedding::new(body.lattice(), mesh.vertices()).smoothed(body.lattice());
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords.map(|x| x as f32).into()).collect();
    let mut expected = vec![[0.0; 3]; embedding.len()];
    embedding.interpolate(&positions, &mut expected);
    for (found, expected) in body.alone().surface().positions.iter().zip(expected) {
        let expected = Point3::from(expected.map(f64::from));
        assert!((found - expected).norm() < tolerance, "{found} {expected}");
    }
}

fn smooth_ball(skin: SkinKind) -> supple::BodyBuilder {
    Body::builder(ball(1.0)).lattice_vertices(600).skin(skin)
}

/// Twists, bends and stretches a body.
fn deform(body: &mut Body, amount: f64) {
    let pose = |p: &Point3<f64>| {
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), amount * p.y);
        turn * Point3::new(p.x + 0.2 * amount * p.y * p.y, p.y * (1.0 + 0.5 * amount), p.z)
    };
    let positions: Vec<_> = body.positions().iter().map(pose).collect();
    body.set_positions(&positions).unwrap();
}

#[test]
fn the_displayed_mesh_is_that_of_the_embedding_and_keeps_its_volume() {
    for (amount, scope) in
        [(0.3, VolumeScope::Global), (1.0, VolumeScope::Global), (1.0, VolumeScope::Regional)]
    {
        let options = supple::VolumeOptions { scope, ..Preservation::By(supple::VolumeMeasure::Mesh).into() };
        let mut body = smooth_ball(SkinKind::Smooth).volume(options).build().unwrap();
        assert_eq!(body.skin(), SkinKind::Smooth);
        let rest = volume(body.mesh().unwrap(), body.mesh().unwrap().vertices());
        deform(&mut body, amount);
        let surface = body.alone().surface();
        let mesh = body.mesh().unwrap();
        let kept = volume(mesh, &surface.positions) / rest - 1.0;
        assert!(kept.abs() < 1e-6, "{amount}: {kept:e}");
        let report = body.alone().volume_report();
        assert!((report.after / rest - 1.0).abs() < 1e-6, "{report:?}");

        let mut body = smooth_ball(SkinKind::Smooth).volume(supple::VolumeOptions::off()).build().unwrap();
        deform(&mut body, amount);
        assert_displays_embedding(&body, 1e-5);
    }
}

/// The volume correction computes the surface together with the volume, and the display does not interpolate it again.
#[test]
fn the_displayed_mesh_is_that_of_the_corrected_lattice() {
    // Two balls, so that the lattice has two components. An unused vertex is several cells outside.
    let (mut vertices, mut faces) = supple_tests::sphere([0.0; 3], 1.0, 12);
    let (others, other_faces) = supple_tests::sphere([3.0, 0.2, 0.1], 0.8, 12);
    let first = vertices.len() as u32;
    vertices.extend(others);
    faces.extend(other_faces.into_iter().map(|face| face.into_iter().map(|v| first + v).collect()));
    vertices.push([0.3, 2.0, 0.1]);
    let mesh = Mesh::new(vertices, &faces).unwrap();
    for scope in [VolumeScope::Global, VolumeScope::Regional] {
        let options = supple::VolumeOptions { scope, ..Preservation::By(supple::VolumeMeasure::Mesh).into() };
        let body = Body::builder(mesh.clone()).lattice_vertices(900).skin(SkinKind::Smooth);
        let body = body.join(false).volume(options);
        let mut body = body.build().unwrap();
        let middle =
            body.positions().iter().map(|p| p.coords).sum::<Vector3<f64>>() / body.lattice().len() as f64;
        let stretched: Vec<_> =
            body.positions().iter().map(|p| middle + (p - Point3::from(middle)) * 1.1).collect();
        let stretched: Vec<_> = stretched.into_iter().map(Point3::from).collect();
        body.set_positions(&stretched).unwrap();
        let lowest = body.alone().surface().positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        let cell = body.lattice().cell_size();
        // The surface rises from the floor where the body shrinks, and the floor limits the vertices below.
        let floor = Collider::cuboid([0.0, lowest + 0.05 * cell - 1.0, 0.0], [9.0, 1.0, 9.0], [0.0; 3]);
        let sim = Simulation::builder().body(body).collider(floor).build().unwrap();
        let mut display = Display::new();
        let mut displayed = display.evaluate(sim.body(0));
        let lattice: Vec<_> = displayed.positions().map(|p| p.coords.map(|x| x as f32).into()).collect();
        let surface = displayed.surface();
        assert!(
            displayed.corrections().iter().all(|report| report.lambda != 0.0 && report.residual.abs() < 1e-6)
        );
        let lattice_of = sim.body(0).lattice();
        let embedding = Embedding::new(lattice_of, mesh.vertices()).smoothed(lattice_of);
        let mut expected = vec![[0.0; 3]; embedding.len()];
        embedding.interpolate(&lattice, &mut expected);
        for (found, expected) in surface.positions.iter().zip(expected) {
            let expected = Point3::from(expected.map(f64::from));
            // Positions of up to 16 cells in f32, in sums of 32 terms.
            let bound = 32.0 * 16.0 * f64::from(f32::EPSILON) * cell;
            assert!((found - expected).norm() < bound, "{scope:?}: {found} {expected}");
        }
    }
}

#[test]
fn a_smooth_body_rests_with_its_displayed_surface_on_the_floor() {
    for kind in [SkinKind::Linear, SkinKind::Smooth] {
        let body = smooth_ball(kind).preset(Preset::Jelly).translate([0.0, 1.1, 0.0]).build().unwrap();
        let cell = body.lattice().cell_size();
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let mut sim = Simulation::builder()
            .body(body)
            .collider(floor)
            .fps(30.0)
            .substeps(Substeps::Auto)
            .build()
            .unwrap();
        let mut display = Display::new();
        let mut lowest = f64::INFINITY;
        for frame in 0..150 {
            sim.advance(1);
            if frame > 60 {
                let surface = display.evaluate(sim.body(0)).surface();
                lowest = surface.positions.iter().map(|p| p.y).fold(lowest, f64::min);
            }
        }
        // Overlaps of up to 0.01 cells are not pushed out, and while the body sways, a step adds more.
        assert!(lowest > -0.02 * cell, "{kind:?}: {} cells", lowest / cell);
        assert!(lowest < 0.02 * cell, "{kind:?}: {} cells", lowest / cell);
    }
}

#[test]
fn smooth_surfaces_and_steps_have_the_same_bits_for_any_number_of_threads() {
    let run = |threads: usize| {
        let body = Body::builder(ball(1.0)).cell_size(0.08).skin(SkinKind::Smooth).preset(Preset::Jelly);
        let body = body.translate([0.0, 1.0, 0.0]).velocity([1.0, -2.0, 0.0]).build().unwrap();
        assert!(body.lattice().len() > 8_192, "more than two chunks of 4,096 lattice vertices");
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let ball = Collider::sphere([0.5, -0.4, 0.0], 0.5);
        let sim = Simulation::builder().body(body).collider(floor).collider(ball).threads(threads);
        let mut sim = sim.fps(30.0).build().unwrap();
        sim.advance(3);
        (sim.body(0).positions(), sim.body(0).surface())
    };
    let one = run(1);
    for threads in [2, 3] {
        assert!(run(threads) == one, "{threads} threads differ from one");
    }
}

#[test]
fn vertices_that_no_face_uses_follow_their_cell_linearly() {
    let ball = ball(1.0);
    let mut vertices: Vec<[f64; 3]> = ball.vertices().iter().map(|p| (*p).into()).collect();
    // Straight outside along one axis, by several cells.
    vertices.extend([[0.3, 3.0, 0.1], [-2.5, -0.2, 0.1], [0.31, -0.2, 2.2]]);
    let faces: Vec<Vec<u32>> = ball.triangles().iter().map(|triangle| triangle.to_vec()).collect();
    let mesh = Mesh::new(vertices, &faces).unwrap();
    let body = Body::builder(mesh).lattice_vertices(600).skin(SkinKind::Smooth);
    let mut body = body.volume(supple::VolumeOptions::off()).build().unwrap();
    deform(&mut body, 0.5);
    assert_displays_embedding(&body, 2e-5);
    for vertex in body.alone().surface().positions {
        assert!(vertex.coords.norm() < 10.0, "{vertex}");
    }
}

#[test]
fn one_display_evaluates_bodies_with_different_skins_as_new_displays_do() {
    let bodies =
        [(900, SkinKind::Smooth), (300, SkinKind::Smooth), (600, SkinKind::Linear), (900, SkinKind::Smooth)];
    let mut shared = Display::new();
    for (index, (vertices, skin)) in bodies.into_iter().enumerate() {
        let mut body = Body::builder(ball(1.0)).lattice_vertices(vertices).skin(skin).build().unwrap();
        deform(&mut body, 0.4 + 0.3 * index as f64);
        let expected = Display::new().evaluate(&body).surface();
        assert!(shared.evaluate(&body).surface() == expected, "body {index}");
    }
}
