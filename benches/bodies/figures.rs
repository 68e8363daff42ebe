//! Generates thin, branching shapes: rasterizes tapered capsules into cells.

use nalgebra::{Rotation3, Vector3};
use supple::Lattice;

use super::unit_lattice;

type Vec3 = Vector3<f64>;

/// A shape whose bounding box is mostly empty. Its height is approximately 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// A body with head, arms and legs.
    Limbs,
    /// A ball with forty spikes.
    Star,
    /// A head with eight thin winding arms.
    Octopus,
}

/// A tapered capsule: a ball swept along a segment with a linearly varying radius.
struct Capsule {
    ends: [Vec3; 2],
    radii: [f64; 2],
}

/// Relative tolerance of the number of lattice vertices.
const TOLERANCE: f64 = 0.01;

impl Figure {
    /// Builds the lattice of the figure. Its number of vertices differs from `vertices` by at most 1 %.
    ///
    /// # Panics
    ///
    /// Panics if `vertices` is 0, or if the memory does not suffice.
    pub fn lattice(self, vertices: usize) -> Lattice {
        let capsules = self.capsules();
        let mut cells_per_unit = (vertices as f64).cbrt();
        loop {
            let lattice = unit_lattice(&cells(&capsules, cells_per_unit));
            let factor = vertices as f64 / lattice.len() as f64;
            if (factor - 1.0).abs() <= TOLERANCE {
                return lattice;
            }
            // The number of vertices grows with the third power of the resolution for a solid and with the
            // second power for a sheet. The exponent 0.4 is between 1/3 and 1/2.
            cells_per_unit *= factor.powf(0.4);
        }
    }

    fn capsules(self) -> Vec<Capsule> {
        match self {
            Self::Limbs => limbs(),
            Self::Star => star(),
            Self::Octopus => octopus(),
        }
    }
}

fn limbs() -> Vec<Capsule> {
    let point = |x, y, z| Vec3::new(x, y, z);
    let mut capsules = vec![
        capsule([point(0.0, 0.52, 0.0), point(0.0, 0.78, 0.0)], [0.075, 0.09]),
        capsule([point(0.0, 0.84, 0.0), point(0.0, 0.94, 0.01)], [0.035, 0.065]),
    ];
    for side in [-1.0, 1.0] {
        let chain = |joints: [Vec3; 4], radii: [f64; 4]| {
            (0..3).map(move |k| capsule([joints[k], joints[k + 1]], [radii[k], radii[k + 1]]))
        };
        let arm = [(0.1, 0.8, 0.0), (0.27, 0.69, -0.03), (0.42, 0.62, 0.05), (0.5, 0.58, 0.08)];
        let leg = [(0.06, 0.5, 0.0), (0.11, 0.27, 0.03), (0.14, 0.05, -0.03), (0.15, 0.02, 0.07)];
        let mirrored = |joints: [(f64, f64, f64); 4]| joints.map(|(x, y, z)| point(side * x, y, z));
        capsules.extend(chain(mirrored(arm), [0.035, 0.028, 0.02, 0.012]));
        capsules.extend(chain(mirrored(leg), [0.06, 0.042, 0.028, 0.02]));
    }
    capsules
}

fn star() -> Vec<Capsule> {
    const SPIKES: usize = 40;
    // The spikes point to a Fibonacci lattice on the sphere.
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let spike = |k: usize| {
        let y = 1.0 - 2.0 * (k as f64 + 0.5) / SPIKES as f64;
        let (sin, cos) = (golden_angle * k as f64).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        let tip = Vec3::new(radius * cos, y, radius * sin) * if k.is_multiple_of(2) { 0.5 } else { 0.38 };
        capsule([Vec3::zeros(), tip], [0.03, 0.004])
    };
    let ball = capsule([Vec3::zeros(), Vec3::zeros()], [0.1, 0.1]);
    std::iter::once(ball).chain((0..SPIKES).map(spike)).collect()
}

