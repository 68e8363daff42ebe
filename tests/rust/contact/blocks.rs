//! Contacts: push-out, restitution, rest, contact displacements, culling.

use crate::block_body::Block;
use nalgebra::{Matrix3, Point3, Vector3};
use proptest::prelude::*;
use supple::Collider;
use supple::euler_degrees;
use supple::internals::{Colliders, Interval};

const DT: f64 = 1.0 / 60.0;
const CELL: f64 = 0.3;

fn colliders(list: &[Collider]) -> Colliders {
    Colliders::new(list).unwrap()
}

fn ground() -> Collider {
    Collider::plane([0.0; 3], [0.0, 1.0, 0.0])
}

/// Returns the height of the lowest sample above the plane y = 0, in cells.
fn lowest(block: &Block) -> f64 {
    block.surface().iter().map(|p| p.y).fold(f64::INFINITY, f64::min) / block.frame.cell_size
}

fn vertices_of(block: &Block) -> Vec<[f64; 3]> {
    (0..block.rest.len()).map(|v| block.position(v).into()).collect()
}

#[test]
fn one_penetrating_sample_is_moved_to_the_surface_without_a_velocity_change() {
    for local in [[0.3, 0.6, 0.2], [0.0, 0.0, 0.0], [1.0, 0.5, 0.0], [0.5, 0.5, 0.5], [0.99, 0.01, 0.4]] {
        let mut block = Block::new([1, 1, 1], CELL, Some(vec![(0, local)]));
        let frame = block.frame;
        block.place(&euler_degrees([20.0, 30.0, -50.0]), Point3::new(0.2, -0.1, 0.4));
        let before = block.sample(0);
        let normal = Vector3::new(1.0, 2.0, -0.5).normalize();
        let point = frame.origin + (before + normal * 0.21) * frame.cell_size;
        let plane = colliders(&[Collider::plane(point.into(), normal.into())]);
        let report = block.resolve(&plane, Interval::of_step(0, DT));
        assert_eq!(report.contacts, 1);
        assert!((report.deepest - 0.21).abs() < 1e-6);
        assert!((block.sample(0) - before - normal * 0.21).norm() < 1e-5, "{local:?}");
        // The body was at rest, and the displacement adds no velocity.
        assert!((0..8).all(|v| block.velocity(v) == Vector3::zeros()));
    }
}

/// A shallow overlap is removed by velocities, so that the surface of a resting body moves without visible jumps.
#[test]
fn a_shallow_sample_is_moved_by_a_fifth_of_its_depth_in_a_step() {
    for (depth, part) in [(0.005, 0.2), (0.02, 1.0)] {
        let mut block = Block::new([1, 1, 1], CELL, Some(vec![(0, [0.3, 0.0, 0.2])]));
        block.place(&Matrix3::identity(), Point3::new(0.0, -depth * CELL, 0.0));
        let before = block.sample(0);
        block.resolve(&colliders(&[ground()]), Interval::of_step(0, DT));
        let moved = (block.sample(0) - before).y;
        assert!((moved / (part * depth) - 1.0).abs() < 0.01, "{depth}: {moved}");
    }
}

#[test]
fn a_flat_face_is_moved_to_the_surface_in_one_step_without_overshoot() {
    let mut block = Block::new([3, 2, 4], CELL, None);
    block.place(&Matrix3::identity(), Point3::new(0.0, -0.2 * CELL, 0.0));
    block.resolve(&colliders(&[ground()]), Interval::of_step(0, DT));
    for (i, p) in block.surface().iter().enumerate() {
        assert!(p.y > -1e-4 * CELL && p.y < (2.0 + 1e-3) * CELL, "sample {i} at {p}");
    }
    let bottom = block.rest.iter().indices_where(|r| r.y == 0.0);
    for v in bottom {
        let y = block.position(v).y * CELL + block.frame.origin.y;
        assert!(y.abs() < 1e-3 * CELL, "vertex {v} at {y}");
    }
}

