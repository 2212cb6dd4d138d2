//! Each sampler of lights, lenses and directions against its density and its inverse.

use super::*;
use crate::num::{pcg4d, sobol2, u32_to_unit};
use crate::trace::ALL;
use crate::trace::chi_square::{limit, of_directions, of_disc, on_sphere};
use crate::trace::sky::{sample_sky, sky_density, sky_place};
use crate::trace::vector::{cosine_density, invert_cosine, sample_cosine};
use crate::trace::{Camera, LIGHT_POINT, NO_LIGHT, invert_lens, lens_density, lens_point};
use std::vec;
use std::vec::Vec;

fn random(i: u32, stream: u32) -> [f32; 2] {
    let [u, v, ..] = pcg4d([i, stream, 0x119e, 7]).map(u32_to_unit);
    [u, v]
}

/// A light without anything.
const NO_LIGHT_YET: Light = Light {
    emission: [1.0; 3],
    kind: 0,
    position: [0.0; 3],
    primitive: NO_LIGHT,
    edges: [[0.0; 3]; 2],
    normal: [0.0; 3],
    area: 0.0,
    probability: 0.0,
    cumulative: 0.0,
    first_photon: 0,
    photons: 0,
    first_target: 0,
    targets: 0,
    texture: NO_TEXTURE,
};

/// Where lights are looked at from.
const FROM: Vec3 = Vec3::new(0.2, -0.1, 0.3);

/// A light of each kind that has an extent, all within some metres of [`FROM`] and facing it; the flat ones near and far, as [`Fan`] draws them
/// by solid angle or not.
fn lights() -> Vec<Light> {
    let flat = |kind, position: [f32; 3], edges: [[f32; 3]; 2], part: f32| {
        let normal = cross(Vec3::from_array(edges[0]), Vec3::from_array(edges[1]));
        let area = dot(normal, normal).sqrt();
        let normal = (normal / area).to_array();
        Light { kind, position, edges, normal, area: area * part, probability: 1.0, ..NO_LIGHT_YET }
    };
    // x × z = −y: they look down.
    let edges = [[2.0, 0.3, 0.1], [-0.2, 0.4, 1.5]];
    let sphere = |radius: f32, height: f32| Light {
        kind: LIGHT_SPHERE,
        position: [0.3, height, -0.5],
        edges: [[radius, 0.0, 0.0], [0.0; 3]],
        probability: 1.0,
        ..NO_LIGHT_YET
    };
    let sky = Light {
        kind: LIGHT_ENVIRONMENT,
        emission: [2.0; 3],
        edges: [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0]],
        probability: 1.0,
        ..NO_LIGHT_YET
    };
    vec![
        flat(LIGHT_AREA, [-1.0, 1.2, -0.6], edges, 1.0),
        flat(LIGHT_TRIANGLE, [-1.0, 1.2, -0.6], edges, 0.5),
        flat(LIGHT_DISC, [0.1, 1.4, 0.2], edges, PI),
        flat(LIGHT_AREA, [-1.0, 4.2, -0.6], edges, 1.0),
        flat(LIGHT_TRIANGLE, [-1.0, 4.2, -0.6], edges, 0.5),
        flat(LIGHT_DISC, [0.1, 7.2, 0.2], edges, PI),
        sphere(0.9, 1.4),
        sphere(0.05, 3.0),
        sky,
    ]
}

const WIDTH: u32 = 16;
const HEIGHT: u32 = 8;

/// A picture of 16 × 8 random texels, some of them black, with its tables.
fn sky() -> (SceneInfo, [Texture; 1], Vec<Texel>) {
    let chances = |weights: &[f32]| {
        let all: f32 = weights.iter().sum();
        let mut sum = 0.0;
        let mut before = 0.0f32;
        let mut entries = Vec::new();
        for (i, weight) in weights.iter().enumerate() {
            sum += weight;
            let steps = 16_777_216.0;
            let end = if i + 1 == weights.len() { 1.0 } else { (sum / all * steps).round() / steps };
            entries.push(Texel { rg: end.to_bits(), ba: (end - before).to_bits() });
            before = end;
        }
        entries
    };
    let weight = |i: u32| 0.05 + random(i, 9)[0] * random(i, 9)[1];
    let mut texels: Vec<Texel> =
        (0..WIDTH * HEIGHT).map(|i| Texel { rg: 0x3c00 + i, ba: if i % 3 == 0 { 0 } else { 0x3800 } }).collect();
    texels.extend(chances(&(0..HEIGHT).map(|y| weight(1000 + y)).collect::<Vec<_>>()));
    for y in 0..HEIGHT {
        texels.extend(chances(&(0..WIDTH).map(|x| weight(y * WIDTH + x)).collect::<Vec<_>>()));
    }
    let info = SceneInfo { environment: 0, sky: 0, ..SceneInfo::default() };
    (info, [Texture { first: 0, width: WIDTH, height: HEIGHT, wrap: 4 }], texels)
}

