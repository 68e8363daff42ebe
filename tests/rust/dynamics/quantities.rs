//! Mass, momenta and energies of a body.

use nalgebra::{Matrix3, Point3, Vector3};
use supple::{Body, BodyBuilder, Lattice, Material, Mesh, Preset, Simulation, Substeps};
use supple_tests::{
    Random, bare, block, half_cells, lattice, mesh_of, plain_box, points, rest, without_gravity,
};

/// Relative rounding error of velocities and positions, which are stored as f32 in cells.
const F32: f64 = 1e-6;

fn close(a: Vector3<f64>, b: Vector3<f64>, tolerance: f64) {
    assert!((a - b).norm() <= tolerance * b.norm().max(1e-300), "{a:?} is not {b:?}");
}

fn builder(lattice: &Lattice) -> BodyBuilder {
    Body::from_lattice(lattice.clone()).material(Material::fast_lsm())
}

/// Returns the lattice of a box of cells of edge `h`.
fn cells(size: [i32; 3], h: f64) -> Lattice {
    Lattice::from_cells(&block(size), h, Point3::origin(), true).unwrap()
}

/// Stretches a body along x by the strain `strain`.
fn stretch(body: &mut Body, strain: f64) {
    let stretched = |x: &Vector3<f64>| Vector3::new((1.0 + strain) * x.x, x.y, x.z);
    let x: Vec<_> = rest(body.lattice()).iter().map(stretched).collect();
    body.set_positions(&points(&x)).unwrap();
}

#[test]
fn a_spinning_body_has_the_momenta_and_the_energy_of_its_inertia() {
    let (size, h, spin, velocity) =
        (Vector3::new(4.0, 3.0, 2.0), 0.5, Vector3::new(0.3, -1.1, 2.0), [1.0, 2.0, -3.0]);
    let body = builder(&half_cells()).density(12.0).spin(spin.into()).velocity(velocity).build().unwrap();
    let mass = 12.0 * 24.0 * h * h * h;
    assert!((body.mass() - mass).abs() < 1e-12 * mass);
    let center = Point3::new(1.0, 2.0, 3.0) + size * h / 2.0;
    assert!((body.center_of_mass() - center).norm() < F32);
    // Along an axis of N cells, vertices of mass 1 and 1/2 at both ends have the mean square distance
    // (N²/12 + 1/6) h² from the center.
    let square = size.map(|n| (n * n / 12.0 + 1.0 / 6.0) * h * h);
    let inertia = Matrix3::from_diagonal(&square.map(|s| mass * (square.sum() - s)));
    close(body.linear_momentum(), mass * Vector3::from(velocity), F32);
    close(body.angular_momentum(), inertia * spin, F32);
    let energy = 0.5 * mass * Vector3::from(velocity).norm_squared() + 0.5 * spin.dot(&(inertia * spin));
    assert!((body.kinetic_energy() - energy).abs() < F32 * energy);
}

#[test]
fn a_thrown_body_keeps_its_momentum_and_gains_what_gravity_gives() {
    let (velocity, gravity, dt, steps) =
        (Vector3::new(2.0, 5.0, 0.0), Vector3::new(0.0, -9.81, 1.0), 0.01, 50);
    let body = builder(&half_cells()).velocity(velocity.into()).spin([0.0, 3.0, 0.0]).build().unwrap();
    let mut sim = Simulation::builder().body(body).gravity(<[f64; 3]>::from(gravity)).dt(dt).build().unwrap();
    let energy = |sim: &Simulation| sim.body(0).kinetic_energy() + sim.body(0).gravity_energy().unwrap();
    let (mass, spin, before) = (sim.body(0).mass(), sim.body(0).angular_momentum(), energy(&sim));
    assert!(
        (before - sim.body(0).kinetic_energy() + mass * gravity.dot(&sim.body(0).center_of_mass().coords))
            .abs()
            < 1e-9
    );
    sim.steps(steps);
    let seconds = steps as f64 * dt;
    close(sim.body(0).linear_momentum(), mass * (velocity + gravity * seconds), F32);
    close(sim.body(0).angular_momentum(), spin, 1e-5);
    // The velocity v + n h g and the position x + n h v + n (n + 1)/2 h² g give the energy change -n h² |g|²/2 m. The
    // spin stretches the body, and part of its kinetic energy becomes elastic.
    let elastic = sim.body(0).elastic_energy().unwrap();
    let expected = before - 0.5 * mass * gravity.norm_squared() * dt * seconds;
    assert!((energy(&sim) + elastic - expected).abs() < 1e-3 * expected.abs(), "{} {expected}", energy(&sim));
}

