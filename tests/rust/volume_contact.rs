//! The volume correction beside colliders: what is shown does not enter them, gives way sideways, and does not pop when
//! a contact makes or breaks.

use crate::common::{block, lattice};
use nalgebra::{Point3, Rotation3, Vector3};
use supple::internals::Motion;
use supple::{Body, BodyBuilder, BodyRef, Collider, Key, Simulation, VolumeOptions, VolumeScope};

const DT: f64 = 1.0 / 60.0;
const SCOPES: [VolumeScope; 2] = [VolumeScope::Global, VolumeScope::Regional];

/// A body twice among the same colliders: with the correction and without. Cells have edge 1, colliders do not turn.
struct Pair {
    kept: Simulation,
    plain: Simulation,
    colliders: Vec<Collider>,
    /// How far the correction moves each point that is seen; nothing before the first look.
    moved: Vec<Vector3<f64>>,
}

/// What a look at both shows. Lengths in cells.
#[derive(Debug)]
struct Seen {
    /// Depth of the deepest point with the correction, beyond the greatest without.
    deeper: f64,
    /// The farthest that the correction of a point changed since the last look.
    jump: f64,
    /// What is left of the volume error, relative.
    residual: f64,
    /// Greatest extents along x, with the correction and without.
    widths: [f64; 2],
}

impl Pair {
    fn new(body: impl Fn() -> BodyBuilder, scope: VolumeScope, colliders: &[Collider], fall: f64) -> Self {
        let simulation = |volume| {
            let world = Simulation::builder().body(body().volume(volume).build().unwrap());
            let world = world.gravity([0.0, -fall, 0.0]).dt(DT).threads(1);
            colliders.iter().cloned().fold(world, |world, collider| world.collider(collider)).build().unwrap()
        };
        let kept = simulation(VolumeOptions { scope, ..VolumeOptions::default() });
        let plain = simulation(VolumeOptions::off());
        Self { kept, plain, colliders: colliders.to_vec(), moved: Vec::new() }
    }

    fn step(&mut self) -> Seen {
        self.kept.step();
        self.plain.step();
        assert_eq!(self.kept.body(0).positions(), self.plain.body(0).positions(), "the dynamics do not know");
        let [kept, plain] = [&self.kept, &self.plain].map(|simulation| seen(simulation.body(0)));
        let moved: Vec<_> = kept.iter().zip(&plain).map(|(a, b)| a - b).collect();
        let jumps = moved.iter().zip(&self.moved).map(|(now, before)| (now - before).norm());
        let jump = jumps.fold(0.0, f64::max);
        self.moved = moved;
        let deeper =
            |collider: &Collider| self.deepest(collider, &kept) - self.deepest(collider, &plain).max(0.0);
        Seen {
            deeper: self.colliders.iter().map(deeper).fold(f64::NEG_INFINITY, f64::max),
            jump,
            residual: self.kept.body(0).volume_report().residual,
            widths: [&kept, &plain].map(|points| {
                let x = || points.iter().map(|p| p.x);
                x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
            }),
        }
    }

    fn deepest(&self, collider: &Collider, points: &[Point3<f64>]) -> f64 {
        let way = match collider.keys.is_empty() {
            true => Vector3::zeros(),
            false => Motion::new(collider.keys.clone()).unwrap().pose(self.kept.time()).translate,
        };
        let depth = |p: &Point3<f64>| -collider.shape.signed_distance((p - way).into()).distance;
        points.iter().map(depth).fold(f64::NEG_INFINITY, f64::max)
    }
}

fn seen(body: BodyRef<'_>) -> Vec<Point3<f64>> {
    if body.mesh().is_some() { body.surface().positions } else { body.corrected_positions() }
}

/// A ball of radius 4, bouncing little.
fn ball() -> BodyBuilder {
    Body::builder(crate::shapes::ball(4.0)).cell_size(1.0).region_damping(0.1)
}