/// How far a ray from [`FROM`] to the front of a surface light is, if it meets it.
fn met(light: &Light, direction: Vec3) -> Option<f32> {
    let position = Vec3::from_array(light.position);
    if light.kind == LIGHT_SPHERE {
        let axis = position - FROM;
        let inside = dot(direction, normalize(axis)) >= 1.0 - cone(axis, light.edges[0][0]);
        return inside.then_some(1.0);
    }
    let normal = Vec3::from_array(light.normal);
    let distance = dot(position - FROM, normal) / dot(direction, normal);
    if distance <= 0.0 || dot(direction, normal) >= 0.0 {
        return None;
    }
    let place = FROM + direction * distance - position;
    let [a, b] = [Vec3::from_array(light.edges[0]), Vec3::from_array(light.edges[1])];
    // place = x·a + y·b in the plane of a and b.
    let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
    let (pa, pb) = (dot(place, a), dot(place, b));
    let det = aa * bb - ab * ab;
    let (x, y) = ((pa * bb - pb * ab) / det, (pb * aa - pa * ab) / det);
    let inside = match light.kind {
        LIGHT_DISC => x * x + y * y <= 1.0,
        LIGHT_TRIANGLE => x >= 0.0 && y >= 0.0 && x + y <= 1.0,
        _ => (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y),
    };
    inside.then_some(distance)
}

/// Directions that [`look`] draws follow [`look_density`], or [`sky_density`], of which nothing is left of 1; and so they do not if these
/// are 5 % too large.
#[test]
fn looks_follow_their_density() {
    let (info, textures, texels) = sky();
    for light in lights() {
        let is_sky = light.kind == LIGHT_ENVIRONMENT;
        let axis = if is_sky { Vec3::Y } else { normalize(Vec3::from_array(light.position) - FROM) };
        // Cells about another axis than the light's, so that its edges are none of theirs.
        let axis = normalize(axis + Vec3::new(0.2, 0.1, -0.1));
        let density = |direction: Vec3| {
            if is_sky {
                return sky_density(&light, direction, &info, &textures, &texels);
            }
            met(&light, direction).map_or(0.0, |distance| look_density(ALL, &light, FROM, direction, distance))
        };
        // A small light is in few cells, whose quadrature is coarse.
        if light.kind == LIGHT_SPHERE && light.edges[0][0] < 0.1 {
            continue;
        }
        let sample = |i| {
            let [u, v] = random(i, 3);
            let glimpse = look(ALL, &light, FROM, u, v, &info, &[], &textures, &texels);
            (glimpse.distance > 0.0).then_some(glimpse.direction)
        };
        let what = std::format!("light kind {}", light.kind);
        of_directions(axis, sample, density, &what).judge(1.05, &what);
    }
}

/// What [`look`] says of the place that it drew is the density, once more: an irradiance for an emission of 1 is cos / density.
#[test]
fn looks_know_their_density() {
    let (info, textures, texels) = sky();
    for light in lights() {
        for i in 0..2000 {
            let [u, v] = random(i, 4);
            let glimpse = look(ALL, &light, FROM, u, v, &info, &[], &textures, &texels);
            if glimpse.distance <= 0.0 {
                continue; // beside a disc
            }
            let density = if light.kind == LIGHT_ENVIRONMENT {
                sky_density(&light, glimpse.direction, &info, &textures, &texels)
            } else {
                look_density(ALL, &light, FROM, glimpse.direction, glimpse.distance)
            };
            let found = glimpse.geometry(0.5, 0.25) * density;
            assert!((found - 2.0).abs() < 1e-3, "light kind {}: {found} at {u}, {v}", light.kind);
        }
    }
}

