//! The same bits for any number of threads, with and without looking, and the same figures at any SIMD level.

use crate::common::{Random, block, coordinates, lattice, points, rest, worst};
use nalgebra::{Point3, Vector3};
use supple::{
    Body, Collider, Handle, Key, Pin, Selection, Simulation, TimeWindow, VolumeOptions, VolumeScope,
};

type Outcome = (Vec<Point3<f64>>, Vec<Vector3<f64>>);

/// A body of several chunks with all stages: damping, a pin, a handle, the ground and a ball, the regional correction.
fn everything(threads: usize) -> Simulation {
    let lattice = lattice(&block([33, 17, 19]));
    assert!(lattice.len() > 8_192);
    let mut random = Random(31);
    let x: Vec<_> = rest(&lattice).iter().map(|x| x + random.vector() * 0.1).collect();
    let window = TimeWindow { start: 0.1, end: 0.6 };
    let side = |x: f64| Selection::Plane { point: [x, 0.0, 0.0], normal: [x - 16.0, 0.0, 0.0] };
    let key = |time, rotate| Key { time, translate: [0.0, time, 0.0], rotate: [rotate, 0.0, 0.0] };
    let mut body = Body::from_lattice(lattice)
        .half_width(2)
        .stiffness(0.8)
        .region_damping(0.1)
        .pin(Pin { selection: side(1.0), window })
        .handle(Handle { selection: side(32.0), keys: vec![key(0.0, 0.0), key(0.5, 40.0)], window })
        .volume(VolumeOptions { scope: VolumeScope::Regional, ..VolumeOptions::default() })
        .build()
        .unwrap();
    body.set_positions(&points(&x)).unwrap();
    let ground = Collider::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let ball = Collider::sphere([16.0, -2.0, 9.0], 4.0);
    Simulation::builder().body(body).collider(ground).collider(ball).threads(threads).build().unwrap()
}

fn run(threads: usize) -> Outcome {
    let mut sim = everything(threads);
    sim.steps(60);
    (sim.body(0).positions(), sim.body(0).velocities())
}

#[test]
fn for_any_number_of_threads() {
    let one = run(1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads differ from one");
    }
}

#[test]
fn what_is_shown_for_any_number_of_threads() {
    let shown = |threads| {
        let mut sim = everything(threads);
        [20, 20].map(|steps| {
            sim.steps(steps);
            sim.body(0).corrected_positions()
        })
    };
    let one = shown(1);
    for threads in [2, 3] {
        assert!(shown(threads) == one, "{threads} threads differ from one");
    }
}

#[test]
fn whether_somebody_looks_or_not() {
    let blind = run(1);
    let mut sim = everything(2);
    for _ in 0..60 {
        sim.step();
        let body = sim.body(0);
        body.goals();
        body.corrected_positions();
        body.volume_report();
    }
    assert!((sim.body(0).positions(), sim.body(0).velocities()) == blind);
}

/// The levels are chosen once in a process, so each runs in one of its own: this test itself.
#[test]
fn levels_with_fma_agree_bit_for_bit_and_others_to_a_tolerance() {
    const CHILD: &str = "SUPPLE_TEST_CHILD";
    let mut sim = Simulation::builder()
        .body(
            Body::from_lattice(lattice(&block([9, 6, 7])))
                .half_width(2)
                .region_damping(0.05)
                .build()
                .unwrap(),
        )
        .gravity([0.0; 3])
        .threads(1)
        .build()
        .unwrap();
    let mut random = Random(32);
    let x: Vec<_> = rest(sim.body(0).lattice()).iter().map(|x| x + random.vector() * 0.2).collect();
    sim.body_mut(0).set_positions(&points(&x)).unwrap();
    sim.steps(20);
    let x = coordinates(&sim.body(0).positions());
    if let Ok(file) = std::env::var(CHILD) {
        let text: Vec<String> = x.iter().flat_map(|x| x.iter().map(|x| x.to_bits().to_string())).collect();
        std::fs::write(file, format!("{} {}", supple::simd_level(), text.join(" "))).unwrap();
        return;
    }
    let own_level = supple::simd_level();
    let directory = tempfile::tempdir().unwrap();
    for level in ["sse2", "sse4.2", "avx2", "avx512", "neon"] {
        let file = directory.path().join(level);
        let status = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "same_bits::levels_with_fma_agree_bit_for_bit_and_others_to_a_tolerance"])
            .env("SUPPLE_SIMD", level)
            .env(CHILD, &file)
            .stdout(std::process::Stdio::null())
            .status()
            .unwrap();
        assert!(status.success());
        let text = std::fs::read_to_string(&file).unwrap();
        let (ran, bits) = text.split_once(' ').unwrap();
        let numbers: Vec<f64> = bits.split(' ').map(|b| f64::from_bits(b.parse().unwrap())).collect();
        let other: Vec<_> = numbers.chunks(3).map(Vector3::from_column_slice).collect();
        if ran == own_level {
            assert_eq!(x, other, "{level}");
        } else if [ran, own_level].iter().all(|level| ["avx2", "avx512", "neon"].contains(level)) {
            assert_eq!(x, other, "{ran} against {own_level}");
        } else {
            assert!(worst(&x, &other) < 1e-4, "{ran} against {own_level}");
        }
    }
}
