//! Positions relative to a centre near each component, where single precision is fine enough for determinants.

use super::line::Moving;

/// Beyond this a position is cut off, so that differences of positions stay finite.
const FARTHEST: f64 = 1e37;

/// The mean position of each component's vertices.
#[derive(Clone, Debug)]
pub(super) struct Centres {
    sums: Vec<([f64; 3], f64)>,
    centres: Vec<[f64; 3]>,
}

impl Centres {
    pub(super) fn new(components: usize) -> Self {
        Self { sums: vec![([0.0; 3], 0.0); components], centres: vec![[0.0; 3]; components] }
    }

    /// The places become `positions[i] - centre`; the directions are left as they are.
    pub(super) fn centred(&mut self, positions: &[[f32; 3]], of_vertex: &[u32], points: &mut [Moving]) {
        self.subtract(positions.iter().map(|p| p.map(f64::from)), of_vertex, points);
    }

    /// As [`Centres::centred`], of the lattice at rest.
    pub(super) fn at_rest(&mut self, indices: &[[i32; 3]], of_vertex: &[u32], points: &mut [Moving]) {
        self.subtract(indices.iter().map(|i| i.map(f64::from)), of_vertex, points);
    }

    fn subtract(
        &mut self,
        positions: impl Iterator<Item = [f64; 3]> + Clone,
        of_vertex: &[u32],
        points: &mut [Moving],
    ) {
        self.sums.fill(([0.0; 3], 0.0));
        for (p, &component) in positions.clone().zip(of_vertex) {
            let (sum, count) = &mut self.sums[component as usize];
            for (sum, p) in sum.iter_mut().zip(p) {
                *sum += p;
            }
            *count += 1.0;
        }
        for (centre, (sum, count)) in self.centres.iter_mut().zip(&self.sums) {
            // Whole cells: the subtraction is then exact for positions on the grid.
            *centre = sum.map(|sum| (sum / count).round());
        }
        for ((p, &component), point) in positions.zip(of_vertex).zip(points) {
            let centre = &self.centres[component as usize];
            point.set_place(std::array::from_fn(|k| (p[k] - centre[k]).clamp(-FARTHEST, FARTHEST) as f32));
        }
    }
}
