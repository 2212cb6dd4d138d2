//! Meshes that are made and not read: what `file = "built-in:NAME"` stands for.
//!
//! All of it is arithmetic that gives the same bits on every machine.

use super::model::{Finish, Model, Part};
use super::sky::Panorama;
use caustic_kernels::num::{pcg4d, sin_cos_turns};
use glam::{DVec2, DVec3};

/// Names of the meshes.
pub(super) const GENERATED: [&str; 2] = ["hall", "landscape"];

/// The mesh of this name.
pub(super) fn model(name: &str) -> Option<Model> {
    let parts = match name {
        "hall" => hall(),
        "landscape" => vec![landscape()],
        _ => return None,
    };
    Some(Model { parts, finishes: vec![Finish::default()], ..Model::default() })
}

/// The name of the environment that is made.
pub(super) const SKY: &str = "built-in:sky";

/// A clear sky with the sun, 40° above the horizon a little to the right of straight ahead, over a dark ground.
///
/// A vertical gradient, a wide and a narrow glow about the sun that are powers of the cosine of the angle from it, and the sun itself as a steeper
/// one, 2° wide so that some pixels hold it.
pub(super) fn sky() -> Panorama {
    const WIDTH: usize = 512;
    const HEIGHT: usize = 256;
    const ZENITH: DVec3 = DVec3::new(0.16, 0.32, 0.75);
    const HORIZON: DVec3 = DVec3::new(0.62, 0.72, 0.82);
    const GROUND: DVec3 = DVec3::new(0.11, 0.1, 0.09);
    const SUN: DVec3 = DVec3::new(1.0, 0.86, 0.66);
    /// To the power 2ⁿ.
    fn power(x: f64, n: u32) -> f64 {
        (0..n).fold(x.max(0.0), |x, _| x * x)
    }
    let [side, up] = [turn(0.06), turn(40.0 / 360.0)];
    let sun = DVec3::new(side.y * up.x, up.y, -side.x * up.x);
    let mut rgb = Vec::with_capacity(WIDTH * HEIGHT);
    for row in 0..HEIGHT {
        let from_zenith = turn((row as f64 + 0.5) / (2 * HEIGHT) as f64);
        for column in 0..WIDTH {
            let around = turn((column as f64 + 0.5) / WIDTH as f64 - 0.5);
            let d = DVec3::new(from_zenith.y * around.y, from_zenith.x, -from_zenith.y * around.x);
            let low = power(1.0 - d.y.abs(), 2);
            let radiance = if d.y < 0.0 {
                GROUND + (HORIZON * 0.4 - GROUND) * low * low
            } else {
                let near = d.dot(sun);
                let glow = 0.6 * power(near, 3) + 4.0 * power(near, 7);
                ZENITH + (HORIZON - ZENITH) * low + SUN * (glow + 2200.0 * power(near, 13))
            };
            rgb.push(radiance.as_vec3().to_array());
        }
    }
    Panorama { width: WIDTH, height: HEIGHT, rgb, name: SKY.to_string() }
}

/// Sine and cosine of a part of a turn.
fn turn(part: f64) -> DVec2 {
    let (sin, cos) = sin_cos_turns(part as f32);
    DVec2::new(cos.into(), sin.into())
}

