//! Photon paths: emission, bounces, Russian roulette and storage (thesis, section 2.1.2).
//!
//! A path is walked twice by the same function: once to count what it stores, and once, when a prefix sum over the counts
//! has given each path its place, to store it. So the map has exactly the size it needs, photons have the same order on
//! every device, and none is dropped for want of room.

use super::MAX_BOUNCES;
use super::bsdf::{albedo_diffuse, entrance, is_diffuse, sample_specular, scatter_specular, specular_chance};
use super::bvh::BvhNode;
use super::emission::emit;
use super::intersect::{LOST, MISS, closest_hit, leave};
use super::known::Known;
use super::ledger::Tally;
use super::medium::{VACUUM, absorbs, leaks, medium_after, medium_before, roulette, transmittance};
use super::scene::{
    Light, MATERIAL_DIELECTRIC, MATERIAL_LAMBERTIAN, MATERIAL_MIRROR, Material, NO_LIGHT, PRIMITIVE_SPHERE, Primitive,
    SceneInfo, Target,
};
use super::surface::{Corners, surface_of};
use super::texture::{Texel, Texture};
use super::vector::{dot, pack_direction, sample_cosine};
use crate::exec::{Input, Store};
use crate::layout::Photon;
use crate::num::{Rng, abs, div, max, min};
use crate::sort::SCAN_BLOCK;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// [`PhotonPass::rays`]: photons leave in every direction the lights shine in.
pub const RAY_GLOBAL: u32 = 0;
/// [`PhotonPass::rays`]: photons are aimed at specular objects, and a path ends at the first surface that is
/// diffuse and nothing else.
pub const RAY_CAUSTIC: u32 = 1;

/// Parameters of a photon pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PhotonPass {
    /// Photons emitted in all: the lights share them.
    pub emitted: u32,
    /// First path of this dispatch: long passes are cut into several.
    pub first: u32,
    /// Paths of this dispatch.
    pub paths: u32,
    /// [`RAY_GLOBAL`] or [`RAY_CAUSTIC`]; also the stream of random numbers.
    pub rays: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Diffuse reflections a photon has behind it before it is stored: 1 leaves direct and caustic light out, 0 stores all.
    pub stored_from: u32,
    /// One photon in so many is stored, with the power of all of them.
    pub thin: u32,
    /// First path of the chunk whose photons make a map: the places of what its paths store are counted from this one on.
    pub chunk: u32,
}

/// A path's fate: it reached a diffuse surface. Fates are numbers to be added up, for a block of [`SCAN_BLOCK`] paths.
pub const FATE_LANDED: u32 = 1;
/// A path's fate: it was given up after [`MAX_BOUNCES`].
pub const FATE_CUT: u32 = 1 << 16;
const _: () = assert!(SCAN_BLOCK < FATE_CUT);
// The segments of a block are added up in 32 bits.
const _: () = assert!(SCAN_BLOCK <= u32::MAX / MAX_BOUNCES);

/// Counts the photons that the `i`-th path of the dispatch stores, and says what became of it and
/// of its power, and how many segments, rays from one surface to the next, it had.
#[inline]
pub fn count_photons<
    C: Store<u32> + ?Sized,
    F: Store<u32> + ?Sized,
    S: Store<u32> + ?Sized,
    T: Store<Tally> + ?Sized,
>(
    known: impl Known,
    i: u32,
    pass: &PhotonPass,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    targets: &Input<Target>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
    counts: &mut C,
    fates: &mut F,
    segments: &mut S,
    tallies: &mut T,
) {
    if i < pass.paths {
        let path = pass.first + i;
        let walked = walk(
            known,
            path,
            pass,
            info,
            nodes,
            primitives,
            materials,
            lights,
            targets,
            corners,
            textures,
            texels,
            |_, _| {},
        );
        counts.set(path - pass.chunk, walked.stored);
        let landed = if walked.landed { FATE_LANDED } else { 0 };
        fates.set(i, landed + if walked.cut { FATE_CUT } else { 0 });
        segments.set(i, walked.segments);
        tallies.set(i, walked.tally);
    }
}

