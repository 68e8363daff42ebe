//! Pins and handles: they override positions after matching and carry the velocity of their motion.

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use super::{BodyState, Interval, Key, Motion, MotionError, Pose, Selection};

/// A part of a body held as it is at `from`.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// What is held.
    pub selection: Selection,
    /// When. Default: from the start, for ever.
    pub window: Window,
}

/// A part of a body moved along keys, relative to the pose that it has at `from`.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// What is moved.
    pub selection: Selection,
    /// Displacements from the captured pose, rotations about the captured centre.
    pub keys: Vec<Key>,
    /// When. Default: from the start, for ever.
    pub window: Window,
}

/// When a pin or a handle holds, in seconds.
///
/// It captures what it holds at the start of the first step that starts at or after `from`, and lets go after
/// the last step that ends at or before `until`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize, serde::Deserialize))]
pub struct Window {
    /// Finite. Default 0.
    pub from: f64,
    /// Greater than `from`. Default infinity: for ever.
    pub until: f64,
}

impl Default for Window {
    fn default() -> Self {
        Self { from: 0.0, until: f64::INFINITY }
    }
}

/// A pin or a handle that has been resolved to lattice vertices.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize, serde::Deserialize))]
pub struct Hold {
    vertices: Vec<u32>,
    window: Window,
    motion: Option<Motion>,
}

/// What a hold found when it began: state, which a checkpoint keeps.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize, serde::Deserialize))]
pub struct Capture {
    /// Mean of the positions: the centre of the hold's rotations, world space.
    pub centre: [f64; 3],
    /// World position of each held vertex, in the order of the hold's vertices.
    pub positions: Vec<[f64; 3]>,
}

/// Why a pin or a handle cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum KinematicsError {
    /// The window is empty or not a number.
    #[error("from = {from}, until = {until}: from must be finite and until greater than it")]
    Window {
        /// Start in seconds.
        from: f64,
        /// End in seconds.
        until: f64,
    },
    /// The keys are no motion.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// There is no such pin or handle.
    #[error("there is no pin or handle {hold}: the body has {count}")]
    NoSuchHold {
        /// The index asked for.
        hold: usize,
        /// How many there are.
        count: usize,
    },
    /// A saved capture is not one of these holds.
    #[error("the saved captures do not fit: {saved} saved, {expected} expected for hold {hold}")]
    Restore {
        /// Index of the hold, or the number of holds if that differs.
        hold: usize,
        /// How many were saved.
        saved: usize,
        /// How many there should be.
        expected: usize,
    },
}

impl Hold {
    /// Holds `vertices` (lattice vertices in increasing order, each once), still without `keys`.
    ///
    /// # Errors
    /// An empty or non-numeric window, or keys that are no motion.
    pub fn new(vertices: Vec<u32>, window: Window, keys: Option<&[Key]>) -> Result<Self, KinematicsError> {
        let Window { from, until } = window;
        if !from.is_finite() || until.is_nan() || until <= from {
            return Err(KinematicsError::Window { from, until });
        }
        let motion = keys.map(|keys| Motion::new(keys.to_vec())).transpose()?;
        Ok(Self { vertices, window, motion })
    }

    /// The held lattice vertices, in increasing order.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Whether the hold acts in the step. A step that misses a limit by rounding alone counts as on it.
    fn acts_in(&self, step: Interval) -> bool {
        let slack = 1e-6 * step.dt;
        step.start >= self.window.from - slack && step.end <= self.window.until + slack
    }

    fn pose(&self, time: f64) -> Pose {
        self.motion.as_ref().map_or_else(Pose::identity, |motion| motion.pose(time))
    }
}

/// The stage of pins and handles of one body.
///
/// Where holds overlap, the later one wins.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize, serde::Deserialize))]
pub struct Kinematics {
    holds: Vec<Hold>,
    captured: Vec<Option<Capture>>,
    active: Vec<bool>,
    held: Vec<bool>,
}

impl Kinematics {
    /// The stage for a lattice of `vertex_count` vertices.
    pub fn new(vertex_count: usize, holds: Vec<Hold>) -> Self {
        let count = holds.len();
        let mut stage =
            Self { holds, captured: vec![None; count], active: vec![false; count], held: Vec::new() };
        stage.held.resize(vertex_count, false);
        stage
    }

    /// Adds a hold, which wins over those before it.
    pub fn add(&mut self, hold: Hold) {
        self.holds.push(hold);
        self.captured.push(None);
        self.active.push(false);
    }

    /// Lets a hold go for good.
    ///
    /// # Errors
    /// If there is no such hold.
    pub fn release(&mut self, hold: usize) -> Result<(), KinematicsError> {
        self.hold_mut(hold)?.window.until = f64::NEG_INFINITY;
        Ok(())
    }

    /// Gives a hold another motion, relative to what it captured.
    ///
    /// # Errors
    /// If there is no such hold.
    pub fn set_motion(&mut self, hold: usize, motion: Motion) -> Result<(), KinematicsError> {
        self.hold_mut(hold)?.motion = Some(motion);
        Ok(())
    }

