//! A plain voxelization on dense arrays, against which [`voxelize`](mod@super::voxelize) is tested.

use super::grid::Grid;
use super::grid_set::GridSet;
use super::triangle_box::TriangleAxes;
use super::voxelize::{Maxima, TooMany, voxelize};
use crate::mesh::{Mesh, signed_volume};

/// One flag for each cell of a grid and of a margin of one cell around it.
#[derive(Clone)]
struct Flags {
    size: [usize; 3],
    flags: Vec<bool>,
}

impl Flags {
    fn new(grid: &Grid) -> Self {
        let size = grid.size.map(|n| n + 2);
        Self { size, flags: vec![false; size.iter().product()] }
    }

    /// Returns the index of a cell, if it is in the grid or the margin.
    fn index(&self, cell: [i32; 3]) -> Option<usize> {
        let [x, y, z] = cell.map(|i| (i + 1) as usize);
        let [nx, ny, nz] = self.size;
        (x < nx && y < ny && z < nz).then(|| (z * ny + y) * nx + x)
    }

    fn has(&self, cell: [i32; 3]) -> bool {
        self.index(cell).is_some_and(|index| self.flags[index])
    }

    fn set(&mut self, cell: [i32; 3]) {
        let index = self.index(cell).expect("a cell of the grid or the margin");
        self.flags[index] = true;
    }

    /// Returns the cells of the grid and the margin for which `condition` is true, in order.
    fn cells(&self, condition: impl Fn([i32; 3]) -> bool) -> Vec<[i32; 3]> {
        let [nx, ny, nz] = self.size.map(|n| n as i32 - 1);
        let all = (-1..nz).flat_map(|z| (-1..ny).flat_map(move |y| (-1..nx).map(move |x| [x, y, z])));
        all.filter(|cell| condition(*cell)).collect()
    }
}

