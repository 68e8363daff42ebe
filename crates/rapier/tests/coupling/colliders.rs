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

/// An error while bodies are mapped anew leaves the bodies in the simulation as they were.
#[test]
fn an_unsupported_shape_that_is_removed_leaves_the_near_bodies() {
    let mut world = world(0.0);
    for x in [-0.7, 0.7] {
        insert_cube(&mut world, RigidBodyBuilder::dynamic().translation(Vector::X * x), (0.2, 1000.0));
    }
    let mut soft = soft_world(soft_cube().cell_size(0.5));
    soft.step(&mut world).unwrap();
    assert_eq!((soft.near_bodies(), soft.simulation().bodies().len()), (2, 3));
    let round = ColliderBuilder::round_cuboid(0.1, 0.1, 0.1, 0.01);
    let (body, _) = world.insert(RigidBodyBuilder::dynamic().translation(Vector::Y), round);
    let error = soft.step(&mut world).unwrap_err();
    assert!(matches!(error, Error::Shape { role: "dynamic", .. }), "{error:?}");
    world.remove_body(body);
    soft.step(&mut world).unwrap();
    assert_eq!((soft.near_bodies(), soft.simulation().bodies().len()), (2, 3));
}

#[test]
fn a_friction_out_of_range_is_an_error_of_the_body() {
    let mut world = world(0.0);
    let cube = ColliderBuilder::cuboid(0.1, 0.1, 0.1).friction(-1.0);
    let (body, _) = world.insert(RigidBodyBuilder::dynamic().translation(Vector::Y * 0.6), cube);
    let error = soft_world(soft_cube().cell_size(0.5)).step(&mut world).unwrap_err();
    assert!(matches!(&error, Error::Body { body: named, .. } if *named == body), "{error:?}");
    assert!(error.to_string().contains("friction") && error.to_string().contains("-1"), "{error}");
}

/// A ball about the rigid cube is 0.227 above the soft one: farther than the margin of a tenth of the diagonal of the
/// soft cube, which is 0.173. The thickness of 0.4 is greater than the gap of 0.3, so that both touch.
#[test]
fn bodies_within_the_thickness_of_a_soft_body_are_near() {
    for (thickness, near) in [(0.0, 0), (0.4, 1)] {
        let mut world = world(0.0);
        let start = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.9).linvel(Vector::Y * -0.1);
        let body = insert_cube(&mut world, start, (0.2, 1000.0));
        let mut soft = soft_world(soft_cube().cell_size(0.25).thickness(thickness));
        soft.step(&mut world).unwrap();
        assert_eq!(soft.near_bodies(), near);
        assert_eq!(soft.impulse_on(body).unwrap().0.y > 0.0, near == 1);
    }
}

/// A plate that jumps by 0.5 below a resting cube has no velocity: with the 60 m/s of a motion, friction would move the
/// cube. A lateral velocity has no other cause than rounding; the bound of 1 mm/s is a choice.
#[test]
fn a_kinematic_body_that_jumps_has_no_velocity() {
    let mut world = world(9.81);
    let plate = ColliderBuilder::cuboid(3.0, 0.1, 3.0).friction(1.0);
    let at = |x: f32| Vector::new(x, -0.1, 0.0);
    let (body, _) = world.insert(RigidBodyBuilder::kinematic_position_based().translation(at(0.0)), plate);
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.5, 0.0]).damping_ratio(0.5));
    (0..60).for_each(|_| soft.step(&mut world).unwrap());
    world.bodies[body].set_position(Pose::from_translation(at(0.5)), true);
    let mut fastest = 0.0_f64;
    for _ in 0..10 {
        soft.step(&mut world).unwrap();
        let cube = &soft.bodies()[0];
        fastest = fastest.max((cube.linear_momentum() / cube.mass()).x.abs());
    }
    // The cube stays in contact at the new place: the plate carries it when it moves on.
    assert!(fastest < 1e-3, "{fastest}");
    assert!((soft.bodies()[0].center_of_mass().y - 0.5).abs() < 0.1);
    for step in 1..=30 {
        world.bodies[body].set_next_kinematic_translation(at(0.5 + step as f32 / 120.0));
        soft.step(&mut world).unwrap();
    }
    assert!(soft.bodies()[0].center_of_mass().x > 0.05);
}

/// A collider of the simulation keeps its pose and its switch when the colliders of Rapier change.
#[test]
fn driven_and_disabled_colliders_of_the_simulation_stay() {
    let mut world = world(0.0);
    let ball = || supple::Collider::sphere([5.0, 0.0, 0.0], 0.5);
    let simulation =
        supple::Simulation::builder().dt(1.0 / 120.0).threads(1).collider(ball()).collider(ball());
    let simulation = simulation.body(soft_cube().cell_size(0.5).build().unwrap()).build().unwrap();
    let mut soft = supple_rapier::SoftWorld::new(simulation);
    soft.step(&mut world).unwrap();
    soft.simulation_mut().collider_mut(0).move_to([1.0, 2.0, 3.0], [10.0, 0.0, 0.0]).unwrap();
    soft.simulation_mut().collider_mut(1).set_enabled(false);
    soft.step(&mut world).unwrap();
    world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::ball(0.1).translation(Vector::Y * 9.0));
    soft.step(&mut world).unwrap();
    let simulation = soft.simulation();
    assert_eq!(simulation.collider_count(), 3);
    assert_eq!(simulation.collider(0).translation(), [1.0, 2.0, 3.0]);
    assert_eq!(simulation.collider(0).rotation(), [10.0, 0.0, 0.0]);
    assert_eq!(simulation.collider(0).velocity(), [0.0; 3]);
    assert!(simulation.collider(0).is_enabled() && !simulation.collider(1).is_enabled());
}
