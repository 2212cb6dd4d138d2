//! A closed furnace, evenly bright, and a scene of many lights. Seeds are fixed; bounds are 4 standard errors and a bias worked out beside.

use caustic_device::Device;
use caustic_kernels::trace::Camera;
use caustic_renderer::output::Image;
use caustic_renderer::{Settings, Show};
use caustic_tests::renders::*;
use std::f64::consts::PI;

/// The wall of the furnace, the box from −1 to 1, that the camera sees through a point of the film, and where.
fn on_wall(camera: &Camera, x: f64, y: f64) -> [f64; 3] {
    let (origin, direction) = ray(camera, x, y);
    let reach = |axis: usize| (direction[axis].signum() - origin[axis]) / direction[axis];
    let t = (0..3).map(reach).fold(f64::MAX, f64::min);
    std::array::from_fn(|axis| origin[axis] + t * direction[axis])
}

/// Area of the walls of the furnace within `radius` of a point on one of them.
fn wall_area(at: [f64; 3], radius: f64) -> f64 {
    let clipped_disc = |radius2: f64, u: f64, v: f64| {
        const STEPS: u32 = 48;
        let radius = radius2.sqrt();
        let step = 2.0 * radius / f64::from(STEPS);
        let strip = |i: u32| {
            let du = -radius + (f64::from(i) + 0.5) * step;
            let chord = (radius2 - du * du).sqrt();
            if (u + du).abs() > 1.0 { 0.0 } else { (v + chord).min(1.0) - (v - chord).max(-1.0) }
        };
        step * (0..STEPS).map(strip).sum::<f64>()
    };
    let mut area = 0.0;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let height = at[axis] - side;
            let radius2 = radius * radius - height * height;
            if radius2 > 0.0 {
                area += clipped_disc(radius2, at[(axis + 1) % 3], at[(axis + 2) % 3]);
            }
        }
    }
    area
}

/// What the estimate at a point of the furnace is expected to be, as a multiple of the truth: photons are spread evenly over
/// the walls, and the estimate takes the walls within its radius for a disc. At an edge there are two half discs, as much
/// as a disc, half a radius from it 18 % more, and in a corner three quarters.
fn boundary_bias(at: [f64; 3], radius: f64) -> f64 {
    let (mut low, mut high) = (0.5 * radius, 2.0 * radius);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if wall_area(at, middle) < PI * radius * radius {
            low = middle;
        } else {
            high = middle;
        }
    }
    (radius / low).powi(2)
}

