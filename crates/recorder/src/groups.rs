//! Workgroups whose lanes run one after another and whose accesses are counted.

use crate::counts::Accesses;
use crate::tally::Tally;
use bytemuck::Pod;
use caustic_kernels_recorded::exec::{Lanes, TURN_ITEMS, TURN_VALUES, Turns};
use caustic_kernels_recorded::sink;
use rayon::prelude::*;

/// The workgroups of one stage, of which one of `every` is recorded.
pub(crate) struct Groups {
    count: u32,
    every: u32,
    warp: u32,
    /// What the kernel is to know, if it takes a mask.
    pub(crate) known: u32,
}

impl Groups {
    pub(crate) fn new(count: u32, every: u32, warp: u32, known: u32) -> Self {
        Self { count, every, warp, known }
    }

    /// How many are recorded.
    pub(crate) fn recorded(&self) -> u32 {
        self.count.div_ceil(self.every)
    }

    fn all(&self, buffers: &[Option<usize>], lanes: u32, group: impl Fn(u32, &mut Tally<'_>) + Sync) -> Accesses {
        let one = |i: u32| {
            let mut tally = Tally::new(buffers, lanes, self.warp);
            group(i * self.every, &mut tally);
            tally.finish()
        };
        (0..self.recorded()).into_par_iter().map(one).reduce(Accesses::default, Accesses::plus)
    }

    /// Calls `body` for every invocation.
    pub(crate) fn each(&self, buffers: &[Option<usize>], lanes: u32, body: impl Fn(u32) + Sync) -> Accesses {
        self.columns::<u32>(buffers, lanes, |i, _, _| body(i))
    }

    /// Calls `body` for every invocation, with its lane and its workgroup's shared memory.
    pub(crate) fn columns<S: Pod>(
        &self,
        buffers: &[Option<usize>],
        lanes: u32,
        body: impl Fn(u32, u32, &mut S) + Sync,
    ) -> Accesses {
        self.all(buffers, lanes, |group, tally| {
            let mut shared = S::zeroed();
            for lane in 0..lanes {
                sink::set_lane(lane);
                body(group * lanes + lane, lane, &mut shared);
                // Accesses of a warp may be many: they are counted as soon as it is complete.
                if (lane + 1).is_multiple_of(tally.warp()) {
                    tally.settle();
                }
            }
        })
    }

    /// Calls `body` for every workgroup, with its lanes' registers and its shared memory.
    pub(crate) fn phases<R: Clone + Default, S: Pod>(
        &self,
        buffers: &[Option<usize>],
        lanes: u32,
        subgroup_lanes: u32,
        body: impl Fn(&mut Recorded<'_, '_, R>, u32, &mut S) + Sync,
    ) -> Accesses {
        self.all(buffers, lanes, |group, tally| {
            let mut shared = S::zeroed();
            let mut registers = vec![R::default(); lanes as usize];
            let mut lanes = Recorded { registers: &mut registers, subgroup_lanes, tally };
            body(&mut lanes, group, &mut shared);
        })
    }
}

/// One workgroup in phases, each counted by itself.
pub(crate) struct Recorded<'a, 'b, R> {
    registers: &'a mut [R],
    subgroup_lanes: u32,
    tally: &'a mut Tally<'b>,
}

impl<R> Lanes<R> for Recorded<'_, '_, R> {
    fn each<S: ?Sized, F: FnMut(u32, &mut R, &mut S)>(&mut self, shared: &mut S, mut phase: F) {
        self.tally.settle();
        for (lane, registers) in (0..).zip(self.registers.iter_mut()) {
            sink::set_lane(lane);
            phase(lane, registers, shared);
        }
        self.tally.settle();
    }
}

impl<R> Turns<R> for Recorded<'_, '_, R> {
    fn lanes(&self) -> u32 {
        self.registers.len() as u32
    }

    fn subgroup_bits(&self) -> u32 {
        self.subgroup_lanes.trailing_zeros()
    }

    fn take_turns<const N: usize, V: FnMut(u32, &mut R, u32) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        self.tally.settle();
        for item in 0..TURN_ITEMS {
            for (lane, registers) in (0..).zip(self.registers.iter_mut()) {
                sink::set_lane(lane);
                let value = value(lane, registers, item);
                let counter = &mut counters[(lane / self.subgroup_lanes * TURN_VALUES + value) as usize];
                let count = *counter;
                *counter = count + 1;
                took(lane, registers, item, count);
            }
            self.tally.settle();
        }
    }

    fn running_sums<S: ?Sized, V: FnMut(u32, &mut R, &S) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        shared: &S,
        mut value: V,
        mut took: T,
    ) {
        self.tally.settle();
        let mut sum = 0;
        for (lane, registers) in (0..).zip(self.registers.iter_mut()) {
            sink::set_lane(lane);
            if lane % self.subgroup_lanes == 0 {
                sum = 0;
            }
            let value = value(lane, registers, shared);
            took(lane, registers, sum, value);
            sum += value;
        }
        self.tally.settle();
    }
}