/// Stores the photons of the `i`-th path of the dispatch from the path's place on: its offset in its scan block, plus the
/// offset of that block.
#[inline]
pub fn store_photons<P: Store<Photon> + ?Sized>(
    known: impl Known,
    i: u32,
    pass: &PhotonPass,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    targets: &Input<Target>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
    counts: &Input<u32>,
    offsets: &Input<u32>,
    block_offsets: &Input<u32>,
    photons: &mut P,
) {
    if i < pass.paths {
        let path = pass.first + i;
        let at = path - pass.chunk;
        let place = offsets[at as usize] + block_offsets[(at / SCAN_BLOCK) as usize];
        let counted = counts[at as usize];
        let keep = move |n, photon: Photon| {
            // Exact walks agree. A driver may contract this kernel and the one that counted differently.
            if n < counted {
                photons.set(place + n, photon);
            }
        };
        walk(known, path, pass, info, nodes, primitives, materials, lights, targets, corners, textures, texels, keep);
    }
}

/// What became of a path.
struct Walked {
    /// Photons it stored.
    stored: u32,
    /// Rays it took.
    segments: u32,
    /// Whether it reached a diffuse surface.
    landed: bool,
    /// Whether it was given up after [`MAX_BOUNCES`].
    cut: bool,
    /// Where its power went.
    tally: Tally,
}

