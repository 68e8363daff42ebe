//! The displayed surface lies on colliders where the lattice is compressed, and nowhere else.

use std::f64::consts::{PI, TAU};

use nalgebra::Point3;
use supple::{
    Body, Collider, Key, Mesh, Simulation, SkinKind, Substeps, VolumeMeasure, VolumeOptions, VolumeScope,
};

/// Radius of the ball, in cells of size 1.
const RADIUS: f64 = 5.0;

/// A ball around the origin, with its poles along z.
fn ball() -> Mesh {
    let (rings, sides) = (80, 120);
    let mut vertices = vec![[0.0, 0.0, RADIUS], [0.0, 0.0, -RADIUS]];
    for ring in 1..rings {
        let (sin, cos) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
        vertices.extend((0..sides).map(|side| {
            let (y, x) = (TAU * f64::from(side) / f64::from(sides)).sin_cos();
            [RADIUS * sin * x, RADIUS * sin * y, RADIUS * cos]
        }));
    }
    let at = |ring: i32, side: i32| (2 + (ring - 1) * sides + side % sides) as u32;
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for side in 0..sides {
        faces.push(vec![0, at(1, side), at(1, side + 1)]);
        faces.push(vec![1, at(rings - 1, side + 1), at(rings - 1, side)]);
        faces.extend((1..rings - 1).map(|ring| {
            vec![at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)]
        }));
    }
    Mesh::new(vertices, &faces).unwrap()
}

/// The ball in a simulation, scaled by `scale` along y, with its lowest point at y = 0, beside colliders.
fn pressed(
    skin: SkinKind,
    volume: VolumeOptions,
    scale: f64,
    colliders: &[Collider],
    threads: usize,
) -> Simulation {
    let body = Body::builder(ball()).cell_size(1.0).skin(skin).volume(volume).build().unwrap();
    let scene = Simulation::builder().body(body).dt(1.0 / 60.0).threads(threads);
    let scene = colliders.iter().cloned().fold(scene, |scene, collider| scene.collider(collider));
    let mut simulation = scene.build().unwrap();
    place(&mut simulation, scale, 0.0);
    simulation
}

/// Sets the positions of a body to those at rest, scaled along y, with the lowest point of the ball at y = `height`.
fn place(simulation: &mut Simulation, scale: f64, height: f64) {
    let lattice = simulation.body(0).lattice();
    let rest = (0..lattice.len() as u32).map(|vertex| lattice.rest_position(vertex));
    let positions: Vec<_> = rest.map(|p| Point3::new(p.x, scale * (p.y + RADIUS) + height, p.z)).collect();
    simulation.body_mut(0).set_positions(&positions).unwrap();
}

fn ground() -> Collider {
    Collider::plane([0.0; 3], [0.0, 1.0, 0.0])
}

fn surface(simulation: &Simulation) -> Vec<Point3<f64>> {
    simulation.body(0).surface().positions
}

/// Returns the greatest distance between corresponding points.
fn greatest_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

const SKINS: [SkinKind; 2] = [SkinKind::Linear, SkinKind::Smooth];

#[test]
fn compressed_ball_lies_flat_on_the_ground() {
    // A compression of 0.3 closes gaps up to 0.225 cells, and has no effect from 15.5 times that on.
    let (scale, closed, reach) = (0.7, 0.22, 3.49);
    for skin in SKINS {
        let before = surface(&pressed(skin, VolumeOptions::off(), scale, &[], 1));
        let after = surface(&pressed(skin, VolumeOptions::off(), scale, &[ground()], 1));
        let lying = before.iter().zip(&after).filter(|(before, _)| before.y < closed);
        assert!(lying.clone().count() > 100, "{}", lying.count());
        for (before, after) in before.iter().zip(&after) {
            assert!(after.y >= -1e-6 && after.y <= before.y + 1e-6, "{skin:?}: {before} {after}");
            assert!(before.y >= closed || after.y < 1e-5, "{skin:?}: {before} {after}");
            assert!(before.y <= reach || before == after, "{skin:?}: {before} {after}");
            assert!((after.x, after.z) == (before.x, before.z), "{skin:?}: {before} {after}");
        }
    }
}

