//! The naive reference: its invariants and its rotation factor.

use nalgebra::{Matrix3, Matrix4, Point3, Rotation3, Vector3};
use proptest::prelude::*;
use supple::reference::{Naive, Regions, damped_velocities, goals, region, rotation, weights};
use supple::{Body, Lattice, Material, Mesh, Pin, Selection, Simulation, TimeWindow};
use supple_tests::block;

const KINDS: [Regions; 2] = [Regions::Staircase, Regions::BreadthFirst];

fn lattice(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 0.5, Point3::new(3.0, -1.0, 2.0), true).expect("cells make a lattice")
}

/// Returns the cells of two arms on a foot, with a gap of one cell between them.
fn u_shape() -> Vec<[i32; 3]> {
    let mut cells = block([3, 5, 2]);
    cells.retain(|c| c[0] != 1 || c[1] == 0);
    cells
}

fn rest(lattice: &Lattice) -> Vec<Vector3<f64>> {
    (0..lattice.len() as u32).map(|v| lattice.rest_position(v).coords).collect()
}

/// Returns smoothly deformed positions.
fn bent(lattice: &Lattice) -> Vec<Vector3<f64>> {
    rest(lattice)
        .iter()
        .map(|p| Vector3::new(p.x + 0.3 * (2.0 * p.y).sin(), 1.2 * p.y, p.z + 0.2 * (3.0 * p.x).cos()))
        .collect()
}

fn sum(masses: &[f64], values: &[Vector3<f64>]) -> Vector3<f64> {
    masses.iter().zip(values).map(|(m, x)| x * *m).sum()
}

#[test]
fn both_kinds_of_region_are_cubes_in_a_box() {
    let lattice = lattice(&block([6, 6, 6]));
    for w in 0..4usize {
        for v in [0, 20, 171, 342] {
            let expected: Vec<u32> = (0..lattice.len() as u32)
                .filter(|&o| {
                    let (a, b) = (lattice.indices()[v as usize], lattice.indices()[o as usize]);
                    (0..3).all(|k| a[k].abs_diff(b[k]) as usize <= w)
                })
                .collect();
            for kind in KINDS {
                assert_eq!(region(&lattice, v, w, kind), expected);
            }
        }
    }
}

#[test]
fn regions_stop_at_a_gap() {
    let lattice = lattice(&u_shape());
    let tip = lattice.vertex_at([1, 5, 0]).expect("on the left arm");
    for kind in KINDS {
        // The tip of the left arm: its vertices of the highest two cells.
        let expected: Vec<u32> = (0..lattice.len() as u32)
            .filter(|&v| lattice.indices()[v as usize][0] <= 1 && lattice.indices()[v as usize][1] >= 3)
            .collect();
        assert_eq!(region(&lattice, tip, 2, kind), expected, "{kind:?}");
    }
    let foot = lattice.vertex_at([1, 1, 0]).expect("on the foot");
    assert!(
        region(&lattice, foot, 1, Regions::Staircase).iter().any(|&v| lattice.indices()[v as usize][0] == 2)
    );
}

#[test]
fn the_two_regions_differ_at_a_concave_corner() {
    // From the inner side of the left arm, the far vertex is one link down, then one along the top of the
    // foot.
    let lattice = lattice(&u_shape());
    let inner = lattice.vertex_at([1, 2, 0]).expect("on the left arm");
    let far = lattice.vertex_at([2, 1, 0]).expect("on the foot");
    assert!(region(&lattice, inner, 1, Regions::Staircase).contains(&far));
    assert!(!region(&lattice, inner, 1, Regions::BreadthFirst).contains(&far));
    // Staircase regions are not symmetric.
    assert!(!region(&lattice, far, 1, Regions::Staircase).contains(&inner));
}

#[test]
fn goals_keep_linear_momentum() {
    for cells in [block([4, 3, 2]), u_shape(), block([8, 1, 1]), block([1, 1, 1])] {
        let lattice = lattice(&cells);
        let positions = bent(&lattice);
        for kind in KINDS {
            for w in 1..4 {
                let masses = weights(&lattice, w, kind).masses;
                let goals = goals(&lattice, &positions, w, kind);
                let (before, after) = (sum(&masses, &positions), sum(&masses, &goals));
                assert!((before - after).norm() <= 1e-13 * before.norm(), "{kind:?} {w}: {before} {after}");
            }
        }
    }
}

#[test]
fn goals_keep_angular_momentum() {
    let lattice = lattice(&u_shape());
    let positions = bent(&lattice);
    for kind in KINDS {
        let masses = weights(&lattice, 2, kind).masses;
        let goals = goals(&lattice, &positions, 2, kind);
        let torque: Vector3<f64> =
            (0..lattice.len()).map(|i| positions[i].cross(&(goals[i] - positions[i])) * masses[i]).sum();
        assert!(torque.norm() < 1e-12, "{torque}");
    }
}