#[test]
fn the_deepest_of_many_samples_is_moved_to_the_surface() {
    // A curved lower side: 40 samples in each of 16 cells, few of them deep, moving down by half a cell per
    // step.
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let samples: Vec<_> = (0..16 * 40)
        .map(|i| {
            let (cell, x, z) = (i % 16, random(), random());
            let (far_x, far_z) = ((cell % 4) as f32 + x - 2.0, (cell / 4) as f32 + z - 2.0);
            (cell, [x, 0.1 * (far_x * far_x + far_z * far_z), z])
        })
        .collect();
    let mut block = Block::new([4, 1, 4], CELL, Some(samples));
    block.place(&Matrix3::identity(), Point3::new(0.0, -0.5 * CELL, 0.0));
    block.set_velocity(Vector3::new(0.0, -0.5 * CELL / DT, 0.0));
    // Samples up to 1e-3 cells above the plane are contacts.
    let heights: Vec<f64> = block.surface().iter().map(|p| p.y / CELL).collect();
    let expected = heights.iter().filter(|y| **y <= 1e-3).count();
    let deepest = -heights.iter().copied().fold(f64::INFINITY, f64::min);
    let report = block.resolve(&colliders(&[ground()]), Interval::of_step(0, DT));
    assert!(expected > 300, "{expected} samples below the plane");
    assert_eq!(report.contacts, expected);
    assert!((report.deepest - deepest).abs() < 1e-5, "{report:?}, {deepest}");
    assert!(lowest(&block) > -1e-3, "the lowest sample is at {} cells", lowest(&block));
}

#[test]
fn restitution_reverses_the_approach_velocity_but_not_that_of_one_step_of_gravity() {
    for restitution in [0.0, 0.4, 1.0] {
        let mut block = Block::new([1, 1, 1], CELL, Some(vec![(0, [0.2, 0.0, 0.7])]));
        block.place(&Matrix3::identity(), Point3::new(0.0, -0.01, 0.0));
        let plane = colliders(&[Collider { restitution, friction: 0.0, ..ground() }]);
        block.set_velocity(Vector3::new(1.0, -3.0, 0.5));
        block.resolve(&plane, Interval::of_step(0, DT));
        let after = block.sample_velocity(0) * CELL;
        assert!((after - Vector3::new(1.0, 3.0 * restitution, 0.5)).norm() < 1e-5, "{after}");

        // A body that rested on the plane at the start of the step.
        block.place(&Matrix3::identity(), Point3::new(0.0, -9.81 * DT * DT, 0.0));
        block.set_velocity(Vector3::new(0.0, -9.81 * DT, 0.0));
        block.resolve(&plane, Interval::of_step(0, DT));
        assert!(block.sample_velocity(0).y.abs() < 1e-5);
    }
}

#[test]
fn a_dropped_body_rises_to_its_height_times_the_squared_restitution() {
    // A contact at the center of one cell moves the whole cell.
    let restitution: f64 = 0.7;
    let mut block = Block::new([1, 1, 1], CELL, Some(vec![(0, [0.5; 3])]));
    let plane = colliders(&[Collider { restitution, ..ground() }]);
    block.place(&Matrix3::identity(), Point3::new(0.0, 2.0 - 0.5 * CELL, 0.0));
    let (mut hit, mut top) = (false, 0.0_f64);
    for _ in 0..2000 {
        hit |= block.step(&plane, 1e-3, 0.0).contacts > 0;
        if hit {
            top = top.max(block.center().y);
            if block.mean_velocity().y < 0.0 {
                break;
            }
        }
    }
    assert!((top / (2.0 * restitution * restitution) - 1.0).abs() < 0.01, "rose to {top}");
}

#[test]
fn a_body_comes_to_rest_with_its_lowest_point_on_the_ground() {
    for (restitution, tilt, damping) in [
        (0.0, [0.0; 3], 0.1),
        (0.5, [0.0; 3], 0.1),
        (0.0, [30.0, 0.0, 20.0], 0.5),
        (0.5, [10.0, 40.0, 0.0], 0.5),
    ] {
        let mut block = Block::new([3, 3, 3], CELL, None);
        block.damping = damping;
        let plane = colliders(&[Collider { restitution, ..ground() }]);
        block.place(&euler_degrees(tilt), Point3::new(0.0, 1.5, 0.0));
        let (mut largest, mut lowest_ever) = (0.0_f64, f64::INFINITY);
        for step in 0..900 {
            block.step(&plane, DT, 1.0);
            lowest_ever = lowest_ever.min(lowest(&block));
            if step >= 780 {
                largest = largest.max(lowest(&block).abs());
            }
        }
        // Regression bounds.
        assert!(lowest_ever > -0.05, "sank to {lowest_ever} cells");
        assert!(largest < 0.05, "{largest} cells off the ground");
        assert!(block.mean_velocity().norm() < 0.02, "{}", block.mean_velocity());
    }
}

