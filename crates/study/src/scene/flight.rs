//! Free flight: the changes of momenta and energy, which should be none.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use supple::reference::{Mass, Momenta, Naive, Regions};
use supple::{Body, Simulation};

use super::motion::{is_moment, visits};
use super::physical::Physical;
use super::setting::Dynamics;
use crate::error::Halt;
use crate::observer::Meter;

/// How much a body is longer than at rest when it is let go.
const STRETCH: f64 = 1.1;
/// Moments at which the energy is measured.
const ENERGIES: u32 = 12;

/// The bodies of a scene in free flight, undamped, for as long as the scene: let go a tenth longer than at rest, with a
/// spin of one turn and a speed of one diagonal in that time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Free {
    /// Greatest change of the linear momentum, over the sum of mass times speed at the start.
    pub linear_momentum: f64,
    /// Greatest change of the angular momentum about the center of mass, over that at the start.
    pub angular_momentum: f64,
    /// Greatest energy over that at the start, less 1. `None` where measuring it takes too long.
    pub energy_gain: Option<f64>,
    /// 1 less the least energy over that at the start.
    pub energy_loss: Option<f64>,
    /// Time in seconds, kinetic and elastic energy.
    pub energy: Vec<[f64; 3]>,
}

/// Lets the bodies of a scene fly. `budget` limits the visits of the naive sums that the energy takes.
pub(super) fn fly(
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
        // Also at the start: what is measured is compared with it.
        let looked_at = frame == 0 || is_moment(frame, frames, ENERGIES);
        let mut left = u64::from(dynamics.substeps);
        if looked_at && measured {
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

/// Stretches a body along its longest axis, and sets it flying and spinning about an oblique axis.
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
type Moment = (Vec<Point3<f64>>, Vec<Vector3<f64>>);

/// Kinetic and elastic energy of all bodies at the positions before a step. The kinetic energy is that of the velocities
/// before and after it, multiplied: with it the sum is exactly kept by an oscillator under these steps.
fn energies(simulation: &Simulation, before: &[Moment], dt: f64) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (body, (positions, velocities)) in simulation.bodies().iter().zip(before) {
        let masses = body.masses();
        let products = velocities.iter().zip(body.velocities()).map(|(before, after)| before.dot(&after));
        sums[0] += masses.iter().zip(products).map(|(m, square)| m * square / 2.0).sum::<f64>();
        let naive = Naive::new(body.lattice(), body.half_width(), Regions::Staircase);
        let positions: Vec<_> = positions.iter().map(|x| x.coords).collect();
        let full_cell = body.material().density * body.lattice().cell_size().powi(3);
        let stiffness_rate_over_dt = body.material().alpha(dt) / (dt * dt);
        sums[1] +=
            full_cell * stiffness_rate_over_dt * naive.mismatch(&naive.motions(&positions), &positions);
    }
    sums
}
