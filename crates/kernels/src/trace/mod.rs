//! Light transport: rays, surfaces, lights, photon paths, camera paths and the film.
//!
//! A path is cut where it meets a diffuse surface: what arrives there straight from a light is `direct`, what arrives
//! after mirrors, glass and gloss alone is `caustic` (L (S|G)⁺ D in Heckbert's notation), and what was diffusely reflected before
//! is `global`. Each part is estimated in one way only, so nothing is counted twice. Where a surface has lobes of both kinds, a
//! path of the eye is cut or goes on, as chance has it, and a photon is stored and goes on. [`trace_paths`] knows no parts: it is
//! what their sum is compared with.

pub mod bsdf;
mod bvh;
mod camera;
#[cfg(test)]
mod chi_square;
mod direct;
mod emission;
mod film;
mod final_gather;
mod intersect;
pub mod known;
mod lattice;
mod layers;
mod ledger;
pub mod light;
pub mod medium;
mod next_event;
mod paths;
mod photons;
mod scene;
pub mod sky;
pub mod solid_angle;
mod surface;
mod texture;
mod triangle;
pub mod vector;

pub use bvh::{BvhNode, INNER, LEAF_BITS, OCTANTS, Slabs, list_of, octant};
pub use camera::{Camera, CameraTile, Vertex, invert_lens, lens_density, lens_point, trace_camera};
pub use direct::shade_direct;
pub use film::{
    FilmTile, PART_BIAS, PART_CAUSTIC, PART_DIRECT, PART_GLOBAL, PART_PATHS, PART_REACH, Pixel, develop_film,
};
pub use final_gather::{GatherTile, sum_gather, trace_gather};
pub use intersect::{BLOCKED, Hit, LOST, MISS, closest_hit, corners_of, intersect, leave, occluded};
pub use known::{ALL, EVERYTHING, Known, Only, Told};
pub use lattice::{LatticeTile, lend_irradiance, spare_queries};
pub use layers::{LayerPixel, develop_layers};
pub use ledger::{LEDGER_PATHS, LedgerBlock, LedgerPass, LedgerSum, Tally, sum_ledger};
pub use paths::trace_paths;
pub use photons::{FATE_CUT, FATE_LANDED, PhotonPass, RAY_CAUSTIC, RAY_GLOBAL, count_photons, store_photons};
pub use scene::{
    LIGHT_AREA, LIGHT_DIRECTIONAL, LIGHT_DISC, LIGHT_ENVIRONMENT, LIGHT_POINT, LIGHT_SPHERE, LIGHT_SPOT,
    LIGHT_TRIANGLE, Light, MATERIAL_DIELECTRIC, MATERIAL_LAMBERTIAN, MATERIAL_LAYERED, MATERIAL_MIRROR,
    MATERIAL_ROUGH_DIELECTRIC, Material, NO_LIGHT, NO_TEXTURE, PRIMITIVE_DISC, PRIMITIVE_QUAD, PRIMITIVE_SPHERE,
    PRIMITIVE_TRIANGLE, Primitive, SceneInfo, Target,
};
pub use surface::{Corners, Surface, material_at, surface_at, surface_of};
pub use texture::{Texel, Texture, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT, half_to_f32, texel_at};
pub use triangle::shares;

/// Lanes of a tracing workgroup.
pub const TRACE_LANES: u32 = 64;
/// Bounces after which a path is given up. Russian roulette ends nearly all long before; the rest is counted.
/// Few enough that llvmpipe, which ends loops after 65,535 turns, gives up the same paths: light that is caught in glass bounces that often.
pub const MAX_BOUNCES: u32 = 256;
