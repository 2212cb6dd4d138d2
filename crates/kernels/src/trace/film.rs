//! The film: a pixel is the mean of its samples.

use super::STATUS_NOT_FINITE;
use super::camera::Vertex;
use crate::exec::{Store, Tally};
use crate::layout::Irradiance;
use crate::num::{div, is_finite};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// [`FilmTile::parts`]: emitted light that is seen and light straight from the lights.
pub const PART_DIRECT: u32 = 1;
/// [`FilmTile::parts`]: the estimate from the global map.
pub const PART_GLOBAL: u32 = 2;
/// [`FilmTile::parts`]: the estimate from the caustic map.
pub const PART_CAUSTIC: u32 = 4;

/// What the film adds up.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FilmTile {
    /// First pixel, counted row by row.
    pub first_pixel: u32,
    /// Pixels in the tile.
    pub pixels: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// Sum of the `PART_` bits that are wanted. A part that is not wanted may have an empty buffer.
    pub parts: u32,
}

/// A pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Pixel {
    /// Mean radiance, W·sr⁻¹·m⁻², for each of red, green and blue.
    pub rgb: [f32; 3],
    /// Samples that found a diffuse surface.
    pub covered: u32,
}

/// Means the samples of pixel `i` of the tile, in their order, into the film.
#[inline]
pub fn develop_film<P: Store<Pixel> + ?Sized, S: Tally + ?Sized>(
    i: u32,
    tile: &FilmTile,
    vertices: &[Vertex],
    direct: &[Irradiance],
    global: &[Irradiance],
    caustic: &[Irradiance],
    film: &mut P,
    status: &mut S,
) {
    if i >= tile.pixels {
        return;
    }
    let mut sum = Vec3::ZERO;
    let mut covered = 0;
    let mut sample = 0;
    while sample < tile.samples {
        let at = (i * tile.samples + sample) as usize;
        let vertex = vertices[at];
        let mut irradiance = Vec3::ZERO;
        let mut radiance = Vec3::ZERO;
        if tile.parts & PART_DIRECT != 0 {
            radiance += Vec3::from_array(vertex.emitted);
            irradiance += Vec3::from_array(direct[at].rgb);
        }
        if tile.parts & PART_GLOBAL != 0 {
            irradiance += Vec3::from_array(global[at].rgb);
        }
        if tile.parts & PART_CAUSTIC != 0 {
            irradiance += Vec3::from_array(caustic[at].rgb);
        }
        radiance += Vec3::from_array(vertex.weight) * irradiance;
        if is_finite(radiance.x) && is_finite(radiance.y) && is_finite(radiance.z) {
            sum += radiance;
        } else {
            status.add(STATUS_NOT_FINITE, 1);
        }
        if vertex.primitive != super::MISS {
            covered += 1;
        }
        sample += 1;
    }
    let share = div(1.0, tile.samples as f32);
    film.set(tile.first_pixel + i, Pixel { rgb: (sum * share).to_array(), covered });
}
