//! A simulation that is watched: the figures of a case are taken here.

use nalgebra::{Point3, Vector3};
use supple::{Body, Simulation, Stiffness};

use crate::energy::Energy;
use crate::rigid::{RigidMotion, distance, mean};
use crate::{Figures, Measure};

/// Lattice vertices up to which the energy is summed region by region.
const SUMMED: usize = 600;

/// A simulation and the figures of its bodies.
pub(crate) struct Trial {
    pub(crate) simulation: Simulation,
    pub(crate) figures: Figures,
    starts: Vec<Start>,
    /// Whether nothing acts from outside, so that momenta and energy are the bodies' own.
    free: bool,
}

/// How a body began.
struct Start {
    rest: Vec<Vector3<f64>>,
    masses: Vec<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    /// Largest sums of magnitudes so far: of linear and of angular momentum.
    magnitudes: [f64; 2],
    shape: f64,
    energy: Option<(Energy, f64)>,
}

/// Positions and velocities of a body in cells and steps.
struct Now {
    x: Vec<Vector3<f64>>,
    v: Vec<Vector3<f64>>,
}

impl Now {
    fn of(body: &Body, dt: f64) -> Self {
        let cell = body.lattice().cell_size();
        let x = body.positions().iter().map(|p| p.coords / cell).collect();
        let v = body.velocities().iter().map(|v| v * (dt / cell)).collect();
        Self { x, v }
    }

    /// Linear and angular momentum, and the sums of their magnitudes.
    fn momenta(&self, masses: &[f64]) -> ([Vector3<f64>; 2], [f64; 2]) {
        let (centre, drift) = (mean(masses, &self.x), mean(masses, &self.v));
        let (mut momenta, mut magnitudes) = ([Vector3::zeros(); 2], [0.0; 2]);
        for ((x, v), m) in self.x.iter().zip(&self.v).zip(masses) {
            let (arm, beside) = (x - centre, v - drift);
            momenta[0] += v * *m;
            momenta[1] += arm.cross(&beside) * *m;
            magnitudes[0] += v.norm() * m;
            magnitudes[1] += arm.norm() * beside.norm() * m;
        }
        (momenta, magnitudes)
    }
}

impl Trial {
    /// Of bodies on which nothing acts.
    pub(crate) fn free(simulation: Simulation) -> Self {
        Self::new(simulation, true)
    }

    /// Of bodies that are held, or that touch something.
    pub(crate) fn bound(simulation: Simulation) -> Self {
        Self::new(simulation, false)
    }

    fn new(simulation: Simulation, free: bool) -> Self {
        let dt = simulation.dt();
        let starts = simulation.bodies().iter().map(|body| {
            let now = Now::of(body, dt);
            let cells = body.lattice().occupied_cells();
            let masses: Vec<f64> = cells.iter().map(|&cells| f64::from(cells) / 8.0).collect();
            let rest: Vec<Vector3<f64>> =
                body.lattice().indices().iter().map(|index| Vector3::from(index.map(f64::from))).collect();
            let ([linear, angular], magnitudes) = now.momenta(&masses);
            let shape = RigidMotion::fit(&masses, &rest, &now.x).distance(&rest, &now.x);
            let energy = (free && rest.len() <= SUMMED).then(|| {
                let energy = Energy::new(body.lattice(), body.half_width(), alpha(body));
                let start = energy.of(&now.x, &now.v);
                (energy, start)
            });
            Start { rest, masses, linear, angular, magnitudes, shape, energy }
        });
        let starts = starts.collect();
        let mut trial = Self { simulation, figures: Figures::default(), starts, free };
        trial.look();
        trial
    }

    /// Makes `steps` steps, and looks after each `every`.
    pub(crate) fn run(&mut self, steps: u64, every: u64) {
        for _ in 0..steps / every {
            self.simulation.steps(every);
            self.look();
        }
    }

    /// How deep the surfaces lie by `depth`, in scene units.
    pub(crate) fn depth(&mut self, depth: impl Fn(&Point3<f64>) -> f64) {
        for body in self.simulation.bodies() {
            let deepest = body.positions().iter().map(&depth).fold(0.0, largest);
            self.figures.raise(Measure::Depth, deepest / body.lattice().cell_size());
        }
    }