#[test]
fn the_goals_of_a_rigid_motion_are_its_positions() {
    let turn = Rotation3::new(Vector3::new(0.7, -1.9, 0.4));
    for cells in [block([4, 3, 2]), u_shape(), block([1, 1, 1])] {
        let lattice = lattice(&cells);
        let moved: Vec<_> = rest(&lattice).iter().map(|p| turn * p + Vector3::new(10.0, -4.0, 7.0)).collect();
        for kind in KINDS {
            for w in 1..4 {
                for (goal, position) in goals(&lattice, &moved, w, kind).iter().zip(&moved) {
                    assert!((goal - position).norm() < 1e-13 * 30.0);
                }
            }
        }
    }
}

#[test]
fn damping_keeps_rigid_motions_and_both_momenta_and_removes_energy() {
    let lattice = lattice(&u_shape());
    let turn = Rotation3::new(Vector3::new(0.2, 0.5, -0.3));
    let positions: Vec<_> = rest(&lattice).iter().map(|p| turn * p).collect();
    let (spin, drift) = (Vector3::new(0.3, -2.0, 1.0), Vector3::new(5.0, 0.1, -1.0));
    let rigid: Vec<_> = positions.iter().map(|p| drift + spin.cross(p)).collect();
    let irregular: Vec<_> =
        positions.iter().map(|p| Vector3::new((7.0 * p.x).sin(), p.y * p.z, (5.0 * p.z).cos())).collect();
    for kind in KINDS {
        let damped = damped_velocities(&lattice, &positions, &rigid, 2, kind, 1.0);
        assert!(damped.iter().zip(&rigid).all(|(a, b)| (a - b).norm() < 1e-12));
        let masses = weights(&lattice, 2, kind).masses;
        let damped = damped_velocities(&lattice, &positions, &irregular, 2, kind, 0.7);
        assert!((sum(&masses, &damped) - sum(&masses, &irregular)).norm() < 1e-12);
        let angular = |v: &[Vector3<f64>]| -> Vector3<f64> {
            (0..v.len()).map(|i| positions[i].cross(&v[i]) * masses[i]).sum()
        };
        assert!((angular(&damped) - angular(&irregular)).norm() < 1e-12);
        let energy =
            |v: &[Vector3<f64>]| -> f64 { v.iter().zip(&masses).map(|(v, m)| m * v.norm_squared()).sum() };
        assert!(energy(&damped) < energy(&irregular));
        assert_eq!(damped_velocities(&lattice, &positions, &irregular, 2, kind, 0.0), irregular);
    }
}

#[test]
fn mass_times_offset_from_the_goal_is_the_gradient_of_the_mismatch() {
    let lattice = lattice(&u_shape());
    for kind in KINDS {
        let naive = Naive::new(&lattice, 2, kind).listed();
        assert!(naive.matching_energy(&naive.motions(&rest(&lattice)), &rest(&lattice)) < 1e-28);
        let matching_energy = |x: &[Vector3<f64>]| naive.matching_energy(&naive.motions(x), x);
        let mut x = bent(&lattice);
        let goals = naive.goals(&naive.motions(&x));
        assert_eq!(goals, supple::reference::goals(&lattice, &x, 2, kind));
        for (vertex, mass) in naive.weights().masses.iter().enumerate().step_by(7) {
            for axis in 0..3 {
                let (at, by) = (x[vertex][axis], 1e-5);
                let mut shifted = |by: f64| {
                    x[vertex][axis] = at + by;
                    matching_energy(&x)
                };
                let slope = (shifted(by) - shifted(-by)) / (2.0 * by);
                x[vertex][axis] = at;
                assert!((slope - mass * (at - goals[vertex][axis])).abs() < 1e-9, "{slope}");
            }
        }
    }
}

/// Returns the largest tr(R^T A) of all rotations R: the largest eigenvalue of Davenport's matrix of A.
fn largest_trace(a: &Matrix3<f64>) -> f64 {
    let (t, axial) = (a.trace(), Vector3::new(a.m32 - a.m23, a.m13 - a.m31, a.m21 - a.m12));
    let mut k = Matrix4::zeros();
    k.fixed_view_mut::<3, 3>(0, 0).copy_from(&(a + a.transpose() - Matrix3::identity() * t));
    k.fixed_view_mut::<3, 1>(0, 3).copy_from(&axial);
    k.fixed_view_mut::<1, 3>(3, 0).copy_from(&axial.transpose());
    k[(3, 3)] = t;
    k.symmetric_eigenvalues().max()
}

/// Asserts that the reference rotation of `a` is a rotation that maximizes tr(R^T A).
fn check_rotation(a: &Matrix3<f64>) {
    let r = rotation(a);
    assert!((r.transpose() * r - Matrix3::identity()).amax() < 1e-14, "{a} {r}");
    assert!((r.determinant() - 1.0).abs() < 1e-14, "{a} {r}");
    let s = (r.transpose() * a).map(|x| x / a.amax().max(f64::MIN_POSITIVE));
    assert!((s - s.transpose()).amax() < 1e-14 * 3.0, "not symmetric: {a} {r}");
    let largest = largest_trace(&a.map(|x| x / a.amax().max(f64::MIN_POSITIVE)));
    assert!(s.trace() >= largest - 1e-13, "{a}: {} of {largest}", s.trace());
}

