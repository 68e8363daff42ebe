//! Free flight: the changes of momenta and energy, which should be zero.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use supple::reference::{Mass, Momenta, Naive, Regions};
use supple::{Body, Simulation};

use super::motion::{is_sampled, visits};
use super::physical::Physical;
use super::setting::Dynamics;
use crate::error::Halt;
use crate::observer::Meter;

/// Initial length of a body relative to its rest length.
const STRETCH: f64 = 1.1;
/// Number of frames at which the energy is measured, besides frame 0.
const ENERGY_SAMPLES: u32 = 12;

/// Conservation errors of the bodies of a scene in undamped free flight over the duration of the scene. The
/// bodies start stretched by a tenth, with a spin of one turn and a speed of one diagonal per duration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Free {
    /// Maximum change of the linear momentum, relative to the initial sum of mass times speed.
    pub linear_momentum: f64,
    /// Maximum change of the angular momentum about the center of mass, relative to its initial value.
    pub angular_momentum: f64,
    /// Maximum energy relative to the initial energy, minus 1. `None` if the measurement takes too long.
    pub energy_gain: Option<f64>,
    /// 1 minus the minimum energy relative to the initial energy.
    pub energy_loss: Option<f64>,
    /// Samples of time in seconds, kinetic energy and elastic energy.
    pub energy: Vec<[f64; 3]>,
}

/// Simulates the free flight of the bodies of a scene. The energy is measured if one evaluation of the naive
/// sums takes at most `budget` visits.
pub(super) fn advance_origin(
    physical: &Physical,
    dynamics: Dynamics,
    budget: f64,
    meter: &mut Meter<'_>,
) -> Result<Free, Halt> {
    let prepared = physical.prepare_free(dynamics)?;
    let measured = visits(&prepared.simulation) <= budget;
    let mut simulation = prepared.simulation;
    let frames = physical.scene().simulation.frames;
    let time = f64::from(frames) / physical.scene().simulation.fps;
    for body in simulation.bodies_mut() {
        launch(body, time)?;
    }
    let start: Vec<Momenta> = simulation.bodies().iter().map(momenta).collect();
    let quantity = |body: &Body| -> f64 {
        body.masses().iter().zip(body.velocities()).map(|(mass, v)| mass * v.norm()).sum()
    };
    let quantities: Vec<f64> = simulation.bodies().iter().map(quantity).collect();
    let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
    let mut energy = Vec::new();
    for frame in 0..=frames {
        for ((body, start), quantity) in simulation.bodies().iter().zip(&start).zip(&quantities) {
            let now = momenta(body);
            linear = linear.max((now.linear - start.linear).norm() / quantity);
            angular = angular.max((now.angular - start.angular).norm() / start.angular.norm());
        }
        // The initial energy is the reference.
        let sampled = frame == 0 || is_sampled(frame, frames, ENERGY_SAMPLES);
        let mut left = u64::from(dynamics.substeps);
        if sampled && measured {
            let before: Vec<_> =
                simulation.bodies().iter().map(|body| (body.positions(), body.velocities())).collect();
            let (time, dt) = (simulation.time(), simulation.dt());
            simulation.step();
            left -= 1;
            let [kinetic, elastic] = energies(&simulation, &before, dt);
            energy.push([time, kinetic, elastic]);
        }
        simulation.steps(left);
        meter.tick()?;
    }
    let shares = energy.first().map(|first| {
        let total = |[_, kinetic, elastic]: [f64; 3]| kinetic + elastic;
        let least = energy.iter().map(|&e| total(e)).fold(f64::INFINITY, f64::min);
        let greatest = energy.iter().map(|&e| total(e)).fold(f64::NEG_INFINITY, f64::max);
        (greatest / total(*first) - 1.0, 1.0 - least / total(*first))
    });
    Ok(Free {
        linear_momentum: linear,
        angular_momentum: angular,
        energy_gain: shares.map(|(gain, _)| gain),
        energy_loss: shares.map(|(_, loss)| loss),
        energy,
    })
}

/// Stretches a body along its longest axis and sets the velocities of a translation and a spin about an
/// oblique axis.
fn launch(body: &mut Body, time: f64) -> Result<(), supple::Error> {
    let positions = body.positions();
    let center = momenta(body).center;
    let extent = |axis: usize| {
        let along = positions.iter().map(|x| x[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
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
    let spin = Vector3::new(1.0, 1.0, 1.0).normalize() * (std::f64::consts::TAU / time);
    let speed = Vector3::x() * (extents.norm() / time);
    let velocities: Vec<_> = stretched.iter().map(|x| speed + spin.cross(&(x.coords - center))).collect();
    body.set_positions(&stretched)?;
    body.set_velocities(&velocities)?;
    Ok(())
}

/// Returns the momenta of a body.
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

/// Returns the kinetic and elastic energy of all bodies at the positions before a step. The kinetic energy is
/// the product of the velocities before and after the step times m/2: with it, these steps conserve the
/// energy of a harmonic oscillator exactly.
fn energies(simulation: &Simulation, before: &[State], dt: f64) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (body, (positions, velocities)) in simulation.bodies().iter().zip(before) {
        let masses = body.masses();
        let products = velocities.iter().zip(body.velocities()).map(|(before, after)| before.dot(&after));
        sums[0] += masses.iter().zip(products).map(|(m, square)| m * square / 2.0).sum::<f64>();
        let naive = Naive::new(body.lattice(), body.half_width(), Regions::Staircase);
        let positions: Vec<_> = positions.iter().map(|x| x.coords).collect();
        let full_cell = body.material().density * body.lattice().cell_size().powi(3);
        let stiffness_rate_over_dt = body.material().alpha(dt) / (dt * dt);
        sums[1] += full_cell
            * stiffness_rate_over_dt
            * naive.matching_energy(&naive.motions(&positions), &positions);
    }
    sums
}
