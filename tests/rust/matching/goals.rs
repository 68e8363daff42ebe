//! Fast lattice shape matching compared with the naive reference.

use nalgebra::{Matrix3, Vector3};
use supple::reference::{self, Regions};
use supple::{Body, Material, Simulation};
use supple_tests::{
    Random, bare, block, coordinates, difficult_lattices, points, rest, rigid_fit, tolerance, worst,
};

/// Returns a shape with a stretch, noise and a rotation.
fn deformed(x: &[Vector3<f64>], random: &mut Random) -> Vec<Vector3<f64>> {
    let turn = random.rotation();
    let stretch = Matrix3::from_diagonal(&Vector3::new(1.3, 0.8, 1.1));
    let middle = x.iter().sum::<Vector3<f64>>() / x.len() as f64;
    x.iter().map(|x| turn * (stretch * (x - middle)) + random.vector() * 0.2).collect()
}

fn extent(x: &[Vector3<f64>]) -> f64 {
    x.iter().map(|x| x.amax()).fold(1.0, f64::max)
}

#[test]
fn goals_equal_the_reference() {
    let mut random = Random(1);
    for (name, lattice) in difficult_lattices() {
        for half_width in [0.5, 1.0, 2.0, 3.0, 4.0, 5.0] {
            let x = deformed(&rest(&lattice), &mut random);
            let mut body = bare(&lattice, half_width);
            body.set_positions(&points(&x)).unwrap();
            let fast = coordinates(&body.goals());
            let naive = reference::goals(&lattice, &x, half_width, Regions::Staircase);
            let error = worst(&fast, &naive);
            assert!(error <= tolerance(extent(&x)), "{name}, w = {half_width}: {error:e} cells");
        }
    }
}

/// Wide windows use other summations: running sums, and sums within blocks. They break at gaps as well.
#[test]
fn wide_regions_equal_the_reference() {
    let mut random = Random(2);
    let long =
        [[30, 5, 4], [4, 30, 5], [5, 4, 30]].map(|size| ("long box", supple_tests::lattice(&block(size))));
    for (name, lattice) in long.into_iter().chain(difficult_lattices()) {
        for half_width in [6, 9, 16, 1000] {
            let x = deformed(&rest(&lattice), &mut random);
            let mut body = bare(&lattice, half_width);
            body.set_positions(&points(&x)).unwrap();
            let naive = reference::goals(&lattice, &x, half_width.min(64), Regions::Staircase);
            let error = worst(&coordinates(&body.goals()), &naive);
            // Sums of more terms round more.
            assert!(error <= 2.0 * tolerance(extent(&x)), "{name}, w = {half_width}: {error:e} cells");
        }
    }
}

#[test]
fn the_goals_of_a_rigid_motion_are_its_positions_also_far_away() {
    let mut random = Random(3);
    for (name, lattice) in difficult_lattices() {
        for away in [0.0, 1e3, 1e6] {
            let turn = random.rotation();
            let shift = random.vector() * away;
            let middle = rest(&lattice).iter().sum::<Vector3<f64>>() / lattice.len() as f64;
            let x: Vec<_> = rest(&lattice).iter().map(|x| turn * (x - middle) + shift).collect();
            let mut body = bare(&lattice, 2);
            body.set_positions(&points(&x)).unwrap();
            let local: Vec<_> = x.iter().map(|x| x - shift).collect();
            let error = worst(&coordinates(&body.goals()), &x);
            // The origin of the body is a multiple of its extent, so its coordinates are up to twice as
            // large.
            assert!(error <= tolerance(2.0 * extent(&local)), "{name}, {away:e} cells away: {error:e}");
        }
    }
}

