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
    need(MEDIA, (0..content.surfaces.len()).any(|i| has_an_inside(content, i)));
    needs
}

/// Whether it matters that something is inside of surface `i`: always, if it is a dielectric, but for a closed sphere that is clear and
/// touched by other surfaces from outside at most: no light in it and nothing that reflects diffusely is seen.
fn has_an_inside(content: &Content, i: usize) -> bool {
    let surface = &content.surfaces[i];
    let Substance::Dielectric(Glass { absorption, .. }) = content.materials[surface.material] else { return false };
    let Shape::Sphere { centre, radius } = surface.shape else { return true };
    let within =
        |(low, high): (glam::DVec3, glam::DVec3)| centre.clamp(low, high).distance(centre) < radius * (1.0 - TOUCHING);
    let others = content.surfaces.iter().enumerate().filter(|&(j, _)| j != i);
    absorption != glam::DVec3::ZERO || others.map(|(_, other)| other.bounds()).any(within)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// What is in a ball of glass is seen through it; what touches it from outside is not in it.
    #[test]
    fn a_closed_ball_of_clear_glass_has_an_inside_only_if_something_is_in_it() {
        let needs = |glass: &str, rest: &str| {
            let text = format!(
                "[camera]\nposition=[0,1,6]\ntarget=[0,1,0]\nvertical_fov_degrees=40\n\
                 [materials.white]\nkind='lambertian'\nreflectance=[0.8,0.8,0.8]\n\
                 [materials.glass]\nkind='dielectric'\nior=1.5\n{glass}\
                 [[quads]]\ncorner=[-3,0,3]\nedge_u=[6,0,0]\nedge_v=[0,0,-6]\nmaterial='white'\n\
                 [[spheres]]\ncentre=[0,1,0]\nradius=1\nmaterial='glass'\n\
                 [[lights]]\nkind='point'\nposition=[0,4,0]\nintensity=[9,9,9]\n{rest}"
            );
            Scene::parse("test.toml", &text).unwrap().compile().needs
        };
        let ball = |x: f64, radius: f64, material: &str| {
            format!("[[spheres]]\ncentre=[{x},1,0]\nradius={radius}\nmaterial='{material}'\n")
        };
        assert_eq!(needs("", ""), 0);
        assert_eq!(needs("", &ball(1.5, 0.5, "white")), 0);
        for more in [ball(0.0, 0.5, "white"), ball(0.0, 0.9, "glass"), ball(1.5, 0.6, "white")] {
            assert_eq!(needs("", &more), MEDIA, "{more}");
        }
        assert_eq!(needs("roughness=0.5\n", ""), GLOSS);
        assert_eq!(needs("absorption=[1,0,0]\n", ""), MEDIA);
    }
}
