//! Sorts on the CPU: of (key, index) pairs, by key, from a copy that is made outside the time.

use crate::measure::{Policy, Spread, repeat};
use crate::row::Peer;
use rayon::slice::ParallelSliceMut;
use rdst::{RadixKey, RadixSort};
use std::convert::Infallible;
use std::time::Instant;

/// A pair whose key has `BYTES` bytes that count.
#[derive(Clone, Copy)]
struct Pair<const BYTES: usize> {
    key: u32,
    /// Carried along, as ours does.
    _index: u32,
}

impl<const BYTES: usize> RadixKey for Pair<BYTES> {
    const LEVELS: usize = BYTES;

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        (self.key >> (8 * level)) as u8
    }
}

/// All of them.
pub(super) fn all(
    keys: &[u32],
    bits: u32,
    sorted: &[u32],
    policy: Policy,
    goes_on: &mut dyn FnMut() -> bool,
) -> Vec<Peer> {
    let std_version = env!("CAUSTIC_RUSTC").split_whitespace().nth(1).unwrap_or_default();
    let threads = format!("{} threads", rayon::current_num_threads());
    let data = Data { keys, sorted };
    let by_bytes = match bits.div_ceil(8) {
        1 => data.time::<1>(policy, goes_on, RadixSort::radix_sort_unstable),
        2 => data.time::<2>(policy, goes_on, RadixSort::radix_sort_unstable),
        3 => data.time::<3>(policy, goes_on, RadixSort::radix_sort_unstable),
        _ => data.time::<4>(policy, goes_on, RadixSort::radix_sort_unstable),
    };
    let parallel = data.time::<4>(policy, goes_on, |pairs| pairs.par_sort_unstable_by_key(|pair| pair.key));
    let one = data.time::<4>(policy, goes_on, |pairs| pairs.sort_unstable_by_key(|pair| pair.key));
    vec![
        Peer { name: "rdst".to_string(), version: "0.20".to_string(), note: threads.clone(), ..by_bytes },
        Peer {
            name: "par_sort_unstable_by_key".to_string(),
            version: "rayon 1".to_string(),
            note: threads,
            ..parallel
        },
        Peer {
            name: "sort_unstable_by_key".to_string(),
            version: format!("std {std_version}"),
            note: "1 thread".to_string(),
            ..one
        },
    ]
}

struct Data<'a> {
    keys: &'a [u32],
    sorted: &'a [u32],
}

impl Data<'_> {
    fn time<const BYTES: usize>(
        &self,
        policy: Policy,
        goes_on: &mut dyn FnMut() -> bool,
        sort: impl Fn(&mut [Pair<BYTES>]),
    ) -> Peer {
        let pair = |(index, &key): (usize, &u32)| Pair { key, _index: index as u32 };
        let input: Vec<Pair<BYTES>> = self.keys.iter().enumerate().map(pair).collect();
        let mut pairs = input.clone();
        let Ok(times) = repeat(policy, goes_on, || {
            pairs.copy_from_slice(&input);
            let start = Instant::now();
            sort(&mut pairs);
            Ok::<_, Infallible>(start.elapsed().as_secs_f64() * 1e3)
        });
        Peer {
            name: String::new(),
            version: String::new(),
            runs: times.len(),
            wall_ms: (!times.is_empty()).then(|| Spread::of(&times)),
            stages_ms: None,
            parts: Vec::new(),
            over_ours: None,
            agree: pairs.iter().zip(self.sorted).filter(|(pair, key)| pair.key == **key).count(),
            compared: self.sorted.len(),
            note: String::new(),
        }
    }
}
