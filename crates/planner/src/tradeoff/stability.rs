//! Where numbers break: estimates of a map beside the same in f64, from the same places before they are rounded to f32.

use super::Store;
use super::point::Case;
use super::run::Event;
use caustic_device::Device;
use caustic_experiments::figure::Table;
use caustic_experiments::store::Outcome;
use caustic_kernels::layout::{Photon, Query};
use caustic_kernels::num::pcg4d;
use caustic_photon_map::{Gather, Hash, MapError, MapOptions, PhotonMap};
use caustic_renderer::Part;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Points that are estimated.
const QUERIES: u32 = 64;
/// Two directions that span a plane which is along no axis.
const PLANE: [[f64; 3]; 2] = [[0.8, 0.36, 0.48], [-0.6, 0.48, 0.64]];

/// Evenly spread photons on a square, and how they are far from the ordinary.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trial {
    /// Which of the numbers below is swept.
    what: &'static str,
    value: f64,
    /// Side of the square, m.
    side: f64,
    /// Distance of its corner from the origin along each axis, m.
    offset: f64,
    k: u32,
    photons: u32,
    /// Powers are spread over so many decades.
    decades: f64,
}

fn trials(quick: bool) -> Vec<Trial> {
    let photons = if quick { 20_000 } else { 100_000 };
    let usual = Trial { what: "", value: 0.0, side: 1.0, offset: 0.0, k: 50, photons, decades: 0.0 };
    let mut trials = Vec::new();
    for side in [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6] {
        trials.push(Trial { what: "scale", value: side, side, ..usual });
    }
    for offset in [0.0, 1.0, 1e2, 1e3, 1e4, 1e5, 1e6] {
        trials.push(Trial { what: "offset", value: offset, offset, ..usual });
    }
    for k in [8, 50, 150, 512] {
        trials.push(Trial { what: "k", value: f64::from(k), k, ..usual });
    }
    for photons in if quick { &[10_000, 200_000][..] } else { &[10_000, 1_000_000, 10_000_000] } {
        trials.push(Trial { what: "photons", value: f64::from(*photons), photons: *photons, ..usual });
    }
    for decades in [3.0, 6.0, 9.0, 12.0] {
        trials.push(Trial { what: "decades of power", value: decades, decades, ..usual });
    }
    trials
}

/// Whose numbers are tried: exact and fast arithmetic, and a compact map's.
const WAYS: [&str; 3] = ["exact", "fast", "compact"];

/// All trials in all ways; only GPUs are fast.
fn all(quick: bool, gpu: bool) -> Vec<(Trial, &'static str)> {
    let ways = move |trial| WAYS.into_iter().filter(move |&way| gpu || way != "fast").map(move |way| (trial, way));
    trials(quick).into_iter().flat_map(ways).collect()
}

/// What results of all trials are kept by.
#[must_use]
pub fn stability_cases(quick: bool, gpu: bool) -> Vec<Case> {
    all(quick, gpu).iter().map(|(trial, way)| case(trial, way)).collect()
}

/// Measures what the store does not have yet, of all trials or of a part of them, on the exact device and on the fast one if there is one. Returns whether all is there: false if
/// `watch` returned false.
///
/// # Errors
/// If a device or the disk fails.
pub fn stability(
    quick: bool,
    part: Option<Part>,
    [exact, fast]: [Option<&Device>; 2],
    store: &mut Store,
    watch: &mut dyn FnMut(Event) -> bool,
) -> Result<bool, String> {
    let gpu = exact.is_some_and(Device::is_gpu);
    for (trial, way) in Part::share(part, all(quick, gpu)) {
        let case = case(&trial, way);
        if store.outcome(&case).is_some() {
            continue;
        }
        if !watch(Event::Begin(&case, 1.0)) {
            return Ok(false);
        }
        let device = if way == "fast" { fast } else { exact };
        let outcome = match device.map(|device| errors(&trial, device, way == "compact")) {
            None => Outcome::Skipped("there is no such device".to_string()),
            Some(Ok([most, rms])) => Outcome::Values(BTreeMap::from([
                ("most_relative_error".to_string(), most),
                ("rms_relative_error".to_string(), rms),
            ])),
            Some(Err(error)) => Outcome::Skipped(error.to_string()),
        };
        store.add(&case, outcome, None)?;
    }
    Ok(true)
}

fn case(trial: &Trial, way: &str) -> Case {
    Case { knob: format!("stability: {}", trial.what), command: format!("{:e} {way}", trial.value) }
}

