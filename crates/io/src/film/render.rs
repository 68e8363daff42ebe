//! Renders a frame.
//!
//! ```text
//! moment -> geometry in the coordinates of the camera -> lights
//! of each band of rows: samples with the triangle in front -> colors of the triangles in each pixel -> their mean
//! ```

use nalgebra::Vector3;

use super::camera::Camera;
use super::light::{KeyLight, SkyLight, sky_light};
use super::moment::{Color, Moment, PlaneAt, Solid};
use super::raster::{NOTHING, Samples};
use super::shade::{self, Lights, ToSrgb};
use super::{Coloring, Picture};

type Vec3 = Vector3<f32>;

/// Samples of a pixel along each axis.
const SIDE: usize = 3;
/// Rows of pixels that are rendered at a time.
const BAND: usize = 16;
/// Points along a side of the grid of a plane, and half of that side relative to half the diagonal of the bounds of what
/// hides the sky.
const GRID: usize = 112;
const GRID_SIZE: f32 = 2.2;
/// Indices of samples from which on they are those of planes.
const PLANES: u32 = u32::MAX - 1024;

/// Renders the frames of a motion.
#[derive(Debug)]
pub(super) struct Renderer {
    pub(super) camera: Camera,
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    pub(super) coloring: Coloring,
    pub(super) to_srgb: ToSrgb,
}

/// The surfaces of a frame.
#[derive(Debug, Default)]
struct Geometry {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    colors: Vec<Color>,
}

/// A plane of a frame that faces the camera, and a grid on it with the light of the sky.
#[derive(Debug)]
struct PlaneView {
    point: Vec3,
    normal: Vec3,
    /// Directions along the grid, its first point, and its points per length.
    axes: [Vec3; 2],
    low: [f32; 2],
    scale: f32,
    sky: Vec<f32>,
    /// Inverse depth at the first sample, and its change from column to column and from row to row.
    depths: [f32; 3],
}

impl Geometry {
    fn new(renderer: &Renderer, moment: &Moment) -> Self {
        let mut all = Self::default();
        for (index, body) in moment.bodies.iter().enumerate() {
            all.add(renderer, body, Some(index));
        }
        for collider in &moment.colliders {
            all.add(renderer, collider, None);
        }
        all
    }

    /// Adds a body with an index, or a collider.
    fn add(&mut self, renderer: &Renderer, solid: &Solid, body: Option<usize>) {
        let surface = &solid.surface;
        let first = self.points.len();
        let place = |&vertex: &u32| renderer.camera.place(solid.positions[vertex as usize]);
        self.points.extend(surface.vertices.iter().map(place));
        let mut normals = vec![Vec3::zeros(); surface.vertices.len()];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|corner| self.points[first + corner as usize]);
            let normal = (b - a).cross(&(c - a));
            triangle.iter().for_each(|&corner| normals[corner as usize] += normal);
        }
        let unit = |normal: Vec3| normal.try_normalize(f32::MIN_POSITIVE).unwrap_or_else(Vec3::y);
        self.normals.extend(normals.into_iter().map(unit));
        let moved = |triangle: &[u32; 3]| triangle.map(|corner| first as u32 + corner);
        self.triangles.extend(surface.triangles.iter().map(moved));
        let of_volume = solid.volume.filter(|_| body.is_some() && renderer.coloring == Coloring::Volume);
        match of_volume {
            Some(volume) => {
                self.colors.resize(self.triangles.len(), shade::color_of_volume(volume));
            }
            None => self.colors.extend(surface.tints.iter().map(|&tint| shade::color(tint, body))),
        }
    }

    /// Returns the center and half the diagonal of the bounds.
    fn bounds(&self) -> (Vec3, f32) {
        let Some(&first) = self.points.first() else { return (Vec3::zeros(), 1.0) };
        let (low, high) =
            self.points.iter().fold((first, first), |(low, high), point| (low.inf(point), high.sup(point)));
        (0.5 * (low + high), (0.5 * (high - low).norm()).max(1e-6))
    }
}

