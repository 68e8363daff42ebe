//! Results have the same bits for any number of threads, with or without evaluation, at every SIMD level.

use nalgebra::{Point3, Vector3};
use supple::reference::{self, Regions};
use supple::{
    Body, Collider, Field, FieldLaw, Handle, Key, Lattice, Material, Pin, Selection, Simulation, Substeps,
    Switch, SwitchKey, TimeWindow, VolumeOptions, VolumeScope, Wind, Zone,
};
use supple_tests::{Random, block, coordinates, half_cells, lattice, points, rest, tolerance, worst};

type Outcome = (Vec<Point3<f64>>, Vec<Vector3<f64>>);

/// A body of several chunks with every stage: damping, a pin, a handle, a plane, a sphere, a
/// driven collider, the regional correction.
fn full_simulation(threads: usize) -> Simulation {
    let lattice = lattice(&block([33, 17, 19]));
    assert!(lattice.len() > 8_192, "more than two chunks of 4,096 lattice vertices");
    let mut random = Random(31);
    let x: Vec<_> = rest(&lattice).iter().map(|x| x + random.vector() * 0.1).collect();
    let window = TimeWindow { start: 0.1, end: 0.6 };
    let side = |x: f64| Selection::Plane { point: [x, 0.0, 0.0], normal: [x - 16.0, 0.0, 0.0] };
    let key = |time, rotate| Key { time, translate: [0.0, time, 0.0], rotate: [rotate, 0.0, 0.0] };
    let mut body = Body::from_lattice(lattice)
        .material(Material::fast_lsm())
        .half_width(2)
        .stiffness(0.8)
        .region_damping(0.1)
        .pin(Pin { goal: None, selection: side(1.0), window })
        .handle(Handle {
            goal: None,
            selection: side(32.0),
            motion: vec![key(0.0, 0.0), key(0.5, 40.0)].into(),
            window,
        })
        .volume(VolumeOptions { scope: VolumeScope::Regional, ..VolumeOptions::default() })
        .build()
        .unwrap();
    body.set_positions(&points(&x)).unwrap();
    let ground = Collider::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let sphere = Collider::sphere([16.0, -2.0, 9.0], 4.0);
    let world = Simulation::builder().body(body).collider(ground).collider(sphere).threads(threads);
    let mut simulation = world.build().unwrap();
    simulation.collider_mut(1).move_to_in([2.0, 1.0, 0.5], [0.0, 400.0, 90.0], 0.7).unwrap();
    simulation
}

