//! The film: a pixel is the mean of its samples, and the sum of its parts.

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
/// [`FilmTile::parts`]: the reach of the estimates from each map that is wanted, for a layer.
pub const PART_REACH: u32 = 16;
/// [`FilmTile::parts`]: the estimates from half of each disc, for the layer of the bias.
pub const PART_BIAS: u32 = 32;

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

/// A sum of samples, compensated (Kahan 1965).
///
/// Its relative error is below 2⁻²³ + O(n·2⁻⁴⁸) for n samples, none of them negative (Goldberg, "What every computer scientist
/// should know about floating-point arithmetic", 1991, theorem 8), against n·2⁻²⁴ of plain addition.
#[derive(Clone, Copy)]
pub(super) struct Sum {
    // Not vectors, which wgpu's translator would not let stand side by side in a struct of sums.
    value: [f32; 3],
    lost_digits: [f32; 3],
}

impl Sum {
    pub(super) const ZERO: Self = Self { value: [0.0; 3], lost_digits: [0.0; 3] };

    #[inline]
    #[must_use]
    pub(super) fn with(self, sample: Vec3) -> Self {
        let before = Vec3::from_array(self.value);
        let term = sample - Vec3::from_array(self.lost_digits);
        let value = before + term;
        Self { value: value.to_array(), lost_digits: ((value - before) - term).to_array() }
    }

    #[inline]
    #[must_use]
    pub(super) fn over(self, n: f32) -> Vec3 {
        Vec3::new(div(self.value[0], n), div(self.value[1], n), div(self.value[2], n))
    }
}

/// Sums of the radiance of samples, W·sr⁻¹·m⁻², by the parts of the light.
#[derive(Clone, Copy)]
pub(super) struct Parts {
    pub(super) direct: Sum,
    pub(super) global: Sum,
    pub(super) caustic: Sum,
}

impl Parts {
    pub(super) const ZERO: Self = Self { direct: Sum::ZERO, global: Sum::ZERO, caustic: Sum::ZERO };

    /// These sums with the parts of the sample `at` of the tile.
    #[inline]
    #[must_use]
    pub(super) fn with(
        self,
        at: usize,
        tile: &FilmTile,
        vertex: &Vertex,
        direct: &Input<Irradiance>,
        global: &Input<Irradiance>,
        caustic: &Input<Irradiance>,
    ) -> Self {
        let weight = Vec3::from_array(vertex.weight);
        let mut sums = self;
        if tile.parts & PART_PATHS != 0 {
            sums.direct = sums.direct.with(Vec3::from_array(vertex.emitted));
        }
        if tile.parts & PART_DIRECT != 0 {
            let reflected = weight * Vec3::from_array(direct[at].rgb);
            sums.direct = sums.direct.with(Vec3::from_array(vertex.emitted) + reflected);
        }
        if tile.parts & PART_GLOBAL != 0 {
            sums.global = sums.global.with(weight * Vec3::from_array(global[at].rgb));
        }
        if tile.parts & PART_CAUSTIC != 0 {
            sums.caustic = sums.caustic.with(weight * Vec3::from_array(caustic[at].rgb));
        }
        sums
    }

    /// Whether the parts and their sum are finite: a part that is not makes the sum so.
    #[inline]
    #[must_use]
    pub(super) fn is_finite(&self) -> bool {
        let direct = Vec3::from_array(self.direct.value);
        let all = (direct + Vec3::from_array(self.global.value)) + Vec3::from_array(self.caustic.value);
        is_finite(all.x) && is_finite(all.y) && is_finite(all.z)
    }
}

/// Means the samples of pixel `i` of the tile, in their order, into the film.
///
/// Each part has a compensated mean of its own, and the pixel is their sum, (direct + global) + caustic: what an image of layers adds up to
/// has the bits of the picture. Each mean and each addition are rounded once more.
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
    let mut sums = Parts::ZERO;
    let mut pixel = Pixel { rgb: [0.0; 3], covered: 0, not_finite: 0, lost: 0, cut_short: 0, rays: 0 };
    let mut sample = 0;
    while sample < tile.samples {
        let at = (i * tile.samples + sample) as usize;
        let vertex = vertices[at];
        if tile.parts & PART_DIRECT != 0 {
            let cut_short = direct[at].photons == CUT_SHORT;
            pixel.cut_short += u32::from(cut_short);
            pixel.rays += if cut_short { 1 } else { direct[at].photons };
        }
        if tile.parts & PART_GLOBAL != 0 {
            pixel.cut_short += u32::from(global[at].photons == CUT_SHORT);
        }
        if tile.parts & PART_CAUSTIC != 0 {
            pixel.cut_short += u32::from(caustic[at].photons == CUT_SHORT);
        }
        // What is not finite, or would make a sum so, is left out and counted.
        let next = sums.with(at, tile, &vertex, direct, global, caustic);
        if next.is_finite() {
            sums = next;
        } else {
            pixel.not_finite += 1;
        }
        pixel.rays += vertex.rays;
        pixel.lost += u32::from(vertex.primitive == LOST);
        pixel.covered += u32::from(vertex.primitive < LOST);
        sample += 1;
    }
    let n = tile.samples as f32;
    pixel.rgb = ((sums.direct.over(n) + sums.global.over(n)) + sums.caustic.over(n)).to_array();
    film.set(tile.first_pixel + i, pixel);
}
