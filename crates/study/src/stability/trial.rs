//! Runs a simulation and measures the figures of a case.

use nalgebra::{Point3, Vector3};
use supple::reference::{Naive, Regions};
use supple::{Body, BodyRef, Lattice, Simulation};

use super::case::{Figures, Measure, largest};
use crate::elasticity::{alpha, relative_masses};
use crate::shape::{distance, mean, shape_distance};

/// Maximum number of entries in the region lists of a body. For bodies with more entries, the energy is not
/// measured, because run time and memory would be too large.
const MAX_LIST_ENTRIES: usize = 30_000_000;

/// Speed that counts as rest when energies are compared, in cells per step.
const REST_SPEED: f64 = 1e-3;

/// Distance from the rest shape that counts as zero, in cells.
const REST_DISTANCE: f64 = 1e-3;

/// Whether external forces can change momenta and energy.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum System {
    /// Nothing acts on the bodies: momenta and energy are measured.
    Isolated,
    /// Gravity, constraints or contacts act on the bodies: momenta and energy are not measured.
    Driven,
}

/// Runs the steps that `script` makes, and returns the figures.
pub(super) fn measure(simulation: Simulation, system: System, script: impl FnOnce(&mut Trial)) -> Figures {
    let lattices: Vec<Lattice> = simulation.bodies().iter().map(|body| body.lattice().clone()).collect();
    let mut trial = Trial::new(simulation, &lattices, system);
    script(&mut trial);
    trial.finish()
}

/// A simulation and the figures that are measured while it runs.
pub(super) struct Trial<'a> {
    pub(super) simulation: Simulation,
    figures: Figures,
    /// Initial state of each body.
    initials: Vec<Initial<'a>>,
    system: System,
}

/// Rest shape and initial state of a body.
struct Initial<'a> {
    rest: Vec<Vector3<f64>>,
    masses: Vec<f64>,
    /// Initial linear and angular momentum.
    momenta: [Vector3<f64>; 2],
    /// Maximum so far of the sum of the magnitudes of the vertices' momenta, linear and angular.
    magnitudes: [f64; 2],
    /// Initial distance from the rest shape, in cells.
    shape: f64,
    /// `None` if the energy is not measured.
    energy: Option<Energy<'a>>,
}

/// Computes the energy of an isolated body by the naive method in f64.
struct Energy<'a> {
    naive: Naive<'a>,
    cell_size: f64,
    /// Stiffness per step.
    alpha: f64,
    /// Initial energy.
    start: f64,
}

/// Positions of the vertices of a body in cells, and velocities in cells per step.
struct Snapshot {
    x: Vec<Vector3<f64>>,
    v: Vec<Vector3<f64>>,
}

impl Snapshot {
    fn new(body: &Body, dt: f64) -> Self {
        let cell = body.lattice().cell_size();
        let x = body.positions().iter().map(|p| p.coords / cell).collect();
        let v = body.velocities().iter().map(|v| v * (dt / cell)).collect();
        Self { x, v }
    }

    /// Returns linear and angular momentum, and the sums of the magnitudes of the vertices' contributions.
    fn momenta(&self, masses: &[f64]) -> ([Vector3<f64>; 2], [f64; 2]) {
        let (center, drift) = (mean(masses, &self.x), mean(masses, &self.v));
        let (mut momenta, mut magnitudes) = ([Vector3::zeros(); 2], [0.0; 2]);
        for ((x, v), m) in self.x.iter().zip(&self.v).zip(masses) {
            let (arm, relative) = (x - center, v - drift);
            momenta[0] += v * *m;
            momenta[1] += arm.cross(&relative) * *m;
            magnitudes[0] += v.norm() * m;
            magnitudes[1] += arm.norm() * relative.norm() * m;
        }
        (momenta, magnitudes)
    }

    /// Returns the maximum speed of a vertex.
    fn speed(&self) -> f64 {
        self.v.iter().map(Vector3::norm).fold(0.0, largest)
    }
}

impl<'a> Energy<'a> {
    fn new(body: &Body, lattice: &'a Lattice, dt: f64, now: &Snapshot) -> Self {
        // Before the first step the body has its ratios of rest volumes still to come.
        let ratios = vec![body.inflate().constant().unwrap_or(1.0); lattice.len()];
        let naive = Naive::new(lattice, body.half_width(), Regions::Staircase).with_material_of(body);
        let naive = naive.with_rest_volumes(ratios).listed();
        let alpha = alpha(body, dt);
        let mut energy = Self { naive, cell_size: lattice.cell_size(), alpha, start: 0.0 };
        energy.set_shapes(body);
        energy.start = energy.at(now);
        energy
    }

