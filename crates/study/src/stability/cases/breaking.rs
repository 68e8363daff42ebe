//! Cases with bodies that break: torn apart, dropped and spun.

use supple::{
    Body, BodyBuilder, BreakLimit, Collider, Error, FractureOptions, Handle, Key, Material, Mesh, Selection,
    Simulation, TimeWindow, VolumeMeasure,
};

use crate::stability::bodies::{alone, block, of_cells};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, Trial, measure};

/// Cells of the bar along x, y and z.
const BAR: [i32; 3] = [16, 4, 4];

/// Creates the fracture of a body that breaks at a strain, with up to `cracks` cracks at a time.
fn brittle(strain: f64, cracks: usize) -> FractureOptions {
    FractureOptions { cracks, ..FractureOptions::new(BreakLimit::Strain(strain)) }
}

/// Returns the greatest number of pieces of a body.
fn pieces(trial: &Trial<'_>) -> usize {
    trial.simulation.bodies().iter().map(Body::pieces).max().unwrap_or_default()
}

/// The seconds within which the ends of a bar are torn apart.
const TEARING: f64 = 1.0;

/// Moves the ends of a bar apart by its length, and turns one of them, and then lets them go: the volume of a piece of which
/// the correction may not move most vertices is not kept.
fn torn(
    body: impl Fn() -> Result<BodyBuilder, Error>,
    fracture: FractureOptions,
    degrees: f64,
) -> Result<Figures, Error> {
    let end = |x: i32, translate: f64, angle: f64| {
        let key = |time, share: f64| Key {
            time,
            translate: [share * translate, 0.0, 0.0],
            rotate: [share * angle, 0.0, 0.0],
        };
        let motion = vec![key(0.0, 0.0), key(TEARING, 1.0)].into();
        let window = TimeWindow { end: TEARING, ..TimeWindow::default() };
        Handle { goal: None, selection: end_of_bar(x), motion, window }
    };
    let body = body()?.region_damping(0.1).fracture(fracture);
    let body = body.handle(end(0, -8.0, 0.0)).handle(end(BAR[0], 8.0, degrees)).build()?;
    Ok(measure(alone(body)?, System::Driven, |trial| {
        trial.run(1_500, 10);
        assert!(pieces(trial) > 1, "the bar did not break");
    }))
}

/// Selects the vertices of the mesh or the lattice at an end of the bar.
fn end_of_bar(x: i32) -> Selection {
    let [_, y, z] = BAR.map(f64::from);
    let x = f64::from(x);
    Selection::Box { min: [x - 0.1, -0.1, -0.1], max: [x + 0.1, y + 0.1, z + 0.1] }
}

/// Lets a brittle block hit the ground at `speed` cells per step.
fn dropped(
    body: Result<BodyBuilder, Error>,
    fracture: FractureOptions,
    speed: f64,
) -> Result<Figures, Error> {
    let body = body?.damping_ratio(0.2).fracture(fracture);
    let body = body.rotate([30.0, 0.0, 40.0]).translate([0.0, 8.0, 0.0]).velocity([0.0, -60.0 * speed, 0.0]);
    let ground = Collider { friction: 0.5, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let simulation = Simulation::builder().body(body.build()?).collider(ground).threads(1).build()?;
    Ok(measure(simulation, System::Driven, |trial| {
        trial.run(600, 10);
        assert!(pieces(trial) > 1, "the block did not break");
    }))
}

/// Spins a bar about an axis across it so fast that it breaks, and measures whether the pieces keep the momenta.
fn spun(fracture: FractureOptions, half_width: f64) -> Result<Figures, Error> {
    let body = of_cells(&block(BAR), half_width)?.fracture(fracture).spin([0.0, 0.0, 12.0]).build()?;
    Ok(measure(alone(body)?, System::Isolated, |trial| {
        trial.run(600, 10);
        assert!(pieces(trial) > 1, "the bar did not break");
    }))
}

/// Returns a block of cells with a mesh, whose volume is preserved.
fn with_mesh(size: [i32; 3], half_width: f64) -> Result<BodyBuilder, Error> {
    let body = Body::builder(grid_mesh(size, 2)).cell_size(1.0).material(Material::fast_lsm());
    Ok(body.half_width(half_width).volume(VolumeMeasure::Mesh))
}

/// Returns the mesh of a block of unit cells, with `n` x `n` quads to a face of a cell.
fn grid_mesh(size: [i32; 3], n: i32) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let (axis, upper) = (side / 2, side % 2 == 1);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let [along, across] = [size[u] * n, size[v] * n];
        let first = vertices.len() as u32;
        for (j, i) in (0..=across).flat_map(|j| (0..=along).map(move |i| (j, i))) {
            let mut place = [0.0; 3];
            place[axis] = if upper { f64::from(size[axis]) } else { 0.0 };
            (place[u], place[v]) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            vertices.push(place);
        }
        for (j, i) in (0..across).flat_map(|j| (0..along).map(move |i| (j, i))) {
            let row = (along + 1) as u32;
            let a = first + (j * (along + 1) + i) as u32;
            faces.push(if upper {
                [a, a + 1, a + 1 + row, a + row]
            } else {
                [a, a + row, a + 1 + row, a + 1]
            });
        }
    }
    Mesh::new(vertices, &faces).expect("the indices of the faces are valid")
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for half_width in [0.5, 1.0, 2.0] {
        let expected = "breaks into pieces that keep their volumes";
        // The ends move at 8 cells in 100 steps, and a wave of the strain at which the bar breaks at less than half a cell in a
        // step. Many times this is an explosion.
        let torn_case = |name: String, body: fn(f64) -> Result<BodyBuilder, Error>, degrees| {
            let torn = move || torn(|| body(half_width), brittle(0.2, 1), degrees);
            Case::new(name, expected, torn).bound(Measure::Volume, 1e-6).bound(Measure::LargestSpeed, 5.0)
        };
        for (name, degrees) in [("pulled", 0.0), ("pulled and twisted", 90.0)] {
            let name = format!("half-width {half_width}, {name} apart by a length");
            cases.push(torn_case(name.clone(), |half_width| of_cells(&block(BAR), half_width), degrees));
            cases.push(torn_case(name + ", mesh", |half_width| with_mesh(BAR, half_width), degrees));
        }
        // A fifth and more above the speed of waves, sqrt(w (w + 1)/3) cells per step.
        let speed = 1.2 * half_width;
        for (name, has_mesh) in [("thrown on the ground", false), ("thrown on the ground, mesh", true)] {
            let dropped = move || {
                let size = [6; 3];
                let body =
                    if has_mesh { with_mesh(size, half_width) } else { of_cells(&block(size), half_width) };
                dropped(body, brittle(0.02, 2), speed)
            };
            let expected = "breaks, and comes to lie";
            let case = Case::new(format!("half-width {half_width}, {name}"), expected, dropped);
            // Crumbs that others press on the ground do not keep their volume. A fragment can be faster than the block
            // was, by the strain that it had, but not many times.
            cases.push(case.bound(Measure::LargestSpeed, 3.0 * speed));
        }
        for cracks in [1, 8] {
            let name = format!("half-width {half_width}, spun, cracks {cracks}");
            let expected = "flies apart, and the pieces keep the momenta and their volumes";
            let case = Case::new(name, expected, move || spun(brittle(0.02, cracks), half_width));
            cases.push(case.bound(Measure::Volume, 1e-6).keeps_momenta());
        }
    }
    cases
}
