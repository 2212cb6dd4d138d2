//! Buffers that many threads write at once.
//!
//! The stages promise that no two invocations write the same element, but nothing here relies on it: every word is an
//! atomic, written without ordering, which costs a plain store. A kernel that breaks the promise gives a wrong result
//! that a test can see, never undefined behaviour.

use bytemuck::Pod;
use caustic_kernels::exec::{Store, Update};
use std::marker::PhantomData;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use zerocopy::{FromBytes, IntoBytes};

/// A buffer as one stage sees it.
pub(crate) enum Bound<'a> {
    Read(&'a [u32]),
    Write(&'a [AtomicU32]),
}

impl<'a> Bound<'a> {
    /// A buffer that the stage's threads write.
    pub(crate) fn write_words(words: &'a mut [u32]) -> Self {
        let atomics = <[AtomicU32]>::mut_from_bytes(words.as_mut_bytes());
        Self::Write(atomics.expect("an atomic word has the size and the alignment of a word where caustic runs"))
    }

    /// The records of a buffer that the stage reads.
    pub(crate) fn read<T: Pod>(&self) -> &'a [T] {
        match self {
            Self::Read(words) => bytemuck::cast_slice(words),
            Self::Write(_) => unreachable!("bound for writing"),
        }
    }

    /// A handle to the records of a buffer that the stage writes.
    pub(crate) fn write<T: Pod>(&self) -> SharedMut<'a, T> {
        match self {
            Self::Write(words) => SharedMut { words, record: PhantomData },
            Self::Read(_) => unreachable!("bound for reading"),
        }
    }
}

/// A handle to the records of a buffer, of which every thread has its own copy.
pub(crate) struct SharedMut<'a, T> {
    words: &'a [AtomicU32],
    record: PhantomData<fn(T)>,
}

impl<T> Clone for SharedMut<'_, T> {
    #[inline]
    fn clone(&self) -> Self {
        Self { words: self.words, record: PhantomData }
    }
}

impl<T: Pod> Store<T> for SharedMut<'_, T> {
    #[inline]
    fn set(&mut self, i: u32, value: T) {
        let words: &[u32] = bytemuck::cast_slice(std::slice::from_ref(&value));
        let first = i as usize * words.len();
        for (to, &from) in self.words[first..first + words.len()].iter().zip(words) {
            to.store(from, Relaxed);
        }
    }
}

impl<T: Pod> Update<T> for SharedMut<'_, T> {
    #[inline]
    fn get(&self, i: u32) -> T {
        let mut value = T::zeroed();
        let words: &mut [u32] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut value));
        let first = i as usize * words.len();
        for (to, from) in words.iter_mut().zip(&self.words[first..]) {
            *to = from.load(Relaxed);
        }
        value
    }
}
