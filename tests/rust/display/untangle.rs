//! The displayed lattice has no cell that is inside out.

use nalgebra::{Matrix3, Point3, Vector3};
use supple::{
    Accuracy, Body, BodyBuilder, Collider, Display, Lattice, Material, Pin, Selection, Simulation, Substeps,
    TimeWindow, UntanglingReport, VolumeMeasure, VolumeOptions,
};
use supple_tests::{block, lattice};

/// Returns the number of cells with a determinant that is not positive, at a corner or at the center.
fn inverted_cells(lattice: &Lattice, positions: &[Point3<f64>]) -> usize {
    least_determinants(lattice, positions).filter(|least| *least <= 0.0).count()
}

/// Iterates over the least determinant of each cell, at its corners and at its center.
fn least_determinants<'a>(
    lattice: &'a Lattice,
    positions: &'a [Point3<f64>],
) -> impl Iterator<Item = f64> + 'a {
    let least = move |cell: u32| {
        let corners = lattice.cell_corners(cell).map(|vertex| positions[vertex as usize].coords);
        let edge = |k: usize, axis: usize| corners[k | 1 << axis] - corners[k & !(1 << axis)];
        let determinant = |edges: [Vector3<f64>; 3]| Matrix3::from_columns(&edges).determinant();
        let center = [0, 1, 2].map(|axis| (0..8).map(|k| edge(k, axis)).sum());
        (0..8).map(|k| determinant([0, 1, 2].map(|axis| edge(k, axis)))).fold(determinant(center), f64::min)
    };
    (0..lattice.cells().len() as u32).map(least)
}

/// A block of cells, 6 high, that falls on the ground `times` its height.
fn drop(times: f64, volume: VolumeOptions, threads: usize) -> Simulation {
    let body = Body::from_lattice(lattice(&block([8, 6, 8])));
    fall(body.volume(volume), times, threads)
}

/// A body of a size of 6, as stiff as jelly, that falls on the ground `times` its size.
fn fall(body: BodyBuilder, times: f64, threads: usize) -> Simulation {
    let gravity = 8.0 * 6.0;
    let speed = (2.0 * gravity * times * 6.0_f64).sqrt();
    let modulus = 20.0 * 1000.0 * 6.0 * gravity;
    // With two steps a frame the regions are wide: those of one cell do not turn inside out.
    let body = body.density(1000.0).youngs_modulus(modulus).accuracy(Accuracy::Fast).damping_ratio(0.1);
    Simulation::builder()
        .body(body.translate([0.0, 0.5, 0.0]).velocity([1.0, -speed, 0.0]).build().unwrap())
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
        .gravity([0.0, -gravity, 0.0])
        .fps(30.0)
        .substeps(Substeps::Fixed(2))
        .threads(threads)
        .build()
        .unwrap()
}

/// Returns the lowest y coordinate.
fn lowest(positions: &[Point3<f64>]) -> f64 {
    positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

#[test]
fn no_cell_of_the_displayed_lattice_of_a_hard_drop_is_inverted() {
    for volume in [VolumeOptions::default(), VolumeOptions::off()] {
        let mut simulation = drop(2.0, volume, 1);
        let lattice = simulation.body(0).lattice().clone();
        let mut display = Display::new();
        let mut crushed = 0;
        for _ in 0..30 {
            simulation.advance(1);
            let deformed = simulation.body(0).positions();
            let shown: Vec<Point3<f64>> = display.evaluate(simulation.body(0)).positions().collect();
            assert_eq!(inverted_cells(&lattice, &shown), 0);
            // The samples of a bare lattice are its vertices. 1e-5: positions are rounded to f32, with coordinates up to 32.
            assert!(lowest(&shown) >= lowest(&deformed).min(0.0) - 1e-5);
            crushed += usize::from(inverted_cells(&lattice, &deformed) > 0);
        }
        assert!(crushed > 0, "the drop turns cells inside out");
    }
}

#[test]
fn frames_without_inverted_cells_are_displayed_as_without_untangling() {
    let mut simulation = drop(2.0, VolumeOptions::off(), 1);
    let lattice = simulation.body(0).lattice().clone();
    let mut reused = Display::new();
    let (mut unchanged, mut changed) = (0, 0);
    for _ in 0..30 {
        simulation.advance(1);
        let deformed = simulation.body(0).positions();
        let shown: Vec<Point3<f64>> = reused.evaluate(simulation.body(0)).positions().collect();
        let least = least_determinants(&lattice, &deformed).fold(f64::INFINITY, f64::min);
        // Without a volume correction, the lattice is displayed as it is. 1e-5: positions are rounded to f32, with coordinates up
        // to 32.
        let is_unchanged =
            shown.iter().zip(&deformed).all(|(shown, deformed)| (shown - deformed).amax() < 1e-5);
        // Cells on the ground can be flat, with a determinant that is a rounding error.
        if least.abs() > 1e-9 {
            assert_eq!(is_unchanged, least > 0.0);
        }
        let report = simulation.body(0).volume_report();
        assert_eq!(report.before == report.after, is_unchanged);
        *(if is_unchanged { &mut unchanged } else { &mut changed }) += 1;
    }
    assert!(unchanged > 0 && changed > 0, "{unchanged} {changed}");
}

#[test]
fn a_display_needs_memory_for_untangling_only_after_an_inverted_cell() {
    let body = || Body::from_lattice(lattice(&block([4; 3]))).build().unwrap();
    let mut plain = body();
    let mut display = Display::new();
    display.evaluate(&plain);
    let bytes = display.bytes();
    let squashed: Vec<_> = plain.positions().iter().map(|p| Point3::new(p.x, 0.1 * p.y, p.z)).collect();
    plain.set_positions(&squashed).unwrap();
    display.evaluate(&plain);
    assert_eq!(display.bytes(), bytes);
    let mirrored: Vec<_> = squashed.iter().map(|p| Point3::new(p.x, -p.y, p.z)).collect();
    plain.set_positions(&mirrored).unwrap();
    display.evaluate(&plain);
    assert!(display.bytes() > bytes);
}

#[test]
fn untangling_is_thread_count_independent() {
    let run = |threads| {
        let mut simulation = drop(2.0, VolumeOptions::default(), threads);
        let mut shown = Vec::new();
        for _ in 0..12 {
            simulation.advance(1);
            shown.extend(simulation.body(0).corrected_positions());
        }
        shown
    };
    let one = run(1);
    assert!(one == run(2) && one == run(3));
}

#[test]
fn pinned_vertices_stay_where_they_are() {
    let cells = block([5, 6, 5]);
    let below = Selection::Plane { point: [0.0, 1.5, 0.0], normal: [0.0, -1.0, 0.0] };
    let body = Body::from_lattice(lattice(&cells)).pin(Pin {
        goal: None,
        selection: below,
        window: TimeWindow::default(),
    });
    let mut simulation =
        Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).threads(1).build().unwrap();
    simulation.steps(1);
    let rest = simulation.body(0).positions();
    // The layers at 2 and 3 change places, and those above are pressed flat.
    let folded: Vec<_> = rest
        .iter()
        .map(|p| {
            let y = [0.0, 1.0, 3.0, 2.0, 3.1, 3.1, 3.1][p.y.round() as usize];
            Point3::new(p.x, y, p.z)
        })
        .collect();
    simulation.body_mut(0).set_positions(&folded).unwrap();
    let lattice = simulation.body(0).lattice().clone();
    assert!(inverted_cells(&lattice, &folded) > 0);
    let shown = simulation.body(0).corrected_positions();
    assert_eq!(inverted_cells(&lattice, &shown), 0);
    for (shown, rest) in shown.iter().zip(&rest).filter(|(_, rest)| rest.y < 1.5) {
        assert_eq!(shown, rest);
    }
}

