//! Maps: weights of the mesh vertices, which zones, pins and handles take as shares.

use nalgebra::Vector3;
use supple::{
    Body, BodyBuilder, BreakLimit, FractureOptions, Goal, HalfWidth, Map, Mesh, Pin, Refine, Selection,
    Simulation, TimeWindow, Zone,
};
use supple_tests::{greatest_distance, mesh_of, plain_box, points};

/// A bar of 4 x 1 x 1 of 8 vertices.
fn coarse_bar() -> Mesh {
    mesh_of(plain_box([0.0; 3], [4.0, 1.0, 1.0]))
}

/// A bar of 4 x 1 x 1 of small faces.
fn bar() -> Mesh {
    coarse_bar().refined(0.25).unwrap().unwrap().mesh
}

fn builder(mesh: Mesh) -> BodyBuilder {
    Body::builder(mesh).cell_size(0.25).half_width(HalfWidth::CELL).stiffness(0.3).damping_ratio(0.0)
}

/// Returns a weight of each vertex of a mesh, by its place along the bar.
fn weights(mesh: &Mesh, of: impl Fn(f64) -> f64) -> Vec<f32> {
    mesh.vertices().iter().map(|vertex| of(vertex.x) as f32).collect()
}

/// 1 at one end, 0 at the other one.
fn ramp(mesh: &Mesh) -> Vec<f32> {
    weights(mesh, |x| 1.0 - x / 4.0)
}

fn pin(selection: Selection, goal: Option<Goal>) -> Pin {
    Pin { selection, window: TimeWindow::default(), goal }
}

#[test]
fn a_map_is_the_share_of_the_factors_of_a_zone() {
    let mesh = bar();
    let list = Selection::Map(Map::Weights(ramp(&mesh)));
    let named = Selection::Map("paint".into());
    let mesh = mesh.clone().with_maps([("paint".to_owned(), ramp(&mesh))]).unwrap();
    let mut body = builder(mesh).stiffness(0.1).build().unwrap();
    let shares = body.weights(&list).unwrap().unwrap();
    assert_eq!(body.weights(&named).unwrap().unwrap(), shares);
    assert!(body.weights(&Selection::Group("paint".to_owned())).unwrap().is_none());
    // Along the bar the share is linear up to a cell, behind the ends.
    for (vertex, share) in (0..).zip(&shares) {
        let x = body.lattice().rest_position(vertex).x;
        assert!((share - (1.0 - x / 4.0)).abs() <= 0.25 / 4.0 + 1e-6, "{x}: {share}");
    }
    body.zone(&Zone::new(named, 9.0)).unwrap();
    for (factor, share) in body.stiffness_factors().unwrap().iter().zip(&shares) {
        assert!((factor - 9_f64.powf(*share)).abs() < 1e-12);
    }
    // Where there is no share, only whole parts count.
    let half = body.select(&list).unwrap();
    let expected: Vec<u32> = (0..).zip(&shares).filter(|(_, share)| **share >= 0.5).map(|(v, _)| v).collect();
    assert_eq!(half, expected);
    assert!(half.len() * 2 > shares.len() - 60 && half.len() * 2 < shares.len() + 60);
}

/// A list for the given mesh is continued to the vertices of a refined one.
#[test]
fn weights_of_coarse_faces_are_linear_in_them_also_if_the_faces_are_divided() {
    let mesh = coarse_bar();
    assert_eq!(mesh.vertices().len(), 8);
    let zone = Zone::new(Selection::Map(Map::Weights(ramp(&mesh))), 4.0);
    let factors = |refine| {
        let body = builder(mesh.clone()).stiffness(0.1).refine(refine).zone(zone.clone()).build().unwrap();
        body.stiffness_factors().unwrap().to_vec()
    };
    let (coarse, fine) = (factors(Refine::Off), factors(Refine::Auto));
    assert!(coarse.iter().any(|factor| (1.9..2.1).contains(factor)));
    coarse.iter().zip(fine).for_each(|(a, b)| assert!((a - b).abs() < 0.01 * b, "{a} {b}"));
}

