//! The spatial hash of the thesis (chapter 3): a grid of cells, a hash of the cell, photons sorted by hash, and a table of where
//! each hash value begins.
//!
//! The thesis has cells as wide as the largest query radius, so that a search looks at 27. Here a cell's width is free: fewer
//! photons a cell mean less to test, and a linear hash makes all cells of a row one run, so that many cells cost little.

mod cell;
mod hash;
mod ranges;
mod seen;

pub use cell::{axis_cell, cell_of, coordinates, gap};
pub use hash::{HASH_LINEAR, HASH_MORTON, HASH_TESCHNER, hash_cell, linear, morton, teschner};
pub use ranges::{
    BEGINS_BLOCK, BeginsShared, GRID_BLOCK, GridRegisters, LargestShared, Moved, cell_begins, hash_photons,
    hash_queries, reorder_photons,
};
pub use seen::{keep_photons, mark_cells, see_photons};

use bytemuck::{Pod, Zeroable};

/// Most cells an axis may have. A coordinate in cells then has an error below 2⁻², which [`Grid::slack`] covers.
pub const MAX_CELLS_PER_AXIS: u32 = 1 << 20;
/// Most cells between a query and the end of its search along an axis.
pub const MAX_REACH: u32 = 1 << 7;

/// A grid over the photons' bounding box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Lowest corner of the photons' bounding box, the "world origin" of section 3.1.3, m.
    pub origin: [f32; 3],
    /// The scaling factor s of eq. 3.1, m⁻¹.
    pub inverse_cell: f32,
    /// Cells along each axis.
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
    /// Number of [`Row`]s.
    pub rows: u32,
    /// Steps in which a compact map keeps positions, from the origin, m.
    pub step: f32,
}

/// A row of cells along x, seen from the cell of a query. The table of rows has all that a search may have to visit, nearest
/// first: the neighbour offset table of section 3.1.3.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Row {
    /// Cells in y, plus [`MAX_REACH`].
    pub y: u32,
    /// Cells in z, plus [`MAX_REACH`].
    pub z: u32,
    /// Lower bound on the squared distance to whatever lies in the row, wherever in its cell the query is, m².
    pub least2: f32,
}

