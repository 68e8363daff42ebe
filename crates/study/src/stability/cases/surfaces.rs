//! Cases of bodies with a surface mesh. The volume of the mesh is preserved, and the evaluated surface must
//! be finite.

use nalgebra::Vector3;
use supple::{Body, Collider, Error, Material, Mesh, Simulation};

use crate::stability::bodies::{Matter, block, deform, plate};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Builds a ball of radius 1 centered at the origin from a cube with n x n quads per side.
fn ball(n: i32) -> Result<Mesh, Error> {
    let mut vertices = Vec::new();
    let mut quads = Vec::new();
    for cell in block([n, n, 1]) {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let first = vertices.len() as u32;
            for [u, v] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                let coordinate = |i: i32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
                let mut p = Vector3::zeros();
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                    (side, coordinate(cell[0] + u), coordinate(cell[1] + v));
                vertices.push(p.normalize().into());
            }
            let corners = [first, first + 1, first + 2, first + 3];
            quads.push(if side > 0.0 { corners } else { [first + 3, first + 2, first + 1, first] });
        }
    }
    Ok(Mesh::new(vertices, &quads)?)
}

/// Simulates a damped ball of approximately 300 lattice vertices with an initial deformation and colliders.
/// `gravity` is along y.
fn run(
    matter: Matter,
    colliders: &[Collider],
    state: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
    gravity: f64,
) -> Result<Figures, Error> {
    let body = Body::builder(ball(16)?).material(Material::fast_lsm()).lattice_vertices(300);
    let body = matter.applied(body.half_width(matter.half_width));
    let mut body = body.region_damping(0.1).build()?;
    deform(&mut body, state)?;
    let simulation = Simulation::builder().sleep(false).body(body).gravity([0.0, gravity, 0.0]).threads(1);
    let simulation = colliders.iter().cloned().fold(simulation, |all, collider| all.collider(collider));
    Ok(measure(simulation.build()?, System::Driven, |trial| trial.run(2_000, 20)))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    type Deform = fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>;
    let unchanged: Deform = |x| x.to_vec();
    let plates = [1.0, -1.0].map(|normal| plate(-normal, normal, 0.95 * normal)).to_vec();
    let needle = vec![
        Collider::capsule([0.02, -5.0, 0.02], [0.02, -1.2, 0.02], 0.02),
        Collider::plane([0.0, -5.0, 0.0], [0.0, 1.0, 0.0]),
    ];
    let returning: [(&str, Vec<Collider>, Deform); 3] = [
        ("a ball, squeezed flat and let go", plates, unchanged),
        ("a ball, inside out", Vec::new(), |x| x.iter().map(|x| -x).collect()),
        ("a ball, collapsed to a point", Vec::new(), |x| vec![Vector3::zeros(); x.len()]),
    ];
    let mut cases = Vec::new();
    for matter in Matter::wide(2.0) {
        for (name, colliders, state) in returning.clone() {
            // The plates stay in contact with a ball that is inflated.
            if matter.inflate > 1.0 && !colliders.is_empty() {
                continue;
            }
            let expected = "returns to its rest shape; its volume is preserved";
            let case = Case::new(matter.named(name), expected, move || run(matter, &colliders, state, 0.0));
            cases.push(case.bound(Measure::Shape, 1e-3).bound(Measure::Volume, 1e-6));
        }
        let (name, needle) = (matter.named("a ball, dropped on a needle"), needle.clone());
        let case = Case::new(name, "comes to rest; its volume is preserved", move || {
            run(matter, &needle, unchanged, -9.81)
        });
        cases.push(case.bound(Measure::FinalSpeed, 5e-3).bound(Measure::Volume, 1e-6));
    }
    cases
}