/// Two plates that close on what is between them, wait, and open again: `way` each, from `height` above and below.
fn plates(height: f64, way: f64) -> [Collider; 2] {
    [1.0, -1.0].map(|side| {
        let key = |time, way: f64| Key { time, translate: [0.0, -side * way, 0.0], rotate: [0.0; 3] };
        let keys = vec![key(0.2, 0.0), key(1.2, way), key(1.4, way), key(2.4, 0.0)];
        Collider { keys, ..Collider::plane([0.0, side * height, 0.0], [0.0, -side, 0.0]) }
    })
}

/// The worst of some looks, and the widest.
fn worst(pair: &mut Pair, steps: usize) -> Seen {
    let mut worst = Seen { deeper: 0.0, jump: 0.0, residual: 0.0, widths: [0.0; 2] };
    for _ in 0..steps {
        let seen = pair.step();
        worst.deeper = worst.deeper.max(seen.deeper);
        worst.jump = worst.jump.max(seen.jump);
        worst.residual = worst.residual.max(seen.residual.abs());
        worst.widths = [0, 1].map(|k| worst.widths[k].max(seen.widths[k]));
    }
    worst
}

#[test]
fn squeezed_between_plates_it_bulges_sideways_and_enters_neither() {
    for scope in SCOPES {
        for half_width in [1, 3] {
            let mut pair = Pair::new(|| ball().half_width(half_width), scope, &plates(4.2, 1.6), 0.0);
            let worst = worst(&mut pair, 180);
            assert!(worst.deeper < 1e-5 && worst.residual < 1e-12, "{scope:?}, {half_width}: {worst:?}");
            // The plates move by 1.6 cells in a second, 0.027 in a step.
            assert!(worst.jump < 0.15, "{scope:?}, {half_width}: {worst:?}");
            let [kept, plain] = worst.widths;
            assert!(kept > plain + 0.5, "it gives way sideways: {scope:?}, {half_width}: {worst:?}");
        }
        let cube = || Body::from_lattice(lattice(&block([6, 6, 6]))).region_damping(0.1).translate([-3.0; 3]);
        let worst = worst(&mut Pair::new(cube, scope, &plates(3.2, 1.2), 0.0), 180);
        assert!(worst.deeper < 1e-5 && worst.residual < 1e-12 && worst.jump < 0.05, "{scope:?}: {worst:?}");
        assert!(worst.widths[0] > worst.widths[1] + 1.0, "{scope:?}: {worst:?}");
    }
}

/// A block of 6 x 6 x 6 cells pressed to a share of its height along y, tilted about z, among planes.
fn pressed(
    scope: VolumeScope,
    share: f64,
    tilt: f64,
    planes: impl Fn(&Rotation3<f64>) -> Vec<Collider>,
) -> [Vec<Vector3<f64>>; 2] {
    let turned = Rotation3::new(Vector3::z() * tilt.to_radians());
    let options = VolumeOptions { scope, ..VolumeOptions::default() };
    let mut body = Body::from_lattice(lattice(&block([6, 6, 6]))).volume(options).build().unwrap();
    let pose = |p: &Point3<f64>| turned * Point3::new(p.x, share * p.y, p.z);
    let posed: Vec<_> = body.positions().iter().map(pose).collect();
    body.set_positions(&posed).unwrap();
    let world = Simulation::builder().body(body).gravity([0.0; 3]).threads(1);
    let world =
        planes(&turned).into_iter().fold(world, |world, plane| world.collider(plane)).build().unwrap();
    assert!(world.body(0).volume_report().residual.abs() < 1e-6);
    let upright = |points: Vec<Point3<f64>>| points.iter().map(|p| turned.inverse() * p.coords).collect();
    [upright(world.body(0).corrected_positions()), upright(posed)]
}

/// A plane through a point, in the block's own axes.
fn plane(turned: &Rotation3<f64>, point: [f64; 3], normal: [f64; 3]) -> Collider {
    Collider::plane((turned * Point3::from(point)).into(), (turned * Vector3::from(normal)).into())
}