#[test]
fn uncompressed_or_distant_surface_is_displayed_as_it_is() {
    for (scale, height) in [(1.0, 0.0), (1.2, 0.0), (0.7, 0.52), (0.7, 2.0)] {
        for skin in SKINS {
            let [free, near] = [&[][..], &[ground()]].map(|colliders| {
                let mut simulation = pressed(skin, VolumeOptions::off(), 1.0, colliders, 1);
                place(&mut simulation, scale, height);
                surface(&simulation)
            });
            if height > 0.0 {
                assert_eq!(free, near, "{scale} {height} {skin:?}");
            }
            // The compression of a lattice at rest is a rounding error of its positions of up to 10 cells.
            let greatest = greatest_distance(&free, &near);
            assert!(greatest < 10.0 * f64::from(f32::EPSILON), "{scale} {height} {skin:?}: {greatest}");
        }
    }
}

#[test]
fn only_planes_flatten() {
    // The distance from a box is not linear beside its edges, nor that from a sheet on both sides.
    let sheet = Mesh::new(
        vec![[-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [9.0, 0.0, 9.0], [-9.0, 0.0, 9.0]],
        &[[0, 3, 2], [0, 2, 1]],
    );
    let others = [
        Collider::cuboid([0.0, -1.0, 0.0], [9.0, 1.0, 9.0], [0.0; 3]),
        Collider::cuboid([4.0, -1.0, 0.0], [4.0, 1.0, 9.0], [0.0; 3]),
        Collider::mesh(sheet.unwrap()).unwrap(),
    ];
    for (skin, scale) in SKINS.into_iter().flat_map(|skin| [1.0, 0.7].map(|scale| (skin, scale))) {
        let free = surface(&pressed(skin, VolumeOptions::off(), scale, &[], 1));
        for (index, other) in others.iter().enumerate() {
            let near = surface(&pressed(skin, VolumeOptions::off(), scale, std::slice::from_ref(other), 1));
            assert_eq!(free, near, "{skin:?} {scale} {index}");
        }
    }
}

#[test]
fn flattening_is_continuous() {
    let steps = 300;
    let at = |step: i32, [from, to]: [f64; 2]| from + (to - from) * f64::from(step) / f64::from(steps);
    // Pressed, lifted while pressed, and released while lifted.
    for (scales, heights) in [([1.0, 0.7], [0.0, 0.0]), ([0.7, 0.7], [0.0, 0.6]), ([0.7, 1.0], [0.2, 0.2])] {
        let options = VolumeOptions::off();
        let [mut simulation, mut free] =
            [&[ground()][..], &[]].map(|colliders| pressed(SkinKind::Linear, options, 1.0, colliders, 1));
        let mut previous: Option<[Vec<Point3<f64>>; 2]> = None;
        for step in 0..=steps {
            let present = [&mut simulation, &mut free].map(|simulation| {
                place(simulation, at(step, scales), at(step, heights));
                surface(simulation)
            });
            if let Some(previous) = &previous {
                let [moved, motion] = [0, 1].map(|k| greatest_distance(&previous[k], &present[k]));
                // The remaining gap has a derivative of at most 1.14 by the gap, and of at most 1.77 by the gap that is closed.
                // That changes by 0.75 times the change of the compression, which is 1/(2 RADIUS) times the motion of the top,
                // and by at most 0.3/0.5 times the motion of the body.
                let greatest = 1.14 + 1.77 * (0.75 / (2.0 * RADIUS) + 0.3 / 0.5);
                assert!(moved < greatest * motion + 1e-5, "{step}: {moved} {motion}");
            }
            previous = Some(present);
        }
    }
}

#[test]
fn flattened_surface_is_thread_count_independent() {
    for skin in SKINS {
        let [one, three] = [1, 3]
            .map(|threads| surface(&pressed(skin, VolumeOptions::default(), 0.7, &[ground()], threads)));
        assert_eq!(one, three, "{skin:?}");
    }
}

/// A ball between two plates that are pressed together, to 0.7 times its height.
fn between_plates(skin: SkinKind) -> Simulation {
    let body = Body::builder(ball()).cell_size(1.0).skin(skin).build().unwrap();
    let plate = |side: f64| {
        let end = Key { time: 0.5, translate: [0.0, -0.3 * RADIUS * side, 0.0], ..Key::default() };
        let keys = vec![Key::default(), end];
        Collider { keys, ..Collider::plane([0.0, RADIUS * side, 0.0], [0.0, -side, 0.0]) }
    };
    let scene = Simulation::builder().body(body).collider(plate(1.0)).collider(plate(-1.0));
    scene.gravity([0.0; 3]).fps(60.0).substeps(Substeps::Auto).threads(1).build().unwrap()
}

#[test]
fn surface_between_plates_is_flat_and_keeps_its_volume() {
    for skin in SKINS {
        let mut simulation = between_plates(skin);
        let (mut patch, mut lying) = (0, 0);
        for frame in 0..50 {
            simulation.advance(1);
            let report = simulation.body(0).volume_report();
            assert!(report.residual.abs() < 1e-6, "{skin:?} {frame}: {}", report.residual);
        }
        let points = surface(&simulation);
        for side in [-1.0, 1.0] {
            let gaps: Vec<f64> = points.iter().map(|p| 0.7 * RADIUS - side * p.y).collect();
            let touching: Vec<_> = points.iter().zip(&gaps).filter(|(_, gap)| **gap < 0.01).collect();
            assert!(touching.len() > 100, "{skin:?}: {}", touching.len());
            for (p, &distance) in points.iter().zip(&gaps) {
                // Depth of a vertex: contact samples of a smooth skin and its displayed surface differ by that.
                assert!(distance > -0.01, "{skin:?}: {distance}");
                // The contact is the convex hull of the touching points up to 2 cells around a point.
                let around = touching.iter().map(|(q, _)| [q.x - p.x, q.z - p.z]);
                let near = around.filter(|[x, z]| (1e-9..2.0).contains(&x.hypot(*z)));
                let mut angles: Vec<f64> = near.map(|[x, z]| z.atan2(x)).collect();
                angles.sort_by(f64::total_cmp);
                let Some(&first) = angles.first() else { continue };
                angles.push(first + TAU);
                if distance < 0.3 && angles.windows(2).all(|pair| pair[1] - pair[0] < PI) {
                    patch += 1;
                    lying += usize::from(distance.abs() < 0.01);
                }
            }
        }
        assert!(lying as f64 > 0.9 * f64::from(patch), "{skin:?}: {lying} of {patch}");
    }
}

#[test]
fn flattened_surface_takes_at_most_half_of_the_gap_to_another_body() {
    // A block on the ground below the side of the ball, which would move down by up to 0.3 cells there.
    let (low, high, top) = ([2.0, 0.0, -2.0], [5.0, 0.0, 2.0], 0.6);
    let corner = |k: usize| {
        let [x, z] = [k & 1, k >> 2 & 1].map(|bit| bit as f64);
        [low[0] + x * (high[0] - low[0]), if k & 2 == 0 { 0.0 } else { top }, low[2] + z * (high[2] - low[2])]
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let block = Mesh::new((0..8).map(corner).collect(), &quads).unwrap();
    for skin in SKINS {
        let [free, with, without] = [0, 1, 2].map(|case| {
            let body = Body::builder(ball()).cell_size(1.0).skin(skin).volume(VolumeOptions::off());
            let mut scene = Simulation::builder().body(body.build().unwrap()).threads(1);
            if case > 0 {
                scene = scene.collider(ground());
            }
            if case == 1 {
                scene = scene.body(Body::builder(block.clone()).cell_size(0.3).build().unwrap());
            }
            let mut simulation = scene.build().unwrap();
            place(&mut simulation, 0.7, 0.0);
            surface(&simulation)
        });
        let above = |p: &Point3<f64>| (low[0]..high[0]).contains(&p.x) && p.z.abs() < high[2];
        let mut greatest = [f64::NEG_INFINITY; 2];
        for ((free, with), without) in free.iter().zip(&with).zip(&without).filter(|((p, _), _)| above(p)) {
            let gap = free.y - top;
            if !(0.0..=1.0).contains(&gap) {
                continue;
            }
            // Beyond half of the vertical gap, which is at least the distance.
            let excess = |p: &Point3<f64>| free.y - p.y - gap / 2.0;
            greatest = [greatest[0].max(excess(with)), greatest[1].max(excess(without))];
            assert!(with.y >= without.y - 1e-6, "{skin:?}: {with} {without}");
        }
        // The tolerance of 0.01 cells along normals of up to 60 degrees from the vertical.
        assert!(greatest[0] <= 0.02 + 1e-6 && greatest[1] > 0.1, "{skin:?}: {greatest:?}");
    }
}

#[test]
fn volume_of_a_flattened_surface_is_kept_and_reported() {
    let mesh = ball();
    let volume = |points: &[Point3<f64>]| {
        let det = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|corner| points[corner as usize].coords);
            a.dot(&b.cross(&c))
        };
        mesh.triangles().iter().map(det).sum::<f64>() / 6.0
    };
    let rest = volume(mesh.vertices());
    for skin in SKINS {
        for scope in [VolumeScope::Global, VolumeScope::Regional] {
            let options = VolumeOptions { scope, ..VolumeOptions::default() };
            let simulation = pressed(skin, options, 0.7, &[ground()], 1);
            let (points, report) = (surface(&simulation), simulation.body(0).volume_report());
            let error = volume(&points) / rest - 1.0;
            assert!(error.abs() < 1e-6, "{skin:?} {scope:?}: {error}");
            assert!(report.residual.abs() < 1e-12, "{skin:?} {scope:?}: {}", report.residual);
            let by_mesh = report.by(VolumeMeasure::Mesh).unwrap();
            assert!((by_mesh.after / rest - 1.0).abs() < 1e-6, "{skin:?} {scope:?}: {by_mesh:?}");
            let lowest = points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            let lying = points.iter().filter(|p| p.y.abs() < 1e-5).count();
            assert!(lowest > -1e-4 && lying > 100, "{skin:?} {scope:?}: {lowest} {lying}");
        }
        // Without a correction, the report has the volume of the flattened surface.
        let simulation = pressed(skin, VolumeOptions::off(), 0.7, &[ground()], 1);
        let error = simulation.body(0).volume() / volume(&surface(&simulation)) - 1.0;
        assert!(error.abs() < 1e-6, "{skin:?}: {error}");
    }
}

