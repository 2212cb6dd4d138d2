//! Flat lights by the solid angle that they fill, for points near to them.
//!
//! Drawn by area, a place counts with cos θ′ / d², which has no bound where a surface comes close to a lamp: the mean is right and the
//! variance infinite. Drawn evenly by solid angle it counts with that angle, at most 2π. Far away both are nearly the same and the area is cheaper
//! and loses no digits, so it stays.

use super::known::Known;
use super::scene::{LIGHT_DISC, LIGHT_TRIANGLE, Light};
use super::vector::{cross, dot, invert_disc};
use crate::num::{abs, atan2_turns, div, inv_sqrt, max, min, sin_cos_turns, sqrt};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// A light is near within this many times its radius, squared. Outside, cos θ′ / d² is at most 8 times as large at one place as at another: (3 + 1)³ /
/// (3 − 1)³.
const NEAR: f32 = 9.0;
/// sr, below which a near light, then seen from aside, is drawn by area after all.
const SMALLEST: f32 = 1e-6;

/// A spherical triangle: unit vectors to a corner, the apex, and to the ends of the side that faces it.
///
/// Of volume V between the vectors, its solid angle is 2·atan2(V, 1 + a·b + a·c + b·c) (Van Oosterom and Strackee, "The Solid Angle of a Plane
/// Triangle", IEEE Trans. Biomed. Eng. 1983).
#[derive(Clone, Copy)]
struct Triangle {
    // Not vectors, which wgpu's translator would not let stand side by side in a struct.
    apex: [f32; 3],
    start: [f32; 3],
    end: [f32; 3],
    volume: f32,
    /// Half its solid angle, as a part of 2π.
    half: f32,
}

impl Triangle {
    #[inline]
    fn new(apex: Vec3, start: Vec3, end: Vec3, volume: f32) -> Self {
        let along = 1.0 + dot(apex, start) + dot(apex, end) + dot(start, end);
        Self {
            apex: apex.to_array(),
            start: start.to_array(),
            end: end.to_array(),
            volume,
            half: atan2_turns(volume, along),
        }
    }

    /// The unit vectors to the apex, the start and the end.
    #[inline]
    fn corners(&self) -> (Vec3, Vec3, Vec3) {
        (Vec3::from_array(self.apex), Vec3::from_array(self.start), Vec3::from_array(self.end))
    }

    /// Weights of the apex, start and end in the direction that is drawn evenly by (u, v): `u` turns the side from the apex to its end
    /// point from the start to the end, and `v` goes along it (Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995, in the form of
    /// Peters, "BRDF Importance Sampling for Polygonal Lights", ACM TOG 2021, section 4).
    #[inline]
    fn weights(&self, u: f32, v: f32) -> [f32; 3] {
        let (apex, start, end) = self.corners();
        let (sin, cos) = sin_cos_turns(u * self.half);
        // Over the volume, so that slim triangles do not underflow.
        let sin = div(sin, self.volume);
        let x = cos - sin * (dot(apex, end) + dot(start, end));
        let y = sin * (1.0 + dot(apex, start));
        let middle = start * x + end * y;
        let scale = 2.0 * div(dot(start, middle), dot(middle, middle));
        let (x, y) = (scale * x - 1.0, scale * y);
        let side = start * x + end * y;
        // 1 − cos by the chord, which keeps its digits where the cosine has none.
        let chord = side - apex;
        let whole = 0.5 * dot(chord, chord);
        let part = v * whole;
        // The side's part across the apex, whose length is the sine.
        let across = chord + apex * whole;
        let along = sqrt(div(part * (2.0 - part), max(1e-30, dot(across, across))));
        [max(0.0, 1.0 - part - along * (1.0 - whole)), max(0.0, along * x), max(0.0, along * y)]
    }
}

/// A flat light as two triangles about one corner, or one triangle.
#[derive(Clone, Copy)]
pub struct Fan {
    first: Triangle,
    second: Triangle,
    /// One over the distances of the corners: that of the apex, and on from there.
    closeness: [f32; 4],
    /// Solid angle, sr; 0 of a light that is to be drawn by area. A disc's is that of the parallelogram about it, of which the rest has no light.
    pub solid_angle: f32,
}

