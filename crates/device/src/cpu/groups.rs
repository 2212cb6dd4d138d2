//! Workgroups on the CPU: rayon shares them out, and within one the lanes run one after another.

use bytemuck::Pod;
use caustic_kernels::exec::{Many, Workgroup};
use rayon::prelude::*;

/// The order in which the CPU visits workgroups and, in them, lanes. Kernels give the same bits in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LaneOrder {
    /// 0, 1, 2, …
    #[default]
    Forward,
    /// …, 2, 1, 0
    Reversed,
    /// A permutation that depends on this number; shared memory also starts filled with rubbish, as on a GPU.
    Shuffled(u32),
}

impl LaneOrder {
    fn lanes(self, count: u32) -> Vec<u32> {
        let mut order: Vec<u32> = (0..count).collect();
        match self {
            Self::Forward => {}
            Self::Reversed => order.reverse(),
            Self::Shuffled(seed) => {
                for i in (1..count).rev() {
                    let j = caustic_kernels::num::pcg4d([seed, i, count, 0])[0] % (i + 1);
                    order.swap(i as usize, j as usize);
                }
            }
        }
        order
    }
}

/// The workgroups of one stage.
pub(crate) struct Groups {
    pub(crate) count: u32,
    /// What the kernel is to know, if it takes a mask.
    pub(crate) known: u32,
    pub(crate) order: LaneOrder,
}

impl Groups {
    fn group(&self, i: u32) -> u32 {
        if self.order == LaneOrder::Forward { i } else { self.count - 1 - i }
    }

    /// Calls `body` for every invocation.
    pub(crate) fn each(&self, lanes: u32, body: impl Fn(u32) + Sync) {
        let order = self.order.lanes(lanes);
        (0..self.count).into_par_iter().for_each(|i| {
            let first = self.group(i) * lanes;
            for &lane in &order {
                body(first + lane);
            }
        });
    }

    /// Calls `body` for every workgroup of invocations.
    pub(crate) fn batches<R: Clone + Default + Send>(&self, lanes: u32, body: impl Fn(&mut Many<'_, R>) + Sync) {
        let order = self.order.lanes(lanes);
        (0..self.count).into_par_iter().for_each_init(
            || vec![R::default(); lanes as usize],
            |registers, i| body(&mut Many { first: self.group(i) * lanes, registers, order: &order }),
        );
    }

    /// Calls `body` for every invocation, with its lane and its workgroup's shared memory.
    pub(crate) fn columns<S: Pod + Send>(&self, lanes: u32, body: impl Fn(u32, u32, &mut S) + Sync) {
        let order = self.order.lanes(lanes);
        let rubbish = matches!(self.order, LaneOrder::Shuffled(_));
        (0..self.count).into_par_iter().for_each_init(
            || vec![S::zeroed(); 1],
            |shared, i| {
                if rubbish {
                    bytemuck::cast_slice_mut::<S, u8>(shared).fill(0xa5);
                }
                let first = self.group(i) * lanes;
                for &lane in &order {
                    body(first + lane, lane, &mut shared[0]);
                }
            },
        );
    }

    /// Lanes of a subgroup, if workgroups are to have as many lanes as on a GPU.
    pub(crate) fn subgroup_lanes(&self) -> Option<u32> {
        match self.order {
            LaneOrder::Forward => None,
            LaneOrder::Reversed => Some(32),
            LaneOrder::Shuffled(seed) => Some(32 << (seed % 3)),
        }
    }

    /// Calls `body` for every workgroup, with its lanes' registers and its shared memory.
    pub(crate) fn phases<R, S>(
        &self,
        lanes: u32,
        subgroup_lanes: u32,
        body: impl Fn(&mut Workgroup<'_, R>, u32, &mut S) + Sync,
    ) where
        R: Clone + Default + Send,
        S: Pod + Send,
    {
        let order = self.order.lanes(lanes);
        let rubbish = matches!(self.order, LaneOrder::Shuffled(_));
        (0..self.count).into_par_iter().for_each_init(
            || (vec![R::default(); lanes as usize], vec![S::zeroed(); 1]),
            |(registers, shared), i| {
                if rubbish {
                    bytemuck::cast_slice_mut::<S, u8>(shared).fill(0xa5);
                }
                let mut group = Workgroup { registers, order: &order, subgroup_lanes };
                body(&mut group, self.group(i), &mut shared[0]);
            },
        );
    }
}
