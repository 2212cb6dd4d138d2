//! What a surface is like where a ray meets it.

use super::intersect::{Hit, corners_of};
use super::known::Known;
use super::scene::{
    MATERIAL_LAYERED, Material, NO_TEXTURE, PRIMITIVE_DISC, PRIMITIVE_QUAD, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE,
    Primitive, SceneInfo,
};
use super::texture::{Texel, Texture, texel_at};
use super::triangle::shares;
use super::vector::{cross, dot, normalize, unpack_direction};
use crate::exec::Input;
use crate::num::max;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Sine of the angle above the surface to which a reflection is lifted that a shading normal sends below it.
const LIFTED: f32 = 1e-3;

/// Normals and texture coordinates at the corners of a triangle. Primitive i has number i − [`SceneInfo::first_corners`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Corners {
    /// Unit normals, packed by [`pack_direction`](super::vector::pack_direction).
    pub normals: [u32; 3],
    /// Texture coordinates: u to the right, v down, 1 for the whole texture.
    pub uv: [[f32; 2]; 3],
}
const _: () = assert!(size_of::<Corners>() == 36);

/// The place of a hit.
#[derive(Clone, Copy)]
pub struct Surface {
    /// Where, m.
    pub position: Vec3,
    /// Unit normal of the surface as it is: a sphere's outside, the front of what is flat. It says on which side something is.
    pub normal: Vec3,
    /// Unit normal of the surface as it is meant to look, on the same side: what scatters light is turned to it.
    pub shading: Vec3,
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// Whether the two normals may differ.
    pub smooth: bool,
}

impl Surface {
    /// The normal of the side on which something of direction `out` leaves, when a sampler that knows the shading normal says `side`.
    #[inline]
    #[must_use]
    pub fn side(&self, side: Vec3, out: Vec3) -> Vec3 {
        if !self.smooth {
            return side;
        }
        if dot(out, self.normal) < 0.0 { -self.normal } else { self.normal }
    }

    /// A normal turned to where a ray of this direction comes from.
    #[inline]
    #[must_use]
    pub fn facing(&self, normal: Vec3, direction: Vec3) -> Vec3 {
        if dot(direction, self.normal) > 0.0 { -normal } else { normal }
    }
}

/// The surface where a ray of unit direction meets it.
#[inline]
#[must_use]
pub fn surface_at(
    known: impl Known,
    origin: Vec3,
    direction: Vec3,
    hit: Hit,
    info: &SceneInfo,
    primitive: &Primitive,
    corners: &Input<Corners>,
) -> Surface {
    let (position, normal) = point_of(known, origin, direction, hit.t, primitive);
    let mut surface = Surface { position, normal, shading: normal, uv: [0.0; 2], smooth: false };
    if known.meshes() && has_corners(hit.primitive, info, primitive) {
        let corners = corners[(hit.primitive - info.first_corners) as usize];
        let part = shares(corners_of(primitive), origin + direction * hit.t);
        let mut shading = unpack_direction(corners.normals[0]) * part[0];
        shading += unpack_direction(corners.normals[1]) * part[1];
        shading += unpack_direction(corners.normals[2]) * part[2];
        surface.shading = usable(shading, normal, direction);
        surface.uv = mixed(&corners, part);
        surface.smooth = true;
    } else if known.textures() && is_parallelogram(primitive) {
        surface.uv = on_edges(primitive, position);
    }
    surface
}

/// Whether the primitive of this index is a triangle with normals and texture coordinates.
#[inline]
fn has_corners(index: u32, info: &SceneInfo, primitive: &Primitive) -> bool {
    primitive.kind == PRIMITIVE_TRIANGLE && index >= info.first_corners
}

/// Whether the primitive has edges u and v.
#[inline]
fn is_parallelogram(primitive: &Primitive) -> bool {
    primitive.kind == PRIMITIVE_QUAD || primitive.kind == PRIMITIVE_DISC
}

