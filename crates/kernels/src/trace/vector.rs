//! Directions: frames, reflection, packing. Vectors are glam's; everything that divides or takes a root goes through
//! [`num`](crate::num), because the devices' own operations differ in the last bits.

use crate::num::{abs, atan2_turns, div, floor_to_i32, inv_sqrt, max, min, sin_cos_turns, sqrt};
use glam::Vec3;

const PI: f32 = core::f32::consts::PI;

/// `a · b`, summed in the order of the axes.
#[inline]
#[must_use]
pub fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// `a × b`.
#[inline]
#[must_use]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// `v` at unit length.
#[inline]
#[must_use]
pub fn normalize(v: Vec3) -> Vec3 {
    v * inv_sqrt(dot(v, v))
}

/// The mirror image of direction `d` at a surface of unit normal `n`.
#[inline]
#[must_use]
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    normalize(d - n * (2.0 * dot(d, n)))
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al., "Building an Orthonormal Basis,
/// Revisited", JCGT 2017).
#[inline]
#[must_use]
pub fn frame(n: Vec3) -> (Vec3, Vec3) {
    let mut sign = 1.0;
    if n.z < 0.0 {
        sign = -1.0;
    }
    let a = div(-1.0, sign + n.z);
    let b = n.x * n.y * a;
    let t = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let s = Vec3::new(b, sign + n.y * n.y * a, -n.y);
    (t, s)
}

/// Turns (x, y, z) from the [`frame`] whose third axis is the unit vector `n` into the world's.
#[inline]
#[must_use]
pub fn from_frame(n: Vec3, x: f32, y: f32, z: f32) -> Vec3 {
    let (t, s) = frame(n);
    normalize(t * x + s * y + n * z)
}

/// Turns a vector from the world's frame into the [`frame`] whose third axis is the unit vector `n`.
#[inline]
#[must_use]
pub fn to_frame(n: Vec3, v: Vec3) -> Vec3 {
    let (t, s) = frame(n);
    Vec3::new(dot(v, t), dot(v, s), dot(v, n))
}

/// A point of the disc of radius 1, evenly drawn, from two uniform numbers.
#[inline]
#[must_use]
pub fn sample_disc(u: f32, v: f32) -> [f32; 2] {
    let r = sqrt(u);
    let (sin, cos) = sin_cos_turns(v);
    [r * cos, r * sin]
}

/// The numbers from which [`sample_disc`] draws a point.
#[inline]
#[must_use]
pub fn invert_disc(point: [f32; 2]) -> [f32; 2] {
    let [x, y] = point;
    [min(1.0, x * x + y * y), turns(x, y)]
}

/// The angle of (x, y) from the x axis, 0 to 1.
#[inline]
fn turns(x: f32, y: f32) -> f32 {
    let turns = atan2_turns(y, x);
    if turns < 0.0 { turns + 1.0 } else { turns }
}

/// A direction about `n` with density cos θ / π (Malley's method), from two uniform numbers.
#[inline]
#[must_use]
pub fn sample_cosine(n: Vec3, u: f32, v: f32) -> Vec3 {
    let [x, y] = sample_disc(u, v);
    from_frame(n, x, y, sqrt(max(0.0, 1.0 - u)))
}

/// Density with which [`sample_cosine`] draws the unit vector `d`, sr⁻¹.
#[inline]
#[must_use]
pub fn cosine_density(n: Vec3, d: Vec3) -> f32 {
    max(0.0, dot(n, d)) * (1.0 / PI)
}

/// The numbers from which [`sample_cosine`] draws the unit vector `d`.
#[inline]
#[must_use]
pub fn invert_cosine(n: Vec3, d: Vec3) -> [f32; 2] {
    let local = to_frame(n, d);
    invert_disc([local.x, local.y])
}

/// A direction within a cone about `axis`, uniform in solid angle, from two uniform numbers. `one_minus_cos` is 1 − cos of
/// the cone's half angle: given so, narrow cones lose no digits.
#[inline]
#[must_use]
pub fn sample_cone(axis: Vec3, one_minus_cos: f32, u: f32, v: f32) -> Vec3 {
    let h = u * one_minus_cos;
    let r = sqrt(max(0.0, h * (2.0 - h)));
    let (sin, cos) = sin_cos_turns(v);
    from_frame(axis, r * cos, r * sin, 1.0 - h)
}