#[test]
fn overlapping_and_repeated_colliders_support_a_body_like_one() {
    let corner = [ground(), ground(), Collider::plane([0.0; 3], [1.0, 0.0, 0.0])];
    let mut block = Block::new([2, 2, 2], CELL, None);
    block.place(&Matrix3::identity(), Point3::new(-0.2 * CELL, -0.24 * CELL, 0.0));
    let both = colliders(&corner);
    block.resolve(&both, Interval::of_step(0, DT));
    // Overlaps of up to 0.01 cells are not pushed out.
    for p in block.surface() {
        assert!(p.y > -1e-2 * CELL && p.x > -1e-2 * CELL, "{p}");
    }
    // Regression bounds: the lowest layer is at rest; the cells above it sway with little damping.
    block.run(900, &both, DT);
    assert!(lowest(&block).abs() < 0.05, "{}", lowest(&block));
    assert!(block.mean_velocity().norm() < 0.01, "{}", block.mean_velocity());
}

#[test]
fn hostile_colliders_displace_by_a_quarter_cell_per_step_and_give_finite_results() {
    let far = 1e300;
    let center = [0.45, 0.45, 0.45];
    let hostile = [
        Collider::sphere(center, 50.0),
        Collider::sphere([far, far, far], 1.0),
        Collider::sphere([-far, 0.0, 0.0], far),
        Collider::cuboid(center, [40.0, 1e-9, 40.0], [30.0, 0.0, 0.0]),
        Collider::cuboid([far, 0.0, -far], [far; 3], [1e9, 0.0, 0.0]),
        Collider::capsule(center, center, 3.0),
        Collider::capsule([-far, 0.0, 0.0], [far, 0.0, 0.0], 1.0),
        Collider::plane([far, far, 0.0], [0.0, 1.0, 1e-300]),
        Collider::plane([0.0, 30.0, 0.0], [0.0, 1e-200, 0.0]),
        Collider { friction: 1e300, restitution: 1.0, ..Collider::plane([0.0; 3], [-1.0, 1e-8, 0.0]) },
    ];
    for set in hostile.iter().map(std::slice::from_ref).chain([&hostile[..]]) {
        let (count, set) = (set.len(), colliders(set));
        let mut block = Block::new([3, 3, 3], CELL, None);
        block.place(&Matrix3::identity(), Point3::origin());
        // At rest a sample moves by at most a quarter of a cell per collider, and a vertex at most twice as
        // far.
        let before = vertices_of(&block);
        block.resolve(&set, Interval::of_step(0, DT));
        for (v, before) in before.iter().enumerate() {
            let moved = (block.position(v) - Vector3::from(*before)).norm();
            assert!(moved <= 0.5 * count as f64, "vertex {v} moved {moved} cells");
        }
        for _ in 0..300 {
            block.step(&set, DT, 1.0);
            assert!(vertices_of(&block).iter().flatten().all(|c| c.is_finite()));
            assert!((0..block.rest.len()).all(|v| block.velocity(v).iter().all(|c| c.is_finite())));
        }
    }
}

#[test]
fn two_runs_have_the_same_bits() {
    let run = || {
        let mut block = Block::new([3, 2, 2], CELL, None);
        block.place(&euler_degrees([20.0, 10.0, 5.0]), Point3::new(0.0, 0.6, 0.0));
        let set = colliders(&[ground(), Collider::sphere([0.3, -0.4, 0.2], 0.6)]);
        block.run(120, &set, DT);
        (
            block.positions.clone(),
            block.velocities.clone(),
            block.contacts.displacements().collect::<Vec<_>>(),
        )
    };
    assert_eq!(run(), run());
}

