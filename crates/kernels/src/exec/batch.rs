//! Invocations that share nothing, in phases.

/// Some invocations, each with registers that cross phases.
///
/// A core that reads memory in random order, and computes with what it has read before it reads on, waits for one line after
/// another: it looks ahead a few hundred instructions only. With the reads in a phase of their own it waits for many at once. A GPU
/// does so anyway, by switching to other lanes.
pub trait Batch<R> {
    /// Calls `phase(index, registers)` for each invocation.
    fn each<F: FnMut(u32, &mut R)>(&mut self, phase: F);
}

/// One GPU invocation. There is no barrier between its phases: nobody else is concerned.
#[cfg(target_arch = "spirv")]
pub struct Single<R> {
    /// Its index among all.
    pub index: u32,
    /// Its registers.
    pub registers: R,
}

#[cfg(target_arch = "spirv")]
impl<R> Batch<R> for Single<R> {
    #[inline]
    fn each<F: FnMut(u32, &mut R)>(&mut self, mut phase: F) {
        phase(self.index, &mut self.registers);
    }
}

/// A workgroup of invocations on the CPU: all of them finish a phase before the next begins.
#[cfg(not(target_arch = "spirv"))]
pub struct Many<'a, R> {
    /// Index of the first.
    pub first: u32,
    /// Registers of each.
    pub registers: &'a mut [R],
    /// The order in which a phase visits them: a permutation.
    pub order: &'a [u32],
}

#[cfg(not(target_arch = "spirv"))]
impl<R> Batch<R> for Many<'_, R> {
    #[inline]
    fn each<F: FnMut(u32, &mut R)>(&mut self, mut phase: F) {
        for &lane in self.order {
            phase(self.first + lane, &mut self.registers[lane as usize]);
        }
    }
}