/// Walks path `path` and hands each photon it stores, with its number on the path, to `store`.
#[inline]
fn walk<F: FnMut(u32, Photon)>(
    known: impl Known,
    path: u32,
    pass: &PhotonPass,
    info: &SceneInfo,
    nodes: &Input<BvhNode>,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    lights: &Input<Light>,
    targets: &Input<Target>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
    mut store: F,
) -> Walked {
    let mut walked = Walked { stored: 0, segments: 0, landed: false, cut: false, tally: Tally::nothing() };
    let rng = Rng { seed: pass.seed, stream: pass.rays, index: path };
    let start = emit(known, path, pass, info, lights, targets, corners, textures, texels);
    let mut power = start.power;
    walked.tally.emitted = power.to_array();
    if power.x + power.y + power.z <= 0.0 {
        return walked;
    }
    let mut origin = start.origin;
    if start.primitive != NO_LIGHT {
        let lamp = primitives[start.primitive as usize];
        let sphere = known.lamps() && lamp.kind == PRIMITIVE_SPHERE;
        let normal = if sphere { start.normal } else { Vec3::from_array(lamp.normal) };
        origin = leave(origin, normal, &lamp);
    }
    let mut direction = start.direction;
    let mut absorbed = Vec3::ZERO;
    let mut medium = VACUUM;
    let mut diffuse_bounces = 0;
    let mut specular_bounces = 0;
    let mut bounce = 0;
    let mut given_up = true;
    while bounce < MAX_BOUNCES {
        walked.segments += 1;
        let hit = closest_hit(known, origin, direction, info, nodes, primitives, materials, corners, textures, texels);
        if hit.primitive == MISS {
            walked.tally.escaped = power.to_array();
            given_up = false;
            break;
        }
        if hit.primitive == LOST {
            break;
        }
        let primitive = primitives[hit.primitive as usize];
        let (surface, material) =
            surface_of(known, origin, direction, hit, info, &primitive, materials, corners, textures, texels);
        let point = surface.position;
        let cos = dot(direction, surface.normal);
        if known.media() {
            medium = medium_before(medium, &material, primitive.material, cos);
            if medium != VACUUM {
                let inside = materials[medium as usize];
                if absorbs(&inside) {
                    let left = power * transmittance(&inside, hit.t);
                    absorbed += power - left;
                    power = left * roulette(left, start.power, rng.draw4(2 + MAX_BOUNCES + bounce)[0]);
                    if power == Vec3::ZERO {
                        given_up = false;
                        break;
                    }
                }
            }
        }
        let draw = rng.draw4(2 + bounce);
        let lambertian = material.kind == MATERIAL_LAMBERTIAN;
        let cos_seen = if known.gloss() { abs(dot(direction, surface.shading)) } else { 0.0 };
        if lambertian || (known.gloss() && is_diffuse(&material)) {
            walked.landed = true;
            let wanted =
                if pass.rays == RAY_GLOBAL { diffuse_bounces >= pass.stored_from } else { specular_bounces > 0 };
            // What a black surface receives is never seen, and would only be found from the surfaces beside it.
            // Russian roulette, but for storing alone: the path goes on whichever way it falls.
            let thin = pass.thin as f32;
            let kept = pass.thin <= 1 || rng.draw4(2 + 2 * MAX_BOUNCES + bounce)[0] * thin < 1.0;
            if wanted && kept && material.survival > 0.0 {
                // A coat lets only a part of the light through to what is diffuse.
                let entering = thin * if known.gloss() { power * entrance(known, &material, cos_seen) } else { power };
                store(
                    walked.stored,
                    Photon {
                        position: point.to_array(),
                        direction: pack_direction(direction),
                        power: entering.to_array(),
                        primitive: hit.primitive,
                    },
                );
                walked.stored += 1;
            }
        }
        if lambertian {
            if pass.rays != RAY_GLOBAL {
                walked.tally.landed = power.to_array();
                given_up = false;
                break;
            }
            let reflectance = Vec3::from_array(material.reflectance);
            absorbed += power * (Vec3::ONE - reflectance);
            // Russian roulette (Arvo and Kirk 1990): survivors carry the power of those that were absorbed.
            if draw[0] >= material.survival {
                given_up = false;
                break;
            }
            let gain = div(1.0, material.survival);
            power *= reflectance * gain;
            // About the surface as it is: what arrives is measured by the area that it arrives at, too.
            let facing = surface.facing(surface.normal, direction);
            direction = sample_cosine(facing, draw[1], draw[2]);
            origin = leave(point, facing, &primitive);
            diffuse_bounces += 1;
        } else if known.gloss() && material.kind != MATERIAL_MIRROR && material.kind != MATERIAL_DIELECTRIC {
            // Photons for the caustic map end where they meet what is diffuse, and go on from a coat over it.
            let chance = if pass.rays == RAY_GLOBAL { specular_chance(known, &material, cos_seen) } else { 1.0 };
            let mut weight = Vec3::ZERO;
            let mut side = surface.facing(surface.normal, direction);
            let diffuse = draw[1] >= chance;
            if diffuse {
                let into = direction;
                direction = sample_cosine(side, draw[2], draw[3]);
                let cos_out = dot(direction, surface.facing(surface.shading, into));
                weight =
                    albedo_diffuse(known, &material, cos_out) * div(entrance(known, &material, cos_seen), 1.0 - chance);
                diffuse_bounces += 1;
            } else {
                // What is left of the number is uniform again.
                let rest = if chance < 1.0 { div(draw[1], chance) } else { draw[1] };
                let scattered = sample_specular(known, &material, direction, surface.shading, [draw[2], draw[3], rest]);
                direction = scattered.direction;
                side = surface.side(scattered.side, direction);
                if !leaks(&material, &surface, cos, side) {
                    weight = scattered.weight * div(1.0, chance);
                }
                if known.media() {
                    medium = medium_after(medium, &material, primitive.material, cos, surface.normal, side);
                }
                specular_bounces += 1;
            }
            absorbed += power * (Vec3::ONE - weight);
            // The weight is known only now, and is what decides.
            let survival = min(1.0, max(weight.x, max(weight.y, weight.z)));
            if draw[0] >= survival {
                given_up = false;
                break;
            }
            power *= weight * div(1.0, survival);
            origin = leave(point, side, &primitive);
        } else {
            absorbed += power * (Vec3::ONE - Vec3::from_array(material.reflectance));
            if draw[0] >= material.survival {
                given_up = false;
                break;
            }
            let scattered = scatter_specular(&material, direction, surface.shading, draw[1]);
            power *= scattered.weight * div(1.0, material.survival);
            direction = scattered.direction;
            let side = surface.side(scattered.side, direction);
            if known.media() {
                medium = medium_after(medium, &material, primitive.material, cos, surface.normal, side);
            }
            origin = leave(point, side, &primitive);
            specular_bounces += 1;
        }
        bounce += 1;
    }
    walked.tally.absorbed = absorbed.to_array();
    if given_up {
        walked.tally.lost = power.to_array();
        walked.cut = true;
    }
    walked
}
