//! A body with a surface, whose volume is kept exactly: what is shown stays a number.

use nalgebra::Vector3;
use supple::{Body, Collider, Error, Key, Mesh, Simulation};

use super::super::bodies::{block, deform};
use super::super::trial::{Surroundings, watch};
use super::super::{Case, Figures, Measure};

const FAMILY: &str = "surfaces";

/// A ball of radius 1 about the origin: a cube of n x n x n quads a face, blown up.
fn ball(n: i32) -> Result<Mesh, Error> {
    let mut vertices = Vec::new();
    let mut quads = Vec::new();
    for cell in block([n, n, 1]) {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let first = vertices.len() as u32;
            for [u, v] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                let along = |i: i32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
                let mut p = Vector3::zeros();
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                    (side, along(cell[0] + u), along(cell[1] + v));
                vertices.push(p.normalize().into());
            }
            let outwards = [first, first + 1, first + 2, first + 3];
            quads.push(if side > 0.0 { outwards } else { [first + 3, first + 2, first + 1, first] });
        }
    }
    Ok(Mesh::new(vertices, &quads)?)
}

/// A ball that is damped, of about 300 lattice vertices, changed at first, among colliders.
fn among(
    colliders: &[Collider],
    state: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
    gravity: f64,
) -> Result<Figures, Error> {
    let mut body = Body::builder(ball(16)?).lattice_vertices(300).half_width(2).damping(0.1).build()?;
    deform(&mut body, state)?;
    let simulation = Simulation::builder().body(body).gravity([0.0, gravity, 0.0]).threads(1);
    let simulation = colliders.iter().cloned().fold(simulation, |all, collider| all.collider(collider));
    watch(simulation.build()?, Surroundings::Acting, |trial| {
        trial.run(2_000, 20);
        Ok(())
    })
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    let as_it_is = |x: &[Vector3<f64>]| x.to_vec();
    let plate = |normal: f64| {
        let key = |(time, way)| Key { time, translate: [0.0, way, 0.0], rotate: [0.0; 3] };
        let keys = [(0.0, 0.0), (1.0, 0.95 * normal), (2.0, 0.95 * normal), (2.5, 0.0)].map(key).to_vec();
        Collider { keys, ..Collider::plane([0.0, -normal, 0.0], [0.0, normal, 0.0]) }
    };
    let plates = [plate(1.0), plate(-1.0)];
    let needle = [
        Collider::capsule([0.02, -5.0, 0.02], [0.02, -1.2, 0.02], 0.02),
        Collider::plane([0.0, -5.0, 0.0], [0.0, 1.0, 0.0]),
    ];
    let back = "returns to its rest shape, its volume kept";
    let kept = |case: Case| case.bound(Measure::Shape, 1e-3).bound(Measure::Volume, 1e-6);
    vec![
        kept(Case::new(FAMILY, "a ball, squeezed flat and let go", back, move || {
            among(&plates, as_it_is, 0.0)
        })),
        kept(Case::new(FAMILY, "a ball, inside out", back, || {
            among(&[], |x| x.iter().map(|x| -x).collect(), 0.0)
        })),
        kept(Case::new(FAMILY, "a ball, collapsed to a point", back, || {
            among(&[], |x| vec![Vector3::zeros(); x.len()], 0.0)
        })),
        Case::new(FAMILY, "a ball, dropped on a needle", "comes to rest, its volume kept", move || {
            among(&needle, as_it_is, -9.81)
        })
        .bound(Measure::FinalSpeed, 5e-3)
        .bound(Measure::Volume, 1e-6),
    ]
}