const _: () = assert!(size_of::<Grid>() == 60 && size_of::<Row>() == 12);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::{Many, Workgroup};
    use crate::layout::{Arrival, Photon, Site};
    use crate::num::Limbs;
    use std::vec;
    use std::vec::Vec;

    fn grid(hash: u32, table: u32) -> Grid {
        Grid { origin: [-1.0, 2.0, 0.5], inverse_cell: 2.0, cells: [5, 3, 2], hash, table, ..Grid::default() }
    }

    #[test]
    fn positions_fall_into_cells_and_outside_ones_into_the_nearest() {
        let grid = grid(HASH_LINEAR, 30);
        // A border belongs to the cell above it.
        assert_eq!(cell_of(&grid, [-1.0, 2.0, 0.5]), [0, 0, 0]);
        assert_eq!(cell_of(&grid, [-0.5, 2.5, 1.0]), [1, 1, 1]);
        assert_eq!(cell_of(&grid, [(-0.5f32).next_down(), 2.5f32.next_down(), 1.0f32.next_down()]), [0, 0, 0]);
        assert_eq!(cell_of(&grid, [1.49, 3.49, 1.49]), [4, 2, 1]);
        for far in [100.0, 1e9, 1e30, f32::MAX] {
            assert_eq!(cell_of(&grid, [far; 3]), [4, 2, 1], "{far}");
            assert_eq!(cell_of(&grid, [-far; 3]), [0, 0, 0], "{far}");
        }
    }

    #[test]
    fn a_gap_is_the_distance_to_a_cell_less_the_slack() {
        let grid = Grid { cell_width: 0.5, slack: 0.01, ..grid(HASH_LINEAR, 30) };
        for (coordinate, cell, expected) in
            [(1.5, 1, 0.0), (1.5, 2, 0.5), (1.5, 0, 0.5), (1.5, 4, 2.5), (3.25, 1, 1.25), (2.0, 2, 0.0), (2.0, 1, 0.0)]
        {
            let expected = if expected == 0.0 { 0.0 } else { (expected - 0.01) * 0.5 };
            assert!((gap(&grid, coordinate, cell) - expected).abs() < 1e-6, "{coordinate} {cell}");
        }
    }

    #[test]
    fn linear_numbers_are_those_of_the_table_and_unique() {
        let mut entry = 0;
        for z in 0..2 {
            for y in 0..3 {
                for x in 0..5 {
                    assert_eq!(hash_cell(&grid(HASH_LINEAR, 30), [x, y, z]), entry);
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

    /// A workgroup with the lanes of a GPU, or with one as on the CPU.
    macro_rules! workgroup {
        ($lanes:expr) => {
            &mut Workgroup {
                registers: &mut [GridRegisters::<{ GRID_BLOCK as usize / $lanes }>::default(); $lanes],
                order: &(0..$lanes).rev().collect::<Vec<u32>>(),
                subgroup_lanes: 1,
            }
        };
    }

    #[test]
    fn an_entry_begins_at_the_first_key_that_is_not_below_it() {
        let check = |table: u32, keys: &[u32]| {
            let grid = Grid { photons: keys.len() as u32, ..grid(HASH_MORTON, table) };
            let expected: Vec<u32> = (0..=table).map(|entry| keys.partition_point(|&key| key < entry) as u32).collect();
            let blocks = keys.len().div_ceil(GRID_BLOCK as usize);
            let powers: Vec<u32> = (0..3 * blocks as u32).map(|n| n * 7 % 11).collect();
            let largest = |channel: usize| powers.iter().skip(channel).step_by(3).copied().max().unwrap_or(0);
            for one in [false, true] {
                let (mut begins, mut power) = (vec![9; table as usize + 1], [99; 3]);
                // A workgroup too many, which must do nothing.
                for group in 0..(table + 1).div_ceil(BEGINS_BLOCK) + 1 {
                    let (shared, begins, power) = (&mut [9; 1538], begins.as_mut_slice(), power.as_mut_slice());
                    if one {
                        cell_begins(workgroup!(1), group, shared, &grid, keys, &powers, begins, power);
                    } else {
                        cell_begins(workgroup!(256), group, shared, &grid, keys, &powers, begins, power);
                    }
                }
                assert!(begins == expected, "{} keys", keys.len());
                assert_eq!(power, [0, 1, 2].map(largest));
            }
        };
        check(8, &[]);
        check(8, &[5]);
        check(8, &[0, 0, 3, 7, 7, 7]);
        check(1, &[0; 10_000]);
        let mut random: Vec<u32> = (0..40_000).map(|i| crate::num::pcg4d([i, 1, 2, 3])[0] % 30_000).collect();
        random.sort_unstable();
        check(30_000, &random);
        // A crowd in one entry, and none far around it.
        random.fill(9000);
        check(30_000, &random);
    }

    #[test]
    fn photons_are_hashed_and_put_in_order_and_no_more_of_them_than_there_are() {
        let photons: Vec<_> = (0..5000u32)
            .map(|i| Photon {
                position: [i as f32 * 4e-4, 2.0, 0.5],
                power: [0.0, 1.0, (i % 4567) as f32],
                direction: i,
                ..Photon::default()
            })
            .collect();
        // Room for more than the map has.
        let grid = Grid { photons: 4998, ..grid(HASH_LINEAR, 30) };
        let expected: Vec<_> = photons[..4998].iter().map(|p| linear(cell_of(&grid, p.position), grid.cells)).collect();
        for one in [false, true] {
            let (mut keys, mut powers) = (vec![99; 5000], [99; 9]);
            for group in 0..3 {
                let (shared, keys, powers) = (&mut [9; 768], keys.as_mut_slice(), powers.as_mut_slice());
                if one {
                    hash_photons(workgroup!(1), group, shared, &grid, &photons, keys, powers);
                } else {
                    hash_photons(workgroup!(256), group, shared, &grid, &photons, keys, powers);
                }
            }
            assert!((&keys[..4998], &keys[4998..]) == (&expected[..], &[99, 99][..]));
            let bits = f32::to_bits;
            assert_eq!(powers, [0, bits(1.0), bits(4095.0), 0, bits(1.0), bits(4566.0), 99, 99, 99]);
        }
        let (mut sites, mut arrivals) = (vec![Site::default(); 6], vec![Arrival::default(); 6]);
        let grid = Grid { photons: 4, ..grid };
        for first in [0, 3, 6] {
            let (sites, arrivals) = (sites.as_mut_slice(), arrivals.as_mut_slice());
            let power = [1f32, 1.0, 4566.0].map(f32::to_bits);
            let mut batch = Many { first, registers: &mut [Moved::default(); 3], order: &[2, 0, 1] };
            reorder_photons(&mut batch, &grid, &[3, 1, 0, 2], &photons, &power, sites, arrivals);
        }
        assert_eq!(sites.iter().map(|site| site.photon()).collect::<Vec<_>>(), [3, 1, 0, 2, 0, 0]);
        assert_eq!(arrivals.iter().map(|arrival| arrival.direction()).collect::<Vec<_>>(), [3, 1, 0, 2, 0, 0]);
        assert_eq!(sites[0].position(), photons[3].position);
        let [high, middle, low] = arrivals[0].limbs();
        for (channel, scale) in [1.0, 1.0, 4566.0].into_iter().enumerate() {
            let limbs = Limbs([high[channel], middle[channel], low[channel]]);
            assert_eq!(limbs.value(scale), photons[3].power[channel]);
        }
    }
}
