//! Selections, motions along keys, pins and handles.

use nalgebra::{Point3, Vector3};
use supple::euler_degrees;
use supple::internals::{BodyFrame, BodyState, Constraint, Constraints, Interval, Lanes, Motion};
use supple::{
    ConstraintError, Executor, Interpolation, Key, MotionError, Selection, SelectionError, SelectionPose,
    TimeWindow,
};

const DT: f64 = 1.0 / 60.0;

fn key(time: f64, translate: [f64; 3], rotate: [f64; 3]) -> Key {
    Key { time, translate, rotate }
}

/// The corners of a unit cube, x fastest.
fn cube() -> Vec<Point3<f64>> {
    (0..8).map(|k| Point3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1))).collect()
}

fn select(selection: Selection) -> Result<Vec<u32>, SelectionError> {
    selection.lattice_vertices(cube(), 8, |i| [i])
}

#[test]
fn each_shape_selects_the_vertices_inside_it_including_its_boundary() {
    assert_eq!(select(Selection::Box { min: [0.0; 3], max: [1.0, 0.0, 1.0] }), Ok(vec![0, 1, 4, 5]));
    assert_eq!(select(Selection::Sphere { center: [0.0; 3], radius: 1.0 }), Ok(vec![0, 1, 2, 4]));
    assert_eq!(
        select(Selection::Plane { point: [0.5, 9.0, 9.0], normal: [1e-200, 0.0, 0.0] }),
        Ok(vec![1, 3, 5, 7])
    );
    assert_eq!(select(Selection::Vertices(vec![7, 2, 7])), Ok(vec![2, 7]));
}

