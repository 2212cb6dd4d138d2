//! Where recorded kernels write.

use bytemuck::Pod;
use caustic_device::{Access, Observed};
use caustic_kernels_recorded::exec::{Store, Update};
use caustic_kernels_recorded::sink;
use std::marker::PhantomData;
use std::panic::Location;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Copies of the buffers that a stage wrote. A kernel that writes the same once more leaves them as they are.
pub(crate) struct Outputs(Vec<Vec<AtomicU32>>);

impl Outputs {
    pub(crate) fn of(stage: &Observed<'_>) -> Self {
        let copy = |words: &[u32]| words.iter().map(|&word| AtomicU32::new(word)).collect();
        let buffers = stage.kernel.bindings().iter().zip(stage.buffers);
        Self(buffers.map(|(b, words)| if b.access == Access::Out { copy(words) } else { Vec::new() }).collect())
    }

    /// A handle to the records of a binding.
    pub(crate) fn write<T: Pod>(&self, binding: usize) -> Output<'_, T> {
        Output { words: &self.0[binding], record: PhantomData }
    }

    /// The address by which accesses to a binding know it, if it is written.
    pub(crate) fn address(&self, binding: usize) -> Option<usize> {
        let words = &self.0[binding];
        (!words.is_empty()).then(|| words.as_ptr().addr())
    }

    /// The first buffer that is not as the stage left it.
    pub(crate) fn changed(&self, stage: &Observed<'_>) -> Option<&'static str> {
        let buffers = self.0.iter().zip(stage.buffers).zip(stage.kernel.bindings());
        let changed = |(copy, words): (&Vec<AtomicU32>, &&[u32])| {
            copy.iter().zip(words.iter()).any(|(copy, &word)| copy.load(Relaxed) != word)
        };
        buffers.into_iter().find(|&(pair, _)| changed(pair)).map(|(_, binding)| binding.name)
    }
}

/// A handle to the records of an output, of which every workgroup has its own copy.
pub(crate) struct Output<'a, T> {
    words: &'a [AtomicU32],
    record: PhantomData<fn(T)>,
}

impl<T> Clone for Output<'_, T> {
    fn clone(&self) -> Self {
        Self { words: self.words, record: PhantomData }
    }
}

impl<T: Pod> Store<T> for Output<'_, T> {
    #[track_caller]
    fn set(&mut self, i: u32, value: T) {
        sink::access(Location::caller(), self.words.as_ptr().addr(), i as usize, size_of::<T>());
        let words: &[u32] = bytemuck::cast_slice(std::slice::from_ref(&value));
        let first = i as usize * words.len();
        for (to, &from) in self.words[first..first + words.len()].iter().zip(words) {
            to.store(from, Relaxed);
        }
    }
}

/// Kernels that change buffers in place are not recorded: what they found is gone. Their bodies are compiled like all others.
impl<T: Pod> Update<T> for Output<'_, T> {
    fn get(&self, _i: u32) -> T {
        unreachable!("kernels that change buffers in place are not recorded")
    }
}
