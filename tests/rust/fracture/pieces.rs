//! The pieces of a broken body: their contacts, and their displayed meshes and volumes.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use supple::{
    Body, BreakLimit, Collider, Display, FractureOptions, Handle, Key, Mesh, Preset, Selection, Simulation,
    Substeps, TimeWindow, VolumeMeasure,
};

use crate::cracks::quantities;
use supple_tests::{bust, cuboid, volumes_of_pieces, without_gravity};

/// Pieces fit together where a body was cut, also where the smooth surface of the cut leaves their cells, so that they do not
/// push each other apart.
#[test]
fn pieces_of_a_cut_body_stay_at_rest() {
    for planes in [vec![[0.0, 1.0, 0.0]], vec![[0.3, 1.0, 0.2]], vec![[0.3, 1.0, 0.2], [1.0, 0.1, 0.3]]] {
        let body = Body::builder(cuboid([8; 3])).lattice_vertices(600).build().unwrap();
        let mut simulation = without_gravity(body);
        for normal in &planes {
            assert!(simulation.body_mut(0).cut([4.0; 3], *normal).unwrap() > 30);
        }
        assert!(simulation.body(0).pieces() > 1, "{planes:?}");
        simulation.advance(100);
        assert!(simulation.contacts().len() > 100, "{planes:?}");
        // Rounding of the positions to f32, whose unit is 1e-6 cells, in each of 100 steps of 0.01 s.
        let speed = simulation.body(0).velocities().iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(speed < 1e-2, "{planes:?}: {speed} units per second");
    }
}

/// Returns a bar, and the same bar with a hole in its surface.
fn closed_and_open() -> (Mesh, Mesh) {
    let closed = cuboid([10, 4, 4]);
    let vertices = closed.vertices().iter().map(|&vertex| vertex.into()).collect();
    let faces: Vec<Vec<u32>> = closed.faces().skip(8).map(<[u32]>::to_vec).collect();
    let open = Mesh::new(vertices, &faces).unwrap();
    assert!(closed.is_closed() && !open.is_closed());
    (closed, open)
}

/// Contacts push pieces apart, and never hold them together, also where the surface of the body has a hole.
#[test]
fn pieces_that_part_are_not_held_together() {
    let (closed, open) = closed_and_open();
    for (mesh, normal) in
        [&closed, &open].into_iter().flat_map(|mesh| [[1.0, 0.0, 0.0], [1.0, 0.3, 0.2]].map(|n| (mesh, n)))
    {
        let body = Body::builder(mesh.clone()).cell_size(0.5).build().unwrap();
        let mut simulation = without_gravity(body);
        // The halves move apart, each as a whole.
        let body = simulation.body_mut(0);
        assert!(body.cut([5.0, 2.0, 2.0], normal).unwrap() > 0);
        assert_eq!(body.pieces(), 2);
        let pieces = body.lattice().components().of_vertex.clone();
        let positions = body.positions();
        let masses = body.masses();
        let mean = |piece: u32, x: &dyn Fn(usize) -> f64| {
            let own = || (0..pieces.len()).filter(|&v| pieces[v] == piece);
            own().map(|v| masses[v] * x(v)).sum::<f64>() / own().map(|v| masses[v]).sum::<f64>()
        };
        let left = u32::from(mean(0, &|v| positions[v].x) > 5.0);
        let direction = |v: usize| if pieces[v] == left { -1.0 } else { 1.0 };
        let velocities: Vec<_> = (0..pieces.len()).map(|v| Vector3::new(direction(v), 0.0, 0.0)).collect();
        body.set_velocities(&velocities).unwrap();
        simulation.advance(30);
        let velocities = simulation.body(0).velocities();
        for piece in [0, 1] {
            let speed = mean(piece, &|v| velocities[v].x * direction(v));
            let is_kept = (0.999..1.001).contains(&speed);
            assert!(is_kept, "closed: {}, {normal:?}: {speed}", mesh.is_closed());
        }
    }
}

