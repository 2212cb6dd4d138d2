//! How a kernel body meets a device.
//!
//! Four shapes of kernel exist:
//!
//! * **each**: `fn body(i: u32, inputs…, outputs…)`, one invocation an element. Invocations share nothing.
//! * **batch**: `fn body(batch: &mut impl Batch<R>, inputs…, outputs…)`, an `each` in phases without barriers: nothing is shared, but
//!   what many elements wait for is on its way at once on the CPU, too ([`Batch`]).
//! * **group**: `fn body(lanes: &mut impl Lanes<R>, group: u32, shared: &mut S, inputs…, outputs…)`, written as
//!   phases. Between two phases stands a workgroup barrier. A value that crosses a phase lives in the lane's
//!   registers `R` or in `shared`; within a phase no lane reads what another lane of that phase writes. So the order
//!   of lanes does not matter, which the CPU driver shows by running them forward, reversed and shuffled.
//! * **block**: a group whose lanes also take turns at counters, those of a subgroup in their order ([`Turns`]). The body
//!   is written for any number of lanes and any size of subgroup: a GPU has 256 lanes in subgroups of 32 or 64, or 128 in
//!   subgroups of 8, or lanes without subgroups, each its own; the CPU has one lane that handles all items itself.
//!
//! A stage may be given more invocations or workgroups than it has work for; a body ignores those past its last. A whole
//! workgroup does so together, before its first barrier.
//!
//! A private array of more than 32 elements in a struct is not initialised on a GPU, whatever the source says: zeroing it
//! costs more than using it. Nothing of it is read that was not written.
//!
//! An output is written through [`Store`] and never read by the stage that writes it, so the same body serves a plain
//! slice on the GPU and a buffer shared between threads on the CPU. What a stage changes in place it reads and writes through
//! [`Update`], and then an element belongs to one invocation.
//!
//! [`Input`] and [`Local`] are a slice and an array here. The package `caustic-kernels-recorded` is made of the same bodies with
//! others in their place, which write down what is accessed.

mod batch;

pub use batch::*;

/// A stage's input buffer: records that no invocation of the stage writes.
pub type Input<T> = [T];

/// A lane's private array whose indices are not known at compile time: a GPU keeps it in local memory, not in registers.
pub type Local<T, const N: usize> = [T; N];

/// A [`Local`] of `N` equal values.
macro_rules! local {
    ($value:expr; $n:expr) => {
        [$value; $n]
    };
}
pub(crate) use local;

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

/// A buffer that a stage changes in place: one invocation of the stage reads and writes element `i`, and no other does either.
pub trait Update<T>: Store<T> {
    /// Reads element `i`.
    fn get(&self, i: u32) -> T;
}

impl<T: Copy> Update<T> for [T] {
    #[inline]
    fn get(&self, i: u32) -> T {
        self[i as usize]
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
/// Items of a lane that take turns at once: as many chains of dependent operations run side by side.
pub const TURN_ITEMS: u32 = 8;

/// A workgroup whose lanes can count in order.
pub trait Turns<R>: Lanes<R> {
    /// Number of lanes.
    fn lanes(&self) -> u32;
    /// Binary logarithm of the lanes of a subgroup: lane `l` is of subgroup `l >> subgroup_bits`.
    fn subgroup_bits(&self) -> u32;
    /// As if the lanes of each subgroup took turns in their order, and that [`TURN_ITEMS`] times: for item `j` a lane chooses a
    /// value below [`TURN_VALUES`] and takes `counters[s · TURN_VALUES + value]`, which then goes up by one.
    /// Afterwards the lanes of a subgroup see each other's counts; those of other subgroups only after the next [`Lanes::each`]
    /// began.
    fn take_turns<const N: usize, V: FnMut(u32, &mut R, u32) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        counters: &mut [u32; N],
        value: V,
        took: T,
    );
    /// As if the lanes of each subgroup added up in their order: a lane takes the sum of the values before its own, and its own. Shared
    /// memory is read only.
    fn running_sums<S: ?Sized, V: FnMut(u32, &mut R, &S) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        shared: &S,
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
    fn subgroup_bits(&self) -> u32 {
        0
    }

    #[inline]
    fn take_turns<const N: usize, V: FnMut(u32, &mut R, u32) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        let mut item = 0;
        while item < TURN_ITEMS {
            let counter = (self.lane * TURN_VALUES + value(self.lane, &mut self.registers, item)) as usize;
            let count = counters[counter];
            counters[counter] = count + 1;
            took(self.lane, &mut self.registers, item, count);
            item += 1;
        }
    }

    #[inline]
    fn running_sums<S: ?Sized, V: FnMut(u32, &mut R, &S) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        shared: &S,
        mut value: V,
        mut took: T,
    ) {
        let value = value(self.lane, &mut self.registers, shared);
        took(self.lane, &mut self.registers, 0, value);
    }
}

/// One GPU invocation that knows its subgroup.
#[cfg(target_arch = "spirv")]
pub struct SubgroupInvocation<R> {
    /// The lane, by (subgroup, invocation in it).
    pub invocation: Invocation<R>,
    /// Its subgroup.
    pub subgroup: u32,
    /// Binary logarithm of the lanes of a subgroup.
    pub subgroup_bits: u32,
}

#[cfg(target_arch = "spirv")]
impl<R> Lanes<R> for SubgroupInvocation<R> {
    #[inline]
    fn each<S: ?Sized, F: FnMut(u32, &mut R, &mut S)>(&mut self, shared: &mut S, phase: F) {
        self.invocation.each(shared, phase);
    }
}

