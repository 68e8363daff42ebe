//! Which colliders soft bodies touch, and changes of the Rapier world between steps.

use rapier3d::prelude::*;
use supple_rapier::Error;

use crate::support::*;

/// Returns a shape of each kind, with its top at the height 0 above the origin.
fn shapes() -> Vec<(&'static str, ColliderBuilder)> {
    let corners = |y: f32| [[-2.0, y, -2.0], [2.0, y, -2.0], [2.0, y, 2.0], [-2.0, y, 2.0]].map(Vector::from);
    let points: Vec<Vector> = [corners(-1.0), corners(0.0)].concat();
    let sheet = vec![[0, 2, 1], [0, 3, 2]];
    let heights = rapier3d::parry::utils::Array2::repeat(3, 3, 0.0);
    let down = |y: f32| Pose::from_translation(Vector::new(0.0, y, 0.0));
    let parts = vec![(down(-0.5), SharedShape::cuboid(1.0, 0.5, 1.0)), (down(-1.5), SharedShape::ball(0.5))];
    vec![
        ("ball", ColliderBuilder::ball(2.0).translation(Vector::Y * -2.0)),
        ("cuboid", ColliderBuilder::cuboid(2.0, 0.5, 2.0).translation(Vector::Y * -0.5)),
        ("capsule", ColliderBuilder::capsule_x(2.0, 1.0).translation(Vector::Y * -1.0)),
        ("half space", ColliderBuilder::new(SharedShape::halfspace(Vector::Y))),
        ("trimesh", ColliderBuilder::trimesh(corners(0.0).to_vec(), sheet).unwrap()),
        ("convex polyhedron", ColliderBuilder::convex_hull(&points).unwrap()),
        ("height field", ColliderBuilder::heightfield(heights, Vector::splat(4.0))),
        ("cylinder", ColliderBuilder::cylinder(0.5, 2.0).translation(Vector::Y * -0.5)),
        ("compound", ColliderBuilder::compound(parts)),
    ]
}

/// The cube falls by 0.1 and reaches each shape with its bottom. A fall of 0.5 s without a contact is 1.2 long.
#[test]
fn soft_bodies_rest_on_fixed_colliders_of_every_shape() {
    for (name, collider) in shapes() {
        let mut world = world(9.81);
        world.insert(RigidBodyBuilder::fixed(), collider);
        let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.6, 0.0]));
        (0..60).for_each(|_| soft.step(&mut world).unwrap());
        let height = soft.bodies()[0].center_of_mass().y;
        assert!(height > 0.4 && height < 0.6, "{name}: {height}");
        assert!(!soft.simulation().contacts().is_empty(), "{name}");
    }
}

/// A dynamic body of each closed shape, of the density 100, hits a soft block at 1 m/s.
#[test]
fn dynamic_bodies_of_every_closed_shape_push_a_soft_block() {
    let is_closed = |name: &str| !["half space", "trimesh", "height field"].contains(&name);
    for (name, collider) in shapes().into_iter().filter(|(name, _)| is_closed(name)) {
        let mut world = world(0.0);
        let bottom = collider.build().shape().compute_aabb(&collider.position).mins.y;
        let start = RigidBodyBuilder::dynamic().translation(Vector::Y * (0.55 - bottom));
        let (body, _) = world.insert(start.linvel(-Vector::Y), collider.density(100.0));
        let mut soft = soft_world(soft_cube().cell_size(0.25));
        soft.step(&mut world).unwrap();
        assert_eq!(soft.near_bodies(), 1, "{name}");
        let mut impulse = 0.0;
        for _ in 0..30 {
            soft.step(&mut world).unwrap();
            impulse += soft.impulse_on(body).unwrap().0.y;
        }
        let momentum = soft.bodies()[0].linear_momentum().y;
        assert!(momentum < -100.0, "{name}: {momentum}");
        assert!((impulse / momentum + 1.0).abs() < 1e-5, "{name}: {impulse} {momentum}");
    }
}

#[test]
fn an_unsupported_shape_is_an_error_that_names_it() {
    let mut world = world(9.81);
    world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::round_cuboid(1.0, 1.0, 1.0, 0.1));
    let mut soft = soft_world(soft_cube().cell_size(0.5));
    let error = soft.step(&mut world).unwrap_err();
    assert!(matches!(error, Error::Shape { role: "fixed or kinematic", .. }), "{error:?}");
    assert!(error.to_string().contains("RoundCuboid"), "{error}");
    assert_eq!(soft.simulation().step_count(), 0);
    let half_space = ColliderBuilder::new(SharedShape::halfspace(Vector::Y)).mass(1.0);
    let mut world = self::world(9.81);
    world.insert(RigidBodyBuilder::dynamic().translation(Vector::X * 1e3), half_space);
    let error = soft.step(&mut world).unwrap_err();
    assert!(error.to_string().contains("of a dynamic body, has the shape HalfSpace"), "{error}");
}

