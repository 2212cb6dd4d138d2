//! Buffers that many threads write at once.
//!
//! The stages promise that no two invocations write the same element, but nothing here relies on it: every word is an
//! atomic, written without ordering, which costs a plain store. A kernel that breaks the promise gives a wrong result
//! that a test can see, never undefined behaviour.
#![allow(unsafe_code)]

use bytemuck::Pod;
use caustic_kernels::exec::{Store, Tally};
use std::marker::PhantomData;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// A buffer as one stage sees it.
pub(crate) enum Bound<'a> {
    Read(&'a [u32]),
    Write(&'a [AtomicU32]),
}

impl<'a> Bound<'a> {
    /// A buffer that the stage's threads write.
    pub(crate) fn write_words(words: &'a mut [u32]) -> Self {
        // SAFETY: the exclusive borrow lasts as long as the result, AtomicU32 has the size and, on every platform that
        // caustic runs on, the alignment of u32 (asserted below), and any bits are a valid value of both.
        const { assert!(align_of::<AtomicU32>() == align_of::<u32>() && size_of::<AtomicU32>() == size_of::<u32>()) };
        Self::Write(unsafe { &*(std::ptr::from_mut(words) as *const [AtomicU32]) })
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

impl Tally for SharedMut<'_, u32> {
    #[inline]
    fn add(&mut self, i: u32, n: u32) {
        self.words[i as usize].fetch_add(n, Relaxed);
    }

    #[inline]
    fn max(&mut self, i: u32, n: u32) {
        self.words[i as usize].fetch_max(n, Relaxed);
    }
}