/// Returns the cells that a surface passes through or encloses, and the number of the cells that it passes through.
fn reference(mesh: &Mesh, grid: &Grid) -> (GridSet, usize) {
    let positions: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| grid.cell_space(vertex)).collect();
    let mut entered = Flags::new(grid);
    // For each axis, the faces of triangles whose normal points up and down the axis.
    let mut faces = [0, 1, 2].map(|_| [Flags::new(grid), Flags::new(grid)]);
    let mut has_faces = false;
    let mut untraced = Vec::new();
    for triangle in mesh.triangles() {
        let corners @ [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let mut low: [i32; 3] = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]).floor() as i32);
        let mut high: [i32; 3] = std::array::from_fn(|k| a[k].max(b[k]).max(c[k]).ceil() as i32);
        let flat: Vec<usize> = (0..3).filter(|&k| low[k] == high[k]).collect();
        if flat.len() > 1 {
            untraced.extend(corners);
            continue;
        }
        let mut target = &mut entered;
        let mut step = [1; 3];
        if let [axis] = flat[..] {
            low[axis] -= 1;
            high[axis] += 1;
            step[axis] = 2;
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
            target = &mut faces[axis][usize::from(area < 0.0)];
            has_faces = true;
        }
        let is_one_box = (0..3).all(|k| high[k] - low[k] == step[k]);
        let axes = TriangleAxes::new(&corners);
        let mut is_traced = false;
        let range = |k: usize| (low[k]..high[k]).step_by(step[k] as usize);
        for (x, y, z) in range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| (x, y, z)))) {
            let end: [i32; 3] = std::array::from_fn(|k| [x, y, z][k] + step[k]);
            if is_one_box || axes.enters([x, y, z].map(f64::from), end.map(f64::from)) {
                target.set(end.map(|i| i - 1));
                is_traced = true;
            }
        }
        if !is_traced {
            untraced.extend(corners);
        }
    }

    let mut outside = Flags::new(grid);
    let mut stack = vec![[-1; 3]];
    outside.set([-1; 3]);
    while let Some(cell) = stack.pop() {
        for (axis, step) in (0..3).flat_map(|axis| [(axis, -1), (axis, 1)]) {
            let mut next = cell;
            next[axis] += step;
            let upper = if step > 0 { next } else { cell };
            let is_wall = entered.has(next) || faces[axis].iter().any(|side| side.has(upper));
            if outside.index(next).is_some() && !is_wall && !outside.has(next) {
                outside.set(next);
                stack.push(next);
            }
        }
    }

    if let Some(solid) = mesh.open_surface().and_then(|open| open.solid.as_ref()) {
        for cell in entered.cells(|cell| grid.contains(cell) && !entered.has(cell)) {
            let index = outside.index(cell).expect("a cell of the grid");
            outside.flags[index] &= !solid.encloses(&grid.center_of(cell));
        }
    }

    let center = nalgebra::Vector3::from(grid.size.map(|n| 0.5 * n as f64));
    let volume = signed_volume(mesh.triangles(), |vertex| {
        nalgebra::Vector3::from(positions[vertex as usize]) - center
    });
    let flipped = has_faces && volume < -1e-9 * grid.size.iter().map(|n| *n as f64).product::<f64>();
    let in_grid = |cell: [i32; 3]| (0..3).all(|k| (0..grid.size[k] as i32).contains(&cell[k]));
    let mut surface = entered.clone();
    for axis in 0..3 {
        let [front, back] = if flipped { [1, 0] } else { [0, 1] }.map(|side| &faces[axis][side]);
        for upper in front.cells(|cell| front.has(cell) || back.has(cell)) {
            let mut lower = upper;
            lower[axis] -= 1;
            let [behind, other] = if front.has(upper) { [lower, upper] } else { [upper, lower] };
            match (outside.has(upper), outside.has(lower)) {
                (false, false) => {}
                (false, true) => surface.set(upper),
                (true, false) => surface.set(lower),
                (true, true) => surface.set(if in_grid(behind) { behind } else { other }),
            }
        }
    }
    let occupied = |surface: &Flags, cell| surface.has(cell) || !outside.has(cell);
    let mut free = Vec::new();
    for corner in untraced {
        let around = (0..8).map(|k| -> [i32; 3] {
            std::array::from_fn(|a| {
                if k >> a & 1 == 0 { corner[a].ceil() as i32 - 1 } else { corner[a].floor() as i32 }
            })
        });
        let around: Vec<_> = around.filter(|cell| in_grid(*cell)).collect();
        if !around.iter().any(|cell| occupied(&surface, *cell)) {
            free.push(around[0]);
        }
    }
    free.into_iter().for_each(|cell| surface.set(cell));
    let cells = surface.cells(|cell| in_grid(cell) && occupied(&surface, cell));
    (GridSet::from_sorted(&cells), surface.flags.iter().filter(|flag| **flag).count())
}

/// Random numbers from 0 to 1. A linear congruential generator (Knuth's MMIX) is random enough for meshes.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a whole number from 0 to `n - 1`.
    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

