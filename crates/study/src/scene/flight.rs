//! Measures the changes of momenta and energy in free flight. They should be zero.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use supple::reference::{Mass, Momenta, Naive, Regions};
use supple::{Body, Simulation};

use super::motion::{is_sampled, visits};
use super::physical::Physical;
use super::setting::Dynamics;
use crate::elasticity::alpha;
use crate::error::Halt;
use crate::observer::Meter;

/// Initial length of a body along its longest axis, relative to its rest length.
const STRETCH: f64 = 1.1;
/// Number of frames at which the energy is measured, besides frame 0.
const ENERGY_SAMPLES: u32 = 12;

/// Conservation errors of the bodies of a scene in undamped free flight for the duration of the scene. At the
/// start the bodies are stretched by a tenth, spin by one turn per duration, and move by one diagonal of
/// their bounding box per duration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Free {
    /// Maximum change of the linear momentum, relative to the initial sum of mass times speed.
    pub linear_momentum: f64,
    /// Maximum change of the angular momentum about the center of mass, relative to its initial value.
    pub angular_momentum: f64,
    /// Maximum energy divided by the initial energy, minus 1. `None` if the measurement would take too long.
    pub energy_gain: Option<f64>,
    /// 1 minus the minimum energy divided by the initial energy. `None` if the measurement would take too
    /// long.
    pub energy_loss: Option<f64>,
    /// Samples, each of the time in seconds, the kinetic energy and the elastic energy.
    pub energy: Vec<[f64; 3]>,
}

/// Simulates the free flight of the bodies of a scene. The energy is measured if one evaluation of the naive
/// sums takes at most `budget` visits (see [`visits`]).
pub(super) fn measure(
    physical: &Physical,
    dynamics: Dynamics,
    budget: f64,
    meter: &mut Meter<'_>,
) -> Result<Free, Halt> {
    let prepared = physical.prepare_free(dynamics)?;
    let measures_energy = visits(&prepared.simulation) <= budget;
    let mut simulation = prepared.simulation;
    let frames = physical.scene().simulation.frames;
    let duration = f64::from(frames) / physical.scene().simulation.fps;
    for body in simulation.bodies_mut() {
        launch(body, duration)?;
    }
    let start: Vec<Momenta> = simulation.bodies().iter().map(momenta).collect();
    let sum_of_magnitudes = |body: &Body| -> f64 {
        body.masses().iter().zip(body.velocities()).map(|(mass, v)| mass * v.norm()).sum()
    };
    let magnitudes: Vec<f64> = simulation.bodies().iter().map(sum_of_magnitudes).collect();
    let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
    let mut energy = Vec::new();
    for frame in 0..=frames {
        for ((body, start), magnitude) in simulation.bodies().iter().zip(&start).zip(&magnitudes) {
            let now = momenta(body);
            linear = linear.max((now.linear - start.linear).norm() / magnitude);
            angular = angular.max((now.angular - start.angular).norm() / start.angular.norm());
        }
        // The initial energy is the reference.
        let sampled = frame == 0 || is_sampled(frame, frames, ENERGY_SAMPLES);
        let mut remaining_steps = u64::from(dynamics.substeps);
        if sampled && measures_energy {
            let before: Vec<_> =
                simulation.bodies().iter().map(|body| (body.positions(), body.velocities())).collect();
            let (time, dt) = (simulation.time(), simulation.dt());
            simulation.step();
            remaining_steps -= 1;
            let [kinetic, elastic] = energies(&simulation, &before, dt);
            energy.push([time, kinetic, elastic]);
        }
        simulation.steps(remaining_steps);
        meter.tick()?;
    }
    let gain_and_loss = energy.first().map(|first| {
        let total = |[_, kinetic, elastic]: [f64; 3]| kinetic + elastic;
        let minimum = energy.iter().map(|&e| total(e)).fold(f64::INFINITY, f64::min);
        let maximum = energy.iter().map(|&e| total(e)).fold(f64::NEG_INFINITY, f64::max);
        (maximum / total(*first) - 1.0, 1.0 - minimum / total(*first))
    });
    Ok(Free {
        linear_momentum: linear,
        angular_momentum: angular,
        energy_gain: gain_and_loss.map(|(gain, _)| gain),
        energy_loss: gain_and_loss.map(|(_, loss)| loss),
        energy,
    })
}

/// Stretches a body along its longest axis, and sets the velocities to a translation plus a spin around an
/// oblique axis. `duration` is the duration of the scene in seconds.
fn launch(body: &mut Body, duration: f64) -> Result<(), supple::Error> {
    let positions = body.positions();
    let center = momenta(body).center;
    let extent = |axis: usize| {
        let coordinates = positions.iter().map(|x| x[axis]);
        coordinates.clone().fold(f64::NEG_INFINITY, f64::max) - coordinates.fold(f64::INFINITY, f64::min)
    };
    let extents = Vector3::from_fn(|axis, _| extent(axis));
    let longest = extents.imax();
    let stretched: Vec<Point3<f64>> = positions
        .iter()
        .map(|x| {
            let mut x = *x;
            x[longest] = center[longest] + STRETCH * (x[longest] - center[longest]);
            x
        })
        .collect();
    let spin = Vector3::new(1.0, 1.0, 1.0).normalize() * (std::f64::consts::TAU / duration);
    let translation = Vector3::x() * (extents.norm() / duration);
    let velocities: Vec<_> =
        stretched.iter().map(|x| translation + spin.cross(&(x.coords - center))).collect();
    body.set_positions(&stretched)?;
    body.set_velocities(&velocities)?;
    Ok(())
}

/// Returns the linear and the angular momentum of a body.
fn momenta(body: &Body) -> Momenta {
    let (masses, positions, velocities) = (body.masses(), body.positions(), body.velocities());
    let points = masses.iter().zip(&positions).zip(&velocities);
    Momenta::of(points.map(|((&mass, position), &velocity)| Mass {
        mass,
        position: position.coords,
        velocity,
    }))
}

/// Positions and velocities of a body.
type State = (Vec<Point3<f64>>, Vec<Vector3<f64>>);

/// Returns the kinetic and the elastic energy of all bodies at the positions before a step. The kinetic
/// energy of a vertex is m/2 times the dot product of its velocities before and after the step, because the
/// steps conserve this energy of a harmonic oscillator exactly.
fn energies(simulation: &Simulation, before: &[State], dt: f64) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (body, (positions, velocities)) in simulation.bodies().iter().zip(before) {
        let masses = body.masses();
        let products = velocities.iter().zip(body.velocities()).map(|(before, after)| before.dot(&after));
        sums[0] += masses.iter().zip(products).map(|(m, product)| m * product / 2.0).sum::<f64>();
        let naive = Naive::new(body.lattice(), body.half_width(), Regions::Staircase).with_material_of(body);
        let positions: Vec<_> = positions.iter().map(|x| x.coords).collect();
        let full_cell = body.material().density * body.lattice().cell_size().powi(3);
        let alpha_over_dt_squared = alpha(body, dt) / (dt * dt);
        sums[1] +=
            full_cell * alpha_over_dt_squared * naive.matching_energy(&naive.motions(&positions), &positions);
    }
    sums
}
