//! The CPU backend: the kernel bodies, called from rayon's threads.

mod groups;
mod observer;
mod shared;
mod words;

pub(crate) use groups::Groups;
pub use groups::LaneOrder;
pub use observer::{Observed, Observer};
pub(crate) use shared::Bound;
pub(crate) use words::Words;

use crate::error::flag_of;
use crate::kernel::{Access, Masked};
use crate::plan::{Plan, Step};
use crate::timing::Timings;
use crate::{Error, Result};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::Instant;

pub(crate) struct Cpu {
    order: LaneOrder,
    allocations: AtomicU64,
    observer: Option<Arc<dyn Observer>>,
}

/// What the CPU calls itself in reports.
pub(crate) fn name() -> String {
    format!("CPU, {} threads", rayon::current_num_threads())
}

/// Memory that can still be had without swapping, bytes, where the system tells (Linux).
fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}

pub(crate) fn lock_read(memory: &RwLock<Words>) -> RwLockReadGuard<'_, Words> {
    memory.read().unwrap_or_else(PoisonError::into_inner)
}

pub(crate) fn lock_write(memory: &RwLock<Words>) -> RwLockWriteGuard<'_, Words> {
    memory.write().unwrap_or_else(PoisonError::into_inner)
}

enum Guard<'a> {
    Read(RwLockReadGuard<'a, Words>),
    Write(RwLockWriteGuard<'a, Words>),
}

impl Cpu {
    pub(crate) fn new(order: LaneOrder) -> Self {
        Self { order, allocations: AtomicU64::new(0), observer: None }
    }

    /// Zeroed memory for a buffer.
    pub(crate) fn allocate(&self, name: &str, bytes: u64) -> Result<RwLock<Words>> {
        let out_of_memory = || Error::OutOfMemory {
            buffer: name.to_string(),
            device: "the CPU".to_string(),
            needed: bytes,
            available: available_bytes().map_or("less than that".to_string(), |b| format!("{b} bytes available")),
            flag: flag_of(name),
        };
        // An operating system that overcommits hands out more than there is and ends the program later.
        if available_bytes().is_some_and(|available| bytes > available) {
            return Err(out_of_memory());
        }
        let words = usize::try_from(bytes / 4).map_err(|_| out_of_memory())?;
        let memory = Words::zeroed(words).map_err(|_| out_of_memory())?;
        self.allocations.fetch_add(1, Relaxed);
        Ok(RwLock::new(memory))
    }

    /// How often memory was asked of the system.
    pub(crate) fn allocations(&self) -> u64 {
        self.allocations.load(Relaxed)
    }

    /// Whether memory is to be full of rubbish where nothing may depend on it.
    pub(crate) fn begins_with_rubbish(&self) -> bool {
        matches!(self.order, LaneOrder::Shuffled(_))
    }

    pub(crate) fn observed(observer: Arc<dyn Observer>) -> Self {
        Self { observer: Some(observer), ..Self::new(LaneOrder::Forward) }
    }

    /// Lanes of a subgroup, for those who choose kernels: one does everything, unless it is watched in place of a GPU.
    pub(crate) fn subgroup_lanes(&self) -> u32 {
        if self.observer.is_some() { 32 } else { 1 }
    }

    /// Executes a plan, timing each stage by the wall clock.
    pub(crate) fn run(&self, plan: &Plan, timings: &Timings) -> Result<()> {
        for step in &plan.steps {
            let start = Instant::now();
            let stage = match step {
                Step::Clear { stage, buffer } => {
                    lock_write(buffer.on_cpu()).fill(0);
                    stage
                }
                Step::Run { stage, kernel: Masked { kernel, known }, groups, buffers } => {
                    if let Some(observer) = &self.observer {
                        observer.begin(stage)?;
                    }
                    let mut guards: Vec<_> = kernel
                        .bindings()
                        .iter()
                        .zip(buffers)
                        .map(|(binding, buffer)| match binding.access {
                            Access::One | Access::In => Guard::Read(lock_read(buffer.on_cpu())),
                            Access::Out | Access::InOut => Guard::Write(lock_write(buffer.on_cpu())),
                        })
                        .collect();
                    let bound: Vec<_> = guards
                        .iter_mut()
                        .map(|guard| match guard {
                            Guard::Read(words) => Bound::Read(words),
                            Guard::Write(words) => Bound::write_words(words),
                        })
                        .collect();
                    kernel.run_on_cpu(&Groups { count: *groups, known: *known, order: self.order }, &bound);
                    stage
                }
            };
            timings.add(stage, start.elapsed().as_secs_f64() * 1e3);
            if let Some(observer) = &self.observer {
                show(step, observer.as_ref());
            }
        }
        Ok(())
    }
}

fn show(step: &Step, observer: &dyn Observer) {
    if let Step::Run { stage, kernel: Masked { kernel, known }, groups, buffers } = step {
        let guards: Vec<_> = buffers.iter().map(|buffer| lock_read(buffer.on_cpu())).collect();
        let words: Vec<&[u32]> = guards.iter().map(|guard| &guard[..]).collect();
        observer.observe(&Observed { stage, kernel: *kernel, known: *known, groups: *groups, buffers: &words });
    }
}