impl PlaneView {
    /// Returns a plane as it is seen; `None` from behind.
    fn new(
        Renderer { camera, size, .. }: &Renderer,
        plane: &PlaneAt,
        (center, radius): (Vec3, f32),
    ) -> Option<Self> {
        let (point, normal) = camera.plane(plane)?;
        if normal.dot(&(camera.eye - point)) <= 1e-6 {
            return None;
        }
        let side = if normal.x.abs() < 0.9 { Vec3::x() } else { Vec3::z() };
        let u = (side - normal * side.dot(&normal)).normalize();
        let axes = [u, normal.cross(&u)];
        let half = GRID_SIZE * radius;
        let low = axes.map(|axis| axis.dot(&center) - half);
        let scale = (GRID - 1) as f32 / (2.0 * half);
        let inverse = normal.dot(&(point - camera.eye)).recip();
        let at =
            |x: f32, y: f32| normal.dot(&camera.ray([x / SIDE as f32, y / SIDE as f32], *size)) * inverse;
        let start = at(0.0, 0.0);
        let depths = [start, at(1.0, 0.0) - start, at(0.0, 1.0) - start];
        Some(Self { point, normal, axes, low, scale, sky: Vec::new(), depths })
    }

    /// Returns the points of the grid.
    fn grid(&self) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        let base = self.normal * self.normal.dot(&self.point);
        (0..GRID * GRID).map(move |k| {
            let along = [k % GRID, k / GRID];
            let [u, v] = [0, 1].map(|axis| self.low[axis] + along[axis] as f32 / self.scale);
            (base + u * self.axes[0] + v * self.axes[1], self.normal)
        })
    }

    /// Returns the light of the sky at a point of the plane.
    fn sky_at(&self, point: Vec3) -> f32 {
        let free = (0.5 + 0.5 * self.normal.y).max(0.0);
        if self.sky.is_empty() {
            return free;
        }
        let [x, y] = [0, 1].map(|axis| (self.axes[axis].dot(&point) - self.low[axis]) * self.scale);
        let last = (GRID - 1) as f32;
        if !(x >= 0.0 && y >= 0.0 && x < last && y < last) {
            return free;
        }
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x - column as f32, y - row as f32);
        let at = |dx: usize, dy: usize| self.sky[(row + dy) * GRID + column + dx];
        let light =
            (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v) + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v;
        // The grid ends without an edge.
        let border = (x.min(y).min(last - x).min(last - y) / (0.15 * last)).min(1.0);
        free + border * (light - free)
    }
}

/// Returns the light on a grid, smoothed along both axes, so that the directions of the sky do not show.
fn smoothed(sky: &[SkyLight]) -> Vec<f32> {
    let mut light: Vec<f32> = sky.iter().map(|sky| sky.front).collect();
    for stride in [1, GRID, 1, GRID] {
        let before = light.clone();
        for (at, light) in light.iter_mut().enumerate() {
            let along = at / stride % GRID;
            let near = |k: usize| before[at + stride * (along + k).clamp(2, GRID + 1) - stride * (along + 2)];
            *light = (near(0) + 4.0 * near(1) + 6.0 * near(2) + 4.0 * near(3) + near(4)) / 16.0;
        }
    }
    light
}

/// A frame that is rendered.
struct View<'a> {
    renderer: &'a Renderer,
    geometry: Geometry,
    planes: Vec<PlaneView>,
    /// Columns and rows of samples, and inverse depths, of the points.
    screen: Vec<[f32; 3]>,
    sky: Vec<SkyLight>,
    lights: Lights,
}

