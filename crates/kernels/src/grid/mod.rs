//! The spatial hash of the thesis (chapter 3): a grid of cells as wide as the largest query radius, a hash of the cell,
//! photons sorted by hash, and a table of where each hash value begins and ends.

mod cell;
mod hash;
mod ranges;

pub use cell::{cell_of, least_distance2, neighbour_cell};
pub use hash::{HASH_LINEAR, HASH_MORTON, HASH_TESCHNER, hash_cell, linear, morton, teschner};
pub use ranges::{cell_ranges, hash_photons, reorder_photons};

use bytemuck::{Pod, Zeroable};

/// Lanes of a workgroup of the stages that handle one photon an invocation.
pub const GRID_LANES: u32 = 256;
/// Most cells an axis may have, border included. A coordinate in cells then has an error below 2⁻², which the margin
/// of [`Grid::inverse_cell`] covers.
pub const MAX_CELLS_PER_AXIS: u32 = 1 << 20;

/// A grid over the photons' bounding box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Lowest corner of the photons' bounding box, the "world origin" of section 3.1.3, m.
    pub origin: [f32; 3],
    /// The scaling factor s of eq. 3.1, m⁻¹: a little less than 1 / r_max, by the rounding errors of a coordinate, so that
    /// two points at most r_max apart are never more than one cell apart.
    pub inverse_cell: f32,
    /// Cells along each axis, two border cells included.
    pub cells: [u32; 3],
    /// Which hash: [`HASH_LINEAR`], [`HASH_TESCHNER`] or [`HASH_MORTON`].
    pub hash: u32,
    /// Entries of the hash table; a power of two unless the hash is linear.
    pub table: u32,
    /// Photons in the map.
    pub photons: u32,
    /// Largest query radius, squared, m².
    pub radius2: f32,
    /// Width of a cell, rounded down, m.
    pub cell_width: f32,
    /// Most by which the coordinates of two points in cells, subtracted, can be wrong.
    pub slack: f32,
}

const _: () = assert!(size_of::<Grid>() == 52);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Photon;
    use std::collections::BTreeSet;
    use std::vec;
    use std::vec::Vec;

    fn grid(hash: u32, table: u32) -> Grid {
        Grid { origin: [-1.0, 2.0, 0.5], inverse_cell: 2.0, cells: [7, 5, 4], hash, table, ..Grid::default() }
    }

    #[test]
    fn positions_fall_into_cells_and_outside_ones_into_the_nearest() {
        let grid = grid(HASH_LINEAR, 140);
        // The origin is in the first inner cell, and a border belongs to the cell above it.
        assert_eq!(cell_of(&grid, [-1.0, 2.0, 0.5]), [1, 1, 1]);
        assert_eq!(cell_of(&grid, [-0.5, 2.5, 1.0]), [2, 2, 2]);
        assert_eq!(cell_of(&grid, [(-0.5f32).next_down(), 2.5f32.next_down(), 1.0f32.next_down()]), [1, 1, 1]);
        assert_eq!(cell_of(&grid, [1.49, 3.49, 1.49]), [5, 3, 2]);
        for far in [100.0, 1e9, 1e30, f32::MAX] {
            assert_eq!(cell_of(&grid, [far; 3]), [5, 3, 2], "{far}");
            assert_eq!(cell_of(&grid, [-far; 3]), [1, 1, 1], "{far}");
        }
    }

    #[test]
    fn the_neighbourhood_is_27_cells_and_begins_with_the_centre() {
        let all: Vec<_> = (0..27).map(|n| neighbour_cell([5, 9, 1], n)).collect();
        assert_eq!(all[0], [5, 9, 1]);
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), 27);
        for cell in all {
            assert!((4..=6).contains(&cell[0]) && (8..=10).contains(&cell[1]) && (0..=2).contains(&cell[2]));
        }
    }

    #[test]
    fn linear_numbers_are_those_of_the_table_and_unique() {
        let mut entry = 0;
        for z in 0..4 {
            for y in 0..5 {
                for x in 0..7 {
                    assert_eq!(hash_cell(&grid(HASH_LINEAR, 140), [x, y, z]), entry);
                    entry += 1;
                }
            }
        }
    }

    #[test]
    fn teschner_is_equation_3_3() {
        // In u64, where nothing overflows.
        for cell in [[0, 0, 0], [1, 1, 1], [1, 2, 3], [1023, 77, 500_000], [(1 << 20) - 1; 3]] {
            let [x, y, z] = cell.map(u64::from);
            let expected = (x * 73_856_093) ^ (y * 19_349_663) ^ (z * 83_492_791);
            for table in [1, 2, 1024, 1 << 27] {
                assert_eq!(u64::from(hash_cell(&grid(HASH_TESCHNER, table), cell)), expected % u64::from(table));
            }
        }
    }

    #[test]
    fn morton_interleaves_ten_bits() {
        for cell in
            [[0u32, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1023; 3], [0x155, 0x2aa, 0x3c3], [1024, 1025, 4096]]
        {
            let mut expected = 0;
            for bit in 0..10 {
                for (axis, &coordinate) in (0..).zip(&cell) {
                    expected |= ((coordinate >> bit) & 1) << (3 * bit + axis);
                }
            }
            assert_eq!(morton(cell), expected, "{cell:?}");
            assert_eq!(hash_cell(&grid(HASH_MORTON, 256), cell), expected % 256);
        }
    }

    #[test]
    fn ranges_are_where_keys_begin_and_end() {
        let check = |keys: &[u32], expected: &[(u32, u32)]| {
            let grid = Grid { photons: keys.len() as u32, ..grid(HASH_MORTON, 8) };
            let (mut starts, mut ends) = (vec![0; 8], vec![0; 8]);
            // More invocations than photons, last first: the order must not matter.
            for i in (0..grid.photons + 5).rev() {
                cell_ranges(i, &grid, keys, starts.as_mut_slice(), ends.as_mut_slice());
            }
            assert_eq!(starts.into_iter().zip(ends).collect::<Vec<_>>(), expected);
        };
        check(&[], &[(0, 0); 8]);
        check(&[5], &[(0, 0), (0, 0), (0, 0), (0, 0), (0, 0), (0, 1), (0, 0), (0, 0)]);
        check(&[0, 0, 3, 7, 7, 7], &[(0, 2), (0, 0), (0, 0), (2, 3), (0, 0), (0, 0), (0, 0), (3, 6)]);
    }

    #[test]
    fn photons_are_hashed_and_put_in_order_and_no_more_of_them_than_there_are() {
        let photons: Vec<_> = (0..6u32)
            .map(|i| Photon { position: [i as f32 * 0.4, 2.0, 0.5], primitive: i, ..Photon::default() })
            .collect();
        // Room for two more than the map has.
        let grid = Grid { photons: 4, ..grid(HASH_LINEAR, 140) };
        let mut keys = vec![99; 6];
        for i in 0..8 {
            hash_photons(i, &grid, &photons, keys.as_mut_slice());
        }
        let expected: Vec<_> = photons[..4].iter().map(|p| linear(cell_of(&grid, p.position), grid.cells)).collect();
        assert_eq!((&keys[..4], &keys[4..]), (&expected[..], &[99, 99][..]));
        let mut sorted = vec![Photon::default(); 6];
        for i in 0..8 {
            reorder_photons(i, &grid, &[3, 1, 0, 2], &photons, sorted.as_mut_slice());
        }
        assert_eq!(sorted.iter().map(|p| p.primitive).collect::<Vec<_>>(), [3, 1, 0, 2, 0, 0]);
    }
}
