//! Other libraries in the same process, on the same data, behind the feature `peers`.

#[cfg(feature = "peers")]
mod gpu_sort;
#[cfg(feature = "peers")]
mod sorts;
#[cfg(feature = "peers")]
mod trees;

use crate::measure::Policy;
use crate::row::Peer;
use caustic_device::Device;

/// Whether any are compiled in.
pub(crate) const ANY: bool = cfg!(feature = "peers");

/// What a search has to find, as far as it can be compared: how many, and how far the last is, squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "peers"), allow(dead_code))] // nobody reads it then
pub(crate) struct Kth {
    pub found: usize,
    pub distance2: f32,
}

/// Sorts on the kind of device that `device` is. `sorted` are the keys in order.
#[cfg(feature = "peers")]
pub(crate) fn sorts(
    device: &Device,
    keys: &[u32],
    bits: u32,
    sorted: &[u32],
    policy: Policy,
    goes_on: &mut dyn FnMut() -> bool,
) -> Vec<Peer> {
    if device.is_gpu() {
        vec![gpu_sort::lampshade(&device.name(), keys, sorted, policy, goes_on)]
    } else {
        sorts::all(keys, bits, sorted, policy, goes_on)
    }
}

/// Searches on the CPU: a structure over `photons`, then the `k` nearest within √`radius2` of each query. `expected` is about the
/// first queries.
#[cfg(feature = "peers")]
pub(crate) fn searches(
    photons: &[[f32; 3]],
    queries: &[[f32; 3]],
    k: u32,
    radius2: f32,
    expected: &[Kth],
    policy: Policy,
    goes_on: &mut dyn FnMut() -> bool,
) -> Vec<Peer> {
    trees::all(photons, queries, k, radius2, expected, policy, goes_on)
}

/// None are compiled in.
#[cfg(not(feature = "peers"))]
pub(crate) fn sorts(_: &Device, _: &[u32], _: u32, _: &[u32], _: Policy, _: &mut dyn FnMut() -> bool) -> Vec<Peer> {
    Vec::new()
}

/// None are compiled in.
#[cfg(not(feature = "peers"))]
pub(crate) fn searches(
    _: &[[f32; 3]],
    _: &[[f32; 3]],
    _: u32,
    _: f32,
    _: &[Kth],
    _: Policy,
    _: &mut dyn FnMut() -> bool,
) -> Vec<Peer> {
    Vec::new()
}
