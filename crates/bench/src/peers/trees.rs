//! k-d trees on the CPU: built, then searched from all of rayon's threads. What a query finds is reduced to its number and its
//! last distance, and not kept.

use super::Kth;
use crate::measure::{Policy, Spread, repeat};
use crate::row::{Part, Peer};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nanoflann::{KdTree, KdTreeDataset, KdTreeParams, L2};
use rayon::prelude::*;
use std::convert::Infallible;
use std::num::NonZeroUsize;
use std::time::Instant;

struct Task<'a> {
    queries: &'a [[f32; 3]],
    expected: &'a [Kth],
    policy: Policy,
}

/// All of them.
pub(super) fn all(
    photons: &[[f32; 3]],
    queries: &[[f32; 3]],
    k: u32,
    radius2: f32,
    expected: &[Kth],
    policy: Policy,
    goes_on: &mut dyn FnMut() -> bool,
) -> Vec<Peer> {
    let task = Task { queries, expected, policy };
    let threads = rayon::current_num_threads();
    let k = NonZeroUsize::new(k as usize).unwrap_or(NonZeroUsize::MIN);
    let kiddo = task.time(
        goes_on,
        || ImmutableKdTree::<f32, 3>::new_from_slice(photons).ok(),
        |tree, query| {
            let within = tree.query(query).nearest_n::<SquaredEuclidean<f32>>(k).within(radius2);
            let found = within.execute();
            Kth { found: found.len(), distance2: found.last().map_or(0.0, |last| last.distance) }
        },
    );
    let cloud = Cloud(photons);
    let nanoflann = task.time(
        goes_on,
        || KdTree::new(3, &cloud, L2, KdTreeParams::default()).ok(),
        |tree, query| {
            let found = tree.rknn_search(query, k.get(), radius2).unwrap_or_default();
            Kth { found: found.len(), distance2: found.last().map_or(0.0, |last| last.distance) }
        },
    );
    vec![
        Peer {
            name: "kiddo".to_string(),
            version: "6.3".to_string(),
            note: format!("ImmutableKdTree, built and searched from {threads} threads"),
            ..kiddo
        },
        Peer {
            name: "nanoflann".to_string(),
            version: "0.5".to_string(),
            note: format!("the Rust port; built by 1 thread as it is made, searched from {threads}"),
            ..nanoflann
        },
    ]
}

impl Task<'_> {
    fn time<T: Sync>(
        &self,
        goes_on: &mut dyn FnMut() -> bool,
        build: impl Fn() -> Option<T>,
        search: impl Fn(&T, &[f32; 3]) -> Kth + Sync,
    ) -> Peer {
        let mut found = Vec::new();
        let mut failed = false;
        let Ok(times) = repeat(self.policy, goes_on, || {
            let start = Instant::now();
            let Some(tree) = build() else {
                failed = true;
                return Ok::<_, Infallible>([0.0; 2]);
            };
            let built = start.elapsed();
            found = self.queries.par_iter().map(|query| search(&tree, query)).collect::<Vec<_>>();
            let searched = start.elapsed();
            // The tree is taken down outside the time.
            drop(tree);
            Ok([built, searched - built].map(|time| time.as_secs_f64() * 1e3))
        });
        let of = |time: fn(&[f64; 2]) -> f64| Spread::of(&times.iter().map(time).collect::<Vec<_>>());
        let part = |part: &str, ms: f64| Part { part: part.to_string(), ms };
        Peer {
            name: String::new(),
            version: String::new(),
            runs: times.len(),
            wall_ms: (!times.is_empty() && !failed).then(|| of(|time| time[0] + time[1])),
            stages_ms: None,
            parts: vec![part("build", of(|time| time[0]).median), part("query", of(|time| time[1]).median)],
            over_ours: None,
            agree: self.expected.iter().zip(&found).filter(|(expected, found)| agree(**expected, **found)).count(),
            compared: self.expected.len(),
            note: String::new(),
        }
    }
}

/// Whether two searches found the same, as far as rounding goes: libraries add the three squares in other orders, so the last
/// photon within the radius may be in for one and out for another.
fn agree(a: Kth, b: Kth) -> bool {
    let near = (a.distance2 - b.distance2).abs() <= 1e-5 * a.distance2.max(b.distance2);
    a.found == b.found && near
}

/// Photons as nanoflann wants them, where they are.
struct Cloud<'a>(&'a [[f32; 3]]);

impl KdTreeDataset<f32> for Cloud<'_> {
    fn kdtree_get_point_count(&self) -> usize {
        self.0.len()
    }

    fn kdtree_get_pt(&self, index: usize, axis: usize) -> f32 {
        self.0[index][axis]
    }

    fn kdtree_get_point(&self, index: usize) -> Option<&[f32]> {
        Some(&self.0[index])
    }
}