impl Part {
    fn point(&mut self, position: DVec3, normal: DVec3) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.positions.len() as u32 - 1
    }

    /// A flat quadrilateral, counter-clockwise from the front.
    fn flat(&mut self, corners: [DVec3; 4]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let [a, b, c, d] = corners.map(|corner| self.point(corner, normal));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// What a profile of (radius, height) makes turned about the vertical through `foot`.
    fn turned(&mut self, foot: DVec3, profile: &[[f64; 2]], sides: u32) {
        for pair in profile.windows(2) {
            let [[r0, y0], [r1, y1]] = [pair[0], pair[1]];
            let slope = DVec2::new(y1 - y0, r0 - r1).normalize();
            let mut ring = Vec::new();
            for i in 0..=sides {
                let at = turn(f64::from(i % sides) / f64::from(sides));
                let normal = DVec3::new(at.x * slope.x, slope.y, at.y * slope.x);
                let on = |r: f64, y: f64| foot + DVec3::new(at.x * r, y, at.y * r);
                ring.push([self.point(on(r0, y0), normal), self.point(on(r1, y1), normal)]);
            }
            for two in ring.windows(2) {
                let ([a, b], [d, c]) = (two[0], two[1]);
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
}

/// Length of a bay of the hall, m.
const BAY: f64 = 4.0;
/// Bays.
const BAYS: u32 = 5;
/// Height of the columns, where the arches begin, m.
const SPRING: f64 = 4.0;
/// Half the thickness of the arcades, m.
const HALF: f64 = 0.35;
/// Where the arcades stand, to both sides of the middle, m.
const ASIDE: f64 = 3.2;
/// Height of the arcades, m.
const TOP: f64 = 9.0;

/// Two arcades of round arches on columns, along x: the floor, the walls and the roof are of quads.
fn hall() -> Vec<Part> {
    let mut columns = Part { name: "columns".into(), finish: Some(0), ..Part::default() };
    let mut arches = Part { name: "arches".into(), finish: Some(0), ..Part::default() };
    const PROFILE: [[f64; 2]; 9] = [
        [0.55, 0.0],
        [0.55, 0.2],
        [0.42, 0.3],
        [0.36, 0.45],
        [0.3, 3.3],
        [0.3, 3.35],
        [0.38, 3.45],
        [0.52, 3.75],
        [0.52, SPRING],
    ];
    let start = -f64::from(BAYS) * BAY / 2.0;
    for side in [-ASIDE, ASIDE] {
        for i in 0..=BAYS {
            let x = start + f64::from(i) * BAY;
            columns.turned(DVec3::new(x, 0.0, side), &PROFILE, 20);
        }
        for i in 0..BAYS {
            arch(&mut arches, start + (f64::from(i) + 0.5) * BAY, side);
        }
    }
    vec![columns, arches]
}

/// One bay of an arcade above its columns: a wall with a half circle cut out, from both sides, and the vault of the arch.
fn arch(part: &mut Part, middle: f64, side: f64) {
    const STEPS: u32 = 24;
    let radius = BAY / 2.0 - 0.45;
    let at = |i: u32| {
        let on = turn(0.5 * f64::from(i) / f64::from(STEPS));
        DVec2::new(middle + radius * on.x, SPRING + radius * on.y)
    };
    let [front, back] = [side + HALF, side - HALF];
    let place = |p: DVec2, z: f64| DVec3::new(p.x, p.y, z);
    for i in 0..STEPS {
        let (a, b) = (at(i), at(i + 1));
        // The wall above this piece of the arch.
        let (up_a, up_b) = (DVec2::new(a.x, TOP), DVec2::new(b.x, TOP));
        part.flat([place(b, front), place(a, front), place(up_a, front), place(up_b, front)]);
        part.flat([place(a, back), place(b, back), place(up_b, back), place(up_a, back)]);
        let inwards = |p: DVec2| place((DVec2::new(middle, SPRING) - p).normalize(), 0.0);
        let vault = [(a, front), (b, front), (b, back), (a, back)].map(|(p, z)| part.point(place(p, z), inwards(p)));
        part.triangles.extend([[vault[0], vault[1], vault[2]], [vault[0], vault[2], vault[3]]]);
    }
    // The wall beside the arch, over the columns.
    for (x0, x1) in [(middle - BAY / 2.0, middle - radius), (middle + radius, middle + BAY / 2.0)] {
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        part.flat([
            corner(x0, SPRING, front),
            corner(x1, SPRING, front),
            corner(x1, TOP, front),
            corner(x0, TOP, front),
        ]);
        part.flat([corner(x1, SPRING, back), corner(x0, SPRING, back), corner(x0, TOP, back), corner(x1, TOP, back)]);
        part.flat([
            corner(x0, SPRING, back),
            corner(x1, SPRING, back),
            corner(x1, SPRING, front),
            corner(x0, SPRING, front),
        ]);
    }
}

/// Side of the landscape, m.
const WIDE: f64 = 6000.0;
/// Cells along a side.
const CELLS: u32 = 160;

/// Hills around a valley, 6 km wide.
fn landscape() -> Part {
    let mut part = Part { name: "landscape".into(), finish: Some(0), ..Part::default() };
    let step = WIDE / f64::from(CELLS);
    let place = |i: f64, k: f64| {
        let (x, z) = (i * step - WIDE / 2.0, k * step - WIDE / 2.0);
        DVec3::new(x, height(x, z), z)
    };
    for k in 0..=CELLS {
        for i in 0..=CELLS {
            let (i, k) = (f64::from(i), f64::from(k));
            let normal = (place(i, k + 0.5) - place(i, k - 0.5)).cross(place(i + 0.5, k) - place(i - 0.5, k));
            part.point(place(i, k), normal);
        }
    }
    let row = CELLS + 1;
    for k in 0..CELLS {
        for i in 0..CELLS {
            let a = k * row + i;
            part.triangles.extend([[a, a + row, a + row + 1], [a, a + row + 1, a + 1]]);
        }
    }
    part
}

/// Height of the ground, m: octaves of noise that grow with the distance from the middle of a valley along z.
fn height(x: f64, z: f64) -> f64 {
    let valley = ((x + 500.0 * noise(DVec2::new(0.0, z) / 1800.0, 9)).abs() / 1500.0).min(1.0);
    let mut sum = 0.0;
    let (mut size, mut share) = (1300.0, 420.0);
    for octave in 0..6 {
        // Ridges where the noise crosses its middle.
        let ridge = 1.0 - (2.0 * noise(DVec2::new(x, z) / size, octave) - 1.0).abs();
        sum += share * ridge * ridge;
        (size, share) = (size * 0.48, share * 0.42);
    }
    sum * valley * valley * (3.0 - 2.0 * valley)
}

/// Smooth noise from 0 to 1 with a value a unit square's corner (Perlin, "An Image Synthesizer", 1985, in its plainest form).
fn noise(at: DVec2, octave: u32) -> f64 {
    let cell = at.floor();
    let part = at - cell;
    let smooth = part * part * (DVec2::splat(3.0) - 2.0 * part);
    let value = |i: f64, k: f64| {
        let corner = [(cell.x + i) as i32 as u32, (cell.y + k) as i32 as u32];
        f64::from(pcg4d([corner[0], corner[1], octave, 0x1a2d])[0]) / 4_294_967_296.0
    };
    let near = value(0.0, 0.0) * (1.0 - smooth.x) + value(1.0, 0.0) * smooth.x;
    let far = value(0.0, 1.0) * (1.0 - smooth.x) + value(1.0, 1.0) * smooth.x;
    near * (1.0 - smooth.y) + far * smooth.y
}
