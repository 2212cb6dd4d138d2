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

/// Where a photon of a map lies: all that a search looks at, 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Site {
    /// Position, m.
    pub position: [f32; 3],
    /// Index of the photon in the order in which photons were given, before the map sorted them.
    pub photon: u32,
}

/// What a photon of a map brings: read of those that count.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Arrival {
    /// Power ΔΦ, W, for each of red, green and blue.
    pub power: [f32; 3],
    /// Direction of travel, packed by [`pack_direction`](crate::trace::vector::pack_direction).
    pub direction: u32,
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

const _: () = {
    assert!(size_of::<Photon>() == 32);
    assert!(size_of::<Site>() == 16);
    assert!(size_of::<Arrival>() == 16);
    assert!(size_of::<Query>() == 16);
    assert!(size_of::<Neighbour>() == 8);
    assert!(size_of::<Irradiance>() == 16);
};
