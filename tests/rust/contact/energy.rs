//! Contacts add no energy for any restitution, and bodies come to rest on the ground.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, BodyRef, Collider, Material, Mesh, Preset, Simulation, Substeps, VolumeOptions,
};
use supple_tests::{block, lattice, surface_of};

const DT: f64 = 1.0 / 60.0;
const GRAVITY: f64 = 9.81;

/// Returns a simulation of a body whose lowest point is `height` above the ground.
fn drop(body: BodyBuilder, ground: Collider, height: f64) -> Simulation {
    let body = body.translate([0.0, 100.0, 0.0]).build().unwrap();
    let low = lowest(body.alone());
    let ground =
        Collider { shape: Collider::plane([0.0, low - height, 0.0], [0.0, 1.0, 0.0]).shape, ..ground };
    let world = Simulation::builder().body(body).collider(ground).gravity([0.0, -GRAVITY, 0.0]);
    world.dt(DT).threads(1).sleep(false).build().unwrap()
}

fn lowest(body: BodyRef<'_>) -> f64 {
    let surface = if body.mesh().is_some() { body.surface().positions } else { body.positions() };
    surface.iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

fn center(body: &Body) -> Vector3<f64> {
    let (positions, masses) = (body.positions(), body.masses());
    let sum: Vector3<f64> = positions.iter().zip(&masses).map(|(p, m)| p.coords * *m).sum();
    sum / masses.iter().sum::<f64>()
}

/// Returns kinetic energy plus potential energy above `level`. Heights are taken at the middle of the last
/// step, so that a free fall keeps the energy to rounding.
fn energy(body: &Body, level: f64) -> f64 {
    let terms = body.positions().into_iter().zip(body.velocities()).zip(body.masses());
    terms.map(|((p, v), m)| m * (0.5 * v.norm_squared() + GRAVITY * (p.y - 0.5 * DT * v.y - level))).sum()
}

/// Returns bare blocks that fall on a face, on a corner and on an end.
fn shapes() -> [(&'static str, BodyBuilder); 3] {
    let cube = || Body::from_lattice(lattice(&block([3, 3, 3]))).material(Material::fast_lsm());
    let bar = Body::from_lattice(lattice(&block([8, 2, 2]))).material(Material::fast_lsm());
    [
        ("flat", cube()),
        ("on a corner", cube().rotate([25.0, 10.0, 40.0])),
        ("on an end", bar.rotate([0.0, 0.0, 30.0])),
    ]
}

/// Asserts for ten seconds that a body under gravity and contact with the ground gains no energy.
fn assert_gains_no_energy(name: &str, body: BodyBuilder, stiffness: f64, ground: Collider) {
    let (restitution, friction) = (ground.restitution, ground.friction);
    let mut sim = drop(body.stiffness(stiffness).region_damping(0.0), ground, 3.0);
    let level = lowest(sim.body(0)) - 3.0;
    let start = energy(&sim.body(0), level);
    // The conserved energy also has a term of the deformation between two steps, at least -stiffness/4 of the
    // kinetic energy. 1e-4 is for rounding.
    let limit = start / (1.0 - stiffness / 4.0) * (1.0 + 1e-4);
    for step in 0..600 {
        sim.step();
        let now = energy(&sim.body(0), level);
        assert!(
            now <= limit,
            "{name}, stiffness {stiffness}, restitution {restitution}, friction {friction}: {} at step {step}",
            now / start
        );
    }
}

#[test]
fn an_undamped_body_gains_no_energy_at_any_restitution_and_friction() {
    for stiffness in [1.0, 0.3] {
        for half_width in [1, 2] {
            for friction in [0.0, 0.5] {
                for restitution in [0.0, 0.25, 0.5, 0.75, 0.9, 1.0] {
                    for (name, body) in shapes() {
                        let ground =
                            Collider { restitution, friction, ..Collider::plane([0.0; 3], [1.0; 3]) };
                        assert_gains_no_energy(name, body.half_width(half_width), stiffness, ground);
                    }
                }
            }
        }
    }
}

/// Returns a sphere with bumps, of six grids of `n` by `n` quads.
fn ball(n: i32) -> Mesh {
    let (vertices, quads) = surface_of(&block([n; 3]));
    let on_ball = |at: &[f64; 3]| {
        let p = Vector3::from(at.map(|x| 2.0 * x - f64::from(n))).normalize();
        let radius = 1.0 + 0.04 * (5.0 * p.x + 0.3).sin() * (4.0 * p.z).cos() * (3.0 * p.y).sin();
        (p * radius).into()
    };
    Mesh::new(vertices.iter().map(on_ball).collect(), &quads).unwrap()
}

fn ball_body() -> BodyBuilder {
    Body::builder(ball(12))
        .material(Material::fast_lsm())
        .lattice_vertices(300)
        .half_width(2)
        .volume(VolumeOptions::off())
}

#[test]
fn an_undamped_body_with_a_mesh_gains_no_energy() {
    for restitution in [0.0, 0.5, 1.0] {
        for friction in [0.0, 0.5] {
            let ground = Collider { restitution, friction, ..Collider::plane([0.0; 3], [1.0; 3]) };
            assert_gains_no_energy("ball", ball_body(), 0.8, ground);
        }
    }
}

#[test]
fn a_body_rises_higher_at_restitution_1_than_at_one_half_and_not_above_its_start() {
    for (name, body) in shapes() {
        let top = |restitution| {
            let ground = Collider { restitution, friction: 0.0, ..Collider::plane([0.0; 3], [1.0; 3]) };
            let mut sim = drop(body.clone().half_width(2).stiffness(0.5), ground, 3.0);
            let start = center(&sim.body(0)).y;
            let mut heights = Vec::new();
            for _ in 0..200 {
                sim.step();
                heights.push(center(&sim.body(0)).y - start);
            }
            let turn = (1..200).find(|&k| heights[k] > heights[k - 1]).unwrap();
            heights[turn..].iter().copied().fold(f64::NEG_INFINITY, f64::max)
        };
        let (elastic, half) = (top(1.0), top(0.5));
        assert!(elastic > half && elastic <= 0.0, "{name}: {elastic} {half}");
    }
}

#[test]
fn bodies_come_to_rest_on_the_ground() {
    // Region damping does not damp the rolling of a ball to and fro.
    let ball = ("ball", ball_body().damping_ratio(0.2));
    for (name, body) in shapes().into_iter().chain([ball]) {
        for restitution in [0.0, 0.5, 0.9] {
            let ground = Collider { restitution, ..Collider::plane([0.0; 3], [1.0; 3]) };
            let mut sim = drop(body.clone().stiffness(0.5).region_damping(0.1), ground, 1.0);
            let cell = sim.body(0).lattice().cell_size();
            let level = lowest(sim.body(0)) - 1.0;
            sim.steps(60 * 60);
            let (mut low, mut high) = (center(&sim.body(0)), center(&sim.body(0)));
            for _ in 0..120 {
                sim.step();
                let center = center(&sim.body(0));
                (low, high) = (low.inf(&center), high.sup(&center));
                let above = (lowest(sim.body(0)) - level) / cell;
                assert!(
                    (-1e-2..1e-2).contains(&above),
                    "{name}, restitution {restitution}: {above} cells above the ground"
                );
            }
            let moved = (high - low).amax() / cell;
            assert!(moved < 1e-2, "{name}, restitution {restitution}: it moves by {moved} cells");
        }
    }
}

#[test]
fn a_symmetric_body_that_falls_flat_stays_symmetric() {
    let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(f64::from)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube = Mesh::new(corners, &quads).unwrap();
    let body =
        Body::builder(cube).material(Material::fast_lsm()).cell_size(0.25).half_width(2).region_damping(0.05);
    let mut sim = drop(body, Collider { restitution: 0.4, ..Collider::plane([0.0; 3], [1.0; 3]) }, 1.0);
    sim.steps(120);
    let positions = sim.body(0).positions();
    let mirrors =
        [|p: Point3<f64>| Point3::new(1.0 - p.x, p.y, p.z), |p: Point3<f64>| Point3::new(p.z, p.y, p.x)];
    for mirror in mirrors {
        for &p in &positions {
            let image = mirror(p);
            let near = positions.iter().map(|q| (q - image).norm()).fold(f64::INFINITY, f64::min);
            assert!(near < 1e-3, "{p} has no mirror image: the nearest vertex is {near} away");
        }
    }
}

/// Returns the height to which a cube of rubber rises, as a fraction of the height of its fall.
fn rise(damping_ratio: f64, restitution: f64) -> f64 {
    let body = Body::from_lattice(lattice(&block([6; 3])))
        .preset(Preset::Rubber)
        .poisson_ratio(0.0)
        .damping_ratio(damping_ratio)
        .build()
        .unwrap();
    let ground = Collider { restitution, ..Collider::plane([0.0, -6.0, 0.0], [0.0, 1.0, 0.0]) };
    let builder = Simulation::builder().body(body).collider(ground).gravity([0.0, -60.0, 0.0]);
    let mut sim = builder.fps(30.0).substeps(Substeps::Auto).sleep(false).build().unwrap();
    let start = center(&sim.body(0)).y;
    let mut heights = Vec::new();
    while sim.time() < 1.6 {
        sim.step();
        heights.push((center(&sim.body(0)).y - start) / 6.0 + 1.0);
    }
    let turn = (1..heights.len()).find(|&k| heights[k] > heights[k - 1]).unwrap();
    heights[turn..].iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The restitution is that of the touching points. The rebound of a soft body is that of its own elasticity, which the
/// damping takes away.
#[test]
fn damping_and_not_restitution_determines_how_high_a_soft_body_bounces() {
    let (undamped, damped) = (rise(0.0, 0.0), rise(0.2, 0.0));
    assert!(undamped > 0.5 && undamped < 1.0, "{undamped}");
    assert!(damped < 0.2, "{damped}");
    // At restitution 1 it rises higher, but far less than the undamped body at restitution 0.
    let elastic = rise(0.2, 1.0);
    assert!(elastic > damped + 0.05 && elastic < 0.5 * undamped, "{elastic}");
}
