//! Defines `[[body.handle]]`: a selection that moves along keyframes, or follows an animated mesh.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::error::SceneError;
use super::field::Field;
use super::keys::{
    SelectionKeys, WindowKeys, finite, fps, interpolation, keyframes, optional_goal, point_cache,
};
use supple::{Goal, Handle, HandleMotion, Interpolation, Key, MeshAnimation, Selection, TimeWindow};

/// `[[body.handle]]`: a selection, a time window and a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandleData {
    /// Keys `box`, `sphere`, `plane`, `vertices` or `vertices_file`, `group` or `lattice`.
    #[serde(rename = "@selection", with = "SelectionKeys")]
    pub selection: Selection,
    /// Keys `start` and `end`.
    #[serde(default, rename = "@window", with = "WindowKeys")]
    pub window: TimeWindow,
    /// Keyframes; empty if the handle follows an animated mesh.
    #[serde(default, with = "keyframes", skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<Key>,
    /// Interpolation between the keyframes.
    #[serde(default, with = "interpolation", skip_serializing_if = "Interpolation::is_linear")]
    pub interpolation: Interpolation,
    /// PC2 file with the positions of the vertices of the mesh, relative to the scene file, in place of keyframes.
    #[serde(default, deserialize_with = "point_cache", skip_serializing_if = "Option::is_none")]
    pub follow: Option<PathBuf>,
    /// Frames per second of the PC2 file, above 0; `None` for those of the simulation.
    #[serde(default, deserialize_with = "fps", skip_serializing_if = "Option::is_none")]
    pub follow_fps: Option<f64>,
    /// Time of the first sample of the PC2 file in seconds; `None` for that of its first frame.
    #[serde(default, deserialize_with = "finite", skip_serializing_if = "Option::is_none")]
    pub follow_start: Option<f64>,
    /// Keys `weight`, `goal_frequency` and `goal_damping`; `None` if the positions are prescribed.
    #[serde(default, rename = "@goal", with = "optional_goal", skip_serializing_if = "Option::is_none")]
    pub goal: Option<Goal>,
}

impl HandleData {
    /// Returns the handle. `read` returns the animation of a file.
    ///
    /// # Errors
    ///
    /// The error of `read`.
    pub fn handle<E>(&self, read: impl FnOnce(&PathBuf) -> Result<MeshAnimation, E>) -> Result<Handle, E> {
        let motion = match &self.follow {
            Some(path) => HandleMotion::Follow(read(path)?),
            None => HandleMotion::Keys(self.keys.clone(), self.interpolation),
        };
        Ok(Handle { goal: self.goal.clone(), selection: self.selection.clone(), motion, window: self.window })
    }

    /// Checks that the handle has either keyframes or an animation, and no key of the other one.
    pub(super) fn check(&self, field: &Field<'_>) -> Result<(), SceneError> {
        let given = [
            ("interpolation", self.interpolation != Interpolation::Linear),
            ("follow_fps", self.follow_fps.is_some()),
            ("follow_start", self.follow_start.is_some()),
        ];
        let is_given = |keys: &[&str]| given.iter().find(|(key, given)| *given && keys.contains(key));
        let (wrong, owner) = match (self.keys.is_empty(), self.follow.is_some()) {
            (true, false) => {
                let hint = "a list of keyframes like [{ time = 1, translate = [0, 1, 0] }]; or give `follow`, a PC2 file";
                return Err(field.missing("keys", hint));
            }
            (false, true) => return Err(field.exclusive("follow", "keys")),
            (true, true) => (is_given(&["interpolation"]), "keys"),
            (false, false) => (is_given(&["follow_fps", "follow_start"]), "follow"),
        };
        match wrong {
            Some((key, _)) => {
                Err(field.at(key).out_of_range(&format!("left out, because only `{owner}` has it")))
            }
            None => Ok(()),
        }
    }
}
