//! Cells, lattices, meshes and bodies.

use crate::random::Random;
use nalgebra::Point3;
use supple::{
    Body, BodyBuilder, HalfWidth, Handle, Key, Lattice, LatticeOptions, Material, Mesh, Pin, Resolution,
    Selection, Simulation, TimeWindow,
};

/// Returns the cells of a box with its lowest cell at [0, 0, 0].
pub fn block(size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect()
}

/// Returns the cells of a box with its lowest cell at `low`.
pub fn block_at(low: [i32; 3], size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nx * ny * nz).map(|i| [low[0] + i % nx, low[1] + i / nx % ny, low[2] + i / nx / ny]).collect()
}

/// Returns a torus around the z axis of the radius 1, with a tube of the radius `tube`: `around` x `across` quads.
pub fn torus(tube: f64, around: u32, across: u32) -> Mesh {
    let angle = |k: u32, n: u32| f64::from(k) / f64::from(n) * std::f64::consts::TAU;
    let vertices = (0..around * across).map(|k| {
        let (a, b) = (angle(k / across, around), angle(k % across, across));
        let radius = 1.0 + tube * b.cos();
        [radius * a.cos(), radius * a.sin(), tube * b.sin()]
    });
    let at = |i: u32, j: u32| i % around * across + j % across;
    let faces: Vec<_> = (0..around * across)
        .map(|k| (k / across, k % across))
        .map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
        .collect();
    Mesh::new(vertices.collect(), &faces).unwrap()
}

/// Returns the mesh of a cuboid of unit cells: a quad for each face of a cell on its surface.
pub fn cuboid(size: [i32; 3]) -> Mesh {
    let (vertices, quads) = surface_of(&block(size));
    Mesh::new(vertices, &quads).unwrap()
}

/// Returns a square sheet in the plane y = 0, with edges of twice `half`, of `n` × `n` faces.
pub fn square_sheet(half: f64, n: u32) -> Mesh {
    let at = |k: u32| half * (2.0 * f64::from(k) / f64::from(n) - 1.0);
    let vertices = (0..(n + 1) * (n + 1)).map(|k| [at(k % (n + 1)), 0.0, at(k / (n + 1))]).collect();
    let quad = |k: u32| {
        let a = k / n * (n + 1) + k % n;
        [a, a + n + 1, a + n + 2, a + 1]
    };
    Mesh::new(vertices, &(0..n * n).map(quad).collect::<Vec<_>>()).unwrap()
}

/// Returns a sphere: the six faces of a cube, of `n` x `n` quads each, projected to a radius. The six faces
/// share no vertices.
pub fn sphere(center: [f64; 3], radius: f64, n: i32) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { -1 } else { 1 });
        let first = vertices.len() as u32;
        for k in 0..(n + 1) * (n + 1) {
            let mut p = [0; 3];
            p[axis] = sign * n;
            p[(axis + 1) % 3] = 2 * (k % (n + 1)) - n;
            p[(axis + 2) % 3] = 2 * (k / (n + 1)) - n;
            let p = p.map(f64::from);
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            vertices.push(std::array::from_fn(|a| center[a] + radius * p[a] / length));
        }
        for k in 0..n * n {
            let a = first + (k / n * (n + 1) + k % n) as u32;
            let [b, c, d] = [a + 1, a + n as u32 + 2, a + n as u32 + 1];
            faces.push(if sign > 0 { vec![a, b, c, d] } else { vec![a, d, c, b] });
        }
    }
    (vertices, faces)
}

/// Returns a sphere whose center is not the origin.
pub fn ball(radius: f64) -> Mesh {
    mesh_of(sphere([0.3, -0.2, 0.1], radius, 12))
}

/// Returns the mesh of vertices and faces.
pub fn mesh_of((vertices, faces): (Vec<[f64; 3]>, Vec<Vec<u32>>)) -> Mesh {
    Mesh::new(vertices, &faces).expect("a mesh")
}

/// Returns a box of eight vertices and six quads that face outwards. The
/// faces are those at the lowest and highest z, y and x.
pub fn plain_box(low: [f64; 3], high: [f64; 3]) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let corner = |k: u32| std::array::from_fn(|a| if k >> a & 1 == 0 { low[a] } else { high[a] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), faces.map(|face| face.to_vec()).to_vec())
}

/// Returns the cube [0, 1]^3 of eight vertices and six quads that face outwards.
pub fn unit_cube() -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    plain_box([0.0; 3], [1.0; 3])
}

/// Returns a box whose sides are grids of quads that face outwards, `counts` of them along each axis. The six
/// sides share no vertices.
pub fn grid_box(low: [f64; 3], high: [f64; 3], counts: [u32; 3]) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (axis, side) in (0..6).map(|k| (k / 2, k % 2)) {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let first = vertices.len() as u32;
        for (i, j) in (0..=counts[v]).flat_map(|j| (0..=counts[u]).map(move |i| (i, j))) {
            let mut p = if side == 0 { low } else { high };
            p[u] = low[u] + (high[u] - low[u]) * f64::from(i) / f64::from(counts[u]);
            p[v] = low[v] + (high[v] - low[v]) * f64::from(j) / f64::from(counts[v]);
            vertices.push(p);
        }
        for (i, j) in (0..counts[v]).flat_map(|j| (0..counts[u]).map(move |i| (i, j))) {
            let a = first + j * (counts[u] + 1) + i;
            let [b, c, d] = [a + 1, a + counts[u] + 2, a + counts[u] + 1];
            faces.push(if side == 1 { vec![a, b, c, d] } else { vec![a, d, c, b] });
        }
    }
    (vertices, faces)
}