#[test]
fn wrong_maps_are_errors_that_say_what_there_is() {
    let mesh = bar();
    let count = mesh.vertices().len();
    let mesh = mesh.with_maps([("red".to_owned(), vec![0.0; count])]).unwrap();
    let mut body = builder(mesh).build().unwrap();
    let mut zone = |selection| body.zone(&Zone::new(selection, 2.0)).unwrap_err().to_string();
    let error = zone(Selection::Map("green".into()));
    assert!(error.contains("green") && error.contains("red"), "{error}");
    let error = zone(Selection::Map(Map::Weights(vec![1.0; 3])));
    assert!(error.contains('3') && error.contains(&count.to_string()), "{error}");
    let mut wrong = vec![0.5; count];
    wrong[7] = f32::NAN;
    let error = zone(Selection::Map(Map::Weights(wrong)));
    assert!(error.contains("vertex 7") && error.contains("NaN"), "{error}");
    let error = body.pin(&pin(Selection::Map("red".into()), None)).unwrap_err().to_string();
    assert!(error.contains("weight"), "{error}");
    let mut bare = Body::from_lattice(body.lattice().clone()).build().unwrap();
    let error =
        bare.zone(&Zone::new(Selection::Map(Map::Weights(vec![1.0; count])), 2.0)).unwrap_err().to_string();
    assert!(error.contains("bare lattice"), "{error}");
}

/// Where the map is 1 the body is held as by a pin on these vertices, bit by bit; where it is 0 nothing holds it.
#[test]
fn a_pin_by_a_map_of_ones_and_zeros_has_the_bits_of_a_pin_on_the_vertices() {
    let mesh = bar();
    let end = weights(&mesh, |x| f64::from(u8::from(x < 1.0)));
    let fallen = |by_map: bool| {
        let body = builder(mesh.clone());
        let probe = builder(mesh.clone()).build().unwrap();
        let carried = probe.weights(&Selection::Map(Map::Weights(end.clone()))).unwrap().unwrap();
        let ones: Vec<u32> = (0..)
            .zip(&carried)
            .filter(|(_, weight)| **weight > 1.0 - 1e-6)
            .map(|(vertex, _)| vertex)
            .collect();
        // Weights between those of the two parts would pull vertices softly.
        let selection = match by_map {
            true => Selection::Map(Map::Weights(end.clone())),
            false => Selection::Vertices(ones),
        };
        let goal = by_map.then(|| Goal { frequency: 1e-9, damping_ratio: 0.0, ..Goal::default() });
        let body = body.pin(pin(selection, goal)).build().unwrap();
        let mut simulation = Simulation::builder().body(body).dt(1.0 / 120.0).build().unwrap();
        simulation.steps(60);
        (simulation.body(0).positions(), simulation.body(0).hold_force(0).unwrap().unwrap().force)
    };
    let ((by_map, force), (by_list, expected)) = (fallen(true), fallen(false));
    assert_eq!(by_map, by_list);
    assert!((force - expected).norm() <= 1e-6 * expected.norm(), "{force} {expected}");
    assert!(by_list.iter().any(|point| point.y < -0.01));
}

/// A body that a map pulls everywhere with the weight 1/2 swings with the frequency of the goal.
#[test]
fn a_weight_of_a_map_is_a_factor_of_the_weight_of_the_goal() {
    let mesh = bar();
    let all = Selection::Map(Map::Weights(vec![0.5; mesh.vertices().len()]));
    let goal = Goal { weight: 0.8.into(), frequency: 2.0, damping_ratio: 0.5 };
    let body = builder(mesh).pin(pin(all, Some(goal))).build().unwrap();
    let mut simulation = Simulation::builder().body(body).dt(1.0 / 120.0).sleep(false).build().unwrap();
    let start = simulation.body(0).center_of_mass().y;
    simulation.steps(600);
    let omega = std::f64::consts::TAU * 2.0 * (0.4_f64 / 0.6).sqrt();
    // The factor of the scheme is 2 (1 - cos(ω h))/h², by (ω h)²/12 less than ω².
    let sag = 9.81 / (omega * omega) * (1.0 + (omega / 120.0).powi(2) / 12.0);
    let found = start - simulation.body(0).center_of_mass().y;
    assert!((found - sag).abs() < 1e-3 * sag, "{found} {sag}");
}

