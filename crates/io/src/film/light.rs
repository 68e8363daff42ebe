//! Light: a soft key light with its shadows, and the light of the sky with what hides it.
//!
//! Both use depth maps: the surfaces as seen from a direction, in parallel projection. The key light has one with many
//! texels, whose shadows are softened by percentage-closer filtering with a width that grows with the distance of what
//! throws them (Fernando 2005, "Percentage-closer soft shadows"). The sky has small ones in [`SKY`] directions, which are
//! evaluated at vertices and at the points of a grid on each plane.

use nalgebra::Vector3;

use super::raster::Samples;

type Vec3 = Vector3<f32>;

/// Texels along a side of the depth map of the key light, and of those of the sky.
const KEY_TEXELS: usize = 1024;
const SKY_TEXELS: usize = 112;
/// Number of directions of the sky.
const SKY: usize = 28;
/// Smallest and largest radius of a soft shadow, in texels.
const SHARP: f32 = 1.6;
const SOFT: f32 = 20.0;
/// Tangent of the angle of the key light, as seen from the scene.
const KEY_ANGLE: f32 = 0.14;
/// Number of samples that look for what throws a shadow, of those of a soft shadow, and of those of a sharp one.
const SEARCHES: usize = 12;
const FILTERS: usize = 28;
const FINE: usize = 6;
/// Texels along a side of the blocks that tell whether a shadow can be near.
const BLOCK: usize = 32;
/// What no surface is below.
const EMPTY: f32 = f32::MIN;

/// Surfaces as seen from a direction.
#[derive(Debug, Default)]
struct DepthMap {
    texels: usize,
    /// Directions of the columns and of the rows, and the direction to the viewer.
    axes: [Vec3; 3],
    low: [f32; 2],
    /// Texels per length.
    scale: f32,
    samples: Samples,
}

impl DepthMap {
    /// Fills the map. `projected`: scratch.
    fn fill(
        &mut self,
        texels: usize,
        toward: Vec3,
        points: &[Vec3],
        triangles: &[[u32; 3]],
        projected: &mut Vec<[f32; 3]>,
    ) {
        let side = if toward.y.abs() < 0.9 { Vec3::y() } else { Vec3::x() };
        let x = side.cross(&toward).normalize();
        self.axes = [x, toward.cross(&x), toward];
        self.texels = texels;
        projected.clear();
        projected.extend(points.iter().map(|point| self.axes.map(|axis| axis.dot(point))));
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for point in &*projected {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1e-6);
        // A margin, so that no shadow reaches the border.
        self.scale = (texels - 4) as f32 / extent;
        self.low = low.map(|low| low - 2.0 / self.scale);
        for point in &mut *projected {
            *point = self.texel(*point);
        }
        self.samples.clear([texels, texels], 0, EMPTY, false);
        for triangle in triangles {
            self.samples.fill(triangle.map(|corner| projected[corner as usize]), 0);
        }
    }

    fn texel(&self, [x, y, height]: [f32; 3]) -> [f32; 3] {
        [(x - self.low[0]) * self.scale, (y - self.low[1]) * self.scale, height]
    }

    /// Returns column, row and height of a point.
    fn project(&self, point: Vec3) -> [f32; 3] {
        self.texel(self.axes.map(|axis| axis.dot(&point)))
    }

    /// Returns the height of the texel at a column and a row.
    fn height(&self, x: f32, y: f32) -> f32 {
        let side = self.texels as f32;
        if x >= 0.0 && y >= 0.0 && x < side && y < side {
            self.samples.heights()[y as usize * self.texels + x as usize]
        } else {
            EMPTY
        }
    }

