//! The volume correction beside colliders: the evaluated surface does not enter them, bulges sideways, and
//! does not jump when a contact begins or ends.

use nalgebra::{Point3, Rotation3, Vector3};
use supple::internals::Motion;
use supple::{Body, BodyBuilder, BodyRef, Collider, Key, Material, Simulation, VolumeOptions, VolumeScope};
use supple_tests::{block, lattice};

const DT: f64 = 1.0 / 60.0;
const SCOPES: [VolumeScope; 2] = [VolumeScope::Global, VolumeScope::Regional];

/// Two simulations of the same body and colliders, with and without the correction. Cells have edge 1, and
/// colliders do not rotate.
struct Pair {
    corrected: Simulation,
    uncorrected: Simulation,
    colliders: Vec<Collider>,
    /// Displacement of each surface point by the correction in the last step; empty before the first.
    displacements: Vec<Vector3<f64>>,
}

/// Measures of both surfaces after a step. Lengths are in cells.
#[derive(Debug)]
struct Measures {
    /// Largest depth in a collider with the correction, minus the largest depth without it (0 if the surface
    /// without it is outside).
    extra_depth: f64,
    /// Largest change of a displacement since the previous step.
    jump: f64,
    /// Relative volume error after the correction.
    residual: f64,
    /// Extents along x, with and without the correction.
    widths: [f64; 2],
}

impl Pair {
    /// Creates both simulations. `fall` is the gravity along -y, in cells per second squared.
    fn new(body: impl Fn() -> BodyBuilder, scope: VolumeScope, colliders: &[Collider], fall: f64) -> Self {
        let simulation = |volume| {
            let world = Simulation::builder().body(body().volume(volume).build().unwrap());
            let world = world.gravity([0.0, -fall, 0.0]).dt(DT).threads(1);
            colliders.iter().cloned().fold(world, |world, collider| world.collider(collider)).build().unwrap()
        };
        let corrected = simulation(VolumeOptions { scope, ..VolumeOptions::default() });
        let uncorrected = simulation(VolumeOptions::off());
        Self { corrected, uncorrected, colliders: colliders.to_vec(), displacements: Vec::new() }
    }

    fn step(&mut self) -> Measures {
        self.corrected.step();
        self.uncorrected.step();
        let simulations = [&self.corrected, &self.uncorrected];
        let [a, b] = simulations.map(|simulation| simulation.body(0).positions());
        assert_eq!(a, b, "the dynamics do not depend on the correction");
        let [corrected, uncorrected] = simulations.map(|simulation| surface_points(simulation.body(0)));
        let displacements: Vec<_> = corrected.iter().zip(&uncorrected).map(|(a, b)| a - b).collect();
        let jumps = displacements.iter().zip(&self.displacements).map(|(now, before)| (now - before).norm());
        let jump = jumps.fold(0.0, f64::max);
        self.displacements = displacements;
        let extra_depth = |collider: &Collider| {
            self.deepest(collider, &corrected) - self.deepest(collider, &uncorrected).max(0.0)
        };
        Measures {
            extra_depth: self.colliders.iter().map(extra_depth).fold(f64::NEG_INFINITY, f64::max),
            jump,
            residual: self.corrected.body(0).volume_report().residual,
            widths: [&corrected, &uncorrected].map(|points| {
                let x = || points.iter().map(|p| p.x);
                x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
            }),
        }
    }

