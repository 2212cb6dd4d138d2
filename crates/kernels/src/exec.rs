//! How a kernel body meets a device.
//!
//! Two shapes of kernel exist:
//!
//! * **each**: `fn body(i: u32, inputs…, outputs…)`, one invocation an element. Invocations share nothing.
//! * **group**: `fn body(lanes: &mut impl Lanes<R>, group: u32, shared: &mut S, inputs…, outputs…)`, written as
//!   phases. Between two phases stands a workgroup barrier. A value that crosses a phase lives in the lane's
//!   registers `R` or in `shared`; within a phase no lane reads what another lane of that phase writes. So the order
//!   of lanes does not matter, which the CPU driver shows by running them forward, reversed and shuffled.
//!
//! A stage may be given more invocations or workgroups than it has work for; a body ignores those past its last. A whole
//! workgroup does so together, before its first barrier.
//!
//! A private array of more than 32 elements in a struct is not initialised on a GPU, whatever the source says: zeroing it
//! costs more than using it. Nothing of it is read that was not written.
//!
//! An output is written through [`Store`] and never read by the stage that writes it, so the same body serves a plain
//! slice on the GPU and a buffer shared between threads on the CPU.

/// A stage's output buffer: element `i` is written by at most one invocation of the stage.
pub trait Store<T> {
    /// Writes element `i`.
    fn set(&mut self, i: u32, value: T);
}

impl<T: Copy> Store<T> for [T] {
    #[inline]
    fn set(&mut self, i: u32, value: T) {
        self[i as usize] = value;
    }
}

/// Runs one phase of a workgroup kernel on every lane, then a barrier.
///
/// Phases are `move` closures: rust-gpu cannot keep a reference to a local variable inside another value.
pub trait Lanes<R> {
    /// Calls `phase(lane, registers, shared)` for each lane of the workgroup.
    fn each<S: ?Sized, F: FnMut(u32, &mut R, &mut S)>(&mut self, shared: &mut S, phase: F);
}

/// One GPU invocation: it is a single lane, and the other lanes run beside it.
#[cfg(target_arch = "spirv")]
pub struct Invocation<R> {
    /// Index of this lane in its workgroup.
    pub lane: u32,
    /// The lane's registers.
    pub registers: R,
}

#[cfg(target_arch = "spirv")]
impl<R> Lanes<R> for Invocation<R> {
    #[inline]
    fn each<S: ?Sized, F: FnMut(u32, &mut R, &mut S)>(&mut self, shared: &mut S, mut phase: F) {
        phase(self.lane, &mut self.registers, shared);
        spirv_std::arch::workgroup_memory_barrier_with_group_sync();
    }
}

/// One CPU workgroup: its lanes run one after another, in any order.
#[cfg(not(target_arch = "spirv"))]
pub struct Workgroup<'a, R> {
    /// Registers of each lane.
    pub registers: &'a mut [R],
    /// The order in which a phase visits the lanes: a permutation of their indices.
    pub order: &'a [u32],
}

#[cfg(not(target_arch = "spirv"))]
impl<R> Lanes<R> for Workgroup<'_, R> {
    #[inline]
    fn each<S: ?Sized, F: FnMut(u32, &mut R, &mut S)>(&mut self, shared: &mut S, mut phase: F) {
        for &lane in self.order {
            phase(lane, &mut self.registers[lane as usize], shared);
        }
    }
}