/// Texture coordinates where each corner has this part.
#[inline]
fn mixed(corners: &Corners, part: [f32; 3]) -> [f32; 2] {
    [
        corners.uv[0][0] * part[0] + corners.uv[1][0] * part[1] + corners.uv[2][0] * part[2],
        corners.uv[0][1] * part[0] + corners.uv[1][1] * part[1] + corners.uv[2][1] * part[2],
    ]
}

/// Texture coordinates of a point of a quad or disc.
#[inline]
fn on_edges(primitive: &Primitive, position: Vec3) -> [f32; 2] {
    let local = position - Vec3::from_array(primitive.position);
    [dot(local, Vec3::from_array(primitive.sides[0])) + 0.5, dot(local, Vec3::from_array(primitive.sides[1])) + 0.5]
}

/// Whether the surface that the ray would meet has a hole there.
#[inline]
#[must_use]
pub(super) fn is_hole(
    origin: Vec3,
    direction: Vec3,
    hit: Hit,
    info: &SceneInfo,
    primitives: &Input<Primitive>,
    materials: &Input<Material>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> bool {
    let primitive = primitives[hit.primitive as usize];
    let material = materials[primitive.material as usize];
    if material.alpha_cutoff <= 0.0 {
        return false;
    }
    let point = origin + direction * hit.t;
    let mut uv = [0.0; 2];
    if has_corners(hit.primitive, info, &primitive) {
        uv = mixed(&corners[(hit.primitive - info.first_corners) as usize], shares(corners_of(&primitive), point));
    } else if is_parallelogram(&primitive) {
        uv = on_edges(&primitive, point);
    }
    texel_at(&textures[material.texture as usize], uv, texels).w < material.alpha_cutoff
}

/// The surface and its material where a ray of unit direction meets them, with the shading normal bent by the material's texture.
#[inline]
#[must_use]
pub fn surface_of(
    known: impl Known,
    origin: Vec3,
    direction: Vec3,
    hit: Hit,
    info: &SceneInfo,
    primitive: &Primitive,
    materials: &Input<Material>,
    corners: &Input<Corners>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> (Surface, Material) {
    let mut surface = surface_at(known, origin, direction, hit, info, primitive, corners);
    let material = material_at(known, primitive.material, surface.uv, materials, textures, texels);
    if known.textures() && material.normal_texture != NO_TEXTURE {
        let (tangent, mirrored) = tangent_at(hit.primitive, info, primitive, corners);
        // Across the normal; where the picture has no direction on the surface, the normal stays.
        let across = tangent - surface.shading * dot(tangent, surface.shading);
        let length2 = dot(across, across);
        if length2 > 1e-6 * dot(tangent, tangent) && length2 > 0.0 {
            let right = normalize(across);
            let up = cross(surface.shading, right) * mirrored;
            let texel = texel_at(&textures[material.normal_texture as usize], surface.uv, texels);
            let x = (texel.x * 2.0 - 1.0) * material.normal_scale;
            let y = (texel.y * 2.0 - 1.0) * material.normal_scale;
            let bent = right * x + up * y + surface.shading * (texel.z * 2.0 - 1.0);
            surface.shading = usable(bent, surface.normal, direction);
            surface.smooth = true;
        }
    }
    (surface, material)
}

/// The direction on a surface in which u grows, 0 if there is none; and −1 if v grows upwards, seen from the front with u to the right, where pictures
/// have it downwards, else 1.
#[inline]
fn tangent_at(index: u32, info: &SceneInfo, primitive: &Primitive, corners: &Input<Corners>) -> (Vec3, f32) {
    if has_corners(index, info, primitive) {
        let uv = corners[(index - info.first_corners) as usize].uv;
        let [a, b, c] = corners_of(primitive);
        let (u1, v1) = (uv[1][0] - uv[0][0], uv[1][1] - uv[0][1]);
        let (u2, v2) = (uv[2][0] - uv[0][0], uv[2][1] - uv[0][1]);
        let area = u1 * v2 - u2 * v1;
        let along = (b - a) * v2 - (c - a) * v1;
        if area > 0.0 {
            return (along, -1.0);
        }
        if area < 0.0 {
            return (-along, 1.0);
        }
    } else if is_parallelogram(primitive) {
        // The edge u, from the dual vector of the other.
        return (cross(Vec3::from_array(primitive.sides[1]), Vec3::from_array(primitive.normal)), -1.0);
    }
    (Vec3::ZERO, 1.0)
}

/// The point of a hit and the surface's unit normal there: the front side of what is flat, a sphere's outside.
///
/// The point is put back onto the surface, so that its error is a rounding of the point itself and not of the ray's length. On
/// what is flat it is also drawn towards the middle, by more than a quad reaches beyond its edges: at a closed corner no point
/// comes to lie behind the other wall.
#[inline]
#[must_use]
pub(super) fn point_of(
    known: impl Known,
    origin: Vec3,
    direction: Vec3,
    t: f32,
    primitive: &Primitive,
) -> (Vec3, Vec3) {
    let position = Vec3::from_array(primitive.position);
    let point = origin + direction * t;
    if primitive.kind == PRIMITIVE_SPHERE {
        let normal = normalize(point - position);
        return (position + normal * primitive.size, normal);
    }
    let normal = Vec3::from_array(primitive.normal);
    let local = point - position;
    let flat = local - normal * dot(normal, local);
    if known.meshes() && primitive.kind == PRIMITIVE_TRIANGLE {
        let [a, b, c] = corners_of(primitive);
        let middle = ((b - a) + (c - a)) * (1.0 / 3.0);
        return (position + (flat + (middle - flat) * primitive.size), normal);
    }
    (position + flat * (1.0 - 8.0 * primitive.size), normal)
}

/// The normal nearest to `shading`, of any length, that can be used where a ray of unit direction `d` meets a surface of unit normal `normal`: on
/// the same side as that, and such that the mirror image of the ray stays on the side it came from.
#[inline]
fn usable(shading: Vec3, normal: Vec3, d: Vec3) -> Vec3 {
    let mut back = 1.0;
    if dot(d, normal) > 0.0 {
        back = -1.0;
    }
    let front = normal * back;
    // Opposite corner normals cancel each other.
    if dot(shading, shading) <= 1e-6 || dot(shading, normal) <= 0.0 {
        return normal;
    }
    let n = normalize(shading) * back;
    let mirrored = d - n * (2.0 * dot(d, n));
    let height = dot(mirrored, front);
    if height >= LIFTED {
        return n * back;
    }
    // Halfway between where the ray comes from and the lifted image: the normal of that reflection.
    normalize(normalize(mirrored + front * (LIFTED - height)) - d) * back
}

/// The material of this index, at texture coordinates `uv`.
#[inline]
#[must_use]
pub fn material_at(
    known: impl Known,
    index: u32,
    uv: [f32; 2],
    materials: &Input<Material>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Material {
    let mut material = materials[index as usize];
    if known.textures() && material.texture != NO_TEXTURE {
        let texel = texel_at(&textures[material.texture as usize], uv, texels);
        let r = Vec3::from_array(material.reflectance) * texel.truncate();
        material.reflectance = r.to_array();
        // Of a layered material it says only whether anything survives.
        material.survival = if material.kind == MATERIAL_LAYERED { 1.0 } else { max(r.x, max(r.y, r.z)) };
    }
    if known.textures() && material.roughness_texture != NO_TEXTURE {
        let texel = texel_at(&textures[material.roughness_texture as usize], uv, texels);
        // What a picture holds is the perceptual roughness, whose square is α.
        material.roughness *= texel.y * texel.y;
        material.metallic *= texel.z;
    }
    material
}

#[cfg(test)]
mod tests;