#[test]
fn contact_displacements_of_a_resting_body_carry_its_weight() {
    let mut block = Block::new([3, 3, 3], CELL, None);
    let plane = colliders(&[ground()]);
    block.place(&Matrix3::identity(), Point3::origin());
    block.run(1200, &plane, DT);
    block.contacts.clear_displacements();
    block.run(1, &plane, DT);
    let displacements: Vec<_> = block.contacts.displacements().collect();
    let touched: Vec<u32> = block.contacts.touched().collect();
    assert_eq!(displacements.len(), 16, "the vertices of the lowest layer");
    assert!(displacements.iter().all(|(v, push)| touched.contains(v) && push[0] == 0.0 && push[2] == 0.0));
    // At rest, gravity adds g dt to the velocity of each vertex and g dt² to its displacement in a step. The
    // contact displacement counts both: the push-out, and the velocity change times dt.
    let sum: f64 = displacements.iter().map(|(_, push)| f64::from(push[1])).sum();
    let fall = 9.81 * DT * DT / CELL * block.rest.len() as f64;
    assert!((sum / (2.0 * fall) - 1.0).abs() < 0.01, "{sum} of {}", 2.0 * fall);
    block.contacts.clear_displacements();
    assert_eq!(block.contacts.displacements().count(), 0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn culling_misses_no_contact(
        angles in prop::array::uniform3(-180.0..180.0_f64),
        place in prop::array::uniform3(-2.0..2.0_f64),
        size in prop::array::uniform3(0.05..1.5_f64),
        turn in prop::array::uniform3(-180.0..180.0_f64),
        squash in 0.1..3.0_f64,
        kind in 0..4,
    ) {
        let collider = match kind {
            0 => Collider::plane([0.0; 3], (euler_degrees(turn) * Vector3::y()).into()),
            1 => Collider::sphere([0.0; 3], size[0]),
            2 => Collider::cuboid([0.0; 3], size, turn),
            _ => Collider::capsule([0.0; 3], size, size[0]),
        };
        let mut block = Block::new([3, 2, 4], CELL, None);
        let deform = euler_degrees(angles) * Matrix3::from_diagonal(&Vector3::new(squash, 1.0, 1.0 / squash));
        block.place(&deform, Point3::from(place));
        let depths: Vec<f64> =
            block.surface().iter().map(|&p| -collider.shape.signed_distance(p.into()).distance / CELL).collect();
        let expected = depths.iter().filter(|d| **d >= -1e-3).count();
        let report = block.resolve(&colliders(&[collider]), Interval::of_step(0, DT));
        prop_assert_eq!(report.contacts, expected);
        let deepest = depths.iter().copied().fold(0.0, f64::max);
        prop_assert!((report.deepest - deepest).abs() < 1e-5 * (1.0 + deepest));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    /// A body that turns about its contact points is pushed out if a sample is then deeper than 0.01 cells. The rounds
    /// of the push-out leave at most a tenth of this.
    #[test]
    fn impacts_on_a_plane_leave_no_deep_sample(
        angles in prop::array::uniform3(-180.0..180.0_f64),
        depth in 0.0..0.2_f64,
        speed in 0.0..0.2_f64,
        slide in -0.3..0.3_f64,
        spin in prop::array::uniform3(-0.1..0.1_f64),
    ) {
        let mut block = Block::new([3, 2, 4], CELL, None);
        block.place(&euler_degrees(angles), Point3::origin());
        let rise = (lowest(&block) + depth) * CELL;
        block.place(&euler_degrees(angles), Point3::new(0.0, -rise, 0.0));
        let center = Vector3::from(vertices_of(&block).iter().fold([0.0; 3], |sum, p| {
            std::array::from_fn(|c| sum[c] + p[c] / block.rest.len() as f64)
        }));
        // In cells per step, so that the samples were outside before the step.
        for v in 0..block.rest.len() {
            let turn = Vector3::from(spin).cross(&(block.position(v) - center));
            let velocity = (Vector3::new(slide, -speed, 0.0) + turn) / DT;
            block.velocities.set(block.slots[v], velocity.map(|x| x as f32).into());
        }
        block.resolve(&colliders(&[ground()]), Interval::of_step(0, DT));
        prop_assert!(lowest(&block) > -0.011, "{}", lowest(&block));
    }
}

/// Indices of the items that satisfy a condition.
trait IndicesWhere: Iterator + Sized {
    /// Returns the indices of the items that satisfy `condition`.
    fn indices_where(self, condition: impl Fn(Self::Item) -> bool) -> Vec<usize> {
        self.enumerate().filter_map(|(i, item)| condition(item).then_some(i)).collect()
    }
}

impl<I: Iterator> IndicesWhere for I {}
