//! Counting numbers in bins, in memory that a workgroup shares out to its lanes.
#![allow(clippy::implicit_saturating_sub)] // rust-gpu 0.10 cannot compile `saturating_sub`

/// Lanes of a workgroup that shares out columns.
pub const COLUMN_LANES: u32 = 64;
/// Bins of a count, two to a word.
pub(crate) const BINS: u32 = 32;
/// Words of a lane for counters, or for a list.
pub(super) const WORDS: u32 = 16;
/// Most that a bin counts. More is not asked for.
const MOST: u32 = 0xffff;
/// Binary digits of a bin's number.
const DIGITS: u32 = 5;
/// Shared memory of a workgroup, a column a lane: word `w` of a lane lies beside the others' words `w`, so that lanes never meet
/// in a bank. It is small because a GPU runs as many workgroups at once as fit its shared memory.
pub type Columns = [u32; (WORDS * COLUMN_LANES) as usize];

/// Place of word `word` in the column of `lane`.
#[inline]
pub(super) fn at(word: u32, lane: u32) -> usize {
    (word * COLUMN_LANES + lane) as usize
}

/// The count of a bin.
#[inline]
pub(super) fn count_of<const N: usize>(memory: &[u32; N], lane: u32, from: u32, bin: u32) -> u32 {
    (memory[at(from + bin % WORDS, lane)] >> (bin & WORDS)) & MOST
}

/// Counts one more, unless that is too many for a bin; returns how many.
#[inline]
pub(crate) fn count<const N: usize>(memory: &mut [u32; N], lane: u32, from: u32, bin: u32) -> u32 {
    let word = at(from + bin % WORDS, lane);
    let shift = bin & WORDS;
    let counts = memory[word];
    if (counts >> shift) & MOST == MOST {
        return 0;
    }
    memory[word] = counts + (1 << shift);
    1
}

#[inline]
pub(crate) fn clear<const N: usize>(memory: &mut [u32; N], lane: u32, from: u32) {
    let mut word = 0;
    while word < WORDS {
        memory[at(from + word, lane)] = 0;
        word += 1;
    }
}

/// The bin that holds the `rank`-th of what was counted from word `from` on (from 1; [`BINS`] if there are fewer), how many are in bins before it,
/// and how many in it.
#[inline]
pub(crate) fn bin_of<const N: usize>(memory: &[u32; N], lane: u32, from: u32, rank: u32) -> (u32, u32, u32) {
    let mut bin = 0;
    let mut before = 0;
    let mut inside = count_of(memory, lane, from, 0);
    while bin < BINS && before + inside < rank {
        before += inside;
        bin += 1;
        inside = if bin < BINS { count_of(memory, lane, from, bin) } else { 0 };
    }
    (bin, before, inside)
}

/// Numbers from `first` on, in bins of 2^`shift`, up to `end`.
#[derive(Clone, Copy)]
pub(super) struct Bins {
    pub(super) first: u32,
    pub(super) end: u32,
    pub(super) shift: u32,
}

impl Bins {
    /// The squared distances of two binades below `end`: in the upper, where a good guess has the last neighbour, each bin is a
    /// 32nd of the whole.
    #[inline]
    pub(super) fn below(end: u32) -> Self {
        const SHIFT: u32 = 19;
        let first = if end > BINS << SHIFT { end - (BINS << SHIFT) } else { 0 };
        Self { first, end, shift: SHIFT }
    }

    /// All squared distances below `end`, eight binades to a bin.
    #[inline]
    pub(super) fn all_below(end: u32) -> Self {
        Self { first: 0, end, shift: 26 }
    }

    /// The parts of one of the bins.
    #[inline]
    pub(super) fn inside(self, bin: u32) -> Self {
        let first = self.first + (bin << self.shift);
        let end = first + (1 << self.shift);
        Self {
            first,
            end: if end < self.end { end } else { self.end },
            shift: if self.shift > DIGITS { self.shift - DIGITS } else { 0 },
        }
    }
}
