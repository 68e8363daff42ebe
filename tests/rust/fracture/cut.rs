//! Cuts of meshes along the broken joints of lattices: closed pieces, the same volume, smooth caps.

use std::collections::BTreeSet;

use nalgebra::{Point3, Rotation3, Vector3};
use supple::{
    Body, BrokenJoint, CrackPlane, CutMesh, CutSurface, FaceSource, Lattice, LatticeOptions, Mesh, Origin,
    Resolution, Simulation, VolumeMeasure, cut,
};
use supple_tests::{bust, grid_box, mesh_of, torus};

/// Returns a closed box with a corner at the origin. Its six sides, of `n` x `n` quads each, share no vertices.
pub(crate) fn sides_box(size: [f64; 3], n: u32) -> Mesh {
    mesh_of(grid_box([0.0; 3], size, [n; 3]))
}

fn lattice(mesh: &Mesh, vertices: usize) -> Lattice {
    let options = LatticeOptions { resolution: Resolution::Vertices(vertices), ..LatticeOptions::default() };
    Lattice::from_mesh(mesh, &options).unwrap()
}

/// Returns the joints between cells on opposite sides of each plane, where `is_broken` accepts the middle of the joint.
fn joints(
    lattice: &Lattice,
    planes: &[CrackPlane],
    is_broken: impl Fn(&Point3<f64>) -> bool,
) -> Vec<BrokenJoint> {
    let center = |index: [i32; 3]| {
        lattice.origin() + Vector3::from(index.map(|x| f64::from(x) + 0.5)) * lattice.cell_size()
    };
    let mut joints = Vec::new();
    for (cell, &index) in lattice.cells().iter().enumerate() {
        for axis in 0..3 {
            let mut next = index;
            next[axis] += 1;
            if lattice.cell_at(next).is_none() {
                continue;
            }
            let (a, b) = (center(index), center(next));
            let crosses =
                |plane: &CrackPlane| plane.is_positive(lattice, index) != plane.is_positive(lattice, next);
            let crack = (0..planes.len()).find(|&n| crosses(&planes[n]));
            let crack = crack.filter(|_| is_broken(&nalgebra::center(&a, &b)));
            if let Some(crack) = crack {
                joints.push(BrokenJoint { cell: cell as u32, axis: axis as u8, crack: crack as u32 });
            }
        }
    }
    joints
}

/// Checks that the pieces are closed, keep the volume, and are described.
fn check(name: &str, mesh: &Mesh, lattice: &Lattice, pieces: &CutMesh) {
    let (before, after) = (mesh.topology(), pieces.mesh.topology());
    assert_eq!(after.open_edges, before.open_edges, "{name}: open edges");
    assert_eq!(pieces.unclosed_faces, 0, "{name}");
    let volume = pieces.mesh.signed_volume();
    assert!((volume / mesh.signed_volume() - 1.0).abs() < 1e-12, "{name}: {volume} {}", mesh.signed_volume());
    let count = pieces.mesh.vertices().len();
    assert_eq!(pieces.mesh.vertices()[..mesh.vertices().len()], *mesh.vertices());
    assert_eq!((pieces.hosts.len(), pieces.origins.len()), (count, count));
    assert!(pieces.hosts.iter().all(|&host| (host as usize) < lattice.cells().len()));
    assert_eq!(pieces.face_sources.len(), pieces.mesh.face_count());
    for (vertex, origin) in pieces.origins.iter().enumerate() {
        let at = |vertex: u32| mesh.vertices()[vertex as usize];
        let expected = match *origin {
            Origin::Vertex(vertex) => at(vertex),
            Origin::Edge { vertices: [a, b], t } => at(a) + (at(b) - at(a)) * t,
            Origin::Face { vertices, weights } => {
                let sum: Vector3<f64> = (0..3).map(|c| at(vertices[c]).coords * weights[c]).sum();
                sum.into()
            }
            Origin::Cap { .. } => continue,
        };
        let error = (pieces.mesh.vertices()[vertex] - expected).norm();
        assert!(error < 1e-9 * lattice.cell_size(), "{name}: vertex {vertex} {origin:?} is off by {error}");
    }
}

