//! Finding the k photons nearest to a point, and what they say about the light there.
//!
//! Neighbours are ordered by (squared distance, index the photon had before sorting). That order is total, so "the k
//! nearest" is one set, whatever the hash, the device or the container that collects it, and sums are taken in that order.

mod estimate;
mod heap;
mod list;
mod search;

pub use estimate::{gather_irradiance, gather_neighbours};
pub use heap::Heap;
pub use list::SortedList;
pub use search::{distance2, search};

use bytemuck::{Pod, Zeroable};

/// Lanes of a gathering workgroup.
pub const GATHER_LANES: u32 = 64;
/// Capacities for which gathering kernels are compiled. A request is served by the smallest that holds it; it still
/// returns exactly what was asked for. The estimate of k photons needs room for k + 1.
pub const CAPACITIES: [u32; 4] = [17, 65, 257, 1025];

/// Parameters of a gathering stage.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GatherParams {
    /// Number of queries.
    pub queries: u32,
    /// Neighbours sought a query, k.
    pub k: u32,
}

/// A container that keeps the best of the candidates it is offered.
pub trait Selection {
    /// Empties it and sets what it keeps: the `k` first in order among those at most `radius2` (m²) away.
    fn reset(&mut self, k: u32, radius2: f32);
    /// Squared distance beyond which no candidate can be kept any more, m².
    fn bound(&self) -> f32;
    /// Offers candidate `slot`, an index into the sorted photons, whose original indices are `order`.
    fn offer(&mut self, distance2: f32, slot: u32, order: &[u32]);
    /// Puts what was kept in order, nearest first.
    fn finish(&mut self, order: &[u32]);
    /// How many were kept.
    fn len(&self) -> u32;
    /// Squared distance of the `i`-th, m².
    fn distance2(&self, i: u32) -> f32;
    /// The `i`-th as an index into the sorted photons.
    fn slot(&self, i: u32) -> u32;
}

/// Whether a candidate comes before another in the order of neighbours.
#[inline]
fn before(distance2: f32, slot: u32, other_distance2: f32, other_slot: u32, order: &[u32]) -> bool {
    if distance2 == other_distance2 {
        order[slot as usize] < order[other_slot as usize]
    } else {
        distance2 < other_distance2
    }
}
