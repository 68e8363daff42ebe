//! The stage of pins and handles: they override positions after matching and carry the velocity of their motion.

use thiserror::Error;

use super::{Hold, Motion, MotionError};
use crate::state::{BodyState, Interval};

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
}

/// The stage of pins and handles of one body.
///
/// Where holds overlap, the later one wins.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Kinematics {
    holds: Vec<Hold>,
    held: Vec<bool>,
}

impl Kinematics {
    /// The stage for a lattice of `vertex_count` vertices.
    pub fn new(vertex_count: usize, holds: Vec<Hold>) -> Self {
        Self { holds, held: vec![false; vertex_count] }
    }

    /// Adds a hold, which wins over those before it.
    pub fn add(&mut self, hold: Hold) {
        self.holds.push(hold);
    }

    /// Lets a hold go for good.
    ///
    /// # Errors
    /// If there is no such hold.
    pub fn release(&mut self, hold: usize) -> Result<(), KinematicsError> {
        self.hold_mut(hold)?.release();
        Ok(())
    }

    /// Gives a hold another motion, relative to what it captured.
    ///
    /// # Errors
    /// If there is no such hold.
    pub fn set_motion(&mut self, hold: usize, motion: Motion) -> Result<(), KinematicsError> {
        self.hold_mut(hold)?.set_motion(motion);
        Ok(())
    }

    fn hold_mut(&mut self, hold: usize) -> Result<&mut Hold, KinematicsError> {
        let count = self.holds.len();
        self.holds.get_mut(hold).ok_or(KinematicsError::NoSuchHold { hold, count })
    }

    /// Whether all is of a lattice of so many vertices, as what is read from a file may not be.
    pub(crate) fn is_whole(&self, vertices: usize) -> bool {
        self.held.len() == vertices && self.holds.iter().all(|hold| hold.is_whole(vertices))
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
        for hold in &mut self.holds {
            changed |= hold.begin(step, state, slots);
        }
        if changed {
            self.held.fill(false);
            for &vertex in self.holds.iter().filter(|hold| hold.acts()).flat_map(Hold::vertices) {
                self.held[vertex as usize] = true;
            }
        }
        changed
    }

    /// Closes a step: held vertices go to where their holds have them at its end, with the velocity of that motion.
    pub fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        for hold in &self.holds {
            hold.apply(step, state, slots);
        }
    }

    /// For each lattice vertex, whether a pin or a handle holds it in the step that was begun last.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Whether anything is held in the step that was begun last.
    pub fn holds_any(&self) -> bool {
        self.holds.iter().any(Hold::acts)
    }
}