    fn hold_mut(&mut self, hold: usize) -> Result<&mut Hold, KinematicsError> {
        let count = self.holds.len();
        self.holds.get_mut(hold).ok_or(KinematicsError::NoSuchHold { hold, count })
    }

    /// Whether all arrays are of a lattice of so many vertices, as those read from a file may not be.
    #[cfg(feature = "scene")]
    pub(crate) fn is_whole(&self, vertices: usize) -> bool {
        let count = self.holds.len();
        let inside = |hold: &Hold| hold.vertices.iter().all(|&vertex| (vertex as usize) < vertices);
        let fits = |(hold, captured): (&Hold, &Option<Capture>)| {
            captured.as_ref().is_none_or(|captured| captured.positions.len() == hold.vertices.len())
        };
        self.held.len() == vertices
            && self.captured.len() == count
            && self.active.len() == count
            && self.holds.iter().all(inside)
            && self.holds.iter().zip(&self.captured).all(fits)
    }

    /// The holds in order; later ones win.
    pub fn holds(&self) -> &[Hold] {
        &self.holds
    }

    /// Opens a step, before positions change: what begins to hold captures where it is, and
    /// [`held`](Self::held) tells the truth from here to the end of the step. Says whether it tells something new.
    ///
    /// `slots` has the slot of each lattice vertex.
    pub fn begin(&mut self, step: Interval, state: &BodyState<'_>, slots: &[u32]) -> bool {
        let mut changed = false;
        for ((hold, captured), active) in self.holds.iter().zip(&mut self.captured).zip(&mut self.active) {
            let acts = hold.acts_in(step);
            changed |= acts != *active;
            *active = acts;
            if acts && captured.is_none() {
                *captured = Some(Capture::of(&hold.vertices, state, slots));
            }
        }
        if changed {
            self.held.fill(false);
            for (hold, _) in self.holds.iter().zip(&self.active).filter(|(_, active)| **active) {
                for &vertex in &hold.vertices {
                    self.held[vertex as usize] = true;
                }
            }
        }
        changed
    }

    /// Closes a step: held vertices go to where the hold has them at its end, with the velocity of its motion,
    /// `(target(end) - target(start)) / dt`.
    pub fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        let to_local_velocity = 1.0 / (step.dt * state.frame.cell_size);
        for ((hold, captured), active) in self.holds.iter().zip(&self.captured).zip(&self.active) {
            let (true, Some(captured)) = (*active, captured) else { continue };
            let (start, end) = (hold.pose(step.start), hold.pose(step.end));
            let centre = Point3::from(captured.centre);
            // Differences of poses and not of places: no rounding at a million cells from the world's origin.
            let (turned, moved) = (end.rotation - start.rotation, end.translate - start.translate);
            for (&vertex, &captured) in hold.vertices.iter().zip(&captured.positions) {
                let captured = Point3::from(captured);
                let target = if hold.motion.is_some() { end.apply(&centre, &captured) } else { captured };
                let velocity: Vector3<f64> = (turned * (captured - centre) + moved) * to_local_velocity;
                let slot = slots[vertex as usize];
                state.set_position(slot, state.frame.to_local(&target));
                state.set_velocity(slot, velocity);
            }
        }
    }

    /// For each lattice vertex, whether a pin or a handle holds it in the step that was begun last.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Whether anything is held in the step that was begun last.
    pub fn holds_any(&self) -> bool {
        self.active.contains(&true)
    }

    /// What each hold captured, `None` where it has not begun: state, to be saved with a checkpoint.
    pub fn captured(&self) -> &[Option<Capture>] {
        &self.captured
    }

    /// Puts back what [`captured`](Self::captured) gave.
    ///
    /// # Errors
    /// Captures of other holds than these; nothing is changed then.
    pub fn restore(&mut self, captured: Vec<Option<Capture>>) -> Result<(), KinematicsError> {
        if captured.len() != self.holds.len() {
            let (saved, expected) = (captured.len(), self.holds.len());
            return Err(KinematicsError::Restore { hold: expected, saved, expected });
        }
        for (index, (hold, capture)) in self.holds.iter().zip(&captured).enumerate() {
            let (saved, expected) =
                (capture.as_ref().map_or(hold.vertices.len(), |c| c.positions.len()), hold.vertices.len());
            if saved != expected {
                return Err(KinematicsError::Restore { hold: index, saved, expected });
            }
        }
        self.captured = captured;
        Ok(())
    }
}

impl Capture {
    fn of(vertices: &[u32], state: &BodyState<'_>, slots: &[u32]) -> Self {
        let place = |&vertex: &u32| state.frame.to_world(state.position(slots[vertex as usize]));
        let positions: Vec<[f64; 3]> = vertices.iter().map(|v| place(v).into()).collect();
        // The mean of the offsets from one of the points, which keeps its digits far from the world's origin.
        let base = positions.first().map_or_else(Point3::origin, |&p| Point3::from(p));
        let sum: Vector3<f64> = positions.iter().map(|&p| Point3::from(p) - base).sum();
        let centre = base + sum / positions.len().max(1) as f64;
        Self { centre: centre.into(), positions }
    }
}
