//! What a surface is like where a ray meets it.

use super::intersect::{Hit, corners_of};
use super::scene::{
    MATERIAL_LAYERED, Material, NO_TEXTURE, PRIMITIVE_DISC, PRIMITIVE_QUAD, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE,
    Primitive, SceneInfo,
};
use super::texture::{Texel, Texture, texel_at};
use super::triangle::shares;
use super::vector::{dot, normalize, unpack_direction};
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
pub fn surface_at<const FULL: bool>(
    origin: Vec3,
    direction: Vec3,
    hit: Hit,
    info: &SceneInfo,
    primitive: &Primitive,
    corners: &Input<Corners>,
) -> Surface {
    let (position, normal) = point_of::<FULL>(origin, direction, hit.t, primitive);
    let mut surface = Surface { position, normal, shading: normal, uv: [0.0; 2], smooth: false };
    if FULL {
        if primitive.kind == PRIMITIVE_TRIANGLE && hit.primitive >= info.first_corners {
            let corners = corners[(hit.primitive - info.first_corners) as usize];
            let part = shares(corners_of(primitive), origin + direction * hit.t);
            let mut shading = unpack_direction(corners.normals[0]) * part[0];
            shading += unpack_direction(corners.normals[1]) * part[1];
            shading += unpack_direction(corners.normals[2]) * part[2];
            surface.shading = usable(shading, normal, direction);
            surface.uv = [
                corners.uv[0][0] * part[0] + corners.uv[1][0] * part[1] + corners.uv[2][0] * part[2],
                corners.uv[0][1] * part[0] + corners.uv[1][1] * part[1] + corners.uv[2][1] * part[2],
            ];
            surface.smooth = true;
        } else if primitive.kind == PRIMITIVE_QUAD || primitive.kind == PRIMITIVE_DISC {
            let local = position - Vec3::from_array(primitive.position);
            surface.uv = [
                dot(local, Vec3::from_array(primitive.sides[0])) + 0.5,
                dot(local, Vec3::from_array(primitive.sides[1])) + 0.5,
            ];
        }
    }
    surface
}

/// The point of a hit and the surface's unit normal there: the front side of what is flat, a sphere's outside.
///
/// The point is put back onto the surface, so that its error is a rounding of the point itself and not of the ray's length. On
/// what is flat it is also drawn towards the middle, by more than a quad reaches beyond its edges: at a closed corner no point
/// comes to lie behind the other wall.
#[inline]
#[must_use]
pub(super) fn point_of<const FULL: bool>(origin: Vec3, direction: Vec3, t: f32, primitive: &Primitive) -> (Vec3, Vec3) {
    let position = Vec3::from_array(primitive.position);
    let point = origin + direction * t;
    if primitive.kind == PRIMITIVE_SPHERE {
        let normal = normalize(point - position);
        return (position + normal * primitive.size, normal);
    }
    let normal = Vec3::from_array(primitive.normal);
    let local = point - position;
    let flat = local - normal * dot(normal, local);
    if FULL && primitive.kind == PRIMITIVE_TRIANGLE {
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
pub fn material_at<const FULL: bool>(
    index: u32,
    uv: [f32; 2],
    materials: &Input<Material>,
    textures: &Input<Texture>,
    texels: &Input<Texel>,
) -> Material {
    let mut material = materials[index as usize];
    if FULL && material.texture != NO_TEXTURE {
        let texel = texel_at(&textures[material.texture as usize], uv, texels);
        let r = Vec3::from_array(material.reflectance) * texel.truncate();
        material.reflectance = r.to_array();
        // Of a layered material it says only whether anything survives.
        material.survival = if material.kind == MATERIAL_LAYERED { 1.0 } else { max(r.x, max(r.y, r.z)) };
    }
    if FULL && material.roughness_texture != NO_TEXTURE {
        let texel = texel_at(&textures[material.roughness_texture as usize], uv, texels);
        // What a picture holds is the perceptual roughness, whose square is α.
        material.roughness *= texel.y * texel.y;
        material.metallic *= texel.z;
    }
    material
}

#[cfg(test)]
mod tests;