    /// Returns the share of light that reaches a column and row at a height, blended between four texels. Light fades as
    /// surfaces are between 0 and `soft` above the height.
    fn light(&self, x: f32, y: f32, height: f32, soft: f32) -> f32 {
        let (x, y) = (x - 0.5, y - 0.5);
        let last = (self.texels - 1) as f32;
        // The margin is empty.
        if !(x >= 0.0 && y >= 0.0 && x < last && y < last) {
            return 1.0;
        }
        let (left, top) = (x as usize, y as usize);
        let (u, v) = (x - left as f32, y - top as f32);
        let rows = &self.samples.heights()[top * self.texels + left..][..self.texels + 2];
        let inverse = soft.recip();
        let at = |texel: usize| 1.0 - ((rows[texel] - height) * inverse).clamp(0.0, 1.0);
        let upper = at(0) * (1.0 - u) + at(1) * u;
        let lower = at(self.texels) * (1.0 - u) + at(self.texels + 1) * u;
        upper * (1.0 - v) + lower * v
    }
}

/// The key light.
#[derive(Debug)]
pub(super) struct KeyLight {
    map: DepthMap,
    /// Smallest and largest height of each block of texels and its neighbors.
    blocks: Vec<[f32; 2]>,
    search: Vec<[f32; 2]>,
    filter: Vec<[f32; 2]>,
    fine: Vec<[f32; 2]>,
}

impl KeyLight {
    /// `toward`: direction to the light.
    pub(super) fn new(toward: Vec3, points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut map = DepthMap::default();
        map.fill(KEY_TEXELS, toward, points, triangles, &mut Vec::new());
        let blocks = blocks(map.samples.heights());
        Self { map, blocks, search: disc(SEARCHES), filter: disc(FILTERS), fine: disc(FINE) }
    }

    /// Returns the share of the light that reaches a point of a surface with a normal.
    pub(super) fn at(&self, point: Vec3, normal: Vec3) -> f32 {
        let map = &self.map;
        let texel = map.scale.recip();
        let [x, y, height] = map.project(point + normal * (1.5 * texel));
        let side = KEY_TEXELS as f32;
        if !(x >= 0.0 && y >= 0.0 && x < side && y < side) {
            return 1.0;
        }
        let height = height + texel;
        let block = y as usize / BLOCK * (KEY_TEXELS / BLOCK) + x as usize / BLOCK;
        let [lowest, highest] = self.blocks[block];
        if highest <= height {
            return 1.0;
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for &[dx, dy] in &self.search {
            let above = map.height(x + SOFT * dx, y + SOFT * dy) - height;
            if above > 0.0 {
                sum += above;
                count += 1.0;
            }
        }
        let light = |of: &[[f32; 2]], radius: f32| {
            let at = |&[dx, dy]: &[f32; 2]| map.light(x + radius * dx, y + radius * dy, height, 1.5 * texel);
            of.iter().map(at).sum::<f32>() / of.len() as f32
        };
        if count == 0.0 {
            // What is thinner than the distances of the samples.
            return light(&self.fine, SHARP);
        }
        if count as usize == SEARCHES && lowest > height {
            return 0.0;
        }
        light(&self.filter, (sum / count * KEY_ANGLE * map.scale).clamp(SHARP, SOFT))
    }
}

/// Returns the smallest and the largest height of each block of the map of the key light and its neighbors.
fn blocks(heights: &[f32]) -> Vec<[f32; 2]> {
    const COUNT: usize = KEY_TEXELS / BLOCK;
    let mut own = vec![[f32::MAX, EMPTY]; COUNT * COUNT];
    for (y, row) in heights.chunks(KEY_TEXELS).enumerate() {
        for (x, part) in row.chunks(BLOCK).enumerate() {
            let block = &mut own[y / BLOCK * COUNT + x];
            for &height in part {
                *block = [block[0].min(height), block[1].max(height)];
            }
        }
    }
    let joined = |block: usize| {
        let (x, y) = (block % COUNT, block / COUNT);
        let near = |k: usize| k.saturating_sub(1)..=(k + 1).min(COUNT - 1);
        let blocks = near(y).flat_map(|y| near(x).map(move |x| y * COUNT + x));
        blocks.fold([f32::MAX, EMPTY], |[low, high], block| [low.min(own[block][0]), high.max(own[block][1])])
    };
    (0..COUNT * COUNT).map(joined).collect()
}

/// Returns points that are spread evenly over the unit disc: a spiral (Vogel 1979).
fn disc(count: usize) -> Vec<[f32; 2]> {
    let point = |k: usize| {
        let (angle, radius) = (2.399_963 * k as f32, ((k as f32 + 0.5) / count as f32).sqrt());
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..count).map(point).collect()
}

/// The light of the sky at a point of a surface: what falls on the front and on the back, 1 on a free level surface,
/// and the share of the sky that is free.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SkyLight {
    pub(super) front: f32,
    pub(super) back: f32,
    pub(super) free: f32,
}

