//! Finding the k photons nearest to a point, and what they say about the light there.
//!
//! Neighbours are ordered by (squared distance, index the photon had before sorting). That order is total, so "the k
//! nearest" is one set, whatever the hash, the device or the container that collects it; and what is summed over it is
//! summed exactly ([`Limbs`](crate::num::Limbs)), so that the order in which a container holds it does not show.

mod bins;
mod compact;
mod counting;
mod density;
mod estimate;
mod filter;
mod filtered;
mod heap;
mod kth;
mod likely;
mod list;
mod neighbours;
mod power;
mod reach;
mod search;
mod seen;
mod surface;

pub(crate) use bins::{BINS, bin_of, clear, count};
pub use bins::{COLUMN_LANES, Columns};
pub use compact::{Compact, gather_compact, reorder_compact, snap, snap_photons};
pub use counting::gather_irradiance_by_counting;
pub use density::{density_of, gather_density, gather_power};
pub(crate) use estimate::over_disc;
pub use estimate::{gather_irradiance, gather_neighbours};
pub use filter::{FILTER_CONE, FILTER_CONSTANT, FILTER_EPANECHNIKOV, FILTER_GAUSSIAN, filter_integral, filter_weight};
pub use filtered::{EstimateParams, gather_filtered};
pub use heap::Heap;
pub use likely::{likely_reach, likely_reach_hashed};
pub use list::SortedList;
pub use neighbours::{WideColumns, gather_neighbours_by_counting, order_neighbours};
pub(crate) use power::Power;
pub use reach::{Reach, gather_reach};
pub use search::{distance2, root_above, search, search_share};
pub use surface::{SURFACE_ANY, SURFACE_FACING, SURFACE_OWN, face_arrivals};

use crate::exec::Input;
use crate::grid::Grid;
use crate::layout::Site;
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
    /// (v / (4π/3))^(2/3) of the number v of photons that a search counts on to find enough: what guesses its first radius.
    pub guess: f32,
}

/// What a search does with the candidates it meets. `M` is memory of the lane that does not fit registers, `A` what is known of
/// photons beside their sites, `O` where results go, `S` a photon's record.
pub trait Candidates<M: ?Sized, A: ?Sized, O: ?Sized, S = Site> {
    /// Whether an offer is a few instructions, so that the search repeats it four times a turn of its innermost loop: that is
    /// faster, and llvmpipe, which ends loops after 65,535 turns, comes four times as far.
    const SHORT: bool = false;
    /// Squared distance beyond which a candidate does not matter, m².
    fn bound(&self) -> f32;
    /// Offers candidate `slot`, an index into the sorted `sites` and `arrivals`.
    fn offer(&mut self, memory: &mut M, output: &mut O, distance2: f32, slot: u32, sites: &Input<S>, arrivals: &A);
    /// Lowers the bound, if that takes more work than one candidate is worth: called between rows.
    #[inline]
    fn settle(&mut self, _memory: &mut M) {}
}

/// A photon of a map as a search sees it.
pub trait Placed: Copy {
    /// Position, m.
    fn position(self, grid: &Grid) -> [f32; 3];
    /// Index of the photon as it was given.
    fn photon(self) -> u32;
}

impl Placed for Site {
    #[inline]
    fn position(self, _grid: &Grid) -> [f32; 3] {
        Site::position(self)
    }

    #[inline]
    fn photon(self) -> u32 {
        Site::photon(self)
    }
}

/// Result in place of a number of photons where the device ended a search before its end: what was found is not the answer.
pub const CUT_SHORT: u32 = 0xffff_ffff;

/// A container that keeps the best of the candidates it is offered: also [`Candidates`], of any memory.
pub trait Selection {
    /// Empties it and sets what it keeps: the `k` first in order among those at most `radius2` (m²) away.
    fn reset(&mut self, k: u32, radius2: f32);
    /// Puts what was kept in order, nearest first.
    fn sort(&mut self, sites: &Input<Site>);
    /// Where, before it is sorted, a full container has what is last in order.
    fn last(&self) -> u32;
    /// How many were kept.
    fn count(&self) -> u32;
    /// Squared distance of the `i`-th, m².
    fn distance2(&self, i: u32) -> f32;
    /// The `i`-th as an index into the sorted photons.
    fn slot(&self, i: u32) -> u32;
}

/// Whether a candidate comes before another in the order of neighbours.
#[inline]
fn before(distance2: f32, slot: u32, other_distance2: f32, other_slot: u32, sites: &Input<Site>) -> bool {
    if distance2 == other_distance2 {
        sites[slot as usize].photon() < sites[other_slot as usize].photon()
    } else {
        distance2 < other_distance2
    }
}

#[cfg(test)]
mod tests;
