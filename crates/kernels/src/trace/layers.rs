//! Layers of a picture: what its light is made of, and what is seen where.

use super::LOST;
use super::camera::Vertex;
use super::film::{FilmTile, PART_BIAS, PART_CAUSTIC, PART_GLOBAL, PART_REACH, Parts, Sum};
use crate::exec::{Input, Store};
use crate::gather::Reach;
use crate::layout::Irradiance;
use crate::num::sqrt;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// The layers of a pixel.
///
/// The parts of the light are means of all samples. Everything else is a mean of the samples that see a diffuse surface, and 0 where
/// none does. Mirrors and glass are looked through: what is told of is the surface behind them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LayerPixel {
    /// Light that is seen straight or came straight from a light, W·sr⁻¹·m⁻².
    pub direct: [f32; 3],
    /// Light from the global map, W·sr⁻¹·m⁻².
    pub global: [f32; 3],
    /// Light from the caustic map, W·sr⁻¹·m⁻².
    pub caustic: [f32; 3],
    /// Normal of the side that is seen, shorter than 1 where samples differ.
    pub normal: [f32; 3],
    /// Reflectance of the surface, times what mirrors and glass on the way let through.
    pub albedo: [f32; 3],
    /// Length of the path from the camera to the surface, m.
    pub depth: f32,
    /// Radius of the estimates from the global and the caustic map, m.
    pub radius: [f32; 2],
    /// Photons in the estimates from the global and the caustic map.
    pub photons: [f32; 2],
    /// Estimate of the picture's bias, W·sr⁻¹·m⁻²: a mean of all samples, below 0 where the picture is too dark.
    pub bias: [f32; 3],
}

/// Means the samples of pixel `i` of the tile into its layers. The parts of the light have the bits that
/// [`develop_film`](super::develop_film) adds up.
///
/// How far the estimates of `global` and `caustic` reach is read if [`PART_REACH`] is set, and what half of their discs say if [`PART_BIAS`] is.
///
/// An estimate over a disc of radius r is the mean of the irradiance there, E + c·r²·ΔE + O(r⁴), c = 1/8 for a constant filter. Over half of
/// the area the second term is half as large, so twice the difference of the two is the bias but for O(r⁴) (Richardson's extrapolation;
/// the same Laplacian is what Hachisuka, Jarosz and Jensen, "A Progressive Error Estimation Framework for Photon Density Estimation", 2010,
/// take from derivatives of the filter). It needs no derivatives, serves every filter and surface, and knows edges, too.
#[inline]
pub fn develop_layers<L: Store<LayerPixel> + ?Sized>(
    i: u32,
    tile: &FilmTile,
    vertices: &Input<Vertex>,
    direct: &Input<Irradiance>,
    global: &Input<Irradiance>,
    caustic: &Input<Irradiance>,
    global_reach: &Input<Reach>,
    caustic_reach: &Input<Reach>,
    global_half: &Input<Irradiance>,
    caustic_half: &Input<Irradiance>,
    layers: &mut L,
) {
    if i >= tile.pixels {
        return;
    }
    let mut sums = Parts::ZERO;
    let mut normal = Sum::ZERO;
    let mut albedo = Sum::ZERO;
    // Depth, and the radius of each map's estimates.
    let mut lengths = Sum::ZERO;
    let mut photons = Sum::ZERO;
    let mut bias = Sum::ZERO;
    let mut covered = 0;
    let mut sample = 0;
    while sample < tile.samples {
        let at = (i * tile.samples + sample) as usize;
        let vertex = vertices[at];
        let next = sums.with(at, tile, &vertex, direct, global, caustic);
        if next.is_finite() {
            sums = next;
        }
        if tile.parts & PART_BIAS != 0 {
            let mut off = Vec3::ZERO;
            if tile.parts & PART_GLOBAL != 0 {
                off += Vec3::from_array(global[at].rgb) - Vec3::from_array(global_half[at].rgb);
            }
            if tile.parts & PART_CAUSTIC != 0 {
                off += Vec3::from_array(caustic[at].rgb) - Vec3::from_array(caustic_half[at].rgb);
            }
            bias = bias.with(Vec3::from_array(vertex.weight) * off * 2.0);
        }
        if vertex.primitive < LOST {
            covered += 1;
            normal = normal.with(Vec3::from_array(vertex.normal));
            albedo = albedo.with(Vec3::from_array(vertex.weight) * PI);
            let mut length = Vec3::new(vertex.distance, 0.0, 0.0);
            let mut found = Vec3::ZERO;
            if tile.parts & PART_GLOBAL != 0 {
                found.x = global[at].photons as f32;
                if tile.parts & PART_REACH != 0 {
                    length.y = sqrt(global_reach[at].radius2);
                }
            }
            if tile.parts & PART_CAUSTIC != 0 {
                found.y = caustic[at].photons as f32;
                if tile.parts & PART_REACH != 0 {
                    length.z = sqrt(caustic_reach[at].radius2);
                }
            }
            lengths = lengths.with(length);
            photons = photons.with(found);
        }
        sample += 1;
    }
    let all = tile.samples as f32;
    // No sample adds nothing: the sums are 0 then, and so are their means.
    let n = if covered == 0 { 1.0 } else { covered as f32 };
    let lengths = lengths.over(n);
    let photons = photons.over(n);
    layers.set(
        tile.first_pixel + i,
        LayerPixel {
            direct: sums.direct.over(all).to_array(),
            global: sums.global.over(all).to_array(),
            caustic: sums.caustic.over(all).to_array(),
            normal: normal.over(n).to_array(),
            albedo: albedo.over(n).to_array(),
            depth: lengths.x,
            radius: [lengths.y, lengths.z],
            photons: [photons.x, photons.y],
            bias: bias.over(all).to_array(),
        },
    );
}