impl SkyLight {
    /// Returns the sum of three, weighted.
    pub(super) fn blended(of: [&Self; 3], weights: [f32; 3]) -> Self {
        let sum = |number: fn(&Self) -> f32| (0..3).map(|k| weights[k] * number(of[k])).sum();
        Self { front: sum(|sky| sky.front), back: sum(|sky| sky.back), free: sum(|sky| sky.free) }
    }
}

/// Directions to the parts of the sky: a spiral over the upper half sphere.
fn sky() -> impl Iterator<Item = Vec3> {
    (0..SKY).map(|k| {
        let (y, angle) = ((k as f32 + 0.5) / SKY as f32, 2.399_963 * k as f32);
        let radius = (1.0 - y * y).sqrt();
        Vec3::new(radius * angle.cos(), y, radius * angle.sin())
    })
}

/// Returns the light of the sky at places with normals, among surfaces.
pub(super) fn sky_light(places: &[(Vec3, Vec3)], points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<SkyLight> {
    // A free level surface has 1.
    let weight = sky().map(|direction| direction.y).sum::<f32>().recip();
    let mut light = vec![SkyLight::default(); places.len()];
    let (mut map, mut projected) = (DepthMap::default(), Vec::new());
    for direction in sky() {
        map.fill(SKY_TEXELS, direction, points, triangles, &mut projected);
        let texel = map.scale.recip();
        for ((place, normal), sky) in places.iter().zip(&mut light) {
            let cosine = normal.dot(&direction);
            // On the side of the surface that the direction lights.
            let place = place + normal * (1.5 * texel).copysign(cosine);
            let [x, y, height] = map.project(place);
            let seen = map.light(x, y, height + texel, 3.0 * texel);
            sky.free += seen / SKY as f32;
            sky.front += weight * seen * cosine.max(0.0);
            sky.back += weight * seen * (-cosine).max(0.0);
        }
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level square above the origin.
    fn roof() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corner = |x: f32, z: f32| Vec3::new(x, 1.0, z);
        let points = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        (points, vec![[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn a_point_below_a_roof_is_in_its_shadow_and_one_beside_it_is_not() {
        let (points, triangles) = roof();
        let light = KeyLight::new(Vec3::y(), &points, &triangles);
        let at = |x: f32| light.at(Vec3::new(x, 0.0, 0.0), Vec3::y());
        assert_eq!((at(0.0), at(1.5), at(9.0)), (0.0, 1.0, 1.0));
        // At the edge, half of the light passes; the samples of the filter are even to a few of them.
        assert!((at(1.0) - 0.5).abs() < 0.1, "{}", at(1.0));
        assert_eq!(light.at(Vec3::new(0.0, 1.0, 0.0), Vec3::y()), 1.0);
    }

    #[test]
    fn a_roof_hides_the_sky_by_its_solid_angle() {
        let (points, triangles) = roof();
        let places = [0.0, 1.0, 9.0].map(|height| (Vec3::new(0.0, height, 0.0), Vec3::y()));
        let [below, on, above] = sky_light(&places, &points, &triangles)[..] else { panic!() };
        assert!((on.front - 1.0).abs() < 1e-5 && (above.front - 1.0).abs() < 1e-5);
        assert!(on.back == 0.0 && (on.free - 1.0).abs() < 1e-5);
        // The form factor of a square at half its side above the point (Howell, configuration C-3): 0.554.
        assert!((below.front - 0.446).abs() < 0.05, "{}", below.front);
    }
}
