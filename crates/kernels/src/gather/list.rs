//! The sorted list with which the thesis collects photons (section 3.1.3).

use super::{Candidates, Selection, before};
use crate::exec::{Input, Local, local};
use crate::layout::Site;

/// The `k ≤ N` first candidates in order. A nearer photon is inserted where it belongs and the later ones move back one
/// place; the last is lost when the list is full.
pub struct SortedList<const N: usize> {
    distances2: Local<f32, N>,
    slots: Local<u32, N>,
    len: u32,
    k: u32,
    bound: f32,
}

impl<const N: usize> SortedList<N> {
    /// An empty list that keeps nothing until it is reset.
    #[inline]
    #[must_use]
    pub fn new() -> Self {
        Self { distances2: local![0.0; N], slots: local![0; N], len: 0, k: 0, bound: 0.0 }
    }
}

impl<const N: usize> Default for SortedList<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: ?Sized, A: ?Sized, O: ?Sized, const N: usize> Candidates<M, A, O> for SortedList<N> {
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
        let mut place = self.len;
        if self.len == self.k {
            place = self.len - 1;
            let last = place as usize;
            if !before(distance2, slot, self.distances2[last], self.slots[last], sites) {
                return;
            }
        } else {
            self.len += 1;
        }
        let mut shifting = place > 0;
        while shifting {
            let previous = (place - 1) as usize;
            if before(distance2, slot, self.distances2[previous], self.slots[previous], sites) {
                self.distances2[place as usize] = self.distances2[previous];
                self.slots[place as usize] = self.slots[previous];
                place -= 1;
                shifting = place > 0;
            } else {
                shifting = false;
            }
        }
        self.distances2[place as usize] = distance2;
        self.slots[place as usize] = slot;
        if self.len == self.k {
            self.bound = self.distances2[(self.k - 1) as usize];
        }
    }
}

impl<const N: usize> Selection for SortedList<N> {
    #[inline]
    fn reset(&mut self, k: u32, radius2: f32) {
        self.len = 0;
        self.k = k;
        self.bound = radius2;
    }

    #[inline]
    fn sort(&mut self, _sites: &Input<Site>) {}

    #[inline]
    fn last(&self) -> u32 {
        self.k - 1
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
impl<const N: usize> SortedList<N> {
    /// One as a GPU may find it: nothing but what [`Selection::reset`] sets is defined.
    pub(super) fn of_rubbish() -> Self {
        Self { distances2: local![f32::NAN; N], slots: local![u32::MAX; N], len: 77, k: 77, bound: f32::NAN }
    }
}
