//! Poisson's ratio: the volume term of the regions equals the reference, follows its laws, and is stable.

use nalgebra::{Matrix3, Point3, Vector3};
use supple::reference::{Naive, Regions};
use supple::{
    Body, BodyBuilder, Damping, ElasticLaw, Elasticity, HalfWidth, Handle, Key, Lattice, Material, Pin,
    Plasticity, RegionSize, Selection, Simulation, Stiffness, TimeWindow, VolumeMeasure,
};
use supple_tests::{
    Random, block, coordinates, difficult_lattices, lattice, momentum, points, rest, rigid_fit, rms,
    tolerance, without_gravity, worst,
};

/// Returns a body with regions of this half-width and the greatest alpha of Poisson's ratio.
pub(crate) fn body(lattice: &Lattice, half_width: impl Into<HalfWidth>, poisson_ratio: f64) -> BodyBuilder {
    let (size, stiffness) = (RegionSize::Cells(half_width.into()), Stiffness::PerStep(1.0));
    let elasticity = Elasticity::Regions { size, stiffness };
    let material = Material { elasticity, poisson_ratio: Some(poisson_ratio), ..Material::fast_lsm() };
    Body::from_lattice(lattice.clone()).material(material)
}

pub(crate) fn naive(lattice: &Lattice, half_width: impl Into<HalfWidth>, poisson_ratio: f64) -> Naive<'_> {
    Naive::new(lattice, half_width, Regions::Staircase).with_poisson_ratio(poisson_ratio)
}

/// Turns, stretches and shakes positions: `stretch` are the factors along the axes, of which negative ones invert.
pub(crate) fn deformed(
    x: &[Vector3<f64>],
    stretch: [f64; 3],
    noise: f64,
    random: &mut Random,
) -> Vec<Vector3<f64>> {
    let map = random.rotation() * Matrix3::from_diagonal(&stretch.into());
    let middle = x.iter().sum::<Vector3<f64>>() / x.len() as f64;
    x.iter().map(|x| map * (x - middle) + random.vector() * noise).collect()
}

#[test]
fn goals_and_energies_equal_the_reference() {
    let mut random = Random(41);
    for (name, lattice) in difficult_lattices() {
        for (half_width, ratio) in [(1.0, 0.45), (2.0, 0.3), (4.0, 0.47), (0.5, 0.0), (0.5, 0.45)] {
            for stretch in [[1.3, 0.9, 1.1], [1.0, 0.0, 1.0], [-0.7, 1.2, 1.0]] {
                let x = deformed(&rest(&lattice), stretch, 0.1, &mut random);
                let mut simulation = without_gravity(body(&lattice, half_width, ratio).build().unwrap());
                simulation.body_mut(0).set_positions(&points(&x)).unwrap();
                let body = simulation.body(0);
                let x = coordinates(&body.positions());
                let naive = naive(&lattice, half_width, ratio);
                let motions = naive.motions(&x);
                let extent = x.iter().map(|x| x.amax()).fold(1.0, f64::max);
                // The second derivatives of the volume term are at most 1.76 k in the metric of the region, and the
                // deformation gradient has the errors of the positions: k is up to 23.5.
                let limit = 20.0 * tolerance(extent);
                let error = worst(&coordinates(&body.goals()), &naive.goals(&motions));
                assert!(error <= limit, "{name}, w = {half_width}, {ratio}, {stretch:?}: goals {error:e}");
                let alpha = ElasticLaw::greatest_alpha_of(ratio);
                let expected = alpha / simulation.dt().powi(2)
                    * naive.matching_energy(&motions, &x)
                    * body.material().density;
                let found = body.elastic_energy().unwrap();
                let scale = expected.max(alpha / simulation.dt().powi(2) * body.mass());
                assert!((found - expected).abs() <= 1e-4 * scale, "{name}: {found} for {expected}");
            }
        }
    }
}

