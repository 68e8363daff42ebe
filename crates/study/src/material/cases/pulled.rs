//! Cases with bars that are pulled at their ends: Poisson's ratio and Young's modulus.
//!
//! The regions beside the surface are thinner and resist a change of volume less, so that Young's modulus is
//! 1 - 0.47 ν R/t of the one of the law (measured in the linear limit), with the radius R of the regions.

use supple::{ElasticLaw, Handle, HandleMotion, Key, Pin, Selection, TimeWindow};

use crate::material::bodies::{bar, bar_vertices, stepped};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};

/// Length of the bar.
const LENGTH: i32 = 5;

/// Share by which the bar is pulled.
const STRAIN: f64 = 0.02;

/// Steps per second.
const STEP_RATE: f64 = 240.0;

/// Time in seconds in which the bar comes to rest after a second of pulling.
const SECONDS: f64 = 6.0;

/// Returns the modulus of a bar with regions of this half-width and the greatest alpha.
fn modulus(cells: i32, half_width: usize, poisson_ratio: f64) -> f64 {
    let density = supple::Material::default().density;
    let law = ElasticLaw { density, cell_size: 1.0 / f64::from(cells), dt: 1.0 / STEP_RATE, poisson_ratio };
    law.modulus(half_width, law.greatest_alpha())
}

/// Pulls a bar by its ends, and measures by how much its middle fifth becomes narrower and with which force.
fn pulled(cells: i32, half_width: usize, poisson_ratio: f64) -> Outcome {
    let length = f64::from(LENGTH);
    let end = |z: f64, side: f64| Selection::Plane { point: [0.0, 0.0, z], normal: [0.0, 0.0, side] };
    let modulus = modulus(cells, half_width, poisson_ratio);
    let key = |time: f64, z: f64| Key { time, translate: [0.0, 0.0, z], rotate: [0.0; 3] };
    let keys = vec![key(0.0, 0.0), key(1.0, STRAIN * length)];
    let window = TimeWindow::default();
    let body = bar(cells, LENGTH)?
        .youngs_modulus(modulus)
        .poisson_ratio(poisson_ratio)
        .damping_ratio(1.0)
        .pin(Pin { selection: end(1e-6, -1.0), window })
        .handle(Handle { selection: end(length - 1e-6, 1.0), motion: HandleMotion::from(keys), window });
    let mut simulation = stepped(body.build()?, [0.0; 3], 1.0 / STEP_RATE).build()?;
    simulation.steps((SECONDS * STEP_RATE) as u64);
    let body = simulation.body(0);
    let vertices: Vec<_> = body.lattice().indices().iter().copied().zip(body.positions()).collect();
    // The mean coordinate of the vertices of the middle fifth that have an index along an axis.
    let (low, high) = (2 * cells, 3 * cells);
    let mean = |axis: usize, at: i32| {
        let is_middle = |index: &[i32; 3]| (low..=high).contains(&index[2]) && index[axis] == at;
        let values: Vec<f64> =
            vertices.iter().filter(|(index, _)| is_middle(index)).map(|(_, x)| x[axis]).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let along = mean(2, high) - mean(2, low) - 1.0;
    let across = (0..2).map(|axis| mean(axis, cells) - mean(axis, 0) - 1.0).sum::<f64>() / 2.0;
    let force = body.hold_force(0)?.unwrap_or_default().force.z.abs();
    Ok(vec![Measured::by_law(-across / along, poisson_ratio), Measured::by_law(force / along, modulus)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let case = |(cells, half_width, ratio): (i32, usize, f64)| {
        let radius = ((half_width * (half_width + 1)) as f64).sqrt() / f64::from(cells);
        let name = format!("{} vertices, R = {radius:.2} t, ratio {ratio}", bar_vertices(cells, LENGTH));
        let poisson =
            Quantity::new("Poisson's ratio", Target::within(1.0 - 0.02 / ratio, 1.0 + 0.02 / ratio));
        let mut young = Quantity::new("Young's modulus", Target::within(0.97, 1.03));
        let expected = 1.0 - 0.47 * ratio * radius;
        if expected < 0.97 {
            young =
                young.misses(format!("regions at the surface are thinner: they give about {expected:.2}"));
        }
        Case::new(name, [poisson, young], move || pulled(cells, half_width, ratio))
            .of_vertices(bar_vertices(cells, LENGTH))
    };
    let sizes = [(6, 1), (6, 2), (10, 1), (10, 2)];
    sizes.into_iter().flat_map(|(t, w)| [0.3, 0.45].map(|ratio| (t, w, ratio))).map(case).collect()
}