#[test]
fn a_closed_furnace_is_evenly_bright() {
    const SIDE: u32 = 48;
    const SEEDS: u32 = 10;
    let scene = load("furnace");
    let camera = scene.camera(SIDE, SIDE);
    let pixels: Vec<[f64; 3]> =
        (0..SIDE * SIDE).map(|i| on_wall(&camera, f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5)).collect();
    // Distance from the nearest edge, and from the nearest of the two walls that do not make it.
    let from_edge = |at: &[f64; 3]| {
        let mut distances = at.map(|x| 1.0 - x.abs());
        distances.sort_by(f64::total_cmp);
        [distances[1], distances[2]]
    };
    // Expected radius of an estimate: each photon is stored 0.5 + 0.25 + … = 1 times on 24 m².
    let settings = Settings { size: [SIDE; 2], spp: 16, ..Settings::of(&scene) };
    let radius = (f64::from(settings.k) * 24.0 / f64::from(settings.photons) / PI).sqrt();
    let inner = |i: &usize| from_edge(&pixels[*i])[0] > 3.0 * radius;
    let corner = |i: &usize| from_edge(&pixels[*i])[1] < radius;
    let band = |i: &usize| from_edge(&pixels[*i])[0] < radius && !corner(i);

    let part = |show: Show, seed: u32| image(&scene, &Settings { show, seed, ..settings.clone() }, &Device::cpu());
    let average = |picture: &Image, wanted: &dyn Fn(&usize) -> bool| {
        let values: Vec<f64> = (0..pixels.len()).filter(wanted).map(|i| f64::from(picture.rgb[i][1])).collect();
        assert!(values.len() > 3, "only {} pixels", values.len());
        mean(&values)
    };
    let mut beauty = Vec::new();
    let mut global = Vec::new();
    for seed in 0..SEEDS {
        beauty.push(part(Show::Beauty, seed));
        if seed < 4 {
            global.push(part(Show::Global, seed));
        }
    }
    let over = |pictures: &[Image], wanted: &dyn Fn(&usize) -> bool| {
        mean_and_error(&pictures.iter().map(|picture| average(picture, wanted)).collect::<Vec<_>>())
    };

    // Away from edges nothing but noise is left.
    let (value, se) = over(&beauty, &inner);
    println!("furnace, away from edges: {value:.5}, SE {se:.5}");
    assert!((value - 1.0).abs() < 4.0 * se && se < 2e-3, "{value} ± {se}");

    // All pixels: the boundary bias of the part that comes from the map, which is a quarter, is known.
    let expected: Vec<f64> = (0..pixels.len())
        .map(|i| {
            let parts = (0..9).map(|part| {
                let at = |i: u32, part: usize| f64::from(i) + (part as f64 + 0.5) / 3.0;
                boundary_bias(on_wall(&camera, at(i as u32 % SIDE, part % 3), at(i as u32 / SIDE, part / 3)), radius)
            });
            parts.sum::<f64>() / 9.0
        })
        .collect();
    let bias = |wanted: &dyn Fn(&usize) -> bool| {
        mean(&(0..pixels.len()).filter(wanted).map(|i| expected[i]).collect::<Vec<_>>())
    };
    let (value, se) = over(&beauty, &|_| true);
    let wanted = 1.0 + 0.25 * (bias(&|_| true) - 1.0);
    println!("furnace, all pixels: {value:.5}, SE {se:.5}, expected with the boundary bias {wanted:.5}");
    assert!((value - wanted).abs() < 4.0 * se + 1e-3, "{value} ± {se}, not {wanted}");
    for (name, wanted) in [("edges", &band as &dyn Fn(&usize) -> bool), ("corners", &corner)] {
        let (value, se) = over(&global, wanted);
        let (ratio, se, bias) = (4.0 * value, 4.0 * se, bias(wanted));
        println!("furnace, {name}, from the map: {ratio:.4} of the truth, SE {se:.4}, expected {bias:.4}");
        assert!((ratio - bias).abs() < 4.0 * se + 0.03, "{name}: {ratio} ± {se}, not {bias}");
    }
}

#[test]
fn direct_light_of_many_lights_converges_in_each_pixel() {
    let scene = load("furnace");
    // The root mean square error of the pixels, the truth being 0.75, away from edges, where 1 / d² has no bound.
    let error = |spp: u32| {
        let settings = Settings { size: [16, 16], spp, show: Show::Direct, ..small(&scene) };
        let picture = image(&scene, &settings, &Device::cpu());
        let camera = scene.camera(16, 16);
        let inner = (0..256u32).filter(|&i| {
            let mut at = on_wall(&camera, f64::from(i % 16) + 0.5, f64::from(i / 16) + 0.5).map(f64::abs);
            at.sort_by(f64::total_cmp);
            at[1] < 0.7
        });
        mean(&inner.map(|i| (f64::from(picture.rgb[i as usize][1]) - 0.75).powi(2)).collect::<Vec<_>>()).sqrt()
    };
    let errors = [16, 256, 4096].map(error);
    println!("root mean square errors at 16, 256 and 4096 samples a pixel: {errors:.5?}");
    // Random numbers would make it 4 times less each time, a sequence more.
    assert!(errors[1] < errors[0] / 3.0 && errors[2] < errors[1] / 3.0, "{errors:?}");
}
