//! Memory of the CPU's buffers.

use memmap2::MmapMut;
use std::io;
use std::ops::{Deref, DerefMut};

/// Words that are zero at first. Their memory comes from the operating system as it is touched, and in huge pages where those can be
/// asked for (Linux): the addresses of 2 MiB take one place in the processor's cache of addresses, and random accesses find theirs.
pub(crate) struct Words {
    memory: MmapMut,
    len: usize,
}

impl Words {
    /// `len` words of zero.
    pub(crate) fn zeroed(len: usize) -> io::Result<Self> {
        let bytes = len.max(1).checked_mul(4).ok_or(io::ErrorKind::OutOfMemory)?;
        let memory = MmapMut::map_anon(bytes)?;
        // A wish: where the system has no huge pages, all else is as it was.
        #[cfg(target_os = "linux")]
        let _ = memory.advise(memmap2::Advice::HugePage);
        Ok(Self { memory, len })
    }

    /// Changes how many words there are, within the memory that there was at first.
    pub(crate) fn resize(&mut self, len: usize) {
        assert!(len * 4 <= self.memory.len(), "memory of {} bytes does not hold {len} words", self.memory.len());
        self.len = len;
    }
}

impl Deref for Words {
    type Target = [u32];

    #[inline]
    fn deref(&self) -> &[u32] {
        bytemuck::cast_slice(&self.memory[..self.len * 4])
    }
}

impl DerefMut for Words {
    #[inline]
    fn deref_mut(&mut self) -> &mut [u32] {
        bytemuck::cast_slice_mut(&mut self.memory[..self.len * 4])
    }
}
