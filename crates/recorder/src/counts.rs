//! What is counted.

use caustic_device::{Access, Kernel};
use serde::Serialize;
use std::ops::AddAssign;

/// Accesses to buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Accesses that the lanes of a warp made together.
    pub requests: u64,
    /// Sectors of 32 bytes that requests touched.
    pub sectors: u64,
    /// Sectors that they would have touched if they were coalesced.
    pub minimum: u64,
    /// Sectors beyond that: the non-coalesced accesses.
    pub excess: u64,
    /// Requests that touched more sectors than their minimum.
    pub uncoalesced_requests: u64,
    /// Bytes that lanes asked for.
    pub bytes: u64,
}

impl Counts {
    /// One request of lanes that ask for so many bytes in all and touch so many sectors.
    pub(crate) fn request(bytes: u64, sectors: u64) -> Self {
        let minimum = bytes.div_ceil(crate::tally::SECTOR).min(sectors);
        let excess = sectors - minimum;
        Self { requests: 1, sectors, minimum, excess, uncoalesced_requests: u64::from(excess > 0), bytes }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.requests += other.requests;
        self.sectors += other.sectors;
        self.minimum += other.minimum;
        self.excess += other.excess;
        self.uncoalesced_requests += other.uncoalesced_requests;
        self.bytes += other.bytes;
    }
}

/// Accesses of a stage to one of its buffers.
#[derive(Clone, Debug, Serialize)]
pub struct BufferAccesses {
    /// What the buffer is to the kernel.
    pub name: &'static str,
    /// Whether it is written, or else read.
    pub written: bool,
    /// The accesses. A buffer that is bound twice has them all where it is bound first.
    #[serde(flatten)]
    pub counts: Counts,
}

/// What a stage accessed, over all its runs.
#[derive(Clone, Debug, Serialize)]
pub struct StageAccesses {
    /// The stage, with its scope.
    pub stage: String,
    /// The kernel's entry point.
    pub kernel: &'static str,
    /// How often it ran.
    pub runs: u32,
    /// Workgroups that ran.
    pub groups: u64,
    /// Workgroups of which accesses were recorded.
    pub recorded_groups: u64,
    /// Accesses to all buffers.
    #[serde(flatten)]
    pub total: Counts,
    /// Loads of lanes from local memory.
    pub local_loads: u64,
    /// Stores of lanes to local memory.
    pub local_stores: u64,
    /// Accesses to each buffer, in the order of the bindings.
    pub buffers: Vec<BufferAccesses>,
}

impl StageAccesses {
    pub(crate) fn new(stage: &str, kernel: Kernel) -> Self {
        let buffers = kernel.bindings().iter().map(|binding| BufferAccesses {
            name: binding.name,
            written: binding.access == Access::Out,
            counts: Counts::default(),
        });
        Self {
            stage: stage.to_string(),
            kernel: kernel.entry_point(),
            runs: 0,
            groups: 0,
            recorded_groups: 0,
            total: Counts::default(),
            local_loads: 0,
            local_stores: 0,
            buffers: buffers.collect(),
        }
    }

    pub(crate) fn add(&mut self, groups: u32, recorded: u32, accesses: &Accesses) {
        self.runs += 1;
        self.groups += u64::from(groups);
        self.recorded_groups += u64::from(recorded);
        self.local_loads += accesses.local_loads;
        self.local_stores += accesses.local_stores;
        for (buffer, &counts) in self.buffers.iter_mut().zip(&accesses.buffers) {
            buffer.counts += counts;
            self.total += counts;
        }
    }

    /// Accesses to the buffers that the stage reads.
    #[must_use]
    pub fn reads(&self) -> Counts {
        self.sum(false)
    }

    /// Accesses to the buffers that it writes.
    #[must_use]
    pub fn writes(&self) -> Counts {
        self.sum(true)
    }

    fn sum(&self, written: bool) -> Counts {
        let mut sum = Counts::default();
        for buffer in self.buffers.iter().filter(|buffer| buffer.written == written) {
            sum += buffer.counts;
        }
        sum
    }
}

/// Accesses of some workgroups of one stage.
#[derive(Clone, Debug, Default)]
pub(crate) struct Accesses {
    /// By binding.
    pub(crate) buffers: Vec<Counts>,
    pub(crate) local_loads: u64,
    pub(crate) local_stores: u64,
}

impl Accesses {
    pub(crate) fn plus(mut self, other: Self) -> Self {
        self.buffers.resize(self.buffers.len().max(other.buffers.len()), Counts::default());
        for (sum, &counts) in self.buffers.iter_mut().zip(&other.buffers) {
            *sum += counts;
        }
        self.local_loads += other.local_loads;
        self.local_stores += other.local_stores;
        self
    }
}
