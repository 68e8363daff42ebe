use super::*;
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct BodyState {
    state: State,
    captured: Vec<Option<crate::dynamics::Capture>>,
}
impl Body {
    pub(crate) fn snapshot(&self) -> BodyState {
        BodyState {
            state: self.state.clone(),
            captured: self.kinematics.as_ref().map_or(vec![], |k| k.captured().to_vec()),
        }
    }
    pub(crate) fn set_snapshot(&mut self, s: &BodyState) {
        self.state = s.state.clone();
        self.bookkeeper.measure(
            &crate::parallel::Executor::sequential(),
            &self.matching.regions.constants,
            &self.state.positions,
            &self.state.velocities,
        );
        if let Some(k) = &mut self.kinematics {
            k.restore(s.captured.clone()).unwrap();
        }
    }
}