/// Largest and root of the mean square of the relative errors of estimates.
fn errors(trial: &Trial, device: &Device, compact: bool) -> Result<[f64; 2], MapError> {
    let Trial { side, offset, k, photons, decades, .. } = *trial;
    let unit = |word: u32| f64::from(word) / 4_294_967_296.0;
    let place = |u: f64, v: f64| -> [f64; 3] {
        std::array::from_fn(|axis| offset + side * (u * PLANE[0][axis] + v * PLANE[1][axis]))
    };
    let rounded = |place: [f64; 3]| place.map(|x| x as f32);
    let power = |word: u32| 10f64.powf(-decades * unit(word)) as f32;
    let drawn: Vec<([f64; 3], f32)> = (0..photons)
        .map(|i| pcg4d([i, 1, 2, 3]))
        .map(|random| (place(unit(random[0]), unit(random[1])), power(random[2])))
        .collect();
    // In the middle, where discs do not hang over the edge.
    let queries: Vec<[f64; 3]> = (0..QUERIES)
        .map(|i| pcg4d([i, 4, 5, 6]))
        .map(|random| place(0.4 + 0.2 * unit(random[0]), 0.4 + 0.2 * unit(random[1])))
        .collect();
    let records: Vec<Photon> = drawn
        .iter()
        .map(|&(place, power)| Photon { position: rounded(place), power: [power; 3], ..Photon::default() })
        .collect();
    let asked: Vec<Query> = queries.iter().map(|&place| Query { position: rounded(place), active: 1 }).collect();
    let radius = (4.0 * side * (f64::from(k) / f64::from(photons) / PI).sqrt()) as f32;
    let options = MapOptions { radius, hash: Hash::Auto, table: None, cell: None };
    let build = if compact { PhotonMap::build_compact } else { PhotonMap::build };
    let found = build(device, &records, &options)?.irradiance(device, &asked, k, Gather::Auto)?;
    let (mut most, mut squares) = (0.0f64, 0.0);
    for (query, found) in queries.iter().zip(found) {
        let error = (f64::from(found.rgb[0]) / estimate(&drawn, *query, k as usize) - 1.0).abs();
        most = most.max(error);
        squares += error * error;
    }
    Ok([most, (squares / f64::from(QUERIES)).sqrt()])
}

/// The estimate of eq. 2.1 in f64, W·m⁻²: the power of the k nearest over the disc that reaches to the next.
fn estimate(photons: &[([f64; 3], f32)], query: [f64; 3], k: usize) -> f64 {
    let distance2 = |place: &[f64; 3]| place.iter().zip(&query).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let mut all: Vec<(f64, f32)> = photons.iter().map(|(place, power)| (distance2(place), *power)).collect();
    let (near, next, _) = all.select_nth_unstable_by(k, |a, b| a.0.total_cmp(&b.0));
    near.iter().map(|(_, power)| f64::from(*power)).sum::<f64>() / (PI * next.0)
}

/// What was measured, a table for each number that was swept.
pub(super) fn tables(store: &Store, quick: bool) -> Vec<Table> {
    let trials = trials(quick);
    let mut names: Vec<&str> = trials.iter().map(|trial| trial.what).collect();
    names.dedup();
    let number = |trial: &Trial, way: &str, name: &str| {
        store.value(&case(trial, way), name).map_or(String::new(), |error| format!("{error:.1e}"))
    };
    let table = |name: &str| Table {
        title: format!("Stability over {name}: relative error against f64"),
        columns: std::iter::once(name.to_string())
            .chain(WAYS.iter().flat_map(|way| [format!("{way}, most"), format!("{way}, RMS")]))
            .collect(),
        rows: trials
            .iter()
            .filter(|trial| trial.what == name)
            .map(|trial| {
                let of =
                    |way: &&str| ["most_relative_error", "rms_relative_error"].map(|name| number(trial, way, name));
                std::iter::once(format!("{:e}", trial.value)).chain(WAYS.iter().flat_map(of)).collect()
            })
            .collect(),
    };
    names.into_iter().map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The estimate holds f32's digits where it should, and the comparison sees where it does not.
    #[test]
    fn estimates_hold_at_any_scale_and_break_far_away() {
        let cpu = Device::cpu();
        let usual = Trial { what: "", value: 0.0, side: 1.0, offset: 0.0, k: 50, photons: 5000, decades: 0.0 };
        for trial in
            [usual, Trial { side: 1e-6, ..usual }, Trial { side: 1e6, ..usual }, Trial { decades: 12.0, ..usual }]
        {
            let [most, rms] = errors(&trial, &cpu, false).unwrap();
            assert!(most < 1e-4 && rms <= most && most > 0.0, "{trial:?}: {most}");
            // Rounded powers and places: a 255th of a power, and a disc whose edge is a photon that moved.
            let [of_compact, _] = errors(&trial, &cpu, true).unwrap();
            assert!(of_compact < 1e-2 && of_compact > most, "{trial:?}, compact: {of_compact}");
        }
        // At 10⁶ m, f32 has steps of 6 cm, as wide as these discs.
        let [most, _] = errors(&Trial { offset: 1e6, ..usual }, &cpu, false).unwrap();
        assert!(most > 0.1, "{most}");
    }
}