#[test]
fn the_elastic_energy_of_a_stretched_bar_is_that_of_youngs_modulus() {
    let (h, w, strain, modulus) = (0.25, 2, 0.01, 3e5);
    let energy = |length: i32| {
        let mut body = builder(&cells([length, 3, 2], h)).youngs_modulus(modulus).build().unwrap();
        stretch(&mut body, strain);
        // Steps for which w is the least half-width.
        let dt = 0.95 * h * (1000.0 * f64::from(w * (w + 1)) / (3.0 * modulus)).sqrt();
        let sim = Simulation::builder().body(body).dt(dt).sleep(false).build().unwrap();
        assert_eq!(sim.body(0).half_width(), w as usize);
        assert!((sim.body(0).youngs_modulus().unwrap() - modulus).abs() < 1e-9 * modulus);
        sim.body(0).elastic_energy().unwrap()
    };
    let expected = |cells: i32| 0.5 * modulus * strain * strain * f64::from(cells * 3 * 2) * h * h * h;
    let (short, long) = (energy(40), energy(60));
    // The same ends: the difference is the energy of 20 cells inside. The positions are rounded to f32, an error of
    // 60 x 6e-8 cells beside deviations of `strain` cells from the goal positions.
    let inside = long - short;
    assert!((inside / expected(20) - 1.0).abs() < 1e-3, "{inside} {}", expected(20));
    // Regions that are cut off by an end, or have a vertex whose other regions are, differ: 2 w at each end.
    assert!((long / expected(60) - 1.0).abs() < f64::from(4 * w) / 60.0, "{long} {}", expected(60));
}

#[test]
fn a_rotated_body_at_rest_has_no_elastic_energy() {
    let mut body = bare(&lattice(&block([12, 3, 4])), 2);
    let turn = Random(5).rotation();
    let x: Vec<_> = rest(body.lattice()).iter().map(|x| turn * x + Vector3::repeat(1e5)).collect();
    let strain = 1e-3;
    let mut stretched = bare(&lattice(&block([12, 3, 4])), 2);
    stretch(&mut stretched, strain);
    let reference = without_gravity(stretched).body(0).elastic_energy().unwrap();
    body.set_positions(&points(&x)).unwrap();
    let energy = without_gravity(body).body(0).elastic_energy().unwrap();
    // An energy is quadratic in the strain: this bound is that of a strain of 1e-6.
    assert!((0.0..=1e-6 * reference).contains(&energy), "{energy} {reference}");
}

#[test]
fn a_free_undamped_body_keeps_its_energy() {
    let (alpha, dt) = (0.01, 0.01);
    let mut body = builder(&cells([20, 4, 3], 0.1)).stiffness(alpha).half_width(2).build().unwrap();
    stretch(&mut body, 0.01);
    let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).dt(dt).sleep(false).build().unwrap();
    let elastic = |sim: &Simulation| sim.body(0).elastic_energy().unwrap();
    let start = elastic(&sim);
    let (mut most_kinetic, mut worst_sum, mut worst_leapfrog) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..2000 {
        let before = sim.body(0).velocities();
        let potential = elastic(&sim);
        sim.step();
        let after = sim.body(0).velocities();
        let masses = sim.body(0).masses();
        let kinetic: f64 = before.iter().zip(&after).zip(&masses).map(|((a, b), m)| 0.5 * m * a.dot(b)).sum();
        worst_leapfrog = worst_leapfrog.max((kinetic + potential - start).abs());
        worst_sum = worst_sum.max((sim.body(0).kinetic_energy() + elastic(&sim) - start).abs());
        most_kinetic = most_kinetic.max(sim.body(0).kinetic_energy());
    }
    // The energy changes its form.
    assert!(most_kinetic > 0.5 * start, "{most_kinetic} of {start}");
    // The leapfrog conserves Σ m v₋·v₊/2 + V of a harmonic potential V. V is harmonic up to terms of the relative size
    // of the strain, of which the leapfrog loses about (h ω)² <= alpha: 1e-4. Goal positions are rounded to f32 by 1e-6
    // cells, beside their distance from the vertices of about w (w + 1)/6 (π/20)² 0.1 cells = 2e-3: 4e-4.
    assert!(worst_leapfrog < 5e-4 * start, "{worst_leapfrog} of {start}");
    // A mode of the angular frequency ω exchanges h ω/2 of its energy, and h ω <= √alpha.
    assert!(worst_sum < 0.5 * alpha.sqrt() * start, "{worst_sum} of {start}");
}