    /// How far the vertices are from where they are expected, in cells of edge 1.
    pub(crate) fn place(&mut self, expected: &[Point3<f64>], now: &[Point3<f64>]) {
        let [expected, now] = [expected, now].map(|points| points.iter().map(|p| p.coords).collect::<Vec<_>>());
        self.figures.raise(Measure::Place, distance(&expected, &now));
    }

    /// What was measured, with what is to be said at the end.
    pub(crate) fn finish(mut self) -> Figures {
        self.figures.steps = self.simulation.step_count();
        let unsettled: usize = self.simulation.bodies().iter().map(Body::unsettled_rotations).sum();
        self.figures.set(Measure::Unsettled, unsettled as f64);
        self.figures
    }

    /// The distance of a body from its rest shape, up to a rigid motion, in cells.
    pub(crate) fn shape(&self, body: usize) -> f64 {
        let Start { rest, masses, .. } = &self.starts[body];
        let now = Now::of(self.simulation.body(body), self.simulation.dt());
        RigidMotion::fit(masses, rest, &now.x).distance(rest, &now.x)
    }

    fn look(&mut self) {
        let (dt, steps) = (self.simulation.dt(), self.simulation.step_count());
        let [mut final_speed, mut shape, mut shape_left, mut volume] = [0.0_f64; 4];
        let mut energies = [0.0; 2];
        for (body, start) in self.simulation.bodies().iter().zip(&mut self.starts) {
            let now = Now::of(body, dt);
            self.figures.add(Measure::NotNumbers, not_numbers(body, &now) as f64);
            let report = body.volume_report();
            self.figures.add(Measure::Capped, f64::from(u8::from(report.capped)));
            volume = largest(volume, report.residual.abs());
            final_speed = now.v.iter().map(|v| v.norm()).fold(final_speed, largest);
            let error = RigidMotion::fit(&start.masses, &start.rest, &now.x).distance(&start.rest, &now.x);
            shape = largest(shape, error);
            shape_left = largest(shape_left, error / start.shape);
            if self.free {
                let ([linear, angular], magnitudes) = now.momenta(&start.masses);
                let missed = [linear - start.linear, angular - start.angular];
                for (k, measure) in [Measure::Linear, Measure::Angular].into_iter().enumerate() {
                    start.magnitudes[k] = start.magnitudes[k].max(magnitudes[k]);
                    let share = if missed[k].norm() == 0.0 { 0.0 } else { missed[k].norm() / start.magnitudes[k] };
                    self.figures.raise(measure, share);
                }
            }
            if let Some((energy, first)) = &start.energy {
                energies[0] += first;
                energies[1] += energy.of(&now.x, &now.v);
            }
        }
        self.figures.raise(Measure::LargestSpeed, final_speed);
        self.figures.set(Measure::FinalSpeed, final_speed);
        self.figures.set(Measure::Volume, volume);
        self.figures.set(Measure::Shape, shape);
        if shape_left.is_finite() {
            self.figures.set(Measure::ShapeLeft, shape_left);
            if shape_left <= 0.1 && self.figures.get(Measure::StepsToTenth).is_none() {
                self.figures.set(Measure::StepsToTenth, steps as f64);
            }
        }
        if self.starts.iter().all(|start| start.energy.is_some()) {
            self.figures.energy.push((steps, energies[1]));
            if energies[0] > 0.0 {
                self.figures.raise(Measure::EnergyGain, energies[1] / energies[0] - 1.0);
                self.figures.set(Measure::EnergyLeft, energies[1] / energies[0]);
            }
        }
    }
}

/// The larger one; what is not a number is larger than any.
fn largest(a: f64, b: f64) -> f64 {
    if b <= a { a } else { b }
}

/// Numbers of a body and of what is shown of it that are NaN or infinite.
fn not_numbers(body: &Body, now: &Now) -> usize {
    let vectors = now.x.iter().chain(&now.v).flatten().copied();
    let rotations = body.rotations();
    let shown = body.corrected_positions();
    let report = body.volume_report();
    let volumes = [report.rest, report.before, report.after, report.lambda, report.residual];
    vectors
        .chain(rotations.iter().flatten().copied())
        .chain(shown.iter().flat_map(|p| p.coords.iter().copied().collect::<Vec<_>>()))
        .chain(volumes)
        .filter(|x| !x.is_finite())
        .count()
}

/// alpha of a body: the cases give it per step.
fn alpha(body: &Body) -> f64 {
    match body.material().stiffness {
        Stiffness::PerStep(alpha) => alpha,
        Stiffness::Frequency(_) => f64::NAN,
    }
}