/// Two bodies of the default material, with elastic damping, in automatic steps: two components of several chunks, of
/// which one is pinned and has a stiffer zone, and the other falls onto the ground, and a cube that rests on the ground and falls asleep.
fn damped_simulation(threads: usize) -> Simulation {
    let mut cells = block([33, 17, 19]);
    cells.extend(block([4, 4, 4]).into_iter().map(|[x, y, z]| [x + 36, y, z]));
    let lattice_of = |cells: &[[i32; 3]]| Lattice::from_cells(cells, 1.0, Point3::origin(), false).unwrap();
    let selection = Selection::Plane { point: [1.0, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
    let large = Body::from_lattice(lattice_of(&cells))
        .pin(Pin { goal: None, selection, window: TimeWindow::default() })
        .zone(Zone::new(Selection::Sphere { center: [16.0, 8.0, 9.0], radius: 6.0 }, 3.0))
        .spin([0.0, 0.0, 0.3])
        .translate([0.0, 0.2, 0.0])
        .build()
        .unwrap();
    assert!(large.lattice().components().count == 2 && large.lattice().len() > 8_192);
    let cube = Body::from_lattice(lattice_of(&block([3, 3, 3]))).translate([-6.0, 0.0, 0.0]);
    let cube = cube.damping_ratio(1.0).build().unwrap();
    let world = Simulation::builder().body(large).body(cube).threads(threads);
    let world = world.collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    world.fps(30.0).substeps(Substeps::Auto).build().unwrap()
}

/// Returns the positions and velocities of both bodies of [`damped_simulation`] after some frames.
fn run_damped(threads: usize, frames: u64) -> [Outcome; 2] {
    let mut sim = damped_simulation(threads);
    sim.advance(frames);
    [0, 1].map(|body| (sim.body(body).positions(), sim.body(body).velocities()))
}

#[test]
fn damped_steps_and_sleep_have_the_same_bits_for_any_number_of_threads() {
    let mut sim = damped_simulation(1);
    sim.advance(24);
    assert!(!sim.body(0).is_asleep() && sim.body(1).is_asleep());
    let one = run_damped(1, 24);
    for threads in [2, 3, 8] {
        assert!(run_damped(threads, 24) == one, "{threads} threads differ from one");
    }
}

fn run(threads: usize) -> Outcome {
    let mut sim = full_simulation(threads);
    sim.steps(60);
    (sim.body(0).positions(), sim.body(0).velocities())
}

#[test]
fn steps_have_the_same_bits_for_any_number_of_threads() {
    let one = run(1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads differ from one");
    }
}

#[test]
fn corrected_positions_have_the_same_bits_for_any_number_of_threads() {
    let corrected = |threads| {
        let mut sim = full_simulation(threads);
        [20, 20].map(|steps| {
            sim.steps(steps);
            sim.body(0).corrected_positions()
        })
    };
    let one = corrected(1);
    for threads in [2, 3] {
        assert!(corrected(threads) == one, "{threads} threads differ from one");
    }
}

#[test]
fn evaluating_a_body_between_steps_changes_no_bit() {
    let unevaluated = run(1);
    let mut sim = full_simulation(2);
    for _ in 0..60 {
        sim.step();
        let body = sim.body(0);
        body.goals();
        body.corrected_positions();
        body.volume_report();
    }
    assert!((sim.body(0).positions(), sim.body(0).velocities()) == unevaluated);
}

/// Coordinates of several points.
type Vectors = Vec<[f64; 3]>;

/// The results at one SIMD level: its name; the goals of a small deformed body; its positions after one step
/// and after [`LEVEL_STEPS`]; positions, velocities and corrected positions of the full simulation, and positions and
/// velocities of the damped one, on one thread and on three.
type LevelResults = (String, Vectors, [Vectors; 2], [Vectors; 2]);

const LEVEL_STEPS: u64 = 20;
const LEVEL_HALF_WIDTH: usize = 2;

/// Returns the lattice of the small body and its deformed positions.
fn deformed() -> (Lattice, Vec<Vector3<f64>>) {
    let lattice = lattice(&block([9, 6, 7]));
    let mut random = Random(32);
    let x = rest(&lattice).iter().map(|x| x + random.vector() * 0.2).collect();
    (lattice, x)
}

/// Computes the results at the SIMD level of this process.
fn level_results() -> LevelResults {
    let plain = |x: &[Vector3<f64>]| -> Vectors { x.iter().map(|&x| x.into()).collect() };
    let (lattice, x) = deformed();
    let body = Body::from_lattice(lattice)
        .material(Material::fast_lsm())
        .half_width(LEVEL_HALF_WIDTH)
        .stiffness(1.0)
        .region_damping(0.05);
    let mut body = body.build().unwrap();
    body.set_positions(&points(&x)).unwrap();
    let goals = plain(&coordinates(&body.goals()));
    let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).threads(1).build().unwrap();
    let stepped = [1, LEVEL_STEPS - 1].map(|steps| {
        sim.steps(steps);
        plain(&coordinates(&sim.body(0).positions()))
    });
    let full = [1, 3].map(|threads| {
        let mut sim = full_simulation(threads);
        sim.steps(LEVEL_STEPS);
        let body = sim.body(0);
        let corrected = coordinates(&body.corrected_positions());
        let mut full = [coordinates(&body.positions()), body.velocities(), corrected].concat();
        for (positions, velocities) in run_damped(threads, 2) {
            full.extend(coordinates(&positions).into_iter().chain(velocities));
        }
        plain(&full)
    });
    (supple::simd_level().to_owned(), goals, stepped, full)
}

/// Returns the results of a process that runs at `level`, or `None` if the machine lacks that level. The
/// level is chosen once per process, so the test that calls this starts itself again.
fn results_at(level: &str, test: &str) -> Option<LevelResults> {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("results");
    let status = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test])
        .env("SUPPLE_SIMD", level)
        .env(LEVEL_OUTPUT, &file)
        .stdout(std::process::Stdio::null())
        .status()
        .unwrap();
    assert!(status.success(), "{level}");
    let results: LevelResults = postcard::from_bytes(&std::fs::read(&file).ok()?).unwrap();
    assert_eq!(results.0, level, "the level that ran");
    Some(results)
}

/// The environment variable that names the file for the results of a process started by [`results_at`].
const LEVEL_OUTPUT: &str = "SUPPLE_TEST_LEVEL_OUTPUT";

