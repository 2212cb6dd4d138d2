//! The grid over a bounding box: its origin, its cells and its table.

use crate::crowding::{OCCUPANCY, cell_width, occupancy, occupied_cells};
use crate::{Hash, MapError, MapOptions};
use caustic_kernels::grid::{Grid, MAX_CELLS_PER_AXIS, MAX_REACH, Row};
use caustic_kernels::num::{floor_to_i32, is_finite};

/// Most entries of a hash table: 4 bytes each.
pub const MAX_TABLE: u32 = 1 << 27;
/// Longest side of a grid, m.
const MAX_EXTENT: f64 = 1e37;
/// Most cells of a linear hash: three passes of the sort.
const MAX_CELLS: u32 = 1 << 24;
/// Entries of a linear table a photon, at most: as many bytes as the photon takes.
const ENTRIES_PER_PHOTON: u64 = 16;
/// How much fuller than those of a Teschner hash the cells of a linear one may be, as photons see it, before the former is faster. On an H100
/// cells eleven times as full (nine of ten photons in a thousandth of the volume) take the linear hash 1.7 times as long as even ones,
/// and Teschner's takes 2.5 times as long as the linear one where both have the cells they want (two CPU cores): the crossover is beyond.
const CROWDED: f64 = 32.0;
/// Most cells to a radius.
const MOST_REACH: f64 = 32.0;
/// Radii that a map can have, m: where squared distances are far above those that count as none, and finite.
pub const RADII: std::ops::RangeInclusive<f32> = 1e-9..=1e18;
/// Most photons of a map.
pub(crate) const MAX_PHOTONS: u32 = 1 << 30;

/// The bounding box of positions; a point at the origin for none.
///
/// # Errors
/// [`MapError::NotFinite`], with the number of bad positions and the index of the first.
pub fn bounds(what: &'static str, positions: impl Iterator<Item = [f32; 3]>) -> Result<([f32; 3], [f32; 3]), MapError> {
    let mut low = [f32::MAX; 3];
    let mut high = [f32::MIN; 3];
    let mut bad = (0, 0);
    let mut count = 0;
    for (i, position) in positions.enumerate() {
        if !position.into_iter().all(is_finite) {
            bad = (bad.0 + 1, if bad.0 == 0 { i } else { bad.1 });
        }
        for axis in 0..3 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
        count += 1;
    }
    if bad.0 > 0 {
        return Err(MapError::NotFinite { what, count: bad.0, first: bad.1 });
    }
    Ok(if count == 0 { ([0.0; 3], [0.0; 3]) } else { (low, high) })
}

/// The grid for `photons` photons inside the box from `low` to `high`. `sample` are the positions of some of them, any as likely
/// as another: how they crowd says how wide cells should be.
///
/// # Errors
/// [`MapError::Radius`], [`MapError::Extent`], [`MapError::TableSize`] and [`MapError::TooMany`].
pub fn plan_grid(
    low: [f32; 3],
    high: [f32; 3],
    photons: u64,
    sample: &[[f32; 3]],
    options: &MapOptions,
) -> Result<Grid, MapError> {
    let radius = options.radius;
    if !RADII.contains(&radius) {
        return Err(MapError::Radius { radius });
    }
    if photons > u64::from(MAX_PHOTONS) {
        return Err(MapError::TooMany { what: "photons", count: photons, max: MAX_PHOTONS });
    }
    let sides: [f64; 3] = std::array::from_fn(|axis| f64::from(high[axis]) - f64::from(low[axis]));
    let extent = sides.into_iter().fold(0.0, f64::max);
    if extent > MAX_EXTENT {
        return Err(MapError::Extent { extent, max: MAX_EXTENT });
    }
    let wanted = options.cell.map_or_else(|| cell_width(low, sides, photons, sample, options), f64::from);
    let with = |hash| MapOptions { hash, ..*options };
    let options = &match options.hash {
        Hash::Auto => {
            let crowd = |hash| occupancy(low, photons, sample, possible_width(sides, photons, wanted, &with(hash)));
            let [linear, scattered] = [Hash::Linear, Hash::Teschner].map(crowd);
            if linear > CROWDED * scattered.max(OCCUPANCY) {
                // The most entries of a linear table say nothing of one that scatters cells.
                MapOptions { table: None, ..with(Hash::Teschner) }
            } else {
                with(Hash::Linear)
            }
        }
        hash => with(hash),
    };
    let width = possible_width(sides, photons, wanted, options);
    // (x − origin)·s has a relative error of 2⁻²³ at most, hence an absolute one of inner·2⁻²³ cells, for each of two points.
    let inner = extent / width + 1.0;
    let inverse_cell = round_down(1.0 / width);
    let mut cells = [0; 3];
    for axis in 0..3 {
        // The kernels' own arithmetic: the highest corner gets the last cell.
        cells[axis] = floor_to_i32((high[axis] - low[axis]) * inverse_cell) as u32 + 1;
    }
    let mut grid = Grid {
        origin: low,
        inverse_cell,
        cells,
        hash: options.hash.code(),
        table: table(cells, photons, options, || occupied_cells(low, photons, sample, width))?,
        photons: photons as u32,
        radius2: radius * radius,
        // 2⁻²⁰ covers the rounding of a squared distance, on both sides of the comparison it is made for.
        cell_width: round_down((1.0 - 2f64.powi(-20)) / f64::from(inverse_cell)),
        slack: (inner * 2f64.powi(-22)) as f32 + f32::EPSILON,
        rows: 0,
        step: step(low, high, extent),
    };
    grid.rows = rows(&grid).len() as u32;
    Ok(grid)
}

