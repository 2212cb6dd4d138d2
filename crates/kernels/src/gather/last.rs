//! The candidates among which is the last that is wanted.

use super::counting::Place;
use super::distance2;
use crate::exec::{Input, Local, local};
use crate::layout::Site;

/// Most that it holds: as many as [`find`](super::kth::find) leaves where it can.
pub(super) const MOST: u32 = 16;

/// Some candidates, by slot, in any order.
pub(super) struct Last {
    slots: Local<u32, { MOST as usize }>,
    pub(super) len: u32,
}

impl Last {
    #[inline]
    pub(super) fn new() -> Self {
        Self { slots: local![0; MOST as usize], len: 0 }
    }

    /// Takes a candidate, if there is room.
    #[inline]
    pub(super) fn add(&mut self, slot: u32) {
        if self.len < MOST {
            self.slots[self.len as usize] = slot;
            self.len += 1;
        }
    }

    /// Takes out the one that is the first in order, and says where it is.
    #[inline]
    pub(super) fn take_first(&mut self, position: [f32; 3], sites: &Input<Site>) -> (Place, u32) {
        let mut first = Place::ALL;
        let mut slot = 0;
        let mut taken = 0;
        let mut n = 0;
        while n < self.len {
            let other = self.slots[n as usize];
            let site = sites[other as usize];
            let bits = distance2(position, site.position()).to_bits();
            if bits < first.bits || (bits == first.bits && site.photon() < first.index) {
                first = Place { bits, index: site.photon() };
                slot = other;
                taken = n;
            }
            n += 1;
        }
        self.len -= 1;
        self.slots[taken as usize] = self.slots[self.len as usize];
        (first, slot)
    }
}