/// Results have the same bits at every SIMD level, and are close to the f64 reference, to the tolerance of
/// `matching::goals_equal_the_reference`.
#[test]
fn every_simd_level_gives_the_same_bits_and_is_close_to_the_reference() {
    if let Ok(file) = std::env::var(LEVEL_OUTPUT) {
        // Where the machine lacks the level, the library runs its best one instead: that leaves no file.
        if supple::check_simd_request().is_ok() {
            std::fs::write(file, postcard::to_stdvec(&level_results()).unwrap()).unwrap();
        }
        return;
    }
    let test = "same_bits::every_simd_level_gives_the_same_bits_and_is_close_to_the_reference";
    let names = ["scalar", "sse2", "sse4.2", "avx2", "avx512", "neon"];
    let levels: Vec<LevelResults> = names.iter().filter_map(|name| results_at(name, test)).collect();
    let ran: Vec<&str> = levels.iter().map(|(name, ..)| &**name).collect();
    // Every x86-64 processor has SSE2 and every AArch64 one NEON. Scalar code is compiled only for targets
    // that guarantee neither, and is the only level there.
    #[cfg(target_arch = "x86_64")]
    {
        assert!(ran.contains(&"sse2"), "{ran:?}");
        if std::is_x86_feature_detected!("avx2") {
            assert!(ran.contains(&"sse4.2") && ran.len() >= 2, "{ran:?}");
        }
    }
    #[cfg(target_arch = "aarch64")]
    assert_eq!(ran, ["neon"]);
    assert!(!ran.is_empty() && (!ran.contains(&"scalar") || ran.len() == 1), "{ran:?}");

    let (_, goals, stepped, full) = level_results();
    assert!(full[0] == full[1], "three threads differ from one");
    for (name, level_goals, level_stepped, level_full) in &levels {
        assert!(*level_goals == goals, "{name}: other goals than at {}", supple::simd_level());
        assert!(*level_stepped == stepped, "{name}: other positions after steps");
        assert!(*level_full == full, "{name}: other results of whole simulations");
    }

    let vectors = |x: &Vectors| -> Vec<Vector3<f64>> { x.iter().map(|&x| x.into()).collect() };
    let (lattice, x) = deformed();
    let naive = reference::goals(&lattice, &x, LEVEL_HALF_WIDTH, Regions::Staircase);
    let goal_error = tolerance(x.iter().map(|x| x.amax()).fold(1.0, f64::max));
    let error = worst(&vectors(&goals), &naive);
    assert!(error <= goal_error, "goals {error:e} cells off the reference");
    // From rest, a step at stiffness 1 ends in the goals; the new positions are rounded once more.
    let error = worst(&vectors(&stepped[0]), &naive);
    assert!(error <= 2.0 * goal_error, "{error:e} cells off the reference after one step");
}

/// Bodies that do not touch each other, and change nothing but themselves: one falls onto a moving plane and comes to rest,
/// one is moved by a handle, and one is in the wind. `switches`: whether a collider that is far away is disabled later.
fn bodies_apart(threads: usize, switches: bool) -> Simulation {
    let cube = |x: f64| Body::from_lattice(half_cells()).youngs_modulus(2e4).translate([x, 0.2, 0.0]);
    let keys = vec![Key::default(), Key { time: 0.3, translate: [0.0, 0.4, 0.2], rotate: [0.0, 50.0, 0.0] }];
    let (selection, window) = (Selection::Vertices(vec![0, 1, 5, 20]), TimeWindow { start: 0.05, end: 0.2 });
    let handle = Handle { goal: None, selection, motion: keys.into(), window };
    let bodies = [cube(0.0).name("falls"), cube(0.0).handle(handle), cube(0.2).spin([0.0, 2.0, 1.0])];
    let rising = vec![Key::default(), Key { time: 0.1, translate: [0.0, 0.1, 0.0], ..Key::default() }];
    let ground = Collider { keys: rising, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let switch = [(0.0, true), (0.25, !switches)].map(|(time, value)| SwitchKey { time, value });
    let far = Collider::sphere([0.0, 500.0, 0.0], 1.0);
    let far = Collider { enabled: Switch::new(switch.to_vec()).unwrap(), ..far };
    let wind = Wind { velocity: [0.0, 0.0, 3.0], drag: 1.0, ..Wind::default() };
    let builder =
        Simulation::builder().collider(ground).collider(far).field(Field::new(FieldLaw::Wind(wind)));
    let builder = builder.fps(60.0).substeps(Substeps::Fixed(7)).contact(false).threads(threads);
    bodies.into_iter().fold(builder, |builder, body| builder.body(body.build().unwrap())).build().unwrap()
}

#[test]
fn bodies_that_do_not_touch_have_the_same_bits_in_a_call_for_many_steps_and_step_by_step() {
    let outcome = |simulation: &Simulation| -> Vec<Outcome> {
        assert_eq!(simulation.step_count(), 280);
        simulation.bodies().iter().map(|body| (body.positions(), body.velocities())).collect()
    };
    // A collider that is switched lets all bodies take each step before the next one.
    let mut together = bodies_apart(1, true);
    together.advance(40);
    let expected = outcome(&together);
    for threads in [1, 3] {
        let mut apart = bodies_apart(threads, false);
        apart.advance(3);
        apart.steps(250);
        (0..9).for_each(|_| apart.step());
        assert!(outcome(&apart) == expected, "{threads} threads");
        assert_eq!(apart.time(), together.time());
    }
}