#[test]
fn masses_momenta_and_energies_scale_with_the_density() {
    let sim = |density: f64| {
        let mut body = builder(&half_cells()).spin([1.0, 2.0, 3.0]).build().unwrap();
        body.set_density(density).unwrap();
        stretch(&mut body, 0.1);
        Simulation::builder().body(body).gravity([0.0, -9.81, 0.0]).build().unwrap()
    };
    let (light, heavy) = (sim(500.0), sim(4000.0));
    let (light, heavy) = (light.body(0), heavy.body(0));
    let same = |a: f64, b: f64| assert!((8.0 * a - b).abs() < 1e-12 * b.abs(), "{a} {b}");
    same(light.mass(), heavy.mass());
    same(light.kinetic_energy(), heavy.kinetic_energy());
    same(light.elastic_energy().unwrap(), heavy.elastic_energy().unwrap());
    same(light.gravity_energy().unwrap(), heavy.gravity_energy().unwrap());
    close(8.0 * light.angular_momentum(), heavy.angular_momentum(), 1e-12);
    assert!((light.center_of_mass() - heavy.center_of_mass()).norm() < 1e-12);
    // Given Young's modulus, the elastic energy does not depend on the density.
    let stiff = |density: f64| {
        let mut body = builder(&half_cells()).youngs_modulus(1e4).density(density).build().unwrap();
        stretch(&mut body, 0.1);
        Simulation::builder().body(body).dt(0.02).build().unwrap().body(0).elastic_energy().unwrap()
    };
    assert!((stiff(1000.0) - stiff(1200.0)).abs() < 1e-9 * stiff(1000.0));
}

#[test]
fn energies_need_a_simulation() {
    let body = bare(&half_cells(), 1);
    assert_eq!((body.alone().elastic_energy(), body.alone().gravity_energy()), (None, None));
}

#[test]
fn the_mass_of_a_cell_is_a_finite_number_above_zero() {
    for (cell_size, density) in [(1e-3, 1e-320), (1e100, 1e300), (1e110, 1000.0)] {
        let lattice = Lattice::from_cells(&[[0; 3]], cell_size, Point3::origin(), true).unwrap();
        let error = Body::from_lattice(lattice).density(density).build().unwrap_err().to_string();
        assert!(error.contains("density x cell_size^3"), "{error}");
    }
    let lattice = Lattice::from_cells(&[[0; 3]], 1e100, Point3::origin(), true).unwrap();
    let mut body = Body::from_lattice(lattice).build().unwrap();
    assert!(body.set_density(1e10).is_err());
    assert_eq!(body.material().density, 1000.0);
}

/// The end of a bar 1 x 1 x s that is held at the other end sinks by 3/2 s^(8/3)/k of its length: up to s = 4, and a longer
/// bar as one of 4.
#[test]
fn a_slender_body_of_a_named_material_is_stiffer() {
    let relative_modulus = |mesh: Mesh, size: f64, vertices: usize| {
        let body = Body::builder(mesh).lattice_vertices(vertices).build().unwrap();
        let simulation = Simulation::builder().body(body).gravity([0.0, -9.81, 0.0]).fps(60.0);
        let mut simulation = simulation.substeps(Substeps::Auto).build().unwrap();
        simulation.advance(1);
        simulation.body(0).youngs_modulus().unwrap() / (1000.0 * size * 9.81_f64.max(8.0 * size))
    };
    let flesh = Preset::Flesh.relative_modulus();
    for length in [1.0_f64, 3.9, 10.0, 20.0] {
        let expected = flesh * (length / 4.0).max(1.0).powf(8.0 / 3.0);
        for vertices in [300, 3000] {
            let mesh = mesh_of(plain_box([0.0; 3], [1.0, length, 1.0]));
            let ratio = relative_modulus(mesh, length.cbrt(), vertices) / expected;
            assert!((ratio - 1.0).abs() < 1e-9, "1 x {length} x 1, {vertices} vertices: {ratio}");
        }
    }
    // A ribbon is a cloth, whatever its length.
    let ribbon =
        Mesh::new(vec![[0.0; 3], [20.0, 0.0, 0.0], [20.0, 1.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2, 3]])
            .unwrap();
    let size = 0.1 * 20.0;
    assert!((relative_modulus(ribbon, size, 300) / flesh - 1.0).abs() < 1e-9);
}
