//! Colors: those of the bodies, and how they look in the light.

use nalgebra::Vector3;

use super::light::{KeyLight, SkyLight};
use super::moment::{Color, Tint};

type Vec3 = Vector3<f32>;

/// Colors of the bodies, in the order of the scene, repeated; sRGB.
const PALETTE: [[u8; 3]; 8] = [
    [111, 152, 196],
    [222, 140, 104],
    [140, 176, 122],
    [232, 190, 110],
    [170, 130, 180],
    [98, 172, 168],
    [216, 128, 142],
    [164, 150, 130],
];
/// Color of colliders.
const COLLIDER: [u8; 3] = [190, 186, 180];
/// Color of a body with its volume at rest, and of one with a relative error of `REDDEST`.
const KEPT: [u8; 3] = [111, 152, 196];
const WRONG: [u8; 3] = [206, 62, 48];
const REDDEST: f64 = 0.2;
/// Color of planes, and behind all.
const PLANE: [u8; 3] = [214, 213, 210];
const BACKGROUND: [u8; 3] = [240, 240, 238];
/// Distances from the center of the picture between which a plane fades into the background.
const FADE: [f32; 2] = [1.5, 4.6];
/// Share of the background in walls, through which the room stays bright.
const WALL: f32 = 0.8;
/// Strengths of the key light, of the sky, and of what the ground reflects.
const KEY: Color = [1.02, 0.99, 0.94];
const SKY: Color = [0.46, 0.48, 0.52];
const BOUNCE: Color = [0.25, 0.24, 0.22];

/// Returns a color, linear.
fn linear(color: [u8; 3]) -> Color {
    color.map(|number| {
        let number = f32::from(number) / 255.0;
        if number <= 0.04045 { number / 12.92 } else { ((number + 0.055) / 1.055).powf(2.4) }
    })
}

fn mixed(a: Color, b: Color, share: f32) -> Color {
    std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
}

/// Returns the color of a triangle of a body with an index, or of a collider.
pub(super) fn color(tint: Tint, body: Option<usize>) -> Color {
    let own = linear(body.map_or(COLLIDER, |body| PALETTE[body % PALETTE.len()]));
    match tint {
        Tint::Palette => own,
        Tint::Inside => mixed(own, [1.0; 3], 0.3),
        // The darkest and the brightest materials keep their shading.
        Tint::Material(color) => color.map(|number| number.clamp(0.015, 0.85)),
    }
}

/// Returns the color of a body by its volume relative to that at rest.
pub(super) fn color_of_volume(volume: f64) -> Color {
    mixed(linear(KEPT), linear(WRONG), ((volume - 1.0).abs() / REDDEST).min(1.0) as f32)
}

/// Returns the color where nothing is.
pub(super) fn background() -> Color {
    linear(BACKGROUND)
}

/// The lights of a frame, as seen from a camera.
#[derive(Debug)]
pub(super) struct Lights {
    /// Direction to the key light.
    pub(super) toward: Vec3,
    /// The key light and its shadows; `None` if nothing throws one.
    pub(super) key: Option<KeyLight>,
    pub(super) plane: Color,
    pub(super) background: Color,
}

/// Returns the direction to the key light: from above, from the left and the front of the picture.
pub(super) fn key_direction([right, _, view]: [Vec3; 3]) -> Vec3 {
    let level = |direction: Vec3| Vec3::new(direction.x, 0.0, direction.z);
    let front = level(view).try_normalize(1e-3).unwrap_or_else(|| Vec3::y().cross(&-right));
    (0.42 * front - 0.62 * level(right) + 1.0 * Vec3::y()).normalize()
}

impl Lights {
    pub(super) fn new(axes: [Vec3; 3], key: Option<KeyLight>) -> Self {
        Self { toward: key_direction(axes), key, plane: linear(PLANE), background: background() }
    }

    fn shadow(&self, point: Vec3, normal: Vec3) -> f32 {
        self.key.as_ref().map_or(1.0, |key| key.at(point, normal))
    }

    /// Returns the color of a point of a surface. `view`: direction to the camera.
    pub(super) fn surface(
        &self,
        color: Color,
        (point, normal, view): (Vec3, Vec3, Vec3),
        sky: f32,
        free: f32,
    ) -> Color {
        let cosine = normal.dot(&self.toward);
        // Light fades where it grazes, so that the triangles of coarse meshes do not show.
        let lit = if cosine > 0.0 { self.shadow(point, normal) * (cosine / 0.12).min(1.0) } else { 0.0 };
        let half = (self.toward + view).normalize();
        let gloss = 0.10 * lit * normal.dot(&half).max(0.0).powi(28);
        let rim = 0.10 * free * (1.0 - normal.dot(&view).max(0.0)).powi(4);
        let below = (0.5 - 0.5 * normal.y) * (0.25 + 0.75 * free);
        std::array::from_fn(|k| {
            let light = KEY[k] * lit * cosine.max(0.0) + SKY[k] * sky + BOUNCE[k] * below;
            rolled_off(color[k] * light + gloss + rim * SKY[k])
        })
    }

    /// Returns the color of a point of a plane, at a distance from the middle of the picture.
    pub(super) fn plane(&self, point: Vec3, normal: Vec3, sky: f32, distance: f32) -> Color {
        let share = ((distance - FADE[0]) / (FADE[1] - FADE[0])).clamp(0.0, 1.0);
        let share = share * share * (3.0 - 2.0 * share);
        let steep = ((0.8 - normal.y) / 0.6).clamp(0.0, 1.0);
        let share = share.max(WALL * steep);
        if share >= 1.0 {
            return self.background;
        }
        let lit = self.shadow(point, normal);
        let cosine = normal.dot(&self.toward).max(0.0);
        let below = 0.5 - 0.5 * normal.y;
        let color = std::array::from_fn(|k| {
            rolled_off(self.plane[k] * (KEY[k] * lit * cosine + SKY[k] * sky + BOUNCE[k] * below))
        });
        mixed(color, self.background, share)
    }
}

/// Bends what is brighter than 0.7 to below 1.
fn rolled_off(light: f32) -> f32 {
    if light <= 0.7 { light } else { 1.0 - 0.3 * (-(light - 0.7) / 0.3).exp() }
}

/// Turns linear colors to sRGB, by a table over their square roots.
#[derive(Debug)]
pub(super) struct ToSrgb(Vec<u8>);

impl ToSrgb {
    pub(super) fn new() -> Self {
        let entry = |k: usize| {
            let light = (k as f32 / 4095.0).powi(2);
            let number =
                if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
            (255.0 * number + 0.5) as u8
        };
        Self((0..4096).map(entry).collect())
    }

    pub(super) fn get(&self, color: Color) -> [u8; 3] {
        color.map(|number| self.0[(number.clamp(0.0, 1.0).sqrt() * 4095.0 + 0.5) as usize])
    }
}

/// Returns the light of the sky on the side that is seen.
pub(super) fn of_side(sky: &SkyLight, is_front: bool) -> f32 {
    if is_front { sky.front } else { sky.back }
}