/// Ballots tell a lane which lanes have the same value: a ballot for each of its bits (Ashkiani et al., "GPU Multisplit",
/// 2016, section 5.1). The first of them counts for all. Written out, since drivers do not unroll loops with barriers.
#[cfg(target_arch = "spirv")]
impl<R> Turns<R> for SubgroupInvocation<R> {
    #[inline]
    fn lanes(&self) -> u32 {
        self.invocation.lanes
    }

    #[inline]
    fn subgroup_bits(&self) -> u32 {
        self.subgroup_bits
    }

    #[inline]
    fn take_turns<const N: usize, V: FnMut(u32, &mut R, u32) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        let lane = self.invocation.lane;
        let registers = &mut self.invocation.registers;
        let table = self.subgroup * TURN_VALUES;
        let v0 = value(lane, registers, 0);
        let v1 = value(lane, registers, 1);
        let v2 = value(lane, registers, 2);
        let v3 = value(lane, registers, 3);
        let v4 = value(lane, registers, 4);
        let v5 = value(lane, registers, 5);
        let v6 = value(lane, registers, 6);
        let v7 = value(lane, registers, 7);
        let p0 = peers(v0);
        let p1 = peers(v1);
        let p2 = peers(v2);
        let p3 = peers(v3);
        let p4 = peers(v4);
        let p5 = peers(v5);
        let p6 = peers(v6);
        let p7 = peers(v7);
        let t0 = turn(counters, table, v0, p0);
        let t1 = turn(counters, table, v1, p1);
        let t2 = turn(counters, table, v2, p2);
        let t3 = turn(counters, table, v3, p3);
        let t4 = turn(counters, table, v4, p4);
        let t5 = turn(counters, table, v5, p5);
        let t6 = turn(counters, table, v6, p6);
        let t7 = turn(counters, table, v7, p7);
        took(lane, registers, 0, t0);
        took(lane, registers, 1, t1);
        took(lane, registers, 2, t2);
        took(lane, registers, 3, t3);
        took(lane, registers, 4, t4);
        took(lane, registers, 5, t5);
        took(lane, registers, 6, t6);
        took(lane, registers, 7, t7);
    }

    #[inline]
    fn running_sums<S: ?Sized, V: FnMut(u32, &mut R, &S) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        shared: &S,
        mut value: V,
        mut took: T,
    ) {
        let lane = self.invocation.lane;
        let registers = &mut self.invocation.registers;
        let value = value(lane, registers, shared);
        took(lane, registers, spirv_std::arch::subgroup_exclusive_i_add(value), value);
    }
}

/// How many lanes of the subgroup before this one have the same value, and how many in all.
#[cfg(target_arch = "spirv")]
#[inline]
fn peers(value: u32) -> [u32; 2] {
    use spirv_std::arch::{subgroup_ballot_bit_count, subgroup_ballot_exclusive_bit_count};
    let mut same = same_bit(value, 1);
    same = same & same_bit(value, 2);
    same = same & same_bit(value, 4);
    same = same & same_bit(value, 8);
    same = same & same_bit(value, 16);
    same = same & same_bit(value, 32);
    same = same & same_bit(value, 64);
    same = same & same_bit(value, 128);
    [subgroup_ballot_exclusive_bit_count(same), subgroup_ballot_bit_count(same)]
}

/// The lanes whose value has the same bit.
#[cfg(target_arch = "spirv")]
#[inline]
fn same_bit(value: u32, bit: u32) -> spirv_std::arch::SubgroupMask {
    let is_set = value & bit != 0;
    let set = spirv_std::arch::subgroup_ballot(is_set);
    if is_set { set } else { !set }
}

/// Takes the counter of a value, and raises it for all lanes that have the value.
#[cfg(target_arch = "spirv")]
#[inline]
fn turn<const N: usize>(counters: &mut [u32; N], table: u32, value: u32, [before, all]: [u32; 2]) -> u32 {
    let counter = (table + value) as usize;
    let count = counters[counter];
    subgroup_barrier();
    if before == 0 {
        counters[counter] = count + all;
    }
    subgroup_barrier();
    count + before
}

/// Orders what lanes of a subgroup do in workgroup memory.
#[cfg(target_arch = "spirv")]
#[inline]
fn subgroup_barrier() {
    use spirv_std::memory::{Scope, Semantics};
    spirv_std::arch::control_barrier::<
        { Scope::Subgroup as u32 },
        { Scope::Subgroup as u32 },
        { Semantics::ACQUIRE_RELEASE.bits() | Semantics::WORKGROUP_MEMORY.bits() },
    >();
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
    fn subgroup_bits(&self) -> u32 {
        self.subgroup_lanes.trailing_zeros()
    }

    #[inline]
    fn take_turns<const N: usize, V: FnMut(u32, &mut R, u32) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        counters: &mut [u32; N],
        mut value: V,
        mut took: T,
    ) {
        for item in 0..TURN_ITEMS {
            for (lane, registers) in (0..).zip(self.registers.iter_mut()) {
                let value = value(lane, registers, item);
                let counter = &mut counters[(lane / self.subgroup_lanes * TURN_VALUES + value) as usize];
                let count = *counter;
                *counter = count + 1;
                took(lane, registers, item, count);
            }
        }
    }

    #[inline]
    fn running_sums<S: ?Sized, V: FnMut(u32, &mut R, &S) -> u32, T: FnMut(u32, &mut R, u32, u32)>(
        &mut self,
        shared: &S,
        mut value: V,
        mut took: T,
    ) {
        let mut sum = 0;
        for (lane, registers) in (0..).zip(self.registers.iter_mut()) {
            if lane % self.subgroup_lanes == 0 {
                sum = 0;
            }
            let value = value(lane, registers, shared);
            took(lane, registers, sum, value);
            sum += value;
        }
    }
}