#[test]
fn looks_have_an_inverse() {
    let (info, textures, texels) = sky();
    for light in lights() {
        let mut worst = 0f32;
        for i in 0..20_000 {
            let [u, v] = random(i, 5);
            // The places of a disc near its middle and the directions near a pole have no angle to speak of.
            let [u, v] = [u * 0.98 + 0.01, v * 0.98 + 0.01];
            let Glimpse { direction, distance, .. } = look(ALL, &light, FROM, u, v, &info, &[], &textures, &texels);
            if distance <= 0.0 {
                continue; // beside a disc
            }
            let [mut x, mut y] = invert_look(ALL, &light, FROM, direction, &info, &textures, &texels);
            let folded = Fan::new(ALL, &light, FROM).solid_angle == 0.0 && u + v > 1.0;
            if light.kind == LIGHT_TRIANGLE && folded {
                (x, y) = (1.0 - x, 1.0 - y);
            }
            worst = worst.max((x - u).abs()).max((y - v).abs());
        }
        // The small sphere is a hundredth of a radian wide: its directions have 2⁻¹⁷ of that.
        let allowed = if light.kind == LIGHT_SPHERE && light.edges[0][0] < 0.1 { 1e-4 } else { 1e-5 };
        std::println!("light kind {}: the inverse is off by {worst:.1e}", light.kind);
        assert!(worst < allowed, "light kind {}: {worst}", light.kind);
    }
}

/// Irradiance under the middle of a square lamp of radiance 1, at any height: the mean over places is the form factor's (Howell, "A Catalog of
/// Radiation Heat Transfer Configuration Factors", C-1), and no place counts with more than the half space.
#[test]
fn a_lamp_that_touches_a_surface_counts_with_its_solid_angle() {
    let light = Light {
        kind: LIGHT_AREA,
        edges: [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0]],
        normal: [0.0, -1.0, 0.0],
        area: 4.0,
        probability: 1.0,
        ..NO_LIGHT_YET
    };
    let (info, textures, texels) = sky();
    // Far away by area, near by solid angle, and so near that the lamp is all that is seen.
    for height in [8.0f32, 3.0, 1.0, 0.1, 1e-3, 1e-5] {
        let from = Vec3::new(1.0, -height, 1.0);
        let side = 1.0 / f64::from(height);
        let long = side.hypot(1.0);
        // Four corners, π of each form factor.
        let exact = 4.0 * side / long * (side / long).atan();
        let (mut sum, mut most) = (0.0, 0f32);
        let samples = 1 << 14;
        for i in 0..samples {
            let [u, v] = sobol2(i, [0x51de, 0x7a11]);
            let glimpse = look(ALL, &light, from, u, v, &info, &[], &textures, &texels);
            let seen = glimpse.geometry(1.0, 1.0);
            sum += f64::from(seen * glimpse.direction.y);
            most = most.max(seen);
        }
        let found = sum / f64::from(samples);
        std::println!("height {height:.0e}: {found:.6} of {exact:.6}, {most} at most");
        // The way straight up has to be found to a height's part of the lamp's width: of the 6e-8 that a float resolves, that is 6e-5 for the last
        // height but one and a hundred times as much for the last.
        let allowed = if height < 1e-4 { 1e-2 } else { 1e-4 };
        assert!((found / exact - 1.0).abs() < allowed, "height {height}: {found}, not {exact}");
        assert!(most <= 2.0 * PI * 1.000_001, "height {height}: one place counts with {most} sr");
    }
}

#[test]
fn a_sky_is_drawn_where_it_is_seen() {
    let (info, textures, texels) = sky();
    let light = lights().pop().unwrap();
    for i in 0..20_000 {
        let [u, v] = random(i, 6);
        let drawn = sample_sky(&light, u, v, &info, &textures, &texels);
        assert!((drawn.direction.length() - 1.0).abs() < 1e-6);
        // But for those on the edge of a pixel.
        let [x, y] = sky_place(&light, drawn.direction);
        let edge = |at: f32, size: u32| (at * size as f32 - (at * size as f32).round()).abs() < 1e-4;
        let density = sky_density(&light, drawn.direction, &info, &textures, &texels);
        assert!(edge(x, WIDTH) || edge(y, HEIGHT) || (density / drawn.density - 1.0).abs() < 1e-5, "{u}, {v}");
    }
}