/// A zone of the whole body with four times the density is a body of four times the density.
#[test]
fn a_denser_zone_is_heavier_and_as_stiff() {
    let mesh = bar();
    let everywhere = Selection::Map(Map::Weights(vec![1.0; mesh.vertices().len()]));
    let end = || pin(Selection::Plane { point: [0.3, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] }, None);
    let hung = |density: f64, zone: Option<Zone>| {
        let body =
            Body::builder(mesh.clone()).cell_size(0.25).youngs_modulus(1e6).density(density).pin(end());
        let body = zone.into_iter().fold(body, BodyBuilder::zone).build().unwrap();
        let mut simulation = Simulation::builder().body(body).dt(1.0 / 480.0).build().unwrap();
        simulation.steps(120);
        let body = simulation.body(0);
        (body.positions(), body.mass(), body.youngs_modulus())
    };
    let zone = Zone { density: 4.0, ..Zone::new(everywhere, 1.0) };
    let (plain, dense, by_zone) = (hung(1000.0, None), hung(4000.0, None), hung(1000.0, Some(zone)));
    assert!((dense.1 - 4.0 * plain.1).abs() < 1e-3 * dense.1);
    assert!((by_zone.1 - dense.1).abs() < 1e-5 * dense.1, "{} {}", by_zone.1, dense.1);
    assert!(greatest_distance(&plain.0, &dense.0) > 0.01);
    assert!(greatest_distance(&by_zone.0, &dense.0) < 1e-3, "{}", greatest_distance(&by_zone.0, &dense.0));
}

/// A thrown bar with a heavy end turns about its center of mass, which flies straight.
#[test]
fn the_spin_of_a_body_with_a_heavy_end_is_about_its_center_of_mass() {
    let mesh = bar();
    let zone = Zone { density: 8.0, ..Zone::new(Selection::Map(Map::Weights(ramp(&mesh))), 1.0) };
    let body = builder(mesh).zone(zone).velocity([1.0, 0.0, 0.0]).spin([0.0, 0.0, 2.0]).build().unwrap();
    let start = body.center_of_mass();
    assert!(start.x < 1.6, "{start}");
    let mut simulation = Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 240.0).build().unwrap();
    simulation.steps(240);
    let moved = simulation.body(0).center_of_mass() - start;
    assert!((moved - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-4, "{moved}");
}

/// A state carries the density of its zones to a body that was built without them.
#[test]
fn a_state_restores_the_density_of_zones() {
    let mesh = bar();
    let zone = Zone { density: 8.0, ..Zone::new(Selection::Map(Map::Weights(ramp(&mesh))), 0.5) };
    let simulation = |zones: Vec<Zone>| {
        let body = zones.into_iter().fold(builder(mesh.clone()), BodyBuilder::zone).build().unwrap();
        Simulation::builder().body(body).dt(1.0 / 240.0).build().unwrap()
    };
    let mut with = simulation(vec![zone]);
    with.steps(20);
    let state = with.state();
    let mut without = simulation(Vec::new());
    without.restore(&state).unwrap();
    assert_eq!(without.body(0).masses(), with.body(0).masses());
    with.steps(20);
    without.steps(20);
    assert_eq!(without.body(0).positions(), with.body(0).positions());
}

/// A bar that is pulled at both ends breaks where a map makes it weak.
#[test]
fn a_bar_breaks_where_it_is_weak() {
    let mesh = bar();
    let weak = weights(&mesh, |x| f64::from(u8::from((2.6..3.2).contains(&x))));
    let ends = [([0.3, 0.0, 0.0], -1.0), ([3.7, 0.0, 0.0], 1.0)];
    let pull = |strength: f64| {
        let mut body = builder(mesh.clone()).fracture(FractureOptions::new(BreakLimit::Strain(0.8)));
        if strength != 1.0 {
            body = body.zone(Zone { strength, ..Zone::new(Selection::Map(Map::Weights(weak.clone())), 1.0) });
        }
        for (point, side) in ends {
            let keys = vec![
                supple::Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
                supple::Key { time: 4.0, translate: [side * 0.5, 0.0, 0.0], rotate: [0.0; 3] },
            ];
            let selection = Selection::Plane { point, normal: [side, 0.0, 0.0] };
            let (motion, window) = (keys.into(), TimeWindow::default());
            body = body.handle(supple::Handle { selection, motion, window, goal: None });
        }
        let body = body.build().unwrap();
        let mut simulation =
            Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 240.0).build().unwrap();
        for _ in 0..960 {
            simulation.step();
            if simulation.body(0).pieces() > 1 {
                break;
            }
        }
        let lattice = simulation.body(0).lattice().clone();
        let of = &lattice.components().of_vertex;
        let (pieces, first) = (simulation.body(0).pieces(), of[0]);
        let end = (0..lattice.len() as u32).filter(|&vertex| of[vertex as usize] == first);
        (pieces, end.map(|vertex| lattice.rest_position(vertex).x).fold(0.0, f64::max))
    };
    assert_eq!(pull(1.0).0, 1);
    let (pieces, place) = pull(0.25);
    assert!(pieces == 2 && (2.4..3.4).contains(&place), "{pieces} {place}");
}