/// Returns a mesh of boxes, some with missing or flipped faces, of random triangles, and of degenerate triangles.
/// Mostly in grid planes if `rounding` is 1; between them if it is 0.
fn random_mesh(random: &mut Random, rounding: f64) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::<Vec<u32>>::new());
    // A cell size of 1 and a box of whole numbers, so that the grid planes are at whole numbers.
    let extent = [11.0, 9.0, 12.0];
    for (corner, inwards) in [([0.0; 3], 1.0), (extent, -1.0)] {
        let first = vertices.len() as u32;
        let [x, y, z] = corner;
        vertices.extend([corner, [x + inwards, y, z], [x, y + inwards, z + inwards]]);
        faces.push((first..first + 3).collect());
    }
    let round = |x: f64, share: f64| if share < rounding { x.round() } else { x };
    for _ in 0..random.below(5) {
        let low: [f64; 3] = std::array::from_fn(|a| round(0.7 * extent[a] * random.next(), random.next()));
        let high: [f64; 3] =
            std::array::from_fn(|a| round(low[a] + (extent[a] - low[a]) * random.next(), random.next()));
        let first = vertices.len() as u32;
        vertices.extend((0..8).map(|k| -> [f64; 3] {
            std::array::from_fn(|a| if k >> a & 1 == 0 { low[a] } else { high[a] })
        }));
        let flipped = random.next() < 0.3;
        let missing = if random.next() < 0.3 { 0.2 } else { 0.0 };
        for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let mut quad = quad.map(|k| first + k).to_vec();
            if flipped || random.next() < 0.05 {
                quad.reverse();
            }
            if random.next() >= missing {
                faces.push(quad);
            }
        }
    }
    for index in 0..random.below(20) {
        let first = vertices.len() as u32;
        let mut corners: [[f64; 3]; 3] =
            std::array::from_fn(|_| std::array::from_fn(|a| round(extent[a] * random.next(), random.next())));
        match index % 5 {
            0 => corners[2] = corners[1],
            1 => corners = [corners[0]; 3],
            2 => corners = [0, 1, 2].map(|c| [corners[0][0], corners[0][1], corners[c][2]]),
            _ => {}
        }
        vertices.extend(corners);
        faces.push((first..first + 3).collect());
    }
    Mesh::new(vertices, &faces).expect("a mesh")
}

#[test]
fn cells_of_random_meshes_are_those_of_the_dense_reference() {
    let random = &mut Random(5);
    let (mut enclosed, mut flat) = (0, 0);
    for index in 0..1500 {
        let rounding = [1.0, 0.95, 0.5, 0.0][index % 4];
        let mesh = random_mesh(random, rounding);
        let cell_size = [1.0, 1.0, 0.5, 1.37, 6.0][index % 5];
        let grid = Grid::new(mesh.bounds(), cell_size).expect("a small grid");
        let (cells, surface_cells) = reference(&mesh, &grid);
        let faces = 1 << 31;
        let voxels = voxelize(&mesh, &grid, Maxima { cells: 1 << 31, faces }).expect("few cells");
        assert_eq!(voxels.cells, cells, "mesh {index}");
        assert_eq!(voxels.surface_cells, surface_cells, "mesh {index}");
        enclosed += usize::from(cells.len() > surface_cells);
        flat += usize::from(rounding == 1.0 && cell_size == 1.0 && cells.len() > surface_cells);
        // The maximum is exact.
        let n = cells.len() as u64;
        assert_eq!(voxelize(&mesh, &grid, Maxima { cells: n, faces }).expect("few cells").cells, cells);
        let too_many = voxelize(&mesh, &grid, Maxima { cells: n - 1, faces }).err();
        assert_eq!(too_many, Some(TooMany::Cells(n)), "mesh {index}");
    }
    assert!(
        enclosed > 300 && flat > 50,
        "{enclosed} meshes enclose cells, {flat} of them with faces in planes"
    );
}

#[test]
fn faces_in_grid_planes_count_once_for_each_orientation() {
    // A cube of 4^3 cells, with its faces once, twice, and in both orientations.
    let vertices: Vec<_> =
        (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|i| 4.0 * f64::from(i))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let reversed = quads.map(|quad: [u32; 4]| [quad[3], quad[2], quad[1], quad[0]]);
    for (faces, number) in
        [(quads.to_vec(), 96), ([quads, quads].concat(), 96), ([quads, reversed].concat(), 192)]
    {
        let mesh = Mesh::new(vertices.clone(), &faces).expect("a cube");
        let grid = Grid::new(mesh.bounds(), 1.0).expect("a small grid");
        let maxima = |faces| Maxima { cells: 64, faces };
        assert_eq!(voxelize(&mesh, &grid, maxima(number)).expect("few faces").cells.len(), 64);
        assert_eq!(voxelize(&mesh, &grid, maxima(number - 1)).err(), Some(TooMany::Faces(number)));
    }
}
