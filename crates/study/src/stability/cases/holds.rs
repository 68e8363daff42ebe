//! Cases with pins and handles that move extremely and then release the body.

use supple::{Error, Handle, Key, Pin, Simulation, TimeWindow};

use crate::stability::bodies::{block, layer, of_cells};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};
use crate::suite::Suite;

/// Cells of the bar along x, y and z.
const BAR: [i32; 3] = [12, 4, 4];

/// Time at which both ends are released, in seconds; the body has come to rest by then.
const RELEASE: f64 = 15.0;

/// Motion of the two ends of a bar. Each keyframe has a time in seconds, a displacement in cells, and a
/// rotation about the axis of the bar in degrees. The near end is pinned if it has no keyframes.
#[derive(Clone, Copy)]
struct EndMotion {
    far: [(f64, [f64; 3], f64); 2],
    near: Option<[(f64, [f64; 3], f64); 2]>,
}

/// Creates the keyframes of an end.
fn keys(moves: [(f64, [f64; 3], f64); 2]) -> Vec<Key> {
    moves.map(|(time, translate, angle)| Key { time, translate, rotate: [angle, 0.0, 0.0] }).to_vec()
}

/// Constrains a bar at both ends, releases it, and lets it move freely.
fn move_ends(motion: EndMotion) -> Result<Figures, Error> {
    let window = TimeWindow { start: 0.0, end: RELEASE };
    let [near, far] = [0, BAR[0]].map(|x| layer(BAR, x));
    let body = of_cells(&block(BAR), 3.0)?.region_damping(0.1);
    let body = match motion.near {
        None => body.pin(Pin { goal: None, selection: near, window }),
        Some(moves) => {
            body.handle(Handle { goal: None, selection: near, motion: keys(moves).into(), window })
        }
    };
    let body = body
        .handle(Handle { goal: None, selection: far, motion: keys(motion.far).into(), window })
        .build()?;
    let simulation = Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).threads(1).build()?;
    Ok(measure(simulation, System::Driven, |trial| {
        trial.run((RELEASE * 60.0) as u64, 10);
        trial.run(3_000, 20);
    }))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let still = [0.0; 3];
    let along_x = |displacement: f64| [displacement, 0.0, 0.0];
    let far = |far| EndMotion { far, near: None };
    let motions = [
        ("ends pulled 100 lengths apart", far([(0.0, still, 0.0), (1.0, along_x(1200.0), 0.0)]), 200.0),
        ("twisted by 10 turns", far([(0.0, still, 0.0), (4.0, still, 3600.0)]), 10.0),
        (
            "ends that change places",
            EndMotion {
                far: [(0.0, still, 0.0), (1.0, along_x(-12.0), 0.0)],
                near: Some([(0.0, still, 0.0), (1.0, along_x(12.0), 0.0)]),
            },
            10.0,
        ),
    ];
    let jumps = [
        ("1000", [300.0, -800.0, 500.0], 0.05, 2e3, Suite::Quick),
        // The bar rotates when it is released. Its spin is so large that it cannot contract, so the bound is
        // large.
        ("1e12", along_x(1e12), 1e9, 2e12, Suite::Long),
    ];
    let expected = "bounded while constrained; returns to its rest shape after the release";
    let motions = motions.into_iter().map(|(name, motion, speed)| {
        let case = Case::new(name, expected, move || move_ends(motion));
        case.bound(Measure::Shape, 1e-3).bound(Measure::LargestSpeed, speed)
    });
    let expected =
        "bounded while constrained; after the release it flies with its momenta, stretched by its spin";
    let jumps = jumps.into_iter().map(|(name, displacement, shape, speed, suite)| {
        let motion = far([(0.5, still, 0.0), (0.5 + 1e-9, displacement, 200.0)]);
        let case =
            Case::new(format!("a handle that jumps {name} cells"), expected, move || move_ends(motion));
        case.bound(Measure::Shape, shape).bound(Measure::LargestSpeed, speed).suite(suite)
    });
    motions.chain(jumps).collect()
}
