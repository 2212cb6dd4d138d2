//! Where a device finds the fields of the records that it shares with the CPU.
//!
//! The host fills a buffer of records with numbered words. A kernel writes down which word it finds in each field of the
//! first record, and in the first field of the second, which is the record's size: the layout as the device has it, and not
//! as a compiler says.

use crate::exec::{Input, Store};
use crate::gather::{EstimateParams, GatherParams, Reach};
use crate::grid::{Grid, Row};
use crate::layout::{Irradiance, Neighbour, Photon, PowerSum, Query};
use crate::rivals::kd::{KdLarge, KdLevel, KdRadius, KdSmall, KdSplit};
use crate::rivals::{BruteParams, SearchParams};
use crate::sort::{RadixPass, ScanParams};
use crate::trace::{
    BvhNode, Camera, CameraTile, Corners, FilmTile, GatherTile, LatticeTile, LayerPixel, LedgerBlock, LedgerPass,
    LedgerSum, Light, Material, PhotonPass, Pixel, Primitive, SceneInfo, Tally, Target, Texel, Texture, Vertex,
};

/// Words that a layout kernel writes at most.
pub const LAYOUT_WORDS: u32 = 128;

/// Fields that can be read word by word.
pub trait Words {
    /// Writes its words from `at` on and returns the place after them.
    fn write<W: Store<u32> + ?Sized>(self, at: u32, words: &mut W) -> u32;
}

impl Words for u32 {
    #[inline]
    fn write<W: Store<u32> + ?Sized>(self, at: u32, words: &mut W) -> u32 {
        words.set(at, self);
        at + 1
    }
}

impl Words for f32 {
    #[inline]
    fn write<W: Store<u32> + ?Sized>(self, at: u32, words: &mut W) -> u32 {
        words.set(at, self.to_bits());
        at + 1
    }
}

impl Words for Tally {
    #[inline]
    fn write<W: Store<u32> + ?Sized>(self, at: u32, words: &mut W) -> u32 {
        let at = self.emitted.write(at, words);
        let at = self.absorbed.write(at, words);
        let at = self.escaped.write(at, words);
        let at = self.landed.write(at, words);
        self.lost.write(at, words)
    }
}

impl<T: Words + Copy, const N: usize> Words for [T; N] {
    #[inline]
    fn write<W: Store<u32> + ?Sized>(self, at: u32, words: &mut W) -> u32 {
        let mut end = at;
        let mut i = 0;
        while i < N {
            end = self[i].write(end, words);
            i += 1;
        }
        end
    }
}

/// A kernel for some records: of each, the size, then the fields.
macro_rules! layouts {
    ($($(#[$doc:meta])* $kernel:ident($($arg:ident: $record:ident { $first:ident $(, $field:ident)* }),*);)*) => {
        $($(#[$doc])*
        #[inline]
        pub fn $kernel<W: Store<u32> + ?Sized>(i: u32, $($arg: &Input<$record>,)* words: &mut W) {
            if i == 0 {
                let mut at = 0;
                $(
                    $arg[1].$first.write(at, words);
                    at = $arg[0].$first.write(at + 1, words);
                    $(at = $arg[0].$field.write(at, words);)*
                )*
                let _ = at;
            }
        })*

        /// Records of each kernel, with their sizes in words, in the order in which the kernel has them.
        #[cfg(not(target_arch = "spirv"))]
        pub const LAYOUTS: &[(&str, &[(&str, usize)])] = &[
            $((stringify!($kernel), &[$((stringify!($record), size_of::<$record>() / 4)),*])),*
        ];
    };
}

layouts! {
    /// Records of photon maps.
    layout_map(
        photons: Photon { position, direction, power, primitive },
        queries: Query { position, active },
        neighbours: Neighbour { distance2, photon },
        irradiance: Irradiance { rgb, photons },
        sums: PowerSum { high, middle, low, above, photons }
    );
    /// Records of grids and searches.
    layout_grid(
        grid: Grid { origin, inverse_cell, cells, hash, table, photons, radius2, cell_width, slack, rows, step },
        rows: Row { y, z, least2 },
        gather: GatherParams { queries, k, guess },
        estimate: EstimateParams { queries, filter, surface, reach },
        reaches: Reach { radius2, photon, photons }
    );
    /// Records of other techniques.
    layout_rivals(
        search: SearchParams { queries, k, photons, radius2 },
        brute: BruteParams { first, queries, columns, photons, k, radius2 }
    );
    /// Records of the kd-tree.
    layout_kd(
        level: KdLevel { photons, nodes, level, roots, radius },
        large: KdLarge { begin, photons, place, low, high },
        split: KdSplit { begin, left, axis },
        small: KdSmall { begin, set, place },
        radius: KdRadius { queries, k, photons, iterations, radius }
    );
    /// Records of sorting, and of emission.
    layout_sort(
        radix: RadixPass { count, blocks, shift, values },
        scan: ScanParams { count, row_length },
        pass: PhotonPass { emitted, first, paths, rays, seed, stored_from, thin, chunk },
        targets: Target { centre, radius }
    );
    /// Records of scenes.
    layout_scene(
        info: SceneInfo { primitives, lights, targets, nodes, lists, first_corners, environment, sky, holes },
        nodes: BvhNode { near, skip, far, leaf },
        primitives: Primitive { kind, material, light, size, position, normal, sides },
        materials: Material {
            reflectance, kind, ior, survival, texture, roughness_texture, roughness, metallic, absorption, normal_texture,
            normal_scale, alpha_cutoff
        },
        lights: Light {
            emission, kind, position, primitive, edges, normal, area, probability, cumulative, first_photon, photons,
            first_target, targets, texture
        }
    );
    /// Records of surfaces that are more than flat and of one colour.
    layout_surface(
        corners: Corners { normals, uv },
        textures: Texture { first, width, height, wrap },
        texels: Texel { rg, ba }
    );
    /// Records of the energy ledger.
    layout_ledger(
        tallies: Tally { emitted, absorbed, escaped, landed, lost },
        pass: LedgerPass { blocks },
        blocks: LedgerBlock { first, paths },
        sums: LedgerSum { power, imbalance, imbalance2, paths, not_finite }
    );
    /// Records of the camera and the film.
    layout_film(
        camera: Camera { origin, width, corner, height, right, down, lens, focus, jitter },
        tile: CameraTile { first_pixel, pixels, samples, seed },
        vertices: Vertex { normal, primitive, weight, emitted, rays, distance },
        film_tile: FilmTile { first_pixel, pixels, samples, parts },
        film: Pixel { rgb, covered, not_finite, lost, cut_short, rays },
        gather: GatherTile { first_pixel, pixels, samples, rays, seed },
        layers: LayerPixel { direct, global, caustic, normal, albedo, depth, radius, photons, bias },
        lattice: LatticeTile { first_pixel, pixels, samples, seed, first_row, rows, width, per_pixel, reach2 }
    );
}
