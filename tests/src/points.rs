//! Sets of points that a photon map meets, each with a radius and with queries.

use caustic_kernels::grid::{HASH_TESCHNER, teschner};
use caustic_kernels::layout::{Photon, Query};
use caustic_kernels::num::{pcg4d, u32_to_unit};
use caustic_photon_map::{Hash, MapOptions, plan_grid};

/// Points in a box of their own, with the radius that a test of them uses.
pub struct PointSet {
    /// What they are.
    pub name: &'static str,
    /// Photons there, of various powers.
    pub photons: Vec<Photon>,
    /// Query radius, m.
    pub radius: f32,
    /// Entries of the tables of Teschner and Morton, if the set depends on it.
    pub table: Option<u32>,
    /// Width of cells, if the set depends on it.
    pub cell: Option<f32>,
    /// Points at which to look.
    pub queries: Vec<Query>,
}

/// Three numbers in [0, 1) that depend on `seed` and `i` only.
#[must_use]
pub fn unit3(seed: u32, i: u32) -> [f32; 3] {
    let random = pcg4d([seed, i, 0x7e57, 3]);
    [u32_to_unit(random[0]), u32_to_unit(random[1]), u32_to_unit(random[2])]
}

/// `n` points spread evenly in the box from `low` to `high`.
#[must_use]
pub fn uniform(seed: u32, n: u32, low: [f32; 3], high: [f32; 3]) -> Vec<[f32; 3]> {
    let place = |i| {
        let unit = unit3(seed, i);
        std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) * unit[axis])
    };
    (0..n).map(place).collect()
}

/// Photons at the given points. Their powers spread over twelve decades, so that the order of a sum shows in its bits.
#[must_use]
pub fn photons_at(seed: u32, points: &[[f32; 3]]) -> Vec<Photon> {
    let photon = |(i, &position): (u32, &[f32; 3])| {
        let unit = unit3(seed ^ 0xf00d, i);
        let power = unit.map(|u| (u + 0.01) * 10f32.powi((i % 13) as i32 - 9));
        Photon { position, direction: i.wrapping_mul(0x9e37_79b9), power, primitive: i % 12 }
    };
    (0..).zip(points).map(photon).collect()
}

/// A query at a point.
#[must_use]
pub fn query(position: [f32; 3]) -> Query {
    Query { position, active: 1 }
}

impl PointSet {
    fn new(name: &'static str, radius: f32, points: &[[f32; 3]]) -> Self {
        let photons = photons_at(name.len() as u32, points);
        let mut set = Self { name, photons, radius, table: None, cell: None, queries: Vec::new() };
        set.queries = set.make_queries();
        set
    }

    /// The lowest and the highest corner of the photons' box.
    #[must_use]
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        caustic_photon_map::bounds("photons", self.photons.iter().map(|photon| photon.position))
            .expect("sets have finite positions")
    }

    /// How a map of the set is built.
    #[must_use]
    pub fn options(&self, hash: Hash) -> MapOptions {
        MapOptions { radius: self.radius, hash, table: self.table, cell: self.cell }
    }

    /// Queries at photons, between them, at corners, on cell borders, just outside the box, far outside, and inactive ones.
    fn make_queries(&self) -> Vec<Query> {
        let (low, high) = self.bounds();
        let r = self.radius;
        let mut points = vec![low, high, [low[0], high[1], low[2]]];
        let step = (self.photons.len() / 12).max(1);
        points.extend(self.photons.iter().step_by(step).map(|photon| photon.position));
        points.extend(uniform(77, 12, low, high));
        // A shell of one and a half radii around the box, in and out of reach.
        let (out_low, out_high) = (low.map(|x| x - 1.5 * r), high.map(|x| x + 1.5 * r));
        points.extend(uniform(78, 12, out_low, out_high));
        for axis in 0..3 {
            for (corner, sign) in [(low, -1.0), (high, 1.0)] {
                for distance in [0.5 * r, r, 1e3 * r] {
                    let mut outside = corner;
                    outside[axis] += sign * distance;
                    points.push(outside);
                }
            }
        }
        points.extend([[3e38, -3e38, 3e38], [-3e38; 3], [0.0; 3], [-0.0; 3]]);
        points.extend(border_points(low, high, r, 79, 12));
        let inactive = Query { position: low, active: 0 };
        let mut queries: Vec<_> = points.into_iter().map(query).collect();
        queries.insert(queries.len() / 2, inactive);
        queries
    }
}

/// `n` points on borders of cells, each at most one float off, inside the box from `low` to `high`.
#[must_use]
pub fn border_points(low: [f32; 3], high: [f32; 3], radius: f32, seed: u32, n: u32) -> Vec<[f32; 3]> {
    let options = MapOptions { radius, hash: Hash::Teschner, table: None, cell: Some(radius) };
    let grid = plan_grid(low, high, 1, &[], &options).expect("a grid that tests can have");
    let on_border = |i| {
        let random = pcg4d([seed, i, 0xb0bd, 0]);
        std::array::from_fn(|axis| {
            let inner = random[axis] % (grid.cells[axis] + 1);
            let x = (f64::from(low[axis]) + f64::from(inner) / f64::from(grid.inverse_cell)) as f32;
            let x = match (random[3] >> (2 * axis)) & 3 {
                0 => x.next_up(),
                1 => x.next_down(),
                _ => x,
            };
            x.clamp(low[axis], high[axis])
        })
    };
    (0..n).map(on_border).collect()
}