fn octopus() -> Vec<Capsule> {
    const ARMS: usize = 8;
    const JOINTS: usize = 32;
    let mut capsules = vec![capsule([Vec3::new(0.0, 0.1, 0.0), Vec3::new(0.0, 0.26, 0.05)], [0.08, 0.1])];
    for arm in 0..ARMS {
        let position = |joint: usize| {
            let t = joint as f64 / JOINTS as f64;
            let outward =
                Rotation3::from_axis_angle(&Vec3::y_axis(), std::f64::consts::TAU * arm as f64 / ARMS as f64);
            // The arm sways sideways and upward, with a different phase for each arm.
            let sway = (7.0 * t + 0.8 * arm as f64).sin();
            let lift = (5.0 * t + 0.5 * arm as f64).cos();
            outward * Vec3::new(0.05 + 0.55 * t, 0.06 + 0.1 * t * lift, 0.12 * t * sway)
        };
        let radius = |joint: usize| 0.026 - 0.022 * joint as f64 / JOINTS as f64;
        capsules.extend((0..JOINTS).map(|joint| {
            let joints = [joint, joint + 1];
            capsule(joints.map(position), joints.map(radius))
        }));
    }
    capsules
}

fn capsule(ends: [Vec3; 2], radii: [f64; 2]) -> Capsule {
    Capsule { ends, radii }
}

/// Returns the cells whose centers lie in a capsule. The grid has `cells_per_unit` cells per unit of length.
fn cells(capsules: &[Capsule], cells_per_unit: f64) -> Vec<[i32; 3]> {
    let mut cells: Vec<_> = capsules.iter().flat_map(|capsule| capsule.rasterize(cells_per_unit)).collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}

impl Capsule {
    /// Returns the cells whose centers lie in the capsule. The grid has `cells_per_unit` cells per unit of
    /// length.
    fn rasterize(&self, cells_per_unit: f64) -> Vec<[i32; 3]> {
        let [a, b] = self.ends.map(|end| end * cells_per_unit);
        // A minimum radius of one cell keeps thin capsules connected.
        let radii = self.radii.map(|radius| (radius * cells_per_unit).max(1.0));
        let margin = Vec3::repeat(radii[0].max(radii[1]));
        let (low, high) = (a.inf(&b) - margin, a.sup(&b) + margin);
        let range = |axis: usize| low[axis].floor() as i32..=high[axis].ceil() as i32;
        let axis = b - a;
        let inside = |cell: [i32; 3]| {
            let center = Vec3::from(cell.map(|k| f64::from(k) + 0.5));
            let length_squared = axis.norm_squared();
            let t = match length_squared > 0.0 {
                true => ((center - a).dot(&axis) / length_squared).clamp(0.0, 1.0),
                false => 0.0,
            };
            (a + axis * t - center).norm() <= radii[0] + (radii[1] - radii[0]) * t
        };
        let mut cells = Vec::new();
        for z in range(2) {
            for y in range(1) {
                cells.extend(range(0).map(|x| [x, y, z]).filter(|&cell| inside(cell)));
            }
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_connected_and_fill_little_of_their_boxes() {
        for figure in [Figure::Limbs, Figure::Star, Figure::Octopus] {
            let lattice = figure.lattice(20_000);
            let extent = |axis: usize| {
                let coordinates = || lattice.indices().iter().map(move |index| index[axis]);
                f64::from(coordinates().max().unwrap() - coordinates().min().unwrap() + 1)
            };
            let filled_fraction = lattice.len() as f64 / (extent(0) * extent(1) * extent(2));
            let ratio = lattice.len() as f64 / 20_000.0;
            assert!((ratio - 1.0).abs() <= TOLERANCE, "{figure:?}: {ratio}");
            assert_eq!(lattice.components().count, 1, "{figure:?}");
            assert!(filled_fraction < 0.2, "{figure:?} fills {filled_fraction} of its box");
        }
    }
}