/// Returns the boundary surface of cells of edge 1: its vertices, and quads that face outwards.
pub fn surface_of(cells: &[[i32; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let occupied: std::collections::BTreeSet<_> = cells.iter().copied().collect();
    let mut numbers = std::collections::BTreeMap::new();
    let (mut vertices, mut quads) = (Vec::new(), Vec::new());
    for cell in cells {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = *cell;
                beyond[axis] += 2 * side - 1;
                if occupied.contains(&beyond) {
                    continue;
                }
                let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut at = *cell;
                    at[axis] += side;
                    at[(axis + 1) % 3] += u;
                    at[(axis + 2) % 3] += v;
                    *numbers.entry(at).or_insert_with(|| {
                        vertices.push(at.map(f64::from));
                        vertices.len() as u32 - 1
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
    }
    (vertices, quads)
}

/// Pins a body below `low`, moves its part above `high` by `distance` along `axis` in one second, and returns
/// the simulation after `steps` steps.
pub fn pull_apart(
    body: BodyBuilder,
    axis: usize,
    [low, high]: [f64; 2],
    distance: f64,
    steps: u64,
) -> Simulation {
    let along = |x: f64| {
        let mut vector = [0.0; 3];
        vector[axis] = x;
        vector
    };
    let beyond = |at: f64, side: f64| Selection::Plane { point: along(at), normal: along(side) };
    let key = |time, distance| Key { time, translate: along(distance), rotate: [0.0; 3] };
    let keys = vec![key(0.0, 0.0), key(1.0, distance)];
    let body = body
        .pin(Pin { goal: None, selection: beyond(low, -1.0), window: TimeWindow::default() })
        .handle(Handle {
            goal: None,
            selection: beyond(high, 1.0),
            motion: keys.into(),
            window: TimeWindow::default(),
        });
    let simulation = Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]);
    let mut simulation = simulation.build().unwrap();
    simulation.steps(steps);
    simulation
}

/// Returns the lattice of a mesh with a cell size.
pub fn lattice_of(mesh: &Mesh, cell_size: f64, join: bool) -> Lattice {
    let resolution = Resolution::CellSize(cell_size);
    Lattice::from_mesh(mesh, &LatticeOptions { resolution, join, ..LatticeOptions::default() })
        .expect("a lattice")
}

/// Returns a lattice of cells of edge 1 with its origin at zero, without bridges between floating parts.
pub fn lattice(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), false).unwrap()
}

/// Returns a block of 4 x 3 x 2 cells of edge 0.5 with its lowest corner at (1, 2, 3).
pub fn half_cells() -> Lattice {
    let cells = block([4, 3, 2]);
    Lattice::from_cells(&cells, 0.5, Point3::new(1.0, 2.0, 3.0), true).unwrap()
}

/// Returns a simulation of one body without gravity, in steps of 0.01 s, on one thread.
pub fn without_gravity(body: Body) -> Simulation {
    Simulation::builder().body(body).gravity([0.0; 3]).dt(0.01).threads(1).build().unwrap()
}

/// Returns lattices of difficult shapes (thin, concave, sparse, far from index 0) with their names.
pub fn difficult_lattices() -> Vec<(&'static str, Lattice)> {
    let u_shape: Vec<_> = block([9, 7, 2]).into_iter().filter(|c| c[1] < 2 || c[0] < 3 || c[0] > 3).collect();
    let mut random = Random(7);
    let mut sparse = |size: [i32; 3], share: f64| {
        block(size).into_iter().filter(|_| random.unit() < share).collect::<Vec<_>>()
    };
    vec![
        ("single cell", lattice(&block([1, 1, 1]))),
        ("box", lattice(&block([6, 5, 7]))),
        ("long box", lattice(&block([21, 4, 3]))),
        ("rod in x", lattice(&block([40, 1, 1]))),
        ("rod in y", lattice(&block([1, 40, 1]))),
        ("rod in z", lattice(&block([1, 1, 40]))),
        ("sheet", lattice(&block([1, 14, 17]))),
        ("u", lattice(&u_shape)),
        ("random cells", lattice(&sparse([9, 8, 7], 0.35))),
        ("more random cells", lattice(&sparse([12, 10, 9], 0.6))),
        ("random cells far from zero", {
            let cells: Vec<_> =
                sparse([10, 7, 6], 0.5).into_iter().map(|c| [c[0] - 1003, c[1] + 517, c[2] - 88]).collect();
            lattice(&cells)
        }),
    ]
}

/// Returns a body of a bare lattice with regions of half-width `half_width` and default settings.
pub fn bare(lattice: &Lattice, half_width: impl Into<HalfWidth>) -> Body {
    Body::from_lattice(lattice.clone()).material(Material::fast_lsm()).half_width(half_width).build().unwrap()
}
