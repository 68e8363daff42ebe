//! Pins and handles that ask for the impossible, and let go.

use supple::{Error, Handle, Key, Pin, Simulation, TimeWindow};

use crate::stability::bodies::{block, layer, of_cells};
use crate::stability::case::{Case, Figures, Measure, Suite};
use crate::stability::trial::{Surroundings, watch};

const BAR: [i32; 3] = [12, 4, 4];

/// When both ends let go, in seconds: by then what was done to them has calmed down.
const LET_GO: f64 = 15.0;

/// How the two ends of a bar move: time, way and turn about its axis in degrees. One end is pinned if it has no keys.
#[derive(Clone, Copy)]
struct Deed {
    far: [(f64, [f64; 3], f64); 2],
    near: Option<[(f64, [f64; 3], f64); 2]>,
}

fn keys(moves: [(f64, [f64; 3], f64); 2]) -> Vec<Key> {
    moves.map(|(time, translate, turn)| Key { time, translate, rotate: [turn, 0.0, 0.0] }).to_vec()
}

/// A bar is held at both ends, let go, and left to itself.
fn held(deed: Deed) -> Result<Figures, Error> {
    let window = TimeWindow { start: 0.0, end: LET_GO };
    let [near, far] = [0, BAR[0]].map(|at| layer(BAR, at));
    let body = of_cells(&block(BAR), 3)?.region_damping(0.1);
    let body = match deed.near {
        None => body.pin(Pin { selection: near, window }),
        Some(moves) => body.handle(Handle { selection: near, keys: keys(moves), window }),
    };
    let body = body.handle(Handle { selection: far, keys: keys(deed.far), window }).build()?;
    let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(1).build()?;
    Ok(watch(simulation, Surroundings::Acting, |trial| {
        trial.run((LET_GO * 60.0) as u64, 10);
        trial.run(3_000, 20);
    }))
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    let still = [0.0; 3];
    let along = |way: f64| [way, 0.0, 0.0];
    let far = |far| Deed { far, near: None };
    let deeds = [
        ("ends pulled 100 lengths apart", far([(0.0, still, 0.0), (1.0, along(1200.0), 0.0)]), 200.0),
        ("twisted by 10 turns", far([(0.0, still, 0.0), (4.0, still, 3600.0)]), 10.0),
        (
            "ends that change places",
            Deed {
                far: [(0.0, still, 0.0), (1.0, along(-12.0), 0.0)],
                near: Some([(0.0, still, 0.0), (1.0, along(12.0), 0.0)]),
            },
            10.0,
        ),
    ];
    let jumps = [
        ("1000", [300.0, -800.0, 500.0], 0.05, 2e3, Suite::Quick),
        // What turns when it is let go has so much spin that it cannot contract.
        ("1e12", along(1e12), 1e9, 2e12, Suite::Long),
    ];
    let shows = "bounded while it is held; let go, it returns to its rest shape";
    let deeds = deeds.into_iter().map(|(name, deed, speed)| {
        let case = Case::new(name, shows, move || held(deed));
        case.bound(Measure::Shape, 1e-3).bound(Measure::LargestSpeed, speed)
    });
    let shows =
        "bounded while it is held; let go, it flies with the momenta that it has, stretched by its spin";
    let jumps = jumps.into_iter().map(|(name, way, shape, speed, suite)| {
        let deed = far([(0.5, still, 0.0), (0.5 + 1e-9, way, 200.0)]);
        let case = Case::new(format!("a handle that jumps {name} cells"), shows, move || held(deed));
        case.bound(Measure::Shape, shape).bound(Measure::LargestSpeed, speed).suite(suite)
    });
    deeds.chain(jumps).collect()
}
