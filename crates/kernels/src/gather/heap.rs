//! A max-heap in a fixed-size array: the data structure that the thesis proposes in section 5.6 in place of its list.

use super::{Candidates, Selection, before};
use crate::exec::{Input, Local, local};
use crate::layout::Site;

/// The `k ≤ N` first candidates, the last of them on top (Cormen, Leiserson and Rivest, chapter 6).
#[derive(Clone)]
pub struct Heap<const N: usize> {
    distances2: Local<f32, N>,
    slots: Local<u32, N>,
    len: u32,
    k: u32,
    bound: f32,
}

impl<const N: usize> Heap<N> {
    /// An empty heap that keeps nothing until it is reset.
    #[inline]
    #[must_use]
    pub fn new() -> Self {
        Self { distances2: local![0.0; N], slots: local![0; N], len: 0, k: 0, bound: 0.0 }
    }

    #[inline]
    fn put(&mut self, at: u32, distance2: f32, slot: u32) {
        self.distances2[at as usize] = distance2;
        self.slots[at as usize] = slot;
    }

    /// Lets (`distance2`, `slot`) sink from `hole` through a heap of `len` elements.
    #[inline]
    fn sift_down(&mut self, mut hole: u32, len: u32, distance2: f32, slot: u32, sites: &Input<Site>) {
        let mut child = 2 * hole + 1;
        while child < len {
            let right = child + 1;
            if right < len
                && before(
                    self.distances2[child as usize],
                    self.slots[child as usize],
                    self.distances2[right as usize],
                    self.slots[right as usize],
                    sites,
                )
            {
                child = right;
            }
            let d = self.distances2[child as usize];
            let s = self.slots[child as usize];
            if before(distance2, slot, d, s, sites) {
                self.put(hole, d, s);
                hole = child;
                child = 2 * hole + 1;
            } else {
                child = len;
            }
        }
        self.put(hole, distance2, slot);
    }

    /// Makes a heap of the elements in any order (Floyd 1964).
    #[inline]
    fn heapify(&mut self, sites: &Input<Site>) {
        let mut root = self.len / 2;
        while root > 0 {
            root -= 1;
            let (d, s) = (self.distances2[root as usize], self.slots[root as usize]);
            self.sift_down(root, self.len, d, s, sites);
        }
    }
}

impl<const N: usize> Default for Heap<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: ?Sized, A: ?Sized, O: ?Sized, const N: usize> Candidates<M, A, O> for Heap<N> {
    #[inline]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline]
    fn offer(
        &mut self,
        _memory: &mut M,
        _output: &mut O,
        distance2: f32,
        slot: u32,
        sites: &Input<Site>,
        _arrivals: &A,
    ) {
        if self.len < self.k {
            // Until it is full nothing is rejected, and no order is needed.
            self.put(self.len, distance2, slot);
            self.len += 1;
            if self.len == self.k {
                self.heapify(sites);
                self.bound = self.distances2[0];
            }
        } else if before(distance2, slot, self.distances2[0], self.slots[0], sites) {
            self.sift_down(0, self.k, distance2, slot, sites);
            self.bound = self.distances2[0];
        }
    }
}

impl<const N: usize> Selection for Heap<N> {
    #[inline]
    fn reset(&mut self, k: u32, radius2: f32) {
        self.len = 0;
        self.k = k;
        self.bound = radius2;
    }

    #[inline]
    fn sort(&mut self, sites: &Input<Site>) {
        if self.len < self.k {
            self.heapify(sites);
        }
        // Heapsort: the last in order leaves the heap first and takes the last place.
        let mut len = self.len;
        while len > 1 {
            len -= 1;
            let (d, s) = (self.distances2[len as usize], self.slots[len as usize]);
            let (top_d, top_s) = (self.distances2[0], self.slots[0]);
            self.sift_down(0, len, d, s, sites);
            self.put(len, top_d, top_s);
        }
    }

    #[inline]
    fn last(&self) -> u32 {
        0
    }

    #[inline]
    fn count(&self) -> u32 {
        self.len
    }

    #[inline]
    fn distance2(&self, i: u32) -> f32 {
        self.distances2[i as usize]
    }

    #[inline]
    fn slot(&self, i: u32) -> u32 {
        self.slots[i as usize]
    }
}

#[cfg(test)]
impl<const N: usize> Heap<N> {
    /// One as a GPU may find it: nothing but what [`Selection::reset`] sets is defined.
    pub(super) fn of_rubbish() -> Self {
        Self { distances2: local![f32::NAN; N], slots: local![u32::MAX; N], len: 77, k: 77, bound: f32::NAN }
    }
}
