//! Candidates that a walk through the cells has met, so that they need not be looked for again.

use super::{Candidates, Placed, distance2};
use crate::exec::{Input, Local, local};
use crate::grid::Grid;

/// Most that are remembered: twice the wanted ones and more for k = 50, half a KiB a lane.
const MOST: u32 = 128;

/// What a walk was offered, by slot. A lane appends to it and reads it in order, which a GPU's local memory is good at.
pub(super) struct Seen {
    slots: Local<u32, { MOST as usize }>,
    len: u32,
}

impl Seen {
    #[inline]
    pub(super) fn new() -> Self {
        Self { slots: local![0; MOST as usize], len: 0 }
    }

    /// Forgets all, before another walk.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    #[inline]
    pub(super) fn add(&mut self, slot: u32) {
        if self.len < MOST {
            self.slots[self.len as usize] = slot;
        }
        self.len += 1;
    }

    /// Whether nothing had to be left out.
    #[inline]
    pub(super) fn is_whole(&self) -> bool {
        self.len <= MOST
    }

    /// Offers `candidates` all that are remembered, as another [`search`](super::search()) would.
    #[inline]
    pub(super) fn offer<S: Placed, M: ?Sized, A: ?Sized, O: ?Sized, C: Candidates<M, A, O, S>>(
        &self,
        position: [f32; 3],
        grid: &Grid,
        sites: &Input<S>,
        arrivals: &A,
        memory: &mut M,
        output: &mut O,
        candidates: &mut C,
    ) {
        macro_rules! slot {
            ($n:expr) => {
                self.slots[(if $n < self.len { $n } else { self.len - 1 }) as usize]
            };
        }
        macro_rules! consider {
            ($n:expr, $slot:expr, $site:expr) => {
                let d2 = distance2(position, $site.position(grid));
                if $n < self.len && d2 <= candidates.bound() {
                    candidates.offer(memory, output, d2, $slot, sites, arrivals);
                }
            };
        }
        let mut n = 0;
        while n < self.len {
            // All four are on their way before the first is needed.
            let slots = [slot!(n), slot!(n + 1), slot!(n + 2), slot!(n + 3)];
            let one = sites[slots[0] as usize];
            let two = sites[slots[1] as usize];
            let three = sites[slots[2] as usize];
            let four = sites[slots[3] as usize];
            consider!(n, slots[0], one);
            consider!(n + 1, slots[1], two);
            consider!(n + 2, slots[2], three);
            consider!(n + 3, slots[3], four);
            n += 4;
        }
    }
}
