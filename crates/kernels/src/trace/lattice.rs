//! Irradiance of a sample from the estimates at the corners of a lattice over the picture, where those lie on its surface: soft light needs
//! no search a sample.
//!
//! The idea of irradiance caching (Ward et al., "A Ray Tracing Solution for Diffuse Interreflection", 1988), with keys that lie on a
//! lattice, so that a key is found without a search and a picture does not depend on the order in which it is computed.

use super::camera::{Camera, FILM_KEY, Vertex, pixel_sobol};
use super::vector::dot;
use crate::exec::{Input, Store};
use crate::gather::CUT_SHORT;
use crate::layout::{Irradiance, Query};
use crate::num::div;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Least cosine between the normals of a sample and a key.
const LEAST_COS: f32 = 0.95;
/// How far a key may lie from the sample's tangent plane: a tenth of the largest distance, squared.
const MOST_OFFSET2: f32 = 0.01;
/// Least sum of the weights of the keys on a sample's surface, of 1.
const LEAST_WEIGHT: f32 = 0.5;

/// The samples of a tile and the keys around them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LatticeTile {
    /// First pixel, counted row by row.
    pub first_pixel: u32,
    /// Pixels in the tile.
    pub pixels: u32,
    /// Camera samples a pixel.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Rows of keys above those that are at hand.
    pub first_row: u32,
    /// Rows of keys at hand.
    pub rows: u32,
    /// Keys in a row.
    pub width: u32,
    /// Keys a pixel along each axis.
    pub per_pixel: f32,
    /// Largest squared distance of a key from a sample, m².
    pub reach2: f32,
}

/// The keys around a sample, and their weights: 0 for those that do not lie on its surface.
struct Around {
    keys: [u32; 4],
    weights: [f32; 4],
    sum: f32,
}

#[inline]
fn around(
    i: u32,
    tile: &LatticeTile,
    camera: &Camera,
    query: Query,
    vertices: &Input<Vertex>,
    key_queries: &Input<Query>,
    key_vertices: &Input<Vertex>,
) -> Around {
    let pixel = tile.first_pixel + i / tile.samples;
    let jitter = pixel_sobol(pixel, i % tile.samples, tile.seed, FILM_KEY);
    let x = ((pixel % camera.width) as f32 + jitter[0]) * tile.per_pixel;
    let y = ((pixel / camera.width) as f32 + jitter[1]) * tile.per_pixel;
    // Rounding may take a sample at the border beyond the last key.
    let column = if (x as u32) + 2 < tile.width { x as u32 } else { tile.width - 2 };
    let most = tile.first_row + tile.rows - 2;
    let row = if (y as u32) < most { y as u32 } else { most };
    let (right, down) = (x - column as f32, y - row as f32);
    let first = (row - tile.first_row) * tile.width + column;
    let mut found = Around {
        keys: [first, first + 1, first + tile.width, first + tile.width + 1],
        weights: [(1.0 - right) * (1.0 - down), right * (1.0 - down), (1.0 - right) * down, right * down],
        sum: 0.0,
    };
    let position = Vec3::from_array(query.position);
    let normal = Vec3::from_array(vertices[i as usize].normal);
    let mut n = 0;
    while n < 4 {
        let key = found.keys[n] as usize;
        let other = key_queries[key];
        let apart = Vec3::from_array(other.position) - position;
        let offset = dot(apart, normal);
        let same = other.active != 0
            && dot(normal, Vec3::from_array(key_vertices[key].normal)) >= LEAST_COS
            && dot(apart, apart) <= tile.reach2
            && offset * offset <= MOST_OFFSET2 * tile.reach2;
        if !same {
            found.weights[n] = 0.0;
        }
        found.sum += found.weights[n];
        n += 1;
    }
    found
}

/// The query of sample `i`, or none if the keys around it will do.
#[inline]
pub fn spare_queries<Q: Store<Query> + ?Sized>(
    i: u32,
    tile: &LatticeTile,
    camera: &Camera,
    queries: &Input<Query>,
    vertices: &Input<Vertex>,
    key_queries: &Input<Query>,
    key_vertices: &Input<Vertex>,
    spared: &mut Q,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let mut query = queries[i as usize];
    if query.active != 0 {
        let found = around(i, tile, camera, query, vertices, key_queries, key_vertices);
        if found.sum >= LEAST_WEIGHT {
            query.active = 0;
        }
    }
    spared.set(i, query);
}

