use super::*;
/// Interim.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct SimulationState {
    count: u64,
    bodies: Vec<crate::body::interim::BodyState>,
}
impl Simulation {
    /// Interim.
    pub fn state(&self) -> SimulationState {
        SimulationState { count: self.count, bodies: self.bodies.iter().map(|b| b.snapshot()).collect() }
    }
    /// Interim.
    pub fn restore(&mut self, s: &SimulationState) -> Result<(), Error> {
        self.count = s.count;
        for (b, s) in self.bodies.iter_mut().zip(&s.bodies) {
            b.set_snapshot(s);
        }
        Ok(())
    }
    /// Interim.
    pub fn plan(&self) -> String {
        "interim".into()
    }
}