#[test]
fn goals_keep_both_momenta() {
    let mut random = Random(4);
    let widths = || [2.0, 0.5];
    for ((name, lattice), half_width) in
        difficult_lattices().into_iter().flat_map(|shape| widths().map(|w| (shape.clone(), w)))
    {
        let x = deformed(&rest(&lattice), &mut random);
        let mut body = bare(&lattice, half_width);
        body.set_positions(&points(&x)).unwrap();
        let goals = coordinates(&body.goals());
        let masses = body.masses();
        let mass: f64 = masses.iter().sum();
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for ((x, g), m) in x.iter().zip(&goals).zip(&masses) {
            force += (g - x) * *m / mass;
            torque += x.cross(&(g - x)) * *m / mass;
        }
        assert!(force.amax() < 2e-6, "{name}: force {force:e}");
        assert!(torque.amax() < 1e-5 * extent(&x), "{name}: torque {torque:e}");
    }
}

#[test]
fn positions_and_velocities_read_back_as_they_were_set() {
    let lattice = supple_tests::lattice(&supple_tests::block([5, 4, 3]));
    let mut random = Random(5);
    let mut body = bare(&lattice, 1);
    let x: Vec<_> =
        rest(&lattice).iter().map(|x| x + random.vector() + Vector3::new(1e6, -2e5, 3.0)).collect();
    let v: Vec<_> = x.iter().map(|_| random.vector()).collect();
    body.set_velocities(&v).unwrap();
    body.set_positions(&points(&x)).unwrap();
    assert!(worst(&coordinates(&body.positions()), &x) < 1e-9);
    assert!(worst(&body.velocities(), &v) < 1e-6);
}

#[test]
fn invalid_arrays_are_errors_that_name_the_array_and_change_nothing() {
    let lattice = supple_tests::lattice(&supple_tests::block([1, 1, 1]));
    let mut body = bare(&lattice, 1);
    let short = body.set_velocities(&[Vector3::zeros()]).unwrap_err().to_string();
    assert_eq!(short, "velocities has 1 entries; the body has 8 lattice vertices");
    let mut x = rest(&lattice);
    x[3].y = f64::NAN;
    let nan = body.set_positions(&points(&x)).unwrap_err().to_string();
    assert!(nan.starts_with("positions[3] = [1.0, NaN, 0.0]"), "{nan}");
    assert_eq!(worst(&coordinates(&body.positions()), &rest(&lattice)), 0.0);
}

#[test]
fn the_rigid_fit_of_a_rotated_body_is_its_rotation() {
    let lattice = supple_tests::lattice(&supple_tests::block([3, 4, 2]));
    let turn = Random(6).rotation();
    let x: Vec<_> = rest(&lattice).iter().map(|x| turn * x).collect();
    let (fit, ..) = rigid_fit(&bare(&lattice, 1).masses(), &rest(&lattice), &x);
    assert!((fit.matrix() - turn.matrix()).amax() < 1e-12);
}

#[test]
fn damping_equals_the_reference() {
    let mut random = Random(8);
    for (name, lattice) in difficult_lattices() {
        for half_width in [0.5, 1.0, 2.0, 3.0] {
            // The goals of a rotated body are its positions, so the step adds nothing to the damped
            // velocities.
            let turn = random.rotation();
            let x: Vec<_> = rest(&lattice).iter().map(|x| turn * x).collect();
            let v: Vec<_> = x.iter().map(|_| random.vector()).collect();
            let body = Body::from_lattice(lattice.clone())
                .material(Material::fast_lsm())
                .half_width(half_width)
                .stiffness(1e-3)
                .region_damping(0.6);
            let mut body = body.build().unwrap();
            body.set_positions(&points(&x)).unwrap();
            body.set_velocities(&v).unwrap();
            let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).threads(1).build().unwrap();
            sim.step();
            let naive = reference::damped_velocities(&lattice, &x, &v, half_width, Regions::Staircase, 0.6);
            let error = worst(&sim.body(0).velocities(), &naive);
            assert!(error < 1e-5, "{name}, w = {half_width}: {error:e} cells/s");
        }
    }
}
