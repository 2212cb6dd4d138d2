//! What kernels have to know of a scene: the bits of their mask.

use super::content::{Content, Glass, Shape, Substance};
use caustic_kernels::trace::known::{GLOSS, LAMPS, MEDIA, MESHES, SKY, TEXTURES};
use caustic_kernels::trace::{
    LIGHT_AREA, LIGHT_ENVIRONMENT, LIGHT_POINT, Light, MATERIAL_LAYERED, MATERIAL_ROUGH_DIELECTRIC, Material,
    NO_TEXTURE, OCTANTS, PRIMITIVE_DISC, PRIMITIVE_TRIANGLE, Primitive,
};

/// Part of a sphere's radius by which what touches it may reach into it.
const TOUCHING: f64 = 1e-6;

/// The mask for a scene whose tree has so many lists.
pub(super) fn needs(
    content: &Content,
    primitives: &[Primitive],
    materials: &[Material],
    lights: &[Light],
    lists: u32,
) -> u32 {
    let mut needs = 0;
    let mut need = |bit: u32, needed: bool| needs |= if needed { bit } else { 0 };
    for primitive in primitives {
        let material = &materials[primitive.material as usize];
        let pictures = [material.texture, material.roughness_texture, material.normal_texture];
        need(TEXTURES, pictures.iter().any(|&picture| picture != NO_TEXTURE));
        need(GLOSS, material.kind == MATERIAL_LAYERED || material.kind == MATERIAL_ROUGH_DIELECTRIC);
        need(MESHES, primitive.kind == PRIMITIVE_TRIANGLE || primitive.kind == PRIMITIVE_DISC);
    }
    for light in lights {
        need(TEXTURES, light.texture != NO_TEXTURE);
        need(SKY, light.kind == LIGHT_ENVIRONMENT);
        need(LAMPS, ![LIGHT_AREA, LIGHT_POINT, LIGHT_ENVIRONMENT].contains(&light.kind));
    }
    need(MESHES, lists < OCTANTS);
    need(MEDIA, (0..content.surfaces.len()).any(|i| has_an_inside(content, materials, i)));
    needs
}

/// Whether it matters that something is inside of surface `i`: always, if it is a dielectric, but for a closed sphere that is clear and smooth and
/// touched by other surfaces from outside at most.
fn has_an_inside(content: &Content, materials: &[Material], i: usize) -> bool {
    let surface = &content.surfaces[i];
    let Substance::Dielectric(Glass { absorption, .. }) = content.materials[surface.material] else { return false };
    let Shape::Sphere { centre, radius } = surface.shape else { return true };
    let rough = materials[surface.material].kind == MATERIAL_ROUGH_DIELECTRIC;
    let within = |(low, high): (glam::DVec3, glam::DVec3)| {
        centre.clamp(low, high).distance(centre) < radius * (1.0 - TOUCHING)
    };
    let others = content.surfaces.iter().enumerate().filter(|&(j, _)| j != i);
    rough || absorption != glam::DVec3::ZERO || others.map(|(_, other)| other.bounds()).any(within)
}
