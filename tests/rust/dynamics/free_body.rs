//! Free bodies: position, orientation and momenta are conserved.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use supple::{Body, Material, Simulation};
use supple_tests::{Random, bare, block, coordinates, lattice, points, rest, rigid_fit, worst};

const DT: f64 = 1.0 / 60.0;

fn free(body: Body) -> Simulation {
    Simulation::builder().body(body).gravity([0.0; 3]).dt(DT).threads(1).build().unwrap()
}

/// Returns the center of mass and the rotation from the rest pose.
fn pose(sim: &Simulation) -> (Vector3<f64>, Rotation3<f64>) {
    let body = sim.body(0);
    let (turn, _, center) = rigid_fit(&body.masses(), &rest(body.lattice()), &coordinates(&body.positions()));
    (center, turn)
}

/// Returns linear momentum, and angular momentum about the center of mass, both divided by the mass.
fn momenta(sim: &Simulation) -> (Vector3<f64>, Vector3<f64>) {
    let body = sim.body(0);
    let (x, v, m) = (coordinates(&body.positions()), body.velocities(), body.masses());
    let mass: f64 = m.iter().sum();
    let center = x.iter().zip(&m).map(|(x, m)| x * *m).sum::<Vector3<f64>>() / mass;
    let linear = v.iter().zip(&m).map(|(v, m)| v * *m).sum::<Vector3<f64>>() / mass;
    let angular =
        x.iter().zip(&v).zip(&m).map(|((x, v), m)| (x - center).cross(v) * *m).sum::<Vector3<f64>>() / mass;
    (linear, angular)
}

/// Adds noise to the rest positions, without net translation and rotation.
fn shaken(body: &mut Body, size: f64) {
    let x0 = rest(body.lattice());
    let mut random = Random(21);
    let noisy: Vec<_> = x0.iter().map(|x| x + random.vector() * size).collect();
    let (turn, c, d) = rigid_fit(&body.masses(), &x0, &noisy);
    let x: Vec<_> = noisy.iter().map(|x| turn.inverse() * (x - d) + c).collect();
    body.set_positions(&points(&x)).unwrap();
}

/// Stretches a body along its three axes of symmetry, so that it vibrates without rotation.
fn stretched(body: &mut Body, factors: Vector3<f64>) {
    let x0 = rest(body.lattice());
    let middle = x0.iter().sum::<Vector3<f64>>() / x0.len() as f64;
    let x: Vec<_> = x0.iter().map(|x| middle + (x - middle).component_mul(&factors)).collect();
    body.set_positions(&points(&x)).unwrap();
}

#[test]
fn a_free_body_keeps_its_position_and_orientation_for_100_000_steps() {
    let (still, stretch) = (Vector3::repeat(1.0), Vector3::new(1.15, 0.95, 0.9));
    for (factors, damping) in [(still, 0.0), (still, 0.1), (stretch, 0.0), (stretch, 0.1)] {
        let lattice = lattice(&block([7, 4, 5]));
        let mut body = Body::from_lattice(lattice)
            .material(Material::fast_lsm())
            .half_width(2)
            .stiffness(0.7)
            .region_damping(damping)
            .build()
            .unwrap();
        stretched(&mut body, factors);
        let mut sim = free(body);
        let before = pose(&sim);
        sim.steps(100_000);
        let after = pose(&sim);
        let turn = UnitQuaternion::from_rotation_matrix(&before.1.rotation_to(&after.1)).angle();
        let drift = (after.0 - before.0).norm();
        // Regression bounds.
        assert!(drift < 1e-3, "stretch {factors:?}, damping {damping}: the center moved by {drift:e} cells");
        assert!(turn < 1e-3, "stretch {factors:?}, damping {damping}: it turned by {turn:e} rad");
    }
}

#[test]
fn momenta_are_conserved_while_a_body_spins_and_vibrates() {
    for damping in [0.0, 0.2] {
        let mut random = Random(22);
        let lattice = lattice(&block([9, 3, 4]));
        let mut body = Body::from_lattice(lattice)
            .material(Material::fast_lsm())
            .half_width(1)
            .region_damping(damping)
            .build()
            .unwrap();
        shaken(&mut body, 0.2);
        let x = coordinates(&body.positions());
        let spin = Vector3::new(0.3, 1.1, -0.4);
        let v: Vec<_> =
            x.iter().map(|x| spin.cross(x) + random.vector() + Vector3::new(2.0, 0.0, 1.0)).collect();
        body.set_velocities(&v).unwrap();
        let mut sim = free(body);
        let before = momenta(&sim);
        sim.steps(2000);
        let after = momenta(&sim);
        assert!((before.0 - after.0).norm() < 1e-6, "damping {damping}: {before:?} {after:?}");
        assert!(
            (before.1 - after.1).norm() < 1e-5 * before.1.norm(),
            "damping {damping}: {before:?} {after:?}"
        );
    }
}