#[test]
fn sensors_and_other_groups_are_no_obstacles() {
    let mut world = world(9.81);
    let ground = || ColliderBuilder::new(SharedShape::halfspace(Vector::Y));
    world.insert(RigidBodyBuilder::fixed(), ground().sensor(true));
    let others = InteractionGroups::new(Group::GROUP_2, Group::GROUP_2, InteractionTestMode::And);
    world.insert(RigidBodyBuilder::fixed(), ground().collision_groups(others));
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.5, 0.0]));
    let own = InteractionGroups::new(Group::GROUP_1, Group::GROUP_1, InteractionTestMode::And);
    soft.set_collision_groups(own);
    (0..30).for_each(|_| soft.step(&mut world).unwrap());
    assert_eq!(soft.simulation().collider_count(), 0);
    soft.set_collision_groups(others);
    soft.step(&mut world).unwrap();
    assert_eq!(soft.simulation().collider_count(), 1);
}

/// Bodies are inserted and removed while they touch; the soft cube falls on when nothing is below it.
#[test]
fn bodies_that_are_inserted_and_removed_are_followed() {
    let mut world = world(9.81);
    let (ground, _) =
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Y)));
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.51, 0.0]));
    (0..20).for_each(|_| soft.step(&mut world).unwrap());
    let at = |x: f32| RigidBodyBuilder::dynamic().translation(Vector::new(x, 1.12, 0.0));
    let [first, second] = [-0.3, 0.3].map(|x| insert_cube(&mut world, at(x), (0.2, 1000.0)));
    let mut impulses = [0.0; 2];
    for _ in 0..20 {
        soft.step(&mut world).unwrap();
        for (sum, body) in impulses.iter_mut().zip([first, second]) {
            *sum += soft.impulse_on(body).unwrap().0.y;
        }
    }
    assert_eq!(soft.near_bodies(), 2);
    assert!(impulses.iter().all(|impulse| *impulse > 0.1), "{impulses:?}");
    world.remove_body(first);
    soft.step(&mut world).unwrap();
    assert_eq!((soft.near_bodies(), soft.impulse_on(first)), (1, None));
    (0..20).for_each(|_| soft.step(&mut world).unwrap());
    assert!(world.bodies[second].translation().y > 1.0);
    world.remove_body(ground);
    let height = soft.bodies()[0].center_of_mass().y;
    (0..30).for_each(|_| soft.step(&mut world).unwrap());
    assert!(soft.bodies()[0].center_of_mass().y < height - 0.2);
}

/// Nothing of the soft bodies changes a body that is far away, and the step costs no rigid body.
#[test]
fn far_bodies_move_as_without_soft_bodies() {
    let scene = || {
        let mut world = world(9.81);
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Y)));
        let at = |k: usize| Vector::new(20.0 + k as f32 * 0.3, 0.5 + 0.4 * k as f32, 0.0);
        let start = |k| RigidBodyBuilder::dynamic().translation(at(k)).angvel(Vector::X);
        let bodies: Vec<_> = (0..5).map(|k| insert_cube(&mut world, start(k), (0.3, 500.0))).collect();
        (world, bodies)
    };
    let ((mut alone, bodies), (mut both, _)) = (scene(), scene());
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.51, 0.0]));
    for _ in 0..120 {
        alone.step();
        soft.step(&mut both).unwrap();
        assert_eq!(soft.near_bodies(), 0);
    }
    assert!(bodies.iter().all(|&body| alone.bodies[body].position() == both.bodies[body].position()));
}

#[test]
fn a_sleeping_body_wakes_up_when_a_soft_body_touches_it() {
    let mut world = world(9.81);
    world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Y)));
    let start = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.25);
    let rigid = insert_cube(&mut world, start, (0.5, 1000.0));
    (0..600).for_each(|_| world.step());
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 1.2, 0.0]));
    soft.step(&mut world).unwrap();
    assert!(world.bodies[rigid].is_sleeping());
    (0..60).for_each(|_| soft.step(&mut world).unwrap());
    assert!(!world.bodies[rigid].is_sleeping());
    assert!(soft.bodies()[0].center_of_mass().y > 0.85);
}

/// A platform moves at 1 m/s, in both kinds of kinematic bodies, and carries the cube with it.
#[test]
fn kinematic_bodies_carry_soft_ones() {
    for is_position_based in [true, false] {
        let mut world = world(9.81);
        let builder = match is_position_based {
            true => RigidBodyBuilder::kinematic_position_based(),
            false => RigidBodyBuilder::kinematic_velocity_based().linvel(Vector::X),
        };
        let plate = ColliderBuilder::cuboid(2.0, 0.1, 2.0).friction(1.0);
        let (body, _) = world.insert(builder.translation(Vector::Y * -0.1), plate);
        let mut soft =
            soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.5, 0.0]).velocity([1.0, 0.0, 0.0]));
        for step in 1..=60 {
            if is_position_based {
                let next = Vector::new(step as f32 / 120.0, -0.1, 0.0);
                world.bodies[body].set_next_kinematic_translation(next);
            }
            soft.step(&mut world).unwrap();
        }
        let center = soft.bodies()[0].center_of_mass();
        assert!((center.x - 0.5).abs() < 0.02 && center.y > 0.4, "{center}");
        assert!((world.bodies[body].translation().x - 0.5).abs() < 1e-3);
    }
}