/// Steps of a compact map: 2²¹ of them are longer than the box, and each is four units of the last place of a coordinate at least, so that
/// a point of the lattice is the nearest to itself however it is rounded.
fn step(low: [f32; 3], high: [f32; 3], extent: f64) -> f32 {
    let farthest = low.into_iter().chain(high).fold(f32::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let last_place = f64::from(farthest.next_up()) - f64::from(farthest);
    (extent / f64::from((1 << 21) - 4)).max(4.0 * last_place).max(1e-30) as f32
}

/// The rows of cells that a search may have to visit, nearest first: those within the radius of some query in some cell of the
/// grid.
#[must_use]
pub fn rows(grid: &Grid) -> Vec<Row> {
    let reach = MAX_REACH as i32 - 1;
    let gap = |cells: i32| {
        let gap = f64::from(cells.abs() - 1) - f64::from(grid.slack);
        gap.max(0.0) * f64::from(grid.cell_width)
    };
    let near = |&cells: &i32| gap(cells).powi(2) <= f64::from(grid.radius2);
    let axis = |all: u32| (-reach..=reach).filter(near).filter(move |cells| cells.unsigned_abs() < all);
    let mut rows: Vec<(i32, Row)> = Vec::new();
    for z in axis(grid.cells[2]) {
        for y in axis(grid.cells[1]) {
            let least2 = gap(y).powi(2) + gap(z).powi(2);
            if least2 <= f64::from(grid.radius2) {
                let place = |cells: i32| (cells + MAX_REACH as i32) as u32;
                rows.push((y * y + z * z, Row { y: place(y), z: place(z), least2: round_down(least2) }));
            }
        }
    }
    rows.sort_by(|(a, row_a), (b, row_b)| row_a.least2.total_cmp(&row_b.least2).then(a.cmp(b)));
    rows.into_iter().map(|(_, row)| row).collect()
}

/// Most entries of a linear table for so many photons, unless it is said: where few photons crowd, more would take longer to fill than they save.
#[must_use]
pub fn most_entries(photons: u64) -> u32 {
    (ENTRIES_PER_PHOTON * photons).clamp(1 << 16, u64::from(MAX_CELLS)) as u32
}

/// The width that cells can have: `wanted`, or more where there would be too many of them.
fn possible_width(sides: [f64; 3], photons: u64, wanted: f64, options: &MapOptions) -> f64 {
    let radius = f64::from(options.radius);
    let longest = sides.into_iter().fold(0.0, f64::max);
    // A hash that scatters cells looks each one up: no more than 125 of them.
    let finest = if options.hash == Hash::Linear { radius / MOST_REACH } else { radius / 2.0 };
    let mut width = wanted.max(finest).max(longest / f64::from(MAX_CELLS_PER_AXIS - 8));
    let usual = if options.cell.is_some() { MAX_CELLS } else { most_entries(photons) };
    let most = options.table.unwrap_or(usual).clamp(1, MAX_CELLS);
    let cells = |width: f64| sides.into_iter().map(|side| (side / width).floor() + 1.0).product::<f64>();
    while options.hash == Hash::Linear && cells(width) > f64::from(most) {
        width *= 1.01;
    }
    width
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { f32::from_bits(rounded.to_bits() - 1) } else { rounded }
}

fn table(cells: [u32; 3], photons: u64, options: &MapOptions, occupied: impl FnOnce() -> f64) -> Result<u32, MapError> {
    if options.hash == Hash::Linear {
        return Ok(cells.iter().product());
    }
    if let Some(entries) = options.table {
        if !entries.is_power_of_two() || entries > MAX_TABLE {
            return Err(MapError::TableSize { entries, max: MAX_TABLE });
        }
        return Ok(entries);
    }
    // Four entries a cell: few cells share one, and an estimate from a sample may be too low by as much.
    let by_cells = ((4.0 * occupied()) as u64).next_power_of_two();
    let by_photons = photons.next_power_of_two().min(by_cells).clamp(1 << 10, 1 << 24);
    if options.hash == Hash::Teschner {
        return Ok(by_photons as u32);
    }
    let side = cells.iter().map(|n| n.next_power_of_two()).max().unwrap_or(1);
    let whole_cube = u128::from(side).pow(3);
    Ok(whole_cube.min(u128::from(by_photons)) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_kernels::grid::{HASH_LINEAR, HASH_TESCHNER, cell_of};

    fn options(radius: f32, hash: Hash) -> MapOptions {
        MapOptions { radius, hash, table: None, cell: None }
    }

    #[test]
    fn points_a_radius_apart_are_at_most_one_cell_apart_on_the_finest_grid() {
        // 2²⁰ cells an axis: where rounding is worst.
        let (low, high) = ([-300.0; 3], [724.0; 3]);
        let radius = 1024.0 / ((1 << 20) as f32 - 8.0);
        let options = MapOptions { cell: Some(radius), ..options(radius, Hash::Teschner) };
        let grid = plan_grid(low, high, 1, &[], &options).unwrap();
        let mut worst = 0;
        for i in 0..1_000_000u32 {
            let a = -300.0 + 1023.0 * (i as f32 / 1e6);
            let b = a + radius;
            if f64::from(b) - f64::from(a) <= f64::from(radius) {
                let (p, q) = (cell_of(&grid, [a, 0.0, 0.0]), cell_of(&grid, [b, 0.0, 0.0]));
                worst = worst.max(q[0] - p[0]);
            }
        }
        assert_eq!(worst, 1);
    }

    #[test]
    fn radii_out_of_range_are_refused_and_all_others_have_a_grid() {
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-10, 1e19] {
            let refused = plan_grid([0.0; 3], [1.0; 3], 1, &[], &options(radius, Hash::Linear));
            assert!(matches!(refused, Err(MapError::Radius { .. })));
        }
        for radius in [1e-9, 1e-3, 1.0, 1e18] {
            for hash in [Hash::Linear, Hash::Teschner, Hash::Morton] {
                let grid = plan_grid([-1e6, 0.0, 0.0], [1e6, 1e4, 1.0], 1, &[], &options(radius, hash)).unwrap();
                assert!(grid.table <= MAX_TABLE && grid.cells.iter().all(|&n| n <= MAX_CELLS_PER_AXIS), "{grid:?}");
            }
        }
    }

    /// Every row that has a point within the radius of some point of the query's cell is in the table.
    #[test]
    fn rows_come_nearest_first_and_reach_the_radius() {
        for cell in [2.0, 1.0, 0.5, 0.3, 0.1] {
            let options = MapOptions { cell: Some(cell), ..options(1.0, Hash::Linear) };
            let grid = plan_grid([0.0; 3], [20.0; 3], 1, &[], &options).unwrap();
            let rows = rows(&grid);
            assert!(rows.is_sorted_by(|a, b| a.least2 <= b.least2));
            assert_eq!((rows[0].y, rows[0].z), (MAX_REACH, MAX_REACH));
            // The cells around the query's come first: a guess counts on it.
            assert!(rows[..9].iter().all(|row| row.y.abs_diff(MAX_REACH) <= 1 && row.z.abs_diff(MAX_REACH) <= 1));
            let reach = (1.0 / cell).ceil() as i32 + 2;
            let near = |cells: i32| f64::from((cells.abs() - 1).max(0)) * f64::from(cell);
            for z in -reach..=reach {
                for y in -reach..=reach {
                    let place = |cells: i32| (cells + MAX_REACH as i32) as u32;
                    let listed = rows.iter().filter(|row| (row.y, row.z) == (place(y), place(z))).count();
                    let least = near(y).hypot(near(z));
                    assert!(listed == 1 || (listed == 0 && least > 0.999), "{cell}: {y} {z} {listed}");
                    assert!(listed == 0 || least < 1.01, "{cell}: {y} {z} is too far");
                }
            }
        }
    }

    /// A crowd a ten-thousandth as wide as its surroundings: the linear hash has no cells that small, the other has.
    #[test]
    fn a_linear_hash_is_chosen_until_its_cells_are_too_wide_for_the_crowd() {
        let at = |i: u32, side: f32| -> [f32; 3] {
            let random = caustic_kernels::num::pcg4d([i, 1, 2, 3]);
            std::array::from_fn(|axis| 0.5 + side * (random[axis] as f32 / 4_294_967_296.0 - 0.5))
        };
        for (side, expected) in [(1.0, HASH_LINEAR), (0.1, HASH_LINEAR), (0.01, HASH_TESCHNER)] {
            let sample: Vec<_> = (0..4096).map(|i| if i % 10 == 0 { at(i, 1.0) } else { at(i, side) }).collect();
            let grid = plan_grid([0.0; 3], [1.0; 3], 1_000_000, &sample, &options(side / 50.0, Hash::Auto)).unwrap();
            assert_eq!(grid.hash, expected, "{side}");
        }
        let none = plan_grid([0.0; 3], [1.0; 3], 1, &[], &options(0.1, Hash::Auto)).unwrap();
        assert_eq!(none.hash, HASH_LINEAR);
    }

    #[test]
    fn bad_positions_are_counted_and_the_first_is_named() {
        let positions = [[0.0; 3], [f32::NAN, 0.0, 0.0], [1.0; 3], [0.0, f32::INFINITY, 0.0]];
        let error = bounds("photons", positions.into_iter()).unwrap_err();
        assert!(matches!(error, MapError::NotFinite { count: 2, first: 1, .. }));
    }
}