/// Irradiance of sample `i`: its own estimate, or for one whose query was spared the weighted mean of those of the keys around it.
#[inline]
pub fn lend_irradiance<I: Store<Irradiance> + ?Sized>(
    i: u32,
    tile: &LatticeTile,
    camera: &Camera,
    queries: &Input<Query>,
    vertices: &Input<Vertex>,
    key_queries: &Input<Query>,
    key_vertices: &Input<Vertex>,
    key_irradiance: &Input<Irradiance>,
    spared: &Input<Query>,
    own: &Input<Irradiance>,
    irradiance: &mut I,
) {
    if i >= tile.pixels * tile.samples {
        return;
    }
    let query = queries[i as usize];
    let mut result = own[i as usize];
    if query.active != 0 && spared[i as usize].active == 0 {
        let found = around(i, tile, camera, query, vertices, key_queries, key_vertices);
        let mut sum = Vec3::ZERO;
        let mut most = 0.0;
        let mut photons = 0;
        let mut cut_short = false;
        let mut n = 0;
        while n < 4 {
            let weight = found.weights[n];
            if weight > 0.0 {
                let key = key_irradiance[found.keys[n] as usize];
                sum += Vec3::from_array(key.rgb) * weight;
                cut_short = cut_short || key.photons == CUT_SHORT;
                if weight > most {
                    most = weight;
                    photons = key.photons;
                }
            }
            n += 1;
        }
        let scale = div(1.0, found.sum);
        result = Irradiance { rgb: (sum * scale).to_array(), photons: if cut_short { CUT_SHORT } else { photons } };
    }
    irradiance.set(i, result);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    const FLOOR: [f32; 3] = [0.0, 0.0, 1.0];

    /// 4 × 4 pixels of a floor with a key every second pixel, irradiance 10·x + y at (x, y). `wall` turns the keys from that column on.
    fn lit(wall: u32) -> (Vec<Query>, Vec<Irradiance>) {
        let camera = Camera { width: 4, height: 4, ..Camera::default() };
        let tile = LatticeTile {
            first_pixel: 0,
            pixels: 16,
            samples: 1,
            seed: 3,
            first_row: 0,
            rows: 3,
            width: 3,
            per_pixel: 0.5,
            reach2: 9.0,
        };
        let vertex = |normal| Vertex { normal, ..Vertex::default() };
        let at = |x, y| Query { position: [x, y, 0.0], active: 1 };
        let queries: Vec<_> = (0..16)
            .map(|pixel| {
                let [u, v] = pixel_sobol(pixel, 0, 3, FILM_KEY);
                at((pixel % 4) as f32 + u, (pixel / 4) as f32 + v)
            })
            .collect();
        let keys: Vec<_> = (0..9).map(|key| at((key % 3 * 2) as f32, (key / 3 * 2) as f32)).collect();
        let normals: Vec<_> = (0..9).map(|key| vertex(if key % 3 >= wall { [1.0, 0.0, 0.0] } else { FLOOR })).collect();
        let light = |query: &Query| 10.0 * query.position[0] + query.position[1];
        let estimate = |query: &Query| Irradiance { rgb: [light(query); 3], photons: 7 };
        let known: Vec<_> = keys.iter().map(estimate).collect();
        let vertices = vec![vertex(FLOOR); 16];
        let mut spared = vec![Query::default(); 16];
        let mut irradiance = vec![Irradiance::default(); 16];
        // An invocation too many, which must do nothing.
        for i in 0..=16 {
            spare_queries(i, &tile, &camera, &queries, &vertices, &keys, &normals, spared.as_mut_slice());
        }
        let own = vec![Irradiance { rgb: [-1.0; 3], photons: 1 }; 16];
        for i in 0..=16 {
            let out = irradiance.as_mut_slice();
            lend_irradiance(i, &tile, &camera, &queries, &vertices, &keys, &normals, &known, &spared, &own, out);
        }
        for (query, found) in queries.iter().zip(&irradiance).filter(|(_, found)| found.photons == 7 && wall > 2) {
            assert!((found.rgb[0] - light(query)).abs() < 1e-4, "bilinear: {query:?} {found:?}");
        }
        (spared, irradiance)
    }

    #[test]
    fn samples_on_the_surface_of_their_keys_borrow_from_them() {
        let (spared, irradiance) = lit(3);
        assert!(spared.iter().all(|query| query.active == 0));
        assert!(irradiance.iter().all(|found| found.photons == 7));
    }

    #[test]
    fn samples_beside_another_surface_have_their_own_estimate() {
        let (spared, irradiance) = lit(1);
        // Of the samples between the first two columns of keys those borrow that are nearer to the first; the others know none.
        let borrowed: Vec<_> = (0..16).filter(|&pixel| spared[pixel].active == 0).collect();
        assert!(!borrowed.is_empty() && borrowed.iter().all(|pixel| pixel % 4 == 0 || pixel % 4 == 1), "{borrowed:?}");
        for (pixel, found) in irradiance.iter().enumerate() {
            assert_eq!(found.rgb[0] == -1.0, !borrowed.contains(&pixel), "{pixel}: {found:?}");
        }
    }

    #[test]
    fn an_estimate_that_was_cut_short_stays_so() {
        let around = [Irradiance { rgb: [1.0; 3], photons: CUT_SHORT }; 4];
        let tile = LatticeTile {
            pixels: 1,
            samples: 1,
            rows: 2,
            width: 2,
            per_pixel: 1.0,
            reach2: 9.0,
            ..LatticeTile::default()
        };
        let camera = Camera { width: 1, height: 1, ..Camera::default() };
        let query = [Query { position: [0.0; 3], active: 1 }; 4];
        let vertex = [Vertex { normal: FLOOR, ..Vertex::default() }; 4];
        let spared = [Query::default()];
        let mut out = [Irradiance::default()];
        lend_irradiance(
            0,
            &tile,
            &camera,
            &query,
            &vertex,
            &query,
            &vertex,
            &around,
            &spared,
            &out.clone(),
            out.as_mut_slice(),
        );
        assert_eq!(out[0].photons, CUT_SHORT);
    }
}