#[test]
fn a_fast_body_moves_a_million_cells_without_rotation_or_deformation() {
    let mut body = bare(&lattice(&block([4, 4, 4])), 2);
    let velocity = Vector3::new(60_000.0, -3_700.0, 1_100.0);
    body.set_velocities(&vec![velocity; body.lattice().len()]).unwrap();
    let mut sim = free(body);
    let start = pose(&sim).0;
    sim.steps(1_000);
    let (end, turn) = pose(&sim);
    let expected = velocity * (1_000.0 * DT);
    assert!(expected.norm() > 1e6);
    assert!((end - start - expected).norm() < 1e-3, "{end:?}");
    let turned = (turn.matrix() - Rotation3::identity().matrix()).amax();
    assert!(turned < 1e-5, "{turned}");
    let goals = coordinates(&sim.body(0).goals());
    let error = worst(&goals, &coordinates(&sim.body(0).positions()));
    assert!(error <= 1e-5, "after the flight the goals are {error:e} cells off");
}

#[test]
fn a_body_slower_than_the_f32_resolution_of_positions_keeps_its_velocity() {
    let mut body = bare(&lattice(&block([4, 4, 4])), 1);
    // 1.7e-8 cells per step. An ulp of the positions is ten times as large.
    let velocity = Vector3::new(1e-6, 0.0, 0.0);
    body.set_velocities(&vec![velocity; body.lattice().len()]).unwrap();
    let mut sim = free(body);
    let start = pose(&sim).0;
    sim.steps(20_000);
    let expected = velocity * (20_000.0 * DT);
    assert!((pose(&sim).0 - start - expected).norm() < 0.01 * expected.norm());
}

#[test]
fn a_body_falls_as_symplectic_euler() {
    let mut sim = Simulation::builder()
        .body(bare(&lattice(&block([3, 3, 3])), 2))
        .gravity([0.0, -9.81, 2.0])
        .dt(DT)
        .threads(1)
        .build()
        .unwrap();
    let start = pose(&sim).0;
    sim.steps(600);
    // Symplectic Euler: x = g dt² n (n + 1)/2.
    let fallen = Vector3::new(0.0, -9.81, 2.0) * (DT * DT * 600.0 * 601.0 / 2.0);
    assert!((pose(&sim).0 - start - fallen).norm() < 1e-6 * fallen.norm());
}

#[test]
fn components_keep_their_own_momenta() {
    let mut cells = block([3, 3, 3]);
    cells.extend(block([2, 2, 2]).into_iter().map(|[x, y, z]| [x + 8, y, z]));
    let lattice = lattice(&cells);
    assert_eq!(lattice.components().count, 2);
    let mut body = Body::from_lattice(lattice.clone())
        .material(Material::fast_lsm())
        .half_width(2)
        .region_damping(0.3)
        .build()
        .unwrap();
    let of = lattice.components().of_vertex.clone();
    let velocity = [Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, -2.0)];
    let v: Vec<_> = of.iter().map(|&c| velocity[c as usize]).collect();
    body.set_velocities(&v).unwrap();
    let mut sim = free(body);
    sim.steps(1000);
    let moved: Vec<_> = coordinates(&sim.body(0).positions())
        .iter()
        .zip(rest(&lattice))
        .zip(&of)
        .map(|((x, x0), &c)| x - x0 - velocity[c as usize] * (1000.0 * DT))
        .collect();
    assert!(moved.iter().all(|d| d.norm() < 1e-4), "{:?}", moved[0]);
}

#[test]
fn damping_keeps_a_rigid_motion_that_was_set() {
    let lattice = lattice(&block([6, 3, 4]));
    let mut body = Body::from_lattice(lattice.clone())
        .material(Material::fast_lsm())
        .half_width(2)
        .region_damping(0.9)
        .build()
        .unwrap();
    let turn = Rotation3::new(Vector3::new(0.9, -1.7, 0.4));
    let x: Vec<_> = rest(&lattice).iter().map(|x| turn * x).collect();
    let center = x.iter().zip(body.masses()).map(|(x, m)| x * m).sum::<Vector3<f64>>()
        / body.masses().iter().sum::<f64>();
    let (drift, spin) = (Vector3::new(0.5, 1.0, -2.0), Vector3::new(0.2, 0.1, -0.3));
    let v: Vec<_> = x.iter().map(|x| drift + spin.cross(&(x - center))).collect();
    body.set_positions(&points(&x)).unwrap();
    body.set_velocities(&v).unwrap();
    let mut sim = free(body);
    sim.step();
    let moved: Vec<_> = x.iter().zip(&v).map(|(x, v)| x + v * DT).collect();
    assert!(worst(&coordinates(&sim.body(0).positions()), &moved) < 1e-5);
}