/// The pieces of a body with a heavy half have the masses of their cells: a hand's breadth from the cut each vertex weighs
/// as much as in the whole body, and both pieces together weigh as much.
#[test]
fn the_pieces_of_a_body_with_a_heavy_half_have_the_masses_of_their_cells() {
    let mesh = bar();
    let heavy = weights(&mesh, |x| f64::from(u8::from(x < 2.0)));
    let zone = Zone { density: 50.0, ..Zone::new(Selection::Map(Map::Weights(heavy)), 1.0) };
    for breaks in [false, true] {
        let body = builder(mesh.clone()).zone(zone.clone());
        let limit = FractureOptions::new(BreakLimit::Strain(0.5));
        let mut body = if breaks { body.fracture(limit) } else { body }.build().unwrap();
        let (total, before) = (body.mass(), body.masses());
        let count = before.len();
        assert!(body.cut([2.0, 0.5, 0.5], [1.0, 0.0, 0.0]).unwrap() > 0);
        assert_eq!(body.pieces(), 2);
        assert!((body.mass() - total).abs() < 1e-5 * total, "{} {total}", body.mass());
        // In regions of one cell the mass of a vertex is the sum of the shares of its cells: those of a piece are either
        // all heavy or all light, so that copies differ by the densities of their sides.
        let (masses, lattice) = (body.masses(), body.lattice());
        let shares = body.cell_shares();
        let mut sums = vec![0.0; lattice.len()];
        for (cell, share) in (0..).zip(&shares) {
            lattice.cell_corners(cell).iter().for_each(|&corner| sums[corner as usize] += share / 8.0);
        }
        let unit = body.material().density * lattice.cell_size().powi(3);
        for (mass, sum) in masses.iter().zip(&sums) {
            assert!((mass - unit * sum).abs() < 1e-4 * mass, "{mass} {}", unit * sum);
        }
        assert!(lattice.len() > count && before.len() == count);
        // And the pieces stay where they are.
        let mut simulation =
            Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 240.0).build().unwrap();
        let start = simulation.body(0).positions();
        simulation.steps(120);
        let moved = greatest_distance(&simulation.body(0).positions(), &start);
        assert!(moved < 1e-3, "{moved}");
    }
}

/// Products of factors that would make masses vanish are errors, and leave the body as it was.
#[test]
fn factors_that_are_too_small_are_errors() {
    let mesh = bar();
    let everywhere = || Selection::Map(Map::Weights(vec![1.0; mesh.vertices().len()]));
    let mut body = builder(mesh.clone()).build().unwrap();
    let masses = body.masses();
    for density in [1e-50, 1e-7] {
        let error = body.zone(&Zone { density, ..Zone::new(everywhere(), 1.0) }).unwrap_err().to_string();
        assert!(error.contains("1e-6"), "{error}");
    }
    assert_eq!(body.masses(), masses);
}

/// A strength in a body that does not break is a mistake.
#[test]
fn a_strength_needs_fracture() {
    let mesh = bar();
    let zone = Zone { strength: 0.5, ..Zone::new(Selection::Map(Map::Weights(ramp(&mesh))), 1.0) };
    let error = builder(mesh).zone(zone).build().unwrap_err().to_string();
    assert!(error.contains("strength_factor") && error.contains("fracture"), "{error}");
}

/// Positions that are set do not change what a map selects: it belongs to the mesh.
#[test]
fn maps_do_not_depend_on_the_pose() {
    let mesh = bar();
    let selection = Selection::Map(Map::Weights(ramp(&mesh)));
    let mut body = builder(mesh).build().unwrap();
    let before = body.weights(&selection).unwrap();
    let moved: Vec<Vector3<f64>> =
        body.positions().iter().map(|point| point.coords * 2.0 + Vector3::repeat(5.0)).collect();
    body.set_positions(&points(&moved)).unwrap();
    assert_eq!(body.weights(&selection).unwrap(), before);
}
