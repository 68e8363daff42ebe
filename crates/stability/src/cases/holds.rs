//! Pins and handles that ask for the impossible, and let go.

use supple::{Body, Error, Handle, Key, Pin, Simulation, Window};

use crate::bodies::{block, lattice, layer};
use crate::trial::Trial;
use crate::{Case, Figures, Measure};

const FAMILY: &str = "pins and handles";
const BAR: [i32; 3] = [12, 4, 4];

/// What a handle at one end of a bar does while the other end is pinned or handled, until both let go.
struct Deed {
    here: Vec<Key>,
    there: Option<Vec<Key>>,
    until: f64,
}

fn key(time: f64, translate: [f64; 3], rotate: [f64; 3]) -> Key {
    Key { time, translate, rotate }
}

/// A bar is held at both ends, let go after a while, and left to itself.
fn held(deed: &Deed, half_width: usize) -> Result<Figures, Error> {
    let lattice = lattice(&block(BAR))?;
    let window = Window { from: 0.0, until: deed.until };
    let [near, far] = [0, BAR[0]].map(|at| layer(&lattice, 0, at));
    let body = Body::from_lattice(lattice).half_width(half_width).damping(0.1);
    let body = match &deed.there {
        None => body.pin(Pin { selection: near, window }),
        Some(keys) => body.handle(Handle { selection: near, keys: keys.clone(), window }),
    };
    let body = body.handle(Handle { selection: far, keys: deed.here.clone(), window });
    let simulation = Simulation::builder().body(body.build()?).gravity([0.0; 3]).threads(1).build()?;
    let mut trial = Trial::bound(simulation);
    trial.run((deed.until * 60.0) as u64, 10);
    trial.run(3_000, 20);
    Ok(trial.finish())
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    let all: [(&'static str, fn() -> Deed); 5] = [
        ("ends pulled 100 lengths apart", || Deed {
            here: vec![key(0.0, [0.0; 3], [0.0; 3]), key(1.0, [1200.0, 0.0, 0.0], [0.0; 3])],
            there: None,
            until: 2.0,
        }),
        ("twisted by 10 turns", || Deed {
            here: vec![key(0.0, [0.0; 3], [0.0; 3]), key(4.0, [0.0; 3], [3600.0, 0.0, 0.0])],
            there: None,
            until: 5.0,
        }),
        ("ends that change places", || Deed {
            here: vec![key(0.0, [0.0; 3], [0.0; 3]), key(1.0, [-12.0, 0.0, 0.0], [0.0; 3])],
            there: Some(vec![key(0.0, [0.0; 3], [0.0; 3]), key(1.0, [12.0, 0.0, 0.0], [0.0; 3])]),
            until: 2.0,
        }),
        ("a handle that jumps 1000 cells", || Deed {
            here: vec![key(0.5, [0.0; 3], [0.0; 3]), key(0.5 + 1e-9, [300.0, -800.0, 500.0], [90.0, 0.0, 200.0])],
            there: None,
            until: 1.0,
        }),
        ("a handle that jumps 1e12 cells", || Deed {
            here: vec![key(0.5, [0.0; 3], [0.0; 3]), key(0.5 + 1e-9, [1e12, 0.0, 0.0], [0.0; 3])],
            there: None,
            until: 1.0,
        }),
    ];
    all.into_iter()
        .map(|(name, deed)| {
            let shows = "bounded while it is held; let go, it returns to its rest shape";
            Case::new(FAMILY, name, shows, move || held(&deed(), 3))
                .bound(Measure::Shape, 1e-3)
                .bound(Measure::FinalSpeed, 1e9)
        })
        .collect()
}
