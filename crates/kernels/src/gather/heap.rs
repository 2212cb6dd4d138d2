//! A max-heap in a fixed-size array: the data structure that the thesis proposes in section 5.6 in place of its list.

use super::{Selection, before};

/// The `k ≤ N` first candidates, the last of them on top (Cormen, Leiserson and Rivest, chapter 6).
pub struct Heap<const N: usize> {
    distances2: [f32; N],
    slots: [u32; N],
    len: u32,
    k: u32,
    bound: f32,
}

impl<const N: usize> Heap<N> {
    /// An empty heap that keeps nothing until it is reset.
    #[inline]
    #[must_use]
    pub fn new() -> Self {
        Self { distances2: [0.0; N], slots: [0; N], len: 0, k: 0, bound: 0.0 }
    }

    #[inline]
    fn put(&mut self, at: u32, distance2: f32, slot: u32) {
        self.distances2[at as usize] = distance2;
        self.slots[at as usize] = slot;
    }

    /// Lets (`distance2`, `slot`) sink from `hole` through a heap of `len` elements.
    #[inline]
    fn sift_down(&mut self, mut hole: u32, len: u32, distance2: f32, slot: u32, order: &[u32]) {
        let mut child = 2 * hole + 1;
        while child < len {
            let right = child + 1;
            if right < len
                && before(
                    self.distances2[child as usize],
                    self.slots[child as usize],
                    self.distances2[right as usize],
                    self.slots[right as usize],
                    order,
                )
            {
                child = right;
            }
            let d = self.distances2[child as usize];
            let s = self.slots[child as usize];
            if before(distance2, slot, d, s, order) {
                self.put(hole, d, s);
                hole = child;
                child = 2 * hole + 1;
            } else {
                child = len;
            }
        }
        self.put(hole, distance2, slot);
    }

    #[inline]
    fn sift_up(&mut self, mut hole: u32, distance2: f32, slot: u32, order: &[u32]) {
        let mut rising = hole > 0;
        while rising {
            let parent = (hole - 1) / 2;
            let d = self.distances2[parent as usize];
            let s = self.slots[parent as usize];
            if before(d, s, distance2, slot, order) {
                self.put(hole, d, s);
                hole = parent;
                rising = hole > 0;
            } else {
                rising = false;
            }
        }
        self.put(hole, distance2, slot);
    }
}

impl<const N: usize> Default for Heap<N> {
    fn default() -> Self {
        Self::new()
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
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline]
    fn offer(&mut self, distance2: f32, slot: u32, order: &[u32]) {
        if self.len < self.k {
            let hole = self.len;
            self.len += 1;
            self.sift_up(hole, distance2, slot, order);
            if self.len == self.k {
                self.bound = self.distances2[0];
            }
        } else if before(distance2, slot, self.distances2[0], self.slots[0], order) {
            self.sift_down(0, self.k, distance2, slot, order);
            self.bound = self.distances2[0];
        }
    }

    #[inline]
    fn finish(&mut self, order: &[u32]) {
        // Heapsort: the last in order leaves the heap first and takes the last place.
        let mut len = self.len;
        while len > 1 {
            len -= 1;
            let (d, s) = (self.distances2[len as usize], self.slots[len as usize]);
            let (top_d, top_s) = (self.distances2[0], self.slots[0]);
            self.sift_down(0, len, d, s, order);
            self.put(len, top_d, top_s);
        }
    }

    #[inline]
    fn len(&self) -> u32 {
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