/// Asserts that the elastic forces are the gradient of the energy: s m (x - g) by differences of the sum.
pub(crate) fn assert_forces_are_gradient(naive: &Naive<'_>, x: &[Vector3<f64>], name: &str) {
    let energy = |x: &[Vector3<f64>]| naive.matching_energy(&naive.motions(x), x);
    let goals = naive.goals(&naive.motions(x));
    let step = 1e-5;
    for vertex in (0..x.len()).step_by(7) {
        for axis in 0..3 {
            let at = |sign: f64| {
                let mut moved = x.to_vec();
                moved[vertex][axis] += sign * step;
                energy(&moved)
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
            let expected = naive.weights().masses[vertex] * (x[vertex] - goals[vertex])[axis];
            let scale = 1.0 + expected.abs();
            assert!((slope - expected).abs() < 1e-6 * scale, "{name}: {slope} for {expected}");
        }
    }
}

#[test]
fn forces_are_the_gradient_of_the_energy() {
    let mut random = Random(42);
    let cells: Vec<[i32; 3]> = block([4, 3, 2]).into_iter().filter(|cell| *cell != [1, 1, 1]).collect();
    let lattice = lattice(&cells);
    for (half_width, ratio) in [(1.0, 0.45), (2.0, 0.3), (0.5, 0.0), (0.5, 0.45)] {
        for (stretch, noise) in
            [([1.2, 0.9, 1.0], 0.1), ([1.0, 1.0, -1.0], 0.2), ([0.1, 0.1, 0.1], 0.05), ([5.0, 3.0, 4.0], 1.0)]
        {
            let naive = naive(&lattice, half_width, ratio);
            let x = deformed(&rest(&lattice), stretch, noise, &mut random);
            assert_forces_are_gradient(&naive, &x, &format!("{half_width}, {ratio}, {stretch:?}"));
        }
    }
}

#[test]
fn poisson_ratio_zero_has_the_bits_of_none() {
    let lattice = lattice(&block([7, 5, 4]));
    let mut random = Random(43);
    let x = points(&deformed(&rest(&lattice), [1.2, 0.8, 1.0], 0.1, &mut random));
    let run = |ratio: Option<f64>| {
        let elasticity = Elasticity::YoungsModulus(1e5);
        let material = Material { elasticity, poisson_ratio: ratio, ..Material::default() };
        let mut body = Body::from_lattice(lattice.clone()).material(material).build().unwrap();
        body.set_positions(&x).unwrap();
        let mut simulation = without_gravity(body);
        simulation.steps(100);
        (simulation.body(0).positions(), simulation.body(0).velocities())
    };
    assert!(run(Some(0.0)) == run(None));
}

#[test]
fn bits_do_not_depend_on_threads_and_states_continue() {
    let lattice = lattice(&block([20, 19, 18]));
    let mut random = Random(44);
    let x = points(&deformed(&rest(&lattice), [1.2, 0.8, 1.0], 0.1, &mut random));
    for (half_width, ratio) in [(1.0, 0.45), (0.5, 0.45), (0.5, 0.0)] {
        let run = |threads: usize| {
            let mut body = body(&lattice, half_width, ratio).build().unwrap();
            body.set_positions(&x).unwrap();
            let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(threads);
            let mut simulation = simulation.build().unwrap();
            simulation.steps(10);
            simulation
        };
        assert_same_bits(run, &format!("{half_width}, {ratio}"));
    }
}

/// Asserts that a simulation that `run` steps with a number of threads has the same bits with one and with three, and that
/// its state continues with the same bits in itself and in another one.
pub(crate) fn assert_same_bits(run: impl Fn(usize) -> Simulation, name: &str) {
    let (alone, mut together) = (run(1), run(3));
    let state = together.state();
    assert!(alone.state() == state, "{name}");
    together.steps(10);
    let end = together.state();
    for mut simulation in [together, alone] {
        simulation.restore(&state).unwrap();
        simulation.steps(10);
        assert!(simulation.state() == end, "{name}");
    }
}

/// Returns the part of the space within 0.1 of `at` along x.
pub(crate) fn layer(at: f64) -> Selection {
    Selection::Box { min: [at - 0.1, -1e3, -1e3], max: [at + 0.1, 1e3, 1e3] }
}

/// Returns a bar along x of a length and thickness in cells whose ends are held and moved apart by the share `strain`, at rest.
pub(crate) fn pulled(
    [cells, thickness]: [i32; 2],
    half_width: impl Into<HalfWidth>,
    ratio: f64,
    strain: f64,
) -> Simulation {
    let lattice = lattice(&block([cells, thickness, thickness]));
    let end = f64::from(cells);
    let translate = [strain * end, 0.0, 0.0];
    let keys = vec![
        Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
        Key { time: 1.0, translate, rotate: [0.0; 3] },
    ];
    let window = TimeWindow::default();
    let pin = Pin { goal: None, selection: layer(0.0), window };
    let handle = Handle { goal: None, selection: layer(end), motion: keys.into(), window };
    let body = body(&lattice, half_width, ratio).damping_rate(4.0).pin(pin).handle(handle);
    let builder =
        Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).dt(1.0 / 240.0).sleep(false);
    let mut simulation = builder.build().unwrap();
    simulation.steps(6 * 240);
    simulation
}