    /// Sets the plastic shapes of the body.
    fn set_shapes(&mut self, body: &Body) {
        if body.material().plastic.is_some() {
            self.naive.set_shapes(body.plastic_shapes());
        }
    }

    /// Returns the energy in units of the mass of a full cell times (cells per step)².
    fn at(&self, now: &Snapshot) -> f64 {
        let scaled =
            |cells: &[Vector3<f64>]| -> Vec<_> { cells.iter().map(|x| x * self.cell_size).collect() };
        self.naive.energy(&scaled(&now.x), &scaled(&now.v), self.alpha) / self.cell_size.powi(2)
    }
}

impl<'a> Initial<'a> {
    /// Adapts the state to the pieces of a body that broke: it has more vertices. Its energy is not measured any more,
    /// because the naive method does not break.
    fn follow(&mut self, body: &Body) {
        if body.lattice().len() != self.rest.len() {
            self.rest = rest_shape(body);
            self.masses = relative_masses(body);
            self.energy = None;
        }
    }

    fn new(body: &Body, lattice: &'a Lattice, dt: f64, system: System) -> Self {
        let now = Snapshot::new(body, dt);
        let masses = relative_masses(body);
        let rest = rest_shape(body);
        let (momenta, magnitudes) = now.momenta(&masses);
        let shape = shape_distance(&masses, &rest, &now.x);
        let list_entries =
            lattice.len() * lattice.len().min((2 * body.half_width().cells().ceil() as usize + 1).pow(3));
        let energy = (system == System::Isolated && list_entries <= MAX_LIST_ENTRIES)
            .then(|| Energy::new(body, lattice, dt, &now));
        Self { rest, masses, momenta, magnitudes, shape, energy }
    }

    /// Returns the errors of linear and angular momentum, relative to the maximum magnitudes.
    fn momentum_errors(&mut self, now: &Snapshot) -> [f64; 2] {
        let (momenta, magnitudes) = now.momenta(&self.masses);
        std::array::from_fn(|k| {
            self.magnitudes[k] = largest(self.magnitudes[k], magnitudes[k]);
            let error = (momenta[k] - self.momenta[k]).norm();
            if error == 0.0 { 0.0 } else { error / self.magnitudes[k] }
        })
    }
}

impl<'a> Trial<'a> {
    fn new(simulation: Simulation, lattices: &'a [Lattice], system: System) -> Self {
        let bodies = simulation.bodies().iter().zip(lattices);
        let initials =
            bodies.map(|(body, lattice)| Initial::new(body, lattice, simulation.dt(), system)).collect();
        let mut trial = Self { simulation, figures: Figures::default(), initials, system };
        trial.evaluate();
        trial
    }

    /// Makes `steps` steps and updates the figures after each `interval` steps. `interval` must divide
    /// `steps`.
    pub(super) fn run(&mut self, steps: u64, interval: u64) {
        for _ in 0..steps / interval {
            self.simulation.steps(interval);
            self.evaluate();
        }
    }

    /// Makes the steps of `frames` frames and measures until when a body was awake. Updates the other figures after
    /// each `interval` frames, which must divide `frames`.
    pub(super) fn run_to_sleep(&mut self, frames: u64, interval: u64) {
        for frame in 1..=frames {
            self.simulation.advance(1);
            if self.simulation.bodies().iter().any(|body| !body.is_asleep()) {
                self.figures.raise(Measure::Awake, self.simulation.time());
            }
            if frame % interval == 0 {
                self.evaluate();
            }
        }
    }

    /// Sets a figure that a case measures itself to the larger of its value and `value`.
    pub(super) fn raise(&mut self, measure: Measure, value: f64) {
        self.figures.raise(measure, value);
    }

    /// Measures the penetration depth of the boundary vertices of the lattices. `depth` returns the depth of
    /// a position in scene units.
    pub(super) fn depth(&mut self, depth: impl Fn(&Point3<f64>) -> f64) {
        for body in self.simulation.bodies() {
            let positions = body.positions();
            let vertices = positions.iter().zip(body.lattice().occupied_cells());
            let boundary = vertices.filter(|(_, cells)| **cells < 8).map(|(position, _)| position);
            let deepest = boundary.map(&depth).fold(0.0, largest);
            self.figures.raise(Measure::Depth, deepest / body.lattice().cell_size());
        }
    }

