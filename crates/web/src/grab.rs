//! A part of the body that follows a pointer, and the part at its base that can be held.

use supple::{Body, Goal, Handle, Key, Pin, Selection, Simulation, TimeWindow};

use crate::settings::FRAMES_PER_SECOND;

/// Radius of the part that a pointer grabs, in m, and in cells if that is more.
const RADIUS: (f64, f64) = (0.06, 1.2);

/// The base reaches at most this far above the lowest lattice vertex, in m, and in cells if that is more. Vertices of a
/// layer are at the same height up to rounding.
const BASE_HEIGHT: (f64, f64) = (0.04, 0.5);

/// A part of the body that follows a pointer.
#[derive(Debug)]
pub(crate) struct Grab {
    pub(crate) pointer: u32,
    /// Index of the handle.
    handle: usize,
    /// Displacement from the place where the part was grabbed, in m.
    current: [f64; 3],
    pub(crate) target: [f64; 3],
}

impl Grab {
    /// Grabs the lattice vertices around a point in the start pose, whose positions are `start`. If there are none
    /// within the radius, grabs the nearest one. `goal`: `None` to hold them, or springs.
    pub(crate) fn new(
        pointer: u32,
        simulation: &mut Simulation,
        (start, point): (&[[f64; 3]], [f64; 3]),
        goal: Option<Goal>,
    ) -> Result<Self, supple::Error> {
        let (time, body) = (simulation.time(), simulation.body_mut(0));
        let distances = || start.iter().map(|position| distance(*position, point));
        let nearest = distances().fold(f64::INFINITY, f64::min);
        let radius = RADIUS.0.max(RADIUS.1 * body.lattice().cell_size()).max(nearest);
        let inside = (0..).zip(distances()).filter(|(_, distance)| *distance <= radius);
        let vertices = inside.map(|(vertex, _)| vertex).collect();
        body.handle(&Handle {
            goal,
            selection: Selection::Vertices(vertices),
            motion: vec![Key { time, ..Key::default() }].into(),
            window: TimeWindow { start: time, ..TimeWindow::default() },
        })?;
        Ok(Self { pointer, handle: body.constraint_count() - 1, current: [0.0; 3], target: [0.0; 3] })
    }

    /// Lets the handle move during the next frame. `share`: the part of the way to the target.
    pub(crate) fn follow(&mut self, simulation: &mut Simulation, share: f64) -> Result<(), supple::Error> {
        if self.current == self.target {
            return Ok(());
        }
        let (start, substeps) = (simulation.time(), simulation.substeps() as f64);
        let body = simulation.body_mut(0);
        // In a step the part moves by at most a cell.
        let limit = body.lattice().cell_size() * substeps;
        let share = share.min(limit / distance(self.current, self.target));
        let next = std::array::from_fn(|axis| {
            let (from, to) = (self.current[axis], self.target[axis]);
            if share < 1.0 { from + share * (to - from) } else { to }
        });
        let key = |time, translate| Key { time, translate, ..Key::default() };
        let keys = [key(start, self.current), key(start + 1.0 / FRAMES_PER_SECOND, next)];
        body.set_keys(self.handle, &keys, None)?;
        self.current = next;
        Ok(())
    }

    /// Lets go of the part.
    pub(crate) fn release(self, simulation: &mut Simulation) -> Result<(), supple::Error> {
        Ok(simulation.body_mut(0).release(self.handle)?)
    }
}

/// The lowest part of the body.
#[derive(Debug)]
pub(crate) struct Base {
    vertices: Vec<u32>,
    /// Index of the pin that holds it.
    pin: Option<usize>,
}

impl Base {
    /// Finds the base of a body in its start pose, and holds it if `is_held`.
    pub(crate) fn new(body: &mut Body, start: &[[f64; 3]], is_held: bool) -> Result<Self, supple::Error> {
        let lowest = start.iter().map(|position| position[1]).fold(f64::INFINITY, f64::min);
        let limit = lowest + BASE_HEIGHT.0.max(BASE_HEIGHT.1 * body.lattice().cell_size());
        let low = (0..).zip(start).filter(|(_, position)| position[1] <= limit);
        let mut base = Self { vertices: low.map(|(vertex, _)| vertex).collect(), pin: None };
        base.set_held(body, is_held)?;
        Ok(base)
    }

    /// Holds the base where it is, or lets go of it.
    pub(crate) fn set_held(&mut self, body: &mut Body, is_held: bool) -> Result<(), supple::Error> {
        match (self.pin, is_held) {
            (None, true) => {
                let selection = Selection::Vertices(self.vertices.clone());
                body.pin(&Pin { goal: None, selection, window: TimeWindow::default() })?;
                self.pin = Some(body.constraint_count() - 1);
            }
            (Some(pin), false) => {
                body.release(pin)?;
                self.pin = None;
            }
            _ => {}
        }
        Ok(())
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares: [f64; 3] = std::array::from_fn(|axis| (a[axis] - b[axis]).powi(2));
    squares.iter().sum::<f64>().sqrt()
}
