//! Which memory accesses kernels make, and how many of them a GPU could not coalesce: the "non-coalesced reads/writes" of the thesis
//! (section 4.1, table 1; figure 26) and its accesses to local memory (figure 17).
//!
//! A [`Recorder`]'s device is the CPU. After every stage it runs the same kernel once more, compiled from the same sources with inputs
//! and private arrays that write down each access (`caustic_kernels_recorded`), and counts what the lanes of each warp did together.
//! Whatever runs on a device can be recorded so, without knowing it; and what the recorded kernel writes has to be what the fast one
//! wrote.
//!
//! ```
//! use caustic_device::{Kernel, Plan};
//! use caustic_recorder::Recorder;
//!
//! let recorder = Recorder::new(32);
//! let device = recorder.device();
//! let input = device.upload("input", &[7u32; 4 * 64])?;
//! let output = device.buffer::<[u32; 4]>("output", 64)?;
//! let mut plan = Plan::new();
//! plan.each(Kernel::CopyQuads, 64, &[&input, &output]);
//! device.run(&plan)?;
//! let copied = &recorder.report()[0];
//! // Two warps read and write 512 bytes each.
//! assert_eq!((copied.total.requests, copied.total.sectors, copied.total.excess), (4, 64, 0));
//! # Ok::<(), caustic_device::Error>(())
//! ```
//!
//! # The model
//!
//! * A **warp** is so many lanes of a workgroup, neighbours by index: 32 on all NVIDIA GPUs. The last of a workgroup may have fewer.
//! * A **request** is an access that the lanes of a warp make together: at the same place in the source and in the same turn of the
//!   same loops, as if lanes that part met again where a loop or a branch ends. Loops are those that the lanes' accesses show
//!   (the module `align` says how). Between two barriers of a workgroup it is told anew.
//! * Memory is moved in **sectors** of 32 bytes: a warp's accesses become as many 32-byte transactions as are necessary to serve all of
//!   its threads (NVIDIA, "CUDA C++ Best Practices Guide", section "Coalesced Access to Global Memory"). A request counts each sector
//!   that it touches once. Buffers begin at a sector.
//! * The **minimum** of a request is ⌈bytes that its lanes ask for / 32⌉, and no more than it touched: lanes that read the same bytes
//!   need fewer. The **excess** is what it touched beyond that: the non-coalesced accesses. NVIDIA's profiling interface has the same
//!   two numbers, `l2_transactions` and `theoreticalL2Transactions` (CUPTI, `CUpti_ActivityGlobalAccess3`).
//! * An access to **local memory** is a load or a store of one value of one lane in an [`exec::Local`](caustic_kernels_recorded::exec::Local). Lanes
//!   that access the same index are coalesced there, by how local memory lies; that is not looked at.
//!
//! What it leaves out:
//!
//! * **Caches.** Every request counts in full, also where another has just fetched the sector. Excess of this kind is what
//!   a cache has to make good, not bytes that memory moved.
//! * **Parts of records.** A record is read and written whole and at once, though a kernel may need one of its fields, and a GPU has
//!   no instruction for more than 16 bytes: of 48-byte records, three instructions touch each sector up to twice, in the first-level cache.
//! * **Single records** (`One` in the list of stages): all lanes read the same few words once.
//! * **Shared memory**, and registers that a compiler spills.
//! * **Inlined calls.** A function's accesses have one place, wherever it was called from: if lanes call it from several places in turn,
//!   its loops go on counting from one call to the next.
//! * **Buffers that are cleared** by the device and not by a kernel.
//! * **Kernels that change buffers in place** (`InOut`), the sorts of brute force: what they found is gone when they are over.

mod align;
mod counts;
mod groups;
mod kernel;
mod output;
mod tally;

pub use counts::{BufferAccesses, Counts, StageAccesses};

use caustic_device::{Access, Device, Observed, Observer};
use output::Outputs;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Records the accesses of what runs on its device.
#[derive(Clone)]
pub struct Recorder(Arc<Inner>);

struct Inner {
    warp: u32,
    every: u32,
    stages: Mutex<Vec<StageAccesses>>,
}

impl Recorder {
    /// A recorder for warps of `warp` lanes.
    ///
    /// # Panics
    /// If a warp has no lanes.
    #[must_use]
    pub fn new(warp: u32) -> Self {
        Self::every(warp, 1)
    }

    /// A recorder that looks at one workgroup of `every`: the first, and so on. What it counts is not scaled up;
    /// [`StageAccesses::recorded_groups`] says of how many workgroups it is.
    ///
    /// # Panics
    /// If a warp has no lanes, or no workgroup would be recorded.
    #[must_use]
    pub fn every(warp: u32, every: u32) -> Self {
        assert!(warp > 0 && every > 0, "warps of {warp} lanes, one workgroup of {every}");
        Self(Arc::new(Inner { warp, every, stages: Mutex::default() }))
    }

