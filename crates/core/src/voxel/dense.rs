//! A plain voxelization on dense arrays, against which [`voxelize`](mod@super::voxelize) is tested.

use nalgebra::Vector3;

use super::grid::{Grid, beside, step};
use super::grid_set::GridSet;
use super::triangle_box::TriangleAxes;
use super::voxelize::{Maxima, TooMany, voxelize};
use crate::mesh::testing::{BOX_FACES, Random, box_corners};
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

/// The cells that triangles enter and the faces of cells on which they lie.
struct Trace {
    entered: Flags,
    /// For each axis, the faces of triangles whose normal points up and down the axis, by their upper cells.
    faces: [[Flags; 2]; 3],
    has_faces: bool,
    /// The corners of triangles without a trace.
    untraced: Vec<[f64; 3]>,
}

impl Trace {
    fn new(mesh: &Mesh, grid: &Grid, positions: &[[f64; 3]]) -> Self {
        let mut trace = Self {
            entered: Flags::new(grid),
            faces: [0, 1, 2].map(|_| [Flags::new(grid), Flags::new(grid)]),
            has_faces: false,
            untraced: Vec::new(),
        };
        for triangle in mesh.triangles() {
            let corners = triangle.map(|vertex| positions[vertex as usize]);
            if !trace.add(&corners) {
                trace.untraced.extend(corners);
            }
        }
        trace
    }

    /// Adds a triangle. Returns whether it leaves a trace.
    fn add(&mut self, corners @ [a, b, c]: &[[f64; 3]; 3]) -> bool {
        let mut low: [i32; 3] = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]).floor() as i32);
        let mut high: [i32; 3] = std::array::from_fn(|k| a[k].max(b[k]).max(c[k]).ceil() as i32);
        let flat: Vec<usize> = (0..3).filter(|&k| low[k] == high[k]).collect();
        if flat.len() > 1 {
            return false;
        }
        let mut target = &mut self.entered;
        let mut step = [1; 3];
        if let [axis] = flat[..] {
            low[axis] -= 1;
            high[axis] += 1;
            step[axis] = 2;
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
            target = &mut self.faces[axis][usize::from(area < 0.0)];
            self.has_faces = true;
        }
        let is_one_box = (0..3).all(|k| high[k] - low[k] == step[k]);
        let axes = TriangleAxes::new(corners);
        let mut is_traced = false;
        let range = |k: usize| (low[k]..high[k]).step_by(step[k] as usize);
        for (x, y, z) in range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| (x, y, z)))) {
            let end: [i32; 3] = std::array::from_fn(|k| [x, y, z][k] + step[k]);
            if is_one_box || axes.enters([x, y, z].map(f64::from), end.map(f64::from)) {
                target.set(end.map(|i| i - 1));
                is_traced = true;
            }
        }
        is_traced
    }

    /// Returns the cells that paths of steps through free faces and cells reach from the margin.
    fn outside(&self, grid: &Grid) -> Flags {
        let mut outside = Flags::new(grid);
        let mut stack = vec![[-1; 3]];
        outside.set([-1; 3]);
        while let Some(cell) = stack.pop() {
            for side in 0..6 {
                let next = beside(cell, side);
                let upper = if side % 2 == 1 { next } else { cell };
                let is_wall =
                    self.entered.has(next) || self.faces[side / 2].iter().any(|side| side.has(upper));
                if outside.index(next).is_some() && !is_wall && !outside.has(next) {
                    outside.set(next);
                    stack.push(next);
                }
            }
        }
        outside
    }

    /// Returns the entered cells and the cells to which the faces belong. `is_flipped`: whether normals point inwards.
    fn surface(&self, outside: &Flags, grid: &Grid, is_flipped: bool) -> Flags {
        let mut surface = self.entered.clone();
        for axis in 0..3 {
            let [front, back] = if is_flipped { [1, 0] } else { [0, 1] }.map(|side| &self.faces[axis][side]);
            for upper in front.cells(|cell| front.has(cell) || back.has(cell)) {
                let lower = step(upper, axis, -1);
                let [behind, other] = if front.has(upper) { [lower, upper] } else { [upper, lower] };
                match (outside.has(upper), outside.has(lower)) {
                    (false, false) => {}
                    (false, true) => surface.set(upper),
                    (true, false) => surface.set(lower),
                    (true, true) => surface.set(if grid.contains(behind) { behind } else { other }),
                }
            }
        }
        surface
    }
}

/// Returns the cells that a surface passes through or encloses, and the number of the cells that it passes through.
fn reference(mesh: &Mesh, grid: &Grid) -> (GridSet, usize) {
    let positions: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| grid.cell_space(vertex)).collect();
    let trace = Trace::new(mesh, grid, &positions);
    let mut outside = trace.outside(grid);
    if let Some(solid) = mesh.open_surface().and_then(|open| open.solid.as_ref()) {
        for cell in outside.cells(|cell| grid.contains(cell) && !trace.entered.has(cell)) {
            let index = outside.index(cell).expect("a cell of the grid");
            outside.flags[index] &= !solid.encloses(&grid.center_of(cell));
        }
    }
    let center = Vector3::from(grid.size.map(|n| 0.5 * n as f64));
    let volume = signed_volume(mesh.triangles(), |vertex| Vector3::from(positions[vertex as usize]) - center);
    let is_flipped = volume < -1e-9 * grid.size.iter().map(|n| *n as f64).product::<f64>();
    let mut surface = trace.surface(&outside, grid, trace.has_faces && is_flipped);
    let occupied = |surface: &Flags, cell| surface.has(cell) || !outside.has(cell);
    let mut free = Vec::new();
    for corner in trace.untraced {
        let around = (0..8).map(|k| -> [i32; 3] {
            std::array::from_fn(|a| {
                if k >> a & 1 == 0 { corner[a].ceil() as i32 - 1 } else { corner[a].floor() as i32 }
            })
        });
        let around: Vec<_> = around.filter(|cell| grid.contains(*cell)).collect();
        if !around.iter().any(|cell| occupied(&surface, *cell)) {
            free.push(around[0]);
        }
    }
    free.into_iter().for_each(|cell| surface.set(cell));
    let cells = surface.cells(|cell| grid.contains(cell) && occupied(&surface, cell));
    (GridSet::new(cells), surface.flags.iter().filter(|flag| **flag).count())
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
        vertices.extend(box_corners(low, high));
        let flipped = random.next() < 0.3;
        let missing = if random.next() < 0.3 { 0.2 } else { 0.0 };
        for quad in BOX_FACES {
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
    let vertices = box_corners([0.0; 3], [4.0; 3]);
    let quads = BOX_FACES;
    let reversed = quads.map(|quad| [quad[3], quad[2], quad[1], quad[0]]);
    for (faces, number) in
        [(quads.to_vec(), 96), ([quads, quads].concat(), 96), ([quads, reversed].concat(), 192)]
    {
        let mesh = Mesh::new(vertices.to_vec(), &faces).expect("a cube");
        let grid = Grid::new(mesh.bounds(), 1.0).expect("a small grid");
        let maxima = |faces| Maxima { cells: 64, faces };
        assert_eq!(voxelize(&mesh, &grid, maxima(number)).expect("few faces").cells.len(), 64);
        assert_eq!(voxelize(&mesh, &grid, maxima(number - 1)).err(), Some(TooMany::Faces(number)));
    }
}
