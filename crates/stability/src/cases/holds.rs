//! Pins and handles that ask for the impossible, and let go.

use supple::{Body, Error, Handle, Key, Pin, Simulation, Window};

use crate::bodies::{block, lattice, layer};
use crate::trial::{Surroundings, watch};
use crate::{Case, Figures, Measure};

const FAMILY: &str = "pins and handles";
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
    let lattice = lattice(&block(BAR))?;
    let window = Window { from: 0.0, until: LET_GO };
    let [near, far] = [0, BAR[0]].map(|at| layer(&lattice, 0, at));
    let body = Body::from_lattice(lattice).half_width(3).damping(0.1);
    let body = match deed.near {
        None => body.pin(Pin { selection: near, window }),
        Some(moves) => body.handle(Handle { selection: near, keys: keys(moves), window }),
    };
    let body = body.handle(Handle { selection: far, keys: keys(deed.far), window }).build()?;
    let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(1).build()?;
    watch(simulation, Surroundings::Acting, |trial| {
        trial.run((LET_GO * 60.0) as u64, 10);
        trial.run(3_000, 20);
        Ok(())
    })
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
        (
            "a handle that jumps 1000 cells",
            far([(0.5, still, 0.0), (0.5 + 1e-9, [300.0, -800.0, 500.0], 200.0)]),
            2000.0,
        ),
        ("a handle that jumps 1e12 cells", far([(0.5, still, 0.0), (0.5 + 1e-9, along(1e12), 0.0)]), 2e12),
    ];
    let shows = "bounded while it is held; let go, it returns to its rest shape";
    let case = |(name, deed, speed): (&str, Deed, f64)| {
        Case::new(FAMILY, name, shows, move || held(deed))
            .bound(Measure::Shape, 1e-3)
            .bound(Measure::LargestSpeed, speed)
    };
    deeds.into_iter().map(case).collect()
}