#[test]
fn the_work_for_a_crushed_body_is_a_tenth_of_that_for_others() {
    // The cells are crushed to a twentieth of their volume, and neighboring vertices are in disorder by half of a cell.
    let body = Body::from_lattice(lattice(&block([6, 6, 6]))).material(Material::fast_lsm());
    let mut body = body.build().unwrap();
    let rest = body.positions();
    let vertices = rest.len();
    let mut random = fastrand::Rng::with_seed(1);
    let mut evaluate = |height: f64, disorder: f64| {
        let mut noise = || disorder * (random.f64() - 0.5);
        let positions: Vec<_> =
            rest.iter().map(|p| Point3::new(p.x + noise(), height * p.y + noise(), p.z + noise())).collect();
        body.set_positions(&positions).unwrap();
        Display::new().evaluate(body.alone()).untangling()
    };
    assert_eq!(evaluate(1.0, 0.0), UntanglingReport::default());
    let crushed = evaluate(0.05, 2.0);
    assert!(crushed.displacements > 0 && crushed.displacements <= 15 * vertices, "{crushed:?}");
    // A body that is not crushed may have ten times as many, and is never given up.
    let pressed = evaluate(0.5, 3.0);
    assert!(pressed.displacements <= 150 * vertices && !pressed.given_up, "{pressed:?}");
}

#[test]
fn collapsed_bodies_are_displayed_with_finite_positions() {
    type Map = fn(&Point3<f64>) -> Point3<f64>;
    let collapse: [(&str, Map); 6] = [
        ("point", |_| Point3::new(1.0, 2.0, 3.0)),
        ("line", |p| Point3::new(p.x, 0.0, 0.0)),
        ("plane", |p| Point3::new(p.x, 0.0, p.z)),
        ("mirrored", |p| Point3::new(p.x, -p.y, p.z)),
        ("folded", |p| Point3::new(p.x, (p.y - 2.0).abs(), p.z)),
        ("huge", |p| Point3::new(-1e12 * p.x, p.y, p.z)),
    ];
    for volume in [VolumeOptions::off(), VolumeMeasure::Cells.into()] {
        for (name, map) in collapse {
            let body = Body::from_lattice(lattice(&block([4, 4, 5]))).material(Material::fast_lsm());
            let mut body = body.volume(volume).build().unwrap();
            let positions: Vec<_> = body.positions().iter().map(map).collect();
            body.set_positions(&positions).unwrap();
            let shown = body.alone().corrected_positions();
            assert!(shown.iter().all(|p| p.coords.iter().all(|x| x.is_finite())), "{name}");
            let report = body.alone().volume_report();
            assert!(report.residual.is_finite() && report.after.is_finite(), "{name}: {report:?}");
            // A plane has a normal along which the cells can be opened; a point and a line have none. A volume that cannot be
            // restored without inverted cells is restored with them.
            let is_solid = ["plane", "mirrored", "folded"].contains(&name);
            if is_solid && (volume == VolumeOptions::off() || report.residual.abs() > 1e-6) {
                assert_eq!(inverted_cells(body.lattice(), &shown), 0, "{name}");
            }
        }
    }
}