    /// Returns the largest depth of points in a collider.
    fn deepest(&self, collider: &Collider, points: &[Point3<f64>]) -> f64 {
        let translation = match collider.keys.is_empty() {
            true => Vector3::zeros(),
            false => Motion::new(collider.keys.clone()).unwrap().pose(self.corrected.time()).translate,
        };
        let depth = |p: &Point3<f64>| -collider.shape.signed_distance((p - translation).into()).distance;
        points.iter().map(depth).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Returns the evaluated mesh, or the corrected positions of a bare lattice.
fn surface_points(body: BodyRef<'_>) -> Vec<Point3<f64>> {
    if body.mesh().is_some() { body.surface().positions } else { body.corrected_positions() }
}

/// Returns a damped ball of radius 4.
fn ball() -> BodyBuilder {
    Body::builder(supple_tests::ball(4.0)).material(Material::fast_lsm()).cell_size(1.0).region_damping(0.1)
}

/// Returns two plates at `height` above and below the origin that close by `distance` each, wait, and open
/// again.
fn plates(height: f64, distance: f64) -> [Collider; 2] {
    [1.0, -1.0].map(|side| {
        let key = |time, moved: f64| Key { time, translate: [0.0, -side * moved, 0.0], rotate: [0.0; 3] };
        let keys = vec![key(0.2, 0.0), key(1.2, distance), key(1.4, distance), key(2.4, 0.0)];
        Collider { keys, ..Collider::plane([0.0, side * height, 0.0], [0.0, -side, 0.0]) }
    })
}

/// Returns the largest measures of several steps.
fn worst(pair: &mut Pair, steps: usize) -> Measures {
    let mut worst = Measures { extra_depth: 0.0, jump: 0.0, residual: 0.0, widths: [0.0; 2] };
    for _ in 0..steps {
        let now = pair.step();
        worst.extra_depth = worst.extra_depth.max(now.extra_depth);
        worst.jump = worst.jump.max(now.jump);
        worst.residual = worst.residual.max(now.residual.abs());
        worst.widths = [0, 1].map(|k| worst.widths[k].max(now.widths[k]));
    }
    worst
}

#[test]
fn a_body_squeezed_between_plates_bulges_sideways_and_enters_neither() {
    for scope in SCOPES {
        for half_width in [1, 3] {
            let mut pair = Pair::new(|| ball().half_width(half_width), scope, &plates(4.2, 1.6), 0.0);
            let worst = worst(&mut pair, 180);
            assert!(worst.extra_depth < 1e-5 && worst.residual < 1e-12, "{scope:?}, {half_width}: {worst:?}");
            // Regression bounds for jumps and widths. The plates move by 1.6 cells in a second, 0.027 in a
            // step.
            assert!(worst.jump < 0.3, "{scope:?}, {half_width}: {worst:?}");
            let [corrected, uncorrected] = worst.widths;
            assert!(corrected > uncorrected + 0.5, "no bulge: {scope:?}, {half_width}: {worst:?}");
        }
        let cube = || {
            Body::from_lattice(lattice(&block([6, 6, 6])))
                .material(Material::fast_lsm())
                .region_damping(0.1)
                .translate([-3.0; 3])
        };
        let worst = worst(&mut Pair::new(cube, scope, &plates(3.2, 1.2), 0.0), 180);
        assert!(worst.extra_depth < 1e-5 && worst.residual < 1e-12, "{scope:?}: {worst:?}");
        assert!(worst.jump < 0.05, "{scope:?}: {worst:?}");
        assert!(worst.widths[0] > worst.widths[1] + 1.0, "{scope:?}: {worst:?}");
    }
}

/// Compresses a block of 6 x 6 x 6 cells along y to the fraction `share` of its height, and rotates it about
/// z by `tilt` degrees. `planes` returns the colliders for this rotation. Returns the positions of the block,
/// rotated back, with and without the correction.
fn pressed(
    scope: VolumeScope,
    share: f64,
    tilt: f64,
    planes: impl Fn(&Rotation3<f64>) -> Vec<Collider>,
) -> [Vec<Vector3<f64>>; 2] {
    let turned = Rotation3::new(Vector3::z() * tilt.to_radians());
    let options = VolumeOptions { scope, ..VolumeOptions::default() };
    let mut body = Body::from_lattice(lattice(&block([6, 6, 6])))
        .material(Material::fast_lsm())
        .volume(options)
        .build()
        .unwrap();
    let pose = |p: &Point3<f64>| turned * Point3::new(p.x, share * p.y, p.z);
    let posed: Vec<_> = body.positions().iter().map(pose).collect();
    body.set_positions(&posed).unwrap();
    let world = Simulation::builder().body(body).gravity([0.0; 3]).threads(1);
    let world =
        planes(&turned).into_iter().fold(world, |world, plane| world.collider(plane)).build().unwrap();
    assert!(world.body(0).volume_report().residual.abs() < 1e-6);
    let untilted = |points: Vec<Point3<f64>>| points.iter().map(|p| turned.inverse() * p.coords).collect();
    [untilted(world.body(0).corrected_positions()), untilted(posed)]
}

/// Returns a plane through a point, both given in the axes of the tilted block.
fn plane(turned: &Rotation3<f64>, point: [f64; 3], normal: [f64; 3]) -> Collider {
    Collider::plane((turned * Point3::from(point)).into(), (turned * Vector3::from(normal)).into())
}

#[test]
fn a_block_between_plates_and_a_wall_enters_none_of_them() {
    for scope in SCOPES {
        for gap in [0.3, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.5] {
            let [corrected, _] = pressed(scope, 0.6, 20.0, |turned| {
                let side = |point, normal| plane(turned, point, normal);
                let plates = [side([0.0; 3], [0.0, 1.0, 0.0]), side([0.0, 3.6, 0.0], [0.0, -1.0, 0.0])];
                plates.into_iter().chain([side([6.0 + gap, 0.0, 0.0], [-1.0, 0.0, 0.0])]).collect()
            });
            for p in corrected {
                let inside = (-1e-5..3.60001).contains(&p.y) && p.x < 6.0 + gap + 1e-5;
                assert!(inside, "{scope:?}, gap {gap}: {p:?}");
            }
        }
    }
}

#[test]
fn the_correction_along_a_slope_is_independent_of_its_angle() {
    for scope in SCOPES {
        let largest_slide = |tilt| {
            let ground = |turned: &_| vec![plane(turned, [0.0; 3], [0.0, 1.0, 0.0])];
            let [corrected, uncorrected] = pressed(scope, 0.8, tilt, ground);
            let bottom = corrected.iter().zip(&uncorrected).filter(|(_, before)| before.y.abs() < 1e-5);
            bottom.map(|(after, before)| (after - before).x.abs()).fold(0.0, f64::max)
        };
        let level = largest_slide(0.0);
        assert!(level > 0.1, "{scope:?}: {level}");
        for tilt in [10.0, 20.0, 45.0, 60.0, 70.0, 80.0, 135.0] {
            let tilted = largest_slide(tilt);
            assert!((tilted - level).abs() < 1e-3 * level, "{scope:?}, {tilt} degrees: {tilted} and {level}");
        }
    }
}

/// The ball starts at most a tenth of its height above the collider; in the valley it overlaps the slopes at
/// the start. 0.02 and 5e-3 are regression bounds.
#[test]
fn the_correction_of_a_dropped_body_enters_colliders_by_at_most_two_hundredths_of_a_cell() {
    let slope = |x: f64| Collider::plane([0.0, -5.0, 0.0], [x, 1.0, 0.0]);
    let grounds = [
        ("plane", vec![slope(0.0)], 1e-5),
        ("valley", vec![slope(1.0), slope(-1.0)], 1e-5),
        ("sphere", vec![Collider::sphere([0.5, -8.0, 0.0], 3.0)], 0.02),
        ("rod", vec![Collider::capsule([-9.0, -6.0, 0.0], [9.0, -6.0, 0.0], 1.0)], 0.02),
        ("edge", vec![Collider::cuboid([0.0, -8.5, 0.0], [3.0, 3.0, 9.0], [0.0, 0.0, 45.0])], 0.02),
    ];
    for (name, ground, limit) in grounds {
        for (scope, half_width) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
            let mut pair = Pair::new(|| ball().half_width(half_width), SCOPES[scope], &ground, 60.0);
            let worst = worst(&mut pair, 90);
            assert!(worst.extra_depth < limit, "{name}, {:?}, {half_width}: {worst:?}", SCOPES[scope]);
            // A sharp edge can block the correction in all directions; the report then has a residual.
            assert!(worst.residual < 5e-3, "{name}, {:?}, {half_width}: {worst:?}", SCOPES[scope]);
        }
    }
}

#[test]
fn the_correction_moves_nothing_at_rest_above_or_overlapping_a_sphere() {
    for height in [-8.0, -3.0] {
        let pair = Pair::new(ball, VolumeScope::Regional, &[Collider::sphere([0.0, height, 0.0], 3.0)], 0.0);
        assert_eq!(surface_points(pair.corrected.body(0)), surface_points(pair.uncorrected.body(0)));
    }
}

/// The evaluated surface depends on the current colliders, not on earlier steps.
#[test]
fn a_restored_state_has_the_same_evaluated_surface() {
    let make = || Pair::new(ball, VolumeScope::Regional, &plates(4.2, 1.6), 0.0).corrected;
    let mut simulation = make();
    simulation.steps(70);
    let mut other = make();
    other.restore(&simulation.state()).unwrap();
    assert_eq!(surface_points(simulation.body(0)), surface_points(other.body(0)));
}
