//! The state of a body as a checkpoint holds it.

use super::{Body, State};
use crate::dynamics::{Capture, Interval, KinematicsError};

/// All of a body that steps change.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct BodySnapshot {
    state: State,
    captured: Vec<Option<Capture>>,
}

impl Body {
    /// The state as it is.
    pub(crate) fn snapshot(&self) -> BodySnapshot {
        let captured = self.kinematics.as_ref().map_or(&[][..], |kinematics| kinematics.captured());
        BodySnapshot { state: self.state.clone(), captured: captured.to_vec() }
    }

    /// Whether a snapshot is of a body like this one.
    pub(crate) fn fits(&self, snapshot: &BodySnapshot) -> Result<(), String> {
        let (own, other) = (self.state.positions.blocks().len(), snapshot.state.positions.blocks().len());
        if !(own == other && snapshot.state.is_whole(own, self.state.books.len())) {
            return Err(format!(
                "body {:?} has {own} blocks of lattice vertices, the state {other}",
                self.name
            ));
        }
        let holds = self.kinematics.as_ref().map_or(0, |kinematics| kinematics.holds().len());
        if holds != snapshot.captured.len() {
            let saved = snapshot.captured.len();
            return Err(format!("body {:?} has {holds} pins and handles, the state {saved}", self.name));
        }
        Ok(())
    }

    /// Takes over a state that [`Body::fits`] has passed; `last` is the step that made it.
    pub(crate) fn restore(
        &mut self,
        snapshot: &BodySnapshot,
        last: Option<Interval>,
    ) -> Result<(), KinematicsError> {
        if let Some(kinematics) = &mut self.kinematics {
            kinematics.restore(snapshot.captured.clone())?;
        }
        self.state = snapshot.state.clone();
        if let (Some(kinematics), Some(last)) = (&mut self.kinematics, last) {
            // Says what is held; all that was captured by then has been restored.
            kinematics.begin(last, &self.state.shared(), self.matching.layout.slots());
        }
        Ok(())
    }
}
