//! How a kernel body meets a device.
//!
//! Three shapes of kernel exist:
//!
//! * **each**: `fn body(i: u32, inputs…, outputs…)`, one invocation an element. Invocations share nothing.
//! * **group**: `fn body(lanes: &mut impl Lanes<R>, group: u32, shared: &mut S, inputs…, outputs…)`, written as
//!   phases. Between two phases stands a workgroup barrier. A value that crosses a phase lives in the lane's
//!   registers `R` or in `shared`; within a phase no lane reads what another lane of that phase writes. So the order
//!   of lanes does not matter, which the CPU driver shows by running them forward, reversed and shuffled.
//! * **block**: a group whose lanes also take turns at counters, those of a subgroup in their order ([`Turns`]). The body
//!   is written for any number of lanes and any size of subgroup: a GPU has 128 lanes in subgroups of 8, 32 or 64, or lanes
//!   without subgroups, each its own; the CPU has one lane that handles all items itself.
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

/// Values that [`Turns::take_turns`] counts.
pub const TURN_VALUES: u32 = 256;

/// A workgroup whose lanes can count in order.
pub trait Turns<R>: Lanes<R> {
    /// Number of lanes.
    fn lanes(&self) -> u32;
    /// Lanes of a subgroup. Subgroup `s` has the lanes from `s` times this on.
    fn subgroup_lanes(&self) -> u32;
    /// As if the lanes of each subgroup took turns in their order: a lane chooses a value below [`TURN_VALUES`], or that
    /// to sit out, and takes `counters[s · TURN_VALUES + value]`, which then goes up by one. Afterwards the lanes of a
    /// subgroup see each other's counts; those of other subgroups only after the next [`Lanes::each`] began.
    fn take_turns<const N: usize, V: FnMut(u32, &mut R) -> u32, T: FnMut(u32, &mut R, u32)>(
        &mut self,
        counters: &mut [u32; N],
        value: V,
        took: T,
    );
}

/// One GPU invocation: it is a single lane, and the other lanes run beside it.
#[cfg(target_arch = "spirv")]
pub struct Invocation<R> {
    /// Lanes of the workgroup.
    pub lanes: u32,
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

/// A subgroup of its own: nobody else is at its counters.
#[cfg(target_arch = "spirv")]
impl<R> Turns<R> for Invocation<R> {
    #[inline]
    fn lanes(&self) -> u32 {
        self.lanes
    }

    #[inline]
    fn subgroup_lanes(&self) -> u32 {
        1
    }

    #[inline]
    fn take_turns<const N: usize, V: FnMut(u32, &mut R) -> u32, T: FnMut(u32, &mut R, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        let value = value(self.lane, &mut self.registers);
        if value < TURN_VALUES {
            let counter = (self.lane * TURN_VALUES + value) as usize;
            let count = counters[counter];
            counters[counter] = count + 1;
            took(self.lane, &mut self.registers, count);
        }
    }
}

/// One GPU invocation that knows its subgroup.
#[cfg(target_arch = "spirv")]
pub struct SubgroupInvocation<R> {
    /// The lane, by (subgroup, invocation in it).
    pub invocation: Invocation<R>,
    /// Its subgroup.
    pub subgroup: u32,
    /// Lanes of a subgroup.
    pub subgroup_lanes: u32,
}

#[cfg(target_arch = "spirv")]
impl<R> Lanes<R> for SubgroupInvocation<R> {
    #[inline]
    fn each<S: ?Sized, F: FnMut(u32, &mut R, &mut S)>(&mut self, shared: &mut S, phase: F) {
        self.invocation.each(shared, phase);
    }
}

/// Ballots tell a lane which lanes have the same value: a ballot for each of its bits (Ashkiani et al., "GPU Multisplit",
/// 2016, section 5.1). The first of them counts for all.
#[cfg(target_arch = "spirv")]
impl<R> Turns<R> for SubgroupInvocation<R> {
    #[inline]
    fn lanes(&self) -> u32 {
        self.invocation.lanes
    }

    #[inline]
    fn subgroup_lanes(&self) -> u32 {
        self.subgroup_lanes
    }

    #[inline]
    fn take_turns<const N: usize, V: FnMut(u32, &mut R) -> u32, T: FnMut(u32, &mut R, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        use spirv_std::arch::{
            subgroup_ballot, subgroup_ballot_bit_count, subgroup_ballot_exclusive_bit_count, subgroup_barrier,
        };
        let lane = self.invocation.lane;
        let value = value(lane, &mut self.invocation.registers);
        let counts = value < TURN_VALUES;
        let mut same = subgroup_ballot(counts);
        let mut bit = 1;
        while bit < TURN_VALUES {
            let is_set = value & bit != 0;
            let set = subgroup_ballot(is_set);
            same = if is_set { same & set } else { same & !set };
            bit *= 2;
        }
        let before = subgroup_ballot_exclusive_bit_count(same);
        let all = subgroup_ballot_bit_count(same);
        let counter = (self.subgroup * TURN_VALUES + value) as usize;
        let mut count = 0;
        if counts {
            count = counters[counter];
        }
        subgroup_barrier();
        if counts && before == 0 {
            counters[counter] = count + all;
        }
        subgroup_barrier();
        if counts {
            took(lane, &mut self.invocation.registers, count + before);
        }
    }
}

/// One CPU workgroup: its lanes run one after another, in any order.
#[cfg(not(target_arch = "spirv"))]
pub struct Workgroup<'a, R> {
    /// Registers of each lane.
    pub registers: &'a mut [R],
    /// The order in which a phase visits the lanes: a permutation of their indices.
    pub order: &'a [u32],
    /// Lanes of a subgroup.
    pub subgroup_lanes: u32,
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

#[cfg(not(target_arch = "spirv"))]
impl<R> Turns<R> for Workgroup<'_, R> {
    #[inline]
    fn lanes(&self) -> u32 {
        self.registers.len() as u32
    }

    #[inline]
    fn subgroup_lanes(&self) -> u32 {
        self.subgroup_lanes
    }

    #[inline]
    fn take_turns<const N: usize, V: FnMut(u32, &mut R) -> u32, T: FnMut(u32, &mut R, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        for (lane, registers) in (0..).zip(self.registers.iter_mut()) {
            let value = value(lane, registers);
            if value < TURN_VALUES {
                let counter = &mut counters[(lane / self.subgroup_lanes * TURN_VALUES + value) as usize];
                let count = *counter;
                *counter = count + 1;
                took(lane, registers, count);
            }
        }
    }
}