#[test]
fn where_plates_leave_one_way_out_a_wall_stops_that_too() {
    for scope in SCOPES {
        for gap in [0.3, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.5] {
            let [kept, _] = pressed(scope, 0.6, 20.0, |turned| {
                let side = |point, normal| plane(turned, point, normal);
                let plates = [side([0.0; 3], [0.0, 1.0, 0.0]), side([0.0, 3.6, 0.0], [0.0, -1.0, 0.0])];
                plates.into_iter().chain([side([6.0 + gap, 0.0, 0.0], [-1.0, 0.0, 0.0])]).collect()
            });
            for p in kept {
                let inside = (-1e-5..3.60001).contains(&p.y) && p.x < 6.0 + gap + 1e-5;
                assert!(inside, "{scope:?}, gap {gap}: {p:?}");
            }
        }
    }
}

#[test]
fn on_a_slope_of_any_angle_it_gives_way_along_the_slope() {
    for scope in SCOPES {
        let widest = |tilt| {
            let ground = |turned: &_| vec![plane(turned, [0.0; 3], [0.0, 1.0, 0.0])];
            let [kept, plain] = pressed(scope, 0.8, tilt, ground);
            let bottom = kept.iter().zip(&plain).filter(|(_, plain)| plain.y.abs() < 1e-5);
            bottom.map(|(kept, plain)| (kept - plain).x.abs()).fold(0.0, f64::max)
        };
        let level = widest(0.0);
        assert!(level > 0.1, "{scope:?}: {level}");
        for tilt in [10.0, 20.0, 45.0, 60.0, 70.0, 80.0, 135.0] {
            let tilted = widest(tilt);
            assert!((tilted - level).abs() < 1e-3 * level, "{scope:?}, {tilt} degrees: {tilted} and {level}");
        }
    }
}

/// A fall of a quarter of the body's height, hard enough to bounce.
#[test]
fn dropped_on_anything_it_enters_by_two_hundredths_of_a_cell_at_most() {
    let slope = |x: f64| Collider::plane([0.0, -5.0, 0.0], [x, 1.0, 0.0]);
    let grounds = [
        ("plane", vec![slope(0.0)], 1e-5),
        ("valley", vec![slope(1.0), slope(-1.0)], 1e-5),
        ("sphere", vec![Collider::sphere([0.5, -8.0, 0.0], 3.0)], 0.02),
        ("rod", vec![Collider::capsule([-9.0, -6.0, 0.0], [9.0, -6.0, 0.0], 1.0)], 0.02),
        ("edge", vec![Collider::cuboid([0.0, -8.5, 0.0], [3.0, 3.0, 9.0], [0.0, 0.0, 45.0])], 0.02),
    ];
    for (name, ground, most) in grounds {
        for (scope, half_width) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
            let mut pair = Pair::new(|| ball().half_width(half_width), SCOPES[scope], &ground, 60.0);
            let worst = worst(&mut pair, 90);
            assert!(worst.deeper < most, "{name}, {:?}, {half_width}: {worst:?}", SCOPES[scope]);
            // Where a sharp edge leaves no way out, some of the volume is not given back, and the report says so.
            assert!(worst.residual < 5e-3, "{name}, {:?}, {half_width}: {worst:?}", SCOPES[scope]);
        }
    }
}

#[test]
fn at_rest_beside_a_ball_and_within_it_nothing_moves() {
    for height in [-8.0, -3.0] {
        let pair = Pair::new(ball, VolumeScope::Regional, &[Collider::sphere([0.0, height, 0.0], 3.0)], 0.0);
        assert_eq!(seen(pair.kept.body(0)), seen(pair.plain.body(0)));
    }
}

/// What is shown depends on where colliders are now, and on nothing that came before.
#[test]
fn a_restored_state_shows_the_same() {
    let make = || Pair::new(ball, VolumeScope::Regional, &plates(4.2, 1.6), 0.0).kept;
    let mut simulation = make();
    simulation.steps(70);
    let mut other = make();
    other.restore(&simulation.state()).unwrap();
    assert_eq!(seen(simulation.body(0)), seen(other.body(0)));
}