/// Returns the factor in the fits, with regions of half-width 2, of a held vertex with one held vertex beside it.
fn held_factor(lattice: &Lattice, vertex: u32) -> f64 {
    let count = weights(lattice, 2, Regions::Staircase).counts[vertex as usize];
    (2.0 * (count as f64).powf(2.0 / 3.0) / 2.0).max(2.0)
}

#[test]
fn the_fits_of_a_body_use_its_fit_masses() {
    // The corners of a box, which fills its outer cells partly.
    let corners =
        (0..8).map(|k| [2.3 * f64::from(k & 1), 1.7 * f64::from(k >> 1 & 1), 2.6 * f64::from(k >> 2)]);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mesh = Mesh::new(corners.collect(), &quads).unwrap();
    let pin = Pin {
        goal: None,
        selection: Selection::Vertices(vec![0, 1]),
        window: TimeWindow { start: 0.0, end: 0.1 },
    };
    let body =
        Body::builder(mesh).cell_size(0.5).density(7.0).material(Material::fast_lsm()).pin(pin).build();
    let mut simulation = Simulation::builder().body(body.unwrap()).dt(0.05).sleep(false).build().unwrap();
    // w N^(2/3)/k with the half-width w = 2: the regions of the two vertices, which are neighbors at the end of an edge,
    // have N vertices, and each contains the other, so that k = 2.
    for (steps, is_held) in [(1, true), (3, false)] {
        simulation.steps(steps);
        let body = simulation.body(0);
        let full_cell = body.material().density * body.lattice().cell_size().powi(3);
        let masses = body.fit_masses();
        for (vertex, (fit, mass)) in masses.iter().zip(body.masses()).enumerate() {
            let factor = if is_held && vertex < 2 { held_factor(body.lattice(), vertex as u32) } else { 1.0 };
            let expected = mass / full_cell * factor;
            assert!((fit / expected - 1.0).abs() < 1e-6, "{vertex}: {fit}, {expected}");
        }
        let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
        let distance = |naive: &Naive<'_>| {
            let goals = naive.goals(&naive.motions(&positions));
            let pairs = goals.iter().zip(body.goals());
            pairs.map(|(a, b)| (a - b.coords).norm()).fold(0.0, f64::max) / body.lattice().cell_size()
        };
        let bare = Naive::new(body.lattice(), body.half_width(), Regions::Staircase);
        assert!(distance(&bare) > 1e-4, "{}", distance(&bare));
        // Coordinates of up to 8 cells are rounded to 2^-21 cells in f32.
        let with_masses = bare.with_masses(masses);
        assert!(distance(&with_masses) < 2e-6, "{}", distance(&with_masses));
    }
}

#[test]
#[should_panic(expected = "`masses` must match the lattice vertices")]
fn masses_of_the_reference_match_the_lattice() {
    let lattice = lattice(&block([1; 3]));
    let _ = Naive::new(&lattice, 1, Regions::Staircase).with_masses(vec![1.0; 7]);
}

#[test]
fn singular_and_inverted_matrices_have_optimal_rotations() {
    let diagonal = |x, y, z| Matrix3::from_diagonal(&Vector3::new(x, y, z));
    for a in [
        Matrix3::identity(),
        Matrix3::zeros(),
        -Matrix3::identity(),
        diagonal(1.0, 1.0, -1.0),
        diagonal(2.0, 1.0, 0.0),
        diagonal(1.0, 0.0, 0.0),
        diagonal(-1.0, 0.0, 0.0),
        diagonal(1.0, 1e-9, 1e-18),
        diagonal(1.0, 1.0, 1e-300),
        diagonal(1e-300, 2e-300, -3e-300),
        diagonal(1e300, 2e300, -3e300),
        Vector3::new(1.0, 2.0, 3.0) * Vector3::new(-1.0, 0.5, 2.0).transpose(),
    ] {
        check_rotation(&a);
    }
    assert_eq!(rotation(&Matrix3::from_element(f64::NAN)), Matrix3::identity());
    assert_eq!(rotation(&Matrix3::from_element(f64::INFINITY)), Matrix3::identity());
    assert!((rotation(&Matrix3::from_diagonal_element(5e-324)) - Matrix3::identity()).amax() < 1e-15);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rotations_maximise_the_trace_globally(
        entries in prop::array::uniform9(-1.0..1.0f64),
        flat in prop::option::of(0..3usize),
        exponent in -100..100i32,
    ) {
        let mut a = Matrix3::from_column_slice(&entries);
        if let Some(column) = flat {
            a.column_mut(column).scale_mut(1e-12);
        }
        check_rotation(&(a * 10f64.powi(exponent)));
    }
}