/// A display keeps buffers of the last frame, which must not be those of another lattice.
#[test]
fn a_display_of_pieces_shows_the_whole_body_after_its_state_is_restored() {
    let body = Body::builder(cuboid([8, 4, 4])).cell_size(1.0).volume(VolumeMeasure::Mesh);
    let plane = Collider::plane([0.0, -0.01, 0.0], [0.0, 1.0, 0.0]);
    let builder = Simulation::builder().body(body.build().unwrap()).collider(plane).gravity([0.0; 3]);
    let mut simulation = builder.build().unwrap();
    let whole = simulation.state();
    let mut display = Display::new();
    let before = display.evaluate(simulation.body(0)).surface().positions;
    simulation.body_mut(0).cut([4.0, 2.0, 2.0], [1.0, 0.3, 0.1]).unwrap();
    simulation.steps(5);
    assert!(display.evaluate(simulation.body(0)).surface().positions.len() > before.len());
    simulation.restore(&whole).unwrap();
    assert_eq!(display.evaluate(simulation.body(0)).surface().positions, before);
}

/// The halves of a cut bar move towards each other and stop each other, also where the surface of the bar has a hole.
#[test]
fn pieces_that_meet_do_not_pass_through_each_other() {
    let (closed, open) = closed_and_open();
    for mesh in [closed, open] {
        let body = Body::builder(mesh.clone()).cell_size(0.5).build().unwrap();
        let mut simulation = without_gravity(body);
        let body = simulation.body_mut(0);
        body.cut([5.0, 2.0, 2.0], [1.0, 0.2, 0.1]).unwrap();
        let pieces = body.lattice().components().of_vertex.clone();
        let side = |piece: u32, x: &[nalgebra::Point3<f64>]| {
            let own = || (0..pieces.len()).filter(|&v| pieces[v] == piece);
            own().map(|v| x[v].x).sum::<f64>() / own().count() as f64
        };
        let positions = body.positions();
        let left = u32::from(side(0, &positions) > side(1, &positions));
        let distance = |x: &[nalgebra::Point3<f64>]| side(1 - left, x) - side(left, x);
        let velocity = |v: usize| Vector3::new(if pieces[v] == left { 0.5 } else { -0.5 }, 0.0, 0.0);
        let before = distance(&positions);
        body.set_velocities(&(0..pieces.len()).map(velocity).collect::<Vec<_>>()).unwrap();
        // Without contact the halves would approach by 1.
        simulation.advance(100);
        let approach = before - distance(&simulation.body(0).positions());
        assert!(approach.abs() < 0.5, "closed: {}: {approach}", mesh.is_closed());
    }
}

/// Returns a simulation of a bar that is pulled apart by a quarter of its length within a second. At both ends, the
/// given number of layers of lattice vertices is held.
fn pulled_bar((cell_size, half_width): (f64, usize), strain: f64, layers: i32) -> Simulation {
    let body = Body::builder(cuboid([12, 4, 4])).cell_size(cell_size).half_width(half_width);
    let body = body.volume(VolumeMeasure::Mesh).fracture(FractureOptions::new(BreakLimit::Strain(strain)));
    let mut body = body.build().unwrap();
    let x: Vec<i32> = body.lattice().indices().iter().map(|index| index[0]).collect();
    let last = x.iter().copied().max().unwrap();
    let end = Key { time: 1.0, translate: [3.0, 0.0, 0.0], ..Key::default() };
    for (layers, keys) in
        [(0..layers, vec![Key::default()]), (last + 1 - layers..last + 1, vec![Key::default(), end])]
    {
        let held = (0..).zip(&x).filter(|(_, x)| layers.contains(x)).map(|(vertex, _)| vertex);
        let selection = Selection::Vertices(held.collect());
        body.handle(&Handle { goal: None, selection, motion: keys.into(), window: TimeWindow::default() })
            .unwrap();
    }
    let builder = Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 120.0);
    builder.build().unwrap()
}

/// Advances by a frame of four steps, and checks that the pieces keep their volume.
fn advance_and_check_volumes(simulation: &mut Simulation) {
    simulation.steps(4);
    assert!(simulation.bodies()[0].mesh().unwrap().is_closed());
    for (now, rest) in piece_volumes(simulation) {
        assert!((now / rest - 1.0).abs() < 1e-6, "{now} {rest}");
    }
}