/// Returns the number of faces whose vertices follow cells on different sides of a plane.
fn faces_across(lattice: &Lattice, planes: &[CrackPlane], pieces: &CutMesh) -> usize {
    let is_across = |face: &&[u32]| {
        let side = |plane: &CrackPlane, vertex: u32| {
            plane.is_positive(lattice, lattice.cells()[pieces.hosts[vertex as usize] as usize])
        };
        planes.iter().any(|plane| face.iter().any(|&v| side(plane, v) != side(plane, face[0])))
    };
    pieces.mesh.faces().filter(is_across).count()
}

/// Returns the greatest distance of a vertex of a cap from the plane of its crack, in cells.
fn farthest(lattice: &Lattice, planes: &[CrackPlane], pieces: &CutMesh) -> f64 {
    let mut farthest: f64 = 0.0;
    for (face, source) in pieces.mesh.faces().zip(&pieces.face_sources) {
        let FaceSource::Cap { crack } = source else { continue };
        let CrackPlane { point, normal } = planes[*crack as usize];
        for &corner in face {
            let position = pieces.mesh.vertices()[corner as usize];
            farthest = farthest.max(normal.normalize().dot(&(position - point)).abs());
        }
    }
    farthest / lattice.cell_size()
}

fn meshes() -> Vec<(&'static str, Mesh, Lattice)> {
    let shapes = [
        ("box", sides_box([2.0, 1.0, 1.0], 2)),
        ("fine box", sides_box([1.0; 3], 30)),
        ("ball", supple_tests::ball(1.0)),
        ("torus", torus(0.4, 40, 20)),
        ("bust", bust()),
    ];
    let with_lattice = |(name, mesh)| {
        let lattice = lattice(&mesh, 1000);
        (name, mesh, lattice)
    };
    shapes.map(with_lattice).into()
}

/// Returns a plane through the middle of a mesh. `aligned`: whether its normal is an axis.
fn random_plane(random: &mut fastrand::Rng, mesh: &Mesh, aligned: bool) -> CrackPlane {
    let (low, high) = mesh.bounds();
    let mut at = || 0.3 + 0.4 * random.f64();
    let point = Point3::from(std::array::from_fn::<_, 3, _>(|a| low[a] + at() * (high[a] - low[a])));
    let normal = if aligned {
        Vector3::ith(random.usize(..3), 1.0)
    } else {
        Vector3::from_fn(|_, _| 2.0 * random.f64() - 1.0)
    };
    CrackPlane { point, normal }
}

#[test]
fn pieces_of_random_cracks_are_closed_and_keep_the_volume() {
    for (name, mesh, lattice) in meshes() {
        let mut random = fastrand::Rng::with_seed(7);
        for n in 0..50 {
            let count = 1 + n % 3;
            let planes: Vec<_> = (0..count).map(|_| random_plane(&mut random, &mesh, n % 5 == 0)).collect();
            // Half of the cases break one side of another plane only.
            let is_partial = n % 2 == 1;
            let half = random_plane(&mut random, &mesh, false);
            let is_broken = |p: &Point3<f64>| !is_partial || half.normal.dot(&(p - half.point)) > 0.0;
            let joints = joints(&lattice, &planes, is_broken);
            for surface in [CutSurface::Cells, CutSurface::Smooth] {
                let name = format!("{name}, case {n}, {surface:?}");
                let pieces = cut(&mesh, &lattice, &joints, &planes, surface).unwrap();
                check(&name, &mesh, &lattice, &pieces);
                if !is_partial {
                    // Where several cracks meet there can be wedges without a cell on their side of all planes.
                    let most = if count == 1 || surface == CutSurface::Cells {
                        0
                    } else {
                        pieces.mesh.face_count() / 50
                    };
                    let across = faces_across(&lattice, &planes, &pieces);
                    assert!(across <= most, "{name}: {across}");
                }
                if planes.len() == 1 && surface == CutSurface::Smooth {
                    // A vertex of the mesh within the rounding of the grid, 1e-5 cells, counts as in the plane.
                    let farthest = farthest(&lattice, &planes, &pieces);
                    assert!(farthest <= 1e-4, "{name}: {farthest}");
                }
            }
        }
    }
}

