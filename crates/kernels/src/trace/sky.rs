//! The environment: radiance from every direction, from infinitely far away, as a picture of longitudes and latitudes.
//!
//! A picture's middle is straight ahead, towards −z, its right a quarter to the right, towards +x, and its upper edge the zenith, +y; the
//! light's angle turns all of it about y. Directions are drawn by a row, then a pixel of the row, each by a table of sums of chances, then
//! evenly by solid angle within the pixel (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, sections 12.5 and A.5). Pixels are mixed where they are seen and not
//! where they are drawn: the tables' chances are for what that makes of a pixel, on average, and none is 0.

use super::light::{FAR_AWAY, Glimpse, power_heuristic};
use super::scene::{Light, NO_LIGHT, SceneInfo};
use super::texture::{Texel, Texture, texel_at};
use super::vector::{dot, normalize};
use crate::exec::Input;
use crate::num::{atan2_turns, div, floor_to_i32, max, min, sin_cos_turns, sqrt};
use glam::Vec3;

const TAU: f32 = core::f32::consts::TAU;
/// Half a step of the random numbers: the middle of what one of them stands for.
const HALF_STEP: f32 = 2.980_232_2e-8;

/// A direction that was drawn.
pub struct Drawn {
    /// Unit vector towards the sky.
    pub direction: Vec3,
    /// Density, sr⁻¹.
    pub density: f32,
}

/// Place of a unit direction in the picture: u to the right and v down, 0 to 1.
#[inline]
#[must_use]
pub fn sky_place(light: &Light, direction: Vec3) -> [f32; 2] {
    let [cos, sin, _] = light.edges[1];
    let x = cos * direction.x - sin * direction.z;
    let z = sin * direction.x + cos * direction.z;
    let across = sqrt(x * x + z * z);
    [atan2_turns(x, -z) + 0.5, min(1.0, 2.0 * atan2_turns(across, direction.y))]
}