#[test]
fn surface_in_a_valley_enters_neither_side() {
    for slope in [0.3, 1.0, 3.0] {
        let sides = [slope, -slope].map(|x| Collider::plane([0.0; 3], [x, 1.0, 0.0]));
        let depth = |points: &[Point3<f64>], side: &Collider| {
            let depths = points.iter().map(|&p| -side.shape.signed_distance(p.into()).distance);
            depths.fold(f64::NEG_INFINITY, f64::max)
        };
        let mut simulation = pressed(SkinKind::Linear, VolumeOptions::off(), 1.0, &sides, 1);
        // The ball touches both sides before it is scaled about its center.
        let center = RADIUS * slope.hypot(1.0);
        let mut free = pressed(SkinKind::Linear, VolumeOptions::off(), 1.0, &[], 1);
        for scale in [1.0, 0.9, 0.8] {
            let height = center - scale * RADIUS - (1.0 - scale) * RADIUS;
            let [points, before] = [&mut simulation, &mut free].map(|simulation| {
                place(simulation, scale, height);
                surface(simulation)
            });
            for side in &sides {
                let [with, without] = [&points, &before].map(|points| depth(points, side));
                // Displacements may enter a collider by 0.01 cells, so that they are continuous.
                assert!(with < without.max(0.0) + 0.01 + 1e-5, "{slope} {scale}: {with} {without}");
            }
        }
    }
}