#[test]
fn selected_mesh_vertices_select_the_lattice_vertices_of_their_cells() {
    // Two cells side by side along x; the second mesh vertex lies in the second cell.
    let corners = |cell: u32| [0, 1, 3, 4, 6, 7, 9, 10].map(|v: u32| v + cell);
    let points = [Point3::new(0.2, 0.2, 0.2), Point3::new(1.7, 0.2, 0.2)];
    let right = Selection::Plane { point: [1.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
    assert_eq!(right.lattice_vertices(points, 12, corners), Ok(vec![1, 2, 4, 5, 7, 8, 10, 11]));
}

#[test]
fn an_empty_selection_is_an_error_with_the_nearest_vertex_and_its_distance() {
    let error = select(Selection::Box { min: [1.25, 0.0, 0.0], max: [3.0, 1.0, 0.5] }).unwrap_err();
    let (shape, nearest, pose) = ("box", [1.0, 0.0, 0.0], SelectionPose::Start);
    assert_eq!(error, SelectionError::Nothing { shape, nearest, distance: 0.25, pose });
    let message = "the box selects nothing of the body at frame 0: the nearest vertex is at \
                   (1.000000, 0.000000, 0.000000), 0.250000 outside; move the box or make it larger";
    assert_eq!(error.to_string(), message);
    let error = select(Selection::Sphere { center: [0.0, 0.0, -3.0], radius: 1.0 }).unwrap_err();
    let (shape, nearest) = ("sphere", [0.0; 3]);
    assert_eq!(error, SelectionError::Nothing { shape, nearest, distance: 2.0, pose });
    let error = select(Selection::Plane { point: [0.0, 1.5, 0.0], normal: [0.0, 2.0, 0.0] }).unwrap_err();
    let (shape, nearest) = ("plane", [0.0, 1.0, 0.0]);
    assert_eq!(error, SelectionError::Nothing { shape, nearest, distance: 0.5, pose });
}

#[test]
fn invalid_selections_are_errors_with_the_value_and_the_way_out() {
    let wrong = [
        (
            Selection::Box { min: [0.0, 2.0, 0.0], max: [1.0; 3] },
            "the box has min 2 > max 1 along y; swap the two",
        ),
        (Selection::Box { min: [f64::NAN, 0.0, 0.0], max: [1.0; 3] }, "min is NaN; it must be finite"),
        (
            Selection::Sphere { center: [0.0; 3], radius: 0.0 },
            "the sphere's radius is 0; it must be greater than 0",
        ),
        (Selection::Sphere { center: [0.0; 3], radius: f64::INFINITY }, "radius is inf; it must be finite"),
        (
            Selection::Plane { point: [0.0; 3], normal: [0.0; 3] },
            "the plane's normal is zero; give the direction of the side to select",
        ),
        (Selection::Vertices(vec![]), "the list of vertices is empty; name at least one vertex"),
        (Selection::Vertices(vec![3, 8]), "vertex 8 is out of range: the lattice has 8 vertices, 0 to 7"),
    ];
    for (selection, message) in wrong {
        let error = select(selection).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn translation_and_angles_are_linear_between_keys_and_constant_outside() {
    let motion =
        Motion::new(vec![key(1.0, [0.0; 3], [0.0; 3]), key(3.0, [4.0, 0.0, -2.0], [0.0, 720.0, 0.0])])
            .unwrap();
    assert_eq!(motion.pose(-5.0), motion.pose(1.0));
    assert_eq!(motion.pose(3.0), motion.pose(1e9));
    for step in 0..=64 {
        let s = f64::from(step) / 64.0;
        let pose = motion.pose(1.0 + 2.0 * s);
        assert_eq!(pose.translate, Vector3::new(4.0 * s, 0.0, -2.0 * s));
        assert_eq!(pose.rotation, euler_degrees([0.0, 720.0 * s, 0.0]));
    }
    // Two full turns: no rotation half way, half a turn at a quarter of the way.
    assert_eq!(motion.pose(2.0).rotation, euler_degrees([0.0; 3]));
    assert_eq!(motion.pose(1.5).rotation * Vector3::x(), -Vector3::x());
    let about = Point3::new(1.0, 0.0, 0.0);
    assert_eq!(motion.pose(1.5).apply(&about, &Point3::new(3.0, 5.0, 0.0)), Point3::new(0.0, 5.0, -0.5));
}

#[test]
fn invalid_keys_are_errors_with_their_index_and_value() {
    assert_eq!(Motion::new(vec![]), Err(MotionError::NoKeys));
    let twice = Motion::new(vec![key(0.5, [0.0; 3], [0.0; 3]); 2]).unwrap_err();
    assert_eq!(twice, MotionError::NotIncreasing { key: 1, time: 0.5, previous: 0.5 });
    assert!(
        twice
            .to_string()
            .contains("key 1 is at time 0.5, which is not after key 0 at 0.5; sort the keys by time"),
        "{twice}"
    );
    let error = Motion::new(vec![key(0.0, [0.0, f64::NAN, 0.0], [0.0; 3])]).unwrap_err();
    assert!(error.to_string().contains("key 0: translate is NaN; it must be finite"), "{error}");
}

/// A cube of eight vertices in reversed slots, far from the origin of world space.
struct Body {
    positions: Lanes<3>,
    compensation: Lanes<3>,
    velocities: Lanes<3>,
    frame: BodyFrame,
    slots: Vec<u32>,
}

impl Body {
    fn new() -> Self {
        let mut body = Self {
            positions: Lanes::zeros(2),
            compensation: Lanes::zeros(2),
            velocities: Lanes::zeros(2),
            frame: BodyFrame { origin: Point3::new(3e5, -20.0, 0.1), cell_size: 0.3 },
            slots: (0..8).map(|v| 11 - v).collect(),
        };
        body.compensation.set(body.slots[0], [3e-7, -1e-7, 2e-7]);
        for (v, p) in cube().iter().enumerate() {
            body.positions.set(body.slots[v], [p.x as f32, p.y as f32 - 40.0, p.z as f32]);
        }
        body
    }

    fn state(&mut self) -> BodyState<'_> {
        let Self { positions, compensation, velocities, frame, .. } = self;
        BodyState { positions, compensation: Some(compensation), velocities, frame: *frame }
    }

    fn world(&self, v: usize) -> Point3<f64> {
        self.frame.to_world(self.local(v))
    }

    fn local(&self, v: usize) -> Vector3<f64> {
        let wide = |lanes: &Lanes<3>| Vector3::from(lanes.get(self.slots[v]).map(f64::from));
        wide(&self.positions) + wide(&self.compensation)
    }

    fn velocity(&self, v: usize) -> Vector3<f64> {
        Vector3::from(self.velocities.get(self.slots[v]).map(f64::from)) * self.frame.cell_size
    }

    /// Runs a step that displaces every vertex before the constraints are applied.
    fn step(&mut self, constraints: &mut Constraints, count: u64) {
        let step = Interval::of_step(count, DT);
        let slots = self.slots.clone();
        constraints.begin(step, (&self.state(), &slots), &Executor::sequential());
        for (v, &slot) in self.slots.iter().enumerate() {
            self.compensation.set(slot, [1e-7, 0.0, -1e-7]);
            let [x, y, z] = self.positions.get(slot);
            self.positions.set(slot, [x + 0.01, y - 0.02 * v as f32, z]);
            self.velocities.set(slot, [9.0, 9.0, 9.0]);
        }
        constraints.apply(step, &mut self.state(), &slots);
    }
}

fn window(start: f64, end: f64) -> TimeWindow {
    TimeWindow { start, end }
}

#[test]
fn a_pin_keeps_its_vertices_at_their_positions_at_start_and_releases_them_at_end() {
    let mut body = Body::new();
    // The window ends at multiples of the step only up to rounding.
    let pin = Constraint::new(vec![0, 3], window(0.1, 0.3), None).unwrap();
    let mut constraints = Constraints::new(8, vec![pin]);
    let (mut captured, mut first) = (Vec::new(), Vec::new());
    for count in 0..30 {
        let before = [0, 3].map(|v: usize| body.local(v));
        body.step(&mut constraints, count);
        let after = [0, 3].map(|v: usize| body.local(v));
        if count == 6 {
            (captured, first) = (before.to_vec(), after.to_vec());
        }
        let active = (6..18).contains(&count);
        assert_eq!(constraints.any_active(), active, "step {count}");
        assert_eq!(constraints.constrained(), [active, false, false, active, false, false, false, false]);
        for (k, v) in [0, 3].into_iter().enumerate() {
            if active {
                // Equal bits from step to step. The captured position passes through world space, a million
                // cells from the origin in f64.
                assert_eq!(after[k], first[k]);
                assert!((after[k] - captured[k]).norm() < 1e-9, "{} {}", after[k], captured[k]);
                assert_eq!(body.velocity(v), Vector3::zeros());
            } else {
                assert_ne!(after[k], before[k]);
            }
        }
        assert!(
            (body.velocity(1) - Vector3::repeat(2.7)).norm() < 1e-5,
            "free vertices keep their velocities"
        );
    }
}

#[test]
fn a_handle_follows_its_keys_about_the_captured_center() {
    let keys = [key(0.0, [0.0; 3], [0.0; 3]), key(1.0, [0.0, 0.5, 0.0], [0.0, 720.0, 0.0])];
    let mut body = Body::new();
    let start: Vec<_> = (0..4).map(|v| body.world(v)).collect();
    let center = Point3::from(start.iter().map(|p| p.coords).sum::<Vector3<f64>>() / 4.0);
    let mut constraints = Constraints::new(
        8,
        vec![Constraint::new(vec![0, 1, 2, 3], TimeWindow::default(), Some(&keys)).unwrap()],
    );
    let cell = body.frame.cell_size;
    for count in 0..90 {
        body.step(&mut constraints, count);
        let [before, after] = [count, count + 1].map(|c| (c as f64 * DT).min(1.0));
        for (v, captured) in start.iter().enumerate() {
            let at = |time: f64| {
                let turned = euler_degrees([0.0, 720.0 * time, 0.0]) * (captured - center);
                center + turned + Vector3::new(0.0, 0.5 * time, 0.0)
            };
            // 4 ulp of f32 at 40 cells.
            assert!((body.world(v) - at(after)).norm() < 2e-5 * cell, "step {count}");
            let velocity = (at(after) - at(before)) / DT;
            assert!((body.velocity(v) - velocity).norm() < 1e-5 * (1.0 + velocity.norm()), "step {count}");
        }
    }
}

#[test]
fn keys_are_relative_to_the_pose_captured_at_start() {
    let keys = [key(0.5, [0.0; 3], [0.0; 3]), key(1.0, [1.0, 0.0, 0.0], [0.0; 3])];
    let mut body = Body::new();
    let handle = Constraint::new(vec![5], window(0.5, 2.0), Some(&keys)).unwrap();
    let mut constraints = Constraints::new(8, vec![handle]);
    (0..30).for_each(|count| body.step(&mut constraints, count));
    let captured = body.world(5);
    (30..60).for_each(|count| body.step(&mut constraints, count));
    assert!((body.world(5) - captured - Vector3::x()).norm() < 1e-5);
}

#[test]
fn the_later_of_two_overlapping_constraints_wins() {
    let up = [key(0.0, [0.0, 1.0, 0.0], [0.0; 3])];
    let mut body = Body::new();
    let start: Vec<_> = (0..8).map(|v| body.world(v)).collect();
    let mut constraints =
        Constraints::new(8, vec![Constraint::new(vec![0, 1], TimeWindow::default(), Some(&up)).unwrap()]);
    constraints.add(Constraint::new(vec![1, 2], window(0.0, 0.5), None).unwrap());
    let rise = |body: &Body, v: usize| (body.world(v) - start[v]).y;
    (0..30).for_each(|count| body.step(&mut constraints, count));
    assert!(
        (rise(&body, 0) - 1.0).abs() < 1e-5 && rise(&body, 1).abs() < 1e-9 && rise(&body, 2).abs() < 1e-9
    );
    assert_eq!(constraints.constrained()[..4], [true, true, true, false]);
    // After the end of the later constraint the earlier one holds the shared vertex again.
    body.step(&mut constraints, 30);
    assert!((rise(&body, 1) - 1.0).abs() < 1e-5 && rise(&body, 2).abs() > 1e-3);
    assert_eq!(constraints.constrained()[..4], [true, true, false, false]);
}

#[test]
fn captured_poses_survive_serialization() {
    let keys = [key(0.0, [0.0; 3], [0.0; 3]), key(1.0, [0.0, 0.0, 2.0], [90.0, 0.0, 0.0])];
    let list = vec![
        Constraint::new(vec![0, 1], TimeWindow::default(), Some(&keys)).unwrap(),
        Constraint::new(vec![6], window(0.4, 9.0), None).unwrap(),
    ];
    let (mut one, mut first) = (Body::new(), Constraints::new(8, list));
    (0..20).for_each(|count| one.step(&mut first, count));

    // As in a checkpoint: the handle has captured its pose, the pin has not.
    let mut second: Constraints = postcard::from_bytes(&postcard::to_stdvec(&first).unwrap()).unwrap();
    assert_eq!(second, first);
    let mut two = Body::new();
    two.positions = one.positions.clone();
    two.compensation = one.compensation.clone();
    for count in 20..60 {
        one.step(&mut first, count);
        two.step(&mut second, count);
        assert_eq!((&one.positions, &one.velocities), (&two.positions, &two.velocities));
        assert_eq!(second.constrained(), first.constrained());
    }
    assert!(first.constrained()[6]);
}

#[test]
fn empty_or_non_finite_time_windows_are_errors() {
    for (start, end) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::NAN), (f64::INFINITY, 1.0)] {
        let error = Constraint::new(vec![0], window(start, end), None).unwrap_err();
        assert!(matches!(error, ConstraintError::TimeWindow { .. }), "{error}");
        assert!(error.to_string().starts_with(&format!("start is {start} and end is {end}; ")), "{error}");
    }
}

#[test]
fn smooth_keys_begin_and_end_each_interval_at_rest() {
    let keys = vec![key(1.0, [0.0; 3], [0.0; 3]), key(3.0, [4.0, 0.0, -2.0], [0.0, 720.0, 0.0])];
    let motion = Motion::new(keys).unwrap().interpolated(Interpolation::Smooth);
    for step in 0..=64 {
        let s = f64::from(step) / 64.0;
        let share = s * s * (3.0 - 2.0 * s);
        let pose = motion.pose(1.0 + 2.0 * s);
        assert_eq!(pose.translate, Vector3::new(4.0 * share, 0.0, -2.0 * share));
        assert_eq!(pose.rotation, euler_degrees([0.0, 720.0 * share, 0.0]));
    }
    let velocity =
        |time: f64| (motion.pose(time + 1e-6).translate - motion.pose(time - 1e-6).translate) / 2e-6;
    // The acceleration is 6 x 4/2², so that the velocity within 1e-6 s of a keyframe is at most 6e-6.
    assert!(velocity(1.0).norm() < 1e-5 && velocity(3.0).norm() < 1e-5);
    assert!((velocity(2.0).x - 1.5 * 4.0 / 2.0).abs() < 1e-6);
}

#[test]
fn cubic_keys_have_a_continuous_velocity_and_no_overshoot() {
    let heights = [(0.0, 0.0), (0.5, 1.0), (2.0, 2.0), (2.5, 2.0), (4.0, -1.0), (4.5, 3.0)];
    let keys: Vec<Key> = heights.map(|(time, y)| key(time, [0.0, y, 0.0], [90.0 * y, 0.0, 0.0])).to_vec();
    let motion = Motion::new(keys).unwrap().interpolated(Interpolation::Cubic);
    let height = |time: f64| motion.pose(time).translate.y;
    for pair in heights.windows(2) {
        let [(start, a), (end, b)] = [pair[0], pair[1]];
        assert_eq!([height(start), height(end)], [a, b]);
        let mut last = a;
        for part in 1..=100 {
            let y = height(start + (end - start) * f64::from(part) / 100.0);
            // Rounding errors of values of at most 3.
            assert!(if b >= a { y >= last - 1e-14 } else { y <= last + 1e-14 }, "{start} {part}");
            last = y;
        }
    }
    for (time, _) in heights {
        let one_sided = |sign: f64| sign * (height(time + sign * 1e-7) - height(time)) / 1e-7;
        // The accelerations are below 6 x 4/0.5² = 96, so that the one-sided slopes differ by less than 1e-5.
        assert!((one_sided(1.0) - one_sided(-1.0)).abs() < 1e-4, "{time}");
    }
    // It passes the second keyframe, and rests where it turns back or does not change.
    let slope = (height(0.5 + 1e-6) - height(0.5 - 1e-6)) / 2e-6;
    assert!(slope > 0.66 && slope < 2.0);
    for time in [2.0, 2.2, 2.5, 4.0] {
        assert!((height(time + 1e-6) - height(time - 1e-6)).abs() / 2e-6 < 1e-3, "{time}");
    }
    assert_eq!([height(-1.0), height(9.0)], [0.0, 3.0]);
    // Angles are interpolated as displacements are.
    assert_eq!(motion.pose(1.1).rotation, euler_degrees([90.0 * height(1.1), 0.0, 0.0]));
}