/// The vertices of the box lie in planes of the grid. The two cracks have random sizes and places, and may cross each
/// other.
#[test]
fn pieces_of_a_mesh_in_planes_of_the_grid_are_closed() {
    let mesh = supple_tests::cuboid([6, 4, 4]);
    let options = LatticeOptions { resolution: Resolution::CellSize(0.5), ..LatticeOptions::default() };
    let lattice = Lattice::from_mesh(&mesh, &options).unwrap();
    let mut random = fastrand::Rng::with_seed(3);
    for n in 0..100 {
        let mut joints: Vec<BrokenJoint> = Vec::new();
        let mut planes = Vec::new();
        for crack in 0..2 {
            let place = [6.0, 4.0, 4.0].map(|size| (2.0 * size * random.f64()).floor() / 2.0 + 0.25);
            let normal = Vector3::from_fn(|_, _| random.f64() - 0.5);
            let plane = CrackPlane { point: place.into(), normal };
            let radius = 0.5 + 3.0 * random.f64();
            let is_broken = |p: &Point3<f64>| (p - plane.point).norm() <= radius;
            let is_new = |joint: &BrokenJoint| {
                !joints.iter().any(|other| (other.cell, other.axis) == (joint.cell, joint.axis))
            };
            let found = self::joints(&lattice, &[plane], is_broken).into_iter();
            let found: Vec<_> = found.filter(is_new).map(|joint| BrokenJoint { crack, ..joint }).collect();
            joints.extend(found);
            planes.push(plane);
        }
        joints.sort_unstable();
        for surface in [CutSurface::Cells, CutSurface::Smooth] {
            let pieces = cut(&mesh, &lattice, &joints, &planes, surface).unwrap();
            check(&format!("case {n}, {surface:?}"), &mesh, &lattice, &pieces);
        }
    }
}

#[test]
fn pieces_of_crossing_cracks_are_separate() {
    let mesh = sides_box([2.0; 3], 3);
    let lattice = supple_tests::lattice_of(&mesh, 0.226, true);
    let plane = |normal: [f64; 3]| CrackPlane { point: Point3::new(1.05, 0.95, 1.1), normal: normal.into() };
    for (planes, expected) in [
        (vec![plane([1.0, 0.0, 0.0])], 2),
        (vec![plane([1.0, 0.4, 0.3])], 2),
        (vec![plane([1.0, 0.0, 0.0]), plane([0.0, 1.0, 0.0])], 4),
        (vec![plane([1.0, 0.2, 0.3]), plane([-0.3, 1.0, 0.2]), plane([0.1, -0.3, 1.0])], 8),
    ] {
        let joints = joints(&lattice, &planes, |_| true);
        for surface in [CutSurface::Cells, CutSurface::Smooth] {
            let pieces = cut(&mesh, &lattice, &joints, &planes, surface).unwrap();
            check(&format!("{planes:?}"), &mesh, &lattice, &pieces);
            let components = &pieces.mesh.topology().components;
            assert_eq!(components.len(), expected, "{planes:?} {surface:?}");
            assert!(components.iter().all(|piece| piece.closed && piece.signed_volume > 0.0));
        }
    }
}

#[test]
fn a_slit_leaves_one_piece_that_shares_its_front() {
    let mesh = sides_box([2.0; 3], 5);
    let lattice = lattice(&mesh, 1000);
    let planes = [CrackPlane { point: Point3::new(1.0, 1.0, 1.0), normal: Vector3::new(0.2, 1.0, 0.1) }];
    let joints = joints(&lattice, &planes, |p| p.x < 0.9);
    for surface in [CutSurface::Cells, CutSurface::Smooth] {
        let pieces = cut(&mesh, &lattice, &joints, &planes, surface).unwrap();
        check("slit", &mesh, &lattice, &pieces);
        assert_eq!(pieces.mesh.topology().components.len(), 1, "{surface:?}");
        let caps = pieces.face_sources.iter().filter(|source| matches!(source, FaceSource::Cap { .. }));
        assert!(caps.count() >= 2 * joints.len(), "{surface:?}");
    }
}

#[test]
fn cuts_of_nothing_change_nothing() {
    let mesh = sides_box([2.0, 1.0, 1.0], 4);
    let lattice = lattice(&mesh, 300);
    let pieces = cut(&mesh, &lattice, &[], &[], CutSurface::Smooth).unwrap();
    assert!(pieces.mesh.faces().eq(mesh.faces()) && pieces.mesh.vertices() == mesh.vertices());
    assert!(pieces.face_sources.iter().zip(0..).all(|(source, face)| *source == FaceSource::Whole(face)));
    let embedding = supple::internals::Embedding::new(&lattice, mesh.vertices());
    assert!(pieces.hosts.iter().enumerate().all(|(vertex, &host)| host == embedding.cell(vertex)));
}