/// A bar that is pulled until it breaks: one crack passes through it, away from the vertices that are held, and then
/// the pieces come to rest.
#[test]
fn a_pulled_bar_keeps_the_volume_of_its_pieces_and_comes_to_rest() {
    let mut simulation = pulled_bar((0.5, 1), 0.1, 2);
    let mut kinetic = Vec::new();
    for _ in 0..90 {
        advance_and_check_volumes(&mut simulation);
        kinetic.push(quantities(&simulation.bodies()[0]).kinetic);
    }
    assert_eq!(simulation.bodies()[0].pieces(), 2);
    // The crack leaves whole layers of cells at the handles: a crumb would have less than a layer.
    let least = piece_volumes(&simulation).into_iter().map(|(_, rest)| rest).fold(f64::INFINITY, f64::min);
    assert!(least > 0.5 * 16.0, "{least}");
    let greatest = kinetic.iter().copied().fold(0.0, f64::max);
    assert!(kinetic[89] < 1e-3 * greatest, "{} of {greatest}", kinetic[89]);
}

/// Large regions break beside the handles, and leave slices of one and a half cells there.
#[test]
fn slices_at_handles_keep_their_volume() {
    for (cell_size, strain) in [(0.8, 0.1), (0.5, 0.2)] {
        let mut simulation = pulled_bar((cell_size, 2), strain, 1);
        for _ in 0..45 {
            advance_and_check_volumes(&mut simulation);
        }
        let slices =
            piece_volumes(&simulation).into_iter().filter(|(_, rest)| *rest < 2.0 * 16.0 * cell_size);
        assert!(slices.count() > 0, "no slices at cells of {cell_size}");
    }
}

/// A block is cut in the middle of a layer of cells and compressed. The correction moves the cuts outwards, also that of
/// the piece whose last layer of cells ends before the cut.
#[test]
fn the_correction_moves_the_cuts_of_pieces_outwards() {
    let body = Body::builder(cuboid([4, 4, 4])).cell_size(1.0).volume(VolumeMeasure::Mesh);
    let mut simulation = without_gravity(body.build().unwrap());
    let body = simulation.body_mut(0);
    body.cut([1.5, 2.0, 2.0], [1.0, 0.0, 0.0]).unwrap();
    let mut compressed = body.positions();
    compressed.iter_mut().for_each(|position| position.x *= 0.9);
    body.set_positions(&compressed).unwrap();
    let body = &simulation.bodies()[0];
    let surface = simulation.body(0).surface().positions;
    let (piece, rest) = (body.piece_of_mesh_vertices().unwrap(), body.mesh().unwrap().vertices());
    let left = piece[rest.iter().position(|p| p.x < 1.0).unwrap()];
    let mut moved_vertices = [0; 2];
    for (vertex, (point, rest)) in surface.iter().zip(rest).enumerate() {
        let is_inside_cap =
            (rest.x - 1.5).abs() < 0.2 && [rest.y, rest.z].iter().all(|x| (0.5..3.5).contains(x));
        let outwards = if piece[vertex] == left { 1.0 } else { -1.0 };
        if is_inside_cap {
            let moved = (point.x - 0.9 * rest.x) * outwards;
            assert!(moved > 0.01, "vertex {vertex} at {rest}, moved by {moved}");
            moved_vertices[usize::from(piece[vertex] == left)] += 1;
        }
    }
    assert!(moved_vertices.iter().all(|&count| count > 0), "{moved_vertices:?}");
}

/// Returns the volume of the displayed surface of each piece, and that at rest.
fn piece_volumes(simulation: &Simulation) -> Vec<(f64, f64)> {
    let body = &simulation.bodies()[0];
    let now = volumes_of_pieces(body, &simulation.body(0).surface().positions);
    let rest = volumes_of_pieces(body, body.mesh().unwrap().vertices());
    now.into_iter().zip(rest).collect()
}

