//! A photon map of your own points: who is near, and how dense they are.
//!
//! `cargo run --release --example my_points [-- FILE]`, where FILE has `x y z` a line; without one, points on a spiral.

use caustic_device::Device;
use caustic_kernels::layout::{Photon, Query};
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let points = match std::env::args().nth(1) {
        Some(file) => read(&std::fs::read_to_string(file)?),
        None => spiral(100_000),
    };
    // A photon is a point with a power. Of power 1, an estimate is a density: points a square metre.
    let photons: Vec<Photon> =
        points.iter().map(|&position| Photon { position, power: [1.0; 3], ..Photon::default() }).collect();

    // The CPU, or the first GPU: both answer with the same bits.
    let (device, line) = Device::open(&"auto".parse()?)?;
    println!("{line}");
    let options = MapOptions { radius: 0.05, hash: Hash::Linear, table: None, cell: None };
    let map = PhotonMap::build(&device, &photons, &options)?;

    let queries: Vec<Query> =
        points.iter().step_by(points.len().div_ceil(5)).map(|&position| Query { position, active: 1 }).collect();
    let nearest = map.k_nearest(&device, &queries, 4, Gather::Auto)?;
    let densities = map.irradiance(&device, &queries, 50, Gather::Auto)?;
    for ((query, neighbours), density) in queries.iter().zip(&nearest).zip(&densities) {
        let found: Vec<String> =
            neighbours.iter().map(|n| format!("{} at {:.4} m", n.photon, n.distance2.sqrt())).collect();
        println!("{:?}: {:.0} points a square metre; nearest {}", query.position, density.rgb[0], found.join(", "));
    }

    let health = map.health(&device)?;
    println!(
        "{} cells with {:.1} points each, {} in the fullest; a search looks at {:.0} points",
        health.cells, health.mean_cell, health.longest_cell, health.candidates_per_query
    );
    Ok(())
}

/// Points on a spiral on the unit sphere, evenly spread (Vogel's angle).
fn spiral(count: u32) -> Vec<[f32; 3]> {
    let point = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [(r * cos) as f32, (r * sin) as f32, z as f32]
    };
    (0..count).map(point).collect()
}

/// The points of lines that begin with three numbers.
fn read(text: &str) -> Vec<[f32; 3]> {
    let numbers = |line: &str| -> Vec<f32> { line.split_whitespace().map_while(|word| word.parse().ok()).collect() };
    text.lines().filter_map(|line| numbers(line).first_chunk::<3>().copied()).collect()
}