#[test]
fn open_inside_out_and_crumpled_meshes_are_cut_without_panic() {
    let mut random = fastrand::Rng::with_seed(3);
    for n in 0..40 {
        let ball = supple_tests::ball(1.0);
        let mut vertices: Vec<[f64; 3]> = ball.vertices().iter().map(|&vertex| vertex.into()).collect();
        let mut faces: Vec<Vec<u32>> = ball.faces().map(<[u32]>::to_vec).collect();
        match n % 4 {
            0 => faces.truncate(faces.len() / 2),
            1 => faces.iter_mut().for_each(|face| face.reverse()),
            2 => vertices.iter_mut().flatten().for_each(|x| *x += 0.5 * random.f64()),
            _ => faces.retain(|_| random.u8(..4) > 0),
        }
        let mesh = Mesh::new(vertices, &faces).unwrap();
        let lattice = lattice(&mesh, 500);
        let planes = [random_plane(&mut random, &mesh, n % 3 == 0), random_plane(&mut random, &mesh, false)];
        let joints = joints(&lattice, &planes, |_| true);
        for surface in [CutSurface::Cells, CutSurface::Smooth] {
            let pieces = cut(&mesh, &lattice, &joints, &planes, surface).unwrap();
            if n % 4 == 1 {
                check("inside out", &mesh, &lattice, &pieces);
            }
        }
    }
}

#[test]
fn cuts_have_the_same_bits_each_time() {
    let mesh = bust();
    let lattice = lattice(&mesh, 800);
    let mut random = fastrand::Rng::with_seed(1);
    let planes = [random_plane(&mut random, &mesh, false), random_plane(&mut random, &mesh, false)];
    let joints = joints(&lattice, &planes, |_| true);
    let run = || cut(&mesh, &lattice, &joints, &planes, CutSurface::Smooth).unwrap();
    let (a, b) = (run(), run());
    assert!(a.mesh.vertices() == b.mesh.vertices() && a.mesh.faces().eq(b.mesh.faces()));
    assert!(a.hosts == b.hosts && a.cap_uvs == b.cap_uvs && a.mesh.weld() == b.mesh.weld());
}

/// Returns an extruded L, whose caps are concave hexagons that begin at the corner `first`, turned by a rotation.
fn angle(first: usize, turn: Rotation3<f64>) -> Mesh {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let at = |z: f64| corners.map(|[x, y]| (turn * Point3::new(x, y, z)).into());
    let vertices: Vec<[f64; 3]> = [at(0.0), at(1.0)].concat();
    let around = |n: u32| (n + first as u32) % 6;
    let mut faces = vec![(0..6).map(|n| around(5 - n)).collect(), (0..6).map(|n| 6 + around(n)).collect()];
    faces.extend((0..6).map(|n| vec![n, (n + 1) % 6, 6 + (n + 1) % 6, 6 + n]));
    Mesh::new(vertices, &faces).unwrap()
}