/// Radiance from a unit direction, W·sr⁻¹·m⁻².
#[inline]
#[must_use]
pub fn sky_radiance(
    light: &Light,
    direction: Vec3,
    info: &SceneInfo,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Vec3 {
    let texel = texel_at(&textures[info.sky as usize], sky_place(light, direction), texels);
    Vec3::from_array(light.emission) * texel.truncate()
}

/// A row of pixels between two circles of latitude.
struct Band {
    /// 1 − cos of the angle between the nearer pole and the nearer circle.
    low: f32,
    /// By how much that grows up to the other circle.
    span: f32,
    /// Whether the nearer pole is the lower one.
    south: bool,
}

/// Row `row` of `rows`. Measured from the nearer pole, where 1 − cos loses no digits.
#[inline]
fn band(row: u32, rows: u32) -> Band {
    let south = 2 * row >= rows;
    let from_pole = if south { rows - 1 - row } else { row };
    let step = div(1.0, (4 * rows) as f32);
    let (edge, _) = sin_cos_turns(from_pole as f32 * step);
    let (middle, _) = sin_cos_turns((2 * from_pole + 1) as f32 * step);
    let (half, _) = sin_cos_turns(step);
    Band { low: 2.0 * edge * edge, span: 2.0 * middle * half, south }
}

/// The entry of a table of `count` that `u` falls to: the first whose sum of chances is above it.
#[inline]
fn entry_of(u: f32, first: u32, count: u32, texels: &Input<Texel>) -> u32 {
    let mut low = 0;
    let mut high = count - 1;
    while low < high {
        let middle = (low + high) / 2;
        if u >= f32::from_bits(texels[(first + middle) as usize].rg) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// Where `u` is between the sums of chances before and after an entry, 0 to 1.
#[inline]
fn part_of(u: f32, entry: Texel) -> f32 {
    let (sum, chance) = (f32::from_bits(entry.rg), f32::from_bits(entry.ba));
    // Sums and chances are multiples of 2⁻²⁴: this is exact but for the quotient.
    max(0.0, min(1.0, div((u - (sum - chance)) + HALF_STEP, chance)))
}

/// Draws a direction by two uniform numbers.
#[inline]
#[must_use]
pub fn sample_sky(
    light: &Light,
    u: f32,
    v: f32,
    info: &SceneInfo,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Drawn {
    let picture = textures[info.sky as usize];
    let rows = picture.first + picture.width * picture.height;
    let row = entry_of(v, rows, picture.height, texels);
    let row_entry = texels[(rows + row) as usize];
    let columns = rows + picture.height + row * picture.width;
    let column = entry_of(u, columns, picture.width, texels);
    let column_entry = texels[(columns + column) as usize];

    let band = band(row, picture.height);
    let down = part_of(v, row_entry);
    let h = band.low + band.span * if band.south { 1.0 - down } else { down };
    let across = sqrt(max(0.0, h * (2.0 - h)));
    let y = if band.south { h - 1.0 } else { 1.0 - h };
    let turns = div(column as f32 + part_of(u, column_entry), picture.width as f32) - 0.5;
    let (to_right, ahead) = sin_cos_turns(turns);
    let (x, z) = (across * to_right, -(across * ahead));
    let [cos, sin, _] = light.edges[1];
    let direction = normalize(Vec3::new(cos * x + sin * z, y, cos * z - sin * x));
    let chance = f32::from_bits(row_entry.ba) * f32::from_bits(column_entry.ba);
    Drawn { direction, density: div(chance * picture.width as f32, TAU * band.span) }
}

/// Density, sr⁻¹, with which [`sample_sky`] draws a unit direction.
#[inline]
#[must_use]
pub fn sky_density(
    light: &Light,
    direction: Vec3,
    info: &SceneInfo,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> f32 {
    let picture = textures[info.sky as usize];
    let [u, v] = sky_place(light, direction);
    let (column, row) = (pixel(u, picture.width), pixel(v, picture.height));
    let rows = picture.first + picture.width * picture.height;
    let columns = rows + picture.height + row * picture.width;
    let chance =
        f32::from_bits(texels[(rows + row) as usize].ba) * f32::from_bits(texels[(columns + column) as usize].ba);
    div(chance * picture.width as f32, TAU * band(row, picture.height).span)
}

/// The pixel of a side of `size` that `at`, 0 to 1, falls to.
#[inline]
fn pixel(at: f32, size: u32) -> u32 {
    let place = floor_to_i32(at * size as f32);
    if place < 0 {
        0
    } else if place >= size as i32 {
        size - 1
    } else {
        place as u32
    }
}

/// Looks at the direction (u, v) of the environment.
#[inline]
#[must_use]
pub(super) fn look_at_sky(
    light: &Light,
    u: f32,
    v: f32,
    info: &SceneInfo,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Glimpse {
    let drawn = sample_sky(light, u, v, info, textures, texels);
    Glimpse {
        direction: drawn.direction,
        distance: FAR_AWAY,
        emission: sky_radiance(light, drawn.direction, info, textures, texels),
        spread: 1.0,
        extent: div(1.0, drawn.density),
        slant: 1.0,
    }
}

/// Radiance that a path finds where it leaves the scene, none without an environment. `density` is the one with which its
/// direction was drawn, beside shadow rays, and 0 if these do not draw it.
#[inline]
#[must_use]
pub(super) fn leaving(
    direction: Vec3,
    density: f32,
    info: &SceneInfo,
    lights: &Input<Light>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Vec3 {
    if info.environment == NO_LIGHT {
        return Vec3::ZERO;
    }
    let light = lights[info.environment as usize];
    let mut found = sky_radiance(&light, direction, info, textures, texels);
    if density > 0.0 {
        let other = sky_density(&light, direction, info, textures, texels) * light.probability;
        found *= power_heuristic(density, other);
    }
    found
}

/// The unit numbers from which [`sample_sky`] draws a direction: its inverse, within the steps of the numbers.
#[inline]
#[must_use]
pub fn invert_sky(
    light: &Light,
    direction: Vec3,
    info: &SceneInfo,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> [f32; 2] {
    let picture = textures[info.sky as usize];
    let [across, down] = sky_place(light, direction);
    let (column, row) = (pixel(across, picture.width), pixel(down, picture.height));
    let rows = picture.first + picture.width * picture.height;
    let band = band(row, picture.height);
    // 1 − cos of the angle from the nearer pole, without cancellation.
    let away = 1.0 + if band.south { -direction.y } else { direction.y };
    let h = div(dot(direction, direction) - direction.y * direction.y, away);
    let part = max(0.0, min(1.0, div(h - band.low, band.span)));
    let part = if band.south { 1.0 - part } else { part };
    let v = back(part, texels[(rows + row) as usize]);
    let part = across * picture.width as f32 - column as f32;
    let columns = rows + picture.height + row * picture.width;
    [back(part, texels[(columns + column) as usize]), v]
}

/// The inverse of [`part_of`].
#[inline]
fn back(part: f32, entry: Texel) -> f32 {
    let (sum, chance) = (f32::from_bits(entry.rg), f32::from_bits(entry.ba));
    max(0.0, (sum - chance) + part * chance - HALF_STEP)
}
