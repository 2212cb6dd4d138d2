//! Single rays against a compiled scene.

use caustic_kernels::trace::{BvhNode, Hit, Known, closest_hit, occluded};
use caustic_renderer::scene::CompiledScene;
use glam::Vec3;

/// What a ray meets first, by the tree `nodes`.
#[must_use]
pub fn closest(known: impl Known, scene: &CompiledScene, nodes: &[BvhNode], origin: Vec3, direction: Vec3) -> Hit {
    let CompiledScene { info, primitives, materials, corners, textures, texels, .. } = scene;
    closest_hit(known, origin, direction, info, nodes, primitives, materials, corners, textures, texels)
}

/// Whether anything but primitive `except` is in the way of a ray of this length, by the tree `nodes`.
#[must_use]
pub fn shadow(
    known: impl Known,
    scene: &CompiledScene,
    nodes: &[BvhNode],
    [origin, direction]: [Vec3; 2],
    distance: f32,
    except: u32,
) -> u32 {
    let CompiledScene { info, primitives, materials, corners, textures, texels, .. } = scene;
    occluded(known, origin, direction, distance, except, info, nodes, primitives, materials, corners, textures, texels)
}