    /// A CPU device of which everything is recorded.
    #[must_use]
    pub fn device(&self) -> Device {
        Device::observed(Arc::new(self.clone()))
    }

    fn stages(&self) -> MutexGuard<'_, Vec<StageAccesses>> {
        self.0.stages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What each stage accessed so far, in the order of first use.
    #[must_use]
    pub fn report(&self) -> Vec<StageAccesses> {
        self.stages().clone()
    }

    /// Forgets what was recorded so far.
    pub fn reset(&self) {
        self.stages().clear();
    }
}

impl Observer for Recorder {
    /// Runs the recorded kernel on the inputs of a stage.
    ///
    /// # Panics
    /// If it writes something else than the stage wrote.
    fn observe(&self, stage: &Observed<'_>) {
        // What they found is gone.
        if stage.kernel.bindings().iter().any(|binding| binding.access == Access::InOut) {
            return;
        }
        let outputs = Outputs::of(stage);
        let groups = groups::Groups::new(stage.groups, self.0.every, self.0.warp, stage.known);
        let recorded = groups.recorded();
        let tally = kernel::run(stage.kernel, &groups, stage.buffers, &outputs);
        if let Some(buffer) = outputs.changed(stage) {
            panic!("{}: the recorded kernel writes something else to `{buffer}`", stage.stage);
        }
        let mut stages = self.stages();
        let known = stages.iter().position(|row| row.stage == stage.stage);
        let row = known.unwrap_or_else(|| {
            stages.push(StageAccesses::new(stage.stage, stage.kernel));
            stages.len() - 1
        });
        stages[row].add(stage.groups, recorded, &tally);
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::TransparentWrapper;
    use caustic_kernels_recorded::exec::Input;
    use caustic_kernels_recorded::gather::{Candidates, Heap, Selection, SortedList};
    use caustic_kernels_recorded::layout::Site;
    use caustic_kernels_recorded::{probe, sink};

    /// Loads and stores of a container of two that is offered 3, then 2, 1 and 5.
    fn local_accesses(mut container: impl Selection + Candidates<(), (), ()>) -> [[u64; 2]; 4] {
        let sites = Input::wrap_ref(&[] as &[Site]);
        let _ = sink::take_local();
        container.reset(2, 100.0);
        let mut slot = 0;
        [3.0, 2.0, 1.0, 5.0].map(|distance2| {
            container.offer(&mut (), &mut (), distance2, slot, sites, &());
            slot += 1;
            sink::take_local()
        })
    }

    /// Each element is a distance and a slot: two loads, or two stores.
    #[test]
    fn local_accesses_of_containers_are_those_counted_by_hand() {
        // 3: put. 2: put; it is full, so its one root is loaded, then its one child, and put back; then the bound. 1: compared with the
        // top, then with the child, which goes up; put; the bound. 5: compared with the top.
        assert_eq!(local_accesses(Heap::<17>::new()), [[0, 2], [5, 4], [5, 4], [2, 0]]);
        // 3: put. 2: compared with 3, which is moved; put; the bound. 1: compared with the last, the last but one, which is moved; put;
        // the bound. 5: compared with the last.
        assert_eq!(local_accesses(SortedList::<17>::new()), [[0, 2], [5, 4], [7, 4], [2, 0]]);
    }

    #[test]
    fn an_access_is_where_the_body_makes_it() {
        let records = [Site::default(); 3];
        let outputs = crate::Outputs::of(&caustic_device::Observed {
            stage: "copy",
            kernel: caustic_device::Kernel::CopyQuads,
            known: 0,
            groups: 1,
            buffers: &[bytemuck::cast_slice(&records), &[0; 12]],
        });
        let mut accesses = vec![];
        sink::take_accesses(&mut accesses);
        accesses.clear();
        sink::set_lane(5);
        probe::copy_quads(2, Input::wrap_ref(&records), &mut outputs.write::<Site>(1));
        sink::take_accesses(&mut accesses);
        let [read, write] = accesses[..] else { panic!("{accesses:?}") };
        assert!(read.at.file().ends_with("probe/copy.rs") && write.at.file().ends_with("probe/copy.rs"));
        assert!(read.at.line() == write.at.line() && read.at.column() != write.at.column());
        for access in [read, write] {
            assert_eq!((access.offset, access.bytes, access.lane), (32, 16, 5));
        }
        assert_eq!((read.buffer, Some(write.buffer)), (records.as_ptr().addr(), outputs.address(1)));
    }
}
