//! Counting the accesses of one workgroup.

use crate::align::Aligner;
use crate::counts::{Accesses, Counts};
use caustic_kernels_recorded::sink::{self, ALL_LANES, Access};

/// Bytes that move together.
pub(crate) const SECTOR: u64 = 32;

/// What a workgroup accessed so far.
pub(crate) struct Tally<'a> {
    /// Address of each binding's buffer; none if it has no records.
    buffers: &'a [Option<usize>],
    lanes: u32,
    warp: u32,
    accesses: Vec<Access>,
    aligner: Aligner,
    sectors: Vec<u64>,
    counts: Accesses,
}

impl<'a> Tally<'a> {
    pub(crate) fn new(buffers: &'a [Option<usize>], lanes: u32, warp: u32) -> Self {
        let mut tally = Self {
            buffers,
            lanes,
            warp,
            accesses: Vec::new(),
            aligner: Aligner::default(),
            sectors: Vec::new(),
            counts: Accesses { buffers: vec![Counts::default(); buffers.len()], ..Accesses::default() },
        };
        // What a kernel that panicked on this thread may have left.
        tally.clear();
        tally
    }

    fn clear(&mut self) {
        sink::set_lane(ALL_LANES);
        sink::take_accesses(&mut self.accesses);
        self.accesses.clear();
        let _ = sink::take_local();
    }

    /// Lanes of a warp.
    pub(crate) fn warp(&self) -> u32 {
        self.warp
    }

    /// Counts what was accessed since the last time, each lane's accesses in their order, lanes in theirs.
    pub(crate) fn settle(&mut self) {
        sink::set_lane(ALL_LANES);
        let mut accesses = std::mem::take(&mut self.accesses);
        let mut aligner = std::mem::take(&mut self.aligner);
        sink::take_accesses(&mut accesses);
        let lanes = self.warp;
        let warp_of = |access: &Access| if access.lane == ALL_LANES { ALL_LANES } else { access.lane / lanes };
        for warp in accesses.chunk_by(|a, b| warp_of(a) == warp_of(b)) {
            if warp[0].lane == ALL_LANES {
                for &access in warp {
                    self.broadcast(access);
                }
            } else {
                aligner.align(warp, |request| self.request(request));
            }
        }
        accesses.clear();
        (self.accesses, self.aligner) = (accesses, aligner);
    }

    /// All lanes of the workgroup make the same access.
    fn broadcast(&mut self, access: Access) {
        let mut first = 0;
        while first < self.lanes {
            let lanes = self.warp.min(self.lanes - first);
            self.request(std::iter::repeat_n(access, lanes as usize));
            first += lanes;
        }
    }

    /// Lanes of a warp access a buffer together.
    fn request(&mut self, lanes: impl IntoIterator<Item = Access>) {
        self.sectors.clear();
        let mut bytes = 0;
        let mut buffer = 0;
        for access in lanes {
            buffer = access.buffer;
            bytes += u64::from(access.bytes);
            let end = access.offset + u64::from(access.bytes);
            self.sectors.extend(access.offset / SECTOR..end.div_ceil(SECTOR));
        }
        self.sectors.sort_unstable();
        self.sectors.dedup();
        let binding = self.buffers.iter().position(|&address| address == Some(buffer));
        let binding = binding.expect("kernels have no other buffers than those bound");
        self.counts.buffers[binding] += Counts::request(bytes, self.sectors.len() as u64);
    }

    /// All that the workgroup accessed.
    pub(crate) fn finish(mut self) -> Accesses {
        self.settle();
        [self.counts.local_loads, self.counts.local_stores] = sink::take_local();
        self.counts
    }
}
