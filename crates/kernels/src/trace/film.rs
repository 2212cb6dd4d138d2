//! The film: a pixel is the mean of its samples.

use super::LOST;
use super::camera::Vertex;
use crate::exec::{Input, Store};
use crate::gather::CUT_SHORT;
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
/// [`FilmTile::parts`]: all that a path found, which its vertex has as emitted light. Then there are no other parts.
pub const PART_PATHS: u32 = 8;

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
    /// Samples that were not finite and count as black.
    pub not_finite: u32,
    /// Samples whose path was given up; they count as black from there on.
    pub lost: u32,
    /// Searches and shadow rays of its samples that the device ended early: what they found is wrong.
    pub cut_short: u32,
    /// Rays of its samples: of camera paths and towards lights.
    pub rays: u32,
}

/// Means the samples of pixel `i` of the tile, in their order, into the film.
///
/// The sum is compensated (Kahan 1965): its relative error is below 2⁻²³ + O(n·2⁻⁴⁸) for n samples, none of them negative
/// (Goldberg, "What every computer scientist should know about floating-point arithmetic", 1991, theorem 8), against n·2⁻²⁴
/// of plain addition; the quotient is rounded once more.
#[inline]
pub fn develop_film<P: Store<Pixel> + ?Sized>(
    i: u32,
    tile: &FilmTile,
    vertices: &Input<Vertex>,
    direct: &Input<Irradiance>,
    global: &Input<Irradiance>,
    caustic: &Input<Irradiance>,
    film: &mut P,
) {
    if i >= tile.pixels {
        return;
    }
    let mut sum = Vec3::ZERO;
    let mut lost_digits = Vec3::ZERO;
    let mut pixel = Pixel { rgb: [0.0; 3], covered: 0, not_finite: 0, lost: 0, cut_short: 0, rays: 0 };
    let mut sample = 0;
    while sample < tile.samples {
        let at = (i * tile.samples + sample) as usize;
        let vertex = vertices[at];
        let mut irradiance = Vec3::ZERO;
        let mut radiance = Vec3::ZERO;
        if tile.parts & PART_DIRECT != 0 {
            radiance += Vec3::from_array(vertex.emitted);
            irradiance += Vec3::from_array(direct[at].rgb);
            let cut_short = direct[at].photons == CUT_SHORT;
            pixel.cut_short += u32::from(cut_short);
            pixel.rays += if cut_short { 1 } else { direct[at].photons };
        }
        if tile.parts & PART_PATHS != 0 {
            radiance += Vec3::from_array(vertex.emitted);
        }
        if tile.parts & PART_GLOBAL != 0 {
            irradiance += Vec3::from_array(global[at].rgb);
            pixel.cut_short += u32::from(global[at].photons == CUT_SHORT);
        }
        if tile.parts & PART_CAUSTIC != 0 {
            irradiance += Vec3::from_array(caustic[at].rgb);
            pixel.cut_short += u32::from(caustic[at].photons == CUT_SHORT);
        }
        radiance += Vec3::from_array(vertex.weight) * irradiance;
        // What is not finite, or would make the sum so, is left out and counted.
        let term = radiance - lost_digits;
        let next = sum + term;
        if is_finite(next.x) && is_finite(next.y) && is_finite(next.z) {
            lost_digits = (next - sum) - term;
            sum = next;
        } else {
            pixel.not_finite += 1;
        }
        pixel.rays += vertex.rays;
        pixel.lost += u32::from(vertex.primitive == LOST);
        pixel.covered += u32::from(vertex.primitive < LOST);
        sample += 1;
    }
    let n = tile.samples as f32;
    pixel.rgb = [div(sum.x, n), div(sum.y, n), div(sum.z, n)];
    film.set(tile.first_pixel + i, pixel);
}
