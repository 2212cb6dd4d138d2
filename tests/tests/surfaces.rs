//! Estimates that know their surface: no light through thin walls or from around corners, and edges as bright as they are.

use caustic_device::Device;
use caustic_photon_map::{Filter, Surface};
use caustic_renderer::{Integrator, Settings, Show, Stop};
use caustic_tests::renders::*;

/// A wall without thickness, lit from below and seen from above.
const THIN: &str = r#"
[camera]
position = [0, 2, 0]
target = [0, 0, 0]
up = [0, 0, -1]
vertical_fov_degrees = 40

[materials.grey]
kind = "lambertian"
reflectance = [0.5, 0.5, 0.5]

[[quads]]
corner = [-1, 0, -1]
edge_u = [0, 0, 2]
edge_v = [2, 0, 0]
material = "grey"

[[lights]]
kind = "point"
position = [0, -1, 0]
intensity = [1, 1, 1]
"#;

#[test]
fn no_light_comes_through_a_wall_without_thickness() {
    let scene = parse(THIN);
    let base = Settings { size: [16, 16], photons: 20_000, show: Show::MapGlobal, ..small(&scene) };
    for (surface, bright) in [(Surface::Any, true), (Surface::Facing, false), (Surface::Own, false)] {
        let picture = image(&scene, &Settings { surface, ..base.clone() }, &Device::cpu());
        let mean = mean_rgb(&picture)[1];
        assert_eq!(mean > 0.01, bright, "{surface:?}: {mean}");
        assert!(bright || mean == 0.0, "{surface:?}: {mean}");
    }
}

/// The indirect part of the furnace is 0.25 everywhere: what is left of the whole radiance of 1 when the walls' own ½ and the
/// ¼ straight from them are taken off. An estimate of any surface is too bright by some percent near its edges.
#[test]
fn edges_and_corners_of_a_furnace_keep_their_brightness() {
    const SEEDS: u32 = 12;
    let scene = load("furnace");
    let measure = |surface: Surface, filter: Filter, integrator: Integrator| {
        let of_seed = |seed: u32| {
            let stop = Stop { passes: Some(1), ..Stop::default() };
            let settings = Settings {
                size: [32, 32],
                spp: 4,
                photons: 100_000,
                k: 150,
                radius: 0.12,
                show: Show::Global,
                seed,
                surface,
                filter,
                integrator,
                stop,
                ..Settings::of(&scene)
            };
            mean_rgb(&image(&scene, &settings, &Device::cpu()))[1] / 0.25
        };
        (0..SEEDS).map(of_seed).collect::<Vec<_>>()
    };
    for integrator in [Integrator::Photon, Integrator::Progressive] {
        for filter in [Filter::Constant, Filter::Epanechnikov] {
            let (mean, se) = mean_and_error(&measure(Surface::Own, filter, integrator));
            println!("{integrator:?}, {filter:?}, own: {mean:.5}, SE {se:.5}");
            assert!((mean - 1.0).abs() < 4.0 * se && se < 5e-3, "{integrator:?}, {filter:?}: {mean} ± {se}");
        }
    }
    // The fault that this is to find, of the same photons.
    let pairs = [Surface::Any, Surface::Own].map(|surface| measure(surface, Filter::Constant, Integrator::Photon));
    let ratios: Vec<f64> = pairs[0].iter().zip(&pairs[1]).map(|(any, own)| any / own).collect();
    let (mean, se) = mean_and_error(&ratios);
    println!("any over own: {mean:.5}, SE {se:.5}");
    assert!(mean - 1.0 > 8.0 * se, "{mean} ± {se}: no bias to be corrected");
}
