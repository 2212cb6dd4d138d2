//! Soups of primitives and rays through them, of the kinds that rounding is worst for.

use crate::renders::parse;
use caustic_kernels::num::{pcg4d, u32_to_unit};
use caustic_kernels::trace::vector::{cross, normalize};
use caustic_kernels::trace::{Hit, MISS, PRIMITIVE_QUAD, Primitive, intersect};
use caustic_renderer::scene::{CompiledScene, Scene};
use glam::Vec3;
use std::fmt::Write;

/// Random numbers from 0 to 1 in their order.
pub struct Random(pub [u32; 2]);

impl Random {
    /// The next.
    pub fn next_unit(&mut self) -> f32 {
        self.0[1] += 1;
        u32_to_unit(pcg4d([self.0[0], self.0[1], 0xb7, 0])[0])
    }

    /// A whole number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        ((self.next_unit() * n as f32) as u32).min(n - 1)
    }

    /// A vector of components from −1 to 1.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next_unit(), self.next_unit(), self.next_unit()) * 2.0 - Vec3::ONE
    }

    /// A unit vector.
    pub fn direction(&mut self) -> Vec3 {
        normalize(self.vector() + Vec3::new(0.0, 0.0, 1e-6))
    }
}

/// Where the primitives of a soup are.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Kind {
    /// All over the place.
    Spread,
    /// On a few planes, parallel to the axes, over and over each other; every fourth is there twice.
    Planes,
    /// Around three points that are far from each other: coordinates are large and primitives small.
    Clusters,
    /// Thin quads, quads of almost parallel edges, and balls that touch each other or hold each other.
    Degenerate,
}
/// All of them.
pub const KINDS: [Kind; 4] = [Kind::Spread, Kind::Planes, Kind::Clusters, Kind::Degenerate];

/// A scene of `n` primitives of about `unit` m, in a room ten times as large for each factor of a thousand in their number.
pub fn soup(n: u32, unit: f64, kind: Kind, seed: u32) -> Scene {
    let mut random = Random([seed, 0]);
    let side = unit * f64::from(n).cbrt() * 0.6;
    let text = |v: [f64; 3]| format!("[{:?}, {:?}, {:?}]", v[0], v[1], v[2]);
    let vector = |random: &mut Random, length: f64| random.vector().to_array().map(|x| f64::from(x) * length);
    let mut quads = String::new();
    let mut spheres = String::new();
    let mut last = String::new();
    for i in 0..n {
        let mut at = vector(&mut random, side);
        let mut u = vector(&mut random, unit);
        let mut v = vector(&mut random, unit);
        let mut radius = unit * (0.2 + 0.5 * f64::from(random.next_unit()));
        match kind {
            Kind::Spread => (),
            Kind::Planes => {
                let axis = i as usize % 3;
                at[axis] = side * f64::from(i % 2);
                (u, v) = ([0.0; 3], [0.0; 3]);
                u[(axis + 1) % 3] = unit * f64::from(1 + i % 4);
                v[(axis + 2) % 3] = -unit * f64::from(1 + i % 3);
                radius = unit / 2.0;
            }
            Kind::Clusters => {
                at = std::array::from_fn(|k| at[k] / 3.0 + [0.0, 300.0, -1000.0][(i as usize + k) % 3] * unit);
            }
            Kind::Degenerate => {
                let factor = 10f64.powi(-((i % 6) as i32)).max(2e-6 / unit);
                if i % 2 == 0 {
                    u = u.map(|x| x * factor);
                } else {
                    v = std::array::from_fn(|k| u[k] + v[k] * factor);
                }
                radius = unit * (1.0 + factor);
                at = at.map(|x| (x / unit / 2.0).round() * 2.0 * unit);
            }
        }
        // No shorter than a scene may have them.
        let longer = |v: [f64; 3]| {
            let length = v.map(|x| x * x).iter().sum::<f64>().sqrt();
            v.map(|x| x * (1.1e-6 / length).max(1.0))
        };
        if i % 3 == 2 {
            let radius = radius.max(1e-6);
            let _ = write!(spheres, "[[spheres]]\ncentre = {}\nradius = {radius:?}\nmaterial = 'm'\n", text(at));
            continue;
        }
        let quad = format!(
            "[[quads]]\ncorner = {}\nedge_u = {}\nedge_v = {}\nmaterial = 'm'\n",
            text(at),
            text(longer(u)),
            text(longer(v))
        );
        quads += if kind == Kind::Planes && i % 4 == 0 && !last.is_empty() { &last } else { &quad };
        last = quad;
    }
    parse(&format!(
        "[camera]\nposition = {}\ntarget = {}\nup = [0.1, 1, 0.2]\nvertical_fov_degrees = 60\n[materials.m]\nkind = 'mirror'\n\
         reflectance = [1, 1, 1]\n{quads}{spheres}[[lights]]\nkind = 'point'\nposition = {}\nintensity = [1, 1, 1]\n",
        text([side, side, side]),
        text([0.0, 0.1 * side, 0.0]),
        text([0.0, side, 0.0])
    ))
}

/// The loop over all primitives.
pub fn linear(origin: Vec3, direction: Vec3, primitives: &[Primitive]) -> Hit {
    let mut best = Hit { t: f32::MAX, primitive: MISS };
    for (i, primitive) in primitives.iter().enumerate() {
        let t = intersect(origin, direction, primitive);
        if t > 0.0 && t < best.t {
            best = Hit { t, primitive: i as u32 };
        }
    }
    best
}

/// A ray of the kinds that paths have, and of those that rounding is worst for. It starts where `last` met something.
pub fn ray(random: &mut Random, scene: &CompiledScene, side: f32, last: Vec3) -> (Vec3, Vec3) {
    let primitive = scene.primitives[random.below(scene.info.primitives) as usize];
    let centre = Vec3::from_array(primitive.position);
    let normal = Vec3::from_array(primitive.normal);
    let mut origin = match random.below(6) {
        0 => centre,
        1 | 2 => last,
        3 => centre + random.vector() * primitive.size.min(side),
        4 if primitive.kind != PRIMITIVE_QUAD => centre + random.direction() * primitive.size,
        _ => random.vector() * side,
    };
    let direction = match random.below(8) {
        0 => [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z][random.below(6) as usize],
        1 => {
            // In a plane of two axes, or almost.
            let mut d = random.direction();
            d[random.below(3) as usize] = [0.0, -0.0, 1e-38, -1e-20, 1e-9][random.below(5) as usize];
            normalize(d)
        }
        // Straight at something, and at an edge of its box.
        2 | 3 if origin != centre => normalize(centre - origin),
        4 => {
            let sphere = primitive.kind != PRIMITIVE_QUAD;
            let corner =
                if sphere { random.direction() * primitive.size } else { random.vector().signum() * side * 1e-3 };
            normalize(centre + corner - origin + Vec3::splat(side * 1e-7))
        }
        // Along a surface.
        5 if primitive.kind == PRIMITIVE_QUAD => {
            let along = normalize(cross(normal, random.direction()));
            origin = centre - along * (side * 0.1 * random.next_unit());
            normalize(along + random.vector() * [0.0, 1e-8, 1e-6, 1e-3][random.below(4) as usize])
        }
        5 => {
            let outwards = random.direction();
            let along = normalize(cross(outwards, random.direction()));
            origin = centre + outwards * primitive.size;
            normalize(along + outwards * [0.0, 1e-9, -1e-9, 1e-4, -1e-4][random.below(5) as usize])
        }
        _ => random.direction(),
    };
    (origin, direction)
}