/// Points in cells of one entry of a Teschner table with `table` entries, in a grid of `side` cells an axis, and some
/// elsewhere.
#[must_use]
pub fn colliding(n: u32, side: u32, table: u32, radius: f32) -> Vec<[f32; 3]> {
    let (low, high) = ([0.0; 3], [side as f32 * radius; 3]);
    let options = MapOptions { radius, hash: Hash::Teschner, table: Some(table), cell: Some(radius) };
    let grid = plan_grid(low, high, 1, &[], &options).expect("a grid that tests can have");
    assert_eq!(grid.hash, HASH_TESCHNER);
    let entry = teschner([2, 2, 2]) & (table - 1);
    let mut cells: Vec<[u32; 3]> = (0..side)
        .flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z])))
        .filter(|&cell| teschner(cell) & (table - 1) == entry)
        .collect();
    assert!(cells.len() > 10, "only {} cells collide", cells.len());
    // Few enough that each has its share of the points; those of the smallest tables are neighbours.
    cells.truncate(64);
    let mut points = vec![low, high];
    for i in 0..n {
        let cell = cells[i as usize % cells.len()];
        let unit = unit3(5, i);
        // The inner 98 % of the cell, clear of its borders.
        points.push(std::array::from_fn(|axis| (cell[axis] as f32 + 0.01 + 0.98 * unit[axis]) / grid.inverse_cell));
    }
    points
}

/// Eight clusters of different widths, the smallest a ten-thousandth of the largest.
#[must_use]
pub fn clustered(seed: u32, n: u32) -> Vec<[f32; 3]> {
    let place = |i| {
        let (centre, spread) = (unit3(seed, i % 8), unit3(seed + 1, i));
        let width = 10f32.powi(-((i % 5) as i32));
        std::array::from_fn(|axis| centre[axis] + width * 0.3 * (spread[axis] - 0.5))
    };
    (0..n).map(place).collect()
}

/// Points whose coordinates are zeros of either sign, subnormals and the smallest normal numbers.
#[must_use]
pub fn subnormal(n: u32) -> Vec<[f32; 3]> {
    let tiny = |bits: u32| {
        f32::from_bits((bits & 0x8000_0000) | [0, 1, 0x0040_0000, 0x007f_ffff, 0x0080_0001][bits as usize % 5])
    };
    (0..n)
        .map(|i| {
            let random = pcg4d([i, 0x5b, 0, 0]);
            [tiny(random[0]), tiny(random[1]), tiny(random[2])]
        })
        .collect()
}

/// All sets, with about `n` points each where the number is not what the set is about.
#[must_use]
pub fn sets(n: u32) -> Vec<PointSet> {
    let mixed = |seed| uniform(seed, n, [-3.0, -2.0, -1.0], [1.0, 2.0, 3.0]);
    let duplicates: Vec<_> = uniform(6, n.div_ceil(8), [0.0; 3], [1.0; 3]).iter().flat_map(|&p| [p; 8]).collect();
    let lattice: Vec<_> = (0..n).map(|i| [(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32]).collect();
    let mut borders = border_points([0.0; 3], [8.0; 3], 1.0, 9, n);
    borders.extend([[0.0; 3], [8.0; 3]]);
    let on_a_plane = uniform(11, n, [-1.0, 0.5, -1.0], [1.0, 0.5, 1.0]);
    let mut sets = vec![
        PointSet::new("empty", 0.5, &[]),
        PointSet::new("one photon", 0.5, &[[0.3, -0.4, 0.5]]),
        PointSet::new("evenly spread", 0.2, &uniform(1, n, [0.0; 3], [1.0; 3])),
        PointSet::new("clustered", 0.1, &clustered(2, n)),
        PointSet::new("negative", 0.5, &uniform(3, n, [-4.0; 3], [-2.0; 3])),
        PointSet::new("of mixed sign", 0.7, &mixed(4)),
        PointSet::new("on a plane", 0.15, &on_a_plane),
        PointSet { cell: Some(1.0), ..PointSet::new("on cell borders", 1.0, &borders) },
        PointSet {
            cell: Some(0.01),
            ..PointSet::new("in cells far smaller than the radius", 0.2, &uniform(14, n, [0.0; 3], [1.0; 3]))
        },
        PointSet::new("all in one point", 0.25, &vec![[0.1, 0.2, -0.3]; n as usize]),
        PointSet::new("all in one cell", 2.0, &uniform(5, n, [1.0; 3], [1.5; 3])),
        PointSet::new("duplicates", 0.3, &duplicates),
        PointSet::new("a lattice, many ties", 2.0, &lattice),
        PointSet::new("small detail far off", 2.0, &uniform(7, n, [1e6; 3], [1e6 + 10.0; 3])),
        PointSet::new("tiny", 1e-7, &uniform(8, n, [-1e-6; 3], [1e-6; 3])),
        PointSet::new("huge", 2e5, &uniform(9, n, [-1e6; 3], [1e6; 3])),
        PointSet::new("a radius beyond the scene", 1e4, &uniform(10, n, [0.0; 3], [1.0; 3])),
        PointSet::new("zeros of both signs and subnormals", 1e-3, &subnormal(n)),
        PointSet::new("the largest floats", 1e18, &vec![[f32::MAX, f32::MIN, f32::MAX]; n.min(100) as usize]),
        PointSet::new("about the smallest radius", 2e-9, &uniform(12, n, [-4e-9; 3], [4e-9; 3])),
        PointSet::new("about the largest radius", 5e17, &uniform(13, n, [-1e18; 3], [1e18; 3])),
    ];
    for table in [1, 2, 64, 1024] {
        // 32 cells an axis are 32 768: more than ten of one entry in any of these tables.
        let set = PointSet::new("colliding", 0.5, &colliding(n, 32, table, 0.5));
        sets.push(PointSet { table: Some(table), cell: Some(0.5), ..set });
    }
    sets
}
