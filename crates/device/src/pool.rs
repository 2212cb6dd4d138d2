//! What dropped buffers leave behind, for the next ones: a second frame takes the memory of the first.

use crate::cpu::{Words, lock_write};
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

/// A buffer's memory: on the CPU as words, on a GPU, or on both.
pub(crate) struct Storage {
    /// Its size, bytes: one of [`size_class`].
    pub(crate) bytes: u64,
    /// As many words as the buffer has, in memory of the size.
    pub(crate) cpu: Option<RwLock<Words>>,
    pub(crate) gpu: Option<wgpu::Buffer>,
}

impl Storage {
    /// Gives the words on the CPU the length that a buffer of `bytes` has. Nothing moves: it is at most the size.
    pub(crate) fn fit(&mut self, bytes: u64) {
        if let Some(memory) = &mut self.cpu {
            lock_write(memory).resize((bytes / 4) as usize);
        }
    }
}

/// The size of the memory that a buffer of `bytes` gets: at most a thirty-second more, so that the photons of another seed, which
/// are nearly as many, fit where the last ones were.
pub(crate) fn size_class(bytes: u64) -> u64 {
    let step = 1 << bytes.max(1).ilog2().saturating_sub(5).max(2);
    bytes.checked_next_multiple_of(step).unwrap_or(bytes)
}

/// What is kept in any case, bytes: a small frame's buffers are of so many sizes that twice what it has at once would not hold them all.
const SPARE: u64 = 64 << 20;

/// Memory that no buffer has at the moment. Together with what buffers have it is never more than twice what they had at once, or than that and
/// [`SPARE`]: what lies longest goes first.
pub(crate) struct Pool(Mutex<State>);

impl Default for Pool {
    fn default() -> Self {
        Self::sparing(SPARE)
    }
}

#[derive(Default)]
struct State {
    /// In the order in which they came.
    kept: VecDeque<Storage>,
    bytes: u64,
    in_use: u64,
    most_in_use: u64,
    spare: u64,
}

impl State {
    fn limit(&mut self) {
        while self.in_use + self.bytes > self.most_in_use + self.most_in_use.max(self.spare) {
            let Some(oldest) = self.kept.pop_front() else { break };
            self.bytes -= oldest.bytes;
        }
    }
}

impl Pool {
    fn sparing(spare: u64) -> Self {
        Self(Mutex::new(State { spare, ..State::default() }))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Memory of just this size, if there is some; the last that came, which a cache may still hold.
    pub(crate) fn take(&self, bytes: u64) -> Option<Storage> {
        let mut state = self.state();
        let place = state.kept.iter().rposition(|storage| storage.bytes == bytes)?;
        let storage = state.kept.remove(place)?;
        state.bytes -= bytes;
        Some(storage)
    }

    /// Counts memory that a buffer has now.
    pub(crate) fn lend(&self, bytes: u64) {
        let mut state = self.state();
        state.in_use += bytes;
        state.most_in_use = state.most_in_use.max(state.in_use);
        state.limit();
    }

    /// Takes the memory of a dropped buffer back.
    pub(crate) fn give_back(&self, storage: Storage) {
        let mut state = self.state();
        state.in_use -= storage.bytes;
        state.bytes += storage.bytes;
        state.kept.push_back(storage);
        state.limit();
    }

    /// Gives everything back to the system; returns how many bytes.
    pub(crate) fn empty(&self) -> u64 {
        let mut state = self.state();
        state.kept.clear();
        std::mem::take(&mut state.bytes)
    }

    /// Bytes that it keeps.
    pub(crate) fn bytes(&self) -> u64 {
        self.state().bytes
    }

    /// Calls `change` for all memory that it keeps.
    pub(crate) fn for_each(&self, change: impl FnMut(&mut Storage)) {
        self.state().kept.iter_mut().for_each(change);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn storage(bytes: u64) -> Storage {
        Storage { bytes, cpu: None, gpu: None }
    }

    #[test]
    fn classes_are_whole_words_little_larger_than_what_is_asked_for() {
        for bytes in (4..100_000).step_by(4).chain([1 << 30, (1 << 30) + 4, (1 << 50) - 4, u64::MAX - 3]) {
            let class = size_class(bytes);
            assert!(class >= bytes && class.is_multiple_of(4), "{bytes}: {class}");
            assert!(class - bytes <= bytes / 32, "{bytes}: {class}");
            assert_eq!(size_class(class), class, "{bytes}");
        }
        assert_eq!(size_class(u64::MAX), u64::MAX);
        // A thousandth more photons than a million, and than so many more.
        assert_eq!(size_class(32_000_000), size_class(32_032_000));
    }

    #[test]
    fn all_is_never_more_than_twice_what_was_in_use_and_the_oldest_goes_first() {
        let pool = Pool::sparing(0);
        for bytes in [100, 60] {
            pool.lend(bytes);
        }
        assert!(pool.take(100).is_none());
        pool.give_back(storage(100));
        pool.give_back(storage(60));
        assert_eq!(pool.bytes(), 160);
        assert!(pool.take(64).is_none(), "only of the same size");
        assert_eq!(pool.take(60).map(|storage| storage.bytes), Some(60));
        for bytes in [60, 80] {
            pool.lend(bytes);
        }
        assert_eq!(pool.bytes(), 100);
        pool.lend(20);
        pool.lend(61);
        assert_eq!(pool.bytes(), 100, "442 bytes are allowed: 221 were in use at once");
        for bytes in [60, 80, 20, 61] {
            pool.give_back(storage(bytes));
        }
        assert_eq!(pool.bytes(), 321);
        // Another buffer, and the first memory has to go for it.
        pool.lend(122);
        assert_eq!(pool.bytes(), 221);
        assert!(pool.take(100).is_none() && pool.take(61).is_some());
        assert_eq!(pool.empty(), 160);
        assert_eq!((pool.bytes(), pool.empty()), (0, 0));
    }

    #[test]
    fn words_have_the_length_of_their_buffer() {
        let mut recycled = Storage { bytes: 40, cpu: Words::zeroed(10).ok().map(RwLock::new), gpu: None };
        let start = recycled.cpu.as_ref().map(|memory| lock_write(memory).as_ptr());
        for words in [10, 9, 3, 8] {
            recycled.fit(4 * words);
            let length = recycled.cpu.as_ref().map(|memory| lock_write(memory).len() as u64);
            assert_eq!(length, Some(words));
        }
        assert_eq!(recycled.cpu.as_ref().map(|memory| lock_write(memory).as_ptr()), start, "nothing moved");
    }
}