impl Renderer {
    /// Renders a frame.
    pub(super) fn render(&self, moment: &Moment) -> Picture {
        let view = View::new(self, moment);
        let [width, height] = self.size.map(|side| side as usize);
        let bands = height.div_ceil(BAND);
        // The triangles of each band.
        let mut of_band: Vec<Vec<u32>> = vec![Vec::new(); bands];
        for (index, triangle) in view.geometry.triangles.iter().enumerate() {
            let corners = triangle.map(|corner| view.screen[corner as usize]);
            // What reaches behind the camera is left out.
            if corners.iter().any(|corner| corner[2] <= 0.0) {
                continue;
            }
            let rows = corners.map(|corner| corner[1]);
            let low = rows.into_iter().fold(f32::INFINITY, f32::min);
            let high = rows.into_iter().fold(f32::NEG_INFINITY, f32::max);
            let band = |row: f32| (row / (BAND * SIDE) as f32).floor();
            if high >= 0.0 && band(low) < bands as f32 {
                let range = band(low).max(0.0) as usize..=band(high).min(bands as f32 - 1.0) as usize;
                of_band[range].iter_mut().for_each(|band| band.push(index as u32));
            }
        }
        let mut pixels = Vec::with_capacity(width * height);
        let mut samples = Samples::default();
        for (band, triangles) in of_band.iter().enumerate() {
            let rows = band * BAND..height.min((band + 1) * BAND);
            samples.clear([SIDE * width, SIDE * rows.len()], SIDE * rows.start, 0.0, true);
            for &index in triangles {
                let corners = view.geometry.triangles[index as usize];
                samples.fill(corners.map(|corner| view.screen[corner as usize]), index);
            }
            for y in rows {
                pixels.extend((0..width).map(|x| self.to_srgb.get(view.pixel(&samples, x, y))));
            }
        }
        Picture { size: self.size, pixels }
    }
}

impl<'a> View<'a> {
    fn new(renderer: &'a Renderer, moment: &Moment) -> Self {
        let camera = &renderer.camera;
        let geometry = Geometry::new(renderer, moment);
        let bounds = geometry.bounds();
        let planes = moment.planes.iter().filter_map(|plane| PlaneView::new(renderer, plane, bounds));
        let mut planes: Vec<PlaneView> = planes.take(1000).collect();
        let size = renderer.size.map(|side| side * SIDE as u32);
        let focal = camera.magnified(SIDE as f32);
        let screen = geometry.points.iter().map(|&point| focal.project(point, size)).collect();
        let Geometry { points, normals, triangles, .. } = &geometry;
        let (mut sky, mut key) = (Vec::new(), None);
        if !triangles.is_empty() {
            let vertices = points.iter().copied().zip(normals.iter().copied());
            let places: Vec<(Vec3, Vec3)> = vertices.chain(planes.iter().flat_map(PlaneView::grid)).collect();
            sky = sky_light(&places, points, triangles);
            let mut of_planes = sky.split_off(points.len());
            for plane in planes.iter_mut().rev() {
                plane.sky = smoothed(&of_planes.split_off(of_planes.len() - GRID * GRID));
            }
            key = Some(KeyLight::new(shade::key_direction(camera.axes), points, triangles));
        }
        Self { renderer, planes, screen, sky, lights: Lights::new(camera.axes, key), geometry }
    }

    /// Returns the color of a pixel.
    fn pixel(&self, samples: &Samples, x: usize, y: usize) -> Color {
        const COUNT: usize = SIDE * SIDE;
        let rows: [_; SIDE] = std::array::from_fn(|row| samples.row(SIDE * x, SIDE * y + row, SIDE));
        let middle = [x, y].map(|side| (SIDE * side) as f32 + 0.5 * SIDE as f32);
        if rows.iter().all(|(_, items)| items.iter().all(|&item| item == NOTHING)) {
            return self.color(self.behind(0.0, middle), middle[0], middle[1]);
        }
        // The items in the pixel: index, number of samples, sums of columns and rows.
        let mut found = [(NOTHING, 0.0_f32, 0.0_f32, 0.0_f32); COUNT];
        let mut count = 0;
        for (row, (heights, items)) in rows.iter().enumerate() {
            for (column, (&height, &item)) in heights.iter().zip(*items).enumerate() {
                let at = [(SIDE * x + column) as f32 + 0.5, (SIDE * y + row) as f32 + 0.5];
                let plane = self.behind(height, at);
                let item = if plane == NOTHING { item } else { plane };
                let entry = found[..count].iter().position(|entry| entry.0 == item).unwrap_or(count);
                count = count.max(entry + 1);
                let (_, weight, columns, rows) = found[entry];
                found[entry] = (item, weight + 1.0, columns + at[0], rows + at[1]);
            }
        }
        // Neighbors on a smooth surface have the color of the one with most samples.
        let found = &mut found[..count];
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut sum = [0.0; 3];
        for entry in 0..count {
            let (item, weight, columns, rows) = found[entry];
            if weight == 0.0 {
                continue;
            }
            let mut share = weight;
            for other in entry + 1..count {
                if self.are_neighbors(item, found[other].0) {
                    share += std::mem::take(&mut found[other].1);
                }
            }
            let color = self.color(item, columns / weight, rows / weight);
            (0..3).for_each(|k| sum[k] += share / COUNT as f32 * color[k]);
        }
        sum
    }

