//! Records that the CPU and the GPU share, word for word.
//!
//! Every field is a `u32`, an `f32` or an array of those, so that alignment is four bytes everywhere and a record has no
//! padding. Sizes are asserted here at compile time.

use bytemuck::{Pod, Zeroable};

/// A photon: where light arrived on a diffuse surface, from where, and how much (thesis, section 2.1.2).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Photon {
    /// Position, m.
    pub position: [f32; 3],
    /// Direction of travel, packed by [`pack_direction`](crate::trace::vector::pack_direction).
    pub direction: u32,
    /// Power ΔΦ, W, for each of red, green and blue.
    pub power: [f32; 3],
    /// Index of the primitive it arrived on.
    pub primitive: u32,
}

/// Four words that a GPU loads at once.
#[cfg(target_arch = "spirv")]
type Quad = glam::UVec4;
#[cfg(not(target_arch = "spirv"))]
type Quad = [u32; 4];

#[inline]
fn quad(a: u32, b: u32, c: u32, d: u32) -> Quad {
    #[cfg(target_arch = "spirv")]
    return glam::UVec4::new(a, b, c, d);
    #[cfg(not(target_arch = "spirv"))]
    [a, b, c, d]
}

#[inline]
fn words(quad: Quad) -> [u32; 4] {
    #[cfg(target_arch = "spirv")]
    return [quad.x, quad.y, quad.z, quad.w];
    #[cfg(not(target_arch = "spirv"))]
    quad
}

/// Where a photon of a map lies: all that a search looks at, 16 bytes. Position, m, and the index of the photon in the order in
/// which photons were given, before the map sorted them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Site(Quad);

impl Site {
    /// A photon's site.
    #[inline]
    #[must_use]
    pub fn new(position: [f32; 3], photon: u32) -> Self {
        Self(quad(position[0].to_bits(), position[1].to_bits(), position[2].to_bits(), photon))
    }

    /// Position, m.
    #[inline]
    #[must_use]
    pub fn position(self) -> [f32; 3] {
        let [x, y, z, _] = words(self.0);
        [f32::from_bits(x), f32::from_bits(y), f32::from_bits(z)]
    }

    /// Index of the photon as it was given.
    #[inline]
    #[must_use]
    pub fn photon(self) -> u32 {
        words(self.0)[3]
    }
}

/// What a photon of a map brings, read of those that count: its power ΔΦ in fixed point (see [`Limbs`](crate::num::Limbs)), a
/// quad for each limb, and its direction of travel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Arrival {
    high: Quad,
    middle: Quad,
    low: Quad,
}

impl Arrival {
    /// An arrival of a power whose limbs for red, green and blue are given, and a direction packed by
    /// [`pack_direction`](crate::trace::vector::pack_direction), on a primitive.
    #[inline]
    #[must_use]
    pub fn new(red: [u32; 3], green: [u32; 3], blue: [u32; 3], direction: u32, primitive: u32) -> Self {
        Self {
            high: quad(red[0], green[0], blue[0], direction),
            middle: quad(red[1], green[1], blue[1], primitive),
            low: quad(red[2], green[2], blue[2], 0),
        }
    }

    /// The limbs of its power, the highest first, each for red, green and blue.
    #[inline]
    #[must_use]
    pub fn limbs(self) -> [[u32; 3]; 3] {
        let (high, middle, low) = (words(self.high), words(self.middle), words(self.low));
        [[high[0], high[1], high[2]], [middle[0], middle[1], middle[2]], [low[0], low[1], low[2]]]
    }

    /// Direction of travel.
    #[inline]
    #[must_use]
    pub fn direction(self) -> u32 {
        words(self.high)[3]
    }

    /// Index of the primitive it arrived on.
    #[inline]
    #[must_use]
    pub fn primitive(self) -> u32 {
        words(self.middle)[3]
    }

    /// The same with the normal of the side on which it arrived, packed like its direction.
    #[inline]
    #[must_use]
    pub fn with_side(self, side: u32) -> Self {
        let low = words(self.low);
        Self { low: quad(low[0], low[1], low[2], side), ..self }
    }

    /// Normal of the side on which it arrived, if [`with_side`](Self::with_side) has given it one.
    #[inline]
    #[must_use]
    pub fn side(self) -> u32 {
        words(self.low)[3]
    }
}

/// A point at which photons are sought.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Query {
    /// Position, m.
    pub position: [f32; 3],
    /// 0 where nothing is sought: the result is then empty.
    pub active: u32,
}

/// One neighbour of a query.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Neighbour {
    /// Squared distance to the query, m².
    pub distance2: f32,
    /// Index of the photon in the order in which photons were given, before the map sorted them.
    pub photon: u32,
}

/// An estimate at a query.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Irradiance {
    /// Irradiance, W·m⁻², for each of red, green and blue.
    pub rgb: [f32; 3],
    /// Photons in the estimate.
    pub photons: u32,
}

/// The power of all photons that a query has found so far, in the limbs of [`Limbs`](crate::num::Limbs).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct PowerSum {
    /// The highest limb of each of red, green and blue.
    pub high: [u32; 3],
    /// The middle limbs.
    pub middle: [u32; 3],
    /// The lowest limbs.
    pub low: [u32; 3],
    /// What has left the highest limbs.
    pub above: [u32; 3],
    /// How many photons, or [`CUT_SHORT`](crate::gather::CUT_SHORT).
    pub photons: u32,
}

const _: () = {
    assert!(size_of::<Photon>() == 32);
    assert!(size_of::<Site>() == 16);
    assert!(size_of::<Arrival>() == 48);
    assert!(size_of::<Query>() == 16);
    assert!(size_of::<Neighbour>() == 8);
    assert!(size_of::<Irradiance>() == 16);
    assert!(size_of::<PowerSum>() == 52);
};
