//! A scene of many surfaces for `verify`: the built-in scenes are so small that their trees are one leaf.

use crate::scene::Scene;
use caustic_kernels::num::{pcg4d, u32_to_unit};
use std::fmt::Write;

/// Name of the scene in reports.
pub(crate) const CROWD: &str = "crowd";
/// Balls, and as many tiles.
const EACH: u32 = 150;

/// Balls of glass, mirror and white, and tiles, in a room with a lamp: where they are depends on the seed.
pub(crate) fn crowd(seed: u32) -> Scene {
    let mut text = String::from(
        "[camera]\nposition = [0, 1, 3.4]\ntarget = [0, 1, 0]\nvertical_fov_degrees = 40\n\
         [render]\nradius = 0.1\n\
         [materials.white]\nkind = 'lambertian'\nreflectance = [0.75, 0.7, 0.65]\n\
         [materials.mirror]\nkind = 'mirror'\nreflectance = [0.9, 0.9, 0.9]\n\
         [materials.glass]\nkind = 'dielectric'\nior = 1.5\n",
    );
    let mut quad = |corner: [f32; 3], edge_u: [f32; 3], edge_v: [f32; 3], surface: &str| {
        let _ = write!(text, "[[quads]]\ncorner = {corner:?}\nedge_u = {edge_u:?}\nedge_v = {edge_v:?}\n{surface}\n");
    };
    let white = "material = 'white'";
    quad([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], white);
    quad([-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], white);
    quad([-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], white);
    quad([-1.0, 0.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], white);
    quad([1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], white);
    quad([-0.5, 1.99, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], "radiance = [9, 8, 7]");
    let unit = |i: u32, stream: u32| {
        let random = pcg4d([seed, i, stream, 0xc40d]);
        [random[0], random[1], random[2]].map(u32_to_unit)
    };
    let place = |i: u32, stream: u32| {
        let [x, y, z] = unit(i, stream);
        [1.8 * x - 0.9, 0.1 + 1.7 * y, 1.8 * z - 0.9]
    };
    for i in 0..EACH {
        let edge = |stream: u32, axis: usize| {
            let mut edge = unit(i, stream).map(|x| 0.1 * x - 0.05);
            edge[axis] = 0.08;
            edge
        };
        let axis = i as usize % 3;
        quad(place(i, 0), edge(1, axis), edge(2, (axis + 1) % 3), white);
    }
    for i in 0..EACH {
        let material = ["white", "mirror", "glass"][i as usize % 3];
        let radius = 0.02 + 0.05 * unit(i, 4)[0];
        let centre = place(i, 3);
        let _ = write!(text, "[[spheres]]\ncentre = {centre:?}\nradius = {radius:?}\nmaterial = '{material}'\n");
    }
    let Ok(scene) = Scene::parse(CROWD, &text) else { unreachable!("it is a scene for every seed") };
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_scene_with_a_tree_for_every_seed() {
        for seed in [0, 1, 2, 7, u32::MAX] {
            let scene = crowd(seed).compile();
            assert_eq!(scene.info.primitives, 6 + 2 * EACH);
            assert_eq!(scene.info.nodes, 2 * scene.info.primitives - 1);
        }
    }
}