    /// Measures the distance of the points `now` from the points `expected`, both in cells.
    pub(super) fn place(&mut self, expected: &[Point3<f64>], now: &[Point3<f64>]) {
        let [expected, now] =
            [expected, now].map(|points| points.iter().map(|p| p.coords).collect::<Vec<_>>());
        self.figures.raise(Measure::Place, distance(&expected, &now));
    }

    /// Adds the counts of the whole simulation and returns the figures.
    fn finish(mut self) -> Figures {
        self.figures.steps = self.simulation.step_count();
        let unconverged: usize = self.simulation.bodies().iter().map(Body::unconverged_rotations).sum();
        self.figures.set(Measure::Unsettled, unconverged as f64);
        self.figures
    }

    /// Evaluates the bodies for display and updates the figures.
    fn evaluate(&mut self) {
        let Self { simulation, figures, initials, system } = self;
        let [mut speed, mut shape, mut shape_at_start, mut volume] = [0.0_f64; 4];
        let (mut energy, mut energy_at_start, mut rest_energy) = (Some(0.0), 0.0, 0.0);
        for (index, start) in initials.iter_mut().enumerate() {
            let body = simulation.body(index);
            let now = Snapshot::new(&body, simulation.dt());
            start.follow(&body);
            let report = body.volume_report();
            let volumes = [report.rest, report.before, report.after, report.lambda, report.residual];
            figures.add(Measure::NotNumbers, count_non_finite(body, &now, &volumes) as f64);
            figures.add(Measure::Capped, f64::from(u8::from(report.capped)));
            volume = largest(volume, report.residual.abs());
            speed = largest(speed, now.speed());
            shape = largest(shape, shape_distance(&start.masses, &start.rest, &now.x));
            shape_at_start = largest(shape_at_start, start.shape);
            if *system == System::Isolated {
                let [linear, angular] = start.momentum_errors(&now);
                figures.raise(Measure::Linear, linear);
                figures.raise(Measure::Angular, angular);
            }
            energy = energy.zip(start.energy.as_mut()).map(|(sum, energy)| {
                energy.set_shapes(body.get());
                energy_at_start += energy.start;
                rest_energy += REST_SPEED * REST_SPEED * start.masses.iter().sum::<f64>();
                sum + energy.at(&now)
            });
        }
        let steps = simulation.step_count();
        figures.raise(Measure::LargestSpeed, speed);
        figures.set(Measure::FinalSpeed, speed);
        figures.set(Measure::Volume, volume);
        figures.set(Measure::Shape, shape);
        let is_below_tenth = shape <= (0.1 * shape_at_start).max(REST_DISTANCE);
        if is_below_tenth && steps > 0 && figures.get(Measure::StepsToTenth).is_none() {
            figures.set(Measure::StepsToTenth, steps as f64);
        }
        if let Some(energy) = energy {
            figures.energy.push((steps, energy));
            figures.raise(Measure::EnergyGain, (energy - energy_at_start) / (energy_at_start + rest_energy));
            figures.set(Measure::EnergyLeft, energy / (energy_at_start + rest_energy));
        }
    }
}

/// Returns the rest positions of the vertices of a body in cells: those of a body that is evenly inflated.
fn rest_shape(body: &Body) -> Vec<Vector3<f64>> {
    let stretch = body.inflate().constant().map_or(1.0, f64::cbrt);
    body.lattice().indices().iter().map(|index| Vector3::from(index.map(f64::from)) * stretch).collect()
}

/// Counts the NaN and infinite numbers in the state of a body, its corrected lattice, its evaluated surface
/// and `volumes`.
fn count_non_finite(body: BodyRef<'_>, now: &Snapshot, volumes: &[f64]) -> usize {
    let corrected: Vec<_> = body.corrected_positions().iter().map(|p| p.coords).collect();
    let vectors = now.x.iter().chain(&now.v).chain(&corrected).flatten();
    let rotations = body.rotations();
    let surface: Vec<_> = body.surface().positions.iter().map(|p| p.coords).collect();
    let numbers = vectors.chain(surface.iter().flatten()).chain(rotations.iter().flatten()).chain(volumes);
    numbers.filter(|x| !x.is_finite()).count()
}