/// Density with which [`sample_cone`] draws each direction of its cone, sr⁻¹.
#[inline]
#[must_use]
pub fn cone_density(one_minus_cos: f32) -> f32 {
    div(1.0, 2.0 * PI * one_minus_cos)
}

/// The numbers from which [`sample_cone`] draws the unit vector `d`.
#[inline]
#[must_use]
pub fn invert_cone(axis: Vec3, one_minus_cos: f32, d: Vec3) -> [f32; 2] {
    let local = to_frame(axis, d);
    // 1 − cos without cancellation.
    let mut h = 1.0 - local.z;
    if local.z > 0.0 {
        h = div(local.x * local.x + local.y * local.y, 1.0 + local.z);
    }
    [min(1.0, div(h, one_minus_cos)), turns(local.x, local.y)]
}

/// The direction of `axis`, any direction for none.
#[inline]
#[must_use]
pub fn axis_direction(axis: Vec3) -> Vec3 {
    if dot(axis, axis) > 0.0 { normalize(axis) } else { Vec3::Z }
}

/// 1 − cos of the half angle of the cone that a sphere at `axis` fills; 2, every direction, from inside it.
#[inline]
#[must_use]
pub fn cone(axis: Vec3, radius: f32) -> f32 {
    let distance2 = dot(axis, axis);
    if distance2 <= radius * radius {
        return 2.0;
    }
    let sin2 = div(radius * radius, distance2);
    div(sin2, 1.0 + sqrt(1.0 - sin2))
}

/// Packs a unit vector into 16 + 16 bits by octahedral mapping (Cigolle et al., JCGT 2014); the error is below 10⁻⁴ rad.
#[inline]
#[must_use]
pub fn pack_direction(d: Vec3) -> u32 {
    let scale = div(1.0, abs(d.x) + abs(d.y) + abs(d.z));
    let mut x = d.x * scale;
    let mut y = d.y * scale;
    if d.z < 0.0 {
        let (fx, fy) = (fold(x, y), fold(y, x));
        x = fx;
        y = fy;
    }
    quantise(x) | (quantise(y) << 16)
}

/// The unit vector that [`pack_direction`] packed.
#[inline]
#[must_use]
pub fn unpack_direction(packed: u32) -> Vec3 {
    let mut x = expand(packed & 0xffff);
    let mut y = expand(packed >> 16);
    let z = 1.0 - abs(x) - abs(y);
    if z < 0.0 {
        let (fx, fy) = (fold(x, y), fold(y, x));
        x = fx;
        y = fy;
    }
    normalize(Vec3::new(x, y, z))
}

#[inline]
fn fold(a: f32, b: f32) -> f32 {
    let folded = 1.0 - abs(b);
    if a < 0.0 { -folded } else { folded }
}

#[inline]
fn quantise(x: f32) -> u32 {
    let q = floor_to_i32((x * 0.5 + 0.5) * 65534.0 + 0.5);
    if q < 0 {
        0
    } else if q > 65534 {
        65534
    } else {
        q as u32
    }
}

#[inline]
fn expand(q: u32) -> f32 {
    (q as f32) * (2.0 / 65534.0) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_a_direction_to_within_a_ten_thousandth_of_a_radian() {
        let mut i = 0;
        while i < 10_000 {
            let h = (i as f32 + 0.5) / 10_000.0;
            let d = sample_cone(Vec3::Z, 2.0, h, (i as f32 * 0.618_034).fract());
            let angle = cross(d, unpack_direction(pack_direction(d))).length();
            assert!(angle < 1e-4, "{d:?}: {angle}");
            i += 1;
        }
    }

    #[test]
    fn a_frame_keeps_lengths_and_its_axis() {
        let mut i = 0;
        while i < 1000 {
            let n = sample_cone(Vec3::Z, 2.0, (i as f32 + 0.5) / 1000.0, (i as f32 * 0.618_034).fract());
            assert!((from_frame(n, 0.0, 0.0, 1.0) - n).length() < 1e-6);
            let x = from_frame(n, 1.0, 0.0, 0.0);
            assert!(dot(x, n).abs() < 1e-6 && (x.length() - 1.0).abs() < 1e-6);
            i += 1;
        }
    }
}
