//! Looking at a body: goals, the corrected lattice, the surface, reports. Nothing here changes what follows.

use nalgebra::Point3;

use super::Body;
use crate::lanes::Lanes;
use crate::matching::Matching;
use crate::parallel::Executor;

impl Body {
    /// The goal positions of the current positions, shape `(n, 3)`. No time passes.
    pub fn goals(&self) -> Vec<Point3<f64>> {
        let layout = self.matching.layout.clone();
        let mut matching = Matching::new(&self.lattice, layout, self.half_width());
        let mut rotations = self.state.rotations.clone();
        let mut goals = Lanes::zeros(self.matching.layout.blocks());
        let executor = Executor::sequential();
        matching.fit(&executor, &self.state.positions, &mut rotations);
        matching.goals(&executor, &mut goals);
        self.by_vertex(|slot| self.state.frame.to_world(goals.get(slot).map(f64::from).into()))
    }
}