/// The cosine's and the cone's directions: densities, inverses, and that the densities add up to 1.
#[test]
fn directions_follow_their_density_and_have_an_inverse() {
    let n = normalize(Vec3::new(0.3, -0.5, 0.8));
    let cosine = (
        "cosine",
        (|n, u, v| sample_cosine(n, u, v)) as fn(Vec3, f32, f32) -> Vec3,
        (|n, d| cosine_density(n, d)) as fn(Vec3, Vec3) -> f32,
        (|n, d| invert_cosine(n, d)) as fn(Vec3, Vec3) -> [f32; 2],
    );
    fn within<const MILLI: u32>(n: Vec3, d: Vec3) -> f32 {
        let h = MILLI as f32 / 1000.0;
        if dot(n, d) >= 1.0 - h { cone_density(h) } else { 0.0 }
    }
    let (wide, sphere) = (
        (
            "cone",
            (|n, u, v| sample_cone(n, 0.4, u, v)) as fn(Vec3, f32, f32) -> Vec3,
            within::<400> as fn(Vec3, Vec3) -> f32,
            (|n, d| invert_cone(n, 0.4, d)) as fn(Vec3, Vec3) -> [f32; 2],
        ),
        (
            "sphere",
            (|n, u, v| sample_cone(n, 2.0, u, v)) as fn(Vec3, f32, f32) -> Vec3,
            within::<2000> as fn(Vec3, Vec3) -> f32,
            (|n, d| invert_cone(n, 2.0, d)) as fn(Vec3, Vec3) -> [f32; 2],
        ),
    );
    for (what, sample, density, invert) in [cosine, wide, sphere] {
        let drawn = |i| {
            let [u, v] = random(i, 7);
            Some(sample(n, u, v))
        };
        let axis = normalize(n + Vec3::new(0.2, 0.1, -0.1));
        of_directions(axis, drawn, |d| density(n, d), what).judge(1.05, what);
        for i in 0..20_000 {
            let [u, v] = random(i, 8).map(|x| x * 0.98 + 0.01);
            let [x, y] = invert(n, sample(n, u, v));
            assert!((x - u).abs() < 2e-6 && (y - v).abs() < 2e-6, "{what}: {u}, {v} become {x}, {y}");
        }
    }
    // Every direction has a place in the frame.
    assert!((0..1000).all(|i| dot(on_sphere(n, f64::from(i) / 1000.0, 0.3), n).abs() <= 1.0 + 1e-6));
}

#[test]
fn a_lens_is_drawn_evenly_and_has_an_inverse() {
    let lens = [[0.03, 0.04, 0.0], [-0.04, 0.03, 0.0]];
    let camera = Camera { lens, focus: 2.0, ..Camera::default() };
    let local = |point: Vec3| lens.map(|axis| dot(point, Vec3::from_array(axis)) / 0.0025);
    let drawn = |i| {
        let [u, v] = random(i, 10);
        local(lens_point(&camera, u, v))
    };
    of_disc(drawn).judge(1.05, "lens");
    // A polar map without its root crowds the middle.
    let (chi2, cells) = of_disc(|i| drawn(i).map(|x| x * random(i, 10)[0].sqrt())).chi_square(1.0);
    assert!(chi2 > limit(cells), "{chi2}");
    assert!((lens_density(&camera) * PI * 0.0025 - 1.0).abs() < 1e-6);
    for i in 0..20_000 {
        let [u, v] = random(i, 11).map(|x| x * 0.98 + 0.01);
        let [x, y] = invert_lens(&camera, lens_point(&camera, u, v));
        assert!((x - u).abs() < 2e-6 && (y - v).abs() < 2e-6, "{u}, {v} become {x}, {y}");
    }
}

/// Lights are chosen with the chances that they have on record.
#[test]
fn lights_are_chosen_with_their_chances() {
    const LIGHTS: usize = 37;
    let mut lights = vec![Light { kind: LIGHT_POINT, primitive: NO_LIGHT, ..NO_LIGHT_YET }; LIGHTS];
    let mut cumulative = 0.0;
    for (i, light) in lights.iter_mut().enumerate() {
        light.probability = if i + 1 == LIGHTS { 1.0 - cumulative } else { (1 + i % 5) as f32 / 128.0 };
        cumulative += light.probability;
        light.cumulative = cumulative;
    }
    let info = SceneInfo { lights: LIGHTS as u32, ..SceneInfo::default() };
    let samples = 1 << 17;
    let mut found = [0.0; LIGHTS];
    for i in 0..samples {
        found[choose_light(random(i, 12)[0], &info, &lights) as usize] += 1.0;
    }
    let chi2: f64 = found
        .iter()
        .zip(&lights)
        .map(|(found, light)| {
            let expected = f64::from(light.probability) * f64::from(samples);
            (found - expected).powi(2) / expected
        })
        .sum();
    assert!(chi2 < limit(LIGHTS - 1) && chi2 > 5.0, "{chi2}");
}
