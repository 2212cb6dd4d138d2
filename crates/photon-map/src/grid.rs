//! The grid over a bounding box: its origin, its cells and its table.

use crate::{Hash, MapError, MapOptions};
use caustic_kernels::grid::{Grid, MAX_CELLS_PER_AXIS};
use caustic_kernels::num::{floor_to_i32, is_finite};

/// Most entries of a hash table: 2 × 4 bytes each.
pub const MAX_TABLE: u32 = 1 << 27;
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

/// The grid for `photons` photons inside the box from `low` to `high`.
///
/// # Errors
/// [`MapError::Radius`], [`MapError::TooManyCells`], [`MapError::TableTooLarge`], [`MapError::TableSize`] and
/// [`MapError::TooMany`].
pub fn plan_grid(low: [f32; 3], high: [f32; 3], photons: u64, options: &MapOptions) -> Result<Grid, MapError> {
    let radius = options.radius;
    // Outside this range the square of the radius leaves the normal numbers.
    if !(1e-18..=1e18).contains(&radius) {
        return Err(MapError::Radius { radius });
    }
    if photons > u64::from(MAX_PHOTONS) {
        return Err(MapError::TooMany { what: "photons", count: photons, max: MAX_PHOTONS });
    }
    let extent = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
    let inner = extent / f64::from(radius) + 1.0;
    let most = MAX_CELLS_PER_AXIS - 2;
    if inner > f64::from(most) {
        return Err(MapError::TooManyCells {
            radius,
            extent,
            cells: inner.ceil(),
            max: most,
            // A thousandth more, so that its first digits are enough.
            least: 1.001 * extent / f64::from(most - 2),
        });
    }
    // (x − origin)·s has a relative error of 2⁻²³ at most, hence an absolute one of inner·2⁻²³ cells, for each of two points;
    // a distance that is taken for r_max may be larger by 2⁻²¹. With s smaller by as much, points at most r_max apart
    // are never two cells apart.
    let margin = inner * 2f64.powi(-22) + 2f64.powi(-20);
    let inverse_cell = round_down((1.0 - margin) / f64::from(radius));
    let mut cells = [0; 3];
    for axis in 0..3 {
        // The kernels' own arithmetic: the highest corner gets the last inner cell.
        cells[axis] = floor_to_i32((high[axis] - low[axis]) * inverse_cell) as u32 + 3;
    }
    Ok(Grid {
        origin: low,
        inverse_cell,
        cells,
        hash: options.hash.code(),
        table: table(cells, photons, options)?,
        photons: photons as u32,
        radius2: radius * radius,
        // 2⁻²⁰ covers the rounding of a squared distance, on both sides of the comparison it is made for.
        cell_width: round_down((1.0 - 2f64.powi(-20)) / f64::from(inverse_cell)),
        slack: (inner * 2f64.powi(-22)) as f32 + f32::EPSILON,
    })
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { f32::from_bits(rounded.to_bits() - 1) } else { rounded }
}

fn table(cells: [u32; 3], photons: u64, options: &MapOptions) -> Result<u32, MapError> {
    let all: u128 = cells.iter().map(|&n| u128::from(n)).product();
    if options.hash == Hash::Linear {
        if all > u128::from(MAX_TABLE) {
            return Err(MapError::TableTooLarge { entries: all, max: MAX_TABLE });
        }
        return Ok(all as u32);
    }
    if let Some(entries) = options.table {
        if !entries.is_power_of_two() || entries > MAX_TABLE {
            return Err(MapError::TableSize { entries, max: MAX_TABLE });
        }
        return Ok(entries);
    }
    // Photons lie on surfaces, many to a cell: a table with as many entries as photons is rarely a quarter full.
    let by_photons = photons.next_power_of_two().clamp(1 << 10, 1 << 24);
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
    use caustic_kernels::grid::cell_of;

    fn options(radius: f32, hash: Hash) -> MapOptions {
        MapOptions { radius, hash, table: None }
    }

    #[test]
    fn points_a_radius_apart_are_at_most_one_cell_apart_on_the_finest_grid() {
        // 2²⁰ cells an axis: where rounding is worst.
        let (low, high) = ([-300.0; 3], [724.0; 3]);
        let radius = 1024.0 / ((1 << 20) as f32 - 8.0);
        let grid = plan_grid(low, high, 1, &options(radius, Hash::Teschner)).unwrap();
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
    fn a_radius_that_the_grid_cannot_have_is_refused_with_one_that_it_can() {
        let error = plan_grid([0.0; 3], [1e6; 3], 1, &options(1e-3, Hash::Teschner)).unwrap_err();
        let MapError::TooManyCells { least, .. } = error else { panic!("{error}") };
        assert!(plan_grid([0.0; 3], [1e6; 3], 1, &options(least as f32 * 1.000_001, Hash::Teschner)).is_ok());
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30] {
            assert!(matches!(
                plan_grid([0.0; 3], [1.0; 3], 1, &options(radius, Hash::Linear)),
                Err(MapError::Radius { .. })
            ));
        }
    }

    #[test]
    fn a_linear_table_that_would_overflow_is_refused() {
        let error = plan_grid([0.0; 3], [1e4; 3], 1, &options(0.1, Hash::Linear)).unwrap_err();
        assert!(matches!(error, MapError::TableTooLarge { entries, .. } if entries > 1 << 32), "{error}");
    }

    #[test]
    fn bad_positions_are_counted_and_the_first_is_named() {
        let positions = [[0.0; 3], [f32::NAN, 0.0, 0.0], [1.0; 3], [0.0, f32::INFINITY, 0.0]];
        let error = bounds("photons", positions.into_iter()).unwrap_err();
        assert!(matches!(error, MapError::NotFinite { count: 2, first: 1, .. }));
    }
}