impl Fan {
    /// The flat light as it is seen from a point.
    #[inline]
    #[must_use]
    pub fn new(known: impl Known, light: &Light, from: Vec3) -> Self {
        let (mut a, mut b) = (Vec3::from_array(light.edges[0]), Vec3::from_array(light.edges[1]));
        let mut corner = Vec3::from_array(light.position) - from;
        let mut twice = light.area;
        if known.lamps() && light.kind == LIGHT_TRIANGLE {
            twice *= 2.0;
        }
        if known.lamps() && light.kind == LIGHT_DISC {
            corner -= a + b;
            a *= 2.0;
            b *= 2.0;
            twice *= 4.0 / PI;
        }
        let middle = corner + (a + b) * 0.5;
        let radius2 = 0.25 * max(dot(a + b, a + b), dot(a - b, a - b));
        let height = -dot(Vec3::from_array(light.normal), corner);
        let nothing = Triangle { apex: [0.0; 3], start: [0.0; 3], end: [0.0; 3], volume: 0.0, half: 0.0 };
        let mut fan = Self { first: nothing, second: nothing, closeness: [0.0; 4], solid_angle: 0.0 };
        if height > 0.0 && dot(middle, middle) < NEAR * radius2 {
            let one = corner + a;
            let triangle = known.lamps() && light.kind == LIGHT_TRIANGLE;
            let two = if triangle { corner + b } else { one + b };
            let three = corner + b;
            let closeness = [
                inv_sqrt(dot(corner, corner)),
                inv_sqrt(dot(one, one)),
                inv_sqrt(dot(two, two)),
                inv_sqrt(dot(three, three)),
            ];
            let apex = corner * closeness[0];
            // The volume that each triangle's edges have with the point, over their lengths.
            let share = (height * closeness[0]) * (twice * closeness[2]);
            fan.first = Triangle::new(apex, one * closeness[1], two * closeness[2], share * closeness[1]);
            let mut half = fan.first.half;
            if !triangle {
                // Turned against the first: the corner that may be straight across from the apex, as seen from right under a lamp, is the end of both,
                // where it costs no digits.
                fan.second = Triangle::new(apex, three * closeness[3], two * closeness[2], share * closeness[3]);
                half += fan.second.half;
            }
            fan.closeness = closeness;
            let solid_angle = half * (4.0 * PI);
            if solid_angle > SMALLEST {
                fan.solid_angle = solid_angle;
            }
        }
        fan
    }

    /// The numbers by which [`light_point`](super::light::light_point) draws the place that (u, v) draw evenly by solid angle, of a fan that has one;
    /// negative where that is beside a disc.
    #[inline]
    #[must_use]
    pub fn place(&self, known: impl Known, light: &Light, u: f32, v: f32) -> [f32; 2] {
        let all = self.first.half + self.second.half;
        let at = u * all;
        let mut place = [0.0; 2];
        if at < self.first.half {
            let [apex, start, end] = self.first.weights(div(at, self.first.half), v);
            let [start, end] = [start * self.closeness[1], end * self.closeness[2]];
            let scale = div(1.0, apex * self.closeness[0] + start + end);
            place = [start * scale, end * scale];
            if self.second.half > 0.0 {
                place[0] = min(1.0, place[0] + place[1]);
            }
        } else if self.second.half > 0.0 {
            let [apex, start, end] = self.second.weights(min(1.0, div(all - at, self.second.half)), v);
            let [start, end] = [start * self.closeness[3], end * self.closeness[2]];
            let scale = div(1.0, apex * self.closeness[0] + start + end);
            place = [end * scale, min(1.0, (start + end) * scale)];
        }
        if known.lamps() && light.kind == LIGHT_TRIANGLE {
            place[1] = min(place[1], 1.0 - place[0]);
        }
        if known.lamps() && light.kind == LIGHT_DISC {
            let [x, y] = [place[0] * 2.0 - 1.0, place[1] * 2.0 - 1.0];
            place = if x * x + y * y > 1.0 { [-1.0; 2] } else { invert_disc([x, y]) };
        }
        place
    }

    /// The numbers (u, v) that [`place`](Self::place) turned into the point at `x` and `y` of the edges from the apex.
    #[inline]
    #[must_use]
    pub fn invert(&self, x: f32, y: f32) -> [f32; 2] {
        let all = self.first.half + self.second.half;
        let quad = self.second.half > 0.0;
        let is_first = !quad || x >= y;
        let triangle = if is_first { self.first } else { self.second };
        let (apex, from, to) = triangle.corners();
        let mut shares = [x, y];
        let mut closeness = [self.closeness[1], self.closeness[2]];
        if quad && is_first {
            shares[0] = x - y;
        } else if quad {
            shares = [y - x, x];
            closeness = [self.closeness[3], self.closeness[2]];
        }
        let [start, end] = [div(shares[0], closeness[0]), div(shares[1], closeness[1])];
        let side = from * start + to * end;
        let direction = side + apex * div(1.0 - shares[0] - shares[1], self.closeness[0]);
        let side = side * inv_sqrt(dot(side, side));
        let chord = direction * inv_sqrt(dot(direction, direction)) - apex;
        let whole = side - apex;
        let volume = dot(apex, cross(from - apex, side - apex));
        let part = Triangle::new(apex, from, side, abs(volume)).half;
        let at = if is_first { part } else { all - part };
        [div(at, all), min(1.0, div(dot(chord, chord), dot(whole, whole)))]
    }
}
