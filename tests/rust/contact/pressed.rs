//! Bodies that colliders press: their faces lie on what presses them, and what is shown of them stays out of their neighbors.

use supple::{Body, Collider, Mesh, Preset, Simulation, SimulationBuilder, Substeps, VolumeOptions};
use supple_tests::{grid_box, mesh_of, plain_box, sphere};

use crate::near_bodies::{greatest_depth, moving_by, with_bodies};

/// Returns a collider that moves by `offset` in the first second.
fn moving(collider: Collider, offset: [f64; 3]) -> Collider {
    Collider { keys: moving_by(offset), ..collider }
}

/// Returns a body of `flesh`.
fn flesh(mesh: Mesh, vertices: usize, translate: [f64; 3], volume: VolumeOptions) -> Body {
    let builder = Body::builder(mesh).lattice_vertices(vertices).preset(Preset::Flesh).volume(volume);
    builder.translate(translate).build().unwrap()
}

fn cube() -> Mesh {
    mesh_of(grid_box([-0.5; 3], [0.5; 3], [16; 3]))
}

fn build(
    bodies: impl IntoIterator<Item = Body>,
    colliders: impl IntoIterator<Item = Collider>,
) -> Simulation {
    let builder = colliders.into_iter().fold(with_bodies(bodies), SimulationBuilder::collider);
    builder.fps(60.0).substeps(Substeps::Auto).build().unwrap()
}

/// The displayed faces of a cube that is pressed by a tenth lie on planes, boxes and driven meshes: the greatest distance, gap or
/// overlap, is 0.05 cells, which nobody sees.
#[test]
fn the_faces_of_a_pressed_cube_lie_on_what_presses_them() {
    let slab = |low: f64, high: f64| mesh_of(plain_box([-1.0, low, -1.0], [1.0, high, 1.0]));
    let pairs = [
        [Collider::plane([0.0; 3], [0.0, 1.0, 0.0]), Collider::plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0])],
        [-0.2, 1.2].map(|y| Collider::cuboid([0.0, y, 0.0], [1.0, 0.2, 1.0], [0.0; 3])),
        [slab(-0.4, 0.0), slab(1.0, 1.4)].map(|mesh| Collider::mesh(mesh).unwrap()),
    ];
    for (pair, vertices) in pairs.iter().flat_map(|pair| [(pair, 216), (pair, 1000)]) {
        let [ground, top] = pair.clone();
        let body = flesh(cube(), vertices, [0.0, 0.5, 0.0], VolumeOptions::default());
        let mut simulation = build([body], [ground, moving(top, [0.0, -0.1, 0.0])]);
        simulation.advance(150);
        let body = simulation.body(0);
        let rest = body.mesh().unwrap().vertices().iter();
        let distances = rest.zip(body.surface().positions).filter_map(|(rest, now)| match rest.y {
            0.5 => Some(now.y - 0.9),
            -0.5 => Some(now.y),
            _ => None,
        });
        let greatest = distances.map(f64::abs).fold(0.0, f64::max) / body.lattice().cell_size();
        assert!(greatest < 0.05, "{:?}, {vertices}: {greatest} cells", pair[0].shape);
    }
}

/// What is shown of pressed bodies enters their neighbors by at most a tenth of a cell more than their lattices do: the volume
/// that the correction restores finds its way past them.
#[test]
fn what_is_shown_of_pressed_bodies_stays_out_of_their_neighbors() {
    let ball = || mesh_of(sphere([0.0; 3], 0.5, 16));
    let plate =
        |x: f64, y: f64, offset: [f64; 3]| moving(Collider::cuboid([x, y, 0.0], [1.2; 3], [0.0; 3]), offset);
    let ground = || Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    type Scene = (&'static str, Vec<(Mesh, [f64; 3])>, Vec<Collider>);
    let scenes: [Scene; 3] = [
        (
            "a ball pressed to 0.4 beside a ball",
            vec![(ball(), [0.0, 0.5, 0.0]), (ball(), [1.02, 0.5, 0.0])],
            vec![ground(), plate(0.0, 2.2, [0.0, -0.6, 0.0])],
        ),
        (
            "a ball pressed between two cubes",
            vec![(cube(), [-1.1, 0.5, 0.0]), (ball(), [0.0, 0.5, 0.0]), (cube(), [1.1, 0.5, 0.0])],
            vec![ground(), plate(-2.8, 0.5, [0.35, 0.0, 0.0]), plate(2.8, 0.5, [-0.35, 0.0, 0.0])],
        ),
        (
            "a cube pressed from the sides under a cube",
            vec![(cube(), [0.0, 0.5, 0.0]), (cube(), [0.3, 1.52, 0.0])],
            vec![ground(), plate(-1.75, -0.5, [0.25, 0.0, 0.0]), plate(1.75, -0.5, [-0.25, 0.0, 0.0])],
        ),
    ];
    for (name, bodies, colliders) in scenes {
        let [mut shown, mut lattices] = [VolumeOptions::default(), VolumeOptions::off()].map(|volume| {
            let bodies = bodies.iter().map(|(mesh, at)| flesh(mesh.clone(), 500, *at, volume));
            build(bodies, colliders.clone())
        });
        for frame in 1..=6 {
            shown.advance(10);
            lattices.advance(10);
            for (a, b) in (0..bodies.len()).flat_map(|a| (0..bodies.len()).map(move |b| (a, b))) {
                if a == b {
                    continue;
                }
                let [depth, own] = [&shown, &lattices].map(|sim| greatest_depth(sim, [a, b]));
                let cell_size = shown.body(a).lattice().cell_size();
                assert!(
                    depth - own < 0.1 * cell_size,
                    "{name}, frame {}, {a} in {b}: {} and {} cells",
                    10 * frame,
                    depth / cell_size,
                    own / cell_size
                );
            }
        }
    }
}