    /// Returns whether two items are triangles with a common corner and color.
    fn are_neighbors(&self, a: u32, b: u32) -> bool {
        let Geometry { triangles, colors, .. } = &self.geometry;
        if a.max(b) >= PLANES {
            return false;
        }
        let (a, b) = (a as usize, b as usize);
        triangles[a].iter().any(|corner| triangles[b].contains(corner)) && colors[a] == colors[b]
    }

    /// Returns the index of the plane that is in front of an inverse depth at a column and a row of samples, or `NOTHING`.
    fn behind(&self, height: f32, [x, y]: [f32; 2]) -> u32 {
        let (mut largest, mut found) = (height, NOTHING);
        for (plane, item) in self.planes.iter().zip(PLANES..) {
            let [start, dx, dy] = plane.depths;
            let of_plane = start + x * dx + y * dy;
            if of_plane > largest {
                (largest, found) = (of_plane, item);
            }
        }
        found
    }

    /// Returns the color of an item at a column and a row of samples.
    fn color(&self, item: u32, x: f32, y: f32) -> Color {
        let Renderer { camera, size, .. } = self.renderer;
        let ray = || camera.ray([x / SIDE as f32, y / SIDE as f32], *size);
        if item == NOTHING {
            return self.lights.background;
        }
        if item >= PLANES {
            let plane = &self.planes[(item - PLANES) as usize];
            let ray = ray();
            let depth = plane.normal.dot(&(plane.point - camera.eye)) / plane.normal.dot(&ray);
            let point = camera.eye + ray * depth;
            let distance = (point - plane.normal * plane.normal.dot(&plane.point)).norm();
            return self.lights.plane(point, plane.normal, plane.sky_at(point), distance);
        }
        let triangle = self.geometry.triangles[item as usize].map(|corner| corner as usize);
        let [a, b, c] = triangle.map(|corner| self.screen[corner]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let second = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
        let third = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
        // Weights in space: those in the picture, divided by the depths.
        let weights = [(1.0 - second - third) * a[2], second * b[2], third * c[2]];
        let sum: f32 = weights.iter().sum();
        let weights = weights.map(|weight| weight / sum);
        let blended = |vectors: &[Vec3]| -> Vec3 { (0..3).map(|k| vectors[triangle[k]] * weights[k]).sum() };
        // Rows go down, so that triangles that face the camera turn to the left.
        let is_front = area < 0.0;
        let normal = blended(&self.geometry.normals) * if is_front { 1.0 } else { -1.0 };
        let normal = normal.try_normalize(f32::MIN_POSITIVE).unwrap_or_else(Vec3::y);
        let point = blended(&self.geometry.points);
        let sky = SkyLight::blended(triangle.map(|corner| &self.sky[corner]), weights);
        let view = (camera.eye - point).normalize();
        let of_sky = shade::of_side(&sky, is_front);
        self.lights.surface(self.geometry.colors[item as usize], (point, normal, view), of_sky, sky.free)
    }
}
