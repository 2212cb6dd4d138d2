//! What a body sees in place of `caustic_kernels::exec`.

use crate::sink;
use bytemuck::TransparentWrapper;
use std::ops::{Index, IndexMut};
use std::panic::Location;

pub use caustic_kernels::exec::{Batch, Lanes, Many, Store, TURN_ITEMS, TURN_VALUES, Turns, Update};

/// A stage's input buffer, whose reads are written down: a record is read whole.
#[derive(TransparentWrapper)]
#[repr(transparent)]
pub struct Input<T>([T]);

impl<T> Input<T> {
    /// How many records there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T> Index<usize> for Input<T> {
    type Output = T;

    #[track_caller]
    fn index(&self, i: usize) -> &T {
        sink::access(Location::caller(), self.0.as_ptr().addr(), i, size_of::<T>());
        &self.0[i]
    }
}

/// A lane's private array in local memory, whose accesses are counted: a load for each value that is read, a store for each place
/// that is written.
#[derive(Clone)]
pub struct Local<T, const N: usize>([T; N]);

impl<T: Copy, const N: usize> Local<T, N> {
    /// An array of equal values. A GPU does not initialise it, so that counts as nothing.
    #[must_use]
    pub fn of(value: T) -> Self {
        Self([value; N])
    }
}

impl<T, const N: usize> Index<usize> for Local<T, N> {
    type Output = T;

    fn index(&self, i: usize) -> &T {
        sink::local_load();
        &self.0[i]
    }
}

impl<T, const N: usize> IndexMut<usize> for Local<T, N> {
    fn index_mut(&mut self, i: usize) -> &mut T {
        sink::local_store();
        &mut self.0[i]
    }
}

/// A [`Local`] of `N` equal values.
macro_rules! local {
    ($value:expr; $n:expr) => {
        $crate::exec::Local::of($value)
    };
}
pub(crate) use local;
