//! The step beside the naive method: explicit sums over each region, in f64, on one thread.

use nalgebra::{Matrix3, Vector3};
use supple::reference::{self, Regions};
use supple::{Body, Lattice, Simulation};
use supple_benches::Target::AtLeast;
use supple_benches::bodies::{block, deform, in_motion};

use crate::measure::{Bench, Effort, steps, timed};

/// Steps beside one evaluation of the naive sums.
const STEPS: u32 = 50;

pub(crate) fn bench(bench: &mut Bench) {
    bench.part("against the naive explicit sums, 1,000 lattice vertices, one thread");
    let lattice = block([10, 10, 10]);
    let mut body = Body::from_lattice(lattice.clone()).build().expect("a block is a body");
    deform(&mut body);
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    for (half_width, target) in [(1, None), (3, Some(AtLeast(100.0)))] {
        let state = || (in_motion(&lattice, half_width, 1), Listed::new(&lattice, half_width));
        let name = format!("w={half_width}");
        let work = |(simulation, listed): &mut (Simulation, Listed), n: u64| {
            let goals = || reference::goals(&lattice, &positions, half_width, Regions::Staircase);
            let each = |goals: &dyn Fn() -> Vec<Vector3<f64>>| timed(|| (0..n).for_each(|_| drop(goals())));
            let step = steps(simulation, n * u64::from(STEPS)) / STEPS;
            [each(&goals), each(&|| listed.goals(&positions)), step]
        };
        let Some(samples) = bench.measure(["naive goals", &name], Effort::Few, state, work) else { continue };
        let times: [f64; 3] = std::array::from_fn(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
        // The target is that of the reference; the lists are there to say what of it is the look-up.
        let cases = [("`supple::reference`", target), ("the same with its regions listed beforehand", None)];
        for (rival, (case, target)) in cases.into_iter().enumerate() {
            let beside =
                format!("goals alone: {:.0} ns, full step: {:.1} ns a vertex", times[rival], times[2]);
            bench.row(
                &format!("w = {half_width}, {case}"),
                (samples.ratio(rival, 2), "times"),
                target,
                beside,
            );
        }
    }
}

/// All that the naive sums need and that does not change.
struct Listed {
    regions: Vec<Vec<u32>>,
    /// m_i / n_i and 1 / n_i.
    weights: Vec<f64>,
    shares: Vec<f64>,
    rest: Vec<Vector3<f64>>,
}

impl Listed {
    fn new(lattice: &Lattice, half_width: usize) -> Self {
        let vertices = 0..lattice.len() as u32;
        let weights = reference::weights(lattice, half_width, Regions::Staircase);
        Self {
            regions: vertices
                .clone()
                .map(|vertex| reference::region(lattice, vertex, half_width, Regions::Staircase))
                .collect(),
            weights: vertices.map(|vertex| weights.of(vertex)).collect(),
            shares: weights.counts.iter().map(|&count| 1.0 / count as f64).collect(),
            rest: lattice.indices().iter().map(|index| Vector3::from(index.map(f64::from))).collect(),
        }
    }

    /// As [`reference::goals`], for cells of edge 1.
    fn goals(&self, positions: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut goals = vec![Vector3::zeros(); positions.len()];
        for region in &self.regions {
            let (mut mass, mut centre, mut at_rest) = (0.0, Vector3::zeros(), Vector3::zeros());
            for &i in region {
                let weight = self.weights[i as usize];
                mass += weight;
                centre += positions[i as usize] * weight;
                at_rest += self.rest[i as usize] * weight;
            }
            let (centre, at_rest): (Vector3<f64>, Vector3<f64>) = (centre / mass, at_rest / mass);
            let mut moments = Matrix3::zeros();
            for &i in region {
                let arm = (self.rest[i as usize] - at_rest) * self.weights[i as usize];
                moments += (positions[i as usize] - centre) * arm.transpose();
            }
            let rotation = reference::rotation(&moments);
            for &i in region {
                goals[i as usize] +=
                    (centre + rotation * (self.rest[i as usize] - at_rest)) * self.shares[i as usize];
            }
        }
        goals
    }
}