#[test]
fn pieces_touch_each_other() {
    // A block on a plane, cut in an upper and a lower half, of which the upper one is then lifted and falls back.
    let body = Body::builder(cuboid([6, 6, 6])).cell_size(1.0).youngs_modulus(1e7).damping_ratio(0.5);
    let plane = Collider::plane([0.0, -0.01, 0.0], [0.0, 1.0, 0.0]);
    let builder =
        Simulation::builder().body(body.build().unwrap()).collider(plane).gravity([0.0, -9.81, 0.0]);
    let mut simulation = builder.dt(1.0 / 120.0).build().unwrap();
    simulation.steps(20);
    simulation.body_mut(0).cut([3.0, 3.0, 3.0], [0.0, 1.0, 0.0]).unwrap();
    let upper = |body: &Body| -> Vec<usize> {
        let lattice = body.lattice();
        let top = (0..lattice.len() as u32).find(|&v| lattice.rest_position(v).y > 5.9).unwrap();
        let piece = lattice.components().of_vertex[top as usize];
        (0..lattice.len()).filter(|&v| lattice.components().of_vertex[v] == piece).collect()
    };
    let body = simulation.body_mut(0);
    let vertices = upper(body);
    let mut positions = body.positions();
    vertices.iter().for_each(|&vertex| positions[vertex].y += 0.5);
    body.set_positions(&positions).unwrap();
    simulation.steps(240);
    let body = &simulation.bodies()[0];
    let heights: Vec<f64> = vertices.iter().map(|&vertex| body.positions()[vertex].y).collect();
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    // It lies on the lower half, which is three cells high and compressed a little by its weight.
    assert!((2.7..3.05).contains(&lowest), "{lowest}");
}

/// A plane beside a slanted face cuts off cells that contain a part of the mesh on the other side of the plane only.
#[test]
fn pieces_without_a_surface_do_not_fall_through_the_ground() {
    let corners = [0, 1, 2]
        .map(|axis| [-1.0, 1.0].map(|side| [0, 1, 2].map(|a| if a == axis { 4.0 * side } else { 0.0 })));
    let faces: Vec<[u32; 3]> = (0u32..8)
        .map(|k| {
            let [x, y, z] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2 & 1)];
            if k.count_ones() % 2 == 1 { [x, y, z] } else { [x, z, y] }
        })
        .collect();
    let octahedron = Mesh::new(corners.concat(), &faces).unwrap();
    let body =
        Body::builder(octahedron).cell_size(1.0).preset(Preset::Rubber).poisson_ratio(0.0).build().unwrap();
    let ground = Collider::plane([0.0, -5.0, 0.0], [0.0, 1.0, 0.0]);
    let mut simulation = Simulation::builder()
        .body(body)
        .collider(ground)
        .gravity([0.0, -9.81, 0.0])
        .fps(60.0)
        .build()
        .unwrap();
    // Just outside the face.
    assert!(simulation.body_mut(0).cut([4.05, 0.0, 0.0], [1.0; 3]).unwrap() > 0);
    let body = &simulation.bodies()[0];
    let with_surface: BTreeSet<u32> = body.piece_of_mesh_vertices().unwrap().into_iter().collect();
    assert!(with_surface.len() < body.pieces());
    // A fall from the greatest height, 9 units, takes 1.4 s, and what falls through the ground is 35 units lower after 3 s.
    simulation.advance(180);
    let lowest = simulation.bodies()[0].positions().iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(lowest > -6.0, "{lowest}");
}

/// A bust that falls on the ground breaks with the half-width and the steps that are chosen for its material, and the pieces
/// are closed and have its volume.
#[test]
fn a_bust_breaks_on_the_ground_without_further_settings() {
    for vertices in [1000, 2000] {
        let body = Body::builder(bust()).lattice_vertices(vertices).preset(Preset::Rubber);
        let body = body.fracture(FractureOptions::new(BreakLimit::Strain(0.03))).build().unwrap();
        let ground = body.mesh().unwrap().bounds().0.y - 5.6;
        let mut simulation = Simulation::builder()
            .body(body)
            .collider(Collider::plane([0.0, ground, 0.0], [0.0, 1.0, 0.0]))
            .fps(30.0)
            .substeps(Substeps::Auto)
            .build()
            .unwrap();
        simulation.advance(40);
        let body = simulation.body(0);
        assert!(body.pieces() > 1 && body.half_width().cells() <= 1.0, "{vertices}");
        let mesh = body.mesh().unwrap();
        assert!(mesh.is_closed() && (mesh.signed_volume() / bust().signed_volume() - 1.0).abs() < 1e-9);
    }
}
