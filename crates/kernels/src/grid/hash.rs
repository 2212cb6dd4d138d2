//! From cells to entries of the hash table.

use super::Grid;

/// Linear cell number (eq. 3.2).
pub const HASH_LINEAR: u32 = 0;
/// Teschner et al. 2003 (eq. 3.3).
pub const HASH_TESCHNER: u32 = 1;
/// Z-order curve (Morton 1966).
pub const HASH_MORTON: u32 = 2;

/// The table entry of a cell.
///
/// Linear numbers are unique. The other two may send several cells to one entry, so whoever searches an entry checks the
/// cell of what it finds.
#[inline]
#[must_use]
pub fn hash_cell(grid: &Grid, cell: [u32; 3]) -> u32 {
    if grid.hash == HASH_LINEAR {
        linear(cell, grid.cells)
    } else if grid.hash == HASH_TESCHNER {
        teschner(cell) & (grid.table - 1)
    } else {
        morton(cell) & (grid.table - 1)
    }
}

/// z · size_y · size_x + y · size_x + x (eq. 3.2).
#[inline]
#[must_use]
pub fn linear(cell: [u32; 3], cells: [u32; 3]) -> u32 {
    (cell[2] * cells[1] + cell[1]) * cells[0] + cell[0]
}

/// x·p₁ xor y·p₂ xor z·p₃ with the primes of Teschner et al., modulo 2³² (eq. 3.3 before the modulo, for which the caller
/// takes the logical AND with n − 1, as section 3.1.4 suggests).
#[inline]
#[must_use]
pub fn teschner(cell: [u32; 3]) -> u32 {
    cell[0].wrapping_mul(73_856_093) ^ cell[1].wrapping_mul(19_349_663) ^ cell[2].wrapping_mul(83_492_791)
}

/// The lowest ten bits of x, y and z interleaved, x lowest. Coordinates of 1024 cells and more wrap around.
#[inline]
#[must_use]
pub fn morton(cell: [u32; 3]) -> u32 {
    spread(cell[0]) | (spread(cell[1]) << 1) | (spread(cell[2]) << 2)
}

/// Moves bit `i` of the lowest ten bits to bit `3i`.
#[inline]
fn spread(x: u32) -> u32 {
    let x = x & 0x3ff;
    let x = (x | (x << 16)) & 0x0300_00ff;
    let x = (x | (x << 8)) & 0x0300_f00f;
    let x = (x | (x << 4)) & 0x030c_30c3;
    (x | (x << 2)) & 0x0924_9249
}
