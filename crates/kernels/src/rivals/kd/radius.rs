//! The radius of the k nearest by histograms (thesis, section 2.3.3).
//!
//! The radius to begin with is cut into 32 shells of equal width, photons are counted in each, and the shell that holds the k-th
//! takes the place of the radius: so often as is asked for. The outer radius of the last shell holds k photons at least, and is off
//! by less than r₀ / 32ⁿ after n histograms, which is 0.098 % of r₀ for two. The numbers of shells and of histograms are ours: the
//! thesis has neither.

use super::KdRadius;
use super::traverse::traverse;
use crate::exec::{Input, Store};
use crate::gather::{BINS, Candidates, Columns, bin_of, clear, count};
use crate::layout::{Query, Site};
use crate::num::flush;

/// Squared radius in place of that of a search that the device ended early.
pub const KD_CUT_SHORT: f32 = -1.0;

/// Counts photons by shells, in the lane's column.
struct Shells {
    lane: u32,
    /// Inner radius of the first shell, outer radius of the last, and the width of one, m.
    inner: f32,
    outer: f32,
    width: f32,
    /// Squared distance up to which photons lie inside all shells, m²; negative if none do.
    inside2: f32,
}

impl Shells {
    #[inline]
    fn new(lane: u32, inner: f32, outer: f32, inside2: f32) -> Self {
        Self { lane, inner, outer, width: (outer - inner) * (1.0 / BINS as f32), inside2 }
    }

    /// The outer radius of the shell before shell `shell`.
    #[inline]
    fn edge(&self, shell: u32) -> f32 {
        if shell == BINS { self.outer } else { self.inner + self.width * shell as f32 }
    }

    /// The first shell whose outer radius is no smaller than a distance.
    #[inline]
    fn shell(&self, distance2: f32) -> u32 {
        let mut shell = 0;
        let mut step = BINS / 2;
        while step > 0 {
            let edge = self.edge(shell + step);
            if distance2 > edge * edge {
                shell += step;
            }
            step /= 2;
        }
        shell
    }
}

impl<const N: usize, A: ?Sized, O: ?Sized> Candidates<[u32; N], A, O> for Shells {
    #[inline]
    fn bound(&self) -> f32 {
        self.outer * self.outer
    }

    #[inline]
    fn offer(
        &mut self,
        memory: &mut [u32; N],
        _output: &mut O,
        distance2: f32,
        _slot: u32,
        _sites: &Input<Site>,
        _arrivals: &A,
    ) {
        if distance2 > self.inside2 {
            count(memory, self.lane, 0, self.shell(distance2));
        }
    }
}

/// Writes the square of a radius within which query `q` has k photons at least, or of the one to begin with if it has fewer there;
/// [`KD_CUT_SHORT`] if the device ended the search early.
#[inline]
pub fn kd_radius<R: Store<f32> + ?Sized>(
    q: u32,
    lane: u32,
    memory: &mut Columns,
    params: &KdRadius,
    queries: &Input<Query>,
    tree: &Input<Site>,
    radii2: &mut R,
) {
    if q >= params.queries {
        return;
    }
    let query = queries[q as usize];
    let mut whole = true;
    let mut inner = 0.0;
    let mut outer = params.radius;
    let mut inside = 0;
    let mut inside2 = -1.0;
    let mut iterations = if query.active != 0 { params.iterations } else { 0 };
    while iterations > 0 {
        iterations -= 1;
        clear(memory, lane, 0);
        let mut shells = Shells::new(lane, inner, outer, inside2);
        whole = traverse(query.position, tree, params.photons, &(), memory, &mut (), &mut shells) && whole;
        let (shell, before, _) = bin_of(memory, lane, 0, params.k - inside);
        if shell < BINS {
            inside += before;
            inner = shells.edge(shell);
            outer = shells.edge(shell + 1);
            if shell > 0 || inside2 >= 0.0 {
                inside2 = inner * inner;
            }
        } else {
            // Fewer than k.
            iterations = 0;
        }
    }
    radii2.set(q, if whole { flush(outer * outer) } else { KD_CUT_SHORT });
}

#[cfg(test)]
mod tests {
    use super::super::KD_LEAF;
    use super::super::node::write_inner;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn a_distance_belongs_to_the_shell_whose_outer_edge_it_does_not_pass() {
        let shells = Shells::new(0, 2.0, 34.0, 4.0);
        for (distance, shell) in [(2.5f32, 0), (3.0, 0), (3.0f32.next_up(), 1), (17.5, 15), (33.5, 31), (34.0, 31)] {
            assert_eq!(shells.shell(distance * distance), shell, "{distance}");
        }
        assert_eq!((shells.edge(0), shells.edge(31), shells.edge(32)), (2.0, 33.0, 34.0));
    }

    /// A tree of photons along x, in their order: each inner node has one photon left.
    fn chain(xs: &[f32]) -> Vec<Site> {
        let mut tree = vec![Site::default(); 3 * xs.len() - 2];
        let (mut place, last) = (0, xs.len() - 1);
        for (i, &x) in xs[..last].iter().enumerate() {
            let (low, high) = ([x, 0.0, 0.0], [xs[last], 0.0, 0.0]);
            write_inner(tree.as_mut_slice(), place, low, high, 0, xs[i + 1], 1, (xs.len() - i) as u32);
            tree[place as usize + 2] = Site::new(low, i as u32);
            place += 3;
        }
        tree[place as usize] = Site::new([xs[last], 0.0, 0.0], last as u32);
        assert_eq!(tree[tree.len() - 5].photon() & KD_LEAF, 0);
        tree
    }

    fn radius(xs: &[f32], k: u32, iterations: u32) -> f32 {
        let tree = chain(xs);
        let queries = [Query::default(), Query { position: [0.0; 3], active: 1 }];
        let params = KdRadius { queries: 2, k, photons: xs.len() as u32, iterations, radius: 32.0 };
        let mut radii2 = vec![9.0; 2];
        for q in 0..3 {
            kd_radius(q, 5, &mut [77; 1024], &params, &queries, &tree, radii2.as_mut_slice());
        }
        assert_eq!(radii2[0], 1024.0, "a query that is not active begins and ends with the largest radius");
        radii2[1].sqrt()
    }

    #[test]
    fn every_histogram_divides_the_error_by_32() {
        let xs: Vec<f32> = (0..100).map(|i| 0.31 * i as f32).collect();
        for k in [1, 2, 10, 50, 100] {
            let exact = xs[k as usize - 1];
            assert_eq!(radius(&xs, k, 0), 32.0);
            for (iterations, width) in [(1, 1.0), (2, 1.0 / 32.0), (3, 1.0 / 1024.0)] {
                let found = radius(&xs, k, iterations);
                assert!(found >= exact && found <= exact + width * 1.001, "k = {k}: {found} {exact}");
            }
        }
        // Fewer than k: the radius to begin with, and what lies beyond it does not count.
        assert_eq!(radius(&xs, 101, 3), 32.0);
        assert_eq!(radius(&[1.0, 2.0, 33.0], 3, 2), 32.0);
        // Photons in the query's own point, more than k of them.
        assert!(radius(&[0.0; 9], 3, 3) <= 32.0 / 32768.0);
    }
}