/// Returns the mean coordinate along an axis of the vertices with some grid indices.
pub(crate) fn mean_position(body: &Body, axis: usize, is_in: impl Fn(&[i32; 3]) -> bool) -> f64 {
    let vertices = body.lattice().indices().iter().zip(body.positions());
    let values: Vec<f64> = vertices.filter(|(index, _)| is_in(index)).map(|(_, x)| x[axis]).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the strain along x, and the mean strain across, in the middle of a bar: a cube.
pub(crate) fn strains(body: &Body, [length, thickness]: [i32; 2]) -> [f64; 2] {
    let (low, high) = ((length - thickness) / 2, (length + thickness) / 2);
    let mean = |axis: usize, is_in: &dyn Fn(&[i32; 3]) -> bool| mean_position(body, axis, is_in);
    let is_middle = |index: &[i32; 3]| (low..=high).contains(&index[0]);
    let along = mean(0, &|index| index[0] == high) - mean(0, &|index| index[0] == low);
    let across = |axis: usize| {
        let side = |at: i32| mean(axis, &|index| is_middle(index) && index[axis] == at);
        (side(thickness) - side(0)) / f64::from(thickness) - 1.0
    };
    [along / f64::from(thickness) - 1.0, (across(1) + across(2)) / 2.0]
}

/// Stretched or pressed by 2 %, a bar becomes narrower or wider by nu of it. The regions near the surface are thinner and
/// resist a change of volume less: nu within 0.02, as on paper.
#[test]
fn poisson_ratio_is_as_asked() {
    for (thickness, half_width) in [(6, 1), (6, 2), (10, 1), (10, 2)] {
        for ratio in [0.0, 0.3, 0.45] {
            for strain in [0.02, -0.02] {
                let simulation = pulled([5 * thickness, thickness], half_width, ratio, strain);
                let [along, across] = strains(&simulation.body(0), [5 * thickness, thickness]);
                let found = -across / along;
                assert!((found - ratio).abs() <= 0.02, "{thickness}, w = {half_width}: {found} for {ratio}");
            }
        }
    }
}

/// Young's modulus by the force of the hold, the area of the cells and the strain, against the law
/// 1 - 0.47 nu R/t, with R = sqrt(w (w + 1)).
#[test]
fn youngs_modulus_is_that_of_the_law() {
    for (thickness, half_width) in [(6, 1), (6, 2), (10, 2)] {
        for ratio in [0.3, 0.45] {
            let simulation = pulled([5 * thickness, thickness], half_width, ratio, 0.02);
            let body = simulation.body(0);
            let [along, _] = strains(&body, [5 * thickness, thickness]);
            let force = body.hold_force(0).unwrap().unwrap().force.x;
            let area = f64::from(thickness * thickness);
            let law = ElasticLaw {
                density: body.material().density,
                cell_size: 1.0,
                dt: simulation.dt(),
                poisson_ratio: ratio,
            };
            let modulus = law.modulus(half_width, law.greatest_alpha());
            let radius = ((half_width * (half_width + 1)) as f64).sqrt() / f64::from(thickness);
            let expected = 1.0 - 0.47 * ratio * radius;
            let found = force.abs() / area / along / modulus;
            assert!(
                (found - expected).abs() <= 0.03,
                "{thickness}, w = {half_width}: {found} for {expected}"
            );
        }
    }
}

/// The volume of the cells over that at rest, without the correction for display.
fn volume(simulation: &Simulation) -> f64 {
    let report = simulation.body(0).volume_report();
    assert_eq!(report.measure, VolumeMeasure::Cells);
    report.before / report.rest
}

#[test]
fn a_stretched_bar_keeps_its_volume_in_the_motion() {
    let simulation = pulled([30, 6], 1, 0.45, 0.5);
    let kept = volume(&simulation);
    assert!(kept <= 1.06, "{kept}");
    let without = volume(&pulled([30, 6], 1, 0.0, 0.5));
    assert!(without > 1.3, "{without}");
}

/// Returns the energy of an undamped body in cell masses times (cells per step)².
fn energy(naive: &Naive, body: &Body, (alpha, dt): (f64, f64)) -> f64 {
    let velocities: Vec<_> = body.velocities().iter().map(|v| v * dt).collect();
    naive.energy(&coordinates(&body.positions()), &velocities, alpha)
}

/// Returns the greatest energies of an undamped bar of 3 x 3 x 6 cells in each of six thousand steps over the one at the
/// start. It is strained, shaken by 10 % of `amplitude` (root mean square), turned and spinning.
fn greatest_energies(
    (half_width, ratio): (f64, f64),
    amplitude: f64,
    spin: f64,
    strain: impl Fn(&mut Random) -> Matrix3<f64>,
) -> Vec<f64> {
    let lattice = lattice(&block([3, 3, 6]));
    let mut random = Random(45);
    let map = random.rotation() * (Matrix3::identity() + strain(&mut random) * amplitude);
    let at_rest = rest(&lattice);
    let middle = at_rest.iter().sum::<Vector3<f64>>() / at_rest.len() as f64;
    let x: Vec<_> =
        at_rest.iter().map(|x| map * (x - middle) + random.vector() * (0.17 * amplitude)).collect();
    let mut body = body(&lattice, half_width, ratio).build().unwrap();
    body.set_positions(&points(&x)).unwrap();
    let omega = Vector3::new(0.3, 0.5, -0.8) * spin;
    let velocities: Vec<_> = x.iter().map(|x| omega.cross(x)).collect();
    body.set_velocities(&velocities).unwrap();
    let mut simulation = without_gravity(body);
    let steps = (ElasticLaw::greatest_alpha_of(ratio), simulation.dt());
    let naive = naive(&lattice, half_width, ratio).listed();
    let start = energy(&naive, &simulation.body(0), steps);
    let mut greatest_of_thousand = || {
        let energies = (0..50).map(|_| {
            simulation.steps(20);
            energy(&naive, &simulation.body(0), steps) / start
        });
        energies.fold(0.0, f64::max)
    };
    (0..6).map(|_| greatest_of_thousand()).collect()
}

/// Strained without much change of its volume, the bar keeps its energy: the bounds are those of the prototype in f64, 1.5 %
/// up to half of its size, and about 3 % at all of it (measured 3.1 %).
#[test]
fn undamped_bodies_keep_their_energy() {
    let strain = |_: &mut Random| Matrix3::new(1.0, 0.3, 0.0, 0.0, -0.5, 0.2, 0.1, 0.0, -0.4);
    for ratio in [0.3, 0.45] {
        for (amplitude, spin, limit) in [
            (0.01, 0.0, 1.015),
            (0.1, 0.0, 1.015),
            (0.1, 3.0, 1.015),
            (0.3, 0.0, 1.015),
            (0.5, 0.0, 1.015),
            (1.0, 0.0, 1.035),
        ] {
            let greatest = greatest_energies((1.0, ratio), amplitude, spin, strain);
            let most = greatest.iter().copied().fold(0.0, f64::max);
            assert!(most <= limit, "{ratio}, {amplitude}, spin {spin}: {greatest:?}");
        }
    }
}

/// Regions of one cell keep it within 1.5 %, and within 6 % over 3,000 steps (measured 5.1 %) where cells are inverted, at the
/// strain 1. There the motion is chaotic: with another order of sums it gained 7.5 %.
#[test]
fn undamped_cells_keep_their_energy() {
    let strain = |_: &mut Random| Matrix3::new(1.0, 0.3, 0.0, 0.0, -0.5, 0.2, 0.1, 0.0, -0.4);
    for ratio in [0.0, 0.3, 0.45] {
        for (amplitude, spin) in [(0.01, 0.0), (0.1, 0.0), (0.1, 3.0), (0.3, 0.0), (0.5, 0.0), (1.0, 0.0)] {
            let greatest = greatest_energies((0.5, ratio), amplitude, spin, strain);
            let (limit, thousands) = if amplitude < 1.0 { (1.015, 6) } else { (1.06, 3) };
            let most = greatest[..thousands].iter().copied().fold(0.0, f64::max);
            assert!(most <= limit, "{ratio}, {amplitude}, spin {spin}: {greatest:?}");
        }
    }
}

/// Where most of the energy is that of a change of volume, which oscillates with few steps per period, the energy of the
/// leapfrog steps differs from that of the start by several per cent. It does not grow.
#[test]
fn energy_of_bodies_that_change_their_volume_does_not_grow() {
    let strain = |random: &mut Random| Matrix3::from_fn(|_, _| random.signed() * 0.5);
    for ratio in [0.3, 0.45, 0.47] {
        for amplitude in [0.01, 0.1, 0.3, 0.5, 1.0] {
            let greatest = greatest_energies((1.0, ratio), amplitude, 0.0, strain);
            assert!(greatest[0] <= 1.1, "{ratio}, {amplitude}: {greatest:?}");
            let later = greatest[1..].iter().copied().fold(0.0, f64::max);
            assert!(later <= 1.025 * greatest[0], "{ratio}, {amplitude}: {greatest:?}");
        }
    }
}

#[test]
fn momenta_are_conserved() {
    let lattice = lattice(&block([8, 5, 4]));
    let x = deformed(&rest(&lattice), [1.3, 0.7, 1.1], 0.2, &mut Random(46));
    assert_keeps_momenta(body(&lattice, 1, 0.45).build().unwrap(), &x);
}

/// Lets a body move freely from positions, with velocities that translate, turn and stretch it.
pub(crate) fn assert_keeps_momenta(mut body: Body, x: &[Vector3<f64>]) {
    body.set_positions(&points(x)).unwrap();
    let velocities: Vec<_> = x.iter().map(|x| Vector3::new(1.0 + x.y, -x.x, x.z)).collect();
    body.set_velocities(&velocities).unwrap();
    let mut simulation = without_gravity(body);
    let before = (momentum(&simulation.body(0)), simulation.body(0).angular_momentum());
    simulation.steps(300);
    let body = simulation.body(0);
    assert!((momentum(&body) - before.0).norm() < 1e-6 * before.0.norm());
    assert!((body.angular_momentum() - before.1).norm() < 1e-6 * before.1.norm());
}

/// Returns the position of a vertex in a state, from its position at rest relative to the middle.
type Start = Box<dyn Fn(Vector3<f64>, &mut Random) -> Vector3<f64>>;

/// Ten extreme states of a bar, from which a damped body returns to its rest shape.
#[test]
fn bodies_return_from_extreme_states() {
    let lattice = lattice(&block([4, 4, 6]));
    let at_rest = rest(&lattice);
    let middle = at_rest.iter().sum::<Vector3<f64>>() / at_rest.len() as f64;
    let mut random = Random(47);
    let states: [(&str, Start); 10] = [
        ("random", Box::new(|_, random| random.vector() * 3.0)),
        ("flat", Box::new(|x, _| Vector3::new(x.x, x.y, 0.0))),
        ("inverted", Box::new(|x, _| Vector3::new(x.x, x.y, -x.z))),
        ("half inverted", Box::new(|x, _| Vector3::new(x.x, x.y, -x.z.abs()))),
        ("point", Box::new(|_, _| Vector3::zeros())),
        ("five times as long", Box::new(|x, _| Vector3::new(x.x, x.y, 5.0 * x.z))),
        ("crushed", Box::new(|x, _| Vector3::new(x.x, x.y, 0.1 * x.z))),
        ("small", Box::new(|x, _| x * 0.2)),
        ("large", Box::new(|x, _| x * 3.0)),
        (
            "twisted",
            Box::new(|x, _| {
                let (sine, cosine) = (x.z * std::f64::consts::TAU / 6.0).sin_cos();
                Vector3::new(cosine * x.x - sine * x.y, sine * x.x + cosine * x.y, x.z)
            }),
        ),
    ];
    for (half_width, ratio) in [(1.0, 0.3), (1.0, 0.45), (1.0, 0.47), (0.5, 0.0), (0.5, 0.45)] {
        for (name, state) in &states {
            let x: Vec<_> = at_rest.iter().map(|x| state(x - middle, &mut random)).collect();
            let mut body = body(&lattice, half_width, ratio).damping_rate(0.03 * 60.0).build().unwrap();
            body.set_positions(&points(&x)).unwrap();
            let mut simulation = without_gravity(body);
            simulation.steps(2000);
            let now = coordinates(&simulation.body(0).positions());
            let distance = distance_from_rest(&at_rest, &now);
            assert!(
                distance < 0.02,
                "{name}, w = {half_width}, {ratio}: {distance} cells from its rest shape"
            );
        }
    }
}

/// Tangled starts: all vertices anywhere in the box of a bar. Without the recovery some of them end in a twisted shape of which
/// no cell is inside out, above all with narrow regions and much damping.
#[test]
fn tangled_bodies_return() {
    let lattice = lattice(&block([4, 4, 6]));
    let at_rest = rest(&lattice);
    let mut random = Random(49);
    for (half_width, poisson_ratio) in [(0.5, 0.0), (0.5, 0.3), (0.5, 0.45), (1.0, 0.45), (2.0, 0.45)] {
        let dampings: [fn(BodyBuilder) -> BodyBuilder; 2] =
            [|body| body.damping_rate(0.03 * 60.0), |body| body.damping_ratio(1.0)];
        for damp in dampings {
            let mut is_lost = |_: &u64| {
                let mut body = damp(body(&lattice, half_width, poisson_ratio)).build().unwrap();
                let x: Vec<_> = at_rest.iter().map(|_| Point3::from(random.vector() * 3.0)).collect();
                body.set_positions(&x).unwrap();
                let mut simulation = without_gravity(body);
                !(0..15).any(|_| {
                    simulation.steps(200);
                    distance_from_rest(&at_rest, &coordinates(&simulation.body(0).positions())) < 0.02
                })
            };
            let lost: Vec<u64> = (0..20).filter(&mut is_lost).collect();
            assert!(lost.is_empty(), "{half_width}, {poisson_ratio}: {lost:?}");
        }
    }
}

/// The recovery keeps the momenta, and ends.
#[test]
fn recovery_of_a_tangled_body_keeps_its_momenta() {
    let lattice = lattice(&block([4, 4, 6]));
    let mut random = Random(50);
    let x: Vec<_> = rest(&lattice).iter().map(|_| random.vector() * 3.0).collect();
    assert_keeps_momenta(body(&lattice, 0.5, 0.45).damping_ratio(1.0).build().unwrap(), &x);
}

/// A pin that becomes active during a recovery ends it: the body goes on in its flight, and only its pinned vertex stops.
#[test]
fn a_pin_ends_the_recovery_of_a_tangled_body() {
    let lattice = lattice(&block([4, 4, 6]));
    let mut random = Random(51);
    let x: Vec<_> = rest(&lattice).iter().map(|_| Point3::from(random.vector() * 3.0)).collect();
    let window = TimeWindow { start: 0.05, ..TimeWindow::default() };
    let pin = Pin { goal: None, selection: Selection::Vertices(vec![0]), window };
    let mut body = body(&lattice, 0.5, 0.45).damping_rate(0.0).pin(pin).build().unwrap();
    body.set_positions(&x).unwrap();
    body.set_velocities(&vec![Vector3::new(5.0, 0.0, 0.0); x.len()]).unwrap();
    let mut simulation = without_gravity(body);
    simulation.steps(6);
    let speed = |simulation: &Simulation| momentum(&simulation.body(0)).x / simulation.body(0).mass();
    assert!(speed(&simulation) > 4.0, "{}", speed(&simulation));
    simulation.steps(5);
    assert!(speed(&simulation) > 2.5, "{}", speed(&simulation));
}

/// Returns the root mean square distance of positions from their best-fit rest shape.
fn distance_from_rest(at_rest: &[Vector3<f64>], now: &[Vector3<f64>]) -> f64 {
    let (rotation, from, to) = rigid_fit(&vec![1.0; now.len()], at_rest, now);
    rms(at_rest.iter().zip(now).map(|(rest, now)| (now - to - rotation * (rest - from)).norm()))
}

/// Coordinates of any finite size stay finite.
#[test]
fn huge_deformations_stay_finite() {
    let lattice = lattice(&block([3, 3, 3]));
    for (size, half_width) in [1e2, 1e5, 1e8, 1e12].into_iter().flat_map(|size| [(size, 1.0), (size, 0.5)]) {
        let mut body = body(&lattice, half_width, 0.45).build().unwrap();
        let x: Vec<_> = rest(&lattice).iter().map(|x| Point3::from(x * size)).collect();
        body.set_positions(&x).unwrap();
        let mut simulation = without_gravity(body);
        for _ in 0..50 {
            simulation.step();
            assert!(
                simulation.body(0).positions().iter().all(|x| x.iter().all(|x| x.is_finite())),
                "{size:e}, w = {half_width}"
            );
        }
    }
}

/// The plastic shape has the determinant 1, so that a plastic body keeps its volume term.
#[test]
fn goals_of_plastic_bodies_equal_the_reference() {
    let mut random = Random(48);
    let lattice = lattice(&block([6, 4, 4]));
    let plastic = Plasticity { yield_strain: 0.02, creep: 50.0, max: 0.6 };
    let material = Material { plastic: Some(plastic), poisson_ratio: Some(0.4), ..Material::fast_lsm() };
    for half_width in [1.0, 0.5] {
        let body = Body::from_lattice(lattice.clone()).material(material).half_width(half_width);
        let mut body = body.build().unwrap();
        let x = deformed(&rest(&lattice), [1.4, 0.8, 1.1], 0.1, &mut random);
        body.set_positions(&points(&x)).unwrap();
        let mut simulation = without_gravity(body);
        for step in 0..8 {
            let body = simulation.body(0);
            let (x, shapes) = (coordinates(&body.positions()), body.plastic_shapes());
            let naive = naive(&lattice, half_width, 0.4).with_shapes(shapes);
            let error = worst(&coordinates(&body.goals()), &naive.goals(&naive.motions(&x)));
            let extent = x.iter().map(|x| x.amax()).fold(1.0, f64::max);
            assert!(error <= 20.0 * tolerance(extent), "w = {half_width}, step {step}: {error:e}");
            simulation.step();
        }
    }
}

#[test]
fn ratios_out_of_range_are_errors() {
    let lattice = lattice(&block([2, 2, 2]));
    for ratio in [-0.1, 0.48, 0.5, f64::NAN] {
        let error = body(&lattice, 1, ratio).build().unwrap_err().to_string();
        assert!(error.contains("poisson_ratio") && error.contains("[0, 0.47]"), "{error}");
    }
    let mut body = body(&lattice, 1, 0.3).damping_rate(2.0).build().unwrap();
    assert!(body.set_poisson_ratio(Some(0.6)).is_err());
    body.set_poisson_ratio(None).unwrap();
    assert_eq!(body.material().poisson_ratio(), 0.0);
    assert_eq!(body.material().damping, Some(Damping::Rate(2.0)));
}