#[test]
fn parts_of_concave_faces_lie_inside_of_them() {
    let mut random = fastrand::Rng::with_seed(11);
    for n in 0..36 {
        let turn = match n % 2 {
            0 => Rotation3::identity(),
            _ => Rotation3::new(Vector3::from_fn(|_, _| 6.0 * random.f64() - 3.0)),
        };
        let mesh = angle(n / 2 % 6, turn);
        let lattice = lattice(&mesh, 600);
        let normal = turn * Vector3::from_fn(|_, _| 2.0 * random.f64() - 1.0);
        let point = turn * Point3::new(0.4 + 0.3 * random.f64(), 0.4 + 0.3 * random.f64(), 0.5);
        let planes = [CrackPlane { point, normal }];
        let joints = joints(&lattice, &planes, |_| true);
        for surface in [CutSurface::Cells, CutSurface::Smooth] {
            let name = format!("case {n}, {surface:?}");
            let pieces = cut(&mesh, &lattice, &joints, &planes, surface).unwrap();
            check(&name, &mesh, &lattice, &pieces);
            let (mut parts, mut turned) = (0, 0.0);
            // The rim of a smooth cut can be folded over a part of a cell.
            let size = if surface == CutSurface::Smooth { lattice.cell_size() } else { 1e-6 };
            for (face, source) in pieces.mesh.faces().zip(&pieces.face_sources) {
                let FaceSource::Part(whole) = *source else { continue };
                // The caps of the L come first, at z = 0 and z = 1.
                let normal = match whole {
                    0 => turn * -Vector3::z(),
                    1 => turn * Vector3::z(),
                    _ => continue,
                };
                let [a, b, c] = [face[0], face[1], face[2]].map(|v| pieces.mesh.vertices()[v as usize]);
                let area = (b - a).cross(&(c - a)).dot(&normal);
                turned += (-area).max(0.0);
                let center = turn.inverse() * nalgebra::center(&a, &nalgebra::center(&b, &c));
                let is_inside = center.x.min(center.y) < 1.0 + size;
                assert!(is_inside, "{name}: a part of face {whole} is outside: {center}");
                parts += 1;
            }
            assert!(parts > 0 && turned <= size * size, "{name}: parts are turned over: {turned}");
        }
    }
}

/// Returns a mesh in which vertices at one position are one vertex.
fn without_seams(mesh: &Mesh) -> Mesh {
    let mut numbers = vec![u32::MAX; mesh.vertices().len()];
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for (vertex, &welded) in mesh.weld().iter().enumerate() {
        if welded as usize == vertex {
            numbers[vertex] = vertices.len() as u32;
            vertices.push(mesh.vertices()[vertex].into());
        }
    }
    let number = |&vertex: &u32| numbers[mesh.weld()[vertex as usize] as usize];
    let faces: Vec<Vec<u32>> = mesh.faces().map(|face| face.iter().map(number).collect()).collect();
    Mesh::new(vertices, &faces).unwrap()
}

/// Returns the position of each mesh vertex of a body, rounded, with its piece.
fn pieces_by_position(body: &Body) -> BTreeSet<([i64; 3], u32)> {
    let (mesh, piece) = (body.mesh().unwrap(), body.piece_of_mesh_vertices().unwrap());
    let rounded = |point: &Point3<f64>| point.coords.map(|x| (x * 1e6).round() as i64).into();
    mesh.vertices().iter().map(rounded).zip(piece).collect()
}

/// The six sides of the box share no vertices: their edges are welded. Its pieces are those of a box without seams, also
/// where the vertices beside a sliver of the lattice follow the piece of their shell.
#[test]
fn pieces_of_a_body_with_seams_are_those_of_one_without() {
    for (lattice_vertices, seed) in [(200, 0), (300, 1), (600, 2)] {
        let with_seams = sides_box([2.0, 1.0, 1.0], 5);
        let [mut with, mut without] = [with_seams.clone(), without_seams(&with_seams)].map(|mesh| {
            let body = Body::builder(mesh).lattice_vertices(lattice_vertices).volume(VolumeMeasure::Mesh);
            Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).build().unwrap()
        });
        let mut random = fastrand::Rng::with_seed(seed);
        for n in 0..5 {
            let point = [0.6 + 0.8 * random.f64(), 0.3 + 0.4 * random.f64(), 0.3 + 0.4 * random.f64()];
            let normal = std::array::from_fn(|_| 2.0 * random.f64() - 1.0);
            let name = format!("{lattice_vertices} vertices, cut {n}");
            for simulation in [&mut with, &mut without] {
                simulation.body_mut(0).cut(point, normal).unwrap();
                assert!(simulation.bodies()[0].mesh().unwrap().is_closed(), "{name}");
            }
            let [a, b] = [&with, &without].map(|simulation| pieces_by_position(&simulation.bodies()[0]));
            assert!(a == b, "{name}: a vertex follows another piece");
            let [a, b] = [&with, &without].map(|simulation| simulation.body(0).volume_report());
            assert_eq!([a.measure, b.measure], [VolumeMeasure::Mesh; 2], "{name}");
            for (a, b) in a.components.iter().zip(&b.components) {
                assert!((a.rest - b.rest).abs() < 1e-9, "{name}: {} {}", a.rest, b.rest);
                assert!(a.residual.abs() <= 1e-6, "{name}: {a:?}");
            }
        }
    }
}
